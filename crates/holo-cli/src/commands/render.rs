//! `holo render`: scene in, folder of images and ground truth out.

use clap::ArgMatches;
use holo_dataset::{RenderJob, SceneSource};

use super::requested::requested;
use crate::arguments::RenderOptions;
use crate::console::{out, say_unless};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Bar;
use crate::report;

pub fn run(options: &RenderOptions, matches: &ArgMatches) -> Result<(), Failure> {
    let job = RenderJob::new(SceneSource::File(options.scene.clone()), options.spec())
        .with_options(requested(matches))
        .with_engine(options.engine.spec());
    if !options.overwrite {
        job.check_replaceable(&options.out, options.shard)?;
    }
    let bar = Bar::new("rendering", options.quiet);
    let report = job.run(&options.out, options.shard, &bar, &say_unless(options.quiet), interrupt::rollback());
    bar.finish();
    let report = report?;
    if !options.quiet {
        report::print(&report, &options.out);
    }
    if options.json {
        out!("{}", report::json(&report))?;
    }
    Ok(())
}
