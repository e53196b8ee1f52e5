//! Builds the libFuzzer targets, and runs each for a while or over its corpus.

use std::path::Path;
use std::process::Command;

use crate::setup::{cargo, cmake, process};
use crate::{Result, root};

/// The targets that need Rust alone.
const TARGETS: &[&str] = &[
    "gltf",
    "draco",
    "meshopt",
    "png",
    "pfm",
    "hdr",
    "exr",
    "tiff",
    "mat",
    "parameters_cfg",
    "camera",
    "manifest",
    "folder",
];

/// The target that needs CMake, for the HDF5 library.
const HDF5: &str = "hdf5";

/// `cargo xtask fuzz [SECONDS [TARGET..]]`: 10 seconds a target and all targets by default. `cargo xtask fuzz corpora`
/// links them to what the tests have built, without the counters of coverage, which takes a tenth of the time.
pub fn run(arguments: &[String]) -> Result {
    if arguments == ["corpora"] {
        return run_corpora();
    }
    let (seconds, named) = match arguments.split_first() {
        None => (10, arguments),
        Some((text, named)) => {
            (text.parse::<u32>().map_err(|_| format!("'{text}' is not a number of seconds"))?, named)
        }
    };
    let mut targets = all();
    if let Some(unknown) = named.iter().find(|name| !targets.contains(&name.as_str())) {
        return Err(format!("unknown target '{unknown}'; the targets are {}", targets.join(", ")));
    }
    targets.retain(|target| named.is_empty() || named.iter().any(|name| name == target));
    let folder = crate::target().join("fuzz");
    // With an explicit `--target` the flags below do not apply to build scripts, which have no fuzzer to link with.
    let host = process::host()?;
    build(&targets, &folder, &host)?;
    for name in targets {
        println!("fuzzing {name} for {seconds} s");
        let findings = folder.join("findings").join(name);
        std::fs::create_dir_all(&findings).map_err(|why| format!("{}: {why}", findings.display()))?;
        process::run(
            Command::new(folder.join(&host).join("quick").join(name))
                .current_dir(root())
                .arg(format!("-max_total_time={seconds}"))
                .args(["-rss_limit_mb=4096", "-timeout=20", "-print_final_stats=1"])
                .arg(format!("-artifact_prefix={}/", findings.display()))
                // New inputs go beside the findings, not into the repository.
                .arg(&findings)
                .arg(root().join("fuzz").join("corpus").join(name)),
        )?;
    }
    Ok(())
}

/// The targets of this machine.
fn all() -> Vec<&'static str> {
    let mut targets = TARGETS.to_vec();
    if cmake::is_present() {
        targets.push(HDF5);
    } else {
        println!("not run: {HDF5}: needs CMake (cargo xtask setup)");
    }
    targets
}

/// The features of `holo-fuzz` that these targets need.
fn features(targets: &[&str]) -> Vec<&'static str> {
    if targets.contains(&HDF5) { vec!["libfuzzer", "hdf5"] } else { vec!["libfuzzer"] }
}

/// Runs every target once over the files of its corpus.
fn run_corpora() -> Result {
    let targets = all();
    let features: Vec<String> = features(&targets).iter().map(|name| format!("holo-fuzz/{name}")).collect();
    let all_features = crate::workspace_features().iter().skip(1).map(|list| (*list).to_owned()).chain(features);
    let all_features = all_features.collect::<Vec<_>>().join(",");
    // Examples need the features of development dependencies: the libraries are those of the tests then.
    let mut arguments = vec!["build", "--quiet", "--workspace", "--examples", "--features", &all_features];
    arguments.extend(targets.iter().flat_map(|name| ["--bin", name]));
    cargo::run(&arguments)?;
    for name in targets {
        let corpus = root().join("fuzz").join("corpus").join(name);
        let entries = corpus.read_dir().map_err(|why| format!("{}: {why}", corpus.display()))?.flatten();
        let program = crate::target().join("debug").join(name);
        let mut command = Command::new(program);
        command.current_dir(root()).args(["-rss_limit_mb=4096", "-timeout=20"]);
        command.args(entries.map(|entry| entry.path()));
        process::output(&mut command).map_err(|why| format!("the corpus of {name}: {why}"))?;
    }
    println!("the fuzz targets run over their corpora");
    Ok(())
}

/// Builds all targets at once: they share everything but their main function.
fn build(targets: &[&str], folder: &Path, host: &str) -> Result {
    let flags = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
                 -Cllvm-args=-sanitizer-coverage-trace-compares -Cdebug-assertions -Ccodegen-units=1";
    let features = features(targets).join(",");
    process::run(
        cargo::command()
            .env("RUSTFLAGS", flags)
            .env("CARGO_TARGET_DIR", folder)
            .envs(cmake::environment())
            .args([
                "build",
                "--quiet",
                "--profile",
                "quick",
                "-p",
                "holo-fuzz",
                "--features",
                &features,
                "--target",
                host,
            ])
            .args(targets.iter().flat_map(|name| ["--bin", name])),
    )
}
