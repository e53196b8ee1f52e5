//! Python packages from PyPI, in folders of their own under `target/`: a bare Debian has no venv.
//!
//! The versions and the SHA-256 of every wheel are pinned in `requirements/`; pip refuses any other file. An
//! installation that fails is an error. A machine that cannot have the packages at all (no Python, no wheel for its
//! processor) is not: see [`Availability`].

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Result;
use crate::setup::process;

/// Whether this machine has something that can be fetched.
pub enum Availability {
    /// It is here.
    Present,
    /// It is not, and why.
    Missing(String),
}

impl Availability {
    /// Whether it is here.
    pub fn is_present(&self) -> bool {
        matches!(self, Self::Present)
    }
}

/// Operating system and processor, as `std::env::consts` names them.
type Platform = (&'static str, &'static str);

/// A set of packages that are installed together.
pub struct Requirements {
    /// The stem of the file in `requirements/`.
    pub name: &'static str,
    /// The minor versions of Python 3 that the pinned wheels fit.
    pub pythons: RangeInclusive<u32>,
    /// The platforms that the pinned wheels fit.
    pub platforms: &'static [Platform],
}

/// The platforms that most packages have wheels for.
pub const COMMON_PLATFORMS: &[Platform] =
    &[("linux", "x86_64"), ("linux", "aarch64"), ("macos", "x86_64"), ("macos", "aarch64"), ("windows", "x86_64")];

impl Requirements {
    /// The file with versions and hashes.
    pub fn file(&self) -> PathBuf {
        crate::root().join("crates/xtask/requirements").join(self.name).with_extension("txt")
    }

    /// A Python of this machine that can install the packages; the error says what is missing.
    pub fn python(&self) -> Result<&'static str> {
        let platform = (std::env::consts::OS, std::env::consts::ARCH);
        if !self.platforms.contains(&platform) || cfg!(target_env = "musl") {
            let libc = if cfg!(target_env = "musl") { " with musl" } else { "" };
            return Err(format!("PyPI has no wheels for {} on {}{libc}", platform.1, platform.0));
        }
        let names = ["python3", "python", "python3.13", "python3.12", "python3.11", "python3.10"];
        let mut found = Vec::new();
        for name in names.into_iter().filter(|name| process::exists(name)) {
            let Some(minor) = minor_version(name) else { continue };
            if !self.pythons.contains(&minor) {
                found.push(format!("{name} is 3.{minor}"));
            } else if !has_pip(name) {
                found.push(format!("{name} has no pip (Debian's package python3-pip)"));
            } else {
                return Ok(name);
            }
        }
        let found = if found.is_empty() { "there is no python3".to_owned() } else { found.join(", ") };
        Err(format!("needs Python {} with pip; {found}", self.versions()))
    }

    fn versions(&self) -> String {
        let (first, last) = (self.pythons.start(), self.pythons.end());
        match last {
            &u32::MAX => format!("3.{first} or newer"),
            _ if first == last => format!("3.{first}"),
            _ => format!("3.{first} to 3.{last}"),
        }
    }
}

fn minor_version(python: &str) -> Option<u32> {
    let print = "import sys; print(sys.version_info[1] if sys.version_info[0] == 3 else '')";
    let output = Command::new(python).args(["-c", print]).output().ok()?;
    String::from_utf8_lossy(&output.stdout).trim().parse().ok()
}

fn has_pip(python: &str) -> bool {
    let output = Command::new(python).args(["-m", "pip", "--version"]).env_remove("PYTHONPATH").output();
    output.is_ok_and(|output| output.status.success())
}

/// Installs packages with their dependencies into `home`, which must be named without an extension, unless they are
/// there.
///
/// They are installed beside `home` and then renamed: an interrupted run leaves no incomplete folder behind.
/// `home.python` holds the name of the Python that they were installed for.
///
/// # Errors
///
/// If pip fails: without a network, or where a file has another hash.
pub fn install(requirements: &Requirements, home: &Path) -> Result<Availability> {
    if installed(requirements, home).is_some() {
        return Ok(Availability::Present);
    }
    let python = match requirements.python() {
        Ok(python) => python,
        Err(why) => return Ok(Availability::Missing(why)),
    };
    eprintln!("xtask: fetching the packages of crates/xtask/requirements/{}.txt from PyPI", requirements.name);
    let fresh = home.with_extension("part");
    let _ = std::fs::remove_dir_all(&fresh);
    run(
        Command::new(python)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--root-user-action=ignore"])
            // The files list dependencies too; packages of the system, which pip would compare them with, do not matter.
            .args(["--no-warn-script-location", "--no-deps", "--target"])
            .arg(&fresh),
        requirements,
    )?;
    finish(requirements, &fresh, home)?;
    write(&home.with_extension("python"), python)?;
    Ok(Availability::Present)
}

/// The Python that the packages in `home` were installed for, if they are those that are pinned now.
pub fn installed(requirements: &Requirements, home: &Path) -> Option<String> {
    if !is_current(requirements, home) {
        return None;
    }
    std::fs::read_to_string(home.with_extension("python")).ok()
}

/// Downloads the wheels themselves, without dependencies, into an empty `folder`.
///
/// # Errors
///
/// As [`install`].
pub fn download(requirements: &Requirements, python: &str, folder: &Path) -> Result {
    let _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let mut pip = Command::new(python);
    pip.args(["-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps", "--dest"]).arg(folder);
    run(&mut pip, requirements)
}

/// Renames `fresh` to `home`, with a copy of the requirements in it.
pub fn finish(requirements: &Requirements, fresh: &Path, home: &Path) -> Result {
    let file = requirements.file();
    let text = std::fs::read_to_string(&file).map_err(|why| format!("{}: {why}", file.display()))?;
    write(&fresh.join(COPY), &text)?;
    let _ = std::fs::remove_dir_all(home);
    std::fs::rename(fresh, home).map_err(|why| format!("{}: {why}", home.display()))
}

/// Whether `home` holds what is pinned now.
pub fn is_current(requirements: &Requirements, home: &Path) -> bool {
    let read = |path: &Path| std::fs::read_to_string(path).ok();
    read(&home.join(COPY)).is_some_and(|copy| Some(copy) == read(&requirements.file()))
}

/// The copy of the requirements in a folder that was installed from them.
const COPY: &str = "holo_requirements.txt";

fn run(pip: &mut Command, requirements: &Requirements) -> Result {
    pip.args(["--only-binary=:all:", "--require-hashes", "--requirement"]).arg(requirements.file());
    // Packages that are installed elsewhere must not count as installed here.
    process::run(pip.env_remove("PYTHONPATH")).map_err(|why| {
        format!("{why}\nNo download is needed for `cargo build --release -p holo-cli` and `cargo test --workspace`.")
    })
}

fn write(path: &Path, text: &str) -> Result {
    std::fs::write(path, text).map_err(|why| format!("{}: {why}", path.display()))
}
