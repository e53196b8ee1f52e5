//! Pixels without samples whose disparity is that of others.
//!
//! Where only some packets of a microlens have samples, the reconstruction needs to know what the others show. One of
//! [`EIGHT`] packets is seen: traced to its first hits. If what these show moves nearly alike, the others show it too, and
//! are not traced. Otherwise there may be an edge among them, and all are.

use crate::camera::PixelPacket;
use crate::film::guides::{Guides, Movement};
use crate::sampling::{RANKS, morton};
use crate::simd::{LANES, Lanes};

/// One of so many packets that follow each other on the Morton curve is always seen.
const EIGHT: u32 = 8;

/// The largest distance of a pixel to one of those eight packets, in views along an axis.
const FARTHEST: f32 = 16.0;

/// The largest movement, px, of what a pixel shows against what the pixel shows that it takes its disparity from.
const MAX_PARTING_PX: f32 = 0.25;

/// The packets of a tile; none if all of them have samples.
#[derive(Default)]
pub(crate) struct Unseen {
    /// The movement between adjacent views, in multiples of the disparity.
    movement: f32,
    packets: Vec<Packet>,
}

/// A packet of a tile.
#[derive(Clone, Copy)]
struct Packet {
    lens: u32,
    /// The number of its group of eight behind the microlens.
    eight: usize,
    valid: Lanes<i32>,
    sight: Sight,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sight {
    Traced,
    /// Not traced so far.
    Unknown,
    /// As others.
    Known,
}

/// The disparities of some pixels.
#[derive(Clone, Copy)]
struct Seen {
    sum: f32,
    count: f32,
    low: f32,
    high: f32,
}

impl Seen {
    const NOTHING: Self = Self { sum: 0.0, count: 0.0, low: f32::INFINITY, high: f32::NEG_INFINITY };

    #[inline(always)]
    fn add(&mut self, disparities: &[f32; LANES], valid: &Lanes<i32>) {
        for lane in 0..LANES {
            if valid.0[lane] != 0 {
                self.sum += disparities[lane];
                self.count += 1.0;
                (self.low, self.high) = (self.low.min(disparities[lane]), self.high.max(disparities[lane]));
            }
        }
    }
}

impl Unseen {
    /// Resets the state for another tile.
    pub fn begin(&mut self, movement: &Option<Movement>) {
        self.movement = if let Some(Movement::Disparity(_, movement)) = movement { *movement } else { f32::INFINITY };
        self.packets.clear();
    }

    /// Adds the next packet.
    #[inline(always)]
    pub fn push(&mut self, pixels: &PixelPacket, rank: u32, has_samples: bool) {
        self.add((pixels.ids.lens[0], pixels.ids.packet), pixels.valid, rank, has_samples);
    }

    #[inline(always)]
    fn add(&mut self, (lens, place): (u32, Option<[u32; 2]>), valid: Lanes<i32>, rank: u32, has_samples: bool) {
        // Packets with pixels behind several microlenses are always traced.
        let eight = place.map_or(0, |place| (morton(place) / EIGHT) as usize);
        let is_traced = has_samples || place.is_none() || rank < RANKS / EIGHT;
        let sight = if is_traced { Sight::Traced } else { Sight::Unknown };
        self.packets.push(Packet { lens, eight, valid, sight });
    }

    /// Whether a packet is traced to its first hits at once.
    #[inline(always)]
    pub fn is_traced(&self, packet: usize) -> bool {
        self.packets.get(packet).is_none_or(|packet| packet.sight == Sight::Traced)
    }

    /// Whether a packet is to be traced because others do not tell what it shows.
    #[inline(always)]
    pub fn is_missing(&self, packet: usize) -> bool {
        self.packets.get(packet).is_some_and(|packet| packet.sight == Sight::Unknown)
    }

    /// Gives packets that were not traced the disparities of others behind their microlens where these are alike. Returns
    /// whether any packets are still missing.
    pub fn fill(&mut self, guides: &mut Guides) -> bool {
        let mut is_any_missing = false;
        let mut first = 0;
        for lens in self.packets.chunk_by_mut(|a, b| a.lens == b.lens) {
            let last = first + lens.len();
            let mut all = Seen::NOTHING;
            let mut of_eights = vec![Seen::NOTHING; lens.iter().map(|packet| packet.eight + 1).max().unwrap_or(0)];
            for (k, packet) in (first..last).zip(&*lens).filter(|(_, packet)| packet.sight == Sight::Traced) {
                all.add(guides.disparity(k), &packet.valid);
                of_eights[packet.eight].add(guides.disparity(k), &packet.valid);
            }
            // Not so if one of them is no number, or if there is none: not every group of eight has all its packets.
            let parting_px = (all.high - all.low) * self.movement * FARTHEST;
            let is_alike = all.count > 0.0 && parting_px <= MAX_PARTING_PX && all.sum.is_finite();
            for (k, packet) in (first..last).zip(lens).filter(|(_, packet)| packet.sight == Sight::Unknown) {
                if is_alike {
                    let own = &of_eights[packet.eight];
                    let near = if own.count > 0.0 { own } else { &all };
                    guides.add_disparity(k, &[near.sum / near.count; LANES]);
                    packet.sight = Sight::Known;
                }
                is_any_missing |= !is_alike;
            }
            first = last;
        }
        is_any_missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rank;
    use holo_core::Disparity;

    /// The packets behind two microlenses, whose pixels have these disparities if they are traced.
    fn filled(of: impl Fn(u32, u32, usize) -> f32) -> (Unseen, Guides, bool) {
        let map = Disparity::new(1.0, 1.0, holo_core::Projection::Perspective).expect("a disparity");
        let (mut unseen, mut guides) = (Unseen::default(), Guides::default());
        unseen.begin(&Some(Movement::Disparity(map, 1.0)));
        guides.begin(1, 128);
        let mut valid = Lanes([-1; LANES]);
        valid.0[LANES - 1] = 0;
        for lens in 0..2 {
            for packet in 0..64 {
                let place = [packet / 8, packet % 8];
                let rank = rank(5, lens, place);
                unseen.add((lens, Some(place)), valid, rank, rank < 4);
                let k = (64 * lens + packet) as usize;
                if unseen.is_traced(k) {
                    guides.add_disparity(k, &std::array::from_fn(|lane| of(lens, packet, lane)));
                }
            }
        }
        let is_any_missing = unseen.fill(&mut guides);
        (unseen, guides, is_any_missing)
    }

    #[test]
    fn packets_take_the_disparity_of_their_eight() {
        // Lanes without a pixel say nothing; between the rows of packets the disparity changes a little.
        let of = |_: u32, packet: u32, lane: usize| if lane == LANES - 1 { 9.0 } else { (packet / 32) as f32 * 0.01 };
        let (unseen, guides, is_any_missing) = filled(of);
        assert!(!is_any_missing && (0..128).filter(|&k| unseen.is_traced(k)).count() == 16);
        for k in (0..128).filter(|&k| !unseen.is_traced(k)) {
            let expected = of(0, k as u32 % 64, 0);
            assert!(guides.disparity(k).iter().all(|&found| (found - expected).abs() < 1e-6), "{k}");
        }
    }

    #[test]
    fn microlenses_of_which_nothing_is_seen_are_traced() {
        let (mut unseen, mut guides) = (Unseen::default(), Guides::default());
        unseen.begin(&Some(Movement::Statistics));
        guides.begin(1, 3);
        for packet in 0..3 {
            unseen.add((7, Some([0, packet])), Lanes([-1; LANES]), RANKS - 1, false);
        }
        assert!((0..3).all(|k| !unseen.is_traced(k)));
        assert!(unseen.fill(&mut guides));
        assert!((0..3).all(|k| unseen.is_missing(k) && *guides.disparity(k) == [0.0; LANES]));
    }

    #[test]
    fn edges_and_what_is_no_number_are_traced() {
        for edge in [0.02, -0.02, f32::INFINITY, f32::NAN] {
            let (unseen, guides, is_any_missing) =
                filled(|lens, packet, _| if lens == 1 && packet < 32 { edge } else { 0.0 });
            assert!(is_any_missing, "{edge}");
            for k in 0..128 {
                assert!(!unseen.is_missing(k) || k >= 64, "{edge}: {k}");
                assert!(k < 64 || unseen.is_missing(k) || (unseen.packets[k].sight == Sight::Traced));
                assert!(!unseen.is_missing(k) || *guides.disparity(k) == [0.0; LANES]);
            }
        }
    }
}
