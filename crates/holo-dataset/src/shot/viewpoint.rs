//! Where the settings place the camera in a scene: at a point, towards a point, or so that an object fills the view.

use holo_scene::{Scene, Transform};

use crate::Error;
use crate::settings::{Point, SceneSettings};

/// The image is this factor wider and higher than the object that fills it.
const MARGIN: f64 = 1.05;

/// The names of objects that a message has.
const SHOWN_OBJECTS: usize = 12;

/// Returns the pose, and what to call it; `None` if the settings leave it to the scene, whose camera has the pose `base`.
/// `slopes` are half the width and the height of the image at a distance of 1.
///
/// # Errors
/// [`Error::BadRequest`] if the settings contradict each other or name no object.
pub(super) fn placed(
    settings: &SceneSettings,
    base: &Transform,
    slopes: [f64; 2],
    scene: &Scene,
) -> Result<Option<(Transform, String)>, Error> {
    let SceneSettings { eye, target, up, fit_object, .. } = settings;
    let pose = match (fit_object, eye, target) {
        (None, None, None) if up.is_none() => return Ok(None),
        (Some(_), _, Some(_)) => {
            return bad("`target` and `fit-object` both say what the camera looks at; give one of them");
        }
        (Some(name), eye, None) => fitted(name, (*eye, *up), base, slopes, scene)?,
        (None, eye, target) => {
            let from = eye.map_or(base.translation, |Point(eye)| eye);
            match target.map(|Point(target)| target).or_else(|| eye.and_then(|_| middle(scene))) {
                Some(target) => looking(from, target, *up)?,
                // The same direction, with another side up.
                None => looking(from, std::array::from_fn(|k| from[k] - base.columns[2][k]), *up)?,
            }
        }
    };
    let [x, y, z] = pose.translation;
    Ok(Some((pose, format!("camera at {x:.4},{y:.4},{z:.4}"))))
}

fn bad<T>(what: &str) -> Result<T, Error> {
    Err(Error::BadRequest(what.into()))
}

/// The middle of everything.
fn middle(scene: &Scene) -> Option<[f64; 3]> {
    scene.bounds().map(|(low, high)| std::array::from_fn(|k| f64::midpoint(low[k], high[k])))
}

/// The pose at `eye` that looks at `target`.
pub(crate) fn looking(eye: [f64; 3], target: [f64; 3], up: Option<Point>) -> Result<Transform, Error> {
    let Point(up) = up.unwrap_or(Point([0.0, 1.0, 0.0]));
    // Of three right angles nothing is left if two of the directions are one.
    match Transform::look_at(eye, target, up).to_pose() {
        Some(pose) => Ok(pose),
        None if eye == target => bad("the camera stands where it looks at; move `eye` or `target`"),
        None => {
            bad("the direction `up` is along the line of sight; give another, such as 0,0,-1 for a view from above")
        }
    }
}

/// The nearest pose on a line of sight from which all of an object is in view: from `eye` towards it, or in the direction of
/// `base`.
fn fitted(
    name: &str,
    (eye, up): (Option<Point>, Option<Point>),
    base: &Transform,
    slopes: [f64; 2],
    scene: &Scene,
) -> Result<Transform, Error> {
    let parts = || scene.instances.iter().filter(|instance| instance.name == name);
    let points = || {
        parts().filter_map(|part| Some((part, scene.meshes.get(part.mesh)?))).flat_map(|(part, mesh)| {
            let corners = mesh.triangles.iter().flatten().filter_map(|&k| mesh.positions.get(k as usize));
            corners.map(|corner| part.transform.point(corner.map(f64::from)))
        })
    };
    let low = points().fold([f64::INFINITY; 3], |low, p| std::array::from_fn(|k| low[k].min(p[k])));
    let high = points().fold([f64::NEG_INFINITY; 3], |high, p| std::array::from_fn(|k| high[k].max(p[k])));
    if low[0] > high[0] {
        return Err(Error::BadRequest(unknown(name, scene)));
    }
    let center: [f64; 3] = std::array::from_fn(|k| f64::midpoint(low[k], high[k]));
    let axes = match (eye, up) {
        (Some(Point(eye)), up) => looking(eye, center, up)?.columns,
        (None, None) => base.columns,
        (None, up) => looking(std::array::from_fn(|k| center[k] + base.columns[2][k]), center, up)?.columns,
    };
    let nearest = |p: [f64; 3]| {
        let [x, y, z] = axes.map(|axis| (0..3).map(|k| axis[k] * (p[k] - center[k])).sum::<f64>());
        z + MARGIN * (x.abs() / slopes[0]).max(y.abs() / slopes[1])
    };
    // An object of a single point is seen from 1 m.
    let distance = Some(points().map(nearest).fold(0.0, f64::max)).filter(|distance| *distance > 0.0).unwrap_or(1.0);
    Ok(Transform { columns: axes, translation: std::array::from_fn(|k| center[k] + distance * axes[2][k]) })
}

/// The message about an object that the scene does not have.
fn unknown(name: &str, scene: &Scene) -> String {
    let named = scene.instances.iter().filter(|instance| !instance.name.is_empty());
    let mut names: Vec<String> = named.map(|instance| format!("'{}'", holo_core::visible(&instance.name))).collect();
    names.sort_unstable();
    names.dedup();
    let more = if names.len() > SHOWN_OBJECTS { ", .." } else { "" };
    names.truncate(SHOWN_OBJECTS);
    format!(
        "`fit-object`: no object '{}' has triangles in the scene; it has {}{more}",
        holo_core::visible(name),
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_scene::{Instance, Material, Mesh};

    /// A triangle in the plane z = 0 around (1, 0, 0), 1 m wide and high, and one around (9, 0, 0).
    fn scene() -> Scene {
        let mesh = |x: f32| Mesh {
            positions: vec![[x - 0.5, -0.5, 0.0], [x + 0.5, -0.5, 0.0], [x, 0.5, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let instance = |name: &str, mesh| Instance { name: name.into(), mesh, transform: Transform::IDENTITY };
        Scene {
            meshes: vec![mesh(1.0), mesh(9.0)],
            instances: vec![instance("near", 0), instance("far", 1)],
            materials: vec![Material::default()],
            ..Scene::default()
        }
    }

    fn pose(settings: &SceneSettings) -> Result<Transform, Error> {
        let placed = placed(settings, &Transform::IDENTITY, [1.0, 0.5], &scene())?;
        Ok(placed.map_or(Transform::IDENTITY, |(pose, _)| pose))
    }

    #[test]
    fn cameras_stand_and_look_where_they_are_told() {
        assert_eq!(pose(&SceneSettings::default()).unwrap(), Transform::IDENTITY);
        let at = |eye: [f64; 3]| SceneSettings { eye: Some(Point(eye)), ..SceneSettings::default() };
        let whole = pose(&at([5.0, 0.0, 10.0])).unwrap();
        assert_eq!((whole.translation, whole.columns[2]), ([5.0, 0.0, 10.0], [0.0, 0.0, 1.0]));
        let settings = SceneSettings { target: Some(Point([5.0, 0.0, 7.0])), ..at([5.0, 0.0, 10.0]) };
        assert_eq!(pose(&settings).unwrap(), whole);
        // From above the usual direction is along the line of sight.
        let above = SceneSettings { target: Some(Point([5.0, 0.0, 7.0])), ..at([5.0, 3.0, 7.0]) };
        let refused = pose(&above).unwrap_err().to_string();
        assert!(refused.contains("`up`"), "{refused}");
        let turned = SceneSettings { up: Some(Point([0.0, 0.0, -1.0])), ..above };
        assert_eq!(pose(&turned).unwrap().columns[2], [0.0, 1.0, 0.0]);
        // A camera of the scene that is only turned about its axis.
        let rolled = SceneSettings { up: Some(Point([1.0, 0.0, 0.0])), ..SceneSettings::default() };
        assert_eq!(pose(&rolled).unwrap().columns, [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn an_object_fills_the_view() {
        let fit = |name: &str| SceneSettings {
            fit_object: Some(name.into()),
            eye: Some(Point([1.0, 0.0, 50.0])),
            ..SceneSettings::default()
        };
        // Half a meter to each side, and the image is twice as wide as high: 1.05 / 0.5 times that.
        let near = pose(&fit("near")).unwrap();
        assert!((near.translation[2] - 1.05).abs() < 1e-12, "{near:?}");
        assert_eq!(near.translation[..2], [1.0, 0.0]);
        // In the direction of the camera of the scene.
        let far = pose(&SceneSettings { eye: None, ..fit("far") }).unwrap();
        assert!((far.translation[0] - 9.0).abs() < 1e-12 && (far.translation[2] - 1.05).abs() < 1e-12, "{far:?}");
        let refused = pose(&fit("nobody")).unwrap_err().to_string();
        assert!(refused.contains("it has 'far', 'near'"), "{refused}");
        let both = SceneSettings { target: Some(Point([0.0; 3])), ..fit("near") };
        assert!(pose(&both).is_err());
    }
}
