//! A rehearsal of a release: everything that publishing needs, but nothing is published.
//!
//! Every step runs, also after one that failed, so that one run says all that is missing.

use std::path::Path;
use std::process::Command;

use crate::outside::blender;
use crate::release::{dist, package};
use crate::setup::{cargo, process};
use crate::{Result, root, target};

/// The libraries and the program in the order in which they can be published: each after those that it needs.
const PACKAGES: [&str; 9] = [
    "holo-core",
    "holo-scene",
    "holo-render",
    "holo-io",
    "holo-dataset",
    "holo-viewer",
    "holo-preview",
    "holoscopic",
    "holo-cli",
];

/// The last release whose interface is compared: the commit of 0.2.0, which has no tag.
const BEFORE: &str = "71164b0";

/// What a step found.
enum Found {
    Ready(String),
    /// It needs what this machine lacks.
    NotRun(String),
}

type Step = fn() -> Result<Found>;

/// What is checked, in order.
const STEPS: [(&str, Step); 8] = [
    ("clean tree", clean),
    ("versions", versions),
    ("packages", packages),
    ("documentation as on docs.rs", documentation),
    ("licenses", licenses),
    ("interface against 0.2.0", interface),
    ("wheel in an empty environment", wheel),
    ("archive and Blender extension", archives),
];

/// Runs all steps and prints what is left for a person to press.
///
/// # Errors
///
/// If a step fails.
pub fn run(arguments: &[String]) -> Result {
    if arguments != ["--dry-run"] {
        return Err("usage: cargo xtask release --dry-run; it publishes nothing".into());
    }
    let mut lines = Vec::new();
    let mut failed = 0;
    for (name, step) in STEPS {
        println!("== {name}");
        lines.push(match step() {
            Ok(Found::Ready(what)) => format!("ready    {name}: {what}"),
            Ok(Found::NotRun(why)) => format!("not run  {name}: {why}"),
            Err(why) => {
                failed += 1;
                format!("FAILED   {name}: {why}")
            }
        });
    }
    println!("\n{}\n\nleft for a person, with {} of {} steps failed:", lines.join("\n"), failed, STEPS.len());
    for name in PACKAGES {
        println!("  cargo publish -p {name}");
    }
    println!("  upload target/wheels to PyPI, one wheel a system");
    println!("  upload target/blender/holoscopic-{0}.zip to extensions.blender.org", env!("CARGO_PKG_VERSION"));
    println!(
        "  git tag v{0}, and attach target/dist/holo-{0}-* and target/report (cargo xtask report --peers) to it",
        env!("CARGO_PKG_VERSION")
    );
    println!("  the full citation of the paper, which no document has yet");
    if failed == 0 { Ok(()) } else { Err(format!("{failed} steps failed")) }
}

fn clean() -> Result<Found> {
    let changed = process::output(Command::new("git").current_dir(root()).args(["status", "--porcelain"]))?;
    match changed.lines().count() {
        0 => Ok(Found::Ready("nothing is uncommitted".into())),
        count => Err(format!("{count} files are not committed")),
    }
}

/// Whether every file that names the version names this one.
fn versions() -> Result<Found> {
    let version = env!("CARGO_PKG_VERSION");
    let wanted = [
        ("CHANGELOG.md", format!("## [{version}]")),
        ("CITATION.cff", format!("\nversion: {version}\n")),
        ("integrations/blender/holoscopic/blender_manifest.toml", format!("\nversion = \"{version}\"\n")),
    ];
    for (name, text) in &wanted {
        let path = root().join(name);
        let found = std::fs::read_to_string(&path).map_err(|why| format!("{name}: {why}"))?;
        if !found.contains(text) {
            return Err(format!("{name} does not have {text:?}"));
        }
    }
    Ok(Found::Ready(format!("{version} in {} files", wanted.len() + 1)))
}

fn packages() -> Result<Found> {
    package::run()?;
    Ok(Found::Ready("each compiles from what it contains".into()))
}

/// With all features and without those of dependencies, where a warning is an error.
fn documentation() -> Result<Found> {
    let mut arguments = vec!["doc", "--quiet", "--no-deps", "--all-features"];
    arguments.extend(PACKAGES.iter().flat_map(|name| ["-p", name]));
    cargo::run_with(&arguments, vec![("RUSTDOCFLAGS", "-D warnings".into())])?;
    Ok(Found::Ready(format!("{} packages without a warning", PACKAGES.len())))
}

fn licenses() -> Result<Found> {
    if !process::exists("cargo-deny") {
        return Ok(Found::NotRun("needs cargo-deny; `.ci/nightly deny` installs it".into()));
    }
    cargo::run(&["deny", "--workspace", "check", "licenses", "bans", "sources"])?;
    Ok(Found::Ready("as deny.toml allows".into()))
}

/// Breaks are expected of a version before 1.0; the changelog has them in its table.
fn interface() -> Result<Found> {
    if !process::exists("cargo-semver-checks") {
        return Ok(Found::NotRun("needs cargo-semver-checks; `.ci/nightly semver` installs it".into()));
    }
    let mut broken = Vec::new();
    for name in ["holo-core", "holo-scene", "holo-render", "holo-io", "holo-dataset", "holo-viewer"] {
        let arguments = ["semver-checks", "--baseline-rev", BEFORE, "--default-features", "-p", name];
        if cargo::run(&arguments).is_err() {
            broken.push(name);
        }
    }
    Ok(Found::Ready(match broken.as_slice() {
        [] => "no break".into(),
        names => format!("breaks in {}, which a minor version before 1.0 may have; see CHANGELOG.md", names.join(", ")),
    }))
}

/// Builds the wheel, installs it where nothing else is, and renders with it.
fn wheel() -> Result<Found> {
    let (wheels, place) = (target().join("wheels"), target().join("wheel-environment"));
    for folder in [&wheels, &place] {
        if folder.exists() {
            std::fs::remove_dir_all(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
        }
    }
    let python = process::python()?;
    let source = root().join("crates/holo-python");
    // The name of the wheel says which systems it runs on, by the symbols that it needs.
    let mut build = Command::new(python);
    build.env("MATURIN_PEP517_ARGS", "--compatibility pypi").args(["-m", "pip", "wheel", "--no-deps", "-w"]);
    process::run(build.arg(&wheels).arg(source))?;
    process::run(Command::new(python).args(["-m", "venv"]).arg(&place))?;
    let inside = place.join("bin").join("python");
    let file = only_file(&wheels)?;
    process::run(Command::new(&inside).args(["-m", "pip", "install", "--quiet"]).arg(wheels.join(&file)))?;
    let shown = process::output(Command::new(&inside).args(["-I", "-c", TRY]))?;
    Ok(Found::Ready(format!("{file}: {}", shown.trim())))
}

const TRY: &str = "import holo
scene = holo.Scene.gallery('plaster')
result = holo.render(scene, views=(3, 3), lenses=(16, 24), spp=1, disparity=(-1, 1), integrator='direct')
print('a light field of', result.light_field.array.shape, result.light_field.array.dtype)";

fn only_file(folder: &Path) -> Result<String> {
    let entries = std::fs::read_dir(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let mut names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.next().ok_or_else(|| format!("{} is empty", folder.display()))
}

fn archives() -> Result<Found> {
    dist::run(&["--check".to_owned()])?;
    blender::run(&["--bundle".to_owned()])?;
    Ok(Found::Ready("target/dist, target/blender".into()))
}
