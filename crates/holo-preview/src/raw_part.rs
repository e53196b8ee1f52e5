//! Which part of the raw image is shown at its real size.

use std::ops::Range;

use holo_core::{GridSize, Intrinsics, LightFieldShape, Rig};
use holo_dataset::{Camera, Prepared, RenderJob};

use crate::job::Ended;

/// Columns and rows that are shown at most, px.
const MOST: [usize; 2] = [1500, 240];

/// Rows of pixels that are shown of a rig, or one row of microlenses.
const ROWS: usize = 110;

/// A part of the raw image.
pub(crate) struct RawPart {
    /// The rig of the microlenses in the middle alone, where those are shown.
    pub rig: Option<Rig>,
    /// The rows to render: of microlenses of a rig, else of pixels.
    pub rows: Range<usize>,
    /// The columns of pixels that are shown of what is rendered.
    pub columns: Range<usize>,
    /// The column of the raw image that is shown first, px.
    pub first: usize,
    /// The first row that is rendered, in the whole raw image: of microlenses of a rig, else of pixels.
    pub first_row: usize,
    /// The row of the microlens in the middle.
    pub row: usize,
    /// Pixels from one micro-image to the next.
    pub pitch_px: f64,
}

/// What a part of the raw image took.
pub(crate) struct Strip {
    pub samples: f64,
    pub seconds: f64,
}

impl RawPart {
    /// The part around the microlens (column, row) `lens` of a rig, or around the middle.
    pub fn new(job: &RenderJob, prepared: &Prepared, lens: Option<[usize; 2]>) -> Result<Self, Ended> {
        match (&job.settings.camera, prepared.rig(), lens) {
            (Camera::Plenoptic(file), _, _) => {
                let size = file.camera.sensor().size;
                let [columns, row] = [middle(size.columns, MOST[0]), middle(size.rows, MOST[1])];
                let (first, pitch_px) = (columns.start, file.camera.micro_image_pitch_px());
                let middle = (row.start + row.end) / 2;
                Ok(Self { rig: None, first_row: row.start, row: middle, rows: row, columns, first, pitch_px })
            }
            (_, Some(rig), None) => of_middle(rig).map_err(|why| Ended::Failed(why.to_string())),
            (_, Some(rig), Some(lens)) => Ok(around(rig, lens)),
            _ => Err(Ended::Failed("the camera has no raw image".into())),
        }
    }
}

/// The middle of a length.
fn middle(length: usize, most: usize) -> Range<usize> {
    let first = length.saturating_sub(most) / 2;
    first..length.min(first + most)
}

/// The microlenses in the middle of a rig, as a rig of their own: nothing else is rendered.
fn of_middle(rig: &Rig) -> Result<RawPart, holo_core::Error> {
    let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
    // The middle stays in the middle if as many are left out on both sides.
    let few = |count: usize, most: usize| {
        let most = most.clamp(1, count);
        if (count - most).is_multiple_of(2) { most } else { most + 1 }
    };
    let part = GridSize::new(few(lenses.rows, ROWS / views.rows), few(lenses.columns, MOST[0] / views.columns));
    let larger = |size: GridSize| size.rows.max(size.columns) as f64;
    let Intrinsics { focal_length_m, sensor_size_m } = rig.intrinsics();
    let sensor_size_m = sensor_size_m / larger(lenses) * larger(part);
    let own = rig
        .to_builder()
        .shape(LightFieldShape::new(views, part)?)
        .intrinsics(Intrinsics { focal_length_m, sensor_size_m })
        .build()?;
    let first_row = (lenses.rows - part.rows) / 2;
    // Of two rows in the middle the second one is enough.
    let rows = if part.rows == 2 && views.rows > ROWS / 2 { 1..2 } else { 0..part.rows };
    Ok(RawPart {
        rig: Some(own),
        first_row: first_row + rows.start,
        rows,
        columns: 0..part.columns * views.columns,
        first: (lenses.columns - part.columns) / 2 * views.columns,
        row: lenses.rows / 2,
        pitch_px: views.columns as f64,
    })
}

/// The row of a microlens.
fn around(rig: &Rig, [column, row]: [usize; 2]) -> RawPart {
    let (views, lenses) = (rig.shape().views().columns, rig.shape().lenses());
    let (row, column) = (row.min(lenses.rows - 1), column.min(lenses.columns - 1));
    let row_count = (ROWS / rig.shape().views().rows).clamp(1, lenses.rows);
    let first_row = row.saturating_sub(row_count / 2).min(lenses.rows - row_count);
    let count = (MOST[0] / views).clamp(1, lenses.columns);
    let first = column.saturating_sub(count / 2).min(lenses.columns - count);
    RawPart {
        rig: None,
        rows: first_row..first_row + row_count,
        first_row,
        columns: first * views..(first + count) * views,
        first: first * views,
        row,
        pitch_px: views as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every ray of the part is a ray of the whole.
    #[test]
    fn the_middle_is_a_part_of_the_whole() {
        for (views, rows, columns) in [(100, 53, 79), (100, 8, 12), (100, 1, 1), (100, 2, 3), (9, 512, 512), (9, 3, 2)]
        {
            let shape = LightFieldShape::new(GridSize::new(views, views), GridSize::new(rows, columns)).unwrap();
            let rig = Rig::builder(shape).focal_length_m(0.05).baseline_m(1e-4).focus_distance_m(2.0).build().unwrap();
            let part = of_middle(&rig).unwrap();
            let own = part.rig.unwrap();
            let first = part.first / views;
            assert!((part.first_row..part.first_row + part.rows.len()).contains(&part.row));
            for (u, t, s) in [(0, 0, 0), (own.shape().lenses().columns - 1, views / 2, views - 1)] {
                let ray = own.ray(part.rows.start, u, t, s, 0.25, 0.75);
                let whole = rig.ray(part.first_row, first + u, t, s, 0.25, 0.75);
                for (a, b) in ray.direction.iter().zip(whole.direction) {
                    assert!((a - b).abs() < 1e-12, "{rows} x {columns}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn a_microlens_at_the_edge_is_shown() {
        let shape = LightFieldShape::new(GridSize::new(100, 100), GridSize::new(53, 79)).unwrap();
        let part = around(&Rig::builder(shape).build().unwrap(), [78, 99]);
        assert_eq!((part.rows, part.first, part.columns), (52..53, 6400, 6400..7900));
    }
}
