//! A mesh that is kept once and placed many times: one placement of it.
//!
//! Rays are turned into the coordinates of the mesh by the engine, in f32. What the rest of the renderer wants to know of
//! a hit (plane, normals, corners) is turned into camera coordinates here, in f64 where depth comes from.
//!
//! **Error of the engine.** Its map from camera to mesh coordinates is W = L^-1 in f32, with L the matrix and t the
//! translation of the placement. For a point x of the mesh, seen from a ray that starts at o, every step of
//! `W o - W t`, of the inversion and of the test against the triangle x errs by a few 2^-24 of `|W| (|o| + |t| + |L| |x|)`
//! (absolute values entry by entry). Back in camera coordinates that is multiplied by |L|: the largest entry of
//! `|L| |W| (|o| + |t| + |L| |x|)` over 2^-24 takes the place that the largest coordinate has for flattened triangles.
//! `|L| |W|` does not see how columns of L are scaled (Bauer, 1966; Skeel, 1979): stretched meshes lose nothing, sheared
//! ones do, and so do meshes far from their own origin. Where the loss is too large the placement is flattened.

use super::Plane;
use holo_scene::Transform;

/// The error bound of a placement over that of its flattened triangles must stay below this. Rotated and stretched
/// meshes around their own origin reach 2 to 9.
const LARGEST_LOSS: f64 = 16.0;

/// Mesh units are between 1e-6 and 1e6 m and placements stay within 1e10 m: products of four such numbers fit in f32.
const LARGEST_SCALE: f64 = 1e6;
const LARGEST_REACH: f64 = 1e10;

/// A placement of a mesh that is kept in its own coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    /// Mesh to camera coordinates.
    to_camera: Transform,
    /// The absolute value of the map's determinant.
    stretch: f64,
    /// The cofactor matrix, with its sign turned for maps that mirror: where unnormalised normals go.
    normal_columns: [[f64; 3]; 3],
    /// The same up to its length, for normals that are made unit length again.
    small_normal_columns: [[f32; 3]; 3],
    /// Which mesh of [`super::Geometry::prototypes`].
    pub prototype: u32,
    /// The error bound of the head of this file, in the place of [`super::Part::extent`].
    pub extent: f32,
}

impl Placed {
    /// The mesh with the corners `low` and `high` of its bounding box, placed by `to_camera`; `None` where a ray engine that
    /// works in mesh coordinates would see it much less exactly than its flattened triangles, or not at all.
    pub fn new(to_camera: &Transform, [low, high]: [[f64; 3]; 2], prototype: u32) -> Option<Self> {
        let columns = &to_camera.columns;
        let determinant = to_camera.determinant();
        let cofactors = to_camera.normal_columns();
        let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let usable = |v: &[f64; 3]| (1.0 / LARGEST_SCALE..=LARGEST_SCALE).contains(&length(v));
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
        // Written so that NaN fails.
        if !(bound <= LARGEST_LOSS * largest && bound <= LARGEST_REACH) {
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
        })
    }

    /// Mesh to camera coordinates as a ray engine takes it: columns, the translation last.
    pub fn matrix(&self) -> [f32; 12] {
        let [x, y, z] = self.to_camera.columns;
        let mut out = [0.0; 12];
        for (to, from) in out.iter_mut().zip([x, y, z, self.to_camera.translation].iter().flatten()) {
            *to = *from as f32;
        }
        out
    }

    /// A plane of the mesh in camera coordinates.
    ///
    /// With n' = s C n, C the cofactor matrix of L and s the sign of its determinant: n' . (L x + t) = |det L| n . x + n' . t;
    /// both sides are then divided by the length of n'.
    /// The sign keeps the front in front where the map mirrors.
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

    /// A vertex normal of the mesh in camera coordinates, unit length; zero stays zero.
    #[inline(always)]
    pub fn normal(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = &self.small_normal_columns;
        let n = [a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z];
        let squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        let inverse = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        [n[0] * inverse, n[1] * inverse, n[2] * inverse]
    }

    /// A vertex of the mesh in camera coordinates.
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
