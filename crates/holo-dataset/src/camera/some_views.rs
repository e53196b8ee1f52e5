//! Disparity from some of the views of a grid.

use holo_core::{
    DisparityEstimate, LightField, OffsetView, PlaneSweepOptions, Sample, ViewIndex, plane_sweep_of_views,
};
use ndarray::Data;

use crate::Error;

/// Estimates the disparity of a view of a grid from some of the others. `taken` says of each view where it is in the light field,
/// which may have no others, and where in the grid.
///
/// # Errors
///
/// [`Error::BadRequest`] if the view itself is not among them; those of [`plane_sweep_of_views`].
pub fn estimate_from_views<S>(
    light_field: &LightField<S>,
    taken: &[(ViewIndex, ViewIndex)],
    of: ViewIndex,
    options: &PlaneSweepOptions,
) -> Result<DisparityEstimate, Error>
where
    S: Data,
    S::Elem: Sample,
{
    let Some((own, _)) = taken.iter().find(|(_, view)| *view == of) else {
        let (column, row) = (of.column, of.row);
        return Err(Error::BadRequest(format!(
            "the view in column {column}, row {row}, whose disparity is estimated, is not among the views"
        )));
    };
    let others = taken.iter().filter(|(_, view)| *view != of).map(|(at, view)| {
        let (down, right) = (view.row as f64 - of.row as f64, view.column as f64 - of.column as f64);
        Ok(OffsetView { down, right, image: light_field.view(at.row, at.column)? })
    });
    let others = others.collect::<Result<Vec<_>, holo_core::Error>>()?;
    Ok(plane_sweep_of_views(light_field.view(own.row, own.column)?, &others, options)?)
}
