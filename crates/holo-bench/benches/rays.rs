//! Rays per second of the stages of a render, as ratios to the ray tracing backend alone on the same rays.
//!
//! `cargo bench -p holo-bench --bench rays -- [SCENE.glb] [--views N] [--lenses UxV] [--rounds N]`
//!
//! Without a scene it renders `garden`. Best of several rounds; every round runs all entries, so that other load of the
//! machine affects all of them.

use std::time::Instant;

use holo_bench::{Entry, best_of, scene_rig};
use holo_render::bench::{Work, trace};
use holo_render::{Backend, GroundTruth, Integrator, LayerSet, Renderer, Request};

fn main() {
    let setup = scene_rig(std::env::args().skip(1));
    let rig = setup.rig;
    let run = |renderer: &Renderer, request: &Request| {
        let start = Instant::now();
        let rendered = renderer.render(request, &()).expect("the scene renders");
        (start.elapsed().as_secs_f64(), rendered.rays.total())
    };
    let render = move |renderer: &Renderer, integrator, sky, ground_truth| {
        run(renderer, &Request::new(rig).integrator(integrator).sky(sky).ground_truth(ground_truth))
    };
    let sky = [0.2, 0.24, 0.32];
    let engines = [Backend::Embree, Backend::Bvh].map(|b| Renderer::new(&setup.scene, &setup.pose, b, None));
    let mut entries: Vec<Entry> = Vec::new();
    for renderer in engines.iter().flatten() {
        let name = renderer.engine_name();
        let bare = move |work| {
            let traced = trace(renderer, &rig, work);
            (traced.seconds, traced.rays)
        };
        let mut add = |what: &str, run| entries.push((format!("{name}: {what}"), run));
        add("bare packets of 16", Box::new(move || bare(Work::BarePackets)));
        add("bare single rays", Box::new(move || bare(Work::BareSingle)));
        add("visibility of all views kept", Box::new(move || bare(Work::Visibility)));
        add(
            "depth + disparity of all views, f64",
            Box::new(move || render(renderer, Integrator::Depth, [0.0; 3], GroundTruth::All)),
        );
        add(
            "all layers of all views",
            Box::new(move || {
                let request = Request::new(rig)
                    .integrator(Integrator::Depth)
                    .layers(LayerSet::ALL)
                    .ground_truth(GroundTruth::All);
                run(renderer, &request)
            }),
        );
        add("direct, lights", Box::new(move || render(renderer, Integrator::Direct, [0.0; 3], GroundTruth::Central)));
        add(
            "direct, lights and sky",
            Box::new(move || render(renderer, Integrator::Direct, sky, GroundTruth::Central)),
        );
        add(
            "paths of 8 vertices, lights and sky",
            Box::new(move || render(renderer, Integrator::Path, sky, GroundTruth::Central)),
        );
    }
    println!("{}", setup.describe());
    let results = best_of(setup.rounds, &mut entries);
    let base = results[0].1.0 / results[0].1.1 as f64;
    println!("{:<48} {:>9} {:>9} {:>12}", "", "seconds", "Mrays/s", "speed/bare");
    let pixels = rig.shape().sample_count() as f64;
    for (name, (seconds, rays)) in results {
        let (mrays, ratio) = (rays as f64 / seconds / 1e6, base * pixels / seconds);
        println!("{name:<48} {seconds:>9.3} {mrays:>9.1} {ratio:>12.3}");
    }
}
