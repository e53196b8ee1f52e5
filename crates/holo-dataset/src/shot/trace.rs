//! From a prepared shot to an image in memory.

use std::ops::Range;

use holo_core::{GridSize, LightFieldShape, Rig};
use holo_io::{CameraPose, Manifest, ParametersCfg};
use holo_render::{
    Camera as Optics, Denoise, GroundTruth, Integrator, Layer, Progress, Rendered, Request, Reuse, Transport, Views,
};
use ndarray::{Array2, Axis};

use super::prepare::{Prepared, Setup, Stage};
use super::warning::RenderWarning;
use super::{identity, motion, sky, warning};
use crate::Error;
use crate::output::raw::lit_white_image;
use crate::output::{HIGHRES_SCALE, Traced, TracedCamera, TracedViews};
use crate::resume::checkpoint::Keeper;
use crate::settings::{Camera, LightSettings, Output, Shard};
use crate::watch::{About, CancelOnly, Diagnostics};

/// Returns the settings of light transport for the renderer.
pub(crate) fn transport(light: &LightSettings, integrator: Integrator) -> Transport {
    let samples = if integrator == Integrator::Depth { 1.into() } else { light.samples_per_pixel() };
    let mut transport = Transport::default();
    (transport.integrator, transport.samples, transport.seed) = (integrator, samples, light.seed);
    transport.sky = sky::constant(&light.sky);
    transport.backdrop = light.backdrop.map(|color| color.0);
    (transport.max_bounces, transport.roulette) = (light.max_bounces, light.roulette);
    transport.target_error = light.target_error;
    transport.indirect = light.indirect;
    transport.indirect_limit = light.indirect_limit.map_or(f32::INFINITY, |limit| limit as f32);
    transport.transparent_shadows = light.transparent_shadows;
    transport.spectral = light.spectral;
    transport.multiple_scattering = light.multiple_scattering;
    (transport.cull, transport.reuse, transport.texture_filter) = (light.cull, light.reuse, light.texture_filter);
    transport
}

/// Returns the request for the complete image of a prepared camera, or for a shard.
pub(super) fn request(setup: &Setup, prepared: &Prepared, shard: Option<Shard>) -> Result<Request, Error> {
    let Setup { settings, wanted, .. } = setup;
    let mut request = Request::new(prepared.camera.clone())
        .transport(transport(&settings.light, wanted.integrator))
        .denoise(settings.light.denoise)
        .estimate_error(wanted.error)
        .layers(match settings.output.ground_truth {
            GroundTruth::Central => wanted.central,
            GroundTruth::All => wanted.all,
        })
        .ground_truth(settings.output.ground_truth)
        .statistics(wanted.raw.iter().any(|layer| layer.needs_samples()));
    if let Camera::Rig(rig) = &settings.camera {
        request.filter_width_px = f64::from(rig.lens_shifts.unwrap_or(1));
        if let (Some(subset), Some(own)) = (&rig.subset, prepared.rig()) {
            request.views = Views::List(subset.views(own.shape().views()));
            // Groups of views would share light with those that are missing.
            request.transport.reuse = Reuse::Off;
        }
    }
    if let Some(shard) = shard {
        request.rows = Some(prepared.renderer.shard_rows(&request, shard.part - 1, shard.of)?);
    }
    Ok(request)
}

/// Renders the complete image or a shard, with everything that is written of it.
pub(super) fn trace(
    setup: &Setup,
    (stage, prepared, pose): (&Stage, &Prepared, usize),
    (request, identity): (&Request, Manifest),
    keeper: Option<&Keeper>,
    progress: &dyn Progress,
    diagnostics: &dyn Diagnostics,
) -> Result<(Traced, Vec<RenderWarning>), Error> {
    let Setup { settings, wanted, .. } = setup;
    let camera = before(setup, diagnostics)?;
    let renderer = &prepared.renderer;
    // A part may see nothing where the whole image does.
    let warnings = match settings.camera {
        Camera::Rig(_) if request.rows.is_none() => prepared.warnings()?,
        _ => Vec::new(),
    };
    warnings.iter().for_each(|warning| diagnostics.report(About::Scene, &format!("warning: {warning}")));
    let mut rendered = match keeper {
        Some(keeper) => renderer.render_with_checkpoint(request, progress, keeper)?,
        None => renderer.render(request, progress)?,
    };
    if let Some(rig) = prepared.rig() {
        // The layers of all views may be fewer than those of the central view.
        let missing = wanted.central.without(rendered.central.set());
        if !missing.is_empty() {
            let mut more = Request::new(*rig).integrator(Integrator::Depth).layers(missing).rows(request.rows.clone());
            more.transport.cull = request.transport.cull;
            rendered.central.extend(renderer.render(&more, &())?.central);
        }
    }
    // Before files are written.
    wanted.outputs(rendered.color.is_some())?;
    if rendered.integrator == Integrator::Depth && request.transport.integrator == Integrator::Auto {
        let note = "note: the scene has no light sources, so there is no color, only ground truth; try `sky auto`";
        diagnostics.report(About::Scene, note);
    }
    let manifest = identity::describe(identity, (settings, wanted), (stage, prepared), &rendered, request);
    let camera = match (camera, prepared.rig()) {
        (Some(raw), _) => raw,
        (None, Some(rig)) => {
            TracedCamera::Rig(Box::new(views(setup, (stage, prepared, pose), rig, request, progress)?))
        }
        (None, None) => return Err(Error::Failed("the camera has neither a rig nor a camera file".into())),
    };
    Ok((Traced { rendered, wanted: (*wanted).clone(), manifest, camera }, warnings))
}

/// What is known of a plenoptic camera before it renders, with warnings about it.
fn before(setup: &Setup, diagnostics: &dyn Diagnostics) -> Result<Option<TracedCamera>, Error> {
    let Camera::Plenoptic(file) = &setup.settings.camera else { return Ok(None) };
    let lines = warning::camera_warnings(file);
    lines.iter().for_each(|line| diagnostics.report(About::Setup, &format!("warning: {line}")));
    let [width, height] = file.camera.angles_of_view_rad().map(f64::to_degrees);
    let note = format!(
        "note: the angle of view of the scene's camera is not used; this one sees {width:.1} x {height:.1} degrees"
    );
    diagnostics.report(About::Setup, &note);
    Ok(Some(TracedCamera::Plenoptic { file: file.clone(), white: lit_white_image(file)? }))
}

/// What only a rig has.
fn views(
    setup: &Setup,
    (stage, prepared, pose): (&Stage, &Prepared, usize),
    rig: &Rig,
    request: &Request,
    progress: &dyn Progress,
) -> Result<TracedViews, Error> {
    let Setup { settings, wanted, .. } = setup;
    let is_highres = settings.output.write.contains(&Output::HciHighres);
    let highres_depth_m = is_highres.then(|| highres_depth_m(prepared, rig)).transpose()?;
    let needs_visibility = wanted.visibility || wanted.masks;
    let visibility =
        if needs_visibility { Some(prepared.renderer.visibility(request, &CancelOnly(progress))?) } else { None };
    let motion = if wanted.flow.contains(&true) {
        motion::trace(setup, (stage, prepared, pose), &CancelOnly(progress))?
    } else {
        Vec::new()
    };
    Ok(TracedViews { rig: *rig, parameters: parameters(setup, prepared, rig), highres_depth_m, visibility, motion })
}

/// The camera parameters in the file of the HCI benchmark.
fn parameters(setup: &Setup, prepared: &Prepared, rig: &Rig) -> ParametersCfg {
    let mut parameters = ParametersCfg::from_rig(rig);
    let [right, up, back] = prepared.pose.columns;
    parameters.center_cam = Some(CameraPose::from_gltf(prepared.pose.translation, right, up, back));
    // A line of the file.
    parameters.scene = holo_core::visible(&setup.source.name()).into_owned();
    parameters.cycles_seed = i64::try_from(setup.settings.light.seed).ok();
    // Reproducible builds set this variable; without it files contain no date.
    if let Some(seconds) = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse::<i64>().ok()) {
        parameters.date = holo_io::date_from_epoch(seconds);
    }
    parameters
}

/// Depth of the central view in [`HIGHRES_SCALE`] times the resolution, one ray a value.
fn highres_depth_m(prepared: &Prepared, rig: &Rig) -> Result<Array2<f32>, Error> {
    let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
    let finer = |count: usize| count.saturating_mul(HIGHRES_SCALE);
    let shape = LightFieldShape::new(views, GridSize::new(finer(lenses.rows), finer(lenses.columns)))?;
    let rig = rig.to_builder().shape(shape).build()?;
    let mut central = prepared.renderer.central_layers(&rig, [Layer::Depth].into())?;
    central
        .take(Layer::Depth)
        .map(|depth_m| depth_m.index_axis_move(Axis(2), 0))
        .ok_or_else(|| Error::Failed("the renderer returned no depth of the central view".into()))
}

/// Returns the request that automatic exposure is chosen by: of the central view of a rig, or of a whole raw image.
pub(super) fn exposure_request(request: Request) -> Request {
    let request = request.denoise(Denoise::Off).estimate_error(false).layers(holo_render::LayerSet::EMPTY);
    let request = request.ground_truth(GroundTruth::Central).statistics(false);
    match &request.camera {
        Optics::Rig(rig) => {
            let (row, column) = rig.shape().central_view();
            request.views(Views::List(vec![holo_core::ViewIndex::new(row, column)]))
        }
        _ => request,
    }
}

/// Returns the rows that were rendered.
pub(super) fn rows(request: &Request, rendered: &Rendered) -> Range<usize> {
    let count = rendered.color.as_ref().map_or(0, |color| color.shape().lenses().rows);
    request.rows.clone().unwrap_or(0..count)
}
