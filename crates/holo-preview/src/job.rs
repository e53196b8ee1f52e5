//! From the state of a page to a render job. Here is decided what a page may ask for.

use holo_dataset::settings::{Given, Group, Setting, spelled};
use holo_dataset::{Frames, RenderJob, RenderSettings, SceneSource, Sky, adjusted_camera};
use holo_io::{ArrayCamera, CameraFile};
use serde_json::{Value, json};

use crate::Preview;
use crate::protocol::Look;
use crate::protocol::inbox::Inbox;

/// The name of the camera that the program named.
pub(crate) const OWN_CAMERA: &str = "own";

/// Whether only a rig has a setting.
pub(crate) fn is_of_rig(key: &str) -> bool {
    let is_in_group = Setting::by_key(key).is_some_and(|setting| setting.group() == Group::Rig);
    // A plenoptic camera has its own angle of view.
    key == "fov-deg" || is_in_group && !["f-number", "focus-m"].contains(&key)
}

/// What a page looks at first: the scene that the program named, or the first one of the gallery.
pub(crate) fn first_look(preview: &Preview) -> Look {
    let of_gallery = || holo_scene::gallery::all_names().next().unwrap_or_default();
    Look {
        scene: preview.scene.as_ref().map_or_else(of_gallery, |_| "").to_owned(),
        camera: preview.camera.as_ref().map_or("", |_| OWN_CAMERA).to_owned(),
        settings: preview.given.iter().map(|(key, text)| (key.to_owned(), text.to_owned())).collect(),
        ..Look::default()
    }
}

/// A pose that a page may look from: its name, and the settings that stand for it.
pub(crate) fn offered(pose: &ArrayCamera) -> Value {
    let [_, up, back, eye] = pose.axes_and_position;
    let target = [0, 1, 2].map(|k| eye[k] - back[k]);
    let text = |point: [f64; 3]| point.map(|x| x.to_string()).join(",");
    let fov_deg = pose.size.map(|size| 2.0 * (size.columns as f64 / (2.0 * pose.focal_px)).atan().to_degrees());
    json!({
        "name": holo_core::visible(&pose.name),
        "settings": {
            "eye": text(eye),
            "target": text(target),
            "up": text(up),
            "fov-deg": fov_deg.map(|angle| angle.to_string()),
        },
    })
}

/// The scene of a look, and a key that differs for other scenes.
pub(crate) fn scene(look: &Look, preview: &Preview, inbox: &Inbox) -> Result<(SceneSource, String), String> {
    if !look.scene.is_empty() {
        return Ok((SceneSource::gallery(&look.scene).map_err(told)?, look.scene.clone()));
    }
    if let Some((source, number)) = inbox.dropped() {
        return Ok((source, format!("dropped {number}")));
    }
    let named = preview.scene.clone().map(|scene| (scene, String::new()));
    named.ok_or_else(|| "choose a scene of the gallery, or drop a .glb on the page".into())
}

/// The job that renders what a look shows.
pub(crate) fn of(look: &Look, source: SceneSource, preview: &Preview) -> Result<RenderJob, String> {
    let mut given = given(look, preview)?;
    let mut settings = RenderSettings::default();
    if let Some(file) = camera(look, preview)? {
        settings.camera = adjusted_camera(file, &mut given).map_err(told)?.into();
    }
    settings.apply(&given).map_err(told)?;
    let job = RenderJob::new(source, settings).engine(preview.engine);
    job.check().map_err(told)?;
    Ok(job)
}

/// The job of its first frame.
pub(crate) fn at_first_frame(mut job: RenderJob) -> RenderJob {
    let frames = &mut job.settings.scene.frames;
    *frames = frames.map(|frames| Frames::one(frames.first));
    job
}

/// The plenoptic camera of a look; `None`: a rig.
fn camera(look: &Look, preview: &Preview) -> Result<Option<CameraFile>, String> {
    match look.camera.as_str() {
        "" => Ok(None),
        OWN_CAMERA => Ok(preview.camera.clone()),
        name => {
            CameraFile::preset(name).map(Some).ok_or_else(|| format!("there is no camera '{}'", holo_core::shown(name)))
        }
    }
}

/// The settings of a look.
pub(crate) fn given(look: &Look, preview: &Preview) -> Result<Given, String> {
    let mut given = Given::default();
    let is_raw = !look.camera.is_empty();
    for (key, text) in look.settings.iter().filter(|(_, text)| !text.trim().is_empty()) {
        // None of them names a file, except for `sky`: of a page it cannot be one.
        if Setting::by_key(key).is_none() {
            return Err(format!("the page cannot set '{}'", holo_core::shown(key)));
        }
        if is_raw && is_of_rig(key) {
            continue;
        }
        let is_own = preview.given.get(key) == Some(text.as_str());
        if key == "sky" && !is_own && is_file(text) {
            return Err("an environment map is a file: name it where the preview is started".into());
        }
        given.insert(key, text.trim()).map_err(told)?;
    }
    Ok(given)
}

/// Whether a sky is the path of a file.
fn is_file(text: &str) -> bool {
    let mut settings = RenderSettings::default();
    let mut sky = Given::default();
    let is_read = sky.insert("sky", text).and_then(|()| settings.apply(&sky));
    // What is no sky at all is refused later.
    is_read.is_ok() && matches!(settings.light.sky, Sky::Map(_))
}

/// An error in the words of the page, which names settings as they are.
pub(crate) fn told(error: impl std::fmt::Display) -> String {
    spelled(&error.to_string(), |key, value| format!("{key}{value}"))
}

/// Why work ended.
pub(crate) enum Ended {
    /// Something newer is to be done.
    Newer,
    /// It failed.
    Failed(String),
}

impl From<String> for Ended {
    fn from(why: String) -> Self {
        Self::Failed(why)
    }
}

impl From<holo_render::Error> for Ended {
    fn from(error: holo_render::Error) -> Self {
        match error {
            holo_render::Error::Cancelled => Self::Newer,
            other => Self::Failed(told(other)),
        }
    }
}

impl From<holo_dataset::Error> for Ended {
    fn from(error: holo_dataset::Error) -> Self {
        match error {
            holo_dataset::Error::Render(error) => error.into(),
            other => Self::Failed(told(other)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::GridSize;
    use holo_scene::Transform;

    /// The settings of a pose place the camera as `transforms` does.
    #[test]
    fn a_look_from_a_pose_stands_where_the_pose_does() {
        let (sin, cos) = 0.4f64.sin_cos();
        let axes_and_position = [[0.0, -1.0, 0.0], [cos, 0.0, -sin], [sin, 0.0, cos], [0.25, -1e6, 2.0 / 3.0]];
        let size = Some(GridSize::new(300, 400));
        let pose = ArrayCamera { axes_and_position, focal_px: 200.0, size, ..ArrayCamera::default() };
        let offer = offered(&pose);
        let settings = offer["settings"].as_object().expect("settings");
        let pairs: Vec<_> = settings.iter().map(|(key, text)| (key.as_str(), text.as_str().expect("text"))).collect();
        let source = SceneSource::gallery("plaster").unwrap();
        let job = of(&look(&pairs), source, &Preview::new()).unwrap();
        assert_eq!(job.settings.scene.fov_deg, Some(90.0));
        let point = |key: &str| -> [f64; 3] {
            let text = settings[key].as_str().expect("text");
            let numbers: Vec<f64> = text.split(',').map(|x| x.parse().expect("a number")).collect();
            numbers.try_into().expect("three numbers")
        };
        let made = Transform::look_at(point("eye"), point("target"), point("up"));
        for (made, expected) in made.columns.iter().flatten().zip(axes_and_position[..3].iter().flatten()) {
            assert!((made - expected).abs() < 1e-9, "{offer}");
        }
        assert_eq!(made.translation, axes_and_position[3]);
        let unknown = offered(&ArrayCamera { size: None, ..pose });
        assert!(unknown["settings"]["fov-deg"].is_null());
    }

    fn look(pairs: &[(&str, &str)]) -> Look {
        let settings = pairs.iter().map(|(key, text)| ((*key).to_owned(), (*text).to_owned())).collect();
        Look { scene: "plaster".into(), settings, ..Look::default() }
    }

    #[test]
    fn a_page_sets_the_camera_and_names_no_files() {
        let preview = Preview::new();
        let of = |pairs: &[(&str, &str)]| of(&look(pairs), SceneSource::gallery("plaster").unwrap(), &preview);
        let job = of(&[("views", "9"), ("lenses", "64x48"), ("disparity", "-1,1"), ("fov-deg", "")]).unwrap();
        assert_eq!(job.settings.camera.rig().unwrap().views, holo_core::GridSize::new(9, 9));
        for (key, text, words) in [
            ("sky", "/etc/secret.hdr", "where the preview is started"),
            ("transforms", "/etc/cameras.json", "cannot set"),
            ("out", "/tmp", "cannot set"),
            ("views", "-3", "views"),
        ] {
            let why = of(&[(key, text)]).unwrap_err();
            assert!(why.contains(words), "{key}: {why}");
        }
        let mut own = Given::default();
        own.insert("sky", "studio.hdr").unwrap();
        let preview = Preview::new().given(own);
        assert!(given(&look(&[("sky", "studio.hdr")]), &preview).is_ok());
        assert!(given(&look(&[("sky", "other.hdr")]), &preview).is_err());
    }

    #[test]
    fn of_a_sequence_the_first_frame_is_shown() {
        let preview = Preview::new();
        let source = || SceneSource::gallery("pendulum").unwrap();
        let all = of(&look(&[("frame", "3-7"), ("views", "2"), ("lenses", "8x6")]), source(), &preview).unwrap();
        assert_eq!(all.shots().len(), 5);
        let first = at_first_frame(all);
        assert_eq!((first.shots().len(), first.settings.scene.frames), (1, Some(Frames::one(3))));
        assert!(first.stage(&()).is_ok());
        assert!(of(&look(&[("frame", "7-3")]), source(), &preview).is_err());
    }

    #[test]
    fn plenoptic_cameras_are_presets_and_ignore_settings_of_rigs() {
        let preview = Preview::new();
        let mut wanted = look(&[("views", "9"), ("f-number", "2.2"), ("focus-m", "1.5")]);
        wanted.camera = "lytro-illum".into();
        let job = of(&wanted, SceneSource::gallery("plaster").unwrap(), &preview).unwrap();
        let camera = &job.settings.camera.plenoptic().unwrap().camera;
        assert!((camera.main_lens().f_number - 2.2).abs() < 1e-12);
        wanted.camera = "/etc/passwd".into();
        let why = of(&wanted, SceneSource::gallery("plaster").unwrap(), &preview).unwrap_err();
        assert!(why.contains("no camera"), "{why}");
    }
}
