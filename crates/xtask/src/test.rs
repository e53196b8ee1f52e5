//! Every test, and a plain word about those that this machine cannot run.

use crate::{Result, cmake, embree, process};

/// `cargo test` over the workspace. Tests that compare engines take the BVH always and Embree where there is one.
pub fn run(arguments: &[String]) -> Result {
    let extra = crate::strs(arguments);
    let embree = std::env::var_os("HOLO_EMBREE_LIB").is_some() || embree::ensure().is_ok();
    let hdf5 = cmake::is_there();
    let features: &[&str] = if hdf5 { &["--features", "holo-io/hdf5,holo-cli/hdf5"] } else { &[] };
    process::cargo(&[&["test", "--workspace", "--quiet"], features, extra.as_slice()].concat())?;
    println!();
    if !embree {
        println!("not run: comparisons with Embree: needs libembree4 (no wheel of it could be fetched)");
    }
    if !hdf5 {
        println!("not run: HDF5 and MATLAB's level 7.3: needs cmake (no wheel of it could be fetched)");
    }
    if !process::exists("c++") {
        println!("not run: libFuzzer builds of the fuzz targets: needs a C++ compiler (their corpora were run)");
    }
    let reference = std::env::var_os("HOLO_REFERENCE")
        .map_or_else(|| crate::root().join("..").join("shared").join("reference"), std::path::PathBuf::from);
    if !reference.join("still_life.glb").is_file() {
        println!("not run: depth against Blender's: needs the reference scene (HOLO_REFERENCE names its folder)");
    }
    println!("all tests passed");
    Ok(())
}
