//! The cameras of the benchmark, each behind a thin lens and behind glass.

use holo_core::GridSize;
use holo_core::plenoptic::Objective;
use holo_core::plenoptic::{
    ArrayFocus, ImageSensor, MainLens, MicrolensArray, MicrolensFocus, PlenopticCamera, Preset,
};
use holo_core::sensor::{ColorFilter, SensorModel, SensorPreset};
use holo_io::CameraFile;

use crate::Error;

/// A camera and its boards.
pub(super) struct Entry {
    pub name: &'static str,
    /// The preset whose sensor and array it has.
    preset: &'static str,
    /// The sensor with noise, without its color filter.
    sensor: &'static str,
    /// Focal length of the thin lens, mm, f-number, and the depth in focus, m.
    lens: [f64; 3],
    /// Where the image of that depth lies, in gaps behind the array.
    virtual_depth: f64,
    /// Whether the thin lens is that of the preset, with its distortion.
    has_lens_of_preset: bool,
    /// The objective of the lens of glass.
    objective: &'static str,
    /// Inner corners, columns and rows, and the side of a square of the full size, mm.
    corners: [usize; 2],
    square_mm: f64,
    /// The depths of boards, m.
    pub depths_m: [f64; 2],
}

/// Focus distances, boards and sizes of R12-A to D: README of the datasets of Labussière et al. (2020, 2022).
pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        name: "r12-a",
        preset: "raytrix-r12-a",
        sensor: "cmv12000",
        lens: [49.7145, 4.0, 0.45],
        virtual_depth: 2.0,
        has_lens_of_preset: true,
        objective: "double-gauss",
        corners: [9, 5],
        square_mm: 10.0,
        depths_m: [0.27, 0.37],
    },
    Entry {
        name: "r12-b",
        preset: "raytrix-r12-a",
        sensor: "cmv12000",
        lens: [50.0, 4.0, 1.0],
        virtual_depth: 2.0,
        has_lens_of_preset: false,
        objective: "double-gauss",
        corners: [8, 5],
        square_mm: 20.0,
        depths_m: [0.45, 0.85],
    },
    Entry {
        name: "r12-c",
        preset: "raytrix-r12-a",
        sensor: "cmv12000",
        lens: [50.0, 4.0, f64::INFINITY],
        virtual_depth: 2.0,
        has_lens_of_preset: false,
        objective: "double-gauss",
        corners: [6, 4],
        square_mm: 30.0,
        depths_m: [0.5, 1.25],
    },
    Entry {
        name: "r12-d",
        preset: "raytrix-r12-a",
        sensor: "cmv12000",
        lens: [135.0, 4.0, 1.5],
        virtual_depth: 2.0,
        has_lens_of_preset: false,
        objective: "telephoto",
        corners: [5, 3],
        square_mm: 20.0,
        depths_m: [0.9, 1.4],
    },
    Entry {
        name: "illum",
        preset: "lytro-illum",
        sensor: "lytro-illum",
        lens: [24.199, 2.2, 0.5],
        virtual_depth: 0.0,
        has_lens_of_preset: true,
        objective: "retrofocus",
        corners: [9, 6],
        square_mm: 10.0,
        depths_m: [0.27, 0.7],
    },
    Entry {
        name: "f01",
        preset: "lytro-f01",
        sensor: "lytro-f01",
        lens: [6.84, 2.05, 0.5],
        virtual_depth: 0.0,
        has_lens_of_preset: true,
        objective: "retrofocus",
        corners: [9, 6],
        square_mm: 10.0,
        depths_m: [0.17, 0.5],
    },
    Entry {
        name: "square",
        preset: "home-made",
        sensor: "cmv12000",
        lens: [50.0, 6.4, 0.8],
        virtual_depth: 0.0,
        has_lens_of_preset: false,
        objective: "double-gauss",
        corners: [5, 3],
        square_mm: 28.0,
        depths_m: [0.45, 1.0],
    },
];

/// What stands before the array.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Tier {
    /// A thin lens, which the models of calibrations can say.
    Thin,
    /// Glass, which they cannot.
    Glass,
}

impl Tier {
    pub const ALL: [Self; 2] = [Self::Thin, Self::Glass];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Thin => "thin",
            Self::Glass => "glass",
        }
    }
}

impl Entry {
    /// Inner corners, and the side of a square, in meters: half as large before half a sensor.
    pub fn board(&self, is_full: bool) -> (GridSize, f64) {
        let scale = if is_full { 1e-3 } else { 0.5e-3 };
        (GridSize::new(self.corners[1], self.corners[0]), scale * self.square_mm)
    }

    /// The sensor with noise, in gray.
    pub fn sensor(&self) -> Result<SensorModel, Error> {
        let preset = SensorPreset::by_name(self.sensor).ok_or_else(|| missing(self.sensor))?;
        Ok(SensorModel { filter: ColorFilter::Mono, ..preset.model })
    }

    fn preset(&self, is_full: bool) -> Result<(ImageSensor, PlenopticCamera), Error> {
        let camera = Preset::by_name(self.preset).ok_or_else(|| missing(self.preset))?.camera()?;
        let mut sensor = *camera.sensor();
        if !is_full {
            sensor.size = GridSize::new(sensor.size.rows / 2, sensor.size.columns / 2);
        }
        Ok((sensor, camera))
    }

    /// The true camera.
    pub fn camera(&self, tier: Tier, is_full: bool) -> Result<CameraFile, Error> {
        let (sensor, preset) = self.preset(is_full)?;
        let mut array = preset.array().clone();
        if array.rotation_rad == 0.0 {
            // The preset stands straight.
            let pitch_m = array.pitch_m;
            (array.rotation_rad, array.offset_m) = (1.3e-3, [0.21 * pitch_m, -0.37 * pitch_m]);
        }
        let [focal_mm, f_number, depth_m] = self.lens;
        let focus = ArrayFocus::Depth { depth_m, virtual_depth: self.virtual_depth };
        let lens = match tier {
            Tier::Thin if self.has_lens_of_preset => MainLens { f_number, ..preset.main_lens().clone() },
            Tier::Thin => MainLens { focus, ..MainLens::new(1e-3 * focal_mm, f_number, 1.0) },
            Tier::Glass => {
                let objective = Objective::by_name(self.objective).ok_or_else(|| missing(self.objective))?;
                let glass = objective.prescription()?.scaled_to(1e-3 * focal_mm)?.stopped_down(f_number)?;
                MainLens::of_glass(glass, focus)
            }
        };
        self.file(format!("{}-{}", self.name, tier.name()), PlenopticCamera::new(sensor, array, lens)?)
    }

    /// What a data sheet says of it: round numbers of a thin lens, and an array that stands straight before the middle of
    /// the sensor.
    pub fn data_sheet(&self, is_full: bool) -> Result<CameraFile, Error> {
        let (sensor, preset) = self.preset(is_full)?;
        let old = preset.array();
        let mut array = MicrolensArray::new(old.grid, rounded(old.pitch_m), rounded(old.gap_m));
        if let MicrolensFocus::Lengths(lengths) = &old.focus {
            array.focus = MicrolensFocus::Lengths(lengths.iter().map(|&length_m| rounded(length_m)).collect());
        }
        let [focal_mm, f_number, depth_m] = self.lens;
        let focus = ArrayFocus::Depth { depth_m, virtual_depth: self.virtual_depth };
        let lens = MainLens { focus, ..MainLens::new(rounded(1e-3 * focal_mm), f_number, 1.0) };
        self.file(format!("{}-data-sheet", self.name), PlenopticCamera::new(sensor, array, lens)?)
    }

    fn file(&self, name: String, camera: PlenopticCamera) -> Result<CameraFile, Error> {
        Ok(CameraFile { name, camera, is_approximate: true, sensor_noise: None })
    }
}

/// Two digits.
fn rounded(x: f64) -> f64 {
    let scale = 10f64.powf(1.0 - x.log10().floor());
    (x * scale).round() / scale
}

fn missing(name: &str) -> Error {
    Error::Failed(format!("'{name}' is not known"))
}
