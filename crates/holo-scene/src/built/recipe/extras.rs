//! What a recipe adds to some scenes: thin things, a fence, repeated objects, plants.

use glam::{DQuat, DVec3};

use super::composition::{Composition, Rest, Space};
use super::objects::{self, Shape};
use super::surface;
use crate::built::parts::{shapes, solids};
use crate::{Mesh, Transform};

/// Adds what takes space of its own.
pub(super) fn before(c: &mut Composition, space: &Space) {
    let extras = c.recipe.extras;
    if c.random.chance(extras.repeated) {
        repeated(c, space);
    }
    if c.random.chance(extras.plants) {
        let count = 2 + c.random.index(6);
        plants(c, space, count, 0.5);
    }
}

/// Adds what lies between other objects, or before them.
pub(super) fn after(c: &mut Composition, space: &Space) {
    let extras = c.recipe.extras;
    if c.random.chance(extras.wires) {
        wires(c, space);
    }
    if c.random.chance(extras.fence) {
        fence(c, space);
    }
}

/// Wires from one side of the image to the other.
fn wires(c: &mut Composition, space: &Space) {
    let material = surface::material(c, false);
    let mut mesh = Mesh::default();
    for _ in 0..3 + c.random.index(10) {
        let depths = [(); 2].map(|()| 1.0 / c.random.between(1.0 / space.far, 1.0 / space.near));
        let is_across = c.random.chance(0.6);
        let [a, b] = [(); 2].map(|()| c.random.between(-1.1, 1.1));
        let ends = match is_across {
            true => [c.view.point(depths[0], -1.6, a), c.view.point(depths[1], 1.6, b)],
            false => [c.view.point(depths[0], a, -1.6), c.view.point(depths[1], b, 1.6)],
        };
        // From one to eight pixels in an image of 512.
        let radius = c.view.slope * depths[0].min(depths[1]) * c.random.between(0.002_f64.ln(), 0.016_f64.ln()).exp();
        let sag = if is_across { -0.1 * c.random.unit() * ends[0].distance(ends[1]) } else { 0.0 };
        let path = move |s: f64| ends[0].lerp(ends[1], s) + DVec3::Y * (4.0 * sag * s * (1.0 - s));
        solids::join(&mut mesh, &shapes::tube(24, 8, |_| radius, path), &Transform::IDENTITY);
    }
    c.solid("wires", mesh, material);
}

/// Bars, slats or a mesh of wires before everything.
fn fence(c: &mut Composition, space: &Space) {
    let depth = space.near * c.random.between(0.8, 0.98);
    let unit = c.view.slope * depth;
    let (count, width) = (6 + c.random.index(14), c.random.between(0.006_f64.ln(), 0.08_f64.ln()).exp());
    let (slant, is_mesh) = (c.random.between(-0.15, 0.15), c.random.chance(0.5));
    // Some reach over a part of the image alone.
    let (left, right) = (-1.3, c.random.between(-0.2, 1.6));
    let material = surface::material(c, false);
    let axes = DQuat::from_mat3(&glam::DMat3::from_cols(c.view.right, c.view.up, -c.view.ahead));
    let mut mesh = Mesh::default();
    // Those of one direction lie behind those of the other.
    let mut bar = |x: f64, y: f64, turn: f64, length: f64| {
        let part = solids::rounded_box([width * unit, length * unit, width * unit], 0.3 * width * unit);
        let behind = if turn > 0.0 { 1.1 * width * unit } else { 0.0 };
        let center = c.view.point(depth * (1.0 + slant * x), x, y) + behind * c.view.ahead;
        let pose = (axes * DQuat::from_rotation_z(turn)).to_array();
        solids::join(&mut mesh, &part, &Transform::from_parts(center.to_array(), pose, [1.0; 3]));
    };
    for k in 0..count {
        let x = left + (right - left) * (f64::from(k as u32) + 0.5) / count as f64;
        match is_mesh {
            true => [-0.7, 0.7].into_iter().for_each(|turn| bar(x, 0.01 * turn, turn, 3.6)),
            false => bar(x, 0.0, 0.0, 3.2),
        }
    }
    if !is_mesh {
        for y in [-0.5, 0.5] {
            bar(0.5 * (left + right), y, std::f64::consts::FRAC_PI_2, right - left);
        }
    }
    c.solid("fence", mesh, material);
}

/// Copies of one object beside each other.
fn repeated(c: &mut Composition, space: &Space) {
    let kind = match c.recipe.objects.shapes.without(Shape::Model) {
        Some(shapes) => shapes.pick(&mut c.random),
        None => Shape::Box,
    };
    let body = objects::body(kind, &mut c.random);
    let material = surface::material(c, body.is_closed);
    let mesh = c.studio.add_mesh("copies", body.mesh, material);
    let depth = 1.0 / c.random.between(1.0 / space.far, 1.0 / space.near);
    let radius = c.view.slope * depth * c.random.between(0.04, 0.12);
    let step = radius * c.random.between(2.05, 2.8);
    let counts = match space.rest {
        Rest::Floor(_) => [4 + c.random.index(8), 1, 1 + c.random.index(4)],
        Rest::Nothing => [3 + c.random.index(6), 3 + c.random.index(5), 1 + c.random.index(2)],
    };
    let center = match space.rest {
        Rest::Floor(height) => {
            let place = c.view.point(depth, c.random.between(-0.4, 0.4), 0.0);
            DVec3::new(place.x, height + radius, place.z)
        }
        Rest::Nothing => c.view.point(depth, c.random.between(-0.4, 0.4), c.random.between(-0.4, 0.4)),
    };
    let turn = DQuat::from_rotation_y(c.random.between(-0.6, 0.6));
    for (i, j, k) in
        (0..counts[0]).flat_map(|i| (0..counts[1]).flat_map(move |j| (0..counts[2]).map(move |k| (i, j, k))))
    {
        let off = |index: usize, count: usize| (index as f64 - 0.5 * (count as f64 - 1.0)) * step;
        let place = center + turn * DVec3::new(off(i, counts[0]), off(j, counts[1]), off(k, counts[2]));
        let place = match space.rest {
            Rest::Floor(height) => DVec3::new(place.x, height + radius, place.z),
            Rest::Nothing => place,
        };
        c.take(place, radius);
        c.studio.add_instance("copy", mesh, Transform::from_parts(place.to_array(), turn.to_array(), [radius; 3]));
    }
}

/// Plants on the floor, or in the air.
pub(super) fn plants(c: &mut Composition, space: &Space, count: usize, size: f64) {
    let material = surface::leaf(c);
    // A few kinds, and many of each.
    let kinds: Vec<usize> = (0..3)
        .map(|_| {
            let mesh = objects::body(Shape::Plant, &mut c.random).mesh;
            c.studio.add_mesh("plant", mesh, material)
        })
        .collect();
    for _ in 0..count {
        let depth = 1.0 / c.random.between(1.0 / space.far, 1.0 / space.near);
        let radius = c.view.slope * depth * size * c.random.between(0.3, 1.0);
        let (x, y) = (c.random.between(-1.1, 1.1), c.random.between(-0.9, 0.9));
        let place = match space.rest {
            Rest::Floor(height) => {
                let place = c.view.point(depth, x, 0.0);
                DVec3::new(place.x, height + 0.9 * radius, place.z)
            }
            Rest::Nothing => c.view.point(depth, x, y),
        };
        let turn = DQuat::from_rotation_y(c.random.between(0.0, std::f64::consts::TAU));
        let mesh = kinds[c.random.index(kinds.len())];
        c.studio.add_instance("plant", mesh, Transform::from_parts(place.to_array(), turn.to_array(), [radius; 3]));
    }
}
