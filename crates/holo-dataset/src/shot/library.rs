//! The digest of the library that was loaded for ray tracing.
//!
//! Such a library has tens of megabytes, and hashing it takes as long as a small image. So its digest is kept in the
//! user's cache, in a file whose name depends on all that changes with the file: path, device, inode, size, and the times of
//! its contents and of its metadata, which no program can set back.

use std::fs::Metadata;
use std::path::Path;

use holo_io::{FileDigest, Folder, Sha256};

/// The folder of digests in the cache of `holo`.
const DIGESTS: &str = "libraries";

/// The size of a digest in hexadecimal digits.
const DIGITS: u64 = 64;

/// The name and the digest of the file that a path leads to.
pub(super) fn identify(path: &Path) -> Option<(String, FileDigest)> {
    let path = path.canonicalize().ok()?;
    let name = path.file_name()?.to_str()?.to_owned();
    let metadata = path.metadata().ok()?;
    let kept =
        holo_render::cache_folder().zip(state(&path, &metadata)).map(|(cache, state)| (cache.join(DIGESTS), state));
    if let Some(sha256) = kept.as_ref().and_then(|(folder, state)| read(folder, state)) {
        return Some((name, FileDigest { bytes: metadata.len(), sha256 }));
    }
    let digest = holo_io::hash_file(&path).ok()?;
    if let Some((folder, state)) = kept {
        // Without a cache it is hashed every time.
        let _ = write(&folder, &state, &digest.sha256);
    }
    Some((name, digest))
}

/// What tells a state of the file from all others.
#[cfg(unix)]
fn state(path: &Path, metadata: &Metadata) -> Option<String> {
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::MetadataExt;

    let times = [metadata.mtime(), metadata.mtime_nsec(), metadata.ctime(), metadata.ctime_nsec()];
    let numbers = [metadata.dev(), metadata.ino(), metadata.len()].into_iter().chain(times.map(i64::cast_unsigned));
    let bytes: Vec<u8> =
        numbers.flat_map(u64::to_le_bytes).chain(path.as_os_str().as_bytes().iter().copied()).collect();
    Some(Sha256::of(&bytes).to_string())
}

/// Other systems do not tell all of it.
#[cfg(not(unix))]
fn state(_: &Path, _: &Metadata) -> Option<String> {
    None
}

fn read(folder: &Path, state: &str) -> Option<Sha256> {
    let text = Folder::open(folder).ok()?.read(state, DIGITS).ok()?;
    Sha256::from_hex(std::str::from_utf8(&text).ok()?)
}

fn write(folder: &Path, state: &str, digest: &Sha256) -> Option<FileDigest> {
    std::fs::create_dir_all(folder).ok()?;
    holo_io::write_file(Folder::open(folder).ok()?.file(state), digest.to_string().as_bytes()).ok()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_changed_file_is_another_state() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("library");
        let state = || state(&path, &path.metadata().expect("a file")).expect("a state");
        std::fs::write(&path, "one").expect("a file");
        let time = path.metadata().expect("a file").modified().expect("a time");
        let first = state();
        assert_eq!(first, state());
        // The same size, and the time of the contents set back.
        std::thread::sleep(std::time::Duration::from_millis(20));
        std::fs::write(&path, "two").expect("a file");
        std::fs::File::options().write(true).open(&path).expect("a file").set_modified(time).expect("a time");
        assert_eq!(path.metadata().expect("a file").modified().expect("a time"), time);
        assert_ne!(first, state());
        let kept = folder.path().join("cache");
        assert_eq!(read(&kept, &first), None);
        let digest = Sha256::of(b"two");
        write(&kept, &first, &digest).expect("a file");
        assert_eq!(read(&kept, &first), Some(digest));
        std::fs::write(kept.join(&first), "no digest").expect("a file");
        assert_eq!(read(&kept, &first), None);
    }
}
