//! What distinguishes two results by their manifests.

use std::path::Path;

use holo_io::{Manifest, dataset};

use crate::Error;
use crate::output::existing;
use crate::settings::{OPTIONS, changed};

/// Checks that the folder `inner` below `root` has no manifest, or one of a result with the same identity. Results that another version or
/// backend made of the same may be replaced. `other` returns a further reason why the result is another one.
pub(crate) fn check_replaceable(
    (root, inner): (&Path, &str),
    identity: impl FnOnce() -> Result<Manifest, Error>,
    other: impl FnOnce(&Manifest) -> Option<String>,
) -> Result<(), Error> {
    let Some(folder) = existing(root, inner)? else { return Ok(()) };
    if folder.kind(dataset::MANIFEST_JSON)?.is_none() {
        return Ok(());
    }
    let mut older = Manifest::read_in(&folder)?;
    let identity = identity()?;
    let further = other(&older);
    older.versions.clone_from(&identity.versions);
    let advice = "give `overwrite` to replace it, or another `out`";
    further.or_else(|| difference(&older, &identity)).map_or(Ok(()), |why| {
        Err(Error::BadRequest(format!("{} holds another image: {why}; {advice}", folder.path().display())))
    })
}

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
        return Some(format!("it was made with `seed={}`, this is `seed={}`", manifest.seed, identity.seed));
    }
    for (name, value) in &identity.settings {
        let own = manifest.settings.get(name);
        if own == Some(value) {
            continue;
        }
        return Some(match name.as_str() {
            "scene_sha256" => "the scene has changed".into(),
            "sky_sha256" => "the environment map has changed".into(),
            "camera_sha256" => "the plenoptic camera has changed".into(),
            "cameras_sha256" => "the poses have changed".into(),
            OPTIONS => match changed(manifest, identity) {
                Some(key) => format!("`{key}` has changed"),
                None => continue,
            },
            _ => format!("'{}' has changed", holo_io::shown(name)),
        });
    }
    // What this image does not have at all.
    let others = [
        ("camera_sha256", "it is of a plenoptic camera"),
        ("cameras_sha256", "it is of poses of a list"),
        ("sky_sha256", "it has an environment map"),
        ("pose", "it is of one of several poses"),
    ];
    let has = |values: &Manifest, key: &str| values.settings.contains_key(key);
    let other = others.into_iter().find(|(key, _)| has(manifest, key) && !has(identity, key));
    other.map(|(_, what)| what.into())
}
