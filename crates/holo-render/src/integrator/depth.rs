//! Ground truth: planar depth and disparity of the first surface, one exact ray through every pixel's centre.
//!
//! The engine finds the triangle in f32, [`crate::refine`] gives the depth in f64, disparity is computed from that
//! before both are rounded to f32. Nothing hit: depth +infinity, disparity that of infinity.

use ndarray::ArrayViewMut5;

use super::{Context, RayCounts};
use crate::accel::{Coherence, LANES, Lanes, RayHits};
use crate::dispatch::Kernel;
use crate::refine;
use crate::tile::Tile;

/// Depth and disparity of one tile, packet by packet.
#[derive(Default)]
pub(crate) struct Truth {
    depth_m: Vec<[[f32; LANES]; 1]>,
    disparity_px: Vec<[[f32; LANES]; 1]>,
}

/// Where a tile's ground truth goes.
pub(crate) struct TruthTile<'a> {
    pub depth_m: ArrayViewMut5<'a, f32>,
    pub disparity_px: ArrayViewMut5<'a, f32>,
}

impl Truth {
    /// Takes the next packet's refined depths.
    #[inline(always)]
    pub fn push(&mut self, context: &Context, depth: &[f64; LANES]) {
        let (mut rounded, mut disparity) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            rounded[lane] = depth[lane] as f32;
            disparity[lane] = context.disparity.from_depth_m(depth[lane]) as f32;
        }
        self.depth_m.push([rounded]);
        self.disparity_px.push([disparity]);
    }

    /// Writes the tile.
    #[inline(always)]
    pub fn scatter(&self, tile: &Tile, out: &mut TruthTile) {
        tile.scatter(&self.depth_m, 1.0, &mut out.depth_m);
        tile.scatter(&self.disparity_px, 1.0, &mut out.disparity_px);
    }
}

/// The integrator over one tile.
pub(crate) struct DepthTile<'a, 'b> {
    pub context: &'a Context<'a>,
    pub tile: &'a Tile,
    pub out: TruthTile<'b>,
}

impl Kernel for DepthTile<'_, '_> {
    type Output = RayCounts;

    #[inline(always)]
    fn run(mut self) -> RayCounts {
        let mut truth = Truth::default();
        let mut packet = RayHits::EMPTY;
        let mut primary = 0;
        for block in self.tile.blocks() {
            let pixels = self.context.tables.pixels(block);
            let rays = self.context.tables.fill(&pixels, None, &mut packet);
            self.context.engine.intersect(&pixels.valid, &mut packet, Coherence::Coherent);
            primary += count(&pixels.valid);
            truth.push(self.context, &refine::refine(self.context.geometry, &packet, &rays).depth);
        }
        truth.scatter(self.tile, &mut self.out);
        RayCounts { primary, ..RayCounts::default() }
    }
}

/// Valid lanes.
#[inline(always)]
pub(crate) fn count(valid: &Lanes<i32>) -> u64 {
    valid.0.iter().map(|&v| u64::from(v != 0)).sum()
}
