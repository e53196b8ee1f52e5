//! The watertight ray-triangle test of the BVH engine.
//!
//! Source: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2 (2013). The ray is sheared so that it
//! runs along +Z; two triangles that share an edge then compute the same edge function with opposite signs, so no ray
//! falls between them. Edge functions that come out as zero in f32 are recomputed in f64, where they are exact products.

/// A ray prepared for the test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    origin: [f32; 3],
    /// The order of the axes: the last is the one along which the direction is longest.
    axes: [usize; 3],
    shear: [f32; 3],
}

/// Where a ray meets a triangle: parameter and the weights of the second and third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TriangleHit {
    pub t: f32,
    pub u: f32,
    pub v: f32,
}

impl ShearedRay {
    #[inline]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let longest = (0..3).fold(0, |best, k| if direction[k].abs() > direction[best].abs() { k } else { best });
        let mut axes = [(longest + 1) % 3, (longest + 2) % 3, longest];
        if direction[longest] < 0.0 {
            axes.swap(0, 1);
        }
        let [x, y, z] = axes;
        let shear = [direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]];
        Self { origin, axes, shear }
    }

    /// The hit with `near < t < far`, if any; both sides of the triangle count.
    #[inline]
    pub fn intersect(&self, corners: &[[f32; 3]; 3], near: f32, far: f32) -> Option<TriangleHit> {
        let [kx, ky, kz] = self.axes;
        let [sx, sy, sz] = self.shear;
        let relative = corners.map(|c| [c[kx] - self.origin[kx], c[ky] - self.origin[ky], c[kz] - self.origin[kz]]);
        let [a, b, c] = relative.map(|p| [p[0] - sx * p[2], p[1] - sy * p[2]]);
        let edge = |p: [f32; 2], q: [f32; 2]| q[0] * p[1] - q[1] * p[0];
        let (mut u, mut v, mut w) = (edge(b, c), edge(c, a), edge(a, b));
        if u == 0.0 || v == 0.0 || w == 0.0 {
            let exact = |p: [f32; 2], q: [f32; 2]| {
                let [px, py, qx, qy] = [p[0], p[1], q[0], q[1]].map(f64::from);
                (qx * py - qy * px) as f32
            };
            (u, v, w) = (exact(b, c), exact(c, a), exact(a, b));
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let scaled = u * (sz * relative[0][2]) + v * (sz * relative[1][2]) + w * (sz * relative[2][2]);
        let inverse = 1.0 / determinant;
        let t = scaled * inverse;
        (t > near && t < far).then_some(TriangleHit { t, u: v * inverse, v: w * inverse })
    }
}
