//! SGI images (`.rgb`), in which light fields of the nineties are stored. Through the crate `image-extras`.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use holo_core::{DynImage, GridSize, SampleKind};
use image::{ImageDecoder, ImageError};
use image_extras::sgi::SgiDecoder;
use ndarray::Array3;

use crate::files::panic_guard::decoded;
use crate::{Error, Limits};

/// The name of the format in messages.
const FORMAT: &str = "SGI image";

/// The header of an SGI image.
pub(crate) struct SgiInfo {
    pub(crate) size: GridSize,
    /// Channels, 1 to 4.
    pub(crate) channels: usize,
    /// Integers of 8 or 16 bits.
    pub(crate) kind: SampleKind,
}

/// Reads the header of an SGI image.
pub(crate) fn read_sgi_info(path: &Path) -> Result<SgiInfo, Error> {
    decoded(path, FORMAT, || open(path).map(|decoder| info(&decoder)))
}

/// Reads an SGI image of 8 or 16 bits, gray or RGB, with or without alpha: `(rows, columns, channels)`.
pub(crate) fn read_sgi(path: &Path, limits: &Limits) -> Result<DynImage, Error> {
    decoded(path, FORMAT, || {
        let decoder = open(path)?;
        let SgiInfo { size, channels, kind } = info(&decoder);
        let shape = (size.rows, size.columns, channels);
        let count = limits.elements(path, "image", &[shape.0, shape.1, shape.2], kind.bytes())? * kind.bytes();
        let mut bytes = Limits::room(path, "image", count)?;
        bytes.resize(count, 0);
        decoder.read_image(&mut bytes).map_err(|why| of_decoder(path, why))?;
        let image = match kind {
            SampleKind::U8 => Array3::from_shape_vec(shape, bytes).map(DynImage::U8),
            _ => {
                let samples = bytes.chunks_exact(2).map(|pair| u16::from_ne_bytes([pair[0], pair[1]])).collect();
                Array3::from_shape_vec(shape, samples).map(DynImage::U16)
            }
        };
        Ok(image.expect("the length is the product"))
    })
}

fn open(path: &Path) -> Result<SgiDecoder<BufReader<File>>, Error> {
    let file = File::open(path).map_err(|why| Error::io("read", path, why))?;
    SgiDecoder::new(BufReader::new(file)).map_err(|why| of_decoder(path, why))
}

fn info(decoder: &impl ImageDecoder) -> SgiInfo {
    let ((columns, rows), color) = (decoder.dimensions(), decoder.color_type());
    let channels = usize::from(color.channel_count());
    let kind = if usize::from(color.bytes_per_pixel()) > channels { SampleKind::U16 } else { SampleKind::U8 };
    SgiInfo { size: GridSize::new(rows as usize, columns as usize), channels, kind }
}

fn of_decoder(path: &Path, error: ImageError) -> Error {
    match error {
        ImageError::IoError(why) if why.kind() != std::io::ErrorKind::UnexpectedEof => Error::io("read", path, why),
        other => Error::broken(path, FORMAT, other.to_string()),
    }
}
