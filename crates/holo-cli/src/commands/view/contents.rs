//! What a page shows: the raw image, the maps of the central view, the rig.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use holo_core::{GridSize, Layout, LightFieldOwned, LightFieldShape, Rig};
use holo_io::dataset::{ELEMENTAL_PNG, MANIFEST_JSON, VIEWPOINT_PNG};
use holo_io::{ColorEncoding, Compression, FileInfo, Limits};
use ndarray::{Array2, Axis};

use super::super::beside::Beside;
use super::super::raw::{self, Raw};
use crate::arguments::ViewOptions;
use crate::failure::Failure;

/// Everything that goes into a page.
pub struct Contents {
    /// What the window is called.
    pub title: String,
    pub split: LightFieldShape,
    pub rig: Option<Rig>,
    pub picture: Picture,
    /// Maps of the central view, (v, u).
    pub depth_m: Option<Array2<f32>>,
    pub disparity_px: Option<Array2<f32>>,
    pub estimate_px: Option<Array2<f32>>,
}

/// The elemental grid as a PNG of 8 bits, grey or RGB.
pub enum Picture {
    /// A file that is one already.
    File(PathBuf),
    /// Made from something else.
    Encoded(Vec<u8>),
}

impl Picture {
    /// The bytes of the PNG, from the first one.
    ///
    /// # Errors
    ///
    /// Those of opening the file.
    pub fn bytes(&self) -> io::Result<Box<dyn Read + '_>> {
        Ok(match self {
            Self::File(path) => Box::new(File::open(path)?),
            Self::Encoded(bytes) => Box::new(Cursor::new(bytes)),
        })
    }
}

impl Contents {
    /// Finds everything that `holo view` was asked to show.
    ///
    /// # Errors
    ///
    /// [`Failure`] if there is no light field, or if the estimate has not the size of a view.
    pub fn gather(options: &ViewOptions) -> Result<Self, Failure> {
        let input = dataset_of(options).unwrap_or(&options.input.input);
        let beside = Beside::of(input, options.input.views.is_some())?;
        let (picture, split) = picture(input, options)?;
        let beside_fits = beside.rig.as_ref().is_none_or(|rig| *rig.shape() == split);
        let Beside { rig, depth_m, disparity_px } = if beside_fits { beside } else { Beside::default() };
        let estimate_px = options.estimate.as_deref().map(|path| estimate(path, split.lenses())).transpose()?;
        let name = std::path::absolute(&options.input.input).unwrap_or_else(|_| options.input.input.clone());
        let title = name.file_name().map_or_else(|| "light field".into(), |name| name.to_string_lossy().into_owned());
        Ok(Self { title, split, rig, picture, depth_m, disparity_px, estimate_px })
    }
}

/// The folder of a raw image that is named itself: what stands in its manifest belongs to the picture.
fn dataset_of(options: &ViewOptions) -> Option<&Path> {
    let named = options.input.input.file_name().is_some_and(|name| name == ELEMENTAL_PNG || name == VIEWPOINT_PNG);
    let folder = options.input.input.parent()?;
    let plain = named && options.input.from.is_none() && options.input.views.is_none();
    (plain && folder.join(MANIFEST_JSON).is_file()).then_some(folder)
}

/// The PNG. One that can be shown as it is stays a file; everything else is read and encoded.
fn picture(input: &Path, options: &ViewOptions) -> Result<(Picture, LightFieldShape), Failure> {
    let given = match holo_io::open(input)? {
        FileInfo::DatasetFolder(folder) => folder.raw_image().map(|(file, layout)| (file, layout, folder.shape())),
        FileInfo::Png(_) => {
            let (layout, split) = raw::describe_png(input, options.input.from, options.input.views)?;
            Some((input.to_owned(), layout, split))
        }
        _ => None,
    };
    if let Some((file, Layout::ElementalGrid, split)) = given {
        let info = holo_io::read_png_info(&file)?;
        if info.bits == 8 && matches!(info.channels, 1 | 3) && info.size == split.raw_size() {
            return Ok((Picture::File(file), split));
        }
    }
    let (raw, _) = raw::read(input, options.input.from, options.input.views)?;
    let split = raw.shape();
    let field = match raw {
        Raw::U8(field) => field,
        // Codes on the same curve: 65535 is 255, and halves round up.
        Raw::U16(field) => narrowed(&field, |code| ((u32::from(code) * 255 + 32767) / 65535) as u8)?,
        Raw::Float(field) => {
            let ev = holo_render::exposure::automatic_exposure(&field);
            holo_render::exposure::encode_8bit(&field, ev)?
        }
    };
    let grid = field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?;
    // Alpha says nothing here: colours are shown as they are stored.
    let channels = if grid.len_of(Axis(2)) >= 3 { 3 } else { 1 };
    let png =
        holo_io::encode_png(grid.slice_axis(Axis(2), (..channels).into()), ColorEncoding::Srgb, Compression::Fast)?;
    Ok((Picture::Encoded(png), split))
}

fn narrowed(field: &LightFieldOwned<u16>, code: fn(u16) -> u8) -> Result<LightFieldOwned<u8>, holo_core::Error> {
    field.map(|&sample| code(sample))
}

fn estimate(path: &Path, view: GridSize) -> Result<Array2<f32>, Failure> {
    let map = holo_io::read_pfm_grey(path, &Limits::default())?;
    if (map.nrows(), map.ncols()) != (view.rows, view.columns) {
        return Err(Failure::Usage(format!(
            "{}: an estimate has one value for every pixel of a view, {} x {}, not {} x {}",
            path.display(),
            view.columns,
            view.rows,
            map.ncols(),
            map.nrows()
        )));
    }
    Ok(map)
}
