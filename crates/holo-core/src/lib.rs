//! The light field of holoscopic imaging (also integral imaging, plenoptic 1.0) as a 5D array, with camera geometry,
//! disparity, refocusing, stereo and error measures.
//!
//! # Terms
//!
//! | term | meaning |
//! |---|---|
//! | microlens, short: lens | an element of the array; its V x U microlenses are the *spatial resolution* of a view |
//! | view | the image of one viewpoint; the T x S views are the *angular resolution* |
//! | viewpoint image (VPI) | one view, also *sub-aperture image*: V x U pixels, one from every microlens |
//! | elemental image (EI) | the T x S pixels behind one microlens, also *micro-image* |
//! | elemental grid | the raw image, also *elemental image array* or *lenslet image* |
//! | viewpoint grid | all views side by side, also *sub-aperture image array* |
//! | [`LightFieldShape`] | views and microlenses; the raw image has V*T rows and U*S columns (Eq. 1) |
//!
//! # Index order
//!
//! Rows come before columns, indices start at 0, and no axis is flipped.
//!
//! | what | axes | meaning |
//! |---|---|---|
//! | [`LightField`] | `(v, u, t, s, c)` | microlens row, microlens column, view row, view column, channel |
//! | elemental grid | `(row, column, c)` | microlens `(v, u)` owns the T x S block at row `v*T`, column `u*S` |
//! | viewpoint grid | `(row, column, c)` | view `(t, s)` owns the V x U block at row `t*V`, column `s*U` |
//! | one view | `(v, u, c)` | `light_field.view(t, s)` |
//! | one elemental image | `(t, s, c)` | `light_field.elemental_image(v, u)` |
//!
//! Both grids hold the same samples: they are one 5D array with two orders of strides. Wrapping either copies nothing.
//! Only the `to_*_grid` methods (Eq. 4) move samples.
//!
//! # Geometry
//!
//! All lengths are meters in `f64`. The frame is right-handed with +Y up, and a camera looks along its -Z; rows run
//! downward. A [`Rig`] is a grid of T x S cameras with parallel axes in the XY plane of a camera, centered on that
//! camera. All rays of one elemental image pass through one point of the focus plane. Depth is planar: the distance
//! along the optical axis, not along the ray; a ray that hits nothing has depth `+infinity`. Disparity is in pixels
//! between *adjacent* views, positive for points nearer than the focus plane (Eq. 3). The central view of T x S views
//! is row `T/2`, column `S/2`, rounded down.
//!
//! # Equations
//!
//! Equation numbers are those of the paper on simulated holoscopic cameras that this project follows.
//!
//! | equation | item |
//! |---|---|
//! | Eq. 1, Table I | [`LightFieldShape`], [`Sensor`] |
//! | Eq. 2 | [`StereoPair`] |
//! | Eq. 3 | [`Disparity`] |
//! | Eq. 4 | [`LightField::to_elemental_grid`], [`LightField::to_viewpoint_grid`], [`rearrange::naive`] |
//! | Eq. 5 | [`LightField::from_elemental_grid`], [`LightField::from_viewpoint_grid`] |
//!
//! # Tools
//!
//! [`plane_sweep`] estimates the disparity of the central view by multi-view stereo. [`refocus`] adds shifted views up
//! to an image that is in focus in one plane or everywhere. [`metrics`] has error measures for disparity maps and for
//! images. [`display`] maps a light field to a panel behind lenses. [`optics`] computes depth of field and depth resolution of a rig, and the rig for a range of disparities.
//!
//! # Limits
//!
//! The crate opens no file, calls no C library and renders nothing. A [`LightField`] is an exact rectangular grid of blocks;
//! [`plenoptic`] has cameras whose arrays are hexagonal, rotated, or of any pitch, and decodes their raw images to light
//! fields.
//!
//! # Examples
//!
//! ```
//! use holo_core::{GridSize, LightField, LightFieldShape};
//! use ndarray::Array3;
//!
//! // 3 x 4 views behind 5 x 7 microlenses: a raw image of 15 x 28 pixels.
//! let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7))?;
//! let raw = Array3::from_shape_fn((15, 28, 3), |(row, column, channel)| row * 1000 + column * 10 + channel);
//! let light_field = LightField::from_elemental_grid(raw, shape)?;
//! let central = light_field.view(1, 2)?;
//! assert_eq!(central.dim(), (5, 7, 3));
//! assert_eq!(central[[4, 6, 0]], (4 * 3 + 1) * 1000 + (6 * 4 + 2) * 10);
//! # Ok::<(), holo_core::Error>(())
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

/// The README's example as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod base;
mod camera;
pub mod display;
mod estimate;
mod light_field;
pub mod metrics;
pub mod plenoptic;
pub mod refocus;
pub mod sensor;
mod synthesize;

/// The crate `ndarray` in the version of the public signatures.
pub use ndarray;

pub use base::color;
pub use base::color::ColorEncoding;
pub use base::error::Error;
pub use base::grid::{GridSize, LensIndex, ParseGridSizeError, ViewIndex};
pub use base::millimeters::{meters_to_millimeters, millimeters_to_meters};
pub use base::real::Real;
pub use base::shown::{shown, shown_lines, shown_output, visible};
pub use camera::disparity::{Disparity, Projection, StereoPair};
pub use camera::optics;
pub use camera::{
    BaselineRatio, CameraDeviation, CameraJitter, Correspondence, Intrinsics, Pinhole, Rig, RigBuilder, RigRay,
    automatic_baseline_m, rotation_near, rotation_of,
};
pub use estimate::{
    DisparityEstimate, Effort, OffsetView, PlaneSweepOptions, evenly_chosen_views, plane_sweep, plane_sweep_of_views,
};
pub use light_field::layout::{LightFieldShape, Remainder, Sensor, SensorDivision};
pub use light_field::rearrange;
pub use light_field::{
    DynImage, DynImageRef, DynLightField, DynLightFieldRef, Layout, LightField, LightFieldCow, LightFieldOwned,
    LightFieldRef, LightFieldRefMut, Sample, SampleKind, ViewOrder, ViewPath, evenly_spaced_views,
};
pub use synthesize::{PosedView, SynthesizedImage, SynthesizedView, ViewDisparities, ViewSynthesis};
