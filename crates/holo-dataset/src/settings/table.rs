//! The table of settings: every one with its type, default, form and help, in groups.
//!
//! A setting is declared here and nowhere else. The command line, configuration files, manifests, the keywords of
//! Python and the reference page of the guide follow from this table.

use holo_core::{GridSize, Projection, Sensor};
use holo_io::{ManifestValue, MatOrder};
use holo_render::{Denoise, GroundTruth, Integrator, Reuse, SamplesPerPixel, TextureFilter};
use holo_scene::gltf::LightUnits;

use super::declare::settings;
use super::types::{
    Color, Exposure, Focus, Frames, LayerChoice, Output, Pixels, Point, SensorName, Sky, Spacing, Tool, ViewSubset,
    angle_deg, bit_depth, bounces, lens_shifts,
};
use super::value::{Kind, Malformed, SettingType, not_negative, positive, share};
use super::{RenderSettings, Setting};

settings! {
    /// How a scene file is read.
    pub struct SceneSettings of scene, scene_mut {
        /// Unit of the lights in the file: candela and lux of glTF, those of Blender's lighting mode "Standard" (683 times
        /// as bright), or `auto`, by generator and numbers.
        light_units: LightUnits = LightUnits::Gltf, "light-units" "";
        /// Treat closed meshes with transmission but without a volume as solid glass; otherwise they are thin, like soap
        /// bubbles.
        solid_glass: bool = false, "solid-glass" "";
        /// Name of a material variant of the file, as `holo info` lists them.
        material_variant: Option<String>, "material-variant" "NAME";
        /// Name or number of the scene's camera [default: the first].
        camera: Option<String>, "camera" "NAME|INDEX";
        /// Place of the camera in the world of the file, m [default: that of the scene's camera].
        eye: Option<Point>, "eye" "X,Y,Z";
        /// Point that the camera looks at, m [default: with `eye` the middle of the scene].
        target: Option<Point>, "target" "X,Y,Z";
        /// Direction that is up in the image [default: 0,1,0].
        up: Option<Point>, "up" "X,Y,Z";
        /// Horizontal angle of view, degrees [default: that of the scene's camera].
        fov_deg: Option<f64>, "fov-deg" "A" by angle_deg;
        /// Name of an object that fills the view: the camera keeps its direction, or looks from `eye`, and moves along its line of
        /// sight.
        fit_object: Option<String>, "fit-object" "NAME";
        /// Add a gray ground below the lowest point, which catches shadows.
        ground: bool = false, "ground" "";
        /// Frame of the file's animations, or frames A-B, each in a folder of its own with the focus and exposure of the
        /// first [default: the scene at rest]. Frame N is at N / fps seconds.
        frames: Option<Frames>, "frame" "N|A-B";
        /// Frames per second [default: 24].
        fps: Option<f64>, "fps" "F" by positive;
        /// Name or index of the animation to play [default: all of the file].
        animation: Option<String>, "animation" "NAME";
    }
}

settings! {
    /// A rig: a grid of parallel pinhole cameras.
    pub struct RigSettings of rig, rig_mut {
        /// Views, columns x rows, or one number for both.
        views: GridSize = GridSize::new(100, 100), "views" "SxT|N";
        /// What determines the pixels of a view.
        one_of pixels: Pixels = Pixels::Sensor(Sensor::Paper8k) => {
            /// Sensor resolution in pixels: hd, 4k, 8k (7952x5304), uhd8k (7680x4320) or WIDTHxHEIGHT, less the rest when divided by the views.
            sensor: Sensor(Sensor), "sensor" "NAME|WxH";
            /// Lenses, columns x rows: the microlenses, which are the pixels of one view. Replaces `sensor`.
            lenses: Lenses(GridSize), "lenses" "UxV";
        }
        /// Lens array shifting: N x N exposures, the microlens array moved by 1/N of its pitch, interleaved to N times as many
        /// lenses along both axes.
        lens_shifts: Option<u32>, "lens-shifts" "N" by lens_shifts;
        /// What determines the distance between adjacent views.
        one_of spacing: Spacing = Spacing::FNumber(5.0) => {
            /// f-number of the main lens, whose aperture the views sample.
            f_number: FNumber(f64), "f-number" "N" by positive;
            /// Baseline: distance between adjacent views, m.
            baseline_m: BaselineM(f64), "baseline-m" "B" by not_negative;
            /// Smallest and largest disparity of the scene, px between adjacent views: focus distance and baseline follow.
            disparities_px: DisparitiesPx((f64, f64)), "disparity" "MIN,MAX";
        }
        /// Focus distance, m, `inf`, or `auto` (harmonic mean of nearest and farthest depth). Disparity is 0 there.
        focus: Focus = Focus::Automatic, "focus-m" "Z|inf|auto";
        /// Focal length, mm [default: from the angle of view of the scene's camera].
        focal_mm: Option<f64>, "focal-mm" "F" by positive;
        /// Sensor size: length of the larger image side, mm.
        sensor_mm: f64 = 36.0, "sensor-mm" "S" by positive;
        /// Projection of the views.
        projection: Projection = Projection::Perspective, "projection" "";
        /// Render only some of the views: the row and column of the central one (cross), with both diagonals (star), or a list of
        /// COLUMN,ROW. Writes them as hci/input_CamNNN.png, numbered as in the whole grid.
        subset: Option<ViewSubset>, "subset" "cross|star|C,R;C,R..";
    }
}

settings! {
    setters of RenderSettings in light;

    /// The light that is simulated, its samples, and what is left of their noise.
    pub struct LightSettings of light, light_mut {
        /// Light transport.
        integrator: Integrator = Integrator::Auto, "integrator" "";
        /// Samples per pixel [default: 16, with the integrator depth 1]. With `denoise views` also 1/2, 1/4 .. 1/64: so many of
        /// the pixels have a sample, and all share them.
        samples: Option<SamplesPerPixel>, "spp" "N|1/N";
        /// Adaptive sampling: stop at this relative standard error of a pixel, such as 0.02 or 2%. `spp` is then the maximum
        /// [default: 1024; with `denoise views` 16, and the error is that after samples are shared].
        target_error: Option<f64>, "target-error" "E" by share;
        /// Maximum number of bounces of a light path.
        max_bounces: u32 = 8, "max-bounces" "N" by bounces;
        /// Disable Russian roulette: follow every path to its last bounce.
        off roulette, "no-roulette";
        /// Omit light that diffuse surfaces reflect to each other (with `integrator auto`).
        off indirect, "no-indirect";
        /// Limit what a light path may add after its first hit: fewer bright specks, darker caustics [default: no limit].
        indirect_limit: Option<f64>, "indirect-limit" "L" by positive;
        /// Let shadow rays pass straight through smooth glass: no noise behind windows, but no caustics of solid glass.
        transparent_shadows: bool = false, "transparent-shadows" "";
        /// Omit light that is scattered more than once in the roughness of a surface: rough metal gets darker.
        off multiple_scattering, "no-multiple-scattering";
        /// Share the light that rays find on diffuse surfaces between groups of 16 neighboring views. Their noise is lower, but the
        /// same: do not score or train stereo with it.
        reuse: Reuse = Reuse::Off, "reuse" "";
        /// Average fine textures over the part of a pixel that a sample stands for: a small bias that more samples remove. No
        /// effect with `denoise views`.
        texture_filter: TextureFilter = TextureFilter::Footprint, "texture-filter" "";
        /// Let the main lens of glass of a plenoptic camera refract red, green and blue light differently, at three times the cost.
        spectral: bool = false, "spectral" "";
        /// Reduce the noise of color by the samples of pixels that see the same point: a small bias that more samples remove. The
        /// noise that is left moves with the true disparity: do not score or train stereo with it.
        denoise: Denoise = Denoise::Off, "denoise" "";
        /// Hide the backs of surfaces that are not double-sided, as game engines do.
        cull: bool = false, "cull" "";
        /// Environment light: linear radiance of a constant sky (one number is gray), an equirectangular map (.hdr, .exr;
        /// .png, .jpg as sRGB), or `auto`: black, and a soft sky for scenes without light.
        sky: Sky = Sky::Automatic, "sky" "auto|R,G,B|FILE";
        /// Color behind the scene instead of the environment, linear RGB. It lights nothing.
        backdrop: Option<Color>, "backdrop" "R,G,B";
        /// Random seed.
        seed: u64 = 0, "seed" "N";
    }
}

settings! {
    setters of RenderSettings in output;

    /// The files, and how they are encoded.
    pub struct OutputSettings of output, output_mut {
        /// Files to write, separated by commas [default: vpi,el,mat, and disparity,depth unless `layers` names others;
        /// without color no vpi, el and mat. Of a plenoptic camera raw,raw-png,white,centers].
        write: Vec<Output> = Vec::new(), "write" "WHAT,..";
        /// Layers (AOVs) to write as float maps (PFM), separated by commas [default: those of `write`].
        ///
        /// Most describe the first surface, glass included, that the ray through the center of a pixel hits.
        /// scene_LAYER.pfm is of the central view (raw_LAYER.pfm of a plenoptic camera); with `ground-truth all` the folder
        /// LAYER has one of every view.
        layers: Vec<LayerChoice> = Vec::new(), "layers" "NAME,..";
        /// Views for which ground truth is written.
        ground_truth: GroundTruth = GroundTruth::Central, "ground-truth" "";
        /// Exposure compensation of 8- and 16-bit images in EV, or `auto`.
        exposure: Exposure = Exposure::Automatic, "exposure" "auto|EV";
        /// Bits per channel of the raw PNGs and of scene_5d.mat.
        bit_depth: u8 = 8, "bit-depth" "8|16" by bit_depth;
        /// Order of the array in scene_5d.mat: H(v,u,t,s,c), or LF(t,s,v,u,c) as in the Light Field Toolbox.
        mat_order: MatOrder = MatOrder::Lenses, "mat-order" "ORDER";
        /// Also write the codes that this image sensor makes of the raw image: scene_raw.png, .dng, .json.
        sensor_model: Option<SensorName>, "sensor-model" "NAME";
        /// Film speed of that sensor [default: its base speed].
        iso: Option<f64>, "iso" "ISO" by positive;
        /// Programs that the raw image of a plenoptic camera is also written for, separated by commas: a folder each, with
        /// a README.txt.
        tools: Vec<Tool> = Vec::new(), "for" "TOOL,..";
    }
}

// Why a group is not there is an error of the setting that is in it.

fn scene(settings: &RenderSettings) -> Option<&SceneSettings> {
    Some(&settings.scene)
}

fn scene_mut(settings: &mut RenderSettings) -> Result<&mut SceneSettings, Malformed> {
    Ok(&mut settings.scene)
}

fn rig(settings: &RenderSettings) -> Option<&RigSettings> {
    settings.camera.rig()
}

fn rig_mut(settings: &mut RenderSettings) -> Result<&mut RigSettings, Malformed> {
    settings.camera.rig_mut()
}

fn light(settings: &RenderSettings) -> Option<&LightSettings> {
    Some(&settings.light)
}

fn light_mut(settings: &mut RenderSettings) -> Result<&mut LightSettings, Malformed> {
    Ok(&mut settings.light)
}

fn output(settings: &RenderSettings) -> Option<&OutputSettings> {
    Some(&settings.output)
}

fn output_mut(settings: &mut RenderSettings) -> Result<&mut OutputSettings, Malformed> {
    Ok(&mut settings.output)
}

/// All settings, in the order in which help lists them.
pub(super) const TABLE: [&[Setting]; 4] =
    [SceneSettings::TABLE, RigSettings::TABLE, LightSettings::TABLE, OutputSettings::TABLE];
