//! From linear light to the codes of an image sensor, and from a mosaic of codes to color.

use std::fs;
use std::path::{Path, PathBuf};

use holo_core::color::Srgb8Encoder;
use holo_core::sensor::{Demosaic, ElectronsAtOne, Exposure, SensorModel, SensorPreset, demosaic};
use holo_core::{ColorEncoding, DynImage};
use holo_io::{CameraFile, Compression, ExrChannel, Limits, MosaicInfo, hash_file};
use ndarray::{Array3, ArrayView3, Axis};

use super::linear_image::read_linear;
use crate::Error;
use crate::output::raw::lit_white_image;
use crate::settings::{SensorName, SettingType};

/// The electrons of a full well that a dark frame is named with: it has no light.
const NO_LIGHT: f64 = 1.0;

/// A file that [`DevelopJob`] writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DevelopOutput {
    /// `NAME.png`: the codes, in 16 bits.
    Png,
    /// `NAME.dng`: the codes with what raw converters need; of a mosaic only.
    Dng,
    /// `NAME_clean.png`: the codes without noise.
    Clean,
    /// `NAME_rgb.png`: the image without mosaic and noise, 8 bits on the sRGB curve; saturation is white.
    Rgb,
}

impl DevelopOutput {
    /// All outputs.
    pub const ALL: [Self; 4] = [Self::Png, Self::Dng, Self::Clean, Self::Rgb];

    /// Returns the name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Dng => "dng",
            Self::Clean => "clean",
            Self::Rgb => "rgb",
        }
    }
}

/// An image that a sensor is exposed to.
#[derive(Clone, Debug)]
pub struct DevelopJob {
    /// The image in linear light: the raw image of a plenoptic camera, an elemental image array, a view, a white image.
    pub input: PathBuf,
    /// The camera, whose file may describe a sensor.
    pub camera: Option<CameraFile>,
    /// The name of a sensor, instead of that of the camera.
    pub sensor: Option<String>,
    /// The electrons of value 1, instead of those of the camera file.
    pub electrons_at_one: Option<ElectronsAtOne>,
    /// Film speed; `None`: that without gain.
    pub iso: Option<f64>,
    /// Exposure time, s, for dark current.
    pub time_s: Option<f64>,
    /// The camera, of several of one kind: its fixed pattern depends on it.
    pub camera_seed: u64,
    /// The seed of the noise.
    pub seed: u64,
    /// The number of the frame.
    pub frame: u64,
    /// The frames to take the mean of.
    pub frames: u64,
    /// Whether the shutter stays closed.
    pub is_dark: bool,
    /// What to write; `None`: everything that the sensor has.
    pub outputs: Option<Vec<DevelopOutput>>,
}

/// What was developed.
#[derive(Clone, Debug)]
pub struct Developed {
    /// Sensor and exposure.
    pub info: MosaicInfo,
    /// The share of the codes that are the largest one.
    pub saturated: f64,
    /// The files.
    pub files: Vec<PathBuf>,
}

impl DevelopJob {
    /// A job with the sensor of the camera file at its base film speed.
    #[must_use]
    pub fn new(input: PathBuf) -> Self {
        Self {
            input,
            camera: None,
            sensor: None,
            electrons_at_one: None,
            iso: None,
            time_s: None,
            camera_seed: 0,
            seed: 0,
            frame: 0,
            frames: 1,
            is_dark: false,
            outputs: None,
        }
    }

    /// Develops into `out`, whose extension is `.png` or `.dng`, and the files beside it, with a JSON file of sensor and
    /// exposure.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if there is no sensor or no output, an output is impossible with it, or the input would be
    /// overwritten; [`Error::Core`] for numbers out of range; [`Error::Io`] if files cannot be read or written.
    pub fn run(&self, out: &Path) -> Result<Developed, Error> {
        let (name, guesses, sensor, electrons) = self.sensor()?;
        let outputs = self.outputs(&sensor)?;
        let stem = stem(out)?;
        let path = |ending: &str| out.with_file_name(format!("{stem}{ending}"));
        let of = |output: DevelopOutput| match output {
            DevelopOutput::Png => path(".png"),
            DevelopOutput::Dng => path(".dng"),
            DevelopOutput::Clean => path("_clean.png"),
            DevelopOutput::Rgb => path("_rgb.png"),
        };
        let mut files: Vec<PathBuf> = outputs.iter().map(|&output| of(output)).collect();
        files.push(path(".json"));
        keeps(&self.input, &files)?;
        let mut image = read_linear(&self.input)?;
        if self.is_dark {
            image.fill(0.0);
        }
        let exposure = self.exposure(&sensor, electrons, image.view())?;
        let codes = sensor.expose(image.view(), &exposure, self.frames)?;
        let linear = |path: &Path, codes: &Array3<u16>| {
            holo_io::write_png(path, codes.view(), ColorEncoding::Linear, Compression::Fast)
        };
        for output in outputs {
            let path = of(output);
            match output {
                DevelopOutput::Png => linear(&path, &codes)?,
                DevelopOutput::Dng => holo_io::write_dng(&path, codes.index_axis(Axis(2), 0), &sensor, &name)?,
                DevelopOutput::Clean => linear(&path, &sensor.expose_without_noise(image.view(), &exposure)?)?,
                DevelopOutput::Rgb => {
                    // Saturation is white.
                    let scale = (exposure.electrons_at_one / sensor.saturation_e(exposure.iso)) as f32;
                    let encoder = Srgb8Encoder::get();
                    let rgb = image.mapv(|value| encoder.encode(value * scale));
                    holo_io::write_png(&path, rgb.view(), ColorEncoding::Srgb, Compression::Fast)?
                }
            };
        }
        let white = sensor.white();
        let saturated = codes.iter().filter(|&&code| code == white).count() as f64 / codes.len() as f64;
        let mut info = MosaicInfo::new(&name, &guesses, sensor, exposure);
        (info.frames, info.input_sha256) = (self.frames, hash_file(&self.input)?.sha256.to_string());
        info.write(path(".json"))?;
        Ok(Developed { info, saturated, files })
    }

    /// The codes of an image in memory, axes (row, column, channel), and what they were made with. The input of the job is
    /// not read, and nothing is written.
    ///
    /// # Errors
    /// As [`run`](Self::run), without those of files.
    pub fn expose(&self, image: ArrayView3<f32>) -> Result<(Array3<u16>, MosaicInfo), Error> {
        let (name, guesses, sensor, electrons) = self.sensor()?;
        let dark = self.is_dark.then(|| Array3::zeros(image.dim()));
        let image = dark.as_ref().map_or(image, |dark| dark.view());
        let exposure = self.exposure(&sensor, electrons, image)?;
        let codes = sensor.expose(image, &exposure, self.frames)?;
        let mut info = MosaicInfo::new(&name, &guesses, sensor, exposure);
        info.frames = self.frames;
        Ok((codes, info))
    }

    /// Name, guesses, sensor, and electrons.
    fn sensor(&self) -> Result<(String, String, SensorModel, ElectronsAtOne), Error> {
        let of_file = self.camera.as_ref().and_then(|camera| camera.sensor_noise.as_ref().map(|noise| (camera, noise)));
        let electrons = of_file.map_or(ElectronsAtOne::Automatic, |(_, noise)| noise.electrons_at_one);
        let electrons = self.electrons_at_one.unwrap_or(electrons);
        if let Some(name) = &self.sensor {
            let preset = SensorPreset::by_name(name).ok_or_else(|| unknown(name))?;
            return Ok((name.clone(), preset.guesses.into(), preset.model, electrons));
        }
        match of_file {
            Some((camera, noise)) => {
                let guesses = if camera.is_approximate { "some numbers of the camera file" } else { "" };
                let preset = noise.preset.and_then(SensorPreset::by_name);
                let guesses = preset.map_or(guesses, |preset| preset.guesses);
                Ok((camera.name.clone(), guesses.into(), noise.model, electrons))
            }
            None => Err(Error::BadRequest(
                "no sensor: give `sensor-model`, or a `camera-file` whose [sensor] has bits, cfa and full_well_e"
                    .into(),
            )),
        }
    }

    fn outputs(&self, sensor: &SensorModel) -> Result<Vec<DevelopOutput>, Error> {
        let has_mosaic = sensor.filter.mosaic().is_some();
        let Some(outputs) = &self.outputs else {
            let is_possible = |output: &DevelopOutput| has_mosaic || *output != DevelopOutput::Dng;
            return Ok(DevelopOutput::ALL.into_iter().filter(is_possible).collect());
        };
        if outputs.is_empty() {
            return Err(Error::BadRequest("`write` names no file; without it everything is written".into()));
        }
        if outputs.contains(&DevelopOutput::Dng) && !has_mosaic {
            let name = sensor.filter.name();
            return Err(Error::BadRequest(format!(
                "`write dng` needs a Bayer mosaic, and this sensor is {name}; remove it, or change sensor.cfa"
            )));
        }
        Ok(outputs.clone())
    }

    fn exposure(
        &self,
        sensor: &SensorModel,
        electrons: ElectronsAtOne,
        image: ArrayView3<f32>,
    ) -> Result<Exposure, Error> {
        let iso = self.iso.unwrap_or(sensor.base_iso);
        let mut exposure = Exposure::new(NO_LIGHT, iso);
        exposure.electrons_at_one = match electrons {
            _ if self.is_dark => NO_LIGHT,
            ElectronsAtOne::Automatic => sensor.automatic_electrons(image, iso)?,
            ElectronsAtOne::Given(electrons) => electrons,
            ElectronsAtOne::Photometric { luminance_cd_m2, exposure_s, quantum_efficiency } => {
                exposure.time_s = exposure_s;
                let share = quantum_efficiency.unwrap_or(sensor.quantum_efficiency);
                let camera = self.camera.as_ref().ok_or_else(|| {
                    Error::BadRequest("a luminance needs the optics of a camera; give `camera-file`".into())
                })?;
                camera.camera.photometric_electrons(luminance_cd_m2, exposure_s, share)
            }
        };
        exposure.time_s = self.time_s.unwrap_or(exposure.time_s);
        (exposure.camera_seed, exposure.seed, exposure.frame) = (self.camera_seed, self.seed, self.frame);
        Ok(exposure)
    }
}

fn unknown(name: &str) -> Error {
    Error::BadRequest(SensorName::parse(name).err().map_or_else(String::new, |why| why.to_string()))
}

/// How a mosaic becomes color.
#[derive(Clone, Debug)]
pub enum DemosaicMethod {
    /// By neighboring pixels, wherever they lie.
    Plain(Demosaic),
    /// By neighboring pixels of the same micro-image of a camera, weighted with the white image.
    MicroImages(Box<CameraFile>),
}

/// Demosaics codes with the JSON file that [`DevelopJob`] wrote beside them, into linear sRGB: `out` is `.exr`, `.pfm`, or a
/// `.png` of 16 bits in linear light whose largest code is saturation. Values have the scale of the image that was exposed.
///
/// # Errors
/// [`Error::BadRequest`] for another extension, or if the input would be overwritten; [`Error::Core`] if the mosaic does not
/// fit the camera; [`Error::Io`] if files cannot be read or written.
pub fn write_demosaiced(mosaic: &Path, method: &DemosaicMethod, out: &Path) -> Result<MosaicInfo, Error> {
    let extension = out.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if !["exr", "pfm", "png"].contains(&extension.as_str()) {
        return Err(Error::BadRequest(format!("{}: end the name in .exr, .pfm or .png", out.display())));
    }
    keeps(mosaic, &[out.to_owned()])?;
    let info = MosaicInfo::read_for(mosaic)?;
    let codes = match holo_io::read_png(mosaic, &Limits::default())? {
        DynImage::U16(codes) => codes,
        _ => return Err(Error::Failed(format!("{}: codes have 16 bits", mosaic.display()))),
    };
    let filter = info.sensor.filter;
    if codes.dim().2 != filter.channels() {
        let what =
            format!("{}: {} channels, and the sensor has {}", mosaic.display(), codes.dim().2, filter.channels());
        return Err(Error::Failed(what));
    }
    let values = info.linear(codes.view());
    drop(codes);
    let camera_rgb = match method {
        _ if filter.channels() == 3 => values,
        DemosaicMethod::Plain(method) => demosaic(values.index_axis(Axis(2), 0), filter, *method)?,
        DemosaicMethod::MicroImages(file) => {
            let (size, found) = (file.camera.sensor().size, [values.dim().0, values.dim().1]);
            if found != [size.rows, size.columns] {
                let expected = vec![size.rows, size.columns];
                return Err(holo_core::Error::Shape { what: "mosaic", expected, found: found.to_vec() }.into());
            }
            let white = lit_white_image(file)?;
            file.camera.demosaic(values.index_axis(Axis(2), 0), white.view(), filter)?
        }
    };
    let rgb = info.sensor.rgb_from_camera(camera_rgb);
    match extension.as_str() {
        "exr" => {
            let planes = ["R", "G", "B"].iter().zip(rgb.axis_iter(Axis(2)));
            let channels: Vec<_> = planes.map(|(name, plane)| ExrChannel::float(name, plane)).collect();
            holo_io::write_exr(out, &channels)?
        }
        "pfm" => holo_io::write_pfm_rgb(out, rgb.view())?,
        _ => {
            let scale = 65_535.0 * info.exposure.electrons_at_one / info.sensor.saturation_e(info.exposure.iso);
            let codes = rgb.mapv(|value| (f64::from(value) * scale).round().clamp(0.0, 65_535.0) as u16);
            holo_io::write_png(out, codes.view(), ColorEncoding::Linear, Compression::Fast)?
        }
    };
    Ok(info)
}

fn stem(out: &Path) -> Result<String, Error> {
    let extension = out.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match out.file_stem() {
        Some(stem) if matches!(extension.as_str(), "png" | "dng") => Ok(stem.to_string_lossy().into_owned()),
        _ => Err(Error::BadRequest(format!("{}: end the name in .png or .dng", out.display()))),
    }
}

/// Checks that no output is the input.
fn keeps(input: &Path, files: &[PathBuf]) -> Result<(), Error> {
    let input_place = fs::canonicalize(input).ok();
    match files.iter().find(|file| input_place.is_some() && fs::canonicalize(file).ok() == input_place) {
        Some(file) => Err(Error::BadRequest(format!("{} is the input; choose another `out`", file.display()))),
        None => Ok(()),
    }
}
