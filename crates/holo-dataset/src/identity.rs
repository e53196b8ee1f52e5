//! What distinguishes two renders by their manifests.

use holo_io::{Manifest, ManifestValue};

/// The first difference between the manifest of an older result and the identity of a job.
pub(crate) fn difference(manifest: &Manifest, identity: &Manifest) -> Option<String> {
    let text = |value: Option<&String>| value.map_or_else(|| "unknown".to_owned(), Clone::clone);
    for (name, version) in &identity.versions {
        let own = manifest.versions.get(name);
        if own != Some(version) {
            return Some(format!("it was made by {name} {}, this is {name} {version}", text(own)));
        }
    }
    if manifest.seed != identity.seed {
        return Some(format!("it was made with --seed={}, this is --seed={}", manifest.seed, identity.seed));
    }
    for (name, value) in &identity.settings {
        let own = manifest.settings.get(name);
        if own == Some(value) {
            continue;
        }
        return Some(match (name.as_str(), own, value) {
            ("scene_sha256", ..) => "the scene has changed".into(),
            ("sky_sha256", ..) => "the environment map has changed".into(),
            (_, Some(ManifestValue::Table(own)), ManifestValue::Table(value)) => {
                let keys = value.keys().chain(own.keys());
                let changed = keys.into_iter().find(|key| own.get(*key) != value.get(*key));
                changed.map_or_else(|| "its options differ".into(), |key| format!("--{key} has changed"))
            }
            _ => format!("'{name}' has changed"),
        });
    }
    None
}
