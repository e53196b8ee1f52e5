//! Adaptive sampling: the number of samples of each pixel, either fixed or controlled by a target error.
//!
//! With a target error the samples are taken in groups. After 16, 32, 64, ... samples the variance of the means of the
//! groups estimates the standard error of the luminance of each pixel. A packet is complete when the standard error of
//! all its pixels, relative to their means, is below the target. The 16 pixels of a packet are decided together,
//! because a single pixel terminates too early now and then.
//!
//! The error is overestimated: the points of one sequence are better distributed over the groups than independent
//! points, which the formula assumes. The relative error of a black pixel is undefined; such a pixel is complete after
//! 256 samples.
//!
//! # Bias
//! A pixel whose first samples happen to agree terminates earlier, so rare bright samples are missed slightly too
//! often. A bright feature that covers less than 1/256 of an otherwise black pixel may be lost. The tests in
//! `tests/all/adaptive.rs` compare the means of images with the unbiased ones.

use crate::simd::{LANES, Lanes};

/// The number of samples before the first check of the error.
const FIRST_CHECK: u32 = 16;

/// The number of samples after which a pixel that is still black is complete.
const BLACK_AFTER: u32 = 256;

/// The sampling state of the packets of a tile.
#[derive(Default)]
pub(crate) struct Samples {
    target: Option<f64>,
    packets: Vec<Packet>,
    active: usize,
}

/// The statistics of a packet.
#[derive(Clone, Copy)]
struct Packet {
    samples: u32,
    groups: u32,
    done: bool,
    /// Lanes with a pixel.
    valid: [bool; LANES],
    /// The sum of the luminances of all samples at the end of the last group.
    sum: [f64; LANES],
    /// The sum of the squares of the sums of the groups.
    squares: [f64; LANES],
}

impl Samples {
    /// Resets the state for another tile, without packets.
    pub fn begin(&mut self, target: Option<f64>) {
        self.target = target;
        self.active = 0;
        self.packets.clear();
    }

    /// Adds the next packet, which has pixels in its valid lanes; it is complete already unless samples are `wanted`.
    #[inline(always)]
    pub fn push(&mut self, valid: &Lanes<i32>, wanted: bool) {
        let zero = [0.0; LANES];
        let mut packet =
            Packet { samples: 0, groups: 0, done: !wanted, valid: [false; LANES], sum: zero, squares: zero };
        for lane in 0..LANES {
            packet.valid[lane] = valid.0[lane] != 0;
        }
        self.packets.push(packet);
        self.active += usize::from(wanted);
    }

    /// Whether a packet needs more samples.
    #[inline(always)]
    pub fn wanted(&self, packet: usize) -> bool {
        !self.packets[packet].done
    }

    /// Whether any packet needs more samples.
    pub fn any_wanted(&self) -> bool {
        self.active > 0
    }

    /// Records `count` more samples of all incomplete packets; `color` holds the sums of all samples so far.
    #[inline(always)]
    pub fn add(&mut self, count: u32, color: &[[[f32; LANES]; 3]]) {
        for (packet, color) in self.packets.iter_mut().zip(color) {
            if packet.done {
                continue;
            }
            packet.samples += count;
            let Some(target) = self.target else { continue };
            packet.groups += 1;
            for lane in 0..LANES {
                let [r, g, b] = [color[0][lane], color[1][lane], color[2][lane]];
                // Luminance, Rec. 709.
                let sum = 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
                let group = sum - packet.sum[lane];
                packet.sum[lane] = sum;
                packet.squares[lane] += group * group;
            }
            if packet.samples >= FIRST_CHECK && packet.samples.is_power_of_two() && packet.is_within(target) {
                packet.done = true;
                self.active -= 1;
            }
        }
    }

    /// The number of samples of a packet so far.
    #[inline(always)]
    pub fn count(&self, packet: usize) -> u32 {
        self.packets[packet].samples
    }

    /// Converts the sums to means, up to a common factor, which is returned.
    #[inline(always)]
    pub fn average(&self, color: &mut [[[f32; LANES]; 3]], all: u32) -> f32 {
        if self.target.is_none() {
            return 1.0 / all as f32;
        }
        for (packet, color) in self.packets.iter().zip(color) {
            let scale = 1.0 / packet.samples.max(1) as f32;
            for c in 0..3 {
                for lane in 0..LANES {
                    color[c][lane] *= scale;
                }
            }
        }
        1.0
    }
}

impl Packet {
    /// Whether the standard error of every pixel is at most `target` times its mean.
    #[inline(always)]
    fn is_within(&self, target: f64) -> bool {
        let groups = f64::from(self.groups);
        let mut within = true;
        for lane in 0..LANES {
            let mean = self.sum[lane] / groups;
            let variance = (self.squares[lane] / groups - mean * mean) / (groups - 1.0);
            let calm = if mean > 0.0 { variance <= target * target * mean * mean } else { self.samples >= BLACK_AFTER };
            within &= calm | !self.valid[lane];
        }
        within
    }
}
