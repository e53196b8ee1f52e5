//! Renders of the library and its scenes, pinned to the bit: SHA-256 of every render's arrays, and of the numbers of every scene of
//! the gallery and the first scenes of every recipe, against `pinned/arrays.txt` and `pinned/scenes.txt`.
//!
//! What changes pixels on purpose writes the list anew (`HOLO_PIN=write cargo test --test all pinned::`) and says why in the
//! changelog; nothing else may change a line of it.
//!
//! The arrays are the same for any number of threads and any instruction set. They are pinned on 64-bit Linux with
//! glibc alone, because the gallery's shapes are computed with the system's sine and cosine; and for Embree 4.4.0
//! alone.

use crate::common;
use crate::pins;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::common::{engines, rig};
use holo_core::Projection;
use holo_io::{Limits, Sha256};
use holo_render::{Backend, Denoise, GroundTruth, Integrator, LayerSet, Rendered, Renderer, Request, Reuse};
use holo_scene::recipe::{self, Recipe};
use holo_scene::{Environment, Scene};
use holo_scene::{gallery, gltf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

/// The digest of float values in the order of their axes.
fn digest<'a>(values: impl Iterator<Item = &'a f32>) -> String {
    let bytes: Vec<u8> = values.flat_map(|value| value.to_bits().to_le_bytes()).collect();
    Sha256::of(&bytes).to_string()
}

/// A line for the color, one for its estimated error, and one for the layers of each kind.
fn lines(name: &str, rendered: &Rendered, lines: &mut BTreeMap<String, String>) {
    if let Some(color) = &rendered.color {
        lines.insert(format!("{name}/color"), digest(color.samples().iter()));
    }
    if let Some(error) = &rendered.error {
        lines.insert(format!("{name}/error"), digest(error.samples().iter()));
    }
    lines.insert(format!("{name}/central"), digest(rendered.central.iter().flat_map(|(_, image)| image)));
    if let Some(all) = &rendered.all {
        lines.insert(format!("{name}/all"), digest(all.iter().flat_map(|(_, field)| field.samples().into_iter())));
    }
}

/// The gallery, and a scene from a file with an environment map; built once.
fn scenes() -> &'static [(&'static str, Scene)] {
    static SCENES: OnceLock<Vec<(&str, Scene)>> = OnceLock::new();
    SCENES.get_or_init(built)
}

fn built() -> Vec<(&'static str, Scene)> {
    let mut scenes: Vec<_> =
        gallery::NAMES.iter().map(|&name| (name, gallery::scene(name).expect("a scene of the gallery"))).collect();
    let radiance = folder().join("radiance");
    let mut window = gltf::load(&radiance.join("window.glb"), &gltf::Limits::default()).expect("a scene").scene;
    let map = holo_io::read_hdr(radiance.join("window_sky.hdr"), &Limits::default()).expect("a map");
    window.environment = Some(Environment { radiance: map });
    scenes.push(("window", window));
    scenes
}

fn arrays(backend: Backend, engine: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for &(name, ref scene) in scenes() {
        let renderer = Renderer::new(scene, &scene.cameras[0].pose, backend, None).expect("a renderer");
        let sky = if name == "garden" { [0.3, 0.4, 0.5] } else { [0.0; 3] };
        let focused = |views, lenses, projection| rig(views, lenses, 1e-3, 0.6, projection);
        let dense = focused([5, 6], [12, 17], Projection::Perspective);
        let path = Request::new(dense).samples(3).seed(5).sky(sky).max_bounces(5).reuse(Reuse::Views);
        let mut put = |what: &str, request: Request| {
            let rendered = renderer.render(&request, &()).expect("a render");
            lines(&format!("{engine}/{name}/{what}"), &rendered, &mut found);
        };
        put("path", path.clone().integrator(Integrator::Path));
        put("direct", path.clone().integrator(Integrator::Direct).layers(LayerSet::ALL));
        put("no_indirect", path.clone().indirect(false).samples(1));
        let sparse = focused([1, 2], [19, 23], Projection::Perspective);
        put("adaptive", path.clone().target_error(Some(0.2)).samples(64).camera(sparse));
        put("denoised", path.clone().denoise(Denoise::Views).estimate_error(true));
        let parallel = focused([9, 4], [7, 5], Projection::Orthographic);
        let truth = Request::new(parallel).integrator(Integrator::Depth).layers(LayerSet::ALL);
        put("parallel", truth.clone().ground_truth(GroundTruth::All));
        put("rows", truth.camera(dense).rows(Some(4..9)));
    }
    found
}

/// The digest of all that a scene has, whatever its form in a file.
fn digest_of_scene(scene: &Scene) -> String {
    let Scene { meshes, instances, materials, textures, lights, environment, cameras } = scene;
    let mut bytes = format!("{instances:?} {materials:?} {lights:?} {cameras:?}").into_bytes();
    for mesh in meshes {
        let numbers = [
            mesh.positions.as_flattened(),
            mesh.normals.as_flattened(),
            mesh.tangents.as_flattened(),
            mesh.texture_coordinates.as_flattened(),
            mesh.second_texture_coordinates.as_flattened(),
            mesh.colors.as_flattened(),
        ];
        bytes.extend(numbers.concat().iter().flat_map(|x| x.to_bits().to_le_bytes()));
        bytes.extend(mesh.triangles.as_flattened().iter().flat_map(|k| k.to_le_bytes()));
        bytes.extend(mesh.material.to_le_bytes());
    }
    for texture in textures {
        bytes.extend([texture.width, texture.height].into_iter().flat_map(usize::to_le_bytes));
        bytes.extend(texture.texels.as_flattened());
    }
    let light = environment.iter().flat_map(|environment| &environment.radiance);
    bytes.extend(light.flat_map(|x| x.to_bits().to_le_bytes()));
    Sha256::of(&bytes).to_string()
}

#[test]
fn no_number_of_a_scene_changes() {
    if !is_pinned_here() {
        return;
    }
    let others = gallery::STRATIFIED.iter().chain(gallery::ANIMATED);
    let others = others.map(|&name| (name.to_owned(), gallery::scene(name).expect("a scene of the gallery")));
    let drawn = recipe::NAMES.iter().flat_map(|&name| {
        let recipe = Recipe::by_name(name).expect("a recipe");
        (0..6).map(move |number| (format!("{name}/{number}"), recipe.scene(7, number, 0)))
    });
    let mut found: BTreeMap<String, String> =
        others.chain(drawn).map(|(name, scene)| (name, digest_of_scene(&scene))).collect();
    found.extend(scenes().iter().map(|(name, scene)| ((*name).to_owned(), digest_of_scene(scene))));
    pins::check(&folder().join("pinned").join("scenes.txt"), &found, |_| false);
}

/// Whether this is the system whose bytes are pinned; says so if not.
fn is_pinned_here() -> bool {
    let is_here = cfg!(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"));
    if !is_here {
        println!("not run: the arrays are pinned on 64-bit x86 Linux with glibc");
    }
    is_here
}

#[test]
fn no_bit_of_a_render_changes() {
    if !is_pinned_here() {
        return;
    }
    let list = folder().join("pinned").join("arrays.txt");
    let mut found = BTreeMap::new();
    for backend in engines() {
        let name = Renderer::new(&common::soup(4, 1), &holo_scene::Transform::IDENTITY, backend, NonZeroUsize::new(1))
            .expect("a renderer")
            .engine_name()
            .to_owned();
        let pinned = match name.as_str() {
            "bvh" => Some("bvh"),
            "embree 4.4.0" | "embree 4.4.0 avx2" | "embree 4.4.0 avx512" => pins::embree(),
            _ => None,
        };
        match pinned {
            Some(engine) => found.extend(arrays(backend, engine)),
            None => println!("not run for {name}: the arrays are pinned for Embree 4.4.0 with AVX2 or AVX-512"),
        }
    }
    pins::check(&list, &found, |_| false);
}
