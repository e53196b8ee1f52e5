//! The grid of micro-images as the Light Field Toolbox for MATLAB describes it.

use holo_core::plenoptic::{MicrolensGrid, MicrolensIndex, PlenopticCamera};
use serde_json::json;

use crate::Error;

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
    /// Whether every second row, from the second on, is shifted by half a spacing.
    pub is_hexagonal: bool,
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
        Ok(Self { h_spacing, v_spacing, h_offset, v_offset, rot: -array.rotation_rad, u_max, v_max, is_hexagonal })
    }

    /// Returns the row from which on every second one is shifted, counted from 1; beyond the last one in a square grid.
    #[must_use]
    pub fn first_pos_shift_row(&self) -> usize {
        if self.is_hexagonal { 2 } else { self.v_max + 1 }
    }

    /// Returns the file `*.grid.json` that `LFReadMetadata` reads.
    #[must_use]
    pub fn to_json(&self) -> String {
        let model = json!({
            "HSpacing": self.h_spacing, "VSpacing": self.v_spacing,
            "HOffset": self.h_offset, "VOffset": self.v_offset,
            "Rot": self.rot, "UMax": self.u_max, "VMax": self.v_max,
            "Orientation": "horz", "FirstPosShiftRow": self.first_pos_shift_row(),
        });
        format!("{:#}\n", json!({ "LensletGridModel": model }))
    }

    /// Returns a MATLAB script that decodes `raw.png` and `white.png` beside it to the light field `LF(t, s, v, u, c)`.
    #[must_use]
    pub fn script(&self) -> String {
        let method = if self.is_hexagonal { "fast" } else { "none" };
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
            self.first_pos_shift_row()
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
            let (sin, cos) = model.rot.sin_cos();
            for (v, u) in [(0, 0), (1, 0), (model.v_max - 1, model.u_max - 1), (model.v_max / 2, model.u_max / 3)] {
                let is_shifted =
                    v + 1 >= model.first_pos_shift_row() && (v + 1 - model.first_pos_shift_row()).is_multiple_of(2);
                let x = (u as f64 + if is_shifted { 0.5 } else { 0.0 }) * model.h_spacing;
                let y = v as f64 * model.v_spacing;
                let at = [cos * x - sin * y + model.h_offset - 0.5, sin * x + cos * y + model.v_offset - 0.5];
                let nearest = camera.micro_image_center_px(camera.owner(camera.place_m(at)));
                let away = (at[0] - nearest[0]).hypot(at[1] - nearest[1]);
                assert!(away < 1e-6, "{name}: {at:?} {nearest:?}");
            }
        }
        let turned = "preset = \"lytro-illum\"\n[mla]\nrotation_deg = 180.0";
        let turned = CameraFile::parse(turned, "").unwrap().camera;
        assert!(LensletGridModel::new(&turned).unwrap_err().to_string().contains("mla.rotation_deg is 180"));
        let columns = CameraFile::preset("raytrix-r8").unwrap().camera;
        assert!(LensletGridModel::new(&columns).unwrap_err().to_string().contains("hex-columns"));
    }
}
