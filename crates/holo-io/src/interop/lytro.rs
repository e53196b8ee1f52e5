//! Raw images and white images as those of Lytro's cameras, for the decoder of LFToolbox.

mod image;

use holo_core::GridSize;
use holo_core::plenoptic::PlenopticCamera;
use holo_core::sensor::{SensorModel, SensorPreset};
use ndarray::ArrayView2;
use serde_json::{Value, json};

use super::LensletGridModel;
use crate::Error;

pub use self::image::LytroImage;

/// The serial number of the camera.
const SERIAL: &str = "HOLO000001";

/// A camera of Lytro.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LytroModel {
    /// The F01 of 2012: 3280 x 3280 pixels of 12 bits.
    F01,
    /// The Illum of 2014: 7728 x 5368 pixels of 10 bits.
    Illum,
}

impl LytroModel {
    /// The model whose sensor has the size of a camera's.
    ///
    /// # Errors
    /// [`Error::Camera`] if there is none: the toolbox reads files of these sizes only.
    pub fn of(camera: &PlenopticCamera) -> Result<Self, Error> {
        let size = camera.sensor().size;
        let what = || format!("files of Lytro have 3280 x 3280 or 7728 x 5368 pixels; sensor.size_px is {size}");
        let mut models = [Self::F01, Self::Illum].into_iter();
        models.find(|model| model.size() == size).ok_or_else(|| Error::Camera(what()))
    }

    fn size(self) -> GridSize {
        match self {
            Self::F01 => GridSize::new(3280, 3280),
            Self::Illum => GridSize::new(5368, 7728),
        }
    }

    /// The sensor of the model.
    ///
    /// # Panics
    /// Never: the presets exist, which a test asserts.
    #[must_use]
    pub fn sensor(self) -> SensorModel {
        let found = SensorPreset::by_name(self.preset()).map(|preset| preset.model);
        found.unwrap_or_else(|| SensorModel::ideal(holo_core::sensor::ColorFilter::Grbg, 10, 5000.0))
    }

    /// The name of its camera and its sensor among the presets.
    const fn preset(self) -> &'static str {
        if matches!(self, Self::F01) { "lytro-f01" } else { "lytro-illum" }
    }

    const fn name(self) -> &'static str {
        if matches!(self, Self::F01) { "F01" } else { "B01" }
    }

    const fn order(self) -> &'static str {
        if matches!(self, Self::F01) { "big" } else { "little" }
    }

    /// Codes as the camera packs them: four of 10 bits in five bytes, two of 12 in three.
    #[must_use]
    pub fn packed(self, codes: ArrayView2<u16>) -> Vec<u8> {
        let codes: Vec<u16> = codes.iter().copied().collect();
        match self {
            Self::Illum => codes
                .chunks_exact(4)
                .flat_map(|v| {
                    let low = (0..4).fold(0, |low, k| low | (v[k] & 3) << (2 * k));
                    [v[0] >> 2, v[1] >> 2, v[2] >> 2, v[3] >> 2, low].map(|byte| byte as u8)
                })
                .collect(),
            Self::F01 => codes
                .chunks_exact(2)
                .flat_map(|v| [v[0] >> 4, (v[0] & 15) << 4 | v[1] >> 8, v[1] & 255].map(|byte| byte as u8))
                .collect(),
        }
    }

    /// Codes from the bytes of [`packed`](Self::packed); bytes of a part of a group are left out.
    #[must_use]
    pub fn unpacked(self, bytes: &[u8]) -> Vec<u16> {
        match self {
            Self::Illum => bytes
                .chunks_exact(5)
                .flat_map(|five| [0, 1, 2, 3].map(|k| u16::from(five[k]) << 2 | u16::from(five[4] >> (2 * k) & 3)))
                .collect(),
            Self::F01 => bytes
                .chunks_exact(3)
                .flat_map(|three| {
                    let [high, middle, low] = [0, 1, 2].map(|k| u16::from(three[k]));
                    [high << 4 | middle >> 4, (middle & 15) << 8 | low]
                })
                .collect(),
        }
    }

    fn pixel_format(self) -> Value {
        let sensor = self.sensor();
        let all = |code: u64| json!({"r": code, "gr": code, "gb": code, "b": code});
        json!({"rightShift": 0, "black": all(sensor.black as u64), "white": all(u64::from(sensor.white()))})
    }

    fn packing(self) -> Value {
        json!({"endianness": self.order(), "bitsPerPixel": self.sensor().bits})
    }

    fn devices(self, camera: &PlenopticCamera) -> Value {
        let (array, sensor, lens) = (camera.array(), camera.sensor(), camera.main_lens());
        let (x, y) = (array.offset_m[0], array.offset_m[1]);
        json!({
            "sensor": {"bitsPerPixel": self.sensor().bits, "pixelPitch": sensor.pixel_m},
            "lens": {"zoomStep": 0, "focusStep": 0, "focalLength": lens.focal_length_m, "fNumber": lens.f_number,
                     "exitPupilOffset": {"z": camera.exit_pupil_m()}},
            "shutter": {"frameExposureDuration": 0.01},
            "mla": {"tiling": "hexUniformRowMajor", "lensPitch": array.pitch_m, "rotation": array.rotation_rad,
                    "scaleFactor": {"x": 1.0, "y": array.scale_y},
                    "sensorOffset": {"x": x, "y": y, "z": array.gap_m}},
        })
    }

    fn mosaic(self) -> Value {
        json!({"tile": "r,gr:gb,b", "upperLeftPixel": if self == Self::F01 { "b" } else { "gr" }})
    }

    /// The metadata of a white image, `MOD_0000.TXT`.
    #[must_use]
    pub fn white_metadata(self, camera: &PlenopticCamera) -> String {
        let size = self.size();
        let metadata = json!({
            "type": "lightField",
            "image": {"width": size.columns, "height": size.rows, "orientation": 1, "representation": "rawPacked",
                      "rawDetails": {"pixelFormat": self.pixel_format(), "pixelPacking": self.packing(),
                                     "mosaic": self.mosaic()}},
            "devices": self.devices(camera),
            "camera": {"make": "Lytro, Inc.", "model": self.name(), "firmware": "holo"},
        });
        let frame = json!({"metadata": metadata, "privateMetadata": {"camera": {"serialNumber": SERIAL}}});
        format!("{:#}\n", json!({"master": {"picture": {"frameArray": [{"frame": frame}]}}}))
    }

    /// The metadata of an image, `IMG_0001__frame_metadata.json`.
    #[must_use]
    pub fn image_metadata(self, camera: &PlenopticCamera) -> String {
        let (size, sensor) = (self.size(), self.sensor());
        let [r, g, b] = sensor.white_balance;
        let gains = json!({"r": r, "gr": g, "gb": g, "b": b});
        let matrix: Vec<f64> = sensor.color_matrix.iter().flatten().copied().collect();
        let image = match self {
            Self::Illum => json!({
                "width": size.columns, "height": size.rows, "orientation": 1, "pixelPacking": self.packing(),
                "pixelFormat": self.pixel_format(), "mosaic": self.mosaic(), "iso": sensor.base_iso,
                "color": {"whiteBalanceGain": gains, "ccm": matrix},
            }),
            Self::F01 => json!({
                "width": size.columns, "height": size.rows, "orientation": 1,
                "rawDetails": {"pixelFormat": self.pixel_format(), "pixelPacking": self.packing(),
                               "mosaic": self.mosaic()},
                "color": {"ccmRgbToSrgbArray": matrix, "gamma": 0.416_660_010_814_666_75, "whiteBalanceGain": gains},
            }),
        };
        let camera_json = json!({"make": "Lytro, Inc.", "model": self.name(), "firmware": "holo"});
        format!("{:#}\n", json!({"image": image, "devices": self.devices(camera), "camera": camera_json}))
    }

    /// The private metadata of an image, `IMG_0001__frame_private_metadata.json`.
    #[must_use]
    pub fn private_metadata(self) -> String {
        let object = json!({"devices": {"sensor": {"serialNumber": SERIAL}}, "camera": {"serialNumber": SERIAL}});
        format!("{object:#}\n")
    }

    /// The grid of the white image, `MOD_0000.grid.json`, which spares the toolbox to look for it.
    #[must_use]
    pub fn grid(self, grid: &LensletGridModel) -> String {
        let information = json!({
            "ZoomStep": 0, "FocusStep": 0, "ExposureDuration": 0.01, "CamSerial": SERIAL, "CamModel": self.name(),
            "Fname": format!("{SERIAL}/WhiteImages/MOD_0000.TXT"),
        });
        let model: Value = serde_json::from_str(&grid.to_json()).unwrap_or_default();
        let by = json!({"mfilename": "holo", "time": "01Jan2026_000000", "VersionStr": "v0.5.3"});
        let object =
            json!({"GeneratedByInfo": by, "CamInfo": information, "LensletGridModel": model["LensletGridModel"]});
        format!("{object:#}\n")
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;
    use crate::CameraFile;

    /// Codes unpacked as the toolbox does it.
    #[test]
    fn packed_codes_are_unpacked_again() {
        let codes = Array2::from_shape_fn((3, 8), |(row, column)| (row * 371 + column * 119) as u16 % 1024);
        let bytes = LytroModel::Illum.packed(codes.view());
        let ten: Vec<u16> = bytes
            .chunks(5)
            .flat_map(|b| (0..4).map(|k| u16::from(b[k]) << 2 | u16::from(b[4]) >> (2 * k) & 3).collect::<Vec<_>>())
            .collect();
        assert_eq!(ten, codes.iter().copied().collect::<Vec<_>>());
        let bytes = LytroModel::F01.packed(codes.mapv(|code| code * 4 + 3).view());
        let twelve: Vec<u16> = bytes
            .chunks(3)
            .flat_map(|b| [u16::from(b[0]) << 4 | u16::from(b[1]) >> 4, u16::from(b[1] & 15) << 8 | u16::from(b[2])])
            .collect();
        assert_eq!(twelve, codes.iter().map(|code| code * 4 + 3).collect::<Vec<_>>());
        let whole = Array2::zeros((5368, 7728));
        assert_eq!(LytroModel::Illum.packed(whole.view()).len(), 51_854_880);
    }

    #[test]
    fn metadata_has_the_keys_that_the_toolbox_reads() {
        for (name, model, bits, order) in [("lytro-illum", "B01", 10, "little"), ("lytro-f01", "F01", 12, "big")] {
            let camera = CameraFile::preset(name).unwrap().camera;
            let lytro = LytroModel::of(&camera).unwrap();
            assert_eq!(u64::from(lytro.sensor().bits), bits);
            let white: Value = serde_json::from_str(&lytro.white_metadata(&camera)).unwrap();
            let frame = &white["master"]["picture"]["frameArray"][0]["frame"];
            assert_eq!(frame["metadata"]["camera"]["model"], model);
            let packing = &frame["metadata"]["image"]["rawDetails"]["pixelPacking"];
            assert_eq!((packing["bitsPerPixel"].as_u64(), packing["endianness"].as_str()), (Some(bits), Some(order)));
            let image: Value = serde_json::from_str(&lytro.image_metadata(&camera)).unwrap();
            let private: Value = serde_json::from_str(&lytro.private_metadata()).unwrap();
            assert_eq!(frame["privateMetadata"]["camera"], private["camera"]);
            assert_eq!(image["devices"]["lens"]["zoomStep"], frame["metadata"]["devices"]["lens"]["zoomStep"]);
            let grid = LensletGridModel::new(&camera).unwrap();
            let grid: Value = serde_json::from_str(&lytro.grid(&grid)).unwrap();
            assert!(grid["LensletGridModel"]["HSpacing"].as_f64().unwrap() > 9.0);
        }
        let other = CameraFile::preset("h3dv").unwrap().camera;
        assert!(LytroModel::of(&other).unwrap_err().to_string().contains("sensor.size_px"));
    }
}
