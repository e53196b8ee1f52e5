//! Cameras with published numbers.

use super::{
    ArrayFocus, Distortion, ImageSensor, LensAperture, MainLens, MicrolensArray, MicrolensFocus, MicrolensGrid,
    PlenopticCamera, PupilShape,
};
use crate::{Error, GridSize};

/// A camera with a name.
#[derive(Debug, Clone, Copy)]
pub struct Preset {
    /// The name on the command line.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Where the numbers come from.
    pub source: &'static str,
    /// Whether some numbers are guesses, because they are not published.
    pub is_approximate: bool,
    /// The name of its [sensor](crate::sensor::SensorPreset), if one with noise is known.
    pub sensor: Option<&'static str>,
    parts: fn() -> (ImageSensor, MicrolensArray, MainLens),
}

impl Preset {
    /// Returns the preset of this name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// Returns the camera.
    ///
    /// # Errors
    ///
    /// None: every preset is valid, which a test asserts. The error is that of [`PlenopticCamera::new`].
    pub fn camera(&self) -> Result<PlenopticCamera, Error> {
        let (sensor, array, main_lens) = (self.parts)();
        PlenopticCamera::new(sensor, array, main_lens)
    }
}

/// Returns all presets.
#[must_use]
pub const fn presets() -> &'static [Preset] {
    PRESETS
}

const PRESETS: &[Preset] = &[
    Preset {
        name: "lytro-f01",
        description: "Lytro F01, 2012: unfocused, hexagonal, 3280 x 3280 pixels",
        source: "metadata of a camera's file, in the tests of imageio; lens: OpenAccessSPC",
        is_approximate: false,
        sensor: Some("lytro-f01"),
        parts: || {
            let mut array = hexagonal(14.0e-6, 25e-6);
            (array.rotation_rad, array.scale_y, array.offset_m) = (-0.000_859, 1.000_373, [-8.18e-6, 0.80e-6]);
            let lens = MainLens { exit_pupil_m: Some(223.58e-3), ..MainLens::new(6.84e-3, 1.92, 0.5) };
            (ImageSensor::new(GridSize::new(3280, 3280), 1.4e-6), array, lens)
        },
    },
    Preset {
        name: "lytro-illum",
        description: "Lytro Illum, 2014: unfocused, hexagonal, 7728 x 5368 pixels",
        source: "metadata of a camera's file, in the tests of imageio; focal length of the microlenses: taken as the gap",
        is_approximate: true,
        sensor: Some("lytro-illum"),
        parts: || {
            let mut array = hexagonal(20e-6, 37e-6);
            (array.rotation_rad, array.scale_y, array.offset_m) = (-0.000_543, 1.000_343, [8.42e-6, -0.95e-6]);
            let lens = MainLens { exit_pupil_m: Some(97.2856e-3), ..MainLens::new(24.199e-3, 2.2, 0.5) };
            (ImageSensor::new(GridSize::new(5368, 7728), 1.4e-6), array, lens)
        },
    },
    Preset {
        name: "pleno-upcs",
        description: "a calibrated Lytro Illum: unfocused, hexagonal, exit pupil in the lens",
        source: "examples of the simulator PRISM, after Bok et al. (2017)",
        is_approximate: false,
        sensor: Some("lytro-illum"),
        parts: || {
            let mut lens = MainLens::new(9.984_45e-3, 2.0, 0.5);
            lens.focus = ArrayFocus::Distance { mla_distance_m: 9.8479e-3 };
            (ImageSensor::new(GridSize::new(5368, 7728), 1.4e-6), hexagonal(20e-6, 40.087e-6), lens)
        },
    },
    Preset {
        name: "raytrix-r12-a",
        description: "Raytrix R12: focused, hexagonal, three types of microlenses, 4080 x 3068 pixels",
        source: "calibration R12-A of Labussière et al. (2020), in the examples of libpleno",
        is_approximate: false,
        sensor: Some("cmv12000"),
        parts: || {
            // On the axis: the published translation is that of a corner of a tilted array.
            let mut array = hexagonal(127.455e-6, 338.416e-6);
            array.focus = MicrolensFocus::Lengths(vec![578.18e-6, 505.42e-6, 552.08e-6]);
            // Of the first two columns of its rotation, and B_0 and B_1: with x of the stored image opposite to libpleno's.
            array.tilt_rad = [-6.371e-4, 8.431e-4];
            let mut lens = MainLens::new(49.7145e-3, 4.0, 0.45);
            lens.focus = ArrayFocus::Distance { mla_distance_m: 56.6871e-3 };
            lens.distortion =
                Distortion { radial: [246.573, -2.998_40e6, 1.062_84e10], tangential: [-0.063_402, 0.145_853] };
            (ImageSensor::new(GridSize::new(3068, 4080), 5.5e-6), array, lens)
        },
    },
    Preset {
        name: "raytrix-r29",
        description: "Raytrix R29: focused, hexagonal, three types of microlenses, 6576 x 4384 pixels",
        source: "OpenAccessSPC for pitch and gap; focal lengths: for virtual depths of 2, 3 and 5",
        is_approximate: true,
        sensor: None,
        parts: || {
            let gap = 1.2e-3;
            let mut array = hexagonal(171e-6, gap);
            array.focus = MicrolensFocus::Lengths([2.0, 3.0, 5.0].map(|v| gap * v / (v - 1.0)).to_vec());
            let mut lens = MainLens::new(50e-3, 7.0, 0.6);
            lens.focus = ArrayFocus::Depth { depth_m: 0.6, virtual_depth: 2.0 };
            (ImageSensor::new(GridSize::new(4384, 6576), 5.5e-6), array, lens)
        },
    },
    Preset {
        name: "raytrix-r8",
        description: "Raytrix R8: focused, hexagonal in columns, three types of microlenses, 3840 x 2160 pixels",
        source: "size and arrangement: MPEG's scripts for lenslet video; the optics are those of the R12, scaled",
        is_approximate: true,
        sensor: None,
        parts: || {
            // 185 / 127.455 times those of the R12.
            let mut array = MicrolensArray::new(MicrolensGrid::HexColumns, 185e-6, 471.4e-6);
            array.focus = MicrolensFocus::Lengths(vec![839.2e-6, 733.6e-6, 801.3e-6]);
            let mut lens = MainLens::new(49.7145e-3, 4.0, 0.45);
            lens.focus = ArrayFocus::Distance { mla_distance_m: 56.7007e-3 };
            (ImageSensor::new(GridSize::new(2160, 3840), 5.5e-6), array, lens)
        },
    },
    Preset {
        name: "hahne-arri",
        description: "plenoptic camera of a 193 mm lens and an Arri sensor: unfocused, square, 4008 x 2672 pixels",
        source: "constants of PlenoptiSign; Hahne et al. (2018)",
        is_approximate: false,
        sensor: None,
        parts: || {
            let lens = MainLens { exit_pupil_m: Some(111.0324e-3), ..MainLens::new(193.2935e-3, 22.0, 4.0) };
            (ImageSensor::new(GridSize::new(2672, 4008), 9e-6), square(125e-6, 2.75e-3), lens)
        },
    },
    Preset {
        name: "h3dv",
        description: "holoscopic camera of square micro-images, 28 x 28 of 1920 x 1088 pixels",
        source: "sizes of the light field \"Plane and Toy\"; the optics are not published",
        is_approximate: true,
        sensor: None,
        parts: || {
            // 28 pixels between micro-images that touch each other behind a square aperture of f/4.
            let pitch = 250e-6;
            let (focal, focus): (f64, f64) = (50e-3, 1.0);
            let distance = 1.0 / (1.0 / focal - 1.0 / focus);
            // The square pupil of width f / N is imaged to the pitch of the micro-images: d = P D / (A - P).
            let gap = pitch * distance / (focal / 4.0 - pitch);
            let mut array = MicrolensArray::new(MicrolensGrid::Square, pitch, gap);
            array.aperture = LensAperture::Square { half_width_m: pitch / 2.0 };
            array.focus = MicrolensFocus::Pupil;
            let lens = MainLens { aperture: PupilShape::Square, ..MainLens::new(focal, 4.0, focus) };
            // Half a pitch aside: an even number of microlenses.
            array.offset_m = [pitch / 2.0; 2];
            let pixel = pitch * (1.0 + gap / distance) / 28.0;
            (ImageSensor::new(GridSize::new(1088, 1920), pixel), array, lens)
        },
    },
    Preset {
        name: "focused-p45",
        description: "focused camera with a Phase One P45 back: Keplerian, square, 7240 x 5432 pixels",
        source: "Lumsdaine and Georgiev (2009); sizes of the image \"Laura\"",
        is_approximate: true,
        sensor: None,
        parts: || {
            let mut array = square(500e-6, 1.6e-3);
            array.focus = MicrolensFocus::Lengths(vec![1.5e-3]);
            let mut lens = MainLens::new(80e-3, 4.0, 3.0);
            lens.focus = ArrayFocus::Depth { depth_m: 3.0, virtual_depth: -15.0 };
            (ImageSensor::new(GridSize::new(5432, 7240), 6.8e-6), array, lens)
        },
    },
    Preset {
        name: "home-made",
        description: "a camera for tutorials: unfocused, square, 6000 x 4000 pixels",
        source: "plausible numbers of a full-frame camera with an array glued in front of its sensor",
        is_approximate: true,
        sensor: None,
        parts: || {
            (
                ImageSensor::new(GridSize::new(4000, 6000), 3.9e-6),
                square(150e-6, 1.0e-3),
                MainLens::new(50e-3, 6.4, 0.8),
            )
        },
    },
];

/// Round microlenses that touch each other, of a focal length equal to the gap.
fn hexagonal(pitch_m: f64, gap_m: f64) -> MicrolensArray {
    MicrolensArray::new(MicrolensGrid::HexRows, pitch_m, gap_m)
}

fn square(pitch_m: f64, gap_m: f64) -> MicrolensArray {
    MicrolensArray::new(MicrolensGrid::Square, pitch_m, gap_m)
}

#[cfg(test)]
mod tests {
    use super::super::PlenopticMode;
    use super::*;

    #[test]
    fn every_preset_is_a_camera_that_light_reaches() {
        for preset in presets() {
            let camera = preset.camera().unwrap_or_else(|error| panic!("{}: {error}", preset.name));
            assert_eq!(Preset::by_name(preset.name).map(|found| found.name), Some(preset.name));
            let center = camera.owner([0.0; 2]);
            let white = camera.lit_region(camera.micro_image_center_m(center), center).area_m2();
            assert!(white > 0.0, "{}", preset.name);
            let mode = camera.mode(0);
            let is_focused = ["raytrix-r12-a", "raytrix-r8", "raytrix-r29", "focused-p45"].contains(&preset.name);
            assert_eq!(mode != PlenopticMode::Unfocused, is_focused, "{}: {mode:?}", preset.name);
        }
        let pitch = Preset::by_name("h3dv").map(|preset| preset.camera().expect("valid").micro_image_pitch_px());
        assert!((pitch.expect("a preset") - 28.0).abs() < 1e-9);
        assert!(Preset::by_name("lytro").is_none());
    }
}
