//! The validated camera: places on sensor and array, and which pixels a microlens lights.

use std::sync::Arc;

use super::glass_lens::{GlassLens, WAVELENGTH_NM};
use super::main_lens::Pupils;
use super::{MainLens, Microlens, MicrolensArray, MicrolensFocus, MicrolensIndex};
use crate::base::error::positive;
use crate::{Error, GridSize};

/// The largest number of pixels along a side of a sensor, so that every microlens has an index.
const MAX_PIXELS: usize = 1 << 24;

/// The largest number of microlenses.
const MAX_LENSES: f64 = (1 << 28) as f64;

/// The largest radius of a micro-image, px, so that the place of a pixel within it has 16 bits.
const MAX_RADIUS_PX: f64 = 32_000.0;

/// The largest number of micro-images that a pixel may lie in, on average.
const MAX_OVERLAP: f64 = 1000.0;

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
    /// Of every type of microlens, and of clear gaps: how far the pupil point moves over the exit pupil, per meter on the
    /// microlens.
    alphas: Vec<f64>,
    /// Depth and radius of the stops in front of the pupil, seen from the entrance pupil.
    pub(super) stops: Vec<[f64; 2]>,
    /// The main lens, if it is one of glass.
    pub(super) glass: Option<Arc<GlassLens>>,
}

impl PlenopticCamera {
    /// Validates a camera.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] for a number that is not finite or out of its range, and for lenses that cannot form an
    /// image: a focus distance of 0, a main lens behind the array, an entrance pupil at infinity, microlenses that
    /// overlap, micro-images of which a thousand share a pixel; [`Error::ZeroCount`] or [`Error::TooLarge`] for an impossible sensor.
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
        let main_lens = main_lens.resolved(array.gap_m)?;
        let pupils = main_lens.pupils(array.gap_m)?;
        let focal_lengths_m = match &array.focus {
            MicrolensFocus::Lengths(lengths) => lengths.clone(),
            MicrolensFocus::Pupil => vec![1.0 / (1.0 / array.gap_m + 1.0 / pupils.exit_m)],
        };
        let stops = main_lens.stops.iter();
        let stops = stops.map(|stop| [stop.distance_m - pupils.entrance_offset_m, stop.diameter_m / 2.0]).collect();
        let mut camera =
            Self { sensor, array, main_lens, pupils, focal_lengths_m, alphas: Vec::new(), stops, glass: None };
        let openings = 0..camera.array.type_count() + usize::from(camera.array.has_clear_gaps);
        camera.alphas = openings.map(|k| camera.alpha_for(k, camera.array.gap_m, camera.pupils.exit_m)).collect();
        camera.validate_extent()?;
        camera.set_glass(WAVELENGTH_NM);
        if camera.glass.is_some() {
            camera.validate_extent()?;
        }
        Ok(camera)
    }

    /// Prepares the lens of glass for a wavelength, if there is one.
    pub(super) fn set_glass(&mut self, wavelength_nm: f64) {
        let Some(prescription) = &self.main_lens.prescription else { return };
        let corner_m = self.corners_m().into_iter().map(|[x, y]| x.hypot(y)).fold(0.0, f64::max);
        let dark_m = self.pupils.exit_radius_m() * self.array.gap_m / self.pupils.exit_m;
        let farthest_m = corner_m + 2.0 * dark_m + 2.0 * self.array.pitch_m;
        self.glass = Some(Arc::new(GlassLens::new(prescription, wavelength_nm, &self.pupils, farthest_m)));
    }

    /// The corners of the sensor, in meters from the axis.
    pub(super) fn corners_m(&self) -> [[f64; 2]; 4] {
        let (columns, rows) = (self.sensor.size.columns as f64, self.sensor.size.rows as f64);
        [[0.0, 0.0], [columns, 0.0], [0.0, rows], [columns, rows]].map(|corner| self.place_m(corner))
    }

    /// Whether the sensor is so large beside the microlenses, or a micro-image beside the pixels, that they cannot be
    /// numbered, or an image would take days.
    fn validate_extent(&self) -> Result<(), Error> {
        let (size, pixel_m) = (self.sensor.size, self.sensor.pixel_m);
        let cell_px = (self.array.pitch_m / pixel_m).powi(2) * self.array.scale_y;
        let dark_px = (0..self.alphas.len()).map(|k| self.micro_image_radii_m(k)[2] / pixel_m).fold(0.0, f64::max);
        let overlap = std::f64::consts::PI * dark_px * dark_px / cell_px;
        for (what, value, most, need) in [
            ("number of microlenses", size.count() as f64 / cell_px, MAX_LENSES, "at most 2^28"),
            ("radius of the micro-images in pixels", dark_px, MAX_RADIUS_PX, "at most 32,000"),
            ("number of micro-images that a pixel lies in", overlap, MAX_OVERLAP, "at most 1000"),
        ] {
            if value.is_nan() || value > most {
                return Err(Error::BadNumber { what, value, need });
            }
        }
        self.main_lens.distortion.validate(&self.corners_m())?;
        for place in self.corners_m() {
            let lenses = (place[0].abs() + place[1].abs()) / self.array.pitch_m / self.array.scale_y.min(1.0);
            if lenses.is_nan() || lenses >= f64::from(1u32 << 24) {
                return Err(Error::TooLarge { what: "number of microlenses" });
            }
            let lens = self.microlens(self.owner(place));
            for (what, value) in [
                ("gap behind the tilted array at a corner in meters", lens.gap_m),
                ("distance of the tilted array from the main lens in meters", lens.pupils.lens_m),
                ("distance of the tilted array from the exit pupil in meters", lens.pupils.exit_m),
            ] {
                positive(what, value)?;
            }
            let Some(ray) = self.ray(place, lens.center_m, lens.index) else { continue };
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

    /// Returns the depth from the entrance pupil at which light leaves the camera: that of the main lens, or of its first
    /// surface; below 0 behind the entrance pupil.
    #[must_use]
    pub fn front_depth_m(&self) -> f64 {
        self.glass.as_ref().map_or(-self.pupils.entrance_offset_m, |glass| glass.front_depth_m())
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
        self.pupils.exit_radius_m()
    }

    /// Returns 1 / depth of the plane that the main lens images onto the array, in 1/m, from the entrance pupil; 0 for
    /// infinity.
    #[must_use]
    pub const fn inverse_focus_per_m(&self) -> f64 {
        self.pupils.inverse_focus_per_m
    }

    /// Returns alpha of a type of microlens: the displacement over the exit pupil per displacement on the microlens. 0
    /// if it images the pupil sharply onto the sensor, 1 if its focal length is the gap. On a tilted array that of the
    /// microlens at its origin, as all numbers of types.
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
    #[inline]
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

    /// Returns the electrons of an unvignetted pixel on the axis that sees a surface of a luminance (cd/m^2) for an exposure time
    /// (s): those of its raw value for radiance 1.
    ///
    /// # Source
    ///
    /// E = L c_0 A / d^2 of a microlens of area A at a distance d, with the [mean of cos^4](Self::central_cos4) c_0; of a
    /// round one that is pi L sin^2(angle of its edge). 4.09e15 photons a lumen and second, at 555 nm.
    #[must_use]
    pub fn photometric_electrons(&self, luminance_cd_m2: f64, exposure_s: f64, quantum_efficiency: f64) -> f64 {
        const PHOTONS_PER_LUMEN_S: f64 = 4.09e15;
        let width_m = self.sensor.fill * self.sensor.pixel_m;
        let solid_angle = self.array.aperture.area_m2() / (self.array.gap_m * self.array.gap_m);
        let illuminance_lx = luminance_cd_m2 * self.central_cos4() * solid_angle;
        PHOTONS_PER_LUMEN_S * illuminance_lx * exposure_s * quantum_efficiency * width_m * width_m
    }

    /// Returns the center of a microlens, in meters from the axis.
    #[must_use]
    pub fn lens_center_m(&self, lens: MicrolensIndex) -> [f64; 2] {
        let (place, origin) = (self.array.place_m(lens), self.array_origin_m());
        [0, 1].map(|k| place[k] + origin[k])
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
        self.microlens(lens).image_center_m
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

    /// Returns the angles of view along x and y, in radians: those between the chief rays from the edges of the sensor,
    /// through the middle of the pupil.
    #[must_use]
    pub fn angles_of_view_rad(&self) -> [f64; 2] {
        let size = self.sensor.size;
        [size.columns, size.rows].map(|count| {
            let half = count as f64 / 2.0 * self.sensor.pixel_m / self.micro_image_scale();
            2.0 * (half * self.pupils.slope_per_m).abs().atan()
        })
    }

    /// Returns the microlens whose micro-image center is nearest to a place of the sensor: the owner of that place.
    #[must_use]
    pub fn owner(&self, place_m: [f64; 2]) -> MicrolensIndex {
        let on_array = self.on_array_m(place_m);
        let nearest = self.array.nearest(on_array);
        let raised_m = self.array.raised_m(on_array);
        if raised_m == 0.0 && self.glass.is_none() {
            return nearest;
        }
        // On a tilted array and behind a lens of glass, by the scale at the place, or a neighbor of that.
        let exit_m = match &self.glass {
            Some(glass) => glass.field(place_m.map(|x| x / self.micro_image_scale())).exit_m,
            None => self.pupils.exit_m,
        };
        let exit_m = exit_m - raised_m;
        let scale = 1.0 + (self.array.gap_m + raised_m) / exit_m;
        let MicrolensIndex { row, column } = self.array.nearest(self.relative_to_array_m(place_m.map(|x| x / scale)));
        let around = |k: i32| MicrolensIndex { row: row + k / 3 - 1, column: column + k % 3 - 1 };
        let away = |lens: MicrolensIndex| {
            let center = self.micro_image_center_m(lens);
            (center[0] - place_m[0]).hypot(center[1] - place_m[1])
        };
        (0..9).map(around).min_by(|a, b| away(*a).total_cmp(&away(*b))).unwrap_or(nearest)
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
        let [inner, outer] = self.main_lens.aperture.inner_and_outer().map(|part| part * pupil);
        let moved = self.alphas[lens_type].abs() * self.array.aperture.half_width_m();
        let outer_moved = self.alphas[lens_type].abs() * self.outer_radius_m(lens_type);
        let dark = match &self.glass {
            None => scale * (outer + outer_moved),
            Some(glass) => {
                let [least, most] = glass.table().exit_range_m();
                // Alpha is linear in the distance of the pupil.
                let alphas = [least, most].map(|exit_m| self.alpha_for(lens_type, self.array.gap_m, exit_m).abs());
                let moved = alphas[0].max(alphas[1]) * self.outer_radius_m(lens_type);
                self.array.gap_m / least * (glass.table().outer_m() + moved)
            }
        };
        [scale * (inner - moved).abs(), scale * pupil, dark]
    }

    /// The radius of the smallest disc around a microlens of a type, or around the cell of a gap.
    fn outer_radius_m(&self, lens_type: usize) -> f64 {
        let is_gap = lens_type == self.array.type_count();
        if is_gap { self.array.pitch_m * self.array.scale_y.max(1.0) } else { self.array.aperture.outer_radius_m() }
    }
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
        let corners = [[0.0, size.rows as f64], [size.columns as f64, 0.0]].map(|corner| self.place_m(corner));
        let [low, high] = corners.map(|corner| corner.map(|x| x / self.micro_image_scale()));
        self.lenses_within(low, high).count()
    }

    /// The microlenses with their centers between two opposite corners, in meters from the axis, line by line.
    pub(super) fn lenses_within(&self, low_m: [f64; 2], high_m: [f64; 2]) -> impl Iterator<Item = MicrolensIndex> {
        let (low, high) = (self.relative_to_array_m(low_m), self.relative_to_array_m(high_m));
        self.array.lines_within(low, high).flat_map(move |line| self.array.on_line(line, low, high))
    }

    /// The origin of the array, in meters from the axis.
    pub(super) fn array_origin_m(&self) -> [f64; 2] {
        [0, 1].map(|k| self.sensor.offset_m[k] + self.array.offset_m[k])
    }

    /// The places on the array, from its origin, of microlenses that light any pixel of these rows.
    fn lens_extent(&self, rows: &std::ops::Range<usize>) -> ([f64; 2], [f64; 2]) {
        let dark = (0..self.alphas.len()).map(|k| self.micro_image_radii_m(k)[2]).fold(0.0, f64::max);
        let corners = [[0.0, rows.end as f64], [self.sensor.size.columns as f64, rows.start as f64]];
        let [low, high] = corners.map(|corner| self.place_m(corner));
        // On a tilted array and behind a lens of glass micro-images lie up to this much elsewhere.
        let margin = dark + self.displacement_m();
        let low = self.on_array_m(low.map(|x| x - margin));
        (low, self.on_array_m(high.map(|x| x + margin)))
    }

    /// By how much the tilt of the array or a lens of glass may displace and enlarge micro-images, m.
    fn displacement_m(&self) -> f64 {
        let corners = self.corners_m();
        let of_glass = self.glass.as_ref().map_or(0.0, |glass| {
            let farthest_m = corners.map(|[x, y]| x.hypot(y)).into_iter().fold(0.0, f64::max);
            let near_axis = self.array.gap_m / self.pupils.exit_m;
            let scales = glass.table().exit_range_m().map(|exit_m| (self.array.gap_m / exit_m - near_axis).abs());
            1.1 * scales[0].max(scales[1]) * farthest_m
        });
        let at = |place: [f64; 2]| {
            let raised_m = self.array.raised_m(self.on_array_m(place));
            let scale = (self.array.gap_m + raised_m) / (self.pupils.exit_m - raised_m);
            let difference = (scale - self.array.gap_m / self.pupils.exit_m).abs();
            difference * (place[0].hypot(place[1]) + 2.0 * self.exit_pupil_radius_m())
        };
        of_glass + 2.0 * corners.map(at).into_iter().fold(0.0, f64::max)
    }

    /// The place on the array that a micro-image center belongs to, from the origin of the array.
    fn on_array_m(&self, place_m: [f64; 2]) -> [f64; 2] {
        self.relative_to_array_m(place_m.map(|x| x / self.micro_image_scale()))
    }

    /// A place on the array from its origin instead of the axis.
    pub(super) fn relative_to_array_m(&self, place_m: [f64; 2]) -> [f64; 2] {
        let origin = self.array_origin_m();
        [0, 1].map(|k| place_m[k] - origin[k])
    }

    /// Returns the pixels of these rows that a microlens may light: those within the dark radius of its micro-image, as
    /// ranges of columns, row by row.
    pub fn lit_pixels(
        &self,
        lens: &Microlens,
        rows: std::ops::Range<usize>,
    ) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + use<> {
        let scale = lens.gap_m / lens.pupils.exit_m;
        let [x, y] = self.position_px([0, 1].map(|k| lens.image_center_m[k] + scale * lens.pupil.center_m[k]));
        let outer_m = self.main_lens.aperture.inner_and_outer()[1] * lens.pupil.radius_m;
        let lit_m = outer_m + lens.alpha.abs() * self.outer_radius_m(lens.lens_type);
        let dark_m = if lens.pupil.radius_m > 0.0 { scale * lit_m } else { -self.sensor.pixel_m };
        let dark = dark_m / self.sensor.pixel_m;
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
