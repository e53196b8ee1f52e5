//! The render request, its validation, and the result of a render.

use std::ops::{Deref, Range};

use holo_core::plenoptic::PlenopticCamera;
use holo_core::{LightFieldOwned, Rig, ViewIndex};
use ndarray::{Array2, Array3};

use super::transport::{Reuse, TextureFilter, Transport, transport_setters};
use crate::error::Error;
use crate::film::error_distribution::ErrorDistribution;
use crate::film::layers::{Layer, LayerSet, Layers};
use crate::integrator::{Integrator, RayCounts};
use crate::sampling::Sampling;

/// The camera of a request. The pose of the renderer is that of a rig, or of the entrance pupil of a plenoptic camera.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Camera {
    /// A grid of parallel pinhole cameras: views, microlenses, intrinsics, baseline, focus distance and projection.
    Rig(Rig),
    /// A main lens and a microlens array in front of a sensor. Its image is a light field of one view, whose pixels are
    /// those of the sensor.
    Plenoptic(Box<PlenopticCamera>),
}

impl From<Rig> for Camera {
    fn from(rig: Rig) -> Self {
        Self::Rig(rig)
    }
}

impl From<PlenopticCamera> for Camera {
    fn from(camera: PlenopticCamera) -> Self {
        Self::Plenoptic(Box::new(camera))
    }
}

impl Camera {
    /// Returns the rig; `None` for other cameras.
    #[must_use]
    pub fn rig(&self) -> Option<&Rig> {
        match self {
            Self::Rig(rig) => Some(rig),
            Self::Plenoptic(_) => None,
        }
    }

    /// The rows of pixels of one view.
    pub(super) fn row_count(&self) -> usize {
        match self {
            Self::Rig(rig) => rig.shape().lenses().rows,
            Self::Plenoptic(camera) => camera.sensor().size.rows,
        }
    }
}

/// A render request: the camera, the settings of light transport, and the outputs.
///
/// The fields have the defaults of [`Request::new`]; they are validated by
/// [`Renderer::render`](super::Renderer::render).
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape, Rig};
/// use holo_render::{Integrator, Request};
///
/// let rig = Rig::builder(LightFieldShape::new(GridSize::new(3, 3), GridSize::new(40, 60))?).build()?;
/// let request = Request::new(rig).integrator(Integrator::Path).samples(16).sky([0.2, 0.3, 0.4]);
/// assert_eq!(request.transport.samples, 16.into());
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Request {
    /// The camera.
    pub camera: Camera,
    /// Of a rig: the width of the square around its center over which a pixel averages, px. 1, the default: the pixel itself. N: of
    /// the microlenses of an array that was exposed in N x N positions, 1/N of its pitch apart, each is N px wide.
    pub filter_width_px: f64,
    /// Light transport: the integrator and its samples.
    pub transport: Transport,
    /// The layers (AOVs) beside color. They describe the first hit of the ray through the center of the pixel, for any
    /// number of samples; with a plenoptic camera of the chief ray, which also passes the center of the nearest microlens.
    /// Its `Disparity` is that of views of neighboring pixels (Eq. 3 of the equivalent rig), which has a meaning for
    /// unfocused cameras only.
    pub layers: LayerSet,
    /// Of a rig: the views for which the layers are rendered.
    pub ground_truth: GroundTruth,
    /// Of a rig: the rendered views.
    pub views: Views,
    /// Whether the noise of color is reduced with the samples of neighboring views, or of those pixels of a plenoptic camera
    /// that see the same point.
    pub denoise: Denoise,
    /// Whether [`Rendered::error`] is estimated.
    pub estimate_error: bool,
    /// Of a plenoptic camera: whether [`Rendered::statistics`] are computed.
    pub statistics: bool,
    /// The range of rows to render, of microlenses of a rig or of pixels of a plenoptic camera; `None` renders all. A range
    /// of [`Renderer::shard_rows`](super::Renderer::shard_rows) has the same values as in the whole image.
    pub rows: Option<Range<usize>>,
}

impl Request {
    /// A request with one sample per pixel and a black environment.
    #[must_use]
    pub fn new(camera: impl Into<Camera>) -> Self {
        Self {
            camera: camera.into(),
            filter_width_px: 1.0,
            transport: Transport::default(),
            layers: DEPTH_AND_DISPARITY,
            ground_truth: GroundTruth::Central,
            views: Views::All,
            denoise: Denoise::default(),
            estimate_error: false,
            statistics: false,
            rows: None,
        }
    }

    /// Sets [`Request::camera`].
    #[must_use]
    pub fn camera(mut self, camera: impl Into<Camera>) -> Self {
        self.camera = camera.into();
        self
    }

    setters! {
        filter_width_px: f64,
        transport: Transport,
        layers: LayerSet,
        ground_truth: GroundTruth,
        views: Views,
        denoise: Denoise,
        estimate_error: bool,
        statistics: bool,
        rows: Option<Range<usize>>,
    }

    transport_setters!();
}

/// The default layers.
pub(super) const DEPTH_AND_DISPARITY: LayerSet = LayerSet::of(&[Layer::Depth, Layer::Disparity]);

/// The rendered views of a rig.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Views {
    /// All views, in their grid.
    #[default]
    All,
    /// A list of views, side by side in one row: the light fields of [`Rendered`] have 1 x N views. Every pixel has the
    /// same random numbers as in the whole image, and with [`Reuse::Off`] the same value up to the rounding of the ray tracing
    /// backend, which depends on the rays that are traced together.
    List(Vec<ViewIndex>),
}

/// The reduction of noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Denoise {
    /// None: every pixel is the mean of its own samples, which is unbiased.
    #[default]
    Off,
    /// Reconstruction across views: every pixel is a mean over the samples of neighboring views, as many as show the same
    /// within the noise. Biased where the views differ by less than that; the bias vanishes as the samples grow. A pixel of a
    /// plenoptic camera is a mean over the pixels, behind its own and other microlenses, that see the same point.
    Views,
}

impl Denoise {
    /// The name of the method of [`Denoise::Views`], for manifests: it changes when the results do.
    pub const METHOD: &'static str = "mean over neighboring views, 1";

    /// The same for plenoptic cameras.
    pub const RAW_METHOD: &'static str = "mean over pixels that see the same point, 1";
}

/// The views for which ground truth is rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundTruth {
    /// The central view of the rig, whether or not it is one of [`Request::views`].
    #[default]
    Central,
    /// All views of [`Request::views`], and the central view.
    All,
}

/// The result of a render.
///
/// The memory layout of light fields is the elemental image array. All arrays have the rows of [`Request::rows`]. The raw
/// image of a plenoptic camera is a light field of one view: its axes v and u are the rows and columns of the sensor.
#[derive(Debug)]
pub struct Rendered {
    /// Linear RGB radiance, axes (v, u, t, s, c); of a plenoptic camera times its [white
    /// image](holo_core::plenoptic::PlenopticCamera::white_image). `None` for the integrator `Depth`.
    pub color: Option<LightFieldOwned<f32>>,
    /// The estimated relative standard error of `color`, axes (v, u, t, s, c) with one channel, if
    /// [`Request::estimate_error`] is set: the square root of variance and squared bias, averaged over 3 x 3 microlenses and
    /// about 6 sqrt(n) of n views along an axis and divided by the luminance there; of a plenoptic camera 8 x 8 pixels, and 0
    /// for pixels without light. The estimate is above the true error where samples are better distributed than independent ones. `None` for the
    /// integrator `Depth`.
    pub error: Option<LightFieldOwned<f32>>,
    /// The distribution of the same over all pixels, if [`Request::estimate_error`] is set or color is reconstructed.
    pub error_distribution: Option<ErrorDistribution>,
    /// The layers of the central view, axes (v, u, c). Units: [`layers`](crate::layers).
    pub central: Layers<Array3<f32>>,
    /// The layers of all views, axes (v, u, t, s, c), if [`Request::ground_truth`] is [`GroundTruth::All`].
    pub all: Option<Layers<LightFieldOwned<f32>>>,
    /// Statistics of the inverse depth, if [`Request::statistics`] is set and there is color.
    pub statistics: Option<RawStatistics>,
    /// The integrator that was used.
    pub integrator: Integrator,
    /// The reason for the choice of the integrator.
    pub why: String,
    /// The number of rays, including those for ground truth.
    pub rays: RayCounts,
    /// The number of color samples: views x lenses x samples per pixel, or fewer with a target error.
    pub samples: u64,
}

/// What the pixels of a raw image see, over the samples of their color with their weights; axes (row, column). 0 where no
/// light reaches a pixel.
#[derive(Debug)]
pub struct RawStatistics {
    /// The mean of 1 / depth, 1/m; rays that miss the scene count as 0.
    pub inverse_depth_mean: Array2<f32>,
    /// The standard deviation of 1 / depth, 1/m.
    pub inverse_depth_deviation: Array2<f32>,
    /// The share of the light whose rays hit the scene.
    pub coverage: Array2<f32>,
}

/// A request of a rig.
#[derive(Clone, Copy)]
pub(super) struct RigRequest<'a> {
    pub rig: &'a Rig,
    pub request: &'a Request,
}

impl Deref for RigRequest<'_> {
    type Target = Request;

    fn deref(&self) -> &Request {
        self.request
    }
}

impl Request {
    /// The request as one of a rig.
    pub(super) fn of_rig(&self) -> Result<RigRequest<'_>, Error> {
        match &self.camera {
            Camera::Rig(rig) => Ok(RigRequest { rig, request: self }),
            Camera::Plenoptic(_) => Err(Error::BadSetting("this needs a rig, and the camera is plenoptic".into())),
        }
    }

    /// The range of rows to render.
    pub(super) fn row_range(&self) -> Range<usize> {
        self.rows.clone().unwrap_or(0..self.camera.row_count())
    }
}
