//! `holo render`: scene in, folder of images and ground truth out.

use clap::ArgMatches;
use holo_dataset::{Checkpoints, RenderJob, SceneSource};

use super::requested::requested;
use crate::arguments::RenderOptions;
use crate::console::{out, peak_rss_bytes, say, say_unless};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Bar;

pub fn run(options: &RenderOptions, matches: &ArgMatches) -> Result<(), Failure> {
    let job = RenderJob::new(SceneSource::File(options.scene.clone()), options.spec())
        .with_options(requested(matches))
        .with_engine(options.engine.spec())
        .with_checkpoints(Checkpoints::every_seconds(options.checkpoint));
    if !options.overwrite {
        job.check_replaceable(&options.out, options.shard)?;
    }
    let bar = Bar::new("rendering", options.quiet);
    let report = job.run(&options.out, options.shard, &bar, &say_unless(options.quiet), interrupt::rollback());
    bar.finish();
    let report = report?;
    if !options.quiet {
        let (out, s) = (options.out.display(), &report.seconds);
        let times = format!("load {:.2} s, build {:.2} s, total {:.2} s", s.load, s.build, s.total);
        say!("{report}\nwrote {} files to {out} ({:.2} s; {times})", report.files.len(), s.write);
    }
    if options.json {
        let mut object = report.to_json();
        object["peak_rss_bytes"] = peak_rss_bytes().into();
        out!("{object}")?;
    }
    Ok(())
}
