//! Conversion of linear radiance to the integers of an image file: one exposure for all views, then the sRGB transfer
//! curve.
//!
//! Exposure is exposure compensation in EV (stops): linear values are multiplied by 2^EV.

use holo_core::{Layout, LightField, LightFieldOwned};
use ndarray::{ArrayView3, ArrayView4, Axis, Data, Zip};
use rayon::prelude::*;

use crate::error::Error;
use holo_core::color::{Srgb8Encoder, linear_to_srgb16};

/// The share of pixels that lie below [`PERCENTILE_TARGET`] of the range of the display.
const PERCENTILE: f64 = 0.99;
/// The linear display value of the percentile.
const PERCENTILE_TARGET: f64 = 0.8;
/// Buckets of the histogram per stop, its lowest stop, and its number of stops.
const STEPS_PER_STOP: f64 = 16.0;
const DARKEST_STOP: f64 = -64.0;
const STOPS: usize = 128;
const BUCKETS: usize = STOPS * STEPS_PER_STOP as usize;

/// Rows of pixels that one task counts.
const ROWS_AT_ONCE: usize = 32;

/// Values that one task encodes.
const VALUES_AT_ONCE: usize = 1 << 16;

/// Returns the exposure, EV, at which 99 % of the pixels that are not black lie below 80 % of the linear range of the
/// display. It is computed from the whole light field, so that all views have the same exposure; 0 if all pixels are
/// black.
///
/// # Accuracy
/// A multiple of 1/16 EV. It is computed from an integer histogram, so it does not depend on the number of threads.
#[must_use]
pub fn automatic_exposure(color: &LightField<impl Data<Elem = f32>>) -> f64 {
    let of_rows = |rows: ArrayView3<f32>| {
        let mut histogram = vec![0u64; BUCKETS];
        match rows.as_slice() {
            Some(values) => values.chunks_exact(rows.dim().2).for_each(|pixel| count(&mut histogram, pixel)),
            None => rows.rows().into_iter().for_each(|pixel| count(&mut histogram, &pixel.to_vec())),
        }
        histogram
    };
    let add = |a: Vec<u64>, b: Vec<u64>| a.iter().zip(&b).map(|(x, y)| x + y).collect();
    let none = || vec![0; BUCKETS];
    let histogram = match color.as_elemental_grid() {
        Some(image) => image.axis_chunks_iter(Axis(0), ROWS_AT_ONCE).into_par_iter().map(of_rows).reduce(none, add),
        None => {
            let views = color.samples();
            let rows = views.axis_iter(Axis(0)).into_par_iter();
            let of_row = |row: ArrayView4<f32>| row.axis_iter(Axis(0)).map(of_rows).reduce(add).unwrap_or_else(none);
            rows.map(of_row).reduce(none, add)
        }
    };
    let total: u64 = histogram.iter().sum();
    let mut seen = 0;
    for (bucket, &count) in histogram.iter().enumerate() {
        seen += count;
        if count > 0 && seen as f64 >= PERCENTILE * total as f64 {
            let stop = (bucket + 1) as f64 / STEPS_PER_STOP + DARKEST_STOP;
            // Inverts the linear interpolation of the logarithm above.
            let radiance = stop.floor().exp2() * (1.0 + stop.fract().rem_euclid(1.0));
            return ((PERCENTILE_TARGET / radiance).log2() * STEPS_PER_STOP).round() / STEPS_PER_STOP;
        }
    }
    0.0
}

/// Counts a pixel by its luminance, if that is finite and not black.
#[inline]
fn count(histogram: &mut [u64], pixel: &[f32]) {
    // Rec. 709; gray images have one channel.
    let luminance = match pixel {
        [r, g, b, ..] => 0.2126 * r + 0.7152 * g + 0.0722 * b,
        _ => pixel[0],
    };
    if luminance > 0.0 && luminance.is_finite() {
        // The exponent with the first bits of the mantissa: log2 in sixteenths, exact at powers of two and linear between. The
        // buckets only need to be ordered.
        let step = (luminance.to_bits() >> 19) as i32 - ((127 << 4) + (DARKEST_STOP * STEPS_PER_STOP) as i32);
        histogram[step.clamp(0, BUCKETS as i32 - 1) as usize] += 1;
    }
}

/// Encodes linear radiance as 8-bit sRGB: exposure (EV), clamping, transfer curve, rounding to nearest. The axes stay
/// (v, u, t, s, c); the memory layout is the elemental image array.
///
/// # Errors
/// [`Error::Core`] if the image does not fit into memory.
pub fn encode_8bit(color: &LightField<impl Data<Elem = f32>>, exposure_ev: f64) -> Result<LightFieldOwned<u8>, Error> {
    let encoder = Srgb8Encoder::get();
    encode(color, exposure_ev, |x| encoder.encode(x))
}

/// Encodes linear radiance as 16-bit sRGB, as [`encode_8bit`] with 16 bits.
///
/// # Errors
/// As [`encode_8bit`].
pub fn encode_16bit(
    color: &LightField<impl Data<Elem = f32>>,
    exposure_ev: f64,
) -> Result<LightFieldOwned<u16>, Error> {
    encode(color, exposure_ev, linear_to_srgb16)
}

fn encode<T: Copy + Default + Send + Sync>(
    color: &LightField<impl Data<Elem = f32>>,
    exposure_ev: f64,
    code: impl Fn(f32) -> T + Sync,
) -> Result<LightFieldOwned<T>, Error> {
    let split = color.shape();
    let factor = exposure_ev.exp2() as f32;
    let mut coded = LightField::filled(split, color.channels(), Layout::ElementalGrid, T::default())?;
    // In the order of the elemental image array.
    let order = [0, 2, 1, 3, 4];
    let mut to = coded.samples_mut().permuted_axes(order);
    let from = color.samples().permuted_axes(order);
    match (to.as_slice_mut(), from.as_slice()) {
        (Some(to), Some(from)) => {
            to.par_chunks_mut(VALUES_AT_ONCE).zip(from.par_chunks(VALUES_AT_ONCE)).for_each(|(to, from)| {
                to.iter_mut().zip(from).for_each(|(code_of, &x)| *code_of = code(x * factor));
            });
        }
        _ => Zip::from(to).and(from).par_for_each(|to, &x| *to = code(x * factor)),
    }
    Ok(coded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::{GridSize, LightFieldShape};

    fn field(values: impl Fn(usize) -> f32) -> LightFieldOwned<f32> {
        let split = LightFieldShape::new(GridSize::new(4, 5), GridSize::new(6, 7)).unwrap();
        let mut field = LightField::filled(split, 3, Layout::ElementalGrid, 0.0).unwrap();
        for (k, x) in field.samples_mut().iter_mut().enumerate() {
            *x = values(k / 3);
        }
        field
    }

    #[test]
    fn twice_the_light_is_one_stop_less() {
        let base = automatic_exposure(&field(|k| 1e-3 * (k + 1) as f32));
        assert_eq!(automatic_exposure(&field(|k| 2e-3 * (k + 1) as f32)), base - 1.0);
        // The 99th percentile of a ramp up to 0.84 is 0.83; it is mapped to 0.8.
        assert!((base - (0.8f64 / 0.83).log2()).abs() < 2.0 / STEPS_PER_STOP, "{base}");
    }

    /// A light field in the order of views, and a part of one, have the exposure and the codes of their pixels.
    #[test]
    fn the_order_in_memory_does_not_matter() {
        let grid = field(|k| 1e-3 * (k * 7919 % 840 + 1) as f32);
        let mut views = LightField::filled(grid.shape(), 3, Layout::ViewpointGrid, 0.0).unwrap();
        views.samples_mut().assign(&grid.samples());
        assert_eq!(automatic_exposure(&views), automatic_exposure(&grid));
        assert_eq!(encode_8bit(&views, 0.5).unwrap().samples(), encode_8bit(&grid, 0.5).unwrap().samples());
        let part = grid.clip_views(1..3, 0..5).unwrap();
        assert_eq!(automatic_exposure(&part), automatic_exposure(&part.to_owned().unwrap()));
    }

    #[test]
    fn black_and_broken_pixels_do_not_count() {
        assert_eq!(automatic_exposure(&field(|_| 0.0)), 0.0);
        let lit = automatic_exposure(&field(|_| 0.25));
        assert_eq!(automatic_exposure(&field(|k| [0.25, 0.0, f32::NAN, f32::INFINITY][k % 4])), lit);
    }

    #[test]
    fn codes_are_the_formula_after_the_exposure() {
        let color = field(|k| k as f32 / 840.0);
        let (eight, sixteen) = (encode_8bit(&color, -1.0).unwrap(), encode_16bit(&color, -1.0).unwrap());
        for ((x, a), b) in color.samples().iter().zip(eight.samples()).zip(sixteen.samples()) {
            assert_eq!(*a, holo_core::color::linear_to_srgb8(x * 0.5));
            assert_eq!(*b, linear_to_srgb16(x * 0.5));
        }
    }
}
