//! How time and memory grow with views, samples, triangles, lights, poses, frames and threads.

use std::num::NonZeroUsize;

use holo_core::{GridSize, Remainder, Sensor};
use holo_render::{Backend, Denoise, Framing, Integrator, Rendered, Renderer, Request, SamplesPerPixel, World};
use holo_scene::gltf::{self, LoadOptions};
use holo_scene::{Instance, Light, LightKind, Material, Mesh, Scene, Transform, gallery};

use crate::plot::{Plot, Series};
use crate::scenes::{FramedScene, sky};
use crate::table::{Seconds, Table, peak_bytes, short, timed};
use crate::{RunOptions, Section};

pub fn section(options: &RunOptions) -> Section {
    let mut table = Rows::new();
    let mut plot = Plot::new("Render time (direct light, 1 sample per pixel)", "count", "seconds");
    let engine = options.engines[0];
    plot.add(Series {
        name: "views of 79 x 53 px".into(),
        color: 0,
        dashes: 0,
        points: views(options, engine, &mut table),
    });
    let mut largest = vec![table.table.last()];
    if !options.quick {
        for sharing in [Sharing::Plain, Sharing::Shared] {
            let points = divisions(engine, sharing, &mut table);
            plot.add(Series { name: sharing.views_of_8k().into(), color: 3 + sharing as usize, dashes: 0, points });
            sensors(engine, sharing, &mut table);
        }
    }
    let points = triangles(options, engine, &mut table);
    largest.push(table.table.last());
    plot.add(Series { name: "triangles, 10,000 pixels".into(), color: 1, dashes: 0, points });
    let axes: [(&str, Axis); 5] =
        [("samples", samples), ("lamps", lamps), ("poses", poses), ("frames", frames), ("threads", threads)];
    for (number, (name, axis)) in axes.into_iter().enumerate() {
        let points = axis(options, engine, &mut table);
        plot.add(Series { name: name.into(), color: 2 + number, dashes: 1, points });
    }
    let highlights = largest
        .into_iter()
        .map(|row| {
            let [what, count, _, seconds, rays, memory, _] = row;
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
             light, 10,000 pixels. Samples, lamps and poses: 10 x 10 views of 79 x 53 px, of `garden`; of a ball under \
             lamps around it; of `garden` from places along a line. Frames: the same views of `pendulum`, which is \
             loaded and built for each. Memory is the increase of the peak during rendering; for triangles and \
             frames, during the BVH build, too. Growth is the exponent of the time against the row before: 1 is linear, 0 constant.",
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
        table: table.table,
        plots: vec![("scaling", plot.svg())],
    }
}

/// Measures a row for every count; returns the points of the plot.
type Axis = fn(&RunOptions, Backend, &mut Rows) -> Vec<(f64, f64)>;

/// The table, and what its last row counted.
struct Rows {
    table: Table,
    last: Option<(String, f64, f64)>,
}

impl Rows {
    fn new() -> Self {
        let headings = ["what", "count", "build, s", "render, s", "Mrays/s", "memory, MB", "growth"];
        Self { table: Table::new(&headings), last: None }
    }

    /// Adds a row; returns its point.
    fn add(
        &mut self,
        what: &str,
        count: usize,
        build: Option<Seconds>,
        render: Seconds,
        measured: [Option<u64>; 2],
    ) -> (f64, f64) {
        let [rays, bytes] = measured;
        let point = (count as f64, render.median);
        let growth = match &self.last {
            Some((before, counted, took)) if before == what => {
                short(((point.1 / took).ln() / (point.0 / counted).ln() * 100.0).round() / 100.0)
            }
            _ => String::new(),
        };
        self.last = Some((what.into(), point.0, point.1));
        // The section takes long: what is measured is seen before its end.
        eprintln!("        {count} {what}: {} s", render.text());
        self.table.push([
            what.into(),
            count.to_string(),
            build.map_or(String::new(), |build| short(build.median)),
            render.text(),
            rays.map_or(String::new(), |rays| short(rays as f64 / render.median / 1e6)),
            bytes.map_or("?".into(), |bytes| short(bytes as f64 / 1e6)),
            growth,
        ]);
        point
    }
}

fn direct(rig: holo_core::Rig, sky: [f32; 3]) -> Request {
    Request::new(rig).integrator(Integrator::Direct).sky(sky)
}

fn views(options: &RunOptions, engine: Backend, table: &mut Rows) -> Vec<(f64, f64)> {
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
fn divisions(engine: Backend, sharing: Sharing, table: &mut Rows) -> Vec<(f64, f64)> {
    let row = |views| {
        let split = Sensor::Paper8k.divide(GridSize::new(views, views), Remainder::Crop).expect("a split").shape;
        add_garden_row([sharing.views_of_8k(), ""], views, split.lenses(), sharing, 1, engine, table)
    };
    [5, 10, 20, 50, 100, 200].into_iter().map(row).collect()
}

/// Sensors of different sizes divided into 100 x 100 views.
fn sensors(engine: Backend, sharing: Sharing, table: &mut Rows) {
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
    table: &mut Rows,
) -> (f64, f64) {
    let framed = FramedScene::new("garden", views, lenses, None);
    let request = sharing.request(framed.rig);
    let (build, renderer) = timed(1, || framed.renderer(engine, None));
    let (bytes, (seconds, rendered)) =
        peak_bytes(|| timed(rounds, || renderer.render(&request, &()).expect("a render")));
    table.add(&what.concat(), views * views, Some(build), seconds, [Some(rendered.rays.total()), bytes])
}

/// `garden` in 10 x 10 views.
fn small_garden() -> FramedScene {
    FramedScene::new("garden", 10, GridSize::new(53, 79), None)
}

fn samples(options: &RunOptions, engine: Backend, table: &mut Rows) -> Vec<(f64, f64)> {
    let framed = small_garden();
    let renderer = framed.renderer(engine, None);
    let counts: &[u32] = if options.quick { &[1, 4, 16] } else { &[1, 4, 16, 64] };
    let row = |&count: &u32| {
        let request = direct(framed.rig, sky("garden")).samples(count);
        let (bytes, (seconds, rendered)) = peak_bytes(|| timed(options.rounds, || render(&renderer, &request)));
        table.add("samples", count as usize, None, seconds, [Some(rendered.rays.total()), bytes])
    };
    counts.iter().map(row).collect()
}

/// Lamps on a ball around a smaller one.
fn lamps(options: &RunOptions, engine: Backend, table: &mut Rows) -> Vec<(f64, f64)> {
    let rig = small_garden().rig;
    let counts: &[usize] = if options.quick { &[1, 10, 100] } else { &[1, 10, 100, 1000, 10_000] };
    let row = |&count: &usize| {
        let lamp = |number: usize| {
            // A spiral with the golden angle.
            let height = 1.0 - (2 * number + 1) as f64 / count as f64;
            let (sine, cosine) = (number as f64 * 2.399_963).sin_cos();
            let across = 4.0 * (1.0 - height * height).sqrt();
            let kind = LightKind::Point { position: [across * cosine, 4.0 * height, across * sine], range: None };
            Light { name: format!("lamp {number}"), intensity: [100.0 / count as f64; 3], kind }
        };
        let scene = Scene { lights: (0..count).map(lamp).collect(), ..displaced_sphere(10_000) };
        let pose = Transform::from_translation([0.0, 0.0, 3.0]);
        let (build, renderer) = timed(1, || Renderer::new(&scene, &pose, engine, None).expect("a scene"));
        let request = direct(rig, [0.0; 3]);
        let (bytes, (seconds, rendered)) = peak_bytes(|| timed(options.rounds, || render(&renderer, &request)));
        table.add("lamps", count, Some(build), seconds, [Some(rendered.rays.total()), bytes])
    };
    counts.iter().map(row).collect()
}

/// One scene from places along a line, as `--transforms` has it.
fn poses(options: &RunOptions, engine: Backend, table: &mut Rows) -> Vec<(f64, f64)> {
    let framed = small_garden();
    let (build, world) = timed(1, || World::new(&framed.scene, engine, None).expect("a scene"));
    let request = direct(framed.rig, sky("garden"));
    let counts: &[usize] = if options.quick { &[1, 4] } else { &[1, 4, 16] };
    let row = |&count: &usize| {
        let all = || {
            let place =
                |number: usize| framed.pose.after(&Transform::from_translation([0.01 * number as f64, 0.0, 0.0]));
            let one = |number| render(&world.at(&place(number)).expect("a pose"), &request).rays.total();
            (0..count).map(one).sum::<u64>()
        };
        let (bytes, (seconds, rays)) = peak_bytes(|| timed(options.rounds, all));
        table.add("poses", count, Some(build), seconds, [Some(rays), bytes])
    };
    counts.iter().map(row).collect()
}

/// Frames of a scene that moves, as `--frame 1-N` has it: loaded, built and rendered one after the other.
fn frames(options: &RunOptions, engine: Backend, table: &mut Rows) -> Vec<(f64, f64)> {
    let glb = gallery::to_glb("pendulum").expect("a scene of the gallery").expect("a scene that is written");
    let rig = small_garden().rig;
    let counts: &[usize] = if options.quick { &[1, 4] } else { &[1, 4, 16] };
    let row = |&count: &usize| {
        let one = |number: usize| {
            let mut at = LoadOptions::default();
            at.time_s = Some(number as f64 / 24.0);
            let scene = gltf::load_slice_with(&glb, &at).expect("a scene").scene;
            let pose = Framing::new(*rig.shape()).frame(&scene).expect("a camera").pose;
            let renderer = Renderer::new(&scene, &pose, engine, None).expect("a scene");
            render(&renderer, &direct(rig, sky("garden"))).rays.total()
        };
        let (bytes, (seconds, rays)) = peak_bytes(|| timed(options.rounds, || (0..count).map(one).sum::<u64>()));
        table.add("frames", count, None, seconds, [Some(rays), bytes])
    };
    counts.iter().map(row).collect()
}

fn render(renderer: &Renderer, request: &Request) -> Rendered {
    renderer.render(request, &()).expect("a render")
}

fn threads(options: &RunOptions, engine: Backend, table: &mut Rows) -> Vec<(f64, f64)> {
    let framed = FramedScene::new("garden", if options.quick { 10 } else { 32 }, GridSize::new(53, 79), None);
    let request = direct(framed.rig, sky("garden"));
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut points = Vec::new();
    let mut count = 1;
    loop {
        let renderer = framed.renderer(engine, NonZeroUsize::new(count));
        let (seconds, rendered) = timed(options.rounds, || renderer.render(&request, &()).expect("a render"));
        points.push(table.add("threads", count, None, seconds, [Some(rendered.rays.total()), None]));
        if count == all {
            return points;
        }
        count = (2 * count).min(all);
    }
}

fn triangles(options: &RunOptions, engine: Backend, table: &mut Rows) -> Vec<(f64, f64)> {
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
        let count = scene.triangle_count();
        points.push(table.add("triangles", count, Some(build), seconds, [Some(rendered.rays.total()), bytes]));
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
