//! The images of a file: their bytes, sizes and texels.

use std::borrow::Cow;
use std::io::Cursor;

use image::{ImageFormat, ImageReader};

use super::super::buffer_views::BufferViews;
use super::super::container::Files;
use super::super::json::Object;
use super::super::uri::{self, Target};
use super::image_format;
use crate::Error;

/// A decoded image.
#[derive(Clone)]
pub(super) struct Decoded {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: Vec<[u8; 4]>,
}

/// An encoded image of known size.
pub(super) struct Source<'v> {
    bytes: Cow<'v, [u8]>,
    format: ImageFormat,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl<'v> Source<'v> {
    /// Reads the header of an image. The inner error says why there is no image that can be decoded.
    ///
    /// # Errors
    /// Rules of glTF about the references of an image, and the limit of bytes in files.
    pub(super) fn new(
        image: &Object<'_>,
        buffer_views: &'v BufferViews<'_>,
        files: &Files,
    ) -> Result<Result<Self, String>, Error> {
        let bytes = match (image.index("bufferView", "bufferViews", buffer_views.len())?, image.string("uri")?) {
            (Some(view), _) => Cow::Borrowed(buffer_views.get(view)?.bytes),
            (None, Some(uri)) => match external(image, uri, files)? {
                Ok(bytes) => Cow::Owned(bytes),
                Err(why) => return Ok(Err(why)),
            },
            (None, None) => return Ok(Err("the image has neither bufferView nor uri".into())),
        };
        Ok(Self::header(bytes))
    }

    fn header(bytes: Cow<'v, [u8]>) -> Result<Self, String> {
        let format = image_format::detect(&bytes).map_err(|kind| format!("the image is {kind}"))?;
        let size = ImageReader::with_format(Cursor::new(&*bytes), format).into_dimensions();
        let (width, height) = size.map_err(|e| format!("the image cannot be decoded: {e}"))?;
        if width == 0 || height == 0 {
            return Err("the image has no pixels".into());
        }
        Ok(Self { bytes, format, width, height })
    }

    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width).saturating_mul(u64::from(self.height))
    }

    pub(super) fn decode(self) -> Result<Decoded, String> {
        let fail = |e: image::ImageError| format!("the image cannot be decoded: {e}");
        let mut reader = ImageReader::with_format(Cursor::new(&*self.bytes), self.format);
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(self.width);
        limits.max_image_height = Some(self.height);
        // 16-bit RGBA, once for the decoder and once for the image, and some memory for tables.
        limits.max_alloc = Some(self.pixels().saturating_mul(16).saturating_add(64 << 20));
        reader.limits(limits);
        let image = reader.decode().map_err(fail)?.into_rgba8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let texels = image.as_raw().as_chunks::<4>().0.to_vec();
        if (width, height) != (self.width as usize, self.height as usize) || texels.len() != width * height {
            return Err("the image changed its size while it was decoded".into());
        }
        Ok(Decoded { width, height, texels })
    }
}

/// The bytes of an image outside of the buffers; the inner error says why they cannot be read.
fn external(image: &Object<'_>, uri: &str, files: &Files) -> Result<Result<Vec<u8>, String>, Error> {
    let at = image.at("uri");
    let located = match uri::resolve(uri, &at) {
        Ok(Target::Data(bytes)) => return Ok(Ok(bytes)),
        Ok(Target::File(path)) => files.locate(&path, &at),
        Err(error) => Err(error),
    };
    let path = match located {
        Ok(path) => path,
        Err(Error::Unsupported { what, .. }) => return Ok(Err(format!("{what} is not supported"))),
        Err(Error::BadFile { what, .. }) => return Ok(Err(format!("the image {what}"))),
        Err(other) => return Err(other),
    };
    match files.read(&path) {
        Ok(bytes) => Ok(Ok(bytes)),
        Err(Error::Read { error, .. }) => Ok(Err(format!("the image cannot be read: {error}"))),
        Err(limit) => Err(limit),
    }
}
