//! Camera files from white images.

use std::path::PathBuf;

use holo_core::plenoptic::{Calibration, PlenopticCamera, mean_white_image};
use holo_io::CameraFile;
use ndarray::{Array2, Array3};

use super::linear_image::read_white;
use crate::Error;

/// A window of the image of centers: its side in pitches, and in the image, px.
const WINDOW_PITCHES: f64 = 6.0;
const WINDOW_PX: usize = 240;

/// The color of centers, sRGB.
const CENTER: [u8; 3] = [230, 40, 40];

/// What is known of a camera before it is calibrated.
#[derive(Clone, Debug)]
pub enum KnownCamera {
    /// All but its microlens array: pixels, gap, main lens.
    Camera(Box<CameraFile>),
    /// The width of a pixel, in meters.
    Pixel(f64),
}

/// A camera that was found by its white images.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Calibrated {
    /// The camera.
    pub camera: CameraFile,
    /// How well its micro-images are those of the white images.
    pub fit: Calibration,
    /// The mean of the white images.
    pub white: Array2<f32>,
}

impl Calibrated {
    /// Finds the microlens array of a camera by its white images of one f-number, EXR, PNG or TIFF of floats in linear light, or of a
    /// Lytro camera. Several have less noise than one. Colors are averaged.
    ///
    /// # Errors
    /// [`Error::Io`] if an image cannot be read; [`Error::Core`] if sizes differ; [`Error::Failed`] if there is no lattice of
    /// micro-images.
    pub fn from_white_images(paths: &[PathBuf], known: &KnownCamera) -> Result<Self, Error> {
        let white = mean_white_image(&paths.iter().map(|path| read_white(path)).collect::<Result<Vec<_>, _>>()?)?;
        let (name, fit) = match known {
            KnownCamera::Camera(file) => (file.name.clone(), file.camera.calibrated(white.view())?),
            KnownCamera::Pixel(pixel_m) => {
                ("calibrated".to_owned(), PlenopticCamera::of_white_image(white.view(), *pixel_m)?)
            }
        };
        let Some(fit) = fit else {
            let path = paths.first().map(|path| path.display().to_string()).unwrap_or_default();
            return Err(Error::Failed(format!(
                "{path}: it has no square or hexagonal lattice of micro-images, 4 px apart or more and a dozen a side; a \
                 white image shows an evenly bright surface, sharp or not, and more than a hundredth of it is lit: \
                 open the aperture if its spots are smaller"
            )));
        };
        let camera = match known {
            KnownCamera::Camera(file) => CameraFile { camera: fit.camera.clone(), ..(**file).clone() },
            KnownCamera::Pixel(_) => {
                CameraFile { name, camera: fit.camera.clone(), is_approximate: true, sensor_noise: None }
            }
        };
        Ok(Self { camera, fit, white })
    }

    /// Draws the centers of micro-images into nine windows of the white image: in the corners, the middles of the sides, and the
    /// middle. Codes on the sRGB curve, axes (row, column, RGB).
    #[must_use]
    pub fn image(&self) -> Array3<u8> {
        let camera = &self.fit.camera;
        let (rows, columns) = self.white.dim();
        let side = (WINDOW_PITCHES * camera.micro_image_pitch_px()).ceil() as usize;
        let side = side.clamp(1, rows.min(columns));
        let scale = (WINDOW_PX / side).max(1);
        let step = side * scale + scale;
        let brightest = self.white.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        let mut image = Array3::from_elem((3 * step - scale, 3 * step - scale, 3), 255);
        for place in 0..9 {
            let (down, right) = (place / 3, place % 3);
            let first = [down * (rows - side) / 2, right * (columns - side) / 2];
            let corner = [down * step, right * step];
            for v in 0..side * scale {
                for u in 0..side * scale {
                    let light = self.white[[first[0] + v / scale, first[1] + u / scale]];
                    let code = (255.0 * (light / brightest).clamp(0.0, 1.0).powf(1.0 / 2.2)) as u8;
                    (0..3).for_each(|c| image[[corner[0] + v, corner[1] + u, c]] = code);
                }
            }
            let rows_here = first[0]..first[0] + side;
            for line in camera.lens_lines(rows_here.clone()) {
                for lens in camera.lenses_on_line(line, rows_here.clone()) {
                    let [x, y] = camera.micro_image_center_px(lens);
                    let at = [y - first[0] as f64, x - first[1] as f64].map(|a| (a * scale as f64).floor() as isize);
                    for arm in -3..=3_isize {
                        for [v, u] in [[at[0] + arm, at[1]], [at[0], at[1] + arm]] {
                            let end = (side * scale) as isize;
                            if (0..end).contains(&v) && (0..end).contains(&u) {
                                for (c, code) in CENTER.into_iter().enumerate() {
                                    image[[corner[0] + v as usize, corner[1] + u as usize, c]] = code;
                                }
                            }
                        }
                    }
                }
            }
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::GridSize;
    use holo_core::plenoptic::{ImageSensor, MainLens, MicrolensArray, MicrolensGrid};

    /// Each window has the white image of its place, marks have the color of centers, and what is between windows is white.
    #[test]
    fn windows_show_their_places() {
        let array = MicrolensArray::new(MicrolensGrid::Square, 62.3e-6, 3e-4);
        let sensor = ImageSensor::new(GridSize::new(420, 640), 4.4e-6);
        let camera = PlenopticCamera::new(sensor, array, MainLens::new(0.05, 5.0, 2.0)).unwrap();
        let mut white = camera.white_image().unwrap();
        // Every place has its own light.
        white
            .indexed_iter_mut()
            .for_each(|((row, column), light)| *light *= 0.4 + 1e-3 * row as f32 + 1e-4 * column as f32);
        let fit = camera.calibrated(white.view()).unwrap().unwrap();
        let camera = CameraFile { name: "a".into(), camera, is_approximate: true, sensor_noise: None };
        let calibrated = Calibrated { camera, fit, white };
        let (image, white) = (calibrated.image(), &calibrated.white);
        let side = (WINDOW_PITCHES * calibrated.fit.camera.micro_image_pitch_px()).ceil() as usize;
        let scale = WINDOW_PX / side;
        let step = (side + 1) * scale;
        assert_eq!(image.dim(), (3 * step - scale, 3 * step - scale, 3));
        let brightest = white.iter().copied().fold(0.0, f32::max);
        let mut marked = [0; 9];
        for ((row, column, c), &code) in image.indexed_iter() {
            let (place, within) = ([row / step, column / step], [row % step / scale, column % step / scale]);
            if within.contains(&side) {
                assert_eq!(code, 255, "{row} {column}");
            } else if image[[row, column, 0]] != image[[row, column, 1]] {
                assert_eq!(code, CENTER[c], "{row} {column}");
                marked[3 * place[0] + place[1]] += usize::from(c == 0);
            } else {
                let [v, u] = [(0, 420), (1, 640)].map(|(k, count)| place[k] * (count - side) / 2 + within[k]);
                let expected = 255.0 * (white[[v, u]] / brightest).powf(1.0 / 2.2);
                assert!((f32::from(code) - expected).abs() <= 1.0, "{row} {column}: {code} {expected}");
            }
        }
        // Five to seven centers a side, of 13 pixels each.
        assert!(marked.iter().all(|count| (13 * 5 * 5 - 200..=13 * 7 * 7).contains(count)), "{marked:?}");
    }
}
