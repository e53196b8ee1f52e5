//! Measurements of pixels, and of squares of pixels as one: a far neighborhood has few squares, and every pixel of it counts.

use std::borrow::Cow;

use crate::base::parallel::*;

use super::measure::Measurements;
use super::plane::Plane;
use crate::base::memory::filled;
use crate::{Error, GridSize};

/// The weight of the current disparity beside its measurement, in 1/px^2. It determines pixels without information.
pub(super) const PRIOR: f32 = 0.05;
/// The largest information of the coarser estimate, in 1/px^2: its error is not noise alone.
const MOST_COARSE: f32 = 500.0;
/// The pixels over which a fit spreads it.
const SPREAD: f32 = 64.0;

/// Squares of pixels, each as one measurement.
pub(super) struct Cells<'a> {
    /// The side of a square, px.
    pub(super) side: usize,
    /// Rows and columns of pixels: the last squares may have fewer.
    pixels: GridSize,
    /// Rows and columns of squares.
    pub(super) size: GridSize,
    /// The current disparities.
    pub(super) map: Cow<'a, [f32]>,
    /// The means of the measurements, the coarser estimate and the current disparities.
    pub(super) values: Vec<f32>,
    /// The weights of the values, in 1/px^2.
    pub(super) weights: Vec<f32>,
    /// The same without those of the current disparities.
    pub(super) information: Vec<f32>,
    /// The colors, channel by channel.
    pub(super) image: Cow<'a, [f32]>,
}

impl<'a> Cells<'a> {
    /// Single pixels. `coarse` is the coarser estimate, or nothing; one that is more than `gate_px` away from the current
    /// disparity is that of another surface.
    pub(super) fn pixels(
        size: GridSize,
        map: &'a [f32],
        found: &'a Measurements,
        coarse: &[Plane],
        gate_px: f32,
    ) -> Result<Self, Error> {
        let mut values = filled("a disparity map", map.len(), 0.0)?;
        let mut weights = filled("the weights of a disparity map", map.len(), 0.0)?;
        let mut information = filled("the information of a disparity map", map.len(), 0.0)?;
        let places = values.par_iter_mut().zip(weights.par_iter_mut()).zip(information.par_iter_mut());
        places.with_min_len(size.columns).enumerate().for_each(|(pixel, ((value, weight), information))| {
            *information = found.information[pixel];
            *value = *information * found.disparity_px[pixel] + PRIOR * map[pixel];
            if let Some(coarse) = coarse.get(pixel) {
                let off = (map[pixel] - coarse.here) / gate_px;
                let same = (1.0 - off * off).max(0.0);
                let own = same * same * coarse.information.min(MOST_COARSE) / SPREAD;
                *information += own;
                *value += own * coarse.here;
            }
            *weight = *information + PRIOR;
            *value /= *weight;
        });
        let (map, image) = (Cow::from(map), Cow::from(&found.image));
        Ok(Self { side: 1, pixels: size, size, map, values, weights, information, image })
    }

    /// The number of pixels of a square.
    fn pixels_of(&self, cell: usize) -> usize {
        let along = |place: usize, pixels: usize| self.side.min(pixels - place * self.side);
        along(cell / self.size.columns, self.pixels.rows) * along(cell % self.size.columns, self.pixels.columns)
    }

    /// Squares of twice the side: means of up to four. The weights add up.
    pub(super) fn doubled(&self) -> Result<Cells<'static>, Error> {
        let GridSize { rows, columns } = self.size;
        let size = GridSize::new(rows.div_ceil(2), columns.div_ceil(2));
        let parts = |cell: usize| {
            let (row, column) = (2 * (cell / size.columns), 2 * (cell % size.columns));
            let across = column..(column + 2).min(columns);
            (row..(row + 2).min(rows)).flat_map(move |row| across.clone().map(move |column| row * columns + column))
        };
        let mut map = filled("a disparity map", size.count(), 0.0)?;
        let mut values = filled("a disparity map", size.count(), 0.0)?;
        let mut weights = filled("the weights of a disparity map", size.count(), 0.0)?;
        let mut information = filled("the information of a disparity map", size.count(), 0.0)?;
        let sums = values.par_iter_mut().zip(weights.par_iter_mut()).zip(information.par_iter_mut());
        let places = map.par_iter_mut().zip(sums).with_min_len(size.columns);
        places.enumerate().for_each(|(cell, (map, ((value, weight), information)))| {
            for part in parts(cell) {
                let own = self.weights[part];
                *weight += own;
                *information += self.information[part];
                *map += own * self.map[part];
                *value += own * self.values[part];
            }
            *map /= *weight;
            *value /= *weight;
        });
        let mut image = filled("an averaged view", self.image.len() / self.map.len() * size.count(), 0.0)?;
        let channels = image.chunks_exact_mut(size.count()).zip(self.image.chunks_exact(self.map.len()));
        for (to, from) in channels {
            to.par_iter_mut().with_min_len(size.columns).enumerate().for_each(|(cell, to)| {
                let (mut sum, mut count) = (0.0, 0.0);
                for part in parts(cell) {
                    let pixels = self.pixels_of(part) as f32;
                    sum += pixels * from[part];
                    count += pixels;
                }
                *to = sum / count;
            });
        }
        let (map, image) = (map.into(), image.into());
        Ok(Cells { side: 2 * self.side, pixels: self.pixels, size, map, values, weights, information, image })
    }
}
