//! Camera files: a plenoptic camera as TOML.
//!
//! ```toml
//! name = "bench camera"
//! # preset = "lytro-illum"           # then only what differs
//! # approximate = true               # some numbers are guesses
//! [sensor]
//! size_px = [560, 420]               # columns, rows
//! pixel_um = 5.0
//! fill = 1.0                         # side of the light-sensitive square of a pixel
//! offset_um = [0.0, 0.0]             # middle of the sensor from the axis, right and up in the image
//! model = "imx250"                   # a sensor with noise, for `holo develop`; then only what differs
//! cfa = "GRBG"                       # RGGB, BGGR, GBRG, "mono", "rgb"
//! bits = 12
//! black = 64.0                       # the code of no light
//! full_well_e = 11000.0              # electrons
//! read_noise_e = 2.3
//! dark_current_e_s = 2.0
//! prnu = 0.005                       # relative
//! dsnu_e = 1.0
//! hot_share = 1e-5
//! row_noise_e = 0.0
//! column_noise_e = 0.0
//! dn_per_e = 0.366                   # codes an electron at base_iso; left out: the full well is the largest code
//! base_iso = 100.0
//! quantum_efficiency = 0.65
//! color_matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]  # sRGB from balanced camera RGB
//! white_balance = [1.4, 1.0, 1.2]
//! electrons_at_one = "auto"          # a number, { luminance_cd_m2 = 1000.0, exposure_s = 0.01 }
//! [mla]
//! grid = "square"                    # hex-rows, hex-columns
//! pitch_um = 70.85
//! scale_y = 1.0
//! rotation_deg = 0.11                # counterclockwise in the image
//! offset_um = [7.0, -4.0]
//! gap_um = 400.0                     # from the array to the sensor
//! focal_um = [400.0]                 # one to three; "pupil" images the exit pupil onto the sensor
//! aperture = { shape = "square", width_um = 70.85 }   # round, hexagon
//! gaps = "opaque"                    # clear: light passes between the microlenses
//! tilt_deg = [0.0, 0.0]              # the gap grows to the right and up
//! [main_lens]
//! focal_mm = 40.0
//! f_number = 5.5
//! aperture = "round"                 # square, { blades = 7, rotation_deg = 10.0 }
//! exit_pupil_mm = 60.0               # from the array; left out: in the lens
//! focus_m = 0.5                      # or mla_distance_mm
//! focus_virtual_depth = 0.0          # focused cameras: where the image of focus_m lies, in gaps behind the array
//! stops = [{ distance_mm = 25.0, diameter_mm = 14.0 }]  # further ones, in front of the lens
//! # instead of focal_mm, f_number, aperture, exit_pupil_mm, stops and distortion, a lens of glass: a file beside this one
//! # (.toml, .csv, .dat, .zmx, .json), an objective (double-gauss, petzval, retrofocus, telephoto, tessar, ..), or its surfaces
//! # as [[main_lens.surface]]; mla_distance_mm then counts from the last surface
//! # prescription = "double-gauss"
//! # scale_to_focal_mm = 80.0         # all lengths of the prescription scaled
//! # close_to_f_number = 4.0          # its stop closed
//! # focus_group = [8, 11]            # the surfaces that move to focus at focus_m; left out: the whole lens does
//! distortion = { radial_m2 = [0.0, 0.0, 0.0], tangential_m = [0.0, 0.0] }  # of places on the array, in 1/m^2, 1/m^4, 1/m^6
//! ```
//!
//! Left out, `fill` and `scale_y` are 1, offsets, rotation and tilt 0, gaps opaque, stops and distortion none, `focal_um` is the gap, microlenses are round and touch each
//! other, the main aperture is round and its pupil lies in the lens.

use std::fmt::Write as _;
use std::path::Path;

use holo_core::meters_to_millimeters;
use holo_core::plenoptic::{
    ArrayFocus, FocusGroup, LensAperture, MainLens, MicrolensFocus, PlenopticCamera, Preset, PupilShape, presets,
};
use holo_core::sensor::{ElectronsAtOne, SensorModel, SensorPreset};
use prescription::{Beside, surface_lines};
use sensor_table::{SensorTable, noise_lines};
use serde::Deserialize;
use tables::{MainLensTable, MlaTable, grid_name, um};

use crate::files::limits::read_small_file;
use crate::interop::Libpleno;
use crate::{Error, Folder};

pub(crate) mod checks;
mod prescription;
mod sensor_table;
pub(crate) mod tables;

pub use prescription::read_prescription;

/// The largest camera file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The smallest similarity of a key to one that is suggested instead.
const SIMILAR: f64 = 0.6;

/// Keys of the design of a camera that are not supported yet.
const LATER: [(&str, &str); 1] = [("storage", "raw images are stored upright")];

/// A camera with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraFile {
    /// The name; that of the preset if the file has none.
    pub name: String,
    /// The camera.
    pub camera: PlenopticCamera,
    /// Whether some numbers are guesses: as the file says it, else as its preset.
    pub is_approximate: bool,
    /// The noise of its sensor, if the file or its preset describe that.
    pub sensor_noise: Option<SensorNoise>,
}

/// The sensor of a camera, and how much light it gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// The name of the [`SensorPreset`] that the numbers come from, with those of the file in place of its own.
    pub preset: Option<&'static str>,
    /// The sensor.
    pub model: SensorModel,
    /// The electrons of a raw value of 1.
    pub electrons_at_one: ElectronsAtOne,
}

impl SensorNoise {
    /// A preset with the exposure found from the image.
    fn of(preset: &'static SensorPreset) -> Self {
        Self { preset: Some(preset.name), model: preset.model, electrons_at_one: ElectronsAtOne::Automatic }
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct Document {
    name: Option<String>,
    preset: Option<String>,
    approximate: Option<bool>,
    sensor: SensorTable,
    mla: MlaTable,
    main_lens: MainLensTable,
}

impl CameraFile {
    /// Reads a camera file, or the `intrinsics.js` of a program on libpleno, such as COMPOTE. A lens that it names lies in
    /// its folder, behind no link.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read; [`Error::Broken`] if it is no TOML or no camera. The message names the key.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let bytes = read_small_file(path, MAX_BYTES)?;
        Self::decode(&bytes, path, Beside::File(path))
    }

    /// Reads a camera file of an open folder, like [`CameraFile::read`].
    ///
    /// # Errors
    /// Those of [`CameraFile::read`] and [`Folder::open_regular`].
    pub fn read_in(folder: &Folder, name: &str) -> Result<Self, Error> {
        Self::decode(&folder.read(name, MAX_BYTES)?, &folder.path_of(name), Beside::Folder(folder))
    }

    fn decode(bytes: &[u8], path: &Path, beside: Beside) -> Result<Self, Error> {
        let broken = |what: String| Error::Broken { path: path.into(), format: "camera", what };
        let text = std::str::from_utf8(bytes).map_err(|_| broken("it is not text in UTF-8".into()))?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        if path.extension().is_some_and(|extension| extension == "js") {
            let camera = Libpleno::read(text).map_err(broken)?;
            return Ok(Self { name: stem, camera, is_approximate: false, sensor_noise: None });
        }
        Self::parsed(text, &stem, beside).map_err(broken)
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
        let sensor = preset.sensor.and_then(SensorPreset::by_name);
        let sensor_noise = sensor.map(SensorNoise::of);
        Some(Self { name: name.into(), camera, is_approximate: preset.is_approximate, sensor_noise })
    }

    /// Parses the text of a camera file; `name` is that of a camera without one. A prescription is one of its own, or an
    /// objective by its name.
    ///
    /// # Errors
    /// [`Error::Camera`] with the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, Error> {
        Self::parsed(text, name, Beside::Nowhere).map_err(Error::Camera)
    }

    fn parsed(text: &str, name: &str, beside: Beside) -> Result<Self, String> {
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
        let lens = document.main_lens.lens(base, beside)?;
        let camera = PlenopticCamera::new(sensor, array, lens).map_err(|why| keyed(&why, &document.main_lens))?;
        let noise = document.sensor.noise(preset.as_ref().and_then(|preset| preset.sensor_noise.as_ref()))?;
        let name = document.name.or(document.preset).unwrap_or_else(|| name.to_owned());
        let is_approximate = document.approximate.or(preset.map(|preset| preset.is_approximate));
        Ok(Self { name, camera, is_approximate: is_approximate.unwrap_or(false), sensor_noise: noise })
    }

    /// Returns the camera focused at another depth, in meters.
    ///
    /// # Errors
    /// [`Error::Camera`] if the lens cannot be focused there.
    pub fn with_focus_m(self, depth_m: f64) -> Result<Self, Error> {
        let lens = self.camera.main_lens().with_focus(depth_m);
        let lens = lens.map_err(|why| Error::Camera(format!("main_lens.focus_group: {why}")))?;
        self.with_lens(lens)
    }

    /// Returns the camera with another f-number: a lens of glass with its stop closed to it.
    ///
    /// # Errors
    /// [`Error::Camera`] if it is not above 0, or below that of an open lens of glass.
    pub fn with_f_number(self, f_number: f64) -> Result<Self, Error> {
        let lens = self.camera.main_lens().with_f_number(f_number);
        let lens = lens.map_err(|why| Error::Camera(format!("main_lens.f_number: {why}")))?;
        self.with_lens(lens)
    }

    fn with_lens(self, lens: MainLens) -> Result<Self, Error> {
        let camera = PlenopticCamera::new(*self.camera.sensor(), self.camera.array().clone(), lens);
        let camera = camera.map_err(|why| Error::Camera(keyed(&why, &MainLensTable::default())))?;
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
            line(
                "approximate",
                "true # the maker did not publish some values of this camera; they are estimates".into(),
            );
        }
        line("\n[sensor]\nsize_px", format!("[{}, {}]", sensor.size.columns, sensor.size.rows));
        line("pixel_um", format!("{:?}", um(sensor.pixel_m)));
        line("fill", format!("{:?}", sensor.fill));
        line("offset_um", pair(sensor.offset_m));
        if let Some(noise) = &self.sensor_noise {
            text += &noise_lines(noise);
        }
        let mut line = |key: &str, value: String| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{key} = {value}");
        };
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
        line("gaps", if array.has_clear_gaps { "\"clear\"" } else { "\"opaque\"" }.into());
        line("tilt_deg", format!("{:?}", array.tilt_rad.map(f64::to_degrees)));
        text += "\n[main_lens]\n";
        text += &lens_lines(lens);
        text
    }
}

/// The lines of a main lens.
fn lens_lines(lens: &MainLens) -> String {
    let mut text = String::new();
    let mut line = |key: &str, value: String| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{key} = {value}");
    };
    if lens.prescription.is_none() {
        line("focal_mm", format!("{:?}", meters_to_millimeters(lens.focal_length_m)));
        line("f_number", format!("{:?}", lens.f_number));
        let aperture = match lens.aperture {
            PupilShape::Round => "\"round\"".into(),
            PupilShape::Square => "\"square\"".into(),
            PupilShape::Polygon { blades, rotation_rad } => {
                format!("{{ blades = {blades}, rotation_deg = {:?} }}", rotation_rad.to_degrees())
            }
        };
        line("aperture", aperture);
        if let Some(exit_m) = lens.exit_pupil_m {
            line("exit_pupil_mm", format!("{:?}", meters_to_millimeters(exit_m)));
        }
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
    if !lens.stops.is_empty() {
        let millimeters = |meters: f64| format!("{:?}", meters_to_millimeters(meters));
        let stops = lens.stops.iter().map(|stop| {
            let (distance, diameter) = (millimeters(stop.distance_m), millimeters(stop.diameter_m));
            format!("{{ distance_mm = {distance}, diameter_mm = {diameter} }}")
        });
        line("stops", format!("[{}]", stops.collect::<Vec<_>>().join(", ")));
    }
    if !lens.distortion.is_none() {
        let (radial, tangential) = (lens.distortion.radial, lens.distortion.tangential);
        line("distortion", format!("{{ radial_m2 = {radial:?}, tangential_m = {tangential:?} }}"));
    }
    if let Some(FocusGroup { surfaces: [first, last], .. }) = &lens.focus_group {
        line("focus_group", format!("[{}, {}]", first + 1, last + 1));
    }
    let prescription = lens.focus_group.as_ref().map(|group| &group.at_infinity);
    if let Some(prescription) = prescription.or(lens.prescription.as_ref()) {
        text += &surface_lines(prescription.surfaces(), "main_lens.surface");
    }
    text
}

/// A basic string of TOML, whose escapes are those of JSON.
fn toml_string(text: &str) -> String {
    // The one control character that JSON takes and TOML does not.
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007f")
}

/// An error of the camera with the key that it is about.
fn keyed(why: &holo_core::Error, lens: &MainLensTable) -> String {
    const KEYS: [(&str, &str); 22] = [
        ("radius of the micro-images", "main_lens.f_number"),
        ("number of micro-images", "main_lens.f_number"),
        ("of a stop", "main_lens.stops"),
        ("diameter of a stop", "main_lens.stops"),
        ("distortion", "main_lens.distortion"),
        ("tilt", "mla.tilt_deg"),
        ("blades of the aperture", "main_lens.aperture.blades"),
        ("rotation of the aperture", "main_lens.aperture.rotation_deg"),
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
pub(crate) fn explained(why: &toml::de::Error) -> String {
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
