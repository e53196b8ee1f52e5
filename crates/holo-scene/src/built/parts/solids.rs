//! Procedural bodies: closed meshes with their triangles counter-clockwise from outside, as required for glass.

use glam::DVec3;

use crate::Mesh;

/// A body of revolution about +Y through the points (radius, height) of `profile`, as a smooth curve.
///
/// The outside is to the left of the profile: a solid goes from its top to its bottom, a vessel from the middle of the
/// bowl up the inner wall, over the rim and down the outer wall. Points close to each other form an edge. Texture
/// coordinates are (angle, position along the profile), 0 to 1.
pub(crate) fn lathe(columns: u32, steps: u32, profile: &[[f64; 2]]) -> Mesh {
    let mut mesh = Mesh::default();
    let rows = steps * (profile.len() as u32 - 1);
    let curve = |k: u32| spline(profile, f64::from(k) / f64::from(steps));
    let mut radii = Vec::new();
    for j in 0..=rows {
        let ([radius, height], [outward, upward]) = curve(j);
        let radius = if radius < 1e-7 { 0.0 } else { radius };
        radii.push(radius);
        for i in 0..=columns {
            // The last column equals the first, without a crack.
            let (sin, cos) = (f64::from(i % columns) / f64::from(columns) * std::f64::consts::TAU).sin_cos();
            mesh.positions.push([(radius * sin) as f32, height as f32, (radius * cos) as f32]);
            let normal = DVec3::new(-upward * sin, outward, -upward * cos).normalize_or(DVec3::Y);
            mesh.normals.push(normal.as_vec3().to_array());
            mesh.texture_coordinates.push([i as f32 / columns as f32, j as f32 / rows as f32]);
        }
    }
    let corner = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            // On the axis a quad is a triangle.
            if radii[j as usize + 1] > 0.0 {
                mesh.triangles.push([a, b, c]);
            }
            if radii[j as usize] > 0.0 {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

/// Position and direction of a Catmull-Rom spline at `x`, from 0 to the index of the last point.
fn spline(points: &[[f64; 2]], x: f64) -> ([f64; 2], [f64; 2]) {
    let last = points.len() - 1;
    let k = (x.floor() as usize).min(last - 1);
    let t = x - k as f64;
    let [b, c] = [points[k], points[k + 1]];
    let slope = |k: usize| -> [f64; 2] {
        let (before, after) = (points[k.saturating_sub(1)], points[(k + 1).min(last)]);
        let here = points[k];
        // Monotone along radius and height, so that the curve does not overshoot its points.
        std::array::from_fn(|axis| {
            let (left, right) = (here[axis] - before[axis], after[axis] - here[axis]);
            match (k == 0, k == last) {
                (true, _) => right,
                (_, true) => left,
                _ if left * right <= 0.0 => 0.0,
                _ => 2.0 * left * right / (left + right),
            }
        })
    };
    let (p, q) = (slope(k), slope(k + 1));
    let place = |axis: usize| {
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * b[axis]
            + (t3 - 2.0 * t2 + t) * p[axis]
            + (3.0 * t2 - 2.0 * t3) * c[axis]
            + (t3 - t2) * q[axis]
    };
    let direction = |axis: usize| {
        (6.0 * t * t - 6.0 * t) * b[axis]
            + (3.0 * t * t - 4.0 * t + 1.0) * p[axis]
            + (6.0 * t - 6.0 * t * t) * c[axis]
            + (3.0 * t * t - 2.0 * t) * q[axis]
    };
    let mut ahead = [direction(0), direction(1)];
    if ahead[0].hypot(ahead[1]) < 1e-9 {
        ahead = [c[0] - b[0], c[1] - b[1]];
    }
    ([place(0).max(0.0), place(1)], ahead)
}

/// A box around the origin with rounded edges. Texture coordinates are 0 to 1 on every side.
pub(crate) fn rounded_box(size: [f64; 3], radius: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let steps = 4;
    let half = size.map(|x| 0.5 * x);
    let quarter = |k: u32| f64::from(k) / f64::from(steps) * std::f64::consts::FRAC_PI_2;
    // Longitudes and latitudes of a ball, those on the borders of the octants twice, with a flat side between the two.
    for row in 0..2 * (steps + 1) {
        let (lower, latitude) = (row > steps, quarter(row % (steps + 1)));
        let latitude = if lower { latitude + std::f64::consts::FRAC_PI_2 } else { latitude };
        for column in 0..4 * (steps + 1) {
            let quadrant = column / (steps + 1);
            let longitude = quarter(column % (steps + 1)) + f64::from(quadrant) * std::f64::consts::FRAC_PI_2;
            let direction = [latitude.sin() * longitude.sin(), latitude.cos(), latitude.sin() * longitude.cos()];
            let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]][quadrant as usize];
            let sign = [signs[0], if lower { -1.0 } else { 1.0 }, signs[1]];
            let p: [f64; 3] = std::array::from_fn(|k| sign[k] * (half[k] - radius) + radius * direction[k]);
            mesh.positions.push(p.map(|x| x as f32));
            mesh.normals.push(direction.map(|x| x as f32));
            let widest =
                (0..3).fold(0, |best, k| if direction[k].abs() > direction[best].abs() + 1e-9 { k } else { best });
            let [x, y, z]: [f32; 3] = std::array::from_fn(|k| (p[k] / size[k] + 0.5) as f32);
            mesh.texture_coordinates.push([[z, 1.0 - y], [x, z], [x, 1.0 - y]][widest]);
        }
    }
    let columns = 4 * (steps + 1);
    let corner = |i: u32, j: u32| j * columns + i % columns;
    for j in 0..2 * (steps + 1) - 1 {
        for i in 0..columns {
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            let ends = [
                mesh.positions[a as usize] == mesh.positions[d as usize],
                mesh.positions[b as usize] == mesh.positions[c as usize],
            ];
            if !ends[1] {
                mesh.triangles.push([a, b, c]);
            }
            if !ends[0] {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    for (row, turn) in [(0, [0, 1, 2, 3]), (2 * (steps + 1) - 1, [3, 2, 1, 0])] {
        let [a, b, c, d] = turn.map(|quadrant| corner(quadrant * (steps + 1), row));
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// A flat ring of the given thickness around +Z: from the circle of radius `inner` to the outline `outer(turn)`, with
/// turn from 0 to 1. Flat sides.
pub(crate) fn plate(columns: u32, thickness: f64, inner: f64, outer: impl Fn(f64) -> f64) -> Mesh {
    let mut mesh = Mesh::default();
    let z = 0.5 * thickness as f32;
    for i in 0..columns {
        let turn = f64::from(i) / f64::from(columns);
        let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
        for (radius, z) in [(inner, z), (outer(turn), z), (outer(turn), -z), (inner, -z)] {
            let p = [(radius * cos) as f32, (radius * sin) as f32];
            mesh.positions.push([p[0], p[1], z]);
            mesh.texture_coordinates.push([p[0] * 10.0, p[1] * 10.0 + z * 7.0]);
        }
    }
    for i in 0..columns {
        let (here, next) = (4 * i, 4 * ((i + 1) % columns));
        for k in 0..4 {
            let [a, b] = [k, (k + 1) % 4];
            let quad = [[here + a, here + b, next + b], [here + a, next + b, next + a]];
            // Without a hole the innermost wall has no area.
            if inner > 0.0 || k < 3 {
                let thin = inner <= 0.0;
                mesh.triangles.extend(match k {
                    0 if thin => vec![quad[0]],
                    2 if thin => vec![quad[1]],
                    _ => quad.to_vec(),
                });
            }
        }
    }
    mesh
}

/// Appends a transformed mesh to a larger one.
pub(crate) fn join(all: &mut Mesh, part: &Mesh, place: &crate::Transform) {
    let first = all.positions.len() as u32;
    all.positions.extend(part.positions.iter().map(|p| place.point(p.map(f64::from)).map(|x| x as f32)));
    let turn = |n: &[f32; 3]| DVec3::from(place.vector(n.map(f64::from))).normalize_or(DVec3::Y).as_vec3().to_array();
    all.normals.extend(part.normals.iter().map(turn));
    all.texture_coordinates.extend(&part.texture_coordinates);
    all.triangles.extend(part.triangles.iter().map(|t| t.map(|k| k + first)));
}
