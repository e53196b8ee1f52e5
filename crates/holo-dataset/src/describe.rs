//! The two files in the root: `dataset.json` for programs, `DATASET.md` for people.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use holo_core::LightFieldShape;
use holo_io::dataset::{self as names};
use holo_io::dataset::{Description, SceneEntry};
use holo_scene::gallery;

use crate::Error;
use crate::options::{Options, arguments};
use crate::source::SceneSource;

/// Where the licence can be read.
const LICENCE: &str = "CC0-1.0";

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

/// A scene and how it is divided.
type Job<'a> = (&'a SceneSource, LightFieldShape);

/// Writes both, for a dataset of these jobs.
pub(crate) fn write(root: &Path, jobs: &[Job], options: &Options, backend: &str) -> Result<(), Error> {
    let description = describe(jobs, options, backend)?;
    description.write(root)?;
    holo_io::write_file(root.join(names::DATASET_MD), document(&description).as_bytes())?;
    Ok(())
}

fn describe(jobs: &[Job], options: &Options, backend: &str) -> Result<Description, Error> {
    let mut scenes: Vec<SceneEntry> = Vec::new();
    let mut splits: Vec<LightFieldShape> = Vec::new();
    for (source, shape) in jobs {
        let name = source.name();
        if scenes.iter().all(|scene| scene.name != name) {
            let purpose = gallery::purpose(&name).unwrap_or("a scene from a file").to_owned();
            scenes.push(SceneEntry { name, purpose, sha256: source.sha256()?.to_string() });
        }
        if !splits.contains(shape) {
            splits.push(*shape);
        }
    }
    let pairs = |pairs: &[(&str, &str)]| pairs.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    Ok(Description {
        versions: BTreeMap::from([
            ("holo".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("engine".to_owned(), backend.to_owned()),
        ]),
        options: options.clone(),
        scenes,
        splits,
        conventions: pairs(&CONVENTIONS),
        licence: LICENCE.to_owned(),
    })
}

/// The page for people.
fn document(description: &Description) -> String {
    let mut text = String::new();
    // Writing into a text cannot fail.
    let _ = write_document(description, &mut text);
    text
}

fn write_document(description: &Description, text: &mut String) -> std::fmt::Result {
    let (scenes, splits) = (&description.scenes, &description.splits);
    writeln!(text, "# A dataset of raw holoscopic images\n")?;
    writeln!(
        text,
        "{} scenes, each seen through {} arrays of micro-lenses: raw images as a holoscopic (integral, plenoptic 1.0) camera\n\
         would take them, the same light fields as grids of views and as 5D arrays, and exact depth and disparity. Everything is\n\
         synthetic; the ground truth comes from the geometry itself.\n",
        scenes.len(),
        splits.len()
    )?;
    writeln!(text, "## Scenes\n\n| folder | what it is there for |\n|---|---|")?;
    scenes.iter().try_for_each(|scene| writeln!(text, "| `{}` | {} |", scene.name, scene.purpose))?;
    writeln!(text, "\n## Splits\n\nEvery scene has a folder a split, named by its views, columns x rows.\n")?;
    writeln!(text, "| folder | views | lenses (pixels of a view) | raw image, px |\n|---|---|---|---|")?;
    for shape in splits {
        let (views, lenses, raw) =
            (shape.views().to_string(), shape.lenses().to_string(), shape.raw_size().to_string());
        writeln!(text, "| `{views}` | {views} | {lenses} | {raw} |")?;
    }
    writeln!(text, "\n## Files\n\n| file | what |\n|---|---|")?;
    for (file, what) in FILES {
        writeln!(text, "| `{file}` | {what} |")?;
    }
    writeln!(text, "\n## Conventions\n")?;
    description.conventions.iter().try_for_each(|(topic, what)| writeln!(text, "- **{topic}**: {what}"))?;
    writeln!(text, "\n## How it was made\n")?;
    let versions: Vec<String> =
        description.versions.iter().map(|(what, version)| format!("{what} {version}")).collect();
    writeln!(
        text,
        "With `holo dataset`: {}. The same command makes the same bytes, on any number of machines:\n",
        versions.join(", ")
    )?;
    writeln!(text, "```\nholo dataset --out DIR \\")?;
    writeln!(text, "    --scenes {} \\", join(scenes.iter().map(|scene| scene.name.clone())))?;
    write!(text, "    --splits {}", join(splits.iter().map(|shape| shape.views().to_string())))?;
    for argument in arguments(&description.options).filter(|argument| !argument.ends_with('=')) {
        write!(text, " \\\n    {argument}")?;
    }
    writeln!(
        text,
        "\n```\n\nScenes that are not of the gallery are given by `--glb FILE`. `holo verify DIR` checks the result."
    )?;
    writeln!(text, "\n## Licence and citation\n")?;
    writeln!(
        text,
        "The images and maps are in the public domain: CC0 1.0, https://creativecommons.org/publicdomain/zero/1.0/. If they help\n\
         your work, please cite the program and its version:\n\n\
         ```\n@software{{holo,\n  title = {{holo: raw holoscopic images with exact ground truth}},\n  version = {{{}}},\n}}\n```\n\n\
         Folders, file names and splits are those of section IV and Table I of the paper whose method the program follows;\n\
         its README names the equations.",
        description.versions.get("holo").map_or("", String::as_str)
    )
}

/// What a folder may hold.
const FILES: [(&str, &str); 9] = [
    (names::ELEMENTAL_PNG, "the raw image behind the lenses"),
    (names::VIEWPOINT_PNG, "all views side by side"),
    (names::LIGHT_FIELD_MAT, "the light field as a 5D array for MATLAB"),
    (names::LIGHT_FIELD_HDF5, "the same in linear light, where it was asked for"),
    (names::DISPARITY_PFM, "disparity of the central view, px between adjacent views"),
    (names::DISPARITY_PNG, "the same as a picture, brighter is nearer"),
    (names::DEPTH_PFM, "depth of the central view, m"),
    (names::PARAMETERS_CFG, "the cameras, with the keys of the HCI benchmark"),
    (names::MANIFEST_JSON, "settings, versions, exposure, and the SHA-256 of every file"),
];

fn join(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(",")
}
