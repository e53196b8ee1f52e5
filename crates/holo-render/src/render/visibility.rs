//! Visibility: which part of all views sees the points that the central view sees.
//!
//! From every view a ray goes to the point at the center of a pixel of the central view. The point is seen where the ray
//! lies within the image of that view and hits nothing before it.

use holo_core::Rig;
use ndarray::{Array2, Axis};
use rayon::prelude::*;

use super::Renderer;
use super::request::Request;
use crate::accel::{Coherence, Engine, RayHits};
use crate::error::Error;
use crate::integrator::Integrator;
use crate::integrator::progress::{Progress, Stop};
use crate::simd::{self, Kernel, LANES, Lanes};

/// The side of the block of views whose rays to a point are traced together.
const BLOCK: usize = 4;

/// The part of the way to a point at its end where surfaces do not count: the surface of the point itself may be hit
/// there, because rays are traced in f32.
const TOLERANCE: f64 = 1e-4;

impl Renderer {
    /// For every pixel of the central view, the part of all views of the rig that see the point at its center: 1
    /// where every view does, less at occlusions and where the point leaves the image of a view. Axes (v, u), of
    /// [`Request::rows`].
    ///
    /// What counts as a surface is as for [layers](crate::layers); a pixel that hits nothing is a point at infinity.
    ///
    /// # Accuracy
    /// Surfaces less than 1e-4 of the way in front of a point do not hide it.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn visibility(&self, request: &Request, progress: &dyn Progress) -> Result<Array2<f32>, Error> {
        let request = request.of_rig()?;
        let rig = request.rig;
        let mut ground_truth = Request::new(*rig).integrator(Integrator::Depth).cull(request.transport.cull);
        ground_truth.rows.clone_from(&request.rows);
        let depth_m = self.render(&ground_truth, progress)?.central;
        let Some(depth_m) = depth_m.depth_m() else {
            return Err(Error::BadSetting(
                "visibility: the central view has no depth; report this, with the request".into(),
            ));
        };
        let depth_m = depth_m.index_axis(Axis(2), 0);
        let stop = Stop::new(progress);
        let engine = self.scene_data(&request.transport, Integrator::Depth).engine;
        let first_row = request.row_range().start;
        let mut out = Array2::zeros(depth_m.dim());
        self.install(|| {
            out.outer_iter_mut().into_par_iter().zip(depth_m.outer_iter()).enumerate().for_each(
                |(v, (mut out, row))| {
                    for (u, (out, depth_m)) in out.iter_mut().zip(row).enumerate() {
                        if stop.requested() {
                            return;
                        }
                        let point = Point { pixel: [first_row + v, u], depth_m: f64::from(*depth_m) };
                        *out = simd::run(Seen { rig, engine, point });
                    }
                },
            );
        });
        if stop.requested() { Err(Error::Cancelled) } else { Ok(out) }
    }
}

/// A point that the central view sees.
#[derive(Clone, Copy)]
struct Point {
    /// Lens row and column.
    pixel: [usize; 2],
    depth_m: f64,
}

impl Point {
    /// The position of the point in a view, px along rows and columns of lenses, and whether it is within the image.
    fn position_in(&self, rig: &Rig, [t, s]: [usize; 2]) -> ([f64; 2], bool) {
        let (central, lenses) = (rig.shape().central_view(), rig.shape().lenses());
        let moved = |pixel: usize, disparity: holo_core::Disparity, view: usize, central: usize| {
            let views = view as f64 - central as f64;
            // An infinite disparity moves nothing where there is no distance.
            let shift = if view == central { 0.0 } else { disparity.from_depth_m(self.depth_m) * views };
            pixel as f64 + 0.5 - shift
        };
        let row = moved(self.pixel[0], rig.disparity_y(), t, central.0);
        let column = moved(self.pixel[1], rig.disparity_x(), s, central.1);
        let is_within = (0.0..=lenses.rows as f64).contains(&row) && (0.0..=lenses.columns as f64).contains(&column);
        ([row, column], is_within)
    }
}

/// The part of all views that see a point.
struct Seen<'a> {
    rig: &'a Rig,
    engine: &'a dyn Engine,
    point: Point,
}

impl Kernel for Seen<'_> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let (views, central) = (self.rig.shape().views(), self.rig.shape().central_view());
        let far = if self.point.depth_m.is_finite() { self.point.depth_m * (1.0 - TOLERANCE) } else { f64::INFINITY };
        let mut seen = 0;
        let mut packet = RayHits::EMPTY;
        for top in (0..views.rows).step_by(BLOCK) {
            for left in (0..views.columns).step_by(BLOCK) {
                let mut valid = Lanes([0; LANES]);
                packet.rays.far = [far as f32; LANES];
                for lane in 0..LANES {
                    let (t, s) = (top + lane / BLOCK, left + lane % BLOCK);
                    if t >= views.rows || s >= views.columns {
                        continue;
                    }
                    if (t, s) == central {
                        seen += 1;
                        continue;
                    }
                    let ([row, column], is_within) = self.point.position_in(self.rig, [t, s]);
                    if !is_within {
                        continue;
                    }
                    let ray = self.rig.ray(0, 0, t, s, column, row);
                    for axis in 0..3 {
                        packet.rays.origin[axis][lane] = ray.origin_m[axis] as f32;
                        packet.rays.direction[axis][lane] = ray.direction[axis] as f32;
                    }
                    valid.0[lane] = -1;
                }
                let count = simd::count(&valid);
                if count == 0 {
                    continue;
                }
                self.engine.occluded(&valid, &mut packet.rays, Coherence::Coherent);
                for lane in 0..LANES {
                    seen += u64::from(valid.0[lane] != 0 && packet.rays.far[lane] != f32::NEG_INFINITY);
                }
            }
        }
        (seen as f64 / views.count() as f64) as f32
    }
}
