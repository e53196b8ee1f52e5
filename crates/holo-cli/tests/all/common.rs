//! The binary in a folder of its own, with a tiny scene in it.

#![allow(dead_code, reason = "every test file uses its own part of this")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use holo_core::{DynImage, GridSize, LightFieldOwned, LightFieldShape};
use holo_io::Limits;
use holo_scene::{Camera, CameraProjection, Instance, Light, LightKind, Material, Mesh, Scene, Transform};
use ndarray::Array3;

pub use crate::python::peer;

/// The program: that of this build, or the one at the path `HOLO_PROGRAM`, to see how an older one fails.
pub fn program() -> PathBuf {
    std::env::var_os("HOLO_PROGRAM").map_or_else(|| env!("CARGO_BIN_EXE_holo").into(), PathBuf::from)
}

/// Whether the nightly run wants more rounds, which take minutes.
pub fn is_thorough() -> bool {
    std::env::var_os("HOLO_THOROUGH").is_some_and(|value| value == "1")
}

/// The scene in every [`Bench`].
pub const SCENE: &str = "tiny.glb";

/// The rig of most tests: 12 x 8 lenses and 5 x 4 views, columns x rows.
pub const SMALL: &str = "--lenses 12x8 --views 5x4";

/// An unfocused camera of 60 x 45 pixels with its pupil in the lens.
pub const CAMERA: &str = r#"
name = "small"
[sensor]
size_px = [60, 45]
pixel_um = 5.0
[mla]
grid = "square"
pitch_um = 71.2
gap_um = 400.0
[main_lens]
focal_mm = 40.0
f_number = 5.8
focus_m = 0.8
"#;

/// The same with 120 x 90 pixels and the array beside the axis.
pub fn shifted_camera() -> String {
    CAMERA.replace("[60, 45]", "[120, 90]").replace("gap_um", "offset_um = [7.0, -4.0]\ngap_um")
}

/// A bench with [`shifted_camera`] in `small.toml`.
pub fn camera_bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("small.toml"), shifted_camera()).unwrap();
    bench
}

/// The keys of an image sensor, for the section `sensor`.
const SENSOR_KEYS: &str = r#"pixel_um = 5.0
model = "imx250"
electrons_at_one = { luminance_cd_m2 = 1000.0, exposure_s = 0.004 }"#;

/// The camera with an image sensor.
pub fn camera_with_sensor() -> String {
    CAMERA.replace("pixel_um = 5.0", SENSOR_KEYS)
}

/// The light field shape of [`SMALL`].
pub fn small_split() -> LightFieldShape {
    LightFieldShape::new(GridSize::new(4, 5), GridSize::new(8, 12)).unwrap()
}

/// The files that a render with color writes unless told otherwise, in alphabetical order.
pub const DEFAULT_FILES: [&str; 9] = [
    "manifest.json",
    "parameters.cfg",
    "scene_5d.mat",
    "scene_depth.pfm",
    "scene_disparity.pfm",
    "scene_disparity.png",
    "scene_el.png",
    "scene_hit_mask.png",
    "scene_vpi.png",
];

/// A folder that goes with the test; `holo` runs in it.
pub struct Bench {
    folder: tempfile::TempDir,
}

/// What became of one run.
#[derive(Debug)]
pub struct Outcome {
    /// The exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    pub took: Duration,
}

impl Bench {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(SCENE), holo_scene::gltf::to_glb(&tiny_scene()).unwrap()).unwrap();
        Self { folder }
    }

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `holo` with arguments separated by blanks, ready to be changed or started.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.folder.path()).stdin(Stdio::null()).args(arguments.split_whitespace());
        command.env_remove("SOURCE_DATE_EPOCH");
        command
    }

    pub fn run(&self, arguments: &str) -> Outcome {
        outcome(self.command(arguments))
    }

    /// Renders the tiny scene with the rig [`SMALL`] and more options into `out`, which must succeed. One ray a pixel
    /// unless `more` says otherwise.
    pub fn render(&self, out: &str, more: &str) -> Outcome {
        let spp = if more.contains("--spp") { "" } else { "--spp 1" };
        let outcome = self.run(&format!("render {SCENE} --out {out} {SMALL} {spp} {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome
    }

    /// The names of all files and folders below `folder`, folders with a `/` behind them, in alphabetical order.
    pub fn list(&self, folder: &str) -> Vec<String> {
        let mut names = Vec::new();
        collect(&self.path(folder), "", &mut names);
        names.sort();
        names
    }

    /// The bytes of all files below `folder`.
    pub fn bytes(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let files = self.list(folder).into_iter().filter(|name| !name.ends_with('/'));
        files.map(|name| (name.clone(), std::fs::read(self.path(folder).join(name)).unwrap())).collect()
    }
}

fn collect(folder: &Path, prefix: &str, names: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            collect(&entry.path(), &format!("{name}/"), names);
            names.push(format!("{name}/"));
        } else {
            names.push(name);
        }
    }
}

/// The names in a list of a report, in alphabetical order.
pub fn names(list: &serde_json::Value) -> Vec<String> {
    let mut names: Vec<String> =
        list.as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

/// Runs to the end.
pub fn outcome(mut command: Command) -> Outcome {
    let start = Instant::now();
    let output = command.output().unwrap();
    Outcome {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
        took: start.elapsed(),
    }
}

/// What became of a run that must have succeeded.
#[track_caller]
pub fn ok(outcome: Outcome) -> Outcome {
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    outcome
}

/// Runs `holo`, which must succeed.
#[track_caller]
pub fn run(bench: &Bench, arguments: &str) -> Outcome {
    let outcome = bench.run(arguments);
    assert_eq!(outcome.code, Some(0), "{arguments}: {outcome:?}");
    outcome
}

/// Runs `holo`, which must succeed: what it says.
#[track_caller]
pub fn succeeds(bench: &Bench, arguments: &str) -> String {
    run(bench, arguments).stderr
}

/// Runs `holo`, which must call that a wrong use, with this word.
#[track_caller]
pub fn refused(bench: &Bench, arguments: &str, word: &str) {
    let outcome = bench.run(arguments);
    assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
    assert!(outcome.stderr.contains(word), "{arguments}: no '{word}' in {}", outcome.stderr);
}

/// Waits for a process at most so long; what runs longer is killed and gives `None`.
pub fn wait(mut child: Child, at_most: Duration) -> Option<Outcome> {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > at_most {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let took = start.elapsed();
    let output = child.wait_with_output().unwrap();
    Some(Outcome {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
        took,
    })
}

/// A PNG of 8 bits, (rows, columns, channels).
pub fn read_u8(path: impl AsRef<Path>) -> Array3<u8> {
    match holo_io::read_png(path, &Limits::default()).unwrap() {
        DynImage::U8(image) => image,
        other => panic!("{:?}", other.kind()),
    }
}

/// A PNG of 16 bits, (rows, columns, channels).
pub fn read_u16(path: impl AsRef<Path>) -> Array3<u16> {
    match holo_io::read_png(path, &Limits::default()).unwrap() {
        DynImage::U16(image) => image,
        other => panic!("{:?}", other.kind()),
    }
}

/// A raw image of [`small_split`] with every sample different from its neighbours.
pub fn patterned(step: usize) -> LightFieldOwned<u16> {
    let raw = small_split().raw_size();
    let image = Array3::from_shape_fn((raw.rows, raw.columns, 3), |(row, column, channel)| {
        ((row * raw.columns + column) * 3 + channel).wrapping_mul(step) as u16
    });
    LightFieldOwned::from_elemental_grid(image, small_split()).unwrap()
}

/// Three quads at different depths before a larger one, a point light, a camera that sees some emptiness at the rim.
pub fn tiny_scene() -> Scene {
    let quad = Mesh {
        name: "quad".into(),
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        colors: vec![[1.0, 0.2, 0.2, 1.0], [0.2, 1.0, 0.2, 1.0], [0.2, 0.2, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let placed = |center: [f64; 3], turn: f64, size: f64| Instance {
        name: String::new(),
        mesh: 0,
        transform: Transform::from_parts(center, [0.0, turn, 0.0, 1.0], [size; 3]),
    };
    Scene {
        meshes: vec![quad],
        instances: vec![
            placed([0.0, 0.0, -2.0], 0.0, 0.6),
            placed([-0.3, 0.1, -1.4], 0.3, 0.2),
            placed([0.25, -0.1, -1.0], -0.2, 0.12),
            placed([0.1, 0.2, -1.7], 0.1, 0.15),
        ],
        materials: vec![Material { name: "paint".into(), ..Material::default() }],
        lights: vec![Light {
            name: "lamp".into(),
            intensity: [8.0, 7.0, 6.0],
            kind: LightKind::Point { position: [0.8, 1.0, 0.2], range: None },
        }],
        cameras: vec![Camera {
            name: "front".into(),
            pose: Transform::IDENTITY,
            projection: CameraProjection::Perspective { vertical_angle_rad: 0.6, aspect_ratio: Some(1.5) },
        }],
        ..Scene::default()
    }
}

/// A display of columns x rows lenses over `across` x `across` pixels each, for viewers 3 m away, as a file.
pub fn bench_display(grid: &str, columns: usize, rows: usize, across: usize) -> String {
    let pitch_mm = 0.2 * across as f64;
    format!(
        "[panel]\nsize_px = [{}, {}]\npixel_um = 200.0\n[lenses]\ngrid = \"{grid}\"\npitch_mm = {pitch_mm}\ngap_mm = 3.0\n\
         offset_mm = [{2}, {2}]\n[viewer]\ndistance_m = 3.0\n",
        columns * across,
        rows * across,
        pitch_mm / 2.0
    )
}
