//! `holo render`: scene in, folder of images and ground truth out.

use clap::ArgMatches;
use holo_dataset::{Checkpoints, RawJob, RenderJob, SceneSource, Seconds};
use holo_io::CameraFile;

use super::requested::requested;
use crate::arguments::RenderOptions;
use crate::console::{out, peak_rss_bytes, say, say_unless};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Bar;

pub fn run(options: &RenderOptions, matches: &ArgMatches) -> Result<(), Failure> {
    if let Some(camera) = &options.camera_file {
        return raw(options, camera, matches);
    }
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
    tell(options, &report, &report.seconds, report.files.len(), report.to_json())
}

/// The raw image of a plenoptic camera.
fn raw(options: &RenderOptions, camera: &str, matches: &ArgMatches) -> Result<(), Failure> {
    let camera = options.rig.main_lens.adjusted(CameraFile::open(camera)?)?;
    let mut job =
        RawJob::new(SceneSource::File(options.scene.clone()), camera, options.spec()).with_options(requested(matches));
    (job.tools, job.engine) = (options.tools.clone(), options.engine.spec());
    if !options.overwrite {
        job.check_replaceable(&options.out, options.shard)?;
    }
    let bar = Bar::new("rendering", options.quiet);
    let report = job.run(&options.out, options.shard, &bar, &say_unless(options.quiet), interrupt::rollback());
    bar.finish();
    let report = report?;
    tell(options, &report, &report.seconds, report.files.len(), report.to_json())
}

/// Prints what was done.
fn tell(
    options: &RenderOptions,
    report: &dyn std::fmt::Display,
    s: &Seconds,
    files: usize,
    mut object: serde_json::Value,
) -> Result<(), Failure> {
    if !options.quiet {
        let times = format!("load {:.2} s, build {:.2} s, total {:.2} s", s.load, s.build, s.total);
        say!("{report}\nwrote {files} files to {} ({:.2} s; {times})", options.out.display(), s.write);
    }
    if options.json {
        object["peak_rss_bytes"] = peak_rss_bytes().into();
        out!("{object}")?;
    }
    Ok(())
}
