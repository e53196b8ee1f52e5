//! From the command line to what the libraries take.

use std::num::NonZeroUsize;

use holo_core::GridSize;
use holo_dataset::{DatasetCameras, EngineSettings, RenderSettings, RigSettings, adjusted_camera};
use holo_io::CameraFile;

use super::config;
use super::settings::FOCAL_MM;
use super::{DatasetOptions, EngineOptions, InfoOptions, OpticsOptions, RenderOptions};
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

impl DatasetOptions {
    /// Returns the cameras, and the settings that all jobs share.
    pub fn settings(&self) -> Result<(DatasetCameras, RenderSettings), Failure> {
        let mut given = self.settings.given().clone();
        let mut settings = RenderSettings::default();
        if let Some(preset) = self.preset {
            given = given.over(preset.given());
        }
        settings.preset = self.preset;
        let views = self.views(given.remove("views"))?;
        let files = self.camera_file.iter().map(|path| Ok(adjusted_camera(open_camera(path)?, &mut given.clone())?));
        let files = files.collect::<Result<Vec<_>, Failure>>()?;
        if let Some(first) = files.first() {
            settings.camera = first.clone().into();
            // The cameras have both now.
            for key in ["focus-m", "f-number"] {
                given.remove(key);
            }
        }
        match &self.transforms {
            Some(path) => {
                // Light fields instead of single images; every job has its own number of views.
                if let (true, Some(views)) = (files.is_empty(), views.first()) {
                    given.insert("views", views.to_string())?;
                }
                settings.apply_at_poses(given, path, self.transforms_up)?;
            }
            None => settings.apply(&given)?,
        }
        let cameras = match files.is_empty() {
            true => DatasetCameras::Views(views),
            false => DatasetCameras::Plenoptic(files),
        };
        Ok((cameras, settings))
    }

    /// Returns the numbers of views of the dataset: those of the command line, else that of the preset, else those of the paper.
    fn views(&self, of_preset: Option<String>) -> Result<Vec<GridSize>, Failure> {
        match (self.view_counts.as_slice(), of_preset) {
            ([], Some(one)) => Ok(vec![one.parse().map_err(|why| Failure::Usage(format!("{why}")))?]),
            ([], None) => Ok(VIEW_COUNTS.map(|count| GridSize::new(count, count)).into()),
            (counts, _) => Ok(counts.to_vec()),
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
