//! A summary of the contents of a file.

use std::fmt;

use super::advice::is_thin_glass;
use super::animation::{self, AnimationSummary};
use super::extensions::Extensions;
use super::json::Object;
use super::options::LightUnits;
use super::uri::shorten;
use crate::Error;
use crate::Scene;

/// A summary of a scene file, as printed by `holo info`. [`Display`](fmt::Display) gives a few lines of text.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// The program that wrote the file (`asset.generator`).
    pub generator: Option<String>,
    /// Extensions the file uses, sorted.
    pub extensions_used: Vec<String>,
    /// Extensions the file requires, sorted.
    pub extensions_required: Vec<String>,
    /// Nodes of the file, in the loaded scene or not.
    pub nodes: usize,
    /// Meshes of the scene: one for each primitive of the file.
    pub meshes: usize,
    /// Instances of meshes in the world.
    pub instances: usize,
    /// Triangles of all instances.
    pub triangles: usize,
    /// Materials of the scene.
    pub materials: usize,
    /// Textures of the scene.
    pub textures: usize,
    /// The names of the material variants (`KHR_materials_variants`), in the order of the file.
    pub variants: Vec<String>,
    /// The materials of meshes with transmission but without a volume, as index and name: thin panes without
    /// refraction. With [`LoadOptions::solid_glass`](super::LoadOptions::solid_glass) closed meshes are not among them.
    pub thin_glass: Vec<(usize, String)>,
    /// Lights in the world.
    pub lights: usize,
    /// The unit that the intensities of the lights in the file seem to have, which no file says: a guess from its
    /// generator and the numbers. `None` without lights.
    pub light_units: Option<LightUnits>,
    /// The names of the cameras, in the order of their indices; empty for cameras without a name.
    pub cameras: Vec<String>,
    /// The animations, in the order of their indices.
    pub animations: Vec<AnimationSummary>,
}

impl Summary {
    pub(super) fn new(
        root: &Object<'_>,
        extensions: Extensions,
        variants: Vec<String>,
        scene: &Scene,
    ) -> Result<Self, Error> {
        let generator = match root.object("asset")? {
            Some(asset) => asset.string("generator")?.map(str::to_owned),
            None => None,
        };
        Ok(Self {
            generator,
            extensions_used: extensions.used,
            extensions_required: extensions.required,
            nodes: root.list("nodes")?.len(),
            meshes: scene.meshes.len(),
            instances: scene.instances.len(),
            triangles: scene.triangle_count(),
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            variants,
            thin_glass: thin_glass(scene),
            lights: scene.lights.len(),
            light_units: None,
            cameras: scene.cameras.iter().map(|camera| camera.name.clone()).collect(),
            animations: animation::summaries(root)?,
        })
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |names: &[String]| match names {
            [] => "none".to_owned(),
            names => names.iter().map(|name| shorten(name)).collect::<Vec<_>>().join(", "),
        };
        writeln!(f, "generator:           {}", shorten(self.generator.as_deref().unwrap_or("unknown")))?;
        writeln!(f, "extensions used:     {}", list(&self.extensions_used))?;
        writeln!(f, "extensions required: {}", list(&self.extensions_required))?;
        writeln!(f, "nodes:               {}", self.nodes)?;
        writeln!(f, "meshes:              {} in {} places", self.meshes, self.instances)?;
        writeln!(f, "triangles:           {} in the world", self.triangles)?;
        writeln!(f, "materials:           {}", self.materials)?;
        writeln!(f, "textures:            {}", self.textures)?;
        if !self.variants.is_empty() {
            writeln!(f, "material variants:   {}", list(&self.variants))?;
        }
        let numbered = |(k, name): (usize, &String)| format!("{k} '{name}'");
        if !self.thin_glass.is_empty() {
            let panes: Vec<String> = self.thin_glass.iter().map(|(k, name)| numbered((*k, name))).collect();
            writeln!(f, "thin glass:          {} (transmission without a volume: no refraction)", list(&panes))?;
        }
        writeln!(f, "lights:              {}", self.lights)?;
        match self.light_units {
            Some(LightUnits::Blender) => {
                writeln!(f, "light units:         Blender's \"Standard\" by the look of the numbers (x 683)")?;
            }
            Some(_) => writeln!(f, "light units:         glTF (candela, lux)")?,
            None => {}
        }
        if !self.animations.is_empty() {
            let animation =
                |(k, of): (usize, &AnimationSummary)| format!("{k} '{}' ({} s)", shorten(&of.name), of.seconds);
            let animations: Vec<String> = self.animations.iter().enumerate().map(animation).collect();
            writeln!(f, "animations:          {}", list(&animations))?;
        }
        let cameras: Vec<String> = self.cameras.iter().enumerate().map(numbered).collect();
        write!(f, "cameras:             {}", list(&cameras))
    }
}

/// The materials that meshes use with transmission and without a volume.
fn thin_glass(scene: &Scene) -> Vec<(usize, String)> {
    let mut used = vec![false; scene.materials.len()];
    scene.meshes.iter().for_each(|mesh| used[mesh.material] = true);
    let thin =
        scene.materials.iter().zip(used).enumerate().filter(|(_, (material, used))| *used && is_thin_glass(material));
    thin.map(|(k, (material, _))| (k, material.name.clone())).collect()
}
