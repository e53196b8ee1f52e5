//! How time and memory grow with views, with triangles and with threads.

use std::num::NonZeroUsize;

use holo_core::{GridSize, Remainder, Sensor};
use holo_render::{Backend, Denoise, Integrator, Renderer, Request, SamplesPerPixel};
use holo_scene::{Instance, Light, LightKind, Material, Mesh, Scene, Transform};

use crate::plot::{Plot, Series};
use crate::scenes::{FramedScene, sky};
use crate::table::{Table, peak_bytes, short, timed};
use crate::{RunOptions, Section};

pub fn section(options: &RunOptions) -> Section {
    let mut table = Table::new(&["what", "count", "build, s", "render, s", "Mrays/s", "memory, MB"]);
    let mut plot = Plot::new("Render time (direct light, 1 sample per pixel)", "count", "seconds");
    let engine = options.engines[0];
    plot.add(Series {
        name: "views of 79 x 53 px".into(),
        color: 0,
        dashes: 0,
        points: views(options, engine, &mut table),
    });
    let mut largest = vec![table.last()];
    if !options.quick {
        for sharing in [Sharing::Plain, Sharing::Shared] {
            let points = divisions(engine, sharing, &mut table);
            plot.add(Series { name: sharing.views_of_8k().into(), color: 3 + sharing as usize, dashes: 0, points });
            sensors(engine, sharing, &mut table);
        }
    }
    let points = triangles(options, engine, &mut table);
    largest.push(table.last());
    plot.add(Series { name: "triangles, 10,000 pixels".into(), color: 1, dashes: 0, points });
    plot.add(Series { name: "threads".into(), color: 2, dashes: 0, points: threads(options, engine, &mut table) });
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
        text: format!(
            "Direct light of `garden`, 1 sample per pixel, for 1 to {} views of 79 x 53 px at the baseline of an f/5 \
             lens{}, and for 1 to all threads; a displaced sphere of 10^3 to 10^{} triangles under a directional \
             light, 10,000 pixels. Memory is the increase of the peak during rendering; for triangles, during the BVH \
             build, too.",
            if options.quick { "1024" } else { "10,000" },
            if options.quick {
                ""
            } else {
                ", for an 8K sensor divided into 5 to 200 views per axis, for sensors of HD, 4K and 8K in 100 x 100 views (both \
                 also with paths of up to 8 bounces, 1/4 sample, denoise views; single runs)"
            },
            if options.quick { 5 } else { 7 }
        ),
        highlights,
        table,
        plots: vec![("scaling", plot.svg())],
    }
}

fn direct(rig: holo_core::Rig, sky: [f32; 3]) -> Request {
    Request::new(rig).integrator(Integrator::Direct).sky(sky)
}

fn views(options: &RunOptions, engine: Backend, table: &mut Table) -> Vec<(f64, f64)> {
    let counts: &[usize] = if options.quick { &[1, 3, 10, 32] } else { &[1, 3, 10, 32, 56, 100] };
    counts
        .iter()
        .map(|&views| {
            add_garden_row(["views", ""], views, GridSize::new(53, 79), Sharing::Plain, options.rounds, engine, table)
        })
        .collect()
}

/// How pixels get their light.
#[derive(Clone, Copy)]
enum Sharing {
    /// Direct light, a sample of its own for every pixel.
    Plain,
    /// Paths, a quarter of a sample for each, shared between views.
    Shared,
}

impl Sharing {
    fn views_of_8k(self) -> &'static str {
        match self {
            Self::Plain => "views of 8K",
            Self::Shared => "views of 8K, paths, 1/4 sample, denoise views",
        }
    }

    fn request(self, rig: holo_core::Rig) -> Request {
        let request = direct(rig, sky("garden"));
        match self {
            Self::Plain => request,
            Self::Shared => request
                .integrator(Integrator::Path)
                .samples(SamplesPerPixel::one_in(4).expect("a power of two"))
                .denoise(Denoise::Views),
        }
    }
}

/// One sensor divided into different numbers of views, as in the paper's Table I.
fn divisions(engine: Backend, sharing: Sharing, table: &mut Table) -> Vec<(f64, f64)> {
    let row = |views| {
        let split = Sensor::Paper8k.divide(GridSize::new(views, views), Remainder::Crop).expect("a split").shape;
        add_garden_row([sharing.views_of_8k(), ""], views, split.lenses(), sharing, 1, engine, table)
    };
    [5, 10, 20, 50, 100, 200].into_iter().map(row).collect()
}

/// Sensors of different sizes divided into 100 x 100 views.
fn sensors(engine: Backend, sharing: Sharing, table: &mut Table) {
    for (name, sensor) in [(", HD", Sensor::Hd), (", 4K", Sensor::Uhd4k), (", 8K", Sensor::Paper8k)] {
        let split = sensor.divide(GridSize::new(100, 100), Remainder::Crop).expect("a split").shape;
        let what = match sharing {
            Sharing::Plain => "views",
            Sharing::Shared => "views, paths, 1/4 sample, denoise views",
        };
        add_garden_row([what, name], 100, split.lenses(), sharing, 1, engine, table);
    }
}

/// Adds a row for the scene `garden` to the table; returns its point in the plot.
fn add_garden_row(
    what: [&str; 2],
    views: usize,
    lenses: GridSize,
    sharing: Sharing,
    rounds: usize,
    engine: Backend,
    table: &mut Table,
) -> (f64, f64) {
    let framed = FramedScene::new("garden", views, lenses, None);
    let request = sharing.request(framed.rig);
    let (build, renderer) = timed(1, || framed.renderer(engine, None));
    let (bytes, (seconds, rendered)) =
        peak_bytes(|| timed(rounds, || renderer.render(&request, &()).expect("a render")));
    let count = views * views;
    table.push([
        what.concat(),
        count.to_string(),
        short(build.median),
        seconds.text(),
        short(rendered.rays.total() as f64 / seconds.median / 1e6),
        bytes.map_or("?".into(), |bytes| short(bytes as f64 / 1e6)),
    ]);
    (count as f64, seconds.median)
}

fn threads(options: &RunOptions, engine: Backend, table: &mut Table) -> Vec<(f64, f64)> {
    let framed = FramedScene::new("garden", if options.quick { 10 } else { 32 }, GridSize::new(53, 79), None);
    let request = direct(framed.rig, sky("garden"));
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut points = Vec::new();
    let mut count = 1;
    loop {
        let renderer = framed.renderer(engine, NonZeroUsize::new(count));
        let (seconds, rendered) = timed(options.rounds, || renderer.render(&request, &()).expect("a render"));
        points.push((count as f64, seconds.median));
        let rays = short(rendered.rays.total() as f64 / seconds.median / 1e6);
        table.push(["threads".into(), count.to_string(), String::new(), seconds.text(), rays, String::new()]);
        if count == all {
            return points;
        }
        count = (2 * count).min(all);
    }
}

fn triangles(options: &RunOptions, engine: Backend, table: &mut Table) -> Vec<(f64, f64)> {
    let counts: &[usize] =
        if options.quick { &[1000, 10_000, 100_000] } else { &[1000, 10_000, 100_000, 1_000_000, 10_000_000] };
    // A rig of 10,000 pixels.
    let rig = FramedScene::new("garden", 10, GridSize::new(10, 10), None).rig;
    let mut points = Vec::new();
    for &target in counts {
        let scene = displaced_sphere(target);
        let (bytes, (build, seconds, rendered)) = peak_bytes(|| {
            let renderer = || Renderer::new(&scene, &Transform::from_translation([0.0, 0.0, 3.0]), engine, None);
            let (build, renderer) = timed(1, || renderer().expect("a scene"));
            let request = direct(rig, [0.0; 3]);
            let (seconds, rendered) = timed(options.rounds, || renderer.render(&request, &()).expect("a render"));
            (build, seconds, rendered)
        });
        points.push((scene.triangle_count() as f64, seconds.median));
        table.push([
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

/// A displaced sphere of about this many triangles under a directional light.
fn displaced_sphere(triangles: usize) -> Scene {
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
