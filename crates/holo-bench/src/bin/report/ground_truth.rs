//! Errors of depth and disparity against a closed form, and against brute-force intersection in f64.

use holo_core::{GridSize, LightFieldShape, Rig};
use holo_render::{Backend, GroundTruth, Integrator, Layer, Renderer, Request};
use holo_scene::{Instance, Material, Mesh, Scene, Transform};

use crate::scenes::{FramedScene, backend_name};
use crate::table::{Table, short, timed};
use crate::{RunOptions, Section};

/// The relative difference of depth above which two rays are taken to have hit different surfaces.
const DIFFERENT_SURFACE: f64 = 1e-5;

pub fn section(options: &RunOptions) -> Section {
    let mut table = Table::new(&[
        "what",
        "engine",
        "Mrays/s",
        "median relative error of depth",
        "largest",
        "median error of disparity, px",
        "largest",
        "pixels on another surface",
    ]);
    let mut highlights = Vec::new();
    for &engine in &options.engines {
        highlights.push(slanted_plane(options, engine, &mut table));
    }
    for scene in ["plaster", "garden"] {
        for &engine in &options.engines {
            highlights.push(brute_force(options, scene, engine, &mut table));
        }
    }
    // Only the fastest backend is in the summary.
    let highlights = highlights.into_iter().step_by(options.engines.len()).collect();
    Section {
        text: "A slanted plane against its closed form in f64; scenes of the gallery against brute-force intersection \
               of every triangle in f64 (with fewer rays, because it is slow). Layers are stored in f32, with a \
               relative rounding error of up to 6e-8. Pixels on another surface are rays within rounding of a \
               silhouette; they are excluded from the errors."
            .into(),
        highlights,
        table,
        plots: Vec::new(),
    }
}

fn ground_truth_request(rig: Rig) -> Request {
    Request::new(rig).integrator(Integrator::Depth).ground_truth(GroundTruth::All)
}

/// The plane z = -2 - 0.5 x - 0.25 y.
fn slanted_plane(options: &RunOptions, engine: Backend, table: &mut Table) -> [String; 3] {
    let corner = |x: f32, y: f32| [x, y, -2.0 - 0.5 * x - 0.25 * y];
    let scene = Scene {
        meshes: vec![Mesh {
            positions: vec![corner(-8.0, -8.0), corner(8.0, -8.0), corner(8.0, 8.0), corner(-8.0, 8.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY }],
        materials: vec![Material::default()],
        ..Scene::default()
    };
    let views = if options.quick { 30 } else { 100 };
    let rig = Rig::builder(LightFieldShape::new(GridSize::new(views, views), GridSize::new(53, 79)).expect("sizes"))
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_m(1e-4)
        .focus_distance_m(2.0)
        .build()
        .expect("a rig");
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, engine, None).expect("a scene");
    let (seconds, rendered) =
        timed(options.rounds, || renderer.render(&ground_truth_request(rig), &()).expect("a render"));
    let all = rendered.all.expect("requested");
    let (depth, disparity) = (all[Layer::Depth].samples(), all[Layer::Disparity].samples());
    let (mut errors, mut errors_px) = (Vec::new(), Vec::new());
    for ((v, u, t, s, _), &found) in depth.indexed_iter() {
        // The signed height above the plane is linear along the ray through the pixel center; depth 1 has a, depth 2 b.
        let ray = rig.ray(v, u, t, s, 0.5, 0.5);
        let [near, far] = [1.0, 2.0].map(|z| ray.at_depth_m(z));
        let height = |p: [f64; 3]| p[2] + 2.0 + 0.5 * p[0] + 0.25 * p[1];
        let (a, b) = (height(near), height(far));
        let exact = 1.0 + a / (a - b);
        errors.push((f64::from(found) / exact - 1.0).abs());
        let exact_px = rig.disparity().from_depth_m(exact);
        errors_px.push((f64::from(disparity[[v, u, t, s, 0]]) - exact_px).abs());
    }
    row(table, "slanted plane, closed form", engine, rendered.rays.total() as f64 / seconds.median, errors, errors_px)
}

fn brute_force(options: &RunOptions, scene: &str, engine: Backend, table: &mut Table) -> [String; 3] {
    let lenses = if options.quick { GridSize::new(6, 9) } else { GridSize::new(20, 30) };
    let framed = FramedScene::new(scene, 2, lenses, Some(1e-3));
    let request = ground_truth_request(framed.rig);
    let render = |backend| framed.renderer(backend, None).render(&request, &()).expect("a render");
    let (exact, found) = (render(Backend::BruteForce), render(engine));
    let speed = {
        let many = FramedScene::new(scene, if options.quick { 20 } else { 100 }, GridSize::new(53, 79), None);
        let renderer = many.renderer(engine, None);
        let request = ground_truth_request(many.rig);
        let (seconds, rendered) = timed(options.rounds, || renderer.render(&request, &()).expect("a render"));
        rendered.rays.total() as f64 / seconds.median
    };
    let (exact, found) = (exact.all.expect("requested"), found.all.expect("requested"));
    let (mut errors, mut errors_px) = (Vec::new(), Vec::new());
    let pairs = exact[Layer::Depth].samples().into_iter().zip(found[Layer::Depth].samples());
    let disparities = exact[Layer::Disparity].samples().into_iter().zip(found[Layer::Disparity].samples());
    for ((&exact, &found), (&exact_px, &found_px)) in pairs.zip(disparities) {
        let error = if exact == found { 0.0 } else { (f64::from(found) / f64::from(exact) - 1.0).abs() };
        errors.push(if error.is_nan() { f64::INFINITY } else { error });
        if error < DIFFERENT_SURFACE {
            errors_px.push((f64::from(found_px) - f64::from(exact_px)).abs());
        }
    }
    row(table, &format!("{scene}, brute force"), engine, speed, errors, errors_px)
}

/// Adds a row to the table; returns the row of the summary.
fn row(
    table: &mut Table,
    what: &str,
    engine: Backend,
    rays_per_second: f64,
    mut errors: Vec<f64>,
    mut errors_px: Vec<f64>,
) -> [String; 3] {
    let all = errors.len();
    errors.retain(|error| *error < DIFFERENT_SURFACE);
    errors.sort_by(f64::total_cmp);
    errors_px.sort_by(f64::total_cmp);
    let largest_px = short(errors_px[errors_px.len() - 1]);
    let largest = short(errors[errors.len() - 1]);
    table.push([
        what.into(),
        backend_name(engine).into(),
        short(rays_per_second / 1e6),
        short(errors[errors.len() / 2]),
        largest.clone(),
        short(errors_px[errors_px.len() / 2]),
        largest_px.clone(),
        format!("{} of {all}", all - errors.len()),
    ]);
    [
        format!("depth and disparity: {what}"),
        format!("{} Mrays/s", short(rays_per_second / 1e6)),
        format!("at most {largest} of depth, {largest_px} px of disparity"),
    ]
}
