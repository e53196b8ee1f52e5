//! The order in which a list holds the views of a light field, and which one the images themselves show.

use std::cell::OnceCell;

use ndarray::{Array2, Axis, Data};

use super::{LightField, Sample};
use crate::{Error, GridSize};

/// The order in which a list holds the views of a light field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ViewOrder {
    /// Row by row, every row from left to right: the numbering `t*S + s` of the HCI benchmark.
    #[default]
    RowMajor,
    /// Row by row, in alternating directions, the first row from left to right: the usual path of a gantry, also called
    /// "lawnmower" or "snake".
    Serpentine,
    /// Column by column, every column from above.
    ColumnMajor,
    /// Column by column, in alternating directions, the first column from above.
    ColumnSerpentine,
    /// As [`RowMajor`](Self::RowMajor) with the lowest row first.
    RowMajorUp,
    /// As [`Serpentine`](Self::Serpentine) with the lowest row first.
    SerpentineUp,
    /// As [`ColumnMajor`](Self::ColumnMajor), every column from below.
    ColumnMajorUp,
    /// As [`ColumnSerpentine`](Self::ColumnSerpentine), the first column from below.
    ColumnSerpentineUp,
}

impl ViewOrder {
    /// All orders.
    pub const ALL: [Self; 8] = [
        Self::RowMajor,
        Self::Serpentine,
        Self::ColumnMajor,
        Self::ColumnSerpentine,
        Self::RowMajorUp,
        Self::SerpentineUp,
        Self::ColumnMajorUp,
        Self::ColumnSerpentineUp,
    ];

    /// Returns the name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RowMajor => "row-major",
            Self::Serpentine => "serpentine",
            Self::ColumnMajor => "column-major",
            Self::ColumnSerpentine => "column-serpentine",
            Self::RowMajorUp => "row-major-up",
            Self::SerpentineUp => "serpentine-up",
            Self::ColumnMajorUp => "column-major-up",
            Self::ColumnSerpentineUp => "column-serpentine-up",
        }
    }

    /// Whether columns follow each other.
    #[must_use]
    pub const fn is_by_columns(self) -> bool {
        matches!(self, Self::ColumnMajor | Self::ColumnSerpentine | Self::ColumnMajorUp | Self::ColumnSerpentineUp)
    }

    const fn is_serpentine(self) -> bool {
        matches!(self, Self::Serpentine | Self::ColumnSerpentine | Self::SerpentineUp | Self::ColumnSerpentineUp)
    }

    const fn is_up(self) -> bool {
        matches!(self, Self::RowMajorUp | Self::SerpentineUp | Self::ColumnMajorUp | Self::ColumnSerpentineUp)
    }

    /// Returns the row and column `(t, s)` of the view at `index` of the list.
    ///
    /// Indices from `views.count()` on are outside the grid.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if the grid has no rows or columns.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, ViewOrder};
    ///
    /// let views = GridSize::new(2, 3);
    /// assert_eq!(ViewOrder::RowMajor.view(3, views)?, (1, 0));
    /// assert_eq!(ViewOrder::Serpentine.view(3, views)?, (1, 2));
    /// assert_eq!(ViewOrder::ColumnMajor.view(3, views)?, (1, 1));
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn view(self, index: usize, views: GridSize) -> Result<(usize, usize), Error> {
        for (what, count) in [("view rows", views.rows), ("view columns", views.columns)] {
            if count == 0 {
                return Err(Error::ZeroCount { what });
            }
        }
        let length = if self.is_by_columns() { views.rows } else { views.columns };
        let (line, place) = (index / length, index % length);
        let place = if self.is_serpentine() && line % 2 == 1 { length - 1 - place } else { place };
        let (row, column) = if self.is_by_columns() { (place, line) } else { (line, place) };
        let is_inside = row < views.rows;
        Ok((if self.is_up() && is_inside { views.rows - 1 - row } else { row }, column))
    }
}

/// The widest small view, px.
const WIDTH_PX: usize = 96;

/// The side of a block with one disparity, px of small views.
const BLOCK_PX: usize = 8;

/// The largest number of views whose neighbors are compared.
const MOST_VIEWS: usize = 256;

/// Another order explains the motion if it leaves less than this part of what the given one leaves.
const CLEARLY: f64 = 0.75;

impl<S: Data<Elem: Sample>> LightField<S> {
    /// Returns the order of the views that the images show, if they are not in order: what the list of all views, row by
    /// row, is in truth.
    ///
    /// Between neighbors of a row the image moves along its rows, between those of a column along its columns, in every
    /// place by one disparity. So the error that one disparity a block leaves, by the image's gradient, is smallest in the
    /// right order. `None`: no other order leaves clearly less, or there are not several rows and columns.
    ///
    /// Whether both rows and columns run backwards cannot be seen: near would be far. Orders by columns are looked for in
    /// a grid with rows and columns exchanged.
    ///
    /// # Source
    ///
    /// The gradient constraint of light fields (Adelson and Wang, *Single lens stereo with a plenoptic camera*, 1992), by
    /// least squares.
    #[must_use]
    pub fn view_order_of_images(&self) -> Option<ViewOrder> {
        let views = self.shape().views();
        if views.rows.min(views.columns) < 2 {
            return None;
        }
        let list: Vec<OnceCell<Array2<f32>>> = vec![OnceCell::new(); views.count()];
        let small = |k: usize| list[k].get_or_init(|| self.small_view(k));
        let left = |order: ViewOrder| unexplained(small, views, order);
        let given = left(ViewOrder::RowMajor);
        let others = ViewOrder::ALL.into_iter().skip(1).map(|order| (order, left(order)));
        let (order, least) = others.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (least < CLEARLY * given).then_some(order)
    }

    /// A channel in the middle, of a view in small; views count row by row.
    fn small_view(&self, index: usize) -> Array2<f32> {
        let (shape, samples) = (self.shape(), self.samples());
        let (t, s) = (index / shape.views().columns, index % shape.views().columns);
        let factor = shape.lenses().larger().div_ceil(WIDTH_PX);
        let view = samples.index_axis(Axis(4), self.channels() / 2);
        let view = view.index_axis(Axis(3), s);
        let view = view.index_axis(Axis(2), t);
        let side = [view.nrows(), view.ncols()].map(|count| count.min(factor));
        let blocks = view.exact_chunks(side);
        let size = [view.nrows() / side[0], view.ncols() / side[1]];
        let sums = blocks.into_iter().map(|block| block.iter().map(|sample| sample.to_f64()).sum::<f64>() as f32);
        Array2::from_shape_vec(size, sums.collect()).unwrap_or_default()
    }
}

/// The part of the differences between neighboring views that one disparity a block leaves.
fn unexplained<'a>(small: impl Fn(usize) -> &'a Array2<f32>, views: GridSize, order: ViewOrder) -> f64 {
    let views = if order.is_by_columns() { GridSize::new(views.columns, views.rows) } else { views };
    let mut grid = vec![0; views.count()];
    for index in 0..views.count() {
        if let Ok((t, s)) = order.view(index, views) {
            grid[t * views.columns + s] = index;
        }
    }
    let at = |t: usize, s: usize| small(grid[t * views.columns + s]);
    let (rows, columns) = small(0).dim();
    let blocks = (rows.div_ceil(BLOCK_PX), columns.div_ceil(BLOCK_PX));
    // Of every block the sums of gradient^2, gradient * difference, difference^2.
    let mut sums = Array2::from_elem(blocks, [0.0_f64; 3]);
    let mut add = |one: &Array2<f32>, other: &Array2<f32>, step: [usize; 2]| {
        for v in 1..rows.saturating_sub(1) {
            for u in 1..columns.saturating_sub(1) {
                let gradient =
                    |image: &Array2<f32>| (image[[v + step[0], u + step[1]]] - image[[v - step[0], u - step[1]]]) / 2.0;
                let slope = f64::from(gradient(one) + gradient(other)) / 2.0;
                let difference = f64::from(other[[v, u]] - one[[v, u]]);
                let sums = &mut sums[[v / BLOCK_PX, u / BLOCK_PX]];
                for (sum, value) in sums.iter_mut().zip([slope * slope, slope * difference, difference * difference]) {
                    *sum += value;
                }
            }
        }
    };
    // Of many views a part, in all rows and columns.
    let step = views.count().div_ceil(MOST_VIEWS);
    for t in 0..views.rows {
        for s in (0..views.columns).filter(|s| (7 * t + s).is_multiple_of(step)) {
            if s + 1 < views.columns {
                add(at(t, s), at(t, s + 1), [0, 1]);
            }
            if t + 1 < views.rows {
                add(at(t, s), at(t + 1, s), [1, 0]);
            }
        }
    }
    // Per squared gradient: orders have other differences in all.
    let left = |[slopes, both, all]: [f64; 3]| if slopes > 0.0 { all - both * both / slopes } else { all };
    let slopes: f64 = sums.iter().map(|sums| sums[0]).sum();
    let sum: f64 = sums.iter().map(|&sums| left(sums)).sum();
    if slopes > 0.0 { sum / slopes } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layout, LightFieldShape};

    #[test]
    fn lists_run_along_rows_or_columns() {
        let order = |order: ViewOrder, rows: usize, columns: usize| -> Vec<(usize, usize)> {
            (0..rows * columns).map(|index| order.view(index, GridSize::new(rows, columns)).unwrap()).collect()
        };
        assert_eq!(order(ViewOrder::Serpentine, 2, 3), [(0, 0), (0, 1), (0, 2), (1, 2), (1, 1), (1, 0)]);
        assert_eq!(order(ViewOrder::ColumnMajor, 2, 3), [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)]);
        assert_eq!(order(ViewOrder::ColumnSerpentine, 2, 3), [(0, 0), (1, 0), (1, 1), (0, 1), (0, 2), (1, 2)]);
        assert_eq!(order(ViewOrder::SerpentineUp, 2, 2), [(1, 0), (1, 1), (0, 1), (0, 0)]);
        for one in ViewOrder::ALL {
            let mut all = order(one, 3, 4);
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), 12, "{one:?}");
            assert!(one.view(0, GridSize::new(3, 0)).is_err() && one.view(0, GridSize::new(0, 3)).is_err());
        }
    }

    /// Two planes of waves, with noise; `disparity_px` of the nearer one.
    fn field(rows: usize, columns: usize, disparity_px: f64) -> LightField<ndarray::OwnedRepr<u8>> {
        let shape = LightFieldShape::new(GridSize::new(rows, columns), GridSize::new(40, 56)).unwrap();
        let mut state = 7_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16) / 65_536.0 - 0.5
        };
        let mut out = LightField::filled(shape, 1, Layout::ViewpointGrid, 0_u8).unwrap();
        for t in 0..rows {
            for s in 0..columns {
                for ((v, u, _), sample) in out.view_mut(t, s).unwrap().indexed_iter_mut() {
                    let disparity = if u < 28 { disparity_px } else { -0.4 * disparity_px };
                    let [x, y] = [u as f64 + disparity * s as f64, v as f64 + disparity * t as f64];
                    let wave = (0.5 * x + 0.2 * y).sin() + (0.3 * x - 0.6 * y + 1.0).sin() + (0.9 * y).sin();
                    *sample = (128.0 + 25.0 * wave + 10.0 * noise()) as u8;
                }
            }
        }
        out
    }

    #[test]
    fn the_images_show_their_order() {
        for (rows, columns) in [(5, 5), (3, 4), (2, 2)] {
            for disparity in [0.8, -0.6] {
                let right = field(rows, columns, disparity);
                assert_eq!(right.view_order_of_images(), None, "{rows} x {columns}, {disparity} px");
                for order in ViewOrder::ALL.into_iter().skip(1) {
                    // A list in that order, read row by row.
                    let views = right.shape().views();
                    let list: Vec<_> = (0..views.count()).map(|k| order.view(k, views).unwrap()).collect();
                    let images = list.iter().map(|&(t, s)| right.view(t, s).unwrap());
                    let grid =
                        if order.is_by_columns() { GridSize::new(columns, rows) } else { GridSize::new(rows, columns) };
                    let wrong =
                        LightField::from_views(grid, ViewOrder::RowMajor, Layout::ViewpointGrid, images).unwrap();
                    let found = wrong.view_order_of_images();
                    assert_eq!(found, Some(order), "{rows} x {columns}, {disparity} px");
                }
            }
        }
    }

    #[test]
    fn without_texture_or_grid_no_order_is_shown() {
        let even = LightField::filled(
            LightFieldShape::new(GridSize::new(3, 3), GridSize::new(9, 9)).unwrap(),
            3,
            Layout::ViewpointGrid,
            7_u8,
        );
        assert_eq!(even.unwrap().view_order_of_images(), None);
        assert_eq!(field(1, 5, 0.7).view_order_of_images(), None);
    }
}
