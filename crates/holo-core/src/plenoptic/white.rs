//! The white image: what the camera records of a scene of radiance 1, without rays.

use std::ops::Range;

use ndarray::{Array2, ArrayViewMut2, Axis};

mod area;
mod glass;
mod points;

use self::area::{SMALL_SQUARE, area_of, clipped, quadrant, small_square};
use self::glass::LensEdges;
use self::points::{GAUSS_3, even_points, lens_points};
use super::microlenses::HEX_ROW;
use super::{LensAperture, Microlens, PlenopticCamera, PupilShape};
use crate::Error;
use crate::base::memory;
use crate::base::parallel::*;

/// Rows of pixels that are computed together.
const BAND_ROWS: usize = 64;

/// Micro-images whose edge is at least this wide, in pixels, are integrated over pixels; others over microlenses, with
/// the exact share of the pixel that the pupil's image covers.
const WIDE_EDGE_PX: f64 = 0.5;

/// Micro-images whose edge is narrower than this, in pixels, have the edge of the light through one point of the
/// microlens. An edge along the border of a pixel loses 0.21 of its width: 1e-3 of the pixel.
const SHARP_EDGE_PX: f64 = 0.005;

/// Gauss-Legendre places within a pixel: two, from -1/2 to 1/2.
const GAUSS: [f64; 2] = [-0.288_675_134_594_812_9, 0.288_675_134_594_812_9];

impl PlenopticCamera {
    /// Returns the white image: for every pixel the light of a scene of radiance 1, relative to the center of an
    /// unvignetted micro-image on the axis. Axes (row, column).
    ///
    /// It contains the vignetting by both apertures and the cos^4 law, and the light of several microlenses where their
    /// micro-images overlap. Raw image / white image is the mean radiance that a pixel sees.
    ///
    /// # Accuracy
    ///
    /// Quadrature over pixel and microlens, for microlenses of f/1.6 or slower: 2e-4 of the whole light. If the image of
    /// the pupil moves by less than 0.05 px over a microlens, single pixels at the edges of micro-images are within 2e-3,
    /// and the light of all pixels in which micro-images overlap is within 5e-4; if it moves farther, single pixels are
    /// within 2e-2, with a deviation of 5e-3. So are those at the edges of the light of a lens of glass, where the whole light is within
    /// 5e-4 also where it ends.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the image does not fit into memory.
    pub fn white_image(&self) -> Result<Array2<f32>, Error> {
        self.white_rows(0..self.sensor().size.rows)
    }

    /// Returns some rows of the [white image](Self::white_image), with the same values; without those beyond the sensor.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the rows do not fit into memory.
    pub fn white_rows(&self, rows: Range<usize>) -> Result<Array2<f32>, Error> {
        let size = self.sensor().size;
        let rows = rows.start..rows.end.min(size.rows);
        let values = memory::filled("a white image", rows.len() * size.columns, 0.0f32)?;
        let mut image = Array2::from_shape_vec((rows.len(), size.columns), values).map_err(|_| Error::Shape {
            what: "white image",
            expected: vec![rows.len(), size.columns],
            found: Vec::new(),
        })?;
        let mut bands: Vec<_> = image.axis_chunks_iter_mut(Axis(0), BAND_ROWS).enumerate().collect();
        let rule = Rule::new(self);
        bands.par_iter_mut().for_each(|(number, band)| self.white_band(&rule, rows.start + *number * BAND_ROWS, band));
        Ok(image)
    }

    /// Adds the light of all microlenses to the rows from `first` on.
    fn white_band(&self, rule: &Rule, first: usize, band: &mut ArrayViewMut2<f32>) {
        let rows = first..first + band.nrows();
        for line in self.lens_lines(rows.clone()) {
            for lens in self.lenses_on_line(line, rows.clone()).flat_map(|lens| self.openings(lens)) {
                let edge = match rule.edges[lens.lens_type] {
                    Edge::Wide(_) if self.has_glass() && lens.lens_type < self.array().type_count() => Edge::OfGlass,
                    Edge::Wide(_) if self.has_glass() => Edge::Stopped,
                    edge if self.is_clear_of_stops(&lens) => edge,
                    _ => Edge::Stopped,
                };
                let light = Light::new(self, rule, lens);
                for (row, columns) in self.lit_pixels(&lens, rows.clone()) {
                    for column in columns {
                        let middle = self.place_m([column as f64 + 0.5, row as f64 + 0.5]);
                        band[[row - first, column]] += (light.of_pixel(middle, edge) * rule.relative) as f32;
                    }
                }
            }
        }
    }

    /// Whether lit regions of a microlens or gap are sampled in a rectangle around them.
    fn is_masked(&self, lens: &Microlens) -> bool {
        if lens.lens_type == self.array().type_count() {
            return true;
        }
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
        central_cos4(self.array().aperture, self.array().gap_m)
    }
}

/// The mean of cos^4 over an aperture whose center faces a place at a distance.
///
/// In polar coordinates the integral along the radius is R^2 d^2 / (2 (d^2 + R^2)). R is constant for a disc, and
/// half width / cos(angle) for the sides of a polygon, so that the integral along the angle is an arc tangent.
fn central_cos4(aperture: LensAperture, gap_m: f64) -> f64 {
    let of_polygon = |half_width_m: f64, half_side_m: f64| {
        let slant_m = half_width_m.hypot(gap_m);
        gap_m * gap_m / (half_side_m * slant_m) * (half_side_m / slant_m).atan()
    };
    match aperture {
        LensAperture::Round { radius_m } => 1.0 / (1.0 + (radius_m / gap_m).powi(2)),
        LensAperture::Square { half_width_m } => of_polygon(half_width_m, half_width_m),
        // Half of a side is half width / sqrt(3).
        LensAperture::Hexagon { half_width_m } => of_polygon(half_width_m, half_width_m / (2.0 * HEX_ROW)),
    }
}

/// The edge of the micro-images of a type of microlens.
#[derive(Clone, Copy)]
enum Edge {
    /// The pupil's image hardly moves over the microlens: its edge is that of the middle of the light on the microlens.
    Sharp,
    /// It moves by less than a pixel: cos^4 and the lit part of the pixel are integrated over points of the microlens.
    Narrow,
    /// It moves by several pixels, or the microlens is larger than the pupil's image: integrated over points of the
    /// pixel, this many along each side.
    Wide(usize),
    /// It moves by more, behind a lens of glass: integrated over many points of the microlens.
    OfGlass,
    /// Further stops may block a part, or a lens of glass that of a gap: integrated over points of both.
    Stopped,
}

/// What all pixels of a white image have in common.
struct Rule {
    /// 1 / the light of an unvignetted pixel on the axis.
    relative: f64,
    /// Points of a microlens and their weights, exact to the fifth degree.
    points: Vec<([f64; 2], f64)>,
    /// The mean of x^2 over them.
    spread_m2: f64,
    /// Many points that stand for the same area each.
    even_points: Vec<[f64; 2]>,
    edges: Vec<Edge>,
    /// The mean of cos^4 over pixel and microlens, by the squared distance of their centers, so many entries per m^2; for round
    /// microlenses.
    cos4: Vec<f64>,
    per_squared_m: f64,
}

/// The number of entries of the table of cos^4.
const ENTRIES: usize = 512;

impl Rule {
    fn new(camera: &PlenopticCamera) -> Self {
        let (array, pixel) = (camera.array(), camera.sensor().pixel_m);
        let edge = |lens_type: usize| {
            if lens_type == array.type_count() {
                // The light through a gap has the edge of the gap.
                return Edge::Wide(4);
            }
            let moved = camera.alpha(lens_type).abs() * array.aperture.half_width_m();
            let moved_px = moved * array.gap_m / camera.exit_pupil_m() / pixel;
            if moved > camera.exit_pupil_radius_m() || moved_px >= WIDE_EDGE_PX {
                Edge::Wide(if moved_px < 4.0 { 4 } else { 2 })
            } else if moved_px < SHARP_EDGE_PX {
                Edge::Sharp
            } else {
                Edge::Narrow
            }
        };
        let points = lens_points(array.aperture, array.rotation_rad);
        let mut rule = Self {
            relative: 1.0 / camera.central_cos4(),
            spread_m2: points.iter().map(|&(point, weight)| weight * point[0] * point[0]).sum(),
            points,
            even_points: even_points(array.aperture, array.rotation_rad),
            edges: (0..array.type_count() + usize::from(array.has_clear_gaps)).map(edge).collect(),
            cos4: Vec::new(),
            per_squared_m: 0.0,
        };
        if matches!(array.aperture, LensAperture::Round { .. }) {
            // From the center of a microlens to the farthest pixel that it lights.
            let size = camera.sensor().size;
            let corners = [
                [0.0, 0.0],
                [size.columns as f64, 0.0],
                [0.0, size.rows as f64],
                [size.columns as f64, size.rows as f64],
            ];
            let shift = array.gap_m / camera.exit_pupil_m();
            let dark = (0..array.type_count()).map(|k| camera.micro_image_radii_m(k)[2]).fold(0.0, f64::max);
            let corner =
                corners.map(|corner| camera.place_m(corner)).map(|[x, y]| x.hypot(y)).into_iter().fold(0.0, f64::max);
            let farthest = (corner + dark + pixel) * shift + dark + 2.0 * pixel;
            rule.per_squared_m = (ENTRIES - 2) as f64 / (farthest * farthest);
            let width = pixel * camera.sensor().fill;
            let mean = |k: usize| {
                let away = (k as f64 / rule.per_squared_m).sqrt();
                let places = GAUSS.iter().flat_map(|&y| GAUSS.map(|x| [away + x * width, y * width]));
                places.map(|place| rule.over_lens(|point| cos4(place, point, array.gap_m))).sum::<f64>() / 4.0
            };
            rule.cos4 = (0..ENTRIES).map(mean).collect();
        }
        rule
    }

    /// The mean of a smooth function over the points of a microlens.
    fn over_lens(&self, function: impl Fn([f64; 2]) -> f64) -> f64 {
        self.points.iter().map(|&(point, weight)| weight * function(point)).sum()
    }
}

/// The light through a microlens. Places on the sensor are from the axis, points of the microlens from its center.
struct Light<'a> {
    camera: &'a PlenopticCamera,
    rule: &'a Rule,
    lens: Microlens,
    /// Within the square of this distance from the center of the micro-image light through all of the microlens reaches all
    /// of a pixel; below 0 if it does nowhere.
    whole_squared: f64,
    /// A distance on the sensor per distance on the exit pupil, and 1 / the image of its radius there, 1/m.
    scale: f64,
    per_radius: f64,
    /// The squared distances from the middle of the pupil's image within which it covers all of a pixel, and from which on
    /// nothing.
    covered: [f64; 2],
    /// The edges of the light of a lens of glass.
    edges: Option<LensEdges>,
}

impl<'a> Light<'a> {
    fn new(camera: &'a PlenopticCamera, rule: &'a Rule, lens: Microlens) -> Self {
        let inner = camera.main_lens().aperture.inner_and_outer()[0] * lens.pupil.inner_m;
        let outer_m = camera.array().aperture.outer_radius_m();
        let moved = lens.alpha.abs() * outer_m;
        let scale = lens.gap_m / lens.pupils.exit_m;
        let radius_m = scale * camera.exit_pupil_radius_m();
        let mut light = Self {
            camera,
            rule,
            lens,
            whole_squared: -1.0,
            scale,
            per_radius: 1.0 / radius_m,
            covered: [0.0; 2],
            edges: camera.glass.as_ref().map(|glass| LensEdges::new(glass.table(), &lens, outer_m)),
        };
        let reach = light.width_m() * std::f64::consts::FRAC_1_SQRT_2;
        let squared = |within: f64| if within >= 0.0 { within * within } else { -1.0 };
        light.whole_squared = squared(scale * (inner - moved) - reach);
        light.covered = [squared(radius_m - reach), squared(radius_m + reach)];
        light
    }

    /// The light that the pixel around a place gets: its share of the white image, before the division by that of an
    /// unvignetted pixel.
    #[inline]
    fn of_pixel(&self, middle: [f64; 2], edge: Edge) -> f64 {
        match edge {
            Edge::Sharp | Edge::Narrow | Edge::OfGlass if self.is_lit_whole(middle) => self.mean_cos4(middle),
            Edge::Sharp => {
                if let Some(edges) = &self.edges {
                    return self.sharp_of_glass(edges, middle);
                }
                let share = self.covered_share(self.middle_of_light(middle), middle);
                if share > 0.0 { share * self.mean_cos4(self.lit_place(middle, share)) } else { 0.0 }
            }
            Edge::Narrow => match &self.edges {
                Some(edges) => self.narrow_of_glass(edges, middle),
                None => self.rule.over_lens(|point| {
                    let share = self.covered_share(point, middle);
                    if share > 0.0 { self.cos4_of(share, self.lit_place(middle, share), point) } else { 0.0 }
                }),
            },
            Edge::OfGlass => self.edges.as_ref().map_or(0.0, |edges| self.of_glass(edges, middle)),
            Edge::Wide(steps) => self.wide(middle, steps),
            Edge::Stopped => self.stopped(middle),
        }
    }

    /// cos^4 of the light from a point of the microlens to a place on the sensor.
    fn cos4(&self, place: [f64; 2], point: [f64; 2]) -> f64 {
        let Microlens { center_m, gap_m, .. } = self.lens;
        cos4([place[0] - center_m[0], place[1] - center_m[1]], point, gap_m)
    }

    /// The light from a point of the microlens to the lit part of a pixel: its share, and its middle.
    fn cos4_of(&self, share: f64, place: [f64; 2], point: [f64; 2]) -> f64 {
        share * self.cos4_over(place, share.sqrt() * self.width_m(), point)
    }

    /// The mean of cos^4 of the light from a point of the microlens to a square around a place on the sensor.
    fn cos4_over(&self, place: [f64; 2], width_m: f64, point: [f64; 2]) -> f64 {
        let at = |x: f64, y: f64| self.cos4([place[0] + x * width_m, place[1] + y * width_m], point);
        let [low, high] = GAUSS;
        (at(low, low) + at(high, low) + at(low, high) + at(high, high)) / 4.0
    }

    /// The mean of cos^4 over the microlens and a pixel around a place.
    #[inline]
    fn mean_cos4(&self, place: [f64; 2]) -> f64 {
        if self.rule.cos4.is_empty() || self.lens.gap_m != self.camera.array().gap_m {
            return self.rule.over_lens(|point| self.cos4_over(place, self.width_m(), point));
        }
        let [x, y] = [place[0] - self.lens.center_m[0], place[1] - self.lens.center_m[1]];
        let at = (x * x + y * y) * self.rule.per_squared_m;
        let k = (at as usize).min(ENTRIES - 2);
        let (low, high) = (self.rule.cos4[k], self.rule.cos4[k + 1]);
        low + (high - low) * (at - k as f64)
    }

    /// The point of the microlens that is the middle of the light to a place: points nearer to the place give it more. A
    /// share of the pixel that is linear over the microlens has its mean, weighted with cos^4, there.
    fn middle_of_light(&self, place: [f64; 2]) -> [f64; 2] {
        let Microlens { center_m, gap_m, .. } = self.lens;
        let away = [place[0] - center_m[0], place[1] - center_m[1]];
        // From the center towards the place, cos^4 grows by 4 r / (d^2 + r^2) of itself per meter.
        let lean = 4.0 * self.rule.spread_m2 / (gap_m * gap_m + away[0] * away[0] + away[1] * away[1]);
        away.map(|x| x * lean)
    }

    /// Whether light through all of the microlens reaches all of a pixel.
    fn is_lit_whole(&self, middle: [f64; 2]) -> bool {
        let [x, y] = self.on_sensor(middle);
        x * x + y * y <= self.whole_squared
    }

    /// The middle of the lit part of a pixel that an edge crosses, which lies towards the center.
    fn lit_place(&self, middle: [f64; 2], share: f64) -> [f64; 2] {
        if share >= 1.0 {
            return middle;
        }
        let pixel = self.width_m();
        let [x, y] = self.lens.image_center_m;
        let away = [x - middle[0], y - middle[1]];
        let length = (away[0] * away[0] + away[1] * away[1]).sqrt();
        let inwards = (1.0 - share) / 2.0 * pixel / length.max(pixel);
        [middle[0] + away[0] * inwards, middle[1] + away[1] * inwards]
    }

    /// The width of the light-sensitive part of a pixel.
    fn width_m(&self) -> f64 {
        self.camera.sensor().fill * self.camera.sensor().pixel_m
    }

    /// A place on the sensor from the center of the micro-image.
    fn on_sensor(&self, place: [f64; 2]) -> [f64; 2] {
        [place[0] - self.lens.image_center_m[0], place[1] - self.lens.image_center_m[1]]
    }

    /// A wide edge is smooth over a pixel, and cos^4 over all that a pixel sees: the area is integrated over the pixel,
    /// and so is cos^4 over the part of the microlens that its center sees.
    fn wide(&self, middle: [f64; 2], steps: usize) -> f64 {
        let camera = self.camera;
        let pixel = self.width_m();
        let region = |place: [f64; 2]| camera.relative_lit_region(&self.lens, self.on_sensor(place));
        let offset = |k: usize| match steps {
            2 => GAUSS[k],
            _ => (k as f64 + 0.5) / steps as f64 - 0.5,
        };
        let at = |k: usize| [middle[0] + offset(k % steps) * pixel, middle[1] + offset(k / steps) * pixel];
        let places = (0..steps * steps).map(at);
        if camera.is_masked(&self.lens) {
            // Counted: many points, which no straight edge follows.
            return places.map(|place| self.counted(place, &region(place))).sum::<f64>() / (steps * steps) as f64;
        }
        let area = places.map(|place| region(place).sampled_area_m2()).sum::<f64>() / (steps * steps) as f64;
        if area == 0.0 {
            return 0.0;
        }
        let center = region(middle);
        let points = GAUSS_3.iter().flat_map(|&(u, weight)| GAUSS.map(|v| ([u, v + 0.5], weight / 2.0)));
        let mean = match center.is_empty() {
            true => self.cos4_over(middle, pixel, [0.0; 2]),
            false => {
                let light =
                    |(unit, weight): ([f64; 2], f64)| Some(weight * self.cos4_over(middle, pixel, center.point(unit)?));
                points.filter_map(light).sum()
            }
        };
        area * mean / camera.array().aperture.area_m2()
    }

    /// The light that a place gets through a region of which points are counted.
    fn counted(&self, place: [f64; 2], region: &super::LitRegion) -> f64 {
        if region.is_empty() {
            return 0.0;
        }
        let inside = evenly_spread(PLANE_STEPS, 256).filter_map(|unit| region.point(unit));
        let sum = inside.map(|point| self.cos4(place, point)).sum::<f64>();
        sum / 256.0 * region.sampled_area_m2() / self.camera.array().aperture.area_m2()
    }

    /// The light that further stops or a lens of glass let pass: of rays from points of the pixel through points of the
    /// microlens.
    fn stopped(&self, middle: [f64; 2]) -> f64 {
        let pixel = self.width_m();
        // Every pixel has its own points, so that their errors cancel.
        let position = self.camera.position_px(middle).map(f64::floor);
        let shift: [f64; 4] = std::array::from_fn(|k| position[0] * SPACE_STEPS[k] + position[1] * SPACE_STEPS[3 - k]);
        let light = |point: [f64; 4]| {
            let [u, v, x, y]: [f64; 4] = std::array::from_fn(|k| (point[k] + shift[k]).fract());
            let place = [middle[0] + (x - 0.5) * pixel, middle[1] + (y - 0.5) * pixel];
            let on_sensor = self.on_sensor(place);
            let region = self.camera.relative_lit_region(&self.lens, on_sensor);
            let point = region.point([u, v])?;
            let passes = self.camera.lets_pass(&self.lens, on_sensor, point);
            passes.then(|| self.cos4(place, point) * region.sampled_area_m2())
        };
        let sum = evenly_spread(SPACE_STEPS, STOPPED_POINTS).filter_map(light).sum::<f64>();
        sum / f64::from(STOPPED_POINTS) / self.camera.array().aperture.area_m2()
    }

    /// The share of a pixel that light through one point of the microlens reaches: that of the image of the pupil.
    fn covered_share(&self, point: [f64; 2], middle: [f64; 2]) -> f64 {
        let (camera, pixel) = (self.camera, self.width_m());
        let from = self.on_sensor(middle);
        let from = [0, 1].map(|k| from[k] - self.scale * self.lens.alpha * point[k]);
        let per_radius = self.per_radius;
        let [low, high] = [-0.5, 0.5].map(|side| from.map(|x| (x + side * pixel) * per_radius));
        let unit = pixel * per_radius;
        match camera.main_lens().aperture {
            PupilShape::Square => {
                let width = [0, 1].map(|k| (high[k].min(1.0) - low[k].max(-1.0)).max(0.0) / unit);
                width[0] * width[1]
            }
            PupilShape::Round => {
                let squared = from[0] * from[0] + from[1] * from[1];
                let [all, nothing] = self.covered;
                if squared <= all {
                    return 1.0;
                }
                if squared >= nothing {
                    return 0.0;
                }
                let center = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
                let area = if unit <= SMALL_SQUARE {
                    small_square(center, unit)
                } else {
                    quadrant(high[0], high[1]) - quadrant(low[0], high[1]) - quadrant(high[0], low[1])
                        + quadrant(low[0], low[1])
                };
                (area / (unit * unit)).clamp(0.0, 1.0)
            }
            PupilShape::Polygon { .. } => {
                let sign = self.lens.pupils.magnification.signum();
                let corners = [low, [high[0], low[1]], high, [low[0], high[1]]].map(|corner| corner.map(|x| x * sign));
                area_of(&clipped(corners.to_vec(), &camera.main_lens().aperture.corners())) / (unit * unit)
            }
        }
    }
}

/// The number of points of a pixel and the microlens where stops vignette: a mean error of 0.01 a pixel.
const STOPPED_POINTS: u32 = 128;

/// Steps of evenly spread points in two and in four dimensions: powers of the real roots of 1 / x^(n + 1) = 1 + 1 / x.
///
/// Source: Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018).
const PLANE_STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
const SPACE_STEPS: [f64; 4] =
    [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_806_4, 0.538_597_256_661_187];

/// Points of the unit cube, evenly spread.
fn evenly_spread<const N: usize>(steps: [f64; N], count: u32) -> impl Iterator<Item = [f64; N]> {
    (0..count).map(move |k| steps.map(|step| ((f64::from(k) + 0.5) * step).fract()))
}

/// cos^4 of the light from a point to a place over a gap.
fn cos4(place: [f64; 2], point: [f64; 2], gap_m: f64) -> f64 {
    let [x, y] = [point[0] - place[0], point[1] - place[1]];
    let squared = 1.0 + (x * x + y * y) / (gap_m * gap_m);
    1.0 / (squared * squared)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows are those of the whole image, also where bands begin elsewhere, and none are beyond the sensor.
    #[test]
    fn rows_are_those_of_the_image() {
        let array = crate::plenoptic::MicrolensArray::new(crate::plenoptic::MicrolensGrid::HexRows, 5e-5, 3e-4);
        let sensor = crate::plenoptic::ImageSensor::new(crate::GridSize::new(90, 40), 5e-6);
        let camera = PlenopticCamera::new(sensor, array, crate::plenoptic::MainLens::new(0.05, 5.6, 3.0)).unwrap();
        let image = camera.white_image().unwrap();
        assert!(image.iter().any(|&light| light > 0.5));
        for rows in [0..90, 7..53, 33..34, 60..200, 90..100] {
            let inside = rows.start..rows.end.min(90);
            assert_eq!(camera.white_rows(rows).unwrap(), image.slice_axis(Axis(0), inside.into()));
        }
    }
}
