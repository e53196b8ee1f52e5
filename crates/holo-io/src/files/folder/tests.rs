//! Names, links, pipes and devices.

use super::*;

/// A folder `inside`, in which the tests work, and a folder `outside` beside it, which nothing may touch.
fn bench() -> (tempfile::TempDir, Folder) {
    let place = tempfile::tempdir().unwrap();
    for name in ["inside", "outside"] {
        std::fs::create_dir(place.path().join(name)).unwrap();
    }
    std::fs::write(place.path().join("outside/keep"), b"keep").unwrap();
    let folder = Folder::open(place.path().join("inside")).unwrap();
    (place, folder)
}

fn message<T>(outcome: Result<T, Error>) -> String {
    outcome.err().expect("an error").to_string()
}

#[test]
fn names_that_lead_out_are_refused() {
    let (_place, folder) = bench();
    for name in ["", ".", "..", "../outside/keep", "a/../../outside/keep", "/etc/passwd", "a//b", "a/", "a\0", "a\nb"] {
        assert!(matches!(folder.read(name, 9), Err(Error::BadInput { .. })), "{name:?}");
        assert!(matches!(folder.remove_file(name), Err(Error::BadInput { .. })), "{name:?}");
        assert!(matches!(folder.create_folder(name), Err(Error::BadInput { .. })), "{name:?}");
        assert!(crate::write_file(folder.file(name), b"x").is_err(), "{name:?}");
    }
    assert!(message(folder.read("a\u{1b}[2J", 9)).contains("a\\u{1b}[2J"), "no control character is shown");
}

#[test]
fn files_are_read_written_renamed_and_removed() {
    let (_place, folder) = bench();
    assert!(folder.create_folder("a").unwrap() && !folder.create_folder("a").unwrap());
    let written = crate::write_file(folder.file("a/x"), b"holo").unwrap();
    assert_eq!(folder.digest("a/x", 4).unwrap(), written);
    assert!(matches!(folder.digest("a/x", 3), Err(Error::TooLarge { needed: 4, allowed: 3, .. })));
    assert!(matches!(folder.read("a/x", 3), Err(Error::TooLarge { .. })));
    assert_eq!(folder.sub("a").unwrap().read("x", 4).unwrap(), b"holo");
    crate::write_file(folder.file("a/x"), b"again").unwrap();
    folder.rename("a/x", "y").unwrap();
    let expected = [("a".to_owned(), EntryKind::Folder), ("y".to_owned(), EntryKind::File)];
    assert_eq!(folder.list().unwrap(), expected);
    assert_eq!((folder.kind("a/x").unwrap(), folder.kind("b/x").unwrap()), (None, None));
    assert!(message(folder.read("a", 9)).contains("it is a folder"));
    assert!(message(folder.create_folder("y")).contains("it is a file"));
    folder.remove_folder("a").unwrap();
    folder.remove_file("y").unwrap();
    assert!(folder.list().unwrap().is_empty());
}

#[test]
fn a_dropped_file_leaves_nothing() {
    let (_place, folder) = bench();
    let file = crate::AtomicFile::create(folder.file("x")).unwrap();
    assert_eq!(folder.list().unwrap().len(), 1, "the temporary file");
    drop(file);
    assert!(folder.list().unwrap().is_empty());
}

#[cfg(unix)]
#[test]
fn no_link_is_followed() {
    use std::os::unix::fs::symlink;

    let (place, folder) = bench();
    let link = |target: &str, name: &str| symlink(target, place.path().join("inside").join(name)).unwrap();
    link("../outside", "folder");
    link("../outside/keep", "file");
    link("/dev/zero", "zeros");
    link("nowhere", "dangling");
    folder.create_folder("real").unwrap();
    link("real", "inner");
    for name in ["folder/keep", "folder/new", "file", "zeros", "dangling", "inner/x"] {
        let link = message(folder.read(name, 9));
        assert!(link.contains("symbolic link"), "{name}: {link}");
        assert!(message(crate::write_file(folder.file(name), b"x")).contains("symbolic link"), "{name}");
        assert!(message(folder.open_own(name, true)).contains("symbolic link"), "{name}");
        assert!(folder.remove_file(name).is_err() && !folder.has_file(name), "{name}");
        assert!(folder.create_folder(name).is_err(), "{name}");
    }
    assert!(folder.sub("folder").is_err() && folder.sub("inner").is_err());
    crate::write_file(folder.file("own"), b"own").unwrap();
    assert!(message(folder.rename("own", "file")).contains("symbolic link"));
    assert!(folder.rename("own", "folder/own").is_err() && folder.rename("file", "other").is_err());
    assert_eq!(std::fs::read(place.path().join("outside/keep")).unwrap(), b"keep");
    assert_eq!(std::fs::read_dir(place.path().join("outside")).unwrap().count(), 1);
    assert_eq!(folder.kind("dangling").unwrap(), Some(EntryKind::Link));
}

/// The folder stays the one that was opened, whatever its path leads to later.
#[cfg(unix)]
#[test]
fn the_handle_stays_where_the_folder_is() {
    let (place, folder) = bench();
    std::fs::rename(place.path().join("inside"), place.path().join("moved")).unwrap();
    std::os::unix::fs::symlink("outside", place.path().join("inside")).unwrap();
    crate::write_file(folder.file("keep"), b"new").unwrap();
    assert_eq!(std::fs::read(place.path().join("moved/keep")).unwrap(), b"new");
    assert_eq!(std::fs::read(place.path().join("outside/keep")).unwrap(), b"keep");
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_second_names_are_refused_without_waiting() {
    let (place, folder) = bench();
    let pipe = place.path().join("inside/pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo is a program of every Unix");
    for outcome in [
        folder.read("pipe", 9).map(drop),
        folder.open_own("pipe", true).map(drop),
        folder.digest("pipe", 9).map(drop),
        crate::write_file(folder.file("pipe"), b"x").map(drop),
        folder.remove_file("pipe"),
    ] {
        assert!(message(outcome).contains("a pipe, a socket or a device"));
    }
    let devices = Folder::open("/dev").unwrap();
    assert!(message(devices.read("zero", 9)).contains("a pipe, a socket or a device"));
    std::fs::hard_link(place.path().join("outside/keep"), place.path().join("inside/second")).unwrap();
    assert!(message(folder.open_own("second", false)).contains("2 names"));
    // A new file in its place does not change the other name.
    crate::write_file(folder.file("second"), b"new").unwrap();
    assert_eq!(std::fs::read(place.path().join("outside/keep")).unwrap(), b"keep");
}

#[test]
fn the_second_in_a_folder_learns_who_is_the_first() {
    let (place, folder) = bench();
    let lock = folder.lock(false).unwrap();
    let second = Folder::open(place.path().join("inside")).unwrap();
    let why = message(second.lock(true));
    assert!(why.contains(&format!("process {}", std::process::id())) && why.contains("is writing in it"), "{why}");
    drop(lock);
    assert!(folder.list().unwrap().is_empty(), "the file goes with the lock");
    // A killed process leaves the file and no lock.
    std::fs::write(place.path().join("inside/.holo.lock"), "holo lock\nhost gone\nprocess 1\n").unwrap();
    drop(second.lock(false).unwrap());
    // A file of somebody else is neither overwritten nor removed.
    std::fs::write(place.path().join("inside/.holo.lock"), "mine\n").unwrap();
    assert!(message(second.lock(true)).contains("no lock of this program"));
    assert_eq!(std::fs::read(place.path().join("inside/.holo.lock")).unwrap(), b"mine\n");
}
