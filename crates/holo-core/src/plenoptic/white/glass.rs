//! The part of a pixel that the light of a lens of glass reaches.

use std::f64::consts::FRAC_1_SQRT_2;

use super::super::Microlens;
use super::super::prescription::{FieldTable, LightEdge};
use super::Light;

/// A square within which the edge bends by more than this part of its width is divided: there one straight edge would be off by up
/// to twice as much of the square.
const STRAIGHT: f64 = 0.05;

/// So often at most: the parts are then 1/1000 of the square.
const DIVISIONS: u32 = 5;

/// The strips of a microlens, across the way from the axis, that have an edge each.
const STRIPS: usize = 5;

/// The edges of the light to a microlens: they change along the way from the axis.
pub(super) struct LensEdges {
    edges: [LightEdge; STRIPS],
    /// From the place of a point to its strip: strips per meter.
    per_meter: [f64; 2],
}

impl LensEdges {
    pub fn new(table: &FieldTable, lens: &Microlens, radius_m: f64) -> Self {
        let away = lens.center_m[0].hypot(lens.center_m[1]);
        let outwards = if away > 0.0 { lens.center_m.map(|x| x / away) } else { [1.0, 0.0] };
        let middle = |strip: usize| radius_m * ((2 * strip + 1) as f64 / STRIPS as f64 - 1.0);
        Self {
            edges: std::array::from_fn(|strip| {
                table.edge([0, 1].map(|k| lens.center_m[k] + middle(strip) * outwards[k]))
            }),
            per_meter: outwards.map(|x| x * STRIPS as f64 / (2.0 * radius_m)),
        }
    }

    /// The edge of the strip that a point of the microlens lies in.
    #[inline]
    fn at(&self, point: [f64; 2]) -> &LightEdge {
        let strip = point[0] * self.per_meter[0] + point[1] * self.per_meter[1] + STRIPS as f64 / 2.0;
        &self.edges[(strip as usize).min(STRIPS - 1)]
    }
}

impl Light<'_> {
    /// The light that a pixel gets from a microlens over which the edge moves by more than half a pixel: the mean over its even
    /// points, between which the edge moves by less than two pixels.
    pub(super) fn of_glass(&self, edges: &LensEdges, middle: [f64; 2]) -> f64 {
        let pixel = Pixel::new(self, middle);
        let points = &self.rule.even_points;
        let light = |&point: &[f64; 2]| {
            let lit = pixel.lit(edges.at(point), point);
            if lit.share > 0.0 { lit.share * self.cos4(pixel.place(&lit), point) } else { 0.0 }
        };
        points.iter().map(light).sum::<f64>() / points.len() as f64
    }

    /// The light that a pixel gets from a microlens over which the edge does not move.
    pub(super) fn sharp_of_glass(&self, edges: &LensEdges, middle: [f64; 2]) -> f64 {
        let (pixel, point) = (Pixel::new(self, middle), self.middle_of_light(middle));
        let lit = pixel.lit(edges.at(point), point);
        if lit.share > 0.0 { lit.share * self.mean_cos4(pixel.place(&lit)) } else { 0.0 }
    }

    /// The light that a pixel gets from a microlens over which the edge hardly moves.
    pub(super) fn narrow_of_glass(&self, edges: &LensEdges, middle: [f64; 2]) -> f64 {
        let pixel = Pixel::new(self, middle);
        self.rule.over_lens(|point| {
            let lit = pixel.lit(edges.at(point), point);
            if lit.share > 0.0 { self.cos4_of(lit.share, pixel.place(&lit), point) } else { 0.0 }
        })
    }
}

/// A pixel, and what it sees through a point of the microlens: a square in the exit pupil.
struct Pixel {
    middle: [f64; 2],
    width_m: f64,
    /// The middle of the square through the center of the microlens, how far it moves per distance on the microlens, and its width.
    square: [f64; 2],
    alpha: f64,
    square_m: f64,
}

impl Pixel {
    #[inline]
    fn new(light: &Light<'_>, middle: [f64; 2]) -> Self {
        let (per_sensor, width_m) = (1.0 / light.scale, light.width_m());
        let square = light.on_sensor(middle).map(|x| x * per_sensor);
        Self { middle, width_m, square, alpha: light.lens.alpha, square_m: width_m * per_sensor }
    }

    #[inline(always)]
    fn lit(&self, edge: &LightEdge, point: [f64; 2]) -> Moments {
        moments(edge, [0, 1].map(|k| self.square[k] - self.alpha * point[k]), self.square_m, DIVISIONS)
    }

    /// The middle of the lit part of a pixel, which is not dark.
    #[inline]
    fn place(&self, lit: &Moments) -> [f64; 2] {
        if lit.share >= 1.0 {
            return self.middle;
        }
        let width_m = self.width_m / lit.share;
        [0, 1].map(|k| self.middle[k] + lit.moved[k] * width_m)
    }
}

/// The lit part of a square.
struct Moments {
    share: f64,
    /// Its middle from that of the square, times the share, in widths of the square.
    moved: [f64; 2],
}

/// The part of a square in the exit pupil that an edge leaves light.
///
/// # Accuracy
///
/// Where the edge hardly bends it is straight: the mean one over the square, of the middle and the corners by the rule that is exact
/// for quadratic functions. Squares in which it bends, such as those at the tips of the light far from the axis, are divided.
#[inline(always)]
fn moments(edge: &LightEdge, middle: [f64; 2], width: f64, divisions: u32) -> Moments {
    match edge.is_lit(middle, FRAC_1_SQRT_2 * width) {
        Some(is_lit) => Moments { share: f64::from(u8::from(is_lit)), moved: [0.0; 2] },
        None => of_cut_square(edge, middle, width, divisions),
    }
}

/// The same of a square that an edge may cross.
#[inline(never)]
fn of_cut_square(edge: &LightEdge, middle: [f64; 2], width: f64, divisions: u32) -> Moments {
    let within = |x: f64, y: f64| edge.within_m([middle[0] + x * width, middle[1] + y * width]);
    let center = within(0.0, 0.0);
    let [a, b, c, d] = [within(-0.5, -0.5), within(0.5, -0.5), within(-0.5, 0.5), within(0.5, 0.5)];
    let corners = (a + b + c + d) / 4.0;
    let bend = (center - corners).abs().max((a + d - b - c).abs() / 4.0);
    if divisions > 0 && bend > STRAIGHT * width {
        let mut whole = Moments { share: 0.0, moved: [0.0; 2] };
        for [x, y] in [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]] {
            let part = moments(edge, [middle[0] + x * width, middle[1] + y * width], width / 2.0, divisions - 1);
            whole.share += part.share / 4.0;
            for (k, from) in [x, y].into_iter().enumerate() {
                whole.moved[k] += (part.moved[k] / 2.0 + from * part.share) / 4.0;
            }
        }
        return whole;
    }
    let [along_x, along_y] = [(b + d - a - c) / 2.0, (c + d - a - b) / 2.0];
    let share = cut_share((2.0 * center + corners) / 3.0, along_x, along_y);
    // Of a straight cut the middle of the lit part moves away from it, by half of the dark part of the square.
    let slope = (along_x * along_x + along_y * along_y).sqrt().max(f64::MIN_POSITIVE);
    let inwards = share * (1.0 - share) / (2.0 * slope);
    Moments { share, moved: [along_x * inwards, along_y * inwards] }
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
