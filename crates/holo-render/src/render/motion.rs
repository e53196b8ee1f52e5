//! Motion: where the points that a view sees will be in the next frame.
//!
//! A ray through the center of a pixel finds a triangle; the barycentric coordinates of the point on it, in f64, place the
//! same point on the same triangle in the next frame. Scene flow is the difference of both places, optical flow that of
//! their images. Vertices are subtracted before they are weighted, so that what rests has a flow of exactly 0.

use holo_core::{Projection, Rig, ViewIndex};
use holo_scene::{Scene, Transform};
use ndarray::Array3;
use rayon::prelude::*;

use super::Renderer;
use super::request::Request;
use crate::accel::refine;
use crate::accel::{CAMERA_RAY, Coherence, ExactRays, NO_TRIANGLE, RayHits};
use crate::error::Error;
use crate::geometry::{FLATTENED, Geometry, Hit};
use crate::integrator::progress::{Progress, Stop};
use crate::integrator::{Integrator, SceneData};
use crate::simd::{LANES, Lanes};

/// The distance, m, that stands for infinity: beside it, the distances between views vanish.
const FAR_M: f64 = 1e15;

/// A frame of an animation: the scene, the camera and its rig.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Camera to world coordinates.
    pub pose: Transform,
    /// The rig. Both frames have the same numbers of views and lenses.
    pub rig: &'a Rig,
}

/// The motion of what a view sees until the next frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Where the image of a point moves, px to the right and downward, axes (v, u, 2). NaN where the point is not in front
    /// of the next camera, and for points at infinity of orthographic views once the camera moves.
    pub optical_flow: Array3<f32>,
    /// How a point moves in the world, m along its x, y and z, axes (v, u, 3); 0 where nothing is hit.
    pub scene_flow: Array3<f32>,
}

impl Renderer {
    /// The motion of the points that each of `views` sees in the centers of its pixels from one frame to the next.
    ///
    /// `frames[0]` is the scene and the pose of this renderer. What counts as a surface is as for
    /// [layers](crate::layers). A pixel that hits nothing is a point at infinity, which moves in the image if the camera
    /// turns. A point may be hidden in the next frame, or outside of its image; depth of that frame tells.
    ///
    /// # Accuracy
    /// Both flows are computed in f64 and rounded to f32 once. What rests before a camera that rests has exactly 0.
    ///
    /// # Errors
    /// [`Error::Scene`] if the next scene is invalid; [`Error::BadSetting`] if the frames differ in more than places and
    /// shapes: in instances, numbers of triangles or the numbers of views and lenses; [`Error::Cancelled`] if `progress` cancels.
    pub fn motion(
        &self,
        frames: [&Frame; 2],
        views: &[ViewIndex],
        cull: bool,
        progress: &dyn Progress,
    ) -> Result<Vec<Motion>, Error> {
        let this = frames[0];
        check(frames, views, self.counts[0])?;
        let request = Request::new(*this.rig).integrator(Integrator::Depth).cull(cull);
        let data = self.scene_data(&request.transport, Integrator::Depth);
        let triangles = FirstTriangles::new(data.geometry);
        let stop = Stop::new(progress);
        let of_view = |&view: &ViewIndex| self.install(|| motion_of(frames, view, (&data, &triangles), &stop));
        let motion = views.iter().map(of_view).collect();
        if stop.requested() { Err(Error::Cancelled) } else { Ok(motion) }
    }
}

/// The motion of one view; unfinished if it is stopped.
fn motion_of(
    frames: [&Frame; 2],
    view: ViewIndex,
    (data, triangles): (&SceneData, &FirstTriangles),
    stop: &Stop,
) -> Motion {
    let rig = frames[0].rig;
    let lenses = rig.shape().lenses();
    let mut motion = Motion {
        optical_flow: Array3::zeros((lenses.rows, lenses.columns, 2)),
        scene_flow: Array3::zeros((lenses.rows, lenses.columns, 3)),
    };
    let Motion { optical_flow, scene_flow } = &mut motion;
    let rows = optical_flow.outer_iter_mut().into_par_iter().zip(scene_flow.outer_iter_mut()).enumerate();
    rows.for_each(|(v, (mut optical, mut scene))| {
        for first in (0..lenses.columns).step_by(LANES) {
            if stop.requested() {
                return;
            }
            let row = Row { rig, view, v, first, columns: lenses.columns };
            let mut packet = RayHits::EMPTY;
            let (rays, valid) = row.rays(&mut packet);
            data.engine.intersect(&valid, &mut packet, Coherence::Coherent);
            let refined = refine::refine(data.geometry, &packet, &rays);
            for lane in (0..LANES).filter(|&lane| valid.0[lane] != 0) {
                let (u, hit) = (first + lane, packet.hit(lane));
                let point = Seen { frames, view, pixel: [v, u], depth_m: refined.depth[lane] };
                let on = (hit.triangle != NO_TRIANGLE).then(|| triangles.of(data.geometry, hit));
                let moved = point.moved(on);
                let image = point.image_moved(moved).unwrap_or([f64::NAN; 2]);
                moved.into_iter().enumerate().for_each(|(axis, m)| scene[[u, axis]] = m as f32);
                image.into_iter().enumerate().for_each(|(axis, px)| optical[[u, axis]] = px as f32);
            }
        }
    });
    motion
}

/// Checks that both frames have the same instances of the same triangles.
fn check([this, next]: [&Frame; 2], wanted: &[ViewIndex], instances: usize) -> Result<(), Error> {
    let bad = |what: String| Err(Error::BadSetting(format!("motion: {what}")));
    next.scene.validate()?;
    let views = this.rig.shape().views();
    if let Some(view) = wanted.iter().find(|view| view.row >= views.rows || view.column >= views.columns) {
        return bad(format!("view row {}, column {} is outside the {views} views", view.row, view.column));
    }
    if this.rig.shape() != next.rig.shape() {
        return bad("the frames have different numbers of views or lenses".into());
    }
    let (before, after) = (&this.scene.instances, &next.scene.instances);
    if before.len() != instances {
        return bad(format!("the first frame has {} instances, the renderer {instances}", before.len()));
    }
    if before.len() != after.len() {
        return bad(format!("{} instances become {}: nothing may appear or vanish", before.len(), after.len()));
    }
    let [old, new] = [&this.scene.meshes, &next.scene.meshes];
    let differs = before
        .iter()
        .zip(after)
        .position(|(a, b)| old.get(a.mesh).map(|mesh| &mesh.triangles) != new.get(b.mesh).map(|mesh| &mesh.triangles));
    match differs {
        Some(k) => {
            let name = holo_core::shown(&before[k].name);
            bad(format!("instance {k}, '{name}', has another number of triangles in the next frame"))
        }
        None => Ok(()),
    }
}

/// Up to sixteen neighboring pixels of a row of a view.
struct Row<'a> {
    rig: &'a Rig,
    view: ViewIndex,
    v: usize,
    first: usize,
    columns: usize,
}

impl Row<'_> {
    /// The rays through the centers of the pixels, also in `packet`; which lanes are pixels.
    fn rays(&self, packet: &mut RayHits) -> (ExactRays, Lanes<i32>) {
        let mut valid = Lanes([0; LANES]);
        let zeros = [0.0; LANES];
        let mut rays = ExactRays { origin_x: zeros, origin_y: zeros, direction_x: zeros, direction_y: zeros };
        for lane in 0..LANES.min(self.columns - self.first) {
            let ray = self.rig.ray(self.v, self.first + lane, self.view.row, self.view.column, 0.5, 0.5);
            [rays.origin_x[lane], rays.origin_y[lane], _] = ray.origin_m;
            [rays.direction_x[lane], rays.direction_y[lane], _] = ray.direction;
            valid.0[lane] = -1;
        }
        rays.write(packet);
        // So that culling hides back faces from them.
        packet.rays.id = [CAMERA_RAY; LANES];
        (rays, valid)
    }
}

/// The first triangle of every instance in the list of the geometry.
struct FirstTriangles(Vec<u32>);

impl FirstTriangles {
    fn new(geometry: &Geometry) -> Self {
        // Flattened instances follow each other.
        let mut first = Vec::new();
        for triangle in 0..geometry.flattened_count() {
            let instance = geometry.instance_index(Hit::flattened(triangle)) as usize;
            if instance >= first.len() {
                first.resize(instance + 1, triangle as u32);
            }
        }
        Self(first)
    }

    /// The index of the instance in the scene, and that of the triangle in its mesh.
    fn of(&self, geometry: &Geometry, hit: Hit) -> (usize, usize) {
        let instance = geometry.instance_index(hit);
        let first = if hit.placement == FLATTENED {
            self.0[instance as usize] as usize
        } else {
            let placement = &geometry.placements()[hit.placement as usize];
            geometry.prototypes()[placement.prototype as usize].start
        };
        (geometry.instance(instance).object as usize, hit.triangle as usize - first)
    }
}

/// What a pixel sees.
struct Seen<'a> {
    frames: [&'a Frame<'a>; 2],
    view: ViewIndex,
    /// Row and column.
    pixel: [usize; 2],
    /// m; infinite where nothing is hit.
    depth_m: f64,
}

impl Seen<'_> {
    /// The point at a depth in the axes of the world, from the position of the camera, m.
    fn at_depth(&self, depth_m: f64) -> [f64; 3] {
        let ([v, u], rig) = (self.pixel, self.frames[0].rig);
        let ray = rig.ray(v, u, self.view.row, self.view.column, 0.5, 0.5);
        self.frames[0].pose.vector(ray.at_depth_m(depth_m))
    }

    /// How the point moves in the world, m; `on` is its instance and the triangle in its mesh.
    fn moved(&self, on: Option<(usize, usize)>) -> [f64; 3] {
        let Some((object, triangle)) = on else { return [0.0; 3] };
        let [before, after] = self.frames.map(|frame| corners(frame, object, triangle));
        let from = self.frames[0].pose.translation;
        let relative = before.map(|corner| std::array::from_fn(|k| corner[k] - from[k]));
        let weights = barycentric(relative, self.at_depth(self.depth_m));
        std::array::from_fn(|k| (0..3).map(|corner| weights[corner] * (after[corner][k] - before[corner][k])).sum())
    }

    /// How the image of the point moves to the right and downward, px; `None` if the next camera cannot see it.
    fn image_moved(&self, moved: [f64; 3]) -> Option<[f64; 2]> {
        let [this, next] = self.frames;
        if moved == [0.0; 3] && this.pose == next.pose && this.rig == next.rig {
            return Some([0.0; 2]);
        }
        let point = if self.depth_m.is_finite() {
            let seen = self.at_depth(self.depth_m);
            let travelled = |k: usize| next.pose.translation[k] - this.pose.translation[k];
            std::array::from_fn(|k| seen[k] + moved[k] - travelled(k))
        } else if this.rig.projection() == Projection::Perspective {
            self.at_depth(FAR_M)
        } else {
            // All pixels of an orthographic view look into the same direction.
            return None;
        };
        let along = |axis: [f64; 3]| (0..3).map(|k| axis[k] * point[k]).sum::<f64>();
        let (row, column) = next.rig.project(next.pose.columns.map(along), self.view.row, self.view.column)?;
        let [v, u] = self.pixel;
        Some([column - (u as f64 + 0.5), row - (v as f64 + 0.5)])
    }
}

/// The corners of a triangle in the world, m.
fn corners(frame: &Frame, object: usize, triangle: usize) -> [[f64; 3]; 3] {
    let instance = &frame.scene.instances[object];
    let mesh = &frame.scene.meshes[instance.mesh];
    mesh.triangles[triangle].map(|k| instance.transform.point(mesh.positions[k as usize].map(f64::from)))
}

/// The barycentric coordinates of a point on a triangle.
fn barycentric(corners: [[f64; 3]; 3], point: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(glam::DVec3::from);
    let (ab, ac, ap) = (b - a, c - a, glam::DVec3::from(point) - a);
    let normal = ab.cross(ac);
    let squared = normal.length_squared();
    if squared == 0.0 {
        // A triangle without area is a line or a point; any of its corners moves about as it does.
        return [1.0, 0.0, 0.0];
    }
    let (second, third) = (ap.cross(ac).dot(normal) / squared, ab.cross(ap).dot(normal) / squared);
    [1.0 - second - third, second, third]
}

#[cfg(test)]
#[path = "motion_tests.rs"]
mod tests;
