//! `holo dataset`: scenes times splits, each a folder of its own; what is done stays done.

mod config;
mod describe;
mod plan;
mod table;

use std::time::Instant;

use clap::ArgMatches;
use holo_render::{Backend, Renderer};
use serde_json::json;

use self::plan::Job;
use self::table::{Line, Table};
use super::output::OutputFolder;
use super::remarks::{OnceEach, Remarks};
use super::{job, prepare};
use crate::arguments::{DatasetOptions, EngineOptions};
use crate::console::{out, say};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Overall;
use crate::report::{RunJson, Seconds, peak_rss_bytes};

pub fn run(options: DatasetOptions, said: ArgMatches) -> Result<(), Failure> {
    let start = Instant::now();
    let (options, said) = config::complete(options, said)?;
    let root = options.out.clone().ok_or_else(|| {
        Failure::Usage("where to? give --out DIR, on the command line or as `out` in the file of --config".into())
    })?;
    job::refuse_what_cannot_be(&options.job)?;
    let jobs = plan::jobs(&options, &said)?;
    let bar = Overall::new(options.quiet);
    let remarks = OnceEach::above(&bar, options.quiet);
    let engine = engine_name(&options.engine, &remarks)?;

    // The root is described before anything is in it, so that a dataset that is half done can be checked too.
    let folder = OutputFolder::create_plain(&root)?;
    describe::write(&root, &options, &jobs, &said, &engine)?;
    folder.keep();

    let mine: Vec<(usize, &Job)> = jobs
        .iter()
        .enumerate()
        .filter(|(index, _)| options.shard.is_none_or(|shard| index % shard.of == shard.part - 1))
        .collect();
    bar.expect(mine.len());
    let mut table = Table::default();
    for (done, &(index, job)) in mine.iter().enumerate() {
        bar.begin(done, &job.name());
        let line = match run_job(&options, &root, job, &engine, &bar, &remarks.of_scene(&job.source.name())) {
            Ok(line) => line,
            Err(_) if interrupt::requested() => {
                return Err(Failure::Failed("stopped; the same command goes on".into()));
            }
            Err(failure) => Line::failed(job, failure.message()),
        };
        if !options.quiet {
            bar.above(|| say!("[{:>2}/{}] {}", index + 1, jobs.len(), line.text()));
        }
        if options.json {
            out!("{}", line.json())?;
        }
        table.push(line);
    }
    bar.finish();
    let seconds = start.elapsed().as_secs_f64();
    if !options.quiet {
        table.print(&root, seconds);
    }
    if options.json {
        let (made, kept, failed) = table.counts();
        out!(
            "{}",
            json!({"made": made, "kept": kept, "failed": failed, "seconds": seconds, "peak_rss_bytes": peak_rss_bytes()})
        )?;
    }
    match table.counts() {
        (_, _, 0) => Ok(()),
        (made, kept, failed) => Err(Failure::Failed(format!(
            "{failed} of {} jobs failed; mend what they say and run the same command again, which does these alone",
            made + kept + failed
        ))),
    }
}

/// Does one job, or finds that it is done.
fn run_job(
    options: &DatasetOptions,
    root: &std::path::Path,
    job: &Job,
    engine: &str,
    bar: &Overall,
    remarks: &dyn Remarks,
) -> Result<Line, Failure> {
    let start = Instant::now();
    let out = root.join(job.folder()?);
    let identity = job::identity(&job.source, &job.wish, engine)?;
    if let Some(manifest) = plan::done(&out, &identity) {
        return Ok(Line::kept(job, &manifest));
    }
    let folder = OutputFolder::create(&out)?;
    let prepared = job::prepare_job(&job.source, &job.wish, remarks)?;
    let rendering = Instant::now();
    let (traced, _) = job::trace(&job.source, &job.wish, &prepared, None, bar, remarks)?;
    let exposure_ev = prepared.renderer.install(|| job::exposure_ev(&options.job, &traced.rendered));
    let (rays, samples, integrator) = (traced.rendered.rays, traced.rendered.samples, traced.rendered.integrator);
    let (render, writing) = (rendering.elapsed().as_secs_f64(), Instant::now());
    let finished = prepared.renderer.install(|| job::write(&job.wish.options.job, traced, exposure_ev, folder))?;
    let seconds = Seconds {
        load: prepared.load_seconds,
        build: prepared.build_seconds,
        render,
        write: writing.elapsed().as_secs_f64(),
        total: start.elapsed().as_secs_f64(),
    };
    let run = RunJson { seconds, rays, samples, integrator, disparity_px: finished.disparity_px };
    let bytes = finished.files.iter().filter_map(|name| out.join(name).metadata().ok()).map(|file| file.len()).sum();
    Ok(Line::made(job, run, bytes, finished.files.len()))
}

/// The engine and its version, as manifests name it.
fn engine_name(options: &EngineOptions, remarks: &dyn Remarks) -> Result<String, Failure> {
    let backend: Backend = prepare::backend(options);
    let empty = holo_scene::Scene::default();
    let renderer = Renderer::new(&empty, &holo_scene::Transform::IDENTITY, backend, 1)?;
    prepare::remark_on_engine(&renderer, remarks);
    Ok(renderer.engine_name().to_owned())
}
