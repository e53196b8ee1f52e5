//! Options as text, by the names of the command line.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;

use holo_core::{Effort, Layout, ViewOrder};
use holo_dataset::settings::{Given, PRESETS, Preset, SettingType};
use holo_dataset::{Camera, EngineSettings, RenderSettings};
use holo_io::WorldUp;
use holo_render::Backend;

use crate::failure::Failure;

/// The settings of a render, over those of a preset, with this camera, at the poses of a file or of the scene.
pub fn settings(
    options: &BTreeMap<String, String>,
    preset: Option<&str>,
    camera: Camera,
    poses: Option<(&Path, WorldUp)>,
) -> Result<RenderSettings, Failure> {
    let mut given = Given::default();
    for (key, text) in options {
        // A plenoptic camera has its own focus and aperture already.
        if camera.plenoptic().is_none() || !["focus-m", "f-number"].contains(&key.as_str()) {
            given.insert(key, text.as_str())?;
        }
    }
    let mut settings = RenderSettings::default();
    if let Some(name) = preset {
        let known = || {
            let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
            Failure::Usage(format!("preset='{name}': give {}", names.join(", ")))
        };
        let preset = Preset::by_name(name).ok_or_else(known)?;
        given = given.over(preset.given());
        settings.preset = Some(preset);
    }
    settings.camera = camera;
    match poses {
        Some((path, up)) => settings.apply_at_poses(given, path, up)?,
        None => settings.apply(&given)?,
    }
    Ok(settings)
}

/// The value of `word` among `choices`; the error names them.
pub fn choice<T: Copy>(name: &str, word: &str, choices: &[(&str, T)]) -> Result<T, Failure> {
    match choices.iter().find(|(known, _)| *known == word) {
        Some((_, value)) => Ok(*value),
        None => {
            let known: Vec<&str> = choices.iter().map(|(known, _)| *known).collect();
            Err(Failure::Usage(format!("{name}='{word}': give {}", known.join(", "))))
        }
    }
}

pub fn engine(backend: &str, threads: usize) -> Result<EngineSettings, Failure> {
    let backend = Backend::parse(backend).map_err(|why| Failure::Usage(format!("backend='{backend}': {why}")))?;
    Ok(EngineSettings::default().backend(backend).threads(NonZeroUsize::new(threads)))
}

pub fn layout(word: &str) -> Result<Layout, Failure> {
    choice("layout", word, &[("el", Layout::ElementalGrid), ("vpi", Layout::ViewpointGrid)])
}

pub fn order(word: &str) -> Result<ViewOrder, Failure> {
    choice("order", word, &ViewOrder::ALL.map(|order| (order.name(), order)))
}

/// The axis of the world that points up.
pub fn world_up(word: &str) -> Result<WorldUp, Failure> {
    choice("transforms_up", word, &[("z", WorldUp::Z), ("y", WorldUp::Y)])
}

pub fn effort(word: &str) -> Result<Effort, Failure> {
    let choices = [
        ("draft", Effort::Draft),
        ("fast", Effort::Fast),
        ("balanced", Effort::Balanced),
        ("thorough", Effort::Thorough),
    ];
    choice("effort", word, &choices)
}
