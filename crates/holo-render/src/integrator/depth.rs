//! Ground truth alone: layers of the first surface, one exact ray through every pixel's centre.

use super::truth::{self, Seen, Truth, TruthTile};
use super::{Context, RayCounts};
use crate::accel::refine;
use crate::accel::{Coherence, RayHits};
use crate::camera::tile::Tile;
use crate::material::{HitPoints, Surfaces};
use crate::simd::{Kernel, count};

/// The integrator over one tile.
pub(crate) struct DepthTile<'a, 'b> {
    pub context: &'a Context<'a>,
    pub tile: &'a Tile,
    pub out: TruthTile<'b>,
    pub truth: &'a mut Truth,
}

impl Kernel for DepthTile<'_, '_> {
    type Output = RayCounts;

    #[inline(always)]
    fn run(mut self) -> RayCounts {
        let layers = self.out.set();
        self.truth.begin(layers);
        let primary = if truth::needs_surfaces(layers) { self.trace::<true>() } else { self.trace::<false>() };
        self.truth.write(self.tile, &mut self.out);
        RayCounts { primary, ..RayCounts::default() }
    }
}

impl DepthTile<'_, '_> {
    /// Traces the tile; returns the rays. Two loops, because the compiler lets even those who need no surfaces pay a
    /// tenth for having them in theirs.
    #[inline(always)]
    fn trace<const WITH_SURFACES: bool>(&mut self) -> u64 {
        let context = self.context;
        let mut packet = RayHits::EMPTY;
        let mut primary = 0;
        for pixels in context.camera.packets(self.tile) {
            let rays = context.camera.chief(&pixels, &mut packet);
            context.scene.engine.intersect(&pixels.valid, &mut packet, Coherence::Coherent);
            primary += count(&pixels.valid);
            let refined = refine::refine(context.scene.geometry, &packet, &rays);
            let surfaces = if WITH_SURFACES {
                Surfaces::new(
                    context.scene.appearance,
                    context.scene.geometry,
                    &packet,
                    &HitPoints::primary(&rays, &refined),
                )
            } else {
                None
            };
            let seen = Seen { packet: &packet, rays: &rays, refined: &refined, surfaces: surfaces.as_ref() };
            self.truth.push(context, &seen);
        }
        primary
    }
}
