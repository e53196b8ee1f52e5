//! `transforms.json` in the root of several poses, whose folders it names.

use holo_core::GridSize;
use holo_io::{CameraArray, Folder, WorldUp};

use super::TRANSFORMS;
use crate::Error;

/// The largest size of a file that is read to find out whose it is.
const MAX_BYTES: u64 = 1 << 30;

/// Writes the poses of the folders in a root; `size` is that of cameras without one. Temporary files that a killed run left
/// there are removed: those in the folders of shots are when these are opened.
pub(crate) fn write(root: &Folder, cameras: &CameraArray, up: WorldUp, size: Option<GridSize>) -> Result<(), Error> {
    let mut cameras = cameras.clone();
    for camera in &mut cameras.cameras {
        camera.size = camera.size.or(size);
    }
    root.remove_stale_temporary_files()?;
    cameras.write_folders(root.file(TRANSFORMS), up)?;
    Ok(())
}

/// Whether the poses in a root are in every byte as [`write`] writes them, without anything else: a list that came from
/// elsewhere is none to replace.
pub(crate) fn is_own(root: &Folder) -> bool {
    let is_same = || {
        let bytes = root.read(TRANSFORMS, MAX_BYTES).ok()?;
        // Both directions turn the axes alike.
        let up = WorldUp::default();
        let cameras = CameraArray::read_in(root, TRANSFORMS, up, None).ok()?;
        Some(cameras.to_folders_json(&root.path_of(TRANSFORMS), up).ok()?.as_bytes() == bytes)
    };
    is_same().unwrap_or(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_with_one_more_byte_is_not_own() {
        let place = tempfile::tempdir().expect("a folder");
        let root = Folder::open(place.path()).expect("opened");
        assert!(!is_own(&root));
        let cameras = CameraArray { cameras: vec![Default::default()] };
        write(&root, &cameras, WorldUp::default(), Some(GridSize::new(2, 3))).expect("written");
        assert!(is_own(&root));
        let path = place.path().join(TRANSFORMS);
        let text = std::fs::read_to_string(&path).expect("read");
        std::fs::write(&path, text + "\n").expect("written");
        assert!(!is_own(&root));
    }
}
