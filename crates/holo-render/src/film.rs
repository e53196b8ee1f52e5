//! The film: adaptive sampling, layers (AOVs) beside color, and the conversion of linear radiance to integers. **May
//! import:** nothing that traces rays.

pub(crate) mod adaptive;
pub mod exposure;
pub mod layers;
