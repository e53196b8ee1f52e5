//! Specifications as text: the long options of the command line and their values, as manifests contain them.
//!
//! A later run compares them with its own to decide whether a folder is up to date, and `merge` takes the outputs to
//! write from them. Threads, backend and output folder are not among them, because the files do not depend on them.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use holo_core::sensor::{SensorPreset, sensor_presets};
use holo_core::{ParseGridSizeError, Projection, Sensor};
use holo_io::MatOrder;
use holo_render::{Denoise, GroundTruth, Integrator, Layer, Reuse, TextureFilter};
use holo_scene::gltf::LightUnits;

use crate::Error;
use crate::spec::{Exposure, Focus, Frames, LayerChoice, Output, RawLayer, RenderSpec, Shard, Sky};

/// Long options of the command line, without `--`, and their values.
pub type Options = BTreeMap<String, String>;

/// The value of `sky` for an environment map: its path is private, and the manifest contains its digest.
const MAP: &str = "map";

/// Outputs and their names.
const OUTPUTS: [(Output, &str); 13] = [
    (Output::Vpi, "vpi"),
    (Output::El, "el"),
    (Output::Disparity, "disparity"),
    (Output::Depth, "depth"),
    (Output::Exr, "exr"),
    (Output::Mat, "mat"),
    (Output::H5, "h5"),
    (Output::Hci, "hci"),
    (Output::HciHighres, "hci-highres"),
    (Output::Raw, "raw"),
    (Output::RawPng, "raw-png"),
    (Output::White, "white"),
    (Output::Centers, "centers"),
];

/// Integrators and their names.
const INTEGRATORS: [(Integrator, &str); 4] = [
    (Integrator::Auto, "auto"),
    (Integrator::Depth, "depth"),
    (Integrator::Direct, "direct"),
    (Integrator::Path, "path"),
];

/// Kinds of noise reduction and their names.
const DENOISE: [(Denoise, &str); 2] = [(Denoise::Off, "off"), (Denoise::Views, "views")];

/// Kinds of reuse and their names.
const REUSE: [(Reuse, &str); 2] = [(Reuse::Off, "off"), (Reuse::Views, "views")];

/// Texture filters and their names.
const TEXTURE_FILTERS: [(TextureFilter, &str); 2] =
    [(TextureFilter::Off, "off"), (TextureFilter::Footprint, "footprint")];

const SENSORS: [(Sensor, &str); 4] =
    [(Sensor::Hd, "hd"), (Sensor::Uhd4k, "4k"), (Sensor::Paper8k, "8k"), (Sensor::Uhd8k, "uhd8k")];

const LIGHT_UNITS: [(LightUnits, &str); 3] =
    [(LightUnits::Gltf, "gltf"), (LightUnits::Blender, "blender"), (LightUnits::Auto, "auto")];

/// The last frame: eleven hours at 24 frames a second.
const MAX_FRAME: u32 = 999_999;

/// The value of what is chosen automatically.
const AUTO: &str = "auto";

/// Endings of environment maps.
const MAPS: [&str; 5] = [".hdr", ".exr", ".png", ".jpg", ".jpeg"];

const SKY_FORMS: &str = "give auto, three numbers from 0 up, R,G,B, or one for gray, or an environment map: a file that \
    ends in .hdr, .exr, .png or .jpg";

/// Returns the name of an integrator on the command line and in files.
#[must_use]
pub fn integrator_name(integrator: Integrator) -> &'static str {
    name_of(&INTEGRATORS, &integrator)
}

/// Returns the integrator of a name; `None` for an unknown name.
#[must_use]
pub fn integrator_from_name(name: &str) -> Option<Integrator> {
    named(&INTEGRATORS, name)
}

/// Returns the name of a kind of noise reduction on the command line and in files.
#[must_use]
pub fn denoise_name(denoise: Denoise) -> &'static str {
    name_of(&DENOISE, &denoise)
}

/// Returns the name of a texture filter on the command line and in files.
pub(crate) fn texture_filter_name(filter: TextureFilter) -> &'static str {
    name_of(&TEXTURE_FILTERS, &filter)
}

/// Parses a sensor: a name such as `8k`, or a size `WIDTHxHEIGHT` in pixels.
///
/// # Errors
/// A message with the accepted values, if the text is neither a known name nor a size.
pub fn parse_sensor(text: &str) -> Result<Sensor, String> {
    let name = text.to_ascii_lowercase();
    match named(&SENSORS, &name) {
        Some(sensor) => Ok(sensor),
        None if name.contains('x') => {
            name.parse().map(Sensor::Other).map_err(|why: ParseGridSizeError| why.to_string())
        }
        None => Err("give hd, 4k, 8k, uhd8k or WIDTHxHEIGHT, such as 1500x1000".into()),
    }
}

/// Parses a finite number above 0.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn parse_positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("give a number above 0".into()),
    }
}

/// Parses a finite number that is not negative.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn parse_not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err("give a number from 0 up".into()),
    }
}

/// Parses a range `MIN,MAX` of finite numbers, the smaller first.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn parse_range(text: &str) -> Result<(f64, f64), String> {
    let finite = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite());
    let ends = text.split_once(',').and_then(|(min, max)| Some((finite(min)?, finite(max)?)));
    ends.filter(|(min, max)| min < max).ok_or_else(|| "write MIN,MAX, such as -2,2.5, the smaller first".into())
}

/// Parses the name of an image sensor.
///
/// # Errors
/// A message with all names.
pub fn parse_sensor_model(text: &str) -> Result<String, String> {
    match SensorPreset::by_name(text) {
        Some(preset) => Ok(preset.name.into()),
        None => {
            let names: Vec<&str> = sensor_presets().iter().map(|preset| preset.name).collect();
            Err(format!("there is no sensor '{text}'; they are {}", names.join(", ")))
        }
    }
}

/// Parses the unit of lights: `gltf`, `blender` or `auto`.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn parse_light_units(text: &str) -> Result<LightUnits, String> {
    named(&LIGHT_UNITS, text).ok_or_else(|| "give gltf, blender or auto".into())
}

/// Parses a bit depth, 8 or 16.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn parse_bit_depth(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("give 8 or 16".into()),
    }
}

impl FromStr for Shard {
    type Err = String;

    /// Parses `K/N`, part K of N, counted from 1.
    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(part, of)| Some((part.parse().ok()?, of.parse().ok()?)));
        match parsed {
            Some((part, of)) if (1..=of).contains(&part) => Ok(Self { part, of }),
            _ => Err("write K/N, such as 2/3: part 2 of 3, counted from 1".into()),
        }
    }
}

impl FromStr for Frames {
    type Err = String;

    /// Parses `N` or `A-B`, both ends included.
    fn from_str(text: &str) -> Result<Self, String> {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        match (first.parse(), last.parse()) {
            (Ok(first), Ok(last)) if first <= last && last <= MAX_FRAME => Ok(Self { first, last }),
            _ => Err(format!("give the number of a frame, or A-B from the first to the last, up to {MAX_FRAME}")),
        }
    }
}

impl fmt::Display for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.single() {
            Some(frame) => write!(f, "{frame}"),
            None => write!(f, "{}-{}", self.first, self.last),
        }
    }
}

impl FromStr for Sky {
    type Err = String;

    /// Parses `auto`, `R,G,B`, one number for gray, or the path of an image: `.hdr`, `.exr`, `.png`, `.jpg`, `.jpeg`.
    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.to_ascii_lowercase();
        if text == AUTO {
            return Ok(Self::Automatic);
        }
        if MAPS.iter().any(|ending| lower.ends_with(ending)) {
            return Ok(Self::Map(text.into()));
        }
        let parts: Vec<f32> = text
            .split(',')
            .map(|part| part.trim().parse::<f32>().ok().filter(|x| *x >= 0.0 && x.is_finite()))
            .collect::<Option<_>>()
            .ok_or(SKY_FORMS)?;
        match parts[..] {
            [gray] => Ok(Self::Constant([gray; 3])),
            [r, g, b] => Ok(Self::Constant([r, g, b])),
            _ => Err(SKY_FORMS.into()),
        }
    }
}

impl FromStr for Focus {
    type Err = String;

    /// Parses `auto`, `inf` or a distance in meters.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Automatic),
            "inf" => Ok(Self::Meters(f64::INFINITY)),
            other => parse_positive(other).map(Self::Meters).map_err(|_| "give meters above 0, inf or auto".into()),
        }
    }
}

impl FromStr for Exposure {
    type Err = String;

    /// Parses `auto` or an exposure compensation in EV.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Automatic),
            other => match other.parse::<f64>() {
                Ok(ev) if ev.abs() <= 100.0 => Ok(Self::Ev(ev)),
                _ => Err("give an EV between -100 and 100, or auto".into()),
            },
        }
    }
}

impl LayerChoice {
    /// Parses `color`, `error`, `visibility`, `optical-flow`, `scene-flow`, `all` or the name of a layer; `None` for an unknown name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "color" | "colour" => Some(Self::Color),
            "error" => Some(Self::Error),
            "visibility" => Some(Self::Visibility),
            "optical-flow" => Some(Self::OpticalFlow),
            "scene-flow" => Some(Self::SceneFlow),
            "all" => Some(Self::All),
            other => {
                let raw = RawLayer::ALL.into_iter().find(|layer| layer.name() == other);
                Layer::from_name(other).map(Self::One).or(raw.map(Self::Raw))
            }
        }
    }

    /// Returns the name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Error => "error",
            Self::Visibility => "visibility",
            Self::OpticalFlow => "optical-flow",
            Self::SceneFlow => "scene-flow",
            Self::All => "all",
            Self::One(layer) => layer.name(),
            Self::Raw(layer) => layer.name(),
        }
    }
}

impl Output {
    /// Returns the output of a name; `None` for an unknown name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        named(&OUTPUTS, name)
    }

    /// Returns the name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        name_of(&OUTPUTS, &self)
    }
}

impl RenderSpec {
    /// Returns the specification as text. The value of `sky` for an environment map is `map`, without its path.
    #[must_use]
    pub fn to_options(&self) -> Options {
        let rig = &self.rig;
        let mut options = Options::new();
        let mut set = |name: &str, value: String| drop(options.insert(name.to_owned(), value));
        let list = |names: Vec<&str>| names.join(",");
        match rig.lenses {
            // The number of microlenses replaces a sensor.
            Some(lenses) => set("lenses", lenses.to_string()),
            None => set("sensor", sensor_text(rig.sensor)),
        }
        set("views", rig.views.to_string());
        if let Some(count) = rig.lens_shifts {
            set("lens-shifts", count.to_string());
        }
        let optional = [
            ("f-number", rig.f_number),
            ("baseline-m", rig.baseline_m),
            ("focal-mm", rig.focal_mm),
            ("target-error", self.target_error),
        ];
        for (name, value) in optional.into_iter().filter_map(|(name, value)| Some((name, value?))) {
            set(name, value.to_string());
        }
        if let Some((min, max)) = rig.disparity_px {
            set("disparity", format!("{min},{max}"));
        }
        if let Some(camera) = &rig.camera {
            set("camera", camera.clone());
        }
        if let Some(subset) = &rig.subset {
            set("subset", subset.to_string());
        }
        set("light-units", name_of(&LIGHT_UNITS, &self.scene.light_units).into());
        set("solid-glass", self.scene.solid_glass.to_string());
        if let Some(variant) = &self.scene.material_variant {
            set("material-variant", variant.clone());
        }
        if let Some(frames) = self.scene.frames {
            set("frame", frames.to_string());
        }
        if let Some(fps) = self.scene.fps {
            set("fps", fps.to_string());
        }
        if let Some(animation) = &self.scene.animation {
            set("animation", animation.clone());
        }
        if let Some(name) = &self.sensor_model {
            set("sensor-model", name.clone());
        }
        if let Some(iso) = self.iso {
            set("iso", iso.to_string());
        }
        if let Some(samples) = self.samples {
            set("spp", samples.to_string());
        }
        set("focus-m", focus_text(rig.focus));
        set("sensor-mm", rig.sensor_mm.to_string());
        let orthographic = rig.projection == Projection::Orthographic;
        set("projection", if orthographic { "orthographic" } else { "perspective" }.into());
        set("integrator", integrator_name(self.integrator).into());
        set("max-bounces", self.max_bounces.to_string());
        set("no-roulette", (!self.roulette).to_string());
        set("no-indirect", (!self.indirect).to_string());
        if self.indirect_limit.is_finite() {
            set("indirect-limit", self.indirect_limit.to_string());
        }
        set("transparent-shadows", self.transparent_shadows.to_string());
        set("no-multiple-scattering", (!self.multiple_scattering).to_string());
        set("cull", self.cull.to_string());
        set("reuse", name_of(&REUSE, &self.reuse).into());
        set("texture-filter", texture_filter_name(self.texture_filter).into());
        set("denoise", denoise_name(self.denoise).into());
        set(
            "sky",
            match &self.sky {
                Sky::Automatic => AUTO.into(),
                Sky::Constant([r, g, b]) => format!("{r},{g},{b}"),
                Sky::Map(_) => MAP.into(),
            },
        );
        set("exposure", exposure_text(self.exposure));
        let all = self.ground_truth == GroundTruth::All;
        set("ground-truth", if all { "all" } else { "central" }.into());
        if !self.layers.is_empty() {
            set("layers", list(self.layers.iter().map(|layer| layer.name()).collect()));
        }
        if !self.outputs.is_empty() {
            set("write", list(self.outputs.iter().map(|output| output.name()).collect()));
        }
        let views_first = self.mat_order == MatOrder::LightFieldToolbox;
        set("mat-order", if views_first { "lftoolbox" } else { "lenses" }.into());
        set("bit-depth", self.bit_depth.to_string());
        set("seed", self.seed.to_string());
        options
    }

    /// Parses a specification from text; missing options have their defaults. The sky `map` becomes black, because its
    /// path is unknown.
    ///
    /// # Errors
    /// [`Error::BadRequest`] for an unknown option or an invalid value.
    pub fn from_options(options: &Options) -> Result<Self, Error> {
        let mut spec = Self::default();
        for (name, value) in options {
            spec.set(name, value).map_err(|why| Error::BadRequest(format!("--{name}={value}: {why}")))?;
        }
        Ok(spec)
    }

    fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        let size = |text: &str| text.parse().map_err(|why: ParseGridSizeError| why.to_string());
        fn number<T: FromStr>(text: &str) -> Result<T, String> {
            text.parse().map_err(|_| "not a valid number".to_owned())
        }
        let rig = &mut self.rig;
        match name {
            "sensor" => rig.sensor = parse_sensor(value)?,
            "f-number" => rig.f_number = Some(parse_positive(value)?),
            "focus-m" => rig.focus = value.parse()?,
            "views" => rig.views = size(value)?,
            "lenses" => rig.lenses = Some(size(value)?),
            "lens-shifts" => rig.lens_shifts = Some(number(value)?),
            "baseline-m" => rig.baseline_m = Some(parse_not_negative(value)?),
            "focal-mm" => rig.focal_mm = Some(parse_positive(value)?),
            "sensor-mm" => rig.sensor_mm = parse_positive(value)?,
            "projection" => {
                rig.projection = one_of(
                    &[(Projection::Perspective, "perspective"), (Projection::Orthographic, "orthographic")],
                    value,
                )?;
            }
            "disparity" => rig.disparity_px = Some(parse_range(value)?),
            "light-units" => self.scene.light_units = parse_light_units(value)?,
            "solid-glass" => self.scene.solid_glass = number(value)?,
            "material-variant" => self.scene.material_variant = Some(value.to_owned()),
            "frame" => self.scene.frames = Some(value.parse()?),
            "fps" => self.scene.fps = Some(parse_positive(value)?),
            "animation" => self.scene.animation = Some(value.to_owned()),
            "sensor-model" => self.sensor_model = Some(parse_sensor_model(value)?),
            "iso" => self.iso = Some(parse_positive(value)?),
            "camera" => rig.camera = Some(value.to_owned()),
            "subset" => rig.subset = Some(value.parse()?),
            "integrator" => self.integrator = one_of(&INTEGRATORS, value)?,
            "spp" => self.samples = Some(number(value)?),
            "target-error" => self.target_error = Some(parse_positive(value)?),
            "max-bounces" => self.max_bounces = number(value)?,
            "no-roulette" => self.roulette = !number::<bool>(value)?,
            "no-indirect" => self.indirect = !number::<bool>(value)?,
            "indirect-limit" => self.indirect_limit = parse_positive(value)? as f32,
            "transparent-shadows" => self.transparent_shadows = number(value)?,
            "no-multiple-scattering" => self.multiple_scattering = !number::<bool>(value)?,
            "cull" => self.cull = number(value)?,
            "reuse" => self.reuse = one_of(&REUSE, value)?,
            "texture-filter" => self.texture_filter = one_of(&TEXTURE_FILTERS, value)?,
            "denoise" => self.denoise = one_of(&DENOISE, value)?,
            "sky" if value == MAP => self.sky = Sky::Constant([0.0; 3]),
            "sky" => self.sky = value.parse()?,
            "exposure" => self.exposure = value.parse()?,
            "ground-truth" => {
                self.ground_truth = one_of(&[(GroundTruth::Central, "central"), (GroundTruth::All, "all")], value)?;
            }
            "layers" => self.layers = list(value, LayerChoice::from_name)?,
            "write" => self.outputs = list(value, Output::from_name)?,
            "mat-order" => {
                self.mat_order =
                    one_of(&[(MatOrder::Lenses, "lenses"), (MatOrder::LightFieldToolbox, "lftoolbox")], value)?;
            }
            "bit-depth" => self.bit_depth = parse_bit_depth(value)?,
            "seed" => self.seed = number(value)?,
            _ => return Err("unknown option".into()),
        }
        Ok(())
    }

    /// Returns the path of the environment map, if there is one.
    #[must_use]
    pub fn sky_map(&self) -> Option<&PathBuf> {
        match &self.sky {
            Sky::Automatic | Sky::Constant(_) => None,
            Sky::Map(path) => Some(path),
        }
    }
}

/// Returns options as arguments of a command line. Options with the value `false` are omitted.
pub fn arguments(options: &Options) -> impl Iterator<Item = String> {
    options.iter().filter(|(_, value)| *value != "false").map(|(name, value)| match value.as_str() {
        "true" => format!("--{name}"),
        value => format!("--{name}={value}"),
    })
}

/// Removes the path of an environment map from options, as [`RenderSpec::to_options`] does.
#[must_use]
pub fn without_paths(mut options: Options, spec: &RenderSpec) -> Options {
    if spec.sky_map().is_some() {
        options.insert("sky".into(), MAP.into());
    }
    options
}

fn focus_text(focus: Focus) -> String {
    match focus {
        Focus::Automatic => AUTO.into(),
        Focus::Meters(distance) => distance.to_string(),
    }
}

fn exposure_text(exposure: Exposure) -> String {
    match exposure {
        Exposure::Automatic => AUTO.into(),
        Exposure::Ev(ev) => ev.to_string(),
    }
}

fn sensor_text(sensor: Sensor) -> String {
    match sensor {
        Sensor::Other(size) => size.to_string(),
        known => name_of(&SENSORS, &known).into(),
    }
}

fn named<T: Copy>(names: &[(T, &str)], name: &str) -> Option<T> {
    names.iter().find(|(_, known)| *known == name).map(|(value, _)| *value)
}

fn name_of<T: PartialEq>(names: &[(T, &'static str)], value: &T) -> &'static str {
    names.iter().find(|(known, _)| known == value).map_or("", |(_, name)| name)
}

fn one_of<T: Copy>(names: &[(T, &str)], name: &str) -> Result<T, String> {
    let all = || names.iter().map(|(_, name)| *name).collect::<Vec<_>>().join(", ");
    named(names, name).ok_or_else(|| format!("give one of {}", all()))
}

fn list<T>(text: &str, read: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, String> {
    text.split(',').map(|name| read(name).ok_or_else(|| format!("there is no '{name}'"))).collect()
}

#[cfg(test)]
mod tests;
