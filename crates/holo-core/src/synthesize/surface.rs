//! Disparity maps as surfaces, and where the line of a pixel of another view meets them.

use ndarray::{ArrayView2, Axis};

use super::ViewDisparities;
use super::fill::{STEP_PX, fill};
use crate::base::memory::filled;
use crate::base::parallel::*;
use crate::{BaselineRatio, Error, GridSize, LightFieldShape, ViewIndex};

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
                return Surface::widened(map);
            }
            ViewDisparities::OfView(map, at) => {
                let from = Surface::widened(map)?;
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

/// The least and the greatest finite value.
pub(super) fn span(values: &mut dyn Iterator<Item = f32>) -> [f64; 2] {
    values
        .filter(|x| x.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(f64::from(x)), high.max(f64::from(x))])
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

/// The square between four pixels, by its first row and column.
type Cell = [isize; 2];

impl Surface {
    /// The surface of a map whose nearer surfaces are a pixel wider: pixels that their edges cross show both surfaces, and move with
    /// the nearer.
    pub fn widened(map: ArrayView2<'_, f32>) -> Result<Self, Error> {
        let (rows, columns) = map.dim();
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
        Ok(Self { map: wide, size: [rows, columns] })
    }

    /// Its disparities, row by row.
    pub fn into_map(self) -> Vec<f32> {
        self.map
    }

    /// The disparity of a pixel.
    pub fn of_pixel(&self, row: usize, column: usize) -> f32 {
        self.map[row * self.size[1] + column]
    }

    /// The disparities of the four pixels around a cell, and whether they belong to one surface.
    fn corners(&self, cell: Cell) -> ([f64; 4], bool) {
        let pixel = |axis: usize, k: isize| (cell[axis] + k).clamp(0, self.size[axis] as isize - 1) as usize;
        let corners = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(k, l)| self.of_pixel(pixel(0, k), pixel(1, l)));
        let [a, b, c, d] = corners;
        let spread = a.max(b).max(c).max(d) - a.min(b).min(c).min(d);
        (corners.map(f64::from), spread <= STEP_PX && !(a + b + c + d).is_nan())
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
        if line.step == [0.0; 2] {
            let [row, column] = [0, 1].map(|axis| line.from[axis].round());
            let is_inside = row >= 0.0 && row < self.size[0] as f64 && column >= 0.0 && column < self.size[1] as f64;
            let disparity_px = is_inside.then(|| f64::from(self.of_pixel(row as usize, column as usize)));
            return disparity_px.filter(|x| x.is_finite());
        }
        let [low_px, high_px] = self.crossed(line, [range_px[0] - MEETS_PX, range_px[1] + MEETS_PX])?;
        let start = line.at(high_px);
        let mut cell: Cell = start.map(|x| x.floor() as isize);
        for axis in 0..2 {
            // A line that begins on the border of two cells and goes to lower places leaves the second.
            if line.step[axis] > 0.0 && start[axis] == cell[axis] as f64 {
                cell[axis] -= 1;
            }
        }
        let mut near_px = high_px;
        loop {
            let (mut far_px, mut next) = (low_px, None);
            for axis in (0..2).filter(|&axis| line.step[axis] != 0.0) {
                let border = if line.step[axis] > 0.0 { cell[axis] } else { cell[axis] + 1 };
                let at_px = (border as f64 - line.from[axis]) / line.step[axis];
                if at_px > far_px {
                    (far_px, next) = (at_px.min(near_px), Some(axis));
                }
            }
            let found = match self.corners(cell) {
                (corners, true) => meets_surface(corners, cell, line, [far_px, near_px]),
                (corners, false) => meets_pixels(corners, cell, line, [far_px, near_px]),
            };
            if found.is_some() {
                return found;
            }
            let axis = next?;
            cell[axis] += if line.step[axis] > 0.0 { -1 } else { 1 };
            near_px = far_px;
        }
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

/// Where a line meets a surface from the front that is linear between four pixels.
fn meets_surface([a, b, c, d]: [f64; 4], cell: Cell, line: &Line, [far_px, near_px]: [f64; 2]) -> Option<f64> {
    // How far the surface is nearer than the line: below 0 before it.
    let above = |disparity_px: f64| {
        let place = line.at(disparity_px);
        let [down, along] = [0, 1].map(|axis| place[axis] - cell[axis] as f64);
        let (top, bottom) = (a + (b - a) * along, c + (d - c) * along);
        top + (bottom - top) * down - disparity_px
    };
    let (before, after) = (above(near_px), above(far_px));
    if !(before <= MEETS_PX && after >= 0.0) {
        return None;
    }
    if before >= 0.0 {
        return Some(near_px);
    }
    // Exact on a plane.
    let between = near_px + (far_px - near_px) * before / (before - after);
    if above(between).abs() < MEETS_PX / 100.0 {
        return Some(between);
    }
    let (mut front, mut back) = (near_px, far_px);
    for _ in 0..24 {
        let middle = (front + back) / 2.0;
        if above(middle) < 0.0 { front = middle } else { back = middle }
    }
    Some(back)
}

/// Where a line meets one of four pixels of several surfaces from the front: each pixel has the same disparity everywhere.
fn meets_pixels(corners: [f64; 4], cell: Cell, line: &Line, [far_px, near_px]: [f64; 2]) -> Option<f64> {
    // Where it goes from a pixel to the next.
    let mut ends = [near_px, near_px, far_px];
    for axis in (0..2).filter(|&axis| line.step[axis] != 0.0) {
        ends[axis] = ((cell[axis] as f64 + 0.5 - line.from[axis]) / line.step[axis]).clamp(far_px, near_px);
    }
    ends[..2].sort_by(|a, b| b.total_cmp(a));
    let mut near_px = near_px;
    for far_px in ends {
        let place = line.at((near_px + far_px) / 2.0);
        let [down, along] = [0, 1].map(|axis| usize::from(place[axis] - cell[axis] as f64 >= 0.5));
        let disparity_px = corners[2 * down + along];
        if far_px <= disparity_px && disparity_px <= near_px + MEETS_PX {
            return Some(disparity_px.min(near_px));
        }
        near_px = far_px;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The disparity at a place, by its definition.
    fn at(surface: &Surface, place: [f64; 2]) -> f64 {
        let cell = place.map(|x| x.floor() as isize);
        let ([a, b, c, d], is_smooth) = surface.corners(cell);
        let [down, along] = [0, 1].map(|axis| place[axis] - cell[axis] as f64);
        if is_smooth {
            return (a * (1.0 - along) + b * along) * (1.0 - down) + (c * (1.0 - along) + d * along) * down;
        }
        [a, b, c, d][2 * usize::from(down >= 0.5) + usize::from(along >= 0.5)]
    }

    /// Lines meet surfaces where steps of 1e-3 px along them do: slanted ones, steps, thin ones and pixels without a number.
    #[test]
    fn lines_meet_surfaces_where_small_steps_do() {
        let size = [12, 15];
        let (mut hits, mut apart, mut lines) = (0, 0, 0);
        let mut state = 7u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for _ in 0..40 {
            let [slant_v, slant_u] = [random() * 0.3 - 0.15, random() * 0.3 - 0.15];
            let value = |k: usize, near: f64| {
                let (v, u) = (k / size[1], k % size[1]);
                (slant_v * v as f64 + slant_u * u as f64 + if near < 0.2 { 3.0 } else { 0.0 }) as f32
            };
            let mut map: Vec<f32> = (0..size[0] * size[1]).map(|k| value(k, random())).collect();
            map[(random() * 180.0) as usize] = f32::NAN;
            let surface = Surface { map, size };
            for _ in 0..50 {
                let line = Line {
                    from: [(random() * 12.0).floor(), (random() * 15.0).floor()],
                    step: [random() * 2.0 - 1.0, random() * 2.0 - 1.0],
                };
                let range_px = [-5.0, 8.0];
                let found = surface.meets(&line, range_px);
                let [low_px, high_px] = surface.crossed(&line, range_px).expect("its own pixel is within the view");
                let above = |px: f64| at(&surface, line.at(px)) - px;
                let count = ((high_px - low_px) / 1e-3) as usize;
                let place = |k: usize| high_px - k as f64 * 1e-3;
                let meets = |k: usize| above(place(k)) < 0.0 && (0.0..4e-3).contains(&above(place(k + 1)));
                let expected = (0..count).find(|&k| meets(k)).map(place);
                lines += 1;
                hits += usize::from(found.is_some());
                apart += match (found, expected) {
                    (Some(found), Some(expected)) => usize::from((found - expected).abs() > 3e-3),
                    (found, expected) => usize::from(found.is_some() != expected.is_some()),
                };
            }
        }
        // Lines that touch the corner of a pixel, or begin on a surface at the border, are met or not by rounding.
        assert!(hits > lines / 2 && apart * 200 < lines, "{apart} of {lines}, {hits} hits");
    }
}
