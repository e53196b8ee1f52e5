//! An archive for machines without Rust: `target/dist/holo-VERSION-TARGET.tar.gz`, on Windows `.zip`.
//!
//! It contains the release binary, the folder `embree` in which the binary looks for its libraries, the readme, the
//! changelog and all licenses. Equal contents give equal archives: names are sorted, and times and owners are fixed. On
//! Linux the binary needs glibc of the version that it was built with, or newer; Embree also needs libstdc++ and
//! without it the built-in BVH is used.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::setup::pip::Availability;
use crate::setup::{cargo, embree, process};
use crate::{Result, features, program, release::licenses, root, target};

/// What the binary may link dynamically on Linux: parts of glibc, and the unwinder of GCC.
const ALLOWED: [&str; 8] = [
    "linux-vdso.so.1",
    "ld-linux-x86-64.so.2",
    "ld-linux-aarch64.so.1",
    "libc.so.6",
    "libm.so.6",
    "libdl.so.2",
    "libpthread.so.0",
    "libgcc_s.so.1",
];

/// Builds the archive; with `--check` also unpacks it and runs what is in it.
pub fn run(arguments: &[String]) -> Result {
    let check_it = match arguments {
        [] => false,
        [argument] if argument == "--check" => true,
        _ => return Err("usage: cargo xtask dist [--check]".into()),
    };
    let folder = unpacked()?;
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let archive = target().join("dist").join(format!("{name}{ENDING}"));
    pack(&folder, &archive)?;
    let size = std::fs::metadata(&archive).map_err(|why| format!("{}: {why}", archive.display()))?.len();
    println!("{} ({} MB)", archive.display(), size.div_ceil(1_000_000));
    if check_it { check(&folder, &archive, &name) } else { Ok(()) }
}

/// Makes the folder that is packed: program, Embree, readme and licenses.
///
/// # Errors
///
/// If the build, pip or a copy fails.
pub fn unpacked() -> Result<PathBuf> {
    let host = process::host()?;
    let binary = build()?;
    let folder = target().join("dist").join(format!("holo-{}-{host}", env!("CARGO_PKG_VERSION")));
    fill(&folder, &binary, &host)?;
    Ok(folder)
}

const ENDING: &str = if cfg!(windows) { ".zip" } else { ".tar.gz" };

const BINARY: &str = if cfg!(windows) { "holo.exe" } else { "holo" };

/// Builds the release binary, without debug information.
fn build() -> Result<PathBuf> {
    let arguments = [&["build", "--release", "-p", "holo-cli"], features()].concat();
    cargo::run_with(&arguments, vec![("CARGO_PROFILE_RELEASE_STRIP", "debuginfo".into())])?;
    Ok(program(&target()))
}

/// Fills the folder that is packed.
fn fill(folder: &Path, binary: &Path, host: &str) -> Result {
    let _ = std::fs::remove_dir_all(folder);
    copy(binary, &folder.join(BINARY))?;
    for name in ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT"] {
        copy(&root().join(name), &folder.join(name))?;
    }
    match embree::fetch()? {
        Availability::Present => {
            for path in embree::all_libraries(&embree::folder()) {
                copy(&path, &folder.join("embree").join(path.file_name().unwrap_or_default()))?;
            }
        }
        Availability::Missing(why) => println!("the archive has no Embree: {why}"),
    }
    licenses::write(folder, ("holo-cli", features().get(1..).unwrap_or_default()), host, licenses::Embree::Inside)
}

fn copy(from: &Path, to: &Path) -> Result {
    let folder = to.parent().unwrap_or(to);
    std::fs::create_dir_all(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    std::fs::copy(from, to).map(drop).map_err(|why| format!("{}: {why}", from.display()))
}

/// Packs `folder` under its own name.
fn pack(folder: &Path, archive: &Path) -> Result {
    // 1980, where the times of zip archives begin.
    let epoch = std::env::var("SOURCE_DATE_EPOCH").unwrap_or_else(|_| "315532800".into());
    process::run(Command::new(process::python()?).args(["-c", PACK]).arg(folder).arg(archive).args([&epoch, BINARY]))
}

const PACK: &str = "
import gzip, os, sys, tarfile, time, zipfile
folder, archive, epoch, binary = sys.argv[1], sys.argv[2], max(int(sys.argv[3]), 315532800), sys.argv[4]
top = os.path.dirname(folder)
paths = [os.path.join(at, name) for at, _, names in os.walk(folder) for name in names]
entries = sorted((os.path.relpath(path, top).replace(os.sep, '/'), path) for path in paths)
mode = lambda path: 0o755 if os.path.basename(path) == binary else 0o644
if archive.endswith('.zip'):
    with zipfile.ZipFile(archive, 'w', zipfile.ZIP_DEFLATED) as out:
        for name, path in entries:
            entry = zipfile.ZipInfo(name, time.gmtime(epoch)[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = (0o100000 | mode(path)) << 16
            with open(path, 'rb') as data:
                out.writestr(entry, data.read())
else:
    with open(archive, 'wb') as raw, gzip.GzipFile('', 'wb', 9, raw, 0) as packed:
        with tarfile.open(fileobj=packed, mode='w', format=tarfile.GNU_FORMAT) as out:
            for name, path in entries:
                entry = tarfile.TarInfo(name)
                entry.size, entry.mode, entry.mtime = os.path.getsize(path), mode(path), epoch
                with open(path, 'rb') as data:
                    out.addfile(entry, data)
";

/// Unpacks the archive and runs the program that is in it with an empty environment.
fn check(folder: &Path, archive: &Path, name: &str) -> Result {
    let again = archive.with_file_name(format!("{name}-again{ENDING}"));
    pack(folder, &again)?;
    let read = |path: &Path| std::fs::read(path).map_err(|why| format!("{}: {why}", path.display()));
    if read(archive)? != read(&again)? {
        return Err("packing the same folder twice gives two different archives".into());
    }
    let _ = std::fs::remove_file(&again);
    let place = target().join("dist").join("check");
    let _ = std::fs::remove_dir_all(&place);
    std::fs::create_dir_all(&place).map_err(|why| format!("{}: {why}", place.display()))?;
    // The module `tarfile` keeps permissions, unlike `zipfile`, which is used on Windows alone.
    let unpack = "import shutil, sys; shutil.unpack_archive(sys.argv[1], sys.argv[2])";
    process::run(Command::new(process::python()?).args(["-c", unpack]).arg(archive).arg(&place))?;
    let program = std::path::absolute(place.join(name).join(BINARY)).map_err(|why| why.to_string())?;
    check_libraries(&program)?;
    let version = holo(&program, &place, "--version")?;
    if version.trim() != concat!("holo ", env!("CARGO_PKG_VERSION")) {
        return Err(format!("holo --version prints '{}'", version.trim()));
    }
    holo(&program, &place, "scene plaster --out plaster.glb")?;
    let formats = if features().is_empty() { "vpi,el,mat,depth,exr" } else { "vpi,el,mat,depth,exr,h5" };
    let render = format!("render plaster.glb --out out --lenses 12x8 --views 5x4 --spp 1 --json --write {formats}");
    let report = holo(&program, &place, &render)?;
    holo(&program, &place, "verify out")?;
    let report: serde_json::Value =
        serde_json::from_str(&report).map_err(|why| format!("holo render --json: {why}"))?;
    let backend = report["backend"].as_str().unwrap_or_default();
    let expected = if folder.join("embree").is_dir() { format!("embree {}", embree::version()?) } else { "bvh".into() };
    if backend != expected {
        return Err(format!("the unpacked program renders with '{backend}', not with '{expected}'"));
    }
    println!("unpacked, holo renders with {backend} and verifies its files; it links glibc alone");
    Ok(())
}

/// Runs the program with nothing but a search path.
fn holo(program: &Path, place: &Path, arguments: &str) -> Result<String> {
    let mut command = Command::new(program);
    command.args(arguments.split_whitespace()).current_dir(place).env_clear().env("PATH", "/usr/bin");
    // Without it Windows starts no program.
    if let Some(folder) = std::env::var_os("SystemRoot") {
        command.env("SystemRoot", folder);
    }
    process::output(&mut command)
}

/// Checks that the program links nothing but [`ALLOWED`].
fn check_libraries(program: &Path) -> Result {
    if !cfg!(target_os = "linux") || !process::exists("ldd") {
        return Ok(());
    }
    let listed = process::output(Command::new("ldd").arg(program))?;
    let names = listed.lines().filter_map(|line| line.split_whitespace().next()?.rsplit('/').next());
    let other: Vec<&str> = names.filter(|name| !ALLOWED.contains(name)).collect();
    if other.is_empty() { Ok(()) } else { Err(format!("the program needs {}", other.join(", "))) }
}
