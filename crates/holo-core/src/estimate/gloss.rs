//! Light that changes from view to view: gloss, which looks like parallax.
//!
//! Where brightness changes steadily over the image, as on a plain wall, light that gets brighter from view to view is what
//! a movement makes of it. Texture tells the two apart: a movement changes the two sides of a spot in opposite ways. So the
//! disparity is measured twice over a neighborhood of one surface: from what varies within it, and from the means of
//! gradients and changes over it. If the two contradict each other, the means are those of gloss, and are taken off.

use crate::base::parallel::*;

use super::sums::Sums;
use crate::base::memory::filled;
use crate::{Error, GridSize};

/// The side of a cell, px.
const SIDE: usize = 4;
/// Half the side of a neighborhood, in cells.
const RADIUS: usize = 2;
/// The color difference from which on a cell belongs to another surface, for colors from 0 to 1.
const COLOR: f32 = 0.2;
/// The contradiction at which half of the means is taken off, in squared standard errors.
const CONTRADICTION: f32 = 9.0;
/// A contradiction that is no larger than this share of a step may come from the curvature of images.
const CURVED: f32 = 0.3;
/// A difference between the two that does not matter, px.
const NEGLIGIBLE_PX: f32 = 0.02;
/// The share of a neighborhood, by weight, that must be of one surface.
const ONE_SURFACE: f32 = 0.25;
/// The texture that counts, as a share of the noise: less may be noise itself.
const LEAST_TEXTURE: f32 = 0.15;

/// Values by channel and axis: rows, columns.
type Pairs = [[f32; 2]; 3];

/// The means around every cell.
pub(super) struct Gloss {
    columns: usize,
    around: Vec<Around>,
}

/// The means over a neighborhood.
#[derive(Clone, Copy, Default)]
struct Around {
    gradients: Pairs,
    /// The change of light from view to view.
    changes: Pairs,
    /// How much of the means is taken off, from 0 to 1.
    share: f32,
}

impl Gloss {
    /// Finds gloss around every cell. `image` has the gradients of `sums`; `gate_px` is the distance of another surface.
    pub(super) fn find(size: GridSize, map: &[f32], image: &[f32], sums: &[Sums], gate_px: f32) -> Result<Self, Error> {
        let cells = Cells::new(size, map, image, sums)?;
        let mut around = filled("means around cells", cells.all.len(), Around::default())?;
        around.par_iter_mut().enumerate().for_each(|(cell, around)| cells.means(cell, gate_px, around));
        let mut fits = filled("fits of cells", cells.all.len(), Fit::default())?;
        fits.par_iter_mut().enumerate().for_each(|(cell, fit)| {
            for sums in cells.pixels_of(cell).map(|pixel| &sums[pixel]).filter(|sums| sums.variance > 0.0) {
                fit.add(1.0, &Fit::of(sums, &around[cell]));
            }
        });
        around.par_iter_mut().enumerate().for_each(|(cell, around)| {
            let (mut fit, mut weights) = (Fit::default(), 0.0);
            cells.neighbors(cell, gate_px, |other, weight| {
                fit.add(weight, &fits[other]);
                weights += weight;
            });
            let surface = weights / (ONE_SURFACE * (2 * RADIUS + 1).pow(2) as f32);
            let contradiction = surface.min(1.0) * fit.contradiction(around) / CONTRADICTION;
            around.share = contradiction * contradiction / (1.0 + contradiction * contradiction);
        });
        Ok(Self { columns: cells.size.columns, around })
    }

    /// The sums of the linear fit of a pixel, less its share of gloss: of squares, and of products.
    pub(super) fn fit(&self, row: usize, column: usize, sums: &Sums) -> (f32, f32) {
        let around = &self.around[row / SIDE * self.columns + column / SIDE];
        let (squares, products) = sums.fit(&sums.gradients, &sums.pulls);
        let (own_squares, own_products) = around.own_fit(sums);
        let mixed = |all: f32, own: f32| all + around.share * (own - all);
        (mixed(squares, own_squares), mixed(products, own_products))
    }
}

impl Around {
    /// The fit of what a pixel has more than its neighborhood.
    fn own_fit(&self, sums: &Sums) -> (f32, f32) {
        let [down, right, both] = sums.spread;
        let (mut gradients, mut pulls) = (sums.gradients, sums.pulls);
        for channel in 0..3 {
            let [y, x] = self.changes[channel];
            pulls[channel][0] -= down * y + both * x;
            pulls[channel][1] -= right * x + both * y;
            for axis in 0..2 {
                gradients[channel][axis] -= self.gradients[channel][axis];
            }
        }
        sums.fit(&gradients, &pulls)
    }
}

/// Sums over the pixels of a neighborhood, in units of their noise.
#[derive(Clone, Copy, Default)]
struct Fit {
    squares: f32,
    products: f32,
    noise: f32,
    /// Of the squared places of views, down and right.
    spread: [f32; 2],
}

impl Fit {
    fn of(sums: &Sums, around: &Around) -> Self {
        let (squares, products) = around.own_fit(sums);
        let per = 1.0 / sums.variance;
        let spread = [sums.spread[0] * per, sums.spread[1] * per];
        Self { squares: squares * per, products: products * per, noise: sums.noise, spread }
    }

    fn add(&mut self, weight: f32, other: &Self) {
        self.squares += weight * other.squares;
        self.products += weight * other.products;
        self.noise += weight * other.noise;
        for (sum, spread) in self.spread.iter_mut().zip(other.spread) {
            *sum += weight * spread;
        }
    }

    /// The squared difference of the two measurements over its variance; 0 if texture does not tell the disparity.
    fn contradiction(&self, around: &Around) -> f32 {
        let texture = self.squares - self.noise;
        if texture <= LEAST_TEXTURE * self.noise {
            return 0.0;
        }
        let own_px = self.products / texture;
        let own_variance = self.squares / (texture * texture);
        let (mut squares, mut products) = (1e-9, 0.0);
        for (gradient, change) in around.gradients.iter().zip(&around.changes) {
            for axis in 0..2 {
                squares += self.spread[axis] * gradient[axis] * gradient[axis];
                products += self.spread[axis] * gradient[axis] * change[axis];
            }
        }
        let off_px = products / squares - own_px;
        let variance = own_variance + 1.0 / squares + (CURVED * own_px).powi(2) + NEGLIGIBLE_PX * NEGLIGIBLE_PX;
        off_px * off_px / variance
    }
}

/// Squares of pixels.
struct Cells {
    size: GridSize,
    pixels: GridSize,
    channels: usize,
    all: Vec<Cell>,
}

/// Means and sums over a cell.
#[derive(Clone, Copy, Default)]
struct Cell {
    disparity_px: f32,
    color: [f32; 3],
    /// Of gradients times the spread of the views.
    gradients: Pairs,
    pulls: Pairs,
    spread: [f32; 2],
}

impl Cells {
    fn new(pixels: GridSize, map: &[f32], image: &[f32], sums: &[Sums]) -> Result<Self, Error> {
        let size = GridSize::new(pixels.rows.div_ceil(SIDE), pixels.columns.div_ceil(SIDE));
        let all = filled("cells", size.count(), Cell::default())?;
        let mut cells = Self { size, pixels, channels: image.len() / map.len(), all };
        let mut all = std::mem::take(&mut cells.all);
        all.par_iter_mut().enumerate().for_each(|(number, cell)| {
            let per_pixel = 1.0 / cells.pixels_of(number).count() as f32;
            for pixel in cells.pixels_of(number) {
                cell.disparity_px += per_pixel * map[pixel];
                for (color, plane) in cell.color.iter_mut().zip(image.chunks_exact(map.len())) {
                    *color += per_pixel * plane[pixel];
                }
                let sums = &sums[pixel];
                for axis in 0..2 {
                    cell.spread[axis] += sums.spread[axis];
                    for channel in 0..3 {
                        cell.gradients[channel][axis] += sums.spread[axis] * sums.gradients[channel][axis];
                        cell.pulls[channel][axis] += sums.pulls[channel][axis];
                    }
                }
            }
        });
        cells.all = all;
        Ok(cells)
    }

    /// The pixels of a cell.
    fn pixels_of(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let GridSize { rows, columns } = self.pixels;
        let (row, column) = (cell / self.size.columns * SIDE, cell % self.size.columns * SIDE);
        let across = column..(column + SIDE).min(columns);
        (row..(row + SIDE).min(rows)).flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    /// Calls `visit` with every cell around one that belongs to the same surface, and with its weight.
    fn neighbors(&self, cell: usize, gate_px: f32, mut visit: impl FnMut(usize, f32)) {
        let GridSize { rows, columns } = self.size;
        let (row, column) = (cell / columns, cell % columns);
        let here = &self.all[cell];
        for row in row.saturating_sub(RADIUS)..(row + RADIUS + 1).min(rows) {
            for column in column.saturating_sub(RADIUS)..(column + RADIUS + 1).min(columns) {
                let there = &self.all[row * columns + column];
                let off = (there.disparity_px - here.disparity_px) / gate_px;
                let squares: f32 = there.color.iter().zip(&here.color).map(|(a, b)| (a - b) * (a - b)).sum();
                let alike = 1.0 - squares / (self.channels as f32 * COLOR * COLOR);
                let weight = (1.0 - off * off).max(0.0) * alike.max(0.0);
                if weight > 0.0 {
                    visit(row * columns + column, weight);
                }
            }
        }
    }

    fn means(&self, cell: usize, gate_px: f32, around: &mut Around) {
        let mut spread = [1e-9_f32; 2];
        self.neighbors(cell, gate_px, |other, weight| {
            let other = &self.all[other];
            for axis in 0..2 {
                spread[axis] += weight * other.spread[axis];
                for channel in 0..3 {
                    around.gradients[channel][axis] += weight * other.gradients[channel][axis];
                    around.changes[channel][axis] += weight * other.pulls[channel][axis];
                }
            }
        });
        for channel in 0..3 {
            for axis in 0..2 {
                around.gradients[channel][axis] /= spread[axis];
                around.changes[channel][axis] /= spread[axis];
            }
        }
    }
}
