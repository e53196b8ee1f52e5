//! How time and memory grow with views, with triangles and with threads.

use holo_core::{GridSize, Remainder, Sensor};
use holo_render::{Backend, Integrator, Renderer, Request};
use holo_scene::{Instance, Light, LightKind, Material, Mesh, Scene, Transform};

use crate::plot::{Plot, Series};
use crate::scenes::{Ready, sky};
use crate::sheet::{Sheet, peak_bytes, short, timed};
use crate::{Section, Wish};

pub fn section(wish: &Wish) -> Section {
    let mut sheet = Sheet::new(&["what", "how many", "build, s", "render, s", "Mrays/s", "memory, MB"]);
    let mut plot = Plot::new("How time grows (direct light, a sample a pixel)", "how many", "seconds");
    let engine = wish.engines[0];
    plot.add(Series {
        name: "views of 79 x 53 px".into(),
        color: 0,
        dashes: 0,
        points: views(wish, engine, &mut sheet),
    });
    let mut largest = vec![sheet.last()];
    if !wish.quick {
        let points = divisions(wish, engine, &mut sheet);
        plot.add(Series { name: "views of an 8K sensor".into(), color: 3, dashes: 0, points });
    }
    let points = triangles(wish, engine, &mut sheet);
    largest.push(sheet.last());
    plot.add(Series { name: "triangles, 10,000 pixels".into(), color: 1, dashes: 0, points });
    plot.add(Series { name: "threads".into(), color: 2, dashes: 0, points: threads(wish, engine, &mut sheet) });
    let highlights = largest
        .into_iter()
        .map(|row| {
            let [what, count, _, seconds, rays, memory] = row;
            [
                format!("direct light: {count} {what}"),
                format!("{seconds} s, {rays} Mrays/s"),
                format!("(memory: {memory} MB)"),
            ]
        })
        .collect();
    Section {
        title: "Scaling",
        text: format!(
            "Direct light of `garden`, a sample a pixel, for 1 to {} views of 79 x 53 px at the baseline of an f/5 lens{}, and for 1 to all \
             threads; a bumpy ball of 10^3 to 10^{} triangles under a sun, 10,000 pixels. Memory is what the peak rises by while it is \
             rendered; of triangles, also while the tree is built.",
            if wish.quick { "1024" } else { "10,000" },
            if wish.quick { "" } else { ", for an 8K sensor divided into 20 to 100 views an axis" },
            if wish.quick { 5 } else { 7 }
        ),
        highlights,
        sheet,
        plots: vec![("scaling", plot.svg())],
    }
}

fn direct(rig: holo_core::Rig, sky: [f32; 3]) -> Request {
    Request { integrator: Integrator::Direct, sky, ..Request::new(rig) }
}

fn views(wish: &Wish, engine: Backend, sheet: &mut Sheet) -> Vec<(f64, f64)> {
    let counts: &[usize] = if wish.quick { &[1, 3, 10, 32] } else { &[1, 3, 10, 32, 56, 100] };
    counts.iter().map(|&views| garden("views", views, GridSize::new(53, 79), wish.rounds, engine, sheet)).collect()
}

/// The rows of the paper's Table I: few large views or many small ones of the same sensor.
fn divisions(wish: &Wish, engine: Backend, sheet: &mut Sheet) -> Vec<(f64, f64)> {
    let row = |views| {
        let split = Sensor::Paper8k.divide(GridSize::new(views, views), Remainder::Crop).expect("a split").shape;
        garden("views of 8K", views, split.lenses(), wish.rounds.min(3), engine, sheet)
    };
    [20, 40, 60, 80, 100].into_iter().map(row).collect()
}

/// A row of the table, and its point on the plot.
fn garden(what: &str, views: usize, lenses: GridSize, rounds: usize, engine: Backend, sheet: &mut Sheet) -> (f64, f64) {
    let ready = Ready::new("garden", views, lenses, None);
    let request = direct(ready.rig, sky("garden"));
    let (build, renderer) = timed(1, || ready.renderer(engine, 0));
    let (bytes, (seconds, rendered)) =
        peak_bytes(|| timed(rounds, || renderer.render(&request, &()).expect("a render")));
    let count = views * views;
    sheet.push([
        what.into(),
        count.to_string(),
        short(build.median),
        seconds.text(),
        short(rendered.rays.total() as f64 / seconds.median / 1e6),
        bytes.map_or("?".into(), |bytes| short(bytes as f64 / 1e6)),
    ]);
    (count as f64, seconds.median)
}

fn threads(wish: &Wish, engine: Backend, sheet: &mut Sheet) -> Vec<(f64, f64)> {
    let ready = Ready::new("garden", if wish.quick { 10 } else { 32 }, GridSize::new(53, 79), None);
    let request = direct(ready.rig, sky("garden"));
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut points = Vec::new();
    let mut count = 1;
    loop {
        let renderer = ready.renderer(engine, count);
        let (seconds, rendered) = timed(wish.rounds, || renderer.render(&request, &()).expect("a render"));
        points.push((count as f64, seconds.median));
        let rays = short(rendered.rays.total() as f64 / seconds.median / 1e6);
        sheet.push(["threads".into(), count.to_string(), String::new(), seconds.text(), rays, String::new()]);
        if count == all {
            return points;
        }
        count = (2 * count).min(all);
    }
}

fn triangles(wish: &Wish, engine: Backend, sheet: &mut Sheet) -> Vec<(f64, f64)> {
    let counts: &[usize] =
        if wish.quick { &[1000, 10_000, 100_000] } else { &[1000, 10_000, 100_000, 1_000_000, 10_000_000] };
    // Any rig of 10,000 pixels will do.
    let rig = Ready::new("garden", 10, GridSize::new(10, 10), None).rig;
    let mut points = Vec::new();
    for &wanted in counts {
        let scene = bumpy_ball(wanted);
        let (bytes, (build, seconds, rendered)) = peak_bytes(|| {
            let renderer = || Renderer::new(&scene, &Transform::from_translation([0.0, 0.0, 3.0]), engine, 0);
            let (build, renderer) = timed(1, || renderer().expect("a scene"));
            let request = direct(rig, [0.0; 3]);
            let (seconds, rendered) = timed(wish.rounds, || renderer.render(&request, &()).expect("a render"));
            (build, seconds, rendered)
        });
        points.push((scene.triangle_count() as f64, seconds.median));
        sheet.push([
            "triangles".into(),
            scene.triangle_count().to_string(),
            short(build.median),
            seconds.text(),
            short(rendered.rays.total() as f64 / seconds.median / 1e6),
            bytes.map_or("?".into(), |bytes| short(bytes as f64 / 1e6)),
        ]);
    }
    points
}

/// A ball of about so many triangles with bumps on it, under a sun.
fn bumpy_ball(triangles: usize) -> Scene {
    let rows = ((triangles as f64 / 4.0).sqrt() as u32).max(2);
    let columns = 2 * rows;
    let mut mesh = Mesh::default();
    for i in 0..=rows {
        for j in 0..=columns {
            let a = std::f64::consts::PI * f64::from(i) / f64::from(rows);
            let b = std::f64::consts::TAU * f64::from(j) / f64::from(columns);
            let radius = 1.0 + 0.05 * (20.0 * a).sin() * (20.0 * b).sin();
            mesh.positions.push([a.sin() * b.cos(), a.cos(), a.sin() * b.sin()].map(|x| (radius * x) as f32));
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            let [a, b] = [i, i + 1].map(|i| i * (columns + 1) + j);
            mesh.triangles.extend([[a, b + 1, b], [a, a + 1, b + 1]]);
        }
    }
    let kind = LightKind::Directional { direction: [-0.6, -0.64, -0.48], angular_diameter_rad: 0.0 };
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY }],
        materials: vec![Material::default()],
        lights: vec![Light { name: "sun".into(), intensity: [1.0; 3], kind }],
        ..Scene::default()
    }
}
