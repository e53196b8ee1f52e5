//! Renders a scene that is built in code into a raw holoscopic image. It reads no file.

use holo_core::{GridSize, LightFieldShape};
use holo_io::{ColorEncoding, Compression, write_pfm, write_png};
use holo_render::{Backend, Baseline, Framing, Integrator, Renderer, Request, exposure};
use holo_scene::{Camera, CameraProjection, Instance, Light, LightKind, Material, Mesh, Scene, Transform};
use ndarray::Axis;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Three colored squares at 0.4, 0.5 and 0.65 m.
    let mut scene = Scene::default();
    for (k, (x, z, base_color)) in
        [(-0.08, -0.4, [0.8, 0.1, 0.1, 1.0]), (0.02, -0.5, [0.1, 0.6, 0.2, 1.0]), (0.1, -0.65, [0.15, 0.2, 0.8, 1.0])]
            .into_iter()
            .enumerate()
    {
        scene.materials.push(Material { base_color, ..Material::default() });
        scene.meshes.push(Mesh {
            positions: vec![[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: k,
            ..Mesh::default()
        });
        let transform = Transform::from_translation([x, 0.0, z]);
        scene.instances.push(Instance { name: format!("square {k}"), mesh: k, transform });
    }
    let direction = [0.0, -0.6, -0.8];
    scene.lights.push(Light {
        name: "sun".into(),
        intensity: [3.0; 3],
        kind: LightKind::Directional { direction, angular_diameter_rad: 0.0 },
    });
    let projection = CameraProjection::Perspective { vertical_angle_rad: 0.6, aspect_ratio: Some(1.5) };
    scene.cameras.push(Camera { name: "main".into(), pose: Transform::IDENTITY, projection });

    // 10 x 10 views behind 80 x 120 microlenses, 2 mm apart, with the focus on the middle square.
    let framing = Framing::new(LightFieldShape::new(GridSize::new(10, 10), GridSize::new(80, 120))?)
        .baseline(Baseline::Meters(0.002));
    let framed = framing.frame(&scene)?;
    let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, None)?;
    let request = Request::new(framed.rig(0.5)?).integrator(Integrator::Direct).samples(4).sky([0.1, 0.1, 0.12]);
    let rendered = renderer.render(&request, &())?;

    let color = rendered.color.ok_or("the integrator `Direct` makes an image")?;
    let raw = exposure::encode_8bit(&color, exposure::automatic_exposure(&color))?.to_elemental_grid()?;
    let out = std::env::temp_dir();
    write_png(out.join("holo_example_raw.png"), raw.view(), ColorEncoding::Srgb, Compression::Best)?;
    let depth_m = rendered.central.depth_m().ok_or("depth is a default layer")?;
    write_pfm(out.join("holo_example_depth.pfm"), depth_m.index_axis(Axis(2), 0))?;
    println!(
        "{} x {} px with {}: holo_example_raw.png in {}",
        raw.dim().1,
        raw.dim().0,
        renderer.engine_name(),
        out.display()
    );
    Ok(())
}
