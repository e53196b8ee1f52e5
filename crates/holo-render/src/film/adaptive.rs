//! How many samples a pixel gets: all that were asked for, or as many as its error needs.
//!
//! With a target error the samples come in groups. After 16, 32, 64, ... samples the spread of the groups' means tells
//! the standard error of the pixel's luminance; once it is below the target, relative to the mean, for all pixels of a
//! packet, the packet is done. Sixteen neighbours decide together: one of them alone stops too early now and then.
//!
//! The error is overestimated, by design: points of one sequence spread better over the groups than independent ones,
//! which is what the formula assumes. A pixel that is black so far has no error that could be told; it is done after
//! 256 samples.
//!
//! Bias: a pixel that happens to look calm stops sooner, so that what its samples missed is missing a little more often
//! than it should; something bright that covers less than 1/256 of a black pixel may be lost. The tests in
//! `tests/adaptive.rs` hold the means of pictures to the unbiased ones.

use crate::simd::{LANES, Lanes};

/// Samples after which the error is looked at for the first time.
const FIRST_LOOK: u32 = 16;

/// Samples after which a pixel that is still black is taken for black.
const BLACK_ENOUGH: u32 = 256;

/// The samples of a tile's packets.
#[derive(Default)]
pub(crate) struct Samples {
    target: Option<f64>,
    packets: Vec<Packet>,
    active: usize,
}

/// What a packet's samples gave so far.
#[derive(Clone, Copy)]
struct Packet {
    samples: u32,
    groups: u32,
    done: bool,
    /// Lanes that have a pixel.
    valid: [bool; LANES],
    /// Sum of all samples' luminances when the last group was complete.
    sum: [f64; LANES],
    /// Sum of the squares of the groups' sums.
    squares: [f64; LANES],
}

impl Samples {
    /// Makes it ready for another tile, no packet of which is noted yet.
    pub fn begin(&mut self, target: Option<f64>) {
        self.target = target;
        self.active = 0;
        self.packets.clear();
    }

    /// Notes the next packet, which has pixels in its valid lanes.
    #[inline(always)]
    pub fn push(&mut self, valid: &Lanes<i32>) {
        let zero = [0.0; LANES];
        let mut packet = Packet { samples: 0, groups: 0, done: false, valid: [false; LANES], sum: zero, squares: zero };
        for lane in 0..LANES {
            packet.valid[lane] = valid.0[lane] != 0;
        }
        self.packets.push(packet);
        self.active += 1;
    }

    /// Whether a packet needs more.
    #[inline(always)]
    pub fn wanted(&self, packet: usize) -> bool {
        !self.packets[packet].done
    }

    /// Whether any packet does.
    pub fn any_wanted(&self) -> bool {
        self.active > 0
    }

    /// Notes `count` more samples of all packets that wanted them; `color` has the sums of all samples so far.
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
                // Rec. 709.
                let sum = 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
                let group = sum - packet.sum[lane];
                packet.sum[lane] = sum;
                packet.squares[lane] += group * group;
            }
            if packet.samples >= FIRST_LOOK && packet.samples.is_power_of_two() && packet.is_within(target) {
                packet.done = true;
                self.active -= 1;
            }
        }
    }

    /// Makes means of the sums; returns what is left to multiply them with.
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
            let calm =
                if mean > 0.0 { variance <= target * target * mean * mean } else { self.samples >= BLACK_ENOUGH };
            within &= calm | !self.valid[lane];
        }
        within
    }
}
