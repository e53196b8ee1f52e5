//! What COMPOTE reads beside a camera: boards, their images, and the camera before it is calibrated.

use holo_core::plenoptic::{ArrayFocus, MicrolensIndex, PlenopticCamera};
use holo_core::{GridSize, meters_to_millimeters as mm};
use serde_json::{Value, json};

use super::{Grid, Libpleno, geometry, mode};
use crate::Error;

/// The focus of a camera that is focused at infinity, mm.
const FAR_MM: f64 = 1e6;

/// An image and its f-number.
pub type ImageOfStop = (String, f64);

/// A corner of a board in a micro-image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardCorner {
    /// The microlens.
    pub lens: MicrolensIndex,
    /// The position, in pixels whose centers are whole numbers.
    pub position_px: [f64; 2],
    /// The signed radius of the blur, in pixels.
    pub blur_px: f64,
    /// Row and column of the corner on its board.
    pub place: [usize; 2],
    /// The number of the board.
    pub frame: usize,
}

impl Libpleno {
    /// Returns `camera.js`, with which COMPOTE begins: the numbers of a data sheet and the size of the grid of micro-images of
    /// the true camera.
    ///
    /// # Errors
    /// [`Error::Camera`] as [`new`](Self::new).
    pub fn before_calibration(data_sheet: &PlenopticCamera, truth: &PlenopticCamera) -> Result<String, Error> {
        let (sensor, lens, grid) = (data_sheet.sensor(), data_sheet.main_lens(), Grid::new(truth)?);
        let focus_m = match lens.focus {
            ArrayFocus::Depth { depth_m, .. } => depth_m,
            ArrayFocus::Distance { .. } => 1.0 / data_sheet.inverse_focus_per_m(),
        };
        let object = json!({
            "I": truth.array().type_count(),
            "mode": mode(truth),
            "dist_focus": if focus_m > 0.0 { mm(focus_m).min(FAR_MM) } else { FAR_MM },
            "main_lens": { "f": mm(lens.focal_length_m), "aperture": lens.f_number },
            "mia": { "mesh": { "geometry": geometry(truth)?, "width": grid.columns, "height": grid.rows } },
            "sensor": { "width": sensor.size.columns, "height": sensor.size.rows, "scale": mm(sensor.pixel_m) },
        });
        Ok(format!("{object:#}\n"))
    }

    /// Returns `images.js` for white images of several f-numbers, the one of them that boards are divided by, and boards, by
    /// their paths: 8 bits of red, green and blue each.
    #[must_use]
    pub fn boards(whites: &[ImageOfStop], mask: &ImageOfStop, boards: &[String]) -> String {
        let image = |(path, f_number): &ImageOfStop| json!({ "path": path, "fnumber": f_number });
        let board = |(frame, path): (usize, &String)| json!({ "path": path, "fnumber": mask.1, "frame": frame });
        let object = json!({
            "meta": { "debayered": true, "rgb": true, "format": 8 },
            "whites": whites.iter().map(image).collect::<Vec<_>>(),
            "checkerboards": boards.iter().enumerate().map(board).collect::<Vec<_>>(),
            "mask": image(mask),
        });
        format!("{object:#}\n")
    }

    /// Returns the features of boards of `corners` as COMPOTE detects them, here as they are: for its option `--features`. Its own
    /// detection asks a person to show it every board.
    ///
    /// # Errors
    /// [`Error::Camera`] as [`new`](Self::new).
    pub fn features(camera: &PlenopticCamera, corners: GridSize, found: &[BoardCorner]) -> Result<String, Error> {
        let grid = Grid::new(camera)?;
        let feature = |corner: &BoardCorner| {
            let [l, k] = grid.place(corner.lens)?;
            let [row, column] = corner.place;
            // Boards begin at the lower right.
            let cluster = (corners.rows - 1 - row) * corners.columns + (corners.columns - 1 - column);
            let [u, v] = corner.position_px;
            let (rho, frame) = (corner.blur_px, corner.frame);
            Some(json!({ "k": k, "l": l, "u": u, "v": v, "rho": rho, "cluster": cluster, "frame": frame }))
        };
        let nodes = (0..grid.rows).flat_map(|l| (0..grid.columns).map(move |k| (k, l)));
        let center = |(k, l)| {
            let [u, v] = camera.micro_image_center_px(grid.at(l, k)).map(|x| x - 0.5);
            json!({ "k": k, "l": l, "u": u, "v": v })
        };
        let object = json!({
            "features": found.iter().filter_map(feature).collect::<Vec<_>>(),
            "centers": nodes.map(center).collect::<Vec<_>>(),
        });
        Ok(format!("{object}\n"))
    }

    /// Returns `scene.js`: a board by its inner corners and the side of a square.
    #[must_use]
    pub fn scene(corners: GridSize, square_m: f64) -> String {
        let upright = json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let object = json!({
            "checkerboards": [{
                "lph": mm(square_m), "x_grid": corners.columns, "y_grid": corners.rows,
                "pose": { "rotation": upright, "translation": [[0.0, 0.0, 0.0]] },
            }],
        });
        format!("{object:#}\n")
    }

    /// Returns `poses.js`: the place of the camera in the frame of each board. A board is its first corner, at the lower right as
    /// the camera sees a board that stands upright, and the directions of its rows to the right, its columns up, and its front,
    /// in meters before a camera that looks along -z.
    #[must_use]
    pub fn poses(boards: &[([f64; 3], [[f64; 3]; 3])]) -> String {
        // libpleno looks along +z, and its x and y are those of the image of the main lens.
        let turned = |[x, y, z]: [f64; 3]| [-x, y, -z];
        let pose = |(frame, (corner_m, [right, up, front])): (usize, &([f64; 3], [[f64; 3]; 3]))| {
            let axes = [right.map(|x| -x), *up, front.map(|x| -x)].map(turned);
            let corner = turned(*corner_m).map(mm);
            let place = axes.map(|axis| -(0..3).map(|k| axis[k] * corner[k]).sum::<f64>());
            // The columns of the rotation from the camera to the board.
            let columns: [[f64; 3]; 3] = std::array::from_fn(|k| axes.map(|axis| axis[k]));
            json!({ "frame": frame, "pose": { "rotation": columns, "translation": [place] } })
        };
        let poses: Vec<Value> = boards.iter().enumerate().map(pose).collect();
        format!("{:#}\n", json!({ "poses": poses }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// libpleno asks for columns before rows, in millimeters.
    #[test]
    fn scenes_describe_one_board() {
        let value: Value = serde_json::from_str(&Libpleno::scene(GridSize::new(5, 8), 0.0125)).unwrap();
        let board = &value["checkerboards"][0];
        assert_eq!((&board["lph"], &board["x_grid"], &board["y_grid"]), (&json!(12.5), &json!(8), &json!(5)));
        assert_eq!(board["pose"]["rotation"], json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
    }

    /// A point of a board has the place in libpleno's frame that its pose says: p = R^T (b - t).
    #[test]
    fn poses_place_corners() {
        let (sin, cos) = 0.3f64.sin_cos();
        let board = ([0.02, -0.01, -0.4], [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]]);
        let value: Value = serde_json::from_str(&Libpleno::poses(&[board])).unwrap();
        let pose = &value["poses"][0]["pose"];
        let number = |value: &Value| value.as_f64().unwrap();
        let (columns, place) = (&pose["rotation"], &pose["translation"][0]);
        for (i, j) in [(0.0, 0.0), (3.0, 0.0), (0.0, 2.0), (4.0, 1.0)] {
            let on_board = [10.0 * i, 10.0 * j, 0.0];
            let from: [f64; 3] = std::array::from_fn(|k| on_board[k] - number(&place[k]));
            let found: [f64; 3] = std::array::from_fn(|k| (0..3).map(|a| number(&columns[k][a]) * from[a]).sum());
            // Rows of the board run to the left from its first corner.
            let point: [f64; 3] =
                std::array::from_fn(|k| 1e3 * board.0[k] - on_board[0] * board.1[0][k] + on_board[1] * board.1[1][k]);
            let expected = [-point[0], point[1], -point[2]];
            for k in 0..3 {
                assert!((found[k] - expected[k]).abs() < 1e-9, "{found:?} {expected:?}");
            }
            assert!(found[2] > 300.0);
        }
    }
}
