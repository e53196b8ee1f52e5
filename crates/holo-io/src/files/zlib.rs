//! zlib streams for PNG, OpenEXR and MAT: compression in parallel, with the one of two strategies that is worth its time,
//! and decompression piece by piece.
//!
//! Every band but the last ends in an empty stored block (deflate's "sync flush"), so it ends on a whole byte and bands
//! can be concatenated. No band refers back to an earlier one: that costs a few hundred bytes a band, and makes the
//! result the same for any number of threads.

mod inflate;
mod pieces;

use zlib_rs::{Deflate, DeflateConfig, DeflateFlush, Method, Status, Strategy};

pub(crate) use inflate::Inflated;
pub(crate) use pieces::{Piece, Stream};

/// Size of the sample of a band on which the strategies are compared: twice the window of deflate.
const SAMPLE_BYTES: usize = 64 << 10;

/// The header of a zlib stream with a window of 32 KiB and the default compression level.
pub(crate) const ZLIB_HEADER: [u8; 2] = [0x78, 0x9c];

const ADLER_BASE: u32 = 65_521;

/// `window_bits` of deflate without header and checksum, and with them.
const RAW: i32 = -15;
const WITH_HEADER: i32 = 15;

/// Run lengths with a Huffman code: in noise, the search for repetitions finds only short accidental matches, which cost
/// more bits than they save.
const RUNS: (Strategy, i32) = (Strategy::Rle, 6);

/// The search for repetitions, where rows repeat. Of 8K images level 6 is 1 to 4 % smaller and takes 1.2 to 2.1 times as
/// long (elemental images the most of both).
const SEARCH: (Strategy, i32) = (Strategy::Default, 3);

/// The search takes twice as long, so it must save this part of the size.
const WORTH_OF_SEARCH: usize = 16;

/// Compresses a band with the strategy that is worth its time to raw deflate data, which another band may follow unless it is the last.
pub(crate) fn deflate_band(filtered: &[u8], is_last: bool) -> std::io::Result<Vec<u8>> {
    deflate_well(filtered, RAW, if is_last { DeflateFlush::Finish } else { DeflateFlush::SyncFlush })
}

/// Compresses data with the strategy that is worth its time to a complete zlib stream, with header and checksum.
pub(crate) fn zlib_stream(data: &[u8]) -> std::io::Result<Vec<u8>> {
    deflate_well(data, WITH_HEADER, DeflateFlush::Finish)
}

fn deflate_well(data: &[u8], window_bits: i32, flush: DeflateFlush) -> std::io::Result<Vec<u8>> {
    // From the middle, because the edge of an image is not typical.
    let start = data.len().saturating_sub(SAMPLE_BYTES) / 2;
    let sample = &data[start..data.len().min(start + SAMPLE_BYTES)];
    let size = |choice| Ok::<_, std::io::Error>(deflate(sample, choice, RAW, DeflateFlush::Finish)?.len());
    let runs = size(RUNS)?;
    let choice = if size(SEARCH)? + runs / WORTH_OF_SEARCH < runs { SEARCH } else { RUNS };
    deflate(data, choice, window_bits, flush)
}

/// Compresses data in memory.
fn deflate(
    data: &[u8],
    (strategy, level): (Strategy, i32),
    window_bits: i32,
    flush: DeflateFlush,
) -> std::io::Result<Vec<u8>> {
    let config = DeflateConfig { level, method: Method::Deflated, window_bits, mem_level: 8, strategy };
    let mut deflate = Deflate::new_with_config(config);
    let mut out = vec![0; data.len() / 2 + 1024];
    loop {
        let (read, written) = (deflate.total_in() as usize, deflate.total_out() as usize);
        let status = deflate
            .compress(&data[read..], &mut out[written..], flush)
            .map_err(|error| std::io::Error::other(error.as_str()))?;
        let end = deflate.total_out() as usize;
        // A flush is complete if it does not fill the buffer.
        if status == Status::StreamEnd || (end < out.len() && flush != DeflateFlush::Finish) {
            out.truncate(end);
            return Ok(out);
        }
        out.resize(out.len() * 2, 0);
    }
}

/// The Adler-32 checksum, which ends a zlib stream.
pub(crate) fn adler32(data: &[u8]) -> u32 {
    let (mut a, mut b) = (1_u32, 0_u32);
    // The longest block whose sums fit into 32 bits.
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

/// Returns the checksum of two concatenated pieces of data from theirs; `length` is that of the second piece.
pub(crate) fn combine_adler32(first: u32, second: u32, length: usize) -> u32 {
    let base = u64::from(ADLER_BASE);
    let (a1, b1) = (u64::from(first & 0xffff), u64::from(first >> 16));
    let (a2, b2) = (u64::from(second & 0xffff), u64::from(second >> 16));
    // The checksum of the second piece started with a = 1 instead of a1, and every byte of it added a to b.
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
