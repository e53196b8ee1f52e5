//! glTF 2.0: `.glb`, and `.gltf` with external files or data URIs.
//!
//! # Geometry
//! The loader reads the node hierarchy of the default scene, composed in f64; triangles, strips and fans,
//! indexed or not, with normals, tangents, vertex colors and two sets of texture coordinates (`TEXCOORD_0` and `_1`; if
//! the textures of a material use other sets, those); sparse and normalized accessors; cameras; and the lights of
//! `KHR_lights_punctual`. Instances, lights and cameras are in the order of their nodes in the file. Tangents are read
//! only for materials that use them (normal maps, anisotropy); where a smooth mesh has none, those of MikkTSpace are
//! computed ([`Scene::add_tangents`]).
//!
//! `EXT_mesh_gpu_instancing` gives an instance for every element of its accessors; `KHR_node_visibility` hides meshes
//! and lights, not cameras. A scene may list a node that is the child of another: it is drawn once, as that child.
//!
//! # Pose
//! The scene is drawn in the pose of its nodes, or as its animations have it at a time ([`LoadOptions::time_s`]): nodes,
//! weights of morph targets, and with `KHR_animation_pointer` other numbers of the file. All animations are played
//! together, or one by its name. Before its first key and after its last one a property keeps that value; values between
//! keys are interpolated in f64: steps, linearly (rotations spherically) or cubic splines.
//!
//! Morph targets move positions, normals and tangents by the weights of the node, else of the mesh. A skin places
//! vertices by all sets of joints and weights; the transform of the node has no effect then, as the specification
//! demands. Nodes with a skin or weights of their own have meshes of their own, which count against [`Limits`], as does
//! every pass of a morph target.
//!
//! # Compressed and quantized geometry
//! - `KHR_mesh_quantization`: positions, normals and texture coordinates of 8 or 16 bits. Integers become floats by the
//!   equations of the extension, correctly rounded.
//! - `EXT_meshopt_compression` and `KHR_meshopt_compression`: all modes and filters. Decoding is exact but for the
//!   filters OCTAHEDRAL, QUATERNION and COLOR, which are within one unit of their integers, as the extension allows.
//!   Uncompressed copies in the file (fallback buffers) are not read.
//! - `KHR_draco_mesh_compression`, with the feature `draco`: bit stream 2.2, sequential and Edgebreaker. The Draco data
//!   must have as many vertices and triangles as the accessors say. Attributes that it does not contain are read from
//!   their accessors. Without the feature, the accessors are used if they have data.
//!
//! Geometry that a program has quantized stays so: only the file knows the positions before.
//!
//! # Materials
//! Materials are read completely, with the defaults of the specification (the default material is a rough white metal;
//! a dielectric without `KHR_materials_specular` has the reflection of index 1.5): metallic-roughness, normal maps,
//! emission, alpha, `doubleSided`, and the extensions `KHR_materials_emissive_strength`, `_ior`, `_specular`,
//! `_transmission`, `_unlit`, `_volume`, `_clearcoat`, `_sheen`, `_anisotropy`, `_iridescence`, `_dispersion`,
//! `_diffuse_transmission` and `KHR_texture_transform`. Occlusion textures are ignored without a warning,
//! because renderers compute occlusion. Of the thickness of a volume only matters whether it is above 0 (0: a thin
//! pane); attenuation distances are in world units. An index of refraction of 0, which means infinity in the
//! specification, becomes 1000 (99.6 % reflectance at normal incidence), with a warning. Black attenuation is clamped
//! slightly above 0.
//!
//! `KHR_materials_pbrSpecularGlossiness` becomes a dielectric with the same reflectance at normal incidence and the
//! same roughness; its diffuse part is dimmed by what the renderer's coat reflects instead of by the largest channel of
//! the specular color. [`LoadOptions::material_variant`] chooses a variant of `KHR_materials_variants`.
//!
//! # Textures
//! PNG, JPEG and WebP (also `EXT_texture_webp`), with wrap modes and the filter for magnification; 16-bit images are
//! rounded to 8. KTX2 images (`KHR_texture_basisu`) are not decoded: the fallback image is used. A texture without a
//! readable image is left out with a warning that says why.
//!
//! # Lights
//! A directional light whose `extras` contain the number `angular_diameter_rad` is a disc of that angular diameter,
//! rad: 0.0093 for the sun. Without it, its light is parallel. This is an addition of this crate. [`LightUnits`] is
//! about files of Blender.
//!
//! # Not supported
//! Other extensions (volume scattering, ...) cause a warning if they are used, and an error if they are
//! required. Files of other formats (OBJ, FBX, USD, Blender, glTF 1.0, ...) are errors that say how to get a `.glb`
//! from them.
//!
//! # Untrusted files
//! A file is either loaded or rejected with an [`Error`] that says where. All sizes are checked against [`Limits`]
//! before memory is allocated, files are read only below the folder of the scene file, and all values are validated
//! before they reach another crate. Should a decoder panic all the same, the panic is caught and becomes an error; a
//! program whose panic hook prints should check [`is_guarding`] first.

mod accessors;
mod advice;
mod animation;
mod buffer_views;
mod container;
mod deform;
mod draco;
mod extensions;
mod foreign;
mod handle;
mod instancing;
mod json;
mod materials;
mod meshes;
mod meshopt;
mod nodes;
mod options;
pub(crate) mod panic_guard;
mod placements;
mod poses;
mod skins;
mod summary;
mod textures;
mod uri;
mod values;
mod variants;
mod warnings;
mod write;

use std::path::Path;

use self::accessors::Checker;
use self::buffer_views::BufferViews;
use self::container::Files;
use self::json::Object;
use self::placements::Shown;
use self::warnings::Warnings;
use crate::Error;
use crate::Scene;

pub use self::animation::AnimationSummary;
pub use self::options::{LightUnits, LoadOptions};
pub use self::panic_guard::is_guarding;
pub use self::summary::Summary;
pub use self::write::{to_glb, to_glb_animated};

/// A loaded scene with warnings and a summary of its file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Loaded {
    /// The scene; it passes [`Scene::validate`].
    pub scene: Scene,
    /// What was ignored or changed during loading, one line per kind of warning.
    pub warnings: Vec<String>,
    /// Counts and names of the contents of the file.
    pub summary: Summary,
}

impl From<Scene> for Loaded {
    /// A scene that was not read from a file.
    fn from(scene: Scene) -> Self {
        Self { scene, warnings: Vec::new(), summary: Summary::default() }
    }
}

/// Limits of the size of a file. All are checked before memory is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Triangles of all meshes together, and triangles of all instances together.
    pub max_triangles: u64,
    /// Vertices of all meshes together. Those of a morph target and of a set of joints count as others.
    pub max_vertices: u64,
    /// Instances of meshes in the world.
    pub max_instances: usize,
    /// Pixels of all textures together.
    pub max_texture_pixels: u64,
    /// Bytes of the scene file and all files that it refers to together; and, counted separately, of all compressed
    /// buffer views together when they are decompressed.
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

/// Loads a scene file, `.glb` or `.gltf`; the format is detected by content.
///
/// # Errors
/// [`Error::Read`] for files that cannot be read, [`Error::BadFile`] for files that violate the rules of glTF or exceed
/// `limits`, [`Error::Unsupported`] for required features that are not supported.
pub fn load(path: &Path, limits: &Limits) -> Result<Loaded, Error> {
    load_with(path, &LoadOptions { limits: *limits, ..LoadOptions::default() })
}

/// Loads a scene file as [`load`], with options.
///
/// # Errors
/// As [`load`]; also a material variant or an animation that the file does not have, or a time that is not finite.
pub fn load_with(path: &Path, options: &LoadOptions) -> Result<Loaded, Error> {
    let files = Files::new(path.parent(), options.limits.max_bytes);
    let bytes = files.read(path)?;
    panic_guard::catch("glTF", || assemble(&bytes, &files, options))
}

/// Loads a scene from memory: `.glb`, or `.gltf` JSON whose buffers and images are data URIs.
///
/// # Errors
/// As [`load`]; also a file whose buffers are other files.
pub fn load_slice(bytes: &[u8], limits: &Limits) -> Result<Loaded, Error> {
    load_slice_with(bytes, &LoadOptions { limits: *limits, ..LoadOptions::default() })
}

/// Loads a scene from memory as [`load_slice`], with options.
///
/// # Errors
/// As [`load_slice`]; also a material variant or an animation that the file does not have, or a time that is not finite.
pub fn load_slice_with(bytes: &[u8], options: &LoadOptions) -> Result<Loaded, Error> {
    let most = options.limits.max_bytes;
    if bytes.len() as u64 > most {
        return Err(json::bad("file", format!("{} bytes are more than the limit of {most}", bytes.len())));
    }
    let files = Files::new(None, most);
    panic_guard::catch("glTF", || assemble(bytes, &files, options))
}

fn assemble(bytes: &[u8], files: &Files, options: &LoadOptions) -> Result<Loaded, Error> {
    let limits = &options.limits;
    let mut warnings = Warnings::default();
    let parts = container::split(bytes)?;
    let file = container::parse(parts.json)?;
    let root = Object::root(&file)?;
    let extensions = extensions::check(&file, &root, &mut warnings)?;
    let buffers = container::buffers(&root, parts.binary, files)?;
    let buffer_views = BufferViews::new(&root, buffers, limits.max_bytes)?;
    let posed = animation::at(&file, &root, &buffer_views, options, &mut warnings)?;
    let root = posed.as_ref().map_or(Ok(root), Object::root)?;
    let variants = variants::names(&root)?;
    let variant = variants::choose(&variants, options.material_variant.as_deref())?;

    let nodes = nodes::load(&root, &mut warnings)?;
    let poses = poses::collect(&root, &nodes)?;
    let mut materials = materials::load(&root, &mut warnings)?;
    let mut accessors = Checker::new(&root, &buffer_views)?;
    let context = meshes::Context { poses: &poses, limits, variant };
    let meshes = meshes::plan_all(&root, &mut accessors, &mut materials, &context, &mut warnings)?;
    let skins = skins::plan(&root, &poses, &mut accessors)?;
    let instancing = instancing::plan(&nodes, &mut accessors, limits, &mut warnings)?;
    let values = values::Values::of(accessors);
    let skins = skins::load(skins, &values, &nodes)?;
    let meshes = meshes.read(&values, &skins, &mut warnings)?;
    let shown = Shown { meshes: &meshes, of_node: &poses.of_node, skins: &skins, instancing: &instancing };
    let placements = placements::load(&root, &nodes, &shown, (&values, limits), &mut warnings)?;
    let textures = textures::load(
        &root,
        (&buffer_views, files),
        &materials.needed_textures,
        &materials.derived_textures,
        limits,
        &mut warnings,
    )?;
    let mut scene = Scene {
        meshes: meshes.meshes,
        instances: placements.instances,
        materials: materials.finish(&textures.index),
        textures: textures.textures,
        lights: placements.lights,
        environment: None,
        cameras: placements.cameras,
    };
    let light_units = advice::apply(&root, &mut scene, options, &mut warnings)?;
    // It validates the scene.
    scene.add_tangents()?;
    let summary = Summary { light_units, ..Summary::new(&root, extensions, variants, &scene)? };
    Ok(Loaded { scene, warnings: warnings.into_lines(), summary })
}
