//! The validated camera: places on sensor and array, and its rays.

use super::main_lens::Pupils;
use super::{LitRegion, MainLens, MicrolensArray, MicrolensFocus, MicrolensIndex, PupilShape};
use crate::error::positive;
use crate::{Error, GridSize};

/// The largest number of pixels along a side of a sensor, so that every microlens has an index.
const MAX_PIXELS: usize = 1 << 24;

/// An image sensor, not validated.
///
/// # Units
///
/// Meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSensor {
    /// Rows and columns of pixels.
    pub size: GridSize,
    /// The width of a pixel.
    pub pixel_m: f64,
    /// The width of the light-sensitive square in the middle of every pixel, relative to the pixel: above 0, at most 1.
    pub fill: f64,
    /// The middle of the sensor from the optical axis, to the right and up in the image.
    pub offset_m: [f64; 2],
}

impl ImageSensor {
    /// Returns a sensor on the optical axis whose pixels are light-sensitive everywhere.
    #[must_use]
    pub const fn new(size: GridSize, pixel_m: f64) -> Self {
        Self { size, pixel_m, fill: 1.0, offset_m: [0.0; 2] }
    }
}

/// A ray into the scene, in the frame of the entrance pupil.
///
/// As for [`RigRay`](crate::RigRay) the direction along z is -1: the point at depth Z is `(origin + Z * direction, -Z)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlenopticRay {
    /// Where it crosses the entrance pupil's plane z = 0, x and y in meters.
    pub origin_m: [f64; 2],
    /// The displacement per meter of depth, in meters.
    pub direction: [f64; 2],
}

/// A validated plenoptic camera.
///
/// # Examples
///
/// ```
/// use holo_core::GridSize;
/// use holo_core::plenoptic::{ImageSensor, MainLens, MicrolensArray, MicrolensGrid, PlenopticCamera};
///
/// // Microlenses of 70 um, 14 pixels each, behind a lens of 50 mm at f/5.6 focused at 0.5 m.
/// let camera = PlenopticCamera::new(
///     ImageSensor::new(GridSize::new(420, 560), 5e-6),
///     MicrolensArray::new(MicrolensGrid::Square, 70e-6, 392e-6),
///     MainLens::new(0.05, 5.6, 0.5),
/// )?;
/// // Micro-images are a little farther apart than the microlenses.
/// assert!((camera.micro_image_pitch_px() - 14.0 * (1.0 + 392e-6 / camera.mla_distance_m())).abs() < 1e-12);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PlenopticCamera {
    sensor: ImageSensor,
    array: MicrolensArray,
    main_lens: MainLens,
    pub(super) pupils: Pupils,
    /// The focal length of every type of microlens.
    focal_lengths_m: Vec<f64>,
    /// Of every type of microlens: how far the pupil point moves over the exit pupil, per meter on the microlens.
    alphas: Vec<f64>,
}

impl PlenopticCamera {
    /// Validates a camera.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] for a number that is not finite or out of its range, and for lenses that cannot form an
    /// image: a focus distance of 0, a main lens behind the array, an entrance pupil at infinity, microlenses that
    /// overlap; [`Error::ZeroCount`] or [`Error::TooLarge`] for an impossible sensor.
    pub fn new(sensor: ImageSensor, array: MicrolensArray, main_lens: MainLens) -> Result<Self, Error> {
        for (what, count) in [("sensor rows", sensor.size.rows), ("sensor columns", sensor.size.columns)] {
            if count == 0 {
                return Err(Error::ZeroCount { what });
            }
            if count > MAX_PIXELS {
                return Err(Error::TooLarge { what: "sensor" });
            }
        }
        positive("pixel width in meters", sensor.pixel_m)?;
        if !(sensor.fill > 0.0 && sensor.fill <= 1.0) {
            return Err(Error::BadNumber { what: "fill factor", value: sensor.fill, need: "above 0 and at most 1" });
        }
        for value in sensor.offset_m {
            if !value.is_finite() {
                return Err(Error::BadNumber { what: "offset of the sensor in meters", value, need: "finite" });
            }
        }
        array.validate()?;
        let pupils = main_lens.pupils(array.gap_m)?;
        let focal_lengths_m = match &array.focus {
            MicrolensFocus::Lengths(lengths) => lengths.clone(),
            MicrolensFocus::Pupil => vec![1.0 / (1.0 / array.gap_m + 1.0 / pupils.exit_m)],
        };
        let alphas = match &array.focus {
            // Exactly 0.
            MicrolensFocus::Pupil => vec![0.0],
            MicrolensFocus::Lengths(lengths) => {
                lengths.iter().map(|f| 1.0 + pupils.exit_m * (1.0 / array.gap_m - 1.0 / f)).collect()
            }
        };
        let camera = Self { sensor, array, main_lens, pupils, focal_lengths_m, alphas };
        camera.validate_extent()?;
        Ok(camera)
    }

    /// Whether the sensor is so large beside the microlenses that their indices or rays cannot be represented.
    fn validate_extent(&self) -> Result<(), Error> {
        let size = self.sensor.size;
        for corner in [[0.0, 0.0], [size.columns as f64, size.rows as f64]] {
            let place = self.place_m(corner);
            let lenses = (place[0].abs() + place[1].abs()) / self.array.pitch_m / self.array.scale_y.min(1.0);
            if lenses.is_nan() || lenses >= f64::from(1u32 << 24) {
                return Err(Error::TooLarge { what: "number of microlenses" });
            }
            let lens = self.owner(place);
            let ray = self.ray(place, self.lens_center_m(lens), lens);
            for value in ray.origin_m.into_iter().chain(ray.direction) {
                if !value.is_finite() {
                    return Err(Error::BadNumber {
                        what: "coordinate of the camera's corner ray",
                        value,
                        need: "finite",
                    });
                }
            }
        }
        Ok(())
    }

    /// Returns the sensor.
    #[must_use]
    pub const fn sensor(&self) -> &ImageSensor {
        &self.sensor
    }

    /// Returns the microlens array.
    #[must_use]
    pub const fn array(&self) -> &MicrolensArray {
        &self.array
    }

    /// Returns the main lens.
    #[must_use]
    pub const fn main_lens(&self) -> &MainLens {
        &self.main_lens
    }

    /// Returns the focal length of every type of microlens, in meters.
    #[must_use]
    pub fn microlens_focal_lengths_m(&self) -> &[f64] {
        &self.focal_lengths_m
    }

    /// Returns the distance from the microlens array to the main lens, D, in meters.
    #[must_use]
    pub const fn mla_distance_m(&self) -> f64 {
        self.pupils.lens_m
    }

    /// Returns the distance from the microlens array to the exit pupil, D_X, in meters.
    #[must_use]
    pub const fn exit_pupil_m(&self) -> f64 {
        self.pupils.exit_m
    }

    /// Returns the distance from the main lens to the entrance pupil, towards the scene, in meters.
    #[must_use]
    pub const fn entrance_pupil_offset_m(&self) -> f64 {
        self.pupils.entrance_offset_m
    }

    /// Returns the radius (or half width) of the entrance pupil, in meters.
    #[must_use]
    pub const fn entrance_pupil_radius_m(&self) -> f64 {
        self.pupils.entrance_radius_m
    }

    /// Returns the radius (or half width) of the exit pupil, in meters.
    #[must_use]
    pub fn exit_pupil_radius_m(&self) -> f64 {
        self.pupils.entrance_radius_m / self.pupils.magnification.abs()
    }

    /// Returns 1 / depth of the plane that the main lens images onto the array, in 1/m, from the entrance pupil; 0 for
    /// infinity.
    #[must_use]
    pub const fn inverse_focus_per_m(&self) -> f64 {
        self.pupils.inverse_focus_per_m
    }

    /// Returns alpha of a type of microlens: the displacement over the exit pupil per displacement on the microlens. 0
    /// if it images the pupil sharply onto the sensor, 1 if its focal length is the gap.
    ///
    /// # Panics
    ///
    /// If there is no such type.
    #[must_use]
    pub fn alpha(&self, lens_type: usize) -> f64 {
        self.alphas[lens_type]
    }

    /// Returns the place of a pixel position in upright coordinates, in meters from the axis.
    ///
    /// # Units
    ///
    /// The position (x, y) in pixels from the upper left corner of the sensor.
    #[must_use]
    pub fn place_m(&self, position_px: [f64; 2]) -> [f64; 2] {
        let ImageSensor { size, pixel_m, offset_m, .. } = self.sensor;
        [
            (position_px[0] - size.columns as f64 / 2.0) * pixel_m + offset_m[0],
            (size.rows as f64 / 2.0 - position_px[1]) * pixel_m + offset_m[1],
        ]
    }

    /// Returns the pixel position of a place, the inverse of [`place_m`](Self::place_m).
    #[must_use]
    pub fn position_px(&self, place_m: [f64; 2]) -> [f64; 2] {
        let ImageSensor { size, pixel_m, offset_m, .. } = self.sensor;
        [
            (place_m[0] - offset_m[0]) / pixel_m + size.columns as f64 / 2.0,
            size.rows as f64 / 2.0 - (place_m[1] - offset_m[1]) / pixel_m,
        ]
    }

    /// Returns the center of a microlens, in meters from the axis.
    #[must_use]
    pub fn lens_center_m(&self, lens: MicrolensIndex) -> [f64; 2] {
        let place = self.array.place_m(lens);
        [0, 1].map(|k| place[k] + (self.sensor.offset_m[k] + self.array.offset_m[k]))
    }

    /// Returns the magnification from microlens centers to micro-image centers, 1 + d / D_X.
    #[must_use]
    pub fn micro_image_scale(&self) -> f64 {
        1.0 + self.array.gap_m / self.pupils.exit_m
    }

    /// Returns the center of the micro-image of a microlens: the projection of its center from the exit pupil, in
    /// meters from the axis.
    #[must_use]
    pub fn micro_image_center_m(&self, lens: MicrolensIndex) -> [f64; 2] {
        self.lens_center_m(lens).map(|x| x * self.micro_image_scale())
    }

    /// Returns the same as a pixel position (x, y).
    #[must_use]
    pub fn micro_image_center_px(&self, lens: MicrolensIndex) -> [f64; 2] {
        self.position_px(self.micro_image_center_m(lens))
    }

    /// Returns the distance between the centers of neighboring micro-images, in pixels.
    #[must_use]
    pub fn micro_image_pitch_px(&self) -> f64 {
        self.array.pitch_m * self.micro_image_scale() / self.sensor.pixel_m
    }

    /// Returns the microlens whose micro-image center is nearest to a place of the sensor: the owner of that place.
    #[must_use]
    pub fn owner(&self, place_m: [f64; 2]) -> MicrolensIndex {
        let scale = self.micro_image_scale();
        let from_origin = [0, 1].map(|k| place_m[k] / scale - (self.sensor.offset_m[k] + self.array.offset_m[k]));
        self.array.nearest(from_origin)
    }

    /// Returns the radii of the micro-images of a type of microlens: fully lit within the first, half of the light at
    /// the second, dark from the third on. In meters; for round microlenses and a round pupil (for other shapes the third
    /// is an upper bound).
    ///
    /// # Panics
    ///
    /// If there is no such type.
    #[must_use]
    pub fn micro_image_radii_m(&self, lens_type: usize) -> [f64; 3] {
        let scale = self.array.gap_m / self.pupils.exit_m;
        let pupil = self.exit_pupil_radius_m();
        let moved = self.alphas[lens_type].abs() * self.array.aperture.half_width_m();
        let outer = match self.main_lens.aperture {
            PupilShape::Round => pupil,
            PupilShape::Square => pupil * std::f64::consts::SQRT_2,
        };
        let outer_moved = self.alphas[lens_type].abs() * self.array.aperture.outer_radius_m();
        [scale * (pupil - moved).abs(), scale * pupil, scale * (outer + outer_moved)]
    }

    /// Returns the ray from a place on the sensor through a point of a microlens, both in meters in upright coordinates.
    /// It may miss the pupil, see [`passes`](Self::passes).
    ///
    /// All rays through one point of a microlens meet in one point of the plane in focus.
    ///
    /// # Source
    ///
    /// Thin lenses one after the other, collected: with C' the [center of the micro-image](Self::micro_image_center_m),
    /// origin = m (D_X / d) (X - C') - m alpha (Q - C), direction = g Q - origin / F, g = (1 + o_E / F) / D.
    ///
    /// # Accuracy
    ///
    /// Rounding of f64.
    #[must_use]
    pub fn ray(&self, place_m: [f64; 2], lens_point_m: [f64; 2], lens: MicrolensIndex) -> PlenopticRay {
        let center = self.lens_center_m(lens);
        let scale = self.micro_image_scale();
        let on_sensor = [0, 1].map(|k| place_m[k] - center[k] * scale);
        let on_lens = [0, 1].map(|k| lens_point_m[k] - center[k]);
        self.relative_ray(center, self.array.type_of(lens), on_sensor, on_lens)
    }

    /// Returns the same ray by the center of the microlens, its type, and the points relative to the centers: that on the
    /// sensor to the center of the micro-image (X - C'), that on the microlens to its center (Q - C).
    #[inline]
    #[must_use]
    pub fn relative_ray(
        &self,
        center_m: [f64; 2],
        lens_type: usize,
        on_sensor_m: [f64; 2],
        on_lens_m: [f64; 2],
    ) -> PlenopticRay {
        let Pupils { magnification, exit_m, inverse_focus_per_m, slope_per_m, .. } = self.pupils;
        let alpha = self.alphas[lens_type];
        let origin_m = [0, 1]
            .map(|k| magnification * exit_m / self.array.gap_m * on_sensor_m[k] - magnification * alpha * on_lens_m[k]);
        let direction = [0, 1].map(|k| slope_per_m * (center_m[k] + on_lens_m[k]) - origin_m[k] * inverse_focus_per_m);
        PlenopticRay { origin_m, direction }
    }

    /// Returns whether a ray passes the pupil.
    #[must_use]
    pub fn passes(&self, ray: &PlenopticRay) -> bool {
        let [x, y] = ray.origin_m;
        let radius = self.pupils.entrance_radius_m;
        match self.main_lens.aperture {
            PupilShape::Round => x * x + y * y <= radius * radius,
            PupilShape::Square => x.abs().max(y.abs()) <= radius,
        }
    }

    /// Returns the cosine to the power of 4 of the angle between the axis and the light from a point of a microlens to
    /// a place on the sensor: the factor of irradiance.
    #[must_use]
    pub fn cos4(&self, place_m: [f64; 2], lens_point_m: [f64; 2]) -> f64 {
        cos4(&[0, 1].map(|k| lens_point_m[k] - place_m[k]), self.array.gap_m)
    }

    /// Returns the same by the center of the microlens and points relative to the centers, as for
    /// [`relative_ray`](Self::relative_ray).
    #[inline]
    #[must_use]
    pub fn relative_cos4(&self, center_m: [f64; 2], on_sensor_m: [f64; 2], on_lens_m: [f64; 2]) -> f64 {
        let shift = self.array.gap_m / self.pupils.exit_m;
        cos4(&[0, 1].map(|k| on_lens_m[k] - on_sensor_m[k] - center_m[k] * shift), self.array.gap_m)
    }

    /// Returns the part of a microlens through which light reaches a place on the sensor.
    #[must_use]
    pub fn lit_region(&self, place_m: [f64; 2], lens: MicrolensIndex) -> LitRegion {
        let center = self.micro_image_center_m(lens);
        self.relative_lit_region([0, 1].map(|k| place_m[k] - center[k]), self.array.type_of(lens))
    }

    /// Returns the same by the place relative to the center of the micro-image, in meters, and the type of the microlens.
    #[inline]
    #[must_use]
    pub fn relative_lit_region(&self, on_sensor_m: [f64; 2], lens_type: usize) -> LitRegion {
        let scale = self.pupils.exit_m / self.array.gap_m;
        LitRegion::new(
            self.array.aperture,
            self.array.rotation_rad,
            self.main_lens.aperture,
            self.exit_pupil_radius_m(),
            on_sensor_m.map(|x| scale * x),
            self.alphas[lens_type],
        )
    }
}

/// cos^4 of light that moves sideways by `away` over the gap.
#[inline]
fn cos4(away: &[f64; 2], gap_m: f64) -> f64 {
    let squared = 1.0 + (away[0] * away[0] + away[1] * away[1]) / (gap_m * gap_m);
    1.0 / (squared * squared)
}

/// The microlenses of an image.
impl PlenopticCamera {
    /// Returns the lines of microlenses - rows, or columns of a grid of columns - that light any pixel of these rows of
    /// the sensor.
    ///
    /// A line and the microlenses on it are numbered in the order in which the renderer adds their light.
    #[must_use]
    pub fn lens_lines(&self, rows: std::ops::Range<usize>) -> std::ops::RangeInclusive<i32> {
        let (low, high) = self.lens_extent(&rows);
        self.array.lines_within(low, high)
    }

    /// Returns the microlenses on a line that light any pixel of these rows of the sensor.
    pub fn lenses_on_line(
        &self,
        line: i32,
        rows: std::ops::Range<usize>,
    ) -> impl Iterator<Item = MicrolensIndex> + use<> {
        let (low, high) = self.lens_extent(&rows);
        self.array.on_line(line, low, high)
    }

    /// Returns the number of microlenses whose micro-images have their centers on the sensor.
    #[must_use]
    pub fn lens_count(&self) -> usize {
        let size = self.sensor.size;
        let corners = [self.place_m([0.0, size.rows as f64]), self.place_m([size.columns as f64, 0.0])];
        let [low, high] = corners.map(|corner| self.on_array_m(corner));
        self.array.lines_within(low, high).map(|line| self.array.on_line(line, low, high).count()).sum()
    }

    /// The places on the array, from its origin, of microlenses that light any pixel of these rows.
    fn lens_extent(&self, rows: &std::ops::Range<usize>) -> ([f64; 2], [f64; 2]) {
        let dark = (0..self.alphas.len()).map(|k| self.micro_image_radii_m(k)[2]).fold(0.0, f64::max);
        let corners = [[0.0, rows.end as f64], [self.sensor.size.columns as f64, rows.start as f64]];
        let [low, high] = corners.map(|corner| self.place_m(corner));
        let low = self.on_array_m(low.map(|x| x - dark));
        (low, self.on_array_m(high.map(|x| x + dark)))
    }

    /// The place on the array that a micro-image center belongs to, from the origin of the array.
    fn on_array_m(&self, place_m: [f64; 2]) -> [f64; 2] {
        let scale = self.micro_image_scale();
        [0, 1].map(|k| place_m[k] / scale - (self.sensor.offset_m[k] + self.array.offset_m[k]))
    }

    /// Returns the pixels of these rows that a microlens may light: those within the dark radius of its micro-image, as
    /// ranges of columns, row by row.
    pub fn lit_pixels(
        &self,
        lens: MicrolensIndex,
        rows: std::ops::Range<usize>,
    ) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + use<> {
        let [x, y] = self.micro_image_center_px(lens);
        let dark = self.micro_image_radii_m(self.array.type_of(lens))[2] / self.sensor.pixel_m;
        // Light-sensitive squares reach half of the fill factor from the centers of pixels.
        let half = self.sensor.fill / 2.0;
        let columns = self.sensor.size.columns as f64;
        let first = (y - dark - half - 0.5).ceil().max(rows.start as f64) as usize;
        let last = (y + dark + half - 0.5).floor().min(rows.end as f64 - 1.0);
        let range = if last >= first as f64 { first..last as usize + 1 } else { 0..0 };
        range.filter_map(move |row| {
            // The square's nearest row of points.
            let away = ((row as f64 + 0.5 - y).abs() - half).max(0.0);
            let width = (dark * dark - away * away).max(0.0).sqrt() + half;
            let first = (x - width - 0.5).ceil().max(0.0);
            let last = (x + width - 0.5).floor().min(columns - 1.0);
            (first <= last).then(|| (row, first as usize..last as usize + 1))
        })
    }
}
