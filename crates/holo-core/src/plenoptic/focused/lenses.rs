//! The microlenses around the rays of views.

use super::super::{MicrolensIndex, PlenopticCamera};
use crate::base::memory::filled;
use crate::{Error, GridSize};

/// Microlenses farther from a ray have next to no weight in its color, pitches.
pub(super) const FARTHEST: f64 = 1.6;

/// Microlenses whose centers lie within this distance of a ray may show its points, pitches.
pub(super) const REACH: f64 = 3.0;

/// The least virtual depth of points that views show, gaps: with less, points between microlenses of a hexagonal array are in no
/// micro-image (2 / sqrt(3)); of a square one with 1.42 or less.
const NEAREST_DEPTH: f64 = 1.45;

/// What the rays of a microlens need.
#[derive(Debug, Clone)]
pub(super) struct Lens {
    /// The center of its micro-image, (x, y) from the upper left corner of the sensor, px.
    pub center_px: [f64; 2],
    /// The slope of its chief ray through the middle of the pupil, to the right and up.
    pub slope: [f64; 2],
    /// How far a ray moves over the sensor per meter in the pupil, px/m.
    pub px_per_m: f64,
    /// The blur of a point, px: `blur[0] - blur[1] / (1 / depth - 1 / focus depth)`.
    pub blur: [f64; 2],
    /// Its type.
    pub lens_type: usize,
    /// The microlenses within [`REACH`], the nearest ones first: where they begin in the list, where those within [`FARTHEST`] end,
    /// and where all do.
    around: [u32; 3],
}

/// The microlenses whose micro-images lie on the sensor.
pub(super) struct Lenses {
    list: Vec<Lens>,
    around: Vec<u32>,
    /// The number in the list plus 1 by row and column from the first ones; 0: none.
    table: Vec<u32>,
    first: [i32; 2],
    size: GridSize,
    camera: PlenopticCamera,
    /// Of every type of microlens, by the distance from the center of the micro-image in [`LEAN_STEPS`] steps: how far the middle of
    /// the part that lights the place lies from that of the microlens, in the same direction, half widths.
    leans: Vec<Vec<f64>>,
    /// The slope between neighbors.
    pub pitch: f64,
    /// 1 / depth of the plane that is imaged onto the array.
    pub inverse_focus: f64,
    /// The distance of the images of a point behind neighbors, px, is this over 1 / depth - 1 / focus depth.
    pub shift_numerator: f64,
    /// What 1 / depth - 1 / focus depth is at the virtual depth [`NEAREST_DEPTH`].
    pub least_off_focus: f64,
    /// The most that a sample lies from the center of its micro-image, px.
    pub radius_px: f64,
}

impl Lenses {
    pub fn new(camera: &PlenopticCamera) -> Result<Self, Error> {
        let size = camera.sensor().size;
        let indices: Vec<MicrolensIndex> = camera
            .lens_lines(0..size.rows)
            .flat_map(|line| camera.lenses_on_line(line, 0..size.rows))
            .filter(|&lens| {
                let [x, y] = camera.micro_image_center_px(lens);
                (0.0..size.columns as f64).contains(&x) && (0.0..size.rows as f64).contains(&y)
            })
            .collect();
        if indices.is_empty() {
            return Err(Error::ZeroCount { what: "micro-images that lie wholly on the sensor" });
        }
        let bounds = |of: fn(&MicrolensIndex) -> i32| {
            let all = || indices.iter().map(of);
            (all().min().unwrap_or(0), all().max().unwrap_or(0))
        };
        let ((top, bottom), (left, right)) = (bounds(|lens| lens.row), bounds(|lens| lens.column));
        let grid = GridSize::new((bottom - top + 1) as usize, (right - left + 1) as usize);
        let mut table = filled("a table of microlenses", grid.count(), 0u32)?;
        for (k, lens) in indices.iter().enumerate() {
            table[(lens.row - top) as usize * grid.columns + (lens.column - left) as usize] = k as u32 + 1;
        }
        let list: Vec<Lens> = indices.iter().map(|&index| lens(camera, index)).collect();
        let mut lenses = Self {
            list,
            around: Vec::new(),
            table,
            first: [top, left],
            size: grid,
            camera: camera.clone(),
            leans: (0..camera.array().type_count()).map(|lens_type| leans(camera, lens_type)).collect(),
            pitch: camera.array().pitch_m * camera.pupils.slope_per_m,
            inverse_focus: camera.inverse_focus_per_m(),
            shift_numerator: camera.shift_numerator(),
            least_off_focus: camera.shift_numerator() / camera.shift_px(NEAREST_DEPTH),
            radius_px: camera.micro_image_pitch_px() / 2.0,
        };
        lenses.find_neighbors(&indices);
        Ok(lenses)
    }

    fn find_neighbors(&mut self, indices: &[MicrolensIndex]) {
        let reach = REACH.ceil() as i32 + 1;
        for (k, &index) in indices.iter().enumerate() {
            // A ray lies up to 0.6 pitches from the nearest microlens.
            let (near, far) = (FARTHEST + 0.6, REACH + 0.6);
            let mut found = vec![(0.0, k as u32)];
            for row in -reach..=reach {
                for column in -reach..=reach {
                    let other = MicrolensIndex { row: index.row + row, column: index.column + column };
                    let Some(other) = self.number(other).filter(|&other| other != k as u32) else { continue };
                    let away = self.away(&self.list[other as usize], self.list[k].slope);
                    if away <= far {
                        found.push((away, other));
                    }
                }
            }
            found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let start = self.around.len();
            let ends = [found.partition_point(|(away, _)| *away <= near), found.len()];
            self.around.extend(found.iter().map(|(_, other)| other));
            self.list[k].around = [start as u32, (start + ends[0]) as u32, (start + ends[1]) as u32];
        }
    }

    fn number(&self, index: MicrolensIndex) -> Option<u32> {
        let (row, column) = (index.row - self.first[0], index.column - self.first[1]);
        let is_inside =
            row >= 0 && column >= 0 && (row as usize) < self.size.rows && (column as usize) < self.size.columns;
        let number = if is_inside { self.table[row as usize * self.size.columns + column as usize] } else { 0 };
        number.checked_sub(1)
    }

    /// How far a microlens is from the place on the array that a slope leads to, pitches.
    pub fn away(&self, lens: &Lens, slope: [f64; 2]) -> f64 {
        (lens.slope[0] - slope[0]).hypot(lens.slope[1] - slope[1]) / self.pitch
    }

    /// The microlenses around the place on the array that a slope leads to, at least those within [`FARTHEST`] or, far ones too,
    /// within [`REACH`]; none beside the sensor.
    pub fn around(&self, slope: [f64; 2], with_far_ones: bool) -> impl Iterator<Item = &Lens> {
        let origin = self.camera.array_origin_m();
        let place = [0, 1].map(|k| slope[k] / self.camera.pupils.slope_per_m - origin[k]);
        let near = self.number(self.camera.array().nearest(place));
        let [start, end, far_end] = near.map_or([0; 3], |near| self.list[near as usize].around);
        let end = if with_far_ones { far_end } else { end };
        self.around[start as usize..end as usize].iter().map(|&k| &self.list[k as usize])
    }

    /// How far, in half widths of the microlens, the light of a place comes from beside its middle; the place from the center of the
    /// micro-image, px.
    pub fn lean(&self, lens: &Lens, distance_px: f64) -> f64 {
        let leans = &self.leans[lens.lens_type];
        let at = (distance_px / self.radius_px * LEAN_STEPS as f64).min(LEAN_STEPS as f64);
        let below = (at as usize).min(LEAN_STEPS - 1);
        leans[below] + (at - below as f64) * (leans[below + 1] - leans[below])
    }

    /// The microlens whose micro-image a pixel lies in, if that is on the sensor.
    pub fn owner(&self, position_px: [f64; 2]) -> Option<&Lens> {
        let owner = self.camera.owner(self.camera.place_m(position_px));
        self.number(owner).map(|k| &self.list[k as usize])
    }
}

/// The steps from the center of a micro-image to its border.
const LEAN_STEPS: usize = 24;

/// The middle of the lit part of a microlens, by the distance of the place that it lights: pupil and microlens as discs.
fn leans(camera: &PlenopticCamera, lens_type: usize) -> Vec<f64> {
    const SIDE: usize = 48;
    let half_light_px = camera.micro_image_radii_m(lens_type)[1] / camera.sensor().pixel_m;
    let half_width_m = camera.array().aperture.half_width_m();
    // How far the microlens reaches over the exit pupil, in radii of the pupil.
    let reach = camera.alpha(lens_type) * half_width_m / camera.exit_pupil_radius_m();
    let at = |k: usize| (2.0 * k as f64 + 1.0) / SIDE as f64 - 1.0;
    let mean = |step: usize| {
        let away = step as f64 / LEAN_STEPS as f64 * camera.micro_image_pitch_px() / 2.0 / half_light_px;
        let (mut count, mut sum) = (0.0, 0.0);
        for k in 0..SIDE * SIDE {
            let [x, y] = [at(k % SIDE), at(k / SIDE)];
            if x.hypot(y) <= 1.0 && (away - reach * x).hypot(reach * y) <= 1.0 {
                (count, sum) = (count + 1.0, sum + x);
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    };
    (0..=LEAN_STEPS).map(mean).collect()
}

fn lens(camera: &PlenopticCamera, index: MicrolensIndex) -> Lens {
    let lens = camera.microlens(index);
    let pixel_m = camera.sensor().pixel_m;
    let rays = lens.ray_coefficients();
    let chief_m = camera.undistorted_m(lens.center_m);
    let px_per_m = 1.0 / (rays.origin_per_sensor * pixel_m);
    let half_px = px_per_m * camera.array().aperture.half_width_m();
    Lens {
        center_px: camera.position_px(lens.image_center_m),
        slope: chief_m.map(|x| x * rays.slope_per_m),
        px_per_m,
        blur: [half_px * rays.origin_per_lens, half_px * rays.slope_per_m],
        lens_type: lens.lens_type,
        around: [0; 3],
    }
}
