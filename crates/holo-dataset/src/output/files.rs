//! Writes the files of a complete render.

use holo_core::Rig;
use holo_io::{CameraFile, Manifest, ParametersCfg, dataset};
use holo_render::{Layer, Motion, Rendered, exposure};
use ndarray::{Array2, Axis};

use super::codes::Exposed;
use super::folder::OutputFolder;
use super::images::Images;
use super::statistics::Finished;
use super::statistics::Statistics;
use super::wanted::Wanted;
use super::{layers, masks, motion, raw};
use crate::Error;
use crate::settings::{Exposure, RenderSettings};

/// A render before its files are written.
pub(crate) struct Traced {
    pub rendered: Rendered,
    pub wanted: Wanted,
    /// Without exposure, disparities and files, which depend on the complete image.
    pub manifest: Manifest,
    pub camera: TracedCamera,
}

/// What only one kind of camera has.
pub(crate) enum TracedCamera {
    Rig(Box<TracedViews>),
    Plenoptic {
        file: Box<CameraFile>,
        /// The white image of the whole sensor.
        white: Array2<f32>,
    },
}

/// What only a rig has.
pub(crate) struct TracedViews {
    pub rig: Rig,
    /// Without the disparity range.
    pub parameters: ParametersCfg,
    /// Depth of the central view in high resolution, m.
    pub highres_depth_m: Option<Array2<f32>>,
    /// The part of all views that sees the points of the central view.
    pub visibility: Option<Array2<f32>>,
    /// The motion of the central view or of all views until the next frame, if it was requested.
    pub motion: Vec<Motion>,
}

/// Returns the exposure compensation of the complete image in EV, if it has color.
pub(crate) fn exposure_ev(wanted: Exposure, rendered: &Rendered) -> Option<f64> {
    rendered.color.as_ref().map(|color| match wanted {
        Exposure::Ev(ev) => ev,
        Exposure::Automatic => exposure::automatic_exposure(color),
    })
}

/// Writes all files of a complete image, and last the manifest.
pub(crate) fn write(
    settings: &RenderSettings,
    traced: Traced,
    exposed: Exposed,
    folder: OutputFolder,
) -> Result<Finished, Error> {
    let Traced { rendered, wanted, manifest, camera } = traced;
    match camera {
        TracedCamera::Rig(views) => write_views(settings, (rendered, wanted, manifest), *views, exposed, folder),
        TracedCamera::Plenoptic { file, white } => {
            raw::write_all(settings, (rendered, wanted, manifest), (&file, white), exposed, folder)
        }
    }
}

/// Writes the files of a light field.
fn write_views(
    settings: &RenderSettings,
    (mut rendered, wanted, manifest): (Rendered, Wanted, Manifest),
    views: TracedViews,
    exposed: Exposed,
    mut folder: OutputFolder,
) -> Result<Finished, Error> {
    let outputs = wanted.outputs(rendered.color.is_some())?;
    // Pixels at infinite depth have a finite disparity too.
    let disparity_px = range(rendered.central.disparity_px().into_iter().flatten());
    let mut parameters = views.parameters;
    // Those of all views, where all were rendered.
    let all = rendered.all.as_ref().filter(|all| all.set().contains(Layer::Disparity));
    let all_px = all.and_then(|all| range(all[Layer::Disparity].samples().iter()));
    if let Some((min, max)) = all_px.or(disparity_px) {
        parameters.set_disparity_range_px(min, max);
    }
    folder.unseal()?;
    layers::write(&mut folder, &wanted, &rendered, disparity_px)?;
    let mut statistics = Statistics::new(&rendered, views.visibility.as_ref());
    if let Some(visibility) = &views.visibility {
        if wanted.visibility {
            layers::write_central(&mut folder, layers::VISIBILITY, visibility.view().insert_axis(Axis(2)))?;
        }
        if wanted.masks {
            statistics.masks = masks::write(&mut folder, &rendered, visibility)?;
        }
    }
    motion::write(&mut folder, &wanted, &views.rig, &views.motion)?;
    let images = Images {
        settings: &settings.output,
        subset: settings.camera.rig().and_then(|rig| rig.subset.as_ref()),
        sensor: exposed.sensor(settings),
        outputs: &outputs,
        rig: &views.rig,
        parameters: &parameters,
        highres_depth_m: views.highres_depth_m.as_ref(),
    };
    statistics.color = images.write(&mut folder, &wanted, &mut rendered, exposed.ev)?;
    folder.add(dataset::PARAMETERS_CFG, parameters.write(folder.file(dataset::PARAMETERS_CFG))?);
    let mut manifest = Manifest { disparity_px, exposure_ev: exposed.ev, ..manifest };
    statistics.write_to(&mut manifest);
    let files = folder.seal(manifest)?;
    Ok(Finished { disparity_px, statistics, files })
}

/// The range of the finite values.
pub(crate) fn range<'a>(values: impl Iterator<Item = &'a f32>) -> Option<(f64, f64)> {
    let finite = values.filter(|value| value.is_finite()).map(|&value| f64::from(value));
    let range = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), x| (min.min(x), max.max(x)));
    (range.0 <= range.1).then_some(range)
}
