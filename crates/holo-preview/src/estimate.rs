//! What a full render will take, and the commands that make it.

use holo_dataset::settings::Setting;
use holo_dataset::{Camera, Output, Prepared, RenderSettings, SceneSource};
use holo_io::CameraFile;
use holo_render::{Denoise, Integrator};
use serde_json::{Value, json};

use crate::job::{OWN_CAMERA, is_of_rig};
use crate::protocol::Look;
use crate::raw_part::Strip;

/// Bytes of a pixel in files, measured over the gallery: PNG of 8 bits, MAT and HDF5 of 3 channels.
const PNG_BYTES: f64 = 1.7;
const MAT_BYTES: f64 = 3.0;
const H5_BYTES: f64 = 9.0;
const EXR_BYTES: f64 = 5.0;

/// Bytes of a pixel of the central view in a float map.
const MAP_BYTES: f64 = 4.0;

/// What files take to be written, s a byte: compression of PNG on one core.
const WRITE_SECONDS: f64 = 1.0 / 50e6;

/// What the reconstruction from neighboring views takes, s a pixel of the raw image.
const RECONSTRUCTION_SECONDS: f64 = 6e-8;

/// The same of a plenoptic camera: an Illum takes 65 s on two cores.
const RAW_RECONSTRUCTION_SECONDS: f64 = 1.6e-6;

/// The share of samples that a render to a target error takes on average, of the 16 that it may.
const TARGET_SAMPLES: f64 = 0.5;

/// Time and disk space of a full render: seconds, bytes and pixels, all about.
pub(crate) fn of(settings: &RenderSettings, prepared: &Prepared, strip: &Strip) -> Value {
    let (pixels, central) = match (&settings.camera, prepared.rig()) {
        (Camera::Plenoptic(file), _) => (file.camera.sensor().size.count(), 0),
        (_, Some(rig)) => (rig.shape().raw_size().count(), rig.shape().lenses().count()),
        _ => (0, 0),
    };
    let pixels = pixels as f64;
    let light = &settings.light;
    let is_shared = light.denoise == Denoise::Views;
    let samples = match light.target_error {
        Some(_) if is_shared => TARGET_SAMPLES,
        _ => light.samples.map_or(16.0, holo_render::SamplesPerPixel::as_f64),
    };
    let samples = if light.integrator == Integrator::Depth { 0.0 } else { samples };
    let bytes = bytes(settings, pixels, central as f64);
    let reconstruction = match settings.camera {
        _ if !is_shared => 0.0,
        Camera::Plenoptic(_) => pixels * RAW_RECONSTRUCTION_SECONDS,
        _ => pixels * RECONSTRUCTION_SECONDS,
    };
    let seconds = pixels * samples * strip.seconds / strip.samples.max(1.0)
        + prepared.build_seconds
        + reconstruction
        + bytes * WRITE_SECONDS;
    json!({"seconds": seconds, "bytes": bytes, "pixels": pixels})
}

/// The bytes of all files.
fn bytes(settings: &RenderSettings, pixels: f64, central: f64) -> f64 {
    let default = match settings.camera {
        Camera::Plenoptic(_) => vec![Output::Raw, Output::White],
        _ => vec![Output::Vpi, Output::El, Output::Mat, Output::Depth, Output::Disparity],
    };
    let outputs = if settings.output.write.is_empty() { default } else { settings.output.write.clone() };
    outputs
        .iter()
        .map(|output| match output {
            Output::Vpi | Output::El | Output::Hci | Output::HciHighres => pixels * PNG_BYTES,
            Output::Mat => pixels * MAT_BYTES,
            Output::H5 => pixels * H5_BYTES,
            Output::Exr | Output::Raw => pixels * EXR_BYTES,
            Output::RawPng => pixels * 2.0 * PNG_BYTES,
            Output::White => pixels * MAP_BYTES / 2.0,
            _ => central * MAP_BYTES,
        })
        .sum()
}

/// A render as a command line and as a call of Python.
pub(crate) struct Commands {
    pub shell: String,
    pub python: String,
}

pub(crate) fn commands(source: &SceneSource, look: &Look, settings: &RenderSettings) -> Commands {
    let name = source.name();
    let path = match source {
        SceneSource::File(path) => path.display().to_string(),
        _ => format!("{name}.glb"),
    };
    // The gallery writes its scenes itself.
    let (first, scene) = match source {
        SceneSource::Gallery(..) => {
            (format!("holo scene {name} && "), format!("holo.Scene.gallery({})", python_text(&name)))
        }
        _ => (String::new(), python_text(&path)),
    };
    let camera = match (look.camera.as_str(), &settings.camera) {
        (OWN_CAMERA, Camera::Plenoptic(file)) => {
            let is_preset = CameraFile::preset(&file.name).is_some_and(|preset| preset == **file);
            Some(format!("{}{}", file.name, if is_preset { "" } else { ".toml" }))
        }
        ("", _) => None,
        (preset, _) => Some(preset.to_owned()),
    };
    let is_used = |key: &str| look.camera.is_empty() || !is_of_rig(key);
    let given = || look.settings.iter().filter(|(key, text)| !text.trim().is_empty() && is_used(key));
    let mut shell = format!("{first}holo render {} --out {}", quoted(&path), quoted(&name));
    let mut python = format!("holo.render_to({}, {scene}", python_text(&name));
    if let Some(camera) = camera {
        shell += &format!(" --camera-file {}", quoted(&camera));
        python += &format!(", camera_file={}", python_text(&camera));
    }
    for (key, text) in given() {
        let is_flag = text == "true";
        shell += &if is_flag { format!(" --{key}") } else { format!(" --{key} {}", quoted(text)) };
        let value = match text.parse::<f64>() {
            _ if is_flag => "True".into(),
            Ok(number) if number.is_finite() => text.clone(),
            _ => python_text(text),
        };
        let keyword = Setting::by_key(key).map_or_else(|| key.clone(), Setting::keyword);
        python += &format!(", {keyword}={value}");
    }
    Commands { shell, python: python + ")" }
}

/// A word of a shell.
fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:+=@%".contains(c);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

/// A text of Python. The escapes of JSON are its own.
fn python_text(text: &str) -> String {
    json!(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_say_what_is_looked_at() {
        let pairs = [("disparity", "-1,1"), ("ground", "true"), ("views", "9"), ("focal-mm", " ")];
        let settings = pairs.map(|(key, text)| (key.to_owned(), text.to_owned())).into();
        let look = Look { settings, ..Look::default() };
        let source = SceneSource::file("a room.glb");
        let commands = commands(&source, &look, &RenderSettings::default());
        assert_eq!(commands.shell, "holo render 'a room.glb' --out 'a room' --disparity -1,1 --ground --views 9");
        assert_eq!(
            commands.python,
            r#"holo.render_to("a room", "a room.glb", disparity="-1,1", ground=True, views=9)"#
        );
    }
    #[test]
    fn commands_of_plenoptic_cameras_have_no_settings_of_rigs() {
        let pairs = [("for", "plenpy"), ("views", "9"), ("spp", "4")];
        let settings = pairs.map(|(key, text)| (key.to_owned(), text.to_owned())).into();
        let look = Look { settings, camera: "lytro-illum".into(), ..Look::default() };
        let source = SceneSource::gallery("plaster").unwrap();
        let found = commands(&source, &look, &RenderSettings::default());
        let shell = "holo scene plaster && holo render plaster.glb --out plaster --camera-file lytro-illum --for plenpy --spp 4";
        assert_eq!(found.shell, shell);
        assert_eq!(
            found.python,
            r#"holo.render_to("plaster", holo.Scene.gallery("plaster"), camera_file="lytro-illum", tools="plenpy", spp=4)"#
        );
        // A preset that the program was given.
        let look = Look { camera: OWN_CAMERA.into(), ..Look::default() };
        let mut file = CameraFile::preset("h3dv").unwrap();
        for (name, ending) in [("h3dv", ""), ("own", ".toml")] {
            file.name = name.into();
            let settings = RenderSettings::default().camera(file.clone());
            let shell = commands(&source, &look, &settings).shell;
            assert!(shell.ends_with(&format!("--camera-file {name}{ending}")), "{shell}");
        }
    }
}
