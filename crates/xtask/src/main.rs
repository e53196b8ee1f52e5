//! Tasks of the workspace: `cargo xtask demo`, `cargo xtask test` and what they need.
//!
//! ```text
//! setup    fetch what the machine lacks (Embree 4, CMake) under target/
//! build    setup + the release binary target/release/holo with every feature
//! demo     a quick build without HDF5 + render the demo scene into out/
//! test     setup + the programs to test against + every test
//! dist     build + an archive for machines without Rust in target/dist/; --check: unpack it and run what is in it
//! embree   fetch Embree 4 alone
//! doc      documentation
//! clippy   clippy, warnings denied
//! fuzz     build every fuzz target and run each for some seconds, or over its corpus
//! sanitize the renderer's tests under AddressSanitizer and ThreadSanitizer, parts under Miri (nightly)
//! modules  the rooms of every crate and what they import of each other; circles between files are errors
//! python   build the Python package and run its tests
//! blender  the Blender extension in target/blender/; --bundle: with the program; --test: run its tests
//! package  build each library from its package alone
//! release --dry-run  everything that publishing needs, but nothing is published
//! bench    setup + the benchmarks
//! wild DIR setup + render every glTF file below DIR, compare with Cycles, write a table into target/wild/
//! consumers DIR setup + build + run the loading code of the repositories below DIR over what `holo export` writes
//! speed OLD setup + two builds of `holo` by turns, programs or commits: what NEW (this one) gains or costs
//! report   setup + measure speed against error into target/report; --peers: beside Mitsuba and Blender
//! ```
#![forbid(unsafe_code)]

mod demo;
mod fuzz;
mod modules;
mod outside;
mod rehearsal;
mod release;
mod sanitize;
mod setup;
mod test;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use setup::pip::Availability;

const USAGE: &str = "usage: cargo xtask setup | build | demo | test | dist [--check] | clippy | doc | embree | \
    fuzz [SECONDS [TARGET..] | corpora] | package | release --dry-run | python [PYTEST ARGUMENTS] | blender [--bundle] [--test] | modules | bench | speed OLD [NEW] .. | report [--quick] [--peers] [--only TEXT].. [--out DIR] | \
    sanitize [address] [thread] [miri] | wild DIR [--list FILE] | consumers DIR [--only TEXT]..";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("xtask: {why}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Result {
    let (command, rest) = arguments.split_first().ok_or(USAGE)?;
    match command.as_str() {
        "setup" => setup(),
        "build" => build(),
        "demo" => demo::run(rest),
        "test" => {
            setup()?;
            test::run(rest)
        }
        "dist" => {
            setup()?;
            release::dist::run(rest)
        }
        "clippy" => clippy(),
        "embree" => match setup::embree::fetch()? {
            Availability::Present => Ok(()),
            Availability::Missing(why) => Err(why),
        },
        "fuzz" => fuzz::run(rest),
        "package" => release::package::run(),
        "release" => rehearsal::run(rest),
        "blender" => outside::blender::run(rest),
        "python" => {
            setup()?;
            setup::python::test(rest)
        }
        "doc" => doc(),
        "modules" => modules::run(),
        "sanitize" => {
            setup::embree::ensure()?;
            sanitize::run(rest)
        }
        "wild" => {
            setup()?;
            outside::wild::run(rest)
        }
        "consumers" => {
            setup()?;
            outside::consumers::run(rest)
        }
        "bench" => {
            setup()?;
            if let Availability::Missing(why) = setup::peers::ensure()? {
                eprintln!("xtask: no programs to measure against: {why}");
            }
            setup::cargo::run(&[&["bench", "-p", "holo-bench"], strs(rest).as_slice()].concat())
        }
        "speed" => {
            setup()?;
            outside::speed::run(rest)
        }
        "report" => {
            setup()?;
            let report = ["run", "--quiet", "--release", "-p", "holo-bench", "--bin", "report", "--"];
            let has_peers = rest.iter().any(|argument| argument == "--peers");
            let environment = if has_peers { outside::renderers::ensure()? } else { Vec::new() };
            setup::cargo::run_with(&[&report, strs(rest).as_slice()].concat(), environment)
        }
        _ => Err(USAGE.into()),
    }
}

/// The error is a message for the user.
type Result<T = ()> = std::result::Result<T, String>;

/// The workspace's folder.
fn root() -> PathBuf {
    // crates/xtask/../..
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).map(PathBuf::from).unwrap_or(here)
}

/// The folder of everything built and fetched.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// The release build of `holo`, in the folder of everything built.
fn program(target: &Path) -> PathBuf {
    target.join("release").join(format!("holo{}", std::env::consts::EXE_SUFFIX))
}

fn strs(list: &[String]) -> Vec<&str> {
    list.iter().map(String::as_str).collect()
}

/// Fetches what is missing. A machine that cannot have Embree or CMake is no error: without Embree everything works,
/// slower; without CMake, everything but HDF5.
fn setup() -> Result {
    setup_embree()?;
    if let Availability::Missing(why) = setup::cmake::ensure()? {
        eprintln!("xtask: no CMake: {why}");
        eprintln!(
            "xtask: continuing without HDF5 and MATLAB's version 7.3; install cmake and a C compiler to have them"
        );
    }
    Ok(())
}

fn setup_embree() -> Result {
    if let Availability::Missing(why) = setup::embree::ensure()? {
        eprintln!("xtask: no Embree 4: {why}");
        eprintln!(
            "xtask: continuing with the built-in BVH, which is several times slower; install libembree4 to avoid that"
        );
    }
    Ok(())
}

/// Cargo's arguments for every feature of `holo` that can be built here.
fn features() -> &'static [&'static str] {
    if setup::cmake::is_present() { &["--features", "hdf5"] } else { &[] }
}

/// Cargo's arguments for every feature of the workspace that can be built here. All commands on debug builds use this
/// one set: cargo builds a library again for each set of its features.
fn workspace_features() -> &'static [&'static str] {
    if setup::cmake::is_present() { &["--features", HDF5_FEATURES] } else { &[] }
}

/// Builds the documentation.
fn doc() -> Result {
    setup::cargo::run(&[&["doc", "--quiet", "--workspace", "--no-deps"], workspace_features()].concat())
}

/// Every feature that needs CMake.
const HDF5_FEATURES: &str =
    "holo-io/hdf5,holo-cli/hdf5,holo-bench/hdf5,holo-python/hdf5,holo-workspace/hdf5,holoscopic/hdf5";

/// Lints everything.
fn clippy() -> Result {
    let clippy = ["clippy", "--workspace", "--all-targets", "--quiet"];
    setup::cargo::run(&[&clippy, workspace_features(), &["--", "-D", "warnings"]].concat())
}

fn build() -> Result {
    setup()?;
    setup::cargo::run(&[&["build", "--release", "-p", "holo-cli"], features()].concat())?;
    // Not copied elsewhere: from here the program finds Embree.
    println!("built {}", program(&target()).display());
    if cfg!(unix) {
        let folder = target().join("release");
        let folder = folder.canonicalize().unwrap_or(folder);
        println!("to call it holo: export PATH=\"{}:$PATH\"", folder.display());
    }
    Ok(())
}
