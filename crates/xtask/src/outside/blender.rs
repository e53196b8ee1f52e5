//! The Blender extension as an archive, `target/blender/holoscopic-VERSION.zip`, and its tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::setup::pip::Availability;
use crate::setup::{process, python};
use crate::{Result, outside::renderers, program, release::dist, root, target};

/// Writes the archive; with `--bundle` the program and Embree are in it; with `--test` runs the tests in Blender's module.
///
/// # Errors
///
/// If the program cannot be built, the archive cannot be written, or a test fails.
pub fn run(arguments: &[String]) -> Result {
    let (mut bundle, mut test, mut rest) = (false, false, Vec::new());
    for argument in arguments {
        match argument.as_str() {
            "--bundle" => bundle = true,
            "--test" => test = true,
            other if test => rest.push(other),
            _ => return Err("usage: cargo xtask blender [--bundle] [--test [PYTEST ARGUMENTS]]".into()),
        }
    }
    let archive = target().join("blender").join(format!("holoscopic-{}.zip", env!("CARGO_PKG_VERSION")));
    pack(&archive, bundle)?;
    println!("{}", archive.display());
    if test { run_tests(&archive, &rest) } else { Ok(()) }
}

/// Writes the archive: the same bytes for the same files.
fn pack(archive: &Path, bundle: bool) -> Result {
    let folder = archive.parent().unwrap_or(archive);
    std::fs::create_dir_all(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let programs = if bundle { dist::unpacked()? } else { PathBuf::new() };
    process::run(Command::new(process::python()?).args(["-c", PACK]).arg(sources()).arg(archive).arg(programs))
}

/// Names are sorted, times are fixed. Of the program's folder only what runs and its licenses are taken.
const PACK: &str = "
import os, sys, zipfile
source, archive, programs = sys.argv[1:]
entries = []
def add(folder, prefix, wanted):
    for at, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if name != '__pycache__']
        for name in names:
            path = os.path.join(at, name)
            inside = os.path.relpath(path, folder).replace(os.sep, '/')
            if wanted(inside):
                entries.append((prefix + inside, path))
add(source, '', lambda name: not name.endswith('.pyc'))
if programs:
    add(programs, 'bin/', lambda name: name not in ('README.md', 'CHANGELOG.md'))
with zipfile.ZipFile(archive + '.part', 'w', zipfile.ZIP_DEFLATED) as out:
    for name, path in sorted(entries):
        entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
        entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
        entry.external_attr = (0o100755 if name in ('bin/holo', 'bin/holo.exe') else 0o100644) << 16
        with open(path, 'rb') as data:
            out.writestr(entry, data.read())
os.replace(archive + '.part', archive)
";

/// Runs the tests in two versions of Blender with the release build of the program. Blender's module fits one version of Python, so a machine without
/// it is no failure unless `HOLO_REQUIRE_PEERS` is 1.
fn run_tests(archive: &Path, arguments: &[&str]) -> Result {
    if let Availability::Missing(why) = python::ensure()? {
        return not_run(&why);
    }
    crate::build()?;
    for requirements in [&renderers::BLENDER_LTS, &renderers::BLENDER] {
        let name = requirements.name;
        let Some((python, home)) = renderers::module(requirements)? else {
            return not_run("needs Python 3.11 and Blender's module for it");
        };
        println!("{name}:");
        test_in(&python, home, archive, &target().join("blender").join(name), arguments)?;
    }
    Ok(())
}

/// Runs the tests in one version of Blender; images and a table go into `report`.
fn test_in(python: &str, home: PathBuf, archive: &Path, report: &Path, arguments: &[&str]) -> Result {
    let tests = root().join("integrations").join("blender").join("tests");
    // Blender's own version of numpy comes first.
    let path = std::env::join_paths([home, tests.clone(), python::packages()]).map_err(|why| why.to_string())?;
    let mut pytest = Command::new(python.trim());
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(tests).args(arguments);
    pytest.env("PYTHONPATH", path).env("PYTHONDONTWRITEBYTECODE", "1").env("HOLO", program(&target()));
    pytest.env("HOLOSCOPIC_ZIP", archive).env("HOLOSCOPIC_REPORT", report);
    process::run(&mut pytest)
}

fn not_run(why: &str) -> Result {
    let line = format!("the Blender extension: {why}");
    if std::env::var_os("HOLO_REQUIRE_PEERS").is_some_and(|value| value == "1") {
        return Err(line);
    }
    println!("not run: {line}");
    Ok(())
}

fn sources() -> PathBuf {
    root().join("integrations").join("blender").join("holoscopic")
}
