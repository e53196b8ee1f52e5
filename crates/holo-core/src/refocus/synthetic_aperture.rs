//! The image of a wide aperture from the images of cameras anywhere.

use ndarray::{Array3, ArrayView2, ArrayView3};

use super::FocalPlane;
use super::kernel::{Kernel, add_sample};
use crate::base::memory::filled;
use crate::base::parallel::*;
use crate::camera::Relative;
use crate::{Error, Pinhole, Sample};

/// The image of a wide aperture, summed up image by image from those of cameras anywhere.
///
/// Every pixel of the view looks at a point of the focal surface. Each camera is sampled where it sees that point, and the samples
/// are averaged: what lies on the surface is sharp, and what lies before it, such as leaves, spreads over the aperture. The
/// surface is a plane, or has a depth for every pixel. Occlusion is ignored.
///
/// Only one image has to be in memory at a time.
///
/// # Accuracy
///
/// Within (N + 20) 2^-23 of the sum of N images in exact arithmetic, times the largest sample. For cameras at N random positions
/// evenly over an aperture the image is that of a lens with this aperture, with noise of 1/sqrt(N) and the blur of the kernel. The
/// result does not depend on the number of threads.
///
/// # Source
///
/// Wilburn et al., *High Performance Imaging Using Large Camera Arrays*, 2005; Vaish et al., *Using Plane + Parallax for
/// Calibrating Dense Camera Arrays*, 2004; Isaksen et al., *Dynamically Reparameterized Light Fields*, 2000.
///
/// # Examples
///
/// ```
/// use holo_core::refocus::{FocalPlane, Kernel, SyntheticAperture};
/// use holo_core::{GridSize, Pinhole};
/// use ndarray::Array3;
///
/// // Two cameras 0.2 m apart see a point of light 1 m before them.
/// let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let camera = |x| Pinhole::new(axes, [x, 0.0, 0.0], 10.0, GridSize::new(1, 7));
/// let image = |at| Array3::from_shape_fn((1, 7, 1), |(_, column, _)| if column == at { 1.0f32 } else { 0.0 });
/// let mut sum = SyntheticAperture::new(camera(0.0)?, Kernel::Bilinear);
/// for (x, at) in [(-0.1, 4), (0.1, 2)] {
///     sum.add(&camera(x)?, image(at).view(), 1.0, FocalPlane::new(1.0)?)?;
/// }
/// assert_eq!(sum.image()?.into_raw_vec_and_offset().0, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SyntheticAperture {
    view: Pinhole,
    kernel: Kernel,
    channels: usize,
    /// The samples of each pixel, and last the sum of their weights.
    sums: Vec<f32>,
}

/// What a synthetic aperture is focused on.
#[derive(Debug, Clone, Copy)]
pub enum FocalSurface<'a> {
    /// A plane before the view.
    Plane(FocalPlane),
    /// The depth of every pixel of the view, (row, column), m. Pixels whose depth is not above 0 stay empty.
    Depth(ArrayView2<'a, f32>),
}

impl From<FocalPlane> for FocalSurface<'_> {
    fn from(plane: FocalPlane) -> Self {
        Self::Plane(plane)
    }
}

impl<'a> From<ArrayView2<'a, f32>> for FocalSurface<'a> {
    fn from(depth_m: ArrayView2<'a, f32>) -> Self {
        Self::Depth(depth_m)
    }
}

impl SyntheticAperture {
    /// Returns an empty image of a view.
    #[must_use]
    pub const fn new(view: Pinhole, kernel: Kernel) -> Self {
        Self { view, kernel, channels: 0, sums: Vec::new() }
    }

    /// The view.
    #[must_use]
    pub const fn view(&self) -> &Pinhole {
        &self.view
    }

    /// Adds the image of a camera, focused on a surface, with a weight. A pixel gets a sample if its point of the surface lies in
    /// front of the camera and within its image, and the interpolated sample is a number.
    ///
    /// # Shape
    ///
    /// (row, column, channel), the size of the camera.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if image or depth has not the size of its camera, or the image another number of channels than those before;
    /// [`Error::BadNumber`] if the weight is negative or not finite; [`Error::OutOfMemory`] if the image of the view does not fit
    /// into memory.
    pub fn add<'s, T: Sample>(
        &mut self,
        camera: &Pinhole,
        image: ArrayView3<'_, T>,
        weight: f32,
        surface: impl Into<FocalSurface<'s>>,
    ) -> Result<(), Error> {
        let surface = surface.into();
        self.check(camera, &image, weight, &surface)?;
        let size = self.view.size();
        let stride = self.channels + 1;
        if self.sums.is_empty() {
            self.sums = filled("a refocused image", size.count() * stride, 0.0)?;
        }
        let (view, kernel, channels) = (self.view, self.kernel, self.channels);
        let relative = Relative::new(camera, &view);
        // Where the camera sees a point; `None` behind it.
        let place = |slopes: [f64; 2], inverse_depth: f64| {
            let (origin_m, direction) = (relative.origin_m, relative.direction(slopes));
            let [x, y, depth] = std::array::from_fn(|k| direction[k] + inverse_depth * origin_m[k]);
            (depth > 0.0).then(|| camera.place([x / depth, y / depth]))
        };
        let (rows, columns) = (camera.size().rows as f64 - 0.5, camera.size().columns as f64 - 0.5);
        let lines = self.sums.par_chunks_mut(size.columns * stride).enumerate();
        lines.for_each_init(Vec::new, |sample, (row, line)| {
            for (column, sums) in line.chunks_exact_mut(stride).enumerate() {
                let slopes = view.slopes([row as f64, column as f64]);
                let inverse_depth = match surface {
                    FocalSurface::Plane(plane) => plane.inverse_depth([0.0; 2], slopes),
                    FocalSurface::Depth(map) => 1.0 / f64::from(map[[row, column]]),
                };
                let is_before = inverse_depth > 0.0 || inverse_depth == 0.0 && surface.may_be_infinite();
                let Some(place) = place(slopes, inverse_depth).filter(|_| is_before) else { continue };
                if !((-0.5..rows).contains(&place[0]) && (-0.5..columns).contains(&place[1])) {
                    continue;
                }
                sample.clear();
                sample.resize(channels, 0.0);
                add_sample(image, place, kernel, weight, sample);
                if sample.iter().all(|x| x.is_finite()) {
                    sums.iter_mut().zip(&*sample).for_each(|(sum, x)| *sum += x);
                    sums[channels] += weight;
                }
            }
        });
        Ok(())
    }

    /// Returns the mean of the samples of each pixel; NaN where there are none.
    ///
    /// # Shape
    ///
    /// (row, column, channel), the size of the view.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if no image was added; [`Error::OutOfMemory`] if the image does not fit into memory.
    pub fn image(&self) -> Result<Array3<f32>, Error> {
        if self.sums.is_empty() {
            return Err(Error::ZeroCount { what: "images of a synthetic aperture" });
        }
        let (size, channels) = (self.view.size(), self.channels);
        let mut image = filled("a refocused image", size.count() * channels, f32::NAN)?;
        for (pixel, sums) in image.chunks_exact_mut(channels).zip(self.sums.chunks_exact(channels + 1)) {
            pixel.iter_mut().zip(sums).for_each(|(value, sum)| *value = sum / sums[channels]);
        }
        Ok(Array3::from_shape_vec((size.rows, size.columns, channels), image).expect("the length is the product"))
    }

    fn check<T>(
        &mut self,
        camera: &Pinhole,
        image: &ArrayView3<'_, T>,
        weight: f32,
        surface: &FocalSurface<'_>,
    ) -> Result<(), Error> {
        let wrong = |what, expected: &[usize], found: &[usize]| {
            Err(Error::Shape { what, expected: expected.to_vec(), found: found.to_vec() })
        };
        let channels = if self.sums.is_empty() { image.dim().2 } else { self.channels };
        let (own, view) = (camera.size(), self.view.size());
        if image.dim() != (own.rows, own.columns, channels) || channels == 0 {
            return wrong("image of a camera", &[own.rows, own.columns, channels.max(1)], image.shape());
        }
        if let FocalSurface::Depth(map) = surface
            && map.dim() != (view.rows, view.columns)
        {
            return wrong("depth of a view", &[view.rows, view.columns], map.shape());
        }
        if !(weight >= 0.0 && weight.is_finite()) {
            let value = f64::from(weight);
            return Err(Error::BadNumber { what: "weight of an image", value, need: "finite and not negative" });
        }
        self.channels = channels;
        Ok(())
    }
}

impl FocalSurface<'_> {
    /// Whether points at infinity belong to it: those of a map that says so, and a plane that is there as a whole.
    fn may_be_infinite(&self) -> bool {
        match self {
            Self::Plane(plane) => plane.distance_m().is_infinite(),
            Self::Depth(_) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridSize;

    const SIZE: GridSize = GridSize::new(80, 120);
    const FOCAL_PX: f64 = 160.0;

    fn camera(position_m: [f64; 3]) -> Pinhole {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Pinhole::new(axes, position_m, FOCAL_PX, SIZE).expect("a camera")
    }

    /// A camera turned by some degrees about all axes.
    fn turned(position_m: [f64; 3], [a, b, c]: [f64; 3]) -> Pinhole {
        let turn = |axes: [[f64; 3]; 3], i: usize, j: usize, angle: f64| {
            axes.map(|mut axis| {
                let (x, y) = (axis[i], axis[j]);
                (axis[i], axis[j]) = (x * angle.cos() - y * angle.sin(), x * angle.sin() + y * angle.cos());
                axis
            })
        };
        let axes = camera([0.0; 3]).axes();
        let axes = turn(turn(turn(axes, 0, 1, a), 1, 2, b), 0, 2, c);
        Pinhole::new(axes, position_m, 140.0, GridSize::new(128, 160)).expect("a camera")
    }

    /// The waves of a wall, per m.
    const WAVE: f64 = 40.0;

    fn wall([x, y]: [f64; 2]) -> f64 {
        0.5 + 0.2 * (WAVE * x).cos() + 0.2 * (WAVE * y).cos()
    }

    /// The image of a wall at z = -`distance_m`.
    fn image(camera: &Pinhole, distance_m: f64) -> Array3<f32> {
        let size = camera.size();
        Array3::from_shape_fn((size.rows, size.columns, 1), |(row, column, _)| {
            let (eye, direction) = (camera.position_m(), camera.direction([row as f64, column as f64]));
            let depth_m = -(eye[2] + distance_m) / direction[2];
            wall([eye[0] + depth_m * direction[0], eye[1] + depth_m * direction[1]]) as f32
        })
    }

    /// Evenly distributed over the unit disc.
    fn random_place(state: &mut u32) -> [f64; 2] {
        let mut next = || {
            *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(*state >> 8) / f64::from(1 << 24) * 2.0 - 1.0
        };
        loop {
            let [x, y] = [next(), next()];
            if x * x + y * y <= 1.0 {
                return [x, y];
            }
        }
    }

    /// 2 J1(x) / x by its series.
    fn disc_spectrum(x: f64) -> f64 {
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..40 {
            term *= -(x / 2.0).powi(2) / f64::from(k * (k + 1));
            sum += term;
        }
        sum
    }

    /// The mean over random cameras tends to the image of a lens: a wall out of focus is blurred by a disc, which has a closed form.
    /// The error falls as 1/sqrt(N), to a floor below 1e-3, which is the kernel: half of a percent of waves of 12.6 px.
    #[test]
    fn random_cameras_are_a_lens() {
        let (wall_m, focus_m, radius_m) = (2.0, 1.5, 0.2);
        // The disc of confusion, on the wall.
        let spread_m = radius_m * (wall_m - focus_m) / focus_m;
        let contrast = disc_spectrum(WAVE * spread_m);
        let view = camera([0.0; 3]);
        let lens = |row: f64, column: f64| {
            let [x, y] = view.slopes([row, column]).map(|slope| slope * wall_m);
            0.5 + 0.2 * contrast * ((WAVE * x).cos() + (WAVE * y).cos())
        };
        let (mut state, mut errors) = (3, Vec::new());
        for count in [16, 64, 256, 1024] {
            let mut squares = 0.0;
            let turns = 2048 / count;
            for _ in 0..turns {
                let mut sum = SyntheticAperture::new(view, Kernel::CatmullRom);
                for _ in 0..count {
                    let [x, y] = random_place(&mut state);
                    let eye = camera([radius_m * x, radius_m * y, 0.0]);
                    let plane = FocalPlane::new(focus_m).expect("a plane");
                    sum.add(&eye, image(&eye, wall_m).view(), 1.0, plane).expect("added");
                }
                let image = sum.image().expect("an image");
                let inside = || (24..56).flat_map(|row| (24..96).map(move |column| (row, column)));
                let error = |(row, column)| f64::from(image[[row, column, 0]]) - lens(row as f64, column as f64);
                squares += inside().map(|at| error(at).powi(2)).sum::<f64>() / inside().count() as f64;
            }
            errors.push((squares / f64::from(turns)).sqrt());
        }
        println!("{errors:?}");
        assert!(errors[0] > 0.02 && contrast.abs() < 0.5, "the wall is blurred");
        for pair in errors.windows(2) {
            assert!((0.35..0.65).contains(&(pair[1] / pair[0])), "{errors:?}");
        }
        let far = 1.0 / 1024_f64.sqrt() * 0.2;
        assert!(errors[3] < far, "{errors:?}");
    }

    /// A wall that is not perpendicular to any camera is sharp on a tilted plane, and on its depth: what is left is the kernel.
    #[test]
    fn cameras_anywhere_agree_on_the_surface() {
        let view = turned([0.1, 0.05, 0.0], [0.1, 0.2, -0.15]);
        // The depth of the wall, which is that of a tilted plane in the frame of the view.
        let depth = |place: [f64; 2]| -2.0 / view.direction(place)[2];
        let middle = [63.5, 79.5];
        let slopes = {
            // 1 / depth = (1 - x right - y up) / distance.
            let [x, y] =
                [[63.5, 80.5], [62.5, 79.5]].map(|place| (1.0 - depth(middle) / depth(place)) * view.focal_px());
            [x.atan(), y.atan()]
        };
        let plane =
            FocalPlane::new(depth(middle)).and_then(|plane| plane.tilted(slopes[0], slopes[1])).expect("a plane");
        let map = ndarray::Array2::from_shape_fn((128, 160), |(row, column)| depth([row as f64, column as f64]) as f32);
        let mut sums = [0, 1].map(|_| SyntheticAperture::new(view, Kernel::CatmullRom));
        for k in 0..6 {
            let a = f64::from(k) - 2.5;
            let eye = turned([0.06 * a, -0.02 * a * a, 0.05 * a], [0.1 - 0.03 * a, 0.2 + 0.02 * a, -0.1]);
            let image = image(&eye, 2.0);
            sums[0].add(&eye, image.view(), 1.0, plane).expect("added");
            sums[1].add(&eye, image.view(), 1.0, map.view()).expect("added");
        }
        let expected = image(&view, 2.0);
        for sum in sums {
            let image = sum.image().expect("an image");
            for row in 32..96 {
                for column in 32..128 {
                    let error = (image[[row, column, 0]] - expected[[row, column, 0]]).abs();
                    assert!(error < 5e-3, "{row} {column}: {error}");
                }
            }
        }
    }

    #[test]
    fn points_that_no_camera_sees_are_empty() {
        let view = camera([0.0; 3]);
        let mut sum = SyntheticAperture::new(view, Kernel::Bilinear);
        assert!(matches!(sum.image(), Err(Error::ZeroCount { .. })));
        let plane = FocalPlane::new(1.0).expect("a plane");
        // A camera beyond the plane, and one beside the view.
        for eye in [camera([0.0, 0.0, -2.0]), camera([9.0, 0.0, 0.0])] {
            sum.add(&eye, image(&eye, 5.0).view(), 1.0, plane).expect("added");
        }
        assert!(sum.image().expect("an image").iter().all(|x| x.is_nan()));
        sum.add(&view, image(&view, 5.0).view(), 0.5, plane).expect("added");
        assert_eq!(sum.image().expect("an image"), image(&view, 5.0));
        let infinite = FocalPlane::new(f64::INFINITY).expect("a plane");
        let mut far = SyntheticAperture::new(view, Kernel::Bilinear);
        far.add(&camera([9.0, 0.0, 0.0]), image(&view, 5.0).view(), 1.0, infinite).expect("added");
        assert_eq!(far.image().expect("an image"), image(&view, 5.0));
    }

    #[test]
    fn wrong_images_are_refused() {
        let view = camera([0.0; 3]);
        let mut sum = SyntheticAperture::new(view, Kernel::Bilinear);
        let plane = FocalPlane::new(1.0).expect("a plane");
        let image = |rows, channels| Array3::<f32>::zeros((rows, 120, channels));
        assert!(matches!(sum.add(&view, image(79, 3).view(), 1.0, plane), Err(Error::Shape { .. })));
        assert!(matches!(sum.add(&view, image(80, 0).view(), 1.0, plane), Err(Error::Shape { .. })));
        assert!(matches!(sum.add(&view, image(80, 3).view(), -1.0, plane), Err(Error::BadNumber { .. })));
        let map = ndarray::Array2::<f32>::zeros((80, 119));
        assert!(matches!(sum.add(&view, image(80, 3).view(), 1.0, map.view()), Err(Error::Shape { .. })));
        sum.add(&view, image(80, 3).view(), 1.0, plane).expect("added");
        assert!(matches!(sum.add(&view, image(80, 1).view(), 1.0, plane), Err(Error::Shape { .. })));
    }
}
