//! Every test, and a list of those that this machine cannot run.

use std::path::PathBuf;

use crate::Result;
use crate::setup::pip::Availability;
use crate::setup::{cargo, cmake, embree, peers, process, python};

/// A program that tests compare with.
struct Peer {
    /// The tests that need it.
    tests: &'static str,
    /// What is missing, unless it is here.
    missing: Option<String>,
}

/// Runs `cargo test` over the workspace. Tests that compare ray tracing backends run the BVH always and Embree where
/// there is one.
///
/// # Errors
///
/// If a test fails, and if a peer is missing while `HOLO_REQUIRE_PEERS` is 1.
pub fn run(arguments: &[String]) -> Result {
    let extra = crate::strs(arguments);
    let missing: Vec<Peer> = all_peers()?.into_iter().filter(|peer| peer.missing.is_some()).collect();
    let lines: Vec<String> = missing
        .iter()
        .map(|peer| format!("not run: {}: {}", peer.tests, peer.missing.as_deref().unwrap_or_default()))
        .collect();
    if std::env::var_os("HOLO_REQUIRE_PEERS").is_some_and(|value| value == "1") && !lines.is_empty() {
        return Err(format!("HOLO_REQUIRE_PEERS is 1, and there is something missing:\n{}", lines.join("\n")));
    }
    cargo::run(&[&["test", "--workspace", "--quiet"], crate::workspace_features(), extra.as_slice()].concat())?;
    if python::ensure()?.is_present() {
        python::test(&[])?;
    }
    println!();
    for line in lines {
        println!("{line}");
    }
    // What follows needs rights or data, which no package brings.
    if cfg!(target_os = "linux") && !is_root() {
        println!("not run: full and read-only disks: needs root, to mount a small file system");
    }
    let reference = std::env::var_os("HOLO_REFERENCE")
        .map_or_else(|| crate::root().join("..").join("shared").join("reference"), PathBuf::from);
    if !reference.join("still_life.glb").is_file() {
        println!(
            "not run: depth against Blender's, the still life against Mitsuba's: needs their scene \
             (HOLO_REFERENCE names its folder)"
        );
    }
    println!("all tests passed");
    Ok(())
}

/// All peers, fetched where that is possible.
fn all_peers() -> Result<Vec<Peer>> {
    let fetched = |tests, availability| {
        let missing = if let Availability::Missing(why) = availability { Some(why) } else { None };
        Peer { tests, missing }
    };
    let program = |tests, names: &[&str], missing: &str| {
        let is_there = names.iter().any(|name| process::exists(name));
        Peer { tests, missing: (!is_there).then(|| missing.to_owned()) }
    };
    let mut list = vec![
        fetched("comparisons with Embree", embree::ensure()?),
        fetched("HDF5 and MATLAB's version 7.3", cmake::ensure()?),
        fetched("the Python package", python::ensure()?),
        fetched("files read and written by SciPy, h5py, OpenCV, OpenEXR", peers::ensure()?),
        program(
            "MAT files read and written by GNU Octave",
            &["octave-cli"],
            "needs octave-cli (Debian's package octave)",
        ),
        program(
            "libFuzzer builds of the fuzz targets",
            &["c++"],
            "needs a C++ compiler (the tests run the corpora without it)",
        ),
    ];
    if std::env::var_os("HOLO_CHROMIUM").is_none() {
        let names = ["chromium", "chromium-browser", "google-chrome"];
        list.push(program("the viewer's page in a browser", &names, "needs chromium (HOLO_CHROMIUM names it)"));
    }
    Ok(list)
}

/// Whether the effective user is root, as far as `/proc` says.
fn is_root() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("Uid:"));
    line.is_some_and(|ids| ids.split_whitespace().nth(1) == Some("0"))
}
