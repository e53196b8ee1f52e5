//! Which light a lens lets pass to a place on the microlens array, by the distance of the place from the axis.

use super::{LensRays, TracedLens};

/// The number of distances from the axis in the table, evenly spread by their squares.
const NODES: usize = 65;

/// The number of distances whose chief ray is traced, as evenly spread.
const CHIEF_NODES: usize = 257;

/// The number of directions along half of the edge of the light.
const DIRECTIONS: usize = 65;

/// The number of directions along half of a disc at which nothing outside of it is lit.
const TIPS: u32 = 512;

/// The most that the distance of the exit pupil changes from a place to the next.
const MOST_CHANGE: f64 = 0.1;

/// Discs around the light are larger than it by this part of the exit pupil, for places between those of the table.
const MARGIN: f64 = 0.01;

/// The light of a place on the array, in the plane of the exit pupil that its chief ray crosses on the axis.
///
/// # Units
///
/// Meters in the plane, from the axis, along the direction to the place in the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plenoptic) struct Field {
    /// The distance of the plane from the array.
    pub exit_m: f64,
    /// The middle of a disc around the light.
    pub center_m: f64,
    /// The radius of the disc; 0 for a place without light.
    pub radius_m: f64,
    /// The radius around the axis within which all is light; below 0 if there is none.
    pub inner_m: f64,
}

/// The light of one place of the table.
#[derive(Debug, Clone, PartialEq)]
struct Node {
    field: Field,
    /// The distances of the edge of the light from the middle of the disc, for directions from 0 to pi.
    edge_m: Vec<f64>,
    shape: EdgeShape,
}

/// What bounds an edge around its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct EdgeShape {
    /// Its least and its greatest distance from the middle, m.
    least_m: f64,
    most_m: f64,
    /// The most by which the way to the edge changes per meter at the edge: 1 of a circle.
    steepness: f64,
}

/// The light of places on the array.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::plenoptic) struct FieldTable {
    nodes: Vec<Node>,
    /// The distances of the planes, closer together.
    exit_m: Vec<f64>,
    /// Nodes per square of the distance from the axis, 1/m^2.
    per_squared_m: f64,
    /// From the last surface to the array, m.
    array_m: f64,
}

impl FieldTable {
    /// Traces the table of an array `array_m` behind the last surface, whose places are at most `farthest_m` from the axis;
    /// `exit_m` and `radius_m` are the distance and the radius of the exit pupil near the axis.
    pub fn new(lens: &TracedLens, array_m: f64, (exit_m, radius_m): (f64, f64), farthest_m: f64) -> Self {
        // On the axis, of a place so near to it that its light is the same.
        let away = |k: usize, count: usize| (k as f64 / (count - 1) as f64).sqrt().max(1e-4) * farthest_m;
        let beam = |away_m| Beam { lens, array_m, away_m };
        // From the axis outwards, where every chief ray is near the last one.
        let mut last_m = exit_m;
        let planes = (0..CHIEF_NODES).map(|k| {
            last_m = beam(away(k, CHIEF_NODES)).exit_m(last_m);
            last_m
        });
        let planes: Vec<f64> = planes.collect();
        let of_node = |k: usize| planes[k * ((CHIEF_NODES - 1) / (NODES - 1))];
        Self {
            nodes: (0..NODES).map(|k| beam(away(k, NODES)).node(of_node(k), radius_m)).collect(),
            exit_m: planes,
            per_squared_m: (NODES - 1) as f64 / (farthest_m * farthest_m),
            array_m,
        }
    }

    /// From the last surface to the array, m.
    pub fn array_m(&self) -> f64 {
        self.array_m
    }

    /// The greatest distance of light from the axis of any place, m.
    pub fn outer_m(&self) -> f64 {
        self.nodes.iter().map(|node| node.field.center_m.abs() + node.field.radius_m).fold(0.0, f64::max)
    }

    /// The least and the greatest distance of the plane of any place from the array, m.
    pub fn exit_range_m(&self) -> [f64; 2] {
        self.exit_m.iter().fold([f64::INFINITY, 0.0], |[low, high], &x| [x.min(low), x.max(high)])
    }

    /// The distance of the plane of a place by the square of its distance from the axis, by four chief rays around it.
    fn exit_at_m(&self, squared_m: f64) -> f64 {
        let last = CHIEF_NODES - 1;
        let at = (squared_m * self.per_squared_m * last as f64 / (NODES - 1) as f64).min(last as f64);
        let first = (at as usize).saturating_sub(1).min(CHIEF_NODES - 4);
        lagrange(std::array::from_fn(|j| self.exit_m[first + j]), at - first as f64)
    }

    /// The place among the nodes.
    fn at(&self, squared_m: f64) -> (usize, f64) {
        let at = (squared_m * self.per_squared_m).min((NODES - 1) as f64);
        let k = (at as usize).min(NODES - 2);
        (k, at - k as f64)
    }

    /// The middle of the light of a place between two nodes. A place without light has no middle: where the light ends, the disc of
    /// the last place with light holds it.
    fn center_m(&self, k: usize, rest: f64) -> f64 {
        let (low, high) = (self.nodes[k].field, self.nodes[k + 1].field);
        match (low.radius_m > 0.0, high.radius_m > 0.0) {
            (true, false) => low.center_m,
            (false, true) => high.center_m,
            _ => low.center_m + (high.center_m - low.center_m) * rest,
        }
    }

    /// The light of a place by the square of its distance from the axis.
    pub fn field(&self, squared_m: f64) -> Field {
        let (k, rest) = self.at(squared_m);
        let (low, high) = (self.nodes[k].field, self.nodes[k + 1].field);
        let exit_m = self.exit_at_m(squared_m);
        // Angles change less from place to place than lengths in planes that lie elsewhere.
        let [radii, inner] = [[low.radius_m, high.radius_m], [low.inner_m, high.inner_m]]
            .map(|[a, b]| [exit_m / low.exit_m * a, exit_m / high.exit_m * b]);
        Field {
            exit_m,
            center_m: self.center_m(k, rest),
            radius_m: radii[0].max(radii[1]),
            inner_m: inner[0].min(inner[1]),
        }
    }

    /// The area of the light of a place over the square of the distance of its plane.
    pub fn solid_angle(&self, squared_m: f64) -> f64 {
        let (k, rest) = self.at(squared_m);
        let of_node = |node: &Node| {
            // Twice the triangles of half of the edge.
            let triangle = |j: usize| {
                let [[ax, ay], [bx, by]] = [unit(j), unit(j + 1)];
                node.edge_m[j] * node.edge_m[j + 1] * (ax * by - ay * bx)
            };
            (0..DIRECTIONS - 1).map(triangle).sum::<f64>() / (node.field.exit_m * node.field.exit_m)
        };
        of_node(&self.nodes[k]) * (1.0 - rest) + of_node(&self.nodes[k + 1]) * rest
    }

    /// The edge of the light of a place, in the plane that its chief ray crosses on the axis.
    pub fn edge(&self, place_m: [f64; 2]) -> LightEdge {
        let squared_m = place_m[0] * place_m[0] + place_m[1] * place_m[1];
        let away_m = squared_m.sqrt();
        let along = if away_m > 0.0 { place_m.map(|x| x / away_m) } else { [1.0, 0.0] };
        let (k, rest) = self.at(squared_m);
        let (low, high) = (&self.nodes[k], &self.nodes[k + 1]);
        let between = |a: f64, b: f64| a + (b - a) * rest;
        LightEdge {
            along,
            center_m: self.center_m(k, rest),
            edge_m: std::array::from_fn(|j| between(low.edge_m[j], high.edge_m[j])),
            shape: EdgeShape {
                least_m: between(low.shape.least_m, high.shape.least_m),
                most_m: between(low.shape.most_m, high.shape.most_m),
                steepness: low.shape.steepness.max(high.shape.steepness),
            },
        }
    }

    /// How far within the light a ray crosses the plane of the exit pupil that arrives at a place on the array with a slope per meter,
    /// both in upright coordinates: along the way from the middle of its disc to the edge, m; below 0 for one that the lens stops.
    ///
    /// # Accuracy
    ///
    /// The edge of the light is interpolated, within 5e-3 of the radius of the exit pupil.
    pub fn within_m(&self, place_m: [f64; 2], slope: [f64; 2]) -> f64 {
        let squared_m = place_m[0] * place_m[0] + place_m[1] * place_m[1];
        let away_m = squared_m.sqrt();
        let [cos, sin] = if away_m > 0.0 { place_m.map(|x| x / away_m) } else { [1.0, 0.0] };
        let (k, rest) = self.at(squared_m);
        let exit_m = self.exit_at_m(squared_m);
        let in_pupil = [0, 1].map(|axis| -(place_m[axis] + exit_m * slope[axis]));
        let [along, across] = [cos * in_pupil[0] + sin * in_pupil[1], cos * in_pupil[1] - sin * in_pupil[0]];
        let within = |node: &Node| within(&node.edge_m, [along - node.field.center_m, across]);
        within(&self.nodes[k]) * (1.0 - rest) + within(&self.nodes[k + 1]) * rest
    }
}

/// The edge of the light of one place on the array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plenoptic) struct LightEdge {
    /// The direction from the axis to the place in the image.
    along: [f64; 2],
    /// The middle of the light from the axis, along it, m.
    center_m: f64,
    edge_m: [f64; DIRECTIONS],
    shape: EdgeShape,
}

impl LightEdge {
    /// How far within the light a point of the plane lies, along the way from the middle to the edge, m; below 0 outside.
    #[inline]
    pub fn within_m(&self, [x, y]: [f64; 2]) -> f64 {
        within(&self.edge_m, self.centered([x, y]))
    }

    /// Whether all of a disc around a point is lit, or dark; `None` if the edge may cross it.
    #[inline]
    pub fn is_lit(&self, point: [f64; 2], radius_m: f64) -> Option<bool> {
        let [x, y] = self.centered(point);
        let (squared, reach) = (x * x + y * y, self.shape.steepness * radius_m);
        let (inner, outer) = (self.shape.least_m - reach, self.shape.most_m + reach);
        if inner > 0.0 && squared < inner * inner {
            return Some(true);
        }
        if squared > outer * outer {
            return Some(false);
        }
        let within_m = within(&self.edge_m, [x, y]);
        (within_m.abs() > reach).then_some(within_m > 0.0)
    }

    #[inline]
    fn centered(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.along;
        [cos * x + sin * y - self.center_m, cos * y - sin * x]
    }
}

/// How far within an edge a point lies, from its middle.
#[inline]
fn within(edge_m: &[f64], [x, y]: [f64; 2]) -> f64 {
    let sides = x.abs() + y.abs();
    let direction = if sides > 0.0 { (1.0 - x / sides) * ((DIRECTIONS - 1) as f64 / 2.0) } else { 0.0 };
    let j = (direction as usize).min(DIRECTIONS - 2);
    let (low, high) = (edge_m[j], edge_m[j + 1]);
    low + (high - low) * (direction - j as f64) - (x * x + y * y).sqrt()
}

/// The polynomial through four values at 0, 1, 2 and 3.
fn lagrange(values: [f64; 4], at: f64) -> f64 {
    let [a, b, c, d] = [at, at - 1.0, at - 2.0, at - 3.0];
    (values[3] * a * b * c - values[0] * b * c * d) / 6.0 + (values[1] * a * c * d - values[2] * a * b * d) / 2.0
}

/// The unit vector of a direction of the table, from 0 to pi: those to points evenly spread along two sides of a square that stands
/// on its corner.
fn unit(j: usize) -> [f64; 2] {
    let x = 1.0 - 2.0 * j as f64 / (DIRECTIONS - 1) as f64;
    let y = 1.0 - x.abs();
    let length = x.hypot(y);
    [x / length, y / length]
}

/// The displacement per meter of depth of the ray through the middle of the stop that ends at a distance from the axis on an array.
pub(in crate::plenoptic) fn chief_direction(lens: &TracedLens, array_m: f64, away_m: f64, exit_m: f64) -> f64 {
    let beam = Beam { lens, array_m, away_m };
    let mut ray = beam.ray([beam.chief_slope(exit_m), 0.0]);
    lens.trace(&mut ray)[1][0][0]
}

/// The rays that end at a place on the array.
struct Beam<'a> {
    lens: &'a TracedLens,
    array_m: f64,
    /// The distance of the place from the axis, to the right in the image.
    away_m: f64,
}

impl Beam<'_> {
    /// The ray that comes from a slope per meter towards the scene; the place is upside down there.
    fn ray(&self, slope: [f64; 2]) -> LensRays<1> {
        LensRays::new([[-self.away_m], [0.0]], -self.array_m, [[slope[0]], [slope[1]]])
    }

    /// The slope of the ray through the middle of the stop, by the secant method.
    fn chief_slope(&self, exit_m: f64) -> f64 {
        let miss = |slope: f64| self.lens.at_stop_m(self.ray([slope, 0.0]));
        let first = self.away_m / exit_m;
        let (mut before, mut slope) = (0.99 * first, first);
        let mut missed = miss(before);
        for _ in 0..50 {
            let now = miss(slope);
            let next = slope - now * (slope - before) / (now - missed);
            // Both are the middle, or as near to it as numbers are.
            if !next.is_finite() || now.abs() <= 1e-18 {
                break;
            }
            (before, missed, slope) = (slope, now, next);
        }
        slope
    }

    /// Where the chief ray crosses the axis, from the array; `near_m`: where that of a place a little nearer to the axis does, and
    /// this one too if it misses the lens.
    fn exit_m(&self, near_m: f64) -> f64 {
        let own = self.away_m / self.chief_slope(near_m);
        if (own / near_m - 1.0).abs() < MOST_CHANGE { own } else { near_m }
    }

    fn node(&self, own_exit_m: f64, radius_m: f64) -> Node {
        let is_lit = |x: f64, y: f64| {
            let mut ray = self.ray([(x + self.away_m) / own_exit_m, y / own_exit_m]);
            self.lens.trace(&mut ray);
            ray.clearance[0] >= 0.0
        };
        let wide = 3.0 * radius_m;
        let edge = |from: f64, [cos, sin]: [f64; 2], mut lit: f64| {
            let mut dark = wide;
            while dark - lit > 1e-7 * radius_m {
                let middle = (lit + dark) / 2.0;
                if is_lit(from + middle * cos, middle * sin) { lit = middle } else { dark = middle }
            }
            lit
        };
        let edges = |from: f64| -> Vec<f64> { (0..DIRECTIONS).map(|j| edge(from, unit(j), 0.0)).collect() };
        let inside = std::iter::once(0.0)
            .chain((1..=200).flat_map(|k| [-1.0, 1.0].map(|sign| sign * wide * f64::from(k) / 200.0)));
        let Some(from) = inside.into_iter().find(|&x| is_lit(x, 0.0)) else {
            let field = Field { exit_m: own_exit_m, center_m: 0.0, radius_m: 0.0, inner_m: -1.0 };
            return Node { field, edge_m: vec![0.0; DIRECTIONS], shape: EdgeShape::of(&[]) };
        };
        let points: Vec<[f64; 2]> = edges(from)
            .into_iter()
            .zip(0..)
            .map(|(edge, j)| {
                let [cos, sin] = unit(j);
                [from + edge * cos, edge * sin]
            })
            .collect();
        let farthest = |x: f64| points.iter().map(|point| (point[0] - x).hypot(point[1])).fold(0.0, f64::max);
        // The least disc around the light, by golden sections: the farthest point's distance is convex.
        let (mut low, mut high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p[0]), b.max(p[0])));
        while high - low > 1e-6 * radius_m {
            let [left, right] = [0.382, 0.618].map(|part| low + (high - low) * part);
            if farthest(left) < farthest(right) { high = right } else { low = left }
        }
        let center_m = (low + high) / 2.0;
        let mut disc_m = farthest(center_m) + MARGIN * radius_m;
        // The tip of a cat's eye may lie between two directions.
        for k in 1..TIPS {
            let (sin, cos) = (std::f64::consts::PI * f64::from(k) / f64::from(TIPS)).sin_cos();
            if is_lit(center_m + disc_m * cos, disc_m * sin) {
                disc_m = edge(center_m, [cos, sin], disc_m) + MARGIN * radius_m;
            }
        }
        let edge_m = edges(center_m);
        let inner = |(edge, j): (&f64, usize)| {
            let [cos, sin] = unit(j);
            (center_m + edge * cos).hypot(edge * sin)
        };
        let nearest = edge_m.iter().zip(0..).map(inner).fold(f64::INFINITY, f64::min);
        let inner_m = if is_lit(0.0, 0.0) { nearest - MARGIN * radius_m } else { -1.0 };
        Node {
            field: Field { exit_m: own_exit_m, center_m, radius_m: disc_m, inner_m },
            shape: EdgeShape::of(&edge_m),
            edge_m,
        }
    }
}

impl EdgeShape {
    /// That of an edge, or of no light.
    fn of(edge_m: &[f64]) -> Self {
        let steepest = edge_m.windows(2).zip(0..).map(|(ends, j)| {
            let angle = unit(j + 1)[0].acos() - unit(j)[0].acos();
            2.0 * (ends[1] - ends[0]).abs() / ((ends[0] + ends[1]) * angle)
        });
        let least_m = edge_m.iter().copied().fold(f64::INFINITY, f64::min);
        Self {
            least_m: if least_m.is_finite() { least_m } else { 0.0 },
            most_m: edge_m.iter().copied().fold(0.0, f64::max),
            steepness: steepest.filter(|slope| slope.is_finite()).fold(0.0, f64::max).hypot(1.0),
        }
    }
}
