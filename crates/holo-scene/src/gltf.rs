//! glTF 2.0: `.glb`, and `.gltf` with files beside it or data URIs inside.
//!
//! **What is read.** The default scene's node hierarchy, composed in f64; triangles, strips and fans, indexed or not, with
//! normals, vertex colors and two sets of texture coordinates (`TEXCOORD_0` and `_1`; where a material's textures read
//! others, those); sparse and normalized accessors; textures (PNG, JPEG; 16-bit images are rounded to 8) with their wrap
//! modes; cameras; the lights of `KHR_lights_punctual`. Instances, lights and cameras come in the order of their nodes in
//! the file.
//!
//! **Materials** are read whole, with the specification's defaults (a file that says nothing means rough white metal, a
//! non-metal without `KHR_materials_specular` the gloss of index 1.5): metallic-roughness, normal maps, emission, alpha,
//! `doubleSided`, and the extensions `KHR_materials_emissive_strength`, `_ior`, `_specular`, `_transmission`, `_unlit`,
//! `_volume` and `KHR_texture_transform`. Occlusion textures are passed over without a word, since light is really
//! occluded. Of the thickness of a volume only counts whether it is above 0 (0: a thin pane); distances of attenuation are
//! in world units. An index of refraction of 0, the specification's infinity, becomes 1000 (99.6 % reflected at normal
//! incidence), with a warning. Black attenuation is kept a hair above 0.
//!
//! **Our own addition.** A directional light whose `extras` hold the number `angular_diameter_rad` is a disc of that
//! apparent diameter, rad: 0.0093 for the sun. Without it, its light is parallel.
//!
//! **What is not.** Vertex tangents are passed over: normal maps follow the texture coordinates. Morph targets, skins and
//! animations are ignored, with a warning. Compressed and quantized meshes (Draco, meshopt, `KHR_mesh_quantization`) are
//! errors. An extension we do not handle (clearcoat, sheen, iridescence, anisotropy, dispersion, variants, ...) is named
//! in a warning when it is used, in an error when it is required.
//!
//! **What a file may do.** Nothing but be loaded or be refused with an [`Error`] that says where: all sizes are checked
//! against [`Limits`] before memory is taken, files are read only below the folder of the scene file, and nothing a file
//! says reaches another crate unchecked. Should a decoder panic all the same, that is caught and becomes an error; a
//! program whose panic hook prints should ask [`is_guarding`] first.

mod accessors;
mod container;
mod extensions;
mod json;
mod materials;
mod meshes;
mod net;
mod nodes;
mod placed;
mod summary;
mod textures;
mod uri;
mod values;
mod views;
mod warnings;
mod write;

use std::path::Path;

use self::accessors::Checker;
use self::container::Files;
use self::json::Object;
use self::views::Views;
use self::warnings::Warnings;
use crate::Error;
use crate::Scene;

pub use self::net::is_guarding;
pub use self::summary::Summary;
pub use self::write::to_glb;

/// A scene with what its file said about itself.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Loaded {
    /// The scene; it passes [`Scene::validate`].
    pub scene: Scene,
    /// What was left out or is drawn otherwise than the file asks, one line a kind.
    pub warnings: Vec<String>,
    /// Counts and names.
    pub summary: Summary,
}

/// How much a file may ask for. All of it is checked before memory is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Triangles of all meshes together, and triangles in the world with every instance counted.
    pub max_triangles: u64,
    /// Vertices of all meshes together.
    pub max_vertices: u64,
    /// Placements of meshes in the world.
    pub max_instances: usize,
    /// Pixels of all textures together.
    pub max_texture_pixels: u64,
    /// Bytes of the scene file and the files it refers to together.
    pub max_bytes: u64,
}

impl Default for Limits {
    /// 256 Mi triangles and vertices, 4 Mi instances, 1 Gi texture pixels, 16 GiB in files.
    fn default() -> Self {
        Self {
            max_triangles: 1 << 28,
            max_vertices: 1 << 28,
            max_instances: 1 << 22,
            max_texture_pixels: 1 << 30,
            max_bytes: 16 << 30,
        }
    }
}

/// Loads a scene file, `.glb` or `.gltf`, told apart by content.
///
/// # Errors
/// Files that cannot be read, break the rules of glTF, exceed `limits` or require what is not handled.
pub fn load(path: &Path, limits: &Limits) -> Result<Loaded, Error> {
    let files = Files::new(path.parent(), limits.max_bytes);
    let bytes = files.read(path)?;
    net::catch(|| assemble(&bytes, &files, limits))
}

/// Loads a scene from memory: `.glb`, or `.gltf` JSON whose buffers and images are data URIs.
///
/// # Errors
/// As [`load`]; also a file that refers to other files.
pub fn load_slice(bytes: &[u8], limits: &Limits) -> Result<Loaded, Error> {
    if bytes.len() as u64 > limits.max_bytes {
        let what = format!("{} bytes are more than the limit of {}", bytes.len(), limits.max_bytes);
        return Err(json::bad("file", what));
    }
    let files = Files::new(None, limits.max_bytes);
    net::catch(|| assemble(bytes, &files, limits))
}

fn assemble(bytes: &[u8], files: &Files, limits: &Limits) -> Result<Loaded, Error> {
    let mut warnings = Warnings::default();
    let parts = container::split(bytes)?;
    let file = container::parse(parts.json)?;
    let root = Object::root(&file)?;
    let extensions = extensions::check(&file, &root, &mut warnings)?;
    let views = Views::new(&root, container::buffers(&root, parts.binary, files)?)?;

    let nodes = nodes::load(&root, &mut warnings)?;
    let mut materials = materials::load(&root, &mut warnings)?;
    let meshes = meshes::load(&root, Checker::new(&root, &views)?, &mut materials, limits, &mut warnings)?;
    let placed = placed::load(&root, &nodes, &meshes, limits, &mut warnings)?;
    let textures = textures::load(&root, &views, files, &materials.needed_textures, limits, &mut warnings)?;
    if !root.list("animations")?.is_empty() {
        warnings.note("animations are ignored: the scene is drawn as it stands in the file", String::new);
    }
    let scene = Scene {
        meshes: meshes.meshes,
        instances: placed.instances,
        materials: materials.finish(&textures.index),
        textures: textures.textures,
        lights: placed.lights,
        environment: None,
        cameras: placed.cameras,
    };
    scene.validate()?;
    let summary = Summary::new(&root, extensions, &scene)?;
    Ok(Loaded { scene, warnings: warnings.into_lines(), summary })
}
