//! Validation of a specification, and writing the files of a complete render.

use holo_core::Rig;
use holo_io::{Manifest, ParametersCfg, dataset};
use holo_render::{Integrator, Layers, Motion, Rendered, exposure};
use ndarray::{Array2, Array3};

use crate::Error;
use crate::images::{self, Images};
use crate::layers::{self, Wanted};
use crate::output_folder::OutputFolder;
use crate::spec::{Exposure, LayerChoice, Output, RenderSpec};
use crate::statistics::Statistics;
use crate::warning::RenderWarning;
use crate::{motion, subset};

/// A render before its files are written.
pub(crate) struct Traced {
    pub rendered: Rendered,
    pub wanted: Wanted,
    pub rig: Rig,
    /// Without exposure, disparities and files, which depend on the complete image.
    pub manifest: Manifest,
    /// Without the disparity range.
    pub parameters: ParametersCfg,
    /// Depth of the central view in high resolution, m.
    pub highres_depth_m: Option<Array2<f32>>,
    /// The part of all views that sees the points of the central view.
    pub visibility: Option<Array2<f32>>,
    /// The motion of the central view or of all views until the next frame, if it was requested.
    pub motion: Vec<Motion>,
    /// Of a shard none.
    pub warnings: Vec<RenderWarning>,
}

/// The result of writing the files.
pub(crate) struct Finished {
    pub disparity_px: Option<(f64, f64)>,
    pub statistics: Statistics,
    pub files: Vec<String>,
}

/// Checks whether a specification is possible for any scene, before anything is loaded or written.
///
/// # Errors
/// [`Error::BadRequest`] if outputs or layers need color and the integrator computes none, or if they need HDF5 and the
/// feature `hdf5` is off.
pub fn validate(spec: &RenderSpec) -> Result<(), Error> {
    #[cfg(not(feature = "hdf5"))]
    if spec.outputs.contains(&Output::H5) {
        return Err(images::without_hdf5());
    }
    subset::validate(spec)?;
    if let Some(output) = spec.outputs.iter().find(|output| Output::RAW.contains(output)) {
        let name = output.name();
        return Err(Error::BadRequest(format!("--write {name} is of a plenoptic camera; give one with --camera-file")));
    }
    if let Some(LayerChoice::Raw(layer)) = spec.layers.iter().find(|layer| matches!(layer, LayerChoice::Raw(_))) {
        let name = layer.name();
        return Err(Error::BadRequest(format!(
            "--layers {name} is of a plenoptic camera; give one with --camera-file"
        )));
    }
    let flow = [LayerChoice::OpticalFlow, LayerChoice::SceneFlow].into_iter().find(|flow| spec.layers.contains(flow));
    if let (Some(flow), None) = (flow, spec.scene.frames) {
        let name = flow.name();
        return Err(Error::BadRequest(format!(
            "--layers {name} is the motion from one frame to the next; give --frame"
        )));
    }
    if let (None, Some(animation)) = (spec.scene.frames, &spec.scene.animation) {
        return Err(Error::BadRequest(format!("--animation {animation} is played at a time; give --frame too")));
    }
    if let (None, Some(fps)) = (spec.scene.frames, spec.scene.fps) {
        return Err(Error::BadRequest(format!("--fps {fps} is of an animation; give --frame too")));
    }
    if let Some(names) =
        images::needing_color(&spec.outputs, spec.integrator).filter(|_| spec.integrator == Integrator::Depth)
    {
        return Err(Error::BadRequest(format!(
            "--integrator depth renders no color; remove {names} from --write, or choose --integrator direct"
        )));
    }
    if let Some(name) = layers::needing_color(spec).filter(|_| spec.integrator == Integrator::Depth) {
        return Err(Error::BadRequest(format!(
            "--integrator depth renders no color; remove {name} from --layers, or choose --integrator direct"
        )));
    }
    Ok(())
}

/// The exposure compensation of the complete image in EV, if it has color.
pub(crate) fn exposure_ev(spec: &RenderSpec, rendered: &Rendered) -> Option<f64> {
    rendered.color.as_ref().map(|color| match spec.exposure {
        Exposure::Ev(ev) => ev,
        Exposure::Automatic => exposure::automatic_exposure(color),
    })
}

/// Writes all files and last the manifest.
pub(crate) fn write(
    spec: &RenderSpec,
    mut traced: Traced,
    exposure_ev: Option<f64>,
    mut folder: OutputFolder,
) -> Result<Finished, Error> {
    let rendered = &mut traced.rendered;
    let outputs = outputs(spec, rendered.color.is_some())?;
    let disparity_px = finite_range(&rendered.central);
    let mut parameters = traced.parameters;
    if let Some((min, max)) = disparity_px {
        parameters.set_disparity_range_px(min, max);
    }
    folder.unseal()?;
    layers::write(&mut folder, &traced.wanted, rendered, disparity_px)?;
    if let Some(visibility) = &traced.visibility {
        layers::write_visibility(&mut folder, visibility)?;
    }
    motion::write(&mut folder, &traced.wanted, &traced.rig, &traced.motion)?;
    let mut statistics = Statistics::new(rendered, traced.visibility.as_ref());
    let images = Images {
        spec,
        outputs: &outputs,
        rig: &traced.rig,
        parameters: &parameters,
        highres_depth_m: traced.highres_depth_m.as_ref(),
    };
    statistics.color = images.write(&mut folder, &traced.wanted, rendered, exposure_ev)?;
    folder.add(dataset::PARAMETERS_CFG, parameters.write(folder.file(dataset::PARAMETERS_CFG))?);
    let mut manifest = Manifest { disparity_px, exposure_ev, ..traced.manifest };
    statistics.write_to(&mut manifest);
    let files = folder.seal(manifest)?;
    Ok(Finished { disparity_px, statistics, files })
}

/// The outputs to write: the requested ones, or without a request the default ones if there is color.
pub(crate) fn outputs(spec: &RenderSpec, has_color: bool) -> Result<Vec<Output>, Error> {
    if let Some(name) = layers::needing_color(spec).filter(|_| !has_color) {
        return Err(Error::BadRequest(format!(
            "the scene has no light sources, so there is no color to write; remove {name} from --layers, or light it \
             with --sky auto"
        )));
    }
    if spec.outputs.is_empty() {
        return Ok(if has_color { images::DEFAULT_OUTPUTS.to_vec() } else { Vec::new() });
    }
    if let Some(names) = images::needing_color(&spec.outputs, spec.integrator).filter(|_| !has_color) {
        return Err(Error::BadRequest(format!(
            "the scene has no light sources, so there is no color to write; remove {names} from --write, or light it \
             with --sky auto"
        )));
    }
    Ok(spec.outputs.clone())
}

/// The range of the finite disparities of the central view, in pixels. Pixels at infinite depth have a finite disparity
/// too.
fn finite_range(central: &Layers<Array3<f32>>) -> Option<(f64, f64)> {
    let disparities = central.disparity_px().into_iter().flatten();
    let finite = disparities.filter(|d| d.is_finite()).map(|&d| f64::from(d));
    let range = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), d| (min.min(d), max.max(d)));
    (range.0 <= range.1).then_some(range)
}
