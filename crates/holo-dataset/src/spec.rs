//! Specifications: everything that determines the files of a render, together with the scene.

mod view_subset;

use std::path::PathBuf;

use holo_core::{GridSize, Projection, Sensor};
use holo_io::MatOrder;
use holo_render::{Denoise, GroundTruth, Integrator, Layer, Reuse, TextureFilter};
use holo_scene::gltf::LightUnits;

pub use self::view_subset::ViewSubset;

/// The specification of a render and its output. The defaults are those of the command line: 8K sensor, 100 x 100
/// views.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderSpec {
    /// How the scene file is read.
    pub scene: SceneSpec,
    /// Specification of the rig.
    pub rig: RigSpec,
    /// The integrator.
    pub integrator: Integrator,
    /// Samples a pixel; `None`: 16, with the integrator `Depth` 1, with a target error at most 1024.
    pub samples: Option<u32>,
    /// Target relative standard error of adaptive sampling; `None`: all pixels get all samples.
    pub target_error: Option<f64>,
    /// Maximum number of bounces of a path.
    pub max_bounces: u32,
    /// Whether paths of low throughput end by Russian roulette (unbiased).
    pub roulette: bool,
    /// Whether `Integrator::Auto` includes indirect light between diffuse surfaces.
    pub indirect: bool,
    /// The largest radiance that a path may add at a vertex after the first; infinite: no limit (unbiased).
    pub indirect_limit: f32,
    /// Whether shadow rays go straight through smooth glass (an approximation for bodies).
    pub transparent_shadows: bool,
    /// Whether light is scattered more than once between the microfacets of rough surfaces.
    pub multiple_scattering: bool,
    /// Whether neighboring views share the light that rays find on diffuse surfaces.
    pub reuse: Reuse,
    /// Whether textures are averaged over the part of a pixel that a sample stands for.
    pub texture_filter: TextureFilter,
    /// Whether the noise of color is reduced with the samples of neighboring views.
    pub denoise: Denoise,
    /// Whether the backs of surfaces that are not double-sided are invisible to the camera.
    pub cull: bool,
    /// Environment light.
    pub sky: Sky,
    /// Exposure compensation of 8- and 16-bit images.
    pub exposure: Exposure,
    /// The views of which ground truth layers are rendered.
    pub ground_truth: GroundTruth,
    /// Layers to write as float maps; empty: those of `outputs`.
    pub layers: Vec<LayerChoice>,
    /// Outputs; empty: `Vpi`, `El` and `Mat` if there is color, and disparity and depth if `layers` is empty.
    pub outputs: Vec<Output>,
    /// Axis order of the array in the MAT file.
    pub mat_order: MatOrder,
    /// Bits a channel of PNG and MAT files: 8 or 16.
    pub bit_depth: u8,
    /// The name of an image sensor, whose codes of the raw image are also written.
    pub sensor_model: Option<String>,
    /// Its film speed; `None`: that without gain.
    pub iso: Option<f64>,
    /// Random seed.
    pub seed: u64,
}

/// How a scene file is read. Scenes of the gallery have nothing of it but frames.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SceneSpec {
    /// The unit of the intensities of lights.
    pub light_units: LightUnits,
    /// Whether closed meshes with transmission but without a volume are bodies of glass.
    pub solid_glass: bool,
    /// The name of a material variant (`KHR_materials_variants`); `None`: the materials of the primitives.
    pub material_variant: Option<String>,
    /// The frames of the animations of the file; `None`: the pose of its nodes without animation.
    pub frames: Option<Frames>,
    /// Frames a second; `None`: 24. Frame N is at N / fps seconds.
    pub fps: Option<f64>,
    /// The name of the animation to play, or its index; `None`: all of them.
    pub animation: Option<String>,
}

/// A range of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// Number of the first frame.
    pub first: u32,
    /// Number of the last frame, not below the first.
    pub last: u32,
}

/// The specification of a rig.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigSpec {
    /// The sensor, which is divided into views and microlenses. Ignored if `lenses` is given.
    pub sensor: Sensor,
    /// The f-number of the aperture that the views sample; `None`: 5. Ignored if `baseline_m` is given.
    pub f_number: Option<f64>,
    /// Distance of the focus plane.
    pub focus: Focus,
    /// Number of views, T rows and S columns.
    pub views: GridSize,
    /// Number of microlenses, V rows and U columns, which are the pixels of a view; `None`: from the sensor.
    pub lenses: Option<GridSize>,
    /// The microlens array is exposed in N x N positions, 1/N of its pitch apart, and the elemental images are interleaved:
    /// N times as many microlenses along both axes, each as wide as without; `None`: one position.
    pub lens_shifts: Option<u32>,
    /// Distance between adjacent views, m; `None`: from the f-number.
    pub baseline_m: Option<f64>,
    /// Smallest and largest disparity of what the central view hits, pixels between adjacent views: `focus` and baseline
    /// follow, and `focus`, `f_number` and `baseline_m` are ignored.
    pub disparity_px: Option<(f64, f64)>,
    /// Focal length, mm; `None`: from the angle of view of the scene camera.
    pub focal_mm: Option<f64>,
    /// Sensor size along the larger image side, mm.
    pub sensor_mm: f64,
    /// Projection of the views.
    pub projection: Projection,
    /// Name or index of the scene camera; `None`: the first.
    pub camera: Option<String>,
    /// The views that are rendered; `None`: all.
    pub subset: Option<ViewSubset>,
}

/// The ray tracing backend and the number of threads. Of the files, only the name of the backend in the manifest
/// depends on them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EngineSpec {
    /// The ray tracing backend.
    pub backend: holo_render::Backend,
    /// Number of threads; 0: one per core.
    pub threads: usize,
}

/// Environment light.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// Black for a scene with light sources, else a soft sky:
    /// [`Environment::overcast`](holo_scene::Environment::overcast).
    Automatic,
    /// The same linear RGB radiance from all directions.
    Constant([f32; 3]),
    /// An equirectangular environment map: an OpenEXR or Radiance HDR file in linear light, or a PNG or JPEG of 8 or 16
    /// bits, whose codes are sRGB and become radiance from 0 to 1.
    Map(PathBuf),
}

/// The distance of the focus plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// The harmonic mean of the nearest and farthest depth of the central view.
    Automatic,
    /// A distance in meters, which may be infinite.
    Meters(f64),
}

/// Exposure compensation of 8- and 16-bit images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// From the image: 99 % of the pixels that are not black are below 80 % of the range.
    Automatic,
    /// A value in EV.
    Ev(f64),
}

/// A shard of an image or a dataset: part `part` (from 1) of `of` parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1.
    pub part: usize,
    /// Number of parts.
    pub of: usize,
}

/// A choice of layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerChoice {
    /// Linear radiance, without exposure.
    Color,
    /// The estimated relative error of color.
    Error,
    /// The part of all views that sees a point of the central view.
    Visibility,
    /// Where the image of a point moves until the next frame.
    OpticalFlow,
    /// How a point moves in the world until the next frame.
    SceneFlow,
    /// One layer.
    One(Layer),
    /// One layer of the raw image of a plenoptic camera.
    Raw(RawLayer),
    /// Color and all layers that describe the first hit.
    All,
}

/// A layer of the raw image of a plenoptic camera that follows from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawLayer {
    /// Row of the nearest micro-image, from the microlens at the origin of the array.
    LensRow,
    /// Its column.
    LensColumn,
    /// Its type, from 0.
    LensType,
    /// The white image: light of a scene of radiance 1.
    White,
    /// Distance of the image of the main lens behind the array, in gaps.
    VirtualDepth,
    /// Diameter of the blur, px.
    Blur,
    /// Mean of 1 / depth over what a pixel sees, 1/m.
    InverseDepthMean,
    /// Standard deviation of the same.
    InverseDepthDeviation,
    /// Share of the light that comes from surfaces.
    Coverage,
}

impl RawLayer {
    /// All layers.
    pub const ALL: [Self; 9] = [
        Self::LensRow,
        Self::LensColumn,
        Self::LensType,
        Self::White,
        Self::VirtualDepth,
        Self::Blur,
        Self::InverseDepthMean,
        Self::InverseDepthDeviation,
        Self::Coverage,
    ];

    /// Returns the name on the command line and in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LensRow => "lens-row",
            Self::LensColumn => "lens-column",
            Self::LensType => "lens-type",
            Self::White => "white",
            Self::VirtualDepth => "virtual-depth",
            Self::Blur => "blur",
            Self::InverseDepthMean => "inverse-depth-mean",
            Self::InverseDepthDeviation => "inverse-depth-deviation",
            Self::Coverage => "coverage",
        }
    }

    /// Whether it follows from the depth too.
    pub(crate) const fn needs_depth(self) -> bool {
        matches!(self, Self::VirtualDepth | Self::Blur)
    }

    /// Whether it follows from the samples of color.
    pub(crate) const fn needs_samples(self) -> bool {
        matches!(self, Self::InverseDepthMean | Self::InverseDepthDeviation | Self::Coverage)
    }
}

/// A file, or a set of files, that a render writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Output {
    /// `scene_vpi.png`: the sub-aperture image array.
    Vpi,
    /// `scene_el.png`: the raw image, an elemental image array.
    El,
    /// `scene_disparity.pfm` and `.png` of the central view.
    Disparity,
    /// `scene_depth.pfm` of the central view.
    Depth,
    /// `scene_central.exr`: color and all layers of the central view, linear. With `El` or `Vpi` also `scene_el.exr`,
    /// `scene_vpi.exr`.
    Exr,
    /// `scene_5d.mat`: the raw image's integers as a 5D array for MATLAB.
    Mat,
    /// `scene_5d.h5`: linear radiance and the layers of depth and disparity as 5D arrays.
    H5,
    /// `hci/`: an HCI folder, with one PNG a view, depth and disparity.
    Hci,
    /// The same, with ground truth of the central view in ten times the resolution.
    HciHighres,
    /// `raw.exr`: the raw image of a plenoptic camera, linear.
    Raw,
    /// `raw_linear.png`: the same with 16 bits.
    RawPng,
    /// `white.exr` and `white.png` of a plenoptic camera.
    White,
    /// `centers.csv`: the centers of the micro-images of a plenoptic camera.
    Centers,
}

impl Output {
    /// Those of the raw image of a plenoptic camera: all of them without a request.
    pub(crate) const RAW: [Self; 4] = [Self::Raw, Self::RawPng, Self::White, Self::Centers];
}

impl Default for RenderSpec {
    fn default() -> Self {
        Self {
            scene: SceneSpec::default(),
            rig: RigSpec::default(),
            integrator: Integrator::Auto,
            samples: None,
            target_error: None,
            max_bounces: 8,
            roulette: true,
            indirect: true,
            indirect_limit: f32::INFINITY,
            transparent_shadows: false,
            multiple_scattering: true,
            reuse: Reuse::Views,
            texture_filter: TextureFilter::Footprint,
            denoise: Denoise::Off,
            cull: false,
            sky: Sky::Automatic,
            exposure: Exposure::Automatic,
            ground_truth: GroundTruth::Central,
            layers: Vec::new(),
            outputs: Vec::new(),
            mat_order: MatOrder::Lenses,
            bit_depth: 8,
            sensor_model: None,
            iso: None,
            seed: 0,
        }
    }
}

impl Default for RigSpec {
    fn default() -> Self {
        Self {
            sensor: Sensor::Paper8k,
            f_number: None,
            focus: Focus::Automatic,
            views: GridSize::new(100, 100),
            lenses: None,
            baseline_m: None,
            disparity_px: None,
            focal_mm: None,
            sensor_mm: 36.0,
            projection: Projection::Perspective,
            camera: None,
            lens_shifts: None,
            subset: None,
        }
    }
}

impl SceneSpec {
    /// Returns the time of a frame, s.
    #[must_use]
    pub fn seconds_of(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps.unwrap_or(24.0)
    }
}

impl Frames {
    /// One frame.
    #[must_use]
    pub const fn one(frame: u32) -> Self {
        Self { first: frame, last: frame }
    }

    /// Returns the number of the frame, if it is only one.
    #[must_use]
    pub fn single(self) -> Option<u32> {
        (self.first == self.last).then_some(self.first)
    }
}

impl RigSpec {
    /// Returns the f-number, or 5, that of the paper.
    #[must_use]
    pub fn f_number_or_default(&self) -> f64 {
        self.f_number.unwrap_or(5.0)
    }
}
