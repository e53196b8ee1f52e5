//! Chores of the workspace: `cargo xtask demo`, `cargo xtask test` and what they need.
//!
//! ```text
//! setup    fetch what the machine lacks (Embree 4, CMake) under target/
//! build    setup + the release binary target/release/holo with every feature
//! demo     build + render the demo scene into out/
//! test     setup + the programs to test against + every test
//! embree   fetch Embree 4 alone
//! doc      documents of all that needs HDF5
//! clippy   clippy over all that needs HDF5, warnings denied
//! fuzz     build every fuzz target and run each for some seconds
//! sanitize the renderer's tests under AddressSanitizer and ThreadSanitizer, parts under Miri (nightly)
//! rooms    the modules of every library and what they import of each other; circles are errors
//! package  build each library from its package alone
//! bench    setup + the benchmarks
//! report   setup + speed against error, measured anew into report/; --peers: beside Mitsuba and Blender
//! ```
#![forbid(unsafe_code)]

mod cmake;
mod demo;
mod embree;
mod fuzz;
mod package;
mod peers;
mod pip;
mod process;
mod renderers;
mod rooms;
mod sanitize;
mod test;

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let rest = arguments.get(1..).unwrap_or_default();
    let result = match arguments.first().map(String::as_str) {
        Some("setup") => setup(),
        Some("build") => build(),
        Some("demo") => build().and_then(|()| demo::run(rest)),
        Some("test") => setup().and_then(|()| test::run(rest)),
        Some("clippy") => clippy(),
        Some("embree") => embree::fetch(),
        Some("fuzz") => fuzz::run(rest),
        Some("package") => package::run(),
        Some("doc") => doc(),
        Some("rooms") => rooms::run(),
        Some("sanitize") => embree::ensure().and_then(|()| sanitize::run(rest)),
        Some("bench") => setup().and_then(|()| {
            if let Err(why) = peers::ensure() {
                eprintln!("xtask: no programs to measure against: {why}");
            }
            process::cargo(&[&["bench", "-p", "holo-bench"], strs(rest).as_slice()].concat())
        }),
        Some("report") => setup().and_then(|()| {
            let report = ["run", "--quiet", "--release", "-p", "holo-bench", "--bin", "report", "--"];
            let environment =
                if rest.iter().any(|argument| argument == "--peers") { renderers::ensure() } else { Vec::new() };
            process::cargo_with(&[&report, strs(rest).as_slice()].concat(), environment)
        }),
        _ => Err(
            "usage: cargo xtask setup | build | demo | test | clippy | doc | embree | fuzz [SECONDS [TARGET..]] | package | rooms | \
                  bench | report [--quick] [--peers] [--out DIR] | sanitize [address] [thread] [miri]"
                .into(),
        ),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("xtask: {why}");
            ExitCode::FAILURE
        }
    }
}

/// What went wrong, in words.
type Result<T = ()> = std::result::Result<T, String>;

/// The workspace's folder.
fn root() -> PathBuf {
    // crates/xtask/../..
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).map(PathBuf::from).unwrap_or(here)
}

/// Where builds and everything fetched go.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

fn strs(list: &[String]) -> Vec<&str> {
    list.iter().map(String::as_str).collect()
}

/// Fetches what is missing. Without Embree everything still works, slower, and without CMake everything but HDF5: that is
/// said, and is no failure.
fn setup() -> Result {
    if let Err(why) = embree::ensure() {
        eprintln!("xtask: no Embree 4: {why}");
        eprintln!(
            "xtask: going on with the built-in BVH, which is several times slower; install libembree4 to mend it"
        );
    }
    if let Err(why) = cmake::ensure() {
        eprintln!("xtask: no CMake: {why}");
        eprintln!("xtask: going on without HDF5 and MATLAB's level 7.3; install cmake to mend it");
    }
    Ok(())
}

/// Cargo's arguments for all that can be built here.
fn features() -> &'static [&'static str] {
    if cmake::is_there() { &["--features", "hdf5"] } else { &[] }
}

/// Builds the documents of what the plain `cargo doc` leaves out.
fn doc() -> Result {
    if !cmake::is_there() {
        println!("not run: documents with HDF5: needs cmake");
        return Ok(());
    }
    process::cargo(&["doc", "--quiet", "--workspace", "--no-deps", "--features", HDF5_FEATURES])
}

/// All that needs CMake.
const HDF5_FEATURES: &str = "holo-io/hdf5,holo-cli/hdf5,holo-bench/hdf5,holo-workspace/hdf5";

/// Lints what the plain `cargo clippy` leaves out.
fn clippy() -> Result {
    if !cmake::is_there() {
        println!("not run: clippy over HDF5: needs cmake");
        return Ok(());
    }
    process::cargo(&[
        "clippy",
        "--workspace",
        "--all-targets",
        "--quiet",
        "--features",
        HDF5_FEATURES,
        "--",
        "-D",
        "warnings",
    ])
}

fn build() -> Result {
    setup()?;
    process::cargo(&[&["build", "--release", "-p", "holo-cli"], features()].concat())
}
