//! Shading normals that reflect away from the surface.

/// The minimum cosine between the direction to the viewer and the shading normal of a glossy surface. Normals that face
/// away (at the silhouette of smooth-shaded meshes) are rotated towards the viewer.
pub(crate) const MIN_COSINE: f32 = 1e-3;

/// The shading normal, turned as little as necessary for the mirror direction of the viewer to be above the triangle.
/// Normal maps and interpolated normals at grazing angles would otherwise reflect into the surface, where the light is
/// lost. All are unit vectors on the side of the viewer.
#[inline(always)]
pub(crate) fn reflecting(normal: [f32; 3], viewer: [f32; 3], geometric: [f32; 3]) -> [f32; 3] {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let twice = 2.0 * dot(normal, viewer);
    let mut half = [0.0; 3];
    for axis in 0..3 {
        half[axis] = twice * normal[axis] - viewer[axis];
    }
    let lift = (MIN_COSINE - dot(half, geometric)).max(0.0);
    for axis in 0..3 {
        half[axis] += geometric[axis] * lift;
    }
    // The lifted mirror direction, and between it and the viewer the normal.
    let unit = 1.0 / dot(half, half).sqrt();
    for axis in 0..3 {
        half[axis] = half[axis] * unit + viewer[axis];
    }
    let unit = 1.0 / dot(half, half).sqrt();
    let turned = (lift > 0.0) & unit.is_finite();
    let mut out = [0.0; 3];
    for axis in 0..3 {
        out[axis] = if turned { half[axis] * unit } else { normal[axis] };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrored_viewers_stay_above_the_triangle() {
        let unit = |v: [f32; 3]| {
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            v.map(|x| x / length)
        };
        let dot = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f32>();
        let up = [0.0, 0.0, 1.0];
        let mut turned = 0;
        for k in 0..400 {
            let viewer = unit([1.0, 0.0, 0.02 * (k % 20 + 1) as f32]);
            let slope = (k / 20) as f32 * 0.1 - 1.0;
            let normal = unit([slope, 0.3 * slope, 1.0]);
            if dot(normal, viewer) <= MIN_COSINE {
                continue;
            }
            let found = reflecting(normal, viewer, up);
            let mirrored: [f32; 3] = std::array::from_fn(|k| 2.0 * dot(found, viewer) * found[k] - viewer[k]);
            assert!(mirrored[2] > 0.0, "{viewer:?} {normal:?} {found:?}");
            assert!((dot(found, found) - 1.0).abs() < 1e-5 && dot(found, viewer) > 0.0);
            let was_above = 2.0 * dot(normal, viewer) * normal[2] - viewer[2] > MIN_COSINE;
            assert!(!was_above || found == normal, "a normal that reflects upwards stays");
            turned += u32::from(found != normal);
        }
        assert!(turned > 10, "{turned}");
        // Seen from above, a slope of 80 degrees becomes one of 45, whose mirror direction is level.
        let steep = unit([(80.0_f32).to_radians().sin(), 0.0, (80.0_f32).to_radians().cos()]);
        let found = reflecting(steep, up, up);
        assert!((found[2] - std::f32::consts::FRAC_1_SQRT_2).abs() < 3e-3, "{found:?}");
    }
}
