//! Camera files: a plenoptic camera as TOML.
//!
//! ```toml
//! name = "bench camera"
//! # preset = "lytro-illum"           # then only what differs
//! [sensor]
//! size_px = [560, 420]               # columns, rows
//! pixel_um = 5.0
//! fill = 1.0                         # side of the light-sensitive square of a pixel
//! offset_um = [0.0, 0.0]             # middle of the sensor from the axis, right and up in the image
//! [mla]
//! grid = "square"                    # hex-rows, hex-columns
//! pitch_um = 70.85
//! scale_y = 1.0
//! rotation_deg = 0.11                # counterclockwise in the image
//! offset_um = [7.0, -4.0]
//! gap_um = 400.0                     # from the array to the sensor
//! focal_um = [400.0]                 # one to three; "pupil" images the exit pupil onto the sensor
//! aperture = { shape = "square", width_um = 70.85 }   # round, hexagon
//! [main_lens]
//! focal_mm = 40.0
//! f_number = 5.5
//! aperture = "round"                 # square
//! exit_pupil_mm = 60.0               # from the array; left out: in the lens
//! focus_m = 0.5                      # or mla_distance_mm
//! focus_virtual_depth = 0.0          # focused cameras: where the image of focus_m lies, in gaps behind the array
//! ```
//!
//! Left out, `fill` and `scale_y` are 1, offsets and rotation 0, `focal_um` is the gap, microlenses are round and touch each
//! other, the main aperture is round and its pupil lies in the lens.

use std::fmt::Write as _;
use std::path::Path;

use holo_core::plenoptic::{
    ArrayFocus, ImageSensor, LensAperture, MainLens, MicrolensArray, MicrolensFocus, MicrolensGrid, PlenopticCamera,
    Preset, PupilShape, presets,
};
use holo_core::{GridSize, meters_to_millimeters, millimeters_to_meters};
use serde::Deserialize;

use crate::Error;
use crate::limits::read_small_file;

/// The largest camera file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The smallest similarity of a key to one that is suggested instead.
const SIMILAR: f64 = 0.6;

/// Keys of the design of a camera that are not supported yet.
const LATER: [(&str, &str); 16] = [
    ("storage", "raw images are stored upright"),
    ("tilt_deg", "arrays are parallel to the sensor"),
    ("gaps", "arrays are opaque between the microlenses"),
    ("stops", "the pupil is the only stop"),
    ("distortion", "main lenses have no distortion"),
    ("cfa", "raw images are linear RGB without noise"),
    ("bits", "raw images are linear RGB without noise"),
    ("black", "raw images are linear RGB without noise"),
    ("full_well_e", "raw images are linear RGB without noise"),
    ("read_noise_e", "raw images are linear RGB without noise"),
    ("dark_current_e_s", "raw images are linear RGB without noise"),
    ("prnu", "raw images are linear RGB without noise"),
    ("dsnu_e", "raw images are linear RGB without noise"),
    ("hot_share", "raw images are linear RGB without noise"),
    ("electrons_at_one", "raw images are linear RGB without noise"),
    ("blades", "main apertures are round or square"),
];

/// A camera with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraFile {
    /// The name; that of the preset if the file has none.
    pub name: String,
    /// The camera.
    pub camera: PlenopticCamera,
    /// Whether some numbers are guesses, because those of the preset are not published.
    pub is_approximate: bool,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct Document {
    name: Option<String>,
    preset: Option<String>,
    sensor: SensorTable,
    mla: MlaTable,
    main_lens: MainLensTable,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct SensorTable {
    size_px: Option<[usize; 2]>,
    pixel_um: Option<f64>,
    fill: Option<f64>,
    offset_um: Option<[f64; 2]>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct MlaTable {
    grid: Option<String>,
    pitch_um: Option<f64>,
    scale_y: Option<f64>,
    rotation_deg: Option<f64>,
    offset_um: Option<[f64; 2]>,
    gap_um: Option<f64>,
    focal_um: Option<FocalLengths>,
    aperture: Option<ApertureTable>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected one to three numbers in mla.focal_um, or \"pupil\"")]
enum FocalLengths {
    Word(String),
    Lengths(Vec<f64>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ApertureTable {
    shape: String,
    width_um: f64,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct MainLensTable {
    focal_mm: Option<f64>,
    f_number: Option<f64>,
    aperture: Option<String>,
    exit_pupil_mm: Option<f64>,
    focus_m: Option<f64>,
    focus_virtual_depth: Option<f64>,
    mla_distance_mm: Option<f64>,
}

impl CameraFile {
    /// Reads a camera file.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read; [`Error::Broken`] if it is no TOML or no camera. The message names the key.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let bytes = read_small_file(path, MAX_BYTES)?;
        let broken = |what: String| Error::Broken { path: path.into(), format: "camera", what };
        let text = std::str::from_utf8(&bytes).map_err(|_| broken("it is not text in UTF-8".into()))?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Self::parse(text, &stem).map_err(broken)
    }

    /// Returns the camera of a file, or of the preset of this name.
    ///
    /// # Errors
    /// As [`CameraFile::read`]; [`Error::BadInput`] if there is neither.
    pub fn open(path_or_preset: &str) -> Result<Self, Error> {
        let path = Path::new(path_or_preset);
        if path.is_file() {
            return Self::read(path);
        }
        match Self::preset(path_or_preset) {
            Some(found) => Ok(found),
            None => {
                let names = presets().iter().map(|preset| preset.name);
                let advice = suggestion(path_or_preset, names.clone());
                let names = names.collect::<Vec<_>>().join(", ");
                let what = format!("neither a file nor a preset{advice}; the presets are {names}");
                Err(Error::BadInput { path: path.into(), what })
            }
        }
    }

    /// Returns the preset of this name; `None` for an unknown one.
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        let preset = Preset::by_name(name)?;
        let camera = preset.camera().ok()?;
        Some(Self { name: name.into(), camera, is_approximate: preset.is_approximate })
    }

    /// Parses the text of a camera file; `name` is that of a camera without one.
    ///
    /// # Errors
    /// A message that names the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, String> {
        let document: Document = toml::from_str(text).map_err(|why| explained(&why))?;
        let preset = match &document.preset {
            None => None,
            Some(preset) => Some(Self::preset(preset).ok_or_else(|| {
                let advice = suggestion(preset, presets().iter().map(|preset| preset.name));
                format!("preset: there is none called '{preset}'{advice}")
            })?),
        };
        let base = preset.as_ref().map(|preset| &preset.camera);
        let sensor = document.sensor.sensor(base)?;
        let array = document.mla.array(base)?;
        let lens = document.main_lens.lens(base)?;
        let camera = PlenopticCamera::new(sensor, array, lens).map_err(|why| keyed(&why, &document.main_lens))?;
        let name = document.name.or(document.preset).unwrap_or_else(|| name.to_owned());
        Ok(Self { name, camera, is_approximate: preset.is_some_and(|preset| preset.is_approximate) })
    }

    /// Returns the camera focused at another depth, in meters.
    ///
    /// # Errors
    /// A message, if the lens cannot be focused there.
    pub fn with_focus_m(self, depth_m: f64) -> Result<Self, String> {
        let mut lens = *self.camera.main_lens();
        let virtual_depth = match lens.focus {
            ArrayFocus::Depth { virtual_depth, .. } => virtual_depth,
            ArrayFocus::Distance { .. } => 0.0,
        };
        lens.focus = ArrayFocus::Depth { depth_m, virtual_depth };
        self.with_lens(lens)
    }

    /// Returns the camera with another f-number.
    ///
    /// # Errors
    /// A message, if it is not above 0.
    pub fn with_f_number(self, f_number: f64) -> Result<Self, String> {
        let lens = MainLens { f_number, ..*self.camera.main_lens() };
        self.with_lens(lens)
    }

    fn with_lens(self, lens: MainLens) -> Result<Self, String> {
        let camera = PlenopticCamera::new(*self.camera.sensor(), self.camera.array().clone(), lens);
        let camera = camera.map_err(|why| keyed(&why, &MainLensTable::default()))?;
        Ok(Self { camera, ..self })
    }

    /// Returns the text of a camera file with every key.
    ///
    /// # Accuracy
    /// Lengths in decimal digits as they were; the rotation to the rounding of degrees.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let (sensor, array, lens) = (self.camera.sensor(), self.camera.array(), self.camera.main_lens());
        let mut text = String::new();
        let pair = |pair: [f64; 2]| format!("[{:?}, {:?}]", um(pair[0]), um(pair[1]));
        let mut line = |key: &str, value: String| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{key} = {value}");
        };
        line("name", toml_string(&self.name));
        if self.is_approximate {
            line("# approximate", "some numbers of this camera are not published, and guesses".into());
        }
        line("\n[sensor]\nsize_px", format!("[{}, {}]", sensor.size.columns, sensor.size.rows));
        line("pixel_um", format!("{:?}", um(sensor.pixel_m)));
        line("fill", format!("{:?}", sensor.fill));
        line("offset_um", pair(sensor.offset_m));
        line("\n[mla]\ngrid", format!("\"{}\"", grid_name(array.grid)));
        line("pitch_um", format!("{:?}", um(array.pitch_m)));
        line("scale_y", format!("{:?}", array.scale_y));
        line("rotation_deg", format!("{:?}", array.rotation_rad.to_degrees()));
        line("offset_um", pair(array.offset_m));
        line("gap_um", format!("{:?}", um(array.gap_m)));
        line(
            "focal_um",
            match &array.focus {
                MicrolensFocus::Pupil => "\"pupil\"".into(),
                MicrolensFocus::Lengths(all) => format!("{:?}", all.iter().map(|&f| um(f)).collect::<Vec<_>>()),
            },
        );
        let shape = match array.aperture {
            LensAperture::Round { .. } => "round",
            LensAperture::Square { .. } => "square",
            LensAperture::Hexagon { .. } => "hexagon",
        };
        let width = um(2.0 * array.aperture.half_width_m());
        line("aperture", format!("{{ shape = \"{shape}\", width_um = {width:?} }}"));
        line("\n[main_lens]\nfocal_mm", format!("{:?}", meters_to_millimeters(lens.focal_length_m)));
        line("f_number", format!("{:?}", lens.f_number));
        let round = lens.aperture == PupilShape::Round;
        line("aperture", if round { "\"round\"" } else { "\"square\"" }.into());
        if let Some(exit_m) = lens.exit_pupil_m {
            line("exit_pupil_mm", format!("{:?}", meters_to_millimeters(exit_m)));
        }
        match lens.focus {
            ArrayFocus::Distance { mla_distance_m } => {
                line("mla_distance_mm", format!("{:?}", meters_to_millimeters(mla_distance_m)));
            }
            ArrayFocus::Depth { depth_m, virtual_depth } => {
                line("focus_m", format!("{depth_m:?}"));
                line("focus_virtual_depth", format!("{virtual_depth:?}"));
            }
        }
        text
    }
}

impl SensorTable {
    fn sensor(&self, base: Option<&PlenopticCamera>) -> Result<ImageSensor, String> {
        let base = base.map(PlenopticCamera::sensor);
        let size = match self.size_px {
            Some([columns, rows]) => GridSize::new(rows, columns),
            None => base.map(|base| base.size).ok_or_else(|| missing("sensor.size_px"))?,
        };
        let pixel_m = length("sensor.pixel_um", self.pixel_um, base.map(|base| base.pixel_m))?;
        let fill = positive("sensor.fill", self.fill.or(base.map(|base| base.fill)).unwrap_or(1.0))?;
        let offset_m = offset("sensor.offset_um", self.offset_um, base.map(|base| base.offset_m))?;
        Ok(ImageSensor { size, pixel_m, fill, offset_m })
    }
}

impl MlaTable {
    fn array(&self, base: Option<&PlenopticCamera>) -> Result<MicrolensArray, String> {
        let base = base.map(PlenopticCamera::array);
        let grid = match &self.grid {
            Some(name) => [MicrolensGrid::Square, MicrolensGrid::HexRows, MicrolensGrid::HexColumns]
                .into_iter()
                .find(|&grid| grid_name(grid) == name)
                .ok_or_else(|| format!("mla.grid is '{name}'; give square, hex-rows or hex-columns"))?,
            None => base.map(|base| base.grid).ok_or_else(|| missing("mla.grid"))?,
        };
        let pitch_m = length("mla.pitch_um", self.pitch_um, base.map(|base| base.pitch_m))?;
        let gap_m = length("mla.gap_um", self.gap_um, base.map(|base| base.gap_m))?;
        let mut array = MicrolensArray::new(grid, pitch_m, gap_m);
        array.scale_y = positive("mla.scale_y", self.scale_y.or(base.map(|base| base.scale_y)).unwrap_or(1.0))?;
        let degrees = self.rotation_deg.map(f64::to_radians).or(base.map(|base| base.rotation_rad));
        array.rotation_rad = finite("mla.rotation_deg", degrees.unwrap_or(0.0))?;
        array.offset_m = offset("mla.offset_um", self.offset_um, base.map(|base| base.offset_m))?;
        match (&self.focal_um, base) {
            (Some(FocalLengths::Word(word)), _) if word == "pupil" => array.focus = MicrolensFocus::Pupil,
            (Some(FocalLengths::Word(word)), _) => {
                return Err(format!("mla.focal_um is '{word}'; give one to three numbers, or \"pupil\""));
            }
            (Some(FocalLengths::Lengths(lengths)), _) => {
                if !(1..=3).contains(&lengths.len()) {
                    return Err(format!("mla.focal_um has {} numbers; give one to three", lengths.len()));
                }
                let lengths = lengths.iter().map(|&um| Ok(meters(positive("mla.focal_um", um)?)));
                array.focus = MicrolensFocus::Lengths(lengths.collect::<Result<_, String>>()?);
            }
            // With another gap, the focal lengths of the preset stay.
            (None, Some(base)) => array.focus = base.focus.clone(),
            (None, None) => {}
        }
        match (&self.aperture, base) {
            (Some(aperture), _) => {
                let half_width_m = meters(positive("mla.aperture.width_um", aperture.width_um)?) / 2.0;
                array.aperture = match aperture.shape.as_str() {
                    "round" => LensAperture::Round { radius_m: half_width_m },
                    "square" => LensAperture::Square { half_width_m },
                    "hexagon" => LensAperture::Hexagon { half_width_m },
                    other => return Err(format!("mla.aperture.shape is '{other}'; give round, square or hexagon")),
                };
            }
            (None, Some(base)) if self.pitch_um.is_none() => array.aperture = base.aperture,
            _ => {}
        }
        Ok(array)
    }
}

impl MainLensTable {
    fn lens(&self, base: Option<&PlenopticCamera>) -> Result<MainLens, String> {
        let base = base.map(PlenopticCamera::main_lens);
        let millimeters =
            |key: &str, value: Option<f64>| value.map(|mm| positive(key, mm).map(millimeters_to_meters)).transpose();
        let focal = millimeters("main_lens.focal_mm", self.focal_mm)?.or(base.map(|base| base.focal_length_m));
        let focal_length_m = focal.ok_or_else(|| missing("main_lens.focal_mm"))?;
        let f_number = self.f_number.or(base.map(|base| base.f_number));
        let f_number = positive("main_lens.f_number", f_number.ok_or_else(|| missing("main_lens.f_number"))?)?;
        let exit_pupil_m =
            millimeters("main_lens.exit_pupil_mm", self.exit_pupil_mm)?.or(base.and_then(|base| base.exit_pupil_m));
        let aperture = match self.aperture.as_deref() {
            None => base.map_or(PupilShape::Round, |base| base.aperture),
            Some("round") => PupilShape::Round,
            Some("square") => PupilShape::Square,
            Some(other) => return Err(format!("main_lens.aperture is '{other}'; give round or square")),
        };
        let virtual_depth = finite("main_lens.focus_virtual_depth", self.focus_virtual_depth.unwrap_or(0.0))?;
        let focus = match (self.focus_m, self.mla_distance_mm) {
            (Some(_), Some(_)) => {
                return Err("main_lens.focus_m and main_lens.mla_distance_mm: give one of them".into());
            }
            (None, Some(mm)) => {
                if self.focus_virtual_depth.is_some() {
                    return Err("main_lens.focus_virtual_depth belongs to main_lens.focus_m, which is not given".into());
                }
                let mla_distance_m = millimeters_to_meters(positive("main_lens.mla_distance_mm", mm)?);
                ArrayFocus::Distance { mla_distance_m }
            }
            (Some(depth_m), None) if depth_m.is_nan() || depth_m == 0.0 => {
                return Err(format!("main_lens.focus_m is {depth_m}; give meters, or inf"));
            }
            (Some(depth_m), None) => ArrayFocus::Depth { depth_m, virtual_depth },
            (None, None) => match (base.map(|base| base.focus), self.focus_virtual_depth) {
                (Some(ArrayFocus::Depth { depth_m, .. }), Some(virtual_depth)) => {
                    ArrayFocus::Depth { depth_m, virtual_depth }
                }
                (Some(focus), None) => focus,
                _ => return Err(missing("main_lens.focus_m (or main_lens.mla_distance_mm)")),
            },
        };
        Ok(MainLens { focal_length_m, f_number, focus, exit_pupil_m, aperture })
    }
}

fn missing(key: &str) -> String {
    format!("{key} is missing")
}

fn finite(key: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{key} is {value}; give a finite number")) }
}

fn positive(key: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(format!("{key} is {value}; give a number above 0")) }
}

/// Micrometers, or the length of a preset.
fn length(key: &str, um: Option<f64>, base_m: Option<f64>) -> Result<f64, String> {
    match (um, base_m) {
        (Some(um), _) => Ok(meters(positive(key, um)?)),
        (None, Some(base_m)) => Ok(base_m),
        (None, None) => Err(missing(key)),
    }
}

fn offset(key: &str, um: Option<[f64; 2]>, base_m: Option<[f64; 2]>) -> Result<[f64; 2], String> {
    match um {
        Some([x, y]) => Ok([meters(finite(key, x)?), meters(finite(key, y)?)]),
        None => Ok(base_m.unwrap_or_default()),
    }
}

fn meters(um: f64) -> f64 {
    millimeters_to_meters(millimeters_to_meters(um))
}

fn um(meters: f64) -> f64 {
    meters_to_millimeters(meters_to_millimeters(meters))
}

fn grid_name(grid: MicrolensGrid) -> &'static str {
    match grid {
        MicrolensGrid::Square => "square",
        MicrolensGrid::HexRows => "hex-rows",
        MicrolensGrid::HexColumns => "hex-columns",
    }
}

/// A basic string of TOML, whose escapes are those of JSON.
fn toml_string(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// An error of the camera with the key that it is about.
fn keyed(why: &holo_core::Error, lens: &MainLensTable) -> String {
    const KEYS: [(&str, &str); 14] = [
        ("sensor rows", "sensor.size_px"),
        ("sensor columns", "sensor.size_px"),
        ("number of microlenses", "mla.pitch_um"),
        ("half width of a microlens as", "mla.aperture.width_um"),
        ("half width", "mla.aperture.width_um"),
        ("vertical scale", "mla.scale_y"),
        ("fill factor", "sensor.fill"),
        ("f-number", "main_lens.f_number"),
        ("exit pupil", "main_lens.exit_pupil_mm"),
        ("focal length of the main lens", "main_lens.focal_mm"),
        ("pixel width", "sensor.pixel_um"),
        ("pitch", "mla.pitch_um"),
        ("gap", "mla.gap_um"),
        ("sensor", "sensor.size_px"),
    ];
    let text = why.to_string();
    // The distance follows from the focus, unless it is given.
    let focus = if lens.mla_distance_mm.is_some() { "main_lens.mla_distance_mm" } else { "main_lens.focus_m" };
    let is_focus = text.starts_with("the focus distance");
    let key = KEYS.iter().find(|(what, _)| !is_focus && text.contains(what)).map_or(focus, |(_, key)| key);
    format!("{key}: {text}")
}

/// An error of the TOML, with a suggestion for an unknown key.
fn explained(why: &toml::de::Error) -> String {
    let text = why.to_string();
    let message = why.message();
    let Some(rest) = message.strip_prefix("unknown field `") else { return text };
    let mut words = rest.split('`').step_by(2);
    let Some(key) = words.next() else { return text };
    if let Some((_, instead)) = LATER.iter().find(|(later, _)| *later == key) {
        return format!("{key} is not supported by this version: {instead}; remove it\n{text}");
    }
    let advice = suggestion(key, words);
    format!("{key} is not a key here{advice}\n{text}")
}

/// "; did you mean X?" for the most similar of some names, if any is similar.
fn suggestion<'a>(given: &str, names: impl Iterator<Item = &'a str>) -> String {
    let similarity = |name: &str| strsim::jaro_winkler(given, name);
    let best = names.map(|name| (similarity(name), name)).max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(similarity, _)| *similarity >= SIMILAR)
        .map_or(String::new(), |(_, name)| format!("; did you mean {name}?"))
}

#[cfg(test)]
mod tests;
