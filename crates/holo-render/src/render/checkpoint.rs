//! Checkpoints: finished tiles of a render leave it before its end, and a later run of the same request takes them
//! back.
//!
//! A tile is stored as the renderer has accumulated it, before anything that needs the complete image: exposure,
//! encoding, filters across views. What it holds depends on the scene, the pose, the [`Request`](crate::Request) and
//! the version of this crate alone, so a run that takes tiles back ends with the same values as one without.

use crate::integrator::RayCounts;

/// The pixels that a tile belongs to. Each kind has tiles of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum TileKind {
    /// Color of all rendered views.
    Color,
    /// Layers of all rendered views.
    AllLayers,
    /// Layers of the central view.
    CentralLayers,
}

/// The identity of a tile among those of one request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileId {
    /// The pixels that it belongs to.
    pub kind: TileKind,
    /// Its number among the tiles of its kind, from 0.
    pub number: usize,
}

/// A finished tile.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedTile {
    /// The identity of the tile.
    pub id: TileId,
    /// The rays that were traced for it.
    pub rays: RayCounts,
    /// Color, followed by what a reconstruction needs of each pixel, if one is requested; or one layer after
    /// another in the order of [`Layer::ALL`](crate::Layer::ALL); of each the values with the
    /// axes (v, u, t, s, c), the last fastest.
    pub values: Vec<f32>,
}

/// Stores the finished tiles of one request, and returns those that an earlier run of the same request has stored.
///
/// [`Renderer::render_with_checkpoint`](crate::Renderer::render_with_checkpoint) calls it from any thread. The caller
/// guarantees that the tiles are of the same scene, pose, request, ray tracing backend and version of this crate.
pub trait Checkpoint: Sync {
    /// Returns whether a tile is stored, without reading it.
    fn contains(&self, id: TileId) -> bool;

    /// Returns a stored tile; `None` if it is not stored or cannot be read. A tile with a wrong number of values is
    /// rendered again.
    fn restore(&self, id: TileId) -> Option<FinishedTile>;

    /// Returns whether tiles should be stored now; [`store`](Self::store) follows then. Called after every tile, with the
    /// number of tiles that this run has finished and will finish.
    fn is_due(&self, done: u64, total: u64) -> bool;

    /// Returns whether the tiles that are left at the end of a kind, or when the render is canceled, should be stored;
    /// [`store`](Self::store) follows then.
    fn wants_rest(&self) -> bool;

    /// Stores tiles, which may be none. The iterator copies each from the result when it is read. Returns whether
    /// all are stored; otherwise they are offered again.
    fn store(&self, tiles: &mut dyn Iterator<Item = FinishedTile>) -> bool;
}
