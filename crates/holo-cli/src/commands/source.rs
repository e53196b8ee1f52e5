//! Where a scene comes from: a file, or the gallery.

use std::path::{Path, PathBuf};

use holo_io::Sha256;
use holo_scene::gltf::{self, Limits, Loaded};
use holo_scene::{Error, gallery};

use crate::failure::Failure;

/// A scene that can be loaded.
#[derive(Clone, Debug)]
pub enum Source {
    /// A `.glb` or `.gltf`.
    File(PathBuf),
    /// One of the gallery, as the `.glb` that `holo scene` writes: whoever renders that gets the same picture.
    Gallery(&'static str, Vec<u8>),
}

impl Source {
    /// The scene of the gallery that has this name.
    pub fn gallery(name: &str) -> Result<Self, Failure> {
        let known = gallery::NAMES.iter().find(|known| **known == name);
        let (name, scene) = known.and_then(|known| Some((*known, gallery::scene(known)?))).ok_or_else(|| {
            let known = gallery::NAMES.join(", ");
            Failure::Usage(format!("the gallery has no scene '{name}'; it has: {known}"))
        })?;
        Ok(Self::Gallery(name, gltf::to_glb(&scene)?))
    }

    /// What to call it in messages: the file's path, or the scene's name.
    pub fn path(&self) -> &Path {
        match self {
            Self::File(path) => path,
            Self::Gallery(name, _) => Path::new(name),
        }
    }

    /// Its name: that of the file without its ending.
    pub fn name(&self) -> String {
        self.path().file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// The digest of the file.
    pub fn sha256(&self) -> Result<Sha256, Failure> {
        Ok(match self {
            Self::File(path) => holo_io::hash_file(path)?.sha256,
            Self::Gallery(_, glb) => Sha256::of(glb),
        })
    }

    pub fn load(&self) -> Result<Loaded, Error> {
        match self {
            Self::File(path) => gltf::load(path, &Limits::default()),
            Self::Gallery(_, glb) => gltf::load_slice(glb, &Limits::default()),
        }
    }
}
