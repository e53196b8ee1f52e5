//! `holo develop` and `holo demosaic`: codes of sensors, and color again.

use crate::common::{Bench, SCENE, camera_with_sensor, refused, succeeds};
use crate::python;
use holo_io::{ExrChannel, Limits, MosaicInfo, read_exr, read_png, write_exr};
use ndarray::{Array2, Array3};

/// A camera of 120 x 90 pixels with a sensor.
fn camera() -> String {
    camera_with_sensor().replace("[60, 45]", "[120, 90]")
}

/// A bench with the raw image of a camera, in `out`.
fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("small.toml"), camera()).unwrap();
    succeeds(&bench, &format!("render {SCENE} --camera-file small.toml --spp 4 --sky 1,1,1 --out out"));
    bench
}

fn codes(bench: &Bench, name: &str) -> Array3<u16> {
    match read_png(bench.path(name), &Limits::default()).unwrap() {
        holo_core::DynImage::U16(codes) => codes,
        other => panic!("{name}: {:?}", other.kind()),
    }
}

#[test]
fn a_raw_image_is_developed_demosaiced_and_decoded() {
    let bench = bench();
    let develop = "develop out/raw.exr --camera-file out/camera.toml --iso 400 --seed 3 --out out/raw.png";
    let said = succeeds(&bench, develop);
    assert!(said.contains("electrons at value 1") && said.contains("guessed: dark current"), "{said}");
    let files = bench.list("out");
    for name in ["raw.png", "raw.dng", "raw_clean.png", "raw_rgb.png", "raw.json", "raw.exr"] {
        assert!(files.contains(&name.to_owned()), "no {name} in {files:?}");
    }
    let info = MosaicInfo::read_for(bench.path("out/raw.png")).unwrap();
    assert_eq!((info.exposure.iso, info.exposure.seed, info.exposure.time_s), (400.0, 3, 0.004));
    assert_eq!(info, MosaicInfo::read_for(bench.path("out/raw_clean.png")).unwrap());
    let (noisy, clean) = (codes(&bench, "out/raw.png"), codes(&bench, "out/raw_clean.png"));
    assert_eq!(noisy.dim(), (90, 120, 1));
    // Shot noise, read noise and fixed patterns, of the codes that do not saturate.
    let gain = info.sensor.gain(400.0);
    let (mut sum, mut count) = (0.0, 0);
    for (&noisy, &clean) in noisy.iter().zip(&clean) {
        if (200..3500).contains(&clean) {
            let electrons = (f64::from(clean) - info.sensor.black) / gain;
            let expected = gain * gain * (electrons + 2.3 * 2.3 + 1.0 + (0.005 * electrons).powi(2));
            sum += (f64::from(noisy) - f64::from(clean)).powi(2) / expected;
            count += 1;
        }
    }
    assert!(count > 1000, "{count}");
    // The standard error of the mean of squares.
    assert!((sum / f64::from(count) - 1.0).abs() < 4.0 * (2.0 / f64::from(count)).sqrt(), "{sum} {count}");

    // The same again has the same bytes, another frame other noise.
    let before = std::fs::read(bench.path("out/raw.png")).unwrap();
    succeeds(&bench, develop);
    assert_eq!(std::fs::read(bench.path("out/raw.png")).unwrap(), before);
    succeeds(&bench, "develop out/raw.exr --camera-file small.toml --frame 1 --write png --out out/other.png");
    assert_ne!(std::fs::read(bench.path("out/other.png")).unwrap(), before);
    assert!(!bench.path("out/other.dng").exists());

    let raw = read_exr(bench.path("out/raw.exr"), &Limits::default()).unwrap();
    let green = raw.channel("G").unwrap();
    for method in ["bilinear", "malvar", "ahd", "micro-images --camera-file small.toml"] {
        succeeds(&bench, &format!("demosaic out/raw_clean.png --method {method} --out out/color.exr"));
        let color = read_exr(bench.path("out/color.exr"), &Limits::default()).unwrap();
        let found = color.channel("G").unwrap();
        let saturation = info.sensor.saturation_e(400.0) / info.exposure.electrons_at_one;
        let pairs = found.iter().zip(green).filter(|(_, truth)| f64::from(**truth) < 0.9 * saturation);
        let (error, total) = pairs.fold((0.0, 0.0), |(error, total), (a, b)| (error + (a - b).abs(), total + b));
        // Of small micro-images with dark gaps, which the plain methods mix with the light.
        let bound = if method.starts_with("micro") { 0.1 } else { 0.2 };
        assert!(error / total < bound, "{method}: {}", error / total);
        // The code of a green pixel is rounded, after the mean dark current; no method changes it.
        let dark_code = gain * info.sensor.dark_current_e_s * info.exposure.time_s;
        let half_code = (0.5 + dark_code) / (gain * info.exposure.electrons_at_one);
        for ((row, column), &truth) in green.indexed_iter().filter(|((row, column), _)| (row + column) % 2 == 1) {
            let error = f64::from((found[[row, column]] - truth).abs());
            assert!(
                error < 1.01 * half_code || f64::from(truth) > 0.9 * saturation,
                "{method} {row} {column}: {error}"
            );
        }
    }
    succeeds(&bench, "decode out/color.exr --camera-file out/camera.toml --out views");
    succeeds(&bench, "verify views");
}

#[test]
fn white_and_dark_frames_are_means() {
    let bench = bench();
    succeeds(&bench, "white --camera-file small.toml --out white");
    succeeds(
        &bench,
        "develop white/white.exr --camera-file small.toml --frames 64 --write png,clean --out white/w.png",
    );
    let (mean, clean) = (codes(&bench, "white/w.png"), codes(&bench, "white/w_clean.png"));
    let off = mean.iter().zip(&clean).map(|(&a, &b)| (f64::from(a) - f64::from(b)).abs() / f64::from(b).max(100.0));
    assert!(off.fold(0.0, f64::max) < 0.05);
    succeeds(&bench, "develop out/raw.exr --camera-file small.toml --dark --write png --out dark.png");
    let dark = codes(&bench, "dark.png");
    let mean = dark.iter().map(|&code| f64::from(code)).sum::<f64>() / dark.len() as f64;
    assert!((mean - 60.0).abs() < 0.1, "{mean}");
}

#[test]
fn an_ideal_raw_image_has_a_sensor_too() {
    let bench = Bench::new();
    let render = format!("render {SCENE} --views 5 --lenses 24x18 --spp 4 --sky 1,1,1");
    succeeds(&bench, &format!("{render} --sensor-model cmv12000 --iso 200 --out ideal"));
    let files = bench.list("ideal");
    assert!(files.contains(&"scene_raw.png".into()) && files.contains(&"scene_raw.json".into()), "{files:?}");
    succeeds(&bench, "verify ideal");
    assert_eq!(codes(&bench, "ideal/scene_raw.png").dim(), (90, 120, 1));
    succeeds(&bench, "demosaic ideal/scene_raw.png --out color.png");
    assert_eq!(codes(&bench, "color.png").dim(), (90, 120, 3));
    // The published image, back from its curve.
    succeeds(&bench, "develop ideal/scene_el.png --sensor-model imx250 --write rgb,png --out again.png");
    let rgb = read_png(bench.path("again_rgb.png"), &Limits::default()).unwrap();
    assert_eq!((rgb.size().columns, rgb.channels()), (120, 3));
}

/// LibRaw, through rawpy, makes gray of gray and red of red: black level, white balance and color matrix arrive.
#[test]
fn libraw_opens_dngs_with_the_right_colors() {
    let bench = Bench::new();
    // A gray half and a reddish one.
    let color = |channel: usize| {
        Array2::from_shape_fn((128, 256), |(_, column)| if column < 128 { 0.5 } else { [0.5f32, 0.3, 0.2][channel] })
    };
    let planes = [0, 1, 2].map(color);
    let channels: Vec<_> =
        ["R", "G", "B"].iter().zip(&planes).map(|(name, plane)| ExrChannel::float(name, plane.view())).collect();
    write_exr(bench.path("patches.exr"), &channels).unwrap();
    for sensor in ["lytro-illum", "imx250"] {
        succeeds(&bench, &format!("develop patches.exr --sensor-model {sensor} --electrons 4500 --out {sensor}.dng"));
        let path = bench.path(format!("{sensor}.dng")).to_str().unwrap().to_owned();
        let Some(said) = python::run(&["numpy", "rawpy"], include_str!("rawpy_patches.py"), &[&path]) else { return };
        let means: [[f64; 3]; 2] = serde_json::from_str(&said).unwrap();
        let info = MosaicInfo::read_for(bench.path(format!("{sensor}.png"))).unwrap();
        let range = f64::from(info.sensor.white()) - info.sensor.black;
        let one = info.sensor.gain(info.exposure.iso) * 4500.0 / range;
        for (found, expected) in means.iter().zip([[0.5; 3], [0.5, 0.3, 0.2]]) {
            for (found, expected) in found.iter().zip(expected) {
                assert!((found / (one * expected) - 1.0).abs() < 0.01, "{sensor}: {found} {}", one * expected);
            }
        }
    }
}

#[test]
fn impossible_requests_are_refused() {
    let bench = bench();
    refused(&bench, "develop out/raw.exr --out x.png", "--sensor-model");
    refused(&bench, "develop out/raw.exr --sensor-model imx25 --out x.png", "imx250, cmv12000");
    refused(&bench, "develop out/raw.exr --sensor-model imx250 --out x.tif", ".png or .dng");
    refused(&bench, "develop out/raw.exr --sensor-model imx250 --iso 0 --out x.png", "--iso");
    refused(&bench, "develop out/raw_linear.png --sensor-model imx250 --out out/raw_linear.png", "is the input");
    refused(&bench, "demosaic out/raw_linear.png --out x.jpg", ".exr, .pfm or .png");
    refused(&bench, "demosaic out/raw_linear.png --method micro-images --out x.exr", "--camera-file");
    refused(
        &bench,
        "demosaic out/raw.png --method ahd --camera-file small.toml --out x.exr",
        "ahd knows no microlenses",
    );
    let outcome = bench.run("demosaic out/raw_linear.png --out x.exr");
    assert!(outcome.code == Some(1) && outcome.stderr.contains("raw_linear.json"), "{outcome:?}");
    let mono = camera().replace("model = \"imx250\"", "model = \"imx250\"\ncfa = \"mono\"");
    std::fs::write(bench.path("mono.toml"), mono).unwrap();
    refused(&bench, "develop out/raw.exr --camera-file mono.toml --write dng --out x.dng", "Bayer mosaic");
    succeeds(&bench, "develop out/raw.exr --camera-file mono.toml --out mono.png");
    assert!(!bench.path("mono.dng").exists() && bench.path("mono_clean.png").exists());
    for (key, word) in [("bits = 20", "bits"), ("cfa = \"RGBG\"", "RGGB"), ("model = \"imx25\"", "did you mean imx250")]
    {
        let text = camera().replace("model = \"imx250\"", key);
        let text =
            if key.starts_with("model") { text } else { text.replace("electrons", "model = \"imx250\"\nelectrons") };
        std::fs::write(bench.path("bad.toml"), text).unwrap();
        let outcome = bench.run("develop out/raw.exr --camera-file bad.toml --out x.png");
        assert!(outcome.code == Some(1) && outcome.stderr.contains(word), "{key}: {outcome:?}");
    }
    assert!(!bench.path("x.png").exists());
}
