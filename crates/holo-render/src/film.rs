//! The film: adaptive sampling, reconstruction across views and its error, layers (AOVs) beside color, and the conversion of linear
//! radiance to integers. **May
//! import:** nothing that traces rays.

pub(crate) mod adaptive;
pub(crate) mod error_distribution;
pub mod exposure;
pub(crate) mod guides;
pub(crate) mod inverse_depth;
pub mod layers;
pub(crate) mod reconstruct;
pub(crate) mod tint;
