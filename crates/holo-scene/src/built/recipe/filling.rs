//! Objects in the space of a layout.

use glam::DVec3;

use super::composition::{Composition, Rest, Space};
use super::objects::{self, Body, Shape};
use super::surface;
use crate::Transform;

/// Adds objects to a space.
pub(super) fn fill(c: &mut Composition, space: &Space) {
    for _ in 0..c.recipe.objects.count.count(&mut c.random) {
        if let Some((center, radius)) = c.place(space) {
            object(c, center, radius, space.rest);
        }
    }
}

/// Adds an object within a ball.
pub(super) fn object(c: &mut Composition, center: DVec3, radius: f64, rest: Rest) {
    let kind = c.recipe.objects.shapes.pick(&mut c.random);
    let pose = c.pose(center, radius, rest);
    if kind == Shape::Model {
        // A folder without models has none.
        if !c.models.is_empty() {
            let number = c.random.index(c.models.len());
            let pose = standing(c.models.lowest(number), pose, radius, rest);
            c.models.add(number, &mut c.studio, &pose);
        }
        return;
    }
    let Body { mesh, is_closed } = objects::body(kind, &mut c.random);
    let material = if kind == Shape::Plant { surface::leaf(c) } else { surface::material(c, is_closed) };
    let lowest = mesh.positions.iter().map(|p| f64::from(p[1])).fold(f64::INFINITY, f64::min);
    let pose = standing(lowest, pose, radius, rest);
    c.studio.add(kind.name(), mesh, material, pose);
}

/// Lets what has its lowest point at this height of its unit ball stand on the floor.
fn standing(lowest: f64, pose: Transform, radius: f64, rest: Rest) -> Transform {
    let Rest::Floor(height) = rest else { return pose };
    let mut translation = pose.translation;
    // A little above it: faces of two objects must not lie on each other.
    translation[1] = height - lowest.max(-1.0) * radius + 1e-4 * radius;
    Transform { translation, ..pose }
}
