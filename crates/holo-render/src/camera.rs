//! Cameras: the sources of rays. One camera per file, behind the enum [`RaySource`] (the camera of pbrt, the sensor of
//! Mitsuba).
//!
//! An image is divided into [tiles](tile) of packets of 16 pixels. A [`RaySource`] identifies the pixels of a packet by
//! opaque ids (a microlens, and a pixel behind it) and generates a ray through each: a sample of the pixel with its
//! weight, or the chief ray, which defines the ground truth. Integrators keep their values in the order of packets and
//! lanes; [`tile::Tile::write`] writes them to rows and columns of the image.
//!
//! The variant is selected before a kernel starts, so that every kernel is compiled once. [`framing`] derives a rig
//! from a camera of the scene. **May import:** ray packets ([`crate::accel`]), random numbers, scenes.

pub(crate) mod framing;
pub(crate) mod rig;
pub(crate) mod tile;

use holo_core::Disparity;

use crate::accel::{CAMERA_RAY, ExactRays, RayDifferentials, RayHits};
use crate::sampling::{PixelIds, Sampler};
use crate::simd::{LANES, Lanes};
use rig::{RigPixels, RigRays};
use tile::{PacketPositions, Tile};

/// The source of the rays of an image.
pub(crate) enum RaySource {
    /// A rig of parallel pinhole cameras, one per view.
    Rig(RigRays),
}

/// Sixteen pixels of an image.
#[derive(Clone, Copy)]
pub(crate) struct PixelPacket<'a> {
    /// -1 for lanes with a pixel, else 0.
    pub valid: Lanes<i32>,
    /// The ids that random numbers depend on.
    pub ids: PixelIds,
    source: RigPixels<'a>,
}

/// Sixteen rays from a camera.
pub(crate) struct CameraRays {
    pub exact: ExactRays,
    /// The weight of the radiance of a ray in its pixel; the mean over all samples is 1.
    pub weight: [f32; LANES],
    /// The cells of the pixels that the rays stand for, if textures are filtered.
    pub cells: Option<RayDifferentials>,
}

/// Iterates over the packets of a tile.
pub(crate) struct Packets<'a> {
    source: &'a RaySource,
    positions: PacketPositions,
}

impl<'a> Iterator for Packets<'a> {
    type Item = PixelPacket<'a>;

    #[inline(always)]
    fn next(&mut self) -> Option<PixelPacket<'a>> {
        let position = self.positions.next()?;
        let RaySource::Rig(rig) = self.source;
        let source = rig.pixels(position);
        Some(PixelPacket { valid: source.valid(), ids: rig.pixel_ids(&source), source })
    }
}

impl RaySource {
    /// The packets of `tile`, in the order of its values.
    #[inline(always)]
    pub fn packets(&self, tile: &Tile) -> Packets<'_> {
        Packets { source: self, positions: tile.packet_positions() }
    }

    /// The rays of sample number `sample` through the pixels of a packet, also written as f32 to `packet`. A centered
    /// sampler takes the chief ray.
    #[inline(always)]
    pub fn sample(&self, pixels: &PixelPacket, sampler: &Sampler, sample: u32, packet: &mut RayHits) -> CameraRays {
        let Self::Rig(rig) = self;
        let position = if !sampler.centered { Some(sampler.pixel_positions(&pixels.ids, sample)) } else { None };
        let exact = rig.fill(&pixels.source, position.as_ref(), packet);
        let cells = sampler.cells.map(|count| rig.cells(position.as_ref(), count));
        CameraRays { exact, weight: [1.0; LANES], cells }
    }

    /// The chief rays of a packet, through the centers of the pixels, also written as f32 to `packet`.
    #[inline(always)]
    pub fn chief(&self, pixels: &PixelPacket, packet: &mut RayHits) -> ExactRays {
        let Self::Rig(rig) = self;
        packet.rays.id = [CAMERA_RAY; LANES];
        rig.fill(&pixels.source, None, packet)
    }

    /// The conversion from depth to disparity between adjacent views.
    #[inline(always)]
    pub fn disparity(&self) -> &Disparity {
        let Self::Rig(rig) = self;
        rig.disparity()
    }
}
