//! Layouts of recipes: what surrounds the objects, where they are, and where the camera stands.

use glam::{DQuat, DVec3};
use serde::Deserialize;

use super::composition::{Composition, Rest, Space, View};
use super::{extras, filling, light, objects, surface};
use crate::Transform;
use crate::built::parts::{shapes, solids};

/// A kind of layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Layout {
    /// Objects on a table before a wall.
    #[default]
    Table,
    /// A room with furniture.
    Room,
    /// Two rows of houses: a large range of depths.
    Street,
    /// Objects that float before a wall.
    Floating,
    /// Planes at all angles.
    Slanted,
    /// Flats one behind the other: steps of depth.
    Steps,
    /// Plants.
    Thicket,
}

/// Builds the scene of a composition.
pub(super) fn build(c: &mut Composition) {
    let kind = c.recipe.layouts.pick(&mut c.random);
    let camera = &c.recipe.camera;
    let angle = camera.vertical_angle_deg.even(&mut c.random).to_radians();
    let scale = camera.distance_m.log(&mut c.random);
    let tilt = match kind {
        Layout::Table | Layout::Room | Layout::Thicket => camera.tilt_deg.even(&mut c.random).to_radians(),
        Layout::Street => c.random.between(0.02, 0.15),
        Layout::Floating | Layout::Slanted | Layout::Steps => c.random.between(-0.2, 0.2),
    };
    let turn = c.random.between(-0.5, 0.5);
    let back = DVec3::new(turn.sin() * tilt.cos(), tilt.sin(), turn.cos() * tilt.cos());
    // A little above the floor, which is at the height 0.
    let target = DVec3::Y * (scale * c.random.between(0.02, 0.18));
    c.view = View::new(target + scale * back, target, angle);
    let space = match kind {
        Layout::Table => table(c, scale),
        Layout::Room => room(c, scale),
        Layout::Street => street(c, scale),
        Layout::Floating => floating(c, scale),
        Layout::Slanted => slanted(c, scale),
        Layout::Steps => steps(c, scale),
        Layout::Thicket => thicket(c, scale),
    };
    extras::before(c, &space);
    filling::fill(c, &space);
    extras::after(c, &space);
    light::add(c, target, scale);
}

/// A floor through the origin, and a wall behind it.
fn floor(c: &mut Composition, scale: f64, wall: f64) {
    let half = 6.0 * scale;
    let material = surface::ground(c);
    let mesh = shapes::sheet(1, 1, |s, t| DVec3::new(half * (2.0 * s - 1.0), 0.0, half * (2.0 * t - 1.0)));
    c.solid("floor", mesh, material);
    let turn = c.random.between(-0.4, 0.4);
    // It faces the camera, turned about the vertical.
    let out = DQuat::from_rotation_y(turn) * flat(c.view.ahead);
    let middle = flat(c.view.eye) + flat(c.view.ahead).normalize_or(DVec3::NEG_Z) * (flat(c.view.eye).length() + wall);
    plane(c, "wall", middle + DVec3::Y * (0.98 * half), out, half);
}

fn flat(v: DVec3) -> DVec3 {
    DVec3::new(v.x, 0.0, v.z)
}

/// A square of two halves around a point, across a direction.
fn plane(c: &mut Composition, name: &str, middle: DVec3, across: DVec3, half: f64) {
    let material = surface::ground(c);
    let across = across.normalize_or(DVec3::NEG_Z);
    let right = across.cross(DVec3::Y).normalize_or(DVec3::X);
    let up = right.cross(across);
    let mesh = shapes::sheet(1, 1, |s, t| middle + half * ((2.0 * s - 1.0) * right + (1.0 - 2.0 * t) * up));
    c.solid(name, mesh, material);
}

fn table(c: &mut Composition, scale: f64) -> Space {
    let wall = scale * c.random.between(0.3, 1.5);
    floor(c, scale, wall);
    Space { near: 0.6 * scale, far: scale + 0.8 * wall, rest: Rest::Floor(0.0) }
}

/// A wall on each side, and furniture with things on it.
fn room(c: &mut Composition, scale: f64) -> Space {
    let wall = scale * c.random.between(0.5, 1.2);
    floor(c, scale, wall);
    let right = flat(c.view.right).normalize_or(DVec3::X);
    let width = 2.2 * c.view.slope * scale;
    for side in [-1.0, 1.0] {
        let middle = right * (side * width * c.random.between(0.7, 1.1)) + DVec3::Y * (5.9 * scale);
        plane(c, "wall", middle, right * side, 6.0 * scale);
    }
    let space = Space { near: 0.7 * scale, far: scale + 0.8 * wall, rest: Rest::Floor(0.0) };
    for _ in 0..3 + c.random.index(4) {
        let Some((center, radius)) = c.place(&space) else { continue };
        let half = [(); 3].map(|()| scale * c.view.slope * c.random.between(0.08, 0.25));
        let material = surface::material(c, true);
        let mesh = solids::rounded_box(half.map(|x| 2.0 * x), 0.02 * half[0]);
        let turn = DQuat::from_rotation_y(c.random.between(-0.6, 0.6)).to_array();
        let translation = [center.x, half[1], center.z];
        c.studio.add("furniture", mesh, material, Transform::from_parts(translation, turn, [1.0; 3]));
        c.take(DVec3::from(translation), half.into_iter().fold(radius, f64::max));
        if c.random.chance(0.7) {
            let own = 0.8 * half[0].min(half[2]);
            let top = 2.0 * half[1];
            filling::object(c, DVec3::new(center.x, top + own, center.z), own, Rest::Floor(top));
        }
    }
    space
}

/// Houses on both sides of a long floor.
fn street(c: &mut Composition, scale: f64) -> Space {
    floor(c, scale, 4.5 * scale);
    let ahead = flat(c.view.ahead).normalize_or(DVec3::NEG_Z);
    let (right, eye) = (ahead.cross(DVec3::Y), flat(c.view.eye));
    let width = scale * c.random.between(0.25, 0.5);
    let shades: Vec<usize> = (0..4).map(|_| surface::ground(c)).collect();
    for side in [-1.0, 1.0] {
        let mut along = 0.5 * scale;
        while along < 5.0 * scale {
            let length = scale * c.random.between(0.3, 0.9);
            let (height, depth) = (scale * c.random.between(0.2, 1.6), scale * c.random.between(0.3, 0.6));
            let off = width + scale * c.random.between(0.0, 0.12);
            let mut mesh = crate::Mesh::default();
            let (near, far) = (side * off, side * (off + depth));
            objects::add_box(&mut mesh, [near.min(far), 0.0, -(along + length)], [near.max(far), height, -along]);
            // From the frame of the street into the world.
            for (p, n) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
                let turned = |v: [f32; 3]| {
                    let [x, y, z] = v.map(f64::from);
                    right * x + DVec3::Y * y - ahead * z
                };
                *p = (eye + turned(*p)).as_vec3().to_array();
                *n = turned(*n).as_vec3().to_array();
            }
            // Windows of one size.
            mesh.texture_coordinates.iter_mut().flatten().for_each(|t| *t /= scale as f32);
            let shade = shades[c.random.index(shades.len())];
            c.solid("house", mesh, shade);
            along += length + if c.random.chance(0.4) { scale * c.random.between(0.02, 0.2) } else { 0.0 };
        }
    }
    Space { near: 0.6 * scale, far: 3.5 * scale, rest: Rest::Floor(0.0) }
}

fn floating(c: &mut Composition, scale: f64) -> Space {
    let depth = scale * c.random.between(1.4, 2.6);
    backdrop(c, depth, 0.6);
    Space { near: 0.55 * scale, far: 0.9 * depth, rest: Rest::Nothing }
}

/// A wall across the view at a depth, turned by up to an angle.
fn backdrop(c: &mut Composition, depth: f64, most_rad: f64) {
    let turn = DQuat::from_axis_angle(c.random.direction(), c.random.between(0.0, most_rad));
    let (middle, across) = (c.view.point(depth, 0.0, 0.0), turn * c.view.ahead);
    plane(c, "backdrop", middle, across, 4.0 * depth);
}

fn slanted(c: &mut Composition, scale: f64) -> Space {
    let depth = scale * c.random.between(1.6, 2.6);
    backdrop(c, depth, 0.9);
    for _ in 0..4 + c.random.index(6) {
        let (near, far) = (0.7 * scale, 0.9 * depth);
        let place = 1.0 / c.random.between(1.0 / far, 1.0 / near);
        let (x, y) = (c.random.between(-0.9, 0.9), c.random.between(-0.9, 0.9));
        let half = place * c.view.slope * c.random.between(0.2, 0.7);
        let (axis, angle) = (c.random.direction(), c.random.between(0.2, 1.2));
        let turn = DQuat::from_axis_angle(axis, angle);
        let material = surface::material(c, true);
        let mesh = solids::rounded_box([2.0 * half, 2.0 * half * c.random.between(0.3, 1.0), 0.04 * half], 0.01 * half);
        let pose = Transform::from_parts(c.view.point(place, x, y).to_array(), turn.to_array(), [1.0; 3]);
        c.studio.add("board", mesh, material, pose);
    }
    Space { near: 0.7 * scale, far: 0.9 * depth, rest: Rest::Nothing }
}

/// Flats that face the camera, each with an edge in the image.
fn steps(c: &mut Composition, scale: f64) -> Space {
    let depth = scale * c.random.between(1.4, 2.2);
    backdrop(c, depth, 0.05);
    for _ in 0..4 + c.random.index(8) {
        let place = 1.0 / c.random.between(1.0 / (0.95 * depth), 1.0 / (0.7 * scale));
        let (x, y) = (c.random.between(-1.0, 1.0), c.random.between(-1.0, 1.0));
        let unit = place * c.view.slope;
        let size = [unit * c.random.between(0.1, 0.9), unit * c.random.between(0.1, 0.9), 0.01 * unit];
        let turn = DQuat::from_mat3(&glam::DMat3::from_cols(c.view.right, c.view.up, -c.view.ahead));
        let roll = turn * DQuat::from_rotation_z(c.random.between(-0.5, 0.5));
        let material = surface::material(c, true);
        let pose = Transform::from_parts(c.view.point(place, x, y).to_array(), roll.to_array(), [1.0; 3]);
        c.studio.add("flat", solids::rounded_box(size, 0.004 * unit), material, pose);
    }
    Space { near: 0.7 * scale, far: 0.9 * depth, rest: Rest::Nothing }
}

fn thicket(c: &mut Composition, scale: f64) -> Space {
    let wall = scale * c.random.between(0.5, 1.5);
    floor(c, scale, wall);
    let space = Space { near: 0.6 * scale, far: scale + 0.8 * wall, rest: Rest::Floor(0.0) };
    let count = 10 + c.random.index(20);
    extras::plants(c, &space, count, 0.9);
    space
}
