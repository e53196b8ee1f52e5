//! What plenpy needs to know of a camera.

use holo_core::plenoptic::{MicrolensGrid, PlenopticCamera};
use serde_json::json;

use crate::Error;

/// The focus distance, in meters, that stands for infinity.
const FAR_M: f64 = 1e9;

/// Returns the JSON file that plenpy 0.9 wants beside images and white images, and a script that decodes them, for the class
/// `RayTracerLF`.
///
/// # Units
///
/// Meters and pixels.
///
/// # Errors
/// [`Error::Camera`] if the array is no hexagonal grid of rows.
pub fn plenpy_files(camera: &PlenopticCamera) -> Result<[String; 2], Error> {
    if camera.array().grid != MicrolensGrid::HexRows {
        return Err(Error::Camera("plenpy decodes hexagonal grids of rows only; mla.grid is another".into()));
    }
    let focus_m = camera.inverse_focus_per_m().recip();
    let focus_m = if focus_m.is_finite() { focus_m } else { FAR_M };
    let json = json!({"camera": {"imageDistance": camera.exit_pupil_m(), "focusDistance": focus_m}});
    let script = format!(
        "# Decodes Images/raw.png with Calibration/WhiteImages/white.png: run in this folder, with plenpy 0.9.\n\
         from plenpy.cameras.raytracer_lightfield_camera import RayTracerLF\n\n\
         def main():\n    \
             camera = RayTracerLF(\".\", grid_type=\"hex\", ml_size={:?}, ml_focal_length={:?}, format=\"PNG-PIL\")\n    \
             camera.calibrate(method=\"own\", force=True)\n    \
             camera.load_sensor_image(0)\n    \
             camera.decode_sensor_image(0, resample_method=\"bilinear\")\n    \
             print(camera.get_decoded_image(0).shape)\n\n\n\
         # Plenpy starts processes that import this file.\n\
         if __name__ == \"__main__\":\n    \
             main()\n",
        camera.micro_image_pitch_px(),
        camera.array().gap_m
    );
    Ok([format!("{json:#}\n"), script])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFile;

    #[test]
    fn numbers_are_those_of_the_camera() {
        let camera = CameraFile::preset("lytro-illum").unwrap().camera;
        let [text, script] = plenpy_files(&camera).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!((value["camera"]["imageDistance"].as_f64().unwrap() - 0.097_285_6).abs() < 1e-9);
        assert!((value["camera"]["focusDistance"].as_f64().unwrap() - 0.5).abs() < 1e-9);
        assert!(script.contains("ml_size=14.29"), "{script}");
        assert!(script.contains("\ndef main():\n    camera = ") && script.ends_with("\n    main()\n"), "{script}");
        // The magnification of plenpy is that of the camera.
        let magnification = 1.0 + camera.array().gap_m / value["camera"]["imageDistance"].as_f64().unwrap();
        assert!((magnification - camera.micro_image_scale()).abs() < 1e-12);
        assert!(plenpy_files(&CameraFile::preset("h3dv").unwrap().camera).is_err());
    }
}
