//! The matrix of `crates/README.md`: cameras x poses x frames x features. Every cell works, or is refused with a reason.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use holo_core::{GridSize, Sensor};
use holo_dataset::{
    Camera, Checkpoints, DatasetCameras, DatasetPlan, EngineSettings, Frames, LayerChoice, Output, Pixels, Poses,
    RenderJob, RenderSettings, RigSettings, Rollback, RunOptions, Sky, WebDataset, merge, verify, write_catalog,
};
use holo_io::dataset::{self, DatasetIndex};
use holo_io::{ArrayCamera, CameraArray, CameraFile, FileDigest, Manifest, MosaicInfo, Sha256, WorldUp};
use holo_render::{Backend, Denoise, GroundTruth, Integrator, Progress, Renderer, Reuse, TextureFilter};
use holo_scene::{Scene, Transform};

use crate::gallery;

/// An unfocused camera of 60 x 45 pixels with its pupil in the lens.
const CAMERA: &str = r#"
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

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Rig,
    Plenoptic,
    Pinhole,
}

/// A feature of a render, and what of it is refused: the cameras, and a word of the reason.
type Feature = (&'static str, fn(&mut RenderSettings), &'static [(Kind, &'static str)]);

const FEATURES: [Feature; 12] = [
    ("plain", |_| {}, &[]),
    ("ground truth alone", |settings| settings.light.integrator = Integrator::Depth, &[]),
    ("paths", |settings| settings.light.integrator = Integrator::Path, &[]),
    ("adaptive sampling", |settings| settings.light.target_error = Some(0.5), &[]),
    (
        "no footprints, light shared between views",
        |settings| {
            settings.light.texture_filter = TextureFilter::Off;
            settings.light.reuse = Reuse::Views;
        },
        &[],
    ),
    (
        "culling, one color of the sky",
        |settings| {
            settings.light.cull = true;
            settings.light.sky = Sky::Constant([0.5; 3]);
        },
        &[],
    ),
    ("reconstruction", |settings| settings.light.denoise = Denoise::Views, &[(Kind::Pinhole, "grid of views")]),
    ("error", |settings| settings.output.layers = vec![LayerChoice::Error], &[(Kind::Pinhole, "grid of views")]),
    ("layers of the first hit", |settings| settings.output.layers = vec![LayerChoice::All], &[]),
    (
        "visibility",
        |settings| settings.output.layers = vec![LayerChoice::Visibility],
        &[(Kind::Plenoptic, "views"), (Kind::Pinhole, "grid of views")],
    ),
    (
        "all views",
        |settings| settings.output.ground_truth = GroundTruth::All,
        &[(Kind::Plenoptic, "views"), (Kind::Pinhole, "grid of views")],
    ),
    ("sensor codes", |settings| apply(settings, &[("sensor-model", "imx250")]), &[(Kind::Pinhole, "raw image")]),
];

fn apply(settings: &mut RenderSettings, pairs: &[(&str, &str)]) {
    let mut given = holo_dataset::settings::Given::default();
    pairs.iter().for_each(|(key, text)| given.insert(key, *text).expect("a setting"));
    settings.apply(&given).expect("settings");
}

fn poses() -> Poses {
    let camera = |name: &str, x: f64| ArrayCamera {
        name: name.into(),
        axes_and_position: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.3, 1.2]],
        focal_px: 14.0,
        size: Some(GridSize::new(8, 12)),
        ..ArrayCamera::default()
    };
    Poses::Array { cameras: CameraArray { cameras: vec![camera("left", -0.1), camera("right", 0.1)] }, up: WorldUp::Y }
}

/// Settings of a camera, at two poses or that of the scene, at two frames or at rest.
fn settings(kind: Kind, many_poses: bool, many_frames: bool) -> RenderSettings {
    let mut settings = RenderSettings::default();
    let pixels = if many_poses { Pixels::OfPoses } else { Pixels::Lenses(GridSize::new(8, 12)) };
    settings.camera = match kind {
        Kind::Rig => {
            let mut rig = RigSettings::default();
            (rig.views, rig.pixels) = (GridSize::new(5, 5), pixels);
            rig.into()
        }
        Kind::Plenoptic => CameraFile::parse(CAMERA, "small").expect("a camera").into(),
        Kind::Pinhole => Camera::Pinhole,
    };
    if many_poses {
        settings.poses = poses();
    }
    if many_frames {
        settings.scene.frames = Some(Frames { first: 3, last: 4 });
    }
    settings.light.samples = Some(4.into());
    settings.light.integrator = Integrator::Direct;
    settings
}

fn job(settings: RenderSettings) -> RenderJob {
    let name = if settings.scene.frames.is_some() { "pendulum" } else { "plaster" };
    RenderJob::new(gallery(name), settings)
}

/// The folders of all shots have manifests, and every file its digest.
fn check(out: &Path, job: &RenderJob) {
    for shot in job.shots() {
        let folder = out.join(shot.folder());
        let found = verify(&folder).unwrap_or_else(|why| panic!("{}: {why}", folder.display()));
        assert_eq!(found.bad_folders, 0, "{found:?}");
    }
    let whole = verify(out).unwrap_or_else(|why| panic!("{}: {why}", out.display()));
    assert_eq!((whole.folders, whole.bad_folders), (job.shots().len(), 0), "{whole:?}");
}

/// The manifest names the file of the library that was loaded.
#[test]
fn a_manifest_names_the_library() {
    let renderer = Renderer::new(&Scene::default(), &Transform::IDENTITY, Backend::Auto, None).expect("a renderer");
    let folder = tempfile::tempdir().expect("a folder");
    for (out, backend) in [("auto", Backend::Auto), ("built in", Backend::Bvh)] {
        let engine = EngineSettings { backend, ..EngineSettings::default() };
        let job = job(settings(Kind::Rig, false, false)).engine(engine);
        job.run(folder.path().join(out), &RunOptions::new()).expect("a run");
        let manifest = Manifest::read(folder.path().join(out).join(dataset::MANIFEST_JSON)).expect("a manifest");
        let loaded = renderer.engine_library().filter(|_| backend == Backend::Auto);
        assert_eq!(loaded.is_some(), manifest.versions["engine"].starts_with("embree"), "{manifest:?}");
        let expected = loaded.map(|path| {
            let path = path.canonicalize().expect("a file");
            let name = path.file_name().expect("a name").to_str().expect("UTF-8").to_owned();
            let bytes = std::fs::read(path).expect("a file");
            (name, FileDigest { bytes: bytes.len() as u64, sha256: Sha256::of(&bytes) })
        });
        assert_eq!(manifest.libraries, expected.into_iter().collect());
    }
}

/// Images whose noise tells a disparity say that they are not for scoring stereo; those of default settings need not.
#[test]
fn noise_that_tells_a_disparity_is_stated() {
    let folder = tempfile::tempdir().expect("a folder");
    let plain: fn(&mut RenderSettings) = |_| {};
    for (out, kind, change, words) in [
        ("plain", Kind::Rig, plain, None),
        ("reuse", Kind::Rig, |settings: &mut RenderSettings| settings.light.reuse = Reuse::Views, Some("is equal")),
        (
            "denoise",
            Kind::Rig,
            |settings: &mut RenderSettings| settings.light.denoise = Denoise::Views,
            Some("true disparity"),
        ),
        (
            "raw",
            Kind::Plenoptic,
            |settings: &mut RenderSettings| settings.light.denoise = Denoise::Views,
            Some("true disparity"),
        ),
    ] {
        let mut settings = settings(kind, false, false);
        settings.light.samples = Some(2.into());
        change(&mut settings);
        job(settings).run(folder.path().join(out), &RunOptions::new()).expect("a run");
        let manifest = Manifest::read(folder.path().join(out).join(dataset::MANIFEST_JSON)).expect("a manifest");
        let stated = manifest.settings.get("not-for-stereo").and_then(|value| value.as_text());
        assert_eq!(stated.is_some(), words.is_some(), "{out}: {stated:?}");
        assert!(words.is_none_or(|words| stated.is_some_and(|text| text.contains(words))), "{out}: {stated:?}");
    }
}

/// A manifest that another run has put aside is reported by every job.
#[test]
fn a_manifest_that_lies_aside_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let (job, out) = (job(settings(Kind::Rig, false, false)), folder.path().join("out"));
    let notes = Mutex::new(Vec::new());
    let tell = |_: holo_dataset::About, line: &str| notes.lock().expect("a list").push(line.to_owned());
    let aside = |out: &Path| {
        std::fs::create_dir_all(out).expect("a folder");
        std::fs::write(out.join(".manifest.old.json"), "{}").expect("a file");
    };
    let parts: Vec<PathBuf> = (1..=2)
        .map(|part| {
            let out = folder.path().join(part.to_string());
            job.run(&out, &RunOptions::new().shard(holo_dataset::Shard { part, of: 2 })).expect("a part");
            out
        })
        .collect();
    aside(&out);
    job.run(&out, &RunOptions::new().diagnostics(&tell)).expect("a run");
    let merged = folder.path().join("merged");
    aside(&merged);
    merge(&merged, &parts, &tell, &Rollback::default()).expect("merged");
    let notes = notes.into_inner().expect("a list");
    let of = |out: &Path| notes.iter().filter(|line| line.contains(&*out.to_string_lossy())).count();
    assert_eq!((of(&out), of(&merged)), (1, 1), "{notes:?}");
    assert!(notes.iter().all(|line| !line.contains(".manifest.old.json") || line.contains("is not used")), "{notes:?}");
}

/// All files below a folder.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(inner) = folders.pop() {
        for entry in std::fs::read_dir(inner).expect("a folder") {
            let path = entry.expect("an entry").path();
            match path.is_dir() {
                true => folders.push(path),
                false => {
                    let name = path.strip_prefix(folder).expect("inside").to_owned();
                    found.insert(name, std::fs::read(&path).expect("a file"));
                }
            }
        }
    }
    found
}

fn cells() -> impl Iterator<Item = (Kind, bool, bool)> {
    let all = [Kind::Rig, Kind::Plenoptic, Kind::Pinhole].into_iter();
    let all = all.flat_map(|kind| [false, true].map(|poses| (kind, poses)));
    let all = all.flat_map(|(kind, poses)| [false, true].map(|frames| (kind, poses, frames)));
    // Pinholes have no other place.
    all.filter(|(kind, poses, _)| *kind != Kind::Pinhole || *poses)
}

#[test]
fn every_camera_pose_and_frame_has_every_feature_or_a_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    for (number, (kind, many_poses, many_frames)) in cells().enumerate() {
        for (name, change, refused) in FEATURES {
            let what = format!("{name}: {kind:?}, poses {many_poses}, frames {many_frames}");
            let mut settings = settings(kind, many_poses, many_frames);
            change(&mut settings);
            let job = job(settings);
            let out = folder.path().join(format!("{number} {name}"));
            let outcome = job.run(&out, &RunOptions::new());
            match (refused.iter().find(|(camera, _)| *camera == kind), outcome) {
                (None, Ok(shots)) => {
                    assert_eq!(shots.len(), job.shots().len(), "{what}");
                    check(&out, &job);
                }
                (Some((_, reason)), Err(why)) => {
                    assert!(why.is_bad_request() && why.to_string().contains(reason), "{what}: {why}");
                    assert!(!out.exists(), "{what} left files");
                }
                (None, Err(why)) => panic!("{what}: {why}"),
                (Some(_), Ok(_)) => panic!("{what}: it is said to be refused"),
            }
        }
    }
}

/// The motion until the next frame needs frames and views.
#[test]
fn motion_is_of_frames_of_views() {
    let folder = tempfile::tempdir().expect("a folder");
    for (number, (kind, many_poses, many_frames)) in cells().enumerate() {
        let mut settings = settings(kind, many_poses, many_frames);
        settings.output.layers = vec![LayerChoice::OpticalFlow, LayerChoice::SceneFlow];
        let job = job(settings);
        let outcome = job.run(folder.path().join(number.to_string()), &RunOptions::new());
        match (kind, many_frames) {
            (Kind::Rig, true) => check(&folder.path().join(number.to_string()), &job),
            _ => assert!(outcome.expect_err("refused").is_bad_request(), "{kind:?} {many_frames}"),
        }
    }
}

/// The folder of several poses names the one that is missing.
#[test]
fn a_missing_pose_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = job(settings(Kind::Rig, true, false));
    job.run(folder.path(), &RunOptions::new()).expect("two poses");
    check(folder.path(), &job);
    std::fs::remove_dir_all(folder.path().join("left")).expect("the folder of a pose");
    let found = verify(folder.path()).expect("folders");
    assert_eq!((found.folders, found.bad_folders), (2, 1), "{found:?}");
    assert!(found.mismatches.iter().all(|line| line.starts_with("left: ")), "{found:?}");
}

/// Two shards are the whole: merged rows and images, and shots in one folder.
#[test]
fn shards_of_everything_are_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    for (number, (kind, many_poses, many_frames)) in cells().enumerate() {
        let mut settings = settings(kind, many_poses, many_frames);
        settings.output.layers = vec![LayerChoice::All];
        let job = job(settings);
        let is_single = job.shots().len() == 1;
        let whole = folder.path().join(format!("{number} whole"));
        job.run(&whole, &RunOptions::new()).expect("the whole");
        let (merged, of) = (folder.path().join(format!("{number} merged")), 2);
        let mut parts = Vec::new();
        for part in 1..=of {
            let shard = holo_dataset::Shard { part, of };
            let out = if is_single { folder.path().join(format!("{number} part {part}")) } else { merged.clone() };
            job.run(&out, &RunOptions::new().shard(shard)).expect("a part");
            parts.push(out);
        }
        if is_single {
            merge(&merged, &parts, &(), &Rollback::default()).expect("merged");
        }
        let (whole, merged) = (bytes(&whole), bytes(&merged));
        let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&whole), names(&merged), "{kind:?} {many_poses} {many_frames}");
        let differ: Vec<_> =
            whole.iter().filter(|(name, bytes)| merged[*name] != **bytes).map(|(name, _)| name).collect();
        assert!(differ.is_empty(), "{kind:?} {many_poses} {many_frames}: {differ:?}");
    }
}

/// The sensor is exposed in all shots as in the first, whichever part renders them: a sequence does not flicker.
#[test]
fn sensor_codes_of_all_shots_have_one_exposure() {
    let folder = tempfile::tempdir().expect("a folder");
    for kind in [Kind::Rig, Kind::Plenoptic] {
        let mut settings = settings(kind, true, true);
        apply(&mut settings, &[("sensor-model", "imx250")]);
        let (job, out) = (job(settings), folder.path().join(format!("{kind:?}")));
        for part in [2, 1] {
            let shard = holo_dataset::Shard { part, of: 2 };
            job.run(&out, &RunOptions::new().shard(shard)).expect("a part");
        }
        let exposure = |shot: &holo_dataset::Shot| {
            MosaicInfo::read_for(out.join(shot.folder()).join("scene_raw.png")).expect("a sensor").exposure
        };
        let electrons: Vec<f64> = job.shots().iter().map(|shot| exposure(shot).electrons_at_one).collect();
        assert_eq!(electrons, [electrons[0]; 4], "{kind:?}");
    }
}

/// Cancels after some tiles.
struct CancelAfter(u64, std::sync::atomic::AtomicU64);

impl Progress for CancelAfter {
    fn advance(&self, _: u64, _: u64) {
        self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.1.load(std::sync::atomic::Ordering::Relaxed) >= self.0
    }
}

/// A job that was canceled continues to the same bytes.
#[test]
fn everything_continues() {
    let folder = tempfile::tempdir().expect("a folder");
    for (number, (kind, many_poses, many_frames)) in cells().enumerate() {
        let mut settings = settings(kind, many_poses, many_frames);
        settings.output.write = match kind {
            Kind::Rig => vec![Output::El],
            Kind::Plenoptic => vec![Output::Raw, Output::RawPng],
            Kind::Pinhole => Vec::new(),
        };
        let every = std::time::Duration::ZERO;
        let job = job(settings).checkpoints(Checkpoints { every, ..Checkpoints::default() });
        let [whole, out] = ["whole", "continued"].map(|name| folder.path().join(format!("{number} {name}")));
        job.run(&whole, &RunOptions::new()).expect("the whole");
        for tiles in [1, 2] {
            let cancel = CancelAfter(tiles, std::sync::atomic::AtomicU64::new(0));
            // Small jobs may end before.
            let _ = job.run(&out, &RunOptions::new().progress(&cancel));
        }
        job.run(&out, &RunOptions::new()).expect("continued");
        assert!(bytes(&whole) == bytes(&out), "{kind:?} {many_poses} {many_frames}");
    }
}

/// Two forms of the same settings are the same image: an existing folder is no other image.
#[test]
fn the_same_settings_in_another_form_are_the_same_image() {
    let folder = tempfile::tempdir().expect("a folder");
    let render = |pairs: &[(&str, &str)], overwrite: bool| {
        let mut settings = RenderSettings::default();
        apply(&mut settings, &[&[("lenses", "12x8"), ("integrator", "direct")][..], pairs].concat());
        job(settings).run(folder.path().join("out"), &RunOptions::new().overwrite(overwrite)).map(drop)
    };
    render(&[("views", "2x2")], false).expect("the first");
    for same in [
        &[("views", "2"), ("spp", "16")][..],
        &[("views", "2x2"), ("f-number", "5.0"), ("sensor-mm", "36")],
        &[("views", "2x2"), ("write", "mat,el,vpi,depth,disparity")],
        &[("views", "2x2"), ("lens-shifts", "1")],
    ] {
        render(same, false).unwrap_or_else(|why| panic!("{same:?}: {why}"));
    }
    for (other, part) in [
        (&[("views", "2x2"), ("spp", "3")][..], "`spp`"),
        (&[("views", "3")], "`views`"),
        (&[("views", "2x2"), ("lens-shifts", "2")], "`lens-shifts`"),
    ] {
        let why = render(other, false).expect_err("another image").to_string();
        assert!(why.contains(part) && why.contains("`overwrite`"), "{why}");
    }
    render(&[("views", "3")], true).expect("overwritten");
    render(&[("views", "3"), ("subset", "2,1;0,1")], true).expect("some views");
    render(&[("views", "3"), ("subset", "0,1; 2,1;0,1")], false).expect("the same views");
    let why = render(&[("views", "3"), ("subset", "0,1")], false).expect_err("other views").to_string();
    assert!(why.contains("`subset`"), "{why}");
}

/// Two plenoptic cameras of these names.
fn plenoptic(names: [&str; 2]) -> DatasetCameras {
    let files = names.map(|name| {
        let mut file = CameraFile::parse(CAMERA, "small").expect("a camera");
        file.name = name.into();
        file
    });
    DatasetCameras::Plenoptic(files.to_vec())
}

/// A dataset of two cameras of a kind, of two scenes or an animated one.
fn plan(kind: Kind, many_poses: bool, many_frames: bool) -> DatasetPlan {
    let mut settings = settings(kind, many_poses, many_frames);
    if let (Camera::Rig(rig), false) = (&mut settings.camera, many_poses) {
        rig.pixels = Pixels::Sensor(Sensor::Other(GridSize::new(24, 36)));
    }
    let cameras = match kind {
        Kind::Rig => DatasetCameras::Views(vec![GridSize::new(3, 3), GridSize::new(5, 5)]),
        Kind::Plenoptic | Kind::Pinhole => plenoptic(["small", "other camera"]),
    };
    let names = if many_frames { &["pendulum"][..] } else { &["plaster", "chess"] };
    let sources: Vec<_> = names.iter().map(|name| gallery(name)).collect();
    DatasetPlan::new(&sources, cameras, settings, EngineSettings::default()).expect("a plan")
}

/// Runs a part of the jobs of a dataset, and returns how many of them were rendered.
fn run_part(plan: &DatasetPlan, root: &Path, (part, of): (usize, usize)) -> usize {
    plan.describe(root, &(), &Rollback::default()).expect("a description");
    let mut run = plan.run();
    let mut made = 0;
    for job in plan.jobs().iter().skip(part - 1).step_by(of) {
        let outcome = run.job(job, root, &RunOptions::new()).expect("a job");
        made += usize::from(outcome.report().is_some());
    }
    made
}

/// A dataset has any camera at any poses and frames: it describes itself, verifies, is kept, packed, and made in parts.
#[test]
fn datasets_have_any_camera_pose_and_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let cells = cells().filter(|(kind, ..)| *kind != Kind::Pinhole);
    for (number, (kind, many_poses, many_frames)) in cells.enumerate() {
        let what = format!("{kind:?}, poses {many_poses}, frames {many_frames}");
        let plan = plan(kind, many_poses, many_frames);
        let scenes = if many_poses { 4 } else { 2 };
        let jobs = 2 * scenes;
        assert_eq!(plan.jobs().len(), jobs, "{what}");
        let [whole, parts, archives] =
            ["whole", "parts", "archives"].map(|name| folder.path().join(format!("{number} {name}")));
        assert_eq!(run_part(&plan, &whole, (1, 1)), jobs, "{what}");
        let described = write_catalog(&whole, &()).expect("a catalog");
        assert_eq!((described.finished, described.of), (jobs, jobs), "{what}");
        let found = verify(&whole).expect("folders");
        assert_eq!((found.folders, found.bad_folders, found.notes.len()), (jobs, 0, 0), "{what}: {found:?}");
        let index = DatasetIndex::read(&whole).expect("an index");
        assert_eq!((index.scenes.len(), index.cameras.len()), (scenes, 2), "{what}");
        assert_eq!(index.poses.map(|poses| poses.count), many_poses.then_some(2), "{what}");
        assert_eq!(whole.join("transforms.json").is_file(), many_poses, "{what}");
        assert_eq!(dataset::list(&whole).expect("folders").len(), jobs, "{what}");
        let sheet = if kind == Kind::Rig { "contact_sheet_3x3.png" } else { "contact_sheet_small.png" };
        assert!(whole.join(sheet).is_file(), "{what}");

        assert_eq!(run_part(&plan, &whole, (1, 1)), 0, "{what}: all is done");
        let made: usize = [2, 1].into_iter().map(|part| run_part(&plan, &parts, (part, 2))).sum();
        write_catalog(&parts, &()).expect("a catalog");
        assert!(made == jobs && bytes(&whole) == bytes(&parts), "{what}");
        let archives = WebDataset::default().write(&whole, &archives, &Rollback::default()).expect("archives");
        assert_eq!(archives.iter().map(|archive| archive.samples).sum::<usize>(), jobs, "{what}");
    }
}

/// Another camera of the same name, and other poses, are found by `verify` and rendered again.
#[test]
fn datasets_know_their_cameras_and_poses() {
    let folder = tempfile::tempdir().expect("a folder");
    let plaster = [gallery("plaster")];
    let plan = |cameras: DatasetCameras, settings: RenderSettings| {
        DatasetPlan::new(&plaster, cameras, settings, EngineSettings::default()).expect("a plan")
    };
    let own = settings(Kind::Plenoptic, true, false);
    let first = plan(plenoptic(["small", "other"]), own.clone());
    assert_eq!(run_part(&first, folder.path(), (1, 1)), 4);
    let DatasetCameras::Plenoptic(mut files) = plenoptic(["small", "other"]) else { panic!("plenoptic cameras") };
    files[1] = files[1].clone().with_f_number(8.0).expect("a camera");
    let changed = plan(files.into(), own.clone());
    changed.describe(folder.path(), &(), &Rollback::default()).expect("a description");
    let found = verify(folder.path()).expect("folders");
    assert_eq!((found.bad_folders, found.folders), (2, 4), "{found:?}");
    assert!(found.mismatches.iter().all(|line| line.contains("another camera of this name")), "{found:?}");
    assert_eq!(run_part(&changed, folder.path(), (1, 1)), 2);

    let Poses::Array { mut cameras, up } = poses() else { panic!("poses") };
    cameras.cameras[1].axes_and_position[3][0] = 0.2;
    let moved = plan(plenoptic(["small", "other"]), own.poses(Poses::Array { cameras, up }));
    moved.describe(folder.path(), &(), &Rollback::default()).expect("a description");
    let found = verify(folder.path()).expect("folders");
    assert!(found.bad_folders == 4 && found.mismatches[0].contains("other poses"), "{found:?}");
    // At the poses of the scene nothing is left that says others.
    let still = plan(plenoptic(["small", "other"]), settings(Kind::Plenoptic, false, false));
    still.describe(folder.path(), &(), &Rollback::default()).expect("a description");
    assert!(!folder.path().join("transforms.json").exists());
}

#[test]
fn datasets_refuse_what_has_no_folder_of_its_own() {
    let rig = || settings(Kind::Rig, true, false);
    let Poses::Array { mut cameras, up } = poses() else { panic!("poses") };
    cameras.cameras[1].size = Some(GridSize::new(8, 13));
    let views = || DatasetCameras::Views(vec![GridSize::new(3, 3)]);
    let small = || CameraFile::parse(CAMERA, "small").expect("a camera");
    for (cameras, settings, part) in [
        (plenoptic(["small", "Small"]), settings(Kind::Plenoptic, false, false), "two cameras of `camera-file`"),
        (plenoptic(["small", "20x20"]), settings(Kind::Plenoptic, false, false), "`camera-file`: 20x20"),
        (plenoptic(["small", "a/b"]), settings(Kind::Plenoptic, false, false), "`camera-file`: a/b"),
        (DatasetCameras::Plenoptic(Vec::new()), settings(Kind::Plenoptic, false, false), "`camera-file`"),
        (plenoptic(["small", "other"]), settings(Kind::Rig, false, false), "`camera-file`"),
        (views(), RenderSettings::default().camera(small()), "`views`"),
        (views(), settings(Kind::Pinhole, true, false), "`views`"),
        (views(), rig().poses(Poses::Array { cameras, up }), "'right' of `transforms` has 13x8 pixels"),
        (views(), rig().camera(RigSettings::default()), "`sensor`"),
    ] {
        let source = gallery("plaster");
        let refused = DatasetPlan::new(&[source], cameras, settings, EngineSettings::default());
        let why = refused.expect_err(part);
        assert!(why.is_bad_request() && why.to_string().contains(part), "{part}: {why}");
    }
}
