//! The 5D light field of holoscopic (integral, plenoptic 1.0) imaging: layouts, rig, disparity.
//!
//! # Words
//!
//! A **lens** is one micro-lens; behind it lies one *elemental image* (EI) of T x S pixels. A **view** is one viewpoint; its
//! *viewpoint image* (VPI) has V x U pixels, one under every lens. A [`Split`] says how many of each there are, and so how
//! large the raw image is: V*T rows, U*S columns (Eq. 1).
//!
//! # Index order
//!
//! Rows come first everywhere, indices are 0-based, and no axis is ever flipped.
//!
//! | what | axes | meaning |
//! |---|---|---|
//! | [`LightField`] | `(v, u, t, s, c)` | lens row, lens column, view row, view column, channel |
//! | elemental grid | `(row, column, c)` | lens `(v, u)` owns the T x S block at row `v*T`, column `u*S` |
//! | viewpoint grid | `(row, column, c)` | view `(t, s)` owns the V x U block at row `t*V`, column `s*U` |
//! | one view | `(v, u, c)` | `light_field.view(t, s)` |
//! | one elemental image | `(t, s, c)` | `light_field.elemental(v, u)` |
//!
//! Both grids hold the same samples: they are one 5D array seen through two orders of strides. Wrapping either copies nothing;
//! only the `to_*_grid` methods (Eq. 4) move pixels.
//!
//! # Geometry
//!
//! All lengths are metres in `f64`. The frame is right-handed with +Y up and a camera looks along its -Z; rows run downward.
//! A [`Rig`] is a grid of T x S cameras in the camera's XY plane with parallel axes, centred on the camera. Every ray of one
//! elemental image passes through one point of the focus plane. Depth is planar: the distance along the optical axis, not
//! along the ray; `+infinity` means that nothing was hit. Disparity is in pixels between *adjacent* views, positive nearer than
//! the focus plane (Eq. 3). The central view of T x S views is row `T/2`, column `S/2`, rounded down.
//!
//! # Equations
//!
//! | paper | here |
//! |---|---|
//! | Eq. 1, Table I | [`Split`], [`Sensor`] |
//! | Eq. 2 | [`StereoPair`] |
//! | Eq. 3 | [`Disparity`] |
//! | Eq. 4 | [`LightField::to_elemental_grid`], [`LightField::to_viewpoint_grid`], [`rearrange::naive`] |
//! | Eq. 5 | [`Block`], [`LightField::from_elemental_grid`], [`LightField::from_viewpoint_grid`] |
//!
//! # Tools
//!
//! [`plane_sweep`] estimates the disparity of the central view from the others. [`refocus`] adds shifted views up to a picture that is sharp in one plane, or everywhere. [`metrics`] says how good a disparity map
//! or a picture is. [`optics`] says what a rig can see before it is built, and which rig sees what is wanted.
//!
//! # What is not here
//!
//! No file is opened, no C library is called, and nothing is rendered. Hexagonal lens grids, rotated grids and lens
//! pitches of a fraction of a pixel are not modelled: the raw image is an exact rectangular grid of blocks.
//!
//! # Examples
//!
//! ```
//! use holo_core::{GridSize, LightField, Split};
//! use ndarray::Array3;
//!
//! // 3 x 4 views behind 5 x 7 lenses: a raw image of 15 x 28 pixels.
//! let split = Split::new(GridSize::new(3, 4), GridSize::new(5, 7))?;
//! let raw = Array3::from_shape_fn((15, 28, 3), |(row, column, channel)| row * 1000 + column * 10 + channel);
//! let light_field = LightField::from_elemental_grid(raw, split)?;
//! let central = light_field.view(1, 2)?;
//! assert_eq!(central.dim(), (5, 7, 3));
//! assert_eq!(central[[4, 6, 0]], (4 * 3 + 1) * 1000 + (6 * 4 + 2) * 10);
//! # Ok::<(), holo_core::Error>(())
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod camera;
pub mod color;
mod disparity;
mod error;
mod estimate;
mod grid;
mod layout;
mod light_field;
pub mod metrics;
pub mod optics;
mod real;
pub mod refocus;

/// The array crate of every public signature, in the version that they mean.
pub use ndarray;

pub use camera::{Intrinsics, Rig, RigBuilder, RigRay, automatic_baseline_m};
pub use color::ColorEncoding;
pub use disparity::{Disparity, Projection, StereoPair};
pub use error::Error;
pub use estimate::{DisparityEstimate, Effort, PlaneSweepOptions, plane_sweep};
pub use grid::{GridSize, LensIndex, ParseGridSizeError, ViewIndex};
pub use layout::{Block, OneBasedBlock, Remainder, Sensor, SensorSplit, Split};
pub use light_field::rearrange;
pub use light_field::{
    DynImage, DynImageRef, DynLightField, DynLightFieldRef, Layout, LightField, LightFieldCow, LightFieldOwned,
    LightFieldRef, LightFieldRefMut, Sample, SampleKind, ViewOrder, ViewPath, evenly_spaced_views,
};
pub use real::Real;
