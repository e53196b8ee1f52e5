//! The watertight ray-triangle test of the BVH engine.
//!
//! Source: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2 (2013). The ray is sheared so that it
//! runs along +Z. Two triangles that share an edge then compute the same edge function with opposite signs, so no ray
//! passes between them. Edge functions that are zero in f32 are recomputed in f64, where the products are exact.

/// A ray prepared for the test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    origin: [f32; 3],
    /// The axis of the largest component of the direction, which is permuted to Z.
    longest: usize,
    shear: [f32; 3],
}

/// The intersection of a ray with a triangle: the ray parameter `t` and the barycentrics `u` and `v` of the second and
/// third corner.
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
        let (x, y, z) = (direction[(longest + 1) % 3], direction[(longest + 2) % 3], direction[longest]);
        Self { origin, longest, shear: [x / z, y / z, 1.0 / z] }
    }

    /// The intersection of the line of the ray with the triangle, from either side. The barycentrics are accurate; the
    /// ray parameter on a sliver triangle is not, so the caller recomputes it.
    #[inline(always)]
    pub fn intersect(&self, corners: &[[f32; 3]; 3]) -> Option<TriangleHit> {
        // Three copies with constant indices: run-time indices would go through memory for every corner.
        match self.longest {
            0 => self.intersect_along::<1, 2, 0>(corners),
            1 => self.intersect_along::<2, 0, 1>(corners),
            _ => self.intersect_along::<0, 1, 2>(corners),
        }
    }

    #[inline(always)]
    fn intersect_along<const X: usize, const Y: usize, const Z: usize>(
        &self,
        corners: &[[f32; 3]; 3],
    ) -> Option<TriangleHit> {
        let (o, [sx, sy, sz]) = (&self.origin, self.shear);
        let relative = |p: &[f32; 3]| [p[X] - o[X], p[Y] - o[Y], p[Z] - o[Z]];
        let (pa, pb, pc) = (relative(&corners[0]), relative(&corners[1]), relative(&corners[2]));
        let sheared = |p: [f32; 3]| [p[0] - sx * p[2], p[1] - sy * p[2]];
        let (a, b, c) = (sheared(pa), sheared(pb), sheared(pc));
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
        let scaled = sz * (u * pa[2] + v * pb[2] + w * pc[2]);
        let inverse = 1.0 / determinant;
        Some(TriangleHit { t: scaled * inverse, u: v * inverse, v: w * inverse })
    }
}
