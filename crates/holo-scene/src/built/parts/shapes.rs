//! Procedural meshes: positions, smooth normals where the shape is smooth, texture coordinates where they are used.

use glam::DVec3;

use crate::Mesh;

/// A grid of `columns x rows` quads over `surface(s, t)`, s and t in 0..1, with smooth normals and (s, t) as texture
/// coordinates. Counter-clockwise where s increases to the right and t downwards.
pub(crate) fn sheet(columns: u32, rows: u32, surface: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    let step = 1e-4;
    for j in 0..=rows {
        for i in 0..=columns {
            let (s, t) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let along_s = surface(s + step, t) - surface(s - step, t);
            let along_t = surface(s, t + step) - surface(s, t - step);
            mesh.positions.push(surface(s, t).as_vec3().to_array());
            mesh.normals.push(along_t.cross(along_s).normalize_or_zero().as_vec3().to_array());
            mesh.texture_coordinates.push([s as f32, t as f32]);
        }
    }
    let corner = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A ball of radius 1 around the origin, displaced along its normal by `displacement(direction)`. It ends slightly
/// before its poles, where the parametrization is singular.
pub(crate) fn ball(columns: u32, rows: u32, displacement: impl Fn(DVec3) -> f64) -> Mesh {
    sheet(columns, rows, |s, t| {
        let (longitude, latitude) = (s * std::f64::consts::TAU, (1e-3 + (1.0 - 2e-3) * t) * std::f64::consts::PI);
        let direction = DVec3::new(latitude.sin() * longitude.cos(), latitude.cos(), -latitude.sin() * longitude.sin());
        direction * (1.0 + displacement(direction))
    })
}

/// A tube of the given radius around a closed or open curve `path(s)`.
pub(crate) fn tube(columns: u32, rows: u32, radius: impl Fn(f64) -> f64, path: impl Fn(f64) -> DVec3) -> Mesh {
    sheet(columns, rows, |s, t| {
        let ahead = (path(s + 1e-4) - path(s - 1e-4)).normalize();
        let side = ahead.cross(DVec3::new(0.31, 0.9, -0.17)).normalize();
        let up = side.cross(ahead);
        let angle = -t * std::f64::consts::TAU;
        path(s) + (side * angle.cos() + up * angle.sin()) * radius(s)
    })
}

/// An axis-aligned box with flat sides, from its lowest to its highest corner.
pub(crate) fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [0, 1] {
            let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = mesh.positions.len() as u32;
            for (a, b) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                let pick = |k: usize, which: usize| if which == 1 { high[k] } else { low[k] };
                let mut p = [0.0; 3];
                (p[axis], p[right], p[up]) = (pick(axis, side), pick(right, a), pick(up, b));
                mesh.positions.push(p.map(|x| x as f32));
            }
            let quad = [[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|k| k + first));
            mesh.triangles.extend(if side == 1 { quad } else { quad.map(|[a, b, c]| [a, c, b]) });
        }
    }
    mesh
}

/// Adds a blade of grass: a strip of `segments` quads that narrows to a point and bends over, with flat normals.
pub(crate) fn add_blade(mesh: &mut Mesh, root: DVec3, heading_rad: f64, height: f64, bend: f64, color: [f32; 3]) {
    let segments = 4;
    let ahead = DVec3::new(heading_rad.cos(), 0.0, heading_rad.sin());
    let side = DVec3::new(-heading_rad.sin(), 0.0, heading_rad.cos());
    let first = mesh.positions.len() as u32;
    for k in 0..=segments {
        let t = f64::from(k) / f64::from(segments);
        let spine = root + DVec3::Y * height * (t - 0.35 * bend * t * t) + ahead * height * bend * t * t;
        let half_width = side * height * 0.035 * (1.0 - t).powf(0.7);
        let shade = 0.45 + 0.55 * t as f32;
        for p in [spine - half_width, spine + half_width] {
            mesh.positions.push(p.as_vec3().to_array());
            mesh.colors.push([color[0] * shade, color[1] * shade, color[2] * shade, 1.0]);
        }
    }
    for k in 0..segments {
        let a = first + 2 * k;
        // The last pair of corners coincides: one triangle closes the tip.
        mesh.triangles.push([a, a + 1, a + 2]);
        if k + 1 < segments {
            mesh.triangles.push([a + 1, a + 3, a + 2]);
        }
    }
}
