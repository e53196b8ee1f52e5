//! `holo dataset` and `holo generate`: scenes times cameras, each a folder of its own; complete folders are kept.

use std::path::Path;
use std::time::Instant;

use clap::ArgMatches;
use holo_dataset::{
    Checkpoints, DatasetJob, DatasetPlan, DatasetSummary, Deduplicated, Diagnostics, JobSummary, RunOptions,
    SetProperties, finished, sources, write_catalog,
};
use serde_json::json;

use crate::arguments::{CollectionOptions, DatasetOptions, GenerateOptions, config};
use crate::console::peak_rss_bytes;
use crate::console::{out, say};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Overall;

/// The word for no scene of the gallery.
const NONE: &str = "none";

pub fn run(options: DatasetOptions, matches: &ArgMatches) -> Result<(), Failure> {
    let config = options.collection.config.clone();
    let options = config::complete(options, config, matches)?;
    render(&options.collection, || plan(&options))
}

/// `holo generate`.
pub fn generate(options: GenerateOptions, matches: &ArgMatches) -> Result<(), Failure> {
    let config = options.collection.config.clone();
    let options = config::complete(options, config, matches)?;
    let recipe = options.recipe()?;
    render(&options.collection, || {
        let (scenes, cameras) = options.scenes(&recipe)?;
        Ok(DatasetPlan::of_each(&scenes, cameras, options.collection.engine.settings())?)
    })?;
    let Some(root) = options.collection.out.filter(|_| !options.collection.quiet) else { return Ok(()) };
    let found = SetProperties::read(&root)?;
    if found.scenes > 0 {
        say!("{found}");
    }
    for (name, share, [low, high]) in found.beyond(&recipe) {
        let [share, low, high] = [share, low, high].map(|share| 100.0 * share);
        say!("warning: {share:.0} % of the scenes are {name}, and the recipe has {low:.0} to {high:.0} %");
    }
    Ok(())
}

/// Renders the jobs of a plan.
fn render(options: &CollectionOptions, plan: impl FnOnce() -> Result<DatasetPlan, Failure>) -> Result<(), Failure> {
    let start = Instant::now();
    let root = options.out.clone().ok_or_else(|| {
        Failure::Usage("where to? give --out DIR, on the command line or as `out` in the file of --config".into())
    })?;
    let plan = plan()?.checkpoints(Checkpoints::every_seconds(options.checkpoint).as_ref());
    let bar = Overall::new(options.quiet);
    let diagnostics = Deduplicated::new(|line: &str| {
        if !options.quiet {
            let line = Failure::spelled(line);
            bar.above(|| say!("{line}"));
        }
    });
    plan.describe(&root, &diagnostics, interrupt::rollback())?;

    let jobs = plan.jobs();
    let mine: Vec<(usize, &DatasetJob)> = jobs
        .iter()
        .enumerate()
        .filter(|(index, _)| options.shard.is_none_or(|shard| index % shard.of == shard.part - 1))
        .collect();
    bar.expect(mine.len());
    let mut run = plan.run();
    let mut table = DatasetSummary::default();
    for (done, &(index, job)) in mine.iter().enumerate() {
        bar.begin(done, &job.name());
        let scene = job.source().name();
        let of_scene = diagnostics.of_scene(&scene);
        let how = RunOptions::new().progress(&bar).diagnostics(&of_scene).rollback(interrupt::rollback());
        let outcome = run.job(job, &root, &how);
        if outcome.is_err() && interrupt::requested() {
            return Err(Failure::Failed("stopped; the same command goes on".into()));
        }
        let outcome = outcome.map_err(|error| Failure::from(error).message());
        let summary = JobSummary::new(job, &root, outcome);
        if !options.quiet {
            let line = Failure::spelled(&summary.to_string());
            bar.above(|| say!("[{:>2}/{}] {line}", index + 1, jobs.len()));
        }
        if options.json {
            out!("{}", summary.to_json())?;
        }
        table.push(summary);
    }
    bar.finish();
    let described = describe(&root, options.shard.is_some(), &diagnostics);
    let seconds = start.elapsed().as_secs_f64();
    if !options.quiet {
        say!("\n{table} in {}; {seconds:.0} s", root.display());
    }
    if options.json {
        let (made, kept, failed) = table.counts();
        out!(
            "{}",
            json!({"made": made, "kept": kept, "failed": failed, "seconds": seconds, "peak_rss_bytes": peak_rss_bytes()})
        )?;
    }
    match table.counts() {
        (_, _, 0) => described,
        // The catalog is written again when these are corrected.
        (made, kept, failed) => Err(Failure::Failed(format!(
            "{failed} of {} jobs failed; correct what they report and run the same command again, which renders only these",
            made + kept + failed
        ))),
    }
}

/// Describes the dataset in its root. Of parts that are made at the same time, the last one describes the whole.
fn describe(root: &Path, is_part: bool, diagnostics: &dyn Diagnostics) -> Result<(), Failure> {
    if is_part {
        let whole = finished(root)?;
        if whole.finished < whole.of {
            return Ok(());
        }
    }
    write_catalog(root, diagnostics)?;
    Ok(())
}

/// What the options mean.
fn plan(options: &DatasetOptions) -> Result<DatasetPlan, Failure> {
    let (cameras, settings) = options.settings()?;
    cameras.check(&settings)?;
    let names = match options.scenes.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        // Who names scenes of his own wants these.
        [] if !options.glb.is_empty() && !options.gallery => Some(&[][..]),
        [] => None,
        [NONE] => Some(&[][..]),
        _ => Some(&options.scenes[..]),
    };
    let sources = sources(names, &options.glb)?;
    Ok(DatasetPlan::new(&sources, cameras, settings, options.collection.engine.settings())?)
}
