//! Numbers that describe a light field, for manifests and for the lists of a dataset.

use std::collections::BTreeMap;
use std::fmt;

use holo_core::{LightFieldOwned, Sample};
use holo_io::{Manifest, ManifestValue};
use holo_render::Rendered;
use ndarray::{Array2, Axis};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::settings::text;

/// The result of writing the files.
pub(crate) struct Finished {
    /// The range of disparities of the central view.
    pub disparity_px: Option<(f64, f64)>,
    pub statistics: Statistics,
    pub files: Vec<String>,
}

/// The key in the settings of a manifest.
const STATISTICS: &str = "statistics";

/// Numbers that describe a light field. A number is missing where what it is of was not rendered.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Statistics {
    /// Of the integers of all views.
    pub color: Option<ColorStatistics>,
    /// The estimated error of linear radiance, before it is coded in integers.
    pub error: Option<EstimatedError>,
    /// Smallest, median and largest depth of what the central view hits, m.
    pub depth_m: Option<[f64; 3]>,
    /// The part of the pixels of the central view that hit something.
    pub hit: Option<f64>,
    /// The part of the pixels of the central view that every view sees.
    pub seen_by_all_views: Option<f64>,
    /// The part of the pixels of the central view in each of its masks, by its name.
    pub masks: BTreeMap<String, f64>,
}

/// Statistics of integers with the sRGB curve, as parts of the largest integer, by channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColorStatistics {
    /// Mean.
    pub mean: [f64; 3],
    /// Standard deviation.
    pub deviation: [f64; 3],
    /// The part of the pixels in which a channel has the largest integer.
    pub clipped: f64,
}

/// The distribution over the pixels of the estimated relative standard error of radiance, bias included
/// ([`Rendered::error`](holo_render::Rendered::error)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EstimatedError {
    /// Median.
    pub median: f64,
    /// Ninth decile.
    pub percentile_90: f64,
}

impl fmt::Display for EstimatedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [median, high] = [self.median, self.percentile_90].map(|error| format!("{:.2} %", error * 100.0));
        write!(f, "{median} (median of the pixels), {high} (90 % of them are below)")
    }
}

/// Exact sums over pixels.
#[derive(Clone, Copy, Default)]
struct Sums {
    values: [u64; 3],
    squares: [u64; 3],
    clipped: u64,
}

impl Statistics {
    /// Those of error and ground truth; `visibility` is that of the central view.
    pub(crate) fn new(rendered: &Rendered, visibility: Option<&Array2<f32>>) -> Self {
        let quantile = |part: f64| rendered.error_distribution.as_ref()?.quantile(part);
        let error = quantile(0.5).zip(quantile(0.9));
        let mut depths: Vec<f32> = rendered.central.depth_m().into_iter().flatten().copied().collect();
        let pixels = depths.len();
        depths.retain(|depth| depth.is_finite());
        let middle = depths.len() / 2;
        let depth_m = (!depths.is_empty()).then(|| {
            let (below, median, above) = depths.select_nth_unstable_by(middle, f32::total_cmp);
            let nearest = below.iter().fold(*median, |a, b| a.min(*b));
            let farthest = above.iter().fold(*median, |a, b| a.max(*b));
            [nearest, *median, farthest].map(f64::from)
        });
        let all_views = |visibility: &Array2<f32>| {
            visibility.iter().filter(|part| **part == 1.0).count() as f64 / visibility.len() as f64
        };
        Self {
            color: None,
            error: error.map(|(median, percentile_90)| EstimatedError { median, percentile_90 }),
            depth_m,
            hit: (pixels > 0).then(|| depths.len() as f64 / pixels as f64),
            seen_by_all_views: visibility.map(all_views),
            masks: BTreeMap::new(),
        }
    }

    /// The statistics in a manifest.
    #[must_use]
    pub fn of_manifest(manifest: &Manifest) -> Self {
        let Some(ManifestValue::Table(table)) = manifest.settings.get(STATISTICS) else { return Self::default() };
        let number = |name: &str| table.get(name).and_then(ManifestValue::as_f64);
        let three = |name: &str| match table.get(name) {
            Some(ManifestValue::List(list)) => {
                list.iter().map(ManifestValue::as_f64).collect::<Option<Vec<_>>>()?.try_into().ok()
            }
            _ => None,
        };
        let color = || {
            let (mean, deviation) = (three("color-mean")?, three("color-deviation")?);
            Some(ColorStatistics { mean, deviation, clipped: number("color-clipped")? })
        };
        let error = number("error-median").zip(number("error-percentile-90"));
        Self {
            color: color(),
            error: error.map(|(median, percentile_90)| EstimatedError { median, percentile_90 }),
            depth_m: three("depth-m"),
            hit: number("hit"),
            seen_by_all_views: number("seen-by-all-views"),
            masks: match table.get("masks") {
                Some(ManifestValue::Table(masks)) => {
                    masks.iter().filter_map(|(name, part)| Some((name.clone(), part.as_f64()?))).collect()
                }
                _ => BTreeMap::new(),
            },
        }
    }

    /// Adds them to the settings of a manifest, if there are any.
    pub(crate) fn write_to(&self, manifest: &mut Manifest) {
        let table: BTreeMap<String, ManifestValue> =
            self.values().map(|(name, value)| (name.to_owned(), value)).collect();
        if !table.is_empty() {
            manifest.settings.insert(STATISTICS.into(), ManifestValue::Table(table));
        }
    }

    fn values(&self) -> impl Iterator<Item = (&'static str, ManifestValue)> {
        let three = |values: [f64; 3]| ManifestValue::List(values.map(ManifestValue::Float).to_vec());
        let (color, error, number) = (self.color, self.error, ManifestValue::Float);
        let masks = self.masks.iter().map(|(name, part)| (name.clone(), number(*part))).collect();
        [
            ("color-mean", color.map(|color| three(color.mean))),
            ("color-deviation", color.map(|color| three(color.deviation))),
            ("color-clipped", color.map(|color| number(color.clipped))),
            ("error-median", error.map(|error| number(error.median))),
            ("error-percentile-90", error.map(|error| number(error.percentile_90))),
            ("depth-m", self.depth_m.map(three)),
            ("hit", self.hit.map(number)),
            ("seen-by-all-views", self.seen_by_all_views.map(number)),
            ("masks", (!self.masks.is_empty()).then_some(ManifestValue::Table(masks))),
        ]
        .into_iter()
        .filter_map(|(name, value)| Some((name, value?)))
    }

    /// The statistics as a JSON object, with `null` for what is missing.
    pub(crate) fn json(&self) -> Value {
        let number = |value: Option<f64>| value.map_or(Value::Null, text::json_number);
        let error = self.error.map(|error| {
            json!({
                "median": text::json_number(error.median), "percentile_90": text::json_number(error.percentile_90),
            })
        });
        json!({
            "color": self.color.map(|color| json!({
                "mean": color.mean, "deviation": color.deviation, "clipped": color.clipped,
            })),
            "error": error,
            "depth_m": self.depth_m,
            "hit": number(self.hit),
            "seen_by_all_views": number(self.seen_by_all_views),
            "masks": self.masks,
        })
    }
}

impl ColorStatistics {
    /// Those of a light field of integers with three channels.
    pub(crate) fn new<T: Sample>(coded: &LightFieldOwned<T>) -> Self {
        let white = f64::from(T::WHITE.unwrap_or(1.0));
        // In the order of memory.
        let samples = coded.samples().permuted_axes([0, 2, 1, 3, 4]);
        let sums = samples.axis_iter(Axis(0)).into_par_iter().map(|lens_row| {
            let mut sums = Sums::default();
            match lens_row.as_slice() {
                Some(values) => values.chunks_exact(coded.channels()).for_each(|pixel| sums.count(pixel, white)),
                None => lens_row.rows().into_iter().for_each(|pixel| sums.count(&pixel.to_vec(), white)),
            }
            sums
        });
        let sums = sums.reduce(Sums::default, Sums::add);
        let shape = coded.shape();
        let pixels = (shape.views().count() * shape.lenses().count()) as f64;
        let mean = sums.values.map(|sum| sum as f64 / pixels);
        let variance = |channel: usize| sums.squares[channel] as f64 / pixels - mean[channel] * mean[channel];
        Self {
            mean: mean.map(|mean| mean / white),
            deviation: [0, 1, 2].map(|channel| variance(channel).max(0.0).sqrt() / white),
            clipped: sums.clipped as f64 / pixels,
        }
    }
}

impl Sums {
    /// Adds a pixel, in whose channels `white` is the largest integer.
    fn count<T: Sample>(&mut self, pixel: &[T], white: f64) {
        let mut is_clipped = false;
        for (channel, value) in pixel.iter().take(3).enumerate() {
            is_clipped |= value.to_f64() == white;
            let value = value.to_f64() as u64;
            self.values[channel] += value;
            self.squares[channel] += value * value;
        }
        self.clipped += u64::from(is_clipped);
    }

    fn add(mut self, other: Self) -> Self {
        for channel in 0..3 {
            self.values[channel] += other.values[channel];
            self.squares[channel] += other.squares[channel];
        }
        self.clipped += other.clipped;
        self
    }
}

#[cfg(test)]
mod tests {
    use holo_core::{GridSize, LightField, LightFieldShape};
    use ndarray::Array3;

    use super::*;

    #[test]
    fn integers_are_summed_exactly() {
        let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap();
        let value = |row: usize, column: usize, channel: usize| (row * 31 + column * 7 + channel * 90) as u8;
        let mut image = Array3::from_shape_fn((8, 15, 3), |(row, column, channel)| value(row, column, channel));
        (image[[0, 0, 2]], image[[5, 7, 0]], image[[5, 7, 1]]) = (255, 255, 255);
        let field = LightField::from_elemental_grid(image.clone(), shape).unwrap();
        let found = ColorStatistics::new(&field);
        for channel in 0..3 {
            let values: Vec<f64> = image.index_axis(Axis(2), channel).iter().map(|x| f64::from(*x) / 255.0).collect();
            let mean = values.iter().sum::<f64>() / 120.0;
            let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 120.0;
            assert!((found.mean[channel] - mean).abs() < 1e-12);
            assert!((found.deviation[channel] - variance.sqrt()).abs() < 1e-9);
        }
        let clipped = image.lanes(Axis(2)).into_iter().filter(|pixel| pixel.iter().any(|x| *x == 255)).count();
        assert!(clipped > 1);
        assert_eq!(found.clipped, clipped as f64 / 120.0);
    }

    #[test]
    fn manifests_keep_them() {
        let statistics = Statistics {
            color: Some(ColorStatistics { mean: [0.1, 0.2, 0.3], deviation: [0.01, 0.02, 0.03], clipped: 0.5 }),
            error: Some(EstimatedError { median: 0.02, percentile_90: f64::INFINITY }),
            depth_m: Some([0.5, 1.0, 2.0]),
            hit: Some(0.75),
            seen_by_all_views: None,
            masks: BTreeMap::from([("fine".to_owned(), 0.25), ("valid".to_owned(), 1.0)]),
        };
        let mut manifest = Manifest::default();
        statistics.write_to(&mut manifest);
        let read = Manifest::from_json(&manifest.to_json().unwrap()).unwrap();
        assert_eq!(Statistics::of_manifest(&read), statistics);
        let mut empty = Manifest::default();
        Statistics::default().write_to(&mut empty);
        assert_eq!(empty, Manifest::default());
        assert_eq!(Statistics::of_manifest(&empty), Statistics::default());
    }
}
