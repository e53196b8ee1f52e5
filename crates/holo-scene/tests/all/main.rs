//! Scene files, in one test program: building many takes longer than running them.

mod gltf_compressed;
mod gltf_loading;
mod gltf_mutations;
mod gltf_round_trip;
