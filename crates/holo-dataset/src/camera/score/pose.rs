//! The place of a calibrated camera from which it sees the corners best.

use holo_core::plenoptic::{MicrolensIndex, PlenopticCamera};

/// Gauss-Newton steps: the errors are small, and the first few settle it.
const STEPS: usize = 8;

/// By how much a rotation (rad) and a place, relative to the depth, are changed for derivatives.
const DELTA: f64 = 1e-6;

/// A rotation by a vector (rad) and a movement (m) of points before a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Movement(pub [f64; 6]);

/// A point and where a microlens sees it.
pub(super) struct Sight {
    pub point_m: [f64; 3],
    pub lens: MicrolensIndex,
    pub position_px: [f64; 2],
}

impl Movement {
    pub const NONE: Self = Self([0.0; 6]);

    /// The angle, degrees.
    pub fn angle_deg(&self) -> f64 {
        let [x, y, z, ..] = self.0;
        x.hypot(y).hypot(z).to_degrees()
    }

    /// The movement, m.
    pub fn length_m(&self) -> f64 {
        let [.., x, y, z] = self.0;
        x.hypot(y).hypot(z)
    }

    pub fn of(&self, p: [f64; 3]) -> [f64; 3] {
        let [a, b, c, x, y, z] = self.0;
        let angle = a.hypot(b).hypot(c);
        let (sine, rest) = match angle {
            0.0 => (1.0, 0.5),
            _ => (angle.sin() / angle, (1.0 - angle.cos()) / (angle * angle)),
        };
        let cross = |u: [f64; 3], v: [f64; 3]| {
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        };
        // Rodrigues' formula.
        let once = cross([a, b, c], p);
        let twice = cross([a, b, c], once);
        std::array::from_fn(|k| p[k] + sine * once[k] + rest * twice[k] + [x, y, z][k])
    }

    /// The movement with which the camera sees the points best, in the sense of least squares.
    pub fn best(camera: &PlenopticCamera, sights: &[Sight]) -> Self {
        let mut best = Self::NONE;
        let mut least = squares(camera, sights, &best);
        for _ in 0..STEPS {
            let Some(step) = step(camera, sights, &best) else { break };
            // A step that is too long is halved.
            let shorter = (0..4).map(|halvings| 0.5f64.powi(halvings));
            let tried = shorter.map(|share| Self(std::array::from_fn(|k| best.0[k] + share * step[k])));
            let found = tried.map(|tried| (squares(camera, sights, &tried), tried)).find(|(sum, _)| *sum < least);
            let Some((sum, movement)) = found else { break };
            (least, best) = (sum, movement);
        }
        best
    }
}

/// The error of a sight, px.
fn error(camera: &PlenopticCamera, sight: &Sight, movement: &Movement) -> Option<[f64; 2]> {
    let found = camera.project(movement.of(sight.point_m), sight.lens)?.position_px;
    Some([0, 1].map(|k| found[k] - sight.position_px[k]))
}

fn squares(camera: &PlenopticCamera, sights: &[Sight], movement: &Movement) -> f64 {
    let errors = sights.iter().filter_map(|sight| error(camera, sight, movement));
    errors.map(|[x, y]| x * x + y * y).sum()
}

/// The step of Gauss and Newton; `None` if the sights do not fix it.
fn step(camera: &PlenopticCamera, sights: &[Sight], movement: &Movement) -> Option<[f64; 6]> {
    let mut rows = [[0.0; 7]; 6];
    for sight in sights {
        let Some(own) = error(camera, sight, movement) else { continue };
        let depth_m = sight.point_m[2].abs();
        let mut slopes = [[0.0; 2]; 6];
        for (k, slope) in slopes.iter_mut().enumerate() {
            let delta = if k < 3 { DELTA } else { DELTA * depth_m };
            let mut moved = *movement;
            moved.0[k] += delta;
            let there = error(camera, sight, &moved)?;
            *slope = [0, 1].map(|axis| (there[axis] - own[axis]) / delta);
        }
        for (row, a) in rows.iter_mut().zip(&slopes) {
            for (sum, b) in row.iter_mut().zip(slopes.iter().chain([&own.map(|x| -x)])) {
                *sum += a[0] * b[0] + a[1] * b[1];
            }
        }
    }
    solved(rows)
}

/// The solution of equations whose right side is the last column: Gauss's elimination with pivots.
fn solved(mut rows: [[f64; 7]; 6]) -> Option<[f64; 6]> {
    for column in 0..6 {
        let pivot = (column..6).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))?;
        rows.swap(column, pivot);
        let pivot = rows[column];
        if pivot[column] == 0.0 {
            return None;
        }
        for (k, row) in rows.iter_mut().enumerate() {
            let share = row[column] / pivot[column];
            if k != column {
                row.iter_mut().zip(&pivot).for_each(|(value, by)| *value -= share * by);
            }
        }
    }
    let found: [f64; 6] = std::array::from_fn(|k| rows[k][6] / rows[k][k]);
    found.iter().all(|x| x.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use holo_io::CameraFile;

    use super::*;

    /// What is moved is found, and what is seen rightly stays.
    #[test]
    fn movements_are_found() {
        let camera = CameraFile::preset("raytrix-r12-a").unwrap().camera;
        for truth in [Movement::NONE, Movement([2e-3, -1e-3, 4e-3, 1e-3, -2e-3, 3e-3])] {
            let mut sights = Vec::new();
            for k in 0..60 {
                let place = [k % 5, k / 5 % 4, k / 20].map(f64::from);
                let seen_m = [0.01 * (place[0] - 2.0), 0.01 * (place[1] - 1.5), -0.3 - 0.05 * place[2]];
                for lens in camera.lenses_seeing(seen_m, 8.0) {
                    let position_px = camera.project(seen_m, lens).unwrap().position_px;
                    sights.push((seen_m, lens, position_px));
                }
            }
            // The points before they are moved.
            let back = Movement(truth.0.map(|x| -x));
            let undone = |[x, y, z]: [f64; 3]| {
                let moved = [x - truth.0[3], y - truth.0[4], z - truth.0[5]];
                Movement([back.0[0], back.0[1], back.0[2], 0.0, 0.0, 0.0]).of(moved)
            };
            let sights: Vec<Sight> = sights
                .into_iter()
                .map(|(seen_m, lens, position_px)| Sight { point_m: undone(seen_m), lens, position_px })
                .collect();
            assert!(sights.len() > 200);
            let found = Movement::best(&camera, &sights);
            for k in 0..6 {
                assert!((found.0[k] - truth.0[k]).abs() < 1e-9, "{found:?} {truth:?}");
            }
            assert!((found.angle_deg() - truth.angle_deg()).abs() < 1e-6 && found.length_m() < 5e-3);
        }
    }
}
