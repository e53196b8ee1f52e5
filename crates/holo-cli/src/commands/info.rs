//! `holo info`: a file or folder in a few lines.

use std::path::Path;

use holo_core::{Layout, Rig};
use holo_dataset::{SceneSource, text};
use holo_io::dataset::{MANIFEST_JSON, PARAMETERS_CFG};
use holo_io::{FileFormat, FileInfo, Folder, LightFieldReader, Limits, Manifest, ParametersCfg, ReadOptions};
use holo_render::Layer;

use crate::arguments::InfoOptions;
use crate::console::{out, say_unless};
use crate::failure::Failure;

pub fn run(options: &InfoOptions) -> Result<(), Failure> {
    let path = &options.file;
    let info = holo_io::probe(path)?;
    match &info {
        FileInfo::Other(FileFormat::GltfBinary | FileFormat::GltfJson) => return scene(options),
        FileInfo::Unknown { .. } => {
            return Err(Failure::Failed(format!(
                "{}: not a file that holo knows (.glb, .gltf, .png, .tif, .dng, .pfm, .exr, .hdr, .mat, .h5, \
                 {PARAMETERS_CFG}, {MANIFEST_JSON}) but an {info}",
                path.display()
            )));
        }
        FileInfo::UnknownFolder { .. } => return folder_without_manifest(path),
        _ => out!("{info}")?,
    }
    match info {
        FileInfo::Png(_) => png(path),
        FileInfo::Pfm(_) => pfm(path),
        FileInfo::Exr { channels, .. } => channels.iter().try_for_each(|name| out!("  {name}")),
        FileInfo::ParametersCfg(parameters) => parameter_lines(&parameters),
        FileInfo::HciFolder(folder) => parameter_lines(folder.parameters()),
        FileInfo::Manifest(manifest) => manifest_lines(&manifest),
        FileInfo::DatasetFolder(folder) => manifest_lines(folder.manifest()),
        FileInfo::Cameras { manifest, .. } => manifest.map_or(Ok(()), |manifest| manifest_lines(&manifest)),
        FileInfo::PlenopticFolder(folder) => folder.manifest().map_or(Ok(()), manifest_lines),
        FileInfo::Sequence(sequence) => {
            sequence.frames().iter().try_for_each(|&frame| out!("{}", sequence.frame_path(frame).display()))
        }
        FileInfo::Datasets(entries) => entries.iter().try_for_each(|entry| out!("{}", entry.path.display())),
        FileInfo::Other(FileFormat::Mat5 | FileFormat::Mat73) => mat(path),
        FileInfo::Other(FileFormat::Hdf5 | FileFormat::LightPack) => light_field(path),
        _ => Ok(()),
    }
}

fn mat(path: &Path) -> Result<(), Failure> {
    for variable in holo_io::read_mat_info(path)? {
        let size = variable.size.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ");
        out!("{} {size} {}", variable.name, variable.class.name())?;
    }
    Ok(())
}

fn light_field(path: &Path) -> Result<(), Failure> {
    light_field_lines(&LightFieldReader::open(path, &ReadOptions::default())?)
}

fn light_field_lines(reader: &LightFieldReader) -> Result<(), Failure> {
    match reader.rig() {
        Some(rig) => rig_lines(rig, reader.disparity_range_px()),
        None => out!("{}", text::shape(&reader.shape())),
    }
}

/// A folder of no known kind may still hold a light field.
fn folder_without_manifest(path: &Path) -> Result<(), Failure> {
    match LightFieldReader::open(path, &ReadOptions::default()) {
        Ok(reader) => {
            if let Some(read) = reader.representation() {
                out!("folder without a {MANIFEST_JSON}, light field in {read}")?;
            }
            light_field_lines(&reader)
        }
        Err(holo_io::Error::NoLightField { .. } | holo_io::Error::MissingOption { .. }) => Err(Failure::Failed(
            format!("{} is a folder without a {MANIFEST_JSON} or a light field; name a file in it", path.display()),
        )),
        Err(error) => Err(error.into()),
    }
}

/// The scene, and the rig that a render with the same options would get.
fn scene(options: &InfoOptions) -> Result<(), Failure> {
    let source = SceneSource::File(options.file.clone());
    let (stage, prepared) = source.prepare(&options.settings()?, &options.engine.settings(), &say_unless(false))?;
    let rig = prepared.rig().ok_or_else(|| Failure::Failed("the settings are of no rig".into()))?;
    out!("{}", stage.loaded.summary.to_string().trim_end())?;
    out!("coincident faces:    {} pairs of triangles", stage.loaded.scene.coincident_triangle_pairs())?;
    if let Some((low, high)) = stage.loaded.scene.bounds() {
        out!("bounds: {low:.4?} to {high:.4?} m")?;
    }
    out!("a render with these options: {}, {}", text::shape(rig.shape()), prepared.renderer.engine_name())?;
    out!("{}", prepared.name)?;
    let truth = prepared.renderer.central_truth(rig)?;
    let range = |layer: Layer| {
        let finite = truth[layer].iter().filter(|x| x.is_finite());
        let range = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
            (low.min(f64::from(x)), high.max(f64::from(x)))
        });
        (range.0 <= range.1).then_some(range)
    };
    match range(Layer::Depth) {
        Some((near, far)) => {
            let empty = truth[Layer::Depth].iter().filter(|z| z.is_infinite()).count();
            out!(
                "depth in the central view: {near:.4} to {far:.4} m, {empty} of {} pixels see nothing",
                truth[Layer::Depth].len()
            )?;
        }
        None => out!("depth in the central view: nothing is seen")?,
    }
    out!("{}", text::rig(rig, range(Layer::Disparity)))?;
    prepared.warnings()?.iter().try_for_each(|warning| out!("warning: {}", Failure::spelled(&warning.to_string())))
}

fn png(path: &Path) -> Result<(), Failure> {
    match holo_io::layout_of_file_name(path) {
        Some(Layout::ElementalGrid) => out!("by its name: a grid of elemental images")?,
        Some(Layout::ViewpointGrid) => out!("by its name: a grid of views")?,
        None => {}
    }
    if let Ok(folder) = Folder::beside(path)
        && folder.has_file(PARAMETERS_CFG)
    {
        out!("beside it:")?;
        parameter_lines(&ParametersCfg::read_in(&folder, PARAMETERS_CFG)?)?;
    }
    Ok(())
}

/// The range of the samples, which the header does not contain.
fn pfm(path: &Path) -> Result<(), Failure> {
    let samples = holo_io::read_pfm(path, &Limits::default())?.values;
    let finite = samples.iter().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
    let count = |test: fn(f32) -> bool| samples.iter().filter(|&&x| test(x)).count();
    if low <= high {
        out!("finite values from {low} to {high}")?;
    }
    out!("{} infinite, {} NaN", count(f32::is_infinite), count(f32::is_nan))
}

fn rig_lines(rig: &Rig, disparity_px: Option<(f64, f64)>) -> Result<(), Failure> {
    out!("{}\n{}", text::shape(rig.shape()), text::rig(rig, disparity_px))
}

fn parameter_lines(parameters: &ParametersCfg) -> Result<(), Failure> {
    out!("camera parameters of '{}'", parameters.scene)?;
    rig_lines(&parameters.rig()?, parameters.disp_min.zip(parameters.disp_max))
}

fn manifest_lines(manifest: &Manifest) -> Result<(), Failure> {
    for (name, version) in &manifest.versions {
        out!("{name} {version}")?;
    }
    if let Some(rig) = &manifest.rig {
        rig_lines(rig, manifest.disparity_px)?;
    }
    if let Some(stops) = manifest.exposure_ev {
        out!("exposure {stops} EV")?;
    }
    let files: Vec<(&str, u64)> = manifest.files.iter().map(|(name, file)| (name.as_str(), file.bytes)).collect();
    runs(&files).into_iter().try_for_each(|(name, bytes)| out!("{bytes:>12} bytes  {name}"))
}

/// Files with their sizes; those that differ in a number alone are one line, if there are more than a few.
fn runs(files: &[(&str, u64)]) -> Vec<(String, u64)> {
    const FEW: usize = 4;
    let pattern = |name: &str| name.chars().map(|c| if c.is_ascii_digit() { '#' } else { c }).collect::<String>();
    let mut lines = Vec::new();
    for run in files.chunk_by(|(a, _), (b, _)| a.contains(|c: char| c.is_ascii_digit()) && pattern(a) == pattern(b)) {
        match run {
            [(first, _), .., (last, _)] if run.len() > FEW => {
                let bytes = run.iter().map(|(_, bytes)| bytes).sum();
                lines.push((format!("{first} to {last} ({} files)", run.len()), bytes));
            }
            _ => lines.extend(run.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes))),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbered_files_are_one_line() {
        let names: Vec<String> = (0..81).map(|k| format!("hci/input_Cam{k:03}.png")).collect();
        let mut files: Vec<(&str, u64)> = names.iter().map(|name| (name.as_str(), 10)).collect();
        files.extend([("scene_5d.mat", 7), ("scene_el.png", 8)]);
        let lines = runs(&files);
        assert_eq!(lines[0], ("hci/input_Cam000.png to hci/input_Cam080.png (81 files)".into(), 810));
        assert_eq!(lines[1..], [("scene_5d.mat".into(), 7), ("scene_el.png".into(), 8)]);
        assert_eq!(runs(&[("a_1.png", 1), ("a_2.png", 2)]).len(), 2);
    }
}
