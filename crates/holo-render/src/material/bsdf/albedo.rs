//! The directional albedo of a rough dielectric coat, which determines how much light reaches the diffuse lobe under
//! it.
//!
//! The albedo of a GGX lobe with Schlick's Fresnel term is E = W F(z) + R (f90 - f0), with F(z) = f0 + (f90 - f0) (1 -
//! z)^5 the reflectance of the smooth surface. The `scale` W is the albedo of microfacets with a reflectance of 1. The
//! `bias` R is the excess of the grazing reflectance over that of the smooth surface. In terms of the DFG factors A and
//! B of the split-sum approximation (E = A f0 + B f90): W = A + B and R = B - W (1 - z)^5. A smooth surface has exactly
//! W = 1 and R = 0.
//!
//! The gain k of the light that is scattered more than once ([`super::multiple_scattering`]) solves k(z) times the
//! integral of the lobe times k = 1. On the nodes it is a system with a symmetric kernel, solved by Sinkhorn's
//! iteration (Sinkhorn and Knopp, 1967) k <- sqrt(k / (A k)), where A k is the integral of the interpolated k.
//!
//! W, R and k are tabulated over the cosine z (64 nodes) and alpha (32 nodes) and interpolated bilinearly. With a the
//! alpha, both change within a few a of grazing incidence, so the first coordinate is sqrt(z (1 + a) / (z + a)); the
//! second is the fourth root of a. The nodes are integrals over the visible microfacet normals, by a Fibonacci lattice
//! of 1597 points. They use only basic arithmetic and square roots, so the table is bitwise identical on all machines.
//! It is computed once, at first use.
//!
//! # Accuracy
//! E for f90 = 1 and any f0 has an error of at most 1e-3 over all directions and alphas, and so has its mean. The
//! albedo of the lobe times k k is 1 within 3e-3.

use std::sync::OnceLock;

use super::microfacet::SMOOTH_BELOW;
use crate::simd::LANES;
use crate::simd::{self, Kernel};

const DIRECTIONS: usize = 64;
const ALPHAS: usize = 32;
const NODES: usize = DIRECTIONS * ALPHAS;

/// Consecutive Fibonacci numbers.
const LATTICE: [usize; 2] = [1597, 987];

#[derive(PartialEq)]
pub(super) struct Table {
    scale: [f32; NODES],
    bias: [f32; NODES],
    gain: [f32; NODES],
    /// Cosine-weighted means over the hemisphere of W and B.
    average_scale: [f32; ALPHAS],
    average_grazing: [f32; ALPHAS],
}

/// The positions of sixteen alphas between the rows of the table.
#[derive(Clone, Copy)]
pub(super) struct Rows {
    row: [u32; LANES],
    fraction: [f32; LANES],
}

/// W, R and k of sixteen lanes.
pub(super) struct Albedo {
    pub scale: [f32; LANES],
    pub bias: [f32; LANES],
    pub gain: [f32; LANES],
}

impl Albedo {
    /// Smooth surfaces.
    pub const SMOOTH: Self = Self { scale: [1.0; LANES], bias: [0.0; LANES], gain: [1.0; LANES] };

    /// The directional albedo E of one lane; `schlick_weight` is (1 - z)^5 at the cosine of the lookup.
    #[inline(always)]
    pub fn of(&self, lane: usize, f0: f32, f90: f32, schlick_weight: f32) -> f32 {
        let rise = f90 - f0;
        (self.scale[lane] * (f0 + rise * schlick_weight) + rise * self.bias[lane]).clamp(0.0, 1.0)
    }
}

/// Cosine-weighted means over the hemisphere of W and B.
pub(super) struct Average {
    pub scale: [f32; LANES],
    pub grazing: [f32; LANES],
}

impl Average {
    /// Smooth surfaces: the integral of 2 z (1 - z)^5 is 1/21.
    pub const SMOOTH: Self = Self { scale: [1.0; LANES], grazing: [1.0 / 21.0; LANES] };

    /// The mean albedo `<E>` of one lane.
    #[inline(always)]
    pub fn of(&self, lane: usize, f0: f32, f90: f32) -> f32 {
        (self.scale[lane] * f0 + (f90 - f0) * self.grazing[lane]).clamp(0.0, 1.0)
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

/// The fourth root of the smallest alpha of the table.
#[inline(always)]
fn first_root() -> f32 {
    SMOOTH_BELOW.sqrt().sqrt()
}

#[inline(always)]
pub(super) fn rows(alpha: &[f32; LANES]) -> Rows {
    let mut rows = Rows { row: [0; LANES], fraction: [0.0; LANES] };
    let first = first_root();
    let scale = (ALPHAS - 1) as f32 / (1.0 - first);
    for lane in 0..LANES {
        let place = ((alpha[lane].sqrt().sqrt() - first) * scale).clamp(0.0, (ALPHAS - 1) as f32);
        let row = place.floor().min((ALPHAS - 2) as f32);
        rows.row[lane] = integer(row);
        rows.fraction[lane] = place - row;
    }
    rows
}

impl Table {
    /// W, R and k at `cosine`; smooth lanes have the values of smooth surfaces.
    #[inline(always)]
    pub fn albedo(&self, rows: &Rows, cosine: &[f32; LANES], alpha: &[f32; LANES], smooth: &[bool; LANES]) -> Albedo {
        let mut albedo = Albedo::SMOOTH;
        let mut column = [0; LANES];
        let mut fraction = [0.0; LANES];
        for lane in 0..LANES {
            let z = cosine[lane].clamp(0.0, 1.0);
            let alpha = alpha[lane].max(SMOOTH_BELOW);
            let place = (z * (1.0 + alpha) / (z + alpha)).sqrt() * (DIRECTIONS - 1) as f32;
            let left = place.floor().min((DIRECTIONS - 2) as f32);
            column[lane] = integer(left);
            fraction[lane] = place - left;
        }
        for lane in 0..LANES {
            // The remainders change nothing; they let the compiler omit bounds checks.
            let node = (rows.row[lane] as usize * DIRECTIONS + column[lane] as usize) % NODES;
            let nodes = [node, (node + 1) % NODES, (node + DIRECTIONS) % NODES, (node + DIRECTIONS + 1) % NODES];
            let (right, up) = (fraction[lane], rows.fraction[lane]);
            let scale = bilinear(&self.scale, nodes, right, up);
            let bias = bilinear(&self.bias, nodes, right, up);
            let gain = bilinear(&self.gain, nodes, right, up);
            albedo.scale[lane] = if smooth[lane] { 1.0 } else { scale };
            albedo.bias[lane] = if smooth[lane] { 0.0 } else { bias };
            albedo.gain[lane] = if smooth[lane] { 1.0 } else { gain };
        }
        albedo
    }

    /// The means; smooth lanes have the values of smooth surfaces.
    #[inline(always)]
    pub fn average(&self, rows: &Rows, smooth: &[bool; LANES]) -> Average {
        let mut average = Average::SMOOTH;
        for lane in 0..LANES {
            let [lower, upper] = [rows.row[lane] as usize % ALPHAS, (rows.row[lane] as usize + 1) % ALPHAS];
            let up = rows.fraction[lane];
            let scale = self.average_scale[lower] + (self.average_scale[upper] - self.average_scale[lower]) * up;
            let grazing =
                self.average_grazing[lower] + (self.average_grazing[upper] - self.average_grazing[lower]) * up;
            average.scale[lane] = if smooth[lane] { average.scale[lane] } else { scale };
            average.grazing[lane] = if smooth[lane] { average.grazing[lane] } else { grazing };
        }
        average
    }
}

/// W, R and k of one lane, with the means of W and B, for [`super::layered`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Single {
    pub scale: f32,
    pub bias: f32,
    pub gain: f32,
    pub mean_scale: f32,
    pub mean_grazing: f32,
}

impl Single {
    /// A smooth surface.
    pub const SMOOTH: Self = Self { scale: 1.0, bias: 0.0, gain: 1.0, mean_scale: 1.0, mean_grazing: 1.0 / 21.0 };

    /// The values that [`Table::albedo`] and [`Table::average`] have for sixteen lanes.
    pub fn new(alpha: f32, cosine: f32) -> Self {
        if alpha < SMOOTH_BELOW {
            return Self::SMOOTH;
        }
        let table = table();
        let first = first_root();
        let last = (ALPHAS - 1) as f32;
        let place = ((alpha.sqrt().sqrt() - first) * (last / (1.0 - first))).clamp(0.0, last);
        let row = place.floor().min((ALPHAS - 2) as f32);
        let up = place - row;
        let z = cosine.clamp(0.0, 1.0);
        let place = (z * (1.0 + alpha) / (z + alpha)).sqrt() * (DIRECTIONS - 1) as f32;
        let left = place.floor().min((DIRECTIONS - 2) as f32);
        let (row, node) = (row as usize, row as usize * DIRECTIONS + left as usize);
        let nodes = [node, node + 1, node + DIRECTIONS, node + DIRECTIONS + 1];
        let at = |values: &[f32; NODES]| bilinear(values, nodes, place - left, up);
        let mean = |values: &[f32; ALPHAS]| values[row] + (values[row + 1] - values[row]) * up;
        Self {
            scale: at(&table.scale),
            bias: at(&table.bias),
            gain: at(&table.gain),
            mean_scale: mean(&table.average_scale),
            mean_grazing: mean(&table.average_grazing),
        }
    }

    /// The directional albedo, as [`Albedo::of`].
    pub fn of(&self, f0: f32, f90: f32, schlick_weight: f32) -> f32 {
        let rise = f90 - f0;
        (self.scale * (f0 + rise * schlick_weight) + rise * self.bias).clamp(0.0, 1.0)
    }
}

/// The kernel that computes the table.
pub(super) struct Compute;

impl Kernel for Compute {
    type Output = Table;

    #[inline(always)]
    fn run(self) -> Table {
        let lattice = Lattice::new();
        let mut table = Table {
            scale: [0.0; NODES],
            bias: [0.0; NODES],
            gain: [1.0; NODES],
            average_scale: [0.0; ALPHAS],
            average_grazing: [0.0; ALPHAS],
        };
        let first = f64::from(first_root());
        for row in 0..ALPHAS {
            let root = first + (1.0 - first) * (row as f64 / (ALPHAS - 1) as f64);
            let alpha = root * root * (root * root);
            let mut nodes = [[0.0; 3]; DIRECTIONS];
            let mut kernel = vec![[0.0; DIRECTIONS]; DIRECTIONS];
            for column in 0..DIRECTIONS {
                let place = column as f64 / (DIRECTIONS - 1) as f64;
                // The coordinate solved for z; microfacets are not sampled at exactly grazing incidence.
                let z = (place * place * alpha / (1.0 + alpha - place * place)).clamp(1e-7, 1.0);
                let [scale, grazing] = lattice.integrate(z, alpha, &mut kernel[column]);
                let bias = grazing - scale * fifth(1.0 - z);
                nodes[column] = [z, scale, bias];
                table.scale[row * DIRECTIONS + column] = scale as f32;
                table.bias[row * DIRECTIONS + column] = bias as f32;
            }
            let gain = gain(&kernel);
            for column in 0..DIRECTIONS {
                table.gain[row * DIRECTIONS + column] = gain[column] as f32;
            }
            let [scale, grazing] = average(&nodes, alpha);
            table.average_scale[row] = scale as f32;
            table.average_grazing[row] = grazing as f32;
        }
        table
    }
}

/// Converts a small non-negative integer from f32: read from the mantissa, which is vectorized, unlike a saturating
/// conversion.
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

/// Lattice points of the unit disk in groups of sixteen, padded with points of weight 0.
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
    /// Denser towards the rim, where height = (1 - q)^2, so that the integrand vanishes there.
    #[inline(always)]
    fn new() -> Self {
        let [count, step] = LATTICE;
        // A rotation by 1/`count` turn, by the first terms of its series; the other angles by repeated rotation.
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
            let mut chunk = LatticePoints { x: zero, y: zero, height: [1.0; LANES], weight: zero };
            for lane in 0..LANES.min(count - first) {
                let k = first + lane;
                let left = 1.0 - (k as f64 + 0.5) / count as f64;
                let radius = (1.0 - left * left).sqrt();
                let [c, s] = turns[k * step % count];
                chunk.x[lane] = radius * c;
                chunk.y[lane] = radius * s;
                chunk.height[lane] = left * left;
                chunk.weight[lane] = 2.0 * left / count as f64;
            }
            points.push(chunk);
        }
        Self { points }
    }

    /// W and B at cosine `z`: the means over the visible microfacet normals of G2 / G1, and of G2 / G1 (1 - c)^5 with c
    /// the cosine to the microfacet normal. `kernel` receives the weights of the values at the nodes in the integral of
    /// the lobe times an interpolated function.
    #[inline(always)]
    fn integrate(&self, z: f64, alpha: f64, kernel: &mut [f64; DIRECTIONS]) -> [f64; 2] {
        let x = (1.0 - z * z).sqrt();
        let square = alpha * alpha;
        let length = (square * x * x + z * z).sqrt();
        let (view_x, rise) = (alpha * x / length, 1.0 + z / length);
        let spread_out = (square + (1.0 - square) * z * z).sqrt();
        let (mut scale, mut grazing) = ([0.0; LANES], [0.0; LANES]);
        for points in &self.points {
            let (mut shares, mut places) = ([0.0; LANES], [0.0; LANES]);
            for lane in 0..LANES {
                let height = points.height[lane];
                let spread = (rise * (2.0 - (1.0 - height) * rise)).max(0.0).sqrt();
                let hx = alpha * (points.x[lane] * spread + view_x);
                let hy = alpha * (points.y[lane] * spread);
                let hz = rise * height;
                let inverse = 1.0 / (hx * hx + hy * hy + hz * hz).sqrt();
                let cosine = (x * hx + z * hz) * inverse;
                let into = (2.0 * cosine * hz * inverse - z).max(0.0);
                let spread_into = (square + (1.0 - square) * into * into).sqrt();
                let share = points.weight[lane] * into * (z + spread_out) / (z * spread_into + into * spread_out);
                scale[lane] += share;
                grazing[lane] += share * fifth((1.0 - cosine).max(0.0));
                shares[lane] = share;
                places[lane] = (into * (1.0 + alpha) / (into + alpha)).sqrt() * (DIRECTIONS - 1) as f64;
            }
            for lane in 0..LANES {
                let left = (places[lane] as usize).min(DIRECTIONS - 2);
                let right = places[lane] - left as f64;
                kernel[left] += shares[lane] * (1.0 - right);
                kernel[left + 1] += shares[lane] * right;
            }
        }
        let mut sums = [0.0; 2];
        for lane in 0..LANES {
            sums[0] += scale[lane];
            sums[1] += grazing[lane];
        }
        sums
    }
}

/// The gain at the nodes of one row, by Sinkhorn's iteration.
#[inline(always)]
fn gain(kernel: &[[f64; DIRECTIONS]]) -> [f64; DIRECTIONS] {
    const STEPS: usize = 40;
    let mut gain = [1.0; DIRECTIONS];
    for _ in 0..STEPS {
        let mut next = gain;
        for (column, weights) in kernel.iter().enumerate() {
            let mut received = 0.0;
            for node in 0..DIRECTIONS {
                received += weights[node] * gain[node];
            }
            next[column] = (gain[column] / received).sqrt();
        }
        gain = next;
    }
    gain
}

/// The means of W and B over one row of nodes [z, W, R], of the interpolated values, so that the coated diffuse lobe
/// conserves energy exactly.
#[inline(always)]
fn average(nodes: &[[f64; 3]; DIRECTIONS], alpha: f64) -> [f64; 2] {
    const STEPS: usize = 64;
    let (mut scale, mut grazing) = (0.0, 0.0);
    for column in 0..DIRECTIONS - 1 {
        let ([from, w0, r0], [to, w1, r1]) = (nodes[column], nodes[column + 1]);
        let step = (to - from) / STEPS as f64;
        for k in 0..STEPS {
            let z = from + step * (k as f64 + 0.5);
            let right = (z * (1.0 + alpha) / (z + alpha)).sqrt() * (DIRECTIONS - 1) as f64 - column as f64;
            let w = w0 + (w1 - w0) * right;
            scale += 2.0 * z * step * w;
            grazing += 2.0 * z * step * (w * fifth(1.0 - z) + r0 + (r1 - r0) * right);
        }
    }
    [scale, grazing]
}
