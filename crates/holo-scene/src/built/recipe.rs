//! Recipes: distributions that scenes are drawn from, for training sets of any size.
//!
//! A recipe is a text in TOML. Scene k follows from the recipe, a seed and k alone, so that any machine makes any part of a
//! set. [`Recipe::by_name`] has those of [`NAMES`]; a recipe of one's own begins as a copy of their texts ([`Recipe::text`]).
//!
//! # The text
//! | key | |
//! |---|---|
//! | `format` | `"holo recipe 1"` |
//! | `name`, `about` | the name, letters and digits and `-`, and what the scenes are for |
//! | `[layouts]` | weights of `table`, `room`, `street`, `floating`, `slanted`, `steps`, `thicket` |
//! | `[camera]` | `vertical_angle_deg`, `distance_m` from the middle of the scene, `tilt_deg` downwards; `plenoptic`, a preset of plenoptic cameras if the scenes are for one |
//! | `[camera.perturbed]` | of plenoptic cameras, by how much they differ from the preset: `rotation_deg` of the microlens array, `offset` in pitches, the factor `pitch`; `focus_m`, where they are focused |
//! | `[objects]` | `count`; `size`, in parts of the image; `apart`, whether they keep away from each other; `models`, a folder of `.glb` files |
//! | `[objects.shapes]` | weights of `box`, `ball`, `stone`, `lathe`, `vessel`, `ring`, `knot`, `spring`, `gear`, `frame`, `text`, `burr`, `plant`, `sheet`, and `model` for those of the folder |
//! | `[surfaces]` | weights of `matte`, `glossy`, `coated`, `cloth`, `metal`, `brushed`, `glass`, `veil`, `translucent`, `luminous` |
//! | `[textures]` | `across`, how often a pattern repeats; `relief`, the share of objects with a normal map; `images`, a folder of PNG and JPEG files |
//! | `[textures.patterns]` | weights of `plain`, `grain`, `clouds`, `checks`, `stripes`, `dots`, `bricks`, `wood`, `cells`, `letters`, and `image` for those of the folder |
//! | `[extras]` | shares of the scenes with `wires`, a `fence`, `repeated` objects, `plants` |
//! | `[light]` | shares with a `sky` that varies and a `sun`; numbers of `lamps` and `panels` |
//! | `[settings]` | settings of renders by their names: a list of texts, of which one is drawn, with numbers to draw: `"{-2..-1},{1..2}"`, `"{100..3200 log}"` |
//! | `[shares]` | for properties that are measured in the truth, the least and largest share of scenes that have them |
//!
//! A range is `[low, high]`. Numbers are drawn evenly; sizes, distances and `across` so that factors are equally likely.
//! Folders are relative to the file of the recipe. Positions, sizes and materials are drawn by numbers that are equal on all
//! machines; meshes and textures also depend on the sines and powers of the system's library.

mod camera;
mod composition;
mod distribution;
mod extras;
mod filling;
mod layout;
mod light;
mod models;
mod objects;
mod surface;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

pub use self::camera::CameraChange;
use self::camera::Perturbed;
use self::composition::Composition;
use self::distribution::{Span, Texts, Weights};
use self::layout::Layout;
use self::models::Models;
use self::objects::Shape;
use self::surface::{Pattern, Surface};
use crate::built::parts::noise::Random;
use crate::{Error, Scene};

/// The names of the recipes of this crate.
pub const NAMES: &[&str] = &["mixed", "hci-like", "thin-and-slanted", "specular", "plenoptic-raw"];

const TEXTS: [&str; 5] = [
    include_str!("recipe/mixed.toml"),
    include_str!("recipe/hci-like.toml"),
    include_str!("recipe/thin-and-slanted.toml"),
    include_str!("recipe/specular.toml"),
    include_str!("recipe/plenoptic-raw.toml"),
];

/// The value of the key `format`.
const FORMAT: &str = "holo recipe 1";

/// More objects would take minutes a scene.
const OBJECTS: f64 = 500.0;

/// Numbers of a purpose of their own, so that what one draws does not change the others.
const SCENE: u64 = 1;
const SETTINGS: u64 = 2;
const CAMERA: u64 = 3;

/// Distributions that scenes are drawn from.
#[derive(Clone, Debug)]
pub struct Recipe {
    text: String,
    parts: Parts,
    models: Models,
}

/// The text of a recipe.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Parts {
    format: String,
    name: String,
    about: String,
    layouts: Weights<Layout>,
    camera: CameraPart,
    objects: ObjectPart,
    surfaces: Weights<Surface>,
    textures: TexturePart,
    #[serde(default)]
    extras: Extras,
    light: LightPart,
    #[serde(default)]
    settings: BTreeMap<String, Texts>,
    #[serde(default)]
    shares: BTreeMap<String, [f64; 2]>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraPart {
    vertical_angle_deg: Span,
    distance_m: Span,
    tilt_deg: Span,
    plenoptic: Option<String>,
    perturbed: Option<Perturbed>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectPart {
    count: Span,
    size: Span,
    apart: bool,
    shapes: Weights<Shape>,
    models: Option<PathBuf>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TexturePart {
    across: Span,
    relief: f64,
    patterns: Weights<Pattern>,
    images: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Extras {
    wires: f64,
    fence: f64,
    repeated: f64,
    plants: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LightPart {
    sky: f64,
    sun: f64,
    lamps: Span,
    panels: Span,
}

impl Recipe {
    /// Returns the recipe of a name of [`NAMES`]; `None` for an unknown one.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        let text = NAMES.iter().zip(TEXTS).find(|(known, _)| **known == name)?.1;
        Self::from_toml(text).ok()
    }

    /// Reads a recipe without folders from its text.
    ///
    /// # Errors
    /// [`Error::BadFile`] if a key is unknown or missing, or a value is out of its range.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        Self::read(text, Path::new("recipe"), None)
    }

    /// Reads a recipe with the models and images of its folders from a file.
    ///
    /// # Errors
    /// [`Error::Read`] if a file cannot be read, [`Error::BadFile`] and others if it is no recipe, no scene or no image.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let failed = |error| Error::Read { path: path.display().to_string(), error };
        let text = std::fs::read_to_string(path).map_err(failed)?;
        Self::read(&text, path, Some(path.parent().unwrap_or(Path::new(""))))
    }

    fn read(text: &str, path: &Path, folder: Option<&Path>) -> Result<Self, Error> {
        let at = path.display().to_string();
        let parts: Parts =
            toml::from_str(text).map_err(|why| Error::BadFile { at: at.clone(), what: why.to_string() })?;
        parts.check().map_err(|(key, what)| Error::BadFile { at: format!("{at}: {key}"), what })?;
        let (models, images) = (&parts.objects.models, &parts.textures.images);
        let Some(folder) = folder else {
            if models.is_some() || images.is_some() {
                let what = "folders are of recipes in files".into();
                return Err(Error::BadFile { at, what });
            }
            return Ok(Self { text: text.to_owned(), parts, models: Models::default() });
        };
        let [models, images] = [models, images].map(|inner| inner.as_ref().map(|inner| folder.join(inner)));
        let models = Models::read(models.as_deref(), images.as_deref())?;
        Ok(Self { text: text.to_owned(), parts, models })
    }

    /// Returns the name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.parts.name
    }

    /// Returns what its scenes are for.
    #[must_use]
    pub fn about(&self) -> &str {
        &self.parts.about
    }

    /// Returns the text that it was read from.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the plenoptic camera that its scenes are for, a preset; `None`: a rig of views.
    #[must_use]
    pub fn camera_file(&self) -> Option<&str> {
        self.parts.camera.plenoptic.as_deref()
    }

    /// Draws how the plenoptic camera of scene `number` differs from its preset; `None`: not at all.
    #[must_use]
    pub fn camera(&self, seed: u64, number: u64) -> Option<CameraChange> {
        self.parts.camera.perturbed.map(|perturbed| perturbed.draw(&mut self.random(&[CAMERA, seed, number])))
    }

    /// Returns the files of its folders that are used.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.models.files
    }

    /// Returns the shares of scenes that have a property, at least and at most, by its name.
    pub fn shares(&self) -> impl Iterator<Item = (&str, [f64; 2])> {
        self.parts.shares.iter().map(|(name, share)| (name.as_str(), *share))
    }

    /// Draws scene `number`. If it is of no use, `attempt` 1 is the next, and so on.
    #[must_use]
    pub fn scene(&self, seed: u64, number: u64, attempt: u64) -> Scene {
        let random = self.random(&[SCENE, seed, number, attempt]);
        let mut composition = Composition::new(&self.parts, &self.models, random);
        layout::build(&mut composition);
        composition.finish()
    }

    /// Numbers of this recipe alone: scenes of two recipes with one seed have nothing in common.
    fn random(&self, numbers: &[u64]) -> Random {
        let name = self.parts.name.bytes().map(u64::from);
        Random::of(&name.chain(numbers.iter().copied()).collect::<Vec<_>>())
    }

    /// Draws the settings of scene `number`: names and texts.
    #[must_use]
    pub fn settings(&self, seed: u64, number: u64) -> Vec<(String, String)> {
        let mut random = self.random(&[SETTINGS, seed, number]);
        self.parts.settings.iter().map(|(key, texts)| (key.clone(), texts.pick(&mut random))).collect()
    }
}

impl Parts {
    /// What is wrong: a key, and why.
    fn check(&self) -> Result<(), (String, String)> {
        let wrong = |key: &str, what: &str| Err((key.to_owned(), what.to_owned()));
        if self.format != FORMAT {
            return wrong("format", &format!("this version reads \"{FORMAT}\""));
        }
        if self.name.is_empty() || !self.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-') {
            return wrong("name", "a name has letters, digits and -");
        }
        let weights = [
            ("layouts", self.layouts.fault()),
            ("objects.shapes", self.objects.shapes.fault()),
            ("surfaces", self.surfaces.fault()),
            ("textures.patterns", self.textures.patterns.fault()),
        ];
        for (key, fault) in weights {
            fault.map_or(Ok(()), |fault| wrong(key, &fault))?;
        }
        for (key, texts) in &self.settings {
            texts.fault().map_or(Ok(()), |fault| wrong(&format!("settings.{key}"), &fault))?;
        }
        let spans = [
            ("camera.vertical_angle_deg", self.camera.vertical_angle_deg, 1.0, 120.0),
            ("camera.distance_m", self.camera.distance_m, 1e-3, 1e3),
            ("camera.tilt_deg", self.camera.tilt_deg, 0.0, 85.0),
            ("objects.count", self.objects.count, 0.0, OBJECTS),
            ("objects.size", self.objects.size, 1e-3, 2.0),
            ("textures.across", self.textures.across, 0.5, 200.0),
            ("light.lamps", self.light.lamps, 0.0, 16.0),
            ("light.panels", self.light.panels, 0.0, 16.0),
        ];
        let of_camera = self.camera.perturbed.iter().flat_map(Perturbed::ranges);
        for (key, span, low, high) in spans.into_iter().chain(of_camera) {
            if !span.is_within(low, high) {
                return wrong(key, &format!("both numbers are from {low} to {high}"));
            }
        }
        let Extras { wires, fence, repeated, plants } = self.extras;
        let shares = [
            ("extras.wires", wires),
            ("extras.fence", fence),
            ("extras.repeated", repeated),
            ("extras.plants", plants),
            ("textures.relief", self.textures.relief),
            ("light.sky", self.light.sky),
            ("light.sun", self.light.sun),
        ];
        let of_properties = self.shares.iter().flat_map(|(key, share)| share.map(|share| (key.as_str(), share)));
        for (key, share) in shares.into_iter().chain(of_properties) {
            if !(0.0..=1.0).contains(&share) {
                return wrong(key, "a share is from 0 to 1");
            }
        }
        let is_model = self.objects.shapes.of(Shape::Model) > 0.0;
        if is_model && self.objects.models.is_none() {
            return wrong("objects.shapes.model", "models come from a folder: give `models`");
        }
        if self.textures.patterns.of(Pattern::Image) > 0.0 && self.textures.images.is_none() {
            return wrong("textures.patterns.image", "images come from a folder: give `images`");
        }
        Ok(())
    }
}
