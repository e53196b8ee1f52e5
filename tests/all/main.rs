//! Tests of several libraries together, in one test program: building many takes longer than running them.

#[path = "common/pins.rs"]
mod pins;

mod adaptive;
mod blender_depth;
mod common;
mod denoise;
mod direct_light;
mod epipolar;
mod estimator;
mod furnace;
mod fuzz_corpus;
mod ground_truth;
mod hard_cases;
mod layers;
mod light_paths;
mod path;
mod pinned;
mod plenoptic;
mod radiance;
mod raw_denoise;
mod reuse;
mod shadows;
mod sharpness;
