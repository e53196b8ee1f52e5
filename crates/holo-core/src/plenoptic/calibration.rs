//! A camera from its white image: where its micro-images lie, and how large they are.

use ndarray::{Array2, ArrayView2};

use super::lattice::{self, Lattice};
use super::white_grid::Displacement;
use super::{
    ArrayFocus, ImageSensor, MainLens, MicrolensArray, MicrolensFocus, MicrolensGrid, MicrolensIndex, PlenopticCamera,
};
use crate::base::parallel::*;
use crate::{Error, GridSize};

/// Steps from the lattice of the middle to that of the whole sensor: each leaves a fiftieth of a displacement.
const STEPS: usize = 8;

/// A smaller displacement is not corrected further, px.
const NEAR_PX: f64 = 2e-3;

/// From here on a tilt is looked for, px: the steps before it would only fit a plane to what the tilt explains.
const TILT_FROM_PX: f64 = 0.5;

/// Another tilt of the array that displaces all micro-images by less is not told from noise, px.
const TILT_PX: f64 = 0.05;

/// The assumed gap of an unknown camera, in pitches. It sets how disparity follows from depth.
const GAP_PITCHES: f64 = 10.0;

/// The focal length of its main lens.
const FOCAL_M: f64 = 50e-3;

/// Micro-images of three types differ in their radii by this part, and by that many standard errors.
const DIFFERENCE: f64 = 0.01;
const ERRORS: f64 = 6.0;

/// A micro-image with less than this part of the light of the brightest ones is not measured.
const DARK: f32 = 0.1;

/// Parts of the pixels around a micro-image, per thousand, that may be darker than its light: the first one for which they are.
const DARKER: [usize; 3] = [900, 970, 990];

/// A camera whose micro-images lie where a white image has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The camera: the arrangement, pitch, rotation, place and scale of its array are those of the white image.
    pub camera: PlenopticCamera,
    /// The number of micro-images that were compared: all that lie on the sensor as a whole, and are lit.
    pub count: usize,
    /// The root mean square of the distances of their centers of light from those of the camera, in pixels.
    pub rms_px: f64,
    /// The largest of these distances, in pixels.
    pub largest_px: f64,
    /// The mean radius of the micro-images of every type, as discs of the same light, in pixels: three if they differ.
    pub radii_px: Vec<f64>,
}

/// A micro-image as it is measured.
#[derive(Clone, Copy)]
struct Spot {
    lens: MicrolensIndex,
    /// The center of its light.
    center_px: [f64; 2],
    /// The area of an evenly bright spot of the same light.
    area_px: f64,
}

impl PlenopticCamera {
    /// Finds the microlens array of a camera by a white image. Of this camera everything else is taken: pixels, gap, main lens.
    ///
    /// `None`: the image has no square or hexagonal lattice of at least 4 px, or fewer than a dozen micro-images a side.
    ///
    /// # Shape
    ///
    /// Axes (row, column), the size of the sensor; any unit of light. A mosaic of colors does not matter.
    ///
    /// # Accuracy
    ///
    /// Micro-images of at least 9 px, whose vignetting the camera describes: 0.05 px over the sensor; 0.1 px with noise of a
    /// tenth of the light in every pixel. A tilt of the array is that of this camera, unless another one displaces micro-images by
    /// 0.05 px or more: it then follows from how their scale grows over the sensor, and from the exit pupil of this camera. Which of
    /// the lattice's places has the number (0, 0) is not known from an image: the one nearest to the middle has.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the image has not the size of the sensor; [`Error::BadNumber`] if such a camera forms no image;
    /// [`Error::OutOfMemory`].
    pub fn calibrated(&self, white: ArrayView2<f32>) -> Result<Option<Calibration>, Error> {
        self.calibrated_with(white, true)
    }

    /// The same; the tilt of the array is only looked for where the pupil is known.
    fn calibrated_with(&self, white: ArrayView2<f32>, has_tilt: bool) -> Result<Option<Calibration>, Error> {
        self.check_white(white)?;
        let Some(lattice) = lattice::find(white) else { return Ok(None) };
        let Some(near) = self.with_lattice(&lattice)?.nearer(white, TILT_FROM_PX)? else { return Ok(None) };
        let tilted = if has_tilt { near.with_another_tilt(white)? } else { None };
        let camera = match tilted {
            Some(tilted) => tilted,
            None => match near.nearer(white, NEAR_PX)? {
                Some(camera) => camera,
                None => return Ok(None),
            },
        };
        let spots = camera.spots(white);
        if spots.is_empty() {
            return Ok(None);
        }
        let (camera, radii_px) = camera.with_types(&spots)?;
        let own = camera.spots(camera.white_image()?.view());
        let (count, rms_px, largest_px) = distances(&camera.spots(white), &own);
        Ok(Some(Calibration { camera, count, rms_px, largest_px, radii_px }))
    }

    /// Finds an unknown camera by a white image and the width of a pixel. Its gap, main lens and f-number are such that
    /// the micro-images are as large as those of the image, and say nothing about depths.
    ///
    /// # Errors
    ///
    /// Those of [`calibrated`](Self::calibrated).
    pub fn of_white_image(white: ArrayView2<f32>, pixel_m: f64) -> Result<Option<Calibration>, Error> {
        let Some(lattice) = lattice::find(white) else { return Ok(None) };
        let (rows, columns) = white.dim();
        let sensor = ImageSensor::new(GridSize::new(rows, columns), pixel_m);
        let gap_m = GAP_PITCHES * lattice.pitch_px * pixel_m;
        let array = MicrolensArray::new(lattice.grid, lattice.pitch_px * pixel_m, gap_m);
        let of = |f_number: f64| {
            let mut lens = MainLens::new(FOCAL_M, f_number, 1.0);
            lens.focus = ArrayFocus::Distance { mla_distance_m: FOCAL_M };
            Self::new(sensor, array.clone(), lens)
        };
        let Some(first) = of(GAP_PITCHES)?.calibrated_with(white, false)? else { return Ok(None) };
        let largest_px = first.radii_px.iter().fold(0.0, |a: f64, b| a.max(*b));
        of(gap_m / (2.0 * largest_px * pixel_m).max(pixel_m))?.calibrated_with(white, false)
    }

    /// The camera whose lattice lies this near to that of the white image, or as near as it comes.
    fn nearer(self, white: ArrayView2<f32>, until_px: f64) -> Result<Option<Self>, Error> {
        let mut camera = self;
        for _ in 0..STEPS {
            let Some(displacement) = camera.white_displacement(white, false)? else { return Ok(None) };
            camera = camera.displaced(&displacement)?;
            if displacement.largest_px() < until_px {
                break;
            }
        }
        Ok(Some(camera))
    }

    /// The camera whose array has another tilt; `None` if the white image does not show one, or not such a camera.
    fn with_another_tilt(&self, white: ArrayView2<f32>) -> Result<Option<Self>, Error> {
        let mut camera: Option<Self> = None;
        for _ in 0..STEPS {
            let known = camera.as_ref().unwrap_or(self);
            let Some(displacement) = known.white_displacement(white, true)? else { return Ok(None) };
            if camera.is_none() && displacement.largest_of_growth_px() < TILT_PX {
                break;
            }
            let Ok(next) = known.displaced(&displacement) else { return Ok(None) };
            camera = Some(next);
            if displacement.largest_px() < NEAR_PX {
                break;
            }
        }
        Ok(camera)
    }

    /// Returns this camera with another lattice. One of its micro-images lies in the middle of the sensor.
    fn with_lattice(&self, lattice: &Lattice) -> Result<Self, Error> {
        let mut array = self.array().clone();
        let pitch_m = lattice.pitch_px * self.sensor().pixel_m / self.micro_image_scale();
        array.aperture = array.aperture.scaled(pitch_m / array.pitch_m);
        (array.grid, array.pitch_m, array.rotation_rad) = (lattice.grid, pitch_m, lattice.rotation_rad);
        (array.scale_y, array.offset_m) = (1.0, [0.0; 2]);
        Self::new(*self.sensor(), array, self.main_lens().clone())
    }

    /// The same camera with micro-images that are displaced.
    fn displaced(&self, displacement: &Displacement) -> Result<Self, Error> {
        let origin = self.micro_image_center_px(MicrolensIndex { row: 0, column: 0 });
        let [right, down] = displacement.at(origin);
        let per_px = self.sensor().pixel_m / self.micro_image_scale();
        let ([x, y], rotation_rad) = displacement.scales_and_rotation();
        let mut array = self.array().clone();
        array.offset_m = [array.offset_m[0] + right * per_px, array.offset_m[1] - down * per_px];
        array.aperture = array.aperture.scaled(x.min(y));
        array.pitch_m *= x;
        array.scale_y *= y / x;
        array.rotation_rad += rotation_rad;
        // A microlens nearer to the exit pupil by h has a micro-image that is 1 + h / exit larger.
        let slope_per_growth = self.micro_image_scale() * self.exit_pupil_m() / self.sensor().pixel_m;
        let [right, down] = displacement.growth().map(|growth| growth * slope_per_growth);
        array.tilt_rad = [array.tilt_rad[0].tan() + right, array.tilt_rad[1].tan() - down].map(f64::atan);
        Self::new(*self.sensor(), array, self.main_lens().clone())
    }

    /// The micro-images that lie on the sensor as a whole, and are lit.
    fn spots(&self, white: ArrayView2<f32>) -> Vec<Spot> {
        let (rows, columns) = white.dim();
        let reach = self.micro_image_pitch_px() * self.array().scale_y.min(1.0) / 2.0;
        let brightest = white.iter().copied().fold(0.0, f32::max);
        let lines: Vec<i32> = self.lens_lines(0..rows).collect();
        let of_line = |line: i32| {
            let mut spots = Vec::new();
            for lens in self.lenses_on_line(line, 0..rows) {
                let center = self.micro_image_center_px(lens);
                let is_inside = center[0] >= reach
                    && center[1] >= reach
                    && center[0] + reach < columns as f64
                    && center[1] + reach < rows as f64;
                if is_inside && let Some(spot) = spot(white, lens, center, reach, brightest) {
                    spots.push(spot);
                }
            }
            spots
        };
        let found: Vec<Vec<Spot>> = lines.into_par_iter().map(of_line).collect();
        found.into_iter().flatten().collect()
    }

    /// The camera with its number (0, 0) where its types are as the spots have them, and the radii of the types.
    fn with_types(self, spots: &[Spot]) -> Result<(Self, Vec<f64>), Error> {
        let all = Radii::of(spots, |_| 0);
        if self.array().grid == MicrolensGrid::Square {
            return Ok((self, vec![all.mean(0)]));
        }
        let mut three = self.array().clone();
        three.focus = MicrolensFocus::Lengths(vec![three.gap_m; 3]);
        let found = Radii::of(spots, |lens| three.type_of(lens));
        if ![[0, 1], [1, 2], [0, 2]].into_iter().any(|[a, b]| found.differ(a, b)) {
            return Ok((self, vec![all.mean(0)]));
        }
        let means = [0, 1, 2].map(|k| found.mean(k));
        if self.array().type_count() != 3 {
            return Ok((self, means.to_vec()));
        }
        let own = Radii::of(&self.spots(self.white_image()?.view()), |lens| three.type_of(lens));
        // The number of a type grows by one along a line of either kind of grid.
        let off = |first: usize| -> f64 { (0..3).map(|k| (means[(k + first) % 3] - own.mean(k)).powi(2)).sum() };
        let first = [0, 1, 2].into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(0);
        let next = match self.array().grid {
            MicrolensGrid::HexColumns => MicrolensIndex { row: first as i32, column: 0 },
            _ => MicrolensIndex { row: 0, column: first as i32 },
        };
        let (from, to) = (self.lens_center_m(MicrolensIndex { row: 0, column: 0 }), self.lens_center_m(next));
        let mut array = self.array().clone();
        array.offset_m = [0, 1].map(|k| array.offset_m[k] + to[k] - from[k]);
        let camera = Self::new(*self.sensor(), array, self.main_lens().clone())?;
        Ok((camera, [0, 1, 2].map(|k| means[(k + first) % 3]).to_vec()))
    }
}

/// The radii of spots by their type: number, sum and sum of the squares.
struct Radii([[f64; 3]; 3]);

impl Radii {
    fn of(spots: &[Spot], type_of: impl Fn(MicrolensIndex) -> usize) -> Self {
        let mut sums = [[0.0_f64; 3]; 3];
        for spot in spots {
            let radius = (spot.area_px / std::f64::consts::PI).sqrt();
            for (sum, value) in sums[type_of(spot.lens)].iter_mut().zip([1.0, radius, radius * radius]) {
                *sum += value;
            }
        }
        Self(sums)
    }

    fn mean(&self, k: usize) -> f64 {
        self.0[k][1] / self.0[k][0].max(1.0)
    }

    /// The standard error of the mean.
    fn error(&self, k: usize) -> f64 {
        let [count, _, squares] = self.0[k];
        ((squares / count.max(1.0) - self.mean(k).powi(2)).max(0.0) / count.max(1.0)).sqrt()
    }

    /// Whether two types have different radii.
    fn differ(&self, a: usize, b: usize) -> bool {
        let difference = (self.mean(a) - self.mean(b)).abs();
        difference > DIFFERENCE * self.mean(a) && difference > ERRORS * self.error(a).hypot(self.error(b))
    }
}

/// The light within half a pitch of a place; `None` where it is dark.
fn spot(white: ArrayView2<f32>, lens: MicrolensIndex, at: [f64; 2], reach: f64, brightest: f32) -> Option<Spot> {
    let pixels = |axis: usize| (at[axis] - reach).floor().max(0.0) as usize..(at[axis] + reach).ceil() as usize;
    let (rows, columns) = (pixels(1), pixels(0));
    let is_within =
        |v: usize, u: usize| (v as f64 + 0.5 - at[1]).hypot(u as f64 + 0.5 - at[0]) <= reach && v < white.nrows();
    let places = || {
        let columns = columns.clone();
        rows.clone().flat_map(move |v| columns.clone().map(move |u| (v, u)))
    };
    let mut values: Vec<f32> =
        places().filter(|(v, u)| is_within(*v, *u)).filter_map(|place| white.get(place).copied()).collect();
    if values.is_empty() {
        return None;
    }
    // Noise has no part in what nine of ten pixels are below, or nearly all if the spot is so small.
    let of_darker = |per_thousand: usize| {
        let number = values.len() * per_thousand / 1000;
        *values.select_nth_unstable_by(number, f32::total_cmp).1
    };
    let top = DARKER.into_iter().map(of_darker).find(|top| *top > DARK * brightest)?;
    let (mut sum, mut moments) = (0.0, [0.0; 2]);
    for (v, u) in places().filter(|(v, u)| is_within(*v, *u)) {
        let light = f64::from((white.get((v, u)).copied().unwrap_or(0.0) / top).clamp(0.0, 1.0));
        sum += light;
        moments[0] += light * (u as f64 + 0.5 - at[0]);
        moments[1] += light * (v as f64 + 0.5 - at[1]);
    }
    let center_px = [0, 1].map(|k| at[k] + moments[k] / sum);
    Some(Spot { lens, center_px, area_px: sum })
}

/// How far the centers of spots lie from those of others: their number, the root mean square and the largest distance.
fn distances(found: &[Spot], own: &[Spot]) -> (usize, f64, f64) {
    let known: std::collections::BTreeMap<MicrolensIndex, [f64; 2]> =
        own.iter().map(|spot| (spot.lens, spot.center_px)).collect();
    let (mut count, mut squares, mut largest) = (0, 0.0, 0.0_f64);
    for spot in found {
        if let Some(center) = known.get(&spot.lens) {
            let square = (0..2).map(|k| (spot.center_px[k] - center[k]).powi(2)).sum::<f64>();
            count += 1;
            squares += square;
            largest = largest.max(square.sqrt());
        }
    }
    (count, (squares / f64::from(count.max(1) as u32)).sqrt(), largest)
}

/// Means of white images of one camera, which have less noise than one.
///
/// # Errors
///
/// [`Error::ZeroCount`] without an image, [`Error::Shape`] if their sizes differ.
pub fn mean_white_image(images: &[Array2<f32>]) -> Result<Array2<f32>, Error> {
    let [first, rest @ ..] = images else { return Err(Error::ZeroCount { what: "white images" }) };
    let mut sum = first.clone();
    for image in rest {
        if image.dim() != first.dim() {
            let (expected, found) = (first.shape().to_vec(), image.shape().to_vec());
            return Err(Error::Shape { what: "white image", expected, found });
        }
        sum += image;
    }
    Ok(sum / images.len() as f32)
}
