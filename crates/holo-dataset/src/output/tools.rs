//! Raw images of plenoptic cameras for other programs: a folder each, with their calibration and a README.txt.

mod readme;

use holo_core::color::linear_to_srgb;
use holo_core::plenoptic::PlenopticCamera;
use holo_core::sensor::{Exposure, SensorModel};
use holo_core::{ColorEncoding, DynImageRef};
use holo_io::interop::{
    LensletGridModel, Libpleno, LytroModel, pip_configuration, plenopticam_calibration, plenpy_files,
    raytrix_calibration,
};
use holo_io::{Compression, write_file, write_png, write_tiff};
use ndarray::{Array2, Array3, ArrayView3, Axis, Zip};

use super::folder::OutputFolder;
use crate::Error;
use crate::settings::Tool;

/// The least light of a white image that a raw image is divided by.
const LEAST_LIGHT: f32 = 0.02;

/// The f-numbers of the white images for libpleno, relative to that of the camera.
const STOPS: [f64; 3] = [1.0, std::f64::consts::SQRT_2, 2.0];

/// The code of the brightest white for Lytro's cameras, relative to the largest.
const LYTRO_WHITE: f64 = 0.9;

/// The images of a camera in linear light: 1 is the brightest white, and a pixel that sees an evenly bright scene has the
/// white's value times its radiance.
struct Pictures<'a> {
    color: ArrayView3<'a, f32>,
    white: &'a Array2<f32>,
    /// Factors of both.
    scale: f32,
    white_scale: f32,
}

impl Tool {
    /// The texts of a camera: names and contents.
    fn texts(self, camera: &PlenopticCamera) -> Result<Vec<(&'static str, String)>, holo_io::Error> {
        let mut texts = match self {
            Self::LfToolbox => {
                let grid = LensletGridModel::new(camera)?;
                vec![("raw.grid.json", grid.to_json()), ("decode.m", grid.script())]
            }
            Self::PlenoptiCam => vec![("calibration.json", plenopticam_calibration(camera)?)],
            Self::Libpleno => {
                let files = Libpleno::new(camera)?;
                let whites: Vec<_> =
                    stopped(camera)?.into_iter().map(|(name, stop)| (name, stop.main_lens().f_number)).collect();
                vec![
                    ("intrinsics.js", files.intrinsics),
                    ("params.js", files.parameters),
                    ("images.js", Libpleno::images(&whites, "raw.png")),
                ]
            }
            Self::Pip => vec![("MLAconfig.xml", pip_configuration(camera)?)],
            Self::Raytrix => vec![("raw.xml", raytrix_calibration(camera)?)],
            Self::Plenpy => {
                let [metadata, script] = plenpy_files(camera)?;
                vec![
                    ("Images/raw.json", metadata.clone()),
                    ("Calibration/WhiteImages/white.json", metadata),
                    ("decode.py", script),
                ]
            }
            Self::Lytro => {
                let model = LytroModel::of(camera)?;
                let grid = LensletGridModel::new(camera)?;
                vec![
                    ("Cameras/HOLO000001/WhiteImages/MOD_0000.TXT", model.white_metadata(camera)),
                    ("Cameras/HOLO000001/WhiteImages/MOD_0000.grid.json", model.grid(&grid)),
                    ("Images/IMG_0001__frame_metadata.json", model.image_metadata(camera)),
                    ("Images/IMG_0001__frame_private_metadata.json", model.private_metadata()),
                ]
            }
        };
        texts.push(("README.txt", readme::text(self, camera)));
        Ok(texts)
    }

    /// Checks that the program can read images of a camera.
    pub(crate) fn check(self, camera: &PlenopticCamera) -> Result<(), Error> {
        self.texts(camera).map(drop).map_err(|why| Error::BadRequest(format!("`for {}`: {why}", self.name())))
    }

    /// Writes its folder below `inner`, a folder with `/` at its end, or "": `color` and `white` in linear light, with the
    /// exposure that makes codes of 16 bits of the color.
    pub(crate) fn write(
        self,
        (folder, inner): (&mut OutputFolder, &str),
        camera: &PlenopticCamera,
        color: ArrayView3<f32>,
        white: &Array2<f32>,
        exposure_ev: f64,
    ) -> Result<(), Error> {
        let own = format!("{inner}{}", self.name());
        let name = |file: &str| format!("{own}/{file}");
        folder.subfolder(&own)?;
        for (file, text) in self.texts(camera).map_err(refused)? {
            if let Some((parent, _)) = file.rsplit_once('/') {
                folder.subfolder(&name(parent))?;
            }
            let name = name(file);
            folder.add(name.clone(), write_file(folder.file(&name), text.as_bytes())?);
        }
        let brightest = white.iter().fold(0.0f32, |most, &light| most.max(light)).max(f32::MIN_POSITIVE);
        let scale = exposure_ev.exp2() as f32 / brightest;
        let pictures = Pictures { color, white, scale, white_scale: 1.0 / brightest };
        let mut png = |file: &str, image: DynImageRef<'_>, encoding: ColorEncoding| -> Result<(), Error> {
            let name = name(file);
            let path = folder.file(&name);
            folder.add(name, write_png(path, image, encoding, Compression::Best)?);
            Ok(())
        };
        let linear = ColorEncoding::Linear;
        match self {
            Self::LfToolbox => {
                png("raw.png", pictures.mosaic().view().into(), linear)?;
                png("white.png", pictures.white_codes().view().into(), linear)?;
            }
            Self::Pip => {
                png("raw.png", pictures.rgb(code).view().into(), linear)?;
                png("white.png", tripled(&pictures.white_codes()).view().into(), linear)?;
            }
            Self::Plenpy => {
                png("Images/raw.png", pictures.rgb(byte).view().into(), linear)?;
                let white = pictures.white_codes().mapv(|code| byte(f64::from(code) / 65_535.0));
                png("Calibration/WhiteImages/white.png", tripled(&white).view().into(), linear)?;
            }
            Self::Raytrix => png("raw.png", pictures.without_vignetting().view().into(), ColorEncoding::Srgb)?,
            Self::Libpleno => {
                png("raw.png", pictures.rgb(byte).view().into(), linear)?;
                for (file, stopped) in stopped(camera).map_err(refused)? {
                    let white = stopped.white_image()?;
                    let brightest = white.iter().fold(f32::MIN_POSITIVE, |most, &light| most.max(light));
                    let codes = white.mapv(|light| byte(f64::from(light / brightest))).insert_axis(Axis(2));
                    png(&file, tripled(&codes).view().into(), linear)?;
                }
            }
            Self::PlenoptiCam => {
                let white = tripled(&pictures.white_codes());
                for (file, image) in [("raw.tiff", pictures.rgb(srgb_code)), ("white.tiff", white)] {
                    let name = name(file);
                    let path = folder.file(&name);
                    folder.add(name, write_tiff(path, DynImageRef::from(image.view()))?);
                }
            }
            Self::Lytro => {
                let model = LytroModel::of(camera).map_err(refused)?;
                let [raw, white] = pictures.lytro_codes(&model.sensor())?;
                for (file, codes) in
                    [("Images/IMG_0001__frame.raw", raw), ("Cameras/HOLO000001/WhiteImages/MOD_0000.RAW", white)]
                {
                    let name = name(file);
                    let packed = model.packed(codes.index_axis(Axis(2), 0));
                    folder.add(name.clone(), write_file(folder.file(&name), &packed)?);
                }
            }
        }
        Ok(())
    }
}

impl Pictures<'_> {
    /// Color in codes.
    fn rgb<T: Clone + Default + Send>(&self, code: fn(f64) -> T) -> Array3<T> {
        let mut image = Array3::from_elem(self.color.dim(), T::default());
        Zip::from(&mut image).and(self.color).par_for_each(|out, &value| *out = code(f64::from(value * self.scale)));
        image
    }

    /// Codes behind a Bayer filter in the order GRBG, that of the Illum.
    fn mosaic(&self) -> Array3<u16> {
        let filter = [[1, 0], [2, 1]];
        Array3::from_shape_fn((self.color.dim().0, self.color.dim().1, 1), |(row, column, _)| {
            code(f64::from(self.color[[row, column, filter[row % 2][column % 2]]] * self.scale))
        })
    }

    fn white_codes(&self) -> Array3<u16> {
        self.white.mapv(|light| code(f64::from(light * self.white_scale))).insert_axis(Axis(2))
    }

    /// Color divided by the white image, on the sRGB curve.
    fn without_vignetting(&self) -> Array3<u8> {
        let mut image = Array3::zeros(self.color.dim());
        Zip::indexed(&mut image).and(self.color).par_for_each(|(row, column, _), out, &value| {
            let light = self.white[[row, column]] * self.white_scale;
            if light >= LEAST_LIGHT {
                *out = byte(linear_to_srgb(f64::from(value * self.scale / light)));
            }
        });
        image
    }

    /// The codes of a Lytro's sensor, without noise: of the scene and of an even white.
    fn lytro_codes(&self, sensor: &SensorModel) -> Result<[Array3<u16>; 2], Error> {
        // A white surface as the most sensitive color sees it.
        let most = sensor.camera_from_rgb()?.iter().map(|row| row.iter().sum::<f64>()).fold(0.0, f64::max);
        let saturation = LYTRO_WHITE * sensor.saturation_e(sensor.base_iso) / most;
        let codes = |image: ArrayView3<f32>, scale: f32| {
            let exposure = Exposure::new(saturation * f64::from(scale), sensor.base_iso);
            sensor.expose_without_noise(image, &Exposure { time_s: 0.0, ..exposure })
        };
        let white = self.white.view().insert_axis(Axis(2));
        Ok([codes(self.color, self.scale)?, codes(white, self.white_scale)?])
    }
}

/// The error of a camera that a program cannot read.
fn refused(why: holo_io::Error) -> Error {
    Error::BadRequest(why.to_string())
}

/// The cameras of white images for libpleno, with the names of these.
pub(crate) fn stopped(camera: &PlenopticCamera) -> Result<Vec<(String, PlenopticCamera)>, holo_io::Error> {
    let stop = |factor: f64| {
        let f_number = camera.main_lens().f_number * factor;
        let lens = camera.main_lens().with_f_number(f_number);
        let stopped = lens.and_then(|lens| PlenopticCamera::new(*camera.sensor(), camera.array().clone(), lens));
        Ok((format!("white_f{f_number:.3}.png"), stopped.map_err(|why| holo_io::Error::Camera(why.to_string()))?))
    };
    STOPS.into_iter().map(stop).collect()
}

fn tripled<T: Clone>(image: &Array3<T>) -> Array3<T> {
    let (rows, columns, _) = image.dim();
    Array3::from_shape_fn((rows, columns, 3), |(row, column, _)| image[[row, column, 0]].clone())
}

/// A linear value from 0 to 1 as 16 bits.
fn code(value: f64) -> u16 {
    (value * 65_535.0).round().clamp(0.0, 65_535.0) as u16
}

/// The same as 8 bits.
fn byte(value: f64) -> u8 {
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

/// As 16 bits on the sRGB curve, which PlenoptiCam removes from raw images.
fn srgb_code(value: f64) -> u16 {
    code(linear_to_srgb(value))
}
