//! A builder for studio scenes: a room for indirect light, softboxes, and a camera with a 50 mm lens.
//!
//! All light comes from emissive geometry and punctual lights, so that a scene can be written as .glb without loss.
//! Lamps and the room may be farther away than a meter.

use super::shapes;
use crate::{
    Camera, CameraProjection, Environment, Instance, Light, LightKind, Material, Mesh, Scene, Texture, Transform,
};

/// Half the height of a 36 mm x 24 mm sensor over the focal length: 12 mm / 50 mm.
const HALF_SLOPE: f64 = 0.24;

/// A scene under construction.
pub(crate) struct Studio(Scene);

impl Studio {
    pub fn new(textures: Vec<Texture>) -> Self {
        Self(Scene { textures, ..Scene::default() })
    }

    /// Adds a material; returns its index.
    pub fn material(&mut self, name: &str, material: Material) -> usize {
        self.0.materials.push(Material { name: name.into(), ..material });
        self.0.materials.len() - 1
    }

    /// Adds a texture; returns its index.
    pub fn texture(&mut self, texture: Texture) -> usize {
        self.0.textures.push(texture);
        self.0.textures.len() - 1
    }

    /// Adds a light.
    pub fn light(&mut self, light: Light) {
        self.0.lights.push(light);
    }

    /// Sets the environment.
    pub fn environment(&mut self, environment: Environment) {
        self.0.environment = Some(environment);
    }

    /// Adds a mesh with a single instance.
    pub fn add(&mut self, name: &str, mesh: Mesh, material: usize, transform: Transform) {
        let mesh = self.add_mesh(name, mesh, material);
        self.add_instance(name, mesh, transform);
    }

    /// Adds a mesh without instances, for [`Self::add_instance`]; returns its index.
    pub fn add_mesh(&mut self, name: &str, mesh: Mesh, material: usize) -> usize {
        self.0.meshes.push(Mesh { name: name.into(), material, ..mesh });
        self.0.meshes.len() - 1
    }

    pub fn add_instance(&mut self, name: &str, mesh: usize, transform: Transform) {
        self.0.instances.push(Instance { name: name.into(), mesh, transform });
    }

    /// Adds an emissive rectangle of width and height `size`, m, at `center` that faces `target`. `radiance` is linear
    /// RGB.
    pub fn softbox(&mut self, name: &str, center: [f64; 3], target: [f64; 3], size: [f64; 2], radiance: [f32; 3]) {
        let emissive = self.material(name, emissive(radiance));
        let up = if center[0] == target[0] && center[2] == target[2] { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
        let pose = Transform::look_at(center, target, up);
        let [right, up, back] = pose.columns;
        // A rectangle faces its +Z, a camera looks along its -Z.
        let columns = [right.map(|x| -x * size[0]), up.map(|x| x * size[1]), back.map(|x| -x)];
        self.add(name, rectangle(), emissive, Transform { columns, ..pose });
    }

    /// Adds a room of 2.6 m with emissive walls, which provides indirect light and is visible in reflections. The floor
    /// is darker.
    pub fn room(&mut self, radiance: [f32; 3]) {
        let half = 1.3;
        let middle = [0.0, 0.4, 0.0];
        let walls =
            [("left", 0, -1.0, 0.9), ("right", 0, 1.0, 0.9), ("floor", 1, -1.0, 0.35), ("ceiling", 1, 1.0, 1.1)];
        for (name, axis, side, share) in walls.into_iter().chain([("back", 2, -1.0, 0.8), ("front", 2, 1.0, 0.8)]) {
            let mut center = middle;
            center[axis] += side * half;
            let size = [2.0 * half; 2];
            self.softbox(&format!("room, {name}"), center, middle, size, radiance.map(|c| c * share));
        }
    }

    /// Adds a spot light with hard shadows. `intensity` in candela.
    pub fn spot(&mut self, name: &str, position: [f64; 3], target: [f64; 3], outer_deg: f64, intensity: [f64; 3]) {
        let [_, _, back] = Transform::look_at(position, target, [0.0, 1.0, 0.0]).columns;
        let outer_angle_rad = outer_deg.to_radians();
        let kind = LightKind::Spot {
            position,
            direction: back.map(|x| -x),
            range: None,
            inner_angle_rad: 0.6 * outer_angle_rad,
            outer_angle_rad,
        };
        self.0.lights.push(Light { name: name.into(), intensity, kind });
    }

    /// Adds a camera at `eye` that looks at `target`; returns the scene.
    pub fn with_camera(mut self, eye: [f64; 3], target: [f64; 3]) -> Scene {
        let pose = Transform::look_at(eye, target, [0.0, 1.0, 0.0]);
        let projection =
            CameraProjection::Perspective { vertical_angle_rad: 2.0 * HALF_SLOPE.atan(), aspect_ratio: Some(1.5) };
        self.0.cameras.push(Camera { name: "main".into(), pose, projection });
        self.0
    }
}

/// A black material with one-sided emission.
fn emissive(radiance: [f32; 3]) -> Material {
    Material { base_color: [0.0, 0.0, 0.0, 1.0], emission: radiance, double_sided: false, ..Material::default() }
}

/// The unit square around the origin that faces +Z.
pub(crate) fn rectangle() -> Mesh {
    shapes::sheet(1, 1, |s, t| glam::DVec3::new(s - 0.5, 0.5 - t, 0.0))
}

/// A translation.
pub(crate) fn at(x: f64, y: f64, z: f64) -> Transform {
    Transform::from_translation([x, y, z])
}

/// A rotation about an axis through the origin, after a uniform scale and before a translation.
pub(crate) fn turned(translation: [f64; 3], axis: [f64; 3], degrees: f64, scale: f64) -> Transform {
    let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
    let [x, y, z] = glam::DVec3::from(axis).normalize().to_array().map(|c| c * sin);
    Transform::from_parts(translation, [x, y, z, cos], [scale; 3])
}

/// A rotation about the vertical axis.
pub(crate) fn upright(translation: [f64; 3], degrees: f64) -> Transform {
    turned(translation, [0.0, 1.0, 0.0], degrees, 1.0)
}
