//! The image of a camera between those of an array, which may stand anywhere.

use std::cmp::Ordering;

use ndarray::{Array2, ArrayView2, ArrayView3};

use super::new_view::{Motion, NewView, Source};
use super::surface::{Line, Surface, span};
use super::{SynthesizedImage, ViewSynthesis};
use crate::base::memory::collected;
use crate::camera::Relative;
use crate::{Error, Pinhole, Sample};

/// Cameras take part in groups of this many, the nearest ones first: what a group does not show, the next may.
const GROUP: usize = 4;

/// The groups that take part.
const GROUPS: usize = 4;

/// A camera nearer than this, of the distance of the fourth, counts as if it were there: the view is its image within 1e-6.
const LEAST_DISTANCE: f64 = 1e-4;

/// The least cosine of the angle between a pixel's ray and the optical axis of a camera that may show its point.
const LEAST_FACING: f64 = 0.1;

/// The image of a camera, and the depth of what it shows.
#[derive(Debug, Clone, Copy)]
pub struct PosedView<'a, T> {
    /// The camera.
    pub camera: Pinhole,
    /// Its image, (row, column, channel).
    pub image: ArrayView3<'a, T>,
    /// The planar depth of its pixels, (row, column), m; +infinity where nothing is hit.
    pub depth_m: ArrayView2<'a, f32>,
}

impl ViewSynthesis {
    /// Returns the numbers of the cameras that take part in the image of a view, the nearest ones first: others need not be read.
    #[must_use]
    pub fn cameras_near(cameras: &[Pinhole], view: &Pinhole) -> Vec<usize> {
        let mut ranked: Vec<usize> = (0..cameras.len()).collect();
        let key = |k: usize| (distance_m(&cameras[k], view), cameras[k].position_m());
        // Equally near ones in the order of their places, not of the list.
        ranked.sort_by(|&a, &b| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal));
        ranked.truncate(GROUP * GROUPS);
        ranked
    }

    /// Returns the image of a camera anywhere, from those of others, such as the cameras of an array.
    ///
    /// As between the views of a grid, a pixel is the mean color of the cameras that agree on a point; the four nearest cameras
    /// first, weighted by 1 / distance^2. What they do not show, the next ones may. The ratio of baselines has no meaning here.
    ///
    /// # Accuracy
    ///
    /// At a camera it is its image. The result does not depend on the number of threads, nor on the order of the cameras.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] without cameras; [`Error::Shape`] if an image or a depth has not the size of its camera, or the channels
    /// differ; [`Error::BadNumber`] if no depth is a number above 0; [`Error::OutOfMemory`] if the result does not fit into memory.
    ///
    /// # Source
    ///
    /// Buehler et al., *Unstructured Lumigraph Rendering*, 2001: the nearest cameras, of any pose, on a surface.
    pub fn at_camera<T: Sample>(
        &self,
        cameras: &[PosedView<'_, T>],
        view: &Pinhole,
    ) -> Result<SynthesizedImage, Error> {
        let channels = checked(cameras)?;
        let all: Vec<Pinhole> = cameras.iter().map(|posed| posed.camera).collect();
        let near = Self::cameras_near(&all, view);
        // Disparities are those of cameras this far apart.
        let base_m = distance_m(&all[near[near.len().min(GROUP) - 1]], view);
        let base_m = if base_m > 0.0 { base_m } else { 1.0 };
        let mut result = NewView::new(view.size(), channels)?;
        for group in near.chunks(GROUP) {
            if !result.has_holes() {
                break;
            }
            let mut sources = Vec::new();
            for &k in group {
                let nearness = base_m / distance_m(&all[k], view).max(LEAST_DISTANCE * base_m);
                sources.extend(source(&cameras[k], view, base_m, (nearness * nearness) as f32)?);
            }
            result.add(&sources, self.kernel, None);
        }
        let made = result.finished();
        let depth_m = made.disparity_px.mapv(|x| (view.focal_px() * base_m / f64::from(x)) as f32);
        Ok(SynthesizedImage { image: made.image, depth_m, holes: made.holes })
    }
}

fn distance_m(camera: &Pinhole, view: &Pinhole) -> f64 {
    let (a, b) = (camera.position_m(), view.position_m());
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The number of channels of all images.
fn checked<T>(cameras: &[PosedView<'_, T>]) -> Result<usize, Error> {
    let Some(first) = cameras.first() else { return Err(Error::ZeroCount { what: "cameras" }) };
    let channels = first.image.dim().2;
    let mut nearest_m = f32::INFINITY;
    for PosedView { camera, image, depth_m } in cameras {
        let size = camera.size();
        if image.dim() != (size.rows, size.columns, channels) {
            let (expected, found) = (vec![size.rows, size.columns, channels], image.shape().to_vec());
            return Err(Error::Shape { what: "image of a camera", expected, found });
        }
        if depth_m.dim() != (size.rows, size.columns) {
            let (expected, found) = (vec![size.rows, size.columns], depth_m.shape().to_vec());
            return Err(Error::Shape { what: "depth of a camera", expected, found });
        }
        nearest_m = depth_m.iter().copied().filter(|x| *x > 0.0).fold(nearest_m, f32::min);
    }
    if nearest_m.is_finite() {
        return Ok(channels);
    }
    Err(Error::BadNumber { what: "depth in meters", value: f64::from(nearest_m), need: "a number above 0 somewhere" })
}

/// A camera as a source of the view; `None` if it shows nothing, or looks the other way.
fn source<'a, T>(
    posed: &PosedView<'a, T>,
    view: &Pinhole,
    base_m: f64,
    weight: f32,
) -> Result<Option<Source<'a, T, Projection>>, Error> {
    let motion = Projection::new(view, &posed.camera, base_m);
    let size = posed.camera.size();
    let disparities = collected(
        "a disparity map",
        posed.depth_m.iter().map(
            |&depth_m| {
                if depth_m > 0.0 { (motion.own_px / f64::from(depth_m)) as f32 } else { f32::NAN }
            },
        ),
    )?;
    let map = Array2::from_shape_vec((size.rows, size.columns), disparities).expect("the length is the product");
    let [far_px, near_px] = span(&mut map.iter().copied());
    // Behind the view nothing is looked for.
    let ahead_m = motion.relative.origin_m[2];
    let near_px = if ahead_m > 0.0 { near_px.min(motion.own_px / ahead_m) } else { near_px };
    let is_seen = far_px <= near_px;
    if !is_seen {
        return Ok(None);
    }
    let surface = Surface::widened(map.view())?;
    Ok(Some(Source { image: posed.image, surface, range_px: [far_px, near_px], motion, weight }))
}

/// The motion between two cameras anywhere: a ray of one is a straight line in the other, also in (column, row, 1 / depth).
struct Projection {
    view: Pinhole,
    camera: Pinhole,
    relative: Relative,
    /// Disparity times depth, in the camera and in the view, px m.
    own_px: f64,
    view_px: f64,
}

impl Projection {
    fn new(view: &Pinhole, camera: &Pinhole, base_m: f64) -> Self {
        Self {
            view: *view,
            camera: *camera,
            relative: Relative::new(camera, view),
            own_px: camera.focal_px() * base_m,
            view_px: view.focal_px() * base_m,
        }
    }
}

impl Motion for Projection {
    fn line(&self, pixel: [f64; 2]) -> Option<Line> {
        let [x, y, z] = self.relative.direction(self.view.slopes(pixel));
        if z < LEAST_FACING * (x * x + y * y + z * z).sqrt() {
            return None;
        }
        let from = self.camera.place([x / z, y / z]);
        let [across, above, ahead] = self.relative.origin_m;
        let focal = self.camera.focal_px() / self.own_px;
        Some(Line { from, step: [-(above - ahead * y / z) * focal, (across - ahead * x / z) * focal] })
    }

    fn disparity_px(&self, pixel: [f64; 2], other_px: f64) -> Option<f64> {
        let inverse_depth = other_px / self.own_px;
        let [_, _, z] = self.relative.direction(self.view.slopes(pixel));
        // What lies behind the view is not in it.
        let left = 1.0 - self.relative.origin_m[2] * inverse_depth;
        (left > 0.0 && inverse_depth >= 0.0).then(|| self.view_px * z * inverse_depth / left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridSize;
    use ndarray::Array3;

    const SIZE: GridSize = GridSize::new(48, 64);

    /// Where the square begins and ends along x and y, and how far wall and square are along -z, m.
    const SQUARE: [f64; 2] = [-0.18, 0.17];
    const WALL_M: f64 = 2.0;
    const SQUARE_M: f64 = 1.4;

    /// A camera turned by angles about the vertical and the horizontal axis.
    fn camera(position_m: [f64; 3], [a, b]: [f64; 2], focal_px: f64) -> Pinhole {
        let right = [a.cos(), 0.0, -a.sin()];
        let back = [a.sin() * b.cos(), b.sin(), a.cos() * b.cos()];
        let up = [
            back[1] * right[2] - back[2] * right[1],
            back[2] * right[0] - back[0] * right[2],
            back[0] * right[1] - back[1] * right[0],
        ];
        Pinhole::new([right, up, back], position_m, focal_px, SIZE).expect("a camera")
    }

    fn texture([x, y]: [f64; 2], phase: f64) -> f64 {
        0.5 + 0.2 * (12.0 * x + phase).sin() + 0.25 * (10.0 * y + 7.0 * x + 2.0 * phase).cos()
    }

    /// Color and depth of a place of an image.
    fn seen(camera: &Pinhole, place: [f64; 2]) -> (f64, f64) {
        let (eye, direction) = (camera.position_m(), camera.direction(place));
        let at = |distance_m: f64| {
            let depth = -(eye[2] + distance_m) / direction[2];
            ([eye[0] + depth * direction[0], eye[1] + depth * direction[1]], depth)
        };
        let (near, depth) = at(SQUARE_M);
        if near.iter().all(|x| (SQUARE[0]..SQUARE[1]).contains(x)) && depth > 0.0 {
            return (texture(near, 1.0), depth);
        }
        let (far, depth) = at(WALL_M);
        (texture(far, 0.0), depth)
    }

    fn image(camera: &Pinhole) -> (Array3<f32>, Array2<f32>) {
        let mean = |row: usize, column: usize| {
            let part = |k: usize| (k as f64 + 0.5) / 8.0 - 0.5;
            let color = |k: usize| seen(camera, [row as f64 + part(k / 8), column as f64 + part(k % 8)]).0;
            (0..64).map(color).sum::<f64>() / 64.0
        };
        let depth = |row: usize, column: usize| seen(camera, [row as f64, column as f64]).1 as f32;
        (
            Array3::from_shape_fn((SIZE.rows, SIZE.columns, 1), |(row, column, _)| mean(row, column) as f32),
            Array2::from_shape_fn((SIZE.rows, SIZE.columns), |(row, column)| depth(row, column)),
        )
    }

    /// Cameras at several distances and angles around the view.
    fn cameras() -> Vec<Pinhole> {
        [
            ([-0.05, 0.04, 0.03], [0.05, -0.03], 80.0),
            ([0.06, 0.05, -0.04], [-0.04, 0.02], 84.0),
            ([-0.04, -0.06, 0.0], [0.0, 0.06], 78.0),
            ([0.05, -0.05, 0.02], [-0.06, 0.01], 80.0),
            ([-0.15, 0.1, 0.0], [0.08, 0.0], 80.0),
            ([0.2, 0.0, 0.1], [-0.1, 0.0], 80.0),
        ]
        .map(|(position, turn, focal)| camera(position, turn, focal))
        .to_vec()
    }

    fn synthesized(cameras: &[Pinhole], view: &Pinhole) -> SynthesizedImage {
        let images: Vec<_> = cameras.iter().map(image).collect();
        let posed: Vec<_> = cameras
            .iter()
            .zip(&images)
            .map(|(camera, (image, depth_m))| PosedView {
                camera: *camera,
                image: image.view(),
                depth_m: depth_m.view(),
            })
            .collect();
        ViewSynthesis::default().at_camera(&posed, view).expect("a view")
    }

    /// More than 4 pixels from edges only the kernel errs, by 2e-3 for waves of 20 px. With edges the image is four times nearer to the truth than that of the nearest camera.
    #[test]
    fn a_camera_between_others_sees_what_they_see() {
        let view = camera([0.01, 0.0, 0.01], [0.02, -0.01], 82.0);
        let made = synthesized(&cameras(), &view);
        let (expected, depth_m) = image(&view);
        let (mut squares, mut nearest) = (0.0, 0.0);
        let (other, _) = image(&cameras()[2]);
        for row in 10..SIZE.rows - 10 {
            for column in 10..SIZE.columns - 10 {
                let around =
                    || (row - 4..=row + 4).flat_map(|row| (column - 4..=column + 4).map(move |column| [row, column]));
                let is_edge = around().any(|at| (depth_m[at] - depth_m[[row, column]]).abs() > 0.1);
                let error = f64::from(made.image[[row, column, 0]] - expected[[row, column, 0]]);
                if !is_edge {
                    assert!(error.abs() < 2e-3, "{row} {column}: {error}");
                    assert!(
                        (made.depth_m[[row, column]] / depth_m[[row, column]] - 1.0).abs() < 2e-4,
                        "{row} {column}"
                    );
                    assert!(!made.holes[[row, column]]);
                }
                squares += error * error;
                nearest += f64::from(other[[row, column, 0]] - expected[[row, column, 0]]).powi(2);
            }
        }
        println!("{} of {}", squares.sqrt(), nearest.sqrt());
        assert!(squares * 16.0 < nearest, "{squares} {nearest}");
    }

    #[test]
    fn a_camera_of_the_array_is_itself() {
        let cameras = cameras();
        let made = synthesized(&cameras, &cameras[1]);
        let (expected, depth_m) = image(&cameras[1]);
        for (at, value) in made.image.indexed_iter() {
            assert!((value - expected[at]).abs() < 1e-6, "{at:?}");
        }
        // Pixels beside an edge have the depth of the nearer surface.
        let equal = made.depth_m.iter().zip(&depth_m).filter(|(a, b)| (*a / *b - 1.0).abs() < 1e-5).count();
        assert!(equal * 10 > SIZE.count() * 9, "{equal}");
    }

    #[test]
    fn the_order_of_the_cameras_does_not_matter() {
        let view = camera([0.01, 0.0, 0.01], [0.02, -0.01], 82.0);
        let mut cameras = cameras();
        let made = synthesized(&cameras, &view);
        cameras.reverse();
        let other = synthesized(&cameras, &view);
        assert_eq!((made.image, made.holes), (other.image, other.holes));
    }

    /// Cameras that look away, or see another part only, show nothing; a view ahead of the cameras does not see what is behind it.
    #[test]
    fn what_no_camera_sees_is_a_hole() {
        let view = camera([0.0; 3], [0.0; 2], 80.0);
        let away = camera([0.0, 0.0, 0.1], [3.0, 0.0], 80.0);
        let beside = camera([3.0, 0.0, 0.0], [0.0; 2], 80.0);
        let made = synthesized(&[away, beside], &view);
        assert!(made.holes.iter().all(|&hole| hole) && made.image.iter().all(|&x| x == 0.0));
        // Between square and wall: the square is behind.
        let ahead = camera([0.0, 0.0, -1.6], [0.0; 2], 80.0);
        let made = synthesized(&[view], &ahead);
        let (_, expected) = image(&ahead);
        for (at, &hole) in made.holes.indexed_iter() {
            assert!(hole || (made.depth_m[at] / expected[at] - 1.0).abs() < 1e-3, "{at:?}");
        }
        assert!(made.holes.iter().any(|&hole| hole) && made.image.iter().all(|x| x.is_finite()));
    }

    #[test]
    fn wrong_cameras_are_refused() {
        let synthesis = ViewSynthesis::default();
        let view = camera([0.0; 3], [0.0; 2], 80.0);
        assert!(matches!(synthesis.at_camera::<f32>(&[], &view), Err(Error::ZeroCount { .. })));
        let image = Array3::<f32>::zeros((SIZE.rows, SIZE.columns, 3));
        let depth = Array2::<f32>::ones((SIZE.rows, SIZE.columns));
        let good = PosedView { camera: view, image: image.view(), depth_m: depth.view() };
        assert!(synthesis.at_camera(&[good], &view).is_ok());
        let flat = Array2::<f32>::zeros((SIZE.rows, SIZE.columns));
        let none = PosedView { depth_m: flat.view(), ..good };
        assert!(matches!(synthesis.at_camera(&[none], &view), Err(Error::BadNumber { .. })));
        let small = Array3::<f32>::zeros((SIZE.rows, 3, 3));
        assert!(matches!(
            synthesis.at_camera(&[PosedView { image: small.view(), ..good }], &view),
            Err(Error::Shape { .. })
        ));
        let gray = Array3::<f32>::zeros((SIZE.rows, SIZE.columns, 1));
        let mixed = [good, PosedView { image: gray.view(), ..good }];
        assert!(matches!(synthesis.at_camera(&mixed, &view), Err(Error::Shape { .. })));
    }
}
