//! Layers of materials in whole renders: where their axes and normals point, and that none cost nothing.

use holo_core::{GridSize, LightFieldShape, Rig};
use ndarray::Array5;

use super::*;
use holo_scene::{
    Anisotropy, Clearcoat, Filter, Instance, Iridescence, Light, LightKind, Material, Mesh, NormalMap, Sheen, Texture,
    TextureInfo, Wrap,
};

/// Pixels of the image, rows and columns; the plane is seen from above its middle.
const PIXELS: usize = 21;

/// A square of `material` in the plane z = -1 with the tangent +x and the bitangent +y, lit from the camera. Texture 0
/// slopes to the right, towards +x.
fn plane(material: Material) -> Scene {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let slope = Texture {
        name: String::new(),
        width: 1,
        height: 1,
        texels: vec![[160, 128, 250, 255]],
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: Filter::Nearest,
    };
    Scene {
        meshes: vec![Mesh {
            positions: corners.map(|[x, y]| [x, y, -1.0]).to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            tangents: vec![[1.0, 0.0, 0.0, 1.0]; 4],
            texture_coordinates: corners.map(|[x, y]| [(x + 1.0) / 2.0, (1.0 - y) / 2.0]).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY }],
        materials: vec![material],
        textures: vec![slope],
        lights: vec![Light {
            name: String::new(),
            intensity: [1.0; 3],
            kind: LightKind::Point { position: [0.0; 3], range: None },
        }],
        ..Scene::default()
    }
}

fn image(scene: &Scene, integrator: Integrator) -> Array5<f32> {
    let shape = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(PIXELS, PIXELS)).expect("sizes");
    let rig = Rig::builder(shape)
        .focal_length_m(0.04)
        .sensor_size_m(0.036)
        .baseline_m(0.0)
        .focus_distance_m(1.0)
        .build()
        .expect("a rig");
    let renderer = Renderer::new(scene, &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    let request = Request::new(rig).integrator(integrator).sky([0.2; 3]).samples(4);
    renderer.render(&request, &()).expect("a render").color.expect("lit").samples().to_owned()
}

/// The radiance `right` and `up` pixels from the middle, averaged with the pixel opposite.
fn at(image: &Array5<f32>, right: isize, up: isize) -> f32 {
    let middle = (PIXELS / 2) as isize;
    let pixel = |right: isize, up: isize| image[[(middle - up) as usize, (middle + right) as usize, 0, 0, 0]];
    0.5 * (pixel(right, up) + pixel(-right, -up))
}

/// The highlight is wide along the tangent, turned counter-clockwise by the rotation and by the texture.
#[test]
fn anisotropic_highlights_are_wide_along_their_direction() {
    let metal = |rotation_rad: f32, texture: Option<TextureInfo>| Material {
        metallic: 1.0,
        roughness: 0.3,
        anisotropy: Some(Anisotropy { strength: 0.8, rotation_rad, texture }),
        ..Material::default()
    };
    let quarter = std::f32::consts::FRAC_PI_2;
    for (rotation, wide, narrow) in [
        (0.0, (6, 0), (0, 6)),
        (quarter, (0, 6), (6, 0)),
        (0.5 * quarter, (4, 4), (-4, 4)),
        (-0.5 * quarter, (-4, 4), (4, 4)),
    ] {
        let image = image(&plane(metal(rotation, None)), Integrator::Direct);
        let [wide, narrow] = [wide, narrow].map(|(right, up)| at(&image, right, up));
        assert!(wide > 1.5 * narrow, "{rotation}: {wide} {narrow}");
    }
    // Red 0.25 and green 0.5: against the tangent, which is the same as along it.
    let mut scene = plane(metal(quarter, Some(TextureInfo::new(0))));
    scene.textures[0].texels = vec![[64, 128, 255, 255]];
    let turned = image(&scene, Integrator::Direct);
    assert!(at(&turned, 0, 6) > 1.5 * at(&turned, 6, 0));
    // Without blue, without strength.
    scene.textures[0].texels = vec![[64, 128, 0, 255]];
    let even = image(&scene, Integrator::Direct);
    assert!((at(&even, 0, 6) / at(&even, 6, 0) - 1.0).abs() < 0.05);
}

/// The normal map of the surface below does not tilt the clearcoat, that of the clearcoat does not tilt what is below.
#[test]
fn the_clearcoat_has_a_normal_of_its_own() {
    let map = Some(NormalMap { texture: TextureInfo::new(0), scale: 1.0 });
    let coat = |normal_map| Some(Clearcoat { factor: 1.0, roughness: 0.3, normal_map, ..Clearcoat::default() });
    let black = Material { base_color: [0.0, 0.0, 0.0, 1.0], ..Material::default() };
    let peak = |material: Material| {
        let image = image(&plane(material), Integrator::Direct);
        let row = (0..PIXELS).map(|column| image[[PIXELS / 2, column, 0, 0, 0]]);
        row.enumerate().fold((0, 0.0), |best, (k, x)| if x > best.1 { (k, x) } else { best }).0
    };
    let middle = PIXELS / 2;
    assert_eq!(peak(Material { clearcoat: coat(None), ..black.clone() }), middle);
    assert_eq!(peak(Material { clearcoat: coat(None), normal_map: map, ..black.clone() }), middle);
    // A normal that leans to +x faces camera and light left of the middle.
    let leaning = peak(Material { clearcoat: coat(map), ..black });
    assert!(leaning < middle, "{leaning}");
}

/// Layers of weight 0 leave every bit as it is, and layers of almost none change almost nothing.
#[test]
fn layers_without_weight_cost_nothing() {
    let base = Material { roughness: 0.4, metallic: 0.3, specular: 1.0, ..Material::default() };
    let layers = |weight: f32| Material {
        clearcoat: Some(Clearcoat { factor: weight, roughness: 0.5, ..Clearcoat::default() }),
        sheen: Some(Sheen { color: [weight; 3], roughness: 0.5, ..Sheen::default() }),
        iridescence: Some(Iridescence { factor: weight, ..Iridescence::default() }),
        ..base.clone()
    };
    let [plain, without, thin] =
        [base.clone(), layers(0.0), layers(1e-4)].map(|material| image(&plane(material), Integrator::Path));
    assert_eq!(plain, without);
    let mean = |image: &Array5<f32>| image.iter().sum::<f32>() / image.len() as f32;
    // The minimum of the film instead of the coupling of the coat takes up to 5 % of the diffuse part.
    assert!((mean(&thin) / mean(&plain) - 1.0).abs() < 0.05, "{} {}", mean(&thin), mean(&plain));
}
