//! The scores of a disparity map by name, as tables and JSON have them: over all scored pixels, and by region.
//!
//! | region | in `masks/` | of the HCI benchmark | scores |
//! |---|---|---|---|
//! | discontinuities | `discontinuity` | `mask_discontinuities` | BadPix(0.07) |
//! | planes | `plane` | `mask_planes` | bumpiness, median angle between normals |
//! | curved surfaces | `smooth` | `mask_smooth_surfaces` | the same |
//! | fine structures | `fine` | `mask_fine` | thinning |
//! | what surrounds them | `fine_surrounding` | `mask_fine_surrounding` | fattening |
//! | occluded, textureless, reflective, transparent, slanted, repetitive | the name | - | BadPix(0.07) |
//!
//! The regions of the four stratified scenes are in `score/stratified.rs`.
//!
//! # Source
//! The scores and their regions are those of the HCI benchmark and its evaluation toolkit (Honauer et al., ACCV 2016). The
//! toolkit measures discontinuities and fine structures in the high-resolution truth, others in that of the views.
//!
//! **May import:** camera.

mod stratified;

use std::iter;
use std::path::Path;

use holo_core::metrics::{
    BAD_PIXEL_THRESHOLDS_PX, FINE_THRESHOLD_PX, NormalGeometry, PixelCounts, Region, bad_pixels_percent, bumpiness,
    disparity_scores, fattening_percent, median_angle_error_deg, thinning_percent, trivial_constant, trivial_plane,
};
use holo_core::{Error as CoreError, GridSize, Rig, Sample, for_each_sample};
use holo_io::{Folder, Limits};
use ndarray::{Array2, ArrayView2, Axis};

pub(crate) use self::stratified::Objects;
use crate::Error;
use crate::camera::{NamedQuantity, QuantityValue};

/// The threshold of BadPix in regions, at which the best constant and plane are found too: the benchmark's widest.
const WIDEST_PX: f64 = BAD_PIXEL_THRESHOLDS_PX[2];

/// A dot is missed if this percentage of its pixels is off by more than that, px: `MissedDots` of the toolkit.
const DOT_PERCENT: f64 = 50.0;
const DOT_THRESHOLD_PX: f64 = 0.4;

/// The columns of `backgammon` that see the foreground alone, from the left, and the background alone, from the right, of
/// 512: those of the toolkit.
const SPIKES_FRONT: usize = 14;
const SPIKES_BACK: usize = 10;
const SPIKES_SIDE: usize = 512;

/// The regions with the names of their masks in the HCI benchmark.
const REGIONS: [(&str, Option<&str>); 11] = [
    ("discontinuity", Some("mask_discontinuities")),
    ("plane", Some("mask_planes")),
    ("smooth", Some("mask_smooth_surfaces")),
    ("fine", Some("mask_fine")),
    ("fine_surrounding", Some("mask_fine_surrounding")),
    ("occluded", None),
    ("textureless", None),
    ("reflective", None),
    ("transparent", None),
    ("slanted", None),
    ("repetitive", None),
];

/// A region of the pixels by its name.
pub type RegionMask = (String, Array2<bool>);

/// How a disparity map is scored.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct MapScoring<'a> {
    /// The border of the estimate that is left out, px.
    pub border_px: usize,
    /// The scored pixels; all without.
    pub mask: Option<ArrayView2<'a, bool>>,
    /// The rig of the views, which normals need.
    pub rig: Option<Rig>,
    /// Whether there are also angles between the normals of the HCI benchmark's toolkit.
    pub toolkit_normals: bool,
    /// Regions that are scored too. Those without scores of their own have BadPix(0.07).
    pub regions: &'a [RegionMask],
}

impl<'a> MapScoring<'a> {
    /// All pixels but a border.
    #[must_use]
    pub fn with_border(border_px: usize) -> Self {
        Self { border_px, ..Self::default() }
    }

    /// Sets the scored pixels.
    #[must_use]
    pub fn mask(self, mask: impl Into<Option<ArrayView2<'a, bool>>>) -> Self {
        Self { mask: mask.into(), ..self }
    }

    /// Sets the rig.
    #[must_use]
    pub fn rig(self, rig: impl Into<Option<Rig>>) -> Self {
        Self { rig: rig.into(), ..self }
    }

    /// Sets whether there are angles of the toolkit.
    #[must_use]
    pub fn toolkit_normals(self, toolkit_normals: bool) -> Self {
        Self { toolkit_normals, ..self }
    }

    /// Sets the regions.
    #[must_use]
    pub fn regions(self, regions: &'a [RegionMask]) -> Self {
        Self { regions, ..self }
    }

    /// The scores of an estimate against the truth.
    ///
    /// A truth with a multiple of the rows and columns is one of high resolution: then the estimate is enlarged, and the
    /// border with it. Regions without a pixel to measure have no score.
    ///
    /// # Errors
    /// [`Shape`](CoreError::Shape) if the maps or masks do not fit each other, [`NothingToMeasure`](CoreError::NothingToMeasure)
    /// if no pixel is left.
    pub fn scores(&self, estimate: ArrayView2<f32>, truth: ArrayView2<f32>) -> Result<Vec<NamedQuantity>, CoreError> {
        let scale = enlargement(estimate.dim(), truth.dim());
        let enlarged = (scale > 1).then(|| enlarge(estimate, truth.dim()));
        let maps = Maps {
            estimate: enlarged.as_ref().map_or(estimate, |enlarged| enlarged.view()),
            truth,
            rig: self.rig.filter(|rig| fits(rig, truth.dim())),
            toolkit_normals: self.toolkit_normals,
        };
        let region = Region { border_px: self.border_px * scale, mask: self.mask };
        let (mut rows, counts) = maps.of_all(&region)?;
        for (name, mask) in self.regions {
            let own = match &self.mask {
                Some(scored) if scored.dim() == mask.dim() => mask & scored,
                _ => mask.clone(),
            };
            rows.extend(maps.of_region(name, &Region { border_px: region.border_px, mask: Some(own.view()) })?);
        }
        let count =
            |key: &str, name: &str, count: usize| NamedQuantity::new(key, name, QuantityValue::Count(count), "pixels");
        rows.extend([
            count("border_px", "border left out at every side", region.border_px),
            count("compared", "pixels compared", counts.compared),
            count("estimate_not_finite", "without a finite estimate", counts.estimate_not_finite),
            count("truth_not_finite", "without a finite truth", counts.truth_not_finite),
        ]);
        Ok(rows)
    }
}

/// An estimate and the truth, of one size.
struct Maps<'a> {
    estimate: ArrayView2<'a, f32>,
    truth: ArrayView2<'a, f32>,
    rig: Option<Rig>,
    toolkit_normals: bool,
}

impl Maps<'_> {
    /// The scores that every region can have, and the numbers of its pixels.
    fn of_all(&self, region: &Region) -> Result<(Vec<NamedQuantity>, PixelCounts), CoreError> {
        let (estimate, truth) = (&self.estimate, &self.truth);
        let scores = disparity_scores(estimate, truth, region)?;
        let mut rows = Vec::new();
        for (threshold, percent) in BAD_PIXEL_THRESHOLDS_PX.into_iter().zip(scores.bad_pixels_percent) {
            rows.push(number(
                &format!("bad_pixels_{threshold}_percent"),
                &format!("BadPix({threshold})"),
                percent,
                "%",
            ));
        }
        let constant = trivial_constant(truth, WIDEST_PX, region)?.bad_pixels_percent;
        let plane = trivial_plane(truth, WIDEST_PX, region)?.bad_pixels_percent;
        rows.extend([
            number("best_constant_bad_pixels_percent", "BadPix(0.07), best constant", constant, "%"),
            number("best_plane_bad_pixels_percent", "BadPix(0.07), best plane", plane, "%"),
            number("mean_squared_error_x100", "MSE x 100", scores.mean_squared_error_x100, "px^2"),
            number("q25_x100", "Q25 x 100", scores.q25_x100, "px"),
            number("bumpiness", "bumpiness", bumpiness(estimate, truth, region)?.value, ""),
            number("mean_absolute_error_px", "mean absolute error", scores.mean_absolute_error_px, "px"),
            number("root_mean_squared_error_px", "root mean squared error", scores.root_mean_squared_error_px, "px"),
        ]);
        rows.extend(self.angles("", "", region)?);
        Ok((rows, scores.counts))
    }

    /// The scores of a region by its name.
    fn of_region(&self, name: &str, region: &Region) -> Result<Vec<NamedQuantity>, CoreError> {
        let (estimate, truth) = (&self.estimate, &self.truth);
        let bad = match bad_pixels_percent(estimate, truth, WIDEST_PX, region) {
            // Nothing is left of it.
            Err(CoreError::NothingToMeasure { .. }) => return Ok(Vec::new()),
            bad => bad?,
        };
        let title = format!(", {}", name.replace('_', " "));
        let mut rows = Vec::new();
        match name {
            "plane" | "smooth" => {
                let value = bumpiness(estimate, truth, region)?.value;
                rows.push(number(&format!("{name}_bumpiness"), &format!("bumpiness{title}"), value, ""));
                rows.extend(self.angles(&format!("{name}_"), &title, region)?);
            }
            "fine" => {
                let value = thinning_percent(estimate, truth, FINE_THRESHOLD_PX, region)?;
                rows.push(number("fine_thinning_percent", "thinning of fine structures (0.15)", value, "%"));
            }
            "fine_surrounding" => {
                let value = fattening_percent(estimate, truth, FINE_THRESHOLD_PX, region)?;
                rows.push(number("fine_fattening_percent", "fattening of fine structures (0.15)", value, "%"));
            }
            "relief" | "base" => {
                let value = bumpiness(estimate, truth, region)?.value;
                rows.push(number(&format!("{name}_bumpiness"), &format!("bumpiness{title}"), value, ""));
            }
            "spikes" => {
                let middle = self.middle(|columns| columns - 1 - SPIKES_BACK * columns / SPIKES_SIDE);
                let value = thinning_percent(estimate, &middle, 0.0, region)?;
                rows.push(number("spikes_thinning_percent", "thinning of spikes", value, "%"));
            }
            "between_spikes" => {
                let middle = self.middle(|columns| SPIKES_FRONT * columns / SPIKES_SIDE);
                let value = fattening_percent(estimate, &middle, 0.0, region)?;
                rows.push(number("spikes_fattening_percent", "fattening of spikes", value, "%"));
            }
            "boxes" => {
                let value = disparity_scores(estimate, truth, region)?.mean_squared_error_x100;
                rows.push(number("boxes_mean_squared_error_x100", "MSE x 100, boxes", value, "px^2"));
            }
            "dots" => rows.push(number("missed_dots_percent", "missed dots", self.missed(region)?, "%")),
            _ => {
                let key = format!("{name}_bad_pixels_{WIDEST_PX}_percent");
                rows.push(number(&key, &format!("BadPix({WIDEST_PX}){title}"), bad, "%"));
            }
        }
        Ok(rows)
    }

    /// The middle between the truth and that of a column, which is all foreground or all background, in the same row.
    fn middle(&self, column: impl Fn(usize) -> usize) -> Array2<f64> {
        let column = column(self.truth.ncols());
        let of = |place: [usize; 2]| f64::from(self.truth[place]);
        Array2::from_shape_fn(self.truth.dim(), |(v, u)| 0.5 * (of([v, column]) + of([v, u])))
    }

    /// The percentage of missed dots. A dot is a connected part of the region, and missed if half of its pixels are far off.
    fn missed(&self, region: &Region) -> Result<f64, CoreError> {
        let Some(mask) = region.mask else { return Ok(f64::NAN) };
        let dots = connected(mask);
        let mut missed = 0;
        for dot in &dots {
            let mut own = Array2::from_elem(mask.dim(), false);
            dot.iter().for_each(|&place| own[place] = true);
            // Those beyond the border have no pixel.
            let whole = Region { border_px: 0, mask: Some(own.view()) };
            let bad = bad_pixels_percent(&self.estimate, &self.truth, DOT_THRESHOLD_PX, &whole)?;
            missed += usize::from(bad >= DOT_PERCENT);
        }
        Ok(100.0 * missed as f64 / dots.len() as f64)
    }

    /// Median angles between normals, if there is a rig. The benchmark abbreviates them as MAE, which means another measure
    /// elsewhere.
    fn angles(&self, prefix: &str, title: &str, region: &Region) -> Result<Vec<NamedQuantity>, CoreError> {
        let Some(rig) = &self.rig else { return Ok(Vec::new()) };
        let known = [
            (NormalGeometry::Pinhole, "median_angle_deg", "MedianAngleError"),
            (NormalGeometry::Toolkit, "median_angle_toolkit_deg", "MedianAngleError, HCI toolkit"),
        ];
        let wanted = known.into_iter().take(if self.toolkit_normals { 2 } else { 1 });
        let angle = |(geometry, key, name): (NormalGeometry, &str, &str)| {
            let angle = median_angle_error_deg(&self.estimate, &self.truth, rig, geometry, region)?;
            Ok(number(&format!("{prefix}{key}"), &format!("{name}{title}"), angle.value, "degrees"))
        };
        wanted.map(angle).collect()
    }
}

/// The connected parts of a mask: pixels with common sides.
fn connected(mask: ArrayView2<bool>) -> Vec<Vec<[usize; 2]>> {
    let mut left = mask.to_owned();
    let mut parts = Vec::new();
    for ((v, u), _) in mask.indexed_iter() {
        if !left[[v, u]] {
            continue;
        }
        left[[v, u]] = false;
        let (mut part, mut done) = (vec![[v, u]], 0);
        while let Some(&[v, u]) = part.get(done) {
            done += 1;
            let neighbors = [[v.wrapping_sub(1), u], [v + 1, u], [v, u.wrapping_sub(1)], [v, u + 1]];
            for place in neighbors {
                if left.get(place).is_some_and(|is_in| *is_in) {
                    left[place] = false;
                    part.push(place);
                }
            }
        }
        parts.push(part);
    }
    parts
}

fn number(key: &str, name: &str, value: f64, unit: &'static str) -> NamedQuantity {
    NamedQuantity::new(key, name, QuantityValue::Number(value), unit)
}

/// Whether normals of a map of this size can be had: depths need a baseline.
fn fits(rig: &Rig, (rows, columns): (usize, usize)) -> bool {
    rig.shape().lenses() == GridSize::new(rows, columns) && rig.shape().views().columns > 1
}

/// How many times as wide and high the truth is; 1 if that is no whole number.
fn enlargement(estimate: (usize, usize), truth: (usize, usize)) -> usize {
    let scale = truth.0.checked_div(estimate.0).unwrap_or(1).max(1);
    if (estimate.0 * scale, estimate.1 * scale) == truth { scale } else { 1 }
}

/// A map with more rows and columns: the nearest values, where corners are the middles of the pixels in the corners.
///
/// Source: what the toolkit does with estimates where the truth has a high resolution (`scipy.ndimage.zoom` of order 0).
fn enlarge(map: ArrayView2<f32>, (rows, columns): (usize, usize)) -> Array2<f32> {
    let near = |index: usize, count: usize, of: usize| {
        let place = index as f64 * (of - 1) as f64 / (count - 1) as f64;
        (place + 0.5).floor() as usize
    };
    let (own_rows, own_columns) = map.dim();
    Array2::from_shape_fn((rows, columns), |(v, u)| map[[near(v, rows, own_rows), near(u, columns, own_columns)]])
}

/// Reads the masks of the regions of a map, for [`MapScoring::regions`]: those of files, and those of a stratified scene.
///
/// # Errors
/// [`Error::Io`] if one of them cannot be read.
pub fn region_masks(map: &Path, dim: (usize, usize)) -> Result<Vec<RegionMask>, Error> {
    let mut out = mask_files(map, dim)?;
    out.extend(Objects::read(map, dim)?.iter().flat_map(Objects::regions));
    Ok(out)
}

/// Reads the masks of regions that are files. They lie beside the map or in the folder above, in `masks/` or under the
/// names of the HCI benchmark. Masks of another size are left out.
///
/// # Errors
/// [`Error::Io`] if one of them cannot be read.
pub(crate) fn mask_files(map: &Path, (rows, columns): (usize, usize)) -> Result<Vec<RegionMask>, Error> {
    let (places, mut out) = (Folder::around(map), Vec::new());
    for (name, of_hci) in REGIONS {
        let of_hci = of_hci
            .into_iter()
            .flat_map(|of_hci| ["_lowres", "_highres", ""].map(|resolution| format!("{of_hci}{resolution}.png")));
        let files: Vec<String> = iter::once(format!("masks/{name}.png")).chain(of_hci).collect();
        let found = files.iter().flat_map(|file| places.iter().map(move |folder| (folder, file)));
        for (folder, file) in found.filter(|(folder, file)| folder.has_file(file)) {
            let mask = read_mask(&folder.path_of(file))?;
            if mask.dim() == (rows, columns) {
                out.push((name.to_owned(), mask));
                break;
            }
        }
    }
    Ok(out)
}

/// The name of the mask of a region in the HCI benchmark, if it has one.
pub(crate) fn hci_mask(region: &str) -> Option<&'static str> {
    REGIONS.iter().find(|(name, _)| *name == region).and_then(|(_, of_hci)| *of_hci)
}

/// Reads a mask: the pixels of a PNG that are not black.
///
/// # Errors
/// [`Error::Io`] if it cannot be read.
pub fn read_mask(path: &Path) -> Result<Array2<bool>, Error> {
    let image = holo_io::read_png(path, &Limits::default())?;
    Ok(
        for_each_sample!(DynImage, image, image => image.index_axis(Axis(2), 0).mapv(|value| Sample::to_f64(value) > 0.0)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(rows: &[NamedQuantity], key: &str) -> Option<f64> {
        rows.iter().find(|row| row.key == key).map(|row| match row.value {
            QuantityValue::Number(value) => value,
            QuantityValue::Count(count) => count as f64,
            _ => f64::NAN,
        })
    }

    #[test]
    fn regions_have_their_scores() {
        let truth = Array2::<f32>::zeros((20, 20));
        let estimate = Array2::from_shape_fn((20, 20), |(v, u)| match (v, u) {
            (_, 0..5) => 0.0,
            (_, 5..10) => 0.2,
            (v, _) if v % 4 < 2 => -0.2,
            _ => 0.0,
        });
        let columns = |range: std::ops::Range<usize>| Array2::from_shape_fn((20, 20), |(_, u)| range.contains(&u));
        let regions = [
            ("fine".to_owned(), columns(5..20)),
            ("fine_surrounding".to_owned(), columns(0..10)),
            ("discontinuity".to_owned(), columns(4..6)),
            ("plane".to_owned(), columns(0..3)),
            ("smooth".to_owned(), columns(12..18)),
            ("occluded".to_owned(), columns(0..0)),
        ];
        let rows = MapScoring::with_border(2).regions(&regions).scores(estimate.view(), truth.view()).unwrap();
        // Columns 5 to 17 lie within the border: 8 of 13 are too far in half of the rows.
        assert_eq!(value(&rows, "fine_thinning_percent"), Some(100.0 * 4.0 / 13.0));
        assert_eq!(value(&rows, "fine_fattening_percent"), Some(100.0 * 5.0 / 8.0));
        assert_eq!(value(&rows, "discontinuity_bad_pixels_0.07_percent"), Some(50.0));
        assert_eq!(value(&rows, "plane_bumpiness"), Some(0.0));
        // Its largest value, but for the rounding of the mean.
        let bumpy = value(&rows, "smooth_bumpiness").unwrap();
        assert!((bumpy - 5.0).abs() < 1e-12, "{bumpy}");
        assert_eq!(value(&rows, "occluded_bad_pixels_0.07_percent"), None, "it has no pixel");
        assert_eq!(value(&rows, "plane_median_angle_deg"), None, "there is no rig");
        let scored = columns(0..5);
        let rows = MapScoring::with_border(2).mask(scored.view()).regions(&regions);
        let rows = rows.scores(estimate.view(), truth.view()).unwrap();
        assert_eq!(value(&rows, "fine_fattening_percent"), Some(0.0), "of the scored pixels alone");
    }

    /// `scipy.ndimage.zoom(numpy.arange(3.0), 3, order=0)` and the like.
    #[test]
    fn estimates_are_enlarged_to_a_truth_of_high_resolution() {
        let map = Array2::from_shape_fn((3, 3), |(v, u)| (10 * v + u) as f32);
        let large = enlarge(map.view(), (9, 9));
        assert_eq!(large.row(0).to_vec(), [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
        assert_eq!(large.column(8).to_vec(), [2.0, 2.0, 12.0, 12.0, 12.0, 12.0, 22.0, 22.0, 22.0]);
        let rows = MapScoring::with_border(1).scores(map.view(), large.view()).unwrap();
        assert_eq!((value(&rows, "border_px"), value(&rows, "compared")), (Some(3.0), Some(9.0)));
        assert_eq!(value(&rows, "mean_squared_error_x100"), Some(0.0));
        let other = Array2::zeros((9, 6));
        assert!(MapScoring::with_border(0).scores(map.view(), other.view()).is_err());
    }

    /// Spikes at 1 px before a background at 0, which an estimate sees at other places; of 512 columns.
    #[test]
    fn spikes_are_nearer_to_one_side() {
        let (spike, side) = (100..110, 512);
        let truth =
            Array2::from_shape_fn((20, side), |(_, u)| if u < 50 || spike.contains(&u) { 1.0_f32 } else { 0.0 });
        // The estimate loses five of the ten columns of the spike. Two columns beside it are too near; a third is not.
        let mut estimate = truth.clone();
        estimate.columns_mut().into_iter().enumerate().for_each(|(u, mut column)| match u {
            100..105 => column.fill(0.49),
            110..112 => column.fill(0.51),
            112 => column.fill(0.5),
            _ => {}
        });
        let columns = |range: std::ops::Range<usize>| Array2::from_shape_fn((20, side), |(_, u)| range.contains(&u));
        let regions = [("spikes".to_owned(), columns(spike)), ("between_spikes".to_owned(), columns(110..120))];
        let rows = MapScoring::with_border(2).regions(&regions).scores(estimate.view(), truth.view()).unwrap();
        assert_eq!(value(&rows, "spikes_thinning_percent"), Some(50.0));
        assert_eq!(value(&rows, "spikes_fattening_percent"), Some(20.0));
    }

    #[test]
    fn dots_are_found_or_missed() {
        let mask = Array2::from_shape_fn((12, 30), |(v, u)| (4..6).contains(&v) && u % 10 < 2);
        let truth = Array2::<f32>::zeros((12, 30));
        // One of three is off at half of its pixels, one at a single pixel, and one by little.
        let estimate = Array2::from_shape_fn((12, 30), |(v, u)| match (v, u) {
            (4, 0 | 1) | (5, 10) => 0.5,
            (_, 20..) => 0.3,
            _ => 0.0,
        });
        let regions = [("dots".to_owned(), mask.clone()), ("boxes".to_owned(), !&mask)];
        let rows = MapScoring::default().regions(&regions).scores(estimate.view(), truth.view()).unwrap();
        assert_eq!(value(&rows, "missed_dots_percent"), Some(100.0 / 3.0));
        let squares = 100.0 * f64::from(0.3_f32).powi(2) * f64::from(12 * 10 - 4) / f64::from(12 * 30 - 12);
        let found = value(&rows, "boxes_mean_squared_error_x100").unwrap();
        assert!((found - squares).abs() < 1e-12, "{found} {squares}");
    }
}
