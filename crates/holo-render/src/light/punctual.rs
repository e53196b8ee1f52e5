//! Punctual lights in camera coordinates.
//!
//! Source: KHR_lights_punctual. Radiometry: 1 lux on a white Lambertian surface gives radiance 1/pi; I candela at r
//! metres give I/r^2 lux. No factor of 683 or of 4 pi appears anywhere.

use crate::geometry::world_to_camera_rotation;
use crate::sampling::{self, Points};
use crate::simd::angles::sin_cos;
use crate::simd::{LANES, at};
use holo_scene::{Light, LightKind, Transform};

/// Shadow rays stop this far towards a light, so that a surface in which the light lies does not hide it.
pub(crate) const SHADOW_REACH: f32 = 1.0 - 1e-4;

/// No light is stronger than this anywhere, so that sums and products stay within f32.
pub(crate) const MAX_RADIANCE: f32 = 1e30;

/// A light as the integrators use it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PreparedLight {
    /// Light from everywhere along one direction; the unit vector points *to* the light.
    Directional { to_light: [f32; 3], irradiance: [f32; 3] },
    /// The same from all over a disc: `axis` points to its middle.
    Disc { axis: [f32; 3], irradiance: [f32; 3], disc: Disc },
    /// Light from a point, perhaps into a cone only.
    Point { position: [f32; 3], intensity: [f32; 3], inverse_range: f32, cone: Option<Cone> },
}

/// The disc of a distant light of the half-angle a.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    /// 1 - cos a, which a small angle leaves its digits.
    versine: f32,
    /// Irradiance on a surface that faces the disc, over its radiance: pi sin^2 a.
    projected: f32,
    /// Solid angle over `projected`: 2 / (1 + cos a).
    spread: f32,
}

/// The cone of a spot light: intensity times `clamp(cosine * scale + offset, 0, 1)^2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    axis: [f32; 3],
    scale: f32,
    offset: f32,
}

/// Light that arrives at sixteen points from one light, before the cosine and the shadow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrivals {
    /// Towards the light: unit length for directional lights, up to the light for the others.
    pub to_light: [[f32; LANES]; 3],
    /// Over the length of `to_light`.
    pub inverse_length: [f32; LANES],
    /// How much of `PreparedLight::power` arrives on a surface that faces the light.
    pub attenuation: [f32; LANES],
}

impl Disc {
    fn new(diameter_rad: f64) -> Self {
        let half = 0.5 * diameter_rad;
        let (sin, cos) = half.sin_cos();
        let versine = 2.0 * (0.5 * half).sin().powi(2);
        let projected = std::f64::consts::PI * sin * sin;
        Self { versine: versine as f32, projected: projected as f32, spread: (2.0 / (1.0 + cos)) as f32 }
    }
}

/// The lights that shine at all, in the frame of a camera at `pose`.
pub(crate) fn prepare(lights: &[Light], pose: &Transform) -> Vec<PreparedLight> {
    let rotation = world_to_camera_rotation(pose);
    let place = |p: [f64; 3]| rotation.vector(std::array::from_fn(|k| p[k] - pose.translation[k])).map(|x| x as f32);
    let turn = |d: [f64; 3]| rotation.vector(d).map(|x| x as f32);
    let inverse = |range: Option<f64>| range.map_or(0.0, |r| 1.0 / r) as f32;
    lights
        .iter()
        .filter(|light| light.intensity.iter().any(|&i| i > 0.0))
        .map(|light| {
            let intensity = light.intensity.map(|x| x as f32);
            match light.kind {
                LightKind::Directional { direction, angular_diameter_rad } => {
                    let to_light = turn(direction.map(|x| -x));
                    if angular_diameter_rad > 0.0 {
                        let disc = Disc::new(angular_diameter_rad);
                        PreparedLight::Disc { axis: to_light, irradiance: intensity, disc }
                    } else {
                        PreparedLight::Directional { to_light, irradiance: intensity }
                    }
                }
                LightKind::Point { position, range } => {
                    let inverse_range = inverse(range);
                    PreparedLight::Point { position: place(position), intensity, inverse_range, cone: None }
                }
                LightKind::Spot { position, direction, range, inner_angle_rad, outer_angle_rad } => {
                    let (inner, outer) = (inner_angle_rad.cos(), outer_angle_rad.cos());
                    // The floor under the difference is the specification's own.
                    let scale = 1.0 / (inner - outer).max(0.001);
                    let cone = Cone { axis: turn(direction), scale: scale as f32, offset: (-outer * scale) as f32 };
                    let (position, inverse_range) = (place(position), inverse(range));
                    PreparedLight::Point { position, intensity, inverse_range, cone: Some(cone) }
                }
            }
        })
        .collect()
}

impl PreparedLight {
    /// Irradiance (lux) or intensity (candela).
    #[inline(always)]
    pub fn power(&self) -> [f32; 3] {
        match self {
            Self::Directional { irradiance, .. } | Self::Disc { irradiance, .. } => *irradiance,
            Self::Point { intensity, .. } => *intensity,
        }
    }

    /// What arrives at sixteen points; of discs from the place `place` on them.
    #[inline(always)]
    pub fn arrivals(&self, points: &[[f32; LANES]; 3], place: &Points) -> Arrivals {
        match self {
            Self::Directional { to_light, .. } => {
                let [x, y, z] = *to_light;
                Arrivals {
                    to_light: [[x; LANES], [y; LANES], [z; LANES]],
                    inverse_length: [1.0; LANES],
                    attenuation: [1.0; LANES],
                }
            }
            Self::Disc { axis, disc, .. } => {
                let [x, y] = sampling::frame(*axis);
                let one = [1.0; LANES];
                let mut out = Arrivals { to_light: [one; 3], inverse_length: one, attenuation: [disc.spread; LANES] };
                for lane in 0..LANES {
                    // Uniform over the solid angle: the versine is uniform.
                    let versine = place[0][lane] * disc.versine;
                    let across = (versine * (2.0 - versine)).max(0.0).sqrt();
                    let (sin, cos) = sin_cos((place[1][lane] - 0.5) * std::f32::consts::TAU);
                    for k in 0..3 {
                        let sideways = x[k] * cos + y[k] * sin;
                        out.to_light[k][lane] = axis[k] * (1.0 - versine) + sideways * across;
                    }
                }
                out
            }
            Self::Point { position, inverse_range, cone, .. } => {
                let zero = [0.0; LANES];
                let mut out = Arrivals { to_light: [zero; 3], inverse_length: zero, attenuation: zero };
                for lane in 0..LANES {
                    let to_light =
                        [position[0] - points[0][lane], position[1] - points[1][lane], position[2] - points[2][lane]];
                    let squared = dot(to_light, to_light);
                    let length = squared.sqrt();
                    let reach = length * inverse_range;
                    let window = (1.0 - reach * reach * reach * reach).clamp(0.0, 1.0);
                    for axis in 0..3 {
                        out.to_light[axis][lane] = to_light[axis];
                    }
                    out.inverse_length[lane] = if length > 0.0 { (1.0 / length).min(MAX_RADIANCE) } else { 0.0 };
                    out.attenuation[lane] = if squared > 0.0 { (window / squared).min(MAX_RADIANCE) } else { 0.0 };
                }
                if let Some(cone) = cone {
                    for lane in 0..LANES {
                        let to_light = at(&out.to_light, lane);
                        let cosine = -dot(to_light, cone.axis) * out.inverse_length[lane];
                        let edge = (cosine * cone.scale + cone.offset).clamp(0.0, 1.0);
                        out.attenuation[lane] *= edge * edge;
                    }
                }
                out
            }
        }
    }

    /// Whether the light has an extent on the sky.
    pub fn is_disc(&self) -> bool {
        matches!(self, Self::Disc { .. })
    }

    /// Whether the light is a disc that a ray in direction `direction` meets.
    #[inline(always)]
    pub fn disc_shows(&self, direction: &[[f32; LANES]; 3], lane: usize) -> bool {
        let Self::Disc { axis, disc, .. } = self else { return false };
        // The squared chord is twice the versine, and keeps its digits.
        let unit = 1.0 / dot(at(direction, lane), at(direction, lane)).sqrt();
        let mut chord = 0.0;
        for k in 0..3 {
            let difference = direction[k][lane] * unit - axis[k];
            chord += difference * difference;
        }
        chord <= 2.0 * disc.versine
    }

    /// Radiance of the disc; 0 for other lights.
    #[inline(always)]
    pub fn disc_radiance(&self) -> [f32; 3] {
        let Self::Disc { irradiance: [r, g, b], disc, .. } = self else { return [0.0; 3] };
        [
            (r / disc.projected).min(MAX_RADIANCE),
            (g / disc.projected).min(MAX_RADIANCE),
            (b / disc.projected).min(MAX_RADIANCE),
        ]
    }

    /// How far a shadow ray along `Arrival::to_light` has to look, in multiples of it.
    #[inline(always)]
    pub fn shadow_reach(&self) -> f32 {
        match self {
            Self::Directional { .. } | Self::Disc { .. } => f32::INFINITY,
            Self::Point { .. } => SHADOW_REACH,
        }
    }
}

#[inline(always)]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(kind: LightKind) -> PreparedLight {
        prepare(&[Light { name: String::new(), intensity: [2.0; 3], kind }], &Transform::IDENTITY)[0]
    }

    /// Attenuation at one point, per square metre.
    fn arriving(light: &PreparedLight, point: [f32; 3]) -> f32 {
        let arrivals = light.arrivals(&point.map(|x| [x; LANES]), &[[0.5; LANES]; 2]);
        arrivals.attenuation[3]
    }

    #[test]
    fn a_point_light_falls_off_with_the_square_and_ends_at_its_range() {
        let light = one(LightKind::Point { position: [0.0; 3], range: None });
        assert!((arriving(&light, [3.0, 0.0, 4.0]) - 0.04).abs() < 1e-7);
        let light = one(LightKind::Point { position: [0.0; 3], range: Some(10.0) });
        let expected = (1.0 - 0.5f32.powi(4)) / 25.0;
        assert!((arriving(&light, [3.0, 0.0, 4.0]) - expected).abs() < 1e-7);
        assert_eq!(arriving(&light, [0.0, 10.5, 0.0]), 0.0);
    }

    #[test]
    fn a_spot_is_full_inside_its_inner_and_dark_outside_its_outer_angle() {
        let light = one(LightKind::Spot {
            position: [0.0; 3],
            direction: [0.0, 0.0, -1.0],
            range: None,
            inner_angle_rad: 0.3,
            outer_angle_rad: 0.6,
        });
        let under = |angle: f32| arriving(&light, [angle.sin(), 0.0, -angle.cos()]);
        assert!((under(0.0) - 1.0).abs() < 1e-6 && (under(0.29) - 1.0).abs() < 1e-4);
        assert_eq!(under(0.61), 0.0);
        let half = ((0.45f32.cos() - 0.6f32.cos()) / (0.3f32.cos() - 0.6f32.cos())).powi(2);
        assert!((under(0.45) - half).abs() < 1e-4);
    }

    #[test]
    fn lights_that_do_not_shine_cost_no_shadow_rays() {
        let dark = Light {
            name: String::new(),
            intensity: [0.0; 3],
            kind: LightKind::Point { position: [0.0; 3], range: None },
        };
        assert!(prepare(&[dark], &Transform::IDENTITY).is_empty());
    }
}
