//! The scene: meshes, instances, textures, lights, an environment map and cameras.
//!
//! Nothing is checked while a [`Scene`] is built. [`Scene::validate`] checks everything at once; the renderer and the
//! glTF writer call it first.

pub(crate) mod coincident;
pub(crate) mod light_sources;
pub(crate) mod tangents;
pub(crate) mod validate;

use crate::{Material, Transform};

/// A whole scene in world coordinates (right-handed, +Y up, meters).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Meshes in mesh coordinates; visible only where an [`Instance`] places them.
    pub meshes: Vec<Mesh>,
    /// Instances: placements of meshes in the world.
    pub instances: Vec<Instance>,
    /// Materials, referred to by [`Mesh::material`].
    pub materials: Vec<Material>,
    /// Textures, referred to by [`TextureInfo::texture`](crate::TextureInfo::texture).
    pub textures: Vec<Texture>,
    /// Punctual lights in world coordinates.
    pub lights: Vec<Light>,
    /// The environment map. The renderer adds a constant environment of its own.
    pub environment: Option<Environment>,
    /// Cameras, in the order of the file.
    pub cameras: Vec<Camera>,
}

/// A triangle mesh with one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// A name for messages.
    pub name: String,
    /// Vertex positions in mesh coordinates, m.
    pub positions: Vec<[f32; 3]>,
    /// One unit normal per vertex, or empty for flat shading.
    pub normals: Vec<[f32; 3]>,
    /// One tangent per vertex, or empty: x, y, z of unit length, and the sign w of the bitangent `cross(normal,
    /// tangent) * w`. They are the axes of normal maps and of anisotropy, interpolated; without them the axes are the
    /// directions on each triangle in which u and -v increase. [`Scene::add_tangents`] computes them. Ignored without
    /// normals.
    pub tangents: Vec<[f32; 4]>,
    /// One texture coordinate per vertex (set 0), or empty: textures are then sampled at (0, 0). (0, 0) is the upper
    /// left corner of the image, as in glTF.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// The second texture coordinate set ([`TextureInfo::set`](crate::TextureInfo::set) 1), likewise.
    pub second_texture_coordinates: Vec<[f32; 2]>,
    /// One linear RGBA factor per vertex, 0 to 1, which multiplies the base color; or empty.
    pub colors: Vec<[f32; 4]>,
    /// Vertex indices of the triangles, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// An instance: a mesh placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// A name for messages.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Mesh to world coordinates.
    pub transform: Transform,
}

/// A texture: an image with its wrap modes and filter. Colors are interpolated in linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// A name for messages.
    pub name: String,
    /// Width in texels.
    pub width: usize,
    /// Height in texels.
    pub height: usize,
    /// 8-bit RGBA codes, rows from the top, `width * height` of them. Whether the colors are sRGB or linear values
    /// depends on the use by a material; alpha is always linear.
    pub texels: Vec<[u8; 4]>,
    /// Horizontal wrap mode.
    pub wrap_u: Wrap,
    /// Vertical wrap mode.
    pub wrap_v: Wrap,
    /// How values between the centers of texels are found.
    pub filter: Filter,
}

/// An environment map: radiance from infinitely far away in equirectangular projection. The world direction (x, y, z)
/// lies at u = 1/2 + atan2(z, x) / (2 pi) of the width from the left and at v = acos(y) / pi of the height from the
/// top. Sampled bilinearly, periodic horizontally.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Linear RGB, shape (rows, columns, 3) with at least one row and column, 0 to
    /// [`MAX_RADIANCE`](crate::MAX_RADIANCE).
    pub radiance: ndarray::Array3<f32>,
}

/// The wrap mode of a texture: its values outside the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image is repeated.
    #[default]
    Repeat,
    /// The texels at the edge are extended.
    Clamp,
    /// The image is repeated, mirrored every other time.
    Mirror,
}

/// The filter of a texture: its values between the centers of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Interpolated bilinearly.
    #[default]
    Linear,
    /// The value of the nearest texel, as for pixel art.
    Nearest,
}

/// A punctual light (KHR_lights_punctual). A directional light may have an angular diameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// A name for messages.
    pub name: String,
    /// Linear RGB. Directional: irradiance on a surface that faces the light, lux. Point and spot: intensity, candela.
    /// A white Lambertian surface under 1 lux has a radiance of 1/pi; no other factor is applied.
    pub intensity: [f64; 3],
    /// The kind of the light, with its position and direction.
    pub kind: LightKind,
}

/// The kinds of punctual lights, in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Light from infinitely far away.
    Directional {
        /// The direction in which the light travels (unit length).
        direction: [f64; 3],
        /// The angular diameter of the light, rad: 0 for parallel light with hard shadows, 0.0093 for the sun. A light
        /// with an angular diameter is a disc that is visible to the camera and in mirrors.
        angular_diameter_rad: f64,
    },
    /// A point light, which shines equally in all directions.
    Point {
        /// Position, m.
        position: [f64; 3],
        /// The distance, m, beyond which there is no light; the falloff is that of KHR_lights_punctual. `None`:
        /// unlimited.
        range: Option<f64>,
    },
    /// A spot light, which shines into a cone.
    Spot {
        /// Position, m.
        position: [f64; 3],
        /// The axis of the cone, away from the light (unit length).
        direction: [f64; 3],
        /// As for a point light.
        range: Option<f64>,
        /// The angle from the axis up to which the light has its full intensity, rad.
        inner_angle_rad: f64,
        /// The angle from the axis from which on the intensity is 0, rad; at most pi/2.
        outer_angle_rad: f64,
    },
}

/// A camera. It looks along its -Z with +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The name of the camera (of its node, else of the camera object in a glTF file).
    pub name: String,
    /// Camera to world coordinates: a rotation and a translation.
    pub pose: Transform,
    /// The projection and the field of view.
    pub projection: CameraProjection,
}

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraProjection {
    /// Perspective projection (pinhole).
    Perspective {
        /// Full vertical angle of view, rad.
        vertical_angle_rad: f64,
        /// Width / height; `None`: that of the rendered image.
        aspect_ratio: Option<f64>,
    },
    /// Orthographic projection.
    Orthographic {
        /// Half of the visible width, m.
        half_width_m: f64,
        /// Half of the visible height, m.
        half_height_m: f64,
    },
}

impl Scene {
    /// The number of triangles of all instances.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().filter_map(|i| self.meshes.get(i.mesh)).map(|m| m.triangles.len()).sum()
    }

    /// The axis-aligned bounding box (lowest, highest corner) of all triangles in world coordinates, m; `None` for a
    /// scene without triangles.
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
