//! Who makes rays. One camera a file, all behind one seam.
//!
//! An image is cut into [tiles](tile) of packets of 16 pixels. A [`RaySource`] (pbrt's camera, Mitsuba's sensor) names the
//! pixels of a packet by numbers that mean nothing below the seam - a microlens, a pixel behind it - and makes a ray through
//! each: a sample of the pixel with its weight, or the chief ray, which ground truth is about. What traces the rays keeps its
//! values in the order of packets and lanes, and knows neither rows nor columns; [`tile::Tile::write`] puts them in
//! their places.
//!
//! Which source it is, is decided before a kernel begins, so that every kernel is compiled once. `framing` is the way
//! from a scene's camera to a rig. **May enter:** what rays are ([`crate::accel`]), random numbers, scenes.

pub(crate) mod framing;
pub(crate) mod rig;
pub(crate) mod tile;

use holo_core::Disparity;

use crate::accel::{ExactRays, RayHits};
use crate::sampling::{PixelNumbers, Sampler};
use crate::simd::{LANES, Lanes};
use rig::{RigPixels, RigRays};
use tile::{Blocks, Tile};

/// Where the rays of an image come from.
pub(crate) enum RaySource {
    /// A rig of parallel pinhole cameras, one a view.
    Rig(RigRays),
}

/// Sixteen pixels of an image.
#[derive(Clone, Copy)]
pub(crate) struct PixelPacket<'a> {
    /// -1 for lanes that have a pixel, else 0.
    pub valid: Lanes<i32>,
    /// What random numbers are drawn by.
    pub numbers: PixelNumbers,
    source: RigPixels<'a>,
}

/// Sixteen rays from a camera.
pub(crate) struct CameraRays {
    pub exact: ExactRays,
    /// What a ray's radiance counts for in its pixel, of all samples alike 1 on average.
    pub weight: [f32; LANES],
}

/// Iterates over the packets of a tile.
pub(crate) struct Packets<'a> {
    source: &'a RaySource,
    blocks: Blocks,
}

impl<'a> Iterator for Packets<'a> {
    type Item = PixelPacket<'a>;

    #[inline(always)]
    fn next(&mut self) -> Option<PixelPacket<'a>> {
        let block = self.blocks.next()?;
        let RaySource::Rig(rig) = self.source;
        let source = rig.pixels(block);
        Some(PixelPacket { valid: source.valid(), numbers: rig.numbers(&source), source })
    }
}

impl RaySource {
    /// The packets of `tile`, in the order in which its values are kept.
    #[inline(always)]
    pub fn packets(&self, tile: &Tile) -> Packets<'_> {
        Packets { source: self, blocks: tile.blocks() }
    }

    /// Sample number `sample` of every pixel of a packet, also as f32 in `packet`. The only sample is the chief ray.
    #[inline(always)]
    pub fn sample(&self, pixels: &PixelPacket, sampler: &Sampler, sample: u32, packet: &mut RayHits) -> CameraRays {
        let Self::Rig(rig) = self;
        let position = if sampler.samples > 1 { Some(sampler.pixel_positions(&pixels.numbers, sample)) } else { None };
        CameraRays { exact: rig.fill(&pixels.source, position.as_ref(), packet), weight: [1.0; LANES] }
    }

    /// The chief ray of every pixel of a packet - through the pixel's center -, also as f32 in `packet`.
    #[inline(always)]
    pub fn chief(&self, pixels: &PixelPacket, packet: &mut RayHits) -> ExactRays {
        let Self::Rig(rig) = self;
        rig.fill(&pixels.source, None, packet)
    }

    /// Disparity of a depth between adjacent views.
    #[inline(always)]
    pub fn disparity(&self) -> &Disparity {
        let Self::Rig(rig) = self;
        rig.disparity()
    }
}
