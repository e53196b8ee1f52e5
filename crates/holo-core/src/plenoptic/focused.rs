//! Views from the raw image of a focused camera (plenoptic 2.0).
//!
//! A microlens of a focused camera shows a small image of the scene; neighbors show it from other places of the pupil, so that their
//! images of a point lie apart by a distance that depends on its depth. A ray of a view meets the array at one place, whatever the
//! depth, and the depth says at which pixel each microlens around that place shows the point of the ray. The pixel of the view is the
//! mean of these samples; near microlenses, sharp ones and well lit ones weigh most. With one depth for all pixels this is rendering
//! by patches (Georgiev and Lumsdaine 2010); with one for each it is sharp everywhere, and other viewpoints have their own parallax.
//!
//! The depth is given, or estimated on the raw image: a sweep over the distance of neighboring images, with the deviation of the
//! samples of a point from each other as its cost (correlation of neighboring micro-images).

mod depth;
mod lenses;
mod samples;

use ndarray::{Array2, ArrayView2, ArrayView3, Axis};

use self::lenses::Lenses;
use self::samples::{Point, RawLight};
use super::{Decoded, PlenopticCamera, PlenopticMode};
use crate::base::parallel::*;
use crate::synthesize::map_of_view;
use crate::{Error, GridSize, LightField, LightFieldShape, Rig, ViewIndex};

/// The virtual depth at which a pixel of a view is as wide as one of the sensor, in gaps. Nearer to 2, where images are largest,
/// views have fewer pixels than the raw image resolves; farther away they have more.
const PIXEL_DEPTH: f64 = 3.0;

/// The virtual depth of disparity 0.
const FOCUS_DEPTH: f64 = 4.0;

/// The part of the radius of the pupil, along each axis, that views spread over.
const PUPIL_PART: f64 = 0.6;

/// The views an axis of a focused camera.
const VIEWS: usize = 5;

/// What views leave out around the border of the sensor, in micro-images: rays of the outermost views meet the array up to
/// `PUPIL_PART` / 2 * `FOCUS_DEPTH` pitches beside those of the middle.
const MARGIN: f64 = 1.5 + PUPIL_PART / 2.0 * FOCUS_DEPTH;

impl PlenopticCamera {
    /// Whether views are [rendered](Self::decode) from micro-images, which are small images in a focused camera and in one with
    /// microlenses of several types, instead of being made of single pixels.
    #[must_use]
    pub fn has_rendered_views(&self) -> bool {
        self.array().type_count() > 1 || self.mode(0) != PlenopticMode::Unfocused
    }

    /// The views an axis of a focused camera that [`decode`](Self::decode) renders unless told otherwise.
    pub(super) const fn rendered_view_count() -> usize {
        VIEWS
    }

    /// The rig of the views of a focused camera.
    pub(super) fn rendered_rig(&self, views: usize) -> Result<Rig, Error> {
        if views == 0 {
            return Err(Error::ZeroCount { what: "views" });
        }
        let (pitch_px, sensor) = (self.micro_image_pitch_px(), self.sensor());
        if pitch_px < 4.0 {
            let what = "width of a micro-image of a focused camera in pixels";
            return Err(Error::BadNumber { what, value: pitch_px, need: "at least 4, to render views" });
        }
        let spacing_m = PIXEL_DEPTH * self.array().pitch_m / pitch_px;
        // From the axis to the nearest border, in pixels of the views.
        let axis = self.position_px([0.0; 2]);
        let counts = [(axis[1], sensor.size.rows), (axis[0], sensor.size.columns)].map(|(middle, count)| {
            let room_px = middle.min(count as f64 - middle) - MARGIN * pitch_px;
            2.0 * (room_px / PIXEL_DEPTH).floor() + 1.0
        });
        if counts.iter().any(|count| *count < 1.0) {
            return Err(Error::ZeroCount { what: "micro-images that lie wholly on the sensor" });
        }
        let half_light_px = self.micro_image_radii_m(0)[1] / sensor.pixel_m;
        // A single view has the baseline of two.
        let step_px = 2.0 * PUPIL_PART * half_light_px / (views.max(2) - 1) as f64;
        let size = GridSize::new(counts[0] as usize, counts[1] as usize);
        let focus_distance_m = match self.inverse_depth_at(FOCUS_DEPTH) {
            inverse if inverse > 0.0 => 1.0 / inverse,
            _ => f64::INFINITY,
        };
        let pupils = &self.pupils;
        Rig::builder(LightFieldShape::new(GridSize::new(views, views), size)?)
            .focal_length_m(1.0 / pupils.slope_per_m)
            .sensor_size_m(size.larger() as f64 * spacing_m)
            .baseline_m(self.equivalent_views().baseline_m.abs() * step_px)
            .focus_distance_m(focus_distance_m)
            .build()
    }

    /// 1 / depth at a virtual depth of this size, on the side that the microlenses look at: in front of the array for Keplerian
    /// cameras, behind it for Galilean ones.
    fn inverse_depth_at(&self, gaps: f64) -> f64 {
        self.inverse_focus_per_m() + self.shift_numerator() / self.shift_px(gaps)
    }

    /// The distance of the images of a point behind neighboring microlenses, beyond that of their micro-images, px.
    fn shift_px(&self, gaps: f64) -> f64 {
        let side = if self.mode(0) == PlenopticMode::Keplerian { -1.0 } else { 1.0 };
        side * self.shift_numerator().signum() * self.micro_image_pitch_px() / gaps
    }

    /// That distance is this over 1 / depth - 1 / focus depth, px/m.
    fn shift_numerator(&self) -> f64 {
        self.pupils.slope_per_m * self.array().pitch_m / self.equivalent_views().baseline_m
    }

    /// Decodes the raw image of a focused camera as [`decode`](Self::decode) does, along depths that are known.
    ///
    /// # Shape
    ///
    /// The depth of every pixel of the raw image, (row, column), m, along the ray through the middle of the pixel and of its
    /// microlens; +infinity where nothing is hit, NaN where it is unknown.
    ///
    /// # Errors
    ///
    /// As [`decode`](Self::decode); [`Error::Shape`] if the depth has not the size of the sensor; [`Error::BadNumber`] if the camera is
    /// unfocused, so that its views need no depth, or no depth is known.
    pub fn decode_along(
        &self,
        raw: ArrayView3<f32>,
        white: ArrayView2<f32>,
        views: usize,
        depth_m: ArrayView2<f32>,
    ) -> Result<Decoded, Error> {
        if !self.has_rendered_views() {
            let value = self.microlens_focal_lengths_m()[0] / self.array().gap_m;
            let (what, need) =
                ("focal length of the microlenses in gaps", "far from 1: views of an unfocused camera need no depth");
            return Err(Error::BadNumber { what, value, need });
        }
        self.check_images(raw, white)?;
        let (rig, lenses) = (self.rendered_rig(views)?, Lenses::new(self)?);
        let size = self.sensor().size;
        if depth_m.dim() != (size.rows, size.columns) {
            let (expected, found) = (vec![size.rows, size.columns], depth_m.shape().to_vec());
            return Err(Error::Shape { what: "depth of the raw image", expected, found });
        }
        let light = RawLight { raw, white };
        let central = depth::of_raw(self, &lenses, &rig, depth_m)?;
        self.rendered(&rig, &lenses, &light, central)
    }

    /// The views of a focused camera, along an estimate of the depth.
    pub(super) fn decode_focused(
        &self,
        raw: ArrayView3<f32>,
        white: ArrayView2<f32>,
        views: usize,
    ) -> Result<Decoded, Error> {
        let (rig, lenses) = (self.rendered_rig(views)?, Lenses::new(self)?);
        let light = RawLight { raw, white };
        // Depths of the sweep, as distances of neighboring images.
        let [far, near] = [depth::LEAST_DEPTH, depth::MOST_DEPTH].map(|gaps| self.shift_px(gaps));
        let central = depth::estimated(&lenses, &rig, &light, [far, near])?;
        self.rendered(&rig, &lenses, &light, central)
    }

    /// All views along the inverse depth of the central one.
    fn rendered(
        &self,
        rig: &Rig,
        lenses: &Lenses,
        light: &RawLight<'_>,
        central: Array2<f32>,
    ) -> Result<Decoded, Error> {
        let (shape, channels) = (*rig.shape(), light.channels());
        let (views, size) = (shape.views(), shape.lenses());
        let mut color = super::decode::field(shape, channels)?;
        let mut weight = super::decode::field(shape, 1)?;
        let disparity = rig.disparity();
        let map_px = central.mapv(|inverse| disparity.from_depth_m(1.0 / f64::from(inverse)) as f32);
        let (t, s) = shape.central_view();
        for k in 0..views.count() {
            let view = ViewIndex { row: k / views.columns, column: k % views.columns };
            let at = ViewIndex { row: t, column: s };
            let own_px = map_of_view(shape, map_px.view(), (at, view), rig.baseline_ratio())?;
            let inverse_depth =
                |v: usize, u: usize| 1.0 / disparity.to_depth_m(f64::from(own_px[v * size.columns + u]));
            let mut image = color.index_axis_mut(Axis(3), view.column);
            let mut light_of = weight.index_axis_mut(Axis(3), view.column);
            let (mut image, mut light_of) =
                (image.index_axis_mut(Axis(2), view.row), light_of.index_axis_mut(Axis(2), view.row));
            let rows: Vec<_> = image.axis_iter_mut(Axis(0)).zip(light_of.axis_iter_mut(Axis(0))).enumerate().collect();
            rows.into_par_iter().for_each(|(v, (mut pixels, mut lights))| {
                let mut sums = vec![0.0; channels];
                for u in 0..size.columns {
                    let ray = rig.ray(v, u, view.row, view.column, 0.5, 0.5);
                    let point = Point::new(&ray, inverse_depth(v, u)).shown(lenses);
                    let total = lenses.color(light, &point, &mut sums);
                    if total > 0.0 {
                        (0..channels).for_each(|c| pixels[[u, c]] = (sums[c] / total) as f32);
                        lights[[u, 0]] = total as f32;
                    }
                }
            });
        }
        Ok(Decoded {
            light_field: LightField::new(color)?,
            weight: LightField::new(weight)?,
            rig: *rig,
            roll_rad: 0.0,
            depth_m: Some(central.mapv(|x| 1.0 / x)),
        })
    }
}
