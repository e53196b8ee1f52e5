//! `holo eval`: an estimate against ground truth, an image against another.

use std::path::Path;

use holo_core::metrics::{
    BAD_PIXEL_THRESHOLDS_PX, ErrorColors, NormalGeometry, Region, bumpiness, disparity_scores, error_map,
    median_angle_error_deg, psnr_db, ssim, trivial_constant, trivial_plane,
};
use holo_core::{DynImage, GridSize, Rig, Sample, for_each_sample};
use holo_dataset::{NamedQuantity, QuantityValue};
use holo_io::dataset::HIT_MASK_PNG;
use holo_io::{ColorEncoding, Compression, FileFormat, Limits};
use ndarray::{Array2, Axis};

use crate::arguments::{EvalOptions, NormalsArgument};
use crate::console::say;
use crate::failure::Failure;
use crate::quantities;

/// The name of a mask of all pixels.
const ALL_PIXELS: &str = "none";

/// The threshold at which the best constant and plane are found: the benchmark's widest.
const FIT_THRESHOLD_PX: f64 = 0.07;

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

fn row(key: &str, name: &str, value: f64, unit: &'static str) -> NamedQuantity {
    NamedQuantity::new(key, name, QuantityValue::Number(value), unit)
}

fn maps(options: &EvalOptions) -> Result<Vec<NamedQuantity>, Failure> {
    let limits = Limits::default();
    let estimate = holo_io::read_pfm_gray(&options.estimate, &limits)?;
    let truth = holo_io::read_pfm_gray(&options.truth, &limits)?;
    let (mask, scored) = mask_of(options, truth.dim())?;
    let region = Region { border_px: options.border, mask: mask.as_ref().map(|mask| mask.view()) };
    let scores = disparity_scores(&estimate, &truth, &region)?;
    let mut rows = Vec::new();
    for (threshold, percent) in BAD_PIXEL_THRESHOLDS_PX.into_iter().zip(scores.bad_pixels_percent) {
        let key = format!("bad_pixels_{threshold}_percent");
        rows.push(row(&key, &format!("BadPix({threshold})"), percent, "%"));
    }
    let constant = trivial_constant(&truth, FIT_THRESHOLD_PX, &region)?.bad_pixels_percent;
    let plane = trivial_plane(&truth, FIT_THRESHOLD_PX, &region)?.bad_pixels_percent;
    rows.extend([
        row("best_constant_bad_pixels_percent", "BadPix(0.07), best constant", constant, "%"),
        row("best_plane_bad_pixels_percent", "BadPix(0.07), best plane", plane, "%"),
        row("mean_squared_error_x100", "MSE x 100", scores.mean_squared_error_x100, "px^2"),
        row("q25_x100", "Q25 x 100", scores.q25_x100, "px"),
        row("bumpiness", "bumpiness", bumpiness(&estimate, &truth, &region)?.value, ""),
        row("mean_absolute_error_px", "mean absolute error", scores.mean_absolute_error_px, "px"),
        row("root_mean_squared_error_px", "root mean squared error", scores.root_mean_squared_error_px, "px"),
    ]);
    if let Some(rig) = rig_beside(&options.truth, truth.dim()) {
        // The benchmark abbreviates it as MAE, which means another measure elsewhere.
        let angle = median_angle_error_deg(&estimate, &truth, &rig, NormalGeometry::Pinhole, &region)?;
        rows.push(row("median_angle_deg", "MedianAngleError", angle.value, "degrees"));
        if options.normals == NormalsArgument::Toolkit {
            let angle = median_angle_error_deg(&estimate, &truth, &rig, NormalGeometry::Toolkit, &region)?;
            rows.push(row("median_angle_toolkit_deg", "MedianAngleError, HCI toolkit", angle.value, "degrees"));
        }
    } else if options.normals == NormalsArgument::Toolkit {
        return Err(Failure::Failed(format!(
            "{}: no parameters.cfg of its size beside it, which normals need",
            options.truth.display()
        )));
    }
    rows.push(NamedQuantity::new("mask", "mask of the scored pixels", QuantityValue::Text(scored), ""));
    let counts = scores.counts;
    for (key, name, count) in [
        ("border_px", "border left out at every side", options.border),
        ("compared", "pixels compared", counts.compared),
        ("estimate_not_finite", "without a finite estimate", counts.estimate_not_finite),
        ("truth_not_finite", "without a finite truth", counts.truth_not_finite),
    ] {
        rows.push(NamedQuantity::new(key, name, QuantityValue::Count(count), "pixels"));
    }
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
    let folder = options.truth.parent().unwrap_or(Path::new(""));
    let folders = [folder.to_owned(), folder.join("..")];
    let found = folders.iter().map(|folder| folder.join(HIT_MASK_PNG)).find(|path| path.is_file());
    let Some(path) = found else { return Ok((None, ALL_PIXELS.into())) };
    let mask = read_mask(&path)?;
    if mask.dim() != size {
        return Ok((None, ALL_PIXELS.into()));
    }
    let path = path.display().to_string();
    say!("note: pixels where {path} is black see nothing and are left out; --mask {ALL_PIXELS} scores all");
    Ok((Some(mask), path))
}

fn read_mask(path: &Path) -> Result<Array2<bool>, Failure> {
    let samples = holo_io::read_png(path, &Limits::default())?;
    Ok(
        for_each_sample!(DynImage, samples, image => image.index_axis(Axis(2), 0).mapv(|value| Sample::to_f64(value) > 0.0)),
    )
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
    Ok(vec![row("psnr_db", "PSNR", psnr, "dB"), row("ssim", "SSIM", ssim, "")])
}
