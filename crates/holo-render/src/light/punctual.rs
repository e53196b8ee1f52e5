//! Punctual lights in camera coordinates.
//!
//! Source: KHR_lights_punctual. Radiometry: 1 lux on a white Lambertian surface gives a radiance of 1/pi; I candela at
//! a distance of r meters give I/r^2 lux. There is no factor of 683 or 4 pi.

use crate::geometry::world_to_camera_rotation;
use crate::sampling::{self, Points};
use crate::simd::angles::sin_cos;
use crate::simd::{LANES, at};
use holo_scene::{Light, LightKind, Transform};

/// The end of shadow rays towards point lights, relative to the distance: a surface that contains the light does not
/// occlude it.
pub(crate) const SHADOW_REACH: f32 = 1.0 - 1e-4;

/// The maximum of attenuation and radiance, so that sums and products fit into f32.
pub(crate) const MAX_RADIANCE: f32 = 1e30;

/// A light, prepared for the integrators.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PreparedLight {
    /// Parallel light; the unit vector points *to* the light.
    Directional { to_light: [f32; 3], irradiance: [f32; 3] },
    /// Light from a disc of constant radiance at infinity; `axis` points to its center.
    Disc { axis: [f32; 3], irradiance: [f32; 3], disc: Disc },
    /// Light from a point, with a cone for spot lights.
    Point { position: [f32; 3], intensity: [f32; 3], inverse_range: f32, cone: Option<Cone> },
}

/// The disc of a directional light with the half-angle a.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    /// 1 - cos a, which is accurate for small angles.
    versine: f32,
    /// Projected solid angle: irradiance on a surface that faces the disc / radiance = pi sin^2 a.
    projected_solid_angle: f32,
}

/// The cone of a spot light: intensity times `clamp(cosine * scale + offset, 0, 1)^2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    axis: [f32; 3],
    scale: f32,
    offset: f32,
}

/// The incident light from one light at sixteen points, without cosine and shadow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IncidentLight {
    /// Towards the light: unit length for directional lights, the vector to the light for the others.
    pub to_light: [[f32; LANES]; 3],
    /// 1 / length of `to_light`.
    pub inverse_length: [f32; LANES],
    /// The share of [`PreparedLight::power`] that arrives on a surface that faces the light; without meaning for discs,
    /// which have a radiance.
    pub attenuation: [f32; LANES],
}

impl Disc {
    fn new(diameter_rad: f64) -> Self {
        let half = 0.5 * diameter_rad;
        let sin = half.sin();
        let versine = 2.0 * (0.5 * half).sin().powi(2);
        let projected_solid_angle = std::f64::consts::PI * sin * sin;
        Self { versine: versine as f32, projected_solid_angle: projected_solid_angle as f32 }
    }
}

/// The lights with an intensity above 0, in the frame of a camera at `pose`.
pub(crate) fn prepare(lights: &[Light], pose: &Transform) -> Vec<PreparedLight> {
    let rotation = world_to_camera_rotation(pose);
    let to_camera_point =
        |p: [f64; 3]| rotation.vector(std::array::from_fn(|k| p[k] - pose.translation[k])).map(|x| x as f32);
    let to_camera_direction = |d: [f64; 3]| rotation.vector(d).map(|x| x as f32);
    let inverse = |range: Option<f64>| range.map_or(0.0, |r| 1.0 / r) as f32;
    lights
        .iter()
        .filter(|light| light.intensity.iter().any(|&i| i > 0.0))
        .map(|light| {
            let intensity = light.intensity.map(|x| x as f32);
            match light.kind {
                LightKind::Directional { direction, angular_diameter_rad } => {
                    let to_light = to_camera_direction(direction.map(|x| -x));
                    if angular_diameter_rad > 0.0 {
                        let disc = Disc::new(angular_diameter_rad);
                        PreparedLight::Disc { axis: to_light, irradiance: intensity, disc }
                    } else {
                        PreparedLight::Directional { to_light, irradiance: intensity }
                    }
                }
                LightKind::Point { position, range } => {
                    let inverse_range = inverse(range);
                    PreparedLight::Point { position: to_camera_point(position), intensity, inverse_range, cone: None }
                }
                LightKind::Spot { position, direction, range, inner_angle_rad, outer_angle_rad } => {
                    let (inner, outer) = (inner_angle_rad.cos(), outer_angle_rad.cos());
                    // The specification defines this minimum of the difference.
                    let scale = 1.0 / (inner - outer).max(0.001);
                    let cone = Cone {
                        axis: to_camera_direction(direction),
                        scale: scale as f32,
                        offset: (-outer * scale) as f32,
                    };
                    let (position, inverse_range) = (to_camera_point(position), inverse(range));
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

    /// The incident light at sixteen points; of discs from the sample `disc_point`.
    #[inline(always)]
    pub fn incident(&self, points: &[[f32; LANES]; 3], disc_point: &Points) -> IncidentLight {
        match self {
            Self::Directional { to_light, .. } => {
                let [x, y, z] = *to_light;
                IncidentLight {
                    to_light: [[x; LANES], [y; LANES], [z; LANES]],
                    inverse_length: [1.0; LANES],
                    attenuation: [1.0; LANES],
                }
            }
            Self::Disc { axis, disc, .. } => {
                let [x, y] = sampling::frame(*axis);
                let one = [1.0; LANES];
                let mut out = IncidentLight { to_light: [one; 3], inverse_length: one, attenuation: one };
                for lane in 0..LANES {
                    // Uniform over the solid angle, because the versine is uniform.
                    let versine = disc_point[0][lane] * disc.versine;
                    let across = (versine * (2.0 - versine)).max(0.0).sqrt();
                    let (sin, cos) = sin_cos((disc_point[1][lane] - 0.5) * std::f32::consts::TAU);
                    for k in 0..3 {
                        let sideways = x[k] * cos + y[k] * sin;
                        out.to_light[k][lane] = axis[k] * (1.0 - versine) + sideways * across;
                    }
                }
                out
            }
            Self::Point { position, inverse_range, cone, .. } => {
                let zero = [0.0; LANES];
                let mut out = IncidentLight { to_light: [zero; 3], inverse_length: zero, attenuation: zero };
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

    /// Whether the light has an angular diameter.
    pub fn is_disc(&self) -> bool {
        matches!(self, Self::Disc { .. })
    }

    /// Whether the light is a disc that the ray with this direction hits.
    #[inline(always)]
    pub fn disc_shows(&self, direction: &[[f32; LANES]; 3], lane: usize) -> bool {
        let Self::Disc { axis, disc, .. } = self else { return false };
        // The squared chord is twice the versine, without cancellation.
        let unit = 1.0 / dot(at(direction, lane), at(direction, lane)).sqrt();
        let mut chord = 0.0;
        for k in 0..3 {
            let difference = direction[k][lane] * unit - axis[k];
            chord += difference * difference;
        }
        chord <= 2.0 * disc.versine
    }

    /// The radiance of the disc; 0 for other lights.
    #[inline(always)]
    pub fn disc_radiance(&self) -> [f32; 3] {
        let Self::Disc { irradiance: [r, g, b], disc, .. } = self else { return [0.0; 3] };
        [
            (r / disc.projected_solid_angle).min(MAX_RADIANCE),
            (g / disc.projected_solid_angle).min(MAX_RADIANCE),
            (b / disc.projected_solid_angle).min(MAX_RADIANCE),
        ]
    }

    /// The pdf of [`Self::incident`] per solid angle if a ray can hit the light: of discs; otherwise infinite.
    #[inline(always)]
    pub fn pdf(&self) -> f32 {
        match self {
            Self::Disc { disc, .. } => 1.0 / (std::f32::consts::TAU * disc.versine),
            Self::Directional { .. } | Self::Point { .. } => f32::INFINITY,
        }
    }

    /// The end of a shadow ray along [`IncidentLight::to_light`], in multiples of it.
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

    /// Attenuation at one point, 1/m^2.
    fn attenuation_at(light: &PreparedLight, point: [f32; 3]) -> f32 {
        let incident = light.incident(&point.map(|x| [x; LANES]), &[[0.5; LANES]; 2]);
        incident.attenuation[3]
    }

    #[test]
    fn a_point_light_falls_off_with_the_square_and_ends_at_its_range() {
        let light = one(LightKind::Point { position: [0.0; 3], range: None });
        assert!((attenuation_at(&light, [3.0, 0.0, 4.0]) - 0.04).abs() < 1e-7);
        let light = one(LightKind::Point { position: [0.0; 3], range: Some(10.0) });
        let expected = (1.0 - 0.5f32.powi(4)) / 25.0;
        assert!((attenuation_at(&light, [3.0, 0.0, 4.0]) - expected).abs() < 1e-7);
        assert_eq!(attenuation_at(&light, [0.0, 10.5, 0.0]), 0.0);
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
        let under = |angle: f32| attenuation_at(&light, [angle.sin(), 0.0, -angle.cos()]);
        assert!((under(0.0) - 1.0).abs() < 1e-6 && (under(0.29) - 1.0).abs() < 1e-4);
        assert_eq!(under(0.61), 0.0);
        let half = ((0.45f32.cos() - 0.6f32.cos()) / (0.3f32.cos() - 0.6f32.cos())).powi(2);
        assert!((under(0.45) - half).abs() < 1e-4);
    }

    #[test]
    fn lights_without_intensity_cost_no_shadow_rays() {
        let dark = Light {
            name: String::new(),
            intensity: [0.0; 3],
            kind: LightKind::Point { position: [0.0; 3], range: None },
        };
        assert!(prepare(&[dark], &Transform::IDENTITY).is_empty());
    }
}
