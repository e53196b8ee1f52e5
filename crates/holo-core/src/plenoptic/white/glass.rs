//! The part of a pixel that the light of a lens of glass reaches.

use super::super::prescription::LightEdge;
use super::Light;

/// Farther from the middle of a pixel than this part of its width, no edge crosses it: corners are half of the diagonal away,
/// and a slanted edge a little farther along the way to it.
const REACH: f64 = 0.9;

impl Light<'_> {
    /// The light that a pixel gets from a microlens over which the edge moves by more than half a pixel: the mean over its even
    /// points, between which the edge moves by less than two pixels.
    pub(super) fn of_glass(&self, middle: [f64; 2]) -> f64 {
        let Some(edge) = &self.edge else { return 0.0 };
        let points = &self.rule.even_points;
        let light = |&point: &[f64; 2]| {
            let share = self.share_within(edge, point, middle);
            if share > 0.0 { share * self.cos4(self.lit_place(middle, share), point) } else { 0.0 }
        };
        points.iter().map(light).sum::<f64>() / points.len() as f64
    }

    /// The share of a pixel that light through one point of the microlens reaches, cut by one straight edge.
    ///
    /// # Accuracy
    ///
    /// The edge is the mean one over the pixel, of the middle and the corners by the rule that is exact for quadratic functions.
    pub(super) fn share_within(&self, edge: &LightEdge, point: [f64; 2], middle: [f64; 2]) -> f64 {
        let width = self.width_m() / self.scale;
        let from = self.in_pupil(point, middle);
        let within = |x: f64, y: f64| edge.within_m([from[0] + x * width, from[1] + y * width]);
        let center = within(0.0, 0.0);
        if center.abs() > REACH * width {
            return if center > 0.0 { 1.0 } else { 0.0 };
        }
        let [a, b, c, d] = [within(-0.5, -0.5), within(0.5, -0.5), within(-0.5, 0.5), within(0.5, 0.5)];
        cut_share((2.0 * center + (a + b + c + d) / 4.0) / 3.0, (b + d - a - c) / 2.0, (c + d - a - b) / 2.0)
    }

    /// Where a ray from a point of the microlens to a place on the sensor crosses the plane of the exit pupil.
    fn in_pupil(&self, point: [f64; 2], middle: [f64; 2]) -> [f64; 2] {
        let (from, per_sensor) = (self.on_sensor(middle), 1.0 / self.scale);
        [0, 1].map(|k| per_sensor * from[k] - self.lens.alpha * point[k])
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
