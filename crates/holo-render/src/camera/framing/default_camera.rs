//! The camera for scenes without one: a three-quarter view of the whole scene, from the front right and above.

use holo_core::Projection;
use holo_scene::{Scene, Transform};

use super::{Framed, Framing};
use crate::error::Error;

/// Vertical angle of view, rad (40 degrees).
const ANGLE_RAD: f64 = 40.0 * DEGREE;
/// The direction from the scene to the camera: to the right of +Z, and above the horizon.
const AZIMUTH_RAD: f64 = 35.0 * DEGREE;
const ELEVATION_RAD: f64 = 25.0 * DEGREE;
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// The image is this factor wider than the scene.
const MARGIN: f64 = 1.05;
/// The nearest depth is at least this share of the farthest.
const NEAREST: f64 = 0.1;

/// The vertices of a scene along the axes of the camera (right, up, back), relative to a center.
struct Extent {
    low: [f64; 3],
    high: [f64; 3],
    /// For the right and the up axis: the greatest x/slope + z and the greatest -x/slope + z.
    cones: [[f64; 2]; 2],
}

/// The nearest position from which all views see all triangles, with a margin.
///
/// # Errors
/// [`Error::BadSetting`] for a scene without triangles; [`Error::Core`] for parameters that are invalid for a rig.
pub(super) fn frame(framing: &Framing, scene: &Scene) -> Result<Framed, Error> {
    let Some((low, high)) = scene.bounds() else {
        return Err(Error::BadSetting(
            "the scene has neither a camera nor a triangle: there is nothing to look at".into(),
        ));
    };
    let lenses = framing.shape.lenses();
    let size = [lenses.columns as f64, lenses.rows as f64];
    let larger = size[0].max(size[1]);
    // From the larger image side to half the sensor.
    let automatic = framing.sensor_size_m / (2.0 * (ANGLE_RAD / 2.0).tan() * larger / size[1]);
    let focal_length_m = framing.focal_length_m.unwrap_or(automatic);
    let slopes = size.map(|side| framing.sensor_size_m / (2.0 * focal_length_m) * side / larger);

    let center = std::array::from_fn(|k| f64::midpoint(low[k], high[k]));
    let (sin, cos) = ELEVATION_RAD.sin_cos();
    let toward = [cos * AZIMUTH_RAD.sin(), sin, cos * AZIMUTH_RAD.cos()];
    let axes = Transform::look_at(toward, [0.0; 3], [0.0, 1.0, 0.0]).columns;
    let extent = Extent::new(scene, center, axes, slopes.map(|slope| slope / MARGIN));
    let parallel = framing.projection == Projection::Orthographic;
    let (position, distance) = extent.position(slopes, parallel);

    let pose = |distance: f64| {
        let along = [position[0], position[1], distance];
        let offset = |k: usize| (0..3).map(|axis| axes[axis][k] * along[axis]).sum::<f64>();
        Transform { columns: axes, translation: std::array::from_fn(|k| center[k] + offset(k)) }
    };
    let camera = "no camera in the scene: a view of all of it from the front right and above";
    let framed = framing.framed(pose(distance), camera.into(), focal_length_m)?;
    let views = framing.shape.views();
    let apertures = [views.columns, views.rows].map(|count| framed.baseline_m * (count - 1) as f64);
    let distance = extent.retreat(distance, slopes, apertures, parallel);
    Ok(Framed { pose: pose(distance), ..framed })
}

impl Extent {
    fn new(scene: &Scene, center: [f64; 3], axes: [[f64; 3]; 3], slopes: [f64; 2]) -> Self {
        let none = f64::NEG_INFINITY;
        let mut extent = Self { low: [-none; 3], high: [none; 3], cones: [[none; 2]; 2] };
        for instance in &scene.instances {
            let Some(mesh) = scene.meshes.get(instance.mesh) else { continue };
            for p in mesh.triangles.iter().flatten().filter_map(|&k| mesh.positions.get(k as usize)) {
                let world = instance.transform.point(p.map(f64::from));
                let p = axes.map(|axis| (0..3).map(|k| axis[k] * (world[k] - center[k])).sum::<f64>());
                for k in 0..3 {
                    extent.low[k] = extent.low[k].min(p[k]);
                    extent.high[k] = extent.high[k].max(p[k]);
                }
                for k in 0..2 {
                    let [right, left] = &mut extent.cones[k];
                    *right = right.max(p[k] / slopes[k] + p[2]);
                    *left = left.max(-p[k] / slopes[k] + p[2]);
                }
            }
        }
        extent
    }

    /// Where the camera is along the right and the up axis, and its distance along the back axis: the smallest from
    /// which a single view sees everything.
    fn position(&self, slopes: [f64; 2], parallel: bool) -> ([f64; 2], f64) {
        let (low, high) = (self.low, self.high);
        let of_axis = |k: usize| {
            let slope = slopes[k] / MARGIN;
            if parallel {
                // As wide as at the nearest depth, wherever the focus is.
                return (f64::midpoint(low[k], high[k]), high[2] + (high[k] - low[k]) / 2.0 / slope);
            }
            // x - X <= slope (D - z) and X - x <= slope (D - z) for all vertices.
            let [right, left] = self.cones[k];
            ((right - left) / 2.0 * slope, f64::midpoint(right, left))
        };
        let [(x, distance_x), (y, distance_y)] = [of_axis(0), of_axis(1)];
        let distance = distance_x.max(distance_y).max((high[2] - NEAREST * low[2]) / (1.0 - NEAREST));
        // A scene of a single point.
        ([x, y], if distance > high[2] { distance } else { high[2] + 1.0 })
    }

    /// The distance from which the outermost views see everything too, for a focus anywhere between the nearest and
    /// the farthest depth.
    fn retreat(&self, distance: f64, slopes: [f64; 2], apertures: [f64; 2], parallel: bool) -> f64 {
        let depths = |distance: f64| (distance - self.high[2], distance - self.low[2]);
        let (near, far) = depths(distance);
        let is_seen = |moved: f64| {
            let (near_now, far_now) = (near + moved, far + moved);
            // The share of the image that the scene fills shrinks least at the farthest depth.
            let fixed = if parallel { near / near_now } else { far / far_now };
            // Half an aperture moves a point by this slope: see `Rig::ray`.
            let shift = if parallel { (far_now / near_now - 1.0) / near_now } else { 1.0 / near_now - 1.0 / far_now };
            (0..2).all(|k| slopes[k] / MARGIN * fixed + apertures[k] / 2.0 * shift <= slopes[k])
        };
        let steps = (0..200).map(|step| if step == 0 { 0.0 } else { 0.01 * far * 1.2_f64.powi(step) });
        distance + steps.into_iter().find(|&moved| is_seen(moved)).unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::framing::{Baseline, CameraChoice};
    use holo_core::{GridSize, LightFieldShape};
    use holo_scene::{Instance, Mesh};

    /// An L of two triangles of about this size, away from the origin.
    fn scene(size: f32) -> Scene {
        let positions = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0], [0.3, 0.1, 0.0_f32]];
        let positions = positions.map(|p| p.map(|x| x * size)).to_vec();
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [0, 4, 3]], ..Mesh::default() };
        let transform = Transform::from_translation([5.0, -7.0, 100.0]);
        Scene {
            meshes: vec![mesh],
            instances: vec![Instance { name: String::new(), mesh: 0, transform }],
            ..Scene::default()
        }
    }

    /// Positions of all vertices in all corner views, as shares of half the image from its center; focus on the
    /// harmonic mean of the depths.
    fn seen(framing: &Framing, scene: &Scene) -> Vec<[f64; 2]> {
        let framed = framing.frame(scene).unwrap();
        let [right, up, back] = framed.pose.columns;
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let camera = framed.pose.translation;
        let vertices: Vec<[f64; 3]> = scene.meshes[0]
            .triangles
            .iter()
            .flatten()
            .map(|&k| {
                let p = scene.instances[0].transform.point(scene.meshes[0].positions[k as usize].map(f64::from));
                let p = std::array::from_fn(|k| p[k] - camera[k]);
                [dot(p, right), dot(p, up), -dot(p, back)]
            })
            .collect();
        let (near, far) = vertices.iter().fold((f64::MAX, 0.0_f64), |(n, f), p| (n.min(p[2]), f.max(p[2])));
        assert!(near > 0.0);
        let focus = 2.0 / (1.0 / near + 1.0 / far);
        let (views, lenses) = (framing.shape.views(), framing.shape.lenses());
        let apertures = [views.columns, views.rows].map(|n| framed.baseline_m * (n - 1) as f64);
        let size = [lenses.columns as f64, lenses.rows as f64];
        let slope = framed.intrinsics.sensor_size_m / 2.0 / framed.intrinsics.focal_length_m / size[0].max(size[1]);
        let mut seen = Vec::new();
        for (side, p) in [-0.5, 0.5].into_iter().flat_map(|side| vertices.iter().map(move |p| (side, p))) {
            seen.push(std::array::from_fn(|k| {
                let view = side * apertures[k];
                let at = match framing.projection {
                    Projection::Perspective => (p[k] - view) / p[2] + view / focus,
                    // The ray from the view through P of the focus plane has the direction (-view, -focus).
                    Projection::Orthographic => (p[k] - view * (1.0 - p[2] / focus)) / focus,
                };
                at / (slope * size[k])
            }));
        }
        seen
    }

    #[test]
    fn all_views_see_the_whole_scene_with_a_margin_and_fill_the_image() {
        for (columns, rows) in [(30, 20), (20, 30), (64, 64), (200, 10)] {
            for size in [0.001, 0.1, 1.0, 1e4] {
                for projection in [Projection::Perspective, Projection::Orthographic] {
                    let shape = LightFieldShape::new(GridSize::new(9, 11), GridSize::new(rows, columns)).unwrap();
                    let framing = Framing::new(shape).projection(projection);
                    let framing = framing.baseline(Baseline::FNumber(5.0)).camera(CameraChoice::First);
                    let seen = seen(&framing, &scene(size));
                    let largest = seen.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
                    assert!(largest <= 1.0, "{columns} x {rows}, {size}: {largest}");
                    // The aperture of 10 mm is larger than the smallest scene.
                    let filled = if size > 0.05 && projection == Projection::Perspective { 0.9 } else { 0.0 };
                    assert!(largest > filled, "{columns} x {rows}, {size}: {largest}");
                }
            }
        }
    }

    #[test]
    fn a_focal_length_moves_the_camera() {
        let shape = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(20, 30)).unwrap();
        for focal_length_m in [0.012, 0.2] {
            let framing = Framing::new(shape).focal_length_m(Some(focal_length_m));
            let largest = seen(&framing, &scene(1.0)).into_iter().flatten().fold(0.0_f64, |l, x| l.max(x.abs()));
            assert!((0.95..=1.0).contains(&largest), "{focal_length_m}: {largest}");
        }
    }

    #[test]
    fn the_camera_is_in_front_to_the_right_and_above() {
        let shape = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(20, 30)).unwrap();
        let pose = Framing::new(shape).frame(&scene(1.0)).unwrap().pose;
        let [x, y, z] = pose.translation;
        assert!(x > 5.0 && y > -7.0 && z > 100.0 && pose.is_pose());
        // A single point has a distance all the same.
        let mut point = scene(1.0);
        point.meshes[0].positions = vec![[0.0; 3]; 5];
        let pose = Framing::new(shape).frame(&point).unwrap().pose;
        let distance: f64 = [5.0, -7.0, 100.0].iter().zip(pose.translation).map(|(a, b)| (a - b).powi(2)).sum();
        assert!((distance - 1.0).abs() < 1e-12);
    }
}
