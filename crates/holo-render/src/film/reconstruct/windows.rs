//! Windows of views, and means over the views of one microlens.

use std::ops::Range;

use crate::simd::Kernel;

/// The largest number of windows of a view, from the view itself (level 0) to the largest.
pub(super) const LEVELS: usize = 8;

/// The values of a pixel that are averaged: red, green, blue, half difference.
pub(super) const VALUES: usize = 4;

/// The radii, in views, of the windows of a microlens. Windows end at the border of the views, except for the largest one,
/// which is moved until it has all its views; inside it is the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Radii {
    radius: [usize; LEVELS],
    count: usize,
}

impl Radii {
    /// The view itself.
    pub const SINGLE: Self = Self { radius: [0; LEVELS], count: 1 };

    /// Radii 0, 1, 2, 4, 7 and 12 below `largest`, which is at least 1, and `largest` itself.
    pub fn up_to(largest: usize) -> Self {
        let between = [0, 1, 2, 4, 7, 12];
        let below = between.iter().filter(|&&radius| radius < largest).count();
        let mut radius = [largest; LEVELS];
        radius[..below].copy_from_slice(&between[..below]);
        // The last twice: ended at the border, and moved.
        Self { radius, count: below + 2 }
    }

    /// The number of levels.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether the windows of `level` are moved at the border.
    pub fn is_moved(&self, level: usize) -> bool {
        level > 0 && level + 1 == self.count
    }

    /// The window of `level` around view `k` of `count` views along an axis.
    pub fn window(&self, level: usize, k: usize, count: usize) -> Range<usize> {
        let radius = self.radius[level];
        let k = if self.is_moved(level) { self.moved(level, k, count) } else { k };
        k.saturating_sub(radius)..(k + radius + 1).min(count)
    }

    /// The view nearest to view `k` whose window of the radius of `level` has all views that are possible.
    pub fn moved(&self, level: usize, k: usize, count: usize) -> usize {
        let near = self.radius[level].min(count - 1);
        let far = count - 1 - near;
        k.clamp(near.min(far), near.max(far))
    }
}

/// The views of one microlens, value by value, row by row.
pub(super) type Planes = [Vec<f32>; VALUES];

/// Means over the window of one level around every view of a microlens.
pub(super) struct BoxMean<'a> {
    pub source: &'a Planes,
    /// Rows and columns of views.
    pub views: [usize; 2],
    pub radii: &'a Radii,
    pub level: usize,
    pub scratch: &'a mut Sums,
    pub out: &'a mut Planes,
}

/// The means over the moved windows of `level` from those over the windows that end at the border.
pub(super) fn move_windows(ended: &Planes, [rows, columns]: [usize; 2], radii: &Radii, level: usize, out: &mut Planes) {
    for (ended, out) in ended.iter().zip(out) {
        out.clear();
        for t in 0..rows {
            let row = &ended[radii.moved(level, t, rows) * columns..][..columns];
            out.extend((0..columns).map(|s| row[radii.moved(level, s, columns)]));
        }
    }
}

/// Memory of [`BoxMean`].
#[derive(Default)]
pub(super) struct Sums {
    /// A row of views between zeros.
    padded: Vec<f32>,
    /// The sums along rows.
    rows: Vec<f32>,
    /// The reciprocal numbers of views in the windows of a row.
    scale: Vec<f32>,
}

impl Kernel for BoxMean<'_> {
    type Output = ();

    /// Sums along rows, then along columns.
    #[inline(always)]
    fn run(self) {
        let [view_rows, view_columns] = self.views;
        let radius = self.radii.radius[self.level];
        let Sums { padded, rows, scale } = self.scratch;
        scale.clear();
        scale.extend((0..view_columns).map(|s| 1.0 / self.radii.window(self.level, s, view_columns).len() as f32));
        for (source, out) in self.source.iter().zip(self.out.iter_mut()) {
            rows.clear();
            rows.resize(view_rows * view_columns, 0.0);
            padded.clear();
            padded.resize(view_columns + 2 * radius, 0.0);
            for (row, sums) in source.chunks_exact(view_columns).zip(rows.chunks_exact_mut(view_columns)) {
                padded[radius..radius + view_columns].copy_from_slice(row);
                for offset in 0..=2 * radius {
                    for (sum, value) in sums.iter_mut().zip(&padded[offset..]) {
                        *sum += *value;
                    }
                }
            }
            out.clear();
            out.resize(view_rows * view_columns, 0.0);
            for (t, out) in out.chunks_exact_mut(view_columns).enumerate() {
                let window = self.radii.window(self.level, t, view_rows);
                let reciprocal = 1.0 / window.len() as f32;
                for row in rows[window.start * view_columns..window.end * view_columns].chunks_exact(view_columns) {
                    for (sum, value) in out.iter_mut().zip(row) {
                        *sum += *value;
                    }
                }
                for (sum, scale) in out.iter_mut().zip(scale.iter()) {
                    *sum *= *scale * reciprocal;
                }
            }
        }
    }
}
