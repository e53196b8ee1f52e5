//! `holo synthesize`: the view of a place between the views.
//!
//! Light is blended, not codes: the sRGB curve of integers is undone first and put back at the end.

use holo_core::{DynImage, GridSize, ViewDisparities, ViewIndex, ViewSynthesis, plane_sweep};
use holo_io::{LightFieldReader, Limits};
use ndarray::{Array2, Array4};

use super::{array_view, files};
use crate::arguments::{DisparityArgument, SynthesizeOptions};
use crate::console::say;
use crate::failure::{Failure, wrong_option};

/// Disparities that were read or estimated.
enum Maps {
    Off,
    Central(Array2<f32>),
    All(Array4<f32>),
}

pub fn run(options: &SynthesizeOptions) -> Result<(), Failure> {
    if let Some(array) = array_view::opened(&options.input, &options.viewpoint)? {
        return array_view::synthesize(options, &array);
    }
    let reader = files::open(&options.input.input, &options.input)?;
    files::say_source(&reader);
    let shape = reader.shape();
    let at = options.at.ok_or_else(|| Failure::Usage("give --at S,T: a column and a row of views".into()))?;
    check_place(at, shape.views())?;
    let read = read_maps(&reader, options)?;
    let file = files::read_samples(reader)?;
    let source = file.light_field.kind();
    let (rig, sweep) = (file.rig, file.plane_sweep_options());
    let field = file.light_field.without_alpha()?.into_linear(file.color_encoding)?;
    let maps = match read {
        Some(maps) => maps,
        None => {
            say!(
                "note: disparities are estimated between {} and {} px",
                sweep.disparity_min_px,
                sweep.disparity_max_px
            );
            Maps::Central(plane_sweep(&field, &sweep)?.disparity_px)
        }
    };
    let (t, s) = shape.central_view();
    let disparities = match &maps {
        Maps::Off => ViewDisparities::Plane(0.0),
        Maps::Central(map) => ViewDisparities::OfView(map.view(), ViewIndex { row: t, column: s }),
        Maps::All(maps) => ViewDisparities::OfAll(maps.view()),
    };
    let mut synthesis = ViewSynthesis::default().kernel(options.kernel);
    if let Some(rig) = &rig {
        synthesis = synthesis.baseline_ratio(rig.baseline_ratio());
    }
    let [s, t] = at;
    let view = synthesis.at(&field, disparities, (t, s)).map_err(wrong_option)?;
    let kind = files::kind_of(&options.out, source);
    files::write(&options.out, &DynImage::from_linear(view.image.view(), kind)?)?;
    files::write_holes(&options.out, &view.holes)
}

/// Refuses a place (column, row) outside of the grid of views.
fn check_place([s, t]: [f64; 2], views: GridSize) -> Result<(), Failure> {
    let is_inside = |at: f64, count: usize| (0.0..=(count - 1) as f64).contains(&at);
    if is_inside(s, views.columns) && is_inside(t, views.rows) {
        return Ok(());
    }
    let (columns, rows) = (views.columns, views.rows);
    Err(Failure::Usage(format!(
        "--at {s},{t}: outside of the grid of {columns} x {rows} views; columns are 0 to {}, rows 0 to {}",
        columns - 1,
        rows - 1
    )))
}

/// The disparities of files; `None` if they are to be estimated.
fn read_maps(reader: &LightFieldReader, options: &SynthesizeOptions) -> Result<Option<Maps>, Failure> {
    let truth = || -> Result<Option<Maps>, Failure> {
        if let Some(maps) = reader.disparity_px_of_views()? {
            return Ok(Some(Maps::All(maps)));
        }
        Ok(reader.central_disparity_px()?.map(Maps::Central))
    };
    match &options.disparity {
        None => truth(),
        Some(DisparityArgument::Estimate) => Ok(None),
        Some(DisparityArgument::Off) => Ok(Some(Maps::Off)),
        Some(DisparityArgument::File(path)) => {
            Ok(Some(Maps::Central(holo_io::read_pfm_gray(path, &Limits::default())?)))
        }
        Some(DisparityArgument::Truth) => {
            let missing = || {
                let input = options.input.input.display();
                Failure::Usage(format!(
                    "{input}: it has no disparity map; render with `--write disparity --ground-truth all`, or give --disparity estimate"
                ))
            };
            Ok(Some(truth()?.ok_or_else(missing)?))
        }
    }
}
