//! A list of pinned digests, one per line: `digest  engine/name`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

fn engine(name: &str) -> &str {
    name.split_once('/').map_or(name, |(engine, _)| engine)
}

/// The name of Embree 4.4.0 in the lists: its intersections with AVX-512 and with AVX2 differ in their last bits. `None` for
/// a processor without either, of which nothing is pinned. With `HOLO_EMBREE_ISA=avx2` a processor with AVX-512 makes the
/// digests of AVX2; of other sets nothing is pinned.
pub fn embree() -> Option<&'static str> {
    match std::env::var_os("HOLO_EMBREE_ISA") {
        Some(isa) if isa == "avx2" => return Some("embree-4.4.0-avx2"),
        Some(isa) if isa != "avx512" => return None,
        _ => {}
    }
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx512f") && std::is_x86_feature_detected!("avx512vl") {
        return Some("embree-4.4.0");
    } else if std::is_x86_feature_detected!("avx2") {
        return Some("embree-4.4.0-avx2");
    }
    None
}

/// Fails if a digest of `found` differs from the file `list` or is not in it, or if a digest of the list is missing for
/// an engine that ran. Digests that `is_optional` accepts depend on the build and may be missing.
///
/// With `HOLO_PIN` in the environment it writes the list instead and keeps the lines of engines that did not run.
pub fn check(list: &Path, found: &BTreeMap<String, String>, is_optional: impl Fn(&str) -> bool) {
    let ran: BTreeSet<&str> = found.keys().map(|name| engine(name)).collect();
    let text = std::fs::read_to_string(list).unwrap_or_default();
    let mut pinned: BTreeMap<&str, &str> =
        text.lines().filter_map(|line| line.split_once("  ").map(|(digest, name)| (name, digest))).collect();
    if std::env::var_os("HOLO_PIN").is_some() {
        pinned.retain(|name, _| !ran.contains(engine(name)) || is_optional(name));
        pinned.extend(found.iter().map(|(name, digest)| (name.as_str(), digest.as_str())));
        let lines: String = pinned.iter().map(|(name, digest)| format!("{digest}  {name}\n")).collect();
        std::fs::write(list, lines).expect("the list of digests");
        return;
    }
    let is_pinned = |name: &str, digest: &str| pinned.get(name) == Some(&digest);
    let changed: Vec<_> =
        found.iter().filter(|(name, digest)| !is_pinned(name, digest)).map(|(name, _)| name).collect();
    assert!(changed.is_empty(), "{} of {} are other than pinned: {changed:#?}", changed.len(), found.len());
    let is_missing = |name: &str| ran.contains(engine(name)) && !found.contains_key(name) && !is_optional(name);
    let missing: Vec<_> = pinned.keys().filter(|name| is_missing(name)).collect();
    assert!(missing.is_empty(), "no longer made: {missing:#?}");
}
