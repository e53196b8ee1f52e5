//! The groups of options in help texts, by what a person decides, and the options that the short help (`-h`) has.

/// The heading of options about a run: threads, parts, what is printed.
pub const RUNNING: &str = "Running";

/// The heading of options about files.
pub const FILES: &str = "Files";

/// The heading of options about the camera.
pub const CAMERA: &str = "Camera";

/// Settings by heading; all others are about files.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Scene", &["light-units", "solid-glass", "material-variant", "ground", "frame", "fps", "animation"]),
    (
        CAMERA,
        &[
            "camera",
            "eye",
            "target",
            "up",
            "fov-deg",
            "fit-object",
            "views",
            "sensor",
            "lenses",
            "lens-shifts",
            "f-number",
            "baseline-m",
            "disparity",
            "focus-m",
            "focal-mm",
            "sensor-mm",
            "projection",
            "subset",
        ],
    ),
    (
        "Light",
        &[
            "integrator",
            "max-bounces",
            "no-roulette",
            "no-indirect",
            "indirect-limit",
            "transparent-shadows",
            "no-multiple-scattering",
            "cull",
            "sky",
            "backdrop",
        ],
    ),
    ("Quality", &["spp", "target-error", "denoise", "reuse", "texture-filter", "seed"]),
];

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

/// The heading of a setting.
pub fn of(key: &str) -> &'static str {
    GROUPS.iter().find(|(_, keys)| keys.contains(&key)).map_or(FILES, |(heading, _)| heading)
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
