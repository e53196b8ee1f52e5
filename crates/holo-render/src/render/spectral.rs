//! Colored light through glass: one render per color, each with the refraction of one wavelength.
//!
//! Red, green and blue are those wavelengths that the primaries of sRGB appear as. Three renders of one color cost three times one
//! of all colors, and leave the noise of a pixel as it is; a third of the samples for each color would cost as much for that noise.

use holo_core::plenoptic::PlenopticCamera;
use ndarray::Axis;

use super::checkpoint::{Checkpoint, FinishedTile, TileId};
use super::{Camera, RawRequest, Rendered, Renderer, Request};
use crate::error::Error;
use crate::film::layers::LayerSet;
use crate::integrator::Integrator;
use crate::integrator::progress::Progress;

/// The dominant wavelengths of the primaries of sRGB, nm.
const WAVELENGTHS_NM: [f64; 3] = [611.4, 549.1, 464.3];

/// Renders: one for every color, and one for the ground truth.
const PASSES: u64 = 4;

/// The progress of one of the renders.
struct Part<'a> {
    progress: &'a dyn Progress,
    pass: u64,
}

impl Progress for Part<'_> {
    fn advance(&self, done: u64, total: u64) {
        // Renders differ in their number of tiles.
        const WHOLE: u64 = 1 << 20;
        let share = u128::from(done) * u128::from(WHOLE) / u128::from(total.max(1));
        self.progress.advance(self.pass * WHOLE + share as u64, PASSES * WHOLE);
    }

    fn cancelled(&self) -> bool {
        self.progress.cancelled()
    }
}

/// The tiles of one of the renders.
struct PartTiles<'a> {
    checkpoint: &'a dyn Checkpoint,
    pass: u64,
}

impl PartTiles<'_> {
    fn outside(&self, id: TileId) -> TileId {
        TileId { number: id.number * PASSES as usize + self.pass as usize, ..id }
    }
}

impl Checkpoint for PartTiles<'_> {
    fn contains(&self, id: TileId) -> bool {
        self.checkpoint.contains(self.outside(id))
    }

    fn restore(&self, id: TileId) -> Option<FinishedTile> {
        self.checkpoint.restore(self.outside(id)).map(|tile| FinishedTile { id, ..tile })
    }

    fn is_due(&self, done: u64, total: u64) -> bool {
        self.checkpoint.is_due(done, total)
    }

    fn wants_rest(&self) -> bool {
        self.checkpoint.wants_rest()
    }

    fn store(&self, tiles: &mut dyn Iterator<Item = FinishedTile>) -> bool {
        self.checkpoint.store(&mut tiles.map(|tile| FinishedTile { id: self.outside(tile.id), ..tile }))
    }
}

/// Checks that a request of colored light can be rendered.
pub(super) fn check(request: &Request) -> Result<(), Error> {
    let has_glass = matches!(&request.camera, Camera::Plenoptic(camera) if camera.has_glass());
    if !has_glass {
        let why = "spectral light: only the glass of a plenoptic camera's main lens refracts colors differently, and this camera has \
                   no prescription";
        return Err(Error::BadSetting(why.into()));
    }
    if request.transport.target_error.is_some() || request.estimate_error {
        let why = "spectral light has no estimate of the error; choose a number of samples";
        return Err(Error::BadSetting(why.into()));
    }
    Ok(())
}

impl Renderer {
    /// Renders the raw image of a plenoptic camera color by color.
    pub(super) fn render_spectral(
        &self,
        camera: &PlenopticCamera,
        request: &Request,
        progress: &dyn Progress,
        checkpoint: Option<&dyn Checkpoint>,
    ) -> Result<Rendered, Error> {
        let render = |pass: u64, camera: &PlenopticCamera, request: &Request| {
            let tiles = checkpoint.map(|checkpoint| PartTiles { checkpoint, pass });
            let tiles = tiles.as_ref().map(|tiles| tiles as &dyn Checkpoint);
            self.render_raw(&RawRequest { camera, request }, &Part { progress, pass }, tiles)
        };
        // Ground truth is that of the d line.
        let mut truth = request.clone();
        truth.transport.integrator = Integrator::Depth;
        truth.statistics = false;
        let mut out = render(0, camera, &truth)?;
        let mut colors = request.clone().layers(LayerSet::EMPTY);
        for (channel, nm) in WAVELENGTHS_NM.into_iter().enumerate() {
            // Of the light in the middle.
            colors.statistics = request.statistics && channel == 1;
            let found = render(1 + channel as u64, &camera.at_wavelength(nm)?, &colors)?;
            (out.rays, out.samples) = (out.rays + found.rays, out.samples + found.samples);
            (out.integrator, out.why) = (found.integrator, found.why);
            (out.statistics, out.error_distribution) =
                (out.statistics.or(found.statistics), out.error_distribution.or(found.error_distribution));
            match (&mut out.color, found.color) {
                (Some(all), Some(color)) => {
                    let color = color.samples();
                    let color = color.index_axis(Axis(4), channel);
                    all.samples_mut().index_axis_mut(Axis(4), channel).assign(&color);
                }
                (none @ None, color) => *none = color,
                (Some(_), None) => {}
            }
        }
        Ok(out)
    }
}
