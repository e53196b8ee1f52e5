//! Interrupted renders continue from their checkpoint to the same bytes, and use no checkpoint but their own.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
#[cfg(unix)]
use std::{
    process::{Child, Command, Stdio},
    time::Instant,
};

use holo_core::GridSize;
use holo_dataset::{
    About, Camera, Checkpoints, DatasetPlan, EngineSettings, Error, Output, Pixels, Poses, RenderJob, RenderSettings,
    RigSettings, Rollback, RunOptions, Shard, ShotOutcome, Spacing, merge, verify,
};
use holo_io::{ArrayCamera, CameraArray, WorldUp};
use holo_render::{Backend, GroundTruth, Integrator, Progress};

use crate::gallery;

/// Cancels after some tiles, and counts them. Waits before each.
struct Watch {
    tiles: u64,
    pause: Duration,
    done: AtomicU64,
}

impl Watch {
    fn cancel_after(tiles: u64) -> Self {
        Self { tiles, pause: Duration::ZERO, done: AtomicU64::new(0) }
    }

    fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }
}

impl Progress for Watch {
    fn advance(&self, _: u64, _: u64) {
        self.done.fetch_add(1, Ordering::Relaxed);
        std::thread::sleep(self.pause);
    }

    fn cancelled(&self) -> bool {
        self.done() >= self.tiles
    }
}

/// Three dozen tiles of color, and some of layers; a checkpoint after each.
fn job() -> RenderJob {
    let mut settings = RenderSettings::default();
    settings.camera = rig(Pixels::Lenses(GridSize::new(36, 45))).into();
    (settings.light.samples, settings.light.integrator) = (Some(1.into()), Integrator::Direct);
    settings.output.ground_truth = GroundTruth::All;
    settings.output.write = vec![Output::El, Output::Mat, Output::Exr, Output::Depth];
    with_settings(settings)
}

fn rig(pixels: Pixels) -> RigSettings {
    let mut rig = RigSettings::default();
    (rig.views, rig.pixels) = (GridSize::new(5, 6), pixels);
    rig
}

fn with_settings(settings: RenderSettings) -> RenderJob {
    let engine = EngineSettings::default().backend(Backend::Bvh).threads(std::num::NonZeroUsize::new(2));
    let job = RenderJob::new(gallery("plaster"), settings).engine(engine);
    job.checkpoints(Checkpoints { every: Duration::ZERO, ..Checkpoints::default() })
}

/// Runs a job; returns what it reported about checkpoints, too.
fn run(job: &RenderJob, out: &Path, watch: &Watch, shard: Option<Shard>) -> (Result<(), Error>, Vec<String>) {
    let lines = RefCell::new(Vec::new());
    let report = |_: About, line: &str| lines.borrow_mut().push(line.to_owned());
    let outcome = job.run(out, &RunOptions::new().shard(shard).progress(watch).diagnostics(&report)).map(drop);
    let lines = lines.into_inner().into_iter().filter(|line| line.contains("checkpoint")).collect();
    (outcome, lines)
}

/// Runs a job to its end; returns the number of tiles that it rendered, and what it reported.
fn finish(job: &RenderJob, out: &Path) -> (u64, Vec<String>) {
    let watch = Watch::cancel_after(u64::MAX);
    let (outcome, lines) = run(job, out, &watch, None);
    outcome.unwrap();
    assert!(checkpoints(out).is_empty(), "a finished render has no checkpoint");
    (watch.done(), lines)
}

/// Cancels a job after some tiles.
fn cancel(job: &RenderJob, out: &Path, tiles: u64) -> Vec<String> {
    let (outcome, lines) = run(job, out, &Watch::cancel_after(tiles), None);
    assert!(matches!(outcome, Err(Error::Render(holo_render::Error::Cancelled))), "{outcome:?}");
    lines
}

/// All files below a folder.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(bytes(&path).into_iter().map(|(name, bytes)| (path.join(name), bytes)));
        } else {
            found.insert(PathBuf::from(path.file_name().unwrap()), fs::read(&path).unwrap());
        }
    }
    let relative = |path: PathBuf| path.strip_prefix(folder).map(Path::to_path_buf).unwrap_or(path);
    found.into_iter().map(|(path, bytes)| (relative(path), bytes)).collect()
}

fn checkpoints(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    files.filter(|path| path.extension().is_some_and(|extension| extension == "checkpoint")).collect()
}

/// The only checkpoint in a folder.
fn checkpoint(folder: &Path) -> PathBuf {
    let [path] = &checkpoints(folder)[..] else { panic!("{:?}", checkpoints(folder)) };
    path.clone()
}

/// A folder, in which `whole` is the result of an undisturbed render of `job()`, its bytes, and the number of its tiles.
fn bench() -> (tempfile::TempDir, BTreeMap<PathBuf, Vec<u8>>, u64) {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    let (tiles, lines) = finish(&job().checkpoints(None), &whole);
    assert!(tiles > 36 && lines.is_empty(), "{tiles} {lines:?}");
    let expected = bytes(&whole);
    (folder, expected, tiles)
}

#[test]
fn a_canceled_render_continues_to_the_same_bytes() {
    let (folder, expected, tiles) = bench();
    for (number, after) in [1, 7, tiles - 1].into_iter().enumerate() {
        let out = folder.path().join(format!("out{number}/inner"));
        let lines = cancel(&job(), &out, after);
        assert!(lines.len() == 1 && lines[0].contains("the same command continues"), "{lines:?}");
        assert_eq!(bytes(&out).len(), 1, "nothing but the checkpoint is left: {:?}", bytes(&out).keys());
        assert!(verify(&out).unwrap_err().to_string().contains("unfinished render"));
        let (rendered, lines) = finish(&job(), &out);
        // The tiles that were in work when it was canceled are rendered again.
        assert!(rendered >= tiles - after && rendered <= tiles - after + 2, "{rendered} of {tiles} after {after}");
        assert!(lines.len() == 1 && lines[0].starts_with("note: continues with"), "{lines:?}");
        assert!(bytes(&out) == expected, "after {after}");
    }
}

#[test]
fn a_render_that_is_canceled_again_and_again_comes_to_an_end() {
    let (folder, expected, tiles) = bench();
    let out = folder.path().join("out");
    let mut runs = 1;
    while run(&job(), &out, &Watch::cancel_after(5), None).0.is_err() {
        runs += 1;
        assert!(runs <= tiles, "every run renders some tiles");
    }
    assert!(runs > 2);
    assert!(bytes(&out) == expected);
}

/// The images of pinhole cameras share a checkpoint: those that were finished are not rendered again.
#[test]
fn pinhole_cameras_continue_to_the_same_bytes() {
    let camera = |k: usize| ArrayCamera {
        name: format!("camera_{k}"),
        axes_and_position: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.1 * k as f64, 0.3, 1.2]],
        focal_px: 60.0,
        size: Some(GridSize::new(36, 45)),
        ..ArrayCamera::default()
    };
    let mut settings = RenderSettings::default();
    settings.camera = Camera::Pinhole;
    settings.poses = Poses::Array { cameras: CameraArray { cameras: (0..3).map(camera).collect() }, up: WorldUp::Y };
    (settings.light.samples, settings.light.integrator) = (Some(1.into()), Integrator::Direct);
    let job = with_settings(settings);
    let folder = tempfile::tempdir().unwrap();
    let (whole, out) = (folder.path().join("whole"), folder.path().join("out"));
    let (tiles, _) = finish(&job.clone().checkpoints(None), &whole);
    assert!(tiles >= 3, "{tiles}");
    let lines = cancel(&job, &out, tiles / 2);
    assert!(lines.len() == 1 && lines[0].contains("the same command continues"), "{lines:?}");
    assert_eq!(bytes(&out).len(), 1, "nothing but the checkpoint is left: {:?}", bytes(&out).keys());
    let (rendered, lines) = finish(&job, &out);
    assert!(rendered < tiles && lines[0].starts_with("note: continues with"), "{rendered} of {tiles}: {lines:?}");
    assert!(bytes(&out) == bytes(&whole));
}

#[test]
fn a_short_render_writes_no_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let lines = cancel(&job().checkpoints(Some(Checkpoints::default())), &out, 20);
    assert!(lines.is_empty() && !out.exists(), "{lines:?}");
    let lines = cancel(&job().checkpoints(None), &out, 20);
    assert!(lines.is_empty() && !out.exists(), "{lines:?}");
}

#[test]
fn another_folder_may_hold_the_checkpoint() {
    let (folder, expected, _) = bench();
    let (out, aside) = (folder.path().join("out"), folder.path().join("aside"));
    fs::create_dir(&aside).unwrap();
    let every = Duration::ZERO;
    let job = job().checkpoints(Some(Checkpoints { every, folder: Some(aside.clone()) }));
    cancel(&job, &out, 9);
    assert!(!out.exists());
    checkpoint(&aside);
    let (_, lines) = finish(&job, &out);
    assert!(lines[0].contains("continues"), "{lines:?}");
    assert!(bytes(&out) == expected);
    assert!(checkpoints(&aside).is_empty());
}

/// A name alone makes no checkpoint: the file may be anybody's.
#[test]
fn a_file_of_the_name_of_a_checkpoint_is_not_overwritten() {
    let (folder, expected, tiles) = bench();
    let out = folder.path().join("out");
    cancel(&job(), &out, 12);
    let path = checkpoint(&out);
    let mut bytes_of_other = fs::read(&path).unwrap();
    bytes_of_other[3] ^= 4;
    fs::write(&path, &bytes_of_other).unwrap();
    let watch = Watch::cancel_after(u64::MAX);
    let (outcome, lines) = run(&job(), &out, &watch, None);
    outcome.unwrap();
    assert!(lines.iter().any(|line| line.contains("is no checkpoint of this program")), "{lines:?}");
    assert!(watch.done() >= tiles, "everything is rendered");
    assert!(fs::read(&path).unwrap() == bytes_of_other);
    fs::remove_file(&path).unwrap();
    assert!(bytes(&out) == expected);
}

/// Damage of any kind costs tiles, not correctness.
#[test]
fn of_a_damaged_checkpoint_the_good_part_is_used() {
    let (folder, expected, tiles) = bench();
    let out = folder.path().join("out");
    cancel(&job(), &out, 12);
    let path = checkpoint(&out);
    let good = fs::read(&path).unwrap();
    let identity = u64::from_le_bytes(good[48..56].try_into().unwrap()) as usize;
    let header = 56 + identity + 32;
    let values = u64::from_le_bytes(good[header + 16..header + 24].try_into().unwrap()) as usize;
    let second = header + 112 + 4 * values;
    let flip = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 4;
        bytes
    };
    let mut zeros = good.clone();
    zeros.resize(good.len() + 10_000, 0);
    let repeated = [&good[..], &good[header..second]].concat();
    // What is wrong, how many of the 12 tiles may be used at most, and a part of what is said.
    for (name, damaged, usable, part) in [
        ("cut in the values", good[..good.len() - 5].to_vec(), 13, "damaged bytes at its end"),
        ("cut in a record", good[..second + 50].to_vec(), 1, "damaged bytes at its end"),
        ("cut in the header", good[..header - 1].to_vec(), 0, "header is damaged"),
        ("empty", Vec::new(), 0, "header is damaged"),
        ("zeros at the end", zeros, 14, "10000 damaged bytes at its end"),
        ("a bit of the digest of the render", flip(20), 0, "header is damaged"),
        ("a bit of the identity", flip(60), 0, "header is damaged"),
        ("a bit of the first record", flip(header + 9), 0, "damaged bytes at its end"),
        ("a bit of the count of values", flip(header + 18), 0, "damaged bytes at its end"),
        ("a bit of the second record", flip(second + 90), 1, "damaged bytes at its end"),
        ("a bit of the values", flip(header + 200), 13, "1 tiles of the checkpoint were damaged"),
        ("a tile twice", repeated, 14, "continues"),
    ] {
        let _ = fs::remove_dir_all(&out);
        fs::create_dir(&out).unwrap();
        fs::write(&path, damaged).unwrap();
        let (rendered, lines) = finish(&job(), &out);
        assert!(lines.iter().any(|line| line.contains(part)), "{name}: {lines:?}");
        assert!(rendered >= tiles - usable, "{name}: {rendered}");
        assert!(bytes(&out) == expected, "{name}");
    }
}

#[test]
fn a_checkpoint_of_another_render_is_not_used() {
    let folder = tempfile::tempdir().unwrap();
    let with = |change: fn(&mut RenderSettings)| {
        let mut settings = job().settings;
        change(&mut settings);
        with_settings(settings)
    };
    let mut other_scene = job();
    other_scene.source = gallery("chess");
    for (number, (other, part)) in [
        (with(|settings| settings.light.seed = 1), "`seed=1`"),
        (with(|settings| settings.light.samples = Some(3.into())), "`spp` has changed"),
        (
            with(|settings| settings.camera.rig_mut().unwrap().spacing = Spacing::BaselineM(1e-4)),
            "`baseline-m` has changed",
        ),
        (with(|settings| settings.output.ground_truth = GroundTruth::Central), "`ground-truth` has changed"),
        (other_scene, "the scene has changed"),
    ]
    .into_iter()
    .enumerate()
    {
        let (out, alone) = (folder.path().join(format!("out{number}")), folder.path().join(format!("alone{number}")));
        cancel(&job(), &out, 6);
        let first = checkpoint(&out);
        let lines = cancel(&other, &out, 3);
        assert!(lines[0].contains("is not used") && lines[0].contains(part), "{lines:?}");
        assert!(first.exists() && checkpoints(&out).len() == 2, "both can still be continued");
        let (_, lines) = finish(&other, &out);
        assert!(lines.len() == 2 && lines.iter().any(|line| line.contains("continues with 3")), "{lines:?}");
        finish(&other.checkpoints(None), &alone);
        assert!(bytes(&out) == bytes(&alone), "{part}");
    }
}

/// Exposure, bit depth and files do not determine what is kept.
#[test]
fn a_checkpoint_serves_other_files_of_the_same_light_field() {
    let folder = tempfile::tempdir().unwrap();
    let (out, alone) = (folder.path().join("out"), folder.path().join("alone"));
    cancel(&job(), &out, 10);
    let mut settings = job().settings;
    settings.output.bit_depth = 16;
    settings.output.write.retain(|output| *output != Output::Mat);
    let other = with_settings(settings);
    let (_, lines) = finish(&other, &out);
    assert!(lines[0].contains("continues"), "{lines:?}");
    finish(&other.checkpoints(None), &alone);
    assert!(bytes(&out) == bytes(&alone));
}

#[test]
fn interrupted_shards_make_the_whole() {
    let (folder, expected, _) = bench();
    let parts = [1, 2, 3].map(|part| folder.path().join(format!("part{part}")));
    for (out, part) in parts.iter().zip(1..) {
        let shard = Some(Shard { part, of: 3 });
        if part != 2 {
            run(&job(), out, &Watch::cancel_after(2), shard).0.unwrap_err();
            let why =
                merge(&folder.path().join("merged"), std::slice::from_ref(out), &(), &Rollback::default()).unwrap_err();
            assert!(why.to_string().contains("unfinished render"), "{why}");
            let lines = run(&job(), out, &Watch::cancel_after(0), Some(Shard { part: 2, of: 3 })).1;
            assert!(lines[0].contains("is not used"), "the checkpoint of another part: {lines:?}");
        }
        run(&job(), out, &Watch::cancel_after(u64::MAX), shard).0.unwrap();
    }
    // The manifests contain the numbers of rays and samples.
    let undisturbed = folder.path().join("undisturbed");
    let shard = Some(Shard { part: 3, of: 3 });
    run(&job().checkpoints(None), &undisturbed, &Watch::cancel_after(u64::MAX), shard).0.unwrap();
    assert!(bytes(&undisturbed) == bytes(&parts[2]));
    merge(&folder.path().join("merged"), &parts, &(), &Rollback::default()).unwrap();
    assert!(bytes(&folder.path().join("merged")) == expected);
}

#[test]
fn an_interrupted_job_of_a_dataset_continues() {
    let folder = tempfile::tempdir().unwrap();
    let (root, alone) = (folder.path().join("set"), folder.path().join("alone"));
    let job = job();
    let mut settings = job.settings.clone();
    settings.camera = rig(Pixels::Sensor(holo_core::Sensor::Other(GridSize::new(180, 270)))).into();
    let plan = DatasetPlan::new(&[job.source], &[GridSize::new(5, 6)], settings, job.engine);
    let plan = plan.unwrap().checkpoints(job.checkpoints.as_ref());
    let run = |root: &Path, watch: &Watch| {
        plan.describe(root, &(), &Rollback::default()).unwrap();
        plan.run().job(&plan.jobs()[0], root, &RunOptions::new().progress(watch))
    };
    run(&root, &Watch::cancel_after(8)).unwrap_err();
    let verified = verify(&root).unwrap();
    assert!(verified.bad_folders == 1 && verified.mismatches[0].contains("unfinished render"), "{verified:?}");
    let watch = Watch::cancel_after(u64::MAX);
    assert!(matches!(run(&root, &watch).unwrap(), ShotOutcome::Made(..)));
    let whole = Watch::cancel_after(u64::MAX);
    run(&alone, &whole).unwrap();
    assert!(watch.done() < whole.done());
    assert!(bytes(&root) == bytes(&alone));
    // Killed between the manifest and the removal of the checkpoint.
    let inner = root.join(plan.jobs()[0].folder().unwrap());
    fs::write(inner.join(".holo-0123456789abcdef.checkpoint"), "holo checkpoint\x01 and more").unwrap();
    assert!(matches!(run(&root, &watch).unwrap(), ShotOutcome::Kept(_)));
    assert!(bytes(&root) == bytes(&alone));
}

/// The variable by which a test of this file starts itself as another process.
const OUT: &str = "HOLO_TEST_CHECKPOINT_OUT";

/// The pause after every tile there, ms.
const PAUSE_MS: &str = "HOLO_TEST_CHECKPOINT_PAUSE_MS";

/// Not a test of its own: a slow render in a process that other tests kill.
#[test]
fn render_in_a_process() {
    let Some(out) = std::env::var_os(OUT) else { return };
    let pause = Duration::from_millis(std::env::var(PAUSE_MS).unwrap().parse().unwrap());
    let watch = Watch { pause, ..Watch::cancel_after(u64::MAX) };
    let (outcome, lines) = run(&job(), Path::new(&out), &watch, None);
    println!("{lines:?}");
    outcome.unwrap();
}

#[cfg(unix)]
fn start(out: &Path, before: &str, pause_ms: u64) -> Child {
    let command = format!("{before} exec \"$0\" --exact checkpoints::render_in_a_process --nocapture --test-threads 1");
    let mut shell = Command::new("sh");
    shell
        .args(["-c", &command])
        .arg(std::env::current_exe().unwrap())
        .env(OUT, out)
        .env(PAUSE_MS, pause_ms.to_string());
    shell.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[cfg(unix)]
#[test]
fn a_killed_process_is_continued_to_the_same_bytes() {
    let (folder, expected, tiles) = bench();
    let out = folder.path().join("out");
    let size = || checkpoints(&out).first().and_then(|path| fs::metadata(path).ok()).map_or(0, |found| found.len());
    let mut kills = 0;
    let mut before = 0;
    // Each process is killed when it has stored some more tiles.
    loop {
        let mut child = start(&out, "", 40);
        let start = Instant::now();
        while child.try_wait().unwrap().is_none() && size() < before + 250_000 {
            assert!(start.elapsed() < Duration::from_secs(60), "nothing is stored");
            std::thread::sleep(Duration::from_millis(1));
        }
        // SIGKILL.
        let _ = child.kill();
        if child.wait().unwrap().success() {
            break;
        }
        kills += 1;
        before = size();
        let left: Vec<PathBuf> = bytes(&out).into_keys().collect();
        assert!(!left.contains(&"manifest.json".into()), "{left:?}");
    }
    assert!(kills >= 2, "{kills}");
    assert!(bytes(&out) == expected, "after {kills} kills");
    // The last checkpoint of all, from a kill, continued in this process.
    let out = folder.path().join("again");
    let mut child = start_and_wait(&out, 100_000);
    child.kill().unwrap();
    child.wait().unwrap();
    let (rendered, _) = finish(&job(), &out);
    assert!(rendered < tiles - 3, "{rendered} of {tiles}");
    assert!(bytes(&out) == expected);
}

/// Starts a process, and waits until its checkpoint has a size.
#[cfg(unix)]
fn start_and_wait(out: &Path, bytes: u64) -> Child {
    let child = start(out, "", 300);
    let begin = Instant::now();
    while checkpoints(out).first().is_none_or(|path| fs::metadata(path).map_or(0, |found| found.len()) < bytes) {
        assert!(begin.elapsed() < Duration::from_secs(60), "nothing is stored");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

#[cfg(unix)]
#[test]
fn two_processes_do_not_share_a_folder_or_a_checkpoint() {
    let (folder, expected, _) = bench();
    let (out, other) = (folder.path().join("out"), folder.path().join("other"));
    let mut child = start_and_wait(&out, 30_000);
    let why = run(&job(), &out, &Watch::cancel_after(3), None).0.unwrap_err().to_string();
    assert!(why.contains(&format!("process {} on ", child.id())) && why.contains("is writing in it"), "{why}");
    // With a folder of its own, and the checkpoint in that of the first.
    let aside = Checkpoints { every: Duration::ZERO, folder: Some(out.clone()) };
    let lines = run(&job().checkpoints(aside), &other, &Watch::cancel_after(3), None).1;
    assert!(lines.iter().any(|line| line.contains("another process renders the same")), "{lines:?}");
    let _ = child.kill();
    child.wait().unwrap();
    finish(&job(), &out);
    assert_eq!(bytes(&out).keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    assert!(bytes(&out) == expected);
}

/// A file may not grow beyond some 100 KB: the checkpoint fails first, then the output. No privilege is needed.
#[cfg(unix)]
#[test]
fn on_a_full_disk_the_good_part_is_kept() {
    let (folder, expected, tiles) = bench();
    let out = folder.path().join("out");
    // `bash` counts in KiB, others in blocks of 512 bytes. The signal is ignored, so that the write itself fails.
    let child = start(&out, "trap '' XFSZ; ulimit -f 100;", 40);
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!output.status.success(), "{text}");
    assert!(text.contains("the last checkpoint could not be written") && text.contains("continues"), "{text}");
    let size = fs::metadata(checkpoint(&out)).unwrap().len();
    assert!((18_000..=102_400).contains(&size), "{size}: some tiles fit");
    assert_eq!(bytes(&out).len(), 1, "{:?}", bytes(&out).keys());
    let (rendered, lines) = finish(&job(), &out);
    assert!(rendered < tiles && lines.len() == 1 && !lines[0].contains("damaged"), "{rendered} {lines:?}");
    assert!(bytes(&out) == expected);
}

#[test]
fn a_render_succeeds_where_no_checkpoint_can_be_written() {
    let (folder, expected, _) = bench();
    let (out, missing) = (folder.path().join("out"), folder.path().join("missing"));
    let checkpoints = Checkpoints { every: Duration::ZERO, folder: Some(missing) };
    let (_, lines) = finish(&job().checkpoints(Some(checkpoints)), &out);
    assert!(lines.len() == 1 && lines[0].contains("could not be written"), "{lines:?}");
    assert!(bytes(&out) == expected);
}
