//! Reconstruction of raw images of plenoptic cameras: as good as that of the views of a rig, even where vignetting is not,
//! the same bytes for parts and threads.

use std::num::NonZeroUsize;

use crate::common::{ideal, soup};
use holo_core::plenoptic::{
    ImageSensor, LensAperture, MainLens, MicrolensArray, MicrolensGrid, PlenopticCamera, Preset,
};
use holo_core::{GridSize, LightFieldOwned};
use holo_render::{
    Backend, Denoise, Error, Integrator, LayerSet, Rendered, Renderer, Request, Reuse, SamplesPerPixel, TextureFilter,
};
use holo_scene::{Scene, Transform};
use ndarray::s;

fn renderer(scene: &Scene, threads: usize) -> Renderer {
    Renderer::new(scene, &Transform::IDENTITY, Backend::Auto, NonZeroUsize::new(threads)).expect("a renderer")
}

fn color(rendered: &Rendered) -> &LightFieldOwned<f32> {
    rendered.color.as_ref().expect("an image")
}

/// A preset's camera with a smaller sensor.
fn part(name: &str, size: GridSize) -> PlenopticCamera {
    let whole = Preset::by_name(name).expect("a preset").camera().expect("a camera");
    let mut sensor = *whole.sensor();
    sensor.size = size;
    PlenopticCamera::new(sensor, whole.array().clone(), whole.main_lens().clone()).expect("a camera")
}

/// The mean squared difference relative to the mean square, without the largest of a hundred.
fn squared_error(found: &Rendered, exact: &Rendered) -> f64 {
    let (found, exact) = (color(found).samples(), color(exact).samples());
    let mut squares: Vec<f64> = found.iter().zip(&exact).map(|(a, b)| f64::from(a - b).powi(2)).collect();
    squares.sort_by(f64::total_cmp);
    squares.truncate(squares.len() * 99 / 100);
    let bright = exact.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>() / exact.len() as f64;
    squares.iter().sum::<f64>() / squares.len() as f64 / bright
}

/// One pixel in 16 has a sample, and every second microlens none. Most pixels have the light that four samples of their own find, to
/// a half.
#[test]
fn few_samples_leave_no_pixel_dark() {
    let renderer = renderer(&soup(400, 3), 0);
    let request =
        Request::new(part("lytro-illum", GridSize::new(200, 280))).sky([0.5, 0.7, 1.0]).layers(LayerSet::EMPTY);
    let rendered = |request: &Request| renderer.render(request, &()).expect("a render");
    let plain = rendered(&request.clone().samples(4));
    let few = SamplesPerPixel::one_in(16).expect("a power of two");
    let few = rendered(&request.samples(few).denoise(Denoise::Views));
    let (plain, few) = (color(&plain).samples(), color(&few).samples());
    let mean = plain.mean().expect("pixels");
    let lit: Vec<f32> =
        plain.iter().zip(&few).filter(|&(&plain, _)| plain > 0.3 * mean).map(|(plain, few)| few / plain).collect();
    let share = |is: &dyn Fn(f32) -> bool| lit.iter().filter(|&&ratio| is(ratio)).count() as f64 / lit.len() as f64;
    let (dark, alike) = (share(&|ratio| ratio < 0.05), share(&|ratio| (0.5..2.0).contains(&ratio)));
    println!("{dark:.4} dark, {alike:.3} alike");
    assert!(dark < 0.05 && alike > 0.6, "{dark} of the pixels are dark, {alike} alike");
}

/// Where the camera is a rig, its reconstruction is about as good as that of the rig.
#[test]
fn an_ideal_camera_gains_what_its_rig_gains() {
    let scene = soup(400, 3);
    let renderer = renderer(&scene, 0);
    let (camera, rig) = ideal(12, [10, 14]);
    let gain = |request: Request| {
        let request = request.integrator(Integrator::Direct).sky([0.5, 0.7, 1.0]).layers(LayerSet::EMPTY);
        let request = request.reuse(Reuse::Off).texture_filter(TextureFilter::Off);
        let render = |request: Request| renderer.render(&request, &()).expect("a render");
        let exact = render(request.clone().samples(512).seed(9));
        let request = request.samples(4);
        let plain = squared_error(&render(request.clone()), &exact);
        let denoised = render(request.denoise(Denoise::Views).estimate_error(true));
        assert!(denoised.error_distribution.is_some() && denoised.error.is_some());
        plain / squared_error(&denoised, &exact)
    };
    let (of_rig, of_camera) = (gain(Request::new(rig)), gain(Request::new(camera)));
    println!("the squared error falls by {of_rig:.1} for the rig, by {of_camera:.1} for the camera");
    assert!(of_camera > 1.2 && of_camera > 0.4 * of_rig, "{of_camera} instead of {of_rig}");
}

/// Of an even sky a raw image is the white image: the noise of the samples' vignetting goes, nothing spreads.
#[test]
fn an_even_sky_becomes_the_white_image() {
    for name in ["lytro-illum", "raytrix-r12-a", "h3dv"] {
        let camera = part(name, GridSize::new(72, 80));
        let white = camera.white_image().expect("a white image");
        let request = Request::new(camera).integrator(Integrator::Direct).samples(4).sky([1.0; 3]);
        let request = request.layers(LayerSet::EMPTY);
        let renderer = renderer(&Scene::default(), 0);
        let error = |rendered: &Rendered| {
            let samples = color(rendered).samples();
            let mut squares = 0.0;
            let mut largest = 0.0f64;
            for ((row, column), &white) in white.indexed_iter() {
                for &value in samples.slice(s![row, column, 0, 0, ..]) {
                    let difference = f64::from(value - white);
                    squares += difference * difference;
                    largest = largest.max(difference.abs());
                }
            }
            ((squares / samples.len() as f64).sqrt(), largest)
        };
        let (plain, _) = error(&renderer.render(&request, &()).expect("a render"));
        let (denoised, largest) = error(&renderer.render(&request.denoise(Denoise::Views), &()).expect("a render"));
        println!("{name}: {plain:.5} of the samples, {denoised:.5} after, at most {largest:.5}");
        // The closed form has an error of 0.01 at most, usually far less. One pixel in ten thousand has samples that are lit
        // by luck where the white image is nearly dark; their part of the mixture is 0.1 at most.
        assert!(denoised < 0.25 * plain + 1e-6 && largest < 0.1, "{name}: {plain} to {denoised}, at most {largest}");
    }
}

/// The estimate alone changes no color, and falls with the samples.
#[test]
fn an_estimate_of_the_error_changes_nothing() {
    let scene = soup(200, 5);
    let renderer = renderer(&scene, 0);
    for name in ["lytro-illum", "raytrix-r12-a"] {
        let camera = part(name, GridSize::new(90, 100));
        let mut medians = Vec::new();
        for samples in [1, 4, 16] {
            let request = Request::new(camera.clone()).integrator(Integrator::Direct).samples(samples);
            let request = request.sky([0.3, 0.5, 0.7]).layers(LayerSet::EMPTY);
            let plain = renderer.render(&request, &()).expect("a render");
            let estimated = renderer.render(&request.estimate_error(true), &()).expect("a render");
            assert!(color(&plain) == color(&estimated), "{name}, {samples} samples");
            let mut error: Vec<f32> = estimated.error.expect("an estimate").samples().iter().copied().collect();
            error.retain(|&error| error > 0.0);
            error.sort_by(f32::total_cmp);
            medians.push(error[error.len() / 2]);
        }
        assert!(medians.windows(2).all(|pair| pair[1] < 0.8 * pair[0]), "{name}: {medians:?}");
    }
}

/// Rows that are rendered alone, with any number of threads, have the bytes of the whole; also in two rounds.
#[test]
fn parts_and_threads_give_the_same_bytes() {
    let scene = soup(120, 3);
    let (one, three) = (renderer(&scene, 1), renderer(&scene, 3));
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows] {
        let mut array = MicrolensArray::new(grid, 25e-6, 140e-6);
        array.rotation_rad = 0.01;
        let camera =
            PlenopticCamera::new(ImageSensor::new(GridSize::new(400, 40), 5e-6), array, MainLens::new(0.05, 5.6, 3.0))
                .expect("a camera");
        let request = Request::new(camera).integrator(Integrator::Path).max_bounces(2).sky([0.3, 0.4, 0.5]);
        let request = request.samples(2).layers(LayerSet::EMPTY).denoise(Denoise::Views).estimate_error(true);
        for request in [request.clone(), request.samples(8).target_error(Some(0.05))] {
            let whole = one.render(&request, &()).expect("a render");
            let again = three.render(&request, &()).expect("a render");
            assert!(color(&whole) == color(&again) && whole.error == again.error, "{grid:?}");
            for rows in [0..17usize, 190..212] {
                let part = three.render(&request.clone().rows(Some(rows.clone())), &()).expect("a part");
                let same = |part: &LightFieldOwned<f32>, whole: &LightFieldOwned<f32>| {
                    let rows = whole.samples().slice_move(s![rows.clone(), .., .., .., ..]).to_owned();
                    part.samples().to_owned() == rows
                };
                assert!(same(color(&part), color(&whole)), "{grid:?} {rows:?}");
                assert!(same(part.error.as_ref().expect("one"), whole.error.as_ref().expect("one")), "{grid:?}");
            }
        }
    }
}

/// With a target there are fewer samples than the maximum, and not fewer than those of the first round. Pixels that need no
/// more keep what they have: the image is nearly that of all samples.
#[test]
fn a_target_saves_samples() {
    let scene = soup(200, 5);
    let renderer = renderer(&scene, 0);
    let request = Request::new(part("lytro-illum", GridSize::new(90, 100))).integrator(Integrator::Direct);
    let request = request.sky([0.3, 0.5, 0.7]).layers(LayerSet::EMPTY).denoise(Denoise::Views).samples(64);
    let rendered = [None, Some(0.2), Some(10.0)]
        .map(|target| renderer.render(&request.clone().target_error(target), &()).expect("a render"));
    let [all, some, few] = [0, 1, 2].map(|k| rendered[k].samples);
    // Rays of dark points of a pixel are not counted.
    assert!(few * 10 < all && few <= some && some < all, "{few} {some} {all}");
    let exact = renderer.render(&request.clone().samples(1024), &()).expect("a render");
    let errors = [0, 1].map(|k| squared_error(&rendered[k], &exact).sqrt());
    println!("samples {few} {some} {all}; off by {errors:.4?}");
    // Twice the error for 29 % of the samples; half of the target.
    assert!(errors[0] < 0.05 && errors[1] < 0.1, "{errors:?}");
}

#[test]
fn depth_alone_is_not_denoised() {
    let camera = part("lytro-illum", GridSize::new(20, 20));
    let request = Request::new(camera).integrator(Integrator::Depth);
    let renderer = renderer(&Scene::default(), 1);
    for request in [request.clone().denoise(Denoise::Views), request.estimate_error(true)] {
        match renderer.render(&request, &()) {
            Err(Error::BadSetting(why)) => assert!(why.contains("needs color"), "{why}"),
            other => panic!("{other:?}"),
        }
    }
}

/// Unusual cameras are reconstructed without panic.
#[test]
fn hard_cameras_are_reconstructed() {
    let scene = soup(40, 7);
    type Change = fn(&mut ImageSensor, &mut MicrolensArray, &mut MainLens);
    let changes: [(&str, Change); 6] = [
        ("rotated by 45 degrees", |_, a, _| a.rotation_rad = std::f64::consts::FRAC_PI_4),
        ("pitch of 2.5 pixels", |_, a, _| {
            (a.pitch_m, a.aperture) = (3.5e-6, LensAperture::Round { radius_m: 1.75e-6 });
        }),
        ("one microlens", |s, a, _| {
            s.size = GridSize::new(9, 9);
            (a.pitch_m, a.aperture) = (1e-3, LensAperture::Round { radius_m: 10e-6 });
        }),
        ("overlap", |_, _, l| l.f_number = 0.7),
        ("a pupil far away", |_, _, l| l.exit_pupil_m = Some(1e6)),
        ("one pixel", |s, _, _| s.size = GridSize::new(1, 1)),
    ];
    for (name, change) in changes {
        let sound = part("lytro-illum", GridSize::new(40, 50));
        let (mut sensor, mut array, mut lens) = (*sound.sensor(), sound.array().clone(), sound.main_lens().clone());
        change(&mut sensor, &mut array, &mut lens);
        let camera = PlenopticCamera::new(sensor, array, lens).unwrap_or_else(|why| panic!("{name}: {why}"));
        let request = Request::new(camera).integrator(Integrator::Direct).samples(2).sky([1.0; 3]);
        let request = request.denoise(Denoise::Views).estimate_error(true);
        let rendered = renderer(&scene, 0).render(&request, &()).expect("a render");
        let error = rendered.error.as_ref().expect("an estimate");
        assert!(color(&rendered).samples().iter().all(|x| x.is_finite() && *x >= 0.0), "{name}");
        assert!(error.samples().iter().all(|x| x.is_finite() && *x >= 0.0), "{name}");
    }
}
