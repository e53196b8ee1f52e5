//! The sharpness of an edge through a main lens of glass, measured as by ISO 12233, against the rays of Optiland.

use crate::common::{add, is_thorough};
use holo_core::GridSize;
use holo_core::plenoptic::{
    ArrayFocus, ImageSensor, LensAperture, MainLens, MicrolensArray, MicrolensGrid, Objective, PlenopticCamera,
};
use holo_render::{Backend, Integrator, LayerSet, Renderer, Request};
use holo_scene::{Mesh, Scene, Transform};
use ndarray::{Array3, ArrayView2, Axis};

/// The modulation that rays of Optiland have, at 0, 2 .. 20 cycles/mm, of points 1.25 m from the double Gauss, which is closed to f/2.8
/// and focused at 1.5 m: on the axis, and in an image 4.96 mm away from it, along the radius and around the axis. Its rays are uniform in
/// the entrance pupil, as light is; its own geometric MTF takes them uniform in the stop, and is higher by up to 0.005.
/// `crates/holo-bench/peers/optiland_mtf.py` prints both.
const AXIS: [f64; 11] = [1.0, 0.9539, 0.8235, 0.6311, 0.4085, 0.1905, 0.0076, 0.1192, 0.1819, 0.1854, 0.1449];
const RADIAL: [f64; 11] = [1.0, 0.9342, 0.7568, 0.5201, 0.2906, 0.1337, 0.0956, 0.0950, 0.0741, 0.0521, 0.0440];
const AROUND: [f64; 11] = [1.0, 0.9521, 0.8175, 0.6211, 0.3978, 0.1844, 0.0115, 0.1022, 0.1526, 0.1493, 0.1104];

/// On the axis, of the wavelengths of red, green and blue: 611.4, 549.1 and 464.3 nm.
const COLORS: [[f64; 11]; 3] = [
    [1.0, 0.9516, 0.8153, 0.6154, 0.3865, 0.1658, 0.0146, 0.1342, 0.1864, 0.1789, 0.1298],
    [1.0, 0.9582, 0.8395, 0.6621, 0.4529, 0.2416, 0.0560, 0.0834, 0.1659, 0.1918, 0.1708],
    [1.0, 0.9724, 0.8924, 0.7682, 0.6123, 0.4399, 0.2672, 0.1089, 0.0227, 0.1196, 0.1782],
];

/// A pixel for each microlens, which has all its light: the image of the exit pupil is 0.7 px wide. Microlenses are half as wide as
/// far apart, and four times as far from the sensor, so that cos^4 hardly changes within one.
const PITCH_M: f64 = 20e-6;
const WIDTH_M: f64 = 10e-6;
const GAP_M: f64 = 40e-6;
/// From the exit pupil to the array.
const PUPIL_M: f64 = 55.2e-3;
const SIZE: GridSize = GridSize::new(97, 37);
const DEPTH_M: f64 = 1.25;
/// The light of a point is spread over less than twice this.
const WINDOW_PX: f64 = 12.0;
/// The slant of the edge.
const SLOPE: f64 = 0.09;

fn camera(offset_m: [f64; 2]) -> PlenopticCamera {
    let mut array = MicrolensArray::new(MicrolensGrid::Square, PITCH_M, GAP_M);
    array.aperture = LensAperture::Square { half_width_m: WIDTH_M / 2.0 };
    // The light of a lens far from the axis reaches the middle of its pixel.
    array.offset_m = offset_m.map(|x| -x * GAP_M / (PUPIL_M + GAP_M));
    let mut sensor = ImageSensor::new(SIZE, PITCH_M);
    sensor.offset_m = offset_m;
    let glass = Objective::by_name("double-gauss").expect("an objective").prescription().expect("a lens");
    let glass = glass.stopped_down(2.8).expect("a lens");
    let lens = MainLens::of_glass(glass, ArrayFocus::Depth { depth_m: 1.5, virtual_depth: 0.0 });
    PlenopticCamera::new(sensor, array, lens).expect("a camera")
}

/// The raw image of a world that is bright to the left of a slanted edge through a point (x, y), as a share of a bright world: the
/// rays of both are the same. Three colors; each has its own refraction if `spectral`.
fn image(offset_m: [f64; 2], [x, y]: [f64; 2], spectral: bool) -> Array3<f64> {
    let bright = |edge_m: f64| {
        let corner = |left: f64, up: f64| [(left + SLOPE * (up - y)) as f32, up as f32, -DEPTH_M as f32];
        let half = Mesh {
            positions: vec![corner(-1.0, -1.0), corner(edge_m, -1.0), corner(edge_m, 1.0), corner(-1.0, 1.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let mut scene = Scene::default();
        add(&mut scene, half, [0.0, 0.0, 0.0, 1.0], Transform::IDENTITY);
        scene.materials[0].emission = [1.0; 3];
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a renderer");
        let request = Request::new(camera(offset_m)).integrator(Integrator::Direct).samples(256).spectral(spectral);
        let rendered = renderer.render(&request.layers(LayerSet::EMPTY), &()).expect("a render");
        rendered.color.as_ref().expect("color").to_elemental_grid().expect("memory").mapv(f64::from)
    };
    bright(x) / bright(1.0)
}

/// The modulation at a frequency, cycles/mm, without that of pixels and bins.
fn modulation(edge: ArrayView2<'_, f64>, per_mm: f64) -> f64 {
    // Bins a quarter of a pixel wide across the edge.
    let across = 1.0 / (1.0 + SLOPE * SLOPE).sqrt();
    let bin_px = 0.25;
    let mut bins = vec![[0.0; 2]; 4 * SIZE.columns];
    for ((row, column), value) in edge.indexed_iter() {
        let middle = [SIZE.rows as f64 / 2.0, SIZE.columns as f64 / 2.0];
        let away = (column as f64 - middle[1] + SLOPE * (row as f64 - middle[0])) * across;
        let bin = (away / bin_px).round() + bins.len() as f64 / 2.0;
        let is_near = away.abs() <= WINDOW_PX;
        if is_near && (0.0..bins.len() as f64).contains(&bin) {
            bins[bin as usize][0] += value;
            bins[bin as usize][1] += 1.0;
        }
    }
    let profile: Vec<f64> = bins.iter().filter(|[_, count]| *count >= 8.0).map(|[sum, count]| sum / count).collect();
    let steps: Vec<f64> = profile.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let total: f64 = steps.iter().sum();
    let turn = std::f64::consts::TAU * per_mm * PITCH_M * 1e3 * bin_px;
    let (re, im) = steps.iter().enumerate().fold((0.0, 0.0), |(re, im), (k, step)| {
        (re + step * (turn * k as f64).cos(), im + step * (turn * k as f64).sin())
    });
    let sinc = |width_px: f64| {
        let x = std::f64::consts::PI * per_mm * PITCH_M * 1e3 * width_px;
        if x == 0.0 { 1.0 } else { x.sin() / x }
    };
    // The square of a microlens seen along the edge, the width of a bin, and the difference of two.
    let lens_px = WIDTH_M / PITCH_M * across;
    let measured = sinc(lens_px) * sinc(lens_px * SLOPE) * sinc(bin_px).powi(2);
    (re.hypot(im) / total.abs()) / measured
}

/// Holds the modulation of an edge to that of rays, within 0.01; half of that is noise.
fn check(name: &str, edge: ArrayView2<'_, f64>, expected: [f64; 11]) {
    let found: Vec<f64> = (0..11).map(|k| modulation(edge, 2.0 * f64::from(k))).collect();
    println!("{name}: {found:.4?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 0.01, "{name}: {found} {expected}");
    }
}

/// Away from the axis; on it, too, with `HOLO_THOROUGH=1`: the colors are there.
#[test]
fn an_edge_through_glass_is_as_sharp_as_optiland_says() {
    let cases = [
        ("along the radius", [4.96e-3, 0.0], [0.1202, 0.0], RADIAL),
        ("around the axis", [0.0, 4.96e-3], [0.0, 0.1202], AROUND),
        ("on the axis", [0.0, 0.0], [0.0, 0.0], AXIS),
    ];
    for (name, offset_m, point_m, expected) in cases.into_iter().take(if is_thorough() { 3 } else { 1 }) {
        check(name, image(offset_m, point_m, false).index_axis(Axis(2), 0), expected);
    }
}

/// Light of other wavelengths is sharp elsewhere: a colored edge.
#[test]
fn each_color_is_as_sharp_as_optiland_says() {
    let edge = image([0.0; 2], [0.0; 2], true);
    for (channel, (name, expected)) in ["red", "green", "blue"].into_iter().zip(COLORS).enumerate() {
        check(name, edge.index_axis(Axis(2), channel), expected);
    }
}
