//! The plane sweep on views that a formula defines.

mod gloss;
mod hostile;
mod noise;
mod occlusion;
mod planes;
mod scenes;
