//! `EXT_mesh_gpu_instancing`: a node that shows its mesh at many places.
//!
//! Each element of the accessors TRANSLATION, ROTATION and SCALE is a transform below that of the node. Other
//! attributes, such as colors of instances, are ignored.

use super::Limits;
use super::accessors::{Checker, Use};
use super::extensions::INSTANCING;
use super::handle::Handle;
use super::json::{Object, bad};
use super::nodes::Nodes;
use super::values::Values;
use super::warnings::Warnings;
use crate::Error;
use crate::Transform;

/// The places of the mesh of a node, with validated accessors.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstancingPlan {
    translation: Option<Handle>,
    rotation: Option<Handle>,
    scale: Option<Handle>,
    count: usize,
}

/// For each node of the file the places of its mesh; `None` for nodes without the extension.
pub(super) fn plan(
    nodes: &Nodes<'_>,
    accessors: &mut Checker<'_>,
    limits: &Limits,
    warnings: &mut Warnings,
) -> Result<Vec<Option<InstancingPlan>>, Error> {
    let mut plans = vec![None; nodes.nodes.len()];
    let mut instances = 0_usize;
    for placed in nodes.in_scene().filter(|placed| !placed.hidden && placed.node.has("mesh")) {
        let Some(extension) = placed.node.extension(INSTANCING)? else { continue };
        let Some(attributes) = extension.object("attributes")? else { continue };
        let plan = one(&attributes, accessors, warnings)?;
        // Accessors without data make many instances of a small file.
        instances = instances.saturating_add(plan.map_or(0, |plan| plan.count));
        if instances > limits.max_instances {
            let what = format!("the scene exceeds the limit of {} mesh instances", limits.max_instances);
            return Err(bad(placed.node.path(), what));
        }
        plans[placed.index] = plan;
    }
    Ok(plans)
}

fn one(
    attributes: &Object<'_>,
    accessors: &mut Checker<'_>,
    warnings: &mut Warnings,
) -> Result<Option<InstancingPlan>, Error> {
    let mut read = |key: &str, wanted: Use| -> Result<Option<Handle>, Error> {
        let Some(number) = attributes.index(key, "accessors", accessors.len())? else { return Ok(None) };
        accessors.check(number, wanted, &attributes.at(key)).map(Some)
    };
    let translation = read("TRANSLATION", Use::Positions)?;
    let rotation = read("ROTATION", Use::Rotations)?;
    let scale = read("SCALE", Use::Positions)?;
    attributes.each(|key, _| {
        if key.starts_with("_COLOR") {
            warnings.note("colors of instances are ignored", || attributes.path().to_owned());
        }
    });
    let counts: Vec<usize> = [translation, rotation, scale].into_iter().flatten().map(|handle| handle.count).collect();
    let Some(&count) = counts.first() else { return Ok(None) };
    if counts.iter().any(|&other| other != count) {
        return Err(bad(attributes.path(), format!("have {counts:?} elements; all must have as many")));
    }
    Ok(Some(InstancingPlan { translation, rotation, scale, count }))
}

impl InstancingPlan {
    /// The transforms of all instances to the coordinates of the node.
    pub(super) fn read(&self, values: &Values<'_>, node: &Object<'_>) -> Result<Vec<Transform>, Error> {
        let vectors = |handle: Option<Handle>| handle.map(|handle| values.numbers::<3>(handle)).transpose();
        let (translation, scale) = (vectors(self.translation)?, vectors(self.scale)?);
        let rotation = self.rotation.map(|handle| values.numbers::<4>(handle)).transpose()?;
        let mut transforms = Vec::with_capacity(self.count);
        for k in 0..self.count {
            let at = |list: &Option<Vec<[f32; 3]>>, default: f64| {
                list.as_ref().and_then(|list| list.get(k)).map_or([default; 3], |v| v.map(f64::from))
            };
            let turn =
                rotation.as_ref().and_then(|list| list.get(k)).map_or([0.0, 0.0, 0.0, 1.0], |q| q.map(f64::from));
            let transform = Transform::from_parts(at(&translation, 0.0), turn, at(&scale, 1.0));
            if !transform.is_finite() {
                return Err(bad(node.path(), format!("the transform of its instance {k} is not finite")));
            }
            transforms.push(transform);
        }
        Ok(transforms)
    }
}
