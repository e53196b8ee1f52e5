//! Failures of writers: a full disk, a read-only folder, two writers of one name, a killed process. In each case the
//! name is a complete file or the old one, and no other file is left.
#![cfg(unix)]

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Barrier;
use std::time::{Duration, Instant};

use crate::common::names;
use holo_core::{GridSize, LightFieldOwned, SampleKind};
use holo_io::{
    ColorEncoding, Compression, Error, ExrChannel, ExrCompression, ExrSamples, ExrWriter, FileDigest, Limits,
    MatOptions, MatOrder, MatVersion, PngWriter, read_exr, read_mat_light_field, read_pfm_gray, read_png,
    remove_stale_temporary_files, write_exr_with, write_mat_light_field, write_pfm, write_png,
};
use ndarray::{Array2, Array3, Axis};

/// A way to write an image: a file name, and a function that writes an image that depends on a seed.
type Way = (&'static str, fn(&Path, u64) -> Result<FileDigest, Error>);

const WAYS: &[Way] = &[
    ("fast.png", |path, seed| {
        write_png(path, noise(seed).mapv(|bits| bits as u8).view(), ColorEncoding::Srgb, Compression::Fast)
    }),
    ("best.png", |path, seed| {
        write_png(path, noise(seed).mapv(|bits| bits as u16).view(), ColorEncoding::Linear, Compression::Best)
    }),
    ("bands.png", |path, seed| {
        let image = noise(seed).mapv(|bits| bits as u8);
        let size = GridSize::new(image.dim().0, image.dim().1);
        let mut writer = PngWriter::create(path, size, 3, SampleKind::U8, ColorEncoding::Srgb, Compression::Best)?;
        image.axis_chunks_iter(Axis(0), 7).try_for_each(|rows| writer.write_rows(rows))?;
        writer.finish()
    }),
    ("map.pfm", |path, seed| write_pfm(path, plane(seed).view())),
    ("zip.exr", |path, seed| write_exr_with(path, &[ExrChannel::float("Y", plane(seed).view())], ExrCompression::Zip)),
    ("piz.exr", |path, seed| write_exr_with(path, &[ExrChannel::half("Y", plane(seed).view())], ExrCompression::Piz)),
    ("none.exr", |path, seed| {
        write_exr_with(path, &[ExrChannel::float("Y", plane(seed).view())], ExrCompression::None)
    }),
    ("bands.exr", |path, seed| {
        let plane = plane(seed);
        let size = GridSize::new(plane.dim().0, plane.dim().1);
        let mut writer = ExrWriter::create(path, size, &[("Y", ExrSamples::Float)], ExrCompression::Zips)?;
        plane.axis_chunks_iter(Axis(0), 7).try_for_each(|rows| writer.write_rows(&[rows]))?;
        writer.finish()
    }),
    ("five.mat", |path, seed| write_light_field(path, seed, MatVersion::V5, false)),
    ("zlib.mat", |path, seed| write_light_field(path, seed, MatVersion::V5, true)),
    #[cfg(feature = "hdf5")]
    ("seven.mat", |path, seed| write_light_field(path, seed, MatVersion::V73, true)),
    #[cfg(feature = "hdf5")]
    ("bands.mat", |path, seed| {
        let field = light_field(seed);
        let mut writer = holo_io::MatWriter::create(path, &rig(), 3, false)?;
        field.samples().axis_chunks_iter(Axis(0), 2).try_for_each(|rows| writer.write_lens_rows(rows))?;
        writer.finish()
    }),
    #[cfg(feature = "hdf5")]
    ("bands.h5", |path, seed| {
        let field = light_field(seed);
        let mut writer = holo_io::Hdf5Writer::create(path, &rig(), 3, &[], &holo_io::Hdf5Options::default())?;
        field.samples().axis_chunks_iter(Axis(0), 2).try_for_each(|rows| writer.write_lens_rows(rows))?;
        writer.finish()
    }),
];

/// The noise as 20 x 11 views of 10 x 21 pixels.
fn light_field(seed: u64) -> LightFieldOwned<u16> {
    let samples = noise(seed).mapv(|bits| bits as u16).into_shape_with_order((21, 10, 11, 20, 3)).unwrap();
    LightFieldOwned::new(samples).unwrap()
}

#[cfg(feature = "hdf5")]
fn rig() -> holo_core::Rig {
    holo_core::Rig::builder(light_field(0).shape())
        .intrinsics(holo_core::Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 })
        .baseline_m(1e-3)
        .focus_distance_m(1.0)
        .projection(holo_core::Projection::Perspective)
        .build()
        .unwrap()
}

fn write_light_field(path: &Path, seed: u64, version: MatVersion, is_compressed: bool) -> Result<FileDigest, Error> {
    let options = MatOptions::new().version(version).compressed(is_compressed);
    write_mat_light_field(path, &light_field(seed), None, MatOrder::Lenses, &options)
}

/// Numbers that do not compress, more than 64 KiB in any of the files.
fn noise(seed: u64) -> Array3<u64> {
    let mut state = seed * 2 + 1;
    Array3::from_shape_simple_fn((231, 200, 3), || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    })
}

fn plane(seed: u64) -> Array2<f32> {
    noise(seed).index_axis(Axis(2), 0).mapv(|bits| (bits % 60_001) as f32)
}

/// Whether the file is complete.
fn reads(path: &Path) -> bool {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("png") => read_png(path, &Limits::default()).is_ok(),
        Some("pfm") => read_pfm_gray(path, &Limits::default()).is_ok(),
        Some("mat") => read_mat_light_field(path, &Limits::default()).is_ok(),
        #[cfg(feature = "hdf5")]
        Some("h5") => holo_io::Hdf5LightField::open(path, &Limits::default()).and_then(|file| file.read()).is_ok(),
        _ => read_exr(path, &Limits::default()).is_ok(),
    }
}

/// A small file system in memory; `None` without the right to mount one.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    fn new() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(folder.path());
        mount.stdout(Stdio::null()).stderr(Stdio::null());
        let mounted = mount.status().is_ok_and(|status| status.success());
        if !mounted {
            println!("not run: needs root");
        }
        mounted.then(|| Self(folder))
    }

    fn make_read_only(&self) {
        let mut mount = Command::new("mount");
        assert!(mount.args(["-o", "remount,ro"]).arg(self.0.path()).status().unwrap().success());
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

#[test]
fn a_full_disk_leaves_only_the_old_file() {
    let Some(disk) = SmallDisk::new() else { return };
    let folder = disk.0.path();
    for &(name, write) in WAYS {
        let path = folder.join(name);
        fs::write(&path, b"old").unwrap();
        let error = write(&path, 1).expect_err(name);
        let Error::Io { path: said, error: source, .. } = &error else { panic!("{name}: {error}") };
        assert_eq!((said, source.kind()), (&path, ErrorKind::StorageFull), "{name}: {error}");
        assert!(error.to_string().contains("free some space"), "{error}");
        assert_eq!((fs::read(&path).unwrap(), names(folder)), (b"old".to_vec(), vec![name.to_owned()]));
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn a_read_only_folder_is_named_and_keeps_its_files() {
    let Some(disk) = SmallDisk::new() else { return };
    let folder = disk.0.path();
    fs::write(folder.join("zip.exr"), b"old").unwrap();
    disk.make_read_only();
    for &(name, write) in WAYS {
        let path = folder.join(name);
        let error = write(&path, 1).expect_err(name);
        let Error::Io { path: said, error: source, .. } = &error else { panic!("{name}: {error}") };
        assert_eq!((said, source.kind()), (&path, ErrorKind::ReadOnlyFilesystem), "{name}: {error}");
        assert!(error.to_string().contains("choose another folder"), "{error}");
    }
    assert_eq!((fs::read(folder.join("zip.exr")).unwrap(), names(folder)), (b"old".to_vec(), vec!["zip.exr".into()]));
}

#[test]
fn a_folder_without_permission_is_named() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().unwrap();
    let closed = |mode| fs::set_permissions(folder.path(), fs::Permissions::from_mode(mode)).unwrap();
    closed(0o555);
    if fs::write(folder.path().join("probe"), b"").is_ok() {
        println!("not run: this user may write everywhere");
        return;
    }
    for &(name, write) in WAYS {
        let error = write(&folder.path().join(name), 1).expect_err(name);
        assert!(
            matches!(&error, Error::Io { error: source, .. } if source.kind() == ErrorKind::PermissionDenied),
            "{error}"
        );
    }
    closed(0o755);
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn two_writers_of_one_name_leave_one_of_the_two_files() {
    let folder = tempfile::tempdir().unwrap();
    for &(name, write) in WAYS {
        let path = folder.path().join(name);
        let barrier = Barrier::new(2);
        let written: Vec<FileDigest> = std::thread::scope(|scope| {
            let threads = [1, 2].map(|seed| {
                let (path, barrier) = (&path, &barrier);
                scope.spawn(move || {
                    barrier.wait();
                    write(path, seed).unwrap()
                })
            });
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert_ne!(written[0].sha256, written[1].sha256, "{name}");
        let found = holo_io::hash_file(&path).unwrap();
        assert!(written.contains(&found) && reads(&path), "{name}");
        assert_eq!(names(folder.path()), [name]);
        fs::remove_file(&path).unwrap();
    }
}

/// The process that is killed: writes one file repeatedly.
#[test]
#[ignore = "run by another test in a process of its own"]
fn child() {
    let path = PathBuf::from(std::env::var_os("HOLO_IO_TEST_FILE").unwrap());
    let name = path.file_name().unwrap().to_str().unwrap();
    let (_, write) = WAYS.iter().find(|(own, _)| *own == name).unwrap();
    for seed in 1.. {
        write(&path, seed % 2 + 1).unwrap();
    }
}

/// One hundred kills at random moments, shared by all ways to write.
const KILLS: usize = 100;

#[test]
fn a_killed_process_leaves_a_complete_file_and_a_temporary_one_that_is_removed() {
    let mut parts_left = 0;
    let mut state = 7_u64;
    for number in 0..KILLS {
        let (name, write) = WAYS[number % WAYS.len()];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let whole = [1, 2].map(|seed| write(&path, seed).unwrap());
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["failures::child", "--exact", "--ignored", "--nocapture"])
            .env("HOLO_IO_TEST_FILE", &path)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let part = format!(".{name}.{}-", child.id());
        let started = Instant::now();
        while !names(folder.path()).iter().any(|name| name.starts_with(&part)) {
            assert!(started.elapsed() < Duration::from_secs(60), "{name}: nothing was written");
            std::thread::yield_now();
        }
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        std::thread::sleep(Duration::from_micros(state >> 49));
        assert!(remove_stale_temporary_files(folder.path()).unwrap().is_empty(), "{name}: its writer runs");
        child.kill().unwrap();
        child.wait().unwrap();
        // One of the two files that it wrote alternately, complete.
        assert!(whole.contains(&holo_io::hash_file(&path).unwrap()) && reads(&path), "{name}");
        // The next writer succeeds, and after removal of stale files only the complete one is left.
        let new = write(&path, 3).unwrap();
        let removed = remove_stale_temporary_files(folder.path()).unwrap();
        assert!(removed.len() <= 1, "{removed:?}");
        parts_left += removed.len();
        assert_eq!((names(folder.path()), holo_io::hash_file(&path).unwrap()), (vec![name.to_owned()], new));
    }
    println!("{KILLS} kills: {parts_left} left a temporary file, which was removed");
    // Otherwise no kill happened during writing.
    assert!(parts_left > KILLS / 10, "{parts_left}");
}
