//! A summary of the contents of a file.

use std::fmt;

use super::extensions::Extensions;
use super::json::Object;
use super::uri::shorten;
use crate::Error;
use crate::Scene;

/// A summary of a scene file, as printed by `holo info`. [`Display`](fmt::Display) gives a few lines of text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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
    /// Lights in the world.
    pub lights: usize,
    /// The names of the cameras, in the order of their indices; empty for cameras without a name.
    pub cameras: Vec<String>,
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
            lights: scene.lights.len(),
            cameras: scene.cameras.iter().map(|camera| camera.name.clone()).collect(),
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
        writeln!(f, "lights:              {}", self.lights)?;
        let cameras: Vec<String> = self.cameras.iter().enumerate().map(|(k, name)| format!("{k} '{name}'")).collect();
        write!(f, "cameras:             {}", list(&cameras))
    }
}
