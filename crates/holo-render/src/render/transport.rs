//! The settings of light transport: the integrator, its samples, and what both leave out.

use crate::error::Error;
use crate::integrator::{Integrator, direct};
use crate::sampling::{MAX_SAMPLES, SamplesPerPixel, Sampling};
use holo_scene::MAX_RADIANCE;

/// The maximum of `max_bounces`: far more than any scene needs, and few enough for the dimensions of the random
/// numbers.
const MAX_BOUNCES: u32 = 65_536;

/// The settings of light transport, the same for every camera: the integrator and its samples.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Transport {
    /// The integrator.
    pub integrator: Integrator,
    /// Samples per pixel, 1 to 65,536. A single sample goes through the center of the pixel; more are distributed over
    /// the pixel (box filter). With [`Denoise::Views`](crate::Denoise::Views) also less than one: of 2 to 64 pixels one is traced.
    pub samples: SamplesPerPixel,
    /// The random seed. The same seed gives the same image.
    pub seed: u64,
    /// Radiance of the constant environment, linear RGB, 0 to [`MAX_RADIANCE`].
    pub sky: [f32; 3],
    /// Radiance that camera rays receive instead of the environment if they miss the scene, linear RGB, 0 to
    /// [`MAX_RADIANCE`]; it lights nothing. `None`: the environment.
    pub backdrop: Option<[f32; 3]>,
    /// The maximum number of bounces (scatterings), 1 to 65,536, of the integrator `Path`, also if `Auto` selects it.
    pub max_bounces: u32,
    /// Whether paths with low throughput may be terminated by Russian roulette (unbiased).
    pub roulette: bool,
    /// The target of the relative standard error of each pixel for adaptive sampling; `samples` is then the maximum per
    /// pixel. `None`: all pixels get `samples`. With [`Denoise::Views`](crate::Denoise::Views) it is the error after the
    /// reconstruction, estimated in rounds after 1/16, 1/8, .. 1, 2, 4, ... samples; shards then render 12 more lens rows
    /// on either side for every round, or 12 micro-images of a plenoptic camera.
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
    /// The sample sequence of the pixels.
    pub sampling: Sampling,
    /// Whether neighboring views share the light that their rays find.
    pub reuse: Reuse,
    /// Whether the textures of the surfaces that camera rays hit are averaged over the part of the pixel that a sample
    /// stands for. Not with [`Denoise::Views`](crate::Denoise::Views): its windows hold so many samples that the bias would be what is left.
    pub texture_filter: TextureFilter,
    /// Whether the glass of a plenoptic camera's main lens refracts red, green and blue light as such, at three times the cost;
    /// otherwise all light is that of 587.6 nm. Only for [cameras with a prescription](holo_core::plenoptic::Prescription).
    pub spectral: bool,
}

impl Default for Transport {
    /// The defaults of the command line, one sample per pixel and a black environment.
    fn default() -> Self {
        Self {
            integrator: Integrator::Auto,
            samples: 1.into(),
            seed: 0,
            sky: [0.0; 3],
            backdrop: None,
            max_bounces: 8,
            roulette: true,
            target_error: None,
            indirect: true,
            multiple_scattering: true,
            indirect_limit: f32::INFINITY,
            transparent_shadows: false,
            cull: false,
            sampling: Sampling::default(),
            reuse: Reuse::default(),
            texture_filter: TextureFilter::default(),
            spectral: false,
        }
    }
}

/// Setters of [`Transport`] for requests, which have it as a field.
macro_rules! transport_setters {
    () => {
        transport_setters! {
            integrator: Integrator,
            seed: u64,
            sky: [f32; 3],
            backdrop: Option<[f32; 3]>,
            max_bounces: u32,
            roulette: bool,
            target_error: Option<f64>,
            indirect: bool,
            multiple_scattering: bool,
            indirect_limit: f32,
            transparent_shadows: bool,
            cull: bool,
            sampling: Sampling,
            reuse: Reuse,
            texture_filter: TextureFilter,
            spectral: bool,
        }
    };
    ($($name:ident: $type:ty),* $(,)?) => {
        #[doc = "Sets [`Transport::samples`]."]
        #[must_use]
        pub fn samples(mut self, samples: impl Into<$crate::SamplesPerPixel>) -> Self {
            self.transport.samples = samples.into();
            self
        }

        $(
        #[doc = concat!("Sets [`Transport::", stringify!($name), "`].")]
        #[must_use]
        pub fn $name(mut self, $name: $type) -> Self {
            self.transport.$name = $name;
            self
        }
        )*
    };
}

pub(super) use transport_setters;

/// The filter of textures. The first hits of camera rays are filtered, and those textures that enter the radiance
/// linearly: base color and emission of materials without alpha, in cells that lie within one triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// None: a texture counts at the hit point, bilinearly interpolated. Unbiased.
    Off,
    /// The mean over a cell of the pixel. A pixel is divided into the largest number of 4^m cells that is not above the
    /// number of samples; so is the microlens of a plenoptic camera. Biased where texture and light vary together within a cell (a normal map: 0.25 % of the mean of
    /// `garden` at 4 samples and 18 x 12 pixels a view); the error vanishes with the size of the cells.
    #[default]
    Footprint,
}

/// The reuse of light samples and paths. Both variants are unbiased.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reuse {
    /// None: every pixel uses its own samples alone, so the noise of pixels is independent, and does not depend on which
    /// views are rendered.
    #[default]
    Off,
    /// The views of a group of 16 neighbors (4 x 4 views where their number allows) share samples of the environment and
    /// what their scattered rays find: for direct light, and on diffuse surfaces for paths. There is less noise in every view, and about the same in the mean of a group: the
    /// noise that is left is correlated, and stands still from view to view of a group: what matches views finds a
    /// disparity of 0 in it, so that such images are not for scoring or training stereo. Direct light of a sky gains most
    /// (5 to 7 times in error x time). Without effect
    /// on single samples, which are for speed, on lists of views, with [`Denoise::Views`](crate::Denoise::Views), which uses the same samples,
    /// and with [`Transport::indirect_limit`], [`Transport::transparent_shadows`] or blended alpha.
    Views,
}

impl Transport {
    /// Validates the settings.
    pub(super) fn check(&self) -> Result<(), Error> {
        if !self.samples.is_valid() {
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
        if let Some(backdrop) = self.backdrop.filter(|rgb| rgb.iter().any(|c| !(0.0..=MAX_RADIANCE).contains(c))) {
            let range = format!("between 0 and {MAX_RADIANCE:e}");
            return Err(Error::BadSetting(format!("the backdrop {backdrop:?} must lie {range}")));
        }
        if self.sky.iter().any(|c| !(0.0..=MAX_RADIANCE).contains(c)) {
            return Err(Error::BadSetting(format!("the sky {:?} must lie between 0 and {MAX_RADIANCE:e}", self.sky)));
        }
        Ok(())
    }

    /// The maximum number of bounces of `integrator`.
    pub(super) fn bounces(&self, integrator: Integrator) -> u32 {
        if integrator == Integrator::Direct { direct::BOUNCES } else { self.max_bounces }
    }
}
