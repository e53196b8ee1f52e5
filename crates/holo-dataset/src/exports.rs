//! The raw image of a plenoptic camera for other programs: a folder for each, with images and calibration.

use holo_core::DynImageRef;
use holo_core::color::linear_to_srgb;
use holo_core::plenoptic::PlenopticCamera;
use holo_io::interop::{LensletGridModel, plenopticam_calibration};
use holo_io::{ColorEncoding, Compression, write_file, write_png, write_tiff};
use ndarray::{Array2, Array3, ArrayView3, Axis, Zip};

use crate::Error;
use crate::output_folder::OutputFolder;

/// A program that a raw image is also written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// The Light Field Toolbox for MATLAB by D. Dansereau: the raw image behind a Bayer filter, the white image, its grid
    /// model and a script.
    LfToolbox,
    /// PlenoptiCam by C. Hahne: raw image, white image and the calibration file.
    PlenoptiCam,
}

impl Tool {
    /// Returns the name on the command line and of the folder.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LfToolbox => "lftoolbox",
            Self::PlenoptiCam => "plenopticam",
        }
    }

    /// The texts of a camera: names and contents.
    fn texts(self, camera: &PlenopticCamera) -> Result<Vec<(&'static str, String)>, String> {
        match self {
            Self::LfToolbox => {
                let grid = LensletGridModel::new(camera)?;
                Ok(vec![
                    ("raw.grid.json", grid.to_json()),
                    ("decode.m", grid.script()),
                    ("README.txt", LFTOOLBOX_README.into()),
                ])
            }
            Self::PlenoptiCam => {
                let readme = PLENOPTICAM_README.replace("PATCH", &odd_patch(camera).to_string());
                Ok(vec![("calibration.json", plenopticam_calibration(camera)?), ("README.txt", readme)])
            }
        }
    }

    /// Checks that the program can read images of a camera.
    pub(crate) fn check(self, camera: &PlenopticCamera) -> Result<(), Error> {
        self.texts(camera).map(drop).map_err(|why| Error::BadRequest(format!("--for {}: {why}", self.name())))
    }

    /// Writes its folder: `color` and `white` in linear light, with the exposure that makes codes of 16 bits of the color.
    pub(crate) fn write(
        self,
        folder: &mut OutputFolder,
        camera: &PlenopticCamera,
        color: ArrayView3<f32>,
        white: &Array2<f32>,
        exposure_ev: f64,
    ) -> Result<(), Error> {
        let name = |file: &str| format!("{}/{file}", self.name());
        folder.subfolder(self.name())?;
        for (file, text) in self.texts(camera).map_err(Error::BadRequest)? {
            let name = name(file);
            folder.add(name.clone(), write_file(folder.file(&name), text.as_bytes())?);
        }
        // The brightest white is 1, and a pixel that sees an evenly bright scene has the white's value times its radiance.
        let brightest = white.iter().fold(0.0f32, |most, &light| most.max(light)).max(f32::MIN_POSITIVE);
        let scale = exposure_ev.exp2() as f32 / brightest;
        let white = white.mapv(|light| code(f64::from(light / brightest))).insert_axis(Axis(2));
        match self {
            Self::LfToolbox => {
                let size = (color.dim().0, color.dim().1, 1);
                // GRBG: the filter of the Illum.
                let filter = [[1, 0], [2, 1]];
                let mosaic = Array3::from_shape_fn(size, |(row, column, _)| {
                    code(f64::from(color[[row, column, filter[row % 2][column % 2]]] * scale))
                });
                for (file, image) in [("raw.png", mosaic), ("white.png", white)] {
                    let name = name(file);
                    let path = folder.file(&name);
                    folder.add(name, write_png(path, image.view(), ColorEncoding::Linear, Compression::Best)?);
                }
            }
            Self::PlenoptiCam => {
                let mut raw = Array3::zeros(color.dim());
                Zip::from(&mut raw).and(color).par_for_each(|raw, &value| *raw = srgb_code(value * scale));
                let white = ndarray::concatenate![Axis(2), white, white, white];
                for (file, image) in [("raw.tiff", raw), ("white.tiff", white)] {
                    let name = name(file);
                    let path = folder.file(&name);
                    folder.add(name, write_tiff(path, DynImageRef::from(image.view()))?);
                }
            }
        }
        Ok(())
    }
}

/// A linear value from 0 to 1 as 16 bits.
fn code(value: f64) -> u16 {
    (value * 65_535.0).round().clamp(0.0, 65_535.0) as u16
}

/// The same on the sRGB curve, which PlenoptiCam removes from raw images.
fn srgb_code(value: f32) -> u16 {
    code(linear_to_srgb(f64::from(value)))
}

/// The largest odd number of pixels within a micro-image.
fn odd_patch(camera: &PlenopticCamera) -> usize {
    let half = ((camera.micro_image_pitch_px() - 1.0) / 2.0).floor().max(1.0);
    2 * half as usize + 1
}

const LFTOOLBOX_README: &str = "\
Light Field Toolbox (LFToolbox 0.5, D. Dansereau), MATLAB or Octave:

    decode.m            writes lightfield.mat with LF(t,s,v,u,c), run in this folder with the toolbox on the path

raw.png             raw image, linear, 16 bits, behind a Bayer filter (grbg), without noise
white.png           white image, 1 is the brightest pixel
raw.grid.json       LensletGridModel of the camera, as LFBuildLensletGridModel would find it
";

const PLENOPTICAM_README: &str = "\
PlenoptiCam 0.9 (C. Hahne), Python:

    plenopticam -f raw.tiff -c white.tiff --meta=calibration.json --patch=PATCH --vign

raw.tiff            raw image on the sRGB curve, 16 bits
white.tiff          white image, linear, 1 is the brightest pixel
calibration.json    centers of the micro-images; without --meta the program looks for them in the white image
";
