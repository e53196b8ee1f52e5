//! How many samples a pixel has, and which pixels have one where there are fewer samples than pixels.
//!
//! Packets of 16 pixels are traced or left out together. Every microlens ranks its packets: the place of a packet on the
//! Morton curve over the views, scrambled as Owen does (each bit by a function of the bits above it, differently for
//! every microlens), gives it the bit reversal of its lowest six bits. One of every 2^k packets that begin at a
//! multiple of 2^k on the curve has a rank below 64 / 2^k, and those of a smaller part are among those of a larger one.

use std::fmt;

use super::{MAX_SAMPLES, hash, morton, owen};

/// The number of ranks of a packet.
pub(crate) const RANKS: u32 = 64;

/// The samples of a pixel: a whole number, or a part of the pixels that have one each.
///
/// # Examples
/// ```
/// use holo_render::SamplesPerPixel;
///
/// assert_eq!(SamplesPerPixel::from(4).to_string(), "4");
/// let few = SamplesPerPixel::one_in(16).expect("a power of two, 2 to 64");
/// assert_eq!((few.to_string(), few.as_f64()), ("1/16".to_owned(), 0.0625));
/// assert_eq!(SamplesPerPixel::from(2).max(few), SamplesPerPixel::from(2));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplesPerPixel {
    /// Of a pixel that is traced.
    samples: u32,
    /// One of so many pixels is traced.
    pixels: u32,
}

impl SamplesPerPixel {
    /// One sample in `pixels` pixels: 2, 4, 8, 16, 32 or 64; `None` for other numbers.
    #[must_use]
    pub const fn one_in(pixels: u32) -> Option<Self> {
        if pixels.is_power_of_two() && pixels > 1 && pixels <= RANKS { Some(Self { samples: 1, pixels }) } else { None }
    }

    /// Returns the number of samples of a pixel that is traced.
    #[must_use]
    pub const fn of_traced(self) -> u32 {
        self.samples
    }

    /// Returns of how many pixels one is traced: 1 if all are.
    #[must_use]
    pub const fn pixels(self) -> u32 {
        self.pixels
    }

    /// Returns whether only a part of the pixels is traced.
    #[must_use]
    pub const fn is_fraction(self) -> bool {
        self.pixels > 1
    }

    /// Returns the number of samples per pixel.
    #[must_use]
    pub fn as_f64(self) -> f64 {
        f64::from(self.samples) / f64::from(self.pixels)
    }

    /// Returns the larger of two numbers of samples.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        if other.as_f64() > self.as_f64() { other } else { self }
    }

    /// Whether it is in range.
    pub(crate) const fn is_valid(self) -> bool {
        self.samples >= 1 && self.samples <= MAX_SAMPLES
    }

    /// The ranks of the packets that are traced are below this number.
    pub(crate) const fn ranks(self) -> u32 {
        RANKS / self.pixels
    }
}

impl From<u32> for SamplesPerPixel {
    fn from(samples: u32) -> Self {
        Self { samples, pixels: 1 }
    }
}

impl fmt::Display for SamplesPerPixel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_fraction() { write!(f, "{}/{}", self.samples, self.pixels) } else { self.samples.fmt(f) }
    }
}

/// The rank of the packet at this row and column of the packets of a group, such as those behind a microlens.
#[inline(always)]
pub(crate) fn rank(seed: u64, group: u32, place: [u32; 2]) -> u32 {
    let scramble = hash(hash(group ^ 0x5F35_6495) ^ seed as u32 ^ hash((seed >> 32) as u32));
    owen(morton(place), scramble).reverse_bits() >> (u32::BITS - RANKS.ilog2())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of every aligned run of 2^k places one has a rank below 64 / 2^k, at places that depend on the group.
    #[test]
    fn every_run_of_packets_has_one_of_each_part() {
        let ranks = |group: u32| -> Vec<u32> {
            let mut ranks = vec![0; 1024];
            for row in 0..32 {
                for column in 0..32 {
                    ranks[morton([row, column]) as usize] = rank(7, group, [row, column]);
                }
            }
            ranks
        };
        for group in 0..8 {
            let ranks = ranks(group);
            for pixels in [1, 2, 4, 8, 16, 32, 64] {
                let below = SamplesPerPixel::one_in(pixels).map_or(RANKS, SamplesPerPixel::ranks);
                for run in ranks.chunks_exact(pixels as usize) {
                    assert_eq!(run.iter().filter(|&&rank| rank < below).count(), 1, "{pixels}: {run:?}");
                }
            }
        }
        assert_ne!(ranks(0), ranks(1));
        assert!((0..32).map(|group| ranks(group)[5]).any(|rank| rank < 8));
    }
}
