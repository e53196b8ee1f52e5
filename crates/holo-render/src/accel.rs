//! Ray acceleration: one seam, three engines.
//!
//! The integrators fill packets of 16 rays and ask an engine for the nearest hit or for any hit. [`embree`] is the fast
//! one and is looked for at run time; [`bvh`] is pure Rust and always there; [`brute_force`] tests every triangle in
//! f64 and is what the other two are held against.
//!
//! Packets are arrays of structures of arrays in the layout of Embree's `RTCRayHit16`, so that the fast engine reads
//! them in place.

pub(crate) mod brute_force;
pub(crate) mod bvh;
#[allow(unsafe_code)]
pub(crate) mod embree;
mod packet;
pub(crate) mod refine;
pub(crate) mod triangle;

use std::sync::Arc;

pub(crate) use packet::{ExactRays, NO_TRIANGLE, RayHits, Rays};

use crate::error::Error;
use crate::geometry::{Geometry, Instancing};
use crate::simd::Lanes;

/// Which engine finds the hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// Embree where it can be loaded, else the BVH.
    #[default]
    Auto,
    /// Embree 4, or an error that says where it was looked for.
    Embree,
    /// The pure-Rust BVH.
    Bvh,
    /// Every triangle against every ray in f64: for tests.
    BruteForce,
}

/// How the rays of a packet run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coherence {
    /// Close together: worth walking the tree as one.
    Coherent,
    /// All over the place: better one at a time.
    Incoherent,
}

/// What finds hits. Rays and hits are in camera coordinates.
pub(crate) trait Engine: Send + Sync {
    /// Fills the hits and shortens `far` of every valid lane whose ray hits something in (near, far).
    fn intersect(&self, valid: &Lanes<i32>, packet: &mut RayHits, coherence: Coherence);

    /// Sets `far` of every valid lane whose ray hits anything in (near, far) to minus infinity.
    fn occluded(&self, valid: &Lanes<i32>, rays: &mut Rays, coherence: Coherence);

    /// As `intersect`, asking for one ray after the other: what packets are measured against.
    #[cfg(feature = "bench")]
    fn intersect_singly(&self, valid: &Lanes<i32>, packet: &mut RayHits) {
        self.intersect(valid, packet, Coherence::Coherent);
    }

    /// The name and version for logs and manifests, such as "embree 4.4.0".
    fn name(&self) -> &str;
}

/// How the geometry for this engine may be stored, if it is up to the renderer.
pub(crate) fn instancing(backend: Backend) -> Instancing {
    match backend {
        Backend::Embree => Instancing::WhereItPays,
        Backend::Auto if embree::Embree::available().is_ok() => Instancing::WhereItPays,
        Backend::Auto | Backend::Bvh | Backend::BruteForce => Instancing::Never,
    }
}

/// An engine over `geometry` (as [`instancing`] says for `backend`), with a note where `Auto` had to fall back.
pub(crate) fn build(
    backend: Backend,
    geometry: &Arc<Geometry>,
    threads: usize,
) -> Result<(Box<dyn Engine>, Option<String>), Error> {
    Ok(match backend {
        Backend::Embree => (Box::new(embree::Embree::build(geometry, threads)?), None),
        Backend::Bvh => (Box::new(bvh::Bvh::build(geometry)), None),
        Backend::BruteForce => (Box::new(brute_force::BruteForce::build(geometry)), None),
        // Only a library that is not there is no error: one that fails over this scene is.
        Backend::Auto => match embree::Embree::available() {
            Ok(()) => (Box::new(embree::Embree::build(geometry, threads)?), None),
            Err(why) => {
                let note = format!("{why}; using the built-in BVH, which is several times slower");
                (Box::new(bvh::Bvh::build(geometry)), Some(note))
            }
        },
    })
}

#[cfg(test)]
pub(crate) mod tests;
