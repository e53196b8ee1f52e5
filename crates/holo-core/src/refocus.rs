//! Digital refocusing by shift-and-sum.
//!
//! A point at `(v, u)` of the reference view is at `(v - d*dt, u - d*ds)` in the view `dt` rows down and `ds` columns
//! right, where d is its disparity. To focus on the plane of disparity d, every view is sampled there, and the samples
//! are averaged: points of the plane coincide, other points spread over as many pixels as the aperture has views times
//! the difference of disparity. The weights of the views are the synthetic [`Aperture`].
//!
//! A view contributes to a pixel only if the sample is within its image, and the sum is divided by the weight of the
//! contributing views. The image edges are therefore as bright as the middle, from fewer views.
//!
//! # Shift-and-sum of LFToolbox
//!
//! `LFFiltShiftSum` takes a slope instead of a disparity and centers the aperture between the views:
//! [`Refocus::at_slope`]. The slope of plenpy's `get_refocus` has the opposite sign. [`slope_from_disparity`] and [`disparity_from_slope`] convert between the two.
//!
//! # Source
//!
//! Shift-and-sum: Ng et al., *Light Field Photography with a Hand-Held Plenoptic Camera*, 2005.

mod aperture;
mod every_pixel;
mod focal_plane;
mod kernel;
mod shift_sum;
mod synthetic_aperture;

pub use aperture::{Aperture, ApertureShape};
pub use focal_plane::FocalPlane;
pub use kernel::Kernel;
pub(crate) use kernel::{add_pixels, add_sample};
pub use synthetic_aperture::{FocalSurface, SyntheticAperture};

use ndarray::{Array2, Array3, ArrayRef2, Data};

use crate::{BaselineRatio, Error, GridSize, LightField, Real, Rig, Sample};

/// The settings of refocusing: aperture, reference viewpoint and interpolation kernel.
///
/// # Examples
///
/// ```
/// use holo_core::refocus::Refocus;
/// use holo_core::{GridSize, LightField, LightFieldShape};
/// use ndarray::Array3;
///
/// // Three views in a row of a dot that moves by one pixel to the left from view to view: its disparity is 1.
/// let shape = LightFieldShape::new(GridSize::new(1, 3), GridSize::new(1, 5))?;
/// let mut views = Array3::<u8>::zeros((1, 15, 1));
/// for view in 0..3 {
///     views[[0, 5 * view + 3 - view, 0]] = 90;
/// }
/// let light_field = LightField::from_viewpoint_grid(views, shape)?;
/// let refocus = Refocus::new(shape.views())?;
/// let sharp = refocus.at_disparity(&light_field, 1.0)?;
/// assert_eq!(sharp.into_raw_vec_and_offset().0, [0.0, 0.0, 90.0, 0.0, 0.0]);
/// let blurred = refocus.at_disparity(&light_field, 0.0)?;
/// assert_eq!(blurred.into_raw_vec_and_offset().0, [0.0, 30.0, 30.0, 30.0, 0.0]);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Refocus {
    aperture: Aperture,
    kernel: Kernel,
    reference: (f64, f64),
    ratio: BaselineRatio,
}

impl Refocus {
    /// Returns settings with equal weights of all views, the central view (row T/2, column S/2, rounded down) as
    /// reference, and the Catmull-Rom kernel.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if there are no views; [`Error::TooLarge`] and [`Error::OutOfMemory`] if there are too
    /// many.
    pub fn new(views: GridSize) -> Result<Self, Error> {
        Ok(Self::with_aperture(Aperture::all(views)?))
    }

    /// Returns settings with the given aperture, the central view as reference, and the Catmull-Rom kernel.
    #[must_use]
    pub fn with_aperture(aperture: Aperture) -> Self {
        let views = aperture.views();
        let reference = ((views.rows / 2) as f64, (views.columns / 2) as f64);
        Self { aperture, kernel: Kernel::default(), reference, ratio: BaselineRatio::EQUAL }
    }

    /// Sets the kernel for samples between the pixels of a view.
    #[must_use]
    pub fn kernel(self, kernel: Kernel) -> Self {
        Self { kernel, ..self }
    }

    /// Sets the reference viewpoint, a row and column of the view grid. It may lie between views or outside the grid.
    ///
    /// `((T-1)/2, (S-1)/2)` is the middle of the rig. For even counts it is half a view from the central view.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if a number is NaN or infinite.
    pub fn reference(self, t: f64, s: f64) -> Result<Self, Error> {
        for (what, value) in [("reference view row", t), ("reference view column", s)] {
            finite(what, value)?;
        }
        Ok(Self { reference: (t, s), ..self })
    }

    /// Sets the ratio of the baselines, [`Rig::baseline_ratio`]. The default is [`BaselineRatio::EQUAL`].
    ///
    /// It applies to disparities. [`Refocus::at_distance_m`] uses the baselines of its rig, and [`Refocus::at_slope`]
    /// none.
    #[must_use]
    pub fn baseline_ratio(self, ratio: BaselineRatio) -> Self {
        Self { ratio, ..self }
    }

    /// Returns the image that is in focus where the disparity is `disparity_px`.
    ///
    /// # Shape
    ///
    /// `(v, u, c)`, the size of a view.
    ///
    /// # Units
    ///
    /// Disparity in pixels between adjacent views, positive nearer than the focus plane of the rig. Samples keep their
    /// scale.
    ///
    /// # Accuracy
    ///
    /// Within `(S + 4 T + 16) * 2^-23` of the sum in exact arithmetic, times the largest sample: `f32` sums, over the
    /// views of each row first. The result does not depend on the number of threads. A pixel outside all views of the
    /// aperture is NaN. If the reference is a view of the aperture, there are no such pixels.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the aperture has another number of views; [`Error::BadNumber`] if the disparity is NaN or
    /// infinite; [`Error::OutOfMemory`] if the allocation of `V * U * (T + 1) * C` numbers fails.
    pub fn at_disparity<S>(&self, light_field: &LightField<S>, disparity_px: f64) -> Result<Array3<f32>, Error>
    where
        S: Data,
        S::Elem: Sample,
    {
        finite("disparity in pixels", disparity_px)?;
        self.sum(light_field, disparity_px * self.ratio.vertical(), disparity_px * self.ratio.horizontal())
    }

    /// Returns the image that LFToolbox's `LFFiltShiftSum` focuses at a slope, up to aperture and reference view.
    ///
    /// The toolbox knows no baselines and has a step of its own for each axis: [`disparity_from_slope`] of the number of
    /// view rows and of view columns. An axis with one view has no step.
    ///
    /// # Errors
    ///
    /// As [`Refocus::at_disparity`].
    pub fn at_slope<S>(&self, light_field: &LightField<S>, slope: f64) -> Result<Array3<f32>, Error>
    where
        S: Data,
        S::Elem: Sample,
    {
        finite("slope", slope)?;
        let views = light_field.shape().views();
        let disparity_px = |views: usize| if views < 2 { Ok(0.0) } else { disparity_from_slope(slope, views) };
        self.sum(light_field, disparity_px(views.rows)?, disparity_px(views.columns)?)
    }

    /// Returns the image that is in focus at a distance from the cameras.
    ///
    /// # Units
    ///
    /// Planar depth in meters; infinity is allowed.
    ///
    /// # Errors
    ///
    /// As [`Refocus::at_disparity`]; [`Error::BadNumber`] if the distance is not above 0; [`Error::Shape`] if the
    /// shapes of rig and light field differ.
    ///
    /// # Source
    ///
    /// Eq. 3, for rows and columns with their own baselines.
    pub fn at_distance_m<S>(
        &self,
        light_field: &LightField<S>,
        rig: &Rig,
        distance_m: f64,
    ) -> Result<Array3<f32>, Error>
    where
        S: Data,
        S::Elem: Sample,
    {
        let distance_m = crate::base::error::positive_or_infinite("distance in meters", distance_m)?;
        check_rig(light_field, rig)?;
        let vertical_px = finite("disparity in pixels", rig.disparity_y().from_depth_m(distance_m))?;
        let horizontal_px = finite("disparity in pixels", rig.disparity_x().from_depth_m(distance_m))?;
        self.sum(light_field, vertical_px, horizontal_px)
    }

    /// Returns the image that is in focus on a plane before the middle of the rig, which may be tilted.
    ///
    /// # Accuracy
    ///
    /// As [`Refocus::at_disparity`]. Pixels of the reference view that do not look at the plane are NaN.
    ///
    /// # Errors
    ///
    /// As [`Refocus::at_distance_m`].
    ///
    /// # Source
    ///
    /// Isaksen et al., *Dynamically Reparameterized Light Fields*, 2000.
    pub fn at_plane<S>(&self, light_field: &LightField<S>, rig: &Rig, plane: FocalPlane) -> Result<Array3<f32>, Error>
    where
        S: Data,
        S::Elem: Sample,
    {
        if plane.is_straight() {
            return self.at_distance_m(light_field, rig, plane.distance_m());
        }
        check_rig(light_field, rig)?;
        let (lenses, views) = (light_field.shape().lenses(), light_field.shape().views());
        // Rays are linear in the viewpoint: x in its column, y in its row.
        let [down, along] = [(self.reference.0, views.rows), (self.reference.1, views.columns)]
            .map(|(at, count)| if count > 1 { at / (count - 1) as f64 } else { 0.0 });
        let at_reference = |first: [f64; 3], last: [f64; 3]| {
            [first[0] + along * (last[0] - first[0]), first[1] + down * (last[1] - first[1])]
        };
        let disparity = rig.disparity_x();
        let map = Array2::from_shape_fn((lenses.rows, lenses.columns), |(v, u)| {
            let [first, last] =
                [[0, 0], [views.rows - 1, views.columns - 1]].map(|[t, s]| rig.ray(v, u, t, s, 0.5, 0.5));
            let origin_m = at_reference(first.origin_m, last.origin_m);
            let inverse_depth = plane.inverse_depth(origin_m, at_reference(first.direction, last.direction));
            if inverse_depth > 0.0 { disparity.from_depth_m(1.0 / inverse_depth) } else { f64::NAN }
        });
        let own = self.clone().baseline_ratio(rig.baseline_ratio());
        own.all_in_focus(light_field, &map)
    }

    /// Returns an iterator over the images for a list of disparities. Each image is computed on demand.
    ///
    /// # Errors
    ///
    /// As [`Refocus::at_disparity`], for each image.
    pub fn focal_stack<'a, S>(
        &'a self,
        light_field: &'a LightField<S>,
        disparities_px: &'a [f64],
    ) -> impl ExactSizeIterator<Item = Result<Array3<f32>, Error>> + 'a
    where
        S: Data,
        S::Elem: Sample,
    {
        disparities_px.iter().map(move |&disparity_px| self.at_disparity(light_field, disparity_px))
    }

    /// Returns the all-in-focus image: each pixel is refocused at its own disparity.
    ///
    /// Occlusion is ignored: next to a depth edge, views that see the nearer surface contribute to pixels of the
    /// farther one. A narrower aperture narrows these artifacts.
    ///
    /// # Shape
    ///
    /// The map is (V, U), in the pixels of the reference view; the result is `(v, u, c)`.
    ///
    /// # Accuracy
    ///
    /// As [`Refocus::at_disparity`]. A pixel whose disparity is NaN or infinite is NaN.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the map has not the size of a view or the aperture has another number of views;
    /// [`Error::OutOfMemory`] if an allocation fails.
    pub fn all_in_focus<S, D>(
        &self,
        light_field: &LightField<S>,
        disparity_px: &ArrayRef2<D>,
    ) -> Result<Array3<f32>, Error>
    where
        S: Data,
        S::Elem: Sample,
        D: Real,
    {
        self.check_views(light_field)?;
        let lenses = light_field.shape().lenses();
        if disparity_px.dim() != (lenses.rows, lenses.columns) {
            let (expected, found) = (vec![lenses.rows, lenses.columns], disparity_px.shape().to_vec());
            return Err(Error::Shape { what: "disparity map", expected, found });
        }
        every_pixel::all_in_focus(self, light_field.samples(), disparity_px.view())
    }

    fn sum<S>(&self, light_field: &LightField<S>, vertical_px: f64, horizontal_px: f64) -> Result<Array3<f32>, Error>
    where
        S: Data,
        S::Elem: Sample,
    {
        self.check_views(light_field)?;
        shift_sum::shift_and_sum(self, light_field.samples(), vertical_px, horizontal_px)
    }

    fn check_views<S: Data>(&self, light_field: &LightField<S>) -> Result<(), Error> {
        let (views, aperture) = (light_field.shape().views(), self.aperture.views());
        if views == aperture {
            return Ok(());
        }
        let expected = vec![views.rows, views.columns];
        Err(Error::Shape { what: "aperture", expected, found: vec![aperture.rows, aperture.columns] })
    }
}

pub(crate) fn check_rig<S: Data>(light_field: &LightField<S>, rig: &Rig) -> Result<(), Error> {
    if *rig.shape() == light_field.shape() {
        return Ok(());
    }
    let (expected, found) = (rig.shape().array_shape(light_field.channels()), light_field.samples().shape().to_vec());
    Err(Error::Shape { what: "light field", expected: expected.to_vec(), found })
}

/// Returns the slope at which LFToolbox's `LFFiltShiftSum` focuses on a disparity: `-d (T-1)/T` for T views along the
/// axis.
///
/// The toolbox shifts the views by `linspace(-1/2, 1/2, T) * slope * T` pixels, with a step of `slope * T/(T-1)`
/// between views, and adds the shift to the sample position. The results agree for arrays with the view order of this
/// crate, without flips. The reference of the toolbox is the middle of the grid: `Refocus::reference((T-1)/2,
/// (S-1)/2)`.
///
/// # Errors
///
/// [`Error::BadNumber`] if there are fewer than two views.
///
/// # Examples
///
/// ```
/// use holo_core::refocus::{disparity_from_slope, slope_from_disparity};
///
/// // Nine views: the step is 9/8 of the slope.
/// assert_eq!(slope_from_disparity(1.125, 9)?, -1.0);
/// assert_eq!(disparity_from_slope(-1.0, 9)?, 1.125);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn slope_from_disparity(disparity_px: f64, views: usize) -> Result<f64, Error> {
    let views = at_least_two(views)?;
    Ok(-disparity_px * ((views - 1.0) / views))
}

/// Returns the disparity on which LFToolbox's `LFFiltShiftSum` focuses at a slope: `-slope T/(T-1)`, the inverse of
/// [`slope_from_disparity`].
///
/// # Errors
///
/// As [`slope_from_disparity`].
pub fn disparity_from_slope(slope: f64, views: usize) -> Result<f64, Error> {
    let views = at_least_two(views)?;
    Ok(-slope * (views / (views - 1.0)))
}

fn at_least_two(views: usize) -> Result<f64, Error> {
    let value = views as f64;
    let what = "number of views along the axis";
    if views < 2 { Err(Error::BadNumber { what, value, need: "at least 2" }) } else { Ok(value) }
}

fn finite(what: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() { Ok(value) } else { Err(Error::BadNumber { what, value, need: "finite" }) }
}
