//! The two files in the root of a dataset: `dataset.json` for programs, `DATASET.md` for human readers.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use holo_core::{GridSize, LightFieldShape};
use holo_io::Folder;
use holo_io::dataset::{self as names, DatasetCamera, DatasetIndex, DatasetPoses, DatasetRecipe, SceneEntry};
use holo_scene::gallery;

use super::own::{CROISSANT_JSON, LIGHT_FIELDS_CSV, Own, TITLE};
use crate::Error;
use crate::output::TRANSFORMS;
use crate::settings::text::counted;
use crate::settings::{RenderSettings, texts};

/// SPDX identifier of the license of the images.
const LICENSE: &str = "CC0-1.0";

/// The conventions of light fields in `dataset.json` and `DATASET.md`. Their text is part of the files, so it must not change.
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

/// Those of the raw images of plenoptic cameras.
const RAW_CONVENTIONS: [(&str, &str); 5] = [
    ("raw images", "They are upright: rows run down, and nothing is turned or flipped. Vignetting is in them."),
    (
        "color",
        "raw.exr holds linear radiance; raw_linear.png holds it times 65535 times 2^EV at the exposure of manifest.json.",
    ),
    ("white images", "The light of a scene of radiance 1 in white.exr; in white.png 65535 is the brightest pixel."),
    (
        "centers.csv",
        "Column and row of a micro-image from the upper left, and its center in pixels, whose centers are whole numbers.",
    ),
    ("depth", "Meters along the optical axis; infinity where nothing is hit."),
];

/// A light field or a raw image of a dataset.
pub(crate) struct Entry {
    /// The name of its scene in the dataset.
    pub name: String,
    /// The name of the scene itself.
    pub scene: String,
    /// What the scene is there for.
    pub purpose: String,
    /// The digest of the scene.
    pub sha256: String,
    pub camera: DatasetCamera,
    /// The digest of the camera that it was rendered with, if that is another.
    pub own_camera: Option<String>,
}

/// Settings as text, by key.
type Options = BTreeMap<String, String>;

/// Writes both files for a dataset of these jobs, which have these settings and were made by this backend. Nothing
/// changes if a file that the dataset will write is there and is none of its own.
pub(crate) fn write(
    root: &Folder,
    entries: &[Entry],
    (poses, recipe): (Option<DatasetPoses>, Option<DatasetRecipe>),
    (options, backend): (&Options, &str),
) -> Result<(), Error> {
    let index = DatasetIndex { poses, recipe, ..index(entries, options, backend) };
    let own = Own::new(root);
    own.check(&index)?;
    // The catalog of other folders would be one of none.
    if !own.is(&index) {
        own.remove_catalog()?;
    }
    index.write_in(root)?;
    holo_io::write_file(root.file(names::DATASET_MD), document(&index).as_bytes())?;
    Ok(())
}

fn index(entries: &[Entry], options: &Options, backend: &str) -> DatasetIndex {
    let mut scenes: Vec<SceneEntry> = Vec::new();
    let mut cameras: Vec<DatasetCamera> = Vec::new();
    let mut names = BTreeSet::new();
    for Entry { name, scene, purpose, sha256, camera, own_camera } in entries {
        if names.insert(name) {
            let (name, purpose, sha256) = (name.clone(), purpose.clone(), sha256.clone());
            let source = (name != *scene).then(|| scene.clone());
            scenes.push(SceneEntry { name, purpose, sha256, source, cameras: BTreeMap::new() });
        }
        // The cameras of a scene follow each other.
        if let (Some(own), Some(last)) = (own_camera, scenes.last_mut()) {
            last.cameras.insert(camera.name(), own.clone());
        }
        if !cameras.contains(camera) {
            cameras.push(camera.clone());
        }
    }
    let has_rigs = cameras.iter().any(|camera| camera.shape().is_some());
    let pairs = |pairs: &[(&str, &str)]| pairs.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    DatasetIndex {
        versions: BTreeMap::from([
            ("holo".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("engine".to_owned(), backend.to_owned()),
        ]),
        options: options.clone(),
        scenes,
        conventions: if has_rigs { pairs(&CONVENTIONS) } else { pairs(&RAW_CONVENTIONS) },
        cameras,
        poses: None,
        recipe: None,
        license: LICENSE.to_owned(),
    }
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

/// The rigs of a dataset.
fn shapes(index: &DatasetIndex) -> Vec<LightFieldShape> {
    index.cameras.iter().filter_map(DatasetCamera::shape).collect()
}

/// The plenoptic cameras of a dataset: names and sizes of raw images.
fn plenoptic(index: &DatasetIndex) -> Vec<(&str, GridSize)> {
    let named = index.cameras.iter().filter_map(|camera| match camera {
        DatasetCamera::Plenoptic { name, size, .. } => Some((name.as_str(), *size)),
        DatasetCamera::Rig(_) => None,
    });
    named.collect()
}

/// Scenes, cameras, files and conventions.
fn write_contents(index: &DatasetIndex, text: &mut String) -> std::fmt::Result {
    let (scenes, shapes, cameras) = (&index.scenes, shapes(index), plenoptic(index));
    writeln!(text, "{TITLE}\n")?;
    if !shapes.is_empty() {
        writeln!(
            text,
            "Light fields of holoscopic (integral, plenoptic 1.0) cameras with exact depth and disparity: {}, each seen through {}\n\
             of microlenses. Everything is synthetic; the ground truth comes from the geometry itself.\n",
            counted(scenes.len(), "scene"),
            counted(shapes.len(), "array")
        )?;
    }
    if !cameras.is_empty() {
        writeln!(
            text,
            "{}, each seen by {}: raw images as their sensors record them through main lens and\n\
             microlenses, white images, and the centers of the micro-images. Everything is synthetic; each folder has its camera.\n",
            counted(scenes.len(), "scene"),
            counted(cameras.len(), "plenoptic camera")
        )?;
    }
    writeln!(text, "## Scenes\n\n| folder | what it is there for |\n|---|---|")?;
    scenes.iter().try_for_each(|scene| writeln!(text, "| `{}` | {} |", cell(&scene.name), cell(&scene.purpose)))?;
    if let Some(poses) = &index.poses {
        let count = poses.count;
        writeln!(
            text,
            "\nEvery scene is seen from {count} poses, and has a folder for each: `<scene>_<pose>`. The poses are in `{TRANSFORMS}`."
        )?;
    }
    if !shapes.is_empty() {
        write_views(index, &shapes, text)?;
    }
    if !cameras.is_empty() {
        write_cameras(index, &cameras, text)?;
    }
    writeln!(text, "\n## Lists\n\n| file | what |\n|---|---|")?;
    for (file, what) in LISTS {
        writeln!(text, "| `{file}` | {what} |")?;
    }
    writeln!(text, "\n## Files\n\n| file | what |\n|---|---|")?;
    let files = FILES.iter().filter(|(_, _, word)| has_file(index, word)).map(|(file, what, _)| (*file, *what));
    let files: Vec<_> = if shapes.is_empty() { RAW_FILES.to_vec() } else { files.collect() };
    for (file, what) in files {
        writeln!(text, "| `{file}` | {what} |")?;
    }
    writeln!(text, "\n## Conventions\n")?;
    index.conventions.iter().try_for_each(|(topic, what)| writeln!(text, "- **{topic}**: {what}"))
}

/// Whether folders have one of these outputs, by the settings.
fn has_output(index: &DatasetIndex, outputs: &[&str]) -> bool {
    index.options.get("write").is_none_or(|written| written.split(',').any(|one| outputs.contains(&one)))
}

/// Whether folders have the files of a word of `write` or `layers`, by the settings.
fn has_file(index: &DatasetIndex, word: &str) -> bool {
    let has = |key: &str| index.options.get(key).is_some_and(|given| given.split(',').any(|one| one == word));
    let is_default = match word {
        "" => true,
        "el" | "vpi" | "mat" => !index.options.contains_key("write"),
        "disparity" | "depth" => !index.options.contains_key("write") && !index.options.contains_key("layers"),
        _ => false,
    };
    is_default || has("write") || has("layers")
}

fn write_views(index: &DatasetIndex, shapes: &[LightFieldShape], text: &mut String) -> std::fmt::Result {
    writeln!(text, "\n## View counts\n\nEvery scene has a folder for each, named by its views, columns x rows.\n")?;
    writeln!(text, "| folder | views | lenses (pixels of a view) | raw image, px |\n|---|---|---|---|")?;
    for shape in shapes {
        let (views, lenses, raw) =
            (shape.views().to_string(), shape.lenses().to_string(), shape.raw_size().to_string());
        writeln!(text, "| `{views}` | {views} | {lenses} | {raw} |")?;
    }
    if let Some(first) = shapes.first().filter(|_| has_output(index, &["el", "vpi"])) {
        let views = first.views();
        writeln!(text, "\n![Contact sheet of all scenes with {views} views](contact_sheet_{views}.png)\n")?;
        writeln!(
            text,
            "The scenes in the order of the table, with {views} views: the central view, and a part of the raw image at its real\n\
             size. `contact_sheet_<S>x<T>.png` has the same for every number of views."
        )?;
    }
    Ok(())
}

fn write_cameras(index: &DatasetIndex, cameras: &[(&str, GridSize)], text: &mut String) -> std::fmt::Result {
    writeln!(text, "\n## Cameras\n\nEvery scene has a folder for each, with its name.\n")?;
    writeln!(text, "| folder | raw image, px |\n|---|---|")?;
    cameras.iter().try_for_each(|(name, size)| writeln!(text, "| `{}` | {size} |", cell(name)))?;
    if let Some((name, _)) = cameras.first().filter(|_| has_output(index, &["raw-png"])) {
        let name = holo_core::visible(name);
        writeln!(text, "\n![Contact sheet of all scenes with {name}](<contact_sheet_{name}.png>)\n")?;
        writeln!(
            text,
            "The scenes in the order of the table, with the camera {name}: the raw image, and a part of it at its real size.\n\
             `contact_sheet_<camera>.png` has the same for every camera."
        )?;
    }
    Ok(())
}

/// Settings as arguments of a command line. Flags with the value `false` are omitted.
fn arguments(options: &Options) -> impl Iterator<Item = String> {
    options.iter().filter(|(_, value)| *value != "false").map(|(name, value)| match value.as_str() {
        "true" => format!("--{name}"),
        value => format!("--{name}={}", holo_core::visible(value)),
    })
}

/// The command that makes such a set.
fn command(index: &DatasetIndex) -> &'static str {
    if index.recipe.is_some() { "generate" } else { "dataset" }
}

/// The scenes, as options.
fn write_sources(index: &DatasetIndex, text: &mut String) -> std::fmt::Result {
    let mut sources: Vec<&str> = Vec::new();
    for scene in index.scenes.iter().map(SceneEntry::source) {
        // Poses and frames of a scene follow each other.
        if sources.last() != Some(&scene) {
            sources.push(scene);
        }
    }
    let (built_in, own): (Vec<&str>, Vec<&str>) =
        sources.into_iter().partition(|scene| gallery::purpose(scene).is_some());
    let own: Vec<String> = own.iter().map(|scene| format!("{}.glb", holo_core::visible(scene))).collect();
    writeln!(text, "    --scenes {} \\", if built_in.is_empty() { "none".into() } else { built_in.join(",") })?;
    if !own.is_empty() {
        writeln!(text, "    --glb {} \\", own.join(","))?;
    }
    Ok(())
}

/// The command that makes the dataset.
fn write_command(index: &DatasetIndex, text: &mut String) -> std::fmt::Result {
    writeln!(text, "```\nholo {} --out DIR \\", command(index))?;
    match &index.recipe {
        Some(recipe) => {
            writeln!(text, "    --recipe recipe.toml --count {} --seed {} \\", recipe.count, recipe.seed)?;
        }
        None => write_sources(index, text)?,
    }
    let (shapes, cameras) = (shapes(index), plenoptic(index));
    let first = index.scenes.first().map_or("", |scene| scene.name.as_str());
    match shapes.is_empty() {
        // Each folder has its camera.
        true => {
            let files = cameras.iter().map(|(name, _)| format!("{first}/{name}/{}", names::CAMERA_TOML));
            write!(text, "    --camera-file {}", quoted(holo_core::visible(&join(files)).into_owned()))?;
        }
        false => write!(text, "    --views {}", join(shapes.iter().map(|shape| shape.views().to_string())))?,
    }
    if let Some(poses) = &index.poses {
        write!(text, " \\\n    --transforms {TRANSFORMS} --transforms-up {}", poses.up)?;
    }
    // Defaults are left out: `holo dataset` does not take all settings.
    let default = texts(&RenderSettings::default());
    let given = index.options.iter().filter(|(key, value)| default.get(*key) != Some(value));
    let given: Options = given.map(|(key, value)| (key.clone(), value.clone())).collect();
    for argument in arguments(&given).filter(|argument| !argument.ends_with('=')) {
        write!(text, " \\\n    {argument}")?;
    }
    writeln!(text)
}

/// The command that makes the dataset, and how to cite it.
fn write_origin(index: &DatasetIndex, text: &mut String) -> std::fmt::Result {
    writeln!(text, "\n## How it was made\n")?;
    let versions: Vec<String> = index.versions.iter().map(|(what, version)| format!("{what} {version}")).collect();
    writeln!(
        text,
        "With `holo {}`: {}. The same command makes the same bytes, on any number of machines:\n",
        command(index),
        versions.join(", ")
    )?;
    write_command(index, text)?;
    let is_shared = |key: &str| index.options.get(key).is_some_and(|value| value == "views");
    let shared = if is_shared("denoise") {
        "\n\nViews share samples along the true disparity (--denoise views), and what is left of the noise moves with it: do not\n\
         score or train methods that match views on these images."
    } else if is_shared("reuse") {
        "\n\nGroups of 16 views share light (--reuse views), and their noise does not move with disparity: do not score or\n\
         train methods that match views on these images."
    } else {
        ""
    };
    writeln!(
        text,
        "```{shared}\n\n{}`holo verify DIR` checks the result.",
        if index.recipe.is_some() { "" } else { "The files of --glb are scenes that are not of the gallery. " }
    )?;
    if shapes(index).is_empty() || index.poses.is_some() || index.recipe.is_some() {
        writeln!(text, "The other files of the command are in this folder.")?;
    }
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
    (CROISSANT_JSON, "MLCommons Croissant: every file with its SHA-256, a record for each light field"),
    (LIGHT_FIELDS_CSV, "the same records as a table: cameras, disparities, depths, mean and deviation of color, error"),
    (
        "train.txt, test.txt",
        "the folders for training and for tests; a scene is in one of both with all its cameras, poses and frames",
    ),
    (names::DATASET_JSON, "scenes, cameras, options and conventions, for programs"),
];

/// Files of a folder of a rig, as `DATASET.md` lists them, and the words of `write` or `layers` that make them; none: always
/// there.
const FILES: [(&str, &str, &str); 13] = [
    (names::ELEMENTAL_PNG, "the raw image behind the lenses", "el"),
    (names::VIEWPOINT_PNG, "all views side by side", "vpi"),
    (names::LIGHT_FIELD_MAT, "the light field as a 5D array for MATLAB", "mat"),
    (names::LIGHT_FIELD_HDF5, "the same in linear light", "h5"),
    ("hci/", "a PNG a view with depth and disparity, in the layout of the HCI benchmark", "hci"),
    ("masks/", "masks of the central view: pixels that are hard for stereo", "masks"),
    (names::DISPARITY_PFM, "disparity of the central view, px between adjacent views", "disparity"),
    (names::DISPARITY_PNG, "the same as an image, brighter is nearer", "disparity"),
    (names::DEPTH_PFM, "depth of the central view, m", "depth"),
    (names::HIT_MASK_PNG, "255 where the central view sees the scene, 0 where depth is infinite", ""),
    ("scene_visibility.pfm", "part of all views that see the point of a pixel; 1: no occlusion", "visibility"),
    (names::PARAMETERS_CFG, "the cameras, with the keys of the HCI benchmark", ""),
    (names::MANIFEST_JSON, "settings, versions, exposure, and the SHA-256 of every file", ""),
];

/// The same of a plenoptic camera.
const RAW_FILES: [(&str, &str); 8] = [
    (names::RAW_EXR, "the raw image in linear light"),
    (names::RAW_PNG, "the same with 16 bits, linear"),
    ("white.exr, white.png", "the white image: light of an evenly bright scene"),
    ("centers.csv", "the centers of the micro-images"),
    ("raw_depth.pfm", "depth that a pixel sees through the middle of the lens, m, if it was requested"),
    ("raw_hit_mask.png", "255 where the ray of raw_depth.pfm hits the scene, 0 where depth is infinite"),
    (names::CAMERA_TOML, "the camera, as a file of --camera-file"),
    (names::MANIFEST_JSON, "settings, versions, exposure, and the SHA-256 of every file"),
];

/// A word of a command line, quoted if it has blanks.
fn quoted(word: String) -> String {
    if word.contains(char::is_whitespace) { format!("\"{word}\"") } else { word }
}

/// Text of a file in a cell of a table of Markdown, between backticks or not.
fn cell(text: &str) -> String {
    holo_io::shown(text).replace('|', "\\|").replace('`', "'")
}

fn join(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(",")
}
