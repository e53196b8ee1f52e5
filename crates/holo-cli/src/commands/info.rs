//! `holo info`: what a file holds, in a few lines.

use std::path::Path;

use holo_core::Layout;
use holo_dataset::SceneSource;
use holo_io::dataset::{MANIFEST_JSON, PARAMETERS_CFG};
use holo_io::{FileFormat, FileInfo, Limits, Manifest, ParametersCfg, Pfm};
use holo_render::Layer;

use super::diagnostics::Plain;
use crate::arguments::InfoOptions;
use crate::console::out;
use crate::failure::Failure;
use crate::report::{describe_rig, describe_split};

pub fn run(options: &InfoOptions) -> Result<(), Failure> {
    let path = &options.file;
    if path.is_dir() {
        return folder(path);
    }
    match holo_io::detect_format(path)? {
        FileFormat::GltfBinary | FileFormat::GltfJson => scene(options),
        FileFormat::Png => png(path),
        FileFormat::Pfm => pfm(path),
        FileFormat::ParametersCfg => parameters(path),
        FileFormat::Manifest => manifest(path),
        FileFormat::Exr => exr(path),
        FileFormat::Hdr => hdr(path),
        FileFormat::Mat5 | FileFormat::Mat73 => mat(path),
        _ => Err(Failure::Failed(format!(
            "{}: not a file that holo knows (.glb, .gltf, .png, .pfm, .exr, .hdr, .mat, parameters.cfg, manifest.json)",
            path.display()
        ))),
    }
}

/// What kind of folder, and the rig of a light field in it.
fn folder(path: &Path) -> Result<(), Failure> {
    let opened = holo_io::probe(path)?;
    if matches!(opened, FileInfo::UnknownFolder { .. }) {
        let at = path.display();
        return Err(Failure::Failed(format!(
            "{at} is a folder without a {MANIFEST_JSON} or a light field; name a file in it"
        )));
    }
    out!("{opened}")?;
    match opened {
        FileInfo::DatasetFolder(_) => manifest(&path.join(MANIFEST_JSON)),
        FileInfo::HciFolder(_) => parameters(&path.join(PARAMETERS_CFG)),
        FileInfo::Datasets(entries) => {
            for entry in entries {
                out!("{}", entry.path.display())?;
            }
            Ok(())
        }
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

/// The scene, and the rig that a render with the same options would get.
fn scene(options: &InfoOptions) -> Result<(), Failure> {
    let source = SceneSource::File(options.file.clone());
    let prepared = source.prepare(&options.rig.spec(), &options.engine.spec(), &Plain { quiet: false })?;
    out!("{}", prepared.loaded.summary.to_string().trim_end())?;
    if let Some((low, high)) = prepared.loaded.scene.bounds() {
        out!("bounds: {low:.4?} to {high:.4?} m")?;
    }
    out!("a render with these options: {}, {}", describe_split(&prepared.rig), prepared.renderer.engine_name())?;
    out!("{}", prepared.framed.camera)?;
    let truth = prepared.renderer.central_truth(&prepared.rig)?;
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
    out!("{}", describe_rig(&prepared.rig, range(Layer::Disparity)))?;
    Ok(())
}

fn png(path: &Path) -> Result<(), Failure> {
    let info = holo_io::read_png_info(path)?;
    out!(
        "PNG, {} x {} px, {} {} of {} bits",
        info.size.columns,
        info.size.rows,
        info.channels,
        plural(info.channels, "channel"),
        info.bits
    )?;
    match holo_io::layout_of_file_name(path) {
        Some(Layout::ElementalGrid) => out!("by its name: a grid of elemental images")?,
        Some(Layout::ViewpointGrid) => out!("by its name: a grid of views")?,
        None => {}
    }
    let beside = path.with_file_name(PARAMETERS_CFG);
    if beside.is_file() {
        out!("beside it:")?;
        parameters(&beside)?;
    }
    Ok(())
}

/// `word` with an s unless there is one of it.
fn plural(count: usize, word: &str) -> String {
    format!("{word}{}", if count == 1 { "" } else { "s" })
}

fn pfm(path: &Path) -> Result<(), Failure> {
    let Pfm { values: samples, .. } = holo_io::read_pfm(path, &Limits::default())?;
    let (rows, columns, channels) = samples.dim();
    out!("PFM, {columns} x {rows} px, {channels} {}", plural(channels, "channel"))?;
    let finite = samples.iter().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
    let count = |test: fn(f32) -> bool| samples.iter().filter(|&&x| test(x)).count();
    if low <= high {
        out!("finite values from {low} to {high}")?;
    }
    out!("{} infinite, {} NaN", count(f32::is_infinite), count(f32::is_nan))?;
    Ok(())
}

fn exr(path: &Path) -> Result<(), Failure> {
    let info = holo_io::read_exr_info(path)?;
    let (columns, rows) = (info.size.columns, info.size.rows);
    let count = info.channels.len();
    out!("EXR, {columns} x {rows} px, {}, {count} {}", info.compression, plural(count, "channel"))?;
    for name in &info.channels {
        out!("  {name}")?;
    }
    Ok(())
}

fn hdr(path: &Path) -> Result<(), Failure> {
    let info = holo_io::read_hdr_info(path)?;
    out!("Radiance HDR, {} x {} px", info.size.columns, info.size.rows)?;
    Ok(())
}

fn parameters(path: &Path) -> Result<(), Failure> {
    let parameters = ParametersCfg::read(path)?;
    let rig = parameters.rig()?;
    out!("camera parameters of '{}': {}", parameters.scene, describe_split(&rig))?;
    let range = parameters.disp_min.zip(parameters.disp_max);
    out!("{}", describe_rig(&rig, range))?;
    Ok(())
}

fn manifest(path: &Path) -> Result<(), Failure> {
    let manifest = Manifest::read(path)?;
    for (name, version) in &manifest.versions {
        out!("{name} {version}")?;
    }
    if let Some(rig) = &manifest.rig {
        out!("{}\n{}", describe_split(rig), describe_rig(rig, manifest.disparity_px))?;
    }
    if let Some(stops) = manifest.exposure_ev {
        out!("exposure {stops} EV")?;
    }
    for (name, file) in &manifest.files {
        out!("{:>12} bytes  {name}", file.bytes)?;
    }
    Ok(())
}
