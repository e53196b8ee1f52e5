//! From the command line to what the libraries take.

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;

use holo_core::GridSize;
use holo_dataset::settings::Given;
use holo_dataset::{DatasetCameras, EngineSettings, RenderSettings, RigSettings, SceneSource, adjusted_camera, drawn};
use holo_io::CameraFile;
use holo_scene::recipe::Recipe;

use super::config;
use super::settings::FOCAL_MM;
use super::{
    CollectionOptions, DatasetOptions, EngineOptions, GenerateOptions, InfoOptions, OpticsOptions, RenderOptions,
};
use crate::console::say;
use crate::failure::Failure;

impl RenderOptions {
    /// What to render: the settings of the command line over those of the configuration over those of the preset.
    pub fn settings(&self) -> Result<RenderSettings, Failure> {
        let mut given = self.settings.given().clone();
        if let Some(path) = &self.config {
            given = given.over(config::read(path)?);
        }
        if let Some(preset) = self.preset {
            given = given.over(preset.given());
        }
        let mut settings = RenderSettings::default();
        settings.preset = self.preset;
        if let Some(path) = &self.camera_file {
            settings.camera = adjusted_camera(open_camera(path)?, &mut given)?.into();
        }
        match &self.transforms {
            Some(path) => settings.apply_at_poses(given, path, self.transforms_up)?,
            None => settings.apply(&given)?,
        }
        Ok(settings)
    }
}

/// The numbers of views of the paper, along each axis.
const VIEW_COUNTS: [usize; 5] = [20, 40, 60, 80, 100];

/// The pixels of a sensor whose images take minutes.
const MANY_PIXELS: usize = 1 << 28;

/// Reads a camera file or a preset, and says if the sensor will take long: a file of a few lines announces any size.
pub fn open_camera(name: &str) -> Result<CameraFile, Failure> {
    let file = CameraFile::open(name)?;
    let size = file.camera.sensor().size;
    if size.count() > MANY_PIXELS {
        say!("note: {name}: a sensor of {} x {} px; its images take minutes", size.columns, size.rows);
    }
    Ok(file)
}

/// The number of views of a set that is drawn, along each axis.
const GENERATED_VIEWS: [usize; 1] = [9];

/// Cameras, and settings as they are given, over those that they are applied to.
type Parts = (DatasetCameras, Given, RenderSettings);

impl DatasetOptions {
    /// Returns the cameras, and the settings that all jobs share.
    pub fn settings(&self) -> Result<(DatasetCameras, RenderSettings), Failure> {
        let (cameras, mut given, mut settings) = self.collection.parts(&VIEW_COUNTS)?;
        match &self.transforms {
            Some(path) => {
                // Light fields instead of single images; every job has its own number of views.
                if let DatasetCameras::Views(views) = &cameras
                    && let Some(views) = views.first()
                {
                    given.insert("views", views.to_string())?;
                }
                settings.apply_at_poses(given, path, self.transforms_up)?;
            }
            None => settings.apply(&given)?,
        }
        Ok((cameras, settings))
    }
}

impl GenerateOptions {
    /// Returns the recipe.
    pub fn recipe(&self) -> Result<Arc<Recipe>, Failure> {
        if let Some(recipe) = Recipe::by_name(&self.recipe) {
            return Ok(Arc::new(recipe));
        }
        let path = Path::new(&self.recipe);
        if path.is_file() {
            return Ok(Arc::new(Recipe::open(path).map_err(|why| Failure::Failed(why.to_string()))?));
        }
        let (name, known) = (holo_core::shown(&self.recipe), holo_scene::recipe::NAMES.join(", "));
        Err(Failure::Usage(format!("--recipe {name}: neither a file nor one of {known}")))
    }

    /// Returns the scenes with their settings, and the cameras.
    pub fn scenes(
        &self,
        recipe: &Arc<Recipe>,
    ) -> Result<(Vec<(SceneSource, RenderSettings)>, DatasetCameras), Failure> {
        let mut collection = self.collection.clone();
        let has_views =
            !collection.view_counts.is_empty() || collection.preset.is_some_and(|p| p.given().get("views").is_some());
        if let (true, false, Some(camera)) = (collection.camera_file.is_empty(), has_views, recipe.camera_file()) {
            collection.camera_file.push(camera.to_owned());
        }
        let (cameras, given, base) = collection.parts(&GENERATED_VIEWS)?;
        let draws_focus = recipe.camera(0, 0).is_some_and(|change| change.focus_m.is_some());
        let has_focus = collection.settings.given().get("focus-m").is_some();
        if matches!(cameras, DatasetCameras::Plenoptic(_)) && draws_focus && has_focus {
            let why = "--focus-m: the recipe draws the focus of every scene; take `focus_m` out of [camera.perturbed] in a copy of it";
            return Err(Failure::Usage(why.into()));
        }
        let mut checked = base.clone();
        checked.apply(&given)?;
        let scenes = drawn(recipe, (checked.light.seed, self.count), &given, &base)?;
        Ok((scenes, cameras))
    }
}

impl CollectionOptions {
    /// What the options say; `counts` are the numbers of views that nobody chose.
    fn parts(&self, counts: &[usize]) -> Result<Parts, Failure> {
        let mut given = self.settings.given().clone();
        let mut settings = RenderSettings::default();
        if let Some(preset) = self.preset {
            given = given.over(preset.given());
        }
        settings.preset = self.preset;
        let views = self.views(given.remove("views"), counts)?;
        let files = self.camera_file.iter().map(|path| Ok(adjusted_camera(open_camera(path)?, &mut given.clone())?));
        let files = files.collect::<Result<Vec<_>, Failure>>()?;
        if let Some(first) = files.first() {
            settings.camera = first.clone().into();
            // The cameras have both now.
            for key in ["focus-m", "f-number"] {
                given.remove(key);
            }
        }
        let cameras = match files.is_empty() {
            true => DatasetCameras::Views(views),
            false => DatasetCameras::Plenoptic(files),
        };
        Ok((cameras, given, settings))
    }

    /// Returns the numbers of views: those of the command line, else that of the preset, else `counts`.
    fn views(&self, of_preset: Option<String>, counts: &[usize]) -> Result<Vec<GridSize>, Failure> {
        match (self.view_counts.as_slice(), of_preset) {
            ([], Some(one)) => Ok(vec![one.parse().map_err(|why| Failure::Usage(format!("{why}")))?]),
            ([], None) => Ok(counts.iter().map(|&count| GridSize::new(count, count)).collect()),
            (chosen, _) => Ok(chosen.to_vec()),
        }
    }
}

impl InfoOptions {
    pub fn settings(&self) -> Result<RenderSettings, Failure> {
        let mut settings = RenderSettings::default();
        settings.apply(self.settings.given())?;
        Ok(settings)
    }
}

impl OpticsOptions {
    pub fn rig(&self) -> Result<RigSettings, Failure> {
        let mut rig = RigSettings::default();
        rig.focal_mm = Some(FOCAL_MM);
        let mut settings = RenderSettings::default();
        settings.camera = rig.into();
        settings.apply(self.settings.given())?;
        Ok(settings.camera.rig().cloned().unwrap_or_default())
    }
}

impl EngineOptions {
    pub fn settings(&self) -> EngineSettings {
        let threads = self.threads.and_then(|threads| NonZeroUsize::new(usize::from(threads)));
        EngineSettings::default().backend(self.backend).threads(threads)
    }
}
