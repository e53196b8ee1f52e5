use holo_core::GridSize;
use holo_core::plenoptic::{ImageSensor, MainLens, MicrolensArray};

use super::gather::{Neighborhood, Sampled, WINDOW_COUNT};
use super::*;
use crate::film::guides::luminance;
use crate::sampling::hash;

/// A camera with micro-images of about this many pixels.
fn camera(grid: MicrolensGrid, pixels: f64, size: GridSize) -> PlenopticCamera {
    let pitch_m = pixels * 5e-6;
    let mut array = MicrolensArray::new(grid, pitch_m, 5.6 * pitch_m);
    array.rotation_rad = 2e-3;
    PlenopticCamera::new(ImageSensor::new(size, 5e-6), array, MainLens::new(0.05, 5.6, 3.0)).expect("a camera")
}

/// The border whose micro-images may be cut off.
const BORDER: usize = 15;

/// A synthetic raw image of a part of a camera, all of it at one disparity.
struct Synthetic {
    lattice: Lattice,
    sources: Vec<Source>,
}

/// A number between 0 and 1 of a pixel of the sensor.
fn uniform(seed: u32, row: usize, column: usize) -> f32 {
    (hash(hash(hash(seed).wrapping_add(row as u32)).wrapping_add(column as u32)) >> 8) as f32 / (1 << 24) as f32
}

impl Synthetic {
    /// `value` gives the radiance at a place of the scene in the plane of the microlenses, in pitches; `noise` is the
    /// standard deviation of the mean of the samples, relative to it.
    fn new(
        camera: &PlenopticCamera,
        rows: Range<usize>,
        disparity: f32,
        noise: f32,
        value: impl Fn([f32; 2]) -> f32,
    ) -> Self {
        let lattice = Lattice::new(camera, rows.clone());
        let mut sources = Vec::new();
        for (row, column) in rows.flat_map(|row| (0..lattice.columns).map(move |column| (row, column))) {
            let expected = value(place(&lattice, [row, column], disparity));
            // Uniform numbers of this width have variance 1; mean and half difference of two halves.
            let half =
                |seed: u32| (uniform(seed, row, column) - 0.5) * 12.0f32.sqrt() * noise * 2.0f32.sqrt() * expected;
            let (a, b) = (half(1), half(2));
            let radiance = expected + (a + b) / 2.0;
            let weight = 0.2 + 0.8 * uniform(3, row, column);
            sources.push(Source {
                color: [radiance, 0.5 * radiance, 2.0 * radiance],
                variance: (luminance([1.0, 0.5, 2.0]) * (a - b) / 2.0).powi(2),
                disparity,
                weight,
                share: weight,
                samples: 4.0,
            });
        }
        Self { lattice, sources }
    }

    /// The first channel and the error of every pixel of some rows.
    fn reconstructed(&self, rows: Range<usize>) -> (Vec<f32>, Vec<f32>) {
        let mut color = vec![0.0; 3 * self.sources.len()];
        let mut error = vec![0.0; self.sources.len()];
        LatticeReconstruction {
            lattice: &self.lattice,
            sources: &self.sources,
            filters: true,
            rows: rows.clone(),
            color: Some(&mut color),
            error: Some(&mut error),
        }
        .run(|| true);
        let first = self.lattice.place(rows.start, 0);
        let wanted = first..first + rows.len() * self.lattice.columns;
        (color.into_iter().step_by(3).collect::<Vec<_>>()[wanted.clone()].to_vec(), error[wanted].to_vec())
    }

    /// The mean relative squared error before and after the reconstruction, and the median of the squares of the estimate.
    /// Not of the pixels at the border, whose micro-images are cut off and have few pixels to average.
    fn errors(&self, value: impl Fn([f32; 2]) -> f32) -> [f64; 3] {
        let rows = self.lattice.rows.clone();
        let (color, all_errors) = self.reconstructed(rows.clone());
        let (mut before, mut after, mut error) = (0.0, 0.0, Vec::new());
        for (k, source) in self.sources.iter().enumerate() {
            let pixel = [rows.start + k / self.lattice.columns, k % self.lattice.columns];
            let is_inside = |at: usize, count: usize| (BORDER..count - BORDER).contains(&at);
            if !is_inside(pixel[0] - rows.start, rows.len()) || !is_inside(pixel[1], self.lattice.columns) {
                continue;
            }
            error.push(all_errors[k]);
            let expected = value(place(&self.lattice, pixel, source.disparity));
            before += f64::from(source.color[0] / expected - 1.0).powi(2);
            after += f64::from(color[k] / source.weight / expected - 1.0).powi(2);
        }
        error.sort_by(f32::total_cmp);
        let count = error.len() as f64;
        [before / count, after / count, f64::from(error[error.len() / 2]).powi(2)]
    }
}

/// Where a pixel sees the plane of this disparity, in pitches of the array.
fn place(lattice: &Lattice, [row, column]: [usize; 2], disparity: f32) -> [f32; 2] {
    let lens = &lattice.lenses[lattice.owners[lattice.place(row, column)] as usize];
    [0, 1].map(|k| {
        let viewpoint = [column, row][k] as f64 + 0.5 - lens.center[k];
        (lens.place[k] + f64::from(disparity) * viewpoint) as f32
    })
}

/// Pixels of the same place are those of the camera: rays of the pixels that a window gathers meet in the plane.
#[test]
fn the_places_of_pixels_are_where_their_rays_meet() {
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows, MicrolensGrid::HexColumns] {
        let size = GridSize::new(60, 70);
        let camera = camera(grid, 9.0, size);
        let lattice = Lattice::new(&camera, 0..60);
        for depth_m in [1.0, 2.5, 8.0] {
            let disparity = lattice.disparity_px(1.0 / depth_m);
            // A pitch of the array at that depth.
            let pitch_m = camera.equivalent_views().slope_per_lens * depth_m;
            for pixel in [[3, 5], [30, 31], [59, 69], [41, 12]] {
                let [x, y] = place(&lattice, pixel, disparity).map(f64::from);
                let on_sensor = camera.place_m([pixel[1] as f64 + 0.5, pixel[0] as f64 + 0.5]);
                let owner = camera.owner(on_sensor);
                let ray = camera.ray(on_sensor, camera.lens_center_m(owner), owner).expect("a thin lens");
                let [px, py] = [0, 1].map(|k| (ray.origin_m[k] + depth_m * ray.direction[k]) / pitch_m);
                assert!((px - x).abs() < 1e-4 && (py + y).abs() < 1e-4, "{grid:?} {depth_m}: {px} {py}, {x} {y}");
            }
        }
    }
}

/// Where all pixels see the same, the noise falls with the number of pixels of a window, and the estimate says so.
#[test]
fn noise_falls_with_the_number_of_pixels() {
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows] {
        for (disparity, gain) in [(0.01, 80.0), (0.0, 80.0), (0.3, 12.0)] {
            let camera = camera(grid, 14.0, GridSize::new(120, 130));
            let [before, after, estimated] = Synthetic::new(&camera, 0..120, disparity, 0.3, |_| 1.0).errors(|_| 1.0);
            assert!(before / after > gain, "{grid:?} {disparity}: {before} to {after}");
            let ratio = estimated / after;
            assert!((0.4..2.5).contains(&ratio), "{grid:?} {disparity}: the estimate is {ratio} of the error");
        }
    }
}

/// A pattern in the scene is found behind other microlenses, and not blurred.
#[test]
fn windows_follow_the_disparity() {
    let value = |[x, y]: [f32; 2]| 2.0 + (0.9 * x).sin() * (0.7 * y).cos();
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexColumns] {
        for disparity in [0.3f32, -0.2] {
            let camera = camera(grid, 11.0, GridSize::new(120, 130));
            let [before, after, _] = Synthetic::new(&camera, 0..120, disparity, 0.2, value).errors(value);
            assert!(before / after > 2.5, "{grid:?} {disparity}: {before} to {after}");
        }
    }
}

/// Parts with their margin have the bytes of the whole, and the number of threads changes nothing.
#[test]
fn parts_and_threads_give_the_same_bytes() {
    let value = |[x, y]: [f32; 2]| 2.0 + (0.9 * x).sin() * (0.7 * y).cos();
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows] {
        let camera = camera(grid, 6.0, GridSize::new(260, 40));
        let margin = Lattice::margin_rows(&camera);
        for disparity in [0.02, 0.4, -0.3] {
            let whole = Synthetic::new(&camera, 0..260, disparity, 0.1, value);
            let (color, error) = whole.reconstructed(0..260);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
            assert!(pool.install(|| whole.reconstructed(0..260)) == (color.clone(), error.clone()));
            for rows in [0..11usize, 120..141, 241..260] {
                let cut = rows.start.saturating_sub(margin)..(rows.end + margin).min(260);
                assert!(cut.len() < 260, "the part is the whole");
                let part = Synthetic::new(&camera, cut, disparity, 0.1, value).reconstructed(rows.clone());
                let same = rows.start * 40..rows.end * 40;
                assert!(
                    part.0 == color[same.clone()] && part.1 == error[same],
                    "{grid:?} {disparity}, rows {rows:?} differ"
                );
            }
        }
    }
}

/// The number of samples in the windows of a pixel: of all pixels behind all microlenses, one after the other.
fn counted(field: &Synthetic, lens: usize, pixel: [usize; 2]) -> [f32; WINDOW_COUNT] {
    let Synthetic { lattice, sources } = field;
    let own = &lattice.lenses[lens];
    let Source { disparity, .. } = sources[lattice.place(pixel[0], pixel[1])];
    let spot = lattice.spot(own.lens_type, disparity);
    let mut out = [0.0; WINDOW_COUNT];
    for (place, source) in sources.iter().enumerate().filter(|(_, source)| source.has_samples()) {
        let other = [lattice.rows.start + place / lattice.columns, place % lattice.columns];
        let theirs = &lattice.lenses[lattice.owners[place] as usize];
        // Rows, columns: how far the viewpoint is, and how far the point from what the other pixel sees.
        let [below, beside] = [0, 1].map(|axis| {
            let [from, to] = [own, theirs].map(|lens| lens.center[1 - axis]);
            let apart = (other[axis] as f64 - (pixel[axis] as f64 - from + to)) as f32;
            let way = (theirs.place[1 - axis] - own.place[1 - axis]) as f32;
            (apart.abs(), (disparity * apart + way).abs())
        });
        let is_same = (source.disparity - disparity).abs() * below.0.max(beside.0) <= 0.25 * spot;
        for (level, count) in out.iter_mut().enumerate().skip(1) {
            let (distance, near) = [(0.0, 0.0), (2.5, 0.1), (4.5, 0.15), (7.5, 0.15), (10.5, 0.2)][level];
            let sees = |(apart, away): (f32, f32)| apart <= distance && away <= near * spot;
            if is_same && sees(below) && sees(beside) {
                *count += source.samples;
            }
        }
    }
    out[0] = if sources[lattice.place(pixel[0], pixel[1])].has_samples() { 4.0 } else { 0.0 };
    out
}

/// Windows have the pixels that all microlenses have there; with and without a list of those with samples they have the
/// same bits.
#[test]
fn windows_are_those_of_a_search_of_all_pixels() {
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows, MicrolensGrid::HexColumns] {
        let camera = camera(grid, 9.0, GridSize::new(90, 100));
        for (disparity, one_in) in [(0.02, 1), (0.02, 16), (0.11, 16), (-0.3, 5), (0.0, 16)] {
            let mut field = Synthetic::new(&camera, 0..90, disparity, 0.1, |[x, _]| 1.0 + x.sin());
            for (place, source) in field.sources.iter_mut().enumerate() {
                let [chance, jump] = [7, 8].map(|seed| uniform(seed, place / 100, place % 100));
                source.samples = if chance * one_in as f32 > 1.0 { 0.0 } else { 4.0 };
                source.disparity += if jump > 0.9 { 0.4 } else { 0.0 };
            }
            let Synthetic { lattice, sources } = &field;
            let sampled = Sampled::find(lattice, sources);
            assert_eq!(sampled.is_some(), one_in > 4, "one in {one_in}");
            for pixel in [[45, 50], [46, 57], [20, 71], [3, 4], [88, 99]] {
                let lens = lattice.owners[lattice.place(pixel[0], pixel[1])] as usize;
                let all = Neighborhood::new(lattice, sources, None, lens).gather(pixel, WINDOW_COUNT - 1);
                let counts = all.map(|sums| sums.weight);
                assert_eq!(counts, counted(&field, lens, pixel), "{grid:?} {disparity} {one_in} {pixel:?}");
                let listed = Neighborhood::new(lattice, sources, sampled.as_ref(), lens);
                let bits = |sums: &Sums| [sums.color[0], sums.color[2], sums.variance, sums.weight].map(f32::to_bits);
                let listed = listed.gather(pixel, WINDOW_COUNT - 1);
                assert_eq!(listed.each_ref().map(bits), all.each_ref().map(bits), "{grid:?} {disparity} {pixel:?}");
            }
        }
    }
}

/// Pixels without light and with the largest radiance are no division by zero and do not overflow.
#[test]
fn black_and_bright_pixels_stay_finite() {
    let camera = camera(MicrolensGrid::HexRows, 8.0, GridSize::new(40, 40));
    for disparity in [0.0, -1e6, 1e-30] {
        let mut field = Synthetic::new(&camera, 0..40, disparity, 0.1, |[x, _]| if x > 0.0 { 1e30 } else { 0.0 });
        field.sources.iter_mut().step_by(7).for_each(|source| *source = Source::default());
        let (color, error) = field.reconstructed(0..40);
        assert!(color.iter().chain(&error).all(|x| x.is_finite()), "{disparity}");
    }
}

/// Samples count the more, the more of them there are; with few, the share is that of the white image up to its error.
#[test]
fn shares_become_those_of_the_samples() {
    let (white, weight) = (0.4, 0.6);
    assert!((share(white, weight, 8.0) - white).abs() < 2e-3);
    assert!((share(white, weight, 1048576.0) - weight).abs() < 1e-3);
    let shares: Vec<f32> = (0..24).map(|power| share(white, weight, f32::from(power as u16).exp2())).collect();
    assert!(shares.windows(2).all(|pair| pair[0] < pair[1]), "{shares:?}");
    // Pixels that all or no samples should reach have no noise: the samples know better.
    for white in [0.0, 1.0] {
        assert_eq!(share(white, 0.5, 8.0), 0.5);
    }
}

/// With eight samples a pixel, each lit or not, the white image takes away what is most of the noise at the rims.
#[test]
fn rims_take_their_shares_from_the_white_image() {
    const SAMPLES: u32 = 8;
    let camera = camera(MicrolensGrid::HexRows, 14.0, GridSize::new(120, 130));
    let Synthetic { lattice, sources } = Synthetic::new(&camera, 0..120, 0.01, 0.1, |_| 1.0);
    let white = camera.white_image().unwrap();
    let lit = |place: usize, white: f32| {
        let is_lit = |k: &u32| uniform(10 + k, place / lattice.columns, place % lattice.columns) < white;
        (0..SAMPLES).filter(is_lit).count() as f32 / SAMPLES as f32
    };
    let mut sources: Vec<Source> = sources
        .into_iter()
        .zip(&white)
        .enumerate()
        .map(|(k, (source, &white))| {
            let weight = lit(k, white);
            let is_lit = weight >= MIN_WEIGHT;
            let color = if is_lit { source.color } else { [0.0; 3] };
            let disparity = if is_lit { source.disparity } else { 0.0 };
            Source { color, disparity, weight, share: weight, ..source }
        })
        .collect();
    let squared_error = |sources: &[Source]| {
        let all = Synthetic { lattice: Lattice::new(&camera, 0..120), sources: sources.to_vec() };
        let (color, _) = all.reconstructed(0..120);
        let squares =
            color.iter().zip(&white).filter(|(_, white)| **white > 0.05).map(|(color, white)| (color - white).powi(2));
        squares.sum::<f32>() / white.iter().filter(|white| **white > 0.05).map(|white| white * white).sum::<f32>()
    };
    let before = squared_error(&sources);
    for (source, &white) in sources.iter_mut().zip(&white) {
        source.share = share(white, source.weight, SAMPLES as f32);
    }
    fill_rims(&lattice, &mut sources);
    let after = squared_error(&sources);
    assert!(after < before / 10.0, "{before:e} {after:e}");
}
