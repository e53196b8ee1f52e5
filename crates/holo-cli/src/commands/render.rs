//! `holo render`: scene in, folder of images and ground truth out.

use std::path::Path;

use clap::ArgMatches;
use holo_dataset::{
    ArrayJob, Checkpoints, Deduplicated, ImageJob, ImageReport, JobOutcome, RawJob, RenderJob, SceneSource, Seconds,
    SequenceJob,
};
use holo_io::dataset::SEQUENCE_HDF5;
use holo_io::{CameraArray, CameraFile};

use super::requested::requested;
use crate::arguments::RenderOptions;
use crate::console::{out, peak_rss_bytes, say, say_unless};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::{Bar, Overall};

pub fn run(options: &RenderOptions, matches: &ArgMatches) -> Result<(), Failure> {
    if let Some(camera) = &options.camera_file {
        return raw(options, camera, matches);
    }
    if let Some(cameras) = &options.transforms {
        return array(options, cameras, matches);
    }
    let job = RenderJob::new(SceneSource::File(options.scene.clone()), options.spec())
        .with_options(requested(matches))
        .with_engine(options.engine.spec())
        .with_checkpoints(Checkpoints::every_seconds(options.checkpoint));
    if job.spec.scene.frames.is_some_and(|frames| frames.single().is_none()) {
        return sequence(options, job);
    }
    if !options.overwrite {
        job.check_replaceable(&options.out, options.shard)?;
    }
    let bar = Bar::new("rendering", options.quiet);
    let report = job.run(&options.out, options.shard, &bar, &say_unless(options.quiet), interrupt::rollback());
    bar.finish();
    let report = report?;
    tell(options, &report, &report.seconds, report.files.len(), report.to_json())
}

/// The frames of an animation, each in a folder of its own; complete ones are kept.
fn sequence(options: &RenderOptions, job: impl ImageJob) -> Result<(), Failure> {
    let bar = Overall::new(options.quiet);
    let diagnostics = Deduplicated::new(|line: &str| {
        if !options.quiet {
            bar.above(|| say!("{line}"));
        }
    });
    if !options.overwrite {
        SequenceJob::check_replaceable(&job, &options.out)?;
    }
    let job = SequenceJob::new(job, &bar, &diagnostics)?;
    let frames: Vec<u32> = job.frames(options.shard).collect();
    bar.expect(frames.len());
    let mut made = 0;
    for (done, &frame) in frames.iter().enumerate() {
        bar.begin(done, &format!("frame {frame}"));
        let outcome = job.run_frame(frame, &options.out, &bar, &diagnostics, interrupt::rollback());
        if outcome.is_err() && interrupt::requested() {
            return Err(Failure::Failed("stopped; the same command goes on".into()));
        }
        let line = match &outcome? {
            JobOutcome::Made(report, _) => {
                made += 1;
                if options.json {
                    let mut object = report.to_json();
                    object["frame"] = frame.into();
                    out!("{object}")?;
                }
                format!("{:.1} s, {:.1} Mrays/s", report.seconds().total, report.mrays_per_second())
            }
            JobOutcome::Kept(_) => "done already".into(),
        };
        if !options.quiet {
            bar.above(|| say!("[{}/{}] frame {frame}: {line}", done + 1, frames.len()));
        }
    }
    bar.finish();
    let files: &[&str] = if job.finish(&options.out)? { &[SEQUENCE_HDF5] } else { &[] };
    let (kept, peak_rss_bytes) = (frames.len() - made, peak_rss_bytes());
    if !options.quiet {
        let of_all = files.first().map_or_else(String::new, |file| format!("; {file} has them all"));
        say!("{made} frames made, {kept} done already, in {}{of_all}", options.out.display());
    }
    if options.json {
        let object = serde_json::json!({"made": made, "kept": kept, "files": files, "peak_rss_bytes": peak_rss_bytes});
        out!("{object}")?;
    }
    Ok(())
}

/// The images of cameras anywhere.
fn array(options: &RenderOptions, cameras: &Path, matches: &ArgMatches) -> Result<(), Failure> {
    let (spec, up) = (options.spec(), options.transforms_up);
    let cameras = CameraArray::read(cameras, up, spec.rig.lenses)?;
    let mut job =
        ArrayJob::new(SceneSource::File(options.scene.clone()), cameras, up, spec).with_options(requested(matches));
    job.engine = options.engine.spec();
    if !options.overwrite {
        job.check_replaceable(&options.out)?;
    }
    let bar = Bar::new("rendering", options.quiet);
    let report = job.run(&options.out, &bar, &say_unless(options.quiet), interrupt::rollback());
    bar.finish();
    let report = report?;
    if !options.quiet {
        say!(
            "{report}\nwrote {} files to {} ({:.2} s)",
            report.files.len(),
            options.out.display(),
            report.total_seconds
        );
    }
    if options.json {
        let mut object = report.to_json();
        object["peak_rss_bytes"] = peak_rss_bytes().into();
        out!("{object}")?;
    }
    Ok(())
}

/// The raw image of a plenoptic camera.
fn raw(options: &RenderOptions, camera: &str, matches: &ArgMatches) -> Result<(), Failure> {
    let camera = options.rig.main_lens.adjusted(CameraFile::open(camera)?)?;
    let mut job =
        RawJob::new(SceneSource::File(options.scene.clone()), camera, options.spec()).with_options(requested(matches));
    (job.tools, job.engine) = (options.tools.clone(), options.engine.spec());
    if job.spec.scene.frames.is_some_and(|frames| frames.single().is_none()) {
        return sequence(options, job);
    }
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
