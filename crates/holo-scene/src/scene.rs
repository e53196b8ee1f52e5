//! What a renderer needs to know of the world: meshes, materials, textures, lights, cameras.
//!
//! A [`Scene`] is plain data in world coordinates (right-handed, +Y up, meters): build it in code, or load it from glTF
//! with [`crate::gltf`]. Nothing here is checked while it is being filled; [`Scene::validate`] checks everything at once
//! and the renderer calls it first, so an index out of range or a NaN vertex is an error and never a panic.

use crate::{Material, Transform};

/// A whole scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Geometry in its own (mesh) coordinates; drawn only where an [`Instance`] places it.
    pub meshes: Vec<Mesh>,
    /// Placements of meshes in the world.
    pub instances: Vec<Instance>,
    /// Surface descriptions, referred to by [`Mesh::material`].
    pub materials: Vec<Material>,
    /// Images, referred to by [`TextureUse::texture`](crate::TextureUse::texture).
    pub textures: Vec<Texture>,
    /// Punctual lights, already in world coordinates.
    pub lights: Vec<Light>,
    /// What surrounds the scene, beside the constant sky of a request.
    pub environment: Option<Environment>,
    /// Cameras in the order in which they were found.
    pub cameras: Vec<Camera>,
}

/// Triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// A name for messages.
    pub name: String,
    /// Vertex positions in mesh coordinates, meters.
    pub positions: Vec<[f32; 3]>,
    /// One unit normal a vertex, or empty: then every triangle is flat.
    pub normals: Vec<[f32; 3]>,
    /// One texture coordinate a vertex, or empty: then textures are read at (0, 0). (0, 0) is the corner of the first
    /// (top left) texel, as in glTF.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// The second set ([`TextureUse::set`](crate::TextureUse::set) 1), likewise.
    pub second_coordinates: Vec<[f32; 2]>,
    /// One linear RGBA factor a vertex, multiplied into the base color, or empty.
    pub colors: Vec<[f32; 4]>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// A mesh placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// A name for messages.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Mesh to world coordinates.
    pub transform: Transform,
}

/// An image with its way of repeating. Looked up bilinearly, colors in linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// A name for messages.
    pub name: String,
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// 8-bit codes, rows from the top, `width * height` of them. Whether the colors are sRGB or plain numbers is up to
    /// what a material uses them for; alpha is always a plain number.
    pub texels: Vec<[u8; 4]>,
    /// How the image goes on left and right of itself.
    pub wrap_u: Wrap,
    /// How the image goes on above and below itself.
    pub wrap_v: Wrap,
}

/// Radiance from infinitely far away as an equirectangular map: the direction (x, y, z) of the world lies at
/// u = 1/2 + atan2(z, x) / (2 pi) of the width from the left and v = acos(y) / pi of the height from the top. Looked up
/// bilinearly, around horizontally.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Linear RGB, axes (row, column, channel), at least one row and column, finite and not negative.
    pub radiance: ndarray::Array3<f32>,
}

/// What lies beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// Its outermost texels.
    Clamp,
    /// The image mirrored.
    Mirror,
}

/// A light without extent.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// A name for messages.
    pub name: String,
    /// Linear RGB. Directional: irradiance on a surface that faces it, lux. Point and spot: intensity, candela.
    /// A white Lambertian surface under 1 lux has radiance 1/pi; no other factor is applied.
    pub intensity: [f64; 3],
    /// Where it is and where it shines.
    pub kind: LightKind,
}

/// The kinds of punctual lights, in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Light from far away that travels along `direction` (unit length).
    Directional {
        /// The way the light travels.
        direction: [f64; 3],
        /// Apparent diameter of its disc, rad: 0 for parallel light with hard shadows, 0.0093 for the sun. A disc is
        /// seen by the camera and in mirrors.
        angular_diameter_rad: f64,
    },
    /// Shines equally to all sides.
    Point {
        /// World coordinates, m.
        position: [f64; 3],
        /// Beyond this distance (m) it does not shine; the falloff towards it is that of KHR_lights_punctual.
        range: Option<f64>,
    },
    /// Shines into a cone.
    Spot {
        /// World coordinates, m.
        position: [f64; 3],
        /// The axis of the cone, away from the light (unit length).
        direction: [f64; 3],
        /// As for a point light.
        range: Option<f64>,
        /// Up to this angle from the axis the light is at its full intensity, rad.
        inner_angle_rad: f64,
        /// From this angle on it is zero, rad.
        outer_angle_rad: f64,
    },
}

/// A camera of the scene file. It looks along its -Z with +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Its name (of the camera node, else of the camera), for `--camera`.
    pub name: String,
    /// Camera to world coordinates: a rotation and a translation, scale removed.
    pub pose: Transform,
    /// What it sees.
    pub lens: CameraLens,
}

/// How a camera of the scene file maps the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraLens {
    /// A pinhole.
    Perspective {
        /// Full vertical angle of view, rad.
        vertical_angle_rad: f64,
        /// Width over height; the image's own where missing.
        aspect_ratio: Option<f64>,
    },
    /// Parallel rays; half the width and height of what it sees, m.
    Orthographic {
        /// Half width, m.
        half_width_m: f64,
        /// Half height, m.
        half_height_m: f64,
    },
}

impl Scene {
    /// Triangles in the world, every instance counted.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().filter_map(|i| self.meshes.get(i.mesh)).map(|m| m.triangles.len()).sum()
    }

    /// The smallest axis-parallel box (lowest, highest corner) around all triangles in world coordinates, meters;
    /// `None` for a scene without any.
    #[must_use]
    pub fn bounds(&self) -> Option<([f64; 3], [f64; 3])> {
        let mut bounds: Option<([f64; 3], [f64; 3])> = None;
        for instance in &self.instances {
            let Some(mesh) = self.meshes.get(instance.mesh) else { continue };
            let corners = mesh.triangles.iter().flatten().filter_map(|&k| mesh.positions.get(k as usize));
            for p in corners.map(|p| instance.transform.point(p.map(f64::from))) {
                let (low, high) = bounds.get_or_insert((p, p));
                for axis in 0..3 {
                    low[axis] = low[axis].min(p[axis]);
                    high[axis] = high[axis].max(p[axis]);
                }
            }
        }
        bounds
    }
}
