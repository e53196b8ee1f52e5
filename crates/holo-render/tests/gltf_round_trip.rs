//! `to_glb` and back: every scene that validates and that glTF can hold comes back equal.

use holo_render::gltf::{Limits, load_slice, to_glb};
use holo_render::scene::{
    Camera, CameraLens, Instance, Light, LightKind, Material, Mesh, Scene, Texture, TextureUse, Transform, Wrap,
};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

fn name() -> impl Strategy<Value = String> {
    prop_oneof![Just(String::new()), "[a-z]{1,4}", Just("\"\\\u{0}\u{e9} \u{1f600}".to_owned())]
}

/// All sorts of finite numbers, the awkward ones included.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -10.0..10.0,
        -1e7..1e7,
        Just(0.0),
        Just(-0.0),
        Just(1e-300),
        Just(-1e150),
        Just(0.1 + 0.2),
        Just(f64::from_bits(0x3FF0_0000_0000_0001)),
    ]
}

fn float() -> impl Strategy<Value = f32> {
    prop_oneof![-10.0_f32..10.0, -1e7_f32..1e7, Just(f32::MAX), Just(f32::MIN_POSITIVE), Just(1e-45), Just(-0.0)]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [number(), number(), number()]
}

fn unit() -> impl Strategy<Value = [f64; 3]> {
    let axes = (0_usize..3, any::<bool>()).prop_map(|(axis, negative)| {
        let mut v = [0.0; 3];
        v[axis] = if negative { -1.0 } else { 1.0 };
        v
    });
    let any = [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64].prop_filter_map("too short", |v| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        (length > 0.1).then(|| v.map(|x| x / length))
    });
    prop_oneof![axes, any]
}

/// Any affine map: mirrored, sheared, singular.
fn transform() -> impl Strategy<Value = Transform> {
    let general = ([vector(), vector(), vector()], vector())
        .prop_map(|(columns, translation)| Transform { columns, translation });
    prop_oneof![Just(Transform::IDENTITY), vector().prop_map(Transform::from_translation), general]
}

fn mesh(materials: usize) -> impl Strategy<Value = Mesh> {
    (1_usize..9).prop_flat_map(move |n| {
        let optional = move |on: bool| if on { n } else { 0 };
        let normal = || unit().prop_map(|v| v.map(|x| x as f32));
        (
            (name(), vec([float(), float(), float()], n), vec([0..n as u32, 0..n as u32, 0..n as u32], 1..6)),
            any::<bool>().prop_flat_map(move |on| vec(normal(), optional(on))),
            any::<bool>().prop_flat_map(move |on| vec([float(), float()], optional(on))),
            any::<bool>().prop_flat_map(move |on| {
                vec([0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0], optional(on))
            }),
            0..materials,
        )
            .prop_map(|((name, positions, triangles), normals, texture_coordinates, colors, material)| Mesh {
                name,
                positions,
                normals,
                texture_coordinates,
                second_coordinates: vec![],
                colors,
                triangles,
                material,
            })
    })
}

fn wrap() -> impl Strategy<Value = Wrap> {
    prop_oneof![Just(Wrap::Repeat), Just(Wrap::Clamp), Just(Wrap::Mirror)]
}

fn texture() -> impl Strategy<Value = Texture> {
    (1_usize..6, 1_usize..6).prop_flat_map(|(width, height)| {
        (name(), vec(any::<[u8; 4]>(), width * height), wrap(), wrap())
            .prop_map(move |(name, texels, wrap_u, wrap_v)| Texture { name, width, height, texels, wrap_u, wrap_v })
    })
}

fn material(textures: usize) -> impl Strategy<Value = Material> {
    let texture =
        if textures > 0 { option::of((0..textures).prop_map(TextureUse::new)).boxed() } else { Just(None).boxed() };
    (name(), [0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0], texture).prop_map(
        |(name, base_color, base_color_texture)| Material {
            name,
            base_color,
            base_color_texture,
            ..Material::default()
        },
    )
}

fn light() -> impl Strategy<Value = Light> {
    let positive = || prop_oneof![0.0..1e4_f64, Just(0.0), Just(1e-300), Just(1e29), Just(683.0), Just(0.1)];
    let range = || option::of(1e-3..1e3_f64);
    let kind = prop_oneof![
        unit().prop_map(|direction| LightKind::Directional { direction, angular_diameter_rad: 0.0 }),
        (vector(), range()).prop_map(|(position, range)| LightKind::Point { position, range }),
        (vector(), unit(), range(), 0.0..=1.0_f64, 0.01..=std::f64::consts::FRAC_PI_2).prop_map(
            |(position, direction, range, share, outer)| LightKind::Spot {
                position,
                direction,
                range,
                inner_angle_rad: share * outer,
                outer_angle_rad: outer,
            }
        ),
    ];
    (name(), [positive(), positive(), positive()], kind).prop_map(|(name, intensity, kind)| Light {
        name,
        intensity,
        kind,
    })
}

fn camera() -> impl Strategy<Value = Camera> {
    let lens = prop_oneof![
        (0.01..3.1_f64, option::of(0.1..10.0_f64)).prop_map(|(vertical_angle_rad, aspect_ratio)| {
            CameraLens::Perspective { vertical_angle_rad, aspect_ratio }
        }),
        (0.01..100.0_f64, 0.01..100.0_f64)
            .prop_map(|(half_width_m, half_height_m)| CameraLens::Orthographic { half_width_m, half_height_m }),
    ];
    let turned = (vector(), [-1.0..1.0, -1.0..1.0, -1.0..1.0, 0.1..1.0_f64])
        .prop_map(|(translation, rotation)| Transform::from_parts(translation, rotation, [1.0; 3]));
    let pose = prop_oneof![turned, Just(Transform::look_at([4.0, 1.6, 6.5], [0.1, 0.2, -3.0], [0.0, 1.0, 0.0]))];
    (name(), pose, lens).prop_map(|(name, pose, lens)| Camera { name, pose, lens })
}

fn scene() -> impl Strategy<Value = Scene> {
    (0_usize..4, 1_usize..4, 0_usize..4).prop_flat_map(|(textures, materials, meshes)| {
        let instances = if meshes > 0 {
            let instance = (name(), 0..meshes, transform());
            vec(instance.prop_map(|(name, mesh, transform)| Instance { name, mesh, transform }), 0..5).boxed()
        } else {
            Just(Vec::new()).boxed()
        };
        (
            vec(mesh(materials), meshes),
            instances,
            vec(material(textures), materials),
            vec(texture(), textures),
            vec(light(), 0..4),
            vec(camera(), 0..3),
        )
            .prop_map(|(meshes, instances, materials, textures, lights, cameras)| Scene {
                meshes,
                instances,
                materials,
                textures,
                lights,
                cameras,
                environment: None,
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn scenes_come_back_equal(scene in scene()) {
        let bytes = to_glb(&scene).unwrap();
        let loaded = load_slice(&bytes, &Limits::default()).unwrap();
        prop_assert_eq!(&loaded.scene, &scene);
        // What we write ourselves is exactly what we model. (A texture without coordinates is worth a word.)
        prop_assert!(loaded.warnings.iter().all(|line| line.contains("its first texel")), "{:?}", loaded.warnings);
        prop_assert_eq!(to_glb(&loaded.scene).unwrap(), bytes);
    }
}

fn quad() -> Mesh {
    Mesh {
        name: "quad".into(),
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Guards a setting in Cargo.toml: by default serde_json may miss the nearest f64 by one bit.
#[test]
fn json_numbers_are_read_to_the_last_bit() {
    for x in [0.1 + 0.2, 1.0 / 3.0, 5e-324, f64::MAX, std::f64::consts::PI * 1e-200, 123_456_789.123_456_79] {
        let read: f64 = serde_json::from_str(&serde_json::to_string(&x).unwrap()).unwrap();
        assert_eq!(read.to_bits(), x.to_bits(), "{x}: the feature float_roundtrip of serde_json is missing");
    }
    let (mut bits, mut wrong) = (1_u64, 0);
    for _ in 0..10_000 {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let x = f64::from_bits(bits >> 12 | 0x3FF0_0000_0000_0000) - 1.0;
        let read: f64 = serde_json::from_str(&x.to_string()).unwrap();
        wrong += usize::from(read != x);
    }
    assert_eq!(wrong, 0, "the feature float_roundtrip of serde_json is missing");
}

#[test]
fn an_empty_scene_comes_back() {
    let bytes = to_glb(&Scene::default()).unwrap();
    let loaded = load_slice(&bytes, &Limits::default()).unwrap();
    assert_eq!(loaded.scene, Scene::default());
    assert_eq!(loaded.warnings, [""; 0]);
    assert!(
        bytes.len().is_multiple_of(4) && loaded.summary.generator.is_some_and(|name| name.starts_with("holo-render "))
    );
}

#[test]
fn directions_and_axes_that_are_a_little_off_come_back_within_the_bound() {
    // As single precision leaves them: valid, but not exactly of length one.
    let off = 1.0 + 9e-7;
    let scene = Scene {
        lights: vec![Light {
            name: String::new(),
            intensity: [1.0; 3],
            kind: LightKind::Directional { direction: [0.6 * off, 0.0, -0.8 * off], angular_diameter_rad: 0.0 },
        }],
        cameras: vec![Camera {
            name: String::new(),
            pose: Transform { columns: [[off, 0.0, 0.0], [0.0, 1.0, 5e-7], [0.0, 0.0, off]], translation: [0.0; 3] },
            lens: CameraLens::Orthographic { half_width_m: 1.0, half_height_m: 1.0 },
        }],
        ..Scene::default()
    };
    let back = load_slice(&to_glb(&scene).unwrap(), &Limits::default()).unwrap().scene;
    let LightKind::Directional { direction, .. } = back.lights[0].kind else { panic!("{:?}", back.lights) };
    let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-6);
    assert!(close(direction, [0.6, 0.0, -0.8]));
    for (axis, expected) in back.cameras[0].pose.columns.into_iter().zip(scene.cameras[0].pose.columns) {
        assert!(close(axis, expected), "{axis:?} instead of {expected:?}");
    }
}

#[test]
fn scenes_that_cannot_be_written_are_refused() {
    let with = |mesh: Mesh| Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() };
    assert!(to_glb(&with(quad())).is_ok());
    let empty = to_glb(&with(Mesh { triangles: Vec::new(), ..quad() })).unwrap_err().to_string();
    assert!(empty.contains("meshes[0]") && empty.contains("no triangles"), "{empty}");
    let broken = to_glb(&with(Mesh { triangles: vec![[0, 1, 9]], ..quad() })).unwrap_err().to_string();
    assert!(broken.contains("meshes[0].triangles[0]"), "{broken}");
}

/// The reference scene that came with the task; not part of the project.
#[test]
fn a_blender_export_loads() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let shared = std::env::var_os("HOLO_SHARED").unwrap_or_else(|| beside.into());
    let path = std::path::Path::new(&shared).join("reference/still_life.glb");
    if !path.is_file() {
        eprintln!("skipped: {} is not there (set HOLO_SHARED)", path.display());
        return;
    }
    let loaded = holo_render::gltf::load(&path, &Limits::default()).unwrap();
    let summary = &loaded.summary;
    assert!(summary.triangles > 300_000, "{summary}");
    assert_eq!((summary.lights, summary.cameras.len(), summary.textures), (2, 1, 2));
    assert!(loaded.warnings.len() < 8, "{:#?}", loaded.warnings);
    // Everything survives our own writer.
    let again = load_slice(&to_glb(&loaded.scene).unwrap(), &Limits::default()).unwrap();
    assert_eq!(again.scene, loaded.scene);
}
