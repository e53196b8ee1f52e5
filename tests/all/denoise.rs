//! Reconstruction across views: less error, the same bytes for parts and threads, no effect where it is off.

use std::num::NonZeroUsize;

use crate::common;
use crate::common::rig;
use holo_core::{GridSize, LightFieldOwned, LightFieldShape, Projection, ViewIndex};
use holo_render::{
    Backend, Denoise, Error, Framing, Integrator, Rendered, Renderer, Request, Reuse, SamplesPerPixel, TextureFilter,
    Views,
};
use holo_scene::gallery;
use ndarray::{ArrayView1, ArrayView3, Axis};

/// A scene of the gallery, 24 x 24 views of 18 x 12 pixels. Points move by up to `movement_px` from view to view.
fn prepared(name: &str, movement_px: f64) -> (Renderer, Request) {
    prepared_as(name, movement_px, GridSize::new(24, 24), GridSize::new(12, 18))
}

fn prepared_as(name: &str, movement_px: f64, views: GridSize, lenses: GridSize) -> (Renderer, Request) {
    let scene = gallery::scene(name).expect("a scene of the gallery");
    let shape = LightFieldShape::new(views, lenses).expect("sizes");
    let framed = Framing::new(shape).frame(&scene).expect("a camera");
    let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, None).expect("a renderer");
    let focus_m = renderer.automatic_focus_m(&framed).expect("a focus");
    let rig = framed.rig(focus_m).expect("a rig");
    let (near_m, _) = renderer.central_depths_m(&rig).expect("depths").expect("something is seen");
    let wanted = movement_px / rig.disparity().from_depth_m(near_m);
    // A single view has no baseline, and nothing moves.
    let baseline_m = if views.count() > 1 { rig.baseline_x_m() * wanted } else { 0.0 };
    let rig = rig.to_builder().baseline_m(baseline_m).build().expect("a rig");
    (renderer, Request::new(rig).integrator(Integrator::Path).max_bounces(3).sky([0.35, 0.45, 0.6]).samples(4))
}

fn color(rendered: &Rendered) -> &LightFieldOwned<f32> {
    rendered.color.as_ref().expect("an image")
}

/// The luminance of each pixel of a view.
fn luminances(view: ArrayView3<f32>) -> Vec<f64> {
    let weights = [0.2126, 0.7152, 0.0722];
    let luminance = |pixel: ArrayView1<f32>| pixel.iter().zip(weights).map(|(&x, weight)| f64::from(x) * weight).sum();
    view.lanes(Axis(2)).into_iter().map(luminance).collect()
}

/// Views at the corners and in the middle.
const VIEWS: [(usize, usize); 5] = [(0, 0), (0, 12), (12, 12), (23, 5), (23, 23)];

/// These views, converged.
fn reference(renderer: &Renderer, request: &Request) -> Rendered {
    let list = VIEWS.map(|(row, column)| ViewIndex { row, column }).to_vec();
    let many = request
        .clone()
        .texture_filter(TextureFilter::Off)
        .samples(1024)
        .seed(99)
        .denoise(Denoise::Off)
        .views(Views::List(list));
    let many = many.estimate_error(false).target_error(None);
    renderer.render(&many, &()).expect("a reference")
}

/// In these views: the mean relative squared error without the worst pixel of a hundred, and the median relative error of the
/// luminance as that of a normal distribution.
fn errors(reference: &Rendered, images: &[&Rendered]) -> Vec<[f64; 2]> {
    let error = |rendered: &&Rendered| {
        let (mut sum, mut relative) = (0.0, Vec::new());
        for (k, &(t, s)) in VIEWS.iter().enumerate() {
            let exact = color(reference).view(0, k).expect("a view");
            let found = color(rendered).view(t, s).expect("a view");
            let bright = exact.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>() / exact.len() as f64;
            let pairs = exact.iter().zip(found).map(|(&exact, &found)| (f64::from(exact), f64::from(found)));
            relative.extend(
                luminances(exact).into_iter().zip(luminances(found)).map(|(exact, found)| (found / exact - 1.0).abs()),
            );
            let mut errors: Vec<f64> =
                pairs.map(|(exact, found)| (found - exact).powi(2) / (exact * exact + 0.01 * bright)).collect();
            errors.sort_by(f64::total_cmp);
            errors.truncate(errors.len() * 99 / 100);
            sum += errors.iter().sum::<f64>() / errors.len() as f64;
        }
        relative.sort_by(f64::total_cmp);
        [sum / VIEWS.len() as f64, relative[relative.len() / 2] / 0.6745]
    };
    images.iter().map(error).collect()
}

/// Grass, glass and plaster: a tenth of the squared error or less where views nearly agree, less where points move by a third
/// of a pixel; and the estimated error is that of the image.
#[test]
fn neighboring_views_take_the_noise_away() {
    // Textures unfiltered, as the reconstruction takes them.
    for (name, movement_px, gain) in
        [("plaster", 0.01, 60.0), ("glasses", 0.01, 30.0), ("garden", 0.01, 30.0), ("garden", 0.3, 1.8)]
    {
        let (renderer, request) = prepared(name, movement_px);
        let plain = renderer
            .render(&request.clone().texture_filter(TextureFilter::Off).reuse(Reuse::Off), &())
            .expect("a render");
        let denoised = request.clone().denoise(Denoise::Views).estimate_error(true);
        let rendered = renderer.render(&denoised, &()).expect("a render");
        let reference = reference(&renderer, &request);
        let [[before, _], [after, typical]] = errors(&reference, &[&plain, &rendered])[..] else {
            panic!("two images")
        };
        println!("{name}, {movement_px} px: {before:.5} to {after:.6}, gain {:.0}", before / after);
        assert!(before / after > gain, "{name}, {movement_px} px: {before} to {after}");
        let error = rendered.error.as_ref().expect("an estimate");
        let mut estimated: Vec<f32> = error.samples().iter().copied().collect();
        estimated.sort_by(f32::total_cmp);
        let estimated = f64::from(estimated[estimated.len() / 2]);
        assert!((0.5..2.0).contains(&(estimated / typical)), "{name}: estimated {estimated}, is {typical}");
        // The mean brightness stays: what is averaged is not clipped.
        let mean = |rendered: &LightFieldOwned<f32>| {
            rendered.samples().iter().map(|&x| f64::from(x)).sum::<f64>() / rendered.samples().len() as f64
        };
        let ratio = mean(color(&rendered)) / mean(color(&plain));
        assert!((ratio - 1.0).abs() < 3e-3, "{name}: {ratio}");
    }
}

/// The mean square of what changes fastest: along the rows of every view the upper half of the frequencies, and between
/// neighboring views. Of a row of views.
fn detail(row: &[ndarray::Array3<f32>]) -> [f64; 2] {
    let (mut fine, mut between) = (0.0, 0.0);
    for view in row {
        let (height, width, channels) = view.dim();
        for (v, c) in (0..height).flat_map(|v| (0..channels).map(move |c| (v, c))) {
            for k in width.div_ceil(4)..=width / 2 {
                let turn = std::f64::consts::TAU * k as f64 / width as f64;
                let along = |wave: fn(f64) -> f64| -> f64 {
                    (0..width).map(|u| f64::from(view[[v, u, c]]) * wave(turn * u as f64)).sum()
                };
                fine += (along(f64::cos).powi(2) + along(f64::sin).powi(2)) / width as f64;
            }
        }
    }
    for pair in row.windows(2) {
        between += (&pair[1] - &pair[0]).iter().map(|&step| f64::from(step).powi(2)).sum::<f64>();
    }
    [fine / row.len() as f64, between / (row.len() - 1) as f64]
}

/// Reconstructed views are as sharp as converged ones, which the power at the highest frequencies tells: a blur would take
/// it away (0.94 and more is left), and noise would add to it (0.97 at most, where the plain samples have 2 to 13 times as
/// much). Between neighboring views the noise flickers a tenth as much as that of the samples, or less. The bounds are a
/// little wider than these measurements.
#[test]
fn reconstructed_views_are_as_sharp_as_converged_ones() {
    for (name, movement_px) in [("tiles", 0.3), ("chess", 0.05), ("garden", 0.3)] {
        let (renderer, request) = prepared(name, movement_px);
        let request = request.texture_filter(TextureFilter::Off);
        let columns = 6..18;
        let list = columns.clone().map(|column| ViewIndex { row: 12, column }).collect();
        let many = request.clone().samples(1024).seed(99).reuse(Reuse::Off).views(Views::List(list));
        let converged = renderer.render(&many, &()).expect("a reference");
        let plain = renderer.render(&request.clone().reuse(Reuse::Off), &()).expect("a render");
        let denoised = renderer.render(&request.denoise(Denoise::Views), &()).expect("a render");
        let row = |rendered: &Rendered, row: usize, columns: std::ops::Range<usize>| -> Vec<_> {
            columns.map(|column| color(rendered).view(row, column).expect("a view").to_owned()).collect()
        };
        let converged = detail(&row(&converged, 0, 0..columns.len()));
        let [plain, denoised] = [&plain, &denoised].map(|rendered| {
            let found = detail(&row(rendered, 12, columns.clone()));
            [found[0] / converged[0], found[1] / converged[1]]
        });
        println!("{name}, {movement_px} px: {plain:.3?} to {denoised:.3?} of the converged views");
        assert!((0.93..1.1).contains(&denoised[0]), "{name}: the highest frequencies are {} of those", denoised[0]);
        assert!(denoised[1] < plain[1] / 8.0, "{name}: from view to view {} to {}", plain[1], denoised[1]);
    }
}

/// The estimate alone changes no color; and it falls with the samples.
#[test]
fn an_estimate_of_the_error_changes_nothing() {
    let (renderer, request) = prepared("chess", 0.02);
    let mut medians = Vec::new();
    for samples in [2, 8] {
        let request = request.clone().samples(samples);
        let plain = renderer.render(&request, &()).expect("a render");
        let estimated = renderer.render(&request.estimate_error(true), &()).expect("a render");
        assert!(color(&plain) == color(&estimated), "{samples} samples");
        assert!(plain.error.is_none());
        let mut error: Vec<f32> = estimated.error.expect("an estimate").samples().iter().copied().collect();
        error.sort_by(f32::total_cmp);
        medians.push(error[error.len() / 2]);
    }
    // Independent samples would halve the error.
    assert!(medians[1] < 0.6 * medians[0], "{medians:?}");
}

/// Lens rows that are rendered alone, with any number of threads, have the bytes of the whole.
#[test]
fn parts_have_the_bytes_of_the_whole() {
    let scene = common::soup(80, 3);
    let renderer = |threads| {
        Renderer::new(&scene, &holo_scene::Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(threads))
            .expect("a renderer")
    };
    let (one, three) = (renderer(1), renderer(3));
    // Elemental images as tiles; rows of microlenses as tiles, with points that move by several pixels.
    for (views, lenses, baseline_m) in [([70, 70], [22, 3], 0.0005), ([4, 5], [60, 40], 0.03)] {
        let rig = rig(views, lenses, baseline_m, 3.0, Projection::Perspective);
        let request = Request::new(rig).sky([0.3, 0.4, 0.5]).samples(2).max_bounces(2);
        let request = request.denoise(Denoise::Views).estimate_error(true);
        assert_same_parts(&one, &three, &request);
        for pixels in [4, 64] {
            assert_same_parts(&one, &three, &request.clone().samples(one_in(pixels)));
        }
        // In rounds.
        assert_same_parts(&one, &three, &request.samples(8).target_error(Some(0.05)));
    }
}

fn one_in(pixels: u32) -> SamplesPerPixel {
    SamplesPerPixel::one_in(pixels).expect("a power of two")
}

/// With one sample in 4 or 16 pixels the image is that of the scene: a fourth, an eighth of the squared error that one sample
/// in every pixel leaves, and no brighter.
#[test]
fn few_pixels_need_samples() {
    let (renderer, request) = prepared("plaster", 0.01);
    let reference = reference(&renderer, &request);
    let plain = request.clone().samples(1).texture_filter(TextureFilter::Off);
    let plain = renderer.render(&plain, &()).expect("a render");
    for (pixels, gain) in [(4, 8.0), (16, 4.0)] {
        let few = request.clone().denoise(Denoise::Views).estimate_error(true).samples(one_in(pixels));
        let rendered = renderer.render(&few, &()).expect("a render");
        let traced = 24 * 24 * 18 * 12 / u64::from(pixels);
        // Blocks of views at the edges are smaller.
        assert!(rendered.samples.abs_diff(traced) < traced / 5, "{} instead of {traced}", rendered.samples);
        let [[before, _], [after, typical]] = errors(&reference, &[&plain, &rendered])[..] else {
            panic!("two images")
        };
        println!("1/{pixels}: {before:.5} to {after:.6}, gain {:.1}", before / after);
        assert!(before / after > gain, "1/{pixels}: {before} to {after}");
        let mut estimated: Vec<f32> = rendered.error.expect("an estimate").samples().iter().copied().collect();
        estimated.sort_by(f32::total_cmp);
        let estimated = f64::from(estimated[estimated.len() / 2]);
        // The points of a packet are better distributed than independent ones, as which they are counted.
        assert!((0.5..2.5).contains(&(estimated / typical)), "1/{pixels}: estimated {estimated}, is {typical}");
    }
}

/// One pixel in 16 has a sample: behind most microlenses of few views there is none. No pixel stays dark for that; most have
/// the light of four samples of their own to a half.
#[test]
fn few_samples_of_few_views_leave_no_holes() {
    for views in [1, 3, 9] {
        let (renderer, request) = prepared_as("garden", 1.0, GridSize::new(views, views), GridSize::new(40, 60));
        let rendered = |request: &Request| renderer.render(request, &()).expect("a render");
        let plain = rendered(&request);
        let few = rendered(&request.denoise(Denoise::Views).samples(one_in(16)));
        let luminances = |rendered: &Rendered| -> Vec<f64> {
            let pixels = color(rendered).samples();
            let weights = [0.2126, 0.7152, 0.0722];
            pixels
                .lanes(Axis(4))
                .into_iter()
                .map(|pixel| pixel.iter().zip(weights).map(|(&x, weight)| f64::from(x) * weight).sum())
                .collect()
        };
        let (plain, few) = (luminances(&plain), luminances(&few));
        let mean = plain.iter().sum::<f64>() / plain.len() as f64;
        let lit: Vec<f64> =
            plain.iter().zip(&few).filter(|&(&plain, _)| plain > 0.1 * mean).map(|(plain, few)| few / plain).collect();
        let share = |is: &dyn Fn(f64) -> bool| lit.iter().filter(|&&ratio| is(ratio)).count() as f64 / lit.len() as f64;
        let (dark, alike) = (share(&|ratio| ratio < 0.02), share(&|ratio| (0.5..2.0).contains(&ratio)));
        println!("{views} x {views} views: {dark:.4} dark, {alike:.3} alike");
        assert!(dark < 0.01, "{views} x {views} views: {dark} of the pixels are dark");
        assert!(alike > 0.5, "{views} x {views} views: {alike} of the pixels are alike");
    }
}

#[test]
fn fractions_need_shared_samples() {
    let (renderer, request) = prepared("plaster", 0.01);
    for pixels in [2, 64] {
        match renderer.render(&request.clone().samples(one_in(pixels)), &()) {
            Err(Error::BadSetting(why)) => assert!(why.contains(&format!("1/{pixels} samples per pixel")), "{why}"),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!([0, 1, 3, 128].map(SamplesPerPixel::one_in), [None; 4]);
}

fn assert_same_parts(one: &Renderer, three: &Renderer, request: &Request) {
    let whole = one.render(request, &()).expect("a render");
    let again = three.render(request, &()).expect("a render");
    assert!(color(&whole) == color(&again) && whole.error == again.error);
    let mut rows = 0;
    let parts = 2;
    for part in 0..parts {
        let range = one.shard_rows(request, part, parts).expect("a part");
        let rendered = three.render(&request.clone().rows(Some(range.clone())), &()).expect("a render");
        let same = |part: &LightFieldOwned<f32>, whole: &LightFieldOwned<f32>| {
            assert_eq!(part.shape().lenses().rows, range.len());
            let rows = whole.samples().slice_move(ndarray::s![range.clone(), .., .., .., ..]).to_owned();
            part.samples().to_owned() == rows
        };
        assert!(same(color(&rendered), color(&whole)), "{range:?}");
        assert!(same(rendered.error.as_ref().expect("an estimate"), whole.error.as_ref().expect("one")), "{range:?}");
        rows += range.len();
    }
    assert_eq!(rows, request.camera.rig().expect("a rig").shape().lenses().rows);
}

/// With a target every pixel has at most that error, as estimated, or all samples; the error is the one after the
/// reconstruction, so few samples are enough; and pixels that need more get more.
#[test]
fn samples_are_added_until_the_reconstructed_error_meets_the_target() {
    let (renderer, request) = prepared("chess", 0.01);
    let reference = reference(&renderer, &request);
    let request = request.denoise(Denoise::Views).estimate_error(true);
    let pixels = 24 * 24 * 18 * 12;
    let mut before = 0;
    for (target, most) in [(0.2, 64), (0.05, 64), (0.02, 32)] {
        let rendered =
            renderer.render(&request.clone().samples(most).target_error(Some(target)), &()).expect("a render");
        let (all, samples) = (u64::from(most) * pixels, rendered.samples);
        assert!(16 * samples >= pixels && samples > before && samples < all, "{target}: {samples} of {all}");
        before = samples;
        let [[squared, relative]] = errors(&reference, &[&rendered])[..] else { panic!("one image") };
        assert!(relative < 1.5 * target, "{target}: {relative}, squared {squared}");
        let error = rendered.error.expect("an estimate");
        let exceeding = error.samples().iter().filter(|&&error| f64::from(error) > target).count() as f64;
        // What exceeds it has all samples, and the mean number of samples says how many pixels may.
        let most_exceeding = samples as f64 / f64::from(most);
        assert!(exceeding <= most_exceeding, "{target}: {exceeding} pixels of {samples} samples");
    }
    // A target that the first samples meet leaves them as they are.
    let [few, many] = [4, 64].map(|samples| {
        let request = request.clone().samples(samples).target_error(Some(10.0));
        renderer.render(&request, &()).expect("a render")
    });
    // One pixel of 16, about, as the last packets have fewer views.
    assert!(few.samples == many.samples && (14 * few.samples..18 * few.samples).contains(&pixels), "{}", few.samples);
}

#[test]
fn lists_of_views_and_depth_are_not_denoised() {
    let (renderer, request) = prepared("plaster", 0.01);
    let list = request.views(Views::List(vec![ViewIndex { row: 1, column: 2 }]));
    let depth = list.clone().views(Views::All).integrator(Integrator::Depth);
    for (request, expected) in [(list, "all views"), (depth, "needs color")] {
        for request in [request.clone().denoise(Denoise::Views), request.estimate_error(true)] {
            match renderer.render(&request, &()) {
                Err(Error::BadSetting(why)) => assert!(why.contains(expected), "{why}"),
                other => panic!("{other:?}"),
            }
        }
    }
}
