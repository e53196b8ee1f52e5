//! From the raw image of a camera to a light field with its rig.

use ndarray::{Array2, Array5, ArrayView2, ArrayView3, Axis};

use super::{MicrolensGrid, PlenopticCamera};
use crate::base::memory;
use crate::base::parallel::*;
use crate::{Error, GridSize, LightField, LightFieldOwned, LightFieldShape, Rig};

/// The least light of a white image, relative to an unvignetted pixel, at which a sample counts.
pub(super) const LEAST_LIGHT: f64 = 0.02;

/// A light field that was decoded from a raw image.
#[derive(Debug, Clone)]
pub struct Decoded {
    /// Radiance, axes (v, u, t, s, c).
    pub light_field: LightFieldOwned<f32>,
    /// The light of the white image that each sample rests on, axes (v, u, t, s) with one channel; 0 where there is none:
    /// the radiance is 0 there.
    pub weight: LightFieldOwned<f32>,
    /// The rig that the light field is equivalent to. If the array is rotated, so is the rig: about the optical axis, by
    /// [`roll_rad`](Self::roll_rad).
    pub rig: Rig,
    /// The rotation of the views, counterclockwise in the image.
    pub roll_rad: f64,
    /// Of a focused camera: the depth of the central view along which its views were rendered, axes (v, u), m.
    pub depth_m: Option<Array2<f32>>,
}

/// The places on the microlens array that become the pixels of a view.
struct ViewGrid {
    size: GridSize,
    /// Distance between neighboring places, m.
    spacing_m: f64,
    /// Whether the places are those of microlenses.
    is_exact: bool,
}

impl PlenopticCamera {
    /// Returns the number of views an axis that [`decode`](Self::decode) makes unless told otherwise: the largest odd one whose pixels
    /// are lit in every micro-image, those within the fully lit radius minus half a pixel; of a focused camera five.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if no pixel is fully lit.
    pub fn decodable_views(&self) -> Result<usize, Error> {
        if self.has_rendered_views() {
            return Ok(Self::rendered_view_count());
        }
        let radius_px = self.micro_image_radii_m(0)[0] / self.sensor().pixel_m - 0.5;
        // The corner view is the farthest from the center: a square within the disc.
        let half = (radius_px / std::f64::consts::SQRT_2).floor();
        if half >= 0.0 && self.micro_image_pitch_px() >= 1.0 {
            Ok(2 * half as usize + 1)
        } else {
            let what = "radius of the fully lit part of a micro-image in pixels";
            Err(Error::BadNumber { what, value: radius_px + 0.5, need: "at least half a pixel, to decode views" })
        }
    }

    /// Returns the rig of the `views` x `views` views that [`decode`](Self::decode) makes, without an image.
    ///
    /// # Errors
    ///
    /// Those of [`decode`](Self::decode) that no image causes.
    pub fn decoded_rig(&self, views: usize) -> Result<Rig, Error> {
        if self.has_rendered_views() { self.rendered_rig(views) } else { self.decoded_views(views).map(|(_, rig)| rig) }
    }

    /// The pixels of the views, and their rig.
    fn decoded_views(&self, views: usize) -> Result<(ViewGrid, Rig), Error> {
        if views == 0 {
            return Err(Error::ZeroCount { what: "views" });
        }
        let grid = self.view_grid(views)?;
        let rig = self.equivalent_rig(GridSize::new(views, views), grid.size, grid.spacing_m, 1.0)?;
        Ok((grid, rig))
    }

    /// Decodes a raw image to views. For an unfocused camera it looks raw and white image up around the center of every micro-image,
    /// one pixel from view to view, and divides one by the other. From micro-images of a focused camera it renders views along depths
    /// that it estimates, or that are given to [`decode_along`](Self::decode_along); see there.
    ///
    /// View (t, s) of `views` x `views` sees what the pixels (s - views/2, t - views/2) from the centers see, in the directions
    /// of the array. The pixels of
    /// a view are the microlenses of a square array without rotation whose center is a microlens or a point between
    /// four; otherwise they are a square grid along the array, through the axis, and interpolated between microlenses:
    /// rows of a hexagonal array that are sqrt(3)/2 pitches apart, along each row.
    ///
    /// # Accuracy
    ///
    /// Bilinear interpolation in raw and white image, linear between microlenses. Views of focused cameras are as good as the depth;
    /// behind a lens of glass they neglect what its rays deviate from those near the axis, but distortion.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if an image has not the size of the sensor; [`Error::ZeroCount`] for no views or no whole
    /// micro-image; [`Error::BadNumber`] if the camera has no equivalent rig; [`Error::OutOfMemory`].
    pub fn decode(&self, raw: ArrayView3<f32>, white: ArrayView2<f32>, views: usize) -> Result<Decoded, Error> {
        self.check_images(raw, white)?;
        let size = self.sensor().size;
        if self.has_rendered_views() {
            return self.decode_focused(raw, white, views);
        }
        let (grid, rig) = self.decoded_views(views)?;
        let shape = LightFieldShape::new(GridSize::new(views, views), grid.size)?;
        let channels = raw.dim().2;
        let mut color = field(shape, channels)?;
        let mut weight = field(shape, 1)?;
        // Viewpoints lie along the directions of the array, as the pixels of the views do.
        let offsets: Vec<[f64; 2]> = (0..views * views)
            .map(|k| {
                let [s, t] = [k % views, k / views].map(|k| k as f64 - (views / 2) as f64);
                let [x, y] = super::microlenses::rotate([s, -t], self.array().rotation_rad);
                [x, -y]
            })
            .collect();
        let rows: Vec<_> = color.axis_iter_mut(Axis(0)).zip(weight.axis_iter_mut(Axis(0))).enumerate().collect();
        rows.into_par_iter().for_each(|(v, (mut color, mut weight))| {
            let mut sums = vec![0.0; channels];
            for u in 0..grid.size.columns {
                let neighbors = self.neighbors(&grid, v, u);
                for t in 0..views {
                    for s in 0..views {
                        let from_center = offsets[t * views + s];
                        sums.fill(0.0);
                        let (mut light, mut share) = (0.0, 0.0);
                        for (center, part) in &neighbors {
                            let at = [center[0] + from_center[0], center[1] + from_center[1]];
                            let Some((texels, parts)) = bilinear(at, size) else { continue };
                            let white = weighted(&texels, &parts, |[row, column]| white[[row, column]]);
                            if white < LEAST_LIGHT {
                                continue;
                            }
                            for (c, sum) in sums.iter_mut().enumerate() {
                                *sum += part * weighted(&texels, &parts, |[row, column]| raw[[row, column, c]]) / white;
                            }
                            (light, share) = (light + part * white, share + part);
                        }
                        if share > 0.0 {
                            for (c, sum) in sums.iter().enumerate() {
                                color[[u, t, s, c]] = (sum / share) as f32;
                            }
                            weight[[u, t, s, 0]] = light as f32;
                        }
                    }
                }
            }
        });
        let roll_rad = self.array().rotation_rad;
        Ok(Decoded {
            light_field: LightField::new(color)?,
            weight: LightField::new(weight)?,
            rig,
            roll_rad,
            depth_m: None,
        })
    }

    /// Refuses images that have not the size of the sensor.
    pub(super) fn check_images(&self, raw: ArrayView3<f32>, white: ArrayView2<f32>) -> Result<(), Error> {
        let size = self.sensor().size;
        for (what, dim) in [("raw image", [raw.dim().0, raw.dim().1]), ("white image", [white.dim().0, white.dim().1])]
        {
            if dim != [size.rows, size.columns] {
                return Err(Error::Shape { what, expected: vec![size.rows, size.columns], found: dim.to_vec() });
            }
        }
        Ok(())
    }

    /// The pixels of the views: as many places around the axis as have all their pixels on the sensor.
    fn view_grid(&self, views: usize) -> Result<ViewGrid, Error> {
        let (array, sensor) = (self.array(), self.sensor());
        let offset = self.array_origin_m();
        // Half pitches from the axis, for microlenses that are symmetric about it.
        let halves = offset.map(|x| 2.0 * x / array.pitch_m);
        let is_symmetric = halves.iter().all(|half| (half - half.round()).abs() < 1e-6);
        let is_exact =
            array.grid == MicrolensGrid::Square && array.rotation_rad == 0.0 && array.scale_y == 1.0 && is_symmetric;
        let spacing_m = match array.grid {
            MicrolensGrid::Square => array.pitch_m,
            _ => array.pitch_m * super::microlenses::HEX_ROW,
        };
        // From the axis to the nearest border, in places, less the half micro-image that views take.
        let scale = self.micro_image_scale() * spacing_m / sensor.pixel_m;
        // Places between microlenses need those around them.
        let around = if is_exact { 0.0 } else { self.micro_image_pitch_px() };
        let margin = (views / 2) as f64 + 1.0 + around;
        let axis = self.position_px([0.0; 2]);
        let (sin, cos) = array.rotation_rad.sin_cos();
        let counts = [(axis[0], sensor.size.columns), (axis[1], sensor.size.rows)].map(|(middle, count)| {
            let room = middle.min(count as f64 - middle) - margin;
            (room / scale).max(0.0)
        });
        // A rotated rectangle that fits.
        let (w, h) = (counts[0], counts[1]);
        let shrink = |a: f64, b: f64| a / (cos.abs() + sin.abs() * b / a.max(1e-9)).max(1e-9);
        let [half_columns, half_rows] =
            if sin.abs() < 1e-12 { [w, h] } else { [shrink(w, h).min(w), shrink(h, w).min(h)] };
        let count = |half: f64, halves: f64| {
            let is_between = is_exact && (halves.round() as i64).rem_euclid(2) == 1;
            if is_between { 2 * (half + 0.5).floor() as usize } else { 2 * half.floor() as usize + 1 }
        };
        let size = GridSize::new(count(half_rows, halves[1]), count(half_columns, halves[0]));
        if size.rows == 0 || size.columns == 0 || w <= 0.0 || h <= 0.0 {
            return Err(Error::ZeroCount { what: "micro-images that lie wholly on the sensor" });
        }
        Ok(ViewGrid { size, spacing_m, is_exact })
    }

    /// The centers of the micro-images, px, that a pixel of the views is interpolated between, with their parts.
    fn neighbors(&self, grid: &ViewGrid, v: usize, u: usize) -> Vec<([f64; 2], f64)> {
        // The place on the array, in its own directions.
        let x = (u as f64 - (grid.size.columns - 1) as f64 / 2.0) * grid.spacing_m;
        let y = ((grid.size.rows - 1) as f64 / 2.0 - v as f64) * grid.spacing_m;
        let array = self.array();
        let [x, y] = super::microlenses::rotate([x, y], array.rotation_rad);
        let offset = self.array_origin_m();
        let place = [x - offset[0], y - offset[1]];
        if grid.is_exact {
            return vec![(self.micro_image_center_px(array.nearest(place)), 1.0)];
        }
        array.around(place).into_iter().map(|(lens, part)| (self.micro_image_center_px(lens), part)).collect()
    }
}

/// Zeros in the order of the elemental image array.
pub(super) fn field(shape: LightFieldShape, channels: usize) -> Result<Array5<f32>, Error> {
    let (views, lenses) = (shape.views(), shape.lenses());
    let dim = (lenses.rows, lenses.columns, views.rows, views.columns, channels);
    let count = [dim.0, dim.1, dim.2, dim.3, dim.4].into_iter().try_fold(1usize, usize::checked_mul);
    let count = count.ok_or(Error::TooLarge { what: "decoded light field" })?;
    let values = memory::filled("a decoded light field", count, 0.0)?;
    Array5::from_shape_vec(dim, values).map_err(|_| Error::TooLarge { what: "decoded light field" })
}

/// The four pixels around a position and their parts; `None` outside of the outermost centers.
pub(super) fn bilinear([x, y]: [f64; 2], size: GridSize) -> Option<([[usize; 2]; 4], [f64; 4])> {
    let (x, y) = (x - 0.5, y - 0.5);
    let is_inside = x >= 0.0 && y >= 0.0 && x <= size.columns as f64 - 1.0 && y <= size.rows as f64 - 1.0;
    if !is_inside {
        return None;
    }
    let (column, row) = (x as usize, y as usize);
    let (right, below) = ((column + 1).min(size.columns - 1), (row + 1).min(size.rows - 1));
    let (fx, fy) = (x - column as f64, y - row as f64);
    let texels = [[row, column], [row, right], [below, column], [below, right]];
    Some((texels, [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy]))
}

fn weighted(texels: &[[usize; 2]; 4], parts: &[f64; 4], value: impl Fn([usize; 2]) -> f32) -> f64 {
    texels.iter().zip(parts).map(|(&texel, part)| part * f64::from(value(texel))).sum()
}
