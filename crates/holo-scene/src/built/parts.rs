//! What scenes are built of: meshes, materials, textures, random numbers, and a builder.

pub(crate) mod materials;
pub(crate) mod noise;
pub(crate) mod patterns;
pub(crate) mod shapes;
pub(crate) mod solids;
pub(crate) mod studio;
pub(crate) mod textures;
