//! Alpha and back faces: an engine that wraps another one and lets rays pass through surfaces according to the alpha of
//! their material, and camera rays through the backs of those that are not double-sided.
//!
//! A ray that passes a triangle is traced again from behind it. The other engines need no support for alpha, and scenes
//! without alpha do not use this wrapper. Surfaces that are closer to each other than 5e-7 of their distance count as
//! one.
//!
//! For [`holo_scene::Alpha::Blend`] the decision is random, by a hash of the ray, of a random number of its own that
//! depends on the seed, and of the triangle. Ground truth has a single ray per pixel, for which an opacity of at least one half is opaque,
//! as in the depth pass of Blender.

use std::sync::Arc;

use crate::accel::{CAMERA_RAY, Coherence, Engine, NO_TRIANGLE, RayHits, Rays};
use crate::geometry::Geometry;
use crate::material::Appearance;
use crate::sampling::hash;
use crate::simd::{LANES, Lanes};

/// The test of opacities between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AlphaTest {
    /// Stochastic: the ray is stopped with a probability equal to the opacity.
    Stochastic,
    /// Deterministic: the ray is stopped from an opacity of one half on.
    Threshold,
}

/// An engine with alpha testing.
pub(crate) struct AlphaTested {
    pub inner: Arc<dyn Engine>,
    pub geometry: Arc<Geometry>,
    pub appearance: Arc<Appearance>,
    pub test: AlphaTest,
    /// Whether camera rays pass the backs of surfaces that are not double-sided.
    pub cull: bool,
}

/// The maximum number of surfaces that a ray can pass.
const MAX_ALPHA_LAYERS: usize = 1 << 16;

impl AlphaTested {
    /// The valid lanes whose ray passes the triangle that it hit.
    fn passing(&self, valid: &Lanes<i32>, packet: &RayHits) -> Lanes<i32> {
        let mut passes = Lanes([0; LANES]);
        for lane in 0..LANES {
            let hit = packet.hit(lane);
            if valid.0[lane] == 0 || hit.triangle == NO_TRIANGLE {
                continue;
            }
            if self.cull && self.is_culled(packet, lane) {
                passes.0[lane] = -1;
                continue;
            }
            let barycentrics = [packet.hits.u[lane], packet.hits.v[lane]];
            let opacity = self.appearance.opacity(&self.geometry, hit, barycentrics);
            let threshold = match self.test {
                AlphaTest::Threshold => 0.5,
                // Above 0, so that an opacity of 0 stops no ray.
                AlphaTest::Stochastic if opacity < 1.0 => number(&packet.rays, lane, hit.triangle),
                AlphaTest::Stochastic => 0.5,
            };
            passes.0[lane] = -i32::from(opacity < threshold);
        }
        passes
    }
}

impl AlphaTested {
    /// Whether a camera ray hit the back of a surface that has only a front.
    fn is_culled(&self, packet: &RayHits, lane: usize) -> bool {
        if packet.rays.id[lane] & CAMERA_RAY == 0 || self.appearance.is_double_sided(&self.geometry, packet.hit(lane)) {
            return false;
        }
        let normal = self.geometry.plane(packet.hit(lane)).normal;
        (0..3).map(|axis| normal[axis] * f64::from(packet.rays.direction[axis][lane])).sum::<f64>() > 0.0
    }
}

impl Engine for AlphaTested {
    fn intersect(&self, valid: &Lanes<i32>, packet: &mut RayHits, coherence: Coherence) {
        let far = packet.rays.far;
        self.inner.intersect(valid, packet, coherence);
        let mut going = *valid;
        for _ in 0..MAX_ALPHA_LAYERS {
            going = self.passing(&going, packet);
            if going.0 == [0; LANES] {
                return;
            }
            for lane in (0..LANES).filter(|&lane| going.0[lane] != 0) {
                packet.rays.near[lane] = beyond(packet.rays.far[lane]);
                packet.rays.far[lane] = far[lane];
                packet.hits.triangle[lane] = NO_TRIANGLE;
                packet.hits.geometry[lane] = NO_TRIANGLE;
                packet.hits.instance[lane] = NO_TRIANGLE;
            }
            self.inner.intersect(&going, packet, coherence);
        }
    }

    fn occluded(&self, valid: &Lanes<i32>, rays: &mut Rays, coherence: Coherence) {
        let mut packet = RayHits { rays: *rays, ..RayHits::EMPTY };
        self.intersect(valid, &mut packet, coherence);
        for lane in 0..LANES {
            if valid.0[lane] != 0 && packet.hits.triangle[lane] != NO_TRIANGLE {
                rays.far[lane] = f32::NEG_INFINITY;
            }
        }
    }

    fn name(&self) -> &str {
        self.inner.name()
    }
}

/// A distance slightly larger than `distance`: by more than the rounding error of the engine.
fn beyond(distance: f32) -> f32 {
    (distance * (1.0 + 5e-7)).max(f32::MIN_POSITIVE)
}

/// A random number in (0, 1] for a ray, its random number [`Rays::id`], and a triangle.
fn number(rays: &Rays, lane: usize, triangle: u32) -> f32 {
    let mut state = hash(triangle.wrapping_mul(0x9E37_79B9) ^ rays.id[lane]);
    for axis in 0..3 {
        state = hash(state ^ rays.origin[axis][lane].to_bits());
        state = hash(state ^ rays.direction[axis][lane].to_bits());
    }
    ((state >> 8) + 1) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Backend, build};
    use crate::geometry::Instancing;
    use holo_scene::{Alpha, Instance, Material, Mesh, Scene, Transform};

    /// Ten squares behind each other at 1, 2, .. m, all but the last with `alpha`.
    fn stack(alpha: Alpha, share: f32) -> (Arc<Geometry>, Arc<Appearance>) {
        let paned = Material { base_color: [1.0, 1.0, 1.0, share], alpha, ..Material::default() };
        let mut scene = Scene { materials: vec![paned, Material::default()], ..Scene::default() };
        for k in 0..10 {
            let z = -1.0 - k as f32;
            scene.meshes.push(Mesh {
                positions: vec![[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                material: usize::from(k == 9),
                ..Mesh::default()
            });
            scene.instances.push(Instance { name: String::new(), mesh: k, transform: Transform::IDENTITY });
        }
        let geometry = Geometry::build(&scene, &Transform::IDENTITY, Instancing::Never).unwrap();
        (Arc::new(geometry), Arc::new(Appearance::new(&scene.materials, &scene.textures)))
    }

    /// The depths of 4096 rays.
    fn depths(alpha: Alpha, share: f32, test: AlphaTest) -> Vec<f32> {
        let (geometry, appearance) = stack(alpha, share);
        let inner: Arc<dyn Engine> = Arc::from(build(Backend::Bvh, &geometry, 1).unwrap().0);
        let holes = AlphaTested { inner, geometry, appearance, test, cull: false };
        let mut out = Vec::new();
        for k in 0..256 {
            let mut packet = RayHits::EMPTY;
            for lane in 0..LANES {
                packet.rays.direction[0][lane] = (k * LANES + lane) as f32 * 1e-4;
                packet.rays.direction[1][lane] = 0.1;
            }
            let valid = Lanes([-1; LANES]);
            let mut shadow = packet.rays;
            holes.intersect(&valid, &mut packet, Coherence::Coherent);
            // A shadow ray to just before the hit is free; one to just behind it is occluded.
            shadow.far = packet.rays.far.map(|far| far * 0.999);
            holes.occluded(&valid, &mut shadow, Coherence::Coherent);
            assert!(shadow.far.iter().all(|far| *far > 0.0));
            shadow.far = packet.rays.far.map(|far| far * 1.001);
            holes.occluded(&valid, &mut shadow, Coherence::Coherent);
            assert!(shadow.far.iter().all(|far| *far < 0.0));
            out.extend(packet.rays.far);
        }
        out
    }

    #[test]
    fn masks_and_shares_stop_the_rays_that_they_should() {
        let all = |depths: Vec<f32>, expected: f32| assert!(depths.iter().all(|d| (d - expected).abs() < 1e-5));
        all(depths(Alpha::Mask(0.5), 0.5, AlphaTest::Stochastic), 1.0);
        all(depths(Alpha::Mask(0.5), 0.49, AlphaTest::Stochastic), 10.0);
        all(depths(Alpha::Opaque, 0.0, AlphaTest::Stochastic), 1.0);
        all(depths(Alpha::Blend, 1.0, AlphaTest::Stochastic), 1.0);
        all(depths(Alpha::Blend, 0.0, AlphaTest::Stochastic), 10.0);
        all(depths(Alpha::Blend, 0.5, AlphaTest::Threshold), 1.0);
        all(depths(Alpha::Blend, 0.499, AlphaTest::Threshold), 10.0);
        // Of 4096 rays a quarter stops at each layer: within four standard errors, each at most 0.0078.
        let some = depths(Alpha::Blend, 0.25, AlphaTest::Stochastic);
        let share = |from: f32| some.iter().filter(|d| **d > from).count() as f64 / some.len() as f64;
        for layers in 1..9 {
            let expected = 0.75f64.powi(layers);
            assert!((share(layers as f32 + 0.5) - expected).abs() < 4.0 * 0.0078, "{layers} {}", share(layers as f32));
        }
    }
}
