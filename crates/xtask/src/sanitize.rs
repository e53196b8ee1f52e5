//! The renderer's tests under AddressSanitizer and ThreadSanitizer, and pure Rust code under Miri: `cargo xtask
//! sanitize [WHAT..]`.
//!
//! Needs Linux on x86-64, rustup with a nightly toolchain and its components rust-src and miri, and takes some twenty
//! minutes: not part of the tests. Embree itself is not instrumented. The sanitizers check the calls of Embree: packets
//! and buffers, their lifetimes, threads that share them.

use std::process::Command;

use crate::setup::{embree, process};
use crate::{Result, root, target};

const TARGET: &str = "x86_64-unknown-linux-gnu";

/// Tests of the workspace that use both ray tracing backends and several threads.
const BACKEND_TESTS: [&str; 5] = ["hard_cases::", "ground_truth::", "path::", "shadows::", "layers::"];

/// Runs the named sanitizers, or all three.
pub fn run(arguments: &[String]) -> Result {
    let all = ["address", "thread", "miri"].map(String::from);
    for what in if arguments.is_empty() { &all[..] } else { arguments } {
        match what.as_str() {
            "address" => instrumented(what, &[], "ASAN_OPTIONS", "allocator_may_return_null=1".into())?,
            "thread" => {
                let known = root().join("crates/xtask/thread_sanitizer.supp");
                let options = "allocator_may_return_null=1 ignore_noninstrumented_modules=1";
                let options = format!("suppressions={} {options}", known.display());
                // The standard library, too: the sanitizer must see its locks.
                instrumented(what, &["-Zbuild-std"], "TSAN_OPTIONS", options)?;
            }
            "miri" => miri()?,
            other => return Err(format!("unknown sanitizer '{other}'; the sanitizers are address, thread and miri")),
        }
    }
    Ok(())
}

fn nightly(folder: &str) -> Command {
    let mut cargo = Command::new("cargo");
    cargo.arg("+nightly").current_dir(root()).env("CARGO_TARGET_DIR", target().join("sanitize").join(folder));
    cargo
}

fn instrumented(sanitizer: &str, arguments: &[&str], variable: &str, options: String) -> Result {
    let of_workspace = [&["-p", "holo-workspace", "--test", "all", "--"][..], &BACKEND_TESTS].concat();
    for of in [vec!["-p", "holo-render", "--lib"], of_workspace] {
        let mut cargo = nightly(sanitizer);
        cargo.args(["test", "--release", "--target", TARGET]).args(arguments).args(of);
        cargo.env("RUSTFLAGS", format!("-Zsanitizer={sanitizer}")).env(variable, &options);
        process::run(cargo.envs(embree::environment()))?;
    }
    Ok(())
}

/// Layouts of packets, rays, points, and the light field's blocks and lists of `holo-core`. Miri cannot load Embree and
/// is a thousand times slower than the processor: too slow for images.
fn miri() -> Result {
    let parts: [(&str, &[&str]); 2] = [
        ("holo-render", &["camera::rig::", "camera::tile::", "every_run_of_points"]),
        ("holo-core", &["layout::", "light_field::"]),
    ];
    for (package, filters) in parts {
        let miri = || {
            let mut cargo = nightly("miri");
            cargo.args(["miri", "test", "-p", package, "--lib", "--"]).args(filters);
            cargo.env("MIRIFLAGS", "-Zmiri-disable-isolation");
            cargo
        };
        // A filter that matches nothing would pass unnoticed.
        let listed = process::output(miri().arg("--list"))?;
        if let Some(filter) = filters.iter().find(|filter| !listed.contains(**filter)) {
            return Err(format!("no test of {package} is named like '{filter}'"));
        }
        process::run(&mut miri())?;
    }
    Ok(())
}
