//! The placement of a prototype: an affine map from mesh to camera coordinates.
//!
//! The engine transforms rays to mesh coordinates in f32. The data of a hit (plane, normals, corners) are transformed
//! to camera coordinates here; planes, which determine depth, in f64.
//!
//! # Error of the engine
//! The engine maps camera to mesh coordinates by W = L^-1 in f32, where L is the matrix and t the translation of the
//! placement. For a point x of the mesh and a ray that starts at o, every step of `W o - W t`, of the inversion, and of
//! the test against the triangle at x has an error of a few 2^-24 times `|W| (|o| + |t| + |L| |x|)` (absolute values
//! entry by entry). Transformed back to camera coordinates the error is multiplied by |L|. The largest entry of `|L|
//! |W| (|o| + |t| + |L| |x|)` therefore corresponds to the largest coordinate of flattened triangles.
//!
//! `|L| |W|` is invariant to the scaling of columns of L (Bauer, 1966; Skeel, 1979): stretched meshes lose no
//! precision, but sheared meshes and meshes far from their own origin do. If the loss is too large the instance is
//! flattened.

use super::Plane;
use holo_scene::Transform;

/// The maximum ratio of the error bound of a placement to that of its flattened triangles. Rotated and stretched meshes
/// around their own origin reach 2 to 9.
const MAX_PRECISION_LOSS: f64 = 16.0;

/// Mesh units must be between 1e-6 and 1e6 m, and placements within 1e10 m: products of four such numbers fit into f32.
const MAX_SCALE: f64 = 1e6;
const MAX_REACH_M: f64 = 1e10;

/// A placement of a prototype.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    /// Mesh to camera coordinates.
    to_camera: Transform,
    /// The absolute value of the determinant of the map.
    stretch: f64,
    /// The cofactor matrix, negated for mirroring maps: maps unnormalized normals.
    normal_columns: [[f64; 3]; 3],
    /// The cofactor matrix up to its scale, for normals that are normalized afterwards.
    small_normal_columns: [[f32; 3]; 3],
    /// Index into [`super::Geometry::prototypes`].
    pub prototype: u32,
    /// The error bound of the module documentation, equivalent to the largest coordinate of a flattened triangle.
    pub extent: f32,
    /// -1 for a mirroring map, otherwise 1.
    pub orientation: f32,
}

impl Placement {
    /// The placement by `to_camera` of a mesh with the corners `low` and `high` of its bounding box. `None` if a ray
    /// tracing engine that works in mesh coordinates would lose too much precision in comparison to flattened
    /// triangles.
    pub fn new(to_camera: &Transform, [low, high]: [[f64; 3]; 2], prototype: u32) -> Option<Self> {
        let columns = &to_camera.columns;
        let determinant = to_camera.determinant();
        let cofactors = to_camera.normal_columns();
        let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let usable = |v: &[f64; 3]| (1.0 / MAX_SCALE..=MAX_SCALE).contains(&length(v));
        if !columns.iter().all(usable) || determinant == 0.0 {
            return None;
        }
        // Per axis: the largest camera coordinate, |t|, and |L| |x|.
        let mut seen = [0.0f64; 3];
        for corner in 0..8 {
            let p = to_camera.point(std::array::from_fn(|k| if corner >> k & 1 == 1 { high[k] } else { low[k] }));
            seen = std::array::from_fn(|k| seen[k].max(p[k].abs()));
        }
        let terms: [f64; 3] = std::array::from_fn(|i| {
            let own: f64 = (0..3).map(|k| columns[k][i].abs() * low[k].abs().max(high[k].abs())).sum();
            seen[i] + to_camera.translation[i].abs() + own
        });
        let amplified = |i: usize, j: usize| {
            (0..3).map(|k| columns[k][i].abs() * cofactors[k][j].abs()).sum::<f64>() / determinant.abs()
        };
        let bound = (0..3).map(|i| (0..3).map(|j| amplified(i, j) * terms[j]).sum()).fold(0.0, f64::max);
        let largest = seen.iter().fold(0.0, |m: f64, x| m.max(*x));
        // NaN fails this comparison.
        if !(bound <= MAX_PRECISION_LOSS * largest && bound <= MAX_REACH_M) {
            return None;
        }
        let sign = determinant.signum();
        let normal_columns = cofactors.map(|c| c.map(|x| x * sign));
        let longest = normal_columns.iter().map(length).fold(0.0, f64::max);
        Some(Self {
            to_camera: *to_camera,
            stretch: determinant.abs(),
            normal_columns,
            small_normal_columns: normal_columns.map(|c| c.map(|x| (x / longest) as f32)),
            prototype,
            extent: bound as f32,
            orientation: sign as f32,
        })
    }

    /// Mesh to camera coordinates in the layout of ray tracing engines: columns, the translation last.
    pub fn matrix(&self) -> [f32; 12] {
        let [x, y, z] = self.to_camera.columns;
        let mut out = [0.0; 12];
        for (to, from) in out.iter_mut().zip([x, y, z, self.to_camera.translation].iter().flatten()) {
            *to = *from as f32;
        }
        out
    }

    /// Transforms a plane of the mesh to camera coordinates.
    ///
    /// With n' = s C n, where C is the cofactor matrix of L and s the sign of its determinant: n' . (L x + t) = |det L|
    /// n . x + n' . t. Both sides are then divided by the length of n'. The sign preserves the front side under
    /// mirroring maps.
    #[inline(always)]
    pub fn plane(&self, plane: &Plane) -> Plane {
        let [x, y, z] = plane.normal;
        let [a, b, c] = &self.normal_columns;
        let t = &self.to_camera.translation;
        let normal = [a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z];
        let offset = self.stretch * plane.offset + (normal[0] * t[0] + normal[1] * t[1] + normal[2] * t[2]);
        let squared = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
        let inverse = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        Plane { normal: [normal[0] * inverse, normal[1] * inverse, normal[2] * inverse], offset: offset * inverse }
    }

    /// Transforms a vertex normal of the mesh to camera coordinates, with unit length; zero stays zero.
    #[inline(always)]
    pub fn normal(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = &self.small_normal_columns;
        let n = [a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z];
        let squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        let inverse = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        [n[0] * inverse, n[1] * inverse, n[2] * inverse]
    }

    /// Transforms a vertex tangent of the mesh to camera coordinates, with unit length; zero stays zero.
    pub fn tangent(&self, [x, y, z, w]: [f32; 4]) -> [f32; 4] {
        let along = glam::DVec3::from(self.to_camera.vector([x, y, z].map(f64::from))).normalize_or_zero().as_vec3();
        [along.x, along.y, along.z, w * self.orientation]
    }

    /// Transforms a vertex of the mesh to camera coordinates.
    #[inline(always)]
    pub fn point(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = [f64::from(x), f64::from(y), f64::from(z)];
        let [a, b, c] = &self.to_camera.columns;
        let t = &self.to_camera.translation;
        [
            (a[0] * x + b[0] * y + c[0] * z + t[0]) as f32,
            (a[1] * x + b[1] * y + c[1] * z + t[1]) as f32,
            (a[2] * x + b[2] * y + c[2] * z + t[2]) as f32,
        ]
    }
}
