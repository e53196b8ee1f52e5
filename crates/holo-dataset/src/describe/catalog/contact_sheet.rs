//! Contact sheets: all scenes with one camera, in the order of the dataset, five in a row. Of more than a hundred scenes, every
//! second, third and so on, so that there are at most a hundred.
//!
//! A tile is the central view, enlarged by a whole number or reduced, above a part of the middle of the raw image at its
//! real size. Of a plenoptic camera the raw image takes the place of the central view.

use holo_core::color::linear_to_srgb8;
use holo_core::{DynLightField, LightFieldOwned, Sample, for_each_sample};
use holo_io::dataset::{DatasetCamera, DatasetFolder, MANIFEST_JSON, RAW_PNG};
use holo_io::{ColorEncoding, Compression, Folder, Limits};
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};
use ndarray::{Array3, ArrayView3};

use super::record::Record;
use crate::Error;
use crate::watch::{About, Diagnostics};

/// Tiles in a row.
const COLUMNS: usize = 5;

/// More scenes are not on a sheet.
const MOST: usize = 100;

/// The largest side of the view of a tile, px: that of a view of Table I with 20 x 20 views.
const TILE_SIDE: u32 = 397;

/// The height of the part of the raw image, px.
const RAW_HEIGHT: u32 = 80;

/// Between tiles, and half of it between the two images of a tile, px.
const GAP: u32 = 8;

/// The name of the contact sheet of a camera.
pub(in super::super) fn file_name(camera: &DatasetCamera) -> String {
    format!("contact_sheet_{}.png", camera.name())
}

/// Width and height of the contact sheet of a camera and so many scenes.
pub(in super::super) fn size(camera: &DatasetCamera, scenes: usize) -> (u32, u32) {
    let (upper, raw) = match camera {
        DatasetCamera::Rig(shape) => (shape.lenses(), shape.raw_size()),
        DatasetCamera::Plenoptic { size, .. } => (*size, *size),
    };
    let (width, height) = scaled_size((upper.columns as u32, upper.rows as u32));
    sheet_size(scenes.div_ceil(step(scenes)), (width, height + GAP / 2 + RAW_HEIGHT.min(raw.rows as u32)))
}

/// Every so many scenes one is on the sheet.
fn step(scenes: usize) -> usize {
    scenes.div_ceil(MOST).max(1)
}

/// Writes `contact_sheet_<camera>.png` of the images of one camera, unless it is newer than all of them. Returns whether
/// there is one: not if none of them has a raw image.
pub(super) fn write(
    root: &Folder,
    camera: &DatasetCamera,
    records: &[&Record],
    diagnostics: &dyn Diagnostics,
) -> Result<bool, Error> {
    let name = file_name(camera);
    if is_newer(&name, root, records) {
        return Ok(true);
    }
    let mut sheet: Option<(RgbImage, (u32, u32))> = None;
    let shown: Vec<&Record> = records.iter().step_by(step(records.len())).copied().collect();
    for (k, record) in shown.iter().enumerate() {
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
        let (sheet, size) = sheet.get_or_insert_with(|| {
            let (width, height) = sheet_size(shown.len(), tile.dimensions());
            (RgbImage::from_pixel(width, height, Rgb([255; 3])), tile.dimensions())
        });
        let [x, y] = corner(k, *size);
        imageops::replace(sheet, &tile, x, y);
    }
    let Some((sheet, _)) = sheet else { return Ok(false) };
    let (width, height) = sheet.dimensions();
    let samples = sheet.as_raw().as_slice();
    let samples = ArrayView3::from_shape((height as usize, width as usize, 3), samples)
        .map_err(|why| Error::Failed(why.to_string()))?;
    holo_io::write_png(root.file(name), samples, ColorEncoding::Srgb, Compression::Best)?;
    Ok(true)
}

/// The upper left corner of a tile.
fn corner(k: usize, tile: (u32, u32)) -> [i64; 2] {
    let [column, row] = [k % COLUMNS, k / COLUMNS].map(|place| place as u32);
    [column * (tile.0 + GAP), row * (tile.1 + GAP)].map(i64::from)
}

/// The size of a sheet of so many tiles, with gaps between them.
fn sheet_size(tiles: usize, tile: (u32, u32)) -> (u32, u32) {
    let side =
        |tiles: usize, of_tile: u32| (tiles as u32).saturating_mul(of_tile.saturating_add(GAP)).saturating_sub(GAP);
    (side(tiles.min(COLUMNS), tile.0), side(tiles.div_ceil(COLUMNS), tile.1))
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
    let (width, height) = scaled_size(image.dimensions());
    let filter = if width < image.width() { FilterType::Triangle } else { FilterType::Nearest };
    imageops::resize(&image, width, height, filter)
}

/// Width and height of such an image from those before.
fn scaled_size((width, height): (u32, u32)) -> (u32, u32) {
    let larger = width.max(height).max(1);
    let part = |side: u32| (u64::from(side) * u64::from(TILE_SIDE)).div_ceil(u64::from(larger)) as u32;
    match TILE_SIDE / larger {
        0 => (part(width), part(height)),
        factor => (width * factor, height * factor),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles lie within the sheet, row by row, and reach its ends; none lies on another.
    #[test]
    fn tiles_fill_the_sheet() {
        let tile = (7, 4);
        for tiles in 1..12 {
            let (width, height) = sheet_size(tiles, tile);
            let corners: Vec<[i64; 2]> = (0..tiles).map(|k| corner(k, tile)).collect();
            let ends = [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).max().unwrap());
            assert_eq!([ends[0] + 7, ends[1] + 4], [i64::from(width), i64::from(height)], "{tiles}");
            for (k, [x, y]) in corners.iter().enumerate() {
                let is_apart =
                    |[u, v]: &[i64; 2]| (x - u).abs() >= 7 + i64::from(GAP) || (y - v).abs() >= 4 + i64::from(GAP);
                assert!(corners[..k].iter().all(is_apart), "{tiles} {k}");
            }
        }
    }

    /// The one channel of a gray sensor is all three of a tile.
    #[test]
    fn gray_raw_images_have_gray_tiles() {
        let tile = raw_tile(&Array3::from_elem((40, 60, 1), u8::MAX));
        assert!(tile.pixels().all(|Rgb(codes)| *codes == [255; 3]));
        let color = Array3::from_shape_fn((40, 60, 3), |(.., channel)| if channel == 2 { u16::MAX } else { 0 });
        assert!(raw_tile(&color).pixels().any(|Rgb(codes)| *codes == [0, 0, 255]));
    }
}
