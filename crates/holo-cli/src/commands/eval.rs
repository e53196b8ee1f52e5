//! `holo eval`: an estimate against ground truth, an image against another.

use std::path::Path;

use holo_core::metrics::{ErrorColors, error_map, psnr_db, ssim};
use holo_core::{DynImage, GridSize, Rig};
use holo_dataset::{MapScoring, NamedQuantity, QuantityValue, read_mask};
use holo_io::dataset::HIT_MASK_PNG;
use holo_io::{ColorEncoding, Compression, FileFormat, Folder, Limits};
use ndarray::Array2;

use crate::arguments::{EvalOptions, NormalsArgument};
use crate::console::say;
use crate::failure::Failure;
use crate::quantities;

/// The name of a mask of all pixels.
const ALL_PIXELS: &str = "none";

pub fn run(options: &EvalOptions) -> Result<(), Failure> {
    let kinds = [holo_io::detect_format(&options.estimate)?, holo_io::detect_format(&options.truth)?];
    let rows = match kinds {
        [FileFormat::Pfm, FileFormat::Pfm] => maps(options)?,
        [FileFormat::Png, FileFormat::Png] => images(options)?,
        _ => {
            return Err(Failure::Failed(format!(
                "{} and {}: two disparity maps (.pfm) or two images (.png) can be compared",
                options.estimate.display(),
                options.truth.display()
            )));
        }
    };
    quantities::print(&rows, options.json)
}

fn maps(options: &EvalOptions) -> Result<Vec<NamedQuantity>, Failure> {
    let limits = Limits::default();
    let estimate = holo_io::read_pfm_gray(&options.estimate, &limits)?;
    let truth = holo_io::read_pfm_gray(&options.truth, &limits)?;
    let (mask, scored) = mask_of(options, truth.dim())?;
    let rig = rig_beside(&options.truth, truth.dim());
    let toolkit_normals = options.normals == NormalsArgument::Toolkit;
    if toolkit_normals && rig.is_none() {
        return Err(Failure::Failed(format!(
            "{}: no parameters.cfg of its size beside it, which normals need",
            options.truth.display()
        )));
    }
    let regions = holo_dataset::region_masks(&options.truth, truth.dim())?;
    let scoring = MapScoring::with_border(options.border).mask(mask.as_ref().map(|mask| mask.view())).rig(rig);
    let mut rows = scoring.toolkit_normals(toolkit_normals).regions(&regions).scores(estimate.view(), truth.view())?;
    if estimate.dim() != truth.dim() {
        say!("note: the truth has a high resolution; the estimate is enlarged to it, as by the HCI toolkit");
    }
    let numbers = rows.iter().position(|row| row.key == "border_px").unwrap_or(rows.len());
    rows.insert(numbers, NamedQuantity::new("mask", "mask of the scored pixels", QuantityValue::Text(scored), ""));
    if let Some(path) = &options.error_map {
        let image = error_map(&estimate, &truth, options.error_range, &ErrorColors::default())?;
        holo_io::write_png(path, image.view(), ColorEncoding::Srgb, Compression::Best)?;
    }
    Ok(rows)
}

/// The rig of a map's views, if the `parameters.cfg` beside it is theirs: depths, and with them normals, need one.
fn rig_beside(map: &Path, (rows, columns): (usize, usize)) -> Option<Rig> {
    let rig = holo_io::read_rig(map, &Limits::default()).ok()??;
    let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
    (lenses == GridSize::new(rows, columns) && views.columns > 1).then_some(rig)
}

/// The mask of the pixels that are scored, and what it is called: that which was named, else the mask of what is hit in the
/// folder of the truth or above it, if it has the size of the truth.
fn mask_of(options: &EvalOptions, size: (usize, usize)) -> Result<(Option<Array2<bool>>, String), Failure> {
    if let Some(path) = &options.mask {
        return match path.as_os_str() == ALL_PIXELS {
            true => Ok((None, ALL_PIXELS.into())),
            false => Ok((Some(read_mask(path)?), path.display().to_string())),
        };
    }
    let found = Folder::around(&options.truth).into_iter().find(|folder| folder.has_file(HIT_MASK_PNG));
    let Some(folder) = found else { return Ok((None, ALL_PIXELS.into())) };
    let path = folder.path_of(HIT_MASK_PNG);
    let mask = read_mask(&path)?;
    if mask.dim() != size {
        return Ok((None, ALL_PIXELS.into()));
    }
    let path = path.display().to_string();
    say!("note: pixels where {path} is black see nothing and are left out; --mask {ALL_PIXELS} scores all");
    Ok((Some(mask), path))
}

fn images(options: &EvalOptions) -> Result<Vec<NamedQuantity>, Failure> {
    if options.mask.is_some() || options.error_map.is_some() {
        return Err(Failure::Usage("--mask and --error-map are for disparity maps".into()));
    }
    let limits = Limits::default();
    let (psnr, ssim) =
        match (holo_io::read_png(&options.estimate, &limits)?, holo_io::read_png(&options.truth, &limits)?) {
            (DynImage::U8(one), DynImage::U8(other)) => (psnr_db(&one, &other, 255.0)?, ssim(&one, &other, 255.0)?),
            (DynImage::U16(one), DynImage::U16(other)) => {
                (psnr_db(&one, &other, 65_535.0)?, ssim(&one, &other, 65_535.0)?)
            }
            _ => {
                let what = "one has 8 bits and the other 16; compare images of the same bit depth";
                return Err(Failure::Failed(format!("{}: {what}", options.estimate.display())));
            }
        };
    let row = |key, name, value, unit| NamedQuantity::new(key, name, QuantityValue::Number(value), unit);
    Ok(vec![row("psnr_db", "PSNR", psnr, "dB"), row("ssim", "SSIM", ssim, "")])
}
