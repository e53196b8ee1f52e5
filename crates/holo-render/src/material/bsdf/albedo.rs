//! How much a rough varnish reflects in all directions together, which is what the diffuser under it does not get.
//!
//! The albedo of a GGX lobe with Schlick's Fresnel term is E = W (f0 + (f90 - f0) (1 - z)^5) + (f90 - f0) R: with W the
//! albedo of mirrors that reflect everything, and R how much more of the grazing reflectance (the split sum's second
//! part, B) there is than the smooth surface's (1 - z)^5 has. A smooth surface has W = 1 and R = 0 exactly.
//!
//! W and R are tabulated over the direction (64) and the width (32) and looked up bilinearly. Both change within a few
//! widths of the shading plane whatever the width, so the first coordinate is sqrt(z (1 + w) / (z + w)); the second is
//! the fourth root of w. The nodes are integrals over the visible facets of microfacet.rs, by a Fibonacci lattice of 1597
//! points that is off by less than 1e-4. Arithmetic and square roots alone go into them: the table has the same bits
//! everywhere. It is computed once, at first use, in 10 to 20 ms (one core of an AMD EPYC
//! with AVX-512).
//!
//! Accuracy: E of f90 = 1 and any f0 is off by 1e-3 at most (measured: 8e-4), over all directions and widths; its mean
//! by half of that.

use std::sync::OnceLock;

use super::microfacet::SMOOTH_BELOW;
use crate::simd::LANES;
use crate::simd::{self, Kernel};

const DIRECTIONS: usize = 64;
const WIDTHS: usize = 32;
const NODES: usize = DIRECTIONS * WIDTHS;

/// Consecutive numbers of Fibonacci.
const LATTICE: [usize; 2] = [1597, 987];

#[derive(PartialEq)]
pub(super) struct Table {
    whole: [f32; NODES],
    excess: [f32; NODES],
    /// Means over the hemisphere, weighted by the cosine: of W, and of B.
    average_whole: [f32; WIDTHS],
    average_grazing: [f32; WIDTHS],
}

/// Where sixteen widths lie between the rows of the table.
#[derive(Clone, Copy)]
pub(super) struct Rows {
    row: [u32; LANES],
    fraction: [f32; LANES],
}

/// W and R.
pub(super) struct Albedo {
    pub whole: [f32; LANES],
    pub excess: [f32; LANES],
}

impl Albedo {
    /// Of surfaces that are smooth.
    pub const SMOOTH: Self = Self { whole: [1.0; LANES], excess: [0.0; LANES] };

    /// E of one lane; `way` is Schlick's at the angle of the look-up.
    #[inline(always)]
    pub fn of(&self, lane: usize, f0: f32, f90: f32, way: f32) -> f32 {
        let rise = f90 - f0;
        (self.whole[lane] * (f0 + rise * way) + rise * self.excess[lane]).clamp(0.0, 1.0)
    }
}

/// Means over the hemisphere: of W, and of the grazing part B.
pub(super) struct Average {
    pub whole: [f32; LANES],
    pub grazing: [f32; LANES],
}

impl Average {
    /// Of surfaces that are smooth: the integral of 2 z (1 - z)^5 is 1/21.
    pub const SMOOTH: Self = Self { whole: [1.0; LANES], grazing: [1.0 / 21.0; LANES] };

    /// `<E>` of one lane.
    #[inline(always)]
    pub fn of(&self, lane: usize, f0: f32, f90: f32) -> f32 {
        (self.whole[lane] * f0 + (f90 - f0) * self.grazing[lane]).clamp(0.0, 1.0)
    }
}

pub(super) fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(compute)
}

#[cold]
#[inline(never)]
fn compute() -> Table {
    simd::run(Compute)
}

/// The fourth root of the narrowest width of the table.
#[inline(always)]
fn first_root() -> f32 {
    SMOOTH_BELOW.sqrt().sqrt()
}

#[inline(always)]
pub(super) fn rows(width: &[f32; LANES]) -> Rows {
    let mut rows = Rows { row: [0; LANES], fraction: [0.0; LANES] };
    let first = first_root();
    let scale = (WIDTHS - 1) as f32 / (1.0 - first);
    for lane in 0..LANES {
        let place = ((width[lane].sqrt().sqrt() - first) * scale).clamp(0.0, (WIDTHS - 1) as f32);
        let row = place.floor().min((WIDTHS - 2) as f32);
        rows.row[lane] = integer(row);
        rows.fraction[lane] = place - row;
    }
    rows
}

impl Table {
    /// W and R towards `cosine`; smooth lanes get those of smooth surfaces.
    #[inline(always)]
    pub fn albedo(&self, rows: &Rows, cosine: &[f32; LANES], width: &[f32; LANES], smooth: &[bool; LANES]) -> Albedo {
        let mut albedo = Albedo::SMOOTH;
        let mut column = [0; LANES];
        let mut fraction = [0.0; LANES];
        for lane in 0..LANES {
            let z = cosine[lane].clamp(0.0, 1.0);
            let width = width[lane].max(SMOOTH_BELOW);
            let place = (z * (1.0 + width) / (z + width)).sqrt() * (DIRECTIONS - 1) as f32;
            let left = place.floor().min((DIRECTIONS - 2) as f32);
            column[lane] = integer(left);
            fraction[lane] = place - left;
        }
        for lane in 0..LANES {
            // The masks change nothing but let the compiler see that the nodes exist.
            let node = (rows.row[lane] as usize * DIRECTIONS + column[lane] as usize) % NODES;
            let nodes = [node, (node + 1) % NODES, (node + DIRECTIONS) % NODES, (node + DIRECTIONS + 1) % NODES];
            let (right, up) = (fraction[lane], rows.fraction[lane]);
            let whole = bilinear(&self.whole, nodes, right, up);
            let excess = bilinear(&self.excess, nodes, right, up);
            albedo.whole[lane] = if smooth[lane] { 1.0 } else { whole };
            albedo.excess[lane] = if smooth[lane] { 0.0 } else { excess };
        }
        albedo
    }

    /// The means; smooth lanes get those of smooth surfaces.
    #[inline(always)]
    pub fn average(&self, rows: &Rows, smooth: &[bool; LANES]) -> Average {
        let mut average = Average::SMOOTH;
        for lane in 0..LANES {
            let [lower, upper] = [rows.row[lane] as usize % WIDTHS, (rows.row[lane] as usize + 1) % WIDTHS];
            let up = rows.fraction[lane];
            let whole = self.average_whole[lower] + (self.average_whole[upper] - self.average_whole[lower]) * up;
            let grazing =
                self.average_grazing[lower] + (self.average_grazing[upper] - self.average_grazing[lower]) * up;
            average.whole[lane] = if smooth[lane] { average.whole[lane] } else { whole };
            average.grazing[lane] = if smooth[lane] { average.grazing[lane] } else { grazing };
        }
        average
    }
}

/// Computes the table.
pub(super) struct Compute;

impl Kernel for Compute {
    type Output = Table;

    #[inline(always)]
    fn run(self) -> Table {
        let lattice = Lattice::new();
        let mut table = Table {
            whole: [0.0; NODES],
            excess: [0.0; NODES],
            average_whole: [0.0; WIDTHS],
            average_grazing: [0.0; WIDTHS],
        };
        let first = f64::from(first_root());
        for row in 0..WIDTHS {
            let root = first + (1.0 - first) * (row as f64 / (WIDTHS - 1) as f64);
            let width = root * root * (root * root);
            let mut nodes = [[0.0; 3]; DIRECTIONS];
            for column in 0..DIRECTIONS {
                let place = column as f64 / (DIRECTIONS - 1) as f64;
                // The coordinate solved for z; facets are not drawn from within the shading plane.
                let z = (place * place * width / (1.0 + width - place * place)).clamp(1e-7, 1.0);
                let [whole, grazing] = lattice.integrate(z, width);
                let excess = grazing - whole * fifth(1.0 - z);
                nodes[column] = [z, whole, excess];
                table.whole[row * DIRECTIONS + column] = whole as f32;
                table.excess[row * DIRECTIONS + column] = excess as f32;
            }
            let [whole, grazing] = average(&nodes, width);
            table.average_whole[row] = whole as f32;
            table.average_grazing[row] = grazing as f32;
        }
        table
    }
}

/// A small whole number: read off the mantissa, which unlike a saturating conversion is done in all lanes at once.
#[inline(always)]
fn integer(x: f32) -> u32 {
    (x + 8_388_608.0).to_bits() & 0x7F_FFFF
}

#[inline(always)]
fn bilinear(values: &[f32; NODES], nodes: [usize; 4], right: f32, up: f32) -> f32 {
    let lower = values[nodes[0]] + (values[nodes[1]] - values[nodes[0]]) * right;
    let upper = values[nodes[2]] + (values[nodes[3]] - values[nodes[2]]) * right;
    lower + (upper - lower) * up
}

#[inline(always)]
fn fifth(x: f64) -> f64 {
    let square = x * x;
    square * square * x
}

/// Points of the unit disk, sixteen by sixteen, padded with some of no weight.
struct Lattice {
    points: Vec<LatticePoints>,
}

struct LatticePoints {
    x: [f64; LANES],
    y: [f64; LANES],
    /// 1 - x^2 - y^2.
    height: [f64; LANES],
    weight: [f64; LANES],
}

impl Lattice {
    /// Denser towards the rim, where height = (1 - q)^2, so that the integrand fades there.
    #[inline(always)]
    fn new() -> Self {
        let [count, step] = LATTICE;
        // One turn over `count`: small enough for the first terms of the series, and the rest by rotation.
        let x = std::f64::consts::TAU / count as f64;
        let s = x * x;
        let sin = x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0)));
        let cos = 1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0)));
        let mut turns = vec![[1.0, 0.0]; count];
        for k in 1..count {
            let [c, s] = turns[k - 1];
            turns[k] = [c * cos - s * sin, s * cos + c * sin];
        }
        let mut points = Vec::new();
        for first in (0..count).step_by(LANES) {
            let zero = [0.0; LANES];
            let mut block = LatticePoints { x: zero, y: zero, height: [1.0; LANES], weight: zero };
            for lane in 0..LANES.min(count - first) {
                let k = first + lane;
                let left = 1.0 - (k as f64 + 0.5) / count as f64;
                let radius = (1.0 - left * left).sqrt();
                let [c, s] = turns[k * step % count];
                block.x[lane] = radius * c;
                block.y[lane] = radius * s;
                block.height[lane] = left * left;
                block.weight[lane] = 2.0 * left / count as f64;
            }
            points.push(block);
        }
        Self { points }
    }

    /// W and B at cosine `z`: the means of G2 / G1 and of the same times (1 - c)^5 over the visible facets, c being the
    /// cosine with the facet.
    #[inline(always)]
    fn integrate(&self, z: f64, width: f64) -> [f64; 2] {
        let x = (1.0 - z * z).sqrt();
        let square = width * width;
        let length = (square * x * x + z * z).sqrt();
        let (view_x, rise) = (width * x / length, 1.0 + z / length);
        let spread_out = (square + (1.0 - square) * z * z).sqrt();
        let (mut whole, mut grazing) = ([0.0; LANES], [0.0; LANES]);
        for points in &self.points {
            for lane in 0..LANES {
                let height = points.height[lane];
                let spread = (rise * (2.0 - (1.0 - height) * rise)).max(0.0).sqrt();
                let hx = width * (points.x[lane] * spread + view_x);
                let hy = width * (points.y[lane] * spread);
                let hz = rise * height;
                let inverse = 1.0 / (hx * hx + hy * hy + hz * hz).sqrt();
                let cosine = (x * hx + z * hz) * inverse;
                let into = (2.0 * cosine * hz * inverse - z).max(0.0);
                let spread_into = (square + (1.0 - square) * into * into).sqrt();
                let share = points.weight[lane] * into * (z + spread_out) / (z * spread_into + into * spread_out);
                whole[lane] += share;
                grazing[lane] += share * fifth((1.0 - cosine).max(0.0));
            }
        }
        let mut sums = [0.0; 2];
        for lane in 0..LANES {
            sums[0] += whole[lane];
            sums[1] += grazing[lane];
        }
        sums
    }
}

/// The means of W and B over one row of nodes [z, W, R]: of what is looked up between them, so that a varnished diffuser
/// neither gains nor loses by the difference.
#[inline(always)]
fn average(nodes: &[[f64; 3]; DIRECTIONS], width: f64) -> [f64; 2] {
    const STEPS: usize = 64;
    let (mut whole, mut grazing) = (0.0, 0.0);
    for column in 0..DIRECTIONS - 1 {
        let ([from, w0, r0], [to, w1, r1]) = (nodes[column], nodes[column + 1]);
        let step = (to - from) / STEPS as f64;
        for k in 0..STEPS {
            let z = from + step * (k as f64 + 0.5);
            let right = (z * (1.0 + width) / (z + width)).sqrt() * (DIRECTIONS - 1) as f64 - column as f64;
            let w = w0 + (w1 - w0) * right;
            whole += 2.0 * z * step * w;
            grazing += 2.0 * z * step * (w * fifth(1.0 - z) + r0 + (r1 - r0) * right);
        }
    }
    [whole, grazing]
}
