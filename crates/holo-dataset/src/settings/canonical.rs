//! The settings of a manifest: typed values in one form, whatever was typed.
//!
//! Settings that give the same files have the same form: 16 samples are 16 samples, given or not. A later run compares
//! it with its own to decide whether a folder is up to date, and `merge` reads the outputs from it. Threads, backend and
//! output folder are not in it, because the files do not depend on them.

use std::collections::BTreeMap;
use std::path::PathBuf;

use holo_io::{CameraFile, Manifest, ManifestValue};
use holo_render::{Denoise, Integrator, SamplesPerPixel};

use super::types::{MAP, Output};
use super::value::text;
use super::{Camera, LightSettings, RenderSettings, RigSettings, Setting, Sky, table};
use crate::Error;

/// The key of the settings in a manifest.
pub(crate) const OPTIONS: &str = "options";

/// Settings whose defaults follow from others.
const DERIVED: [&str; 3] = ["spp", "write", "fps"];

/// The keys of the sky and of the tools.
const SKY: &str = "sky";
const TOOLS: &str = "for";

/// Values by key.
type Values = BTreeMap<String, ManifestValue>;

impl LightSettings {
    /// Returns the number of samples per pixel: the one that is set, or the default of integrator, target error
    /// and denoising.
    #[must_use]
    pub fn samples_per_pixel(&self) -> SamplesPerPixel {
        self.samples.unwrap_or(match (self.integrator, self.target_error, self.denoise) {
            (Integrator::Depth, ..) => 1.into(),
            (_, Some(_), Denoise::Off) => 1024.into(),
            (_, None, _) | (_, Some(_), Denoise::Views) => 16.into(),
        })
    }
}

impl RenderSettings {
    /// Returns the outputs without a request, if the image has color.
    fn default_outputs(&self) -> Vec<Output> {
        use Output::{Depth, Disparity, El, Hci, Mat, Vpi};
        match &self.camera {
            Camera::Plenoptic(_) => Output::RAW.to_vec(),
            Camera::Pinhole => Vec::new(),
            Camera::Rig(rig) if rig.subset.is_some() && self.output.layers.is_empty() => vec![Hci, Disparity, Depth],
            Camera::Rig(rig) if rig.subset.is_some() => vec![Hci],
            Camera::Rig(_) if self.output.layers.is_empty() => vec![Vpi, El, Disparity, Depth, Mat],
            Camera::Rig(_) => vec![Vpi, El, Mat],
        }
    }

    /// Returns the same settings with the defaults that depend on other settings.
    fn resolved(&self) -> Self {
        let mut settings = self.clone();
        settings.light.samples = Some(self.light.samples_per_pixel());
        if settings.output.write.is_empty() {
            settings.output.write = self.default_outputs();
        }
        if settings.scene.frames.is_some() {
            settings.scene.fps = Some(self.scene.frames_per_second());
        }
        if let Camera::Rig(rig) = &mut settings.camera {
            // One position of the microlens array is no shift.
            rig.lens_shifts = rig.lens_shifts.filter(|shifts| *shifts != 1);
        }
        settings
    }

    /// Returns the values of all settings that have one.
    fn values(&self) -> Values {
        let values = table().map(|setting| (setting.key.to_owned(), (setting.get)(self)));
        values.filter(|(_, value)| *value != ManifestValue::None).collect()
    }
}

/// Returns settings as text, by key.
pub(crate) fn texts(settings: &RenderSettings) -> BTreeMap<String, String> {
    let values = settings.resolved().values().into_iter();
    values.filter_map(|(key, value)| Some((key, text(&value)?))).collect()
}

/// Adds settings to a manifest.
pub(crate) fn to_manifest(settings: &RenderSettings, manifest: &mut Manifest) {
    manifest.settings.insert(OPTIONS.into(), ManifestValue::Table(settings.resolved().values()));
}

/// Returns the settings of a manifest of this version or of an older one, whose values are texts. `camera` is the kind of
/// camera that the manifest is of: settings of other cameras are left out. An environment map has no path.
///
/// # Errors
/// [`Error::Failed`] if the manifest has no settings, or one of them is unknown or out of range.
pub(crate) fn from_manifest(manifest: &Manifest, camera: Camera) -> Result<RenderSettings, Error> {
    let Some(ManifestValue::Table(values)) = manifest.settings.get(OPTIONS) else {
        return Err(Error::Failed("the manifest does not contain the settings of its render".into()));
    };
    let mut settings = RenderSettings { camera, ..RenderSettings::default() };
    for (key, value) in values {
        let failed = |why: &str| Error::Failed(format!("`{key}` of the manifest: {why}"));
        let setting = Setting::by_key(key).ok_or_else(|| failed("unknown setting"))?;
        if settings.camera.rig().is_none() && is_of_rig(key) {
            continue;
        }
        let text = text(value).ok_or_else(|| failed("not a value of a setting"))?;
        if (key.as_str(), text.as_str()) == (SKY, MAP) {
            settings.light.sky = Sky::Map(PathBuf::new());
            continue;
        }
        (setting.set)(&mut settings, &text).map_err(|why| failed(&why.to_string()))?;
    }
    // Manifests of format 1 have the tools beside the other settings.
    if let (false, Some(tools)) = (values.contains_key(TOOLS), manifest.settings.get(TOOLS).and_then(text))
        && let (Some(setting), true) = (Setting::by_key(TOOLS), settings.camera.plenoptic().is_some())
    {
        (setting.set)(&mut settings, &tools)
            .map_err(|why| Error::Failed(format!("`{TOOLS}` of the manifest: {why}")))?;
    }
    // The outputs without a request, which may lack color.
    let mut outputs = settings.output.write.clone();
    outputs.sort_unstable();
    let mut default = settings.default_outputs();
    default.sort_unstable();
    if outputs == default {
        settings.output.write.clear();
    }
    Ok(settings)
}

/// Returns the key of the first setting in which an older manifest differs from that of this render; `None` if both have
/// the same settings, whatever form the older one has.
pub(crate) fn changed(older: &Manifest, own: &Manifest) -> Option<String> {
    let Some(ManifestValue::Table(own_values)) = own.settings.get(OPTIONS) else { return None };
    let camera = camera_of(own);
    let older = match from_manifest(older, camera) {
        Ok(settings) => settings.resolved().values(),
        // Settings that cannot be read are others.
        Err(_) => return Some(OPTIONS.into()),
    };
    let keys: Vec<&String> = own_values.keys().chain(older.keys()).collect();
    let mut changed = keys.into_iter().filter(|key| own_values.get(*key) != older.get(*key));
    // A default may follow from what has changed.
    let first = changed.next()?;
    let is_derived = |key: &&String| DERIVED.contains(&key.as_str());
    Some(if is_derived(&first) { changed.find(|key| !is_derived(key)).unwrap_or(first) } else { first }.clone())
}

/// A camera of the kind that a manifest is of.
fn camera_of(manifest: &Manifest) -> Camera {
    let has = |key: &str| matches!(manifest.settings.get(OPTIONS), Some(ManifestValue::Table(values)) if values.contains_key(key));
    match (has("views"), manifest.settings.contains_key("camera_sha256"), CameraFile::preset("lytro-illum")) {
        (true, ..) => Camera::default(),
        // Which one does not matter: settings are not of one plenoptic camera or another.
        (false, true, Some(any)) => any.into(),
        _ => Camera::Pinhole,
    }
}

/// Whether a setting belongs to rigs alone.
fn is_of_rig(key: &str) -> bool {
    RigSettings::TABLE.iter().any(|setting| setting.key == key)
}
