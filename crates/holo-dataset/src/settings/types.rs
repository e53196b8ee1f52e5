//! The types of settings that are this crate's own.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;

use holo_core::sensor::SensorPreset;
use holo_core::{GridSize, Sensor};
use holo_io::ManifestValue;
use holo_render::{Backend, Layer, SamplesPerPixel};

use super::value::{Kind, Malformed, SettingType, positive};
pub use super::view_subset::ViewSubset;

/// The ray tracing backend and the number of threads. Of the files, only the name of the backend in the manifest
/// depends on them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EngineSettings {
    /// The ray tracing backend.
    pub backend: Backend,
    /// Number of threads; `None`: one per core.
    pub threads: Option<NonZeroUsize>,
}

/// What determines the pixels of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pixels {
    /// A sensor, which is divided into views and microlenses.
    Sensor(Sensor),
    /// The number of microlenses, V rows and U columns.
    Lenses(GridSize),
    /// The size of the images of [`Poses::Array`](super::Poses::Array).
    OfPoses,
}

/// What determines the distance between adjacent views.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Spacing {
    /// The f-number of the aperture that the views sample.
    FNumber(f64),
    /// The distance, m.
    BaselineM(f64),
    /// Smallest and largest disparity of what the central view hits, px between adjacent views. The focus distance follows
    /// too.
    DisparitiesPx((f64, f64)),
}

/// Environment light.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// Black for a scene with light sources, else a soft sky:
    /// [`Environment::overcast`](holo_scene::Environment::overcast).
    Automatic,
    /// The same linear RGB radiance from all directions.
    Constant([f32; 3]),
    /// An equirectangular environment map: an OpenEXR or Radiance HDR file in linear light, or a PNG or JPEG of 8 or 16
    /// bits, whose codes are sRGB and become radiance from 0 to 1.
    Map(PathBuf),
}

/// The distance of the focus plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// The harmonic mean of the nearest and farthest depth of the central view.
    Automatic,
    /// A distance in meters, which may be infinite.
    Meters(f64),
}

/// Exposure compensation of 8- and 16-bit images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// From the image: 99 % of the pixels that are not black are below 80 % of the range.
    Automatic,
    /// A value in EV.
    Ev(f64),
}

/// A range of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// Number of the first frame.
    pub first: u32,
    /// Number of the last frame, not below the first.
    pub last: u32,
}

/// A shard of a job: part `part` (from 1) of `of` parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1.
    pub part: usize,
    /// Number of parts.
    pub of: usize,
}

/// The name of an image sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorName(&'static str);

/// A choice of layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LayerChoice {
    /// Linear radiance, without exposure.
    Color,
    /// One layer.
    One(Layer),
    /// Color and all layers that describe the first hit.
    All,
    /// The part of all views that sees a point of the central view.
    Visibility,
    /// Where the image of a point moves until the next frame.
    OpticalFlow,
    /// How a point moves in the world until the next frame.
    SceneFlow,
    /// One layer of the raw image of a plenoptic camera.
    Raw(RawLayer),
    /// The estimated relative error of color.
    Error,
}

/// A layer of the raw image of a plenoptic camera that follows from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RawLayer {
    /// Row of the nearest micro-image, from the microlens at the origin of the array.
    LensRow,
    /// Its column.
    LensColumn,
    /// Its type, from 0.
    LensType,
    /// The white image: light of a scene of radiance 1.
    White,
    /// Distance of the image of the main lens behind the array, in gaps.
    VirtualDepth,
    /// Diameter of the blur, px.
    Blur,
    /// Mean of 1 / depth over what a pixel sees, 1/m.
    InverseDepthMean,
    /// Standard deviation of the same.
    InverseDepthDeviation,
    /// Share of the light that comes from surfaces.
    Coverage,
}

/// A file, or a set of files, that a render writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Output {
    /// `scene_vpi.png`: the sub-aperture image array.
    Vpi,
    /// `scene_el.png`: the raw image, an elemental image array.
    El,
    /// `scene_disparity.pfm` and `.png` of the central view.
    Disparity,
    /// `scene_depth.pfm` of the central view.
    Depth,
    /// `masks/`: masks of the central view, for scores.
    Masks,
    /// `scene_central.exr`: color and all layers of the central view, linear. With `El` or `Vpi` also `scene_el.exr`,
    /// `scene_vpi.exr`.
    Exr,
    /// `scene_5d.mat`: the raw image's integers as a 5D array for MATLAB.
    Mat,
    /// `scene_5d.h5`: linear radiance and the layers of depth and disparity as 5D arrays.
    H5,
    /// `hci/`: an HCI folder, with one PNG a view, depth and disparity.
    Hci,
    /// The same, with ground truth of the central view in ten times the resolution.
    HciHighres,
    /// `raw.exr`: the raw image of a plenoptic camera, linear.
    Raw,
    /// `raw_linear.png`: the same with 16 bits.
    RawPng,
    /// `white.exr` and `white.png` of a plenoptic camera.
    White,
    /// `centers.csv`: the centers of the micro-images of a plenoptic camera.
    Centers,
}

/// A program that the raw image of a plenoptic camera is also written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tool {
    /// The Light Field Toolbox for MATLAB by D. Dansereau: the raw image behind a Bayer filter, the white image, its grid
    /// model and a script.
    LfToolbox,
    /// PlenoptiCam by C. Hahne: raw image, white image and the calibration file.
    PlenoptiCam,
    /// libpleno and COMPOTE by M. Labussière: the calibrated camera, and white images of three f-numbers.
    Libpleno,
    /// PIP, the Plenoptic Image Processing of Kiel University: the microlens array, raw and white image.
    Pip,
    /// Raytrix's calibration, as PlenopticToolbox2.0 by L. Palmieri reads it, with the image without vignetting.
    Raytrix,
    /// plenpy by M. Schambach: raw and white image with their metadata, and a script.
    Plenpy,
    /// The files of Lytro's cameras, for the whole chain of LFToolbox.
    Lytro,
}

/// The last frame: eleven hours at 24 frames a second.
const MAX_FRAME: u32 = 999_999;

/// The value of what is chosen automatically.
const AUTO: &str = "auto";

/// The value of the sky of an environment map in a manifest: its path is private, and its digest is beside it.
pub(super) const MAP: &str = "map";

/// Endings of environment maps.
const MAPS: [&str; 5] = [".hdr", ".exr", ".png", ".jpg", ".jpeg"];

const SKY_FORMS: &str = "give auto, three numbers from 0 up, R,G,B, or one for gray, or an environment map: a file that \
    ends in .hdr, .exr, .png or .jpg";

/// Names of sensor resolutions.
const SENSORS: [(Sensor, &str); 4] =
    [(Sensor::Hd, "hd"), (Sensor::Uhd4k, "4k"), (Sensor::Paper8k, "8k"), (Sensor::Uhd8k, "uhd8k")];

impl EngineSettings {
    /// Sets the ray tracing backend.
    #[must_use]
    pub fn backend(self, backend: Backend) -> Self {
        Self { backend, ..self }
    }

    /// Sets the number of threads; `None`: one per core.
    #[must_use]
    pub fn threads(self, threads: impl Into<Option<NonZeroUsize>>) -> Self {
        Self { threads: threads.into(), ..self }
    }
}

impl SensorName {
    /// Returns the sensor.
    #[must_use]
    pub fn preset(self) -> Option<&'static SensorPreset> {
        SensorPreset::by_name(self.0)
    }

    /// Returns the name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.0
    }
}

impl Frames {
    /// One frame.
    #[must_use]
    pub const fn one(frame: u32) -> Self {
        Self { first: frame, last: frame }
    }

    /// Returns the number of the frame, if it is only one.
    #[must_use]
    pub fn single(self) -> Option<u32> {
        (self.first == self.last).then_some(self.first)
    }
}

impl RawLayer {
    /// All layers.
    pub const ALL: [Self; 9] = [
        Self::LensRow,
        Self::LensColumn,
        Self::LensType,
        Self::White,
        Self::VirtualDepth,
        Self::Blur,
        Self::InverseDepthMean,
        Self::InverseDepthDeviation,
        Self::Coverage,
    ];

    /// Whether it follows from the depth too.
    pub(crate) const fn needs_depth(self) -> bool {
        matches!(self, Self::VirtualDepth | Self::Blur)
    }

    /// Whether it follows from the samples of color.
    pub(crate) const fn needs_samples(self) -> bool {
        matches!(self, Self::InverseDepthMean | Self::InverseDepthDeviation | Self::Coverage)
    }

    /// Returns the name on the command line and in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        LayerChoice::Raw(self).name()
    }
}

impl Output {
    /// Those of the raw image of a plenoptic camera: all of them without a request.
    pub(crate) const RAW: [Self; 4] = [Self::Raw, Self::RawPng, Self::White, Self::Centers];

    /// Whether it belongs to the raw image of a plenoptic camera.
    pub(crate) fn is_raw(self) -> bool {
        Self::RAW.contains(&self)
    }
}

/// Parses a number of samples: a whole one, or one in 2 to 64 pixels as `1/16` or `0.0625`.
fn samples(text: &str) -> Result<SamplesPerPixel, Malformed> {
    let bad = || -> Malformed { "give an integer from 1 to 65536, or 1/2, 1/4, 1/8, 1/16, 1/32 or 1/64".into() };
    if let Ok(whole) = within(text, 1..=65_536) {
        return Ok(whole.into());
    }
    let pixels = match text.split_once('/') {
        Some((one, pixels)) if one.trim() == "1" => pixels.trim().parse().map_err(|_| bad())?,
        Some(_) => return Err(bad()),
        None => {
            let inverse = text.parse().map(|samples: f64| 1.0 / samples).map_err(|_| bad())?;
            if !(1.5..=64.0).contains(&inverse) || inverse.fract() != 0.0 {
                return Err(bad());
            }
            inverse as u32
        }
    };
    SamplesPerPixel::one_in(pixels).ok_or_else(bad)
}

/// Parses a number of bounces.
pub(super) fn bounces(text: &str) -> Result<u32, Malformed> {
    within(text, 1..=65_536)
}

/// Parses a number of positions of a microlens array along an axis.
pub(super) fn lens_shifts(text: &str) -> Result<u32, Malformed> {
    within(text, 1..=64)
}

fn within(text: &str, range: std::ops::RangeInclusive<u32>) -> Result<u32, Malformed> {
    let (least, most) = (range.start(), range.end());
    text.parse()
        .ok()
        .filter(|count| range.contains(count))
        .ok_or_else(|| format!("give an integer from {least} to {most}").into())
}

/// Parses a bit depth, 8 or 16.
pub(super) fn bit_depth(text: &str) -> Result<u8, Malformed> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("give 8 or 16".into()),
    }
}

impl FromStr for Shard {
    type Err = Malformed;

    /// Parses `K/N`, part K of N, counted from 1.
    fn from_str(text: &str) -> Result<Self, Malformed> {
        let parsed = text.split_once('/').and_then(|(part, of)| Some((part.parse().ok()?, of.parse().ok()?)));
        match parsed {
            Some((part, of)) if (1..=of).contains(&part) => Ok(Self { part, of }),
            _ => Err("write K/N, such as 2/3: part 2 of 3, counted from 1".into()),
        }
    }
}

impl SettingType for Sensor {
    const KIND: Kind = Kind::Other("str | tuple[int, int]");

    fn parse(text: &str) -> Result<Self, Malformed> {
        let name = text.to_ascii_lowercase();
        match SENSORS.iter().find(|(_, known)| *known == name) {
            Some((sensor, _)) => Ok(*sensor),
            // One size has one form.
            None if name.contains('x') => GridSize::parse(&name).map(|size| {
                let named = SENSORS.iter().find(|(known, _)| known.size() == size);
                named.map_or(Self::Other(size), |(known, _)| *known)
            }),
            None => Err("give hd, 4k, 8k, uhd8k or WIDTHxHEIGHT, such as 1500x1000".into()),
        }
    }

    fn value(&self) -> ManifestValue {
        match (self, SENSORS.iter().find(|(known, _)| known == self)) {
            (Self::Other(size), _) => (*size).into(),
            (_, Some((_, name))) => (*name).into(),
            (known, None) => known.size().into(),
        }
    }
}

impl SettingType for SensorName {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str) -> Result<Self, Malformed> {
        SensorPreset::by_name(text).map(|preset| Self(preset.name)).ok_or_else(|| {
            let names: Vec<&str> = holo_core::sensor::sensor_presets().iter().map(|preset| preset.name).collect();
            format!("there is no sensor '{text}'; they are {}", names.join(", ")).into()
        })
    }

    fn value(&self) -> ManifestValue {
        self.0.into()
    }
}

impl SettingType for SamplesPerPixel {
    const KIND: Kind = Kind::Other("int | float | str");

    fn parse(text: &str) -> Result<Self, Malformed> {
        samples(text)
    }

    fn value(&self) -> ManifestValue {
        number_of_samples(*self)
    }
}

/// Returns a number of samples per pixel for a manifest: an integer, or a number below 1.
pub(crate) fn number_of_samples(samples: SamplesPerPixel) -> ManifestValue {
    if samples.is_fraction() { samples.as_f64().into() } else { samples.of_traced().into() }
}

impl SettingType for Frames {
    const KIND: Kind = Kind::Other("int | str");

    /// Parses `N` or `A-B`, both ends included.
    fn parse(text: &str) -> Result<Self, Malformed> {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        match (first.parse(), last.parse()) {
            (Ok(first), Ok(last)) if first <= last && last <= MAX_FRAME => Ok(Self { first, last }),
            _ => {
                Err(format!("give the number of a frame, or A-B from the first to the last, up to {MAX_FRAME}").into())
            }
        }
    }

    fn value(&self) -> ManifestValue {
        match self.single() {
            Some(frame) => frame.into(),
            None => format!("{}-{}", self.first, self.last).into(),
        }
    }
}

impl SettingType for ViewSubset {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str) -> Result<Self, Malformed> {
        text.parse()
    }

    fn value(&self) -> ManifestValue {
        self.to_string().into()
    }
}

impl SettingType for Sky {
    const KIND: Kind = Kind::Other("str | float | tuple[float, float, float] | os.PathLike[str]");

    /// Parses `auto`, `R,G,B`, one number for gray, or the path of an image. A manifest has the word `map` instead of the
    /// path.
    fn parse(text: &str) -> Result<Self, Malformed> {
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

    fn value(&self) -> ManifestValue {
        match self {
            Self::Automatic => AUTO.into(),
            // The shortest text of an f32 has the same bits.
            Self::Constant(rgb) => ManifestValue::List(rgb.map(|c| ManifestValue::Float(shortest(c))).to_vec()),
            Self::Map(_) => MAP.into(),
        }
    }
}

/// The f64 that is written as the f32 is.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// Linear RGB, each from 0 up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color(pub [f32; 3]);

impl From<[f32; 3]> for Color {
    fn from(rgb: [f32; 3]) -> Self {
        Self(rgb)
    }
}

impl SettingType for Color {
    const KIND: Kind = Kind::Other("tuple[float, float, float] | float | str");

    /// Parses `R,G,B`, or one number for gray.
    fn parse(text: &str) -> Result<Self, Malformed> {
        match Sky::parse(text) {
            Ok(Sky::Constant(rgb)) => Ok(Self(rgb)),
            _ => Err("give three numbers from 0 up, R,G,B, or one for gray".into()),
        }
    }

    fn value(&self) -> ManifestValue {
        Sky::Constant(self.0).value()
    }
}

/// A point or a direction in the world of a scene, (x, y, z); a point in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub [f64; 3]);

impl From<[f64; 3]> for Point {
    fn from(point: [f64; 3]) -> Self {
        Self(point)
    }
}

impl SettingType for Point {
    const KIND: Kind = Kind::Other("tuple[float, float, float] | str");

    /// Parses `X,Y,Z`.
    fn parse(text: &str) -> Result<Self, Malformed> {
        let number = |part: &str| part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let parts: Option<Vec<f64>> = text.split(',').map(number).collect();
        parts.and_then(|parts| parts.try_into().ok()).map(Self).ok_or_else(|| "write X,Y,Z, such as 0,1.5,-2".into())
    }

    fn value(&self) -> ManifestValue {
        ManifestValue::List(self.0.map(ManifestValue::Float).to_vec())
    }
}

/// Parses an angle of view in degrees.
pub(super) fn angle_deg(text: &str) -> Result<f64, Malformed> {
    let angle = text.parse::<f64>().ok().filter(|angle| *angle > 0.0 && *angle < 180.0);
    angle.ok_or_else(|| "give degrees above 0 and below 180".into())
}

impl SettingType for Focus {
    const KIND: Kind = Kind::Other("str | float");

    /// Parses `auto`, `inf` or a distance in meters.
    fn parse(text: &str) -> Result<Self, Malformed> {
        match text {
            AUTO => Ok(Self::Automatic),
            "inf" => Ok(Self::Meters(f64::INFINITY)),
            other => positive(other).map(Self::Meters).map_err(|_| "give meters above 0, inf or auto".into()),
        }
    }

    fn value(&self) -> ManifestValue {
        match self {
            Self::Automatic => AUTO.into(),
            Self::Meters(distance) => (*distance).into(),
        }
    }
}

impl SettingType for Exposure {
    const KIND: Kind = Kind::Other("str | float");

    /// Parses `auto` or an exposure compensation in EV.
    fn parse(text: &str) -> Result<Self, Malformed> {
        match text {
            AUTO => Ok(Self::Automatic),
            other => match other.parse::<f64>() {
                Ok(ev) if ev.abs() <= 100.0 => Ok(Self::Ev(ev)),
                _ => Err("give an EV between -100 and 100, or auto".into()),
            },
        }
    }

    fn value(&self) -> ManifestValue {
        match self {
            Self::Automatic => AUTO.into(),
            Self::Ev(ev) => (*ev).into(),
        }
    }
}
