//! From the raw image of a plenoptic camera to a folder of views.

use std::path::{Path, PathBuf};

use holo_core::Rig;
use holo_core::plenoptic::Decoded;
use holo_io::{CameraFile, Manifest, ManifestValue, ParametersCfg, Sha256, dataset, hash_file};
use holo_render::{Integrator, Layer, LayerSet, Layers, RayCounts, Rendered};
use holo_scene::Transform;
use ndarray::{Array2, Array3, Axis};

use super::linear_image::{read_raw, read_white};
use crate::Error;
use crate::output::raw::{lit_white_image, write_white};
use crate::output::{Exposed, OutputFolder, Rollback, Traced, TracedCamera, TracedViews, Wanted, exposure_ev, write};
use crate::resume::identity::check_replaceable;
use crate::settings::{EngineSettings, Output, RenderSettings};
use crate::shot::{SceneSource, Stage, half_view, pose_of_scene};
use crate::watch::{About, Diagnostics};

/// A white image whose micro-images lie farther from those of the camera is a warning, px.
const MOST_GRID_ERROR_PX: f64 = 0.1;

/// White images with fewer micro-images are not compared with the camera.
const FEWEST_LENSES: usize = 900;

/// A raw image, a white image and their camera.
#[derive(Clone, Debug)]
pub struct DecodeJob {
    /// The raw image: OpenEXR, PNG in linear light, whose views have its scale: 1 is the brightest code, or a file of a Lytro
    /// camera, where 1 is saturation.
    pub raw: PathBuf,
    /// The white image; `None`: that of the camera without dirt and noise.
    pub white: Option<PathBuf>,
    /// The camera.
    pub camera: CameraFile,
    /// Of a focused camera: the depth of the pixels of the raw image, m; `None`: an estimate.
    pub depth: Option<PathBuf>,
    /// Views an axis; `None`: as many as are fully lit, of a focused camera five.
    pub views: Option<usize>,
    /// The scene, for ground truth of the central view.
    pub scene: Option<SceneSource>,
    /// What to write, the bit depth, the exposure, and which camera of the scene.
    pub settings: RenderSettings,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSettings,
}

impl DecodeJob {
    /// Creates a job of the default outputs, with 16 bits.
    #[must_use]
    pub fn new(raw: PathBuf, camera: CameraFile) -> Self {
        let mut settings = RenderSettings::default();
        settings.output.bit_depth = 16;
        Self {
            raw,
            white: None,
            camera,
            depth: None,
            views: None,
            scene: None,
            settings,
            engine: EngineSettings::default(),
        }
    }

    /// Checks that the folder `out` holds no other image: it has no manifest, or one of the same images, camera and scene.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if there is another image; [`Error::Io`] if a file cannot be read, or the manifest of the
    /// folder is damaged.
    pub fn check_replaceable(&self, out: &Path) -> Result<(), Error> {
        check_replaceable((out, ""), || self.identity(), |_| None)
    }

    /// What identifies the job in a manifest.
    fn identity(&self) -> Result<Manifest, Error> {
        let mut manifest = Manifest::default();
        manifest.versions.insert("holo".into(), env!("CARGO_PKG_VERSION").into());
        let mut set = |key: &str, value: ManifestValue| drop(manifest.settings.insert(key.into(), value));
        set("decoded", "views of a plenoptic camera: raw image / white image".into());
        set("camera-file", self.camera.name.clone().into());
        set("camera_sha256", Sha256::of(self.camera.to_toml().as_bytes()).to_string().into());
        set("raw_sha256", hash_file(&self.raw)?.sha256.to_string().into());
        if let Some(white) = &self.white {
            set("white_sha256", hash_file(white)?.sha256.to_string().into());
        }
        if let Some(depth) = &self.depth {
            set("depth_sha256", hash_file(depth)?.sha256.to_string().into());
        }
        if let Some(views) = self.views {
            set("decoded-views", views.into());
        }
        if let Some(scene) = &self.scene {
            set("scene_sha256", scene.sha256()?.to_string().into());
        }
        Ok(manifest)
    }

    /// Whether an input lies in a folder whose files will be replaced.
    fn check_inputs(&self, out: &Path) -> Result<(), Error> {
        let replaced = out.join(dataset::MANIFEST_JSON).is_file().then(|| std::fs::canonicalize(out).ok()).flatten();
        for path in std::iter::once(&self.raw).chain(&self.white).chain(&self.depth) {
            let folder = std::fs::canonicalize(path).ok().and_then(|path| path.parent().map(Path::to_path_buf));
            if folder.is_some() && folder == replaced {
                let (path, out) = (path.display(), out.display());
                return Err(Error::BadRequest(format!(
                    "{path} lies in {out}, whose files are replaced; choose another `out`"
                )));
            }
        }
        Ok(())
    }

    /// Decodes into the folder `out`, which then holds a light field as a render writes it. Returns its rig and the names
    /// of its files.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if an image lies in a folder whose files would be replaced; [`Error::Io`] if an image cannot be
    /// read or a file cannot be written; [`Error::Core`] if they do not fit the camera, or it has no views; those of a
    /// render for the ground truth.
    pub fn run(
        &self,
        out: &Path,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<(Rig, Vec<String>), Error> {
        self.check_inputs(out)?;
        let camera = &self.camera.camera;
        let count = self.views.map_or_else(|| camera.decodable_views(), Ok)?;
        let white = match &self.white {
            Some(path) => read_white(path)?,
            None => lit_white_image(&self.camera)?,
        };
        if let Some(path) = &self.white {
            self.check_grid(path, &white, diagnostics)?;
        }
        let raw = read_raw(&self.raw, camera, &white)?;
        let (size, found) = (camera.sensor().size, [raw.dim().0, raw.dim().1]);
        if found != [size.rows, size.columns] {
            let expected = vec![size.rows, size.columns];
            return Err(holo_core::Error::Shape { what: "raw image", expected, found: found.to_vec() }.into());
        }
        let decoded = match &self.depth {
            None => camera.decode(raw.view(), white.view(), count)?,
            Some(depth) => {
                let depth_m = holo_io::read_pfm_gray(depth, &holo_io::Limits::default())?;
                camera.decode_along(raw.view(), white.view(), count, depth_m.view())?
            }
        };
        drop(raw);
        let mut folder = OutputFolder::create(out, rollback, diagnostics)?;
        let central = self.truth(&decoded, diagnostics)?;
        let mut settings = self.settings.clone();
        if central.iter().next().is_none() && settings.output.write.is_empty() {
            // Without ground truth.
            settings.output.write = vec![Output::Vpi, Output::El, Output::Mat];
        }
        let rig = decoded.rig;
        let manifest = Manifest { rig: Some(rig), ..self.identity()? };
        let rendered = Rendered {
            color: Some(decoded.light_field),
            error: None,
            error_distribution: None,
            central,
            all: None,
            statistics: None,
            integrator: Integrator::Auto,
            why: "decoded".into(),
            rays: RayCounts::default(),
            samples: 0,
        };
        let ev = exposure_ev(settings.output.exposure, &rendered);
        let mut parameters = ParametersCfg::from_rig(&rig);
        // A line of the file.
        let scene = self.scene.as_ref().map_or_else(String::new, SceneSource::name);
        parameters.scene = holo_core::visible(&scene).into_owned();
        let wanted = Wanted::new(&settings)?;
        let views = TracedViews { rig, parameters, highres_depth_m: None, visibility: None, motion: Vec::new() };
        let camera = TracedCamera::Rig(Box::new(views));
        let traced = Traced { rendered, wanted, manifest, camera };
        let weight = decoded.weight.view(count / 2, count / 2)?.index_axis(Axis(2), 0).to_owned();
        folder.unseal()?;
        write_white(&mut folder, "scene_weight", &weight)?;
        Ok((rig, write(&settings, traced, Exposed { ev, electrons: None }, folder)?.files))
    }

    /// Warns of a white image whose micro-images do not lie where the camera has them.
    fn check_grid(&self, path: &Path, white: &Array2<f32>, diagnostics: &dyn Diagnostics) -> Result<(), Error> {
        let camera = &self.camera.camera;
        let (path, name) = (path.display(), &self.camera.name);
        let line = match camera.white_grid(white.view())? {
            None if camera.lens_count() < FEWEST_LENSES => return Ok(()),
            None => format!("{path}: its grid of micro-images is not that of {name}"),
            Some(found) if found.largest_px > MOST_GRID_ERROR_PX => {
                let pitch_px = camera.micro_image_pitch_px();
                let rotation_deg = camera.array().rotation_rad.to_degrees();
                format!(
                    "{path}: its micro-images lie up to {:.2} px from those of {name}: their pitch is {:.4} px instead of \
                     {pitch_px:.4}, their rotation {:.4} degrees instead of {rotation_deg:.4}, and in the middle of the \
                     sensor they lie {:.2} px to the right and {:.2} px down",
                    found.largest_px,
                    pitch_px * found.scale,
                    rotation_deg + found.rotation_rad.to_degrees(),
                    found.offset_px[0],
                    found.offset_px[1]
                )
            }
            Some(_) => return Ok(()),
        };
        diagnostics.report(About::Setup, &format!("warning: {line}; views will be mixed: correct the camera file"));
        Ok(())
    }

    /// Depth and disparity of the central view, if there is a scene.
    fn truth(&self, decoded: &Decoded, diagnostics: &dyn Diagnostics) -> Result<Layers<Array3<f32>>, Error> {
        let Some(scene) = &self.scene else { return Ok(Layers::default()) };
        let stage = Stage::load(scene, &self.settings.scene, None, &self.engine, diagnostics)?;
        let slopes = half_view(&self.camera.camera);
        let framed = pose_of_scene(scene, &stage.loaded, (&self.settings.scene, slopes), diagnostics)?;
        // A rotated array sees a rotated scene.
        let pose = rolled(&framed.pose, decoded.roll_rad);
        let renderer = stage.world(scene, &self.settings.light.sky, &self.engine)?.at(&pose)?;
        Ok(renderer.central_layers(&decoded.rig, LayerSet::of(&[Layer::Depth, Layer::Disparity]))?)
    }
}

/// A camera turned about its axis, counterclockwise as it sees the scene.
fn rolled(pose: &Transform, roll_rad: f64) -> Transform {
    let (sin, cos) = roll_rad.sin_cos();
    let [right, up, back] = pose.columns;
    let mix = |a: [f64; 3], b: [f64; 3], x: f64, y: f64| std::array::from_fn(|k| a[k] * x + b[k] * y);
    Transform { columns: [mix(right, up, cos, sin), mix(up, right, cos, -sin), back], ..*pose }
}

/// Writes the white images of a camera into the folder `out`: `white.exr` and `white.png`, and with f-numbers
/// `white_fN.exr` and `white_fN.png` of each. Returns the names of the files.
///
/// # Errors
/// [`Error::BadRequest`] for an impossible f-number, a camera whose sensor no light reaches, and a folder with a manifest,
/// whose files are not this function's; [`Error::Core`] if there is not enough memory; [`Error::Io`] if files
/// cannot be written.
pub fn write_white_images(
    camera: &CameraFile,
    f_numbers: &[f64],
    out: &Path,
    rollback: &Rollback,
) -> Result<Vec<String>, Error> {
    if out.join(dataset::MANIFEST_JSON).is_file() {
        let out = out.display();
        return Err(Error::BadRequest(format!("{out} holds another image, with a manifest; choose another `out`")));
    }
    let mut cameras = vec![("white".to_owned(), camera.clone())];
    for f_number in f_numbers {
        let stopped = camera.clone().with_f_number(*f_number);
        let stopped = stopped.map_err(|why| Error::BadRequest(why.to_string()))?;
        cameras.push((format!("white_f{f_number}"), stopped));
    }
    let mut folder = OutputFolder::create_plain(out, rollback)?;
    let mut names = Vec::new();
    for (stem, camera) in cameras {
        write_white(&mut folder, &stem, &lit_white_image(&camera)?)?;
        names.extend([format!("{stem}.exr"), format!("{stem}.png")]);
    }
    folder.keep();
    Ok(names)
}
