//! The ray tracing backend of a job, and what manifests say of it.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::OnceLock;

use holo_io::{FileDigest, Manifest};
use holo_render::Renderer;
use holo_scene::{Scene, Transform};

use super::library;
use crate::Error;
use crate::settings::EngineSettings;
use crate::watch::{About, Diagnostics};

/// The key of the backend among the versions.
pub(super) const ENGINE: &str = "engine";

/// Returns the ray tracing backend with its version, as manifests contain it.
pub(crate) fn engine_name(engine: &EngineSettings, diagnostics: &dyn Diagnostics) -> Result<String, Error> {
    let renderer = Renderer::new(&Scene::default(), &Transform::IDENTITY, engine.backend, NonZeroUsize::new(1))?;
    report_backend(&renderer, diagnostics);
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

/// The libraries of a backend, for the manifest.
pub(crate) fn libraries(renderer: &Renderer) -> BTreeMap<String, FileDigest> {
    /// That of this process, which loads one; `None` if its file cannot be read.
    static LIBRARY: OnceLock<Option<(String, FileDigest)>> = OnceLock::new();
    let library = renderer.engine_library().and_then(|path| LIBRARY.get_or_init(|| library::identify(path)).clone());
    library.into_iter().collect()
}
