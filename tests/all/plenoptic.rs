//! Raw images of plenoptic cameras against closed forms: white images, the ideal rig, points of light, planes.

use std::num::NonZeroUsize;

use crate::common::{add, engines, ideal, soup, square};
use holo_core::GridSize;
use holo_core::plenoptic::{
    ArrayFocus, ImageSensor, LensAperture, MainLens, Medium, MicrolensArray, MicrolensGrid, Objective, PlenopticCamera,
    Prescription, Preset, PupilShape, Stop, Surface,
};
use holo_render::{Backend, Integrator, Layer, LayerSet, Rendered, Renderer, Request};
use holo_scene::{Material, Scene, Transform};
use ndarray::{Array2, Array3, s};

fn render(scene: &Scene, request: &Request, threads: usize) -> Rendered {
    let renderer =
        Renderer::new(scene, &Transform::IDENTITY, Backend::Auto, NonZeroUsize::new(threads)).expect("a renderer");
    renderer.render(request, &()).expect("a render")
}

/// A part of a preset's sensor, `offset_m` from its axis.
fn part(name: &str, size: GridSize, offset_m: [f64; 2]) -> PlenopticCamera {
    let whole = Preset::by_name(name).expect("a preset").camera().expect("a camera");
    let (mut sensor, mut array) = (*whole.sensor(), whole.array().clone());
    array.offset_m = [0, 1].map(|k| array.offset_m[k] - offset_m[k]);
    (sensor.size, sensor.offset_m) = (size, offset_m);
    PlenopticCamera::new(sensor, array, whole.main_lens().clone()).expect("a camera")
}

/// The same behind an objective of glass, focused at 1.5 m.
fn behind_glass(camera: &PlenopticCamera, objective: &str) -> PlenopticCamera {
    let lens = Objective::by_name(objective).expect("an objective").prescription().expect("a lens");
    let focus = ArrayFocus::Depth { depth_m: 1.5, virtual_depth: 0.0 };
    let lens = MainLens::of_glass(lens, focus);
    PlenopticCamera::new(*camera.sensor(), camera.array().clone(), lens).expect("a camera")
}

/// The raw image: a light field of one view.
fn raw(rendered: &Rendered) -> Array3<f32> {
    rendered.color.as_ref().expect("color").to_elemental_grid().expect("memory")
}

/// The first channel.
fn red(rendered: &Rendered) -> Array2<f32> {
    raw(rendered).slice(s![.., .., 0]).to_owned()
}

/// A sky of radiance 1 gives the white image: for round, square and hexagonal shapes, masked ones too, at the center and
/// far from it.
#[test]
fn a_bright_sky_gives_the_white_image() {
    let size = GridSize::new(72, 80);
    let mut hexagon = part("raytrix-r12-a", size, [0.0; 2]);
    let (mut array, mut lens) = (hexagon.array().clone(), hexagon.main_lens().clone());
    (array.aperture, lens.aperture) = (LensAperture::Hexagon { half_width_m: 60e-6 }, PupilShape::Square);
    hexagon = PlenopticCamera::new(*hexagon.sensor(), array, lens).expect("a camera");
    let with = |camera: PlenopticCamera, change: &dyn Fn(&mut MicrolensArray, &mut MainLens)| {
        let (mut array, mut lens) = (camera.array().clone(), camera.main_lens().clone());
        change(&mut array, &mut lens);
        PlenopticCamera::new(*camera.sensor(), array, lens).expect("a camera")
    };
    let blades = with(part("lytro-illum", size, [0.0; 2]), &|_, lens| {
        lens.aperture = PupilShape::Polygon { blades: 7, rotation_rad: 0.2 };
    });
    let gaps = with(part("lytro-illum", size, [0.0; 2]), &|array, _| {
        (array.aperture, array.has_clear_gaps) = (LensAperture::Round { radius_m: 8e-6 }, true);
    });
    let real = with(part("raytrix-r12-a", size, [4e-3, 3e-3]), &|array, lens| {
        array.tilt_rad = [8e-3, -6e-3];
        lens.distortion.radial = [-120.0, 0.0, 0.0];
        lens.stops = vec![Stop { distance_m: 0.06, diameter_m: 0.0165 }];
    });
    // Microlens (0, 0) in the dark behind the rim of the lens, light at one edge of the sensor.
    let (array, mut sensor) =
        (MicrolensArray::new(MicrolensGrid::Square, 280e-6, 800e-6), ImageSensor::new(size, 50e-6));
    sensor.offset_m = [22e-3, 9e-3];
    let far = PlenopticCamera::new(sensor, array, MainLens::new(0.05, 4.0, 1.5)).expect("a camera");
    let far = behind_glass(&far, "double-gauss");
    for (name, camera) in [
        ("illum", part("lytro-illum", size, [0.0; 2])),
        ("illum, corner", part("lytro-illum", size, [5e-3, -3.5e-3])),
        ("r12", part("raytrix-r12-a", size, [8e-3, 6e-3])),
        ("square", part("h3dv", size, [0.0; 2])),
        ("hexagon and square", hexagon),
        ("seven blades", blades),
        ("clear gaps", gaps),
        ("tilt, distortion and a stop", real),
        ("double Gauss", behind_glass(&part("raytrix-r12-a", size, [0.0; 2]), "double-gauss")),
        ("double Gauss, corner", behind_glass(&part("h3dv", size, [9e-3, 8e-3]), "double-gauss")),
        ("double Gauss, far from the axis", far),
        ("retrofocus, corner", behind_glass(&part("lytro-illum", size, [9e-3, 6e-3]), "retrofocus")),
        ("telephoto", behind_glass(&part("lytro-illum", size, [3e-3, 2e-3]), "telephoto")),
    ] {
        let white = camera.white_image().expect("memory");
        let camera_has_glass = camera.has_glass();
        let request = Request::new(camera).integrator(Integrator::Direct).samples(256).sky([1.0; 3]);
        let raw = red(&render(&Scene::default(), &request.layers(LayerSet::EMPTY), 0));
        let total = |image: &Array2<f32>| image.iter().map(|&x| f64::from(x)).sum::<f64>();
        let worst = raw.iter().zip(&white).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        println!("{name}: {:.6} of the light, worst pixel off by {worst:.4}", total(&raw) / total(&white));
        // Errors of pixels are independent: the sum of their squares is the variance of the total. The white image has an
        // error of its own, of its quadrature; that of gaps is a sum over 128 points.
        let squares: f64 = raw.iter().zip(&white).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let standard_error = squares.sqrt() / total(&white);
        let (own, worst_bound) = match name {
            "clear gaps" => (1e-3, 0.1),
            "tilt, distortion and a stop" => (3e-4, 0.13),
            // The edge of the light is that of a table, and rays that the glass stops were sampled.
            _ if camera_has_glass => (1.5e-3, 0.16),
            _ => (3e-4, 0.08),
        };
        let error = (total(&raw) / total(&white) - 1.0).abs();
        assert!(standard_error < 5e-4 && error < 3.0 * standard_error + own, "{name}: {error} {standard_error}");
        // 256 samples of a pixel that an edge crosses are off by 1/16 at most, of a rectangle around a lit region by a
        // little more. The light of gaps has edges everywhere.
        assert!(worst < worst_bound, "{name}: {worst}");
        // Where the white image is dark, no sample brings light; behind a stop less than a point of the sum.
        let dark = if name.ends_with("stop") || camera_has_glass { 2.0 / 128.0 } else { 0.01 };
        assert!(raw.iter().zip(&white).all(|(raw, white)| *white > 0.0 || *raw < dark), "{name}");
    }
}

#[test]
fn the_limit_of_point_pixels_is_the_ideal_rig() {
    let scene = soup(400, 3);
    let (camera, rig) = ideal(5, [21, 31]);
    let layers = LayerSet::ALL;
    let request = Request::new(rig).integrator(Integrator::Direct).samples(64).sky([0.5, 0.7, 1.0]).layers(layers);
    let expected = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a renderer");
    let expected = expected.render(&request.ground_truth(holo_render::GroundTruth::All), &()).expect("a render");
    let white = camera.white_image().expect("memory");
    let raw = Request::new(camera).integrator(Integrator::Direct).samples(64).sky([0.5, 0.7, 1.0]).layers(layers);
    let raw = render(&scene, &raw, 0);
    let all = expected.all.expect("all views");
    for layer in layers.iter() {
        let grid: Array3<f32> = all[layer].to_elemental_grid().expect("memory");
        let found = &raw.central[layer];
        assert_eq!(grid.dim(), found.dim());
        // The same ray in f64, up to its last digits: of those that hit an edge another triangle.
        let differ =
            grid.iter().zip(found).filter(|(a, b)| a != b && (*a - *b).abs() > 2e-6 * a.abs().max(1.0)).count();
        assert!(differ * 2000 < grid.len(), "{layer}: {differ} of {}", grid.len());
    }
    let grid = expected.color.expect("color").to_elemental_grid().expect("memory");
    let color = self::raw(&raw);
    // The light of a pixel differs by the noise of 64 samples; its mean by that of all of them.
    let (mut sums, mut squared) = ([0.0; 2], 0.0);
    for ((row, column, c), &expected) in grid.indexed_iter() {
        let found = f64::from(color[[row, column, c]] / white[[row, column]]);
        (sums[0], sums[1]) = (sums[0] + f64::from(expected), sums[1] + found);
        squared += (found - f64::from(expected)).powi(2);
    }
    let count = grid.len() as f64;
    let rms = (squared / count).sqrt();
    println!("mean {:.5} and {:.5}, difference of pixels {rms:.4}", sums[0] / count, sums[1] / count);
    assert!((sums[1] / sums[0] - 1.0).abs() < 1e-3, "{sums:?}");
    assert!(rms < 0.15 * sums[0] / count, "{rms}");
}

/// The same bytes for any number of threads, and for a part of the rows.
#[test]
fn threads_and_parts_change_nothing() {
    let scene = soup(200, 5);
    let size = GridSize::new(90, 120);
    let cameras = ["lytro-illum", "raytrix-r12-a"].map(|name| (name, part(name, size, [1e-3, 0.0])));
    let glass = behind_glass(&part("raytrix-r12-a", size, [5e-3, 4e-3]), "double-gauss");
    for (name, camera) in cameras.into_iter().chain([("glass", glass)]) {
        let request = Request::new(camera).integrator(Integrator::Path).samples(3).sky([0.3, 0.5, 0.7]);
        let one = render(&scene, &request, 1);
        let three = render(&scene, &request, 3);
        assert_eq!(raw(&one), raw(&three), "{name}");
        assert_eq!(one.central, three.central, "{name}");
        let part = render(&scene, &request.clone().rows(Some(37..61)), 0);
        let rows = |image: &Array3<f32>| image.slice(s![37..61, .., ..]).to_owned();
        assert_eq!(raw(&part), rows(&raw(&one)), "{name}");
        for (layer, image) in part.central.iter() {
            assert_eq!(image, rows(&one.central[layer]), "{name} {layer}");
        }
    }
}

/// A small square light: its spot lies at the chief pixel of every microlens, and all spots together have its light.
#[test]
fn points_of_light_arrive_where_the_closed_form_says() {
    for (name, depth, half) in [("lytro-illum", 0.62f32, 2e-4f32), ("raytrix-r12-a", 0.3, 2e-4)] {
        let camera = part(name, GridSize::new(150, 150), [0.0; 2]);
        let mut scene = Scene::default();
        let pose = Transform::from_translation([3e-4, -2e-4, -f64::from(depth)]);
        add(&mut scene, square(half), [0.0, 0.0, 0.0, 1.0], pose);
        let material = scene.materials.last_mut().expect("a material");
        *material = Material { emission: [1.0; 3], double_sided: true, ..material.clone() };
        let request = Request::new(camera.clone()).integrator(Integrator::Direct).samples(1024);
        let raw = red(&render(&scene, &request.layers(LayerSet::EMPTY), 0));
        let white = camera.white_image().expect("memory");
        let mut seen = 0;
        for line in camera.lens_lines(0..150) {
            for lens in camera.lenses_on_line(line, 0..150) {
                let point = camera.project([3e-4, -2e-4, -f64::from(depth)], lens).expect("in front");
                // The microlens is lit whole: the rays through its edge pass the pupil. The image of the light and its blur
                // lie on the sensor, and where this microlens is the nearest.
                let (center, place) = (camera.lens_center_m(lens), camera.place_m(point.position_px));
                let is_lit = (0..32).all(|k| {
                    let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 16.0).sin_cos();
                    let edge = [cos, sin].map(|x| x * 1.02 * camera.array().aperture.half_width_m());
                    let q = [center[0] + edge[0], center[1] + edge[1]];
                    let x = [0, 1].map(|k| place[k] + point.kappa * edge[k]);
                    let out = [0, 1].map(|k| place[k] + 1.5 * point.kappa * edge[k] + 2.0 * edge[k].signum() * 1e-6);
                    camera.ray(x, q, lens).is_some_and(|ray| camera.passes(&ray)) && camera.owner(out) == lens
                });
                let is_inside = point.position_px.iter().all(|&x| (12.0..138.0).contains(&x));
                if !is_lit || !is_inside {
                    continue;
                }
                let (mut sum, mut moments) = (0.0, [0.0; 2]);
                for (row, columns) in camera.lit_pixels(&camera.microlens(lens), 0..150) {
                    for column in columns {
                        let at = [column as f64 + 0.5, row as f64 + 0.5];
                        if camera.owner(camera.place_m(at)) != lens || white[[row, column]] == 0.0 {
                            continue;
                        }
                        let light = f64::from(raw[[row, column]]);
                        sum += light;
                        (0..2).for_each(|k| moments[k] += light * at[k]);
                    }
                }
                if sum > 0.05 {
                    let centroid = moments.map(|moment| moment / sum);
                    let off = (centroid[0] - point.position_px[0]).hypot(centroid[1] - point.position_px[1]);
                    println!("{name} {lens:?}: {off:.4} px off, {sum:.3} light");
                    // The noise of the samples, and the cos^4 law, which prefers rays that arrive steeply.
                    assert!(off < 0.1, "{name} {lens:?}: {centroid:?} {point:?}");
                    seen += 1;
                }
            }
        }
        assert!(seen > 0, "{name}: no spot lies within a micro-image");
    }
}

/// All the light of a small square that enters the pupil arrives, where microlenses leave no gap.
#[test]
fn the_energy_of_a_light_arrives() {
    let slow = part("hahne-arri", GridSize::new(240, 240), [0.0; 2]);
    let mut array = slow.array().clone();
    array.aperture = LensAperture::Square { half_width_m: array.pitch_m / 2.0 };
    let camera = PlenopticCamera::new(*slow.sensor(), array, slow.main_lens().clone()).expect("a camera");
    let (depth, half) = (3.6, 1.5e-3f64);
    let mut scene = Scene::default();
    let pose = Transform::from_translation([1e-3, 2e-3, -depth]);
    add(&mut scene, square(half as f32), [0.0, 0.0, 0.0, 1.0], pose);
    let material = scene.materials.last_mut().expect("a material");
    *material = Material { emission: [1.0; 3], double_sided: true, ..material.clone() };
    let request = Request::new(camera.clone()).integrator(Integrator::Direct).samples(1024);
    let raw = red(&render(&scene, &request.layers(LayerSet::EMPTY), 0));
    // Irradiance of value 1: A_lens cos^4 / d^2.
    let (pixel, gap) = (camera.sensor().pixel_m, camera.array().gap_m);
    let unit = camera.array().aperture.area_m2() * camera.central_cos4() / (gap * gap);
    let arrived = raw.iter().map(|&x| f64::from(x)).sum::<f64>() * unit * pixel * pixel;
    let pupil = std::f64::consts::PI * camera.entrance_pupil_radius_m().powi(2);
    let entered = (2.0 * half).powi(2) * pupil / (depth * depth);
    println!("{:.5} of the light arrives", arrived / entered);
    // At f/22 the cosines of all angles differ from 1 by less than 6e-4.
    assert!((arrived / entered - 1.0).abs() < 2e-3, "{arrived} {entered}");
}

/// Statistics of the samples are those of rays through many random points of pixel and microlens.
#[test]
fn statistics_are_those_of_many_rays() {
    let camera = part("raytrix-r12-a", GridSize::new(40, 48), [2e-3, 1e-3]);
    let mut scene = Scene::default();
    // A plane that ends within the image, and nothing beside it.
    let middle = camera.place_m([24.0, 20.0]);
    let ray =
        camera.ray(middle, camera.lens_center_m(camera.owner(middle)), camera.owner(middle)).expect("a thin lens");
    let [cx, cy] = [0, 1].map(|k| ray.origin_m[k] + 0.6 * ray.direction[k] - 0.02);
    add(&mut scene, square(0.02), [0.5, 0.5, 0.5, 1.0], Transform::from_translation([cx, cy, -0.6]));
    let request = Request::new(camera.clone()).integrator(Integrator::Direct).sky([1.0; 3]).samples(1024);
    let rendered = render(&scene, &request.layers(LayerSet::EMPTY).statistics(true), 0);
    let statistics = rendered.statistics.expect("statistics");
    let mut numbers = 1u64;
    let mut next = || {
        numbers = numbers.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (numbers >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut partly = 0;
    for (row, column) in (0..40).step_by(3).flat_map(|row| (0..48).step_by(3).map(move |column| (row, column))) {
        let (mut weight, mut hits) = (0.0, 0.0);
        let owner = camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5]));
        for _ in 0..4096 {
            let x = camera.place_m([column as f64 + next(), row as f64 + next()]);
            for (dr, dc) in (-1..=1).flat_map(|dr| (-1..=1).map(move |dc| (dr, dc))) {
                let index = holo_core::plenoptic::MicrolensIndex { row: owner.row + dr, column: owner.column + dc };
                let lens = camera.microlens(index);
                let radius = camera.array().aperture.half_width_m();
                let point = [(2.0 * next() - 1.0) * radius, (2.0 * next() - 1.0) * radius];
                let on_sensor = [x[0] - lens.image_center_m[0], x[1] - lens.image_center_m[1]];
                let ray = camera.relative_ray(&lens, on_sensor, point).expect("a thin lens");
                if point[0].hypot(point[1]) > radius || !camera.passes(&ray) {
                    continue;
                }
                let light = camera.relative_cos4(&lens, on_sensor, point);
                let [px, py] = [0, 1].map(|k| ray.origin_m[k] + 0.6 * ray.direction[k]);
                weight += light;
                hits += if (px - cx).abs() <= 0.02 && (py - cy).abs() <= 0.02 { light } else { 0.0 };
            }
        }
        let found = |image: &Array2<f32>| f64::from(image[[row, column]]);
        if weight < 40.0 {
            continue;
        }
        let part = hits / weight;
        partly += usize::from(part > 0.05 && part < 0.95);
        // Three standard errors of both: of `weight` random rays, and of 1024 stratified ones, which are taken for random.
        let error = 3.0 * (0.25 / weight + 0.25 / 1024.0).sqrt();
        assert!((found(&statistics.coverage) - part).abs() < error, "{row} {column}: {part}");
        assert!((found(&statistics.inverse_depth_mean) - part / 0.6).abs() < error / 0.6, "{row} {column}");
        let deviation = (part * (1.0 - part)).sqrt() / 0.6;
        // The slope of the root at a part p is (1 - 2 p) / (2 root).
        let bound = (error + (error * error + error * 2.0).sqrt()) / 0.6;
        assert!((found(&statistics.inverse_depth_deviation) - deviation).abs() < bound, "{row} {column}");
    }
    assert!(partly > 3, "{partly} pixels see the edge");
}

/// Chief rays to a plane: depth, length and disparity are closed forms.
#[test]
fn chief_rays_have_the_truth_of_a_plane() {
    let mut scene = Scene::default();
    add(&mut scene, square(10.0), [0.5, 0.5, 0.5, 1.0], Transform::from_translation([0.0, 0.0, -2.0]));
    for backend in engines() {
        let camera = part("lytro-illum", GridSize::new(60, 61), [4e-3, 2e-3]);
        let request = Request::new(camera.clone()).integrator(Integrator::Depth).layers(LayerSet::ALL);
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, backend, None).expect("a renderer");
        let rendered = renderer.render(&request, &()).expect("a render");
        assert!(rendered.color.is_none());
        let views = camera.equivalent_views();
        let disparity = views.baseline_m / views.slope_per_lens * (0.5 - views.inverse_focus_per_m);
        for row in 0..60 {
            for column in 0..61 {
                let place = camera.place_m([column as f64 + 0.5, row as f64 + 0.5]);
                let lens = camera.owner(place);
                let ray = camera.ray(place, camera.lens_center_m(lens), lens).expect("a thin lens");
                let length = 2.0 * (1.0 + ray.direction[0].powi(2) + ray.direction[1].powi(2)).sqrt();
                let found = |layer: Layer| f64::from(rendered.central[layer][[row, column, 0]]);
                assert!((found(Layer::Depth) - 2.0).abs() < 1e-6);
                assert!((found(Layer::RayLength) - length).abs() < 1e-6);
                assert!((found(Layer::Disparity) - disparity).abs() < 1e-6 * disparity.abs());
                assert_eq!(found(Layer::HitMask), 1.0);
            }
        }
    }
}

/// Unusual cameras render without panic: few and many microlenses, overlap, tiny sensors, odd distances.
#[test]
fn hard_cameras_are_rendered() {
    let scene = soup(40, 7);
    type Change = fn(&mut ImageSensor, &mut MicrolensArray, &mut MainLens);
    let changes: [(&str, Change); 8] = [
        ("rotated by 45 degrees", |_, a, _| a.rotation_rad = std::f64::consts::FRAC_PI_4),
        ("pitch of 2.5 pixels", |_, a, _| {
            (a.pitch_m, a.aperture) = (3.5e-6, LensAperture::Round { radius_m: 1.75e-6 });
        }),
        ("one microlens", |s, a, _| {
            s.size = GridSize::new(9, 9);
            (a.pitch_m, a.aperture) = (1e-3, LensAperture::Round { radius_m: 10e-6 });
        }),
        ("overlap", |_, _, l| l.f_number = 0.7),
        ("focused at infinity", |_, _, l| l.focus = ArrayFocus::Depth { depth_m: f64::INFINITY, virtual_depth: 0.0 }),
        ("focused beyond infinity", |_, _, l| l.focus = ArrayFocus::Depth { depth_m: -2.0, virtual_depth: 0.0 }),
        ("a pupil far away", |_, _, l| l.exit_pupil_m = Some(1e6)),
        ("one pixel", |s, _, _| s.size = GridSize::new(1, 1)),
    ];
    for (name, change) in changes {
        let sound = part("lytro-illum", GridSize::new(40, 50), [0.0; 2]);
        let (mut sensor, mut array, mut lens) = (*sound.sensor(), sound.array().clone(), sound.main_lens().clone());
        change(&mut sensor, &mut array, &mut lens);
        let camera = PlenopticCamera::new(sensor, array, lens).unwrap_or_else(|why| panic!("{name}: {why}"));
        let white = camera.white_image().expect("memory");
        let request = Request::new(camera).integrator(Integrator::Direct).samples(2).sky([1.0; 3]);
        let rendered = render(&scene, &request, 0);
        let color = raw(&rendered);
        assert!(color.iter().chain(&white).all(|x| x.is_finite() && *x >= 0.0), "{name}");
        assert!(white.iter().any(|&x| x > 0.0), "{name}: no light at all");
    }
}

/// A raw image of an even scene decodes to even views; a focused camera has none.
#[test]
fn decoded_views_of_an_even_scene_are_even() {
    let size = GridSize::new(300, 320);
    for (name, views) in [("lytro-illum", 7), ("h3dv", 19), ("hahne-arri", 9)] {
        let camera = part(name, size, [0.0; 2]);
        let white = camera.white_image().expect("memory");
        let raw = Array3::from_shape_fn((300, 320, 3), |(row, column, c)| white[[row, column]] * (c as f32 + 1.0));
        let views = camera.decodable_views().expect("views").min(views);
        let decoded = camera.decode(raw.view(), white.view(), views).expect("a light field");
        let (mut lit, mut all) = (0, 0);
        for ((v, u, t, s, c), &value) in decoded.light_field.samples().indexed_iter() {
            let weight = decoded.weight.samples()[[v, u, t, s, 0]];
            assert!(weight == 0.0 || (value - (c as f32 + 1.0)).abs() < 1e-4, "{name} {v} {u} {t} {s}: {value}");
            (lit, all) = (lit + usize::from(weight > 0.0), all + 1);
        }
        println!(
            "{name}: {:?}, {views} views, {} of the samples lit",
            decoded.rig.shape().lenses(),
            lit as f64 / all as f64
        );
        assert!(lit * 100 > all * 99, "{name}: {lit} of {all}");
    }
    let focused = part("raytrix-r12-a", size, [0.0; 2]);
    let white = focused.white_image().expect("memory");
    let raw = Array3::from_shape_fn((300, 320, 3), |(row, column, c)| white[[row, column]] * (c as f32 + 1.0));
    let decoded = focused.decode(raw.view(), white.view(), 3).expect("views");
    for ((v, u, t, s, c), &value) in decoded.light_field.samples().indexed_iter() {
        assert!((value - (c as f32 + 1.0)).abs() < 1e-4, "focused {v} {u} {t} {s}: {value}");
        assert!(decoded.weight.samples()[[v, u, t, s, 0]] > 0.0);
    }
}

/// Behind glass, chief rays have the truth of a plane where their light passes, and none where it does not.
#[test]
fn glass_has_the_truth_of_its_chief_rays() {
    let mut scene = Scene::default();
    add(&mut scene, square(100.0), [0.5, 0.5, 0.5, 1.0], Transform::from_translation([0.0, 0.0, -2.0]));
    let camera = behind_glass(&part("raytrix-r12-a", GridSize::new(60, 61), [9e-3, 7e-3]), "double-gauss");
    let request = Request::new(camera.clone()).integrator(Integrator::Direct).samples(4).sky([1.0; 3]);
    let request = request.layers(LayerSet::of(&[Layer::Depth, Layer::Disparity]));
    let whole = render(&scene, &request, 0);
    let (mut lit, mut dark) = (0, 0);
    for row in 0..60 {
        for column in 0..61 {
            let place = camera.place_m([column as f64 + 0.5, row as f64 + 0.5]);
            let lens = camera.owner(place);
            let depth = whole.central[Layer::Depth][[row, column, 0]];
            if camera.ray(place, camera.lens_center_m(lens), lens).is_some() {
                assert!((f64::from(depth) - 2.0).abs() < 1e-6, "{row} {column}: {depth}");
                lit += 1;
            } else {
                assert!(depth == f32::INFINITY, "{row} {column}: {depth}");
                dark += 1;
            }
        }
    }
    assert!(lit > 500 && dark > 200, "{lit} {dark}");
}

/// Colored light: every channel is that of a camera of its wavelength, and glass that does not disperse gives the same image.
#[test]
fn glass_refracts_colors_differently() {
    let scene = soup(200, 5);
    let camera = behind_glass(&part("raytrix-r12-a", GridSize::new(60, 70), [5e-3, 4e-3]), "double-gauss");
    let request = |camera: &PlenopticCamera| {
        let request = Request::new(camera.clone()).integrator(Integrator::Direct).samples(3).sky([0.3, 0.5, 0.7]);
        request.layers(LayerSet::of(&[Layer::Depth]))
    };
    let plain = render(&scene, &request(&camera), 0);
    let colored = render(&scene, &request(&camera).spectral(true), 3);
    assert_eq!(colored.central, plain.central);
    for (channel, nm) in [611.4, 549.1, 464.3].into_iter().enumerate() {
        let one = render(&scene, &request(&camera.at_wavelength(nm).expect("a camera")), 1);
        let of = |image: Array3<f32>| image.slice(s![.., .., channel]).to_owned();
        assert_eq!(of(raw(&colored)), of(raw(&one)), "{nm} nm");
        assert!(of(raw(&colored)) != of(raw(&plain)), "{nm} nm");
    }
    let lens = camera.main_lens().prescription.as_ref().expect("a prescription");
    let even = |surface: &Surface| match surface.medium {
        Medium::Abbe { nd, .. } => Surface { medium: Medium::Abbe { nd, vd: None }, ..surface.clone() },
        _ => surface.clone(),
    };
    let lens = Prescription::new(lens.surfaces().iter().map(even).collect()).expect("a lens");
    let lens = MainLens::of_glass(lens, camera.main_lens().focus);
    let even = PlenopticCamera::new(*camera.sensor(), camera.array().clone(), lens).expect("a camera");
    assert_eq!(raw(&render(&scene, &request(&even).spectral(true), 0)), raw(&render(&scene, &request(&even), 0)));
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Bvh, None).expect("a renderer");
    let thin = part("lytro-illum", GridSize::new(60, 70), [0.0; 2]);
    let error = renderer.render(&request(&thin).spectral(true), &()).expect_err("a thin lens").to_string();
    assert!(error.contains("no prescription"), "{error}");
}
