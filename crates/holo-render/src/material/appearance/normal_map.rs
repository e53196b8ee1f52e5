//! Normal maps: the shading normal that a texel gives, along the axes of the surface.

use super::{Appearance, NormalMapLookup, SurfacePoint, mix};
use crate::accel::RayHits;
use crate::geometry::Geometry;
use crate::material::SurfaceInteraction;

/// Unit axes across a normal: x along the tangent, y along the bitangent.
pub(super) struct TangentAxes {
    pub x: [f32; 3],
    pub y: [f32; 3],
}

impl Appearance {
    /// Applies the normal map to the shading normal of one lane.
    #[inline(always)]
    pub(super) fn apply_normal_map(
        &self,
        geometry: &Geometry,
        packet: &RayHits,
        lane: usize,
        out: &mut SurfaceInteraction,
    ) {
        let point = SurfacePoint::new(geometry, out.triangle[lane], [packet.hits.u[lane], packet.hits.v[lane]]);
        let material = &self.materials[point.instance.material as usize];
        let Some(map) = &material.normal_map else { return };
        if !point.instance.textured[map.0.set] {
            return;
        }
        // The map applies to the front; the shading normal may face the back.
        let side = out.side[lane];
        let mut normal = [0.0; 3];
        for axis in 0..3 {
            normal[axis] = out.shading_normal[axis][lane] * side;
        }
        let Some(axes) = tangent_axes(&point, map.0.set, normal) else { return };
        if let Some(mapped) = self.mapped_normal(map, &point, &axes, normal) {
            for axis in 0..3 {
                out.shading_normal[axis][lane] = mapped[axis] * side;
            }
        }
    }

    /// The unit normal of a map on the front; `None` if it vanishes.
    #[inline(always)]
    pub(super) fn mapped_normal(
        &self,
        (lookup, scale): &NormalMapLookup,
        point: &SurfacePoint,
        axes: &TangentAxes,
        normal: [f32; 3],
    ) -> Option<[f32; 3]> {
        let [r, g, b] = self.linear_texel(lookup, point);
        let (x, y, z) = ((2.0 * r - 1.0) * scale, (2.0 * g - 1.0) * scale, 2.0 * b - 1.0);
        let mut mapped = [0.0; 3];
        let mut squared = 0.0f32;
        for axis in 0..3 {
            mapped[axis] = axes.x[axis] * x + axes.y[axis] * y + normal[axis] * z;
            squared += mapped[axis] * mapped[axis];
        }
        let unit = 1.0 / squared.sqrt();
        unit.is_finite().then(|| mapped.map(|x| x * unit))
    }
}

/// The axes of the front at a point with the unit normal `normal`: the interpolated tangent of the vertices, or the
/// direction on the triangle in which u of coordinate set `set` increases; orthogonalized to the normal. `None` where
/// they vanish.
#[inline(always)]
pub(super) fn tangent_axes(point: &SurfacePoint, set: usize, normal: [f32; 3]) -> Option<TangentAxes> {
    let (mut tangent, turn) = match point.geometry.tangents_of(point.instance, point.triangle) {
        Some(corners) => {
            let [x, y, z, w] = mix(&corners, point.barycentrics);
            ([x, y, z], if w < 0.0 { -1.0 } else { 1.0 })
        }
        None => along_coordinates(point, set)?,
    };
    let mut along = 0.0;
    for axis in 0..3 {
        along += tangent[axis] * normal[axis];
    }
    let mut squared = 0.0f32;
    for axis in 0..3 {
        tangent[axis] -= normal[axis] * along;
        squared += tangent[axis] * tangent[axis];
    }
    let unit = 1.0 / squared.sqrt();
    if !unit.is_finite() {
        return None;
    }
    for axis in 0..3 {
        tangent[axis] *= unit;
    }
    let bitangent = [
        (normal[1] * tangent[2] - normal[2] * tangent[1]) * turn,
        (normal[2] * tangent[0] - normal[0] * tangent[2]) * turn,
        (normal[0] * tangent[1] - normal[1] * tangent[0]) * turn,
    ];
    Some(TangentAxes { x: tangent, y: bitangent })
}

/// The direction on a triangle in which u increases, and the sign of the bitangent.
#[inline(always)]
fn along_coordinates(point: &SurfacePoint, set: usize) -> Option<([f32; 3], f32)> {
    if !point.instance.textured[set] {
        return None;
    }
    let [a, b, c] = point.geometry.texture_coordinates_of(point.triangle, set);
    let [(u1, v1), (u2, v2)] = [(b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1])];
    let area = u1 * v2 - u2 * v1;
    if area == 0.0 {
        return None;
    }
    let corners = point.geometry.corners(point.triangle);
    let mut tangent = [0.0; 3];
    for axis in 0..3 {
        let (first, second) = (corners[1][axis] - corners[0][axis], corners[2][axis] - corners[0][axis]);
        tangent[axis] = (first * v2 - second * v1) * area.signum();
    }
    // Upward in the image, against v: to the left of u unless the coordinates or the placement are mirrored.
    Some((tangent, -area.signum() * point.geometry.orientation(point.triangle)))
}
