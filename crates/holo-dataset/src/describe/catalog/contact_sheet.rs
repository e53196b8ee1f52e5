//! Contact sheets: all scenes with one camera, in the order of the dataset, five in a row.
//!
//! A tile is the central view, enlarged by a whole number or reduced, above a part of the middle of the raw image at its
//! real size. Of a plenoptic camera the raw image takes the place of the central view.

use holo_core::color::linear_to_srgb8;
use holo_core::{DynLightField, GridSize, LightFieldOwned, Sample, for_each_sample};
use holo_io::dataset::{DatasetCamera, DatasetFolder, MANIFEST_JSON, RAW_PNG};
use holo_io::{ColorEncoding, Compression, EntryKind, Folder, Limits};
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};
use ndarray::{Array3, ArrayView3};

use super::record::Record;
use super::remove_file;
use crate::Error;
use crate::watch::{About, Diagnostics};

/// Tiles in a row.
const COLUMNS: usize = 5;

/// The largest side of the view of a tile, px: that of a view of Table I with 20 x 20 views.
const TILE_SIDE: u32 = 397;

/// The height of the part of the raw image, px.
const RAW_HEIGHT: u32 = 80;

/// Between tiles, and half of it between the two images of a tile, px.
const GAP: u32 = 8;

/// What the names of contact sheets begin and end with.
const NAME: [&str; 2] = ["contact_sheet_", ".png"];

/// Removes the contact sheets of numbers of views that are not among `cameras`.
pub(super) fn remove_others(root: &Folder, cameras: &[DatasetCamera]) -> Result<(), Error> {
    for (name, kind) in root.list()? {
        let views = name.strip_prefix(NAME[0]).and_then(|name| name.strip_suffix(NAME[1]));
        let views = views.and_then(|views| views.parse::<GridSize>().ok());
        // Not a file of the user's that is spelled otherwise.
        let is_own = |views: GridSize| kind == EntryKind::File && name == of_name(&views.to_string());
        let is_known = cameras.iter().any(|camera| name == file_name(camera));
        if views.is_some_and(is_own) && !is_known {
            remove_file(root, &name)?;
        }
    }
    Ok(())
}

/// The name of the contact sheet of a camera.
pub(super) fn file_name(camera: &DatasetCamera) -> String {
    of_name(&camera.name())
}

fn of_name(camera: &str) -> String {
    format!("{}{camera}{}", NAME[0], NAME[1])
}

/// Writes `contact_sheet_<camera>.png` of the images of one camera, unless it is newer than all of them. If none of
/// them has a raw image, there is no contact sheet.
pub(super) fn write(
    root: &Folder,
    camera: &DatasetCamera,
    records: &[&Record],
    diagnostics: &dyn Diagnostics,
) -> Result<(), Error> {
    let name = file_name(camera);
    if is_newer(&name, root, records) {
        return Ok(());
    }
    let mut sheet: Option<(RgbImage, (u32, u32))> = None;
    for (k, record) in records.iter().enumerate() {
        let tile = root.sub(&record.folder).and_then(|folder| match camera {
            DatasetCamera::Rig(_) => read_tile(&folder),
            DatasetCamera::Plenoptic { .. } => read_raw_tile(&folder, record),
        });
        let tile = match tile {
            Ok(Some(tile)) => tile,
            Ok(None) => continue,
            Err(why) => {
                diagnostics.report(About::Scene, &format!("warning: not in the contact sheet: {why}"));
                continue;
            }
        };
        let (sheet, size) = sheet.get_or_insert_with(|| (empty(records.len(), tile.dimensions()), tile.dimensions()));
        let [column, row] = [k % COLUMNS, k / COLUMNS].map(|place| place as u32);
        let [x, y] = [column * (size.0 + GAP), row * (size.1 + GAP)].map(i64::from);
        imageops::replace(sheet, &tile, x, y);
    }
    // Without a raw image: one of older folders.
    let Some((sheet, _)) = sheet else { return remove_file(root, &name) };
    let (width, height) = sheet.dimensions();
    let samples = sheet.as_raw().as_slice();
    let samples = ArrayView3::from_shape((height as usize, width as usize, 3), samples)
        .map_err(|why| Error::Failed(why.to_string()))?;
    holo_io::write_png(root.file(name), samples, ColorEncoding::Srgb, Compression::Best)?;
    Ok(())
}

/// A white sheet for so many tiles.
fn empty(tiles: usize, size: (u32, u32)) -> RgbImage {
    let [columns, rows] = [tiles.min(COLUMNS), tiles.div_ceil(COLUMNS)].map(|count| count as u32);
    RgbImage::from_pixel(columns * (size.0 + GAP) - GAP, rows * (size.1 + GAP) - GAP, Rgb([255; 3]))
}

/// The tile of a folder, if it has a raw image.
fn read_tile(folder: &Folder) -> Result<Option<RgbImage>, holo_io::Error> {
    let folder = DatasetFolder::open(folder.path())?;
    if folder.raw_image().is_none() {
        return Ok(None);
    }
    folder.read(&Limits::NONE).map(|field| Some(tile(&field)))
}

/// The tile of a folder of a plenoptic camera, if it has its raw image in integers, which have an exposure.
fn read_raw_tile(folder: &Folder, record: &Record) -> Result<Option<RgbImage>, holo_io::Error> {
    if !record.manifest.files.contains_key(RAW_PNG) {
        return Ok(None);
    }
    let image = holo_io::read_png(folder.regular_path(RAW_PNG)?, &Limits::NONE)?;
    Ok(Some(for_each_sample!(DynImage, image, image => raw_tile(&image))))
}

/// Whether a file was written after the manifests of all records, of which there are some.
fn is_newer(name: &str, root: &Folder, records: &[&Record]) -> bool {
    let time = |name: &str| root.open_regular(name, u64::MAX).ok()?.metadata().and_then(|file| file.modified()).ok();
    let Some(own) = time(name).filter(|_| !records.is_empty()) else { return false };
    let manifests = records.iter().map(|record| time(&format!("{}/{MANIFEST_JSON}", record.folder)));
    manifests.into_iter().all(|manifest| manifest.is_some_and(|manifest| manifest < own))
}

fn tile(field: &DynLightField) -> RgbImage {
    match field {
        DynLightField::U8(field) => tile_of(field),
        DynLightField::U16(field) => tile_of(field),
        DynLightField::F32(field) => tile_of(field),
        DynLightField::F64(field) => tile_of(field),
    }
}

fn tile_of<T: Sample>(field: &LightFieldOwned<T>) -> RgbImage {
    let (shape, samples) = (field.shape(), field.samples());
    let (lenses, views, raw) = (shape.lenses(), shape.views(), shape.raw_size());
    let (t, s) = shape.central_view();
    let channels = field.channels();
    let scale = 255.0 / T::WHITE.unwrap_or(1.0);
    let pixel = |v: usize, u: usize, t: usize, s: usize| {
        Rgb([0, 1, 2].map(|c: usize| (samples[[v, u, t, s, c.min(channels - 1)]].to_f32() * scale).round() as u8))
    };
    let [width, height] = [lenses.columns, lenses.rows].map(|count| count as u32);
    let view = scaled(RgbImage::from_fn(width, height, |x, y| pixel(y as usize, x as usize, t, s)));
    let [raw_width, raw_height] = [view.width().min(raw.columns as u32), RAW_HEIGHT.min(raw.rows as u32)];
    // The part begins with a microlens.
    let top = (raw.rows - raw_height as usize) / 2 / views.rows * views.rows;
    let left = (raw.columns - raw_width as usize) / 2 / views.columns * views.columns;
    above(
        &view,
        RgbImage::from_fn(raw_width, raw_height, |x, y| {
            let (row, column) = (top + y as usize, left + x as usize);
            pixel(row / views.rows, column / views.columns, row % views.rows, column % views.columns)
        }),
    )
}

/// An image that is enlarged by a whole number or reduced to the size of a tile.
fn scaled(image: RgbImage) -> RgbImage {
    let (width, height) = image.dimensions();
    let larger = width.max(height);
    match TILE_SIDE / larger {
        0 => {
            let part = |side: u32| (u64::from(side) * u64::from(TILE_SIDE)).div_ceil(u64::from(larger)) as u32;
            imageops::resize(&image, part(width), part(height), FilterType::Triangle)
        }
        factor => imageops::resize(&image, width * factor, height * factor, FilterType::Nearest),
    }
}

/// A tile of one image above another one that is not wider.
fn above(upper: &RgbImage, lower: RgbImage) -> RgbImage {
    let top = upper.height() + GAP / 2;
    let mut tile = RgbImage::from_pixel(upper.width(), top + lower.height(), Rgb([255; 3]));
    imageops::replace(&mut tile, upper, 0, 0);
    imageops::replace(&mut tile, &lower, 0, i64::from(top));
    tile
}

/// The tile of a raw image in linear light.
fn raw_tile<T: Sample>(raw: &Array3<T>) -> RgbImage {
    let (rows, columns, channels) = raw.dim();
    let white = T::WHITE.unwrap_or(1.0);
    let coded =
        |row: usize, column: usize, c: usize| linear_to_srgb8(raw[[row, column, c.min(channels - 1)]].to_f32() / white);
    let [width, height] = [columns, rows].map(|count| count as u32);
    let whole = RgbImage::from_fn(width, height, |x, y| Rgb([0, 1, 2].map(|c| coded(y as usize, x as usize, c))));
    let upper = scaled(whole.clone());
    let (part_width, part_height) = (upper.width().min(width), RAW_HEIGHT.min(height));
    let (left, top) = ((width - part_width) / 2, (height - part_height) / 2);
    let part = imageops::crop_imm(&whole, left, top, part_width, part_height).to_image();
    above(&upper, part)
}
