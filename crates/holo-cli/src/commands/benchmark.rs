//! `holo benchmark`: the data of benchmarks.

use std::cell::Cell;

use holo_dataset::{About, CalibrationBenchmark};

use crate::arguments::CalibrationBenchmarkOptions;
use crate::console::say;
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Bar;

/// Samples a second of two cores, over all cameras; 0.6 times as many before three types of microlenses, 1.7 times before one.
const SAMPLES_PER_S: f64 = 1e7;

pub fn calibration(options: &CalibrationBenchmarkOptions) -> Result<(), Failure> {
    let benchmark = CalibrationBenchmark {
        is_full: options.full,
        cameras: options.cameras.clone(),
        samples: options.spp,
        engine: options.engine.settings(),
    };
    let size = benchmark.size()?;
    say!(
        "{} cameras behind two lenses, {} boards, {:.0} million pixels: {:.1} GB, {:.0} minutes on two cores, about",
        size.cameras,
        size.boards,
        size.pixels / 1e6,
        size.bytes / 1e9,
        size.pixels * f64::from(options.spp) / SAMPLES_PER_S / 60.0
    );
    if options.dry_run {
        return Ok(());
    }
    let bar = Bar::new("rendering", false);
    let parts = Cell::new(0);
    let watch = |about: About, line: &str| {
        if about == About::Scene {
            parts.set(parts.get() + 1);
        }
        say!("{line}");
    };
    let done = benchmark.run(&options.out, options.overwrite, (&bar, &watch, interrupt::rollback()));
    bar.finish();
    done?;
    say!("wrote {} parts to {}", parts.get(), options.out.display());
    Ok(())
}
