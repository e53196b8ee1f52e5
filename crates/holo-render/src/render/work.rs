//! Parallel execution of tiles.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::integrator::RayCounts;
use crate::progress::{Progress, Stop};

/// Parallel execution of tiles, with progress reports and cancellation.
pub(super) struct Work<'a> {
    progress: &'a dyn Progress,
    stop: &'a Stop<'a>,
    total: u64,
    done: AtomicU64,
}

impl<'a> Work<'a> {
    pub fn new(progress: &'a dyn Progress, stop: &'a Stop<'a>, total: u64) -> Self {
        Self { progress, stop, total, done: AtomicU64::new(0) }
    }

    /// Calls `trace` with every tile and its output. Scratch memory is reused from tile to tile.
    pub fn run<P: Send, S: Default + Send>(
        &self,
        tiling: &Tiling,
        outputs: Vec<P>,
        trace: impl Fn(&Tile, P, &mut S) -> RayCounts + Sync,
    ) -> Result<RayCounts, Error> {
        let tiles = tiling.tiles();
        // At most as many entries as tiles that were traced at the same time.
        let idle = Mutex::new(Vec::<S>::new());
        debug_assert_eq!(tiles.len(), outputs.len());
        tiles
            .par_iter()
            .zip(outputs)
            .map(|(tile, output)| {
                if self.stop.requested() {
                    return Err(Error::Cancelled);
                }
                let taken = idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
                let mut scratch = taken.unwrap_or_default();
                let rays = trace(tile, output, &mut scratch);
                idle.lock().unwrap_or_else(PoisonError::into_inner).push(scratch);
                let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
                self.progress.advance(done, self.total);
                Ok(rays)
            })
            .try_reduce(RayCounts::default, |a, b| Ok(a + b))
    }
}
