//! What becomes of the values of pixels: how many samples they need, which layers there are beside color, and how linear
//! radiance becomes the integers of an image. **May enter:** nothing that traces rays.

pub(crate) mod adaptive;
pub mod exposure;
pub mod layers;
