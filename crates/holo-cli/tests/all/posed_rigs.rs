//! Light fields at poses: correspondences, and their views as cameras.

use crate::camera_array::{boxes, deviation, image, numbers};
use crate::common::{Bench, CAMERA, ok};
use holo_io::{ArrayCamera, ArrayFolder, CameraArray, Limits, WorldUp, read_pfm_gray};
use serde_json::Value;

/// An array of float64 in a file of numpy, with its shape.
fn npy(bench: &Bench, name: &str) -> (Vec<usize>, Vec<f64>) {
    let bytes = std::fs::read(bench.path(name)).unwrap();
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.contains("'<f8'"), "{header}");
    let shape = header.split(['(', ')']).nth(1).unwrap();
    let shape = shape.split(',').filter_map(|count| count.trim().parse().ok()).collect();
    (shape, bytes[10 + length..].chunks_exact(8).map(|x| f64::from_le_bytes(x.try_into().unwrap())).collect())
}

/// Three rigs of 5 x 4 views that look at boxes from poses of their own.
fn three_rigs(bench: &Bench) {
    std::fs::write(bench.path("boxes.glb"), holo_scene::gltf::to_glb(&boxes()).unwrap()).unwrap();
    ok(bench.run(
        "array plane --count 3 --spacing-m 0.4 --radius-m 3 --target 0,0,0.5 --size 60x40 --fov-deg 50 --seed 4 --jitter-rotation-deg 4 \
         --jitter-position-m 0.1 --out in.json",
    ));
    ok(bench.run(
        "render boxes.glb --transforms in.json --views 5x4 --baseline-m 0.03 --focus-m 2.6 --spp 64 --exposure 0 --ground-truth all \
         --layers depth,disparity --write el --out rigs",
    ));
}

/// Points that two rigs see: the numbers of the files, put together by hand, lead from a pixel of one view to the surface and on to the
/// place in a view of another rig; the surface is the one of the scene; and colors of both agree.
#[test]
fn points_are_found_in_the_views_of_another_rig() {
    let bench = Bench::new();
    three_rigs(&bench);
    let (from, to) = ((3, 1), (0, 2));
    ok(bench.run("correspond rigs --from camera_0000:3,1 --to camera_0002:0,2 --out found.npy"));
    let (shape, found) = npy(&bench, "found.npy");
    assert_eq!(shape, [40, 60, 4]);
    let text = std::fs::read_to_string(bench.path("rigs/transforms.json")).unwrap();
    let frames: Value = serde_json::from_str(&text).unwrap();
    // The world of the file has Z up. A view stands 3 cm from the next, and its image is shifted so that all see one plane at 2.6 m.
    let view = |frame: usize, (s, t): (usize, usize)| {
        let frame = &frames["frames"][frame];
        let matrix: Vec<Vec<f64>> = frame["transform_matrix"].as_array().unwrap().iter().map(numbers).collect();
        let number = |key: &str| frame[key].as_f64().unwrap();
        let (x, y) = (0.03 * (s as f64 - 2.0), 0.03 * (1.5 - t as f64));
        let (focal, cx, cy) = (number("fl_x"), number("cx"), number("cy"));
        let middle = [cx + focal * x / 2.6 - 0.5, cy - focal * y / 2.6 - 0.5];
        let eye: [f64; 3] = std::array::from_fn(|k| matrix[k][3] + x * matrix[k][0] + y * matrix[k][1]);
        (matrix, eye, focal, middle)
    };
    let (a, eye_a, focal_a, middle_a) = view(0, from);
    let (b, eye_b, focal_b, middle_b) = view(2, to);
    let name = |folder: usize, (s, t): (usize, usize)| {
        format!("rigs/camera_000{folder}/depth/scene_depth_Cam{:03}.pfm", 5 * t + s)
    };
    let depth = read_pfm_gray(bench.path(name(0, from)), &Limits::default()).unwrap();
    let colors = |folder: usize, (s, t): (usize, usize)| {
        ok(bench.run(&format!("extract rigs/camera_000{folder} --view {s},{t} --out view_{folder}.png")));
        image(&bench, &format!("view_{folder}.png"))
    };
    let (image_a, image_b) = (colors(0, from), colors(2, to));
    let (mut seen, mut hidden, mut off, mut wall) = (0, 0, 0.0, 0);
    for (index, found) in found.chunks_exact(4).enumerate() {
        let (row, column) = (index / 60, index % 60);
        let z = f64::from(depth[[row, column]]);
        let (x, y) = ((column as f64 - middle_a[0]) / focal_a * z, (middle_a[1] - row as f64) / focal_a * z);
        let point: [f64; 3] = std::array::from_fn(|k| eye_a[k] + x * a[k][0] + y * a[k][1] - z * a[k][2]);
        let along = |axis: usize| (0..3).map(|k| b[k][axis] * (point[k] - eye_b[k])).sum::<f64>();
        let z_b = -along(2);
        let expected = [middle_b[1] - along(1) / z_b * focal_b, middle_b[0] + along(0) / z_b * focal_b, z_b];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{row} {column}: {found} {expected}");
        }
        // The wall.
        wall += usize::from((point[1] - 0.6).abs() < 2e-6);
        let at = [found[0].round() as usize, found[1].round() as usize];
        match found[3] {
            1.0 => {
                seen += 1;
                off += (image_a[[row, column, 0]] - image_b[[at[0].min(39), at[1].min(59), 0]]).abs();
            }
            _ => hidden += usize::from((0.0..39.0).contains(&found[0]) && (0.0..59.0).contains(&found[1])),
        }
    }
    // Depth is rounded to f32: 2e-7 m. Light is that of pixels, at the nearest one.
    assert!(seen > 900 && hidden > 10 && wall > 1000, "{seen} {hidden} {wall}");
    assert!(off / f64::from(seen) < 0.02, "{}", off / f64::from(seen));
}

/// All views of light fields at poses are cameras: of one rig they refocus as the rig does, and those of all see around the boxes.
#[test]
fn views_of_rigs_are_cameras() {
    let bench = Bench::new();
    three_rigs(&bench);
    let outcome = bench.run("refocus rigs --distance-m 2.4 --out all.pfm");
    assert!(outcome.stderr.contains("images of 60 cameras"), "{outcome:?}");
    let text = std::fs::read_to_string(bench.path("rigs/transforms.json")).unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    file["frames"].as_array_mut().unwrap().truncate(1);
    std::fs::write(bench.path("rigs/transforms.json"), file.to_string()).unwrap();
    ok(bench.run("refocus rigs --distance-m 2.4 --out array.pfm"));
    ok(bench.run("refocus rigs/camera_0000 --distance-m 2.4 --out rig.pfm"));
    // The view in the middle of four rows of views lies between them; the rig's is the one below.
    let central = bench.run("extract rigs/camera_0000 --view 2,2 --out central.png");
    ok(central);
    let (rig, array) = (image(&bench, "rig.pfm"), image(&bench, "array.pfm"));
    let central = image(&bench, "central.png");
    println!("{} {}", deviation(&rig, &array, 4), deviation(&rig, &central, 4));
    assert!(deviation(&rig, &array, 4) < 0.2 * deviation(&rig, &central, 4));
    std::fs::write(bench.path("rigs/transforms.json"), text).unwrap();
    ok(bench.run("correspond rigs --from camera_0001 --out found.npy"));
    assert!(bench.path("found_camera_0000.npy").exists() && bench.path("found_camera_0002.npy").exists());
    ok(bench.run("synthesize rigs --eye 0.1,2.9,1 --target 0,0,0.5 --out made.png"));
    for (line, part) in [
        ("correspond rigs --from camera_0009 --out x.npy", "no such camera; it has camera_0000:2,2"),
        ("correspond rigs --from camera_0001 --to camera_0000:5,0 --out x.npy", "no such camera"),
        ("correspond rigs --from camera_0001 --out x.png", ".npy"),
        (
            "view rigs --out x.html",
            "3 cameras or light fields at poses, which are no grid of views; of light fields name one",
        ),
        ("depth rigs --out x.pfm", "give --depths-m NEAR,FAR"),
        ("depth rigs --depths-m 1,4 --camera b --out x.pfm", "no such camera"),
        ("correspond rigs/camera_0000 --from a --out x.npy", "transforms.json"),
    ] {
        let outcome = bench.run(line);
        assert!(outcome.code != Some(0) && outcome.stderr.contains(part), "{line}: {outcome:?}");
    }
    assert!(bench.run("info rigs").stdout.contains("3 cameras or light fields at poses"));
}

/// Raw images at poses, decoded: their central views are what pinholes see that stand there; those of another pose are not.
#[test]
fn decoded_views_of_raw_images_stand_at_their_poses() {
    let bench = Bench::new();
    std::fs::write(bench.path("boxes.glb"), holo_scene::gltf::to_glb(&boxes()).unwrap()).unwrap();
    let camera =
        CAMERA.replace("[60, 45]", "[720, 480]").replace("40.0", "4.0").replace("focus_m = 0.8", "focus_m = 2.6");
    std::fs::write(bench.path("own.toml"), camera).unwrap();
    ok(bench.run(
        "array plane --count 3 --spacing-m 0.4 --radius-m 3 --target 0,0,0.5 --size 60x40 --fov-deg 50 --seed 4 --jitter-rotation-deg 4 \
         --jitter-position-m 0.1 --out in.json",
    ));
    ok(bench.run("render boxes.glb --transforms in.json --camera-file own.toml --spp 16 --exposure 0 --out raws"));
    let raws = ArrayFolder::open(bench.path("raws"), WorldUp::Z).unwrap();
    let central = raws.central_cameras();
    let pinholes = central.iter().map(|&k| {
        let pinhole = raws.pinhole(k).unwrap();
        let [x, y, z, _] = raws.cameras()[k].axes_and_position;
        ArrayCamera {
            name: format!("camera_{k}"),
            axes_and_position: [x, y, z, pinhole.position_m()],
            focal_px: pinhole.focal_px(),
            size: Some(pinhole.size()),
            ..ArrayCamera::default()
        }
    });
    let pinholes = CameraArray { cameras: pinholes.collect() };
    pinholes.write(bench.path("pinholes.json"), WorldUp::Z).unwrap();
    ok(bench.run("render boxes.glb --transforms pinholes.json --spp 64 --exposure 0 --out seen"));
    let seen = ArrayFolder::open(bench.path("seen"), WorldUp::Z).unwrap();
    let read = |folder: &ArrayFolder, k: usize| folder.image(k, &Limits::default()).unwrap().mapv(f64::from);
    for (k, &view) in central.iter().enumerate() {
        let decoded = read(&raws, view);
        let own = deviation(&decoded, &read(&seen, k), 2);
        let other = deviation(&decoded, &read(&seen, (k + 1) % 3), 2);
        println!("{own} {other}");
        assert!(own < other / 3.0, "{own} {other}");
    }
}
