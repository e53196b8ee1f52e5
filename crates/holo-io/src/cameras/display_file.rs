//! Display files: a panel behind a sheet of lenses as TOML, or the calibration of a Looking Glass display.
//!
//! ```toml
//! name = "bench display"
//! [panel]
//! size_px = [3840, 2160]             # columns, rows
//! pixel_um = 62.5
//! stripes = "rgb"                    # bgr, none
//! [lenses]
//! grid = "square"                    # hex-rows, lenticular
//! pitch_mm = 1.0                     # lenticular: perpendicular to the lenses
//! gap_mm = 3.0                       # to the panel, in air: thickness over refractive index
//! focal_mm = 3.0                     # left out: the gap
//! slant_deg = 9.5                    # lenticular: the upper end leans to the left
//! offset_mm = [0.0, 0.0]             # of one lens from the middle of the panel, right and up
//! [viewer]
//! distance_m = 0.6                   # that all lenses show one view to; left out: far away
//! ```
//!
//! Left out, `stripes` is none, `slant_deg` and `offset_mm` 0.
//!
//! A Looking Glass display has its `visual.json` with `pitch` (lenses an inch), `slope`, `center`, `viewCone` (degrees), `DPI`,
//! `screenW` and `screenH`. The view of stripe i of the pixel at (x, y), in shares of the screen from its lower left corner, is
//! `1 - fract((x + i / (3 screenW) + y screenH / (screenW slope)) pitch screenW / DPI cos(atan(1 / slope)) - center)` of all
//! views, as its public shaders have it (HoloPlayCore, Looking Glass Factory); they have not been compared with a device.

use std::path::Path;

use holo_core::display::{Display, LensSheet, Panel, PixelStripes, SheetGrid};
use holo_core::{GridSize, millimeters_to_meters};
use serde::Deserialize;

use crate::Error;
use crate::cameras::camera_file::checks::{finite, length, positive};
use crate::cameras::camera_file::explained;
use crate::files::limits::read_small_file;

/// The largest display file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Meters in an inch.
const INCH_M: f64 = 0.0254;

/// A display with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayFile {
    /// The name; the serial number of a calibrated device; that of the file if it has none.
    pub name: String,
    /// The display.
    pub display: Display,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    name: Option<String>,
    panel: PanelTable,
    lenses: LensesTable,
    #[serde(default)]
    viewer: ViewerTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PanelTable {
    size_px: [usize; 2],
    pixel_um: f64,
    stripes: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LensesTable {
    grid: String,
    pitch_mm: f64,
    gap_mm: f64,
    focal_mm: Option<f64>,
    slant_deg: Option<f64>,
    offset_mm: Option<[f64; 2]>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct ViewerTable {
    distance_m: Option<f64>,
}

impl DisplayFile {
    /// Reads a display file, or the `visual.json` of a Looking Glass display.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read; [`Error::Broken`] if it is neither, or no display. The message names the key.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let bytes = read_small_file(path, MAX_BYTES)?;
        let broken = |what: String| Error::Broken { path: path.into(), format: "display", what };
        let text = std::str::from_utf8(&bytes).map_err(|_| broken("it is not text in UTF-8".into()))?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let is_calibration = text.trim_start().starts_with('{');
        let read = if is_calibration { Calibration::display(text, stem) } else { Document::display(text, stem) };
        read.map_err(broken)
    }
}

impl Document {
    fn display(text: &str, stem: String) -> Result<DisplayFile, String> {
        let document: Self = toml::from_str(text).map_err(|why| explained(&why))?;
        let [columns, rows] = document.panel.size_px;
        let stripes = match document.panel.stripes.as_deref() {
            None | Some("none") => PixelStripes::None,
            Some("rgb") => PixelStripes::Rgb,
            Some("bgr") => PixelStripes::Bgr,
            Some(other) => return Err(format!("panel.stripes is '{}'; give rgb, bgr or none", crate::shown(other))),
        };
        let panel = Panel {
            size: GridSize::new(rows, columns),
            pitch_m: length("panel.pixel_um", Some(document.panel.pixel_um), None)?,
            stripes,
        };
        let table = document.lenses;
        let slant_deg = table.slant_deg.map(|slant| finite("lenses.slant_deg", slant)).transpose()?;
        let grid = match (table.grid.as_str(), slant_deg) {
            ("lenticular", slant) => SheetGrid::Lenticular { slant_rad: slant.unwrap_or(0.0).to_radians() },
            ("square" | "hex-rows", Some(_)) => {
                return Err("lenses.slant_deg is for lenticular sheets; remove it".into());
            }
            ("square", None) => SheetGrid::Square,
            ("hex-rows", None) => SheetGrid::HexRows,
            (other, _) => {
                return Err(format!("lenses.grid is '{}'; give square, hex-rows or lenticular", crate::shown(other)));
            }
        };
        let millimeters = |key, mm| Ok::<_, String>(millimeters_to_meters(positive(key, mm)?));
        let gap_m = millimeters("lenses.gap_mm", table.gap_mm)?;
        let lenses = LensSheet {
            grid,
            pitch_m: millimeters("lenses.pitch_mm", table.pitch_mm)?,
            gap_m,
            focal_length_m: table.focal_mm.map_or(Ok(gap_m), |mm| millimeters("lenses.focal_mm", mm))?,
            offset_m: match table.offset_mm {
                Some([x, y]) => {
                    [finite("lenses.offset_mm", x)?, finite("lenses.offset_mm", y)?].map(millimeters_to_meters)
                }
                None => [0.0; 2],
            },
        };
        let distance_m = document.viewer.distance_m.map_or(Ok(f64::INFINITY), |z| positive("viewer.distance_m", z))?;
        let display = Display::new(panel, lenses, distance_m).map_err(|why| why.to_string())?;
        Ok(DisplayFile { name: document.name.unwrap_or(stem), display })
    }
}

/// The calibration of a Looking Glass display. Keys that play no part may be there.
#[derive(Deserialize)]
struct Calibration {
    serial: Option<String>,
    pitch: Number,
    slope: Number,
    center: Number,
    #[serde(rename = "viewCone")]
    view_cone: Number,
    #[serde(rename = "DPI")]
    dpi: Number,
    #[serde(rename = "screenW")]
    width: Number,
    #[serde(rename = "screenH")]
    height: Number,
    #[serde(rename = "invView")]
    inverted: Number,
    #[serde(rename = "flipImageX", default)]
    flip_x: Number,
    #[serde(rename = "flipImageY", default)]
    flip_y: Number,
    #[serde(rename = "flipSubp", default)]
    flip_stripes: Number,
}

/// `{"value": 1.0}`.
#[derive(Deserialize, Default, Clone, Copy)]
struct Number {
    value: f64,
}

impl Calibration {
    fn display(text: &str, stem: String) -> Result<DisplayFile, String> {
        let own: Self =
            serde_json::from_str(text).map_err(|why| format!("it is no Looking Glass calibration: {why}"))?;
        for (key, number) in [("flipImageX", own.flip_x), ("flipImageY", own.flip_y), ("flipSubp", own.flip_stripes)] {
            if number.value != 0.0 {
                return Err(format!("{key} is {}; only 0 is supported", number.value));
            }
        }
        if own.inverted.value != 1.0 {
            return Err(format!(
                "invView is {}; lenses turn their elemental images around, so only 1 is supported",
                own.inverted.value
            ));
        }
        let pixels = |key: &str, number: Number| match number.value {
            count if (1.0..=65536.0).contains(&count) && count.fract() == 0.0 => Ok(count as usize),
            count => Err(format!("{key} is {count}; give a whole number of pixels")),
        };
        let size = GridSize::new(pixels("screenH", own.height)?, pixels("screenW", own.width)?);
        let pitch_m = INCH_M / positive("DPI", own.dpi.value)?;
        let slope = finite("slope", own.slope.value)?;
        if slope == 0.0 {
            return Err("slope is 0; a sheet has its lenses upright or slanted".into());
        }
        let cone = positive("viewCone", own.view_cone.value)?;
        if cone >= 180.0 {
            return Err(format!("viewCone is {cone}; give degrees below 180"));
        }
        let panel = Panel { size, pitch_m, stripes: PixelStripes::Rgb };
        let slant_rad = (1.0 / slope).atan();
        let lens_m = INCH_M / positive("pitch", own.pitch.value)?;
        let horizontal_m = lens_m / slant_rad.cos();
        // The formula counts stripes from the middle of a pixel on, a stripe too far to the right. The axis of a lens is
        // where it gives half the views, at the height of the lower edge.
        let from_corner_m = (finite("center", own.center.value)? + 0.5) * horizontal_m - pitch_m / 3.0;
        let [width_m, height_m] = [size.columns, size.rows].map(|count| count as f64 * pitch_m);
        let offset_m = [from_corner_m - width_m / 2.0, -height_m / 2.0];
        let gap_m = horizontal_m / 2.0 / (cone.to_radians() / 2.0).tan();
        let lenses = LensSheet {
            grid: SheetGrid::Lenticular { slant_rad },
            pitch_m: lens_m,
            gap_m,
            focal_length_m: gap_m,
            offset_m,
        };
        let display = Display::new(panel, lenses, f64::INFINITY).map_err(|why| why.to_string())?;
        Ok(DisplayFile { name: own.serial.unwrap_or(stem), display })
    }
}

#[cfg(test)]
mod tests {
    use holo_core::display::PanelMapping;
    use holo_core::{Layout, LightField, LightFieldShape};

    use super::*;

    fn read(text: &str, name: &str) -> Result<DisplayFile, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        DisplayFile::read(path)
    }

    const BENCH: &str = "[panel]\nsize_px = [600, 400]\npixel_um = 100.0\nstripes = \"bgr\"\n[lenses]\ngrid = \"lenticular\"\n\
                         pitch_mm = 1.0\ngap_mm = 3.0\nslant_deg = 9.5\noffset_mm = [0.25, 0.0]\n[viewer]\ndistance_m = 0.6\n";

    #[test]
    fn a_display_file_has_its_numbers() {
        let file = read(BENCH, "bench.toml").unwrap();
        assert_eq!(file.name, "bench");
        let (panel, lenses) = (file.display.panel(), file.display.lenses());
        assert_eq!((panel.size, panel.stripes), (GridSize::new(400, 600), PixelStripes::Bgr));
        assert_eq!((panel.pitch_m, lenses.pitch_m, lenses.gap_m, lenses.focal_length_m), (1e-4, 1e-3, 3e-3, 3e-3));
        assert_eq!((lenses.offset_m, file.display.distance_m()), ([2.5e-4, 0.0], 0.6));
        assert_eq!(lenses.grid, SheetGrid::Lenticular { slant_rad: 9.5_f64.to_radians() });
    }

    #[test]
    fn wrong_keys_and_numbers_are_named() {
        for (from, to, expected) in [
            ("pitch_mm = 1.0", "pitch_mm = -1.0", "lenses.pitch_mm is -1; give a number above 0"),
            ("pitch_mm = 1.0", "pitch_mm = 0.05", "at least the pixel pitch"),
            ("lenticular", "square", "lenses.slant_deg is for lenticular sheets"),
            ("lenticular", "round", "lenses.grid is 'round'; give square, hex-rows or lenticular"),
            ("bgr", "gbr", "panel.stripes is 'gbr'"),
            ("gap_mm", "gap", "gap is not a key here; did you mean gap_mm?"),
            ("gap_mm = 3.0\n", "", "missing field `gap_mm`"),
            ("slant_deg = 9.5", "slant_deg = 80", "at most 60 degrees"),
            ("0.6", "0.0", "viewer.distance_m is 0"),
            ("600, 400", "600, 0", "the number of pixel rows is 0"),
        ] {
            let text = read(&BENCH.replace(from, to), "bench.toml").unwrap_err().to_string();
            assert!(text.contains(expected), "{to}: {text}");
        }
    }

    const PORTRAIT: &str = r#"{"configVersion":"1.0","serial":"LKG-TEST","pitch":{"value":49.82},"slope":{"value":-5.44},
        "center":{"value":0.177},"viewCone":{"value":40.0},"invView":{"value":1.0},"verticalAngle":{"value":0.0},
        "DPI":{"value":338.0},"screenW":{"value":512.0},"screenH":{"value":320.0},"flipImageX":{"value":0.0},
        "flipImageY":{"value":0.0},"flipSubp":{"value":0.0}}"#;

    /// The views that stripes show are those of the formula of the device's shaders.
    #[test]
    fn stripes_of_a_looking_glass_show_the_views_of_its_formula() {
        for slope in [-5.44, 5.04] {
            let text = PORTRAIT.replace("-5.44", &slope.to_string());
            let file = read(&text, "visual.json").unwrap();
            assert_eq!(file.name, "LKG-TEST");
            let views = 45.0;
            // Every view is gray, as light as its number.
            let shape = LightFieldShape::new(GridSize::new(1, 45), GridSize::new(40, 100)).unwrap();
            let mut field = LightField::filled(shape, 1, Layout::ViewpointGrid, 0.0_f32).unwrap();
            for ((_, _, _, s, _), sample) in field.samples_mut().indexed_iter_mut() {
                *sample = s as f32;
            }
            let panel = file.display.panel_image(&field, &PanelMapping::default()).unwrap();
            let (width, height) = (512.0, 320.0);
            let pitch = 49.82 * width / 338.0 * (1.0_f64 / slope).atan().cos();
            let tilt = height / (width * slope);
            let step = 1.0 / (3.0 * width);
            let mut checked = 0;
            for ((row, column, channel), &found) in panel.indexed_iter() {
                // The view of 100 x 40 pixels leaves the upper and lower part dark.
                if !(64..256).contains(&row) {
                    continue;
                }
                let (x, y) = ((column as f64 + 0.5) / width, 1.0 - (row as f64 + 0.5) / height);
                let phase = (x + channel as f64 * step + y * tilt) * pitch - 0.177;
                let expected = (1.0 - phase.rem_euclid(1.0)) * views - 0.5;
                // Where the image ends, it begins again.
                if (0.5..43.5).contains(&expected) {
                    assert!((f64::from(found) - expected).abs() < 1e-3, "{row} {column} {channel}: {found} {expected}");
                    checked += 1;
                }
            }
            assert!(checked > 250_000, "{checked}");
        }
    }

    #[test]
    fn calibrations_that_are_none_are_refused() {
        for (from, to, expected) in [
            (r#""invView":{"value":1.0}"#, r#""invView":{"value":0.0}"#, "invView is 0"),
            (r#""flipImageX":{"value":0.0}"#, r#""flipImageX":{"value":1.0}"#, "flipImageX is 1"),
            (r#""flipSubp":{"value":0.0}"#, r#""flipSubp":{"value":1.0}"#, "flipSubp is 1"),
            (r#""screenW":{"value":512.0}"#, r#""screenW":{"value":1e9}"#, "screenW is 1000000000"),
            (r#""slope":{"value":-5.44}"#, r#""slope":{"value":0.0}"#, "slope is 0"),
            (r#""pitch":{"value":49.82},"#, "", "missing field `pitch`"),
        ] {
            let text = read(&PORTRAIT.replace(from, to), "visual.json").unwrap_err().to_string();
            assert!(text.contains(expected), "{to}: {text}");
        }
        assert!(
            read("{\"pitch\": 3}", "visual.json").unwrap_err().to_string().contains("no Looking Glass calibration")
        );
    }
}
