//! Ground truth only: layers (AOVs) of the first hits of one exact ray through the center of every pixel.

use super::aov::{self, AovTile, PrimaryHits, TileAovs};
use super::{Context, RayCounts};
use crate::accel::refine;
use crate::accel::{Coherence, RayHits};
use crate::camera::tile::Tile;
use crate::material::{HitPoints, SurfaceInteraction};
use crate::simd::{Kernel, count};

/// The integrator over one tile.
pub(crate) struct DepthTile<'a, 'b> {
    pub context: &'a Context<'a>,
    pub tile: &'a Tile,
    pub out: AovTile<'b>,
    pub aov: &'a mut TileAovs,
}

impl Kernel for DepthTile<'_, '_> {
    type Output = RayCounts;

    #[inline(always)]
    fn run(mut self) -> RayCounts {
        let layers = self.out.set();
        self.aov.begin(layers);
        let primary = if aov::needs_interaction(layers) { self.trace::<true>() } else { self.trace::<false>() };
        self.aov.write(self.tile, &mut self.out);
        RayCounts { primary, ..RayCounts::default() }
    }
}

impl DepthTile<'_, '_> {
    /// Traces the tile; returns the number of rays. Specialized at compile time, because the loop without surface
    /// interactions is faster if the other is not compiled into it.
    #[inline(always)]
    fn trace<const WITH_SURFACES: bool>(&mut self) -> u64 {
        let context = self.context;
        let mut packet = RayHits::EMPTY;
        let mut primary = 0;
        for pixels in context.camera.packets(self.tile) {
            let rays = pixels.chief(&mut packet);
            context.scene.engine.intersect(&pixels.valid, &mut packet, Coherence::Coherent);
            primary += count(&pixels.valid);
            let refined = refine::refine(context.scene.geometry, &packet, &rays);
            let interaction = if WITH_SURFACES {
                SurfaceInteraction::new(
                    context.scene.appearance,
                    context.scene.geometry,
                    &packet,
                    &HitPoints::primary(&rays, &refined, None),
                )
            } else {
                None
            };
            let hits =
                PrimaryHits { packet: &packet, rays: &rays, refined: &refined, interaction: interaction.as_ref() };
            self.aov.push(context, &hits);
        }
        primary
    }
}
