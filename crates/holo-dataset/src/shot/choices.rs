//! What is chosen automatically once for all shots of a job, so that nothing flickers: focus distance, baseline and
//! exposure are those of the first pose at the first frame. They depend on no other shot, so that every part of a job has
//! the same.

use holo_render::{Integrator, Progress};

use super::identity::at_frame;
use super::prepare::Setup;
use super::trace::{exposure_request, request};
use crate::Error;
use crate::output::{Wanted, codes, exposure_ev};
use crate::settings::{Camera, Exposure, Focus, Output, RenderSettings, Spacing};
use crate::watch::{CancelOnly, Diagnostics};

/// The choices of the first shot.
pub(super) struct Chosen {
    /// The settings of the job with its focus distance, baseline and exposure.
    pub settings: RenderSettings,
    /// The electrons of the radiance 1 on the image sensor, if there is one and the image has color. No setting says them.
    pub electrons: Option<f64>,
}

/// Returns the choices of the first shot of a job: loads the scene, and if exposure is automatic renders the central view,
/// or the raw image.
pub(super) fn choose(setup: &Setup, progress: &dyn Progress, diagnostics: &dyn Diagnostics) -> Result<Chosen, Error> {
    let first = setup.settings.scene.frames.map(|frames| frames.first);
    let settings = at_frame(setup.settings, first);
    let (mut chosen, mut electrons) = (setup.settings.clone(), None);
    if is_chosen(&settings, setup.wanted) {
        return Ok(Chosen { settings: chosen, electrons });
    }
    let setup = Setup { settings: &settings, ..*setup };
    let stage = setup.stage(diagnostics)?;
    let world = stage.world(setup.source, &settings.light.sky, setup.engine)?;
    let prepared = setup.prepare(&stage, &world, 0, diagnostics)?;
    if let (Camera::Rig(own), Some(rig)) = (&mut chosen.camera, prepared.rig()) {
        if !is_spaced(&settings) {
            own.spacing = Spacing::BaselineM(rig.baseline_x_m());
        }
        own.focus = Focus::Meters(rig.focus_distance_m());
    }
    let needs_exposure = needs_exposure(&settings, setup.wanted);
    let sensor = settings.output.sensor_model;
    if needs_exposure || sensor.is_some() {
        let request = exposure_request(request(&setup, &prepared, None)?);
        let rendered = prepared.renderer.render(&request, &CancelOnly(progress))?;
        if needs_exposure {
            let ev = prepared.renderer.install(|| exposure_ev(Exposure::Automatic, &rendered));
            chosen.output.exposure = ev.map_or(Exposure::Automatic, Exposure::Ev);
        }
        if let (Some(sensor), Some(color)) = (sensor, &rendered.color) {
            let iso = settings.output.iso;
            electrons = Some(prepared.renderer.install(|| codes::automatic_electrons(color, sensor, iso))?);
        }
    }
    Ok(Chosen { settings: chosen, electrons })
}

/// Whether nothing is left to choose.
fn is_chosen(settings: &RenderSettings, wanted: &Wanted) -> bool {
    let is_focused = settings.camera.rig().is_none_or(|rig| rig.focus != Focus::Automatic);
    is_focused && is_spaced(settings) && !needs_exposure(settings, wanted) && settings.output.sensor_model.is_none()
}

/// Whether the baseline of every shot follows from the settings. That of an f-number follows from the focal length, which
/// poses may differ in.
fn is_spaced(settings: &RenderSettings) -> bool {
    settings.camera.rig().is_none_or(|rig| match rig.spacing {
        Spacing::BaselineM(_) => true,
        Spacing::FNumber(_) => settings.poses.cameras().is_none(),
        Spacing::DisparitiesPx(_) => false,
    })
}

/// Whether exposure is automatic, and a file depends on it.
fn needs_exposure(settings: &RenderSettings, wanted: &Wanted) -> bool {
    let output = &settings.output;
    let has_integers = match settings.camera {
        Camera::Plenoptic(_) => {
            output.write.is_empty() || output.write.contains(&Output::RawPng) || !output.tools.is_empty()
        }
        Camera::Rig(_) | Camera::Pinhole => true,
    };
    output.exposure == Exposure::Automatic && has_integers && wanted.integrator != Integrator::Depth
}
