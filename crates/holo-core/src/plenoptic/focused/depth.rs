//! The inverse depth of the central view: from that of the raw image, or estimated.

use ndarray::{Array2, ArrayView2};

use super::super::PlenopticCamera;
use super::lenses::Lenses;
use super::samples::{Brightness, Point, RawLight};
use crate::base::memory::filled;
use crate::base::parallel::*;
use crate::estimate::{WORST, aggregate};
use crate::synthesize::fill;
use crate::{Error, GridSize, Rig, RigRay};

/// The least virtual depth that is looked for, gaps: a point nearer to the array is shown by too few microlenses.
pub(super) const LEAST_DEPTH: f64 = 1.9;

/// The greatest one, gaps: images of points beyond it hardly move from microlens to microlens.
pub(super) const MOST_DEPTH: f64 = 12.0;

/// The distance of neighboring images changes by this from plane to plane, px.
const STEP_PX: f64 = 0.2;

/// The deviation of samples at which the cost is the worst, relative to the brightness of most pixels.
const TRUNCATION: f64 = 0.12;

/// The cost of a point that one microlens shows at most.
const UNSEEN: u16 = (0.5 * WORST) as u16;

/// Views of more pixels are swept at half of the resolution.
const MOST_PIXELS: usize = 500_000;

/// The inverse depth of the central view from that of the pixels of the raw image: each pixel of the view has that of the sample
/// nearest to it in the pupil.
pub(super) fn of_raw(
    camera: &PlenopticCamera,
    lenses: &Lenses,
    rig: &Rig,
    depth_m: ArrayView2<f32>,
) -> Result<Array2<f32>, Error> {
    let (t, s) = rig.shape().central_view();
    let size = rig.shape().lenses();
    let mut map = filled("a depth map", size.count(), f32::NAN)?;
    let mut nearest = filled("a depth map", size.count(), f32::INFINITY)?;
    let radius_px = lenses.radius_px.min(camera.micro_image_radii_m(0)[1] / camera.sensor().pixel_m);
    let eye = rig.ray(0, 0, t, s, 0.5, 0.5).origin_m;
    for ((row, column), &depth_m) in depth_m.indexed_iter() {
        let place_px = [column as f64 + 0.5, row as f64 + 0.5];
        let Some(lens) = lenses.owner(place_px).filter(|_| depth_m > 0.0) else { continue };
        let offset = [place_px[0] - lens.center_px[0], lens.center_px[1] - place_px[1]];
        if offset[0].hypot(offset[1]) > radius_px {
            continue;
        }
        // The point, in slopes from the middle of the view.
        let inverse = 1.0 / f64::from(depth_m);
        let in_pupil_m = offset.map(|x| x / lens.px_per_m);
        let slope = [0, 1].map(|k| in_pupil_m[k] * (inverse - lenses.inverse_focus) + lens.slope[k]);
        let seen = [0, 1].map(|k| slope[k] - eye[k] * inverse);
        let shift = |k: usize| eye[k] / rig.focus_distance_m();
        let (v, u) = (rig.row(seen[1] + shift(1)), rig.column(seen[0] + shift(0)));
        if !(v >= 0.0 && u >= 0.0 && v < size.rows as f64 && u < size.columns as f64) {
            continue;
        }
        let at = v as usize * size.columns + u as usize;
        let away = (in_pupil_m[0] - eye[0]).hypot(in_pupil_m[1] - eye[1]) as f32;
        if away < nearest[at] {
            (nearest[at], map[at]) = (away, inverse as f32);
        }
    }
    if map.iter().all(|x| x.is_nan()) {
        return Err(Error::BadNumber {
            what: "depth of the raw image in meters",
            value: f64::NAN,
            need: "a number somewhere",
        });
    }
    fill(&mut map, [size.rows, size.columns], &mut [], 0);
    Ok(Array2::from_shape_vec((size.rows, size.columns), map).expect("the length is the product"))
}

/// The planes of a sweep: distances of neighboring images, px, all of one sign and with a depth in front of the camera.
struct Planes {
    shifts_px: Vec<f64>,
    /// Distance times (1 / depth - 1 / focus depth).
    numerator: f64,
    inverse_focus: f64,
    pitch_px: f64,
}

impl Planes {
    fn new(lenses: &Lenses, [from_px, to_px]: [f64; 2]) -> Result<Self, Error> {
        let numerator = lenses.shift_numerator;
        let count = ((to_px - from_px).abs() / STEP_PX).ceil() as usize + 1;
        let at = |k: usize| from_px + (to_px - from_px) * k as f64 / (count - 1).max(1) as f64;
        let inverse = |shift_px: f64| lenses.inverse_focus + numerator / shift_px;
        let shifts_px: Vec<f64> = (0..count).map(at).filter(|&shift| inverse(shift) > 0.0).collect();
        if shifts_px.is_empty() {
            let (what, value) = ("depth at a virtual depth of 2 to 12 gaps in meters", 1.0 / inverse(to_px));
            return Err(Error::BadNumber { what, value, need: "in front of the camera" });
        }
        let pitch_px = 2.0 * lenses.radius_px;
        Ok(Self { shifts_px, numerator, inverse_focus: lenses.inverse_focus, pitch_px })
    }

    fn inverse_depth(&self, plane: f64) -> f64 {
        let below = (plane.floor() as usize).min(self.shifts_px.len() - 1);
        let above = (below + 1).min(self.shifts_px.len() - 1);
        let part = plane - below as f64;
        let shift_px = self.shifts_px[below] + part * (self.shifts_px[above] - self.shifts_px[below]);
        self.inverse_focus + self.numerator / shift_px
    }

    /// How far from a ray microlenses show its points, pitches: half of the virtual depth.
    fn reach(&self, plane: usize) -> f64 {
        (0.5 * self.pitch_px / self.shifts_px[plane].abs()).max(1.0)
    }
}

/// The inverse depth of the central view: the plane on which micro-images agree, aggregated along eight directions.
pub(super) fn estimated(
    lenses: &Lenses,
    rig: &Rig,
    light: &RawLight<'_>,
    shifts_px: [f64; 2],
) -> Result<Array2<f32>, Error> {
    let planes = Planes::new(lenses, shifts_px)?;
    let full = rig.shape().lenses();
    let factor = if full.count() > MOST_PIXELS { 2 } else { 1 };
    let size = GridSize::new(full.rows.div_ceil(factor), full.columns.div_ceil(factor));
    let (t, s) = rig.shape().central_view();
    let ray = |v: usize, u: usize| -> RigRay {
        let middle = |k: usize, count: usize| (factor * k + factor / 2).min(count - 1);
        rig.ray(middle(v, full.rows), middle(u, full.columns), t, s, 0.5, 0.5)
    };
    let brightness = Brightness::new(light)?;
    let count = planes.shifts_px.len();
    let mut costs = filled("the costs of a sweep", size.count() * count, 0u16)?;
    let mut guide = filled("a guide image", size.count(), 0.0f32)?;
    costs.par_chunks_mut(size.columns * count).zip(guide.par_chunks_mut(size.columns)).enumerate().for_each(
        |(v, (costs, guide))| {
            let mut near = Vec::new();
            for (u, (costs, guide)) in costs.chunks_exact_mut(count).zip(guide.iter_mut()).enumerate() {
                let (ray, mut least) = (ray(v, u), f64::INFINITY);
                // Where a ray meets the array does not depend on the depth.
                let on_array = Point::new(&ray, 0.0).on_array(lenses);
                near.clear();
                near.extend(lenses.around(on_array, true).map(|lens| (lens, lenses.away(lens, on_array))));
                for (plane, cost) in costs.iter_mut().enumerate() {
                    let point = Point::new(&ray, planes.inverse_depth(plane as f64));
                    *cost = UNSEEN;
                    if let Some(found) = lenses.agreement(&brightness, &point, &near, planes.reach(plane)) {
                        *cost = ((found.deviation / TRUNCATION).min(1.0) * f64::from(WORST)) as u16;
                        if found.deviation < least {
                            (least, *guide) = (found.deviation, found.mean as f32);
                        }
                    }
                }
            }
        },
    );
    let costs = box_means(&costs, size, count)?;
    let mut sums = filled("the costs of a sweep", size.count() * count, 0u16)?;
    aggregate(&costs, size, count, &guide, &mut sums);
    let mut map = filled("a depth map", size.count(), 0.0f32)?;
    for (value, sums) in map.iter_mut().zip(sums.chunks_exact(count)) {
        *value = best_plane(sums) as f32;
    }
    let map = medians(&map, size)?;
    let value =
        |(v, u): (usize, usize)| planes.inverse_depth(f64::from(map[(v / factor) * size.columns + u / factor])) as f32;
    Ok(Array2::from_shape_fn((full.rows, full.columns), value))
}

/// The means of costs over 3 x 3 pixels.
fn box_means(costs: &[u16], size: GridSize, planes: usize) -> Result<Vec<u16>, Error> {
    let mut means = filled("the costs of a sweep", costs.len(), 0u16)?;
    let stride = size.columns * planes;
    means.par_chunks_mut(stride).enumerate().for_each(|(v, means)| {
        let rows = v.saturating_sub(1)..(v + 2).min(size.rows);
        for u in 0..size.columns {
            let columns = u.saturating_sub(1)..(u + 2).min(size.columns);
            let count = (rows.len() * columns.len()) as u32;
            for plane in 0..planes {
                let at = |row: usize, column: usize| u32::from(costs[row * stride + column * planes + plane]);
                let sum: u32 = rows
                    .clone()
                    .flat_map(|row| columns.clone().map(move |column| (row, column)))
                    .map(|(row, column)| at(row, column))
                    .sum();
                means[u * planes + plane] = ((sum + count / 2) / count) as u16;
            }
        }
    });
    Ok(means)
}

/// The plane of the least cost, between planes by a parabola.
fn best_plane(sums: &[u16]) -> f64 {
    let (best, &least) = sums.iter().enumerate().min_by_key(|(_, cost)| **cost).expect("there are planes");
    let (Some(&left), Some(&right)) = (best.checked_sub(1).and_then(|k| sums.get(k)), sums.get(best + 1)) else {
        return best as f64;
    };
    let [left, least, right] = [left, least, right].map(f64::from);
    let bend = left + right - 2.0 * least;
    best as f64 + if bend > 0.0 { 0.5 * (left - right) / bend } else { 0.0 }
}

/// The medians over 3 x 3 pixels.
fn medians(map: &[f32], size: GridSize) -> Result<Vec<f32>, Error> {
    let mut medians = filled("a depth map", map.len(), 0.0f32)?;
    medians.par_chunks_mut(size.columns).enumerate().for_each(|(v, medians)| {
        for (u, median) in medians.iter_mut().enumerate() {
            let mut near = [0.0; 9];
            let mut count = 0;
            for row in v.saturating_sub(1)..(v + 2).min(size.rows) {
                for column in u.saturating_sub(1)..(u + 2).min(size.columns) {
                    near[count] = map[row * size.columns + column];
                    count += 1;
                }
            }
            near[..count].sort_unstable_by(f32::total_cmp);
            *median = near[count / 2];
        }
    });
    Ok(medians)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Images that move by a quarter of the pitch are those of points four gaps away, which four microlenses side by side show.
    #[test]
    fn microlenses_show_points_as_far_away_as_half_of_their_virtual_depth() {
        let planes = Planes { shifts_px: vec![-10.0, 40.0], numerator: 1.0, inverse_focus: 1.0, pitch_px: 40.0 };
        assert_eq!([0, 1].map(|plane| planes.reach(plane)), [2.0, 1.0]);
    }
}
