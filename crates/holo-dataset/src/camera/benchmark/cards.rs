//! Textured cards before a wall, whose depth is known everywhere.

use holo_core::plenoptic::PlenopticCamera;
use holo_scene::{Instance, Material, Mesh, Scene, Transform};

use super::poses::{self, spread};
use crate::camera::target::{BoardPose, transform};

/// The number of cards.
const CARDS: usize = 7;

/// Half the width of a card in that of the field at its depth.
const WIDTH: f64 = 0.2;

/// The wall is wider than the field by this factor: poses and glass show more of it.
const WALL: f64 = 1.3;

/// Shades of the cells, from the darkest albedo to the brightest.
const SHADES: usize = 8;
const DARKEST: f32 = 0.04;
const BRIGHTEST: f32 = 0.8;

/// The most cells along a side.
const MOST_CELLS: f64 = 400.0;

/// Cards between two depths, and a wall at the far one, all of square cells of random shades, unlit, in the frame of the camera.
pub(super) fn scene(camera: &PlenopticCamera, cell_m: f64, [near_m, far_m]: [f64; 2]) -> Scene {
    let tangents = camera.angles_of_view_rad().map(|angle| (angle / 2.0).tan());
    let mut meshes: Vec<Mesh> = vec![Mesh::default(); SHADES];
    let wall = BoardPose { position_m: [0.0, 0.0, -far_m], rotation_deg: [0.0; 3] };
    add_card(&mut meshes, &transform(&wall), tangents.map(|tangent| WALL * far_m * tangent), cell_m, 0);
    for number in 0..CARDS {
        let [depth, x, y, about_x, about_y, about_z] = spread(poses::COUNT + number);
        let depth_m = 1.0 / (1.0 / far_m + (1.0 / near_m - 1.0 / far_m) * depth);
        let half_m = WIDTH * depth_m * tangents[0].min(tangents[1]);
        let place = |from: f64, tangent: f64| (2.0 * from - 1.0) * (depth_m * tangent - half_m);
        let pose = BoardPose {
            position_m: [place(x, tangents[0]), place(y, tangents[1]), -depth_m],
            rotation_deg: [about_x, about_y, about_z].map(|from| (2.0 * from - 1.0) * poses::TILT_DEG),
        };
        add_card(&mut meshes, &transform(&pose), [half_m; 2], cell_m, number as u64 + 1);
    }
    let mut scene = Scene::default();
    for (shade, mut mesh) in meshes.into_iter().enumerate() {
        let albedo = DARKEST + (BRIGHTEST - DARKEST) * shade as f32 / (SHADES - 1) as f32;
        mesh.material = scene.materials.len();
        let base_color = [albedo, albedo, albedo, 1.0];
        scene.materials.push(Material { unlit: true, base_color, ..Material::default() });
        let mesh_number = scene.meshes.len();
        scene.meshes.push(mesh);
        scene.instances.push(Instance { name: "cards".into(), mesh: mesh_number, transform: Transform::IDENTITY });
    }
    scene
}

/// Adds a rectangle of square cells to the meshes of their shades.
fn add_card(meshes: &mut [Mesh], placed: &Transform, half_m: [f64; 2], cell_m: f64, card: u64) {
    let cells = half_m.map(|half_m| (2.0 * half_m / cell_m).clamp(1.0, MOST_CELLS).ceil() as u64);
    let at = |axis: usize, k: u64| half_m[axis] * (2.0 * k as f64 / cells[axis] as f64 - 1.0);
    for row in 0..cells[1] {
        for column in 0..cells[0] {
            let mesh = &mut meshes[shade(card, row, column)];
            let first = mesh.positions.len() as u32;
            let ([left, right], [low, high]) =
                ([column, column + 1].map(|k| at(0, k)), [row, row + 1].map(|k| at(1, k)));
            for [x, y] in [[left, low], [right, low], [right, high], [left, high]] {
                mesh.positions.push(placed.point([x, y, 0.0]).map(|x| x as f32));
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
}

/// The shade of a cell: the top bits of SplitMix64 (Steele et al. 2014).
fn shade(card: u64, row: u64, column: u64) -> usize {
    let mut x = (card << 40 | row << 20 | column).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 61) as usize % SHADES
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbors have the same shade as often as chance has it, within five standard errors: no stripes, no card like another.
    #[test]
    fn shades_of_neighbors_are_independent() {
        const SIDE: u64 = 64;
        let (chance, count) = (1.0 / SHADES as f64, (4 * SIDE * SIDE) as f64);
        for [card_on, row_on, column_on] in [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]] {
            let cells = (0..4).flat_map(|card| (0..SIDE * SIDE).map(move |k| [card, k / SIDE, k % SIDE]));
            let is_same = |[card, row, column]: &[u64; 3]| {
                shade(*card, *row, *column) == shade(card + card_on, row + row_on, column + column_on)
            };
            let part = cells.filter(is_same).count() as f64 / count;
            let error = (chance * (1.0 - chance) / count).sqrt();
            assert!((part - chance).abs() < 5.0 * error, "{card_on} {row_on} {column_on}: {part}");
        }
    }
}
