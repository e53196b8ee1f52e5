//! Placements of cameras: in a line, a grid, on a cylinder or a sphere, all towards one target.

use std::f64::consts::TAU;

use holo_core::{CameraJitter, GridSize};
use holo_io::{ArrayCamera, CameraArray};
use holo_scene::Transform;

use crate::Error;

/// How cameras stand around a target, in the world of glTF: +Y up, the front of a scene towards +Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Where they stand.
    pub surface: Surface,
    /// What they look at, m.
    pub target_m: [f64; 3],
    /// Distance of the nearest point of the surface from the target, m.
    pub radius_m: f64,
    /// Rows and columns of every image.
    pub size: GridSize,
    /// Focal length, px.
    pub focal_px: f64,
}

/// What cameras stand on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The plane in front of the target, in rows from the top, all with parallel axes.
    Plane {
        /// Rows and columns of cameras.
        count: GridSize,
        /// Distances between neighbors along the columns and the rows, m.
        spacing_m: [f64; 2],
    },
    /// A vertical cylinder around the target, in rows from the top; cameras look horizontally at its axis.
    Cylinder {
        /// Rows, and columns around the axis.
        count: GridSize,
        /// The angle that the columns cover, rad, its middle towards +Z; in a whole turn the last is not the first again.
        span_rad: f64,
        /// Distance between rows, m.
        spacing_m: f64,
    },
    /// A sphere around the target, evenly by a Fibonacci spiral from the top; cameras look at the target.
    Sphere {
        /// The number of cameras.
        count: usize,
        /// The lowest and the highest elevation above the horizon, rad.
        elevation_rad: [f64; 2],
    },
}

impl Placement {
    /// Returns the focal length, in pixels, of images of `columns` pixels whose horizontal angle of view is `angle_rad`.
    ///
    /// # Errors
    /// [`Error::BadRequest`] unless the angle is above 0 and below a half turn.
    pub fn focal_px(columns: usize, angle_rad: f64) -> Result<f64, Error> {
        match angle_rad > 0.0 && angle_rad < TAU / 2.0 {
            true => Ok(columns as f64 / (2.0 * (angle_rad / 2.0).tan())),
            false => Err(Error::BadRequest(
                "camera placement: the angle of view must be above 0 and below 180 degrees".into(),
            )),
        }
    }

    /// Returns the cameras, `camera_0000` and so on.
    ///
    /// # Errors
    /// [`Error::BadRequest`] for numbers that are not finite, lengths or counts that are not above 0, or angles out of
    /// range.
    pub fn cameras(&self) -> Result<CameraArray, Error> {
        self.check()?;
        let poses = match self.surface {
            Surface::Plane { count, spacing_m } => self.plane(count, spacing_m),
            Surface::Cylinder { count, span_rad, spacing_m } => self.cylinder(count, span_rad, spacing_m),
            Surface::Sphere { count, elevation_rad } => self.sphere(count, elevation_rad),
        };
        let camera = |(k, pose): (usize, Transform)| {
            let [x, y, z] = pose.columns;
            ArrayCamera {
                name: format!("camera_{k:04}"),
                axes_and_position: [x, y, z, pose.translation],
                focal_px: self.focal_px,
                size: Some(self.size),
                ..ArrayCamera::default()
            }
        };
        Ok(CameraArray { cameras: poses.into_iter().enumerate().map(camera).collect() })
    }

    fn check(&self) -> Result<(), Error> {
        let bad = |what: &str| Err(Error::BadRequest(format!("camera placement: {what}")));
        let is_above = |x: f64| x > 0.0 && x.is_finite();
        if !(is_above(self.radius_m) && is_above(self.focal_px)) || self.target_m.iter().any(|x| !x.is_finite()) {
            return bad("radius and focal length must be above 0, and the target finite");
        }
        if self.size.count() == 0 {
            return bad("the images have no pixels");
        }
        match self.surface {
            Surface::Plane { count, .. } | Surface::Cylinder { count, .. } if count.count() == 0 => bad("no cameras"),
            Surface::Sphere { count: 0, .. } => bad("no cameras"),
            Surface::Plane { spacing_m, .. } if !spacing_m.iter().all(|&x| is_above(x)) => {
                bad("the spacing must be above 0")
            }
            Surface::Cylinder { span_rad, spacing_m, .. }
                if !(is_above(span_rad) && span_rad <= TAU && is_above(spacing_m)) =>
            {
                bad("the angle must be above 0 and at most a whole turn, and the spacing above 0")
            }
            Surface::Sphere { elevation_rad: [low, high], .. }
                if !(low <= high && low >= -TAU / 4.0 && high <= TAU / 4.0) =>
            {
                bad("elevations run from -90 to 90 degrees, the lower one first")
            }
            _ => Ok(()),
        }
    }

    fn plane(&self, count: GridSize, [along, down]: [f64; 2]) -> Vec<Transform> {
        let [x, y, z] = self.target_m;
        let place = |k: usize| {
            let (row, column) = (k / count.columns, k % count.columns);
            let offset = [centered(column, count.columns) * along, -centered(row, count.rows) * down];
            Transform::from_translation([x + offset[0], y + offset[1], z + self.radius_m])
        };
        (0..count.count()).map(place).collect()
    }

    fn cylinder(&self, count: GridSize, span_rad: f64, spacing_m: f64) -> Vec<Transform> {
        // A closed circle has as many steps as cameras, an arc one less.
        let steps = if span_rad < TAU { (count.columns - 1).max(1) } else { count.columns };
        let place = |k: usize| {
            let (row, column) = (k / count.columns, k % count.columns);
            let angle = centered(column, count.columns) * span_rad / steps as f64;
            let height = -centered(row, count.rows) * spacing_m;
            let [x, y, z] = self.target_m;
            let axis = [x, y + height, z];
            let eye = [x + self.radius_m * angle.sin(), axis[1], z + self.radius_m * angle.cos()];
            Transform::look_at(eye, axis, [0.0, 1.0, 0.0])
        };
        (0..count.count()).map(place).collect()
    }

    fn sphere(&self, count: usize, [low, high]: [f64; 2]) -> Vec<Transform> {
        // The angle that divides a turn most evenly, whatever the number of steps.
        let golden = TAU * (3.0 - 5.0_f64.sqrt()) / 2.0;
        let place = |k: usize| {
            // Equal areas have equal heights.
            let share = (k as f64 + 0.5) / count as f64;
            let height = high.sin() + (low.sin() - high.sin()) * share;
            let flat = (1.0 - height * height).max(0.0).sqrt();
            let (sin, cos) = (golden * k as f64).sin_cos();
            let direction = [flat * sin, height, flat * cos];
            let eye = std::array::from_fn(|axis| self.target_m[axis] + self.radius_m * direction[axis]);
            // Straight above or below, the top of the image is towards -Z.
            let up = if flat < 1e-9 { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
            Transform::look_at(eye, self.target_m, up)
        };
        (0..count).map(place).collect()
    }
}

/// Lets cameras deviate from what was meant. What they are, the list says afterwards.
///
/// # Errors
/// [`Error::BadRequest`] if a number of the jitter is negative or not finite.
pub fn jittered(mut array: CameraArray, jitter: &CameraJitter, seed: u64) -> Result<CameraArray, Error> {
    for (k, camera) in array.cameras.iter_mut().enumerate() {
        let deviation =
            jitter.deviation(seed, k as u64).map_err(|why| Error::BadRequest(format!("camera placement: {why}")))?;
        let [x, y, z, position] = camera.axes_and_position;
        let ([x, y, z], position) = deviation.moved([x, y, z], position);
        camera.axes_and_position = [x, y, z, position];
        camera.focal_px *= deviation.focal;
        camera.gain = std::array::from_fn(|channel| camera.gain[channel] * deviation.gain[channel]);
        camera.time_s += deviation.time_s;
    }
    Ok(array)
}

/// The position of entry `k` of `count` from their middle.
fn centered(k: usize, count: usize) -> f64 {
    k as f64 - (count - 1) as f64 / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(surface: Surface) -> Vec<[[f64; 3]; 4]> {
        let placement =
            Placement { surface, target_m: [1.0, 2.0, 3.0], radius_m: 4.0, size: GridSize::new(6, 8), focal_px: 9.0 };
        placement.cameras().expect("cameras").cameras.into_iter().map(|camera| camera.axes_and_position).collect()
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    #[test]
    fn planes_have_rows_from_the_top() {
        let cameras = placed(Surface::Plane { count: GridSize::new(2, 3), spacing_m: [0.5, 0.25] });
        let places: Vec<[f64; 3]> = cameras.iter().map(|camera| camera[3]).collect();
        assert_eq!(places[0], [0.5, 2.125, 7.0]);
        assert_eq!(places[5], [1.5, 1.875, 7.0]);
        assert!(cameras.iter().all(|camera| camera[2] == [0.0, 0.0, 1.0]));
        let line = placed(Surface::Plane { count: GridSize::new(1, 4), spacing_m: [0.5, 1.0] });
        assert!(line.iter().all(|camera| camera[3][1] == 2.0) && line[3][3][0] == 1.75);
    }

    #[test]
    fn cylinders_and_spheres_look_inward() {
        let arc = Surface::Cylinder { count: GridSize::new(3, 5), span_rad: 1.0, spacing_m: 0.5 };
        let turn = Surface::Cylinder { count: GridSize::new(1, 8), span_rad: TAU, spacing_m: 1.0 };
        let dome = Surface::Sphere { count: 100, elevation_rad: [0.0, TAU / 4.0] };
        for (surface, count) in [(arc, 15), (turn, 8), (dome, 100)] {
            let cameras = placed(surface);
            assert_eq!(cameras.len(), count);
            for [right, up, back, eye] in cameras {
                let height = if matches!(surface, Surface::Sphere { .. }) { 2.0 } else { eye[1] };
                let middle = [1.0, height, 3.0];
                assert!((distance(eye, middle) - 4.0).abs() < 1e-12);
                // Its back points away from what it looks at.
                let ahead: [f64; 3] = std::array::from_fn(|k| eye[k] - 4.0 * back[k]);
                assert!(distance(ahead, middle) < 1e-12 && up[1] >= 0.0 && right[1].abs() < 1e-12);
            }
        }
        // In a whole turn all neighbors are equally far, the last and the first too.
        let turn: Vec<[f64; 3]> = placed(turn).iter().map(|camera| camera[3]).collect();
        let step = distance(turn[0], turn[1]);
        assert!((0..8).all(|k| (distance(turn[k], turn[(k + 1) % 8]) - step).abs() < 1e-12));
        // The middle of an arc is in front.
        assert!((placed(arc)[7][3][2] - 7.0).abs() < 1e-12);
    }

    /// Cameras on a whole sphere are about as far from their nearest neighbors as evenly spread ones are.
    #[test]
    fn spheres_are_covered_evenly() {
        let cameras = placed(Surface::Sphere { count: 200, elevation_rad: [-TAU / 4.0, TAU / 4.0] });
        let nearest = |a: &[[f64; 3]; 4]| {
            let others = cameras.iter().filter(|b| b[3] != a[3]).map(|b| distance(a[3], b[3]));
            others.fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = cameras.iter().map(nearest).collect();
        let even = 4.0 * (2.0 * TAU / 200.0_f64).sqrt();
        assert!(distances.iter().all(|d| (0.7..1.1).contains(&(d / even))), "{distances:?}");
    }

    #[test]
    fn impossible_placements_are_errors() {
        let sphere = |count, elevation_rad| Surface::Sphere { count, elevation_rad };
        let plane = |rows, spacing: f64| Surface::Plane { count: GridSize::new(rows, 3), spacing_m: [spacing; 2] };
        let cylinder = |span_rad| Surface::Cylinder { count: GridSize::new(1, 3), span_rad, spacing_m: 1.0 };
        let good = Placement {
            surface: sphere(3, [0.0, 1.0]),
            target_m: [0.0; 3],
            radius_m: 1.0,
            size: GridSize::new(2, 2),
            focal_px: 1.0,
        };
        assert!(good.cameras().is_ok());
        for surface in [
            sphere(0, [0.0, 1.0]),
            sphere(3, [1.0, 0.0]),
            sphere(3, [f64::NAN, 0.0]),
            plane(0, 1.0),
            plane(1, -1.0),
            cylinder(0.0),
            cylinder(7.0),
        ] {
            assert!(Placement { surface, ..good }.cameras().is_err(), "{surface:?}");
        }
        for (radius_m, focal_px) in [(0.0, 1.0), (1.0, f64::INFINITY), (f64::NAN, 1.0)] {
            assert!(Placement { radius_m, focal_px, ..good }.cameras().is_err());
        }
    }
}
