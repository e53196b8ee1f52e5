//! The tables of a camera file, and the parts of a camera that they describe: those of a preset where keys are left out.

use holo_core::plenoptic::{
    ArrayFocus, Distortion, FocusGroup, LensAperture, MainLens, MicrolensArray, MicrolensFocus, MicrolensGrid,
    PlenopticCamera, Prescription, PupilShape, Stop,
};
use holo_core::{meters_to_millimeters, millimeters_to_meters};
use serde::Deserialize;

use super::checks::{finite, length, meters, missing, offset, positive};
use super::prescription::{Beside, SurfaceTable};

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct MlaTable {
    grid: Option<String>,
    pitch_um: Option<f64>,
    scale_y: Option<f64>,
    rotation_deg: Option<f64>,
    offset_um: Option<[f64; 2]>,
    tilt_deg: Option<[f64; 2]>,
    gap_um: Option<f64>,
    focal_um: Option<FocalLengths>,
    aperture: Option<ApertureTable>,
    gaps: Option<String>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected one to three numbers in mla.focal_um, or \"pupil\"")]
enum FocalLengths {
    Word(String),
    Lengths(Vec<f64>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ApertureTable {
    shape: String,
    width_um: f64,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct MainLensTable {
    focal_mm: Option<f64>,
    f_number: Option<f64>,
    aperture: Option<PupilTable>,
    exit_pupil_mm: Option<f64>,
    focus_m: Option<f64>,
    focus_virtual_depth: Option<f64>,
    pub mla_distance_mm: Option<f64>,
    stops: Option<Vec<StopTable>>,
    distortion: Option<DistortionTable>,
    prescription: Option<String>,
    scale_to_focal_mm: Option<f64>,
    close_to_f_number: Option<f64>,
    focus_group: Option<[usize; 2]>,
    surface: Option<Vec<SurfaceTable>>,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected \"round\", \"square\" or { blades = 7, rotation_deg = 10.0 } in main_lens.aperture"
)]
enum PupilTable {
    Word(String),
    Polygon(PolygonTable),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PolygonTable {
    blades: u8,
    #[serde(default)]
    rotation_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StopTable {
    distance_mm: f64,
    diameter_mm: f64,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct DistortionTable {
    radial_m2: [f64; 3],
    tangential_m: [f64; 2],
}

impl MlaTable {
    pub fn array(&self, base: Option<&PlenopticCamera>) -> Result<MicrolensArray, String> {
        let base = base.map(PlenopticCamera::array);
        let grid = match &self.grid {
            Some(name) => [MicrolensGrid::Square, MicrolensGrid::HexRows, MicrolensGrid::HexColumns]
                .into_iter()
                .find(|&grid| grid_name(grid) == name)
                .ok_or_else(|| format!("mla.grid is '{}'; give square, hex-rows or hex-columns", crate::shown(name)))?,
            None => base.map(|base| base.grid).ok_or_else(|| missing("mla.grid"))?,
        };
        let pitch_m = length("mla.pitch_um", self.pitch_um, base.map(|base| base.pitch_m))?;
        let gap_m = length("mla.gap_um", self.gap_um, base.map(|base| base.gap_m))?;
        let mut array = MicrolensArray::new(grid, pitch_m, gap_m);
        array.scale_y = positive("mla.scale_y", self.scale_y.or(base.map(|base| base.scale_y)).unwrap_or(1.0))?;
        let degrees = self.rotation_deg.map(f64::to_radians).or(base.map(|base| base.rotation_rad));
        array.rotation_rad = finite("mla.rotation_deg", degrees.unwrap_or(0.0))?;
        array.offset_m = offset("mla.offset_um", self.offset_um, base.map(|base| base.offset_m))?;
        match (&self.focal_um, base) {
            (Some(FocalLengths::Word(word)), _) if word == "pupil" => array.focus = MicrolensFocus::Pupil,
            (Some(FocalLengths::Word(word)), _) => {
                return Err(format!("mla.focal_um is '{word}'; give one to three numbers, or \"pupil\""));
            }
            (Some(FocalLengths::Lengths(lengths)), _) => {
                if !(1..=3).contains(&lengths.len()) {
                    return Err(format!("mla.focal_um has {} numbers; give one to three", lengths.len()));
                }
                let lengths = lengths.iter().map(|&um| Ok(meters(positive("mla.focal_um", um)?)));
                array.focus = MicrolensFocus::Lengths(lengths.collect::<Result<_, String>>()?);
            }
            // With another gap, the focal lengths of the preset stay.
            (None, Some(base)) => array.focus = base.focus.clone(),
            (None, None) => {}
        }
        match (&self.aperture, base) {
            (Some(aperture), _) => {
                let half_width_m = meters(positive("mla.aperture.width_um", aperture.width_um)?) / 2.0;
                array.aperture = match aperture.shape.as_str() {
                    "round" => LensAperture::Round { radius_m: half_width_m },
                    "square" => LensAperture::Square { half_width_m },
                    "hexagon" => LensAperture::Hexagon { half_width_m },
                    other => return Err(format!("mla.aperture.shape is '{other}'; give round, square or hexagon")),
                };
            }
            (None, Some(base)) if self.pitch_um.is_none() => array.aperture = base.aperture,
            _ => {}
        }
        array.tilt_rad = match (self.tilt_deg, base) {
            (Some([x, y]), _) => [finite("mla.tilt_deg", x)?.to_radians(), finite("mla.tilt_deg", y)?.to_radians()],
            (None, base) => base.map(|base| base.tilt_rad).unwrap_or_default(),
        };
        array.has_clear_gaps = match (self.gaps.as_deref(), base) {
            (Some("opaque"), _) => false,
            (Some("clear"), _) => true,
            (Some(other), _) => return Err(format!("mla.gaps is '{other}'; give opaque or clear")),
            (None, base) => base.is_some_and(|base| base.has_clear_gaps),
        };
        Ok(array)
    }
}

impl MainLensTable {
    pub fn lens(&self, base: Option<&PlenopticCamera>, beside: Beside) -> Result<MainLens, String> {
        let base = base.map(PlenopticCamera::main_lens);
        if let Some(prescription) = self.prescription(beside)? {
            // The focus of a preset is that of its own lens.
            return self.lens_of_glass(prescription, self.focus(None)?);
        }
        let millimeters =
            |key: &str, value: Option<f64>| value.map(|mm| positive(key, mm).map(millimeters_to_meters)).transpose();
        let focal = millimeters("main_lens.focal_mm", self.focal_mm)?.or(base.map(|base| base.focal_length_m));
        let focal_length_m = focal.ok_or_else(|| missing("main_lens.focal_mm"))?;
        let f_number = self.f_number.or(base.map(|base| base.f_number));
        let f_number = positive("main_lens.f_number", f_number.ok_or_else(|| missing("main_lens.f_number"))?)?;
        let exit_pupil_m =
            millimeters("main_lens.exit_pupil_mm", self.exit_pupil_mm)?.or(base.and_then(|base| base.exit_pupil_m));
        let aperture = match &self.aperture {
            None => base.map_or(PupilShape::Round, |base| base.aperture),
            Some(PupilTable::Polygon(table)) => PupilShape::Polygon {
                blades: table.blades,
                rotation_rad: finite("main_lens.aperture.rotation_deg", table.rotation_deg)?.to_radians(),
            },
            Some(PupilTable::Word(word)) if word == "round" => PupilShape::Round,
            Some(PupilTable::Word(word)) if word == "square" => PupilShape::Square,
            Some(PupilTable::Word(word)) => {
                return Err(format!("main_lens.aperture is '{word}'; give round, square or {{ blades = 7 }}"));
            }
        };
        let stops = match (&self.stops, base) {
            (Some(stops), _) => stops.iter().map(StopTable::stop).collect::<Result<_, _>>()?,
            (None, base) => base.map(|base| base.stops.clone()).unwrap_or_default(),
        };
        let distortion = match (&self.distortion, base) {
            (Some(table), _) => Distortion { radial: table.radial_m2, tangential: table.tangential_m },
            (None, base) => base.map(|base| base.distortion).unwrap_or_default(),
        };
        let focus = self.focus(base)?;
        let thin = MainLens::new(focal_length_m, f_number, 1.0);
        Ok(MainLens { focus, exit_pupil_m, aperture, stops, distortion, ..thin })
    }

    /// The lens of glass, if the table describes one.
    fn prescription(&self, beside: Beside) -> Result<Option<Prescription>, String> {
        let mut found = match (&self.prescription, &self.surface) {
            (Some(_), Some(_)) => return Err("main_lens.prescription and main_lens.surface: give one of them".into()),
            (None, None) => {
                let keys = [
                    ("scale_to_focal_mm", self.scale_to_focal_mm.is_some()),
                    ("close_to_f_number", self.close_to_f_number.is_some()),
                    ("focus_group", self.focus_group.is_some()),
                ];
                return match keys.iter().find(|(_, is_given)| *is_given) {
                    Some((key, _)) => Err(format!("main_lens.{key} belongs to a prescription, which is not given")),
                    None => Ok(None),
                };
            }
            (Some(name), None) => beside.prescription(name)?,
            (None, Some(surfaces)) => {
                let surfaces = surfaces.iter().zip(1..).map(|(surface, number)| surface.surface(number));
                let surfaces = surfaces.collect::<Result<Vec<_>, _>>().map_err(|why| format!("main_lens.{why}"))?;
                Prescription::new(surfaces).map_err(|why| format!("main_lens.surface: {why}"))?
            }
        };
        for (key, is_given) in [
            ("focal_mm", self.focal_mm.is_some()),
            ("f_number", self.f_number.is_some()),
            ("aperture", self.aperture.is_some()),
            ("exit_pupil_mm", self.exit_pupil_mm.is_some()),
            ("stops", self.stops.is_some()),
            ("distortion", self.distortion.is_some()),
        ] {
            if is_given {
                return Err(format!("main_lens.{key} follows from the prescription; remove it"));
            }
        }
        if let Some(mm) = self.scale_to_focal_mm {
            let focal_m = millimeters_to_meters(positive("main_lens.scale_to_focal_mm", mm)?);
            found = found.scaled_to(focal_m).map_err(|why| format!("main_lens.scale_to_focal_mm: {why}"))?;
        }
        if let Some(f_number) = self.close_to_f_number {
            found = found.stopped_down(f_number).map_err(|why| format!("main_lens.close_to_f_number: {why}"))?;
        }
        Ok(Some(found))
    }

    /// The lens of glass, focused as a whole or by a group of its surfaces.
    fn lens_of_glass(&self, lens: Prescription, focus: ArrayFocus) -> Result<MainLens, String> {
        const KEY: &str = "main_lens.focus_group";
        let Some([first, last]) = self.focus_group else { return Ok(MainLens::of_glass(lens, focus)) };
        let ArrayFocus::Depth { depth_m, virtual_depth } = focus else {
            return Err(format!("{KEY} belongs to main_lens.focus_m, which is not given"));
        };
        let count = lens.surfaces().len();
        if first < 1 || last < first || last > count {
            return Err(format!(
                "{KEY} is [{first}, {last}]; give the first and the last surface that move, of 1 to {count} from the scene"
            ));
        }
        let group = FocusGroup { surfaces: [first - 1, last - 1], at_infinity: lens };
        MainLens::of_glass_with_group(group, depth_m, virtual_depth).map_err(|why| format!("{KEY}: {why}"))
    }

    /// Where the lens is focused.
    fn focus(&self, base: Option<&MainLens>) -> Result<ArrayFocus, String> {
        let virtual_depth = finite("main_lens.focus_virtual_depth", self.focus_virtual_depth.unwrap_or(0.0))?;
        Ok(match (self.focus_m, self.mla_distance_mm) {
            (Some(_), Some(_)) => {
                return Err("main_lens.focus_m and main_lens.mla_distance_mm: give one of them".into());
            }
            (None, Some(mm)) => {
                if self.focus_virtual_depth.is_some() {
                    return Err("main_lens.focus_virtual_depth belongs to main_lens.focus_m, which is not given".into());
                }
                let mla_distance_m = millimeters_to_meters(positive("main_lens.mla_distance_mm", mm)?);
                ArrayFocus::Distance { mla_distance_m }
            }
            (Some(depth_m), None) if depth_m.is_nan() || depth_m == 0.0 => {
                return Err(format!("main_lens.focus_m is {depth_m}; give meters, or inf"));
            }
            (Some(depth_m), None) => ArrayFocus::Depth { depth_m, virtual_depth },
            (None, None) => match (base.map(|base| base.focus), self.focus_virtual_depth) {
                (Some(ArrayFocus::Depth { depth_m, .. }), Some(virtual_depth)) => {
                    ArrayFocus::Depth { depth_m, virtual_depth }
                }
                (Some(focus), None) => focus,
                _ => return Err(missing("main_lens.focus_m (or main_lens.mla_distance_mm)")),
            },
        })
    }
}

impl StopTable {
    fn stop(&self) -> Result<Stop, String> {
        Ok(Stop {
            distance_m: millimeters_to_meters(positive("main_lens.stops.distance_mm", self.distance_mm)?),
            diameter_m: millimeters_to_meters(positive("main_lens.stops.diameter_mm", self.diameter_mm)?),
        })
    }
}

/// The name of an arrangement of microlenses.
pub(super) fn grid_name(grid: MicrolensGrid) -> &'static str {
    match grid {
        MicrolensGrid::Square => "square",
        MicrolensGrid::HexRows => "hex-rows",
        MicrolensGrid::HexColumns => "hex-columns",
    }
}

/// Meters in micrometers.
pub(super) fn um(meters: f64) -> f64 {
    meters_to_millimeters(meters_to_millimeters(meters))
}
