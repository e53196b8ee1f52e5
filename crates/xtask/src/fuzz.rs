//! Builds the libFuzzer targets and runs each for a while.

use std::process::Command;

use crate::{Result, process, root};

/// The targets `exr` and `hdf5` are built by hand (`--features libfuzzer,hdf5`) and not part of the short run; their corpora are, in
/// `tests/fuzz_corpus.rs`.
const TARGETS: &[&str] = &["gltf", "png", "pfm", "hdr", "mat", "parameters_cfg", "manifest"];

/// `cargo xtask fuzz [SECONDS]`: 10 seconds a target unless told.
pub fn run(arguments: &[String]) -> Result {
    let seconds = match arguments.first() {
        None => 10,
        Some(text) => text.parse::<u32>().map_err(|_| format!("'{text}' is not a number of seconds"))?,
    };
    let target = crate::target().join("fuzz");
    // With a target named, the flags below do not reach build scripts, which have no fuzzer to link with.
    let host = process::host()?;
    let flags = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
                 -Cllvm-args=-sanitizer-coverage-trace-compares -Cdebug-assertions -Ccodegen-units=1";
    for name in TARGETS {
        println!("fuzzing {name} for {seconds} s");
        let corpus = root().join("fuzz").join("corpus").join(name);
        let findings = target.join("findings").join(name);
        std::fs::create_dir_all(&findings).map_err(|why| format!("{}: {why}", findings.display()))?;
        process::run(
            Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
                .current_dir(root())
                .env("RUSTFLAGS", flags)
                .env("CARGO_TARGET_DIR", &target)
                .args(["run", "--quiet", "--release", "-p", "holo-fuzz", "--features", "libfuzzer"])
                .args(["--target", &host, "--bin", name])
                .arg("--")
                .arg(format!("-max_total_time={seconds}"))
                .args(["-rss_limit_mb=4096", "-timeout=20", "-print_final_stats=1"])
                .arg(format!("-artifact_prefix={}/", findings.display()))
                // New inputs go beside the findings, not into the repository.
                .arg(&findings)
                .arg(&corpus),
        )?;
    }
    Ok(())
}
