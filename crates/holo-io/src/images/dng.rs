//! DNG: the mosaic of an image sensor as raw converters read it.

use std::io::Cursor;

use holo_core::sensor::SensorModel;
use ndarray::ArrayView2;
use tiff::TiffResult;
use tiff::encoder::{Rational, SRational, TiffEncoder};
use tiff::tags::Tag;

use crate::files::folder::Destination;
use crate::{Error, FileDigest, write_file};

/// The largest file of TIFF's 32-bit offsets, with room for the header.
const MAX_PIXELS: usize = (u32::MAX as usize - (1 << 20)) / 2;

/// The denominator of fractions.
const PARTS: f64 = 1e6;

/// Linear sRGB from XYZ, both of D65 (IEC 61966-2-1).
const SRGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// Writes the codes of a sensor with a Bayer mosaic as DNG 1.4, uncompressed: with black level, largest code, color matrix
/// for D65 and white balance, by which converters make sRGB of it. `name` is the model of the camera.
///
/// # Shape
///
/// `(rows, columns)`, any strides.
///
/// # Accuracy
///
/// Codes as they are; matrix and white balance in steps of 1e-6; the black level in thousandths of a code.
///
/// # Source
///
/// Adobe, Digital Negative Specification 1.4 (2012).
///
/// # Errors
///
/// [`Error::BadInput`] if the sensor has no mosaic, its color matrix has no inverse, or the image is empty or larger than a
/// TIFF; [`Error::Io`] if the file cannot be written. No file of that name appears then.
pub fn write_dng(
    path: impl Destination,
    codes: ArrayView2<'_, u16>,
    sensor: &SensorModel,
    name: &str,
) -> Result<FileDigest, Error> {
    let bad = |what: &str| Error::bad_input(path.path(), what.to_owned());
    let mosaic = sensor.filter.mosaic().ok_or_else(|| bad("a DNG holds a Bayer mosaic; write a PNG"))?;
    if codes.is_empty() || codes.len() > MAX_PIXELS {
        return Err(bad("an image without pixels, or too large for a DNG; write a PNG"));
    }
    let camera_from_rgb = sensor.camera_from_rgb().map_err(|why| bad(&why.to_string()))?;
    let encoded = encode(codes, sensor, mosaic, camera_from_rgb, name).map_err(|error| bad(&error.to_string()))?;
    write_file(&path as &dyn Destination, &encoded)
}

fn encode(
    codes: ArrayView2<'_, u16>,
    sensor: &SensorModel,
    mosaic: [[usize; 2]; 2],
    camera_from_rgb: [[f64; 3]; 3],
    name: &str,
) -> TiffResult<Vec<u8>> {
    let (rows, columns) = codes.dim();
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes)?;
    let mut directory = encoder.image_directory()?;
    let data = match codes.as_slice() {
        Some(codes) => directory.write_data(codes)?,
        None => directory.write_data(codes.iter().copied().collect::<Vec<_>>().as_slice())?,
    };
    let signed = |value: f64| SRational { n: (value * PARTS).round() as i32, d: PARTS as i32 };
    let unsigned = |value: f64| Rational { n: (value * PARTS).round() as u32, d: PARTS as u32 };
    let camera_from_xyz =
        |row: usize, column: usize| signed((0..3).map(|k| camera_from_rgb[row][k] * SRGB_FROM_XYZ[k][column]).sum());
    // A white surface as the camera sees it.
    let neutral = camera_from_rgb.map(|row| row.iter().sum::<f64>());
    let brightest = neutral.iter().fold(0.0, |most: f64, &value| most.max(value));
    let tag = Tag::Unknown;
    directory.write_tag(Tag::NewSubfileType, 0u32)?;
    directory.write_tag(Tag::ImageWidth, columns as u32)?;
    directory.write_tag(Tag::ImageLength, rows as u32)?;
    directory.write_tag(Tag::BitsPerSample, 16u16)?;
    directory.write_tag(Tag::Compression, 1u16)?;
    directory.write_tag(Tag::PhotometricInterpretation, 32_803u16)?;
    directory.write_tag(Tag::Make, "holo")?;
    directory.write_tag(Tag::Model, name)?;
    directory.write_tag(Tag::StripOffsets, data as u32)?;
    directory.write_tag(Tag::Orientation, 1u16)?;
    directory.write_tag(Tag::SamplesPerPixel, 1u16)?;
    directory.write_tag(Tag::RowsPerStrip, rows as u32)?;
    directory.write_tag(Tag::StripByteCounts, (codes.len() * 2) as u32)?;
    directory.write_tag(Tag::PlanarConfiguration, 1u16)?;
    // CFARepeatPatternDim, CFAPattern.
    directory.write_tag(tag(33_421), [2u16, 2].as_slice())?;
    let pattern = [mosaic[0][0], mosaic[0][1], mosaic[1][0], mosaic[1][1]].map(|color| color as u8);
    directory.write_tag(tag(33_422), pattern.as_slice())?;
    // DNGVersion, DNGBackwardVersion, UniqueCameraModel.
    directory.write_tag(tag(50_706), [1u8, 4, 0, 0].as_slice())?;
    directory.write_tag(tag(50_707), [1u8, 1, 0, 0].as_slice())?;
    directory.write_tag(tag(50_708), name)?;
    // BlackLevel, WhiteLevel.
    directory.write_tag(tag(50_714), Rational { n: (sensor.black * 1e3).round() as u32, d: 1000 })?;
    directory.write_tag(tag(50_717), u32::from(sensor.white()))?;
    // ColorMatrix1, AsShotNeutral, CalibrationIlluminant1: D65.
    let matrix: [SRational; 9] = std::array::from_fn(|k| camera_from_xyz(k / 3, k % 3));
    directory.write_tag(tag(50_721), matrix.as_slice())?;
    directory.write_tag(tag(50_728), neutral.map(|value| unsigned(value / brightest)).as_slice())?;
    directory.write_tag(tag(50_778), 21u16)?;
    directory.finish()?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use holo_core::sensor::{ColorFilter, SensorPreset};
    use ndarray::Array2;

    use super::*;

    /// The numbers of a tag of the first directory: of bytes, 16 or 32 bits, or both parts of fractions. Crate tiff does not
    /// open images behind color filters.
    fn tag_of(bytes: &[u8], wanted: u16) -> Vec<u32> {
        let number = |at: usize, size: usize| {
            bytes[at..at + size].iter().rev().fold(0u32, |number, &byte| (number << 8) | u32::from(byte))
        };
        assert_eq!(&bytes[..4], b"II*\0");
        let directory = number(4, 4) as usize;
        let mut entries = (0..number(directory, 2) as usize).map(|k| directory + 2 + 12 * k);
        let entry =
            entries.find(|&entry| number(entry, 2) == u32::from(wanted)).unwrap_or_else(|| panic!("no {wanted}"));
        let (size, parts) = match number(entry + 2, 2) {
            1 => (1, 1),
            3 => (2, 1),
            4 => (4, 1),
            5 | 10 => (4, 2),
            other => panic!("type {other} of {wanted}"),
        };
        let count = number(entry + 4, 4) as usize * parts;
        let start = if size * count <= 4 { entry + 8 } else { number(entry + 8, 4) as usize };
        (0..count).map(|k| number(start + k * size, size)).collect()
    }

    /// Read again by tag: the codes, the pattern, and a neutral that white has.
    #[test]
    fn tags_and_codes_are_those_of_the_sensor() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("raw.dng");
        let sensor = SensorPreset::by_name("lytro-illum").unwrap().model;
        let codes = Array2::from_shape_fn((5, 7), |(row, column)| (row * 100 + column) as u16);
        write_dng(&path, codes.view(), &sensor, "lytro-illum").unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let numbers = |tag: u16| tag_of(&bytes, tag);
        assert_eq!((numbers(256), numbers(257), numbers(262)), (vec![7], vec![5], vec![32_803]));
        assert_eq!((numbers(33_421), numbers(33_422)), (vec![2, 2], vec![1, 0, 2, 1]));
        assert_eq!((numbers(50_714), numbers(50_717)), (vec![64_000, 1000], vec![1023]));
        let neutral = numbers(50_728);
        let expected = [1.0 / 1.378_859_281_539_917, 1.0, 1.0 / 1.148_465_991_020_202_6];
        for (k, expected) in expected.iter().enumerate() {
            let found = f64::from(neutral[2 * k]) / f64::from(neutral[2 * k + 1]);
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        let (offset, length) = (numbers(273)[0] as usize, numbers(279)[0] as usize);
        let stored: Vec<u16> =
            bytes[offset..offset + length].chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
        assert_eq!(stored, codes.into_raw_vec_and_offset().0);
    }

    #[test]
    fn a_sensor_without_mosaic_has_no_dng() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("raw.dng");
        let sensor = SensorModel::ideal(ColorFilter::Mono, 12, 1e4);
        let error = write_dng(&path, Array2::zeros((2, 2)).view(), &sensor, "mono").unwrap_err();
        assert!(error.to_string().contains("PNG") && !path.exists(), "{error}");
    }
}
