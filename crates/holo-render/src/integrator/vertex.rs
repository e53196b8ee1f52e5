//! Sixteen path vertices, which light is gathered at and rays are scattered from.

use super::paths::PathPacket;
use crate::accel::{Coherence, RayHits};
use crate::material::media::MediaStack;
use crate::material::{Footprints, SurfaceInteraction};
use crate::simd::LANES;

/// Sixteen path vertices.
pub(crate) struct Shading<'a> {
    pub packet: &'a RayHits,
    pub interaction: &'a SurfaceInteraction,
    /// The footprints of camera rays.
    pub footprints: Option<&'a Footprints>,
    /// Lanes with a hit.
    pub hit: [bool; LANES],
    pub sequences: &'a [u32; LANES],
    /// The number of the path vertex, from 0.
    pub vertex: u32,
    /// The media behind the surfaces, as seen from the incident rays; those in front are in `paths`.
    pub media_behind: [MediaStack; LANES],
    /// The state of the paths.
    pub paths: &'a mut PathPacket,
    /// The coherence of shadow rays from here.
    pub coherence: Coherence,
}

/// The media on the side of the surface from which rays towards the light start.
#[inline(always)]
pub(super) fn media_towards(here: &Shading, to_light: &[[f32; LANES]; 3]) -> [MediaStack; LANES] {
    let mut out = [MediaStack::AIR; LANES];
    for lane in 0..LANES {
        let mut above = 0.0;
        for axis in 0..3 {
            above += here.interaction.geometric_normal[axis][lane] * to_light[axis][lane];
        }
        out[lane] = if above < 0.0 { here.media_behind[lane] } else { here.paths.media[lane] };
    }
    out
}
