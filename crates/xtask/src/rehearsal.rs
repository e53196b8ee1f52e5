//! A rehearsal of a release: everything that publishing needs, but nothing is published.
//!
//! Every step runs, also after one that failed, so that one run says all that is missing.

use std::path::Path;
use std::process::Command;

use crate::outside::{blender, renderers};
use crate::release::licenses::{self, Embree};
use crate::release::{dist, package};
use crate::setup::{cargo, process};
use crate::{Result, root, target};

/// What a step found.
enum Found {
    Ready(String),
    /// It needs what this machine lacks.
    NotRun(String),
}

type Step = fn() -> Result<Found>;

/// What is checked, in order.
const STEPS: [(&str, Step); 10] = [
    ("clean tree", clean),
    ("versions", versions),
    ("packages", packages),
    ("documentation as on docs.rs", documentation),
    ("licenses, sources, advisories", || nightly("deny")),
    ("interface against the last release", || nightly("semver")),
    ("Windows and macOS", || nightly("systems")),
    ("wheel in an empty environment", wheel),
    ("archive without Rust", archive),
    ("Blender extension", extension),
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
    for name in package::PACKAGES {
        println!("  cargo publish -p {name}");
    }
    println!("  upload target/wheels to PyPI, one wheel a system");
    println!("  upload target/blender/holoscopic-{0}.zip to extensions.blender.org", env!("CARGO_PKG_VERSION"));
    println!(
        "  git tag v{0}, and attach target/dist/holo-{0}-* and target/report (cargo xtask report --peers) to it",
        env!("CARGO_PKG_VERSION")
    );
    println!(
        "  the address of the repository in Cargo.toml and pyproject.toml: by it crates.io and PyPI resolve links of READMEs"
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

/// With the features that docs.rs takes and without dependencies, where a warning is an error.
fn documentation() -> Result<Found> {
    // The feature `bench` of the renderer is no public interface.
    let (renderer, others): (Vec<_>, Vec<_>) = package::PACKAGES.into_iter().partition(|name| *name == "holo-render");
    for (packages, features) in [(others, "--all-features"), (renderer, "--no-default-features")] {
        let mut arguments = vec!["doc", "--quiet", "--no-deps", features];
        arguments.extend(packages.into_iter().flat_map(|name| ["-p", name]));
        cargo::run_with(&arguments, vec![("RUSTDOCFLAGS", "-D warnings".into())])?;
    }
    Ok(Found::Ready(format!("{} packages without a warning", package::PACKAGES.len())))
}

/// A step of the nightly checks, which installs the tool that it needs.
fn nightly(step: &str) -> Result<Found> {
    process::run(Command::new(root().join(".ci").join("nightly")).arg(step))?;
    Ok(Found::Ready(format!("`.ci/nightly {step}`")))
}

/// Builds the wheel that is published, installs it where nothing else is, Rust neither, and renders with its Embree.
fn wheel() -> Result<Found> {
    let (wheels, texts, place) =
        (target().join("wheels"), target().join("wheel-licenses"), target().join("wheel-environment"));
    for folder in [&wheels, &texts, &place] {
        if folder.exists() {
            std::fs::remove_dir_all(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
        }
    }
    let python = process::python()?;
    let source = root().join("crates/holo-python");
    // The name of the wheel says which systems it runs on, by the symbols that it needs.
    let mut build = Command::new(python);
    build.env("MATURIN_PEP517_ARGS", "--compatibility pypi --profile release");
    process::run(build.args(["-m", "pip", "wheel", "--no-deps", "-w"]).arg(&wheels).arg(source))?;
    let file = only_file(&wheels)?;
    licenses::write(&texts, ("holo-python", &["hdf5"]), &process::host()?, Embree::Outside)?;
    process::run(Command::new(python).args(["-c", WITH_TEXTS]).arg(wheels.join(&file)).arg(&texts))?;
    process::run(Command::new(python).args(["-m", "venv"]).arg(&place))?;
    let binaries = place.join("bin");
    let inside = || {
        let mut python = Command::new(binaries.join("python"));
        python.env("PATH", &binaries);
        python
    };
    let with_embree = format!("{}[embree]", wheels.join(&file).display());
    process::run(inside().args(["-m", "pip", "install", "--quiet", "--only-binary", ":all:", &with_embree]))?;
    let shown = process::output(inside().args(["-I", "-c", TRY]))?;
    Ok(Found::Ready(format!("{file}: {}", shown.trim())))
}

/// Adds the license texts of what is linked into a wheel to it.
const WITH_TEXTS: &str = "
import base64, hashlib, os, sys, zipfile
wheel, folder = sys.argv[1:]
with zipfile.ZipFile(wheel) as old:
    entries = [(entry, old.read(entry)) for entry in old.infolist()]
record, lines = next(pair for pair in entries if pair[0].filename.endswith('.dist-info/RECORD'))
inside = os.path.dirname(record.filename) + '/licenses/'
with zipfile.ZipFile(wheel + '.part', 'w', zipfile.ZIP_DEFLATED) as new:
    for entry, data in entries:
        if entry is not record:
            new.writestr(entry, data)
    for at, folders, names in os.walk(folder):
        folders.sort()
        for name in sorted(names):
            path = os.path.join(at, name)
            entry = zipfile.ZipInfo(inside + os.path.relpath(path, folder).replace(os.sep, '/'))
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o100644 << 16
            with open(path, 'rb') as file:
                data = file.read()
            new.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()
            lines += f'{entry.filename},sha256={digest},{len(data)}\\n'.encode()
    new.writestr(record, lines)
os.replace(wheel + '.part', wheel)
";

const TRY: &str = "import holo
scene = holo.Scene.gallery('plaster')
size = {'views': (3, 3), 'lenses': (16, 24), 'disparity': (-1, 1)}
result = holo.render(scene, **size, spp=1, integrator='direct', backend='embree')
print('a light field of', result.light_field.array.shape, result.light_field.array.dtype, 'by Embree')";

fn only_file(folder: &Path) -> Result<String> {
    let entries = std::fs::read_dir(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let mut names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.next().ok_or_else(|| format!("{} is empty", folder.display()))
}

fn archive() -> Result<Found> {
    dist::run(&["--check".to_owned()])?;
    Ok(Found::Ready("target/dist".into()))
}

/// Packs the extension and checks it with Blender's own command.
fn extension() -> Result<Found> {
    blender::run(&["--bundle".to_owned()])?;
    let Some((python, home)) = renderers::module(&renderers::BLENDER)? else {
        return Ok(Found::NotRun(
            "target/blender is packed; to validate it, Blender's module needs Python 3.11".into(),
        ));
    };
    let found = "import pathlib, sys; print(next(pathlib.Path(sys.argv[1]).glob('bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py')))";
    let tool = process::output(Command::new(python.trim()).args(["-c", found]).arg(&home))?;
    let archive = target().join("blender").join(format!("holoscopic-{}.zip", env!("CARGO_PKG_VERSION")));
    process::run(Command::new(python.trim()).args([tool.trim(), "validate"]).arg(archive))?;
    Ok(Found::Ready("target/blender, which Blender finds valid".into()))
}
