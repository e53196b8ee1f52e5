//! Filtered textures in whole renders: what they take away of the noise of fine texture, and what they change of its mean.

use holo_core::plenoptic::{ImageSensor, MainLens, MicrolensArray, MicrolensGrid, PlenopticCamera};
use holo_core::{GridSize, LightFieldShape, Projection, Rig};

use super::*;
use holo_scene::{
    Alpha, Filter, Instance, Light, LightKind, Material, Mesh, Texture, TextureInfo, TextureTransform, Wrap,
};

/// A plane that leans away from the camera, with a texture of random texels, some 40 a pixel.
fn plane(material: Material) -> Scene {
    let texel = |k: usize| [0, 1, 2].map(|c| (crate::sampling::hash(3 * k as u32 + c) >> 24) as u8);
    let texture = Texture {
        name: String::new(),
        width: 251,
        height: 256,
        texels: (0..251 * 256).map(texel).map(|[r, g, b]| [r, g, b, 255]).collect(),
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Mirror,
        filter: Filter::Linear,
    };
    let corners: [[f32; 2]; 3] = [[-9.0, -0.9], [9.0, -0.9], [0.0, 9.0]];
    let texture_info = TextureInfo {
        transform: TextureTransform { rotation_rad: 0.4, scale: [1.5, 1.2], ..TextureTransform::IDENTITY },
        ..TextureInfo::new(0)
    };
    Scene {
        meshes: vec![Mesh {
            positions: corners.map(|[x, y]| [x, y, -2.0 - y]).to_vec(),
            texture_coordinates: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY }],
        materials: vec![Material { base_color_texture: Some(texture_info), ..material }],
        textures: vec![texture],
        lights: vec![Light {
            name: String::new(),
            intensity: [3.0; 3],
            kind: LightKind::Point { position: [0.0, 0.0, -0.5], range: None },
        }],
        ..Scene::default()
    }
}

fn request(projection: Projection) -> Request {
    let shape = LightFieldShape::new(GridSize::new(2, 2), GridSize::new(14, 14)).expect("sizes");
    let rig = Rig::builder(shape)
        .focal_length_m(0.04)
        .sensor_size_m(0.03)
        .baseline_m(0.01)
        .focus_distance_m(2.0)
        .projection(projection)
        .build()
        .expect("a rig");
    Request::new(rig).integrator(Integrator::Direct).layers(LayerSet::of(&[]))
}

fn render(scene: &Scene, request: &Request) -> Vec<f32> {
    let renderer = Renderer::new(scene, &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    renderer.render(request, &()).expect("a render").color.expect("lit").samples().iter().copied().collect()
}

/// The root of the mean squared difference, relative to the mean.
fn difference(a: &[f32], b: &[f32]) -> f64 {
    let mean = b.iter().map(|&x| f64::from(x)).sum::<f64>() / b.len() as f64;
    let squared = a.iter().zip(b).map(|(&x, &y)| f64::from(x - y).powi(2)).sum::<f64>() / b.len() as f64;
    squared.sqrt() / mean
}

/// Little is left of the noise of fine texture, for every number of samples, both projections and light that varies
/// slowly. The texture is white noise, the hardest case: what is left is the shape of the filter, which is no box.
#[test]
fn the_noise_of_fine_texture_vanishes() {
    for projection in [Projection::Perspective, Projection::Orthographic] {
        for unlit in [true, false] {
            let scene = plane(Material { unlit, ..Material::default() });
            let request = request(projection);
            let exact = render(&scene, &request.clone().samples(4096).texture_filter(TextureFilter::Off));
            for samples in [1, 2, 4, 7, 16] {
                let request = request.clone().samples(samples);
                let plain = difference(&render(&scene, &request.clone().texture_filter(TextureFilter::Off)), &exact);
                let filtered = difference(&render(&scene, &request), &exact);
                println!("{projection:?} unlit {unlit} {samples} samples: {plain:.5} -> {filtered:.5}");
                // At most 0.17 of it is left, at 16 samples: the shape of the filter, which more samples do not change.
                assert!(filtered < 0.3 * plain, "{projection:?} {samples}: {filtered} instead of {plain}");
            }
        }
    }
}

/// The same for a plenoptic camera, whose pixels see spots that are as large as a microlens.
#[test]
fn the_noise_of_fine_texture_vanishes_in_raw_images() {
    let scene = plane(Material { unlit: true, ..Material::default() });
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows] {
        let camera = PlenopticCamera::new(
            ImageSensor::new(GridSize::new(28, 28), 50e-6),
            MicrolensArray::new(grid, 700e-6, 1.4e-3),
            MainLens::new(5e-3, 2.0, 2.0),
        );
        let request = Request::new(camera.expect("a camera")).integrator(Integrator::Direct);
        let request = request.layers(LayerSet::EMPTY);
        let exact = render(&scene, &request.clone().samples(4096).texture_filter(TextureFilter::Off));
        for samples in [1, 4, 16] {
            let request = request.clone().samples(samples);
            let plain = difference(&render(&scene, &request.clone().texture_filter(TextureFilter::Off)), &exact);
            let filtered = difference(&render(&scene, &request), &exact);
            println!("{grid:?} {samples} samples: {plain:.5} -> {filtered:.5}");
            // A parallelogram of the variances of a cell is not its shape, and the light of the edges of micro-images has
            // noise of its own.
            assert!(filtered < 0.5 * plain, "{grid:?} {samples}: {filtered} instead of {plain}");
        }
    }
}

/// The error of the filter vanishes as the number of samples grows, and the mean of the image stays.
#[test]
fn the_bias_vanishes_with_more_samples() {
    let scene = plane(Material { unlit: true, ..Material::default() });
    let request = request(Projection::Perspective);
    let exact = render(&scene, &request.clone().samples(16_384).texture_filter(TextureFilter::Off));
    let means = [4, 1024].map(|samples| {
        // Together 4096 samples, so that the noise is small beside the bias of 4.
        let seeds = 4096 / samples;
        let mut mean = vec![0.0; exact.len()];
        for seed in 0..seeds {
            let one = render(&scene, &request.clone().samples(samples).seed(u64::from(seed)));
            mean.iter_mut().zip(&one).for_each(|(mean, x)| *mean += x / seeds as f32);
        }
        let total = |image: &[f32]| image.iter().map(|&x| f64::from(x)).sum::<f64>();
        let ratio = total(&mean) / total(&exact);
        // Six standard errors of the mean over 784 pixels of 4096 unfiltered samples, which are off by 62 % each.
        assert!((ratio - 1.0).abs() < 2e-3, "{samples} samples: the mean changes by a factor of {ratio}");
        difference(&mean, &exact)
    });
    println!("bias at 4 and 1024 samples: {means:?}");
    // The shape of the filter changes white noise by 1.7 % of the mean; 0.6 % is the noise of 1024 samples.
    assert!(means[0] < 0.03 && means[1] < 0.5 * means[0], "{means:?}");
}

/// Every texel has the same weight over the places of samples: means over seeds have no error that stays. Of a texture of few
/// bright texels, six a pixel along an axis, four samples are as good as those of centered filters, and sixteen seeds better
/// than without filters.
#[test]
fn means_over_seeds_lose_the_noise_of_sparse_texels() {
    let mut scene = plane(Material { unlit: true, ..Material::default() });
    let texture = scene.materials[0].base_color_texture.as_mut().expect("a texture");
    texture.transform.scale = [0.19, 0.15];
    for (k, texel) in scene.textures[0].texels.iter_mut().enumerate() {
        let is_bright = crate::sampling::hash(k as u32) < u32::MAX / 16;
        *texel = if is_bright { [255; 4] } else { [0, 0, 0, 255] };
    }
    let request = request(Projection::Perspective).samples(4);
    let exact = render(&scene, &request.clone().samples(16_384).texture_filter(TextureFilter::Off));
    let errors = [TextureFilter::Off, TextureFilter::Footprint].map(|filter| {
        let seeds = 16;
        let (mut mean, mut single) = (vec![0.0; exact.len()], 0.0);
        for seed in 0..seeds {
            let one = render(&scene, &request.clone().texture_filter(filter).seed(seed));
            single += difference(&one, &exact) / seeds as f64;
            mean.iter_mut().zip(&one).for_each(|(mean, x)| *mean += x / seeds as f32);
        }
        [single, difference(&mean, &exact)]
    });
    let [[off, mean_off], [filtered, mean_filtered]] = errors;
    println!("one seed {off:.3} -> {filtered:.3}, the mean of 16 {mean_off:.4} -> {mean_filtered:.4}");
    assert!(filtered < 0.5 * off && mean_filtered < 1.1 * mean_off, "{errors:?}");
}

/// Of an array of microlenses that is exposed in 3 x 3 positions, every third microlens is one of the array at rest: the
/// same square of the scene, with filtered textures and without. Narrower pixels in the same places differ much more.
#[test]
fn shifted_microlenses_are_as_wide_as_those_at_rest() {
    let scene = plane(Material { unlit: true, ..Material::default() });
    let request = request(Projection::Perspective).samples(1024).texture_filter(TextureFilter::Off);
    let shape = LightFieldShape::new(GridSize::new(2, 2), GridSize::new(42, 42)).expect("sizes");
    let finer =
        request.clone().camera(request.camera.rig().expect("a rig").to_builder().shape(shape).build().expect("a rig"));
    let at_rest = render(&scene, &request);
    let every_third = |request: &Request| -> Vec<f32> {
        let values = render(&scene, request);
        let index = |k: usize| {
            let (lens, rest) = (k / 12, k % 12);
            ((lens / 14 * 3 + 1) * 42 + lens % 14 * 3 + 1) * 12 + rest
        };
        (0..at_rest.len()).map(|k| values[index(k)]).collect()
    };
    let wide = difference(&every_third(&finer.clone().filter_width_px(3.0)), &at_rest);
    let filtered = finer.clone().filter_width_px(3.0).texture_filter(TextureFilter::Footprint).samples(64);
    let filtered = difference(&every_third(&filtered), &at_rest);
    let narrow = difference(&every_third(&finer), &at_rest);
    println!("shifted {wide:.4}, with filtered textures {filtered:.4}, narrow {narrow:.4}");
    // 1024 samples of this texture have a noise of 1.6 %, and the filter has a shape that is no box: 1.7 % (see above). A
    // third of the width leaves 7.5 %.
    assert!(wide < 0.02 && filtered < 0.03 && narrow > 0.06, "{wide} {filtered} {narrow}");
    // One sample does not go through the center of a wide pixel: the mean over many seeds is that of many samples.
    let seeds = 256;
    let mut mean = vec![0.0; at_rest.len()];
    for seed in 0..seeds {
        let one = every_third(&finer.clone().filter_width_px(3.0).samples(1).seed(seed));
        mean.iter_mut().zip(&one).for_each(|(mean, x)| *mean += x / seeds as f32);
    }
    let single = difference(&mean, &at_rest);
    println!("single samples {single:.4}");
    // 256 samples without a net have a noise of 62 % / 16 = 3.9 %; through the centers it would be that of one sample.
    assert!(single < 0.06, "{single}");
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    for width in [0.0, -1.0, f64::NAN, 65.0] {
        let error = renderer.render(&finer.clone().filter_width_px(width), &()).expect_err("a bad width");
        assert!(error.to_string().contains("at most 64"), "{error}");
    }
}

/// Materials with alpha are not filtered: the texels of holes have no color.
#[test]
fn alpha_is_not_filtered() {
    let request = request(Projection::Perspective).samples(4);
    for alpha in [Alpha::Mask(0.5), Alpha::Blend] {
        let scene = plane(Material { alpha, unlit: true, ..Material::default() });
        let off = render(&scene, &request.clone().texture_filter(TextureFilter::Off));
        assert_eq!(render(&scene, &request), off, "{alpha:?}");
    }
}

/// Packets that see one surface look its texture up together, others lane by lane: with the same bits. A small black
/// square puts the pixels around it into mixed packets and changes none of them.
#[test]
fn mixed_packets_filter_as_whole_ones() {
    let scene = plane(Material { unlit: true, ..Material::default() });
    let mut with_square = scene.clone();
    let corners: [[f32; 2]; 4] = [[-0.05, -0.05], [0.05, -0.05], [0.05, 0.05], [-0.05, 0.05]];
    with_square.meshes.push(Mesh {
        positions: corners.map(|[x, y]| [x, y, -1.0]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: 1,
        ..Mesh::default()
    });
    with_square.instances.push(Instance { name: String::new(), mesh: 1, transform: Transform::IDENTITY });
    with_square.materials.push(Material { unlit: true, base_color: [0.0, 0.0, 0.0, 1.0], ..Material::default() });
    let request = request(Projection::Perspective).samples(4);
    let (without, with) = (render(&scene, &request), render(&with_square, &request));
    // Black takes light away from the pixels that show it, and nothing else can change: their number is that of the
    // square, 1.9 pixels wide, and its border.
    let changed = without.iter().zip(&with).filter(|(a, b)| a.to_bits() != b.to_bits()).count() / 3;
    assert!(without.iter().zip(&with).all(|(a, b)| b <= a), "a pixel gets brighter");
    assert!((4..=4 * 16).contains(&changed), "{changed} pixels change");
}
