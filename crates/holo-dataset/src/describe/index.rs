//! The two files in the root of a dataset: `dataset.json` for programs, `DATASET.md` for human readers.

use std::collections::BTreeMap;
use std::fmt::Write;

use holo_core::LightFieldShape;
use holo_io::Folder;
use holo_io::dataset::{self as names, DatasetIndex, SceneEntry};
use holo_scene::gallery;

use super::catalog;
use crate::Error;
use crate::settings::{RenderSettings, texts};

/// SPDX identifier of the license of the images.
const LICENSE: &str = "CC0-1.0";

/// The conventions in `dataset.json` and `DATASET.md`. Their text is part of the files, so it must not change.
const CONVENTIONS: [(&str, &str); 8] = [
    ("axes", "Light fields have the axes (v, u, t, s, c): lens row, lens column, view row, view column, channel."),
    ("scene_el.png", "Elemental grid, the raw image: lens (v, u) owns the T x S block at row v*T, column u*S."),
    ("scene_vpi.png", "Viewpoint grid: view (t, s) owns the V x U block at row t*V, column s*U."),
    (
        "scene_5d.mat",
        "H of size [V U T S C]: squeeze(H(i,j,:,:,:)) is an elemental image, squeeze(H(:,:,k,l,:)) a view.",
    ),
    (
        "disparity",
        "Pixels between adjacent views, positive nearer than the focus plane; of the central view, row floor(T/2), column floor(S/2).",
    ),
    ("depth", "Metres along the optical axis; infinity where nothing is."),
    ("orientation", "No axis is flipped; rows run down. PFM files keep their rows bottom-up, as the format says."),
    (
        "colour",
        "PNG and MAT files hold the sRGB curve at the exposure of manifest.json; HDF5 and EXR files hold linear radiance.",
    ),
];

/// A light field of a dataset.
pub(crate) struct Entry {
    /// The name of its scene in the dataset.
    pub name: String,
    /// The name of the scene itself.
    pub scene: String,
    /// The digest of the scene.
    pub sha256: String,
    pub shape: LightFieldShape,
}

/// Settings as text, by key.
type Options = BTreeMap<String, String>;

/// Writes both files for a dataset of these jobs.
pub(crate) fn write(root: &Folder, entries: &[Entry], options: &Options, backend: &str) -> Result<(), Error> {
    let index = index(entries, options, backend)?;
    // The catalog of other folders would be one of none.
    if DatasetIndex::read_in(root).ok().as_ref() != Some(&index) {
        catalog::remove(root)?;
    }
    index.write_in(root)?;
    holo_io::write_file(root.file(names::DATASET_MD), document(&index).as_bytes())?;
    Ok(())
}

fn index(entries: &[Entry], options: &Options, backend: &str) -> Result<DatasetIndex, Error> {
    let mut scenes: Vec<SceneEntry> = Vec::new();
    let mut shapes: Vec<LightFieldShape> = Vec::new();
    for Entry { name, scene, sha256, shape } in entries {
        if scenes.iter().all(|scene| scene.name != *name) {
            let purpose = gallery::purpose(scene).unwrap_or("a scene from a file").to_owned();
            scenes.push(SceneEntry { name: name.clone(), purpose, sha256: sha256.clone() });
        }
        if !shapes.contains(shape) {
            shapes.push(*shape);
        }
    }
    let pairs = |pairs: &[(&str, &str)]| pairs.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    Ok(DatasetIndex {
        versions: BTreeMap::from([
            ("holo".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("engine".to_owned(), backend.to_owned()),
        ]),
        options: options.clone(),
        scenes,
        shapes,
        conventions: pairs(&CONVENTIONS),
        license: LICENSE.to_owned(),
    })
}

/// The text of `DATASET.md`.
fn document(index: &DatasetIndex) -> String {
    let mut text = String::new();
    // Writing into a `String` cannot fail.
    let _ = write_document(index, &mut text);
    text
}

fn write_document(index: &DatasetIndex, text: &mut String) -> std::fmt::Result {
    write_contents(index, text)?;
    write_origin(index, text)
}

/// Scenes, view counts, files and conventions.
fn write_contents(index: &DatasetIndex, text: &mut String) -> std::fmt::Result {
    let (scenes, shapes) = (&index.scenes, &index.shapes);
    writeln!(text, "# A dataset of raw holoscopic images\n")?;
    writeln!(
        text,
        "{} scenes, each seen through {} arrays of micro-lenses: raw images as a holoscopic (integral, plenoptic 1.0) camera\n\
         would take them, the same light fields as grids of views and as 5D arrays, and exact depth and disparity. Everything is\n\
         synthetic; the ground truth comes from the geometry itself.\n",
        scenes.len(),
        shapes.len()
    )?;
    writeln!(text, "## Scenes\n\n| folder | what it is there for |\n|---|---|")?;
    scenes.iter().try_for_each(|scene| writeln!(text, "| `{}` | {} |", cell(&scene.name), cell(&scene.purpose)))?;
    writeln!(text, "\n## View counts\n\nEvery scene has a folder for each, named by its views, columns x rows.\n")?;
    writeln!(text, "| folder | views | lenses (pixels of a view) | raw image, px |\n|---|---|---|---|")?;
    for shape in shapes {
        let (views, lenses, raw) =
            (shape.views().to_string(), shape.lenses().to_string(), shape.raw_size().to_string());
        writeln!(text, "| `{views}` | {views} | {lenses} | {raw} |")?;
    }
    let outputs = index.options.get("write").map(|outputs| outputs.split(',').any(|one| ["el", "vpi"].contains(&one)));
    if let Some(first) = shapes.first().filter(|_| outputs.unwrap_or(true)) {
        let views = first.views();
        writeln!(text, "\n![Contact sheet of all scenes with {views} views](contact_sheet_{views}.png)\n")?;
        writeln!(
            text,
            "The scenes in the order of the table, with {views} views: the central view, and a part of the raw image at its real\n\
             size. `contact_sheet_<S>x<T>.png` has the same for every number of views."
        )?;
    }
    writeln!(text, "\n## Lists\n\n| file | what |\n|---|---|")?;
    for (file, what) in LISTS {
        writeln!(text, "| `{file}` | {what} |")?;
    }
    writeln!(text, "\n## Files\n\n| file | what |\n|---|---|")?;
    for (file, what) in FILES {
        writeln!(text, "| `{file}` | {what} |")?;
    }
    writeln!(text, "\n## Conventions\n")?;
    index.conventions.iter().try_for_each(|(topic, what)| writeln!(text, "- **{topic}**: {what}"))
}

/// Settings as arguments of a command line. Flags with the value `false` are omitted.
fn arguments(options: &Options) -> impl Iterator<Item = String> {
    options.iter().filter(|(_, value)| *value != "false").map(|(name, value)| match value.as_str() {
        "true" => format!("--{name}"),
        value => format!("--{name}={}", holo_core::visible(value)),
    })
}

/// The command that makes the dataset, and how to cite it.
fn write_origin(index: &DatasetIndex, text: &mut String) -> std::fmt::Result {
    let (scenes, shapes) = (&index.scenes, &index.shapes);
    writeln!(text, "\n## How it was made\n")?;
    let versions: Vec<String> = index.versions.iter().map(|(what, version)| format!("{what} {version}")).collect();
    writeln!(
        text,
        "With `holo dataset`: {}. The same command makes the same bytes, on any number of machines:\n",
        versions.join(", ")
    )?;
    writeln!(text, "```\nholo dataset --out DIR \\")?;
    let (built_in, own): (Vec<_>, Vec<_>) = scenes.iter().partition(|scene| gallery::purpose(&scene.name).is_some());
    let names = |scenes: Vec<&SceneEntry>| join(scenes.into_iter().map(|scene| scene.name.clone()));
    let own: Vec<String> = own.iter().map(|scene| format!("{}.glb", holo_core::visible(&scene.name))).collect();
    writeln!(text, "    --scenes {} \\", if built_in.is_empty() { "none".into() } else { names(built_in) })?;
    if !own.is_empty() {
        writeln!(text, "    --glb {} \\", own.join(","))?;
    }
    write!(text, "    --views {}", join(shapes.iter().map(|shape| shape.views().to_string())))?;
    // Defaults are left out: `holo dataset` does not take all settings.
    let default = texts(&RenderSettings::default());
    let given = index.options.iter().filter(|(key, value)| default.get(*key) != Some(value));
    let given: Options = given.map(|(key, value)| (key.clone(), value.clone())).collect();
    for argument in arguments(&given).filter(|argument| !argument.ends_with('=')) {
        write!(text, " \\\n    {argument}")?;
    }
    writeln!(
        text,
        "\n```\n\nThe files of --glb are scenes that are not of the gallery. `holo verify DIR` checks the result."
    )?;
    writeln!(text, "\n## Licence and citation\n")?;
    writeln!(
        text,
        "The images and maps are in the public domain: CC0 1.0, https://creativecommons.org/publicdomain/zero/1.0/. If they help\n\
         your work, please cite the program and its version:\n\n\
         ```\n@software{{holo,\n  title = {{holo: raw holoscopic images with exact ground truth}},\n  version = {{{}}},\n}}\n```\n\n\
         Folders, file names and splits are those of section IV and Table I of the paper whose method the program follows;\n\
         its README names the equations.",
        index.versions.get("holo").map_or("", String::as_str)
    )
}

/// Files of the root, as `DATASET.md` lists them. All but `dataset.json` are written when the jobs are done.
const LISTS: [(&str, &str); 4] = [
    (catalog::CROISSANT_JSON, "MLCommons Croissant: every file with its SHA-256, a record for each light field"),
    (
        catalog::LIGHT_FIELDS_CSV,
        "the same records as a table: rig, disparities, depths, mean and deviation of color, error",
    ),
    (
        "train.txt, test.txt",
        "the folders for training and for tests; a scene is in one of both with all its view counts",
    ),
    (names::DATASET_JSON, "scenes, view counts, options and conventions, for programs"),
];

/// Files of a folder, as `DATASET.md` lists them.
const FILES: [(&str, &str); 10] = [
    (names::ELEMENTAL_PNG, "the raw image behind the lenses"),
    (names::VIEWPOINT_PNG, "all views side by side"),
    (names::LIGHT_FIELD_MAT, "the light field as a 5D array for MATLAB"),
    (names::LIGHT_FIELD_HDF5, "the same in linear light, if it was requested"),
    (names::DISPARITY_PFM, "disparity of the central view, px between adjacent views"),
    (names::DISPARITY_PNG, "the same as an image, brighter is nearer"),
    (names::DEPTH_PFM, "depth of the central view, m"),
    ("scene_visibility.pfm", "part of all views that see the point of a pixel, if it was requested; 1: no occlusion"),
    (names::PARAMETERS_CFG, "the cameras, with the keys of the HCI benchmark"),
    (names::MANIFEST_JSON, "settings, versions, exposure, and the SHA-256 of every file"),
];

/// Text of a file in a cell of a table of Markdown, between backticks or not.
fn cell(text: &str) -> String {
    holo_io::shown(text).replace('|', "\\|").replace('`', "'")
}

fn join(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(",")
}
