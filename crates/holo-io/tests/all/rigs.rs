//! Rigs that several tests use.

#![allow(dead_code, reason = "each test uses some of them")]

use holo_core::{LightFieldShape, Rig};

/// The rig of the HCI scene `cotton`, with these numbers of views and pixels.
pub fn cotton(shape: LightFieldShape) -> Rig {
    Rig::builder(shape)
        .focal_length_m(0.1)
        .sensor_size_m(0.035)
        .baseline_m(0.025)
        .focus_distance_m(4.25)
        .build()
        .unwrap()
}

/// A rig with unequal baselines, a focus at infinity, and lengths that are not exact in binary.
pub fn unequal_baselines(shape: LightFieldShape) -> Rig {
    Rig::builder(shape)
        .focal_length_m(0.0351)
        .sensor_size_m(0.036)
        .baseline_x_m(1e-4)
        .baseline_y_m(2e-4)
        .focus_distance_m(f64::INFINITY)
        .build()
        .unwrap()
}
