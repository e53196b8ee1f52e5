//! Visibility, compared with where two rectangles are by hand.

use holo_core::{GridSize, LightFieldShape, Projection, Rig};
use holo_scene::{Instance, Material, Mesh};

use super::*;

/// The depth of the small square, m.
const NEAR_M: f64 = 1.0;

/// The depth of the wall behind it, m.
const FAR_M: f64 = 2.0;

/// Half the side of the square, m.
const HALF_M: f64 = 0.1;

/// How far it is to the right of the axis, m.
const RIGHT_M: f64 = 0.03;

/// A square before a wall that fills all views, or before nothing.
fn scene(with_wall: bool) -> Scene {
    let square = |center: [f64; 3], half: f64| Mesh {
        positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| [center[0] + x * half, center[1] + y * half, center[2]].map(|x| x as f32))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let mut meshes = vec![square([RIGHT_M, 0.0, -NEAR_M], HALF_M)];
    if with_wall {
        meshes.push(square([0.0, 0.0, -FAR_M], 100.0));
    }
    let instance = |mesh| Instance { name: String::new(), mesh, transform: Transform::IDENTITY };
    Scene {
        instances: (0..meshes.len()).map(instance).collect(),
        meshes,
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

fn rig(projection: Projection, focus_m: f64) -> Rig {
    let shape = LightFieldShape::new(GridSize::new(6, 9), GridSize::new(16, 24)).expect("sizes");
    Rig::builder(shape)
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_x_m(0.013)
        .baseline_y_m(0.021)
        .focus_distance_m(focus_m)
        .projection(projection)
        .build()
        .expect("a rig")
}

/// The part of all views that see the point of a pixel; `None` where a ray meets an edge.
fn expected(rig: &Rig, pixel: [usize; 2], with_wall: bool) -> Option<f64> {
    let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
    let on_square = |at: [f64; 2]| [at[0] - RIGHT_M, at[1]].map(|x| x.abs() - HALF_M);
    let is_near_edge = |distances: [f64; 2]| distances[0].max(distances[1]).abs() < 1e-5;
    let (t0, s0) = rig.shape().central_view();
    let at = |t: usize, s: usize, jx: f64, jy: f64, depth_m: f64| {
        let ray = rig.ray(pixel[0], pixel[1], t, s, jx, jy);
        [0, 1].map(|k| ray.origin_m[k] + ray.direction[k] * depth_m)
    };
    let own = on_square(at(t0, s0, 0.5, 0.5, NEAR_M));
    if is_near_edge(own) {
        return None;
    }
    let is_square = own[0].max(own[1]) < 0.0;
    let depth_m = match (is_square, with_wall) {
        (true, _) => NEAR_M,
        (false, true) => FAR_M,
        (false, false) => 1e12,
    };
    let [x, y] = at(t0, s0, 0.5, 0.5, depth_m);
    let mut seen = 0;
    for t in 0..views.rows {
        for s in 0..views.columns {
            let (row, column) = rig.project([x, y, -depth_m], t, s).expect("in front of the rig");
            let edge = [row, column - lenses.columns as f64, row - lenses.rows as f64, column];
            if edge.iter().any(|distance| distance.abs() < 1e-6) {
                return None;
            }
            if !(0.0..lenses.rows as f64).contains(&row) || !(0.0..lenses.columns as f64).contains(&column) {
                continue;
            }
            let [jx, jy] = [column - pixel[1] as f64, row - pixel[0] as f64];
            let before = on_square(at(t, s, jx, jy, NEAR_M));
            if !is_square && is_near_edge(before) {
                return None;
            }
            seen += usize::from(is_square || before[0].max(before[1]) > 0.0);
        }
    }
    Some(seen as f64 / views.count() as f64)
}

#[test]
fn a_square_hides_the_wall_where_it_should() {
    let perspective = |focus_m| rig(Projection::Perspective, focus_m);
    let rigs = [perspective(1.4), perspective(f64::INFINITY), rig(Projection::Orthographic, 1.4)];
    for (rig, with_wall) in rigs.into_iter().zip([true, false, true]) {
        let renderer = Renderer::new(&scene(with_wall), &Transform::IDENTITY, Backend::Auto, NonZeroUsize::new(2))
            .expect("a renderer");
        let request = Request::new(rig);
        let found = renderer.visibility(&request, &()).expect("visibility");
        let (mut checked, mut hidden) = (0, 0);
        for ((v, u), found) in found.indexed_iter() {
            if let Some(expected) = expected(&rig, [v, u], with_wall) {
                // A count over 54 views, rounded to f32.
                assert!((f64::from(*found) - expected).abs() < 1e-6, "{v} {u}: {found}, not {expected}");
                checked += 1;
                hidden += usize::from((0.01..0.99).contains(&expected));
            }
        }
        assert!(checked > found.len() * 9 / 10 && hidden > 20, "{checked} pixels, {hidden} not in all views");
        // Parts are those of the whole.
        let part = renderer.visibility(&request.rows(Some(4..9)), &()).expect("visibility");
        assert_eq!(part, found.slice(ndarray::s![4..9, ..]));
        let bvh = Renderer::new(&scene(with_wall), &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1))
            .expect("a renderer");
        assert_eq!(bvh.visibility(&Request::new(rig), &()).expect("visibility"), found);
    }
}
