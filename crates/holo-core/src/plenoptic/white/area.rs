//! Areas that a disc or a polygon covers of squares.

use super::GAUSS_3;

/// The part of a convex polygon that lies within another; both counterclockwise.
///
/// Source: Sutherland and Hodgman, "Reentrant polygon clipping" (CACM, 1974).
pub(super) fn clipped(mut polygon: Vec<[f64; 2]>, by: &[[f64; 2]]) -> Vec<[f64; 2]> {
    for (k, a) in by.iter().enumerate() {
        let b = by[(k + 1) % by.len()];
        let side = |p: &[f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (k, p) in polygon.iter().enumerate() {
            let q = &polygon[(k + 1) % polygon.len()];
            let (sp, sq) = (side(p), side(q));
            if sp >= 0.0 {
                kept.push(*p);
            }
            if (sp >= 0.0) != (sq >= 0.0) {
                let part = sp / (sp - sq);
                kept.push([p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])]);
            }
        }
        polygon = kept;
    }
    polygon
}

/// The area of a polygon.
pub(super) fn area_of(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>().abs() / 2.0
}

/// The width up to which [`small_square`] is used, in radii of the disc: its error is below 1e-5 of the square.
pub(super) const SMALL_SQUARE: f64 = 0.25;

/// The area that the unit disc covers of a square on its edge: the integral of the height of the disc within the square, of
/// which the part along the edge is so smooth that three points suffice.
pub(super) fn small_square(center: [f64; 2], width: f64) -> f64 {
    // Turned such that the edge is above the center of the disc, by no more than 45 degrees and half a square to the side.
    let [x, y] = [center[0].abs(), center[1].abs()];
    let [x, y] = if x > y { [y, x] } else { [x, y] };
    let [left, right] = [x - width / 2.0, x + width / 2.0];
    let [bottom, top] = [y - width / 2.0, y + width / 2.0];
    // Where the edge of the disc leaves the square above and below; it falls from the left to the right, but for the part of
    // the square left of the axis, where it rises.
    let leaves = |height: f64| (1.0 - height * height).max(0.0).sqrt();
    let half = |from: f64, to: f64| {
        let full_to = leaves(top).clamp(from, to);
        let none_from = leaves(bottom).clamp(from, to);
        let height = |x: f64| (1.0 - x * x).max(0.0).sqrt() - bottom;
        let along = none_from - full_to;
        let edge = GAUSS_3.iter().map(|&(place, weight)| weight * height(full_to + place * along)).sum::<f64>();
        (full_to - from) * width + along * edge
    };
    if left < 0.0 { half(0.0, -left) + half(0.0, right) } else { half(left, right) }
}

/// The area of the unit disc left of x and below y.
pub(super) fn quadrant(x: f64, y: f64) -> f64 {
    let (x, y) = (x.clamp(-1.0, 1.0), y.clamp(-1.0, 1.0));
    // The area left of a line.
    let left = |x: f64| x * (1.0 - x * x).sqrt() + x.asin() + std::f64::consts::FRAC_PI_2;
    if x * x + y * y >= 1.0 {
        // The corner lies outside: the lines do not cross within the disc.
        return match (x >= 0.0, y >= 0.0) {
            (true, true) => left(x) + left(y) - std::f64::consts::PI,
            (true, false) => left(y),
            (false, true) => left(x),
            (false, false) => 0.0,
        };
    }
    // Half of what lies left and below the axes' parts: a quarter disc, two half segments and the rectangle.
    (left(x) + left(y)) / 2.0 - std::f64::consts::FRAC_PI_4 + x * y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Small squares all around the edge of the disc are covered as the quadrants at their corners say.
    #[test]
    fn small_squares_are_covered_as_by_quadrants() {
        for width in [0.002, 0.03, 0.14, SMALL_SQUARE] {
            let mut most = 0.0f64;
            for angle in (0..720).map(|k| f64::from(k).to_radians() / 2.0 + 1e-3) {
                for away in (-24..=24).map(|k| 1.0 + f64::from(k) / 24.0 * 0.75 * width) {
                    let center = [away * angle.cos(), away * angle.sin()];
                    let [low, high] = [-0.5, 0.5].map(|side| center.map(|x| x + side * width));
                    let exact = quadrant(high[0], high[1]) - quadrant(low[0], high[1]) - quadrant(high[0], low[1])
                        + quadrant(low[0], low[1]);
                    most = most.max((small_square(center, width) - exact).abs() / (width * width));
                }
            }
            // The differences of quadrants have lost some digits where squares are small.
            assert!(most < 1e-5, "{width}: {most:e}");
        }
    }

    #[test]
    fn quadrants_have_their_areas() {
        let side = 1000;
        for (x, y) in
            [(0.3, 0.2), (-0.3, 0.5), (0.9, 0.9), (-0.9, 0.9), (0.8, -0.7), (-0.8, -0.8), (0.0, 0.0), (2.0, 0.1)]
        {
            let at = |k: usize| (k as f64 + 0.5) / f64::from(side as u32) * 2.0 - 1.0;
            let inside = |px: f64, py: f64| px * px + py * py <= 1.0 && px < x && py < y;
            let count = (0..side * side).filter(|k| inside(at(k % side), at(k / side))).count();
            let counted = 4.0 * count as f64 / (side * side) as f64;
            assert!((quadrant(x, y) - counted).abs() < 3e-3, "{x} {y}: {} {counted}", quadrant(x, y));
        }
    }
}
