//! The contents of nodes, placed in the world: instances of meshes, cameras, and the lights of `KHR_lights_punctual`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::Limits;
use super::extensions::LIGHTS;
use super::instancing::InstancingPlan;
use super::json::{Object, bad, unsupported};
use super::meshes::Meshes;
use super::nodes::{Nodes, Placed};
use super::skins::Skin;
use super::values::Values;
use super::warnings::Warnings;
use crate::Error;
use crate::transform::{EXACT_FRAME, unit};
use crate::{Camera, CameraProjection, Instance, Light, LightKind, Transform};

/// Tolerance for right angles of single-precision exporters.
const ANGLE_SLACK: f64 = 1e-6;

/// The key of the angular diameter, rad, in the extras of a directional light.
pub(super) const ANGULAR_DIAMETER: &str = "angular_diameter_rad";

/// The contents of all nodes, in the order of the nodes in the file.
#[derive(Default)]
pub(super) struct Placements {
    pub(super) instances: Vec<Instance>,
    pub(super) lights: Vec<Light>,
    pub(super) cameras: Vec<Camera>,
}

/// A light without position and direction.
struct LightSource {
    name: String,
    intensity: [f64; 3],
    shape: Shape,
}

#[derive(Clone, Copy)]
enum Shape {
    Directional { diameter: f64 },
    Point { range: Option<f64> },
    Spot { range: Option<f64>, inner: f64, outer: f64 },
}

/// What the nodes show.
pub(super) struct Shown<'s> {
    pub(super) meshes: &'s Meshes,
    /// For each node the index of its mesh in [`Meshes::ranges`].
    pub(super) of_node: &'s [Option<usize>],
    pub(super) skins: &'s [Option<Skin>],
    /// For each node the places of its mesh, if there are many.
    pub(super) instancing: &'s [Option<InstancingPlan>],
}

/// Places the contents of all nodes of the scene.
pub(super) fn load(
    root: &Object<'_>,
    nodes: &Nodes<'_>,
    shown: &Shown<'_>,
    (values, limits): (&Values<'_>, &Limits),
    warnings: &mut Warnings,
) -> Result<Placements, Error> {
    let cameras = cameras(root)?;
    let lights = lights(root)?;
    let mut placements = Placements::default();
    let mut triangles_left = limits.max_triangles;
    for placed in nodes.in_scene() {
        let (node, world) = (placed.node, &placed.world);
        let name = node.name()?;
        shown.place_mesh(&placed, values, limits, &mut triangles_left, &mut placements.instances)?;
        if let Some(camera) = node.index("camera", "cameras", cameras.len())? {
            let (own_name, projection) = &cameras[camera];
            match world.to_pose() {
                Some(pose) => {
                    let name = if name.is_empty() { own_name } else { name };
                    placements.cameras.push(Camera { name: name.to_owned(), pose, projection: *projection });
                }
                None => warnings.note("a camera whose scale is zero is left out", || node.path().to_owned()),
            }
        }
        if let Some(reference) = node.extension(LIGHTS)? {
            let light = reference.index("light", "lights", lights.len())?.ok_or_else(|| reference.missing("light"))?;
            if placed.hidden {
                continue;
            }
            match place(&lights[light], name, world) {
                Some(light) => placements.lights.push(light),
                None => {
                    warnings.note("a light whose scale is zero has no direction: left out", || node.path().to_owned())
                }
            }
        }
    }
    Ok(placements)
}

impl Shown<'_> {
    /// Adds the instances of the mesh of a node.
    fn place_mesh(
        &self,
        placed: &Placed<'_, '_>,
        values: &Values<'_>,
        limits: &Limits,
        triangles_left: &mut u64,
        instances: &mut Vec<Instance>,
    ) -> Result<(), Error> {
        let Some(range) = self.of_node[placed.index].map(|entry| self.meshes.ranges[entry].clone()) else {
            return Ok(());
        };
        let places = match &self.instancing[placed.index] {
            Some(plan) => {
                let all = plan.read(values, placed.node)?;
                all.iter().map(|inner| placed.world.after(inner)).collect()
            }
            None => vec![placed.world],
        };
        let name = placed.node.name()?;
        for transform in places {
            for mesh in range.clone() {
                let triangles = self.meshes.meshes[mesh].triangles.len() as u64;
                let enough = triangles <= *triangles_left && instances.len() < limits.max_instances;
                if !enough {
                    let (i, t) = (limits.max_instances, limits.max_triangles);
                    let what = format!("the scene exceeds the limit of {i} mesh instances or {t} triangles");
                    return Err(bad(placed.node.path(), what));
                }
                *triangles_left -= triangles;
                let skin = self.meshes.skins[mesh].and_then(|skin| self.skins.get(skin)?.as_ref());
                let transform = skin.map_or(transform, |skin| Transform::from_translation(skin.origin));
                if !transform.is_finite() {
                    return Err(bad(placed.node.path(), "the transform of an instance overflows"));
                }
                instances.push(Instance { name: name.to_owned(), mesh, transform });
            }
        }
        Ok(())
    }
}

fn cameras<'f>(root: &Object<'f>) -> Result<Vec<(&'f str, CameraProjection)>, Error> {
    let read = |camera: Object<'f>| {
        let kind = camera.string("type")?.ok_or_else(|| camera.missing("type"))?;
        if !matches!(kind, "perspective" | "orthographic") {
            return Err(bad(camera.at("type"), "must be perspective or orthographic"));
        }
        let projection = camera.object(kind)?.ok_or_else(|| camera.missing(kind))?;
        let positive = |key: &str| match projection.number(key)? {
            Some(x) if x > 0.0 => Ok(Some(x)),
            Some(x) => Err(bad(projection.at(key), format!("is {x}; it must be above 0"))),
            None => Ok(None),
        };
        let required = |key: &str| positive(key)?.ok_or_else(|| projection.missing(key));
        let projection = if kind == "perspective" {
            let angle = required("yfov")?;
            if angle >= PI {
                return Err(bad(projection.at("yfov"), format!("is {angle}; it must be below pi")));
            }
            CameraProjection::Perspective { vertical_angle_rad: angle, aspect_ratio: positive("aspectRatio")? }
        } else {
            CameraProjection::Orthographic { half_width_m: required("xmag")?, half_height_m: required("ymag")? }
        };
        Ok((camera.name()?, projection))
    };
    root.objects("cameras")?.into_iter().map(read).collect()
}

fn lights(root: &Object<'_>) -> Result<Vec<LightSource>, Error> {
    let Some(extension) = root.extension(LIGHTS)? else { return Ok(Vec::new()) };
    let read = |light: Object<'_>| {
        let color = light.numbers::<3>("color")?.unwrap_or([1.0; 3]);
        let factor = light.number("intensity")?.unwrap_or(1.0);
        let intensity = color.map(|c| c * factor);
        if intensity.iter().any(|c| !c.is_finite() || *c < 0.0) {
            return Err(bad(light.path(), "its color times its intensity must be finite and not negative"));
        }
        let range = match light.number("range")? {
            // Not allowed, but written for "unlimited", and read so by other loaders.
            Some(0.0) => None,
            Some(range) if range < 0.0 => {
                return Err(bad(light.at("range"), format!("is {range}; it must be above 0")));
            }
            range => range,
        };
        let shape = match light.string("type")?.ok_or_else(|| light.missing("type"))? {
            "directional" => Shape::Directional { diameter: angular_diameter(&light)? },
            "point" => Shape::Point { range },
            "spot" => {
                let spot = light.object("spot")?;
                let angle = |key: &str, default: f64| {
                    let angle = spot.as_ref().map(|spot| spot.number(key)).transpose()?.flatten();
                    Ok::<f64, Error>(angle.unwrap_or(default))
                };
                let (inner, outer) = (angle("innerConeAngle", 0.0)?, angle("outerConeAngle", FRAC_PI_4)?);
                let ordered = 0.0 <= inner && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2 + ANGLE_SLACK;
                if !ordered {
                    let what = format!("its cone angles are {inner} and {outer}; need 0 <= inner <= outer <= pi/2");
                    return Err(bad(light.at("spot"), what));
                }
                Shape::Spot { range, inner: inner.min(FRAC_PI_2), outer: outer.min(FRAC_PI_2) }
            }
            other => {
                return Err(unsupported(light.at("type"), format!("the light type '{}'", super::uri::shorten(other))));
            }
        };
        Ok(LightSource { name: light.name()?.to_owned(), intensity, shape })
    };
    extension.objects("lights")?.into_iter().map(read).collect()
}

/// The angular diameter of a directional light, rad. glTF has no field for it, so it is in the extras of the light.
fn angular_diameter(light: &Object<'_>) -> Result<f64, Error> {
    let Some(extras) = light.extras()? else { return Ok(0.0) };
    match extras.number(ANGULAR_DIAMETER)? {
        Some(angle) if !(0.0..=PI).contains(&angle) => {
            Err(bad(extras.at(ANGULAR_DIAMETER), format!("is {angle}; it must lie between 0 and pi")))
        }
        angle => Ok(angle.unwrap_or(0.0)),
    }
}

/// A light in the world; `None` if the transform of its node is singular.
fn place(source: &LightSource, node_name: &str, world: &Transform) -> Option<Light> {
    let direction = || {
        let direction = world.vector([0.0, 0.0, -1.0]);
        let off = (direction.iter().map(|x| x * x).sum::<f64>() - 1.0).abs();
        if off <= EXACT_FRAME { Some(direction) } else { unit(direction) }
    };
    let position = world.translation;
    let kind = match source.shape {
        Shape::Directional { diameter } => {
            LightKind::Directional { direction: direction()?, angular_diameter_rad: diameter }
        }
        Shape::Point { range } => LightKind::Point { position, range },
        Shape::Spot { range, inner, outer } => {
            LightKind::Spot { position, direction: direction()?, range, inner_angle_rad: inner, outer_angle_rad: outer }
        }
    };
    let name = if source.name.is_empty() { node_name } else { &source.name };
    Some(Light { name: name.to_owned(), intensity: source.intensity, kind })
}
