use ndarray::Array3;

use super::*;
use crate::sensor::{ElectronsAtOne, SensorPreset, sensor_presets};

fn model(name: &str) -> SensorModel {
    SensorPreset::by_name(name).expect("a preset").model
}

fn even(value: f32, rows: usize, columns: usize) -> Array3<f32> {
    Array3::from_elem((rows, columns, 3), value)
}

/// Mean and variance of codes.
fn moments(codes: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = codes.clone().count() as f64;
    let mean = codes.clone().sum::<f64>() / count;
    [mean, codes.map(|code| (code - mean) * (code - mean)).sum::<f64>() / (count - 1.0)]
}

/// The photon transfer curve of every preset: the variance between two frames grows with the mean by the gain K, within 1 %
/// at ten levels each, from what reading and rounding add (EMVA 1288, 4.0, section 6.6).
#[test]
fn the_photon_transfer_curve_has_the_slope_of_the_gain() {
    const SIDE: usize = 512;
    for preset in sensor_presets() {
        let sensor = SensorModel { hot_share: 0.0, ..preset.model };
        let gain = sensor.gain(sensor.base_iso);
        for level in 1..=10 {
            // Up to 80 % of saturation, in the color of the sensor with the highest response.
            let electrons = 0.08 * level as f64 * sensor.saturation_e(sensor.base_iso);
            let response = sensor.camera_from_rgb().unwrap().map(|row| row.iter().sum::<f64>());
            let most = response.iter().fold(0.0, |a: f64, &b| a.max(b));
            let exposure = Exposure { seed: level, ..Exposure::new(electrons / most, sensor.base_iso) };
            let image = even(1.0, SIDE, SIDE);
            let [a, b] = [0, 1]
                .map(|frame| sensor.expose(image.view(), &Exposure { frame, ..exposure }, 1).unwrap().mapv(f64::from));
            // One color of the mosaic, and the differences of two frames, in which fixed patterns cancel. Rows have their
            // own offset in every frame.
            let color = most_of(&response);
            let places: Vec<[usize; 2]> = (0..SIDE * SIDE)
                .map(|k| [k / SIDE, k % SIDE])
                .filter(|[row, column]| sensor.filter.mosaic().unwrap()[row % 2][column % 2] == color)
                .collect();
            let at = |image: &Array3<f64>, [row, column]: [usize; 2]| image[[row, column, 0]];
            let [mean, _] = moments(places.iter().map(|&p| 0.5 * (at(&a, p) + at(&b, p))));
            let [_, twice] = moments(places.iter().map(|&p| at(&a, p) - at(&b, p)));
            let own = gain * gain * (sensor.read_noise_e.powi(2) + sensor.row_noise_e.powi(2)) + 1.0 / 12.0;
            let dark = gain * sensor.dark_current_e_s * exposure.time_s;
            let slope = (twice / 2.0 - own) / (mean - sensor.black);
            // 65,536 differences or more: a standard error of 0.55 %, and PRNU widens the variance by prnu^2 of itself.
            let error = (2.0 / places.len() as f64).sqrt();
            assert!((slope / gain - 1.0).abs() < 0.01f64.max(3.0 * error), "{} {level}: {slope} {gain}", preset.name);
            assert!((mean - sensor.black - dark - gain * electrons).abs() < 0.01 * gain * electrons, "{}", preset.name);
        }
    }
}

fn most_of(values: &[f64; 3]) -> usize {
    (0..3).fold(0, |most, k| if values[k] > values[most] { k } else { most })
}

/// Fixed patterns are recovered from the mean of many frames, and are those of the camera.
#[test]
fn fixed_patterns_belong_to_the_camera() {
    let sensor = SensorModel { prnu: 0.02, dsnu_e: 8.0, column_noise_e: 4.0, ..model("imx250") };
    let exposure = Exposure::new(5000.0, 100.0);
    let gain = sensor.gain(100.0);
    let dark = even(0.0, 256, 256);
    // The mean of 64 frames as a code would round the pattern away: K is below one.
    let fine = SensorModel { bits: 16, black: 1000.0, dn_per_e: 5.0, full_well_e: 12_000.0, ..sensor };
    let of = |sensor: &SensorModel, image: &Array3<f32>, exposure: &Exposure| {
        sensor.expose(image.view(), exposure, 64).unwrap().mapv(f64::from)
    };
    let [_, variance] = moments(of(&fine, &dark, &exposure).iter().copied());
    let expected = 25.0 * (64.0 + 16.0 + (2.3f64.powi(2) + 0.02) / 64.0);
    // 256 columns: a standard error of 9 % of their share.
    assert!((variance / expected - 1.0).abs() < 0.1, "{variance} {expected}");
    let bright = of(&fine, &even(1.0, 256, 256), &exposure);
    let [mean, variance] = moments(bright.iter().copied());
    let expected = 25.0 * ((0.02f64 * 5000.0).powi(2) + 80.0 + 5000.0 / 64.0);
    assert!((variance / expected - 1.0).abs() < 0.05, "{variance} {expected}");
    assert!((mean / (5.0 * 5000.0 + 1000.0) - 1.0).abs() < 0.01, "{mean}");

    let [same, other] =
        [(0, 1), (1, 0)].map(|(camera_seed, seed)| of(&fine, &dark, &Exposure { camera_seed, seed, ..exposure }));
    let first = of(&fine, &dark, &exposure);
    let correlation = |a: &Array3<f64>, b: &Array3<f64>| {
        let ([mean_a, variance_a], [mean_b, variance_b]) = (moments(a.iter().copied()), moments(b.iter().copied()));
        let product: f64 = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum::<f64>() / a.len() as f64;
        product / (variance_a * variance_b).sqrt()
    };
    assert!(correlation(&first, &same) > 0.99 && correlation(&first, &other).abs() < 0.1);
    assert!(gain < 1.0);
}

/// Codes are clamped at both ends, and the full well before the largest code where the gain is low.
#[test]
fn codes_saturate() {
    let sensor = SensorModel { dn_per_e: 0.1, ..model("imx250") };
    let bright = sensor.expose(even(10.0, 8, 8).view(), &Exposure::new(1e5, 100.0), 1).unwrap();
    // 11,000 electrons and the noise of reading them.
    assert!(bright.iter().all(|&code| (1155..=1165).contains(&code)), "{bright}");
    let loud = sensor.expose(even(10.0, 8, 8).view(), &Exposure::new(1e5, 6400.0), 1).unwrap();
    assert!(loud.iter().all(|&code| code == 4095));
    let noisy = SensorModel { black: 0.0, read_noise_e: 1000.0, ..sensor };
    let dark = noisy.expose(even(0.0, 8, 8).view(), &Exposure::new(1.0, 100.0), 1).unwrap();
    assert!(dark.iter().any(|&code| code == 0) && dark.iter().any(|&code| code > 0));
}

/// Without noise, the code is the rounded value; white keeps the neutral of the white balance.
#[test]
fn clean_codes_are_proportional_to_light() {
    let sensor = model("lytro-illum");
    let exposure = Exposure { time_s: 0.0, ..Exposure::new(2000.0, 80.0) };
    let codes = sensor.expose_without_noise(even(1.0, 2, 2).view(), &exposure).unwrap();
    let gain = sensor.gain(80.0);
    let code = |factor: f64| (gain * 2000.0 / factor + 64.0).round() as u16;
    // GRBG.
    let expected = [code(1.0), code(1.378_859_281_539_917), code(1.148_465_991_020_202_6), code(1.0)];
    assert_eq!(codes.as_slice().unwrap(), expected);
    // And back.
    let light = codes.mapv(|code| sensor.linear(f64::from(code), &exposure) as f32);
    let rgb = demosaic_of(&sensor, &light);
    assert!(rgb.iter().all(|value| (value - 1.0).abs() < 5e-3), "{rgb}");
}

fn demosaic_of(sensor: &SensorModel, light: &Array3<f32>) -> Array3<f32> {
    let gray = light.index_axis(Axis(2), 0);
    let image = crate::sensor::demosaic(gray, sensor.filter, crate::sensor::Demosaic::Bilinear).unwrap();
    sensor.rgb_from_camera(image)
}

/// Automatic exposure leaves 1 % of the lit pixels above 80 % of saturation, whatever the film speed.
#[test]
fn automatic_exposure_has_headroom() {
    let sensor = SensorModel::ideal(ColorFilter::Mono, 12, 10_000.0);
    let mut image = Array3::from_shape_fn((100, 100, 1), |(row, column, _)| (row * 100 + column + 1) as f32 / 1e4);
    image.slice_axis_mut(Axis(1), (..20).into()).fill(0.0);
    for iso in [100.0, 800.0] {
        let electrons = sensor.automatic_electrons(image.view(), iso).unwrap();
        let above = image.iter().filter(|&&v| electrons * f64::from(v) > 0.8 * sensor.saturation_e(iso)).count();
        assert!((70..=80).contains(&above), "{above} of 8000");
    }
    let dark = sensor.automatic_electrons(even(0.0, 2, 2).view(), 100.0).unwrap();
    assert_eq!(dark, 8000.0);
    assert_eq!(ElectronsAtOne::default(), ElectronsAtOne::Automatic);
}

/// A part of an image has the codes of the whole, for any threads: the code depends on the place alone.
#[test]
fn codes_depend_on_the_place_alone() {
    let sensor = model("cmv12000");
    let image = Array3::from_shape_fn((40, 60, 3), |(row, column, c)| ((row * 7 + column * 3 + c) % 11) as f32 / 11.0);
    let exposure = Exposure::new(4000.0, 100.0);
    let whole = sensor.expose(image.view(), &exposure, 1).unwrap();
    let part = sensor.expose(corner(image.view()), &exposure, 1).unwrap();
    assert_eq!(part, corner(whole.view()));
    // As any machine has them, and a script in Python.
    assert_eq!(
        whole.iter().fold(0u64, |sum, &code| sum.wrapping_mul(31).wrapping_add(code.into())),
        10_028_288_525_389_252_655
    );
}

/// The upper left 20 x 30 pixels.
fn corner<T>(image: ndarray::ArrayView3<T>) -> ndarray::ArrayView3<T> {
    image.slice_axis_move(Axis(0), (..20).into()).slice_axis_move(Axis(1), (..30).into())
}

#[test]
fn impossible_numbers_are_errors() {
    let sensor = model("imx250");
    let image = even(1.0, 2, 2);
    let fails = |sensor: SensorModel, exposure: Exposure, word: &str| {
        let error = sensor.expose(image.view(), &exposure, 1).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    };
    let exposure = Exposure::new(1000.0, 100.0);
    fails(SensorModel { bits: 17, ..sensor }, exposure, "bits");
    fails(SensorModel { black: 4095.0, ..sensor }, exposure, "black level");
    fails(SensorModel { full_well_e: f64::NAN, ..sensor }, exposure, "full well");
    fails(SensorModel { read_noise_e: -1.0, ..sensor }, exposure, "read noise");
    fails(SensorModel { hot_share: 1.5, ..sensor }, exposure, "hot pixels");
    fails(SensorModel { color_matrix: [[1.0; 3]; 3], ..sensor }, exposure, "determinant");
    fails(sensor, Exposure { electrons_at_one: 0.0, ..exposure }, "electrons");
    fails(sensor, Exposure { iso: f64::INFINITY, ..exposure }, "film speed");
    assert!(sensor.expose(image.view(), &exposure, 0).is_err());
    assert!(sensor.expose(Array3::zeros((2, 2, 2)).view(), &exposure, 1).is_err());
    assert!(sensor.expose(Array3::zeros((0, 2, 3)).view(), &exposure, 1).is_err());
    // What is no number gives no light, and no panic.
    let odd = Array3::from_shape_vec((1, 4, 1), vec![f32::NAN, f32::INFINITY, -1.0, 1e30]).unwrap();
    let codes = SensorModel { read_noise_e: 0.0, dsnu_e: 0.0, ..sensor }.expose(odd.view(), &exposure, 1).unwrap();
    assert_eq!(codes.as_slice().unwrap()[2], 60);
}
