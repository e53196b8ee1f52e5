//! The ray tracing backend of a job, and what manifests say of it.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::OnceLock;
use std::thread;

use holo_io::{FileDigest, Manifest};
use holo_render::Renderer;
use holo_scene::{Scene, Transform};

use crate::Error;
use crate::settings::EngineSettings;
use crate::watch::{About, Diagnostics};

/// The key of the backend among the versions.
pub(super) const ENGINE: &str = "engine";

/// Returns the ray tracing backend with its version, as manifests contain it.
pub(crate) fn engine_name(engine: &EngineSettings, diagnostics: &dyn Diagnostics) -> Result<String, Error> {
    let renderer = Renderer::new(&Scene::default(), &Transform::IDENTITY, engine.backend, NonZeroUsize::new(1))?;
    report_backend(&renderer, diagnostics);
    hash_library(&renderer);
    Ok(renderer.engine_name().to_owned())
}

/// Reports if another backend is used than the requested one.
pub(super) fn report_backend(renderer: &Renderer, diagnostics: &dyn Diagnostics) {
    if let Some(note) = renderer.engine_note() {
        diagnostics.report(About::Setup, &format!("warning: {note}"));
    }
}

/// The identity of an image with the backend of its renderer: that of the job, unless the memory was too small for it,
/// which is reported.
pub(super) fn built_with(mut identity: Manifest, renderer: &Renderer, diagnostics: &dyn Diagnostics) -> Manifest {
    let name = renderer.engine_name();
    if identity.versions.get(ENGINE).is_some_and(|expected| expected != name) {
        report_backend(renderer, diagnostics);
        identity.versions.insert(ENGINE.into(), name.into());
    }
    identity
}

/// The library of this process, which loads one; `None` if its file cannot be read.
static LIBRARY: OnceLock<Option<(String, FileDigest)>> = OnceLock::new();

/// Begins to hash the library of a backend while other work goes on: it has tens of megabytes.
fn hash_library(renderer: &Renderer) {
    if let Some(path) = renderer.engine_library().map(Path::to_owned) {
        // Without a thread it is hashed when the digest is needed.
        let _ = thread::Builder::new().spawn(move || LIBRARY.get_or_init(|| named_digest(&path)).is_some());
    }
}

/// The libraries of a backend, for the manifest.
pub(crate) fn libraries(renderer: &Renderer) -> BTreeMap<String, FileDigest> {
    let library = renderer.engine_library().and_then(|path| LIBRARY.get_or_init(|| named_digest(path)).clone());
    library.into_iter().collect()
}

/// The name and the digest of the file that a path leads to.
fn named_digest(path: &Path) -> Option<(String, FileDigest)> {
    let path = path.canonicalize().ok()?;
    Some((path.file_name()?.to_str()?.to_owned(), holo_io::hash_file(&path).ok()?))
}
