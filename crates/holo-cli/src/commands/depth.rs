//! `holo depth`: disparity of the central view, estimated from the others.

use std::time::Instant;

use holo_core::{PlaneSweepOptions, for_each_sample, plane_sweep};

use super::files;
use crate::arguments::DepthOptions;
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &DepthOptions) -> Result<(), Failure> {
    let reader = files::open(&options.input.input, &options.input)?;
    if !options.quiet {
        files::say_source(&reader);
    }
    let file = files::read_samples(reader)?;
    let mut sweep = PlaneSweepOptions::default().effort(options.effort);
    if let Some((min, max)) = options.range.or(file.disparity_range_px) {
        sweep = sweep.range_px(min as f32, max as f32);
    } else if !options.quiet {
        say!("note: the disparity range is unknown; searching -4 to 4 px; set it with --range MIN,MAX");
    }
    if let Some(rig) = &file.rig {
        sweep = sweep.baseline_ratio(rig.baseline_ratio());
    }
    let start = Instant::now();
    let estimate = for_each_sample!(DynLightField, &file.light_field, field => plane_sweep(field, &sweep))?;
    let seconds = start.elapsed().as_secs_f64();
    holo_io::write_pfm(&options.out, estimate.disparity_px.view())?;
    if let Some(path) = &options.confidence {
        holo_io::write_pfm(path, estimate.confidence.view())?;
    }
    if let Some(path) = &options.runtime {
        holo_io::write_file(path, format!("{seconds:.3}\n").as_bytes())?;
    }
    if !options.quiet {
        let views = file.light_field.shape().views();
        let (min, max) = (sweep.disparity_min_px, sweep.disparity_max_px);
        say!(
            "estimated the central one of {} x {} views between {min} and {max} px in {seconds:.1} s: {}",
            views.columns,
            views.rows,
            options.out.display()
        );
    }
    Ok(())
}
