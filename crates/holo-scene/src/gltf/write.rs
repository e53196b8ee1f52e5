//! The writer of `.glb` files.

mod animation;
mod materials;

use std::collections::BTreeSet;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Map, Value, json};

use super::extensions::{self, LIGHTS};
use super::placements::ANGULAR_DIAMETER;
use crate::Error;
use crate::animation::{Animation, Target};
use crate::transform::{cross, normalize};
use crate::{Camera, CameraProjection, Filter, Light, LightKind, Mesh, Scene, Texture, Transform, Wrap};

/// The near plane of cameras, m, which glTF requires; the loader ignores it.
const NEAR_PLANE_M: f64 = 0.01;
const FAR_PLANE_M: f64 = 1e6;

/// Writes a scene as binary glTF 2.0.
///
/// The same scene gives the same bytes, and loading them gives the same scene. Instances, lights and cameras become
/// nodes; a node that is not only translated has a `matrix` (also for shear, although glTF requires matrices without).
/// Numbers keep all their digits; textures are PNG. Materials use the extensions that they need: a Lambertian surface
/// has a `specularFactor` of 0, so that other renderers agree; a body of glass has a `thicknessFactor` of 1, because
/// only whether it is above 0 matters; emission is split into a factor and a power of two. The angular diameter of a
/// directional light is written to `extras.angular_diameter_rad` of the light.
///
/// [`Scene::environment`] is not written, because glTF has no place for it.
///
/// # Accuracy
/// `load_slice(to_glb(scene))` gives an equal scene, except for the environment map and for what
/// [`Scene::add_tangents`] adds (a scene without normal maps, or a loaded one, has nothing to add). Light directions
/// and camera axes are bitwise equal if their squared lengths and products are within 1e-12 of the exact values;
/// otherwise they are normalized (a change below 2e-6).
///
/// # Errors
/// [`Error::BadScene`] for a scene that does not pass [`Scene::validate`], a mesh without triangles (which glTF does
/// not allow), or more than 4 GiB.
pub fn to_glb(scene: &Scene) -> Result<Vec<u8>, Error> {
    write(scene, None)
}

/// Writes a scene as [`to_glb`], with an animation of its instances and cameras. Loading the file without a time gives
/// the scene, of what moves within 1e-15 of its rotation; loading it at a time what moves in its place.
///
/// # Errors
/// As [`to_glb`]; [`Error::BadScene`] also for tracks without keys, with times that do not increase, of things that are
/// scaled, that the scene does not have or that another track moves.
pub fn to_glb_animated(scene: &Scene, animation: &Animation) -> Result<Vec<u8>, Error> {
    animation::validate(animation, scene)?;
    write(scene, Some(animation))
}

fn write(scene: &Scene, moving: Option<&Animation>) -> Result<Vec<u8>, Error> {
    scene.validate()?;
    let mut body = Body::default();
    let mut root = Map::new();
    // Without a version: datasets identify scenes by their digest.
    root.insert("asset".into(), json!({ "version": "2.0", "generator": "holo" }));

    let meshes =
        scene.meshes.iter().enumerate().map(|(k, mesh)| body.mesh(k, mesh)).collect::<Result<Vec<_>, Error>>()?;
    let images = scene.textures.iter().enumerate().map(|(k, t)| body.image(k, t)).collect::<Result<Vec<_>, Error>>()?;
    let mut samplers: Vec<Value> = Vec::new();
    let mut textures = Vec::new();
    for (source, texture) in scene.textures.iter().enumerate() {
        let sampler = sampler(texture);
        let number = samplers.iter().position(|known| *known == sampler).unwrap_or_else(|| {
            samplers.push(sampler);
            samplers.len() - 1
        });
        textures.push(named(&texture.name, json!({ "source": source, "sampler": number })));
    }
    let materials: Vec<Value> = scene.materials.iter().map(materials::material).collect();
    let mut used = BTreeSet::new();
    materials.iter().for_each(|material| extensions::find(material, &mut used));
    if !scene.lights.is_empty() {
        used.insert(LIGHTS.to_owned());
        let lights: Vec<Value> = scene.lights.iter().map(light).collect();
        root.insert("extensions".into(), json!({ LIGHTS: { "lights": lights } }));
    }
    let animations = moving.map(|moving| animation::animation(&mut body, moving, scene)).transpose()?;
    let nodes = nodes(scene, moving);
    let all_nodes: Vec<Value> = (0..nodes.len()).map(Value::from).collect();
    let mut shown = Map::new();
    insert(&mut shown, "nodes", all_nodes);
    root.insert("scene".into(), json!(0));
    let buffers = if body.bytes.is_empty() { Vec::new() } else { vec![json!({ "byteLength": body.bytes.len() })] };
    let lists = [
        ("extensionsUsed", used.into_iter().map(Value::from).collect()),
        ("scenes", vec![Value::Object(shown)]),
        ("nodes", nodes),
        ("meshes", meshes),
        ("materials", materials),
        ("textures", textures),
        ("images", images),
        ("samplers", samplers),
        ("cameras", scene.cameras.iter().map(camera).collect()),
        ("animations", animations.into_iter().collect()),
        ("accessors", std::mem::take(&mut body.accessors)),
        ("bufferViews", std::mem::take(&mut body.buffer_views)),
        ("buffers", buffers),
    ];
    for (key, list) in lists {
        insert(&mut root, key, list);
    }
    container(&Value::Object(root), &body.bytes)
}

/// glTF forbids empty lists.
fn insert(object: &mut Map<String, Value>, key: &str, list: Vec<Value>) {
    if !list.is_empty() {
        object.insert(key.into(), Value::Array(list));
    }
}

fn named(name: &str, mut value: Value) -> Value {
    if let (false, Value::Object(map)) = (name.is_empty(), &mut value) {
        map.insert("name".into(), name.into());
    }
    value
}

fn bad(at: String, what: impl Into<String>) -> Error {
    Error::BadScene { at, what: what.into() }
}

fn container(root: &Value, binary: &[u8]) -> Result<Vec<u8>, Error> {
    let mut text = serde_json::to_vec(root).map_err(|e| bad("glb".into(), format!("cannot be written: {e}")))?;
    text.resize(text.len().next_multiple_of(4), b' ');
    // The binary chunk is padded to a multiple of four bytes already, see `Body::view`.
    let binary_chunk = if binary.is_empty() { 0 } else { 8 + binary.len() };
    let total = u32::try_from(12 + 8 + text.len() + binary_chunk).map_err(|_| too_large())?;
    let mut bytes = Vec::with_capacity(total as usize);
    bytes.extend_from_slice(b"glTF");
    bytes.extend_from_slice(&2_u32.to_le_bytes());
    bytes.extend_from_slice(&total.to_le_bytes());
    for (kind, chunk) in [(b"JSON", text.as_slice()), (b"BIN\0", binary)] {
        if !chunk.is_empty() {
            // Fits, because the total does.
            bytes.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
            bytes.extend_from_slice(kind);
            bytes.extend_from_slice(chunk);
        }
    }
    Ok(bytes)
}

fn too_large() -> Error {
    bad("glb".into(), "the scene needs more than the 4 GiB that a .glb file can hold; split it")
}

/// The binary chunk with its buffer views and accessors.
#[derive(Default)]
struct Body {
    bytes: Vec<u8>,
    buffer_views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Body {
    fn mesh(&mut self, k: usize, mesh: &Mesh) -> Result<Value, Error> {
        if mesh.triangles.is_empty() {
            return Err(bad(format!("meshes[{k}]"), "has no triangles, which glTF cannot hold: remove it"));
        }
        let mut attributes = Map::new();
        let positions = self.floats(&mesh.positions, "VEC3")?;
        if let Some(Value::Object(accessor)) = self.accessors.last_mut() {
            let corner = |pick: fn(f32, f32) -> f32| -> Vec<f64> {
                let start = mesh.positions.first().copied().unwrap_or_default();
                let corner = mesh.positions.iter().fold(start, |c, p| std::array::from_fn(|k| pick(c[k], p[k])));
                corner.map(f64::from).to_vec()
            };
            accessor.insert("min".into(), corner(f32::min).into());
            accessor.insert("max".into(), corner(f32::max).into());
        }
        attributes.insert("POSITION".into(), positions);
        if !mesh.normals.is_empty() {
            attributes.insert("NORMAL".into(), self.floats(&mesh.normals, "VEC3")?);
        }
        if !mesh.tangents.is_empty() {
            attributes.insert("TANGENT".into(), self.floats(&mesh.tangents, "VEC4")?);
        }
        for (key, set) in [("TEXCOORD_0", &mesh.texture_coordinates), ("TEXCOORD_1", &mesh.second_texture_coordinates)]
        {
            if !set.is_empty() {
                attributes.insert(key.into(), self.floats(set, "VEC2")?);
            }
        }
        if !mesh.colors.is_empty() {
            attributes.insert("COLOR_0".into(), self.floats(&mesh.colors, "VEC4")?);
        }
        let bytes = mesh.triangles.as_flattened().iter().flat_map(|index| index.to_le_bytes());
        let count = mesh.triangles.len() * 3;
        let view = self.view(bytes, count * 4, Some(34963))?;
        let indices =
            self.accessor(json!({ "bufferView": view, "componentType": 5125, "count": count, "type": "SCALAR" }));
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": mesh.material });
        Ok(named(&mesh.name, json!({ "primitives": [primitive] })))
    }

    fn floats<const N: usize>(&mut self, elements: &[[f32; N]], shape: &str) -> Result<Value, Error> {
        let bytes = elements.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        let view = self.view(bytes, elements.len() * N * 4, Some(34962))?;
        Ok(self.accessor(json!({ "bufferView": view, "componentType": 5126, "count": elements.len(), "type": shape })))
    }

    fn accessor(&mut self, accessor: Value) -> Value {
        self.accessors.push(accessor);
        (self.accessors.len() - 1).into()
    }

    /// Appends bytes and zeros for the alignment of the next ones.
    fn view(&mut self, bytes: impl Iterator<Item = u8>, length: usize, target: Option<u32>) -> Result<usize, Error> {
        let offset = self.bytes.len();
        let end = offset.checked_add(length).filter(|&end| end < u32::MAX as usize - 3).ok_or_else(too_large)?;
        self.bytes.try_reserve(end.next_multiple_of(4) - offset).map_err(|_| too_large())?;
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
        if let (Some(target), Value::Object(map)) = (target, &mut view) {
            map.insert("target".into(), target.into());
        }
        self.buffer_views.push(view);
        Ok(self.buffer_views.len() - 1)
    }

    fn image(&mut self, k: usize, texture: &Texture) -> Result<Value, Error> {
        let fail = |what: String| bad(format!("textures[{k}]"), format!("cannot be written as PNG: {what}"));
        let width = u32::try_from(texture.width).map_err(|_| fail("too wide".into()))?;
        let height = u32::try_from(texture.height).map_err(|_| fail("too high".into()))?;
        let mut png = Vec::new();
        PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Adaptive)
            .write_image(texture.texels.as_flattened(), width, height, ExtendedColorType::Rgba8)
            .map_err(|e| fail(e.to_string()))?;
        let length = png.len();
        let view = self.view(png.into_iter(), length, None)?;
        Ok(json!({ "bufferView": view, "mimeType": "image/png" }))
    }
}

fn sampler(texture: &Texture) -> Value {
    let code = |wrap: Wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::Clamp => 33071,
        Wrap::Mirror => 33648,
    };
    // Without mipmaps, as the renderer samples textures.
    let filter = match texture.filter {
        Filter::Linear => 9729,
        Filter::Nearest => 9728,
    };
    json!({ "magFilter": filter, "minFilter": filter, "wrapS": code(texture.wrap_u), "wrapT": code(texture.wrap_v) })
}

fn camera(camera: &Camera) -> Value {
    match camera.projection {
        CameraProjection::Perspective { vertical_angle_rad, aspect_ratio } => {
            let mut projection = json!({ "yfov": vertical_angle_rad, "znear": NEAR_PLANE_M });
            if let (Some(ratio), Value::Object(map)) = (aspect_ratio, &mut projection) {
                map.insert("aspectRatio".into(), ratio.into());
            }
            json!({ "type": "perspective", "perspective": projection })
        }
        CameraProjection::Orthographic { half_width_m, half_height_m } => {
            let projection = json!({ "xmag": half_width_m, "ymag": half_height_m, "znear": 0.0, "zfar": FAR_PLANE_M });
            json!({ "type": "orthographic", "orthographic": projection })
        }
    }
}

fn light(light: &Light) -> Value {
    let (kind, range) = match light.kind {
        LightKind::Directional { .. } => ("directional", None),
        LightKind::Point { range, .. } => ("point", range),
        LightKind::Spot { range, .. } => ("spot", range),
    };
    let (color, factor) = split_intensity(light.intensity);
    let mut value = json!({ "type": kind, "color": color, "intensity": factor });
    if let Value::Object(map) = &mut value {
        if let Some(range) = range {
            map.insert("range".into(), range.into());
        }
        if let LightKind::Spot { inner_angle_rad, outer_angle_rad, .. } = light.kind {
            map.insert("spot".into(), json!({ "innerConeAngle": inner_angle_rad, "outerConeAngle": outer_angle_rad }));
        }
        if let LightKind::Directional { angular_diameter_rad, .. } = light.kind
            && angular_diameter_rad != 0.0
        {
            map.insert("extras".into(), json!({ ANGULAR_DIAMETER: angular_diameter_rad }));
        }
    }
    named(&light.name, value)
}

/// Splits an intensity into a color within 0..1, as required by glTF, and a factor, so that their product is exact.
fn split_intensity(intensity: [f64; 3]) -> ([f64; 3], f64) {
    let largest = intensity.iter().fold(0.0_f64, |largest, &c| largest.max(c));
    // The largest channel is preferred; powers of two divide without rounding.
    let mut power = 1.0_f64;
    while power < largest && power < f64::MAX / 2.0 {
        power *= 2.0;
    }
    for factor in [largest, power] {
        let color = intensity.map(|c| c / factor);
        if color.iter().zip(intensity).all(|(color, c)| *color <= 1.0 && color * factor == c) {
            return (color, factor);
        }
    }
    (intensity, 1.0)
}

fn nodes(scene: &Scene, moving: Option<&Animation>) -> Vec<Value> {
    let moves = |target: Target| moving.is_some_and(|moving| moving.tracks.iter().any(|track| track.target == target));
    let place = |node: Value, transform: &Transform, target: Target| {
        if moves(target) { with_parts(node, transform) } else { with_transform(node, transform) }
    };
    let instances = scene.instances.iter().enumerate().map(|(k, instance)| {
        let node = named(&instance.name, json!({ "mesh": instance.mesh }));
        place(node, &instance.transform, Target::Instance(k))
    });
    let lights = scene.lights.iter().enumerate().map(|(k, light)| {
        let node = json!({ "extensions": { LIGHTS: { "light": k } } });
        with_transform(node, &light_frame(&light.kind))
    });
    let cameras = scene.cameras.iter().enumerate().map(|(k, camera)| {
        let node = named(&camera.name, json!({ "camera": k }));
        place(node, &camera.pose, Target::Camera(k))
    });
    instances.chain(lights).chain(cameras).collect()
}

/// Adds the transform to a node, in the shortest exact form.
fn with_transform(mut node: Value, transform: &Transform) -> Value {
    let Value::Object(map) = &mut node else { return node };
    if transform.columns != Transform::IDENTITY.columns {
        let [x, y, z] = transform.columns;
        let columns = [(x, 0.0), (y, 0.0), (z, 0.0), (transform.translation, 1.0)];
        let matrix: Vec<f64> =
            columns.iter().flat_map(|(column, last)| [column[0], column[1], column[2], *last]).collect();
        map.insert("matrix".into(), matrix.into());
    } else if transform.translation != [0.0; 3] {
        map.insert("translation".into(), json!(transform.translation));
    }
    node
}

/// Adds a pose as translation and rotation: glTF forbids a matrix for what an animation moves.
fn with_parts(mut node: Value, pose: &Transform) -> Value {
    let Value::Object(map) = &mut node else { return node };
    let [x, y, z] = pose.columns.map(glam::DVec3::from);
    let rotation = glam::DQuat::from_mat3(&glam::DMat3::from_cols(x, y, z)).normalize();
    map.insert("translation".into(), json!(pose.translation));
    map.insert("rotation".into(), json!(rotation.to_array()));
    node
}

/// A frame whose -Z is exactly the direction of the light.
fn light_frame(kind: &LightKind) -> Transform {
    let (translation, direction) = match *kind {
        LightKind::Directional { direction, .. } => ([0.0; 3], direction),
        LightKind::Point { position, .. } => return Transform::from_translation(position),
        LightKind::Spot { position, direction, .. } => (position, direction),
    };
    let z = direction.map(|x| -x);
    if z == [0.0, 0.0, 1.0] {
        return Transform::from_translation(translation);
    }
    // Any axis across is valid; one different from the largest component is never nearly parallel.
    let largest = (0..3).fold(0, |best, k| if z[k].abs() > z[best].abs() { k } else { best });
    let mut across = [0.0; 3];
    across[(largest + 1) % 3] = 1.0;
    let x = normalize(cross(across, z));
    Transform { columns: [x, cross(z, x), z], translation }
}
