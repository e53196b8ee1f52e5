//! Where boards stand.

use std::fmt::Write as _;

use holo_core::plenoptic::PlenopticCamera;

use crate::camera::target::BoardPose;

/// A set of poses.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Poses {
    /// Free poses to calibrate with.
    Boards,
    /// Free poses to score with.
    HeldOut,
    /// Along the axis in equal steps.
    Sweep,
}

/// How far free boards are turned about their rows and columns, and in their plane, degrees.
pub(super) const TILT_DEG: f64 = 30.0;
const TURN_DEG: f64 = 15.0;

/// The number of all poses.
pub(super) const COUNT: usize = 42;

impl Poses {
    pub const ALL: [Self; 3] = [Self::Boards, Self::HeldOut, Self::Sweep];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Boards => "boards",
            Self::HeldOut => "held-out",
            Self::Sweep => "sweep",
        }
    }

    pub const fn count(self) -> usize {
        match self {
            Self::Boards => 16,
            Self::HeldOut => 15,
            Self::Sweep => 11,
        }
    }

    /// The number of the first pose.
    pub const fn first(self) -> usize {
        match self {
            Self::Boards => 0,
            Self::HeldOut => 16,
            Self::Sweep => 31,
        }
    }

    /// The poses before a camera, of boards of some half sides, between two depths.
    pub fn of(self, camera: &PlenopticCamera, half_m: [f64; 2], [near_m, far_m]: [f64; 2]) -> Vec<BoardPose> {
        let angles = camera.angles_of_view_rad();
        let pose = |number: usize| match self {
            Self::Sweep => {
                let depth_m = far_m + (near_m - far_m) * number as f64 / (self.count() - 1) as f64;
                BoardPose { position_m: [0.0, 0.0, -depth_m], rotation_deg: [0.0; 3] }
            }
            Self::Boards | Self::HeldOut => {
                let [depth, x, y, about_x, about_y, about_z] = spread(self.first() + number);
                // As often near as far, by disparity.
                let depth_m = 1.0 / (1.0 / far_m + (1.0 / near_m - 1.0 / far_m) * depth);
                let place = |from: f64, k: usize| {
                    // What is left of the field beside a board, at its middle.
                    let free_m = depth_m * (angles[k] / 2.0).tan() - half_m[k];
                    (2.0 * from - 1.0) * free_m.max(0.0)
                };
                let angle = |from: f64, most_deg: f64| (2.0 * from - 1.0) * most_deg;
                BoardPose {
                    position_m: [place(x, 0), place(y, 1), -depth_m],
                    rotation_deg: [angle(about_x, TILT_DEG), angle(about_y, TILT_DEG), angle(about_z, TURN_DEG)],
                }
            }
        };
        (0..self.count()).map(pose).collect()
    }
}

/// The numbers of an evenly spread sequence between 0 and 1.
///
/// # Source
///
/// Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018): powers of the inverse of the root of x^7 = x + 1.
pub(super) fn spread(number: usize) -> [f64; 6] {
    const ROOT: f64 = 1.112_775_684_278_706;
    std::array::from_fn(|k| (0.5 + (number + 1) as f64 * ROOT.powi(-(k as i32 + 1))).fract())
}

/// The poses as `holo target` reads them.
pub(super) fn to_toml(poses: &[BoardPose]) -> String {
    let mut text = String::new();
    for BoardPose { position_m, rotation_deg } in poses {
        // Writing to a string does not fail.
        let _ = writeln!(text, "[[pose]]\nposition_m = {position_m:?}\nrotation_deg = {rotation_deg:?}\n");
    }
    text
}
