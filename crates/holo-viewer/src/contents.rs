//! The contents of a page: the raw image, the maps of the central view, the rig.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::PathBuf;

use holo_core::{DynLightField, GridSize, Layout, LightFieldShape, Rig};
use holo_io::{ColorEncoding, Compression, FileFormat, LightFieldReader};
use ndarray::Array2;

/// Maximum number of pixels of a raw image: a browser needs four bytes of graphics memory for each, and during loading
/// as much main memory.
const MAX_PIXELS: usize = 1 << 27;

/// An error of creating a page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The raw image has more pixels than a browser can show.
    #[error(
        "{size} pixels are more than a browser can show ({} million); render fewer views or microlenses for a page",
        MAX_PIXELS / 1_000_000
    )]
    TooLarge {
        /// Rows and columns of the raw image.
        size: GridSize,
    },
    /// An estimate does not have one value for every pixel of a view.
    #[error("an estimate needs one value for every pixel of a view, {view}, but has {found}")]
    EstimateSize {
        /// Rows and columns of a view.
        view: GridSize,
        /// Rows and columns of the estimate.
        found: GridSize,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Io(#[from] holo_io::Error),
    /// The 8-bit image does not fit into memory.
    #[error(transparent)]
    Render(#[from] holo_render::Error),
    /// There is not enough memory for the image.
    #[error(transparent)]
    Core(#[from] holo_core::Error),
}

/// The contents of a page.
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

/// The elemental image array as an 8-bit PNG, gray or RGB.
#[derive(Debug)]
pub(crate) enum Image {
    /// A file that is such a PNG.
    File(PathBuf),
    /// A PNG in memory.
    Encoded(Vec<u8>),
}

impl Image {
    /// A reader of the PNG.
    pub(crate) fn bytes(&self) -> io::Result<Box<dyn Read + '_>> {
        Ok(match self {
            Self::File(path) => Box::new(File::open(path)?),
            Self::Encoded(bytes) => Box::new(Cursor::new(bytes)),
        })
    }
}

impl Page {
    /// Reads the contents of a page: the light field, its rig, and its maps of depth and disparity of the central view.
    /// `title` is the title of the window.
    ///
    /// Floats are shown at automatic exposure, 16-bit samples rounded to 8 bits; alpha is dropped.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if the raw image has more than 2^27 pixels; [`Error::Io`] if a file cannot be read;
    /// [`Error::Render`] if the 8-bit image does not fit into memory.
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

    /// Adds an estimate of the disparity of the central view in pixels between horizontally adjacent views, `(v, u)`,
    /// which the page compares with the ground truth.
    ///
    /// # Errors
    ///
    /// [`Error::EstimateSize`] if it does not have one value for every pixel of a view.
    pub fn estimate_px(mut self, map: Array2<f32>) -> Result<Self, Error> {
        let (view, found) = (self.shape.lenses(), GridSize::new(map.nrows(), map.ncols()));
        if view != found {
            return Err(Error::EstimateSize { view, found });
        }
        self.estimate_px = Some(map);
        Ok(self)
    }
}

/// The PNG of a light field: its file if that can be shown, else samples that are read and encoded.
fn image(reader: LightFieldReader) -> Result<Image, Error> {
    if let (Some(file), Some(Layout::ElementalGrid)) = (reader.raw_image(), reader.layout())
        && holo_io::detect_format(&file)? == FileFormat::Png
    {
        let info = holo_io::read_png_info(&file)?;
        if info.bits == 8 && matches!(info.channels, 1 | 3) && info.size == reader.shape().raw_size() {
            return Ok(Image::File(file));
        }
    }
    let light_field = match reader.read()?.light_field {
        // Codes on the same curve: 65535 becomes 255, and halves are rounded up.
        DynLightField::U16(field) => field.map(|&code| ((u32::from(code) * 255 + 32767) / 65535) as u8)?.into(),
        field @ DynLightField::U8(_) => field,
        field => {
            let field = field.into_f32()?;
            let exposure_ev = holo_render::exposure::automatic_exposure(&field);
            holo_render::exposure::encode_8bit(&field, exposure_ev)?.into()
        }
    };
    let grid = light_field.without_alpha()?.into_grid(Layout::ElementalGrid)?;
    let mut png = Vec::new();
    holo_io::encode_png(&mut png, &grid, ColorEncoding::Srgb, Compression::Fast)?;
    Ok(Image::Encoded(png))
}
