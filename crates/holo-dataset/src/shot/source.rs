//! The sources of scenes: files, the gallery, and recipes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use holo_core::plenoptic::PlenopticCamera;
use holo_io::{CameraFile, Sha256};
use holo_scene::gltf::{self, LoadOptions, Loaded};
use holo_scene::recipe::Recipe;
use holo_scene::{Scene, gallery};

use super::drawn;
use crate::Error;
use crate::settings::{EngineSettings, SceneSettings};

/// The source of a scene. Copies share the bytes of the file: a dataset has one for each of its images.
#[derive(Clone, Debug)]
pub enum SceneSource {
    /// A `.glb` or `.gltf` file.
    File(PathBuf),
    /// A scene of the gallery: its name, and the `.glb` that `holo scene` writes, so that both give the same image.
    Gallery(&'static str, Arc<[u8]>),
    /// A `.glb` in memory, with a name for messages and files.
    Memory(String, Arc<[u8]>),
    /// A scene of a recipe, which is drawn when it is loaded.
    Recipe(Drawing),
}

/// A scene of a recipe: the same wherever it is drawn.
#[derive(Clone, Debug)]
pub struct Drawing {
    recipe: Arc<Recipe>,
    /// The digest of the text and the files of the recipe.
    digest: Sha256,
    seed: u64,
    number: u64,
    /// Its number, of six digits.
    name: String,
}

impl Drawing {
    /// The scenes of a recipe and a seed, from 0 to `count - 1`. The files of the recipe are read once.
    ///
    /// # Errors
    /// [`Error::Io`] if a file of the recipe cannot be read.
    pub fn first(recipe: &Arc<Recipe>, seed: u64, count: u64) -> Result<impl Iterator<Item = Self>, Error> {
        let mut text = recipe.text().to_owned();
        for file in recipe.files() {
            text += &format!("\n{}", holo_io::hash_file(file)?.sha256);
        }
        let digest = Sha256::of(text.as_bytes());
        let recipe = Arc::clone(recipe);
        let of = move |number| Self { recipe: Arc::clone(&recipe), digest, seed, number, name: format!("{number:06}") };
        Ok((0..count).map(of))
    }

    /// The number of the scene.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The recipe.
    #[must_use]
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// The seed of all scenes.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns a plenoptic camera as the recipe perturbs it for this scene: its array turned, moved and scaled, its focus
    /// moved.
    ///
    /// # Errors
    /// [`Error::Io`] or [`Error::Core`] if such a camera forms no image.
    pub fn perturbed(&self, mut file: CameraFile) -> Result<CameraFile, Error> {
        let Some(change) = self.recipe.camera(self.seed, self.number) else { return Ok(file) };
        let camera = &file.camera;
        let mut array = camera.array().clone();
        array.rotation_rad += change.rotation_rad;
        array.offset_m = [0, 1].map(|k| array.offset_m[k] + change.offset[k] * array.pitch_m);
        array.pitch_m *= change.pitch;
        array.aperture = array.aperture.scaled(change.pitch);
        file.camera = PlenopticCamera::new(*camera.sensor(), array, camera.main_lens().clone())?;
        match change.focus_m {
            Some(depth_m) => Ok(file.with_focus_m(depth_m)?),
            None => Ok(file),
        }
    }

    /// Draws the scene, and returns how often it was drawn before because it was of no use: empty, hidden, flat or dark.
    ///
    /// # Errors
    /// [`Error::Render`] if it cannot be rendered.
    pub fn draw(&self, engine: &EngineSettings) -> Result<(Scene, u64), Error> {
        drawn::draw(&self.recipe, self.seed, self.number, engine)
    }
}

impl SceneSource {
    /// Creates the scene of a `.glb` or `.gltf` file. It is read when the scene is loaded.
    #[must_use]
    pub fn file(path: impl AsRef<Path>) -> Self {
        Self::File(path.as_ref().to_owned())
    }

    /// Creates a scene of the gallery by its name.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if there is no such scene.
    pub fn gallery(name: &str) -> Result<Self, Error> {
        let known = gallery::all_names().find(|known| *known == name);
        let (name, glb) = known.and_then(|known| Some((known, gallery::to_glb(known)?))).ok_or_else(|| {
            let known = gallery::all_names().collect::<Vec<_>>().join(", ");
            Error::BadRequest(format!("the gallery has no scene '{name}'; it has: {known}"))
        })?;
        Ok(Self::Gallery(name, glb?.into()))
    }

    /// Returns the path of the file, or the name of the gallery scene, for messages.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::File(path) => path,
            Self::Gallery(name, _) => Path::new(name),
            Self::Memory(name, _) => Path::new(name),
            Self::Recipe(drawing) => Path::new(&drawing.name),
        }
    }

    /// Returns the name of the scene: the file name without its extension, or the name in the gallery.
    #[must_use]
    pub fn name(&self) -> String {
        self.path().file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Computes the digest of the file, or of the `.glb` of the gallery scene.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read.
    pub fn sha256(&self) -> Result<Sha256, Error> {
        Ok(match self {
            Self::File(path) => holo_io::hash_file(path)?.sha256,
            Self::Gallery(_, glb) | Self::Memory(_, glb) => Sha256::of(glb),
            // What the scene follows from.
            Self::Recipe(Drawing { digest, seed, number, .. }) => {
                Sha256::of(format!("holo recipe scene 1\n{seed} {number} {digest}").as_bytes())
            }
        })
    }

    /// Loads the scene, at the first of the frames of `settings` if it has some. Nothing else of it changes a scene of the
    /// gallery.
    ///
    /// # Errors
    /// An error of `holo-scene` if the file cannot be read, is not valid glTF, or does not have the material variant.
    pub fn load(&self, settings: &SceneSettings) -> Result<Loaded, holo_scene::Error> {
        self.load_later(settings, 0.0)
    }

    /// As [`load`](Self::load), so many seconds after the frame; without a frame, after the start of the animation.
    pub(super) fn load_later(&self, settings: &SceneSettings, later_s: f64) -> Result<Loaded, holo_scene::Error> {
        match self {
            Self::File(path) => gltf::load_with(path, &settings.load_options(later_s)),
            Self::Gallery(_, glb) => gltf::load_slice_with(glb, &settings.times(later_s)),
            Self::Memory(_, glb) => gltf::load_slice_with(glb, &settings.load_options(later_s)),
            Self::Recipe(drawing) => match drawing.draw(&EngineSettings::default()) {
                Ok((scene, _)) => Ok(scene.into()),
                Err(why) => Err(holo_scene::Error::BadScene { at: drawing.name.clone(), what: why.to_string() }),
            },
        }
    }
}

impl SceneSettings {
    /// Returns the number of frames a second.
    #[must_use]
    pub fn frames_per_second(&self) -> f64 {
        self.fps.unwrap_or(24.0)
    }

    /// Returns the time of a frame, s.
    #[must_use]
    pub fn seconds_of(&self, frame: u32) -> f64 {
        f64::from(frame) / self.frames_per_second()
    }

    /// The options that concern time alone.
    fn times(&self, later_s: f64) -> LoadOptions {
        let mut options = LoadOptions::default();
        let frame_s = self.frames.map(|frames| self.seconds_of(frames.first));
        options.time_s = if later_s == 0.0 { frame_s } else { Some(frame_s.unwrap_or(0.0) + later_s) };
        options.animation.clone_from(&self.animation);
        options
    }

    fn load_options(&self, later_s: f64) -> LoadOptions {
        let mut options = self.times(later_s);
        options.light_units = self.light_units;
        options.solid_glass = self.solid_glass;
        options.material_variant.clone_from(&self.material_variant);
        options
    }
}
