//! `holo render`: scene in, folder of images and ground truth out.

use std::time::Instant;

use holo_render::Integrator;

use super::asked::Wish;
use super::output::OutputFolder;
use super::remarks::Plain;
use super::source::Source;
use super::{job, part};
use crate::console::out;
use crate::failure::Failure;
use crate::progress::Bar;
use crate::report::{Report, Seconds};

pub fn run(wish: &Wish) -> Result<(), Failure> {
    let options = &wish.options;
    let start = Instant::now();
    job::refuse_what_cannot_be(&options.job)?;
    let folder = OutputFolder::create(&options.out)?;
    let source = Source::File(options.scene.clone());
    let remarks = Plain { quiet: options.quiet };
    let prepared = job::prepare_job(&source, wish, &remarks)?;

    let rendering = Instant::now();
    let bar = Bar::new("rendering", options.quiet);
    let traced = job::trace(&source, wish, &prepared, options.shard, &bar, &remarks);
    bar.finish();
    let (traced, _) = traced?;
    let (rays, samples, integrator) = (traced.rendered.rays, traced.rendered.samples, traced.rendered.integrator);
    let why = traced.rendered.why.clone();
    let (exposure_ev, finished, render, writing);
    if let Some(shard) = options.shard {
        (render, writing) = (rendering.elapsed(), Instant::now());
        finished = prepared.renderer.install(|| part::write(traced, shard, folder))?;
    } else {
        exposure_ev = prepared.renderer.install(|| job::exposure_ev(&options.job, &traced.rendered));
        (render, writing) = (rendering.elapsed(), Instant::now());
        finished = prepared.renderer.install(|| job::write(&options.job, traced, exposure_ev, folder))?;
    }
    let split = *prepared.rig.split();
    let report = Report {
        seconds: Seconds {
            load: prepared.load_seconds,
            build: prepared.build_seconds,
            render: render.as_secs_f64(),
            write: writing.elapsed().as_secs_f64(),
            total: start.elapsed().as_secs_f64(),
        },
        rays,
        samples: match integrator {
            Integrator::Depth => split.views().count() as u64 * split.lenses().count() as u64,
            _ => samples,
        },
        backend: prepared.renderer.engine_name(),
        threads: prepared.renderer.threads(),
        integrator,
        why: &why,
        rig: &prepared.rig,
        disparity_px: finished.disparity_px,
        files: &finished.files,
    };
    if !options.quiet {
        report.print(&options.out);
    }
    if options.json {
        out!("{}", report.json())?;
    }
    Ok(())
}
