//! Settings: everything that determines the files of a render, together with the scene.
//!
//! [`RenderSettings`] is typed, complete and comparable. Every setting of its groups is declared once, in the
//! [table]; [`table()`] lists them with type, default and help, so that command lines, configuration files and bindings
//! follow from it. [`Given`] holds settings as text, as people write them.

mod camera;
mod canonical;
mod declare;
mod given;
mod table;
pub mod text;
mod types;
mod value;
mod view_subset;
mod words;

use holo_io::ManifestValue;

pub use self::camera::{Camera, Poses, adjusted_camera};
pub(crate) use self::canonical::{OPTIONS, changed, from_manifest, texts, to_manifest};
pub use self::given::{Given, PRESETS, Preset, spelled};
pub use self::table::{LightSettings, OutputSettings, RigSettings, SceneSettings};
pub(crate) use self::types::number_of_samples;
pub use self::types::{
    Color, EngineSettings, Exposure, Focus, Frames, LayerChoice, Output, Pixels, Point, RawLayer, SensorName, Shard,
    Sky, Spacing, Tool, ViewSubset,
};
pub(crate) use self::value::text as value_text;
pub use self::value::{Kind, Malformed, SettingType, Word, not_negative, positive, range, share};
pub use self::words::name as word;

/// Everything that determines the files of a render, together with the scene. The defaults are those of the command
/// line: a rig of 100 x 100 views behind an 8K sensor.
///
/// The settings of [`LightSettings`] and [`OutputSettings`] have methods here that set them. [`SceneSettings`] and
/// [`RigSettings`] have their own.
///
/// # Example
/// ```
/// use holo_core::GridSize;
/// use holo_dataset::{Output, Pixels, RenderSettings, RigSettings};
///
/// let rig = RigSettings::default().views(20).lenses([265, 397]); // rows, columns
/// assert_eq!((rig.views, rig.pixels), (GridSize::new(20, 20), Pixels::Lenses(GridSize::new(265, 397))));
/// let settings = RenderSettings::default().camera(rig.clone()).samples(64).seed(7).write([Output::El]);
/// assert_eq!((settings.light.samples, settings.light.seed), (Some(64.into()), 7));
/// assert_eq!((settings.camera.rig(), settings.output.write), (Some(&rig), vec![Output::El]));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RenderSettings {
    /// How the scene file is read.
    pub scene: SceneSettings,
    /// The camera that makes one light field or raw image from one place.
    pub camera: Camera,
    /// The places where the camera stands.
    pub poses: Poses,
    /// The light that is simulated.
    pub light: LightSettings,
    /// The files.
    pub output: OutputSettings,
    /// The preset that the settings began with, for the manifest; nothing depends on it.
    pub preset: Option<&'static Preset>,
}

impl RenderSettings {
    /// Sets how the scene file is read.
    #[must_use]
    pub fn scene(self, scene: SceneSettings) -> Self {
        Self { scene, ..self }
    }

    /// Sets the camera: [`RigSettings`], a [`CameraFile`](holo_io::CameraFile), or any [`Camera`].
    #[must_use]
    pub fn camera(self, camera: impl Into<Camera>) -> Self {
        Self { camera: camera.into(), ..self }
    }

    /// Sets the places where the camera stands.
    #[must_use]
    pub fn poses(self, poses: Poses) -> Self {
        Self { poses, ..self }
    }
}

/// A setting: its name, and how its value is read and written.
#[derive(Clone, Copy)]
pub struct Setting {
    key: &'static str,
    form: &'static str,
    help: &'static [&'static str],
    field: &'static str,
    kind: Kind,
    get: fn(&RenderSettings) -> ManifestValue,
    set: fn(&mut RenderSettings, &str) -> Result<(), Malformed>,
}

/// What a setting is about, as a person decides it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// How a scene file is read.
    Scene,
    /// Where the camera of a scene stands.
    Viewpoint,
    /// A rig of pinhole cameras; some of these also change a plenoptic camera.
    Rig,
    /// The light that is simulated.
    Light,
    /// The samples of light, and what is left of their noise.
    Quality,
    /// The files.
    Files,
}

/// The keys of [`Group::Viewpoint`].
const VIEWPOINT: [&str; 6] = ["camera", "eye", "target", "up", "fov-deg", "fit-object"];

/// The keys of [`Group::Quality`].
const QUALITY: [&str; 6] = ["spp", "target-error", "denoise", "reuse", "texture-filter", "seed"];

/// Returns all settings, group by group.
pub fn table() -> impl Iterator<Item = &'static Setting> + Clone {
    table::TABLE.into_iter().flatten()
}

impl Setting {
    /// Returns the setting of a key, such as `focus-m`; `None` for an unknown one.
    #[must_use]
    pub fn by_key(key: &str) -> Option<&'static Self> {
        table().find(|setting| setting.key == key)
    }

    /// Returns what it is about.
    #[must_use]
    pub fn group(&self) -> Group {
        let has = |settings: &[Self]| settings.iter().any(|setting| setting.key == self.key);
        let groups = [Group::Scene, Group::Rig, Group::Light, Group::Files];
        match table::TABLE.into_iter().zip(groups).find(|(settings, _)| has(settings)) {
            _ if VIEWPOINT.contains(&self.key) => Group::Viewpoint,
            _ if QUALITY.contains(&self.key) => Group::Quality,
            Some((_, group)) => group,
            None => Group::Files,
        }
    }

    /// Returns the name in manifests, configuration files and, after `--`, on the command line.
    #[must_use]
    pub fn key(&self) -> &'static str {
        self.key
    }

    /// Returns the name as a keyword of Python: `_` for `-`, and `tools` for `for`, which is a word of the language.
    #[must_use]
    pub fn keyword(&self) -> String {
        if self.key == "for" { "tools".into() } else { self.key.replace('-', "_") }
    }

    /// Returns the form of the value, such as `SxT|N`; empty if its words or its being a flag say it.
    #[must_use]
    pub fn form(&self) -> &'static str {
        self.form
    }

    /// Returns what the value holds.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Returns the paragraphs of its help.
    #[must_use]
    pub fn help(&self) -> Vec<String> {
        let mut paragraphs = vec![String::new()];
        for line in self.help.iter().map(|line| line.trim()) {
            match paragraphs.last_mut() {
                Some(last) if !line.is_empty() => {
                    if !last.is_empty() {
                        last.push(' ');
                    }
                    last.push_str(line);
                }
                _ => paragraphs.push(String::new()),
            }
        }
        paragraphs
    }

    /// Returns whether at most one of both settings can be given.
    #[must_use]
    pub fn excludes(&self, other: &Self) -> bool {
        let is_pair = |a: &str, b: &str| [self.key, other.key] == [a, b] || [self.key, other.key] == [b, a];
        self.key != other.key && self.field == other.field || is_pair("disparity", "focus-m")
    }

    /// Returns the default value as text; `None` if the setting has none of its own.
    #[must_use]
    pub fn default(&self) -> Option<String> {
        value::text(&(self.get)(&RenderSettings::default())).filter(|text| text != "false")
    }

    /// Checks a value without a camera in mind.
    ///
    /// # Errors
    /// A message that says what is accepted.
    pub fn check(&self, text: &str) -> Result<(), Malformed> {
        (self.set)(&mut RenderSettings::default(), text)
    }
}
