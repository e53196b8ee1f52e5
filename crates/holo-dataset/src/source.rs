//! Where a scene comes from: a file, or the gallery.

use std::path::{Path, PathBuf};

use holo_io::Sha256;
use holo_scene::gallery;
use holo_scene::gltf::{self, Limits, Loaded};

use crate::Error;

/// A scene that can be loaded.
#[derive(Clone, Debug)]
pub enum SceneSource {
    /// A `.glb` or `.gltf`.
    File(PathBuf),
    /// One of the gallery, as the `.glb` that `holo scene` writes: whoever renders that gets the same picture.
    Gallery(&'static str, Vec<u8>),
}

impl SceneSource {
    /// The scene of the gallery that has this name.
    ///
    /// # Errors
    /// [`Error::BadRequest`]: no such scene.
    pub fn gallery(name: &str) -> Result<Self, Error> {
        let known = gallery::NAMES.iter().find(|known| **known == name);
        let (name, scene) = known.and_then(|known| Some((*known, gallery::scene(known)?))).ok_or_else(|| {
            let known = gallery::NAMES.join(", ");
            Error::BadRequest(format!("the gallery has no scene '{name}'; it has: {known}"))
        })?;
        Ok(Self::Gallery(name, gltf::to_glb(&scene)?))
    }

    /// What to call it in messages: the file's path, or the scene's name.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::File(path) => path,
            Self::Gallery(name, _) => Path::new(name),
        }
    }

    /// Its name: that of the file without its ending.
    #[must_use]
    pub fn name(&self) -> String {
        self.path().file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// The digest of the file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn sha256(&self) -> Result<Sha256, Error> {
        Ok(match self {
            Self::File(path) => holo_io::hash_file(path)?.sha256,
            Self::Gallery(_, glb) => Sha256::of(glb),
        })
    }

    /// Reads the scene.
    ///
    /// # Errors
    /// A file that cannot be read or breaks the rules of glTF.
    pub fn load(&self) -> Result<Loaded, holo_scene::Error> {
        match self {
            Self::File(path) => gltf::load(path, &Limits::default()),
            Self::Gallery(_, glb) => gltf::load_slice(glb, &Limits::default()),
        }
    }
}
