//! Images of Lytro's cameras: the containers `.lfp` and `.lfr`, and packed codes with their metadata beside them.
//!
//! There is no specification. The structure is that which LFToolbox, imageio and python-lfp-reader read: sections of a magic of 12
//! bytes, a length in big-endian order, a SHA-1 of 80 characters, data, and zeros. The section of kind `M`, the last in real files, is a
//! table in JSON that names the others by their SHA-1. Real metadata of both models was read; no real container
//! was at hand.

use std::path::{Path, PathBuf};

use holo_core::GridSize;
use holo_core::plenoptic::{ArrayFocus, MainLens, MicrolensArray, PlenopticCamera, Preset};
use holo_core::sensor::{ColorFilter, Exposure, SensorModel};
use ndarray::{Array2, Array3, Axis};
use serde_json::Value;

use super::LytroModel;
use crate::files::limits::read_small_file;
use crate::files::names::is_regular;
use crate::{Error, FileFormat, Limits, MosaicInfo, detect_format};

/// What a section begins with, but for its kind, the fourth byte.
const MAGIC: [u8; 8] = [0x89, b'L', b'F', 0, b'\r', b'\n', 0x1a, b'\n'];

/// The bytes of a header: magic, version, length; and of the SHA-1 with what fills it up.
const HEADER: usize = 16;
const NAME: usize = 80;

/// The kind of the section that names the others.
const TABLE: u8 = b'M';

/// The largest metadata, bytes.
const MAX_METADATA: u64 = 4 << 20;

/// The name of the format in messages.
const FORMAT: &str = "LFP";

/// An image of a Lytro camera.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LytroImage {
    /// The codes of the sensor behind its color filter, axes (row, column, 1).
    pub codes: Array3<u16>,
    /// The sensor; light is relative to its saturation.
    pub info: MosaicInfo,
    /// The camera, by the preset of its model with the numbers of the metadata: pitch, rotation, offset and gap of the array, focal
    /// length, f-number and exit pupil of the lens. At what it is focused, the metadata do not say.
    pub camera: PlenopticCamera,
    /// The name of its preset.
    pub preset: &'static str,
}

impl LytroImage {
    /// Returns whether a file is a container, or packed codes `.raw` with metadata beside them.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read.
    pub fn is_at(path: impl AsRef<Path>) -> Result<bool, Error> {
        let path = path.as_ref();
        Ok(detect_format(path)? == FileFormat::Lytro || metadata_beside(path).is_some())
    }

    /// Reads a container, or packed codes `NAME.raw` with `NAME.TXT`, `NAME.json` or `NAME_metadata.json` beside them.
    ///
    /// # Errors
    /// [`Error::Io`] if a file cannot be read; [`Error::Broken`] if it is damaged, or its metadata lack a number;
    /// [`Error::Unsupported`] for a container without codes, and other cameras; [`Error::TooLarge`] beyond the limits.
    pub fn read(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, Error> {
        let path = path.as_ref();
        let max_bytes = limits.max_bytes.min(1 << 32);
        match metadata_beside(path) {
            Some(metadata) => {
                let text = read_small_file(&metadata, MAX_METADATA)?;
                Self::of(path, &read_small_file(path, max_bytes)?, &metadata, &text, limits)
            }
            None => {
                let bytes = read_small_file(path, max_bytes)?;
                let [codes, metadata] = sections_of_frame(path, &bytes)?;
                Self::of(path, codes, path, metadata, limits)
            }
        }
    }

    /// Unpacks codes by their metadata.
    fn of(path: &Path, packed: &[u8], from: &Path, metadata: &[u8], limits: &Limits) -> Result<Self, Error> {
        let metadata = Metadata::parse(from, metadata)?;
        let (model, size) = (metadata.model()?, metadata.size()?);
        let bits = metadata.bits()?;
        limits.elements(path, "image", &[size.rows, size.columns], size_of::<u16>() + size_of::<f32>())?;
        let expected = (size.count() * usize::from(bits)).div_ceil(8);
        if packed.len() < expected {
            let what = format!("{} bytes of codes, and {size} pixels of {bits} bits have {expected}", packed.len());
            return Err(Error::Broken { path: path.to_owned(), format: FORMAT, what });
        }
        let mut codes = model.unpacked(packed);
        codes.truncate(size.count());
        let codes = Array3::from_shape_vec((size.rows, size.columns, 1), codes).map_err(|why| Error::Broken {
            path: path.to_owned(),
            format: FORMAT,
            what: why.to_string(),
        })?;
        let sensor = metadata.sensor(model)?;
        let saturation = Exposure::new(sensor.saturation_e(sensor.base_iso), sensor.base_iso);
        let exposure = Exposure { time_s: 0.0, ..saturation };
        let info = MosaicInfo::new(model.preset(), "exposure: relative to saturation", sensor, exposure);
        Ok(Self { codes, info, camera: metadata.camera(model, size)?, preset: model.preset() })
    }

    /// Returns the light of the pixels behind their filters, 1 at saturation, axes (row, column).
    #[must_use]
    pub fn mosaic(&self) -> Array2<f32> {
        self.info.linear(self.codes.view()).index_axis_move(Axis(2), 0)
    }

    /// Returns the light of a white image: the mosaic with every color at the same mean, axes (row, column).
    #[must_use]
    pub fn white(&self) -> Array2<f32> {
        let mut white = self.mosaic();
        let mut mean = |row: usize, column: usize, scale: f64| -> f64 {
            let mut pixels = white.slice_each_axis_mut(|axis| {
                let first = if axis.axis == Axis(0) { row } else { column };
                ndarray::Slice::new(first as isize, None, 2)
            });
            pixels.mapv_inplace(|value| (f64::from(value) * scale) as f32);
            pixels.iter().map(|value| f64::from(*value)).sum::<f64>() / pixels.len().max(1) as f64
        };
        let means = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(row, column)| mean(row, column, 1.0));
        let all = means.iter().sum::<f64>() / 4.0;
        for (k, own) in means.into_iter().enumerate().filter(|(_, own)| *own > 0.0) {
            mean(k / 2, k % 2, all / own);
        }
        white
    }
}

/// The metadata of packed codes.
fn metadata_beside(path: &Path) -> Option<PathBuf> {
    let is_raw = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("raw"));
    let stem = path.file_stem().filter(|_| is_raw)?.to_string_lossy();
    let names = [format!("{stem}.TXT"), format!("{stem}.txt"), format!("{stem}.json"), format!("{stem}_metadata.json")];
    names.into_iter().map(|name| path.with_file_name(name)).find(|path| is_regular(path))
}

/// The codes and the metadata of the first frame of a container.
fn sections_of_frame<'a>(path: &Path, bytes: &'a [u8]) -> Result<[&'a [u8]; 2], Error> {
    let broken = |what: String| Error::Broken { path: path.to_owned(), format: FORMAT, what };
    let mut sections: Vec<(u8, String, &[u8])> = Vec::new();
    let mut at = 0;
    while let Some(header) = bytes.get(at..at + HEADER) {
        if (0..8).any(|k| k != 3 && header[k] != MAGIC[k]) {
            // Some bytes follow the table of a F01.
            if sections.iter().any(|(kind, ..)| *kind == TABLE) {
                break;
            }
            return Err(broken(format!("no section begins at byte {at}")));
        }
        let length = u32::from_be_bytes([header[12], header[13], header[14], header[15]]) as usize;
        at += HEADER;
        if length > 0 {
            let end = at.saturating_add(NAME).saturating_add(length);
            let section = bytes.get(at..end).ok_or_else(|| {
                broken(format!("a section of {length} bytes ends behind the file, which has {} bytes", bytes.len()))
            })?;
            let (name, data) = section.split_at(NAME);
            let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
            sections.push((header[3], String::from_utf8_lossy(name).into_owned(), data));
            at = end + bytes[end..].iter().take_while(|byte| **byte == 0).count();
        }
    }
    let table = sections.iter().find(|(kind, ..)| *kind == TABLE).map(|(.., data)| *data);
    let table = table.ok_or_else(|| broken("it has no table of its sections".into()))?;
    let table: Value = serde_json::from_slice(table).map_err(|why| broken(format!("its table is no JSON: {why}")))?;
    let frame = ["/frames/0/frame", "/picture/frameArray/0/frame"].into_iter().find_map(|at| table.pointer(at));
    let section = |key: &str| {
        let name = frame.and_then(|frame| frame[key].as_str());
        sections.iter().find(|(_, own, _)| Some(own.as_str()) == name).map(|(.., data)| *data)
    };
    let what = "it has no raw image, only refocused images";
    let unsupported = || Error::unsupported(path, what);
    Ok([section("imageRef").ok_or_else(unsupported)?, section("metadataRef").ok_or_else(unsupported)?])
}

/// The metadata of an image.
struct Metadata {
    path: PathBuf,
    json: Value,
}

impl Metadata {
    fn parse(path: &Path, text: &[u8]) -> Result<Self, Error> {
        // Strings are padded with zeros in some files.
        let end = text.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
        let json: Value = serde_json::from_slice(&text[..end]).map_err(|why| Error::Broken {
            path: path.to_owned(),
            format: FORMAT,
            what: format!("its metadata are no JSON: {why}"),
        })?;
        // Those of a white image lie deeper.
        let inner = json.pointer("/master/picture/frameArray/0/frame/metadata").cloned();
        Ok(Self { path: path.to_owned(), json: inner.unwrap_or(json) })
    }

    fn lacks(&self, key: &str) -> Error {
        Error::Broken { path: self.path.clone(), format: FORMAT, what: format!("its metadata lack {key}") }
    }

    /// A number at one of these places.
    fn number(&self, places: &[&str]) -> Result<f64, Error> {
        let found = places.iter().find_map(|place| self.json.pointer(place)?.as_f64());
        found.filter(|number| number.is_finite()).ok_or_else(|| self.lacks(places[0]))
    }

    fn model(&self) -> Result<LytroModel, Error> {
        let name = self.json.pointer("/camera/model").and_then(Value::as_str).unwrap_or_default();
        let models = [(LytroModel::F01, "F01"), (LytroModel::Illum, "B01"), (LytroModel::Illum, "ILLUM")];
        let found = models.into_iter().find(|(_, own)| name.eq_ignore_ascii_case(own));
        let what = format!("camera {}: there are F01 and B01, the Illum", holo_core::shown(name));
        found.map(|(model, _)| model).ok_or_else(|| Error::unsupported(&self.path, what))
    }

    fn size(&self) -> Result<GridSize, Error> {
        let side = |key: &str| -> Result<usize, Error> {
            let side = self.number(&[key])?;
            match (1.0..=65_536.0).contains(&side) && side.fract() == 0.0 {
                true => Ok(side as usize),
                false => Err(self.lacks(&format!("a possible {key}, which is {side}"))),
            }
        };
        Ok(GridSize::new(side("/image/height")?, side("/image/width")?))
    }

    /// The bits of a code as they are packed.
    fn bits(&self) -> Result<u8, Error> {
        let places = ["/image/rawDetails/pixelPacking/bitsPerPixel", "/image/pixelPacking/bitsPerPixel"];
        let (bits, own) = (self.number(&places)?, self.model()?.sensor().bits);
        match bits == f64::from(own) {
            true => Ok(own),
            false => Err(Error::unsupported(&self.path, format!("{bits} bits a pixel; its model has {own}"))),
        }
    }

    /// The sensor of the model with its filter, black, and colors.
    fn sensor(&self, model: LytroModel) -> Result<SensorModel, Error> {
        let of_format = |key: &str| ["rawDetails/", ""].map(|inner| format!("/image/{inner}pixelFormat/{key}"));
        let mut sensor = model.sensor();
        let black = of_format("black/gr");
        sensor.black = self.number(&[&black[0], &black[1]])?;
        let places = [
            "/image/rawDetails/mosaic/upperLeftPixel",
            "/image/mosaic/upperLeftPixel",
            "/devices/sensor/mosaic/upperLeftPixel",
        ];
        let corner = places.iter().find_map(|place| self.json.pointer(place)?.as_str());
        sensor.filter = match corner {
            Some("r") => ColorFilter::Rggb,
            Some("gr") => ColorFilter::Grbg,
            Some("gb") => ColorFilter::Gbrg,
            Some("b") => ColorFilter::Bggr,
            _ => return Err(self.lacks("upperLeftPixel of the mosaic, one of r, gr, gb, b")),
        };
        let matrix = ["/image/color/ccmRgbToSrgbArray", "/image/color/ccm"].into_iter().find_map(|place| {
            let numbers: Vec<f64> = self.json.pointer(place)?.as_array()?.iter().filter_map(Value::as_f64).collect();
            <[f64; 9]>::try_from(numbers).ok()
        });
        if let Some(matrix) = matrix {
            sensor.color_matrix = std::array::from_fn(|row| std::array::from_fn(|column| matrix[3 * row + column]));
        }
        for (channel, key) in ["r", "gr", "b"].into_iter().enumerate() {
            if let Ok(gain) = self.number(&[&format!("/image/color/whiteBalanceGain/{key}")]) {
                sensor.white_balance[channel] = gain;
            }
        }
        sensor.validate().map_err(|why| Error::Broken {
            path: self.path.clone(),
            format: FORMAT,
            what: format!("the sensor of its metadata is impossible: {why}"),
        })?;
        Ok(sensor)
    }

    /// The camera of the model with the numbers of its array and its lens.
    fn camera(&self, model: LytroModel, size: GridSize) -> Result<PlenopticCamera, Error> {
        let of_model = Preset::by_name(model.preset()).and_then(|preset| preset.camera().ok());
        let of_model = of_model.ok_or_else(|| self.lacks("a camera that has a preset"))?;
        let mut sensor = *of_model.sensor();
        sensor.size = size;
        sensor.pixel_m = self.number(&["/devices/sensor/pixelPitch"])?;
        let (pitch_m, gap_m) =
            (self.number(&["/devices/mla/lensPitch"])?, self.number(&["/devices/mla/sensorOffset/z"])?);
        let mut array = MicrolensArray::new(of_model.array().grid, pitch_m, gap_m);
        array.rotation_rad = self.number(&["/devices/mla/rotation"])?;
        array.scale_y = self.number(&["/devices/mla/scaleFactor/y"])?;
        for (axis, key) in ["x", "y"].into_iter().enumerate() {
            array.offset_m[axis] = self.number(&[&format!("/devices/mla/sensorOffset/{key}")])?;
        }
        let mut lens = of_model.main_lens().clone();
        lens.focal_length_m = self.number(&["/devices/lens/focalLength"])?;
        lens.f_number = self.number(&["/devices/lens/fNumber"])?;
        lens.exit_pupil_m = Some(self.number(&["/devices/lens/exitPupilOffset/z"])?);
        // Zoomed lenses cannot be focused as near as that of the preset.
        let focus = ArrayFocus::Depth { depth_m: f64::INFINITY, virtual_depth: 0.0 };
        let far = MainLens { focus, ..lens.clone() };
        let camera = PlenopticCamera::new(sensor, array.clone(), lens);
        camera.or_else(|_| PlenopticCamera::new(sensor, array, far)).map_err(|why| Error::Broken {
            path: self.path.clone(),
            format: FORMAT,
            what: format!("the camera of its metadata is impossible: {why}"),
        })
    }
}

#[cfg(test)]
mod tests;
