//! Ray tracing backends: the trait [`Engine`] and its three implementations.
//!
//! The integrators fill packets of 16 rays and query an engine for the nearest hit (intersection) or for any hit
//! (occlusion). [`embree`] is the fast engine; its library is loaded at run time. [`bvh`] is pure Rust and always
//! available. [`brute_force`] tests every triangle in f64 and is the reference implementation for the other two.
//!
//! Packets are structures of arrays in the layout of Embree's `RTCRayHit16`, so that Embree uses them in place.

pub(crate) mod brute_force;
pub(crate) mod bvh;
#[allow(unsafe_code, reason = "calls the C interface of Embree")]
pub(crate) mod embree;
mod library;
mod packet;
pub(crate) mod refine;
pub(crate) mod triangle;

use std::path::Path;
use std::sync::Arc;

pub use library::cache_folder;
pub(crate) use packet::{
    CAMERA_RAY, Cells, ExactRays, Half, NO_TRIANGLE, RayDifferentials, RayHits, Rays, SpotDifferentials,
};

use crate::error::Error;
use crate::geometry::{Geometry, Instancing};
use crate::simd::Lanes;

/// The ray tracing backend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// Embree if it can be loaded and has enough memory, otherwise the BVH.
    #[default]
    Auto,
    /// Embree 4. An error if no library is found; the message lists the locations that were searched.
    Embree,
    /// The BVH in pure Rust.
    Bvh,
    /// Tests every triangle against every ray in f64: a reference implementation for tests.
    BruteForce,
}

/// The coherence of the rays of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coherence {
    /// Similar origins and directions: traverse the tree as one packet.
    Coherent,
    /// Unrelated rays: traverse the tree one ray at a time.
    Incoherent,
}

/// A ray tracing engine over a scene. Rays and hits are in camera coordinates.
pub(crate) trait Engine: Send + Sync {
    /// Finds the nearest hit in (near, far) of every valid lane: fills the hits and sets `far` to its ray parameter.
    fn intersect(&self, valid: &Lanes<i32>, packet: &mut RayHits, coherence: Coherence);

    /// Finds any hit in (near, far) of every valid lane: sets `far` to minus infinity if there is one.
    fn occluded(&self, valid: &Lanes<i32>, rays: &mut Rays, coherence: Coherence);

    /// As `intersect`, with one query per ray: the baseline for measurements of packets.
    #[cfg(feature = "bench")]
    fn intersect_singly(&self, valid: &Lanes<i32>, packet: &mut RayHits) {
        self.intersect(valid, packet, Coherence::Coherent);
    }

    /// The name and version for logs and manifests, such as "embree 4.4.0".
    fn name(&self) -> &str;

    /// The file that was loaded for the engine, if it is known.
    fn library(&self) -> Option<&Path> {
        None
    }
}

/// The instancing policy for the engine of `backend`.
pub(crate) fn instancing(backend: Backend) -> Instancing {
    match backend {
        Backend::Embree => Instancing::Automatic,
        Backend::Auto if embree::Embree::available().is_ok() => Instancing::Automatic,
        Backend::Auto | Backend::Bvh | Backend::BruteForce => Instancing::Never,
    }
}

/// Builds an engine over `geometry`, which must follow the policy of [`instancing`] for `backend`. The second value is
/// a note if `Auto` fell back to the BVH.
pub(crate) fn build(
    backend: Backend,
    geometry: &Arc<Geometry>,
    threads: usize,
) -> Result<(Box<dyn Engine>, Option<String>), Error> {
    Ok(match backend {
        Backend::Embree => (Box::new(embree::Embree::build(geometry, threads)?), None),
        Backend::Bvh => (Box::new(bvh::Bvh::build(geometry)), None),
        Backend::BruteForce => (Box::new(brute_force::BruteForce::build(geometry)), None),
        // A missing library is no error here. Of one without memory `World::at` knows what to do.
        Backend::Auto => match embree::Embree::available() {
            Ok(()) => (Box::new(embree::Embree::build(geometry, threads)?), None),
            Err(why) => (Box::new(bvh::Bvh::build(geometry)), Some(fallback(&why))),
        },
    })
}

/// The note that `Auto` uses the BVH.
pub(crate) fn fallback(why: &Error) -> String {
    format!("{why}; using the built-in BVH, which is several times slower")
}

#[cfg(test)]
pub(crate) mod tests;
