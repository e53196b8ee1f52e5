//! The grid of micro-images as the Light Field Toolbox for MATLAB describes it.

use std::path::Path;

use holo_core::plenoptic::{MicrolensGrid, MicrolensIndex, PlenopticCamera};
use serde::Deserialize;
use serde_json::json;

use crate::Error;
use crate::files::limits::read_small_file;

/// The largest file of a grid, bytes: the toolbox writes its options too.
const MAX_BYTES: u64 = 1 << 20;

/// The most micro-images a row or column: twice those of the largest presets.
const MOST: usize = 4096;

/// A file `*.grid.json`; other keys are not read.
#[derive(Deserialize)]
struct Document {
    #[serde(rename = "LensletGridModel")]
    model: Model,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Model {
    #[serde(rename = "HSpacing")]
    h_spacing: f64,
    #[serde(rename = "VSpacing")]
    v_spacing: f64,
    #[serde(rename = "HOffset")]
    h_offset: f64,
    #[serde(rename = "VOffset")]
    v_offset: f64,
    rot: f64,
    #[serde(rename = "UMax")]
    u_max: f64,
    #[serde(rename = "VMax")]
    v_max: f64,
    orientation: String,
    first_pos_shift_row: f64,
}

/// `LensletGridModel` of the Light Field Toolbox (LFToolbox 0.5): what its `LFBuildLensletGridModel` estimates from a white
/// image, here from the camera itself; of a tilted array that around its origin.
///
/// # Units
///
/// Pixels, the center of the first pixel being 1, as in MATLAB; radians.
#[derive(Debug, Clone, PartialEq)]
pub struct LensletGridModel {
    /// Distance of micro-images along a row.
    pub h_spacing: f64,
    /// Distance of rows.
    pub v_spacing: f64,
    /// Column of the first micro-image, the upper left one.
    pub h_offset: f64,
    /// Its row.
    pub v_offset: f64,
    /// Rotation of the grid, clockwise in the image.
    pub rot: f64,
    /// Micro-images a row.
    pub u_max: usize,
    /// Rows.
    pub v_max: usize,
    /// The row, counted from 1, from which on every second one is shifted by half a spacing; beyond the last one in a square grid.
    pub first_pos_shift_row: usize,
}

impl LensletGridModel {
    /// Describes the grid of a camera.
    ///
    /// # Errors
    /// [`Error::Camera`] if the array is a hexagonal grid of columns, turned by more than 45 degrees, or has no row of micro-images on the sensor.
    pub fn new(camera: &PlenopticCamera) -> Result<Self, Error> {
        let (array, size) = (camera.array(), camera.sensor().size);
        let (row_step, is_hexagonal) = match array.grid {
            MicrolensGrid::Square => (1, false),
            MicrolensGrid::HexRows => (2, true),
            MicrolensGrid::HexColumns => {
                return Err(Error::Camera("LFToolbox decodes hexagonal grids of rows; mla.grid is hex-columns".into()));
            }
        };
        // Rows run to the right, and the next one lies below.
        if array.rotation_rad.cos() < std::f64::consts::FRAC_1_SQRT_2 {
            let degrees = array.rotation_rad.to_degrees();
            return Err(Error::Camera(format!(
                "LFToolbox reads grids turned by at most 45 degrees; mla.rotation_deg is {degrees}"
            )));
        }
        let h_spacing = camera.micro_image_pitch_px();
        let row_height = if is_hexagonal { 3f64.sqrt() / 2.0 } else { 1.0 };
        let v_spacing = h_spacing * row_height * array.scale_y;
        // The first unshifted row, and the first micro-image of it, with their centers on the sensor.
        let mut lens = camera.owner(camera.place_m([0.0, 0.0]));
        lens = MicrolensIndex { row: lens.row - lens.row.rem_euclid(row_step) - row_step, column: lens.column - 2 };
        let is_before = |position: f64| position < 0.5;
        while is_before(camera.micro_image_center_px(lens)[1]) {
            lens.row += row_step;
        }
        while is_before(camera.micro_image_center_px(lens)[0]) {
            lens.column += 1;
        }
        let [x, y] = camera.micro_image_center_px(lens);
        let (h_offset, v_offset) = (x + 0.5, y + 0.5);
        let count = |size: usize, offset: f64, spacing: f64| ((size as f64 - offset) / spacing).floor() + 1.0;
        let (u_max, v_max) = (count(size.columns, h_offset, h_spacing), count(size.rows, v_offset, v_spacing));
        if u_max < 1.0 || v_max < 1.0 {
            return Err(Error::Camera("no row of micro-images lies on the sensor".into()));
        }
        let (u_max, v_max) = (u_max as usize, v_max as usize);
        let (rot, first_pos_shift_row) = (-array.rotation_rad, if is_hexagonal { 2 } else { v_max + 1 });
        Ok(Self { h_spacing, v_spacing, h_offset, v_offset, rot, u_max, v_max, first_pos_shift_row })
    }

    /// Reads the file `*.grid.json` that [`to_json`](Self::to_json) or the toolbox's `LFUtilProcessWhiteImages` writes.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read; [`Error::Broken`] if it has no grid of rows, or numbers that are none.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let broken = |what: String| Error::Broken { path: path.into(), format: "LFToolbox grid", what };
        let bytes = read_small_file(path, MAX_BYTES)?;
        let Document { model } = serde_json::from_slice(&bytes).map_err(|why| broken(why.to_string()))?;
        if model.orientation != "horz" {
            let name = crate::shown(&model.orientation);
            return Err(broken(format!("Orientation is '{name}'; grids of rows, 'horz', are read")));
        }
        let count = |key: &str, count: f64| match count.fract() == 0.0 && (1.0..=MOST as f64).contains(&count) {
            true => Ok(count as usize),
            false => Err(broken(format!("{key} is {count}; it is a number from 1 to {MOST}"))),
        };
        let (u_max, v_max) = (count("UMax", model.u_max)?, count("VMax", model.v_max)?);
        for (key, spacing) in [("HSpacing", model.h_spacing), ("VSpacing", model.v_spacing)] {
            if !(spacing.is_finite() && spacing >= 1.0) {
                return Err(broken(format!("{key} is {spacing}; micro-images are one pixel apart or more")));
            }
        }
        let first_pos_shift_row = count("FirstPosShiftRow", model.first_pos_shift_row)?;
        let Model { h_spacing, v_spacing, h_offset, v_offset, rot, .. } = model;
        Ok(Self { h_spacing, v_spacing, h_offset, v_offset, rot, u_max, v_max, first_pos_shift_row })
    }

    /// Returns the centers of the micro-images, to the right and down, in pixels; that of the first pixel is 0.5.
    #[must_use]
    pub fn centers_px(&self) -> Vec<[f64; 2]> {
        let (sin, cos) = self.rot.sin_cos();
        let center = |v: usize, u: usize| {
            let is_shifted = (v + 1).checked_sub(self.first_pos_shift_row).is_some_and(|rows| rows.is_multiple_of(2));
            let x = (u as f64 + if is_shifted { 0.5 } else { 0.0 }) * self.h_spacing;
            let y = v as f64 * self.v_spacing;
            [cos * x - sin * y + self.h_offset - 0.5, sin * x + cos * y + self.v_offset - 0.5]
        };
        (0..self.v_max).flat_map(|v| (0..self.u_max).map(move |u| center(v, u))).collect()
    }

    /// Returns the file `*.grid.json` that `LFReadMetadata` reads.
    #[must_use]
    pub fn to_json(&self) -> String {
        let model = json!({
            "HSpacing": self.h_spacing, "VSpacing": self.v_spacing,
            "HOffset": self.h_offset, "VOffset": self.v_offset,
            "Rot": self.rot, "UMax": self.u_max, "VMax": self.v_max,
            "Orientation": "horz", "FirstPosShiftRow": self.first_pos_shift_row,
        });
        format!("{:#}\n", json!({ "LensletGridModel": model }))
    }

    /// Returns a MATLAB script that decodes `raw.png` and `white.png` beside it to the light field `LF(t, s, v, u, c)`.
    #[must_use]
    pub fn script(&self) -> String {
        let method = if self.first_pos_shift_row <= self.v_max { "fast" } else { "none" };
        format!(
            "% Decodes raw.png to LF(t,s,v,u,c) with LFToolbox 0.5 on the path: run in this folder.\n\
             Raw = imread('raw.png');\n\
             White = imread('white.png');\n\
             Grid = struct('HSpacing',{:?}, 'VSpacing',{:?}, 'HOffset',{:?}, 'VOffset',{:?}, 'Rot',{:?}, ...\n    \
             'UMax',{}, 'VMax',{}, 'Orientation','horz', 'FirstPosShiftRow',{});\n\
             Options = struct('LevelLimits',[0 65535], 'DemosaicOrder','grbg', 'ResampMethod','{method}');\n\
             if exist('griddedInterpolant', 'class')\n    \
             [LF, LFWeight] = LFDecodeLensletImageDirect(Raw, White, Grid, Options);\n\
             else\n    \
             [LF, LFWeight] = LFDecodeLensletImageSimple(Raw, White, Grid, Options);\n\
             end\n\
             save('lightfield.mat', 'LF', 'LFWeight', '-v7');\n",
            self.h_spacing,
            self.v_spacing,
            self.h_offset,
            self.v_offset,
            self.rot,
            self.u_max,
            self.v_max,
            self.first_pos_shift_row
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFile;

    /// The grid that the toolbox builds of the model has the micro-image centers of the camera.
    #[test]
    fn grids_are_those_of_the_camera() {
        for name in ["lytro-illum", "lytro-f01", "raytrix-r29", "h3dv", "hahne-arri"] {
            let camera = CameraFile::preset(name).unwrap().camera;
            let model = LensletGridModel::new(&camera).unwrap();
            assert!(model.h_offset >= 1.0 && model.h_offset < 1.0 + 1.5 * model.h_spacing, "{name} {model:?}");
            assert!(model.v_offset >= 1.0 && model.v_offset < 1.0 + 2.5 * model.v_spacing, "{name} {model:?}");
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("white.grid.json");
            std::fs::write(&path, model.to_json()).unwrap();
            assert_eq!(LensletGridModel::read(&path).unwrap(), model);
            let centers = model.centers_px();
            assert_eq!(centers.len(), model.u_max * model.v_max);
            for at in centers {
                let nearest = camera.micro_image_center_px(camera.owner(camera.place_m(at)));
                let away = (at[0] - nearest[0]).hypot(at[1] - nearest[1]);
                assert!(away < 1e-6, "{name}: {at:?} {nearest:?}");
            }
            for (from, to, what) in [
                ("\"horz\"", "\"vert\"", "Orientation"),
                ("\"UMax\": ", "\"UMax\": 0.5e9, \"x\": ", "UMax"),
                ("\"HSpacing\": ", "\"HSpacing\": -1.0, \"x\": ", "HSpacing"),
                ("\"Rot\"", "\"rot\"", "Rot"),
            ] {
                std::fs::write(&path, model.to_json().replace(from, to)).unwrap();
                let why = LensletGridModel::read(&path).unwrap_err().to_string();
                assert!(why.contains(what) && why.contains("white.grid.json"), "{why}");
            }
        }
        let turned = "preset = \"lytro-illum\"\n[mla]\nrotation_deg = 180.0";
        let turned = CameraFile::parse(turned, "").unwrap().camera;
        assert!(LensletGridModel::new(&turned).unwrap_err().to_string().contains("mla.rotation_deg is 180"));
        let columns = CameraFile::preset("raytrix-r8").unwrap().camera;
        assert!(LensletGridModel::new(&columns).unwrap_err().to_string().contains("hex-columns"));
    }
}
