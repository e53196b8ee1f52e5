//! What identifies a shot in its manifest, and what the manifest says beside it.

use holo_io::{CameraArray, CameraFile, Manifest, ManifestValue, Sha256};
use holo_render::{Denoise, Integrator, Layer, Rendered, Request, Reuse, Transport};

use super::engine::ENGINE;
use super::prepare::{Prepared, Stage};
use super::source::SceneSource;
use crate::Error;
use crate::output::Wanted;
use crate::settings::{Camera, Frames, Poses, RenderSettings, Sky, number_of_samples, to_manifest, word};

/// The names of more objects are left out of manifests, bytes.
const MOST_BYTES_OF_NAMES: usize = 4 << 20;

/// Returns what identifies a job: digests of scene, sky, camera and poses, its settings, and versions.
pub(super) fn of(source: &SceneSource, settings: &RenderSettings, backend: &str) -> Result<Manifest, Error> {
    let mut manifest = Manifest { seed: settings.light.seed, ..Manifest::default() };
    manifest.versions.insert("holo".into(), env!("CARGO_PKG_VERSION").into());
    manifest.versions.insert(ENGINE.into(), backend.into());
    to_manifest(settings, &mut manifest);
    let mut set = |key: &str, value: ManifestValue| drop(manifest.settings.insert(key.into(), value));
    set("scene_sha256", source.sha256()?.to_string().into());
    if let SceneSource::Recipe(drawing) = source {
        set("recipe", drawing.recipe().name().into());
    }
    if let Sky::Map(path) = &settings.light.sky {
        set("sky_sha256", holo_io::hash_file(path)?.sha256.to_string().into());
    }
    if let Camera::Plenoptic(file) = &settings.camera {
        set("camera_sha256", camera_digest(file).to_string().into());
    }
    if let Poses::Array { cameras, .. } = &settings.poses {
        set("cameras_sha256", poses_digest(cameras).to_string().into());
    }
    Ok(manifest)
}

/// Returns what identifies a shot of a job: its frame and its pose beside what identifies the job. Two manifests with the
/// same identity are of the same image.
pub(super) fn of_shot(
    mut of_job: Manifest,
    settings: &RenderSettings,
    (frame, pose): (Option<u32>, Option<&str>),
) -> Manifest {
    let mut set = |key: &str, value: ManifestValue| drop(of_job.settings.insert(key.into(), value));
    if let Some(frame) = frame {
        set("frame", frame.into());
        set("time_s", settings.scene.seconds_of(frame).into());
    }
    if let Some(pose) = pose {
        set("pose", pose.into());
    }
    of_job
}

/// The digest of a plenoptic camera: of its `camera.toml`.
pub(crate) fn camera_digest(file: &CameraFile) -> Sha256 {
    Sha256::of(file.to_toml().as_bytes())
}

/// The digest of the cameras of a list: of names, sizes and the bits of all numbers.
pub(crate) fn poses_digest(array: &CameraArray) -> Sha256 {
    let mut bytes = b"holo cameras 1".to_vec();
    for camera in &array.cameras {
        bytes.extend((camera.name.len() as u64).to_le_bytes());
        bytes.extend(camera.name.as_bytes());
        let size = camera.size.map_or([0; 2], |size| [size.rows as u64, size.columns as u64]);
        bytes.extend(size.iter().flat_map(|count| count.to_le_bytes()));
        let numbers = camera.axes_and_position.as_flattened().iter().chain([&camera.focal_px]);
        // -0 is 0.
        bytes.extend(numbers.flat_map(|number| (number + 0.0).to_bits().to_le_bytes()));
        if camera.gain != [1.0; 3] || camera.time_s != 0.0 {
            bytes.extend(b"gain, time");
            bytes.extend(camera.gain.iter().chain([&camera.time_s]).flat_map(|x| (x + 0.0).to_bits().to_le_bytes()));
        }
    }
    Sha256::of(&bytes)
}

/// Why images are not for scoring or training methods that match views, if their noise tells a disparity.
fn not_for_stereo(denoise: Denoise, reuse: Reuse) -> Option<&'static str> {
    match (denoise, reuse) {
        (Denoise::Views, _) => {
            Some("the noise that is left moves with the true disparity, because views share samples")
        }
        (Denoise::Off, Reuse::Views) => {
            Some("the noise of the views of a group is equal, as they share light, and does not move with disparity")
        }
        (Denoise::Off, Reuse::Off) => None,
    }
}

/// Adds what was rendered and how.
pub(super) fn describe(
    mut manifest: Manifest,
    (settings, wanted): (&RenderSettings, &Wanted),
    (stage, prepared): (&Stage, &Prepared),
    rendered: &Rendered,
    request: &Request,
) -> Manifest {
    manifest.rig = prepared.rig().copied();
    let values = &mut manifest.settings;
    let mut set = |key: &str, value: ManifestValue| drop(values.insert(key.into(), value));
    let switch = |is_on: bool| ManifestValue::from(if is_on { "on" } else { "off" });
    let transport = &request.transport;
    set("camera", prepared.name.clone().into());
    if let Some(preset) = settings.preset {
        let given = preset.given();
        let own = given.iter().map(|(key, text)| (key.to_owned(), text.into())).collect();
        set("preset", ManifestValue::Table([(preset.name.to_owned(), ManifestValue::Table(own))].into()));
    }
    if let Camera::Plenoptic(file) = &settings.camera {
        set("camera-file", file.name.clone().into());
        if file.is_approximate {
            set("approximate", "the maker did not publish some values of the camera; they are estimates".into());
        }
    }
    describe_transport(transport, rendered.integrator, &mut set);
    if rendered.color.is_some() {
        let reuse = if request.camera.rig().is_some() { transport.reuse } else { Reuse::Off };
        if reuse == Reuse::Views {
            set("reuse", word(&reuse).into());
        }
        if let Some(why) = not_for_stereo(request.denoise, reuse) {
            set("not-for-stereo", why.into());
        }
        if request.denoise == Denoise::Off {
            set("texture-filter", word(&transport.texture_filter).into());
        } else {
            set("denoise", word(&request.denoise).into());
            let is_rig = request.camera.rig().is_some();
            let method = if is_rig { Denoise::METHOD } else { Denoise::RAW_METHOD };
            set("denoise-method", method.into());
        }
    }
    if transport.cull {
        set("cull", switch(true));
    }
    set("sky", ManifestValue::List(transport.sky.map(|c| f64::from(c).into()).to_vec()));
    if stage.has_automatic_sky {
        set("automatic-sky", switch(true));
    }
    set("bit-depth", u32::from(settings.output.bit_depth).into());
    set("layers", wanted.names(rendered).into());
    set("ground-truth", word(&request.ground_truth).into());
    if let Some(attempt) = stage.attempt {
        set("attempt", ManifestValue::from(attempt as usize));
    }
    if wanted.masks || rendered.central.set().contains(Layer::ObjectId) {
        let instances = &stage.loaded.scene.instances;
        // A manifest that is too long could not be read again.
        if instances.iter().map(|instance| instance.name.len() + 8).sum::<usize>() <= MOST_BYTES_OF_NAMES {
            let names = instances.iter().map(|instance| instance.name.clone().into());
            set("objects", ManifestValue::List(names.collect()));
        }
    }
    manifest
}

/// Adds how light was transported.
fn describe_transport(transport: &Transport, integrator: Integrator, set: &mut dyn FnMut(&str, ManifestValue)) {
    let switch = |is_on: bool| ManifestValue::from(if is_on { "on" } else { "off" });
    set("integrator", word(&integrator).into());
    set("spp", number_of_samples(transport.samples));
    if let Some(target) = transport.target_error {
        set("target-error", target.into());
    }
    if integrator == Integrator::Path {
        set("max-bounces", transport.max_bounces.into());
        set("roulette", switch(transport.roulette));
        set("indirect", switch(transport.indirect));
    }
    if transport.indirect_limit.is_finite() {
        set("indirect-limit", f64::from(transport.indirect_limit).into());
    }
    if transport.transparent_shadows {
        set("transparent-shadows", switch(true));
    }
    if transport.spectral {
        set("spectral", switch(true));
    }
    if !transport.multiple_scattering {
        set("multiple-scattering", switch(false));
    }
}

/// The frame of a shot in the settings of its job, which may have several.
pub(super) fn at_frame(settings: &RenderSettings, frame: Option<u32>) -> RenderSettings {
    let mut settings = settings.clone();
    settings.scene.frames = frame.map(Frames::one).or(settings.scene.frames);
    settings
}
