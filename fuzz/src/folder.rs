//! Folders from a stranger: the input fills one with files, folders, links and pipes, and runs jobs in it.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

use holo_core::GridSize;
use holo_dataset::{
    Camera, Checkpoints, DatasetPlan, EngineSettings, Output, Pixels, RenderJob, RenderSettings, RigSettings, Rollback,
    RunOptions, SceneSource, Shard, WebDataset, merge, verify, write_catalog,
};
use holo_io::{LightFieldFolder, Manifest, ReadOptions, hash_file, probe};
use holo_render::{Backend, Integrator};
use holo_scene::{CameraProjection, Instance, Mesh, Scene, Transform};

use crate::bytes::Bytes;

/// Names that jobs look for or write.
const NAMES: [&str; 22] = [
    "manifest.json",
    ".manifest.old.json",
    ".holo.lock",
    "scene_el.png",
    "scene_depth.pfm",
    "scene_5d.mat",
    "parameters.cfg",
    "hci",
    "hci/input_Cam000.png",
    "hci/parameters.cfg",
    ".scene_el.png.1-1.part",
    ".holo-0123456789abcdef.checkpoint",
    "transforms.json",
    "dataset.json",
    "camera.toml",
    "raw.exr",
    "tiny",
    "tiny/2x2",
    "tiny/2x2/manifest.json",
    "frame_0000",
    "frame_0000/manifest.json",
    "out_00_00_0.0_0.0.png",
];

/// Names that no job writes, and those that a dataset gives to files that only their contents tell from these: the files
/// of somebody's work.
const OWN: [&str; 6] = [
    "thesis.tex",
    ".git/config",
    "notes/scene_el.png",
    "scene_el.png.bak",
    "light_fields.csv",
    "contact_sheet_2x2.png",
];

/// One triangle before a camera.
static SCENE: LazyLock<SceneSource> = LazyLock::new(|| {
    let mesh = Mesh {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let transform = Transform::from_parts([0.0, 0.0, -2.0], [0.0, 0.0, 0.0, 1.0], [1.0; 3]);
    let scene = Scene {
        meshes: vec![mesh],
        instances: vec![Instance { name: String::new(), mesh: 0, transform }],
        materials: vec![holo_scene::Material::default()],
        cameras: vec![holo_scene::Camera {
            name: String::new(),
            pose: Transform::IDENTITY,
            projection: CameraProjection::Perspective { vertical_angle_rad: 0.6, aspect_ratio: None },
        }],
        ..Scene::default()
    };
    let glb = holo_scene::gltf::to_glb(&scene).expect("a scene");
    SceneSource::Memory("tiny.glb".into(), Arc::from(glb))
});

/// Folders: jobs in any of them end, touch nothing outside, and leave the work of its owner alone.
///
/// # Panics
///
/// If a property does not hold.
pub fn folder(data: &[u8]) {
    let mut bytes = Bytes(data);
    // Memory, where the system offers it as a folder: every job syncs its files.
    let memory = Path::new("/dev/shm");
    let base = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() }.expect("a folder");
    let (root, victim) = (base.path().join("d"), base.path().join("victim"));
    fs::create_dir_all(victim.join("inner")).expect("the folder of the victim");
    fs::create_dir(&root).expect("the folder");
    fs::write(victim.join("keep.txt"), "keep").expect("a file of the victim");
    fs::write(victim.join("inner/scene_el.png"), "keep too").expect("a file of the victim");
    for _ in 0..1 + bytes.below(6) {
        plant(&mut bytes, &root, &victim);
    }
    let own = OWN.map(|name| root.join(name)).into_iter().filter(|path| path.is_file() && !path.is_symlink());
    let own: Vec<(Vec<u8>, PathBuf)> = own.filter_map(|path| Some((fs::read(&path).ok()?, path))).collect();
    let expected = tree(&victim);
    for _ in 0..2 {
        act(&mut bytes, &root, base.path());
        assert_eq!(tree(&victim), expected, "the folder of the victim");
        for (contents, path) in &own {
            assert_eq!(fs::read(path).ok().as_ref(), Some(contents), "{}", path.display());
        }
    }
}

/// Puts one thing into the folder. What is there stays.
fn plant(bytes: &mut Bytes, root: &Path, victim: &Path) {
    let name = if bytes.below(4) == 0 { bytes.pick(&OWN) } else { bytes.pick(&NAMES) };
    let path = root.join(name);
    let parent = path.parent().expect("a folder");
    // What lies behind a link that was planted before is not the stranger's.
    let is_inside = || root.canonicalize().ok().zip(parent.canonicalize().ok()).is_some_and(|(a, b)| b.starts_with(a));
    if fs::create_dir_all(parent).is_err() || !is_inside() || path.symlink_metadata().is_ok() {
        return;
    }
    // Errors: a part of the name is a file, a link or a pipe.
    let _ = match bytes.below(9) {
        0 => fs::write(&path, bytes.take(24)),
        1 | 2 => manifest(bytes, root, victim).write(&path).map(drop).map_err(std::io::Error::other),
        3 => fs::create_dir(&path),
        4 => symlink(victim.join("keep.txt"), &path),
        5 => symlink(if name.contains('/') { "../../victim/inner" } else { "../victim/inner" }, &path),
        6 => symlink(bytes.pick(&["..", ".", "nowhere", "../victim", "/dev/zero"]), &path),
        #[cfg(not(target_vendor = "apple"))]
        7 => rustix::fs::mkfifoat(rustix::fs::CWD, &path, rustix::fs::Mode::RWXU).map_err(Into::into),
        _ => fs::write(&path, "%PDF"),
    };
}

/// A manifest that lists files, some with their true sizes and digests.
fn manifest(bytes: &mut Bytes, root: &Path, victim: &Path) -> Manifest {
    let other = hash_file(victim.join("keep.txt")).expect("a file of the victim");
    let mut manifest = Manifest::default();
    for _ in 0..1 + bytes.below(3) {
        let (own, victim) = (bytes.pick(&OWN), bytes.pick(&["../victim/keep.txt", "hci/keep.txt", "hci/scene_el.png"]));
        let name = *bytes.pick(&[own, victim, "scene_el.png", "hci/input_Cam000.png"]);
        let path = root.join(name);
        let is_file = path.metadata().is_ok_and(|found| found.is_file());
        let digest = if is_file { hash_file(&path).ok() } else { None };
        manifest.files.insert(name.to_owned(), digest.unwrap_or(other));
    }
    manifest
}

/// Runs one job or reader; errors are results.
fn act(bytes: &mut Bytes, root: &Path, base: &Path) {
    let job = job(bytes);
    let rollback = Rollback::default();
    match bytes.below(10) {
        0 | 1 => drop(job.run(root, &RunOptions::new())),
        2 | 3 => drop(job.run(root, &RunOptions::new().overwrite(true))),
        4 => drop(job.run(root, &RunOptions::new().shard(Shard { part: 1, of: 2 }))),
        5 => drop(verify(root)),
        6 => drop(merge(root, &[base.join("victim"), root.to_owned()], &(), &rollback)),
        7 => drop(WebDataset::default().write(root, &base.join("packed"), &rollback)),
        8 => {
            let views = [GridSize::new(2, 2)];
            let mut settings = job.settings;
            if let Camera::Rig(rig) = &mut settings.camera {
                rig.pixels = Pixels::Sensor(holo_core::Sensor::Other(GridSize::new(6, 6)));
            }
            let plan = DatasetPlan::new(std::slice::from_ref(&SCENE), &views, settings, job.engine).expect("a plan");
            if plan.describe(root, &(), &rollback).is_ok() {
                let mut run = plan.run();
                for job in plan.jobs() {
                    let _ = run.job(job, root, &RunOptions::new());
                }
                let _ = write_catalog(root, &());
            }
        }
        _ => {
            let _ = probe(root);
            let _ = LightFieldFolder::open(root).and_then(|folder| folder.into_reader(&ReadOptions::default()));
        }
    }
}

/// A render of a few pixels.
fn job(bytes: &mut Bytes) -> RenderJob {
    let mut settings = RenderSettings::default();
    let mut rig = RigSettings::default();
    (rig.views, rig.pixels) = (GridSize::new(2, 2), Pixels::Lenses(GridSize::new(3, 3)));
    settings.camera = rig.into();
    settings.light.samples = Some(1.into());
    settings.light.integrator = if bytes.below(2) == 0 { Integrator::Direct } else { Integrator::Depth };
    if settings.light.integrator == Integrator::Direct {
        settings.output.write =
            bytes.pick(&[vec![Output::El], vec![Output::El, Output::Hci], vec![Output::Mat, Output::Depth]]).clone();
    }
    let engine = EngineSettings::default().backend(Backend::Bvh).threads(std::num::NonZeroUsize::new(1));
    let every = Checkpoints { every: Duration::ZERO, ..Checkpoints::default() };
    RenderJob::new(SCENE.clone(), settings).engine(engine).checkpoints(every)
}

/// All files below a folder, with their bytes.
fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(inner) = folders.pop() {
        for entry in fs::read_dir(inner).expect("a folder of the victim") {
            let path = entry.expect("an entry").path();
            match path.is_dir() {
                true => folders.push(path),
                false => drop(found.insert(path.clone(), fs::read(&path).expect("a file of the victim"))),
            }
        }
    }
    found
}
