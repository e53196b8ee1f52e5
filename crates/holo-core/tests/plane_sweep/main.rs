//! Depth from views whose every sample follows from a formula.

mod hostile;
mod occlusion;
mod planes;
mod scenes;
