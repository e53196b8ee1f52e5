//! The table `[sensor]` of a camera file: the geometry of the sensor, and its noise.

use std::fmt::Write as _;

use holo_core::GridSize;
use holo_core::plenoptic::{ImageSensor, PlenopticCamera};
use holo_core::sensor::{ColorFilter, ElectronsAtOne, SensorModel, SensorPreset, sensor_presets};
use serde::Deserialize;

use super::checks::{length, missing, offset, positive};
use super::{SensorNoise, suggestion};

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct SensorTable {
    size_px: Option<[usize; 2]>,
    pixel_um: Option<f64>,
    fill: Option<f64>,
    offset_um: Option<[f64; 2]>,
    model: Option<String>,
    cfa: Option<String>,
    bits: Option<u8>,
    black: Option<f64>,
    full_well_e: Option<f64>,
    read_noise_e: Option<f64>,
    dark_current_e_s: Option<f64>,
    prnu: Option<f64>,
    dsnu_e: Option<f64>,
    hot_share: Option<f64>,
    row_noise_e: Option<f64>,
    column_noise_e: Option<f64>,
    dn_per_e: Option<f64>,
    base_iso: Option<f64>,
    quantum_efficiency: Option<f64>,
    color_matrix: Option<[[f64; 3]; 3]>,
    white_balance: Option<[f64; 3]>,
    electrons_at_one: Option<ElectronsTable>,
}

#[derive(Deserialize, Clone)]
#[serde(
    untagged,
    expecting = "expected \"auto\", a number, or { luminance_cd_m2 = 1000, exposure_s = 0.01 } in sensor.electrons_at_one"
)]
enum ElectronsTable {
    Word(String),
    Number(f64),
    Photometric(PhotometricTable),
}

#[derive(Deserialize, Clone)]
#[serde(deny_unknown_fields)]
struct PhotometricTable {
    luminance_cd_m2: f64,
    exposure_s: f64,
    quantum_efficiency: Option<f64>,
}

impl SensorTable {
    pub fn sensor(&self, base: Option<&PlenopticCamera>) -> Result<ImageSensor, String> {
        let base = base.map(PlenopticCamera::sensor);
        let size = match self.size_px {
            Some([columns, rows]) => GridSize::new(rows, columns),
            None => base.map(|base| base.size).ok_or_else(|| missing("sensor.size_px"))?,
        };
        let pixel_m = length("sensor.pixel_um", self.pixel_um, base.map(|base| base.pixel_m))?;
        let fill = positive("sensor.fill", self.fill.or(base.map(|base| base.fill)).unwrap_or(1.0))?;
        let offset_m = offset("sensor.offset_um", self.offset_um, base.map(|base| base.offset_m))?;
        Ok(ImageSensor { size, pixel_m, fill, offset_m })
    }

    /// The noise: that of the model or preset, with the keys that are given; `None` where there is neither.
    pub fn noise(&self, base: Option<&SensorNoise>) -> Result<Option<SensorNoise>, String> {
        let numbers = [
            self.black,
            self.full_well_e,
            self.read_noise_e,
            self.dark_current_e_s,
            self.prnu,
            self.dsnu_e,
            self.hot_share,
            self.row_noise_e,
            self.column_noise_e,
            self.dn_per_e,
            self.base_iso,
            self.quantum_efficiency,
        ];
        let has_own = numbers.iter().any(Option::is_some)
            || self.cfa.is_some()
            || self.bits.is_some()
            || self.color_matrix.is_some()
            || self.white_balance.is_some()
            || self.electrons_at_one.is_some();
        let model = match &self.model {
            Some(name) => Some(SensorPreset::by_name(name).ok_or_else(|| {
                let names = sensor_presets().iter().map(|preset| preset.name);
                let all = names.clone().collect::<Vec<_>>().join(", ");
                let suggestion = suggestion(name, names);
                format!("sensor.model: there is none called '{}'{suggestion}; they are {all}", crate::shown(name))
            })?),
            None => None,
        };
        let mut noise = match (model, base) {
            (Some(preset), _) => SensorNoise::of(preset),
            (None, Some(base)) => *base,
            (None, None) if !has_own => return Ok(None),
            (None, None) => {
                let bits = self.bits.ok_or_else(|| missing("sensor.bits (or sensor.model)"))?;
                let full_well_e = self.full_well_e.ok_or_else(|| missing("sensor.full_well_e (or sensor.model)"))?;
                let cfa = self.cfa.as_deref().ok_or_else(|| missing("sensor.cfa (or sensor.model)"))?;
                let model = SensorModel::ideal(filter(cfa)?, bits, positive("sensor.full_well_e", full_well_e)?);
                SensorNoise { preset: None, model, electrons_at_one: ElectronsAtOne::Automatic }
            }
        };
        self.replace(&mut noise.model)?;
        if let Some(electrons) = &self.electrons_at_one {
            noise.electrons_at_one = electrons.electrons()?;
        }
        noise.model.validate().map_err(|why| format!("sensor: {why}"))?;
        Ok(Some(noise))
    }

    /// Replaces what is given.
    fn replace(&self, model: &mut SensorModel) -> Result<(), String> {
        if let Some(cfa) = &self.cfa {
            model.filter = filter(cfa)?;
        }
        model.bits = self.bits.unwrap_or(model.bits);
        let scale_changes = [self.black, self.full_well_e].iter().any(Option::is_some) || self.bits.is_some();
        let set = |own: &mut f64, given: Option<f64>| *own = given.unwrap_or(*own);
        set(&mut model.black, self.black);
        set(&mut model.full_well_e, self.full_well_e);
        set(&mut model.read_noise_e, self.read_noise_e);
        set(&mut model.dark_current_e_s, self.dark_current_e_s);
        set(&mut model.prnu, self.prnu);
        set(&mut model.dsnu_e, self.dsnu_e);
        set(&mut model.hot_share, self.hot_share);
        set(&mut model.row_noise_e, self.row_noise_e);
        set(&mut model.column_noise_e, self.column_noise_e);
        set(&mut model.base_iso, self.base_iso);
        set(&mut model.quantum_efficiency, self.quantum_efficiency);
        model.color_matrix = self.color_matrix.unwrap_or(model.color_matrix);
        model.white_balance = self.white_balance.unwrap_or(model.white_balance);
        // A full well reaches the largest code, unless the gain is given.
        if scale_changes {
            model.dn_per_e = (f64::from(model.white()) - model.black) / model.full_well_e;
        }
        set(&mut model.dn_per_e, self.dn_per_e);
        Ok(())
    }
}

impl ElectronsTable {
    fn electrons(&self) -> Result<ElectronsAtOne, String> {
        const KEY: &str = "sensor.electrons_at_one";
        match self {
            Self::Word(word) if word == "auto" => Ok(ElectronsAtOne::Automatic),
            Self::Word(word) => Err(format!("{KEY} is '{word}'; give auto, a number or a luminance")),
            Self::Number(number) => Ok(ElectronsAtOne::Given(positive(KEY, *number)?)),
            Self::Photometric(table) => Ok(ElectronsAtOne::Photometric {
                luminance_cd_m2: positive(&format!("{KEY}.luminance_cd_m2"), table.luminance_cd_m2)?,
                exposure_s: positive(&format!("{KEY}.exposure_s"), table.exposure_s)?,
                quantum_efficiency: table
                    .quantum_efficiency
                    .map(|share| positive(&format!("{KEY}.quantum_efficiency"), share))
                    .transpose()?,
            }),
        }
    }
}

fn filter(name: &str) -> Result<ColorFilter, String> {
    ColorFilter::ALL.into_iter().find(|filter| filter.name().eq_ignore_ascii_case(name)).ok_or_else(|| {
        let names = ColorFilter::ALL.map(ColorFilter::name).join(", ");
        format!("sensor.cfa is '{}'; give one of {names}", crate::shown(name))
    })
}

/// The lines of a camera file for the noise.
pub(super) fn noise_lines(noise: &SensorNoise) -> String {
    let SensorNoise { preset, model, electrons_at_one } = noise;
    let mut text = String::new();
    let mut line = |key: &str, value: String| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{key} = {value}");
    };
    if let Some(preset) = preset {
        line("model", format!("\"{preset}\""));
    }
    line("cfa", format!("\"{}\"", model.filter.name()));
    line("bits", model.bits.to_string());
    let numbers = [
        ("black", model.black),
        ("full_well_e", model.full_well_e),
        ("read_noise_e", model.read_noise_e),
        ("dark_current_e_s", model.dark_current_e_s),
        ("prnu", model.prnu),
        ("dsnu_e", model.dsnu_e),
        ("hot_share", model.hot_share),
        ("row_noise_e", model.row_noise_e),
        ("column_noise_e", model.column_noise_e),
        ("dn_per_e", model.dn_per_e),
        ("base_iso", model.base_iso),
        ("quantum_efficiency", model.quantum_efficiency),
    ];
    numbers.iter().for_each(|(key, value)| line(key, format!("{value:?}")));
    line("color_matrix", format!("{:?}", model.color_matrix));
    line("white_balance", format!("{:?}", model.white_balance));
    let electrons = match electrons_at_one {
        ElectronsAtOne::Automatic => "\"auto\"".into(),
        ElectronsAtOne::Given(electrons) => format!("{electrons:?}"),
        ElectronsAtOne::Photometric { luminance_cd_m2, exposure_s, quantum_efficiency } => {
            let share = quantum_efficiency.map_or(String::new(), |share| format!(", quantum_efficiency = {share:?}"));
            format!("{{ luminance_cd_m2 = {luminance_cd_m2:?}, exposure_s = {exposure_s:?}{share} }}")
        }
    };
    line("electrons_at_one", electrons);
    text
}
