//! The groups of options in help texts, by what a person decides, and the options that the short help (`-h`) has.

use holo_dataset::settings::Group;

/// The heading of options about a run: threads, parts, what is printed.
pub const RUNNING: &str = "Running";

/// The heading of options about files.
pub const FILES: &str = "Files";

/// The heading of options about the camera.
pub const CAMERA: &str = "Camera";

/// The heading of options about samples and noise.
pub const QUALITY: &str = "Quality";

/// What most people set.
const COMMON: [&str; 22] = [
    "ground",
    "frame",
    "camera",
    "eye",
    "target",
    "fov-deg",
    "views",
    "sensor",
    "lenses",
    "f-number",
    "baseline-m",
    "disparity",
    "focus-m",
    "sky",
    "backdrop",
    "spp",
    "target-error",
    "denoise",
    "seed",
    "write",
    "exposure",
    "bit-depth",
];

/// The heading of a group of settings.
pub fn of(group: Group) -> &'static str {
    match group {
        Group::Scene => "Scene",
        Group::Viewpoint | Group::Rig => CAMERA,
        Group::Light => "Light",
        Group::Quality => QUALITY,
        Group::Files => FILES,
    }
}

/// Whether the short help has a setting.
pub fn is_common(key: &str) -> bool {
    COMMON.contains(&key)
}

/// The first statement of a help text.
pub fn brief(text: &str) -> &str {
    let ends = [". ", ": ", "; ", " [default", " (", ", or for", " instead of"];
    let end = ends.iter().filter_map(|end| text.find(end)).min().unwrap_or(text.len());
    text[..end].trim_end_matches('.')
}
