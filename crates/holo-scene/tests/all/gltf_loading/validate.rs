//! `Scene::validate`: a valid scene, and one invalid scene for every error.

use holo_scene::{
    Camera, CameraProjection, Instance, Light, LightKind, Material, Mesh, Scene, Texture, TextureInfo, Transform,
    Volume, Wrap,
};

use super::support::assert_contains;

fn scene() -> Scene {
    Scene {
        meshes: vec![Mesh {
            name: "m".into(),
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.6, 0.8]; 3],
            texture_coordinates: vec![[0.0; 2]; 3],
            colors: vec![[0.5; 4]; 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY }],
        materials: vec![Material { base_color_texture: Some(TextureInfo::new(0)), ..Material::default() }],
        textures: vec![Texture {
            name: String::new(),
            width: 2,
            height: 1,
            texels: vec![[0; 4]; 2],
            wrap_u: Wrap::Clamp,
            wrap_v: Wrap::Repeat,
            filter: holo_scene::Filter::Linear,
        }],
        lights: vec![Light {
            name: String::new(),
            intensity: [1.0; 3],
            kind: LightKind::Spot {
                position: [0.0; 3],
                direction: [0.0, 0.6, 0.8],
                range: Some(1.0),
                inner_angle_rad: 0.1,
                outer_angle_rad: 0.2,
            },
        }],
        cameras: vec![Camera {
            name: String::new(),
            pose: Transform::IDENTITY,
            projection: CameraProjection::Perspective { vertical_angle_rad: 1.0, aspect_ratio: None },
        }],
        environment: None,
    }
}

/// Makes the scene invalid; returns the error message.
fn broken(change: impl FnOnce(&mut Scene)) -> String {
    let mut scene = scene();
    change(&mut scene);
    scene.validate().expect_err("validated, although it is broken").to_string()
}

#[test]
fn a_valid_scene_passes() {
    scene().validate().unwrap();
    Scene::default().validate().unwrap();
}

#[test]
fn meshes() {
    assert_contains(&broken(|s| s.meshes[0].triangles[0][1] = 3), &["meshes[0].triangles[0]", "3 vertices"]);
    assert_contains(&broken(|s| s.meshes[0].positions[2][0] = f32::NAN), &["meshes[0].positions[2]", "finite"]);
    assert_contains(&broken(|s| s.meshes[0].normals[1] = [0.0; 3]), &["meshes[0].normals[1]", "length 1"]);
    assert_contains(&broken(|s| s.meshes[0].normals[1][0] = f32::NAN), &["meshes[0].normals[1]"]);
    assert_contains(&broken(|s| s.meshes[0].texture_coordinates[0][1] = f32::INFINITY), &["texture_coordinates[0]"]);
    assert_contains(&broken(|s| s.meshes[0].colors[0][3] = 1.5), &["meshes[0].colors[0]"]);
    assert_contains(&broken(|s| s.meshes[0].colors[0][3] = f32::NAN), &["meshes[0].colors[0]"]);
    assert_contains(&broken(|s| s.meshes[0].normals.truncate(2)), &["meshes[0].normals", "2 entries for 3 vertices"]);
    assert_contains(&broken(|s| s.meshes[0].colors.truncate(2)), &["meshes[0].colors"]);
    assert_contains(&broken(|s| s.meshes[0].texture_coordinates.truncate(2)), &["meshes[0].texture_coordinates"]);
    assert_contains(&broken(|s| s.meshes[0].material = 1), &["meshes[0].material", "1"]);
    assert_contains(&broken(|s| s.instances[0].mesh = 9), &["instances[0].mesh"]);
    assert_contains(&broken(|s| s.instances[0].transform.columns[1][1] = f64::NAN), &["instances[0].transform"]);
}

#[test]
fn the_first_error_is_reported() {
    let message = broken(|s| {
        s.meshes[0].triangles = vec![[0, 1, 2]; 100_000];
        s.meshes[0].triangles[70_001][2] = 7;
        s.meshes[0].triangles[90_001][2] = 7;
    });
    assert_contains(&message, &["triangles[70001]"]);
}

#[test]
fn materials_and_textures() {
    assert_contains(&broken(|s| s.materials[0].base_color[0] = -0.1), &["materials[0].base_color"]);
    assert_contains(&broken(|s| s.materials[0].base_color[0] = f32::NAN), &["materials[0].base_color"]);
    assert_contains(&broken(|s| s.textures.clear()), &["materials[0].base_color_texture"]);
    let volume = |attenuation_distance_m: f32, blue: f32| {
        let volume = Volume { attenuation_distance_m, attenuation_color: [1.0, 1.0, blue] };
        broken(|s| s.materials[0].volume = Some(volume))
    };
    for blue in [0.0, f32::MIN_POSITIVE / 2.0, 1.1, f32::NAN] {
        assert_contains(&volume(1.0, blue), &["materials[0].volume.attenuation_color"]);
    }
    for distance in [0.0, -1.0, f32::NAN] {
        assert_contains(&volume(distance, 1.0), &["materials[0].volume.attenuation_distance_m"]);
    }
    assert_contains(&broken(|s| s.textures[0].width = 3), &["textures[0]", "3 x 1", "2"]);
    assert_contains(&broken(|s| s.textures[0].height = 0), &["textures[0]"]);
    assert_contains(&broken(|s| (s.textures[0].width, s.textures[0].height) = (1 << 31, usize::MAX)), &["textures[0]"]);
}

#[test]
fn lights() {
    let spot = |position, direction, range, inner_angle_rad, outer_angle_rad| {
        let kind = LightKind::Spot { position, direction, range, inner_angle_rad, outer_angle_rad };
        broken(|s| s.lights[0].kind = kind)
    };
    let (at, along) = ([0.0; 3], [0.0, 0.6, 0.8]);
    assert_contains(&spot([f64::NAN, 0.0, 0.0], along, None, 0.1, 0.2), &["lights[0].position"]);
    assert_contains(&spot(at, [f64::NAN, 0.6, 0.8], None, 0.1, 0.2), &["lights[0].direction"]);
    assert_contains(&spot(at, [0.0, 0.61, 0.8], None, 0.1, 0.2), &["lights[0].direction", "length 1"]);
    assert_contains(&spot(at, along, Some(0.0), 0.1, 0.2), &["lights[0].range"]);
    assert_contains(&spot(at, along, Some(f64::INFINITY), 0.1, 0.2), &["lights[0].range"]);
    assert_contains(&spot(at, along, None, 0.3, 0.2), &["lights[0].angles"]);
    assert_contains(&spot(at, along, None, 0.1, 1.6), &["lights[0].angles"]);
    assert_contains(&spot(at, along, None, 0.1, f64::NAN), &["lights[0].angles"]);
    assert_contains(&broken(|s| s.lights[0].intensity[1] = -1.0), &["lights[0].intensity"]);
    assert_contains(&broken(|s| s.lights[0].intensity[1] = f64::NAN), &["lights[0].intensity"]);
}

#[test]
fn cameras() {
    let error_of = |projection: CameraProjection| broken(|s| s.cameras[0].projection = projection);
    for angle in [0.0, -1.0, std::f64::consts::PI, f64::NAN] {
        let error = error_of(CameraProjection::Perspective { vertical_angle_rad: angle, aspect_ratio: None });
        assert_contains(&error, &["cameras[0].projection"]);
    }
    assert_contains(
        &error_of(CameraProjection::Perspective { vertical_angle_rad: 1.0, aspect_ratio: Some(0.0) }),
        &["cameras[0].projection"],
    );
    assert_contains(
        &error_of(CameraProjection::Orthographic { half_width_m: 1.0, half_height_m: f64::INFINITY }),
        &["cameras[0].projection"],
    );
    assert_contains(&broken(|s| s.cameras[0].pose.columns[0] = [2.0, 0.0, 0.0]), &["cameras[0].pose", "rotation"]);
    assert_contains(&broken(|s| s.cameras[0].pose.columns[0] = [-1.0, 0.0, 0.0]), &["cameras[0].pose", "mirroring"]);
    assert_contains(&broken(|s| s.cameras[0].pose.translation[0] = f64::NAN), &["cameras[0].pose"]);
}
