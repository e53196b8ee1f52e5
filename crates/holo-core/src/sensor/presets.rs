//! Sensors with published numbers.

use super::{ColorFilter, SensorModel};

/// A sensor with a name.
#[derive(Debug, Clone, Copy)]
pub struct SensorPreset {
    /// The name on the command line.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Where the numbers come from.
    pub source: &'static str,
    /// The numbers that are not published, and guesses; empty if there are none.
    pub guesses: &'static str,
    /// The sensor.
    pub model: SensorModel,
}

impl SensorPreset {
    /// Returns the preset of this name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }
}

/// Returns all presets.
#[must_use]
pub const fn sensor_presets() -> &'static [SensorPreset] {
    PRESETS
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

const PRESETS: &[SensorPreset] = &[
    SensorPreset {
        name: "imx250",
        description: "Sony IMX250: 3.45 um, 12 bits, global shutter",
        source: "full well, read noise and gain: manual of the Moravian C1+; read noise 2.2 to 2.45 electrons",
        guesses: "dark current, PRNU, DSNU, hot pixels, black level, color matrix",
        model: SensorModel {
            filter: ColorFilter::Rggb,
            bits: 12,
            black: 60.0,
            full_well_e: 11_000.0,
            read_noise_e: 2.3,
            dark_current_e_s: 2.0,
            prnu: 0.005,
            dsnu_e: 1.0,
            hot_share: 1e-5,
            row_noise_e: 0.0,
            column_noise_e: 0.0,
            dn_per_e: 1.0 / 2.8,
            base_iso: 100.0,
            quantum_efficiency: 0.65,
            color_matrix: IDENTITY,
            white_balance: [1.0; 3],
        },
    },
    SensorPreset {
        name: "cmv12000",
        description: "CMOSIS CMV12000: 5.5 um, 12 bits, that of the Raytrix R12",
        source: "dark current and read noise: excerpts of the data sheet; 60 dB of dynamic range",
        guesses: "full well, quantum efficiency, PRNU, DSNU, hot pixels, row and column noise, black level, color matrix",
        model: SensorModel {
            filter: ColorFilter::Grbg,
            bits: 12,
            black: 0.0,
            full_well_e: 13_500.0,
            read_noise_e: 13.0,
            dark_current_e_s: 125.0,
            prnu: 0.013,
            dsnu_e: 5.0,
            hot_share: 1e-5,
            row_noise_e: 1.0,
            column_noise_e: 2.0,
            dn_per_e: 4095.0 / 13_500.0,
            base_iso: 100.0,
            quantum_efficiency: 0.5,
            color_matrix: IDENTITY,
            white_balance: [1.0; 3],
        },
    },
    SensorPreset {
        name: "lytro-illum",
        description: "that of the Lytro Illum: 1.4 um, 10 bits",
        source: "bits, black level, base film speed, color matrix and white balance: metadata of a camera's file, in the \
                 tests of imageio",
        guesses: "full well, read noise, dark current, quantum efficiency, PRNU, DSNU, hot pixels",
        model: SensorModel {
            filter: ColorFilter::Grbg,
            bits: 10,
            black: 64.0,
            full_well_e: 5_000.0,
            read_noise_e: 3.0,
            dark_current_e_s: 5.0,
            prnu: 0.01,
            dsnu_e: 1.0,
            hot_share: 1e-5,
            row_noise_e: 0.0,
            column_noise_e: 0.0,
            dn_per_e: 959.0 / 5_000.0,
            base_iso: 80.0,
            quantum_efficiency: 0.5,
            color_matrix: [
                [2.227_154_731_750_488_3, -1.055_293_321_609_497, -0.171_861_439_943_313_6],
                [-0.426_912_844_181_060_8, 1.745_861_768_722_534_2, -0.318_948_835_134_506_2],
                [-0.204_972_133_040_428_16, -0.746_992_468_833_923_3, 1.951_964_616_775_512_7],
            ],
            white_balance: [1.378_859_281_539_917, 1.0, 1.148_465_991_020_202_6],
        },
    },
    SensorPreset {
        name: "lytro-f01",
        description: "that of the Lytro F01: 1.4 um, 12 bits",
        source: "bits and black level: metadata of a camera's file, in the tests of imageio",
        guesses: "full well, read noise, dark current, quantum efficiency, PRNU, DSNU, hot pixels, gain, color matrix",
        model: SensorModel {
            filter: ColorFilter::Bggr,
            bits: 12,
            black: 168.0,
            full_well_e: 5_000.0,
            read_noise_e: 5.0,
            dark_current_e_s: 5.0,
            prnu: 0.01,
            dsnu_e: 1.0,
            hot_share: 1e-5,
            row_noise_e: 0.0,
            column_noise_e: 0.0,
            dn_per_e: 3927.0 / 5_000.0,
            base_iso: 80.0,
            quantum_efficiency: 0.5,
            color_matrix: IDENTITY,
            white_balance: [1.0; 3],
        },
    },
];
