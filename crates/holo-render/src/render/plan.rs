//! The pixels of a render, and their division into tiles.

use holo_core::{GridSize, LightFieldShape};

use super::request::{Denoise, Request, RigRequest, Views};
use super::rounds;
use super::transport::Transport;
use crate::camera::tile::{SelectedViews, Selection, Tiling};
use crate::error::Error;
use crate::film::reconstruct::HALO;
use crate::integrator::{Integrator, path};

/// A selection of pixels of a light field, divided into tiles.
pub(super) struct Region {
    pub selection: Selection,
    pub tiling: Tiling,
}

/// The pixels of color, of the layers of all views, and of the layers of the central view.
pub(super) struct Plan {
    pub color: Region,
    pub all: Region,
    pub central: Region,
}

impl Region {
    /// Divides all lens rows into tiles, then selects the requested rows.
    fn new(request: &RigRequest, views: SelectedViews, tile: impl Fn([usize; 4]) -> Tiling) -> Self {
        Self::with_margin(request, views, tile, 0)
    }

    /// As `new`, with at least this many more lens rows on each side, up to the end of a tile or the image.
    fn with_margin(
        request: &RigRequest,
        views: SelectedViews,
        tile: impl Fn([usize; 4]) -> Tiling,
        margin: usize,
    ) -> Self {
        let whole = Selection { views, ..Selection::whole(request.rig.shape()) };
        let tiling = tile(whole.counts());
        let lens_rows = match (request.row_range(), margin) {
            (rows, 0) => rows,
            (rows, margin) => {
                let (step, count) = (tiling.tile_rows(), request.rig.shape().lenses().rows);
                let start = rows.start.saturating_sub(margin) / step * step;
                start..((rows.end + margin).next_multiple_of(step)).min(count)
            }
        };
        Self { tiling: tiling.lens_rows(lens_rows.len()), selection: Selection { lens_rows, ..whole } }
    }

    /// The views and lenses of the output light field.
    pub fn shape(&self) -> Result<LightFieldShape, Error> {
        let [v, u, t, s] = self.selection.counts();
        Ok(LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u))?)
    }
}

impl Plan {
    pub fn new(request: &RigRequest, integrator: Integrator) -> Self {
        let split = request.rig.shape();
        let views = match &request.views {
            Views::All => SelectedViews::Grid([split.views().rows, split.views().columns]),
            Views::List(list) => {
                SelectedViews::List(list.iter().map(|view| [view.row as u32, view.column as u32]).collect())
            }
        };
        let (t, s) = split.central_view();
        let pixels = path_tile_pixels(&request.transport, integrator);
        let color_tiling = |counts| Tiling::with_tiles_of(counts, pixels);
        Self {
            color: Region::with_margin(request, views.clone(), color_tiling, margin(request)),
            all: Region::new(request, views, Tiling::new),
            central: Region::new(request, SelectedViews::List(vec![[t as u32, s as u32]]), Tiling::new),
        }
    }

    /// The step of lens rows at which a render can be divided without any change of the result: scattered rays are
    /// sorted and traced per tile, ground truth per packet.
    pub fn row_step(&self) -> usize {
        let steps = [self.color.tiling.tile_rows(), self.all.tiling.packet_rows(), self.central.tiling.packet_rows()];
        steps.into_iter().fold(1, least_common_multiple)
    }
}

/// Whether a render needs the guides of its pixels.
pub(super) fn needs_guides(request: &Request) -> bool {
    request.denoise == Denoise::Views || request.estimate_error
}

/// The lens rows on each side that are rendered for the reconstruction of others.
pub(super) fn margin(request: &RigRequest) -> usize {
    // In a round, the samples of a pixel depend on the error estimated before it.
    if needs_guides(request) { HALO * rounds::rounds(request).len() } else { 0 }
}

/// The pixels of a tile of color.
pub(super) fn path_tile_pixels(transport: &Transport, integrator: Integrator) -> usize {
    path::tile_pixels(transport.samples, transport.bounces(integrator))
}

fn least_common_multiple(a: usize, b: usize) -> usize {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}
