//! The centers of micro-images as a calibration file of PlenoptiCam.

use holo_core::plenoptic::{MicrolensGrid, PlenopticCamera};
use serde_json::{Value, json};

use super::micro_images;
use crate::Error;

/// Returns the calibration file (JSON) of PlenoptiCam 0.9 for a camera, which takes the place of its own calibration by a
/// white image: the centers of all micro-images of the columns that all rows share.
///
/// # Units
///
/// Pixels, the center of the first pixel being 0.
///
/// # Errors
/// [`Error::Camera`] if the array is a hexagonal grid of columns, or no column of micro-images lies in all rows.
pub fn plenopticam_calibration(camera: &PlenopticCamera) -> Result<String, Error> {
    let (pattern, row_height) = match camera.array().grid {
        MicrolensGrid::Square => ("rec", 1.0),
        MicrolensGrid::HexRows => ("hex", 3f64.sqrt() / 2.0),
        MicrolensGrid::HexColumns => {
            return Err(Error::Camera("PlenoptiCam reads hexagonal grids of rows; mla.grid is hex-columns".into()));
        }
    };
    let all = micro_images(camera);
    // Rows are shorter where a rotated array leaves the sensor: those that have half of the columns of the longest count.
    let mut rows: Vec<&[_]> = all.chunk_by(|(a, _), (b, _)| a.row == b.row).collect();
    let longest = rows.iter().map(|row| row.len()).max().unwrap_or(0);
    rows.retain(|row| 2 * row.len() > longest);
    let first = rows.iter().map(|row| row[0].0.column).max().unwrap_or(0);
    let last = rows.iter().map(|row| row[row.len() - 1].0.column).min().unwrap_or(-1);
    if first > last {
        return Err(Error::Camera("no column of micro-images lies in all rows of the sensor".into()));
    }
    let mut list = Vec::new();
    for (number, row) in rows.iter().enumerate() {
        for (lens, [x, y]) in row.iter().filter(|(lens, _)| (first..=last).contains(&lens.column)) {
            list.push(json!([y - 0.5, x - 0.5, number, lens.column - first]));
        }
    }
    let pitch = camera.micro_image_pitch_px();
    let object = json!({
        "pat_type": pattern,
        "ptc_mean": [pitch * row_height * camera.array().scale_y, pitch],
        "mic_list": Value::Array(list),
    });
    Ok(format!("{object}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFile;

    #[test]
    fn all_rows_have_the_same_columns() {
        for name in ["lytro-f01", "raytrix-r29", "h3dv"] {
            let camera = CameraFile::preset(name).unwrap().camera;
            let file: Value = serde_json::from_str(&plenopticam_calibration(&camera).unwrap()).unwrap();
            let list = file["mic_list"].as_array().unwrap();
            let number = |entry: &Value, k: usize| entry[k].as_f64().unwrap();
            let last = list.last().unwrap();
            let (rows, columns) = (number(last, 2) as usize + 1, number(last, 3) as usize + 1);
            assert_eq!(list.len(), rows * columns, "{name}");
            assert!(list.len() as f64 > 0.97 * camera.lens_count() as f64, "{name}: {}", list.len());
            let step = number(&list[1], 1) - number(&list[0], 1);
            assert!((step - file["ptc_mean"][1].as_f64().unwrap()).abs() < 1e-4, "{name}");
        }
    }
}
