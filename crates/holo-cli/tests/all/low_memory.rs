//! Little memory and few descriptors: a result or a message, and no abort.

#![cfg(target_os = "linux")]

use std::process::Command;

use crate::common::{Bench, Outcome, SCENE, SMALL, is_thorough, outcome};

/// Runs `holo` under a limit of the shell.
fn limited(bench: &Bench, limit: &str, arguments: &str) -> Outcome {
    let holo = bench.command(arguments);
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit {limit}; exec \"$0\" \"$@\"")]).arg(holo.get_program()).args(holo.get_args());
    command.current_dir(bench.path(""));
    outcome(command)
}

/// Succeeds or says what is missing. A message of the loader, if not even the program fits, is one too.
fn check(outcome: &Outcome, what: &str) {
    let ended = matches!(outcome.code, Some(0..=2 | 126 | 127));
    assert!(ended && !outcome.stderr.contains("panicked"), "{what}: {outcome:?}");
    assert!(outcome.code == Some(0) || !outcome.stderr.is_empty(), "{what}: {outcome:?}");
}

#[test]
fn little_address_space_is_a_result_or_a_message() {
    let bench = Bench::new();
    bench.render("field", "");
    let mut results = 0;
    let sizes: &[u32] = if is_thorough() {
        &[150, 200, 250, 300, 400, 550, 750, 1000, 1400, 2000]
    } else {
        &[150, 200, 300, 550, 1000, 2000]
    };
    for megabytes in sizes {
        for (number, command) in [
            format!("render {SCENE} {SMALL} --spp 1"),
            format!("render {SCENE} {SMALL} --spp 1 --backend bvh --threads 1"),
            format!("render {SCENE} --camera-file lytro-illum --integrator depth"),
            format!("render {SCENE} --views 100x100 --lenses 20x15 --integrator depth"),
        ]
        .iter()
        .enumerate()
        {
            let limit = format!("-v {}", megabytes * 1000);
            let outcome = limited(&bench, &limit, &format!("{command} --out out{megabytes}_{number}"));
            check(&outcome, &format!("{megabytes} MB: {command}"));
            results += usize::from(outcome.code == Some(0));
        }
        for command in ["depth field -o depth.pfm", "extract field --view 1,1 -o view.png", "verify field"] {
            let outcome = limited(&bench, &format!("-v {}", megabytes * 1000), command);
            check(&outcome, &format!("{megabytes} MB: {command}"));
            results += usize::from(outcome.code == Some(0));
        }
    }
    assert!(results > 2 * sizes.len(), "most commands need less than the most: {results}");
}

#[test]
fn few_descriptors_are_a_result_or_a_message() {
    let bench = Bench::new();
    bench.render("field", "");
    for descriptors in [5, 8, 12, 16] {
        for command in [&format!("render {SCENE} {SMALL} --spp 1 --out out{descriptors}"), "verify field"] {
            check(&limited(&bench, &format!("-n {descriptors}"), command), &format!("{descriptors}: {command}"));
        }
    }
}

#[test]
fn a_command_stays_within_the_memory_that_it_is_given() {
    let bench = Bench::new();
    let before = bench.list("");
    let large = format!("render {SCENE} --views 100x100 --lenses 80x60 --out out");
    let refused = bench.run(&format!("{large} --memory-gb 0.3"));
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("GB of memory") && refused.stderr.contains("fewer views"), "{refused:?}");
    assert_eq!(bench.list(""), before, "nothing is left");
    let enough = bench.run(&format!("render {SCENE} {SMALL} --spp 1 --out out --memory-gb 0.3"));
    assert_eq!(enough.code, Some(0), "{enough:?}");
    let wrong = bench.run(&format!("render {SCENE} {SMALL} --out other --memory-gb 0"));
    assert_eq!(wrong.code, Some(2), "{wrong:?}");
}

/// A sensor of 65,536 pixels a side needs 70 GB; that is said at once.
#[test]
fn the_largest_sensor_is_refused_before_any_work() {
    let bench = Bench::new();
    let camera = "name = \"huge\"\n[sensor]\nsize_px = [65536, 65536]\npixel_um = 1.4\n[mla]\ngrid = \"square\"\npitch_um = 20.0\n\
                  gap_um = 40.0\n[main_lens]\nfocal_mm = 9.5\nf_number = 2.0\nfocus_m = 1.0\n";
    std::fs::write(bench.path("huge.toml"), camera).unwrap();
    let before = bench.list("");
    for command in [
        &format!("render {SCENE} --camera-file huge.toml --out out")[..],
        "white --camera-file huge.toml --out white",
        "target --camera-file huge.toml --square-mm 10 --out target",
    ] {
        let outcome = bench.run(&format!("{command} --memory-gb 1"));
        assert!(matches!(outcome.code, Some(1 | 2)), "{command}: {outcome:?}");
        assert!(outcome.stderr.contains("memory"), "{command}: {outcome:?}");
        assert_eq!(bench.list(""), before, "{command}");
    }
}
