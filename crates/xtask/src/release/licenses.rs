//! The licenses of everything that a release of `holo` or its wheel contains: crates, the Rust standard library, Embree and oneTBB.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::setup::{cargo, embree, process};
use crate::{Result, root};

/// A piece of software by others, with its license texts.
struct Component {
    name: String,
    version: String,
    /// The SPDX expression.
    license: String,
    /// The license texts: names relative to the component's folder, and contents.
    texts: BTreeMap<String, Vec<u8>>,
}

/// Crates whose packages lack a license file, and where the text of their license is.
const WITHOUT_FILE: &[(&str, Text)] = &[
    ("draco-core", Text::Apache),
    ("hdf5-metno", Text::Apache),
    ("hdf5-metno-sys", Text::Apache),
    ("hdf5-metno-types", Text::Apache),
    // From the same repository.
    ("pulp-wasm-simd-flag", Text::Of("pulp")),
    ("zune-inflate", Text::Apache),
];

/// A license text that is not in the crate's own package.
#[derive(Clone, Copy)]
enum Text {
    /// The standard text of Apache-2.0, which is one of the crate's licenses.
    Apache,
    /// The license file of another crate.
    Of(&'static str),
}

/// Where Embree and oneTBB lie.
#[derive(Clone, Copy, PartialEq)]
pub enum Embree {
    /// In the archive, if the system has them.
    Inside,
    /// In a package of others.
    Outside,
}

/// Writes `THIRD-PARTY.md` and the folder `licenses` into `folder`, for what `package` links with its `features`.
///
/// # Errors
///
/// If a crate has no license text.
pub fn write(folder: &Path, (package, features): (&str, &[&str]), target: &str, embree: Embree) -> Result {
    let mut components = crates(package, features, target)?;
    components.push(standard_library()?);
    let libraries = if embree == Embree::Inside { embree_and_tbb()? } else { Vec::new() };
    let head = if libraries.is_empty() {
        ""
    } else {
        "The folder `embree` contains the libraries Embree and oneTBB, unchanged.\n"
    };
    components.extend(libraries);
    let mut list = format!("{HEAD}{head}\n{TABLE}");
    for component in &components {
        let own = format!("{}-{}", component.name, component.version);
        let mut links = Vec::new();
        for (name, text) in &component.texts {
            let path = folder.join("licenses").join(&own).join(name);
            write_file(&path, text)?;
            links.push(format!("[{name}](licenses/{own}/{name})"));
        }
        let Component { name, version, license, .. } = component;
        list += &format!("| {name} | {version} | {license} | {} |\n", links.join(", "));
    }
    write_file(&folder.join("THIRD-PARTY.md"), list.as_bytes())
}

const HEAD: &str = "# Software by others\n\n\
    `holo` contains the Rust standard library and the crates of this list.\n";

const TABLE: &str = "| name | version | license | texts |\n|---|---|---|---|\n";

fn write_file(path: &Path, contents: &[u8]) -> Result {
    let folder = path.parent().unwrap_or(path);
    std::fs::create_dir_all(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    std::fs::write(path, contents).map_err(|why| format!("{}: {why}", path.display()))
}

fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|why| format!("{}: {why}", path.display()))
}

/// All crates of other projects that are linked into a package of this workspace, by name and version.
fn crates(package: &str, features: &[&str], target: &str) -> Result<Vec<Component>> {
    let mut cargo = cargo::command();
    cargo.args(["metadata", "--format-version", "1", "--filter-platform", target]);
    if !features.is_empty() {
        let features: Vec<String> = features.iter().map(|feature| format!("{package}/{feature}")).collect();
        cargo.arg("--features").arg(features.join(","));
    }
    let metadata: Value = serde_json::from_str(&process::output(&mut cargo)?).map_err(|why| why.to_string())?;
    let linked = linked(&metadata, package)?;
    let folder_of =
        |name: &str| linked.iter().find(|package| package["name"] == name).and_then(|package| package_folder(package));
    let mut components = Vec::new();
    for package in &linked {
        // A package without a source is one of this workspace.
        if package["source"].is_null() {
            continue;
        }
        let text = |key: &str| package[key].as_str().unwrap_or_default().to_owned();
        let (name, version) = (text("name"), text("version"));
        let license = if package["license"].is_null() { text("license_file") } else { text("license") };
        let folder = package_folder(package).ok_or_else(|| format!("{name}: no manifest_path in cargo metadata"))?;
        let mut texts = license_files(&folder)?;
        if texts.is_empty() {
            texts = match WITHOUT_FILE.iter().find(|(crate_name, _)| *crate_name == name) {
                Some((_, Text::Apache)) => apache()?,
                Some((_, Text::Of(other))) => license_files(&folder_of(other).unwrap_or(folder))?,
                None => BTreeMap::new(),
            };
        }
        if texts.is_empty() {
            return Err(without_text(&name, &version, &license));
        }
        components.push(Component { name, version, license, texts });
    }
    components.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(components)
}

fn without_text(name: &str, version: &str, license: &str) -> String {
    let ids = license.split([' ', '/', '(', ')']).filter(|id| !["", "OR", "AND", "WITH"].contains(id));
    let pages: Vec<String> = ids.map(|id| format!("https://spdx.org/licenses/{id}.html")).collect();
    format!(
        "{name} {version} ({license}) contains no license file. The standard text is {}; name its place in \
         WITHOUT_FILE of crates/xtask/src/release/licenses.rs",
        pages.join(" or ")
    )
}

fn package_folder(package: &Value) -> Option<PathBuf> {
    Path::new(package["manifest_path"].as_str()?).parent().map(PathBuf::from)
}

/// The packages that one reaches by normal dependencies. Macro crates run in the compiler and are not linked.
fn linked<'a>(metadata: &'a Value, from: &str) -> Result<Vec<&'a Value>> {
    let list = |value: &'_ Value| value.as_array().cloned().unwrap_or_default();
    let packages = metadata["packages"].as_array().ok_or("cargo metadata lists no packages")?;
    let by_id: BTreeMap<&str, &Value> = packages.iter().filter_map(|p| Some((p["id"].as_str()?, p))).collect();
    let mut dependencies = BTreeMap::new();
    for node in list(&metadata["resolve"]["nodes"]) {
        let is_normal = |dependency: &&Value| list(&dependency["dep_kinds"]).iter().any(|kind| kind["kind"].is_null());
        let of =
            list(&node["deps"]).iter().filter(is_normal).map(|d| d["pkg"].as_str().unwrap_or("").to_owned()).collect();
        dependencies.insert(node["id"].as_str().unwrap_or_default().to_owned(), of);
    }
    let is_macro =
        |package: &Value| list(&package["targets"]).iter().any(|t| list(&t["kind"]).contains(&"proc-macro".into()));
    let first = packages.iter().find(|package| package["name"] == from);
    let first = first.ok_or_else(|| format!("there is no package {from}"))?;
    let mut open: Vec<String> = vec![first["id"].as_str().unwrap_or_default().to_owned()];
    let mut seen = BTreeSet::new();
    let mut linked = Vec::new();
    while let Some(id) = open.pop() {
        let Some(package) = by_id.get(id.as_str()) else { continue };
        if is_macro(package) || !seen.insert(id.clone()) {
            continue;
        }
        linked.push(*package);
        let of: Vec<String> = dependencies.remove(&id).unwrap_or_default();
        open.extend(of);
    }
    Ok(linked)
}

/// The license files of a package, also of the C sources in it.
fn license_files(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut texts = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(at) = open.pop() {
        let entries = std::fs::read_dir(&at).map_err(|why| format!("{}: {why}", at.display()))?;
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if !["tests", "examples", "benches"].contains(&name.as_str()) {
                    open.push(path);
                }
            } else if is_license(&name) {
                let inside = path.strip_prefix(folder).unwrap_or(&path);
                let inside: Vec<_> = inside.iter().map(|part| part.to_string_lossy()).collect();
                texts.insert(inside.join("/"), read(&path)?);
            }
        }
    }
    Ok(texts)
}

fn is_license(name: &str) -> bool {
    let name = name.to_lowercase();
    let starts = ["license", "licence", "unlicense", "copying", "copyright", "notice"];
    let is_code = [".rs", ".c", ".h", ".py", ".cmake", ".toml"].iter().any(|extension| name.ends_with(extension));
    starts.iter().any(|start| name.starts_with(start)) && !is_code
}

/// The standard text of Apache-2.0.
fn apache() -> Result<BTreeMap<String, Vec<u8>>> {
    Ok(BTreeMap::from([("LICENSE-APACHE".to_owned(), read(&root().join("LICENSE-APACHE"))?)]))
}

fn standard_library() -> Result<Component> {
    let rustc = || Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    let version = process::output(rustc().arg("--version"))?;
    let version = version.split_whitespace().nth(1).unwrap_or("unknown").to_owned();
    let sysroot = process::output(rustc().args(["--print", "sysroot"]))?;
    let folder = Path::new(sysroot.trim()).join("share/doc/rust");
    let mut texts = BTreeMap::new();
    for name in ["COPYRIGHT-library.html", "licenses/Apache-2.0.txt", "licenses/MIT.txt"] {
        if let Ok(text) = std::fs::read(folder.join(name)) {
            texts.insert(name.to_owned(), text);
        }
    }
    if texts.is_empty() {
        texts = apache()?;
    }
    Ok(Component { name: "rust-standard-library".into(), version, license: "MIT OR Apache-2.0".into(), texts })
}

/// Embree and oneTBB, if the archive has them. The wheel contains the license of its Python code alone.
fn embree_and_tbb() -> Result<Vec<Component>> {
    if embree::library_files(&embree::folder()).is_empty() {
        return Ok(Vec::new());
    }
    let wheel = license_files(&embree::folder().join("licenses"))?;
    let apache_of = |name: &str, version: &str| -> Result<Component> {
        let license = "Apache-2.0".into();
        Ok(Component { name: name.into(), version: version.into(), license, texts: apache()? })
    };
    let version = embree::version()?;
    let mut list = vec![apache_of("Embree", &version)?, apache_of("oneTBB", &format!("of-embree-{version}"))?];
    if !wheel.is_empty() {
        list.push(Component { name: "embreex".into(), version, license: "BSD-2-Clause".into(), texts: wheel });
    }
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn license_files_are_told_by_their_names() {
        for name in ["LICENSE", "LICENSE-MIT", "license.txt", "COPYING", "UNLICENSE", "COPYRIGHT", "NOTICE.md"] {
            assert!(is_license(name), "{name}");
        }
        for name in ["license.rs", "README.md", "copyright.h", "src"] {
            assert!(!is_license(name), "{name}");
        }
    }

    #[test]
    fn every_linked_crate_has_the_text_of_its_license() {
        let crates = crates("holo-cli", &["hdf5"], "x86_64-unknown-linux-gnu").expect("a text of every crate");
        assert!(crates.len() > 100, "{}", crates.len());
    }

    #[test]
    fn macros_and_build_dependencies_are_not_linked() {
        let metadata = serde_json::json!({
            "packages": [
                { "id": "0", "name": "holo-cli", "targets": [{ "kind": ["bin"] }] },
                { "id": "1", "name": "used", "targets": [{ "kind": ["lib"] }] },
                { "id": "2", "name": "macros", "targets": [{ "kind": ["proc-macro"] }] },
                { "id": "3", "name": "of-macros", "targets": [{ "kind": ["lib"] }] },
                { "id": "4", "name": "builds", "targets": [{ "kind": ["lib"] }] },
            ],
            "resolve": { "nodes": [
                { "id": "0", "deps": [
                    { "pkg": "1", "dep_kinds": [{ "kind": null }] },
                    { "pkg": "2", "dep_kinds": [{ "kind": null }] },
                    { "pkg": "4", "dep_kinds": [{ "kind": "build" }] },
                ] },
                { "id": "1", "deps": [] },
                { "id": "2", "deps": [{ "pkg": "3", "dep_kinds": [{ "kind": null }] }] },
            ] },
        });
        let names: Vec<_> =
            linked(&metadata, "holo-cli").unwrap().iter().map(|package| package["name"].clone()).collect();
        assert_eq!(names, ["holo-cli", "used"]);
    }

    #[test]
    fn a_crate_without_a_license_file_is_named_with_the_standard_text() {
        let message = without_text("a", "1.0.0", "MIT OR Zlib");
        assert!(message.contains("a 1.0.0") && message.contains("licenses/MIT.html or https"), "{message}");
    }
}
