//! The microlens array of a camera for PIP, the Plenoptic Image Processing of Kiel University.

use holo_core::meters_to_millimeters;
use holo_core::plenoptic::{MicrolensGrid, PlenopticCamera};

use crate::Error;

/// Returns `MLAconfig.xml` of PIP, which reads hexagonal grids only.
///
/// # Units
///
/// Pixels, the center of the first pixel being 0; millimeters; radians, counterclockwise.
///
/// # Errors
/// [`Error::Camera`] if the array is square: PIP takes every grid for hexagonal.
pub fn pip_configuration(camera: &PlenopticCamera) -> Result<String, Error> {
    let (array, sensor) = (camera.array(), camera.sensor());
    let rotation = match array.grid {
        MicrolensGrid::HexRows => array.rotation_rad,
        MicrolensGrid::HexColumns => array.rotation_rad + std::f64::consts::FRAC_PI_2,
        MicrolensGrid::Square => {
            return Err(Error::Camera("PIP takes every grid for hexagonal; mla.grid is square".into()));
        }
    };
    // Numbers of pixel centers; microlenses as they lie, not as the pupil projects them.
    let pixel = |place_m: [f64; 2]| camera.position_px(place_m).map(|x| x - 0.5);
    let axis = pixel([0.0; 2]);
    let lens = camera.owner([0.0; 2]);
    let center = pixel(camera.lens_center_m(lens));
    // A point or an exponent: whole numbers are not read as real ones.
    let real = |value: f64| format!("{value:.16e}");
    let pair = |[x, y]: [f64; 2]| format!("\n    {} {}", real(x), real(y));
    Ok(format!(
        "<?xml version=\"1.0\"?>\n<opencv_storage>\n<MlaDescription>\n  <IsHexGrid>1</IsHexGrid>\n  \
         <GridRotRAD>{}</GridRotRAD>\n  <MlaCenterPX>{}</MlaCenterPX>\n  <SensorResPX>\n    {} {}</SensorResPX>\n  \
         <MicroLensDistancePX>{}</MicroLensDistancePX>\n  <MainPrincipalPointPX>{}</MainPrincipalPointPX>\n  \
         <MlaImageScale>{}</MlaImageScale>\n  <MicroLensFocalLengthPX>{}</MicroLensFocalLengthPX>\n  \
         <MainLensFLengthMM>{}</MainLensFLengthMM>\n  <MainLensFDistMM>{}</MainLensFDistMM>\n  \
         <PixelsizeMM>{}</PixelsizeMM></MlaDescription>\n</opencv_storage>\n",
        real(rotation),
        pair(center),
        sensor.size.columns,
        sensor.size.rows,
        real(array.pitch_m / sensor.pixel_m),
        pair(axis),
        real(1.0 + array.gap_m / camera.exit_pupil_m()),
        real(array.gap_m / sensor.pixel_m),
        real(meters_to_millimeters(camera.main_lens().focal_length_m)),
        real(meters_to_millimeters(camera.mla_distance_m())),
        real(meters_to_millimeters(sensor.pixel_m)),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFile;

    /// Microlenses on the lattice of PIP, projected from the principal point, are the micro-images of the camera.
    #[test]
    fn the_lattice_is_that_of_the_camera() {
        for name in ["lytro-illum", "raytrix-r29", "raytrix-r8"] {
            let mut camera = CameraFile::preset(name).unwrap().camera;
            let mut array = camera.array().clone();
            (array.rotation_rad, array.scale_y) = (0.002, 1.0);
            camera = PlenopticCamera::new(*camera.sensor(), array, camera.main_lens().clone()).unwrap();
            let text = pip_configuration(&camera).unwrap();
            let numbers = |tag: &str| -> Vec<f64> {
                let inner = text.split(&format!("<{tag}>")).nth(1).unwrap().split('<').next().unwrap();
                inner.split_whitespace().map(|number| number.parse().unwrap()).collect()
            };
            let (center, axis) = (numbers("MlaCenterPX"), numbers("MainPrincipalPointPX"));
            let (pitch, scale) = (numbers("MicroLensDistancePX")[0], numbers("MlaImageScale")[0]);
            let (sin, cos) = (-numbers("GridRotRAD")[0]).sin_cos();
            for (i, j) in [(0, 0), (1, 0), (0, 1), (-7, 12), (20, -5)] {
                let base = [f64::from(i) + 0.5 * f64::from(j), 0.866_025_403_784_438_6 * f64::from(j)];
                let lens = [
                    center[0] + pitch * (cos * base[0] - sin * base[1]),
                    center[1] + pitch * (sin * base[0] + cos * base[1]),
                ];
                let at = [0, 1].map(|k| axis[k] + scale * (lens[k] - axis[k]) + 0.5);
                let found = camera.micro_image_center_px(camera.owner(camera.place_m(at)));
                assert!((found[0] - at[0]).hypot(found[1] - at[1]) < 1e-6, "{name} {i} {j}: {at:?} {found:?}");
            }
            for tag in ["MicroLensDistancePX", "MainLensFLengthMM", "PixelsizeMM"] {
                let inner = text.split(&format!("<{tag}>")).nth(1).unwrap();
                assert!(inner.split('<').next().unwrap().contains('.'), "{tag} is no real number to OpenCV");
            }
        }
        assert!(
            pip_configuration(&CameraFile::preset("h3dv").unwrap().camera).unwrap_err().to_string().contains("square")
        );
    }
}
