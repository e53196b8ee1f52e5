//! Atomic files appear whole or not at all.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Barrier;
use std::time::{Duration, Instant};

use crate::common::names;
use holo_io::{AtomicFile, Error, Sha256, hash_file, remove_stale_temporary_files, write_file};

#[test]
fn the_digest_is_that_of_the_standard() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("abc");
    let written = write_file(&path, b"abc").unwrap();
    let digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!((written.bytes, written.sha256.to_string()), (3, digest.to_owned()));
    assert_eq!(Sha256::from_hex(digest), Some(written.sha256));
    assert_eq!(Sha256::from_hex(&digest.to_uppercase()), Some(written.sha256));
    for bad in ["", &digest[1..], &format!("{digest}0"), &digest.replace('b', "g"), &"ä".repeat(32)] {
        assert_eq!(Sha256::from_hex(bad), None, "{bad}");
    }
}

#[test]
fn pieces_of_any_size_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    let data: Vec<u8> = (0..1_500_000_u32).map(|at| ((at * 31) >> 7) as u8).collect();
    let mut file = AtomicFile::create(&path).unwrap();
    let mut rest = data.as_slice();
    for size in [0, 1, 255, 70_000, 262_143, 262_144, 262_145, 1, 600_000].into_iter().cycle() {
        let (piece, more) = rest.split_at(rest.len().min(size));
        file.write_all(piece).unwrap();
        rest = more;
        if rest.is_empty() {
            break;
        }
    }
    assert_eq!(names(folder.path()).len(), 1);
    assert!(!path.exists());
    let written = file.commit().unwrap();
    assert_eq!(fs::read(&path).unwrap(), data);
    assert_eq!(written, hash_file(&path).unwrap());
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn a_dropped_file_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(&[1; 1_000_000]).unwrap();
    drop(file);
    assert_eq!(names(folder.path()), [""; 0]);
    write_file(&path, b"old").unwrap();
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(b"new").unwrap();
    file.flush().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"old");
    drop(file);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn concurrent_writers_of_one_name_leave_one_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    let barrier = Barrier::new(8);
    std::thread::scope(|scope| {
        for writer in 0..8_u8 {
            let (path, barrier) = (&path, &barrier);
            scope.spawn(move || {
                for _ in 0..10 {
                    let mut file = AtomicFile::create(path).unwrap();
                    barrier.wait();
                    (0..50).for_each(|_| file.write_all(&[writer; 9973]).unwrap());
                    file.commit().unwrap();
                    let seen = fs::read(path).unwrap();
                    assert!(seen.len() == 50 * 9973 && seen.iter().all(|&byte| byte == seen[0]));
                }
            });
        }
    });
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn paths_that_cannot_be_written_are_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), b"x").unwrap();
    for name in ["file/inside", "missing/inside", ""] {
        let path = folder.path().join(name);
        let error = write_file(&path, b"x").unwrap_err();
        assert!(matches!(error, Error::Io { .. }) && error.path() == path, "{error}");
    }
    for path in ["", "/missing/.."] {
        assert!(write_file(path, b"x").is_err());
    }
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn a_relative_name_means_the_folder_of_its_creation() {
    // Tests share the working folder, so it is only read here.
    let name = format!("target-free-{}.tmp", std::process::id());
    let written = write_file(&name, b"here").unwrap();
    let found = std::env::current_dir().unwrap().join(&name);
    let read = fs::read(&found).unwrap();
    fs::remove_file(&found).unwrap();
    assert_eq!((written.bytes, read), (4, b"here".to_vec()));
}

#[cfg(unix)]
#[test]
fn a_link_stays_and_its_target_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    let (link, target) = (folder.path().join("link"), elsewhere.path().join("target"));
    fs::write(&target, b"old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    write_file(&link, b"new").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&target).unwrap(), b"new");
    assert_eq!((names(folder.path()), names(elsewhere.path())), (vec!["link".into()], vec!["target".into()]));
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_into_and_stay_devices() {
    assert_eq!(write_file("/dev/null", b"gone").unwrap().bytes, 4);
    let mut file = AtomicFile::create("/dev/full").unwrap();
    // The code in between ignores the error, as destructors do.
    let _ = file.write_all(&[0; 300_000]);
    let _ = file.write_all(&[0; 300_000]);
    let error = file.commit().unwrap_err();
    let Error::Io { error: source, .. } = &error else { panic!("{error}") };
    assert_eq!(source.kind(), std::io::ErrorKind::StorageFull);
    for device in ["/dev/null", "/dev/full"] {
        assert!(!fs::metadata(device).unwrap().is_file());
    }
}

/// The child process of the tests below: starts a file in a folder, creates the file `ready`, and waits.
#[test]
#[ignore = "run by other tests in a process of its own"]
fn child() {
    let folder = PathBuf::from(std::env::var_os("HOLO_IO_TEST_FOLDER").unwrap());
    let mut file = AtomicFile::create(folder.join("big.png")).unwrap();
    file.write_all(&[7; 600_000]).unwrap();
    file.flush().unwrap();
    fs::write(folder.join("ready"), b"").unwrap();
    match std::env::var("HOLO_IO_TEST_END").as_deref() {
        Ok("clean up") => {
            let held = holo_io::remove_temporary_files();
            let count = held.count();
            let path = folder.join("late.png");
            let late = std::thread::spawn(move || AtomicFile::create(path).unwrap().commit().unwrap().bytes);
            std::thread::sleep(Duration::from_millis(200));
            let waits = !late.is_finished();
            drop(held);
            let late = late.join().unwrap();
            let lost = file.commit().unwrap_err().to_string();
            fs::write(folder.join("report"), format!("{count}\nwaits: {waits}, {late} bytes\n{lost}")).unwrap();
        }
        _ => std::thread::sleep(Duration::from_secs(60)),
    }
}

fn start_child(folder: &Path, end: &str) -> Child {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["atomic::child", "--exact", "--ignored", "--nocapture"])
        .env("HOLO_IO_TEST_FOLDER", folder)
        .env("HOLO_IO_TEST_END", end)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !folder.join("ready").exists() {
        assert!(started.elapsed() < Duration::from_secs(30), "the child did not start");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

#[test]
fn the_temporary_file_of_a_killed_process_is_removed_later() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = start_child(folder.path(), "be killed");
    let part = names(folder.path()).into_iter().find(|name| name.starts_with(".big.png.")).unwrap();
    assert_eq!(part, format!(".big.png.{}-0.part", child.id()));
    // Files of running processes, including this one, stay.
    let mut own = AtomicFile::create(folder.path().join("own.png")).unwrap();
    own.write_all(b"own").unwrap();
    assert!(remove_stale_temporary_files(folder.path()).unwrap().is_empty());

    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!folder.path().join("big.png").exists());
    // Files with similar names stay.
    let lookalikes = [".big.png.part", "big.png.1-0.part", ".x.99999999-0.parts", ".x.99999999-0.part"];
    lookalikes[..3].iter().for_each(|name| fs::write(folder.path().join(name), b"mine").unwrap());
    fs::create_dir(folder.path().join(lookalikes[3])).unwrap();
    assert_eq!(remove_stale_temporary_files(folder.path()).unwrap(), [folder.path().join(part)]);
    own.commit().unwrap();
    let mut left: Vec<String> = lookalikes.iter().chain(&["own.png", "ready"]).map(|&name| name.to_owned()).collect();
    left.sort();
    assert_eq!(names(folder.path()), left);
}

#[test]
fn the_lock_protects_a_file_of_an_unknown_process() {
    // As seen from another machine or container: no process of that number, but a lock.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(".x.png.999999999-0.part");
    let file = fs::File::create(&path).unwrap();
    if file.try_lock().is_err() {
        return; // a file system without locks
    }
    assert!(remove_stale_temporary_files(folder.path()).unwrap().is_empty());
    drop(file);
    assert_eq!(remove_stale_temporary_files(folder.path()).unwrap(), [path]);
}

#[test]
fn open_files_are_removed_and_new_ones_wait_for_whoever_removed_them() {
    let folder = tempfile::tempdir().unwrap();
    let status = start_child(folder.path(), "clean up").wait().unwrap();
    assert!(status.success());
    assert_eq!(names(folder.path()), ["late.png", "ready", "report"]);
    let report = fs::read_to_string(folder.path().join("report")).unwrap();
    let lines: Vec<&str> = report.lines().collect();
    assert_eq!(lines[0], "1");
    assert_eq!(lines[1], "waits: true, 0 bytes");
    assert!(lines[2].starts_with("cannot write"), "{report}");
}

#[test]
fn a_missing_folder_is_an_error() {
    let error = remove_stale_temporary_files("/missing/folder").unwrap_err();
    assert_eq!(error.path(), Path::new("/missing/folder"));
}
