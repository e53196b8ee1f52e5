//! The help texts: what a stranger reads first.

use crate::common::Bench;

fn help(arguments: &str) -> String {
    let outcome = Bench::new().run(arguments);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
    // Lines are wrapped by the width of the terminal.
    outcome.stdout.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn the_help_names_every_command_and_the_order_of_numbers() {
    let text = help("--help");
    for command in [
        "render",
        "dataset",
        "generate",
        "merge",
        "info",
        "remap",
        "extract",
        "compose",
        "rotate-elements",
        "quilt",
        "display",
        "animate",
        "refocus",
        "synthesize",
        "correspond",
        "depth",
        "eval",
        "epi",
        "view",
        "preview",
        "optics",
        "scene",
        "export",
        "verify",
    ] {
        assert!(text.contains(&format!(" {command} ")), "{command}: {text}");
    }
    assert!(text.contains("columns x rows"), "{text}");
}

#[test]
fn the_help_of_render_says_x_before_y_wherever_it_matters() {
    let text = help("render --help");
    for part in [
        "--views <SxT|N> Views, columns x rows",
        "--lenses <UxV> Lenses, columns x rows",
        "WIDTHxHEIGHT",
        "[default: 8k]",
        "[default: 100x100]",
        "[default: 16, with the integrator depth 1]",
    ] {
        assert!(text.contains(part), "no '{part}' in: {text}");
    }
    for layer in holo_render::Layer::ALL.map(holo_render::Layer::name).into_iter().chain(["color", "all"]) {
        assert!(text.contains(&format!("- {layer}:")), "{layer}: {text}");
    }
}

#[test]
fn the_other_commands_say_it_too() {
    assert!(help("remap --help").contains("Views, columns x rows"));
    let text = help("extract --help");
    assert!(text.contains("--view <S,T> Viewpoint images: the column and row of one, from 0"), "{text}");
    assert!(text.contains("--lens <U,V> Elemental images: the column and row of a lens, from 0"), "{text}");
    assert!(help("help verify").contains("manifest.json"));
    let text = help("optics --help");
    assert!(text.contains("--focal-mm <F> Focal length, mm [default: 50]"), "{text}");
}

#[test]
fn the_version_is_the_programs() {
    assert_eq!(help("--version"), format!("holo {}", env!("CARGO_PKG_VERSION")));
}

/// The short help of the largest command fits on one screen, and what it leaves out is in the long one.
#[test]
fn the_short_help_of_render_is_one_screen() {
    let outcome = Bench::new().run("render -h");
    let lines: Vec<&str> = outcome.stdout.lines().collect();
    assert!(lines.len() <= 60, "{} lines:\n{}", lines.len(), outcome.stdout);
    for heading in ["Scene:", "Camera:", "Light:", "Quality:", "Files:", "Running:"] {
        assert!(lines.contains(&heading), "{heading}\n{}", outcome.stdout);
    }
    assert!(!outcome.stdout.contains("--indirect-limit"), "{}", outcome.stdout);
    let long = help("render --help");
    assert!(long.contains("--indirect-limit") && long.contains("Examples:"), "{long}");
    for preset in holo_dataset::settings::PRESETS {
        assert!(long.contains(&format!("- {}: {}", preset.name, preset.help)), "{}", preset.name);
    }
}
