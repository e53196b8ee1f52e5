//! Images on a bad day: a full disk, a read-only folder, two writers of one name, a process that is killed. Whatever
//! happens, a name holds a whole file or the old one, and nothing else is left.
#![cfg(all(unix, feature = "png", feature = "exr"))]

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Barrier;
use std::time::{Duration, Instant};

use holo_core::GridSize;
use holo_io::{
    Compression, Error, ExrChannel, ExrCompression, ExrSamples, ExrWriter, Limits, Meaning, PngWriter, Written,
    read_exr, read_pfm_grey, read_png, remove_stale_temporary_files, write_exr_with, write_pfm, write_png_u8,
    write_png_u16,
};
use ndarray::{Array2, Array3, Axis};

/// Every way to write an image: a name for the file, and what writes an image that depends on a number into it.
type Way = (&'static str, fn(&Path, u64) -> Result<Written, Error>);

const WAYS: [Way; 8] = [
    ("scratch.png", |path, seed| {
        write_png_u8(path, noise(seed).mapv(|bits| bits as u8).view(), Meaning::Srgb, Compression::Scratch)
    }),
    ("published.png", |path, seed| {
        write_png_u16(path, noise(seed).mapv(|bits| bits as u16).view(), Meaning::Data, Compression::Published)
    }),
    ("bands.png", |path, seed| {
        let image = noise(seed).mapv(|bits| bits as u8);
        let size = GridSize::new(image.dim().0, image.dim().1);
        let mut writer = PngWriter::create(path, size, 3, Meaning::Srgb, Compression::Published)?;
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
];

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

/// Whether the file is whole.
fn reads(path: &Path) -> bool {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("png") => read_png(path, &Limits::default()).is_ok(),
        Some("pfm") => read_pfm_grey(path, &Limits::default()).is_ok(),
        _ => read_exr(path, &Limits::default()).is_ok(),
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A small file system in memory; `None` where the system does not let us have one.
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
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let Some(disk) = SmallDisk::new() else { return };
    let folder = disk.0.path();
    for (name, write) in WAYS {
        let path = folder.join(name);
        fs::write(&path, b"old").unwrap();
        let error = write(&path, 1).expect_err(name);
        let Error::Io { path: said, source, .. } = &error else { panic!("{name}: {error}") };
        assert_eq!((said, source.kind()), (&path, ErrorKind::StorageFull), "{name}: {error}");
        assert!(error.to_string().contains("free some space"), "{error}");
        assert_eq!((fs::read(&path).unwrap(), names(folder)), (b"old".to_vec(), vec![name.to_owned()]));
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn a_read_only_folder_is_named_and_keeps_what_it_has() {
    let Some(disk) = SmallDisk::new() else { return };
    let folder = disk.0.path();
    fs::write(folder.join("zip.exr"), b"old").unwrap();
    disk.make_read_only();
    for (name, write) in WAYS {
        let path = folder.join(name);
        let error = write(&path, 1).expect_err(name);
        let Error::Io { path: said, source, .. } = &error else { panic!("{name}: {error}") };
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
    for (name, write) in WAYS {
        let error = write(&folder.path().join(name), 1).expect_err(name);
        assert!(matches!(&error, Error::Io { source, .. } if source.kind() == ErrorKind::PermissionDenied), "{error}");
    }
    closed(0o755);
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn two_writers_of_one_name_leave_one_of_the_two_files() {
    let folder = tempfile::tempdir().unwrap();
    for (name, write) in WAYS {
        let path = folder.path().join(name);
        let barrier = Barrier::new(2);
        let written: Vec<Written> = std::thread::scope(|scope| {
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

/// What is written by the process that is killed: images that take a while, or never end.
#[test]
#[ignore = "run by another test in a process of its own"]
fn child() {
    let path = PathBuf::from(std::env::var_os("HOLO_IO_TEST_FILE").unwrap());
    let size = GridSize::new(100_000_000, 1000);
    match path.file_name().unwrap().to_str().unwrap() {
        "published.png" => {
            let rows = Array3::<u8>::zeros((1000, 1000, 3));
            let mut writer = PngWriter::create(&path, size, 3, Meaning::Srgb, Compression::Published).unwrap();
            (0..100_000).for_each(|_| writer.write_rows(rows.view()).unwrap());
        }
        "scratch.png" => {
            let rows = Array3::<u16>::zeros((1000, 1000, 3));
            let mut writer = PngWriter::create(&path, size, 3, Meaning::Srgb, Compression::Scratch).unwrap();
            (0..100_000).for_each(|_| writer.write_rows(rows.view()).unwrap());
        }
        "map.pfm" => {
            // One number repeated takes no memory.
            let one = Array2::<f32>::zeros((1, 1));
            write_pfm(&path, one.broadcast((20_000, 20_000)).unwrap()).unwrap();
        }
        _ => {
            let rows = Array2::<f32>::zeros((1000, 1000));
            let channels = [("Y", ExrSamples::Half)];
            let mut writer = ExrWriter::create(&path, size, &channels, ExrCompression::Zip).unwrap();
            (0..100_000).for_each(|_| writer.write_rows(&[rows.view()]).unwrap());
        }
    }
}

#[test]
fn a_killed_process_leaves_the_old_file_and_a_part_that_is_cleared_away() {
    for (name, write) in
        WAYS.into_iter().filter(|(name, _)| ["scratch.png", "published.png", "map.pfm", "zip.exr"].contains(name))
    {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let old = write(&path, 1).unwrap();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["child", "--exact", "--ignored", "--nocapture"])
            .env("HOLO_IO_TEST_FILE", &path)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let part = folder.path().join(format!(".{name}.{}-0.part", child.id()));
        let started = Instant::now();
        // Until it is in the middle of the pixels.
        while !fs::metadata(&part).is_ok_and(|part| part.len() > 100_000) {
            assert!(started.elapsed() < Duration::from_secs(60), "{name}: nothing was written");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(remove_stale_temporary_files(folder.path()).unwrap().is_empty(), "{name}: its writer lives");
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(holo_io::hash_file(&path).unwrap(), old, "{name}");
        assert!(reads(&path), "{name}");
        // The next writer is not disturbed, and cleaning leaves only what is whole.
        let new = write(&path, 2).unwrap();
        assert_eq!(remove_stale_temporary_files(folder.path()).unwrap(), [part], "{name}");
        assert_eq!((names(folder.path()), holo_io::hash_file(&path).unwrap()), (vec![name.to_owned()], new));
    }
}
