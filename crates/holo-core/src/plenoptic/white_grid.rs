//! How far the micro-images of a white image lie from those of the camera.

use std::ops::Range;

use ndarray::{ArrayView2, Axis};

use super::{MicrolensIndex, PlenopticCamera};
use crate::Error;

/// Tiles along the longer side of the sensor.
const TILES: usize = 17;

/// The radius of a tile's window, in pitches of micro-images.
const REACH: f64 = 4.0;

/// The least number of tiles.
const FEWEST_TILES: usize = 6;

/// The least part of the light of a tile that has the period of the array.
const LEAST_CONTRAST: f64 = 0.02;

/// Light above this part of what is usual in a tile does not count: the edges of micro-images tell where they lie, not how light falls off
/// within them, which depends on a pupil that may not be known.
const USUAL: f64 = 0.5;

/// How far the micro-images of a white image lie from those of a camera: a grid of another pitch, rotation and place.
///
/// # Units
///
/// Pixels and radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiteGrid {
    /// The largest distance of a micro-image from that of the camera, over the sensor, in pixels.
    pub largest_px: f64,
    /// The pitch of the white image in that of the camera.
    pub scale: f64,
    /// The rotation of the white image against the camera, counterclockwise in the image.
    pub rotation_rad: f64,
    /// How far the grid lies to the right and down in the middle of the sensor, in pixels.
    pub offset_px: [f64; 2],
}

/// The displacement of a grid over the sensor, in pixels to the right and down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Displacement {
    /// In the middle of the sensor, and per pixel to the right and down from there.
    x: [f64; 3],
    y: [f64; 3],
    /// How much the scale grows per pixel to the right and down, as that of a tilted array.
    growth: [f64; 2],
    /// Half of the sensor.
    middle_px: [f64; 2],
}

/// The displacement of a part of the grid.
#[derive(Clone, Copy)]
struct Tile {
    place_px: [f64; 2],
    shift_px: [f64; 2],
    /// The same by the edges of micro-images; `None` where they touch each other.
    of_edges_px: Option<[f64; 2]>,
    /// Two steps of the grid.
    steps_px: [[f64; 2]; 2],
}

impl PlenopticCamera {
    /// Compares the micro-images of a white image with those of this camera.
    ///
    /// `None`: there are too few micro-images (a side of a dozen), or the image has not the period of the array, not even nearly: a pitch that
    /// is off by a hundredth or more, an image of something else.
    ///
    /// # Shape
    ///
    /// Axes (row, column), the size of the sensor.
    ///
    /// # Accuracy
    ///
    /// 0.03 px and a fiftieth of the displacement for white images without noise, vignetted as those of this camera; the
    /// displacement is taken as linear over the sensor. Displacements by whole steps of the grid cannot be seen.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the image has not the size of the sensor; those of [`white_rows`](Self::white_rows).
    ///
    /// # Source
    ///
    /// The shift theorem: a displaced grid has other phases at the two frequencies of the grid, here within windows of some
    /// micro-images around the places where the camera has one; a plane fits the displacements.
    pub fn white_grid(&self, white: ArrayView2<f32>) -> Result<Option<WhiteGrid>, Error> {
        Ok(self.white_displacement(white, false)?.map(|displacement| displacement.grid()))
    }

    /// Checks that a white image has the size of the sensor.
    pub(super) fn check_white(&self, white: ArrayView2<f32>) -> Result<(), Error> {
        let size = self.sensor().size;
        if white.dim() == (size.rows, size.columns) {
            return Ok(());
        }
        let (expected, found) = (vec![size.rows, size.columns], white.shape().to_vec());
        Err(Error::Shape { what: "white image", expected, found })
    }

    /// The same as the displacement itself, with a growth of the scale if the array may be tilted otherwise.
    pub(super) fn white_displacement(
        &self,
        white: ArrayView2<f32>,
        has_tilt: bool,
    ) -> Result<Option<Displacement>, Error> {
        self.check_white(white)?;
        let size = self.sensor().size;
        let spacing = size.larger() as f64 / TILES as f64;
        let counts = [size.columns, size.rows].map(|count| ((count as f64 / spacing) as usize).max(1));
        let mut tiles: Vec<Vec<Option<Tile>>> = Vec::new();
        // Rows of pixels with the windows of all tiles of a row.
        let reach = (REACH + 2.0) * self.micro_image_pitch_px();
        // Where windows are as high as the tiles, every row of pixels is in several.
        let is_dense = 2.0 * reach * counts[1] as f64 > size.rows as f64;
        let whole = is_dense.then(|| self.white_image()).transpose()?;
        for row in 0..counts[1] {
            let y = (row as f64 + 0.5) * size.rows as f64 / counts[1] as f64;
            let x = |column: usize| (column as f64 + 0.5) * size.columns as f64 / counts[0] as f64;
            let band = (y - reach).max(0.0) as usize..((y + reach) as usize + 1).min(size.rows);
            let found = white.slice_axis(Axis(0), band.clone().into());
            // The light within the camera's own micro-images leans towards the axis too.
            let own = match &whole {
                Some(whole) => whole.slice_axis(Axis(0), band.clone().into()).to_owned(),
                None => self.white_rows(band.clone())?,
            };
            let tile = |column: usize| {
                let of = |image: ArrayView2<f32>| self.tile(image, band.start, [x(column), y]);
                let (found, expected) = (of(found), of(own.view()));
                let (found, expected) = (found?, expected?);
                let [found_px, expected_px] = match (found.of_edges_px, expected.of_edges_px) {
                    (Some(found), Some(expected)) => [found, expected],
                    _ => [found.shift_px, expected.shift_px],
                };
                Some(Tile { shift_px: [0, 1].map(|k| found_px[k] - expected_px[k]), ..found })
            };
            tiles.push((0..counts[0]).map(tile).collect());
        }
        Ok(continued(tiles).and_then(|tiles| fitted(&tiles, [size.columns as f64, size.rows as f64], has_tilt)))
    }

    /// The displacement around the micro-image nearest to a place, from the rows of a white image from `first_row` on.
    fn tile(&self, white: ArrayView2<f32>, first_row: usize, near_px: [f64; 2]) -> Option<Tile> {
        let lens = self.owner(self.place_m(near_px));
        let center = self.micro_image_center_px(lens);
        let of = |row: i32, column: i32| {
            let next = MicrolensIndex { row: lens.row + row, column: lens.column + column };
            let place = self.micro_image_center_px(next);
            [place[0] - center[0], place[1] - center[1]]
        };
        let steps_px = [of(0, 1), of(1, 0)];
        let [[ax, ay], [bx, by]] = steps_px;
        let area = ax * by - ay * bx;
        if area.abs() < 1.0 {
            return None;
        }
        // Per step along one of them the phase turns once, along the other one not at all.
        let turn = std::f64::consts::TAU / area;
        let frequencies = [[by * turn, -bx * turn], [-ay * turn, ax * turn]];
        let radius = REACH * area.abs().sqrt();
        // A window that the edge of the sensor cuts has phases of its own.
        let ends = [0..white.ncols(), first_row..first_row + white.nrows()];
        let is_inside = |axis: usize| {
            let Range { start, end } = ends[axis];
            center[axis] - radius >= start as f64 && center[axis] + radius <= end as f64
        };
        if !is_inside(0) || !is_inside(1) {
            return None;
        }
        let range =
            |axis: usize| (center[axis] - radius) as usize..((center[axis] + radius) as usize + 1).min(ends[axis].end);
        let light = |row: usize, column: usize| f64::from(white[[row - first_row, column]]);
        let (mut first, mut second) = (0.0, 0.0);
        for (row, column) in range(1).flat_map(|row| range(0).map(move |column| (row, column))) {
            first += light(row, column);
            second += light(row, column).powi(2);
        }
        let most = if first > 0.0 { USUAL * second / first } else { 0.0 };
        let (mut raw, mut cut) = (Phases::default(), Phases::default());
        for row in range(1) {
            for column in range(0) {
                let away = [column as f64 + 0.5 - center[0], row as f64 + 0.5 - center[1]];
                let window = |x: f64| {
                    let cosine = (std::f64::consts::FRAC_PI_2 * (x / radius).clamp(-1.0, 1.0)).cos();
                    cosine * cosine
                };
                let weight = window(away[0]) * window(away[1]);
                let waves = frequencies.map(|frequency| (frequency[0] * away[0] + frequency[1] * away[1]).sin_cos());
                raw.add(light(row, column) * weight, waves);
                cut.add(light(row, column).min(most) * weight, waves);
            }
        }
        let shift_px = raw.shift_px(steps_px)?;
        Some(Tile { place_px: center, shift_px, of_edges_px: cut.shift_px(steps_px), steps_px })
    }
}

/// The phases of light at the two frequencies of a grid.
#[derive(Default)]
struct Phases {
    sums: [[f64; 2]; 2],
    all: f64,
}

impl Phases {
    fn add(&mut self, light: f64, waves: [(f64, f64); 2]) {
        self.all += light;
        for (sum, (sin, cos)) in self.sums.iter_mut().zip(waves) {
            sum[0] += light * cos;
            sum[1] += light * sin;
        }
    }

    /// The displacement of a grid of these steps; `None` if the light has not its period.
    fn shift_px(&self, steps_px: [[f64; 2]; 2]) -> Option<[f64; 2]> {
        let is_clear = self.sums.iter().all(|[x, y]| x.hypot(*y) > LEAST_CONTRAST * self.all);
        // The part of a step, from -1/2 to 1/2, along each of them.
        let parts = self.sums.map(|[x, y]| y.atan2(x) / std::f64::consts::TAU);
        is_clear.then(|| [0, 1].map(|axis| parts[0] * steps_px[0][axis] + parts[1] * steps_px[1][axis]))
    }
}

/// The tiles with displacements that continue those of their neighbors, from the middle outwards, where they are clear.
fn continued(mut tiles: Vec<Vec<Option<Tile>>>) -> Option<Vec<Tile>> {
    let [rows, columns] = [tiles.len(), tiles.first()?.len()];
    let mut order: Vec<[usize; 2]> = (0..rows).flat_map(|row| (0..columns).map(move |column| [row, column])).collect();
    let far = |[row, column]: [usize; 2]| (2 * row + 1).abs_diff(rows) + (2 * column + 1).abs_diff(columns);
    order.sort_by_key(|&place| far(place));
    let mut done: Vec<[usize; 2]> = Vec::new();
    for place in order {
        let Some(tile) = tiles[place[0]][place[1]] else { continue };
        let nearest = done.iter().min_by_key(|other| (0..2).map(|k| place[k].abs_diff(other[k]).pow(2)).sum::<usize>());
        if let Some(expected) = nearest.and_then(|[row, column]| tiles[*row][*column]) {
            tiles[place[0]][place[1]] = Some(tile.near(expected.shift_px));
        }
        done.push(place);
    }
    (done.len() >= FEWEST_TILES).then(|| tiles.into_iter().flatten().flatten().collect())
}

impl Tile {
    /// The same displacement but for whole steps of the grid, as near to an expected one as can be.
    fn near(self, expected_px: [f64; 2]) -> Self {
        let [[ax, ay], [bx, by]] = self.steps_px;
        let area = ax * by - ay * bx;
        let away = [0, 1].map(|k| expected_px[k] - self.shift_px[k]);
        let [a, b] = [(away[0] * by - away[1] * bx) / area, (ax * away[1] - ay * away[0]) / area].map(f64::round);
        Self { shift_px: [0, 1].map(|k| self.shift_px[k] + a * self.steps_px[0][k] + b * self.steps_px[1][k]), ..self }
    }
}

impl Displacement {
    /// The displacement at a place on the sensor.
    pub fn at(&self, place_px: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|k| place_px[k] - self.middle_px[k]);
        let growth = self.growth[0] * x + self.growth[1] * y;
        let linear = [self.x, self.y].map(|[at_middle, along_x, along_y]| at_middle + along_x * x + along_y * y);
        [linear[0] + growth * x, linear[1] + growth * y]
    }

    /// How much the scale grows per pixel to the right and down.
    pub fn growth(&self) -> [f64; 2] {
        self.growth
    }

    /// The largest displacement by the growth of the scale.
    pub fn largest_of_growth_px(&self) -> f64 {
        Self { x: [0.0; 3], y: [0.0; 3], ..*self }.largest_px()
    }

    /// The scales along x and y, and the rotation, counterclockwise in the image.
    pub(super) fn scales_and_rotation(&self) -> ([f64; 2], f64) {
        ([1.0 + self.x[1], 1.0 + self.y[2]], (self.x[2] - self.y[1]) / 2.0)
    }

    /// The largest displacement.
    pub fn largest_px(&self) -> f64 {
        let corners = [[0.0, 0.0], [0.0, 2.0], [2.0, 0.0], [2.0, 2.0]];
        let distance = |[sx, sy]: [f64; 2]| {
            let [dx, dy] = self.at([sx * self.middle_px[0], sy * self.middle_px[1]]);
            dx.hypot(dy)
        };
        corners.into_iter().map(distance).fold(0.0, f64::max)
    }

    fn grid(&self) -> WhiteGrid {
        let ([x, y], rotation_rad) = self.scales_and_rotation();
        WhiteGrid {
            largest_px: self.largest_px(),
            scale: (x + y) / 2.0,
            rotation_rad,
            offset_px: self.at(self.middle_px),
        }
    }
}

/// The displacement nearest to those of the tiles, by least squares.
fn fitted(tiles: &[Tile], size_px: [f64; 2], has_tilt: bool) -> Option<Displacement> {
    // Both axes have an offset and two slopes, and the growth of the scale together.
    const UNKNOWNS: usize = 8;
    let unknowns = if has_tilt { UNKNOWNS } else { UNKNOWNS - 2 };
    if 2 * tiles.len() < unknowns {
        return None;
    }
    let middle_px = size_px.map(|length| length / 2.0);
    // Places of the order of 1, so that all unknowns are displacements in pixels.
    let unit_px = middle_px[0].max(middle_px[1]);
    let mut normal = [[0.0_f64; UNKNOWNS]; UNKNOWNS];
    let mut right = [0.0_f64; UNKNOWNS];
    // Unknowns that are left out are 0.
    (unknowns..UNKNOWNS).for_each(|k| normal[k][k] = 1.0);
    for tile in tiles {
        let [x, y] = [0, 1].map(|k| (tile.place_px[k] - middle_px[k]) / unit_px);
        let rows = [[1.0, x, y, 0.0, 0.0, 0.0, x * x, x * y], [0.0, 0.0, 0.0, 1.0, x, y, x * y, y * y]];
        for (row, shift_px) in rows.iter().zip(tile.shift_px) {
            for i in 0..unknowns {
                (0..unknowns).for_each(|j| normal[i][j] += row[i] * row[j]);
                right[i] += row[i] * shift_px;
            }
        }
    }
    let [a, b, c, d, e, f, g, h] = solved(normal, right)?;
    let found = Displacement {
        x: [a, b / unit_px, c / unit_px],
        y: [d, e / unit_px, f / unit_px],
        growth: [g, h].map(|growth| growth / (unit_px * unit_px)),
        middle_px,
    };
    let off = |tile: &Tile| {
        let expected = found.at(tile.place_px);
        (expected[0] - tile.shift_px[0]).hypot(expected[1] - tile.shift_px[1])
    };
    let mean = tiles.iter().map(off).sum::<f64>() / tiles.len() as f64;
    let step = tiles[0].steps_px.map(|[x, y]| x.hypot(y)).into_iter().fold(f64::INFINITY, f64::min);
    (mean <= 0.1 * step).then_some(found)
}

/// The solution of linear equations, by elimination with pivots; `None` without a single one.
fn solved<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    for column in 0..N {
        let pivot = (column..N).max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))?;
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        let top = matrix[column];
        if top[column].is_nan() || top[column].abs() < 1e-12 {
            return None;
        }
        for row in column + 1..N {
            let factor = matrix[row][column] / top[column];
            (column..N).for_each(|k| matrix[row][k] -= factor * top[k]);
            right[row] -= factor * right[column];
        }
    }
    for row in (0..N).rev() {
        let known: f64 = (row + 1..N).map(|k| matrix[row][k] * right[k]).sum();
        right[row] = (right[row] - known) / matrix[row][row];
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridSize;
    use crate::plenoptic::{ImageSensor, MainLens, MicrolensArray, MicrolensGrid};

    fn camera(grid: MicrolensGrid, change: impl Fn(&mut MicrolensArray)) -> PlenopticCamera {
        let mut array = MicrolensArray::new(grid, 62.3e-6, 3e-4);
        array.rotation_rad = 0.006;
        array.offset_m = [3e-6, -5e-6];
        change(&mut array);
        let sensor = ImageSensor::new(GridSize::new(420, 640), 4.4e-6);
        PlenopticCamera::new(sensor, array, MainLens::new(0.05, 5.0, 2.0)).unwrap()
    }

    /// The largest distance between micro-images of equal numbers at the corners of the sensor, px.
    fn distance_px(one: &PlenopticCamera, other: &PlenopticCamera) -> f64 {
        let corners = [[0.0, 0.0], [640.0, 0.0], [0.0, 420.0], [640.0, 420.0]];
        let far = corners.map(|corner| {
            let lens = one.owner(one.place_m(corner));
            let [a, b] = [one, other].map(|camera| camera.micro_image_center_px(lens));
            (a[0] - b[0]).hypot(a[1] - b[1])
        });
        far.into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn the_grid_of_a_white_image_is_found() {
        for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows, MicrolensGrid::HexColumns] {
            let known = camera(grid, |_| {});
            let own = known.white_grid(known.white_image().unwrap().view()).unwrap().unwrap();
            assert!(own.largest_px < 0.02, "{grid:?}: {own:?}");
            let others: [fn(&mut MicrolensArray); 3] = [
                |array| array.offset_m = [8e-6, -1e-6],
                |array| array.pitch_m = 62.25e-6,
                |array| {
                    array.rotation_rad = 0.0;
                    array.offset_m = [0.0, 0.0];
                },
            ];
            for change in others {
                let other = camera(grid, change);
                let white = other.white_image().unwrap();
                let found = known.white_grid(white.view()).unwrap().unwrap();
                let expected = distance_px(&known, &other);
                // The micro-images next to the corners are not at the corners.
                assert!((found.largest_px - expected).abs() < 0.03 + 0.02 * expected, "{grid:?}: {found:?} {expected}");
                let scale = other.micro_image_pitch_px() / known.micro_image_pitch_px();
                assert!((found.scale - scale).abs() < 1e-4, "{grid:?}: {found:?} {scale}");
                let turned = other.array().rotation_rad - known.array().rotation_rad;
                assert!((found.rotation_rad - turned).abs() < 1e-4, "{grid:?}: {found:?} {turned}");
            }
        }
    }

    #[test]
    fn another_image_has_no_grid() {
        let known = camera(MicrolensGrid::Square, |_| {});
        let even = ndarray::Array2::from_elem((420, 640), 1.0_f32);
        assert_eq!(known.white_grid(even.view()).unwrap(), None);
        assert!(known.white_grid(even.slice_axis(ndarray::Axis(0), (..9).into())).is_err());
    }
}
