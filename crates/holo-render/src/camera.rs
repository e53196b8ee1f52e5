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
pub(crate) mod moved;
pub(crate) mod plenoptic;
pub(crate) mod rig;
pub(crate) mod tile;

use crate::accel::{CAMERA_RAY, Cells, ExactRays, RayHits};
use crate::sampling::{PixelIds, Sampler, rank};
use crate::simd::{LANES, Lanes};
use plenoptic::{PlenopticRays, RawPacket};
use rig::{RigPixels, RigRays};
use tile::{PacketPositions, Tile};

/// The side of a square of about as many pixels as a packet has.
const BLOCK: u32 = 4;

/// The source of the rays of an image.
pub(crate) enum RaySource {
    /// A rig of parallel pinhole cameras, one per view.
    Rig(RigRays),
    /// A main lens and a microlens array in front of a sensor.
    Plenoptic(Box<PlenopticRays>),
}

/// Sixteen pixels of an image.
#[derive(Clone, Copy)]
pub(crate) struct PixelPacket<'a> {
    /// -1 for lanes with a pixel, else 0.
    pub valid: Lanes<i32>,
    /// The ids that random numbers depend on.
    pub ids: PixelIds,
    source: PixelSource<'a>,
}

/// The pixels of a packet in the terms of their camera.
#[derive(Clone, Copy)]
enum PixelSource<'a> {
    Rig(&'a RigRays, RigPixels<'a>),
    Plenoptic(&'a PlenopticRays, &'a RawPacket),
}

/// Sixteen rays from a camera.
pub(crate) struct CameraRays {
    pub exact: ExactRays,
    /// The weight of the radiance of a ray in its pixel: the light that it stands for. 1 for rays of pinholes.
    pub weight: [f32; LANES],
    /// -1 for lanes with a ray, else 0.
    pub valid: Lanes<i32>,
    /// The cells of the pixels that the rays stand for, if textures are filtered.
    pub cells: Option<Cells>,
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
        Some(match self.source {
            RaySource::Rig(rig) => {
                let pixels = rig.pixels(position);
                let (valid, ids) = (pixels.valid(), rig.pixel_ids(&pixels));
                PixelPacket { valid, ids, source: PixelSource::Rig(rig, pixels) }
            }
            RaySource::Plenoptic(rays) => {
                let pixels = rays.packet(position[1]);
                let (valid, ids) = (pixels.valid(), rays.pixel_ids(pixels));
                PixelPacket { valid, ids, source: PixelSource::Plenoptic(rays, pixels) }
            }
        })
    }
}

impl PixelPacket<'_> {
    /// The [rank](crate::sampling::rank) of the packet among those of its microlens, or, of packets that have pixels of
    /// several microlenses, among those of its view.
    #[inline(always)]
    pub fn rank(&self, seed: u64) -> u32 {
        match &self.source {
            PixelSource::Rig(rig, _) => rig.rank(seed, &self.ids),
            PixelSource::Plenoptic(..) => rank(seed, self.ids.lens[0], self.ids.view.map(|k| k[0] / BLOCK)),
        }
    }

    /// The rays of sample number `sample` through the pixels, also written as f32 to `packet`. A centered sampler takes
    /// one through the center.
    #[inline(always)]
    pub fn sample(&self, sampler: &Sampler, sample: u32, packet: &mut RayHits) -> CameraRays {
        match &self.source {
            PixelSource::Rig(rig, pixels) => {
                let position = if !sampler.centered { Some(sampler.pixel_positions(&self.ids, sample)) } else { None };
                let exact = rig.fill(pixels, position.as_ref(), packet);
                let cells = sampler.cells.map(|count| Cells::Squares(rig.cells(position.as_ref(), count)));
                CameraRays { exact, weight: [1.0; LANES], valid: self.valid, cells }
            }
            PixelSource::Plenoptic(rays, pixels) => rays.sample(pixels, &self.ids, sampler, sample, packet),
        }
    }

    /// The chief rays, also written as f32 to `packet`: through the centers of the pixels, and of their microlenses.
    #[inline(always)]
    pub fn chief(&self, packet: &mut RayHits) -> ExactRays {
        packet.rays.id = [CAMERA_RAY; LANES];
        match &self.source {
            PixelSource::Rig(rig, pixels) => rig.fill(pixels, None, packet),
            PixelSource::Plenoptic(rays, pixels) => rays.chief(pixels, packet),
        }
    }
}

impl RaySource {
    /// The packets of `tile`, in the order of its values.
    #[inline(always)]
    pub fn packets(&self, tile: &Tile) -> Packets<'_> {
        Packets { source: self, positions: tile.packet_positions() }
    }

    /// The packets of a plenoptic camera; those of a rig follow from its tiles.
    pub fn raw_packets(&self) -> &[RawPacket] {
        match self {
            Self::Rig(_) => &[],
            Self::Plenoptic(rays) => rays.packets(),
        }
    }

    /// The disparity of a depth, px between adjacent views.
    #[inline(always)]
    pub fn disparity_px(&self, depth_m: f64) -> f64 {
        match self {
            Self::Rig(rig) => rig.disparity().from_depth_m(depth_m),
            Self::Plenoptic(rays) => rays.disparity_px(depth_m),
        }
    }
}
