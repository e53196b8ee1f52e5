//! The render request, its validation, and the result of a render.

use std::ops::Range;

use holo_core::{LightFieldOwned, Rig, ViewIndex};
use ndarray::Array3;

use crate::error::Error;
use crate::film::layers::{Layer, LayerSet, Layers};
use crate::geometry::MAX_COORDINATE_M;
use crate::integrator::{Integrator, RayCounts, direct};
use crate::sampling::{MAX_SAMPLES, Sampling};
use crate::setters::setters;
use holo_scene::MAX_RADIANCE;

/// The maximum of `max_bounces`: far more than any scene needs, and few enough for the dimensions of the random
/// numbers.
const MAX_BOUNCES: u32 = 65_536;

/// The largest id that f32 represents exactly together with all smaller ones: 2^24.
pub(super) const MAX_EXACT_ID: usize = 1 << 24;

/// A render request: the rig, the integrator with its settings, and the outputs.
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
/// assert_eq!(request.samples, 16);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Request {
    /// The rig: views, microlenses, intrinsics, baseline, focus distance and projection.
    pub rig: Rig,
    /// The integrator.
    pub integrator: Integrator,
    /// Samples per pixel, 1 to 65,536. A single sample goes through the center of the pixel; more are distributed over
    /// the pixel (box filter).
    pub samples: u32,
    /// The random seed. The same seed gives the same image.
    pub seed: u64,
    /// Radiance of the constant environment, linear RGB, 0 to [`MAX_RADIANCE`].
    pub sky: [f32; 3],
    /// The maximum number of bounces (scatterings), 1 to 65,536, of the integrator `Path`, also if `Auto` selects it.
    pub max_bounces: u32,
    /// Whether paths with low throughput may be terminated by Russian roulette (unbiased).
    pub roulette: bool,
    /// The target of the relative standard error of each pixel for adaptive sampling; `samples` is then the maximum per
    /// pixel. `None`: all pixels get `samples`. With [`Denoise::Views`] it is the error after the reconstruction, estimated
    /// in rounds after 4, 8, 16, ... samples; shards then render 7 more lens rows on either side for every round.
    pub target_error: Option<f64>,
    /// Whether `Auto` includes indirect illumination between diffuse surfaces. Otherwise paths continue only from metal
    /// and glass.
    pub indirect: bool,
    /// Whether light is scattered more than once between the microfacets of rough surfaces. Without it rough metal,
    /// coats and panes lose energy, up to 69 %, as in renderers without this model (Mitsuba's).
    pub multiple_scattering: bool,
    /// The largest radiance that a path may add to a pixel at a vertex after the first; larger contributions are scaled
    /// down. It removes single bright pixels (fireflies) and darkens what they are the noise of: caustics, reflections
    /// of lamps. The error vanishes as the limit grows; infinite (the default) is unbiased.
    pub indirect_limit: f32,
    /// Whether shadow rays go straight through smooth panes and bodies of glass: attenuated, not bent. Removes the noise
    /// of light that only scattered rays find behind glass, and lets the light of point lights through. Exact for panes;
    /// an approximation for bodies, whose caustics become plain shadows. Off by default.
    pub transparent_shadows: bool,
    /// Whether surfaces that are not [double-sided](holo_scene::Material::double_sided) are invisible from behind: to
    /// camera rays and ground truth, as in rasterizers. Shadows, reflections and glass see both sides.
    pub cull: bool,
    /// The layers (AOVs) beside color. They describe the first hit of the ray through the center of the pixel, for any
    /// number of samples.
    pub layers: LayerSet,
    /// The views for which the layers are rendered.
    pub ground_truth: GroundTruth,
    /// The rendered views.
    pub views: Views,
    /// The sample sequence of the pixels.
    pub sampling: Sampling,
    /// Whether neighboring views share the light that their rays find.
    pub reuse: Reuse,
    /// Whether the textures of the surfaces that camera rays hit are averaged over the part of the pixel that a sample
    /// stands for. Not with [`Denoise::Views`]: its windows hold so many samples that the bias would be what is left.
    pub texture_filter: TextureFilter,
    /// Whether the noise of color is reduced with the samples of neighboring views.
    pub denoise: Denoise,
    /// Whether [`Rendered::error`] is estimated.
    pub estimate_error: bool,
    /// The range of lens rows to render; `None` renders all. A range of
    /// [`Renderer::shard_lens_rows`](super::Renderer::shard_lens_rows) has the same values as in the whole image.
    pub lens_rows: Option<Range<usize>>,
}

impl Request {
    /// A request with the defaults of the command line, one sample per pixel and a black environment.
    #[must_use]
    pub fn new(rig: Rig) -> Self {
        Self {
            rig,
            integrator: Integrator::Auto,
            samples: 1,
            seed: 0,
            sky: [0.0; 3],
            max_bounces: 8,
            roulette: true,
            target_error: None,
            indirect: true,
            multiple_scattering: true,
            indirect_limit: f32::INFINITY,
            transparent_shadows: false,
            cull: false,
            layers: DEPTH_AND_DISPARITY,
            ground_truth: GroundTruth::Central,
            views: Views::All,
            sampling: Sampling::default(),
            reuse: Reuse::default(),
            texture_filter: TextureFilter::default(),
            denoise: Denoise::default(),
            estimate_error: false,
            lens_rows: None,
        }
    }

    setters! {
        rig: Rig,
        integrator: Integrator,
        samples: u32,
        seed: u64,
        sky: [f32; 3],
        max_bounces: u32,
        roulette: bool,
        target_error: Option<f64>,
        indirect: bool,
        multiple_scattering: bool,
        indirect_limit: f32,
        transparent_shadows: bool,
        cull: bool,
        layers: LayerSet,
        ground_truth: GroundTruth,
        views: Views,
        sampling: Sampling,
        reuse: Reuse,
        texture_filter: TextureFilter,
        denoise: Denoise,
        estimate_error: bool,
        lens_rows: Option<Range<usize>>,
    }
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
    /// same random numbers as in the whole image, and with [`Reuse::Off`] the same value.
    List(Vec<ViewIndex>),
}

/// The filter of textures. The first hits of camera rays are filtered, and those textures that enter the radiance
/// linearly: base color and emission of materials without alpha, in cells that lie within one triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// None: a texture counts at the hit point, bilinearly interpolated. Unbiased.
    Off,
    /// The mean over a cell of the pixel. A pixel is divided into the largest number of 4^m cells that is not above the
    /// number of samples. Biased where texture and light vary together within a cell (a normal map: 0.25 % of the mean of
    /// `garden` at 4 samples and 18 x 12 pixels a view); the error vanishes with the size of the cells.
    #[default]
    Footprint,
}

/// The reuse of light samples and paths. Both variants are unbiased.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reuse {
    /// None: every pixel uses its own samples alone, so the noise of pixels is independent, and does not depend on which
    /// views are rendered.
    Off,
    /// The views of a group of 4 x 4 share samples of the environment and what their scattered rays find: for direct light,
    /// and on diffuse surfaces for paths. There is less noise in every view, and about the same in the mean of a group: the
    /// noise that is left is correlated. Direct light of a sky gains most (5 to 7 times in error x time). Without effect
    /// on single samples, which are for speed, on lists of views, with [`Denoise::Views`], which uses the same samples,
    /// and with [`Request::indirect_limit`], [`Request::transparent_shadows`] or blended alpha.
    #[default]
    Views,
}

/// The reduction of noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Denoise {
    /// None: every pixel is the mean of its own samples, which is unbiased.
    #[default]
    Off,
    /// Reconstruction across views: every pixel is a mean over the samples of neighboring views, as many as show the same
    /// within the noise. Biased where the views differ by less than that; the bias vanishes as the samples grow.
    Views,
}

impl Denoise {
    /// The name of the method of [`Denoise::Views`], for manifests: it changes when the results do.
    pub const METHOD: &'static str = "mean over neighboring views, 1";
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
/// The memory layout of light fields is the elemental image array. All arrays have the lens rows of
/// [`Request::lens_rows`].
#[derive(Debug)]
pub struct Rendered {
    /// Linear RGB radiance, axes (v, u, t, s, c); `None` for the integrator `Depth`.
    pub color: Option<LightFieldOwned<f32>>,
    /// The estimated relative standard error of `color`, axes (v, u, t, s, c) with one channel, if
    /// [`Request::estimate_error`] is set: the square root of variance and squared bias, averaged over 5 x 5 microlenses and
    /// about 8 x 8 views and divided by the luminance there. The estimate is above the true error where samples are better
    /// distributed than independent ones. `None` for the integrator `Depth`.
    pub error: Option<LightFieldOwned<f32>>,
    /// The layers of the central view, axes (v, u, c). Units: [`layers`](crate::layers).
    pub central: Layers<Array3<f32>>,
    /// The layers of all views, axes (v, u, t, s, c), if [`Request::ground_truth`] is [`GroundTruth::All`].
    pub all: Option<Layers<LightFieldOwned<f32>>>,
    /// The integrator that was used.
    pub integrator: Integrator,
    /// The reason for the choice of the integrator.
    pub why: String,
    /// The number of rays, including those for ground truth.
    pub rays: RayCounts,
    /// The number of color samples: views x lenses x samples per pixel, or fewer with a target error.
    pub samples: u64,
}

impl Request {
    /// Validates the request for a scene with this many instances and materials.
    pub(super) fn check(&self, [instances, materials]: [usize; 2]) -> Result<(), Error> {
        let split = self.rig.shape();
        if !(1..=MAX_SAMPLES).contains(&self.samples) {
            return Err(Error::BadSetting(format!("{} samples per pixel; give 1 to {MAX_SAMPLES}", self.samples)));
        }
        if self.target_error.is_some_and(|target| !(target > 0.0 && target.is_finite())) {
            return Err(Error::BadSetting("the target error must be finite and above 0".into()));
        }
        if !(1..=MAX_BOUNCES).contains(&self.max_bounces) {
            let count = self.max_bounces;
            return Err(Error::BadSetting(format!("{count} bounces; give 1 to {MAX_BOUNCES}")));
        }
        if self.indirect_limit.is_nan() || self.indirect_limit <= 0.0 {
            return Err(Error::BadSetting(format!("the indirect limit {} must be above 0", self.indirect_limit)));
        }
        if split.lenses().count() > u32::MAX as usize || split.views().count() > u32::MAX as usize {
            return Err(Error::BadSetting("2^32 or more lenses or views; choose fewer".into()));
        }
        if self.sky.iter().any(|c| !(0.0..=MAX_RADIANCE).contains(c)) {
            return Err(Error::BadSetting(format!("the sky {:?} must lie between 0 and {MAX_RADIANCE:e}", self.sky)));
        }
        // Rays are linear in all indices, so the largest coordinates occur at the corners.
        let (lenses, views) = (split.lenses(), split.views());
        for (v, u) in [(0, 0), (lenses.rows - 1, lenses.columns - 1)] {
            for (t, s) in [(0, 0), (views.rows - 1, views.columns - 1)] {
                let ray = self.rig.ray(v, u, t, s, 0.5, 0.5);
                if !ray.origin_m.iter().chain(&ray.direction).all(|x| x.abs() < MAX_COORDINATE_M) {
                    return Err(Error::BadSetting(format!(
                        "the rig is too large: a ray starts at {:?} m and runs along {:?}; \
                         choose a smaller baseline or sensor",
                        ray.origin_m, ray.direction
                    )));
                }
            }
        }
        for (layer, what, count) in
            [(Layer::ObjectId, "instances", instances), (Layer::MaterialId, "materials", materials)]
        {
            if self.layers.contains(layer) && count > MAX_EXACT_ID {
                return Err(Error::BadSetting(format!(
                    "the layer '{layer}' has exact ids of at most {MAX_EXACT_ID} {what}, but the scene has \
                     {count}: omit the layer"
                )));
            }
        }
        let needs_samples = self.denoise == Denoise::Views || self.estimate_error;
        let what = if self.estimate_error { "the estimate of the error" } else { "denoising" };
        if needs_samples && self.integrator == Integrator::Depth {
            return Err(Error::BadSetting(format!(
                "{what} needs color, which the integrator 'depth' does not render; choose another one, or leave it out"
            )));
        }
        if needs_samples && self.views != Views::All {
            return Err(Error::BadSetting(format!("{what} needs all views; render them all, or without it")));
        }
        if let Views::List(list) = &self.views {
            let outside = list.iter().find(|view| view.row >= views.rows || view.column >= views.columns);
            if let Some(ViewIndex { row, column }) = outside {
                return Err(Error::BadSetting(format!(
                    "view row {row}, column {column} is outside the {} rows and {} columns of views",
                    views.rows, views.columns
                )));
            }
            if list.is_empty() {
                return Err(Error::BadSetting("the list of views is empty; name one or more".into()));
            }
        }
        let rows = self.lens_row_range();
        if rows.is_empty() || rows.end > lenses.rows {
            let count = lenses.rows;
            return Err(Error::BadSetting(format!("lens rows {rows:?} are not a range of the {count} lens rows")));
        }
        Ok(())
    }

    /// The range of lens rows to render.
    pub(super) fn lens_row_range(&self) -> Range<usize> {
        self.lens_rows.clone().unwrap_or(0..self.rig.shape().lenses().rows)
    }

    /// The maximum number of bounces of `integrator`.
    pub(super) fn bounces(&self, integrator: Integrator) -> u32 {
        if integrator == Integrator::Direct { direct::BOUNCES } else { self.max_bounces }
    }
}
