//! What a render writes, decided once from its settings: outputs, layers, and whether color is needed.

use holo_render::{Denoise, GroundTruth, Integrator, Layer, LayerSet, Rendered};

use super::layers::{COLOR, ERROR, FLOWS, VISIBILITY};
use super::{masks, subset};
use crate::Error;
use crate::settings::{Camera, Focus, LayerChoice, Output, RawLayer, RenderSettings, RigSettings, Spacing};

/// Outputs that need color.
const NEED_COLOR: [Output; 8] =
    [Output::Vpi, Output::El, Output::Mat, Output::H5, Output::Hci, Output::HciHighres, Output::Raw, Output::RawPng];

/// Those of them that contain layers beside color, and nothing else where ground truth alone is rendered.
const HAVE_LAYERS: [Output; 3] = [Output::H5, Output::Hci, Output::HciHighres];

/// What a render writes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    /// The integrator to render with: that for ground truth if nothing needs color.
    pub integrator: Integrator,
    /// The outputs that were requested; `None`: the default ones.
    requested: Option<Vec<Output>>,
    /// The default outputs of an image with color.
    default: &'static [Output],
    /// Layers to write as float maps.
    pub written: LayerSet,
    /// Whether the mask of what is hit is written beside depth or disparity.
    pub hit_mask: bool,
    /// Layers to render of the central view, or of the pixels of a raw image.
    pub central: LayerSet,
    /// Layers to render of all views.
    pub all: LayerSet,
    /// Layers of a raw image that follow from its camera.
    pub raw: Vec<RawLayer>,
    /// Whether color is written as a float map too, where there is color.
    pub color: bool,
    /// Whether color is named as a layer, so that there must be color.
    requires_color: bool,
    /// Whether the estimated error of color is written.
    pub error: bool,
    /// Whether the visibility of the central view is written.
    pub visibility: bool,
    /// Whether masks of the central view are written, which its visibility is a part of.
    pub masks: bool,
    /// Whether the movement of images until the next frame is written, and that of points in the world.
    pub flow: [bool; 2],
}

impl Wanted {
    /// Decides what a render writes.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the settings contradict each other, or if the camera does not have what they request.
    pub fn new(settings: &RenderSettings) -> Result<Self, Error> {
        check(settings)?;
        let output = &settings.output;
        let named = |layer: LayerChoice| output.layers.contains(&layer);
        let is_raw = settings.camera.plenoptic().is_some();
        let color = named(LayerChoice::Color) || named(LayerChoice::All);
        let error = named(LayerChoice::Error);
        let mut written = output.layers.iter().fold(LayerSet::EMPTY, |set, layer| match layer {
            LayerChoice::One(layer) => set.union([*layer].into()),
            LayerChoice::All => LayerSet::ALL,
            _ => set,
        });
        if !is_raw && output.layers.is_empty() && output.write.is_empty() {
            written = [Layer::Depth, Layer::Disparity].into();
        }
        for (file, layer) in [(Output::Depth, Layer::Depth), (Output::Disparity, Layer::Disparity)] {
            if output.write.contains(&file) {
                written = written.union([layer].into());
            }
        }
        let mut raw: Vec<RawLayer> = RawLayer::ALL.to_vec();
        raw.retain(|layer| is_raw && (named(LayerChoice::All) || named(LayerChoice::Raw(*layer))));
        let masks = output.write.contains(&Output::Masks);
        let held = held(written, &output.write);
        let has_truth = [Layer::Depth, Layer::Disparity].iter().any(|layer| held.contains(*layer));
        let mask = if has_truth { [Layer::HitMask].into() } else { LayerSet::EMPTY };
        let central = match settings.camera {
            Camera::Rig(_) if output.write.contains(&Output::Exr) => LayerSet::ALL,
            // The manifest of every light field contains the disparity range.
            Camera::Rig(_) => held.union([Layer::Disparity].into()),
            Camera::Plenoptic(_) if raw.iter().any(|layer| layer.needs_depth()) => held.union([Layer::Depth].into()),
            // One view has no disparity.
            Camera::Pinhole => held.without([Layer::Disparity].into()),
            Camera::Plenoptic(_) => held,
        };
        let needs_color = color
            || error
            || output.write.is_empty()
            || output.write.contains(&Output::Exr)
            || needing_color(&output.write, settings.light.integrator).next().is_some()
            || !output.tools.is_empty()
            || output.sensor_model.is_some()
            || raw.iter().any(|layer| layer.needs_samples());
        let integrator = match settings.light.integrator {
            // No light needs to be traced.
            Integrator::Auto if !needs_color => Integrator::Depth,
            chosen => chosen,
        };
        Ok(Self {
            integrator,
            requested: (!output.write.is_empty()).then(|| output.write.clone()),
            default: if is_raw { &Output::RAW } else { &[Output::Vpi, Output::El, Output::Mat] },
            written,
            hit_mask: has_truth,
            central: central.union(mask).union(if masks { masks::LAYERS } else { LayerSet::EMPTY }),
            all: if output.ground_truth == GroundTruth::All { held } else { LayerSet::EMPTY },
            raw,
            color,
            requires_color: named(LayerChoice::Color),
            error,
            visibility: named(LayerChoice::Visibility),
            masks,
            flow: [LayerChoice::OpticalFlow, LayerChoice::SceneFlow].map(named),
        })
    }

    /// Returns the outputs to write: the requested ones, or without a request the default ones, those of color if there is
    /// color.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if one that was requested needs color, and there is none.
    pub fn outputs(&self, has_color: bool) -> Result<Vec<Output>, Error> {
        let dark = |what: &str, setting: &str| {
            Err(Error::BadRequest(format!(
                "the scene has no light sources, so there is no color to write; remove {what} from `{setting}`, or light \
                 it with `sky auto`"
            )))
        };
        let layers = [(self.requires_color, COLOR), (self.error, ERROR)];
        if let Some((_, name)) = layers.into_iter().find(|(wanted, _)| *wanted && !has_color) {
            return dark(name, "layers");
        }
        match &self.requested {
            None => {
                Ok(self.default.iter().copied().filter(|output| has_color || !NEED_COLOR.contains(output)).collect())
            }
            Some(outputs) => match joined(needing_color(outputs, self.integrator)) {
                Some(names) if !has_color => dark(&names, "write"),
                _ => Ok(outputs.clone()),
            },
        }
    }

    /// Returns the names of the written layers, for the manifest.
    pub fn names(&self, rendered: &Rendered) -> Vec<&'static str> {
        let color = (self.color && rendered.color.is_some()).then_some(COLOR);
        let error = rendered.error.is_some().then_some(ERROR);
        let visibility = self.visibility.then_some(VISIBILITY);
        let flow = FLOWS.into_iter().zip(self.flow).filter(|(_, wanted)| *wanted);
        let layers = color.into_iter().chain(self.written.iter().map(Layer::name)).chain(visibility).chain(error);
        layers.chain(flow.map(|(name, _)| name)).chain(self.raw.iter().map(|layer| layer.name())).collect()
    }
}

/// The layers that files of these outputs need beside those that are written.
fn held(written: LayerSet, outputs: &[Output]) -> LayerSet {
    let mut held = written;
    if outputs.contains(&Output::H5) {
        held = held.union([Layer::Depth, Layer::RayLength, Layer::Disparity].into());
    }
    if outputs.iter().any(|output| matches!(output, Output::Hci | Output::HciHighres)) {
        held = held.union([Layer::Depth, Layer::Disparity].into());
    }
    held
}

/// Those outputs that need color. With the integrator for ground truth, files of color and layers have the layers alone.
fn needing_color(outputs: &[Output], integrator: Integrator) -> impl Iterator<Item = Output> {
    let needs = move |output: &Output| integrator != Integrator::Depth || !HAVE_LAYERS.contains(output);
    NEED_COLOR.into_iter().filter(|output| outputs.contains(output)).filter(needs)
}

/// The names of outputs, such as "vpi and el"; `None` if there are none.
fn joined(outputs: impl Iterator<Item = Output>) -> Option<String> {
    let names: Vec<&str> = outputs.map(Output::name).collect();
    let (last, others) = names.split_last()?;
    Some(if others.is_empty() { (*last).to_owned() } else { format!("{} and {last}", others.join(", ")) })
}

/// The error of a build without HDF5.
#[cfg(not(feature = "hdf5"))]
pub(crate) fn without_hdf5() -> Error {
    Error::BadRequest(
        "this build of holo has no HDF5; build it with `cargo xtask build`, or with cargo build --features hdf5".into(),
    )
}

/// Checks whether settings are possible for any scene, before anything is loaded or written.
fn check(settings: &RenderSettings) -> Result<(), Error> {
    #[cfg(not(feature = "hdf5"))]
    if settings.output.write.contains(&Output::H5) {
        return Err(without_hdf5());
    }
    match &settings.camera {
        Camera::Rig(rig) => {
            let is_focused = rig.focus != Focus::Automatic;
            if matches!(rig.spacing, Spacing::DisparitiesPx(_)) && is_focused {
                return bad("`disparity` and `focus-m` exclude each other; give one of them".into());
            }
            if rig.focal_mm.is_some() && settings.scene.fov_deg.is_some() {
                return bad("`focal-mm` and `fov-deg` both say the angle of view; give one of them".into());
            }
            if rig.lens_shifts == Some(0) {
                return bad("`lens-shifts` is a number of positions; give 1 or more".into());
            }
            check_views(settings)?;
            subset::check(settings, rig)?;
        }
        Camera::Plenoptic(camera) => {
            check_raw(settings)?;
            settings.output.tools.iter().try_for_each(|tool| tool.check(&camera.camera))?;
        }
        Camera::Pinhole => check_pinhole(settings)?,
    }
    check_poses(settings)?;
    check_time(settings)?;
    check_color(settings)
}

/// What poses of a list say themselves.
fn check_poses(settings: &RenderSettings) -> Result<(), Error> {
    if settings.poses.cameras().is_none() {
        return Ok(());
    }
    let rig = settings.camera.rig();
    let default = RigSettings::default();
    let of_scene = [
        ("camera", settings.scene.camera.is_some()),
        ("eye", settings.scene.eye.is_some()),
        ("target", settings.scene.target.is_some()),
        ("up", settings.scene.up.is_some()),
        ("fov-deg", settings.scene.fov_deg.is_some()),
        ("fit-object", settings.scene.fit_object.is_some()),
        ("focal-mm", rig.is_some_and(|rig| rig.focal_mm.is_some())),
        ("sensor-mm", rig.is_some_and(|rig| rig.sensor_mm != default.sensor_mm)),
    ];
    match of_scene.into_iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => {
            bad(format!("`{key}` is of the camera of the scene, and `transforms` has others; remove one"))
        }
        None => Ok(()),
    }
}

fn bad(what: String) -> Result<(), Error> {
    Err(Error::BadRequest(what))
}

/// What only plenoptic cameras have.
fn check_views(settings: &RenderSettings) -> Result<(), Error> {
    let output = &settings.output;
    if let Some(name) = output.write.iter().find(|output| output.is_raw()).map(|output| output.name()) {
        return bad(format!("`write {name}` is of a plenoptic camera; give one with `camera-file`"));
    }
    if let Some(LayerChoice::Raw(layer)) = output.layers.iter().find(|layer| matches!(layer, LayerChoice::Raw(_))) {
        return bad(format!("`layers {}` is of a plenoptic camera; give one with `camera-file`", layer.name()));
    }
    match output.tools.first() {
        Some(tool) => bad(format!("`for {}` is of a plenoptic camera; give one with `camera-file`", tool.name())),
        None => Ok(()),
    }
}

/// What only views have.
fn check_raw(settings: &RenderSettings) -> Result<(), Error> {
    let output = &settings.output;
    if settings.scene.fov_deg.is_some() {
        return bad("`fov-deg` is of views; a plenoptic camera has the angle of its main lens and sensor".into());
    }
    if let Some(name) = output.write.iter().find(|output| !output.is_raw()).map(|output| output.name()) {
        return bad(format!(
            "`write {name}` is of rendered views; a plenoptic camera writes raw, raw-png, white and centers, and `holo \
             decode` makes views of them"
        ));
    }
    if output.ground_truth == GroundTruth::All {
        return bad(
            "`ground-truth all` is of rendered views; the layers of a raw image are those of its pixels, and `holo decode` \
             adds those of the central view"
                .into(),
        );
    }
    let of_views = [LayerChoice::Visibility, LayerChoice::OpticalFlow, LayerChoice::SceneFlow];
    match of_views.into_iter().find(|layer| output.layers.contains(layer)) {
        Some(layer) => bad(format!("`layers {}` is of rendered views; remove it", layer.name())),
        None => Ok(()),
    }
}

/// What only light fields have.
fn check_pinhole(settings: &RenderSettings) -> Result<(), Error> {
    let output = &settings.output;
    let advice = "give `views` for a light field at every pose, or remove it";
    if let Some(file) = output.write.first() {
        let name = file.name();
        return bad(format!(
            "`write {name}` is of a grid of views; cameras of one view write images/NAME.png and the maps of `layers`; \
             {advice}"
        ));
    }
    if output.sensor_model.is_some() {
        return bad(format!("`sensor-model` exposes a raw image; {advice}"));
    }
    if settings.light.denoise != Denoise::Off {
        return bad(format!("`denoise views` needs a grid of views; {advice}"));
    }
    if output.ground_truth == GroundTruth::All {
        return bad(format!("`ground-truth all` is of a grid of views; every camera has its layers; {advice}"));
    }
    let of_views = [
        LayerChoice::Error,
        LayerChoice::Visibility,
        LayerChoice::OpticalFlow,
        LayerChoice::SceneFlow,
        LayerChoice::One(Layer::Disparity),
    ];
    if let Some(layer) = of_views.into_iter().find(|layer| output.layers.contains(layer)) {
        return bad(format!("`layers {}` is of a grid of views; {advice}", layer.name()));
    }
    check_views(settings)
}

fn check_time(settings: &RenderSettings) -> Result<(), Error> {
    let has_frames = settings.scene.frames.is_some_and(|frames| frames.single().is_none());
    if has_frames && settings.scene.fit_object.is_some() {
        return bad("`fit-object` would move the camera from frame to frame; give `eye` and `target`".into());
    }
    let (scene, layers) = (&settings.scene, &settings.output.layers);
    if scene.frames.is_some() {
        return Ok(());
    }
    let flow = [LayerChoice::OpticalFlow, LayerChoice::SceneFlow].into_iter().find(|flow| layers.contains(flow));
    if let Some(flow) = flow {
        return bad(format!("`layers {}` is the motion from one frame to the next; give `frame`", flow.name()));
    }
    if let Some(animation) = &scene.animation {
        return bad(format!("`animation {animation}` is played at a time; give `frame` too"));
    }
    match scene.fps {
        Some(fps) => bad(format!("`fps {fps}` is of an animation; give `frame` too")),
        None => Ok(()),
    }
}

fn check_color(settings: &RenderSettings) -> Result<(), Error> {
    let (output, integrator) = (&settings.output, settings.light.integrator);
    if let (Some(iso), None) = (output.iso, output.sensor_model) {
        return bad(format!("`iso {iso}` is of a sensor; give `sensor-model` too"));
    }
    if integrator != Integrator::Depth {
        return Ok(());
    }
    let dark =
        |what: &str| bad(format!("`integrator depth` renders no color; remove {what}, or choose `integrator direct`"));
    if let Some(names) = joined(needing_color(&output.write, integrator)) {
        return dark(&format!("{names} from `write`"));
    }
    let layers = [LayerChoice::Color, LayerChoice::Error];
    if let Some(layer) = layers.into_iter().find(|layer| output.layers.contains(layer)) {
        return dark(&format!("{} from `layers`", layer.name()));
    }
    match (output.tools.first(), output.sensor_model) {
        (Some(tool), _) => dark(&format!("`for {}`", tool.name())),
        (None, Some(_)) => dark("`sensor-model`"),
        (None, None) => Ok(()),
    }
}
