//! What a lens of glass does over the field, as curves in an SVG image.

use std::fmt::Write;

use holo_core::plenoptic::{Aberrations, PlenopticCamera};

/// Points of a curve, less one.
const STEPS: usize = 48;
/// The visible light that the focus of colors is drawn over, nm.
const WAVELENGTHS_NM: [f64; 2] = [420.0, 680.0];

const PANEL: [f64; 2] = [300.0, 220.0];
const MARGIN: [f64; 2] = [58.0, 34.0];
const COLUMNS: usize = 3;
const DASHES: [&str; 2] = ["none", "6 4"];

/// A small plot of one or two curves over the same axis.
struct Panel {
    title: &'static str,
    axis: &'static str,
    curves: Vec<Vec<[f64; 2]>>,
}

/// The curves of a camera with a lens of glass, from the axis to a corner of the array.
pub(super) fn curves(camera: &PlenopticCamera, corner_m: f64) -> String {
    let field: Vec<Aberrations> =
        (0..=STEPS).filter_map(|k| camera.aberrations(corner_m * k as f64 / STEPS as f64)).collect();
    let over_field = |title: &'static str, values: &[fn(&Aberrations) -> f64]| Panel {
        title,
        axis: "mm from the axis",
        curves: values.iter().map(|value| field.iter().map(|at| [at.field_m * 1e3, value(at)]).collect()).collect(),
    };
    let color = (0..=STEPS).filter_map(|k| {
        let nm = WAVELENGTHS_NM[0] + (WAVELENGTHS_NM[1] - WAVELENGTHS_NM[0]) * k as f64 / STEPS as f64;
        Some([nm, camera.chromatic_shift_m(nm)? * 1e3])
    });
    drawn(&[
        over_field("distortion, %", &[|at| at.distortion * 100.0]),
        over_field("light that vignetting leaves, %", &[|at| at.pupil_share * 100.0]),
        over_field("spot in focus (RMS), \u{b5}m", &[|at| at.spot_m * 1e6]),
        over_field(
            "focus behind the array, mm: sagittal, tangential (dashed)",
            &[|at| at.sagittal_m * 1e3, |at| at.tangential_m * 1e3],
        ),
        over_field("486 nm farther from the axis than 656 nm, \u{b5}m", &[|at| at.lateral_color_m * 1e6]),
        Panel { title: "focus on the axis behind that of 588 nm, mm", axis: "nm", curves: vec![color.collect()] },
    ])
}

fn drawn(panels: &[Panel]) -> String {
    let [width, height] =
        [COLUMNS as f64 * (PANEL[0] + MARGIN[0]), panels.len().div_ceil(COLUMNS) as f64 * (PANEL[1] + 2.0 * MARGIN[1])];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"11\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (k, panel) in panels.iter().enumerate() {
        let left = (k % COLUMNS) as f64 * (PANEL[0] + MARGIN[0]) + MARGIN[0];
        let top = (k / COLUMNS) as f64 * (PANEL[1] + 2.0 * MARGIN[1]) + MARGIN[1];
        // Writing into a string cannot fail.
        let _ = panel.draw(&mut svg, left, top);
    }
    svg + "</svg>\n"
}

impl Panel {
    fn draw(&self, svg: &mut String, left: f64, top: f64) -> std::fmt::Result {
        let (width, height) = (PANEL[0] - MARGIN[0] / 2.0, PANEL[1]);
        let all = || self.curves.iter().flatten();
        let x = Axis::over(all().map(|point| point[0]), 1e-6);
        // Curves of rounding errors are flat.
        let y = Axis::over(all().map(|point| point[1]), 1e-4);
        let (bottom, right) = (top + height, left + width);
        writeln!(svg, "<text x=\"{left}\" y=\"{:.1}\">{}</text>", top - 8.0, self.title)?;
        writeln!(svg, "<text x=\"{right:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>", bottom + 27.0, self.axis)?;
        for mark in x.marks() {
            let at = left + x.part(mark) * width;
            writeln!(svg, "<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"#ddd\"/>")?;
            writeln!(svg, "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{mark}</text>", bottom + 14.0)?;
        }
        for mark in y.marks() {
            let at = bottom - y.part(mark) * height;
            writeln!(svg, "<path d=\"M{left} {at:.1}H{right:.1}\" stroke=\"#ddd\"/>")?;
            writeln!(svg, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{mark}</text>", left - 5.0, at + 4.0)?;
        }
        for (curve, dashes) in self.curves.iter().zip(DASHES) {
            let place = |point: &[f64; 2]| {
                format!("{:.2},{:.2}", left + x.part(point[0]) * width, bottom - y.part(point[1]) * height)
            };
            let points: Vec<String> = curve.iter().map(place).collect();
            writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"#1b6ca8\" stroke-width=\"1.6\" stroke-dasharray=\"{dashes}\"/>",
                points.join(" ")
            )?;
        }
        Ok(())
    }
}

/// An axis from one mark to another; marks are 1, 2 or 5 times a power of ten apart.
struct Axis {
    first: i64,
    last: i64,
    step: f64,
}

impl Axis {
    /// The axis of some numbers; they are at least `least` apart.
    fn over(numbers: impl Iterator<Item = f64>, least: f64) -> Self {
        let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        let (low, high) = if high - low < least { (low - least, high + least) } else { (low, high) };
        let about = (high - low) / 5.0;
        let power = 10f64.powf(about.log10().floor());
        let step = power * [1.0, 2.0, 5.0].into_iter().find(|times| times * power >= about).unwrap_or(10.0);
        Self { first: (low / step).floor() as i64, last: (high / step).ceil() as i64, step }
    }

    fn part(&self, number: f64) -> f64 {
        (number / self.step - self.first as f64) / (self.last - self.first) as f64
    }

    /// Rounded to what tells them apart.
    fn marks(&self) -> impl Iterator<Item = f64> {
        let digits = (-self.step.log10().floor()).max(0.0) as i32;
        let scale = 10f64.powi(digits);
        (self.first..=self.last).map(move |k| (k as f64 * self.step * scale).round() / scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_and_surround_the_numbers() {
        for (low, high, first, last) in
            [(0.0, 21.6, 0.0, 25.0), (-0.013, 0.0, -0.015, 0.0), (0.3, 0.3, 0.2999, 0.3001), (99.7, 100.0, 99.7, 100.0)]
        {
            let axis = Axis::over([low, high].into_iter(), 1e-4);
            let marks: Vec<f64> = axis.marks().collect();
            assert!((3..=8).contains(&marks.len()), "{marks:?}");
            assert!((marks[0] - first).abs() < 1e-9 && (marks[marks.len() - 1] - last).abs() < 1e-9, "{marks:?}");
            assert!((0.0..=1.0).contains(&axis.part(low)) && (0.0..=1.0).contains(&axis.part(high)));
        }
    }
}
