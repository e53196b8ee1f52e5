//! View synthesis: the image of a viewpoint between the views, from neighboring views and disparity.
//!
//! A pixel of the new view lies on a line in every other view, and its disparity says where. The disparity maps of the four
//! views around the viewpoint are surfaces over these lines, and each view shows the pixel where its line meets its surface from
//! the front. The pixel is the mean color of the views that agree on a point, weighted by how near they are; of two points that
//! as many views show, it is the nearer one. Where all four show one surface, their pixels are samples of one image, and kriging
//! weights them (`joint.rs`). What none of the four shows, views farther away may show. What no view shows is a
//! hole, and the farthest surface around it fills it.
//!
//! Cameras that stand anywhere take part as views do: a ray of the new camera is a straight line in the image of each, also in
//! (column, row, 1 / depth), so the same lines meet the same kind of surfaces.
//!
//! With the same disparity everywhere this is quadrilinear interpolation on a focal plane (Levoy and Hanrahan 1996, Isaksen
//! et al. 2000); with maps, their depth-corrected interpolation (Gortler et al., *The Lumigraph*, 1996).

mod cameras;
mod fill;
mod joint;
mod new_view;
mod surface;
#[cfg(test)]
mod tests;

use ndarray::{Array2, Array3, ArrayView2, ArrayView4, Data};

pub use self::cameras::PosedView;
pub(crate) use self::fill::fill;
use self::joint::Joint;
use self::new_view::{NewView, Source, Steps};
use self::surface::Maps;
use crate::refocus::Kernel;
use crate::{BaselineRatio, Error, LightField, LightFieldShape, Sample, ViewIndex};

/// How many rings of views around the viewpoint may show what the four next to it do not see.
const RINGS: usize = 3;

/// The disparities of a view, from those of the view `at`: (v, u), row by row.
pub(crate) fn map_of_view(
    shape: LightFieldShape,
    map: ArrayView2<'_, f32>,
    (at, view): (ViewIndex, ViewIndex),
    ratio: BaselineRatio,
) -> Result<Vec<f32>, Error> {
    Ok(Maps::new(shape, ViewDisparities::OfView(map, at))?.surface(view, ratio)?.into_map())
}

/// Where the surfaces of a light field are.
#[derive(Debug, Clone, Copy)]
pub enum ViewDisparities<'a> {
    /// The same disparity everywhere, px: all is in one plane.
    Plane(f64),
    /// The map of one view, `(v, u)`. What other views see is found from it.
    OfView(ArrayView2<'a, f32>, ViewIndex),
    /// The maps of all views, `(v, u, t, s)`.
    OfAll(ArrayView4<'a, f32>),
}

/// A synthesized view.
#[derive(Debug, Clone)]
pub struct SynthesizedView {
    /// The image, `(v, u, c)`.
    pub image: Array3<f32>,
    /// Its disparity map, `(v, u)`, px between adjacent views.
    pub disparity_px: Array2<f32>,
    /// The pixels that no view shows, `(v, u)`: the farthest surface around them fills them. If no view shows any pixel, the image is 0.
    pub holes: Array2<bool>,
}

/// A synthesized image of a camera anywhere.
#[derive(Debug, Clone)]
pub struct SynthesizedImage {
    /// The image, `(row, column, channel)`.
    pub image: Array3<f32>,
    /// Its planar depth, `(row, column)`, m; +infinity where nothing is hit.
    pub depth_m: Array2<f32>,
    /// The pixels that no camera shows, `(row, column)`: the farthest surface around them fills them. If no camera shows any pixel,
    /// the image is 0.
    pub holes: Array2<bool>,
}

/// Synthesizes the views of a light field at other viewpoints.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightField, LightFieldShape, ViewDisparities, ViewSynthesis};
/// use ndarray::Array3;
///
/// // Two views of a dot that moves by two pixels to the left.
/// let shape = LightFieldShape::new(GridSize::new(1, 2), GridSize::new(1, 7))?;
/// let mut views = Array3::<f32>::zeros((1, 14, 1));
/// (views[[0, 4, 0]], views[[0, 7 + 2, 0]]) = (1.0, 1.0);
/// let light_field = LightField::from_viewpoint_grid(views, shape)?;
/// let half_way = ViewSynthesis::default().at(&light_field, ViewDisparities::Plane(2.0), (0.0, 0.5))?;
/// assert_eq!(half_way.image.into_raw_vec_and_offset().0, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ViewSynthesis {
    kernel: Kernel,
    ratio: BaselineRatio,
}

impl ViewSynthesis {
    /// Sets the kernel for samples between the pixels of a view. With [`Kernel::CatmullRom`] and disparity maps, what all views around
    /// the viewpoint show on one surface is interpolated from the pixels of all of them (ordinary kriging), which blurs less.
    #[must_use]
    pub fn kernel(self, kernel: Kernel) -> Self {
        Self { kernel, ..self }
    }

    /// Sets the ratio of the baselines, [`Rig::baseline_ratio`](crate::Rig::baseline_ratio).
    #[must_use]
    pub fn baseline_ratio(self, ratio: BaselineRatio) -> Self {
        Self { ratio, ..self }
    }

    /// Returns the view at a row and a column of the view grid, which may be fractions.
    ///
    /// # Accuracy
    ///
    /// At a view it is that view. Lines meet surfaces within 1e-3 px. The result does not depend on the number of threads.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the viewpoint lies outside of the grid, or no disparity is a number; [`Error::Shape`] if maps do
    /// not have the shape of the light field; [`Error::OutOfMemory`] if the result does not fit into memory.
    pub fn at<S>(
        &self,
        light_field: &LightField<S>,
        disparities: ViewDisparities<'_>,
        (t, s): (f64, f64),
    ) -> Result<SynthesizedView, Error>
    where
        S: Data + Sync,
        S::Elem: Sample,
    {
        let shape = light_field.shape();
        for (what, value, count) in [("view row", t, shape.views().rows), ("view column", s, shape.views().columns)] {
            if !(0.0..=(count - 1) as f64).contains(&value) {
                return Err(Error::BadNumber { what, value, need: "within the grid of views" });
            }
        }
        let maps = Maps::new(shape, disparities)?;
        let joint = match (disparities, self.kernel) {
            (ViewDisparities::Plane(_), _) | (_, Kernel::Bilinear) => None,
            _ => Joint::new([t, s], [self.ratio.vertical(), self.ratio.horizontal()], maps.range_px()),
        };
        let mut view = NewView::new(shape.lenses(), light_field.channels())?;
        for ring in 0..RINGS {
            if !view.has_holes() {
                break;
            }
            let joint = joint.as_ref().filter(|_| ring == 0);
            view.add(&self.sources(light_field, &maps, (t, s), ring)?, self.kernel, joint);
        }
        let made = view.finished();
        Ok(SynthesizedView { image: made.image, disparity_px: made.disparity_px, holes: made.holes })
    }

    /// The views of a ring around a viewpoint: ring 0 are the up to four of the cell that it lies in.
    fn sources<'a, S>(
        &self,
        light_field: &'a LightField<S>,
        maps: &Maps<'_>,
        (t, s): (f64, f64),
        ring: usize,
    ) -> Result<Vec<Source<'a, S::Elem, Steps>>, Error>
    where
        S: Data,
        S::Elem: Sample,
    {
        let first = |at: f64| at.floor() as isize;
        let last = |at: f64| at.ceil() as isize;
        let ring = ring as isize;
        let mut sources = Vec::new();
        for row in first(t) - ring..=last(t) + ring {
            for column in first(s) - ring..=last(s) + ring {
                let is_inner = |at: isize, center: f64| at > first(center) - ring && at < last(center) + ring;
                let in_grid = |at: isize, count: usize| at >= 0 && (at as usize) < count;
                let is_on_ring = ring == 0 || !is_inner(row, t) || !is_inner(column, s);
                if !is_on_ring || !in_grid(row, maps.views().rows) || !in_grid(column, maps.views().columns) {
                    continue;
                }
                let away = [row as f64 - t, column as f64 - s];
                let weight = match ring {
                    0 => (1.0 - away[0].abs()) * (1.0 - away[1].abs()),
                    _ => 1.0 / (away[0] * away[0] + away[1] * away[1]),
                };
                let view = ViewIndex { row: row as usize, column: column as usize };
                sources.push(Source {
                    image: light_field.view(view.row, view.column)?,
                    surface: maps.surface(view, self.ratio)?,
                    range_px: maps.range_px(),
                    motion: Steps([-away[0] * self.ratio.vertical(), -away[1] * self.ratio.horizontal()]),
                    weight: weight as f32,
                });
            }
        }
        Ok(sources)
    }
}
