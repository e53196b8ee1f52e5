//! The round trip through `to_glb` and `load_slice` is exact for every valid scene that glTF can represent.

use holo_scene::gltf::{Limits, load_slice, to_glb};
use holo_scene::{
    Alpha, Anisotropy, Camera, CameraProjection, Clearcoat, DiffuseTransmission, Environment, Filter, Instance,
    Iridescence, Light, LightKind, Material, Mesh, NormalMap, Scene, Sheen, Texture, TextureInfo, TextureTransform,
    Transform, Volume, Wrap,
};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

fn name() -> impl Strategy<Value = String> {
    prop_oneof![Just(String::new()), "[a-z]{1,4}", Just("\"\\\u{0}\u{e9} \u{1f600}".to_owned())]
}

/// Finite numbers, including extreme ones.
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

/// Affine maps, including mirrored, sheared and singular ones.
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
            any::<[bool; 2]>().prop_flat_map(move |on| on.map(|on| vec([float(), float()], optional(on)))),
            any::<bool>().prop_flat_map(move |on| {
                vec([0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0], optional(on))
            }),
            0..materials,
        )
            .prop_map(|((name, positions, triangles), normals, coordinates, colors, material)| Mesh {
                name,
                positions,
                normals,
                tangents: Vec::new(),
                texture_coordinates: coordinates[0].clone(),
                second_texture_coordinates: coordinates[1].clone(),
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
        let filter = prop_oneof![Just(Filter::Linear), Just(Filter::Nearest)];
        (name(), vec(any::<[u8; 4]>(), width * height), wrap(), wrap(), filter).prop_map(
            move |(name, texels, wrap_u, wrap_v, filter)| Texture {
                name,
                width,
                height,
                texels,
                wrap_u,
                wrap_v,
                filter,
            },
        )
    })
}

/// From 0 to 1, including both ends.
fn share() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0_f32), Just(1.0_f32), 0.0_f32..=1.0, Just(1e-45_f32), Just(0.1_f32)]
}

/// From 0 to [`holo_scene::MAX_RADIANCE`].
fn strength() -> impl Strategy<Value = f32> {
    prop_oneof![share(), 0.0_f32..1e4, Just(1e30_f32), Just(683.1_f32), Just(f32::MIN_POSITIVE)]
}

fn texture_use(textures: usize) -> impl Strategy<Value = Option<TextureInfo>> + Clone {
    if textures == 0 {
        return Just(None).boxed();
    }
    let transform = ([float(), float()], float(), [float(), float()])
        .prop_map(|(offset, rotation_rad, scale)| TextureTransform { offset, rotation_rad, scale });
    let transform = prop_oneof![Just(TextureTransform::IDENTITY), transform];
    let used = (0..textures, 0..2_usize, transform);
    option::of(used.prop_map(|(texture, set, transform)| TextureInfo { texture, set, transform })).boxed()
}

type Layers =
    (Option<Clearcoat>, Option<Sheen>, Option<Anisotropy>, Option<Iridescence>, Option<DiffuseTransmission>, f32);

fn layers(textures: usize) -> impl Strategy<Value = Layers> {
    let used = || texture_use(textures);
    let color = || [share(), share(), share()];
    let size = || prop_oneof![Just(0.0_f32), 0.0_f32..1e3, Just(f32::MAX)];
    let clearcoat = (share(), used(), share(), used(), used(), float()).prop_map(
        |(factor, texture, roughness, roughness_texture, map, scale)| {
            let normal_map = map.map(|texture| NormalMap { texture, scale });
            Clearcoat { factor, texture, roughness, roughness_texture, normal_map }
        },
    );
    let sheen = (color(), used(), share(), used()).prop_map(|(color, color_texture, roughness, roughness_texture)| {
        Sheen { color, color_texture, roughness, roughness_texture }
    });
    let anisotropy = (share(), float(), used()).prop_map(|(strength, rotation_rad, texture)| Anisotropy {
        strength,
        rotation_rad,
        texture,
    });
    let iridescence = (share(), used(), 1.0_f32..3.0, [size(), size()], used()).prop_map(
        |(factor, texture, ior, thickness_nm, thickness_texture)| Iridescence {
            factor,
            texture,
            ior,
            thickness_nm,
            thickness_texture,
        },
    );
    let through = (share(), used(), color(), used()).prop_map(|(factor, texture, color, color_texture)| {
        DiffuseTransmission { factor, texture, color, color_texture }
    });
    let last = (option::of(iridescence), option::of(through), size());
    let first = (option::of(clearcoat), option::of(sheen), option::of(anisotropy));
    (first, last).prop_map(|((a, b, c), (d, e, f))| (a, b, c, d, e, f))
}

fn material(textures: usize) -> impl Strategy<Value = Material> {
    let used = texture_use(textures);
    let uses = [used.clone(), used.clone(), used.clone(), used.clone(), used.clone(), used.clone(), used];
    let alpha = prop_oneof![
        Just(Alpha::Opaque),
        Just(Alpha::Blend),
        prop_oneof![share(), 0.0_f32..9.0, Just(0.5_f32), Just(f32::MAX)].prop_map(Alpha::Mask)
    ];
    let distance = prop_oneof![Just(f32::INFINITY), Just(1e-45_f32), Just(f32::MAX), 1e-3_f32..1e3];
    let left = || prop_oneof![Just(1.0_f32), Just(f32::MIN_POSITIVE), 0.01_f32..=1.0];
    let volume = option::of(
        (distance, [left(), left(), left()])
            .prop_map(|(distance, attenuation_color)| Volume { attenuation_distance_m: distance, attenuation_color }),
    );
    let color = || prop_oneof![Just([1.0_f32; 3]), Just([0.0_f32; 3]), [strength(), strength(), strength()]];
    let ior = prop_oneof![Just(1.5_f32), Just(1.0_f32), Just(1000.0_f32), 1.0_f32..3.0];
    (
        (name(), [share(), share(), share(), share()], uses, float()),
        (share(), share(), share(), share()),
        (color(), color(), alpha, ior, volume, any::<[bool; 2]>()),
        layers(textures),
    )
        .prop_map(|((name, base_color, uses, scale), shares, others, layers)| {
            let (clearcoat, sheen, anisotropy, iridescence, diffuse_transmission, dispersion) = layers;
            let (metallic, roughness, specular, transmission) = shares;
            let (emission, specular_color, alpha, ior, volume, [double_sided, unlit]) = others;
            Material {
                name,
                base_color,
                base_color_texture: uses[0],
                metallic,
                roughness,
                metallic_roughness_texture: uses[1],
                normal_map: uses[2].map(|texture| NormalMap { texture, scale }),
                emission,
                emission_texture: uses[3],
                alpha,
                double_sided,
                specular,
                specular_texture: uses[4],
                specular_color,
                specular_color_texture: uses[5],
                ior,
                transmission,
                transmission_texture: uses[6],
                volume,
                dispersion,
                clearcoat,
                sheen,
                anisotropy,
                iridescence,
                diffuse_transmission,
                unlit,
            }
        })
}

fn light() -> impl Strategy<Value = Light> {
    let positive = || prop_oneof![0.0..1e4_f64, Just(0.0), Just(1e-300), Just(1e29), Just(683.0), Just(0.1)];
    let range = || option::of(1e-3..1e3_f64);
    let kind = prop_oneof![
        (unit(), prop_oneof![Just(0.0), Just(std::f64::consts::PI), 0.0..0.1])
            .prop_map(|(direction, angular_diameter_rad)| LightKind::Directional { direction, angular_diameter_rad }),
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
    let projection = prop_oneof![
        (0.01..3.1_f64, option::of(0.1..10.0_f64)).prop_map(|(vertical_angle_rad, aspect_ratio)| {
            CameraProjection::Perspective { vertical_angle_rad, aspect_ratio }
        }),
        (0.01..100.0_f64, 0.01..100.0_f64)
            .prop_map(|(half_width_m, half_height_m)| CameraProjection::Orthographic { half_width_m, half_height_m }),
    ];
    let turned = (vector(), [-1.0..1.0, -1.0..1.0, -1.0..1.0, 0.1..1.0_f64])
        .prop_map(|(translation, rotation)| Transform::from_parts(translation, rotation, [1.0; 3]));
    let pose = prop_oneof![turned, Just(Transform::look_at([4.0, 1.6, 6.5], [0.1, 0.2, -3.0], [0.0, 1.0, 0.0]))];
    (name(), pose, projection).prop_map(|(name, pose, projection)| Camera { name, pose, projection })
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
    fn scenes_come_back_equal(mut scene in scene()) {
        scene.add_tangents().unwrap();
        let bytes = to_glb(&scene).unwrap();
        let loaded = load_slice(&bytes, &Limits::default()).unwrap();
        prop_assert_eq!(&loaded.scene, &scene);
        // Files of the writer load without warnings, except for textures on meshes without coordinates, and bodies of
        // thin glass that happen to be closed.
        let expected = |line: &String| line.contains("its first texel") || line.contains("soap bubble");
        prop_assert!(loaded.warnings.iter().all(expected), "{:?}", loaded.warnings);
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

/// Tests a feature in Cargo.toml: by default serde_json may be off by one bit from the nearest f64.
#[test]
fn json_numbers_are_read_exactly() {
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
fn an_empty_scene_round_trips() {
    let bytes = to_glb(&Scene::default()).unwrap();
    let loaded = load_slice(&bytes, &Limits::default()).unwrap();
    assert_eq!(loaded.scene, Scene::default());
    assert_eq!(loaded.warnings, [""; 0]);
    assert!(bytes.len().is_multiple_of(4));
    assert_eq!(loaded.summary.generator.as_deref(), Some("holo"));
}

/// A Lambertian surface has only the extension that sets `specularFactor` to 0.
#[test]
fn lambertian_materials_need_one_extension() {
    let json = |material: Material| {
        let bytes = to_glb(&Scene { materials: vec![material], ..Scene::default() }).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice::<serde_json::Value>(&bytes[20..20 + length]).unwrap()
    };
    let file = json(Material::default());
    assert_eq!(file["extensionsUsed"], serde_json::json!(["KHR_materials_specular"]));
    let expected = serde_json::json!({
        "pbrMetallicRoughness":
            { "baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0 },
        "doubleSided": true,
        "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } },
    });
    assert_eq!(file["materials"][0], expected);
    // The default specular reflection of glTF needs no extension.
    let file = json(Material { specular: 1.0, emission: [1.0, 0.5, 0.0], ..Material::default() });
    assert_eq!(file.get("extensionsUsed"), None);
    // Factors are within 0..1; the strength is a power of two, so that nothing is rounded.
    let file = json(Material { emission: [5.1, 0.1, 0.0], ..Material::default() });
    assert_eq!(file["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 8.0);
    assert_eq!(file["materials"][0]["emissiveFactor"][0], f64::from(5.1_f32) / 8.0);
    assert_eq!(
        file["extensionsUsed"],
        serde_json::json!(["KHR_materials_emissive_strength", "KHR_materials_specular"])
    );
}

/// glTF cannot represent an environment map.
#[test]
fn the_environment_is_omitted() {
    let environment = Some(Environment { radiance: ndarray::Array3::ones((1, 2, 3)) });
    let bytes = to_glb(&Scene { environment, ..Scene::default() }).unwrap();
    assert_eq!(bytes, to_glb(&Scene::default()).unwrap());
}

#[test]
fn directions_and_axes_that_are_a_little_off_come_back_within_the_bound() {
    // Rounded to f32: valid, but not exactly unit vectors.
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
            projection: CameraProjection::Orthographic { half_width_m: 1.0, half_height_m: 1.0 },
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
fn scenes_that_cannot_be_written_are_rejected() {
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
    let loaded = holo_scene::gltf::load(&path, &Limits::default()).unwrap();
    let summary = &loaded.summary;
    assert!(summary.triangles > 300_000, "{summary}");
    assert_eq!((summary.lights, summary.cameras.len(), summary.textures), (2, 1, 2));
    assert!(loaded.warnings.len() < 8, "{:#?}", loaded.warnings);
    // The round trip through the writer is exact.
    let again = load_slice(&to_glb(&loaded.scene).unwrap(), &Limits::default()).unwrap();
    assert_eq!(again.scene, loaded.scene);
}
