//! `holo depth`: disparity of the central view, estimated from the others, or depth of a camera of an array.

use std::iter;
use std::path::Path;
use std::time::Instant;

use holo_core::{DisparityEstimate, PlaneSweepOptions, Rig, ViewIndex, for_each_sample, plane_sweep};
use holo_dataset::{ArrayViewpoint, estimate_depth, estimate_from_views};
use holo_io::{ArrayFolder, EntryKind, Folder, HciSubset, Limits, WorldUp};
use ndarray::Array2;

use super::files;
use crate::arguments::DepthOptions;
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &DepthOptions) -> Result<(), Failure> {
    if ArrayFolder::is_one(&options.input.input) {
        return of_array(options);
    }
    if options.camera.is_some() {
        let what = "it has no transforms.json, so --camera has no meaning";
        return Err(Failure::Usage(format!("{}: {what}", options.input.input.display())));
    }
    let Some(subset) = some_views(&options.input.input)? else {
        return of_light_field(options);
    };
    if !options.quiet {
        say!("note: reads {} of the views of {}", subset.views().len(), subset.path().display());
    }
    let field = subset.read(&Limits::default())?;
    let parameters = subset.parameters();
    let range = parameters.disp_min.zip(parameters.disp_max);
    let rig = subset.rig().ok();
    let wanted = options.subset.as_ref().map(|wanted| wanted.views(subset.shape().views()));
    let is_wanted = |view: &ViewIndex| wanted.as_ref().is_none_or(|wanted| wanted.contains(view));
    let there = subset.views().iter().enumerate().filter(|(_, view)| is_wanted(view));
    let taken: Vec<_> = there.map(|(k, &view)| (ViewIndex::new(0, k), view)).collect();
    let (row, column) = subset.shape().central_view();
    let sweep = sweep(options, range, rig.as_ref())?;
    let start = Instant::now();
    let estimate = for_each_sample!(DynLightField, &field, field => estimate_from_views(field, &taken, ViewIndex::new(row, column), &sweep))?;
    finish(options, &estimate, start, &of_some(taken.len(), subset.shape().views().count()), &sweep)
}

/// A folder, or the `hci` folder in it, of which some views are missing.
fn some_views(input: &Path) -> Result<Option<HciSubset>, Failure> {
    let inner = Folder::open(input).is_ok_and(|folder| matches!(folder.kind("hci"), Ok(Some(EntryKind::Folder))));
    for folder in iter::once(input.to_owned()).chain(inner.then(|| input.join("hci"))) {
        if folder.is_dir()
            && let Ok(subset) = HciSubset::open(&folder)
        {
            let is_whole = subset.views().len() == subset.shape().views().count();
            return Ok((!is_whole).then_some(subset));
        }
    }
    Ok(None)
}

fn of_light_field(options: &DepthOptions) -> Result<(), Failure> {
    let reader = files::open(&options.input.input, &options.input)?;
    if !options.quiet {
        files::say_source(&reader);
    }
    let file = files::read_samples(reader)?;
    let sweep = sweep(options, file.disparity_range_px, file.rig.as_ref())?;
    let shape = file.light_field.shape();
    let views = shape.views();
    let start = Instant::now();
    if let Some(subset) = &options.subset {
        let (row, column) = shape.central_view();
        let taken: Vec<_> = subset.views(views).into_iter().map(|view| (view, view)).collect();
        let estimate = for_each_sample!(DynLightField, &file.light_field, field => estimate_from_views(field, &taken, ViewIndex::new(row, column), &sweep))?;
        return finish(options, &estimate, start, &of_some(taken.len(), views.count()), &sweep);
    }
    let estimate = for_each_sample!(DynLightField, &file.light_field, field => plane_sweep(field, &sweep))?;
    finish(options, &estimate, start, &format!("of {} x {} views", views.columns, views.rows), &sweep)
}

fn of_some(taken: usize, all: usize) -> String {
    format!("of {taken} of {all} views")
}

/// The range and the effort of the options; without a range that of the files.
fn sweep(options: &DepthOptions, known: Option<(f64, f64)>, rig: Option<&Rig>) -> Result<PlaneSweepOptions, Failure> {
    let mut sweep = PlaneSweepOptions::default().effort(options.effort);
    if let Some(rig) = rig {
        sweep = sweep.baseline_ratio(rig.baseline_ratio());
    }
    let range = match (options.depths_m, rig) {
        (Some((near_m, far_m)), Some(rig)) => {
            let disparity = rig.disparity_x();
            Some((disparity.from_depth_m(far_m), disparity.from_depth_m(near_m)))
        }
        (Some(_), None) => {
            let what = "the camera parameters are unknown, so depths in meters have no meaning; give --range";
            return Err(Failure::Usage(format!("{}: {what}", options.input.input.display())));
        }
        (None, _) => options.range.or(known),
    };
    match range {
        Some((min, max)) => Ok(sweep.range_px(min as f32, max as f32)),
        None => {
            if !options.quiet {
                say!("note: the disparity range is unknown; searching -4 to 4 px; set it with --range MIN,MAX");
            }
            Ok(sweep)
        }
    }
}

/// Writes the maps of a disparity, and says what was done.
fn finish(
    options: &DepthOptions,
    estimate: &DisparityEstimate,
    start: Instant,
    views: &str,
    sweep: &PlaneSweepOptions,
) -> Result<(), Failure> {
    let range = format!("between {} and {} px", sweep.disparity_min_px, sweep.disparity_max_px);
    write(options, &estimate.disparity_px, &estimate.confidence, start, &format!("the central one {views} {range}"))
}

fn write(
    options: &DepthOptions,
    map: &Array2<f32>,
    confidence: &Array2<f32>,
    start: Instant,
    what: &str,
) -> Result<(), Failure> {
    let seconds = start.elapsed().as_secs_f64();
    holo_io::write_pfm(&options.out, map.view())?;
    if let Some(path) = &options.confidence {
        holo_io::write_pfm(path, confidence.view())?;
    }
    if let Some(path) = &options.runtime {
        holo_io::write_file(path, format!("{seconds:.3}\n").as_bytes())?;
    }
    if !options.quiet {
        say!("estimated {what} in {seconds:.1} s: {}", options.out.display());
    }
    Ok(())
}

/// The depth of a camera of an array, or of a view of light fields at poses.
fn of_array(options: &DepthOptions) -> Result<(), Failure> {
    let folder = options.input.input.display();
    let Some((near_m, far_m)) = options.depths_m else {
        return Err(Failure::Usage(format!("{folder}: cameras anywhere have no disparity; give --depths-m NEAR,FAR")));
    };
    if options.subset.is_some() {
        return Err(Failure::Usage(format!("{folder}: its cameras do not form a grid, so --subset has no meaning")));
    }
    // Which axis points up does not matter to depth.
    let array = ArrayFolder::open(&options.input.input, WorldUp::Y)?;
    let k = match &options.camera {
        Some(name) => files::camera_named(&array, "--camera", name)?,
        None => ArrayViewpoint::default().nearest(&array)?,
    };
    let start = Instant::now();
    let found = estimate_depth(&array, k, [near_m, far_m], options.effort)?;
    let name = holo_core::visible(&array.cameras()[k].name);
    let what = format!("the depth of {name} from {} cameras in its plane between {near_m} and {far_m} m", found.others);
    write(options, &found.depth_m, &found.confidence, start, &what)
}
