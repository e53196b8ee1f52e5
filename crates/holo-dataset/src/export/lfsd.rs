//! Saliency: focal stacks, all-in-focus images, depth and masks of chosen objects as in DUTLF-FS, whose layout readers of LFSD,
//! HFUT-Lytro and Lytro Illum take too, and raw images with their masks as MAC, for those who read micro-images.
//!
//! | file | what |
//! |---|---|
//! | `<group>_images/<scene>.jpg` | the central view, sharp everywhere |
//! | `<group>_masks/<scene>.png` | 255 where it sees a chosen object |
//! | `<group>_depths/<scene>.png` | its disparity in 8 bits: 0 the farthest that it hits, 255 the nearest |
//! | `<group>_focals/<scene>.mat` | `img`, uint8 (rows, columns, 36): twelve images of three colors, focused from the nearest to the farthest in equal steps of disparity |
//! | `data/original_data/<scene>.PNG`, `data/original_GT/<scene>.PNG` | the raw image, a pixel of every view behind a microlens, and the mask |

use holo_core::color::linear_to_srgb8;
use holo_core::refocus::Refocus;
use holo_core::{ColorEncoding, DynLightField};
use holo_io::{Compression, MatOptions, MatValue, MatVariable};
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use ndarray::{Array2, Array3, ArrayView3, Axis};

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, Writer, unchecked};
use crate::Error;
use crate::output::OutputFolder;

/// The images of a focal stack, which readers have in their code.
const SLICES: usize = 12;

/// The quality of JPEG: codes of smooth images to 2.
const QUALITY: u8 = 95;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "lfsd",
    help: "saliency, as DUTLF-FS: focal stacks, all-in-focus images, depth, masks of chosen objects, raw images",
    usage: "Readers take train_images, train_masks and train_focals as their folders; `group` test names those of a test set. MAC \
            takes `data`.",
    has_groups: true,
    has_objects: true,
    writer: Writer::Fields { write, check: unchecked },
};

fn write(folder: &mut OutputFolder, loaded: &LoadedField, job: &ExportJob) -> Result<(), Error> {
    let group = job.group.as_deref().unwrap_or("train");
    let (Some(disparity), Some(hits)) = (&loaded.disparity_px, &loaded.hits) else {
        return Err(loaded
            .lacks("depth and focal stacks need its disparity", "render it with `layers` depth,disparity,object-id"));
    };
    let mask = loaded.sees(&job.objects)?.mapv(|is_chosen| if is_chosen { 255 } else { 0 }).insert_axis(Axis(2));
    let hit = disparity.iter().zip(hits).filter(|(px, is_hit)| **is_hit && px.is_finite()).map(|(px, _)| *px);
    let range = hit.fold(None, |range: Option<[f32; 2]>, px| {
        Some(range.map_or([px; 2], |[far, near]| [far.min(px), near.max(px)]))
    });
    let Some(range) = range else {
        return Err(loaded.lacks("the central view hits nothing", "place the camera before the scene"));
    };
    let name = |part: &str, ending: &str| format!("{group}_{part}/{}.{ending}", loaded.name);
    for part in ["images", "masks", "depths", "focals"] {
        folder.subfolder(&format!("{group}_{part}"))?;
    }
    let views = loaded.field.shape().views();
    let central = loaded.field.view(views.rows / 2, views.columns / 2)?;
    let image = name("images", "jpg");
    folder.add(image.clone(), holo_io::write_file(folder.file(&image), &jpeg(central)?)?);
    let stack = focal_stack(loaded, range)?;
    let variable = MatVariable { name: "img", value: MatValue::U8(stack.view().into_dyn()) };
    let focals = name("focals", "mat");
    folder.add(focals.clone(), holo_io::write_mat(folder.file(&focals), &[variable], &MatOptions::default())?);
    let raw = loaded.field.to_elemental_grid()?;
    let micro = |part: &str| format!("data/{part}/{}.PNG", loaded.name);
    for part in ["data/original_data", "data/original_GT"] {
        folder.subfolder(part)?;
    }
    for (file, image, encoding) in [
        (name("masks", "png"), mask.view(), ColorEncoding::Linear),
        (name("depths", "png"), depth_codes(disparity, range).view(), ColorEncoding::Linear),
        (micro("original_data"), raw.view(), ColorEncoding::Srgb),
        (micro("original_GT"), mask.view(), ColorEncoding::Linear),
    ] {
        let written = holo_io::write_png(folder.file(&file), image, encoding, Compression::Fast)?;
        folder.add(file, written);
    }
    Ok(())
}

/// Disparity as 8 bits over a range.
fn depth_codes(disparity: &Array2<f32>, [far, near]: [f32; 2]) -> Array3<u8> {
    let scale = 255.0 / (near - far).max(f32::MIN_POSITIVE);
    disparity.mapv(|px| ((px - far) * scale).round().clamp(0.0, 255.0) as u8).insert_axis(Axis(2))
}

/// The images of a focal stack beside each other: axes (row, column, image and channel).
fn focal_stack(loaded: &LoadedField, [far, near]: [f32; 2]) -> Result<Array3<u8>, Error> {
    let linear = DynLightField::U8(loaded.field.clone()).into_linear(ColorEncoding::Srgb)?;
    let refocus = Refocus::new(linear.shape().views())?;
    let refocus = loaded.rig.as_ref().map_or(refocus.clone(), |rig| refocus.baseline_ratio(rig.baseline_ratio()));
    let lenses = linear.shape().lenses();
    let mut stack = Array3::zeros((lenses.rows, lenses.columns, SLICES * linear.channels()));
    for slice in 0..SLICES {
        let share = slice as f64 / (SLICES - 1) as f64;
        let image = refocus.at_disparity(&linear, f64::from(near) + share * f64::from(far - near))?;
        for ((v, u, c), value) in image.indexed_iter() {
            stack[[v, u, slice * linear.channels() + c]] = linear_to_srgb8(*value);
        }
    }
    Ok(stack)
}

/// An image as a JPEG.
fn jpeg(image: ArrayView3<u8>) -> Result<Vec<u8>, Error> {
    let (rows, columns, channels) = image.dim();
    let color = if channels == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    let pixels: Vec<u8> = image.iter().copied().collect();
    let mut out = Vec::new();
    let encoded = JpegEncoder::new_with_quality(&mut out, QUALITY).encode(&pixels, columns as u32, rows as u32, color);
    encoded.map_err(|why| Error::Failed(format!("a view of {columns} x {rows} px as JPEG: {why}")))?;
    Ok(out)
}
