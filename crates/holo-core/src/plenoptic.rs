//! A physical plenoptic camera: main lens, microlens array and sensor.
//!
//! [`PlenopticCamera`] holds a validated camera of three parts: an [`ImageSensor`], a [`MicrolensArray`] in front of it
//! and a [`MainLens`] with its exit pupil. It covers unfocused cameras (plenoptic 1.0: the main lens images onto the
//! array) and focused ones (2.0: the microlenses image a real or virtual image of the main lens), arrays that are square
//! or hexagonal, rotated and off center, lens pitches of any number of pixels, and up to three interleaved types of
//! microlenses.
//!
//! # Model
//!
//! Thin lenses in Gaussian optics: a main lens with a separate exit pupil, and microlenses. Light is traced from the
//! sensor to the scene. [`PlenopticCamera::ray`] turns a point of the sensor and a point of a microlens into a ray of
//! the same form as [`Rig::ray`](crate::Rig::ray). Vignetting is exact: from a point of the sensor, light passes
//! through the part that microlens and image of the exit pupil share ([`LitRegion`]).
//!
//! A main lens may also be one of glass: a [`Prescription`], whose rays are traced surface by surface. What is defined near the
//! axis - focus, [equivalent views](PlenopticCamera::equivalent_views), decoding - is then that of its focal length and pupils, and
//! light and [chief rays](PlenopticCamera::ray) are those of the glass.
//!
//! # Coordinates
//!
//! On the image side everything is *upright*: x to the right and y up in the stored image; the physical position is the
//! negative. So the raw image has the orientation of an elemental image array, with no flip anywhere. In pixels, x runs
//! right and y down from the upper left corner; the center of the first pixel is (0.5, 0.5). On the scene side the frame
//! is that of a [`Rig`](crate::Rig): z = 0 is the entrance pupil, the camera looks along -Z, depth is planar.
//!
//! # Sources
//!
//! Hahne et al., "Baseline and triangulation geometry in a standard plenoptic camera" (IJCV, 2018), for the views of 1.0
//! cameras and the role of the exit pupil; Labussière et al., "Blur aware calibration of multi-focus plenoptic camera"
//! (CVPR, 2020), for virtual depth and blur of focused ones. Both follow from the same ray here.

mod aberrations;
mod calibration;
mod camera;
mod decode;
mod demosaic;
mod distortion;
mod equivalent;
mod focused;
mod glass_lens;
mod lattice;
mod lune;
mod main_lens;
mod microlens;
mod microlenses;
mod prescription;
mod presets;
mod projection;
mod pupil_shape;
mod rays;
mod white;
mod white_grid;

pub use aberrations::Aberrations;
pub use calibration::{Calibration, mean_white_image};
pub use camera::{ImageSensor, PlenopticCamera};
pub use decode::Decoded;
pub use distortion::Distortion;
pub use equivalent::EquivalentViews;
pub use glass_lens::TracedRays;
pub use lune::LitRegion;
pub use main_lens::{ArrayFocus, FocusGroup, MainLens, Stop};
pub use microlens::{Microlens, PlenopticRay, RayCoefficients};
pub use microlenses::{LensAperture, MicrolensArray, MicrolensFocus, MicrolensGrid, MicrolensIndex};
pub use prescription::{Glass, LensRays, Medium, Objective, Paraxial, Prescription, Surface, glasses, objectives};
pub use presets::{Preset, presets};
pub use projection::{MicroImagePoint, PlenopticMode};
pub use pupil_shape::PupilShape;
pub use white_grid::WhiteGrid;

#[cfg(test)]
mod tests;
