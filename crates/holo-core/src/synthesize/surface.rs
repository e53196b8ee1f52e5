//! Disparity maps as surfaces, and where the line of a pixel of another view meets them.

use ndarray::{ArrayView2, Axis};

use super::ViewDisparities;
use super::fill::fill;
use crate::memory::filled;
use crate::parallel::*;
use crate::{BaselineRatio, Error, GridSize, LightFieldShape, ViewIndex};

/// Neighboring pixels whose disparities differ by more belong to different surfaces, px.
pub(super) const STEP_PX: f32 = 0.5;

/// Steps of a line are this long, px.
const STRIDE_PX: f64 = 0.5;

/// How near a line comes to a surface that it meets, px.
const MEETS_PX: f64 = 1e-3;

/// The disparity maps of a light field.
pub(super) struct Maps<'a> {
    disparities: ViewDisparities<'a>,
    shape: LightFieldShape,
    range_px: [f64; 2],
}

impl<'a> Maps<'a> {
    pub fn new(shape: LightFieldShape, disparities: ViewDisparities<'a>) -> Result<Self, Error> {
        let (lenses, views) = (shape.lenses(), shape.views());
        let wrong = |expected: &[usize], found: &[usize]| {
            Err(Error::Shape { what: "disparity map", expected: expected.to_vec(), found: found.to_vec() })
        };
        let span = |values: &mut dyn Iterator<Item = f32>| {
            values.filter(|x| x.is_finite()).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(f64::from(x)), high.max(f64::from(x))]
            })
        };
        let range_px = match disparities {
            ViewDisparities::Plane(disparity_px) => [disparity_px; 2],
            ViewDisparities::OfView(map, view) => {
                if map.dim() != (lenses.rows, lenses.columns) {
                    return wrong(&[lenses.rows, lenses.columns], map.shape());
                }
                for (what, index, count) in
                    [("view row", view.row, views.rows), ("view column", view.column, views.columns)]
                {
                    if index >= count {
                        return Err(Error::OutOfRange { what, index, count, first: 0 });
                    }
                }
                span(&mut map.iter().copied())
            }
            ViewDisparities::OfAll(maps) => {
                let expected = [lenses.rows, lenses.columns, views.rows, views.columns];
                if maps.shape() != expected {
                    return wrong(&expected, maps.shape());
                }
                span(&mut maps.iter().copied())
            }
        };
        if !(range_px[0].is_finite() && range_px[1].is_finite()) {
            return Err(Error::BadNumber { what: "disparity in pixels", value: f64::NAN, need: "a number somewhere" });
        }
        Ok(Self { disparities, shape, range_px })
    }

    /// The least and the greatest disparity.
    pub fn range_px(&self) -> [f64; 2] {
        self.range_px
    }

    pub fn views(&self) -> GridSize {
        self.shape.views()
    }

    /// The surface that a view sees.
    pub fn surface(&self, view: ViewIndex, ratio: BaselineRatio) -> Result<Surface, Error> {
        let size = [self.shape.lenses().rows, self.shape.lenses().columns];
        let map = match self.disparities {
            ViewDisparities::Plane(disparity_px) => filled("a disparity map", size[0] * size[1], disparity_px as f32)?,
            ViewDisparities::OfAll(maps) => {
                let map = maps.index_axis_move(Axis(3), view.column).index_axis_move(Axis(2), view.row);
                widened(map, size)?
            }
            ViewDisparities::OfView(map, at) => {
                let from = Surface { map: widened(map, size)?, size };
                if at == view {
                    return Ok(from);
                }
                let away = [at.row as f64 - view.row as f64, at.column as f64 - view.column as f64];
                from.seen_from([-away[0] * ratio.vertical(), -away[1] * ratio.horizontal()], self.range_px)?
            }
        };
        Ok(Surface { map, size })
    }
}

/// The disparity map of a view.
pub(super) struct Surface {
    map: Vec<f32>,
    size: [usize; 2],
}

/// The places of another view where a pixel may show a point: from a place, by a step for each pixel of disparity.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub from: [f64; 2],
    pub step: [f64; 2],
}

impl Line {
    pub fn at(&self, disparity_px: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.from[axis] + disparity_px * self.step[axis])
    }
}

/// A map whose nearer surfaces are a pixel wider: pixels that their edges cross show both surfaces, and move with the nearer.
fn widened(map: ArrayView2<'_, f32>, [rows, columns]: [usize; 2]) -> Result<Vec<f32>, Error> {
    let mut wide = filled("a disparity map", rows * columns, 0.0f32)?;
    wide.par_chunks_mut(columns).enumerate().for_each(|(row, pixels)| {
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let own = map[[row, column]];
            let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
            let nearest = near(row, rows)
                .flat_map(|row| near(column, columns).map(move |column| map[[row, column]]))
                .fold(own, f32::max);
            *pixel = if nearest - own > STEP_PX { nearest } else { own };
        }
    });
    Ok(wide)
}

impl Surface {
    /// The disparity of a pixel.
    pub fn of_pixel(&self, row: usize, column: usize) -> f32 {
        self.map[row * self.size[1] + column]
    }

    /// The disparity at a place: linear between the pixels of one surface, else that of the nearest pixel. NaN outside the view.
    fn at(&self, [row, column]: [f64; 2]) -> f64 {
        let [rows, columns] = self.size;
        let is_inside = row >= -0.5 && column >= -0.5 && row < rows as f64 - 0.5 && column < columns as f64 - 0.5;
        if !is_inside {
            return f64::NAN;
        }
        let cell = |at: f64, count: usize| {
            let at = at.clamp(0.0, (count - 1) as f64);
            let first = (at as usize).min(count.saturating_sub(2));
            (first, (first + 1).min(count - 1), at - first as f64)
        };
        let ((top, bottom, down), (left, right, along)) = (cell(row, rows), cell(column, columns));
        let [a, b, c, d] = [(top, left), (top, right), (bottom, left), (bottom, right)]
            .map(|(row, column)| self.of_pixel(row, column));
        let spread = a.max(b).max(c).max(d) - a.min(b).min(c).min(d);
        // Not for NaN: then the nearest pixel decides.
        if spread <= STEP_PX && !(a + b + c + d).is_nan() {
            let between = |x: f32, y: f32| f64::from(x) + (f64::from(y) - f64::from(x)) * along;
            return between(a, b) + (between(c, d) - between(a, b)) * down;
        }
        f64::from(match (down < 0.5, along < 0.5) {
            (true, true) => a,
            (true, false) => b,
            (false, true) => c,
            (false, false) => d,
        })
    }

    /// The part of a range of disparities at which a line lies within the view.
    fn crossed(&self, line: &Line, range_px: [f64; 2]) -> Option<[f64; 2]> {
        let [mut low, mut high] = range_px;
        for axis in (0..2).filter(|&axis| line.step[axis] != 0.0) {
            let ends = [-0.5, self.size[axis] as f64 - 0.5].map(|end| (end - line.from[axis]) / line.step[axis]);
            (low, high) = (low.max(ends[0].min(ends[1])), high.min(ends[0].max(ends[1])));
        }
        (low <= high).then_some([low, high])
    }

    /// The greatest disparity at which a line meets the surface from the front.
    pub fn meets(&self, line: &Line, range_px: [f64; 2]) -> Option<f64> {
        let slope = line.step[0].abs().max(line.step[1].abs());
        if slope == 0.0 {
            let disparity_px = self.at(line.from);
            return disparity_px.is_finite().then_some(disparity_px);
        }
        let [low_px, high_px] = self.crossed(line, range_px)?;
        // How far the surface is nearer than the line: below 0 before it, NaN outside.
        let above = |disparity_px: f64| self.at(line.at(disparity_px)) - disparity_px;
        let stride = STRIDE_PX / slope;
        let count = ((high_px - low_px) / stride).ceil().max(1.0) as usize;
        // Begun a little nearer than everything, ended a little behind.
        let margin = MEETS_PX.min(stride / 2.0);
        let place = |k: usize| (high_px + margin - stride * k as f64).max(low_px - margin);
        let (mut near, mut before) = (place(0), above(place(0)));
        for k in 1..=count + 1 {
            let (far, after) = (place(k), above(place(k)));
            if before < 0.0 && after >= 0.0 {
                // Exact on a plane, which most surfaces are between two steps.
                let between = near + (far - near) * before / (before - after);
                if above(between).abs() < MEETS_PX / 100.0 {
                    return Some(between);
                }
                let (mut front, mut back) = (near, far);
                for _ in 0..24 {
                    let middle = (front + back) / 2.0;
                    if above(middle) < 0.0 { front = middle } else { back = middle }
                }
                // Where the surface jumps instead, the line passes behind it.
                if above(back) < MEETS_PX && above(front) > -MEETS_PX {
                    return Some(back);
                }
            }
            (near, before) = (far, after);
        }
        None
    }

    /// The map of another view, which sees these points by `steps` pixels away for each pixel of disparity.
    fn seen_from(&self, steps: [f64; 2], range_px: [f64; 2]) -> Result<Vec<f32>, Error> {
        let [rows, columns] = self.size;
        let mut map = filled("a disparity map", rows * columns, f32::NAN)?;
        map.par_chunks_mut(columns).enumerate().for_each(|(row, pixels)| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let line = Line { from: [row as f64, column as f64], step: steps };
                if let Some(disparity_px) = self.meets(&line, range_px) {
                    *pixel = disparity_px as f32;
                }
            }
        });
        fill(&mut map, [rows, columns], &mut [], 0);
        Ok(map)
    }
}
