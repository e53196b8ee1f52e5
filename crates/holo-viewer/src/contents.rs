//! What a page shows: the raw image, the maps of the central view, the rig.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::PathBuf;

use holo_core::{DynLightField, GridSize, Layout, LightFieldShape, Rig};
use holo_io::{ColorEncoding, Compression, LightFieldReader};
use ndarray::Array2;

/// How many pixels a page may hold: 16K television fits. A browser keeps four bytes of each in graphics memory, and for a
/// moment once more in its own.
const MAX_PIXELS: usize = 1 << 27;

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The raw image has more pixels than a browser holds.
    #[error(
        "{size} pixels are more than a browser holds ({} million); render fewer views or lenses for a page",
        MAX_PIXELS / 1_000_000
    )]
    TooLarge {
        /// Rows and columns of the raw image.
        size: GridSize,
    },
    /// An estimate has not one value for every pixel of a view.
    #[error("an estimate has one value for every pixel of a view, {view}, not {found}")]
    EstimateSize {
        /// Rows and columns of a view.
        view: GridSize,
        /// Those of the estimate.
        found: GridSize,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Io(#[from] holo_io::Error),
    /// The exposure of the image cannot be computed.
    #[error(transparent)]
    Render(#[from] holo_render::Error),
    /// There is not enough memory for the image.
    #[error(transparent)]
    Core(#[from] holo_core::Error),
}

/// Everything that goes into a page.
#[derive(Debug)]
pub struct Page {
    pub(crate) title: String,
    pub(crate) shape: LightFieldShape,
    pub(crate) rig: Option<Rig>,
    pub(crate) image: Image,
    /// Maps of the central view, (v, u).
    pub(crate) depth_m: Option<Array2<f32>>,
    pub(crate) disparity_px: Option<Array2<f32>>,
    pub(crate) estimate_px: Option<Array2<f32>>,
}

/// The elemental image array as a PNG of 8 bits, gray or RGB.
#[derive(Debug)]
pub(crate) enum Image {
    /// A file that is one already.
    File(PathBuf),
    /// Made from something else.
    Encoded(Vec<u8>),
}

impl Image {
    /// The bytes of the PNG, from the first one.
    pub(crate) fn bytes(&self) -> io::Result<Box<dyn Read + '_>> {
        Ok(match self {
            Self::File(path) => Box::new(File::open(path)?),
            Self::Encoded(bytes) => Box::new(Cursor::new(bytes)),
        })
    }
}

impl Page {
    /// Gathers what a page shows: samples, rig, and the maps of depth and disparity that lie with them. `title` is the
    /// window's.
    ///
    /// Floats are shown at an automatic exposure, 16-bit samples as their nearest 8-bit ones, alpha not at all.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] beyond 134 million pixels; [`Error::Io`] if a file cannot be read.
    pub fn new(title: impl Into<String>, reader: LightFieldReader) -> Result<Self, Error> {
        let (shape, rig) = (reader.shape(), reader.rig().copied());
        let size = shape.raw_size();
        if size.rows.saturating_mul(size.columns) > MAX_PIXELS {
            return Err(Error::TooLarge { size });
        }
        let (depth_m, disparity_px) = (reader.central_depth_m()?, reader.central_disparity_px()?);
        let image = image(reader)?;
        Ok(Self { title: title.into(), shape, rig, image, depth_m, disparity_px, estimate_px: None })
    }

    /// Adds an estimate of the central view's disparity in pixels, `(v, u)`, to be shown beside the ground truth.
    ///
    /// # Errors
    ///
    /// [`Error::EstimateSize`] if it has not one value for every pixel of a view.
    pub fn estimate_px(mut self, map: Array2<f32>) -> Result<Self, Error> {
        let (view, found) = (self.shape.lenses(), GridSize::new(map.nrows(), map.ncols()));
        if view != found {
            return Err(Error::EstimateSize { view, found });
        }
        self.estimate_px = Some(map);
        Ok(self)
    }
}

/// The PNG. One that can be shown as it is stays a file; everything else is read and encoded.
fn image(reader: LightFieldReader) -> Result<Image, Error> {
    if let (Some(file), Some(Layout::ElementalGrid)) = (reader.raw_image(), reader.layout()) {
        let info = holo_io::read_png_info(&file)?;
        if info.bits == 8 && matches!(info.channels, 1 | 3) && info.size == reader.shape().raw_size() {
            return Ok(Image::File(file));
        }
    }
    let light_field = match reader.read()?.light_field {
        // Codes on the same curve: 65535 is 255, and halves round up.
        DynLightField::U16(field) => field.map(|&code| ((u32::from(code) * 255 + 32767) / 65535) as u8)?.into(),
        field @ DynLightField::U8(_) => field,
        field => {
            let field = field.into_f32()?;
            let exposure_ev = holo_render::exposure::automatic_exposure(&field);
            holo_render::exposure::encode_8bit(&field, exposure_ev)?.into()
        }
    };
    let grid = light_field.without_alpha()?.into_grid(Layout::ElementalGrid)?;
    Ok(Image::Encoded(holo_io::encode_png(&grid, ColorEncoding::Srgb, Compression::Fast)?))
}
