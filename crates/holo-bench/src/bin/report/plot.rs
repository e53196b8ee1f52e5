//! Plots with two logarithmic axes, as SVG.

use std::fmt::Write;

const WIDTH: f64 = 830.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 270.0;
const TOP: f64 = 36.0;
const BOTTOM: f64 = 46.0;

const COLORS: [&str; 6] = ["#1b6ca8", "#c1531b", "#2d8659", "#7d4fa3", "#8a6d1f", "#333333"];
const DASHES: [&str; 3] = ["none", "6 4", "2 3"];

/// A polyline with a marker at each point.
pub struct Series {
    pub name: String,
    /// Index into [`COLORS`], modulo their number.
    pub color: usize,
    /// Index into [`DASHES`], modulo their number.
    pub dashes: usize,
    /// Points whose coordinates are not both above 0 are not drawn.
    pub points: Vec<(f64, f64)>,
}

/// A plot of several series.
pub struct Plot {
    title: String,
    axes: [String; 2],
    series: Vec<Series>,
}

impl Plot {
    pub fn new(title: &str, x: &str, y: &str) -> Self {
        Self { title: title.into(), axes: [x.into(), y.into()], series: Vec::new() }
    }

    pub fn add(&mut self, series: Series) {
        self.series.push(series);
    }

    pub fn svg(&self) -> String {
        let all = || self.series.iter().flat_map(|series| &series.points).filter(|(x, y)| *x > 0.0 && *y > 0.0);
        let [x_axis, y_axis] = [Axis::over(all().map(|p| p.0)), Axis::over(all().map(|p| p.1))];
        let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
        let x_at = |x: f64| LEFT + x_axis.fraction(x) * (right - LEFT);
        let y_at = |y: f64| bottom - y_axis.fraction(y) * (bottom - TOP);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\" font-family=\"sans-serif\" font-size=\"12\"><rect width=\"100%\" height=\"100%\" \
             fill=\"white\"/>\n"
        );
        let mut text = |x: f64, y: f64, anchor: &str, size: u32, words: &str| {
            // Writing into a string cannot fail.
            let _ = writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\">{}</text>",
                escaped(words)
            );
        };
        text(LEFT, 15.0, "start", 14, &self.title);
        text(0.5 * (LEFT + right), HEIGHT - 10.0, "middle", 12, &self.axes[0]);
        text(6.0, TOP - 4.0, "start", 12, &self.axes[1]);
        for x in x_axis.marks() {
            text(x_at(x), bottom + 16.0, "middle", 11, &plain(x));
        }
        for y in y_axis.marks() {
            text(LEFT - 6.0, y_at(y) + 4.0, "end", 11, &plain(y));
        }
        for (k, series) in self.series.iter().enumerate() {
            text(right + 44.0, TOP + 12.0 + 18.0 * k as f64, "start", 11, &series.name);
        }
        for x in x_axis.marks() {
            let _ = writeln!(svg, "<path d=\"M{0:.1} {TOP}V{bottom}\" stroke=\"#ddd\"/>", x_at(x));
        }
        for y in y_axis.marks() {
            let _ = writeln!(svg, "<path d=\"M{LEFT} {0:.1}H{right}\" stroke=\"#ddd\"/>", y_at(y));
        }
        let _ = writeln!(svg, "<path d=\"M{LEFT} {TOP}V{bottom}H{right}\" fill=\"none\" stroke=\"black\"/>");
        for (k, series) in self.series.iter().enumerate() {
            let style = format!(
                "stroke=\"{}\" stroke-dasharray=\"{}\" stroke-width=\"2\"",
                COLORS[series.color % COLORS.len()],
                DASHES[series.dashes % DASHES.len()]
            );
            let points = series.points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0);
            let points_px: Vec<String> = points.map(|&(x, y)| format!("{:.1} {:.1}", x_at(x), y_at(y))).collect();
            let _ = writeln!(svg, "<path d=\"M{}\" fill=\"none\" {style}/>", points_px.join("L"));
            for point_px in &points_px {
                let (x, y) = point_px.split_once(' ').unwrap_or_default();
                let fill = COLORS[series.color % COLORS.len()];
                let _ = writeln!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"3\" fill=\"{fill}\"/>");
            }
            let y = TOP + 8.0 + 18.0 * k as f64;
            let _ = writeln!(svg, "<path d=\"M{} {y}h28\" fill=\"none\" {style}/>", right + 10.0);
        }
        svg + "</svg>\n"
    }
}

/// A logarithmic axis.
struct Axis {
    /// Exponents of ten.
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis that contains all values, with a margin of a tenth of a decade.
    fn over(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value.log10()), high.max(value.log10()))
        });
        if low > high {
            return Self { low: 0.0, high: 1.0 };
        }
        Self { low: low - 0.1, high: high + 0.1 }
    }

    fn fraction(&self, value: f64) -> f64 {
        (value.log10() - self.low) / (self.high - self.low)
    }

    /// Tick marks: powers of ten; on short axes also 2 and 5 times them.
    fn marks(&self) -> Vec<f64> {
        let few = self.high - self.low < 2.5;
        let mut marks = Vec::new();
        for exponent in self.low.floor() as i32..=self.high.ceil() as i32 {
            for factor in if few { [1.0, 2.0, 5.0].as_slice() } else { &[1.0] } {
                let mark = factor * 10_f64.powi(exponent);
                if (self.low..=self.high).contains(&mark.log10()) {
                    marks.push(mark);
                }
            }
        }
        marks
    }
}

/// The label of a tick mark, without trailing zeros.
fn plain(mark: f64) -> String {
    let text = crate::table::short(mark);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;")
}
