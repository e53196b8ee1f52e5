//! Mode ATTRIBUTES: differences of consecutive elements, byte by byte, in groups of sixteen elements.
//!
//! Version 0 is that of `EXT_meshopt_compression`; version 1 came with `KHR_meshopt_compression`. Appendix A of the
//! extension defines both; the names of the parts are those of that text.

use super::{Damage, take};

/// A group is this many elements.
const GROUP: usize = 16;

/// A block has at most this many elements.
const MAX_BLOCK: usize = 256;

/// Bytes of a block, at most; it bounds the elements of a block when they are large.
const BLOCK_BYTES: usize = 8192;

/// What a group of sixteen deltas is stored as, for each value of its two header bits: bits a delta.
const VERSION_0: [usize; 4] = [0, 2, 4, 8];
const CONTROL_0: [usize; 4] = [0, 1, 2, 4];
const CONTROL_1: [usize; 4] = [1, 2, 4, 8];

/// The deltas of one byte of all elements of a block.
type Plane = [u8; MAX_BLOCK];

/// How the deltas of four bytes of an element become values.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Shorts,
    /// Differences by XOR, which the encoder has rotated left by this many bits.
    Xor(u32),
}

impl Channel {
    fn new(code: u8) -> Result<Self, Damage> {
        match (code & 15, code >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Shorts),
            (2, bits) => Ok(Self::Xor(u32::from(bits))),
            _ => Err("a channel has an unknown mode"),
        }
    }

    /// The value after `last`, for the deltas of one element.
    fn next(self, last: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => std::array::from_fn(|k| last[k].wrapping_add(delta[k] >> 1 ^ (delta[k] & 1).wrapping_neg())),
            Self::Shorts => {
                let short = |from: [u8; 4], k: usize| u16::from_le_bytes([from[2 * k], from[2 * k + 1]]);
                let next = |k: usize| {
                    let delta = short(delta, k);
                    short(last, k).wrapping_add(delta >> 1 ^ (delta & 1).wrapping_neg()).to_le_bytes()
                };
                let ([a, b], [c, d]) = (next(0), next(1));
                [a, b, c, d]
            }
            Self::Xor(bits) => (u32::from_le_bytes(last) ^ u32::from_le_bytes(delta).rotate_right(bits)).to_le_bytes(),
        }
    }
}

/// Decodes `count` elements of `stride` bytes; `stride` is a multiple of 4 in 4..=256.
pub(super) fn decode(data: &[u8], stride: usize, count: usize) -> Result<Vec<u8>, Damage> {
    let (is_first, rest) = match data.split_first() {
        Some((0xA0, rest)) => (true, rest),
        Some((0xA1, rest)) => (false, rest),
        _ => return Err("its first byte is not that of vertex attributes"),
    };
    let (tail, least) = if is_first { (stride, 32) } else { (stride + stride / 4, 24) };
    let cut = rest.len().checked_sub(tail.max(least)).ok_or("it is cut short")?;
    let mut body = &rest[..cut];
    let (baseline, codes) = rest[rest.len() - tail..].split_at(stride);
    let channels = match codes {
        [] => vec![Channel::Bytes; stride / 4],
        codes => codes.iter().map(|&code| Channel::new(code)).collect::<Result<_, Damage>>()?,
    };

    let block = (BLOCK_BYTES / stride / GROUP * GROUP).min(MAX_BLOCK);
    // A block has at least its headers, so the size of the data bounds the memory.
    let least = count.div_ceil(block).checked_mul(if is_first { stride } else { stride / 4 });
    if least.is_none_or(|least| least > body.len()) {
        return Err("it has fewer bytes than its elements need");
    }
    let mut elements = super::zeros(count, stride)?;
    let mut last = baseline.to_vec();
    for elements in elements.chunks_mut(block * stride) {
        decode_block(&mut body, is_first, &channels, &mut last, elements)?;
    }
    if body.is_empty() { Ok(elements) } else { Err("bytes are left over") }
}

fn decode_block(
    body: &mut &[u8],
    is_first: bool,
    channels: &[Channel],
    last: &mut [u8],
    elements: &mut [u8],
) -> Result<(), Damage> {
    let stride = last.len();
    let count = elements.len() / stride;
    let controls = if is_first { &[] } else { take(body, stride / 4)? };
    let mut planes: [Plane; 4] = [[0; MAX_BLOCK]; 4];
    for (k, (channel, last)) in channels.iter().zip(last.as_chunks_mut::<4>().0).enumerate() {
        for (byte, plane) in planes.iter_mut().enumerate() {
            let control = controls.get(k).map(|controls| controls >> (2 * byte) & 3);
            match control {
                None => decode_plane(body, &VERSION_0, count, plane)?,
                Some(0) => decode_plane(body, &CONTROL_0, count, plane)?,
                Some(1) => decode_plane(body, &CONTROL_1, count, plane)?,
                Some(2) => plane.fill(0),
                Some(_) => plane[..count].copy_from_slice(take(body, count)?),
            }
        }
        for (i, element) in elements.chunks_exact_mut(stride).enumerate() {
            *last = channel.next(*last, planes.each_ref().map(|plane| plane[i]));
            element[4 * k..4 * k + 4].copy_from_slice(last);
        }
    }
    Ok(())
}

/// Decodes the deltas of one byte of `count` elements: two header bits a group, then the groups.
fn decode_plane(body: &mut &[u8], widths: &[usize; 4], count: usize, plane: &mut Plane) -> Result<(), Damage> {
    let groups = count.div_ceil(GROUP);
    let headers = take(body, groups.div_ceil(4))?;
    for (k, group) in plane.as_chunks_mut::<GROUP>().0.iter_mut().take(groups).enumerate() {
        let bits = widths[usize::from(headers[k / 4] >> (2 * (k % 4)) & 3)];
        match bits {
            0 => group.fill(0),
            8 => group.copy_from_slice(take(body, GROUP)?),
            _ => decode_group(body, bits, group)?,
        }
    }
    Ok(())
}

/// Deltas of 1, 2 or 4 bits. The largest value stands for a whole byte, which follows the group.
fn decode_group(body: &mut &[u8], bits: usize, group: &mut [u8; GROUP]) -> Result<(), Damage> {
    let packed = take(body, 2 * bits)?;
    let sentinel = (1_u8 << bits) - 1;
    let in_byte = 8 / bits;
    for (k, delta) in group.iter_mut().enumerate() {
        // Deltas of one bit begin at the lowest bit, others at the highest.
        let place = if bits == 1 { k % 8 } else { 8 - bits - k % in_byte * bits };
        *delta = packed[k / in_byte] >> place & sentinel;
        if *delta == sentinel {
            *delta = take(body, 1)?[0];
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_specification() {
        let mut body = &[0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5][..];
        let mut group = [0; GROUP];
        decode_group(&mut body, 4, &mut group).unwrap();
        assert!(body.is_empty());
        let deltas = group.map(|delta| Channel::Bytes.next([0; 4], [delta; 4])[0] as i8);
        assert_eq!(deltas, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        assert!(decode_group(&mut &[0xFF; 8][..], 4, &mut group).is_err());
    }

    #[test]
    fn groups_of_one_and_two_bits() {
        let mut group = [0; GROUP];
        decode_group(&mut &[0b1000_0001, 0b0000_0010, 7, 8, 9][..], 1, &mut group).unwrap();
        assert_eq!(group, [7, 0, 0, 0, 0, 0, 0, 8, 0, 9, 0, 0, 0, 0, 0, 0]);
        decode_group(&mut &[0b0001_1011, 0, 0, 0b0000_0010, 200][..], 2, &mut group).unwrap();
        assert_eq!(group, [0, 1, 2, 200, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2]);
    }

    #[test]
    fn channels_by_hand() {
        // Zigzag: 1 is -1, 2 is +1, across 16 bits.
        assert_eq!(Channel::Shorts.next([0, 0, 255, 0], [1, 0, 2, 0]), [255, 255, 0, 1]);
        assert_eq!(Channel::Bytes.next([0, 0, 255, 9], [1, 0, 2, 4]), [255, 0, 0, 11]);
        assert_eq!(Channel::Xor(8).next([1, 0, 0, 0], [0, 0x80, 0, 0]), [0x81, 0, 0, 0]);
        assert_eq!(Channel::Xor(0).next([1, 2, 3, 4], [1, 0, 0, 1]), [0, 2, 3, 5]);
        assert!(Channel::new(3).is_err() && Channel::new(0x10).is_err() && Channel::new(0x21 + 1).is_ok());
    }

    #[test]
    fn a_stream_of_version_1_by_hand() {
        // Two elements of four bytes: byte 0 literal, byte 1 without change, byte 2 in one-bit groups, byte 3 zero.
        let mut data = vec![0xA1, 0b1000_1011];
        data.extend([2, 4]);
        data.extend([0b01, 0b10, 0, 20]);
        // The tail: padding to 24 bytes, baseline, channel modes.
        data.extend([0; 24 - 5]);
        data.extend([10, 20, 30, 40, 0]);
        assert_eq!(decode(&data, 4, 2).unwrap(), [11, 20, 30, 40, 13, 20, 40, 40]);
        // One element more needs a literal more.
        assert!(decode(&data, 4, 3).is_err());
        assert!(decode(&data, 4, 1).is_err(), "a literal is left over");
        assert!(decode(&data, 4, usize::MAX / 4).is_err());
        *data.last_mut().unwrap() = 7;
        assert!(decode(&data, 4, 2).is_err(), "mode 7 of a channel");
    }
}
