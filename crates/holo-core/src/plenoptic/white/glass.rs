//! The part of a pixel that the light of a lens of glass reaches.

use super::super::prescription::LightEdge;
use super::Light;

/// Parts of a pixel along each side, in which the edge of the light is taken to be straight.
const PARTS: usize = 4;

impl Light<'_> {
    /// The share of a pixel that light through one point of the microlens reaches: that of parts that a straight edge cuts.
    ///
    /// # Accuracy
    ///
    /// The edge bends by an eighth of the square of a part's width over its radius: for micro-images of 7 px radius 0.1 % of the
    /// pixel.
    pub(super) fn share_within(&self, edge: &LightEdge, point: [f64; 2], middle: [f64; 2]) -> f64 {
        let (per_sensor, width) = (1.0 / self.scale, self.width_m() / self.scale);
        let from = self.on_sensor(middle);
        // In the plane of the exit pupil.
        let from = [0, 1].map(|k| per_sensor * from[k] - self.lens.alpha * point[k]);
        let within = |x: f64, y: f64| edge.within_m([from[0] + x * width, from[1] + y * width]);
        // Corners are half of the diagonal away, and a slanted edge a little farther along the way to it.
        let reach_m = 0.9 * width;
        let center = within(0.0, 0.0);
        if center.abs() > reach_m {
            return if center > 0.0 { 1.0 } else { 0.0 };
        }
        let at = |k: usize| k as f64 / PARTS as f64 - 0.5;
        let mut rows = [[0.0; PARTS + 1]; 2];
        rows[1] = std::array::from_fn(|column| within(at(column), at(0)));
        let mut share = 0.0;
        for row in 1..=PARTS {
            rows = [rows[1], std::array::from_fn(|column| within(at(column), at(row)))];
            for column in 0..PARTS {
                let [[a, b], [c, d]] = rows.map(|row| [row[column], row[column + 1]]);
                share += cut_share((a + b + c + d) / 4.0, (b + d - a - c) / 2.0, (c + d - a - b) / 2.0);
            }
        }
        share / (PARTS * PARTS) as f64
    }
}

/// The share of a square where a linear function is above 0, by its value in the middle and its differences along the sides.
fn cut_share(middle: f64, along_x: f64, along_y: f64) -> f64 {
    let (large, small) =
        if along_x.abs() > along_y.abs() { (along_x.abs(), along_y.abs()) } else { (along_y.abs(), along_x.abs()) };
    let sum = large + small;
    if middle.abs() >= sum / 2.0 {
        return if middle > 0.0 { 1.0 } else { 0.0 };
    }
    // From the corner where it is least, of triangle, trapezoid and the rest.
    let from_corner = middle + sum / 2.0;
    let triangle = |x: f64| x * x / (2.0 * large * small);
    if from_corner < small {
        triangle(from_corner)
    } else if from_corner > large {
        1.0 - triangle(sum - from_corner)
    } else {
        (from_corner - small / 2.0) / large
    }
}

#[cfg(test)]
mod tests {
    use super::cut_share;

    #[test]
    fn squares_are_cut() {
        assert_eq!([cut_share(1.0, 0.5, 0.5), cut_share(-1.0, 0.5, 0.5), cut_share(0.0, 1.0, 0.0)], [1.0, 0.0, 0.5]);
        for (middle, x, y) in [(0.1, 1.0, 0.3), (-0.4, -0.7, 0.6), (0.3, 0.2, -0.9), (-0.05, 0.01, 0.2)] {
            let side = 1000;
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(side) - 0.5;
            let above = (0..side * side).filter(|k| middle + x * at(k % side) + y * at(k / side) > 0.0).count();
            let counted = above as f64 / f64::from(side * side);
            let found = cut_share(middle, x, y);
            assert!((found - counted).abs() < 2e-3, "{middle} {x} {y}: {found} {counted}");
        }
    }
}
