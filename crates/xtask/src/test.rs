//! Every test, and a plain word about those that this machine cannot run.

use crate::{Result, cmake, embree, peers, process};

/// `cargo test` over the workspace. Tests that compare engines take the BVH always and Embree where there is one.
pub fn run(arguments: &[String]) -> Result {
    let extra = crate::strs(arguments);
    let embree = match std::env::var_os("HOLO_EMBREE_LIB") {
        Some(library) => std::path::Path::new(&library).is_file(),
        None => embree::ensure().is_ok(),
    };
    let hdf5 = cmake::is_there();
    if let Err(why) = peers::ensure() {
        eprintln!("xtask: no programs to test against: {why}");
    }
    let features: &[&str] = if hdf5 { &["--features", "holo-io/hdf5,holo-cli/hdf5,holo-workspace/hdf5"] } else { &[] };
    process::cargo(&[&["test", "--workspace", "--quiet"], features, extra.as_slice()].concat())?;
    println!();
    if !embree {
        println!("not run: comparisons with Embree: needs libembree4 (no wheel of it could be fetched)");
    }
    if !hdf5 {
        println!("not run: HDF5 and MATLAB's level 7.3: needs cmake (no wheel of it could be fetched)");
    }
    if !peers::is_there() {
        println!(
            "not run: files read and written by SciPy, h5py, OpenCV, OpenEXR: needs those (pip could not fetch them)"
        );
    }
    if !process::exists("octave-cli") {
        println!("not run: MAT files read and written by GNU Octave: needs octave-cli (Debian's package octave)");
    }
    if !["chromium", "chromium-browser", "google-chrome"].iter().any(|name| process::exists(name))
        && std::env::var_os("HOLO_CHROMIUM").is_none()
    {
        println!("not run: the viewer's page in a browser: needs chromium (HOLO_CHROMIUM names it)");
    }
    if cfg!(target_os = "linux") && !is_root() {
        println!("not run: full and read-only disks: needs root, to mount a small file system");
    }
    if !process::exists("c++") {
        println!("not run: libFuzzer builds of the fuzz targets: needs a C++ compiler (their corpora were run)");
    }
    let reference = std::env::var_os("HOLO_REFERENCE")
        .map_or_else(|| crate::root().join("..").join("shared").join("reference"), std::path::PathBuf::from);
    if !reference.join("still_life.glb").is_file() {
        println!(
            "not run: depth against Blender's, the still life against Mitsuba's: needs their scene (HOLO_REFERENCE names its folder)"
        );
    }
    println!("all tests passed");
    Ok(())
}

/// Whether this user may mount file systems, as far as the user's number tells.
pub fn is_root() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("Uid:"));
    line.is_some_and(|ids| ids.split_whitespace().nth(1) == Some("0"))
}
