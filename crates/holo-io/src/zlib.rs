//! zlib streams: made of bands that are compressed side by side, and read back piece by piece.
//!
//! Every band but the last ends in an empty stored block (deflate's "sync flush"), so it ends on a whole byte and the
//! bands can simply follow one another. Nothing in a band refers back to an earlier one: that costs a few hundred bytes
//! a band, and makes the result the same for any number of threads.

#[cfg(feature = "mat")]
mod inflate;
#[cfg(feature = "mat")]
mod pieces;

use zlib_rs::{DeflateConfig, DeflateFlush, Method, Strategy};

#[cfg(feature = "mat")]
pub(crate) use inflate::Inflated;
#[cfg(feature = "mat")]
pub(crate) use pieces::{Piece, Stream};

/// Bytes of a band that the two strategies are tried on: three rows of an 8K image and twice deflate's window.
const SAMPLE_BYTES: usize = 64 << 10;

/// The header of a zlib stream with a window of 32 KiB and ordinary effort.
pub(crate) const ZLIB_HEADER: [u8; 2] = [0x78, 0x9c];

const ADLER_BASE: u32 = 65_521;

/// The ways to compress a band.
///
/// Rendered images are noisy or they repeat. In noise, deflate's search for repetitions finds only short accidental
/// ones, which cost more bits than they save; run lengths with a good Huffman code are smaller and three times as fast.
/// Where rows do repeat the search wins tenfold. No setting suits both, but a sample tells them apart.
const CHOICES: [(Strategy, i32); 2] = [(Strategy::Rle, 6), (Strategy::Default, 6)];

/// Compresses a band with the strategy that suits it.
pub(crate) fn deflate_band(filtered: &[u8], is_last: bool) -> std::io::Result<Vec<u8>> {
    // From the middle, because a band that begins at an edge of the picture is not typical there.
    let start = filtered.len().saturating_sub(SAMPLE_BYTES) / 2;
    let sample = &filtered[start..filtered.len().min(start + SAMPLE_BYTES)];
    let mut best = (usize::MAX, CHOICES[0]);
    for choice in CHOICES {
        let size = deflate(sample, choice, DeflateFlush::Finish)?.len();
        if size < best.0 {
            best = (size, choice);
        }
    }
    deflate(filtered, best.1, if is_last { DeflateFlush::Finish } else { DeflateFlush::SyncFlush })
}

/// Returns raw deflate data.
fn deflate(data: &[u8], (strategy, level): (Strategy, i32), flush: DeflateFlush) -> std::io::Result<Vec<u8>> {
    let config = DeflateConfig { level, method: Method::Deflated, window_bits: -15, mem_level: 8, strategy };
    crate::deflate::deflate(data, config, flush)
}

/// The checksum at the end of a zlib stream.
pub(crate) fn adler32(data: &[u8]) -> u32 {
    let (mut a, mut b) = (1_u32, 0_u32);
    // The longest block after which the sums still fit 32 bits.
    for block in data.chunks(5552) {
        for &byte in block {
            a += u32::from(byte);
            b += a;
        }
        a %= ADLER_BASE;
        b %= ADLER_BASE;
    }
    b << 16 | a
}

/// Returns the checksum of two pieces of data, one behind the other; `length` is that of the second.
pub(crate) fn combine_adler32(first: u32, second: u32, length: usize) -> u32 {
    let base = u64::from(ADLER_BASE);
    let (a1, b1) = (u64::from(first & 0xffff), u64::from(first >> 16));
    let (a2, b2) = (u64::from(second & 0xffff), u64::from(second >> 16));
    // The second piece began with a sum of 1 instead of a1, which every one of its bytes added to b.
    let a = (a1 + a2 + base - 1) % base;
    let b = (b1 + b2 + (a1 + base - 1) % base * (length as u64 % base)) % base;
    (b << 16 | a) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_the_standard() {
        assert_eq!(adler32(b""), 1);
        assert_eq!(adler32(b"Wikipedia"), 0x11e6_0398);
        let data: Vec<u8> = (0..100_000_u32).map(|at| (at * 7 % 256) as u8 | 0xf0).collect();
        for cut in [0, 1, 5551, 5552, 65_521, 65_522, 99_999, 100_000] {
            let (first, second) = data.split_at(cut);
            assert_eq!(combine_adler32(adler32(first), adler32(second), second.len()), adler32(&data), "{cut}");
        }
    }
}
