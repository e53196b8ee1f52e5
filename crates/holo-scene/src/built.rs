//! Scenes built in code: the gallery, and recipes that draw scenes from distributions; both of the same parts.

pub mod gallery;
pub(crate) mod parts;
pub mod recipe;
