//! The part of a microlens that is lit from a place on the sensor, and points of it.
//!
//! Seen from a place on the sensor, a microlens and the image of the exit pupil in its plane are two discs (or squares).
//! Light passes where both are. Two discs share a lune; its area has a closed form, and points are distributed evenly
//! over it in strips across the line between the centers.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::LensAperture;
use super::PupilShape;
use super::microlenses::{HEX_ROW, rotate};

/// The image of the pupil is taken for a half plane that covers all of a microlens or nothing, if it is larger than the
/// microlens by this factor: the edge then lies within 1e-7 of the micro-image's radius.
const HUGE: f64 = 1e7;

/// The number of entries of the table for the end of the disc.
const ENTRIES: usize = 1024;

/// The number of entries of the table for the rest of it.
const EVEN_ENTRIES: usize = 8192;

/// The part of the disc below which the first table is used.
const END: f64 = 0.01;

/// The part of a microlens through which light reaches a place on the sensor, in the plane of the microlens, from its
/// center.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LitRegion {
    shape: Shape,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Empty,
    /// A disc.
    Disc {
        center: [f64; 2],
        radius: f64,
    },
    /// What a disc of radius `lens` around (0, 0) and one of radius `pupil` at `distance` in `direction` share.
    Lune {
        lune: Lune,
        direction: [f64; 2],
    },
    /// A rectangle, in a frame that is rotated by an angle.
    Rectangle {
        low: [f64; 2],
        high: [f64; 2],
        rotation_rad: f64,
    },
    /// The points of a rectangle that pass both apertures.
    Masked {
        low: [f64; 2],
        high: [f64; 2],
        mask: Mask,
    },
}

/// What two discs share, whose centers are `distance` apart.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lune {
    lens: f64,
    pupil: f64,
    distance: f64,
    /// The areas on both sides of the chord through the corners: a segment of the second disc, which is nearer to the
    /// center of the first, and one of the first.
    left: f64,
    right: f64,
}

/// Both apertures.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Mask {
    aperture: LensAperture,
    rotation_rad: f64,
    /// The cell of the microlens, for light that passes beside the aperture instead of through it.
    cell: Option<[[f64; 2]; 3]>,
    pupil: PupilShape,
    /// Center and size of the image of the pupil, which is upside down if `flip` is -1; infinite for one that covers
    /// everything.
    center: [f64; 2],
    size: f64,
    flip: f64,
}

impl Mask {
    fn contains(&self, point: [f64; 2]) -> bool {
        let from_center = [0, 1].map(|k| (point[k] - self.center[k]) * self.flip);
        let in_pupil = self.size == f64::INFINITY || self.pupil.contains(from_center, self.size);
        let in_lens = is_in_lens(self.aperture, self.rotation_rad, point);
        in_pupil && self.cell.map_or(in_lens, |cell| !in_lens && is_in_cell(&cell, point))
    }
}

/// Whether a point is nearer to the center of its cell than to those of its neighbors.
fn is_in_cell(cell: &[[f64; 2]; 3], [x, y]: [f64; 2]) -> bool {
    cell.iter().all(|way| (x * way[0] + y * way[1]).abs() <= way[0] * way[0] + way[1] * way[1])
}

/// What light passes: the aperture of a microlens, or what is left beside it of its cell.
#[derive(Clone, Copy)]
pub(super) struct Opening {
    pub aperture: LensAperture,
    pub rotation_rad: f64,
    pub cell: Option<[[f64; 2]; 3]>,
}

impl Opening {
    /// The radius of the smallest disc around it.
    pub fn outer_radius_m(&self) -> f64 {
        match self.cell {
            None => self.aperture.outer_radius_m(),
            // The corners of a cell are at most 2 / sqrt(3) of half the way to a neighbor away, of a square one sqrt(2).
            Some(cell) => cell.iter().map(|way| way[0].hypot(way[1])).fold(0.0, f64::max) * std::f64::consts::SQRT_2,
        }
    }
}

pub(super) fn is_in_lens(aperture: LensAperture, rotation_rad: f64, point: [f64; 2]) -> bool {
    match aperture {
        LensAperture::Round { radius_m } => point[0] * point[0] + point[1] * point[1] <= radius_m * radius_m,
        LensAperture::Square { half_width_m } => {
            let [x, y] = rotate(point, -rotation_rad);
            x.abs().max(y.abs()) <= half_width_m
        }
        LensAperture::Hexagon { half_width_m } => {
            let [x, y] = rotate(point, -rotation_rad).map(f64::abs);
            x <= half_width_m && x / 2.0 + y * HEX_ROW <= half_width_m
        }
    }
}

impl LitRegion {
    /// `from_center`: (D_X / d) (X - C'), the pupil point of the ray through the center of the microlens.
    #[inline]
    pub(super) fn new(
        opening: Opening,
        pupil: PupilShape,
        pupil_radius: f64,
        from_center: [f64; 2],
        alpha: f64,
    ) -> Self {
        // A round microlens that is lit whole, as most are in unfocused cameras, needs neither root nor division.
        if let (LensAperture::Round { radius_m: radius }, PupilShape::Round, None) =
            (opening.aperture, pupil, opening.cell)
        {
            let [x, y] = from_center;
            let room = pupil_radius - alpha.abs() * radius;
            if room >= 0.0 && x * x + y * y <= room * room {
                return Self { shape: Shape::Disc { center: [0.0; 2], radius } };
            }
        }
        Self::partly_lit(opening, pupil, pupil_radius, from_center, alpha)
    }

    #[inline(never)]
    fn partly_lit(opening: Opening, pupil: PupilShape, pupil_radius: f64, from_center: [f64; 2], alpha: f64) -> Self {
        let Opening { aperture, rotation_rad, cell } = opening;
        let outer = opening.outer_radius_m();
        let is_huge = alpha == 0.0 || pupil_radius > HUGE * alpha.abs() * outer;
        let (center, size) = if is_huge {
            if !pupil.contains(from_center, pupil_radius) {
                return Self { shape: Shape::Empty };
            }
            ([0.0; 2], f64::INFINITY)
        } else {
            (from_center.map(|x| x / alpha), pupil_radius / alpha.abs())
        };
        let shape = match (aperture, pupil) {
            _ if cell.is_some() => masked(opening, pupil, center, size, -alpha.signum()),
            (LensAperture::Round { radius_m }, PupilShape::Round) => discs(radius_m, size, center),
            (LensAperture::Round { radius_m }, _) if size == f64::INFINITY => {
                Shape::Disc { center: [0.0; 2], radius: radius_m }
            }
            (LensAperture::Square { half_width_m: half }, _) if size == f64::INFINITY => {
                Shape::Rectangle { low: [-half; 2], high: [half; 2], rotation_rad }
            }
            (LensAperture::Square { half_width_m: half }, PupilShape::Square) if rotation_rad == 0.0 => {
                let low = center.map(|x| (x - size).max(-half));
                let high = center.map(|x| (x + size).min(half));
                Shape::Rectangle { low, high, rotation_rad }
            }
            _ => masked(opening, pupil, center, size, -alpha.signum()),
        };
        let is_empty = match shape {
            Shape::Rectangle { low, high, .. } | Shape::Masked { low, high, .. } => {
                low[0] >= high[0] || low[1] >= high[1]
            }
            _ => false,
        };
        Self { shape: if is_empty { Shape::Empty } else { shape } }
    }

    /// Returns whether no light passes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.shape == Shape::Empty
    }

    /// Returns the area over which [`point`](Self::point) distributes points evenly, in square meters: that of the region
    /// for round apertures and for parallel squares, else that of a rectangle around it.
    #[must_use]
    #[inline]
    pub fn sampled_area_m2(&self) -> f64 {
        match self.shape {
            Shape::Empty => 0.0,
            Shape::Disc { radius, .. } => PI * radius * radius,
            Shape::Lune { lune, .. } => lune.left + lune.right,
            Shape::Rectangle { low, high, .. } | Shape::Masked { low, high, .. } => {
                (high[0] - low[0]) * (high[1] - low[1])
            }
        }
    }

    /// Returns a point of the region for a point (u, v) of the unit square, in meters from the center of the microlens:
    /// evenly distributed, and for a microlens that is lit whole the same for every place on the sensor. `None` for points
    /// of the rectangle outside of the region. (1/2, 1/2) gives a point in the middle.
    #[must_use]
    #[inline]
    pub fn point(&self, [u, v]: [f64; 2]) -> Option<[f64; 2]> {
        match self.shape {
            Shape::Disc { center, radius } => {
                let from_end = Tables::get().end_distance(u);
                let half = radius * (from_end * (2.0 - from_end)).max(0.0).sqrt();
                Some([center[0] + radius * (from_end - 1.0), center[1] - (2.0 * v - 1.0) * half])
            }
            _ => self.point_of_part([u, v]),
        }
    }

    /// The same of what is no disc.
    #[inline(never)]
    fn point_of_part(&self, [u, v]: [f64; 2]) -> Option<[f64; 2]> {
        match self.shape {
            Shape::Empty | Shape::Disc { .. } => None,
            Shape::Lune { lune, direction } => {
                let [along, across] = lune.point([u, v]);
                Some([direction[0] * along - direction[1] * across, direction[1] * along + direction[0] * across])
            }
            Shape::Rectangle { low, high, rotation_rad } => {
                let point = [low[0] + u * (high[0] - low[0]), high[1] - v * (high[1] - low[1])];
                Some(if rotation_rad == 0.0 { point } else { rotate(point, rotation_rad) })
            }
            Shape::Masked { low, high, mask } => {
                let point = [low[0] + u * (high[0] - low[0]), high[1] - v * (high[1] - low[1])];
                let point = rotate(point, mask.rotation_rad);
                mask.contains(point).then_some(point)
            }
        }
    }

    /// Returns the area of the region, in square meters.
    ///
    /// # Accuracy
    ///
    /// Rounding for round apertures and parallel squares; others by 256 x 256 points.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        let Shape::Masked { .. } = self.shape else { return self.sampled_area_m2() };
        const SIDE: usize = 256;
        let at = |k: usize| (k as f64 + 0.5) / SIDE as f64;
        let inside = (0..SIDE * SIDE).filter(|k| self.point([at(k % SIDE), at(k / SIDE)]).is_some()).count();
        self.sampled_area_m2() * inside as f64 / (SIDE * SIDE) as f64
    }
}

/// The points of the smaller of the boxes around both apertures, along the sides of the microlens.
fn masked(opening: Opening, pupil: PupilShape, center: [f64; 2], size: f64, flip: f64) -> Shape {
    let Opening { aperture, rotation_rad, cell } = opening;
    let wide = match aperture {
        _ if cell.is_some() => [opening.outer_radius_m(); 2],
        LensAperture::Round { radius_m } => [radius_m; 2],
        LensAperture::Square { half_width_m } => [half_width_m; 2],
        LensAperture::Hexagon { half_width_m } => [half_width_m, aperture.outer_radius_m()],
    };
    let reach = match pupil {
        PupilShape::Square => {
            let (sin, cos) = rotation_rad.sin_cos();
            size * (sin.abs() + cos.abs())
        }
        _ => size,
    };
    let middle = rotate(center, -rotation_rad);
    let low = [0, 1].map(|k| (middle[k] - reach).max(-wide[k]));
    let high = [0, 1].map(|k| (middle[k] + reach).min(wide[k]));
    Shape::Masked { low, high, mask: Mask { aperture, rotation_rad, cell, pupil, center, size, flip } }
}

/// What a disc of radius `lens` around (0, 0) shares with one of radius `pupil` around `center`.
fn discs(lens: f64, pupil: f64, center: [f64; 2]) -> Shape {
    if pupil == f64::INFINITY {
        return Shape::Disc { center: [0.0; 2], radius: lens };
    }
    let squared = center[0] * center[0] + center[1] * center[1];
    if lens <= pupil && squared <= (pupil - lens) * (pupil - lens) {
        return Shape::Disc { center: [0.0; 2], radius: lens };
    }
    let distance = squared.sqrt();
    if distance >= lens + pupil {
        return Shape::Empty;
    }
    if distance <= (pupil - lens).abs() {
        return match lens <= pupil {
            true => Shape::Disc { center: [0.0; 2], radius: lens },
            false => Shape::Disc { center, radius: pupil },
        };
    }
    Shape::Lune { lune: Lune::new(lens, pupil, distance), direction: center.map(|x| x / distance) }
}

impl Lune {
    /// Discs of radius `lens` and `pupil` whose borders cross.
    fn new(lens: f64, pupil: f64, distance: f64) -> Self {
        // The chord through both corners, from the first center.
        let chord = (distance * distance + lens * lens - pupil * pupil) / (2.0 * distance);
        let left = segment(pupil, ((distance - chord) / pupil).clamp(-1.0, 1.0));
        let right = segment(lens, (chord / lens).clamp(-1.0, 1.0));
        Self { lens, pupil, distance, left, right }
    }

    /// A point, along and across the line from the center of the first disc to that of the second.
    #[inline]
    fn point(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let tables = Tables::get();
        let Self { lens, pupil, distance, left, right } = *self;
        let area = u * (left + right);
        // From the end of a disc, relative to its radius: accurate for discs much larger than the lune.
        let (along, from_end, radius) = if area < left {
            let from_end = tables.end_distance(area / (PI * pupil * pupil));
            ((distance - pupil) + pupil * from_end, from_end, pupil)
        } else {
            let from_end = tables.end_distance((left + right - area) / (PI * lens * lens));
            (lens - lens * from_end, from_end, lens)
        };
        let half = radius * (from_end * (2.0 - from_end)).max(0.0).sqrt();
        [along, (2.0 * v - 1.0) * half]
    }
}

/// The area of the segment of a disc beyond a chord at `cos` radii from the center.
fn segment(radius: f64, cos: f64) -> f64 {
    radius * radius * (cos.acos() - cos * (1.0 - cos * cos).sqrt())
}

/// The distance of the chord that cuts off a given part of the unit disc from the end of the disc.
struct Tables {
    /// The square root of that distance for the part (k / ENTRIES)^3 / 2: both roots make it nearly linear at the end.
    roots: Vec<f64>,
    /// The distance for the part k / EVEN_ENTRIES.
    even: Vec<f64>,
}

impl Tables {
    fn get() -> &'static Self {
        static TABLES: OnceLock<Tables> = OnceLock::new();
        TABLES.get_or_init(|| {
            let root = |part: f64| {
                // Newton's method for the angle of the segment: angle - sin angle cos angle = pi part.
                let mut angle = (1.5 * PI * part).cbrt();
                for _ in 0..60 {
                    let (sin, cos) = f64::sin_cos(angle);
                    let step = (angle - sin * cos - PI * part) / (2.0 * sin * sin).max(1e-300);
                    angle -= step;
                    if step.abs() < 1e-15 {
                        break;
                    }
                }
                // 1 - cos angle, its square root.
                (angle / 2.0).sin() * std::f64::consts::SQRT_2
            };
            let roots = (0..=ENTRIES).map(|k| root((k as f64 / ENTRIES as f64).powi(3) / 2.0)).collect();
            let even = |k: usize| {
                let part = k as f64 / EVEN_ENTRIES as f64;
                if part <= 0.5 { root(part).powi(2) } else { 2.0 - root(1.0 - part).powi(2) }
            };
            Self { roots, even: (0..=EVEN_ENTRIES).map(even).collect() }
        })
    }

    /// The distance of the chord from the end of the unit disc on whose side this part of the area lies, 0 to 2.
    #[inline]
    fn end_distance(&self, part: f64) -> f64 {
        if (END..=1.0 - END).contains(&part) {
            return interpolated(&self.even, part * EVEN_ENTRIES as f64);
        }
        let smaller = part.min(1.0 - part).max(0.0);
        let root = interpolated(&self.roots, (2.0 * smaller).cbrt() * ENTRIES as f64);
        if part <= 0.5 { root * root } else { 2.0 - root * root }
    }
}

/// The value of a table at a place between its entries.
#[inline]
fn interpolated(table: &[f64], at: f64) -> f64 {
    let k = (at as usize).min(table.len() - 2);
    let (low, high) = (table[k], table[k + 1]);
    low + (high - low) * (at - k as f64).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Areas against counted points, and limits.
    #[test]
    fn lunes_have_their_area() {
        for (pupil, distance) in [(1.26, 0.5), (1.26, 1.9), (0.4, 0.8), (3.0, 2.5), (100.0, 100.3), (1e5, 1e5)] {
            let region = LitRegion { shape: discs(1.0, pupil, [distance * 0.6, distance * 0.8]) };
            let mask = Mask {
                aperture: LensAperture::Round { radius_m: 1.0 },
                rotation_rad: 0.0,
                cell: None,
                pupil: PupilShape::Round,
                center: [distance * 0.6, distance * 0.8],
                size: pupil,
                flip: -1.0,
            };
            let side = 1000;
            let at = |k: usize| (k as f64 + 0.5) / side as f64 * 2.0 - 1.0;
            let count = (0..side * side).filter(|k| mask.contains([at(k % side), at(k / side)])).count();
            let counted = 4.0 * count as f64 / (side * side) as f64;
            // The boundary crosses some 4000 cells of 4e-6.
            assert!((region.area_m2() - counted).abs() < 1e-3, "{pupil} {distance}: {} {counted}", region.area_m2());
        }
        assert!(LitRegion { shape: discs(1.0, 2.0, [3.0, 0.0]) }.is_empty());
        assert_eq!(LitRegion { shape: discs(1.0, 2.0, [1.0, 0.0]) }.area_m2(), PI);
        assert_eq!(LitRegion { shape: discs(1.0, 0.5, [0.3, 0.0]) }.area_m2(), PI / 4.0);
    }

    /// Points lie inside and have the moments of points taken by rejection.
    #[test]
    fn points_are_even() {
        let side = 400;
        let at = |k: usize| (k as f64 + 0.5) / side as f64;
        for (pupil, distance) in [(1.26, 0.5), (1.26, 1.9), (0.4, 0.8), (0.4, 0.2), (3.0, 2.5), (1e4, 1e4)] {
            let region = LitRegion { shape: discs(1.0, pupil, [distance, 0.0]) };
            let points: Vec<_> =
                (0..side * side).map(|k| region.point([at(k % side), at(k / side)]).expect("inside")).collect();
            for [x, y] in &points {
                assert!(x * x + y * y <= 1.0 + 1e-9, "outside the lens: {x} {y}");
                let from_pupil = (x - distance).hypot(*y) / pupil;
                assert!(from_pupil <= 1.0 + 1e-6, "outside the pupil: {x} {y}, {from_pupil}");
            }
            let mut counted = [0.0; 4];
            let wide = 2000;
            for k in 0..wide * wide {
                let [x, y] = [k % wide, k / wide].map(|k| (k as f64 + 0.5) / f64::from(wide) * 2.0 - 1.0);
                if x * x + y * y <= 1.0 && (x - distance).powi(2) + y * y <= pupil * pupil {
                    [1.0, x, x * x, y * y].iter().zip(&mut counted).for_each(|(value, sum)| *sum += value);
                }
            }
            let count = points.len() as f64;
            let moment = |of: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(of).sum::<f64>() / count;
            let found = [moment(&|p| p[0]), moment(&|p| p[0] * p[0]), moment(&|p| p[1] * p[1])];
            for (k, found) in found.into_iter().enumerate() {
                let expected = counted[k + 1] / counted[0];
                // Both are quadratures: 1/400 in every strip, 1/1000 of the rejection's cells at the boundary.
                assert!((found - expected).abs() < 1e-3, "{pupil} {distance} moment {k}: {found} {expected}");
            }
        }
    }

    /// The table against its own function: the area left of the place.
    #[test]
    fn the_table_inverts_the_area() {
        let tables = Tables::get();
        for k in 0..=10_000 {
            let part = f64::from(k) / 10_000.0;
            let x = tables.end_distance(part) - 1.0;
            let area = (x * (1.0 - x * x).max(0.0).sqrt() + x.asin()) / PI + 0.5;
            assert!((area - part).abs() < 1e-7, "{part}: {area}");
        }
        assert_eq!([0.0, 0.5, 1.0].map(|part| tables.end_distance(part)), [0.0, 1.0, 2.0]);
        // Small segments of height h have the area 4/3 sqrt(2) h^1.5.
        for part in [1e-6, 1e-10, 1e-15] {
            let height = (part * PI * 0.75 / 2f64.sqrt()).powf(2.0 / 3.0);
            assert!((tables.end_distance(part) / height - 1.0).abs() < 1e-4 + height, "{part}");
        }
    }

    #[test]
    fn other_shapes_have_their_areas() {
        let square = LensAperture::Square { half_width_m: 1.0 };
        let opening = |aperture, rotation_rad| Opening { aperture, rotation_rad, cell: None };
        let region =
            |aperture, rotation, pupil, center| LitRegion::new(opening(aperture, rotation), pupil, 2.0, center, 2.0);
        // The pupil's image is a square of half width 1, half a unit to the right: 1.5 x 2 are shared.
        let parallel = region(square, 0.0, PupilShape::Square, [1.0, 0.0]);
        assert!((parallel.area_m2() - 3.0).abs() < 1e-12);
        // A square turned by 45 degrees and an equal one share a regular octagon: 8 (sqrt 2 - 1).
        let octagon = region(square, PI / 4.0, PupilShape::Square, [0.0, 0.0]);
        assert!((octagon.area_m2() - 8.0 * (2f64.sqrt() - 1.0)).abs() < 1e-2, "{}", octagon.area_m2());
        // A disc within a square.
        assert!((region(square, 0.3, PupilShape::Round, [0.0, 0.0]).area_m2() - PI).abs() < 1e-2);
        let hexagon = LensAperture::Hexagon { half_width_m: 0.5 };
        let whole = region(hexagon, 0.2, PupilShape::Round, [0.0, 0.0]);
        assert!((whole.area_m2() / hexagon.area_m2() - 1.0).abs() < 1e-2);
        assert!(region(square, 0.2, PupilShape::Round, [9.0, 0.0]).is_empty());
        // Without a movement over the pupil, all or nothing.
        let sharp = |x: f64| LitRegion::new(opening(square, 0.2), PupilShape::Round, 2.0, [x, 0.0], 0.0);
        assert!((sharp(1.99).area_m2() - 4.0).abs() < 1e-12 && sharp(2.01).is_empty());
        // A triangular pupil's image lies upside down behind a microlens with alpha above 0.
        let triangle = PupilShape::Polygon { blades: 3, rotation_rad: 0.0 };
        let disc = LensAperture::Round { radius_m: 5.0 };
        for alpha in [2.0f64, -2.0] {
            let image = LitRegion::new(opening(disc, 0.3), triangle, 2.0, [0.0; 2], alpha);
            assert!((image.area_m2() - 27f64.sqrt() / 4.0).abs() < 1e-2, "{}", image.area_m2());
            let points = (0..10_000).filter_map(|k| image.point([k % 100, k / 100].map(|k| f64::from(k) / 100.0)));
            let lowest = points.map(|point| point[1] * alpha.signum()).fold(0.0, f64::min);
            assert!((lowest + 1.0).abs() < 0.05, "{lowest}");
        }
        // What is left of a square cell beside a disc.
        let cell = Some([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]);
        let opening = Opening { aperture: LensAperture::Round { radius_m: 1.0 }, rotation_rad: 0.0, cell };
        let gap = LitRegion::new(opening, PupilShape::Round, 9.0, [0.0; 2], 1.0);
        assert!((gap.area_m2() - (4.0 - PI)).abs() < 2e-2, "{}", gap.area_m2());
    }
}
