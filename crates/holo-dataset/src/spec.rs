//! What to render: everything that decides, with the scene, the files of one render.

use std::path::PathBuf;

use holo_core::{GridSize, Projection, Sensor};
use holo_io::MatOrder;
use holo_render::{GroundTruth, Integrator, Layer};

/// What to render and what to write. The defaults are those of the command line: the paper's 8K sensor, 100 x 100 views.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSpec {
    /// The cameras.
    pub rig: RigSpec,
    /// How light is modelled.
    pub integrator: Integrator,
    /// Rays through every pixel; `None`: 16, with the integrator `Depth` 1, with a target error 1024.
    pub samples: Option<u32>,
    /// Relative standard error at which a pixel needs no more samples.
    pub target_error: Option<f64>,
    /// Maximum number of bounces of a path.
    pub max_bounces: u32,
    /// Whether paths that carry little may end at random (unbiased).
    pub roulette: bool,
    /// Whether `Integrator::Auto` includes light between diffuse surfaces.
    pub indirect: bool,
    /// The light from everywhere.
    pub sky: Sky,
    /// Exposure compensation of 8- and 16-bit images.
    pub exposure: Exposure,
    /// The views of which layers are made.
    pub ground_truth: GroundTruth,
    /// Layers to write as float maps; empty: those that `outputs` names.
    pub layers: Vec<LayerChoice>,
    /// What to write; empty: `Vpi`, `El` and `Mat` where there is color, and disparity and depth unless `layers` names
    /// others.
    pub outputs: Vec<Output>,
    /// Axis order of the array in the MAT file.
    pub mat_order: MatOrder,
    /// Bits a channel of PNG and MAT files: 8 or 16.
    pub bit_depth: u8,
    /// Random seed.
    pub seed: u64,
}

/// The cameras of a render.
#[derive(Clone, Debug, PartialEq)]
pub struct RigSpec {
    /// The sensor that views and lenses share. Not used where `lenses` is given.
    pub sensor: Sensor,
    /// The f-number of the aperture that the views sample; `None`: 5. Not used where `baseline_m` is given.
    pub f_number: Option<f64>,
    /// Where the focus plane lies.
    pub focus: Focus,
    /// Views.
    pub views: GridSize,
    /// Lenses, which are the pixels of a view, instead of a sensor.
    pub lenses: Option<GridSize>,
    /// Distance between adjacent views, m.
    pub baseline_m: Option<f64>,
    /// Focal length, mm; `None`: from the scene camera's angle of view.
    pub focal_mm: Option<f64>,
    /// Length of the larger image side, mm.
    pub sensor_mm: f64,
    /// Projection of the views.
    pub projection: Projection,
    /// Name or number of the scene's camera; `None`: the first.
    pub camera: Option<String>,
}

/// Which backend traces rays, on how many threads. It decides no file but the backend's name in the manifest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EngineSpec {
    /// The ray tracing backend.
    pub backend: holo_render::Backend,
    /// Threads; 0: one per core.
    pub threads: usize,
}

/// The light from everywhere.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// The same linear RGB radiance from all directions.
    Constant([f32; 3]),
    /// An equirectangular map in a file, OpenEXR or Radiance HDR.
    Map(PathBuf),
}

/// Where the focus plane lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// At the harmonic mean of the nearest and farthest depth of the central view.
    Automatic,
    /// At a distance, m; may be infinite.
    Meters(f64),
}

/// Exposure compensation of 8- and 16-bit images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// From the image: 99 % of the pixels that are not black stay below 80 % of the range.
    Automatic,
    /// In EV.
    Ev(f64),
}

/// Part `part` (from 1) of `of` parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which part, from 1.
    pub part: usize,
    /// How many there are.
    pub of: usize,
}

/// A layer by name, or what stands for several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerChoice {
    /// Linear radiance, without exposure.
    Color,
    /// One layer.
    One(Layer),
    /// Color and all layers.
    All,
}

/// A kind of file, or a set of files, that a render writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Output {
    /// `scene_vpi.png`: all viewpoint images side by side.
    Vpi,
    /// `scene_el.png`: the raw image behind the lenses.
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
    /// `hci/`: a PNG a view with depth and disparity, in the layout of the HCI benchmark.
    Hci,
}

impl Default for RenderSpec {
    fn default() -> Self {
        Self {
            rig: RigSpec::default(),
            integrator: Integrator::Auto,
            samples: None,
            target_error: None,
            max_bounces: 8,
            roulette: true,
            indirect: true,
            sky: Sky::Constant([0.0; 3]),
            exposure: Exposure::Automatic,
            ground_truth: GroundTruth::Central,
            layers: Vec::new(),
            outputs: Vec::new(),
            mat_order: MatOrder::Lenses,
            bit_depth: 8,
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
            focal_mm: None,
            sensor_mm: 36.0,
            projection: Projection::Perspective,
            camera: None,
        }
    }
}

impl RigSpec {
    /// The f-number, or the paper's.
    #[must_use]
    pub fn f_number_or_default(&self) -> f64 {
        self.f_number.unwrap_or(5.0)
    }
}
