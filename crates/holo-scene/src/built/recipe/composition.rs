//! A scene under construction: what the camera sees, what is free in it, and what is put there.

use glam::DVec3;

use super::Parts;
use super::models::Models;
use crate::built::parts::noise::Random;
use crate::built::parts::studio::Studio;
use crate::{CameraProjection, Mesh, Scene, Transform};

/// How often a place is drawn before an object is left out.
const TRIES: usize = 24;

/// The camera: its place, and what it sees at a distance of 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub eye: DVec3,
    pub right: DVec3,
    pub up: DVec3,
    pub ahead: DVec3,
    /// Half of what is seen at a distance of 1, in a square image.
    pub slope: f64,
}

impl View {
    /// From `eye` to `target`.
    pub fn new(eye: DVec3, target: DVec3, vertical_angle_rad: f64) -> Self {
        let ahead = (target - eye).normalize_or(DVec3::NEG_Z);
        let right = ahead.cross(DVec3::Y).normalize_or(DVec3::X);
        Self { eye, right, up: right.cross(ahead), ahead, slope: (0.5 * vertical_angle_rad).tan() }
    }

    /// The point at a depth, and at a part of the image from its middle: -1 to 1 to the right, and up.
    pub fn point(&self, depth: f64, x: f64, y: f64) -> DVec3 {
        self.eye + depth * (self.ahead + self.slope * (x * self.right + y * self.up))
    }
}

/// What an object rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rest {
    /// A floor at this height.
    Floor(f64),
    /// Nothing: it floats, in any direction.
    Nothing,
}

/// Where objects of a layout may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    /// The depths along the axis of the camera, m.
    pub near: f64,
    pub far: f64,
    pub rest: Rest,
}

/// A scene under construction.
pub(super) struct Composition<'a> {
    pub recipe: &'a Parts,
    pub models: &'a Models,
    pub random: Random,
    pub studio: Studio,
    pub view: View,
    /// Textures of objects, which others may have too.
    pub textures: Vec<usize>,
    /// Centers and radii of what must stay apart.
    taken: Vec<(DVec3, f64)>,
}

impl<'a> Composition<'a> {
    pub fn new(recipe: &'a Parts, models: &'a Models, random: Random) -> Self {
        let view = View::new(DVec3::ZERO, DVec3::NEG_Z, 0.6);
        Self { recipe, models, random, studio: Studio::new(Vec::new()), view, textures: Vec::new(), taken: Vec::new() }
    }

    /// A free place in a space: center and radius of a ball.
    pub fn place(&mut self, space: &Space) -> Option<(DVec3, f64)> {
        for _ in 0..TRIES {
            let random = &mut self.random;
            // Evenly in inverse depth, as disparities are.
            let depth = 1.0 / random.between(1.0 / space.far, 1.0 / space.near);
            // The image is two slopes wide at a depth of 1.
            let radius = self.recipe.objects.size.log(random) * self.view.slope * depth;
            let (x, y) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let mut center = self.view.point(depth, x, y);
            if let Rest::Floor(height) = space.rest {
                // On the floor at this depth, whatever the height was.
                center = self.view.point(depth, x, 0.0);
                center.y = height + radius;
            }
            let is_free = !self.recipe.objects.apart
                || self.taken.iter().all(|(other, size)| other.distance(center) > size + radius);
            if is_free {
                self.taken.push((center, radius));
                return Some((center, radius));
            }
        }
        None
    }

    /// A pose in a ball: upright on a floor, else in any direction.
    pub fn pose(&mut self, center: DVec3, radius: f64, rest: Rest) -> Transform {
        let random = &mut self.random;
        let rotation = match rest {
            Rest::Floor(_) => glam::DQuat::from_rotation_y(random.between(0.0, std::f64::consts::TAU)),
            Rest::Nothing => {
                glam::DQuat::from_axis_angle(random.direction(), random.between(0.0, std::f64::consts::TAU))
            }
        };
        Transform::from_parts(center.to_array(), rotation.to_array(), [radius; 3])
    }

    /// Adds a mesh with a material of its own in world coordinates.
    pub fn solid(&mut self, name: &str, mesh: Mesh, material: usize) {
        self.studio.add(name, mesh, material, Transform::IDENTITY);
    }

    /// Keeps other objects away from a ball.
    pub fn take(&mut self, center: DVec3, radius: f64) {
        self.taken.push((center, radius));
    }

    /// The scene, seen by its camera.
    pub fn finish(self) -> Scene {
        let View { eye, ahead, slope, .. } = self.view;
        let mut scene = self.studio.with_camera(eye.to_array(), (eye + ahead).to_array());
        let projection = CameraProjection::Perspective { vertical_angle_rad: 2.0 * slope.atan(), aspect_ratio: None };
        scene.cameras.iter_mut().for_each(|camera| camera.projection = projection);
        scene
    }
}
