//! The film: adaptive sampling, reconstruction across views, layers (AOVs) beside color, and the conversion of linear
//! radiance to integers. **May
//! import:** nothing that traces rays.

pub(crate) mod adaptive;
pub mod exposure;
pub(crate) mod guides;
pub(crate) mod inverse_depth;
pub mod layers;
pub(crate) mod reconstruct;
