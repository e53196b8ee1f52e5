//! The white image: what the camera records of a scene of radiance 1, without rays.

use ndarray::{Array2, ArrayViewMut2, Axis};

use super::{LensAperture, MicrolensIndex, PlenopticCamera, PupilShape};
use crate::Error;
use crate::memory;
use crate::parallel::*;

/// Rows of pixels that are computed together.
const BAND_ROWS: usize = 64;

/// Micro-images whose edge is at least this wide, in pixels, are integrated over pixels; others over microlenses, with
/// the exact share of the pixel that the pupil's image covers.
const WIDE_EDGE_PX: f64 = 0.5;

/// Gauss-Legendre places within a pixel: two, from -1/2 to 1/2.
const GAUSS: [f64; 2] = [-0.288_675_134_594_812_9, 0.288_675_134_594_812_9];

/// Three of them from 0 to 1, with their weights.
const GAUSS_3: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

impl PlenopticCamera {
    /// Returns the white image: for every pixel the light of a scene of radiance 1, relative to the center of an
    /// unvignetted micro-image on the axis. Axes (row, column).
    ///
    /// It contains the vignetting by both apertures and the cos^4 law, and the light of several microlenses where their
    /// micro-images overlap. Raw image / white image is the mean radiance that a pixel sees.
    ///
    /// # Accuracy
    ///
    /// Quadrature over pixel and microlens: 1e-4 on average, 1e-2 for single pixels at the edges of micro-images.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the image does not fit into memory.
    pub fn white_image(&self) -> Result<Array2<f32>, Error> {
        let size = self.sensor().size;
        let values = memory::filled("a white image", size.rows * size.columns, 0.0f32)?;
        let mut image = Array2::from_shape_vec((size.rows, size.columns), values).map_err(|_| Error::Shape {
            what: "white image",
            expected: vec![size.rows, size.columns],
            found: Vec::new(),
        })?;
        let mut bands: Vec<_> = image.axis_chunks_iter_mut(Axis(0), BAND_ROWS).enumerate().collect();
        bands.par_iter_mut().for_each(|(number, band)| self.white_band(*number * BAND_ROWS, band));
        Ok(image)
    }

    /// Adds the light of all microlenses to the rows from `first` on.
    fn white_band(&self, first: usize, band: &mut ArrayViewMut2<f32>) {
        let rows = first..first + band.nrows();
        let unvignetted = self.central_cos4();
        for line in self.lens_lines(rows.clone()) {
            for lens in self.lenses_on_line(line, rows.clone()) {
                for (row, columns) in self.lit_pixels(lens, rows.clone()) {
                    for column in columns {
                        band[[row - first, column]] += (self.pair_light(lens, row, column) / unvignetted) as f32;
                    }
                }
            }
        }
    }

    /// Returns the light that one pixel gets through one microlens: its share of the white image, before the division by
    /// [`central_cos4`](Self::central_cos4).
    fn pair_light(&self, lens: MicrolensIndex, row: usize, column: usize) -> f64 {
        let center = self.micro_image_center_m(lens);
        let middle = self.place_m([column as f64 + 0.5, row as f64 + 0.5]);
        let pixel = self.sensor().fill * self.sensor().pixel_m;
        let away = (middle[0] - center[0]).hypot(middle[1] - center[1]);
        let lens_type = self.array().type_of(lens);
        let diagonal = pixel * std::f64::consts::FRAC_1_SQRT_2;
        let is_round = matches!(self.array().aperture, LensAperture::Round { .. })
            && self.main_lens().aperture == PupilShape::Round;
        // How far the image of the pupil moves on the sensor while the light moves over the microlens.
        let moved = self.alpha(lens_type).abs() * self.array().aperture.half_width_m();
        let is_lens_smaller = moved <= self.exit_pupil_radius_m();
        let moved_px = moved * self.array().gap_m / self.exit_pupil_m() / self.sensor().pixel_m;
        if is_round && is_lens_smaller && away + diagonal <= self.micro_image_radii_m(lens_type)[0] {
            return self.over_lens(lens, |lens_point| {
                let places = GAUSS.iter().flat_map(|&y| GAUSS.map(|x| [middle[0] + x * pixel, middle[1] + y * pixel]));
                places.map(|place| self.cos4(place, lens_point)).sum::<f64>() / 4.0
            });
        }
        if moved_px < WIDE_EDGE_PX && is_lens_smaller {
            return self.over_lens(lens, |lens_point| {
                let share = self.covered_share(lens, lens_point, middle, pixel);
                // The lit part of a pixel that an edge crosses lies towards the center.
                let inwards = (1.0 - share) / 2.0 * pixel / away.max(pixel);
                let place = [0, 1].map(|k| middle[k] + (center[k] - middle[k]) * inwards);
                if share > 0.0 { share * self.cos4(place, lens_point) } else { 0.0 }
            });
        }
        // A wide edge is smooth over a pixel.
        let steps = if moved_px < 4.0 { 4 } else { 2 };
        let area = self.array().aperture.area_m2();
        let mut sum = 0.0;
        for k in 0..steps * steps {
            let offset = [k % steps, k / steps].map(|k| match steps {
                2 => GAUSS[k],
                _ => (k as f64 + 0.5) / steps as f64 - 0.5,
            });
            let place = [0, 1].map(|axis| middle[axis] + offset[axis] * pixel);
            let region = self.lit_region(place, lens);
            let lens_center = self.lens_center_m(lens);
            let cos4 = |[x, y]: [f64; 2]| self.cos4(place, [lens_center[0] + x, lens_center[1] + y]);
            let light: f64 = if self.is_masked() {
                // Regions of other shapes are counted: many points, which no straight edge follows.
                let steps = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
                let points = (0..256).map(|j| steps.map(|step| ((f64::from(j) + 0.5) * step).fract()));
                points.filter_map(|unit| region.point(unit)).map(cos4).sum::<f64>() / 256.0
            } else {
                let points = GAUSS_3.iter().flat_map(|&(u, weight)| GAUSS.map(|v| ([u, v + 0.5], weight / 2.0)));
                points.filter_map(|(unit, weight)| Some(weight * cos4(region.point(unit)?))).sum()
            };
            sum += light * region.sampled_area_m2() / area;
        }
        sum / (steps * steps) as f64
    }

    /// Whether lit regions are sampled in a rectangle around them.
    fn is_masked(&self) -> bool {
        match (self.array().aperture, self.main_lens().aperture) {
            (LensAperture::Round { .. }, PupilShape::Round) => false,
            (LensAperture::Square { .. }, PupilShape::Square) => self.array().rotation_rad != 0.0,
            _ => true,
        }
    }

    /// Returns the mean of cos^4 for the center of an unvignetted micro-image on the axis, which the white image is
    /// relative to.
    #[must_use]
    pub fn central_cos4(&self) -> f64 {
        let gap = self.array().gap_m;
        match self.array().aperture {
            // The integral of (1 + r^2 / d^2)^-2 over a disc is pi a^2 / (1 + a^2 / d^2).
            LensAperture::Round { radius_m } => 1.0 / (1.0 + (radius_m / gap).powi(2)),
            aperture => {
                let outer = aperture.outer_radius_m();
                let side = 64;
                let at = |k: usize| ((k as f64 + 0.5) / f64::from(side as u32) * 2.0 - 1.0) * outer;
                let points = (0..side * side).map(|k| [at(k % side), at(k / side)]);
                let inside = points.filter(|&point| super::lune::is_in_lens(aperture, 0.0, point));
                let (sum, count) =
                    inside.fold((0.0, 0.0), |(sum, count), point| (sum + self.cos4([0.0; 2], point), count + 1.0));
                sum / count
            }
        }
    }

    /// The mean of a smooth function over the points of a microlens.
    fn over_lens(&self, lens: MicrolensIndex, function: impl Fn([f64; 2]) -> f64) -> f64 {
        let center = self.lens_center_m(lens);
        let rotation = self.array().rotation_rad;
        let at = |point: [f64; 2]| {
            let [x, y] = super::microlenses::rotate(point, rotation);
            function([center[0] + x, center[1] + y])
        };
        match self.array().aperture {
            // Seven points, exact to the fifth degree (Stroud, S2 5-1).
            LensAperture::Round { radius_m } => {
                let r = radius_m * (2f64 / 3.0).sqrt();
                let ring = (0..6).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_3);
                0.25 * at([0.0; 2]) + 0.125 * ring.map(|angle| at([r * angle.cos(), r * angle.sin()])).sum::<f64>()
            }
            LensAperture::Square { half_width_m } => {
                // Three Gauss-Legendre places an axis.
                let each = GAUSS_3.iter().flat_map(|&(y, wy)| GAUSS_3.map(|(x, wx)| ([x, y], wx * wy)));
                each.map(|(point, weight)| weight * at(point.map(|x| (2.0 * x - 1.0) * half_width_m))).sum()
            }
            aperture @ LensAperture::Hexagon { .. } => {
                let (side, outer) = (12, aperture.outer_radius_m());
                let place = |k: usize| ((k as f64 + 0.5) / 6.0 - 1.0) * outer;
                let points = (0..side * side).map(|k| [place(k % side), place(k / side)]);
                let inside = points.filter(|&point| super::lune::is_in_lens(aperture, 0.0, point));
                let (sum, count) = inside.fold((0.0, 0.0), |(sum, count), point| (sum + at(point), count + 1.0));
                sum / count
            }
        }
    }

    /// The share of a pixel that light through one point of a microlens reaches: that of the image of the pupil.
    fn covered_share(&self, lens: MicrolensIndex, lens_point: [f64; 2], middle: [f64; 2], pixel: f64) -> f64 {
        let (center, lens_center) = (self.micro_image_center_m(lens), self.lens_center_m(lens));
        let scale = self.array().gap_m / self.exit_pupil_m();
        let alpha = self.alpha(self.array().type_of(lens));
        let radius = scale * self.exit_pupil_radius_m();
        let from = [0, 1].map(|k| middle[k] - (center[k] + scale * alpha * (lens_point[k] - lens_center[k])));
        let [low, high] = [-0.5, 0.5].map(|side| from.map(|x| (x + side * pixel) / radius));
        let unit = pixel / radius;
        match self.main_lens().aperture {
            PupilShape::Square => {
                let width = [0, 1].map(|k| (high[k].min(1.0) - low[k].max(-1.0)).max(0.0) / unit);
                width[0] * width[1]
            }
            PupilShape::Round => {
                let corner = |x: f64, y: f64| quadrant(x, y);
                let area = corner(high[0], high[1]) - corner(low[0], high[1]) - corner(high[0], low[1])
                    + corner(low[0], low[1]);
                (area / (unit * unit)).clamp(0.0, 1.0)
            }
        }
    }
}

/// The area of the unit disc left of x and below y.
fn quadrant(x: f64, y: f64) -> f64 {
    let (x, y) = (x.clamp(-1.0, 1.0), y.clamp(-1.0, 1.0));
    // The area left of a line.
    let left = |x: f64| x * (1.0 - x * x).sqrt() + x.asin() + std::f64::consts::FRAC_PI_2;
    if x * x + y * y >= 1.0 {
        // The corner lies outside: the lines do not cross within the disc.
        return match (x >= 0.0, y >= 0.0) {
            (true, true) => left(x) + left(y) - std::f64::consts::PI,
            (true, false) => left(y),
            (false, true) => left(x),
            (false, false) => 0.0,
        };
    }
    // Half of what lies left and below the axes' parts: a quarter disc, two half segments and the rectangle.
    (left(x) + left(y)) / 2.0 - std::f64::consts::FRAC_PI_4 + x * y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrants_have_their_areas() {
        let side = 1000;
        for (x, y) in
            [(0.3, 0.2), (-0.3, 0.5), (0.9, 0.9), (-0.9, 0.9), (0.8, -0.7), (-0.8, -0.8), (0.0, 0.0), (2.0, 0.1)]
        {
            let at = |k: usize| (k as f64 + 0.5) / f64::from(side as u32) * 2.0 - 1.0;
            let inside = |px: f64, py: f64| px * px + py * py <= 1.0 && px < x && py < y;
            let count = (0..side * side).filter(|k| inside(at(k % side), at(k / side))).count();
            let counted = 4.0 * count as f64 / (side * side) as f64;
            assert!((quadrant(x, y) - counted).abs() < 3e-3, "{x} {y}: {} {counted}", quadrant(x, y));
        }
    }
}
