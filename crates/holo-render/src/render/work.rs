//! Parallel execution of tiles.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ndarray::ArrayViewMut5;
use rayon::prelude::*;

use super::checkpoint::{Checkpoint, FinishedTile, TileId, TileKind};
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::integrator::RayCounts;
use crate::integrator::aov::AovTile;
use crate::integrator::progress::{Progress, Stop};

/// Parallel execution of tiles, with progress reports, cancellation and checkpoints.
pub(super) struct Work<'a> {
    progress: &'a dyn Progress,
    stop: &'a Stop<'a>,
    checkpoint: Option<&'a dyn Checkpoint>,
    /// Tiles that are not stored yet, of all kinds, and steps after them.
    total: u64,
    done: AtomicU64,
}

/// The memory of a tile in the arrays of the result.
pub(super) trait TileOutput: Send {
    /// All values in the order of [`FinishedTile::values`].
    fn values(&self) -> Vec<f32>;

    /// The number of values.
    fn count(&self) -> usize;

    /// Sets all values; there are [`count`](Self::count) of them.
    fn fill(&mut self, values: &[f32]);
}

impl TileOutput for ArrayViewMut5<'_, f32> {
    fn values(&self) -> Vec<f32> {
        self.iter().copied().collect()
    }

    fn count(&self) -> usize {
        self.len()
    }

    fn fill(&mut self, values: &[f32]) {
        self.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
    }
}

impl TileOutput for AovTile<'_> {
    fn values(&self) -> Vec<f32> {
        self.iter().flat_map(|(_, output)| output.iter().copied()).collect()
    }

    fn count(&self) -> usize {
        self.iter().map(|(_, output)| output.len()).sum()
    }

    fn fill(&mut self, mut values: &[f32]) {
        for (_, output) in self.iter_mut() {
            let (own, rest) = values.split_at(output.len());
            output.fill(own);
            values = rest;
        }
    }
}

/// Tiles that are finished and not stored yet, with their memory.
struct Finished<P>(Mutex<Vec<(TileId, RayCounts, P)>>);

impl<P: TileOutput> Finished<P> {
    fn list(&self) -> MutexGuard<'_, Vec<(TileId, RayCounts, P)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands all tiles to `checkpoint`, while other threads may add more.
    fn store(&self, checkpoint: &dyn Checkpoint) {
        let taken = std::mem::take(&mut *self.list());
        let mut tiles =
            taken.iter().map(|(id, rays, output)| FinishedTile { id: *id, rays: *rays, values: output.values() });
        if !checkpoint.store(&mut tiles) {
            self.list().extend(taken);
        }
    }
}

impl<'a> Work<'a> {
    /// For tiles of these kinds, and `steps` steps after them.
    pub fn new(
        progress: &'a dyn Progress,
        stop: &'a Stop<'a>,
        checkpoint: Option<&'a dyn Checkpoint>,
        kinds: impl Iterator<Item = (TileKind, usize)>,
        steps: usize,
    ) -> Self {
        let is_missing = |id: &TileId| checkpoint.is_none_or(|checkpoint| !checkpoint.contains(*id));
        let missing = |(kind, count)| (0..count).filter(|&number| is_missing(&TileId { kind, number })).count() as u64;
        Self {
            progress,
            stop,
            checkpoint,
            total: kinds.map(missing).sum::<u64>() + steps as u64,
            done: AtomicU64::new(0),
        }
    }

    /// Calls `trace` with every tile and its output, unless the checkpoint contains it. The tiles are numbered from `first`
    /// on. Scratch memory is reused from tile to tile.
    pub fn run<P: TileOutput, S: Default + Send>(
        &self,
        kind: TileKind,
        first: usize,
        tiling: &Tiling,
        outputs: Vec<P>,
        trace: impl Fn(&Tile, &mut P, &mut S) -> RayCounts + Sync,
    ) -> Result<RayCounts, Error> {
        let tiles = tiling.tiles();
        // At most as many entries as tiles that were traced at the same time.
        let idle = Mutex::new(Vec::<S>::new());
        let finished = Finished(Mutex::default());
        debug_assert_eq!(tiles.len(), outputs.len());
        let outcome = tiles
            .par_iter()
            .zip(outputs)
            .enumerate()
            .map(|(number, (tile, mut output))| {
                if self.stop.requested() {
                    return Err(Error::Cancelled);
                }
                let id = TileId { kind, number: first + number };
                if let Some(rays) = self.restore(id, &mut output) {
                    return Ok(rays);
                }
                let taken = idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
                let mut scratch = taken.unwrap_or_default();
                let rays = trace(tile, &mut output, &mut scratch);
                idle.lock().unwrap_or_else(PoisonError::into_inner).push(scratch);
                self.finish(id, rays, output, &finished);
                Ok(rays)
            })
            .try_reduce(RayCounts::default, |a, b| Ok(a + b));
        if let Some(checkpoint) = self.checkpoint.filter(|checkpoint| checkpoint.wants_rest()) {
            finished.store(checkpoint);
        }
        outcome
    }

    /// What is checked for cancellation.
    pub fn stop(&self) -> &'a Stop<'a> {
        self.stop
    }

    /// Whether the caller has canceled.
    pub fn is_stopped(&self) -> bool {
        self.stop.requested()
    }

    /// Reports that this many tiles are not necessary.
    pub fn leave_out(&self, tiles: usize) {
        let done = self.done.fetch_add(tiles as u64, Ordering::Relaxed) + tiles as u64;
        self.progress.advance(done, self.total);
    }

    /// Reports one of the steps after the tiles; returns whether to go on.
    pub fn step(&self) -> bool {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.advance(done, self.total);
        !self.stop.requested()
    }

    /// Fills `output` from the checkpoint, if it contains the tile.
    fn restore(&self, id: TileId, output: &mut impl TileOutput) -> Option<RayCounts> {
        let count = output.count();
        let stored = self.checkpoint?.restore(id).filter(|stored| stored.values.len() == count)?;
        output.fill(&stored.values);
        Some(stored.rays)
    }

    /// Reports a tile that was traced, and stores what is finished from time to time.
    fn finish<P: TileOutput>(&self, id: TileId, rays: RayCounts, output: P, finished: &Finished<P>) {
        // A tile during which the caller canceled may be incomplete; one without rays did not take part in its round.
        let complete = self.checkpoint.filter(|_| !self.stop.requested() && rays.total() > 0);
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.advance(done, self.total);
        let Some(checkpoint) = complete else { return };
        finished.list().push((id, rays, output));
        if checkpoint.is_due(done, self.total) {
            finished.store(checkpoint);
        }
    }
}
