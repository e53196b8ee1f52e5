//! Raw images of Lytro's cameras, made here from renders: containers, packed codes, white images.

use crate::common::{Bench, SCENE, succeeds};
use holo_core::DynImage;
use holo_io::interop::LytroModel;
use holo_io::{CameraFile, Limits};
use ndarray::{Array2, Axis};
use serde_json::{Value, json};

/// An Illum with a part of its sensor, as its own metadata describe it.
const PART: &str = "preset = \"lytro-illum\"\n[sensor]\nsize_px = [240, 160]\n";

/// Codes of an image file.
fn codes(bench: &Bench, name: &str) -> Array2<u16> {
    match holo_io::read_png(bench.path(name), &Limits::default()).unwrap() {
        DynImage::U16(codes) => codes.index_axis_move(Axis(2), 0),
        other => panic!("{:?}", other.kind()),
    }
}

/// The metadata of the camera with the part's size.
fn metadata(bench: &Bench) -> Value {
    let whole = CameraFile::preset("lytro-illum").unwrap().camera;
    let mut metadata: Value = serde_json::from_str(&LytroModel::Illum.image_metadata(&whole)).unwrap();
    let size = CameraFile::read(bench.path("part.toml")).unwrap().camera.sensor().size;
    (metadata["image"]["width"], metadata["image"]["height"]) = (size.columns.into(), size.rows.into());
    metadata
}

/// A section of a container.
fn section(kind: u8, name: &str, data: &[u8]) -> Vec<u8> {
    let mut out = vec![0x89, b'L', b'F', kind, b'\r', b'\n', 0x1a, b'\n', 0, 0, 0, u8::from(kind == b'P')];
    out.extend((data.len() as u32).to_be_bytes());
    if !data.is_empty() {
        let mut name = name.as_bytes().to_vec();
        name.resize(80, 0);
        out.extend(name);
        out.extend(data);
        out.resize(out.len().next_multiple_of(16), 0);
    }
    out
}

/// The light field in a folder, in linear light at its own exposure.
fn views(bench: &Bench, folder: &str) -> holo_core::LightFieldOwned<f32> {
    let options = holo_io::ReadOptions::default();
    let read = holo_io::LightFieldReader::open(bench.path(folder), &options).unwrap().read().unwrap();
    read.light_field.into_linear(read.color_encoding).unwrap()
}

/// By how much two images of any scale differ, relative to their light.
fn off<'a>(a: impl Iterator<Item = &'a f32> + Clone, b: impl Iterator<Item = &'a f32> + Clone) -> f32 {
    let (all, scale) = (a.clone().sum::<f32>(), a.clone().sum::<f32>() / b.clone().sum::<f32>());
    a.zip(b).map(|(a, b)| (a - scale * b).abs()).sum::<f32>() / all
}

/// A container decodes to what its codes decode to by the camera file and the JSON of the sensor.
#[test]
fn containers_decode_as_the_codes_in_them() {
    let bench = Bench::new();
    std::fs::write(bench.path("part.toml"), PART).unwrap();
    let render = format!("render {SCENE} --camera-file part.toml --spp 2 --sky 1,1,1 --write raw --out raw --quiet");
    succeeds(&bench, &render);
    succeeds(&bench, "develop raw/raw.exr --camera-file part.toml --write clean --out codes.png");
    let packed = LytroModel::Illum.packed(codes(&bench, "codes_clean.png").view());
    let frame = json!({"frame": {"imageRef": "sha1-i", "metadataRef": "sha1-m"}});
    let file = [
        section(b'P', "", &[]),
        section(b'C', "sha1-m", metadata(&bench).to_string().as_bytes()),
        section(b'C', "sha1-i", &packed),
        section(b'M', "sha1-t", json!({"frames": [frame]}).to_string().as_bytes()),
    ];
    std::fs::write(bench.path("shot.lfr"), file.concat()).unwrap();
    assert!(bench.run("info shot.lfr").stdout.contains("Lytro"));
    let refused = bench.run("refocus shot.lfr --disparity 0 --out sharp.png");
    assert!(refused.stderr.contains("decode it first"), "{refused:?}");

    succeeds(&bench, "demosaic codes_clean.png --method micro-images --camera-file part.toml --out color.exr");
    succeeds(&bench, "decode color.exr --camera-file part.toml --out expected");
    succeeds(&bench, "decode shot.lfr --out found");
    let (expected, found) = (views(&bench, "expected"), views(&bench, "found"));
    assert_eq!(found.shape(), expected.shape());
    // 8 bits at an automatic exposure each: light is relative to saturation in one, to the render in the other.
    let difference = off(expected.samples().iter(), found.samples().iter());
    assert!(difference < 0.01, "{difference}");

    // The same as packed codes, with a white image of the camera's kind.
    std::fs::write(bench.path("shot.raw"), &packed).unwrap();
    std::fs::write(bench.path("shot.json"), metadata(&bench).to_string()).unwrap();
    succeeds(&bench, "white --camera-file part.toml --out white");
    succeeds(&bench, "develop white/white.exr --camera-file part.toml --write clean --out w.png");
    let white = LytroModel::Illum.packed(codes(&bench, "w_clean.png").view());
    std::fs::write(bench.path("MOD_0001.RAW"), white).unwrap();
    let deep = json!({"master": {"picture": {"frameArray": [{"frame": {"metadata": metadata(&bench)}}]}}});
    std::fs::write(bench.path("MOD_0001.TXT"), deep.to_string()).unwrap();
    succeeds(&bench, "decode shot.raw --white MOD_0001.RAW --out white_views");
    let with_white = views(&bench, "white_views");
    // The white image has 10 bits, and pixels that are nearly dark are divided by few codes: the middle views agree.
    let (middle, own) = (with_white.shape().views(), found.shape().views());
    assert_eq!(middle, own);
    let view = |field: &holo_core::LightFieldOwned<f32>| field.view(own.rows / 2, own.columns / 2).unwrap().to_owned();
    let difference = off(view(&found).iter(), view(&with_white).iter());
    assert!(difference < 0.02, "{difference}");
    // Half of a file, and no file.
    let whole = std::fs::read(bench.path("shot.lfr")).unwrap();
    std::fs::write(bench.path("half.lfr"), &whole[..whole.len() / 2]).unwrap();
    for (name, word) in [("half.lfr", "ends behind the file"), ("none.lfr", "none.lfr")] {
        let outcome = bench.run(&format!("decode {name} --out nothing"));
        assert!(outcome.code == Some(1) && outcome.stderr.contains(word), "{outcome:?}");
        assert!(!bench.path("nothing").exists());
    }
}
