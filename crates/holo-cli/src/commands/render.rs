//! `holo render`: scene in, folders of images and ground truth out.

use std::path::PathBuf;

use holo_dataset::{
    Checkpoints, Deduplicated, Event, RenderJob, RenderReport, RenderSettings, RunOptions, SceneSource, Shot,
    ShotOutcome,
};
use holo_io::dataset::SEQUENCE_HDF5;
use holo_render::Denoise;
use serde_json::{Value, json};

use crate::arguments::{RenderOptions, Seeds};
use crate::console::{out, peak_rss_bytes, say, say_unless};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::{Bar, Overall};

pub fn run(options: &RenderOptions) -> Result<(), Failure> {
    let settings = options.settings()?;
    let Some(Seeds(seeds)) = &options.seeds else { return render(options, settings) };
    for &seed in seeds {
        let mut settings = settings.clone();
        settings.light.seed = seed;
        render(&RenderOptions { out: options.out.join(format!("seed_{seed}")), ..options.clone() }, settings)?;
    }
    Ok(())
}

fn render(options: &RenderOptions, settings: RenderSettings) -> Result<(), Failure> {
    let is_plain = settings.light.denoise == Denoise::Off;
    let job = RenderJob::new(SceneSource::File(options.scene.clone()), settings)
        .engine(options.engine.settings())
        .checkpoints(Checkpoints::every_seconds(options.checkpoint));
    if job.shots().len() > 1 { many(options, &job) } else { one(options, &job, is_plain) }
}

/// The options of a run that do not depend on the number of shots.
fn how(options: &RenderOptions) -> RunOptions<'_> {
    RunOptions::new().shard(options.shard).overwrite(options.overwrite).rollback(interrupt::rollback())
}

/// A job with one shot, in which every pixel may have only its own samples.
fn one(options: &RenderOptions, job: &RenderJob, is_plain: bool) -> Result<(), Failure> {
    let mut bar = Bar::new("rendering", options.quiet);
    if is_plain {
        bar.advise("`--preset draft` renders a first image of the same in seconds");
    }
    let diagnostics = say_unless(options.quiet);
    let done = job.run(&options.out, &how(options).progress(&bar).diagnostics(&diagnostics));
    bar.finish();
    let shots = done?;
    let files = job.files(&options.out, &shots);
    let mut made = shots.iter().filter_map(|(shot, outcome)| Some((shot, outcome.report()?)));
    made.try_for_each(|(shot, report)| tell(options, shot, report, &files))
}

/// A job with a shot for every frame and pose, each in a folder of its own; complete ones are kept.
fn many(options: &RenderOptions, job: &RenderJob) -> Result<(), Failure> {
    let bar = Overall::new(options.quiet);
    let diagnostics = Deduplicated::new(|line: &str| {
        if !options.quiet {
            let line = Failure::spelled(line);
            bar.above(|| say!("{line}"));
        }
    });
    let made = std::cell::Cell::new(0);
    let broken_pipe = std::cell::RefCell::new(None);
    let events = |event: Event| match event {
        Event::Begin(done, of, shot) => {
            bar.expect(of);
            bar.begin(done, &shot.to_string());
        }
        Event::End(done, of, shot, outcome) => {
            let line = match outcome {
                ShotOutcome::Made(report, _) => {
                    made.set(made.get() + 1);
                    if options.json
                        && let Err(failure) = out!("{}", report.to_json())
                    {
                        broken_pipe.borrow_mut().get_or_insert(failure);
                    }
                    format!("{:.1} s, {:.1} Mrays/s", report.seconds.total, report.mrays_per_second())
                }
                ShotOutcome::Kept(_) => "done already".into(),
            };
            if !options.quiet {
                bar.above(|| say!("[{}/{of}] {shot}: {line}", done + 1));
            }
        }
    };
    let done = job.run(&options.out, &how(options).progress(&bar).diagnostics(&diagnostics).events(&events));
    bar.finish();
    if done.is_err() && interrupt::requested() {
        return Err(Failure::Failed("stopped; the same command goes on".into()));
    }
    let shots = done?;
    if let Some(failure) = broken_pipe.into_inner() {
        return Err(failure);
    }
    let files = job.files(&options.out, &shots);
    let (made, kept) = (made.get(), shots.len() - made.get());
    if !options.quiet {
        let of_all = files.iter().find(|file| *file == SEQUENCE_HDF5);
        let of_all = of_all.map_or_else(String::new, |file| format!("; {file} has them all"));
        say!("{made} images made, {kept} done already, in {}{of_all}", options.out.display());
    }
    if options.json {
        out!("{}", json!({"made": made, "kept": kept, "files": files, "peak_rss_bytes": peak_rss_bytes()}))?;
    }
    Ok(())
}

/// Prints what was done. `files` are all that the job has.
fn tell(options: &RenderOptions, shot: &Shot, report: &RenderReport, files: &[String]) -> Result<(), Failure> {
    let s = &report.seconds;
    if !options.quiet {
        let times = format!("load {:.2} s, build {:.2} s, total {:.2} s", s.load, s.build, s.total);
        // Joined with an empty path, it would end in a slash.
        let folder = options.out.components().chain(shot.folder().components()).collect::<PathBuf>();
        let (count, folder) = (report.files.len(), folder.display());
        say!("{report}\nwrote {count} files to {folder} ({:.2} s; {times})", s.write);
    }
    if options.json {
        let mut object: Value = serde_json::from_str(&report.to_json()).unwrap_or_default();
        object["files"] = json!(files);
        object["peak_rss_bytes"] = peak_rss_bytes().into();
        out!("{object}")?;
    }
    Ok(())
}
