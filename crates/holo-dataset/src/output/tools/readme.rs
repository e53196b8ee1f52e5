//! The README.txt of the folder of each program.

use holo_core::plenoptic::PlenopticCamera;

use super::Tool;

/// What the folder has, and the command to run.
pub(super) fn text(tool: Tool, camera: &PlenopticCamera) -> String {
    match tool {
        Tool::LfToolbox => LFTOOLBOX.into(),
        Tool::PlenoptiCam => PLENOPTICAM.replace("PATCH", &odd_patch(camera).to_string()),
        Tool::Libpleno => LIBPLENO.into(),
        Tool::Pip => PIP.into(),
        Tool::Raytrix => RAYTRIX.replace("FARTHEST", &half_pitch(camera).to_string()),
        Tool::Plenpy => PLENPY.into(),
        Tool::Lytro => LYTRO.into(),
    }
}

/// The largest disparity that PlenopticToolbox2.0 looks for: half of a micro-image.
fn half_pitch(camera: &PlenopticCamera) -> usize {
    (camera.micro_image_pitch_px() / 2.0).ceil() as usize
}

/// The largest odd number of pixels within a micro-image.
fn odd_patch(camera: &PlenopticCamera) -> usize {
    let half = ((camera.micro_image_pitch_px() - 1.0) / 2.0).floor().max(1.0);
    2 * half as usize + 1
}

const LFTOOLBOX: &str = "\
Light Field Toolbox (LFToolbox 0.5, D. Dansereau), MATLAB or Octave:

    decode.m            writes lightfield.mat with LF(t,s,v,u,c), run in this folder with the toolbox on the path

raw.png             raw image, linear, 16 bits, behind a Bayer filter (grbg), without noise
white.png           white image, 1 is the brightest pixel
raw.grid.json       LensletGridModel of the camera, as LFBuildLensletGridModel would find it
";

const PLENOPTICAM: &str = "\
PlenoptiCam 0.9 (C. Hahne), Python:

    plenopticam -f raw.tiff -c white.tiff --meta=calibration.json --patch=PATCH --vign

raw.tiff            raw image on the sRGB curve, 16 bits
white.tiff          white image, linear, 1 is the brightest pixel
calibration.json    centers of the micro-images; without --meta the program looks for them in the white image
";

const LIBPLENO: &str = "\
libpleno and the programs on it (M. Labussiere): COMPOTE, BLADE, PRISM, run in this folder.
Written to their source (libpleno 48db282), not run.

    precalibrate -i images.js -c intrinsics.js -p params-found.js -g false

intrinsics.js       the whole camera: sensor, microlens array, main lens
params.js           the internal parameters that follow from it
images.js           the images
raw.png             raw image, linear, 8 bits
white_f*.png        white images of three f-numbers, linear, 8 bits, the brightest pixel is 255
";

const PIP: &str = "\
PIP, Plenoptic Image Processing (A. Petersen, Kiel University): in QtPlenopticTools open raw.png, white.png as the
vignetting image, and MLAconfig.xml by the menu Read MLA. It unprojects Galilean cameras.
Written to its source (f72013a), not run.

raw.png             raw image, linear, 16 bits
white.png           white image, 1 is the brightest pixel
MLAconfig.xml       microlens array and main lens
";

const RAYTRIX: &str = "\
PlenopticToolbox2.0 (L. Palmieri), in its folder python/samples:

    PYTHONPATH=.. python3 disparity_sample.py THIS_FOLDER/raw.xml -o OUT -dmin 1 -dmax FARTHEST -nd 32 -t sad -scene real

Tried with c0669ce on 1500 x 1100 px of a R29: it finds every micro-image and its type, and disparities.

raw.png             raw image divided by the white image, 8 bits on the sRGB curve
raw.xml             calibration in the form of Raytrix
";

const PLENPY: &str = "\
plenpy 0.9 (M. Schambach), Python: run decode.py in this folder.

Tried with plenpy 0.9.2 and numpy 1.24 (it fails with later ones) on 616 x 496 px of an Illum: it finds the grid in the
white image and decodes 13 x 13 views. It imports torch and torchvision, which it does not install and does not use here.

Images/raw.png                        raw image, linear, 8 bits
Calibration/WhiteImages/white.png     white image, 255 is the brightest pixel
*.json                                distances of the camera
";

const LYTRO: &str = "\
The files of a Lytro camera, for Light Field Toolbox (LFToolbox 0.5, D. Dansereau) under MATLAB, in this folder:

    LFMatlabPathSetup
    LFUtilProcessWhiteImages
    LFUtilDecodeLytroFolder

Written to its source (3bf4f55), not run as a whole; its decoder reads the same images by --for lftoolbox.

Cameras/*/WhiteImages/MOD_0000.RAW    white image, packed codes without noise
Images/IMG_0001__frame.raw            raw image, packed codes without noise
*.TXT, *.json                         metadata of both
";

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::plenoptic::presets;

    #[test]
    fn the_patch_is_the_largest_odd_number_within_a_micro_image() {
        for preset in presets() {
            let camera = preset.camera().unwrap();
            let (patch, pitch_px) = (odd_patch(&camera), camera.micro_image_pitch_px());
            assert!(patch % 2 == 1 && patch as f64 <= pitch_px && (patch + 2) as f64 > pitch_px, "{patch} {pitch_px}");
            assert!(
                half_pitch(&camera) as f64 >= pitch_px / 2.0 && (half_pitch(&camera) as f64) < pitch_px / 2.0 + 1.0
            );
        }
    }
}
