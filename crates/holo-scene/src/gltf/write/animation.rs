//! Animations in a glTF file.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{Body, bad, named};
use crate::animation::{Animation, Target};
use crate::{Error, Scene};

/// Checks what the loader would refuse.
pub(super) fn validate(animation: &Animation, scene: &Scene) -> Result<(), Error> {
    let mut targets = BTreeSet::new();
    for (k, track) in animation.tracks.iter().enumerate() {
        let at = || format!("animation.tracks[{k}]");
        let (index, count, what) = match track.target {
            Target::Instance(index) => (index, scene.instances.len(), "instances"),
            Target::Camera(index) => (index, scene.cameras.len(), "cameras"),
        };
        if index >= count {
            return Err(bad(at(), format!("moves {what}[{index}], but the scene has {count}")));
        }
        if !targets.insert(track.target) {
            return Err(bad(at(), format!("moves {what}[{index}], which another track moves")));
        }
        let rest = match track.target {
            Target::Instance(index) => &scene.instances[index].transform,
            Target::Camera(index) => &scene.cameras[index].pose,
        };
        if !rest.is_pose() {
            return Err(bad(at(), format!("moves {what}[{index}], which is scaled or sheared: scale its mesh")));
        }
        if track.keys.is_empty() {
            return Err(bad(at(), "has no keys"));
        }
        if !track.keys.is_sorted_by(|a, b| a.time_s < b.time_s) {
            return Err(bad(at(), "has times that do not increase"));
        }
        let numbers = |key: &crate::animation::Key| {
            let squared: f32 = key.rotation.iter().map(|q| q * q).sum();
            let mut all = std::iter::once(&key.time_s).chain(&key.translation);
            all.all(|x| x.is_finite()) && key.time_s >= 0.0 && (squared - 1.0).abs() < 1e-4
        };
        if let Some(key) = track.keys.iter().position(|key| !numbers(key)) {
            return Err(bad(at(), format!("key {key} is not finite, before 0 s, or its rotation no unit quaternion")));
        }
    }
    Ok(())
}

/// The animation as JSON. Nodes are in the order instances, lights, cameras.
pub(super) fn animation(body: &mut Body, animation: &Animation, scene: &Scene) -> Result<Value, Error> {
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for track in &animation.tracks {
        let node = match track.target {
            Target::Instance(index) => index,
            Target::Camera(index) => scene.instances.len() + scene.lights.len() + index,
        };
        let times: Vec<[f32; 1]> = track.keys.iter().map(|key| [key.time_s]).collect();
        let input = body.times(&times)?;
        let translations: Vec<[f32; 3]> = track.keys.iter().map(|key| key.translation).collect();
        let rotations: Vec<[f32; 4]> = track.keys.iter().map(|key| key.rotation).collect();
        let outputs =
            [("translation", body.values(&translations, "VEC3")?), ("rotation", body.values(&rotations, "VEC4")?)];
        for (path, output) in outputs {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        }
    }
    Ok(named(&animation.name, json!({ "channels": channels, "samplers": samplers })))
}

impl Body {
    /// Increasing times, with the range that glTF requires.
    fn times(&mut self, times: &[[f32; 1]]) -> Result<Value, Error> {
        let accessor = self.values(times, "SCALAR")?;
        if let (Some(Value::Object(map)), Some(first), Some(last)) =
            (self.accessors.last_mut(), times.first(), times.last())
        {
            map.insert("min".into(), json!(first));
            map.insert("max".into(), json!(last));
        }
        Ok(accessor)
    }

    fn values<const N: usize>(&mut self, elements: &[[f32; N]], shape: &str) -> Result<Value, Error> {
        let bytes = elements.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        let view = self.view(bytes, elements.len() * N * 4, None)?;
        Ok(self.accessor(json!({ "bufferView": view, "componentType": 5126, "count": elements.len(), "type": shape })))
    }
}
