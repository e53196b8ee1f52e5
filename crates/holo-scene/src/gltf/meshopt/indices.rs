//! Modes TRIANGLES and INDICES: vertex indices from recent edges and vertices, or as differences.

use super::{Damage, take};

/// The first bytes of the two modes.
const TRIANGLES: u8 = 0xE1;
const INDICES: u8 = 0xD1;

/// The most recent sixteen entries.
struct Recent<T> {
    entries: [T; 16],
    pushed: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { entries: [T::default(); 16], pushed: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.pushed % 16] = entry;
        self.pushed += 1;
    }

    /// The entry `age` pushes before the last one; `age` is below 16.
    fn get(&self, age: u8) -> Result<T, Damage> {
        let back = self.pushed.checked_sub(1 + usize::from(age)).ok_or("it refers to a vertex before the first")?;
        Ok(self.entries[back % 16])
    }
}

/// What the codes of triangles refer to.
struct State<'d> {
    data: &'d [u8],
    /// The first index that was not used yet.
    next: u32,
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

impl State<'_> {
    fn take_next(&mut self) -> u32 {
        let next = self.next;
        self.next = next.wrapping_add(1);
        next
    }

    /// An index in the data, as the difference to the last one there.
    fn explicit(&mut self) -> Result<u32, Damage> {
        let code = varint(&mut self.data)?;
        self.last = self.last.wrapping_add(code >> 1 ^ (code & 1).wrapping_neg());
        Ok(self.last)
    }

    /// A vertex by four bits: 0 a new one, 15 in the data, otherwise a recent one. Also whether it is not a recent one.
    fn vertex(&mut self, code: u8) -> Result<(u32, bool), Damage> {
        match code {
            0 => Ok((self.take_next(), true)),
            15 => Ok((self.explicit()?, true)),
            age => Ok((self.vertices.get(age - 1)?, false)),
        }
    }

    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], Damage> {
        let (high, low) = (code >> 4, code & 15);
        if high == 15 {
            return self.free_triangle(low, table);
        }
        let [a, b] = self.edges.get(high)?;
        let c = match low {
            0 => self.take_next(),
            15 => self.explicit()?,
            13 | 14 => {
                self.last = if low == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                self.last
            }
            age => self.vertices.get(age)?,
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if !(1..13).contains(&low) {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle that shares no recent edge.
    fn free_triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], Damage> {
        let others = if code < 14 {
            table[usize::from(code)]
        } else {
            let others = take(&mut self.data, 1)?[0];
            if others == 0 {
                self.next = 0;
            }
            others
        };
        let a = if code == 15 { self.explicit()? } else { self.take_next() };
        let (b, b_is_new) = self.vertex(others >> 4)?;
        let (c, c_is_new) = self.vertex(others & 15)?;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        self.vertices.push(a);
        if b_is_new {
            self.vertices.push(b);
        }
        if c_is_new {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }
}

/// Decodes `count` indices of triangles, `count` a multiple of 3, to integers of `stride` bytes (2 or 4).
pub(super) fn decode_triangles(data: &[u8], stride: usize, count: usize) -> Result<Vec<u8>, Damage> {
    let mut data = data;
    if take(&mut data, 1)? != [TRIANGLES] {
        return Err("its first byte is not that of triangles");
    }
    let codes = take(&mut data, count / 3)?;
    let (data, table) = data.split_at_checked(data.len().wrapping_sub(16)).ok_or("it is cut short")?;
    if table[14..] != [0, 0] || table.iter().any(|entry| entry >> 4 == 15 || entry & 15 == 15) {
        return Err("the table at its end is invalid");
    }
    let mut state = State { data, next: 0, last: 0, edges: Recent::new(), vertices: Recent::new() };
    let mut indices = super::zeros(count, stride)?;
    for (&code, out) in codes.iter().zip(indices.chunks_exact_mut(3 * stride)) {
        let triangle = state.triangle(code, table)?;
        triangle.into_iter().zip(out.chunks_exact_mut(stride)).for_each(|(index, out)| write(index, out));
    }
    if state.data.is_empty() { Ok(indices) } else { Err("bytes are left over") }
}

/// Decodes `count` indices in any order to integers of `stride` bytes (2 or 4).
pub(super) fn decode_indices(data: &[u8], stride: usize, count: usize) -> Result<Vec<u8>, Damage> {
    let mut data = data;
    if take(&mut data, 1)? != [INDICES] {
        return Err("its first byte is not that of indices");
    }
    // Four bytes of padding.
    let (mut data, _) = data.split_at_checked(data.len().wrapping_sub(4)).ok_or("it is cut short")?;
    if data.len() < count {
        return Err("it has fewer bytes than its indices need");
    }
    let mut last = [0_u32; 2];
    let mut indices = super::zeros(count, stride)?;
    for out in indices.chunks_exact_mut(stride) {
        let code = varint(&mut data)?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(code >> 2 ^ (code >> 1 & 1).wrapping_neg());
        write(*last, out);
    }
    if data.is_empty() { Ok(indices) } else { Err("bytes are left over") }
}

/// Two bytes keep the lower half of an index.
fn write(index: u32, out: &mut [u8]) {
    out.copy_from_slice(&index.to_le_bytes()[..out.len()]);
}

/// Seven bits a byte, the lowest first, at most five bytes; higher bits are ignored.
fn varint(data: &mut &[u8]) -> Result<u32, Damage> {
    let mut value = 0;
    for place in 0..5 {
        let byte = take(data, 1)?[0];
        value |= u32::from(byte & 0x7F) << (7 * place);
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err("an index has more than five bytes")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(bytes: Vec<u8>) -> Vec<u32> {
        bytes.as_chunks().0.iter().copied().map(u32::from_le_bytes).collect()
    }

    #[test]
    fn varints_of_the_specification() {
        // The text prints 0x1FD005 for the last one, which is the other order of bytes than in the example before it.
        for (mut bytes, value) in [(&[0x7F][..], 0x7F), (&[0x81, 0x04], 0x201), (&[0xFF, 0xA0, 0x05], 0x1_507F)] {
            assert_eq!(varint(&mut bytes), Ok(value));
        }
        assert_eq!(varint(&mut &[0xFF, 0xFF, 0xFF, 0xFF, 0x7F][..]), Ok(u32::MAX));
        assert!(varint(&mut &[0x80; 5][..]).is_err() && varint(&mut &[0x80][..]).is_err());
    }

    /// Every kind of code, with the triangles that the rules of the specification give.
    #[test]
    fn triangles_by_hand() {
        let cases: [(&[u8], &[u8], &[u32]); 6] = [
            // Three new vertices, then an edge of it (the last: 0-2) and a new vertex, then a recent vertex.
            (&[0xF0, 0x00, 0x12], &[], &[0, 1, 2, 0, 2, 3, 3, 2, 1]),
            // Entry 1 of the table: a new vertex and the two most recent ones.
            (&[0xF0, 0xF1], &[], &[0, 1, 2, 3, 2, 1]),
            // All three in the data: 5, 5 + 2, 7 - 4; then 3 - 1 and 2 + 1 with the most recent edge.
            (&[0xFF, 0x0D, 0x0E], &[0xFF, 10, 4, 7], &[5, 7, 3, 5, 3, 2, 5, 2, 3]),
            // One in the data behind an edge.
            (&[0xF0, 0x2F], &[18], &[0, 1, 2, 1, 0, 9]),
            // A new vertex, the most recent one, and one in the data.
            (&[0xF0, 0xFE], &[0x1F, 8], &[0, 1, 2, 3, 2, 4]),
            // New vertices begin at 0 again.
            (&[0xF0, 0xFE], &[0x00], &[0, 1, 2, 0, 1, 2]),
        ];
        let table = [0, 0x12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        for (codes, data, expected) in cases {
            let whole = [&[TRIANGLES], codes, data, &table].concat();
            let count = 3 * codes.len();
            assert_eq!(words(decode_triangles(&whole, 4, count).unwrap()), expected, "{codes:x?}");
            let short: Vec<u8> = expected.iter().flat_map(|&k| (k as u16).to_le_bytes()).collect();
            assert_eq!(decode_triangles(&whole, 2, count).unwrap(), short);
            // One triangle more or fewer, or a byte more.
            assert!(decode_triangles(&whole, 4, count + 3).is_err());
            assert!(decode_triangles(&whole, 4, count - 3).is_err());
            assert!(decode_triangles(&[&whole[..], &[0]].concat(), 4, count).is_err());
        }
    }

    #[test]
    fn triangles_before_the_first_are_errors() {
        let decode = |code: u8, table: [u8; 16]| decode_triangles(&[&[TRIANGLES, code][..], &table].concat(), 4, 3);
        assert!(decode(0xF0, [0; 16]).is_ok());
        // An edge, a vertex.
        assert!(decode(0x00, [0; 16]).is_err());
        let mut table = [0; 16];
        table[0] = 0x10;
        assert!(decode(0xF0, table).is_err());
        // Invalid tables.
        for (k, entry) in [(15, 1), (14, 0x10), (3, 0x0F), (3, 0xF0)] {
            let mut table = [0; 16];
            table[k] = entry;
            assert!(decode(0xF0, table).is_err());
        }
    }

    #[test]
    fn indices_by_hand() {
        // Against the first baseline +3, against the second -1 (wrapping), the first +1, the second +2.
        let data = [INDICES, 3 << 2, 0b011, 1 << 2, 2 << 2 | 1, 0, 0, 0, 0];
        assert_eq!(words(decode_indices(&data, 4, 4).unwrap()), [3, u32::MAX, 4, 1]);
        assert_eq!(decode_indices(&data, 2, 4).unwrap(), [3, 0, 255, 255, 4, 0, 1, 0]);
        assert!(decode_indices(&data, 4, 3).is_err() && decode_indices(&data, 4, 5).is_err());
        assert!(decode_indices(&data, 4, usize::MAX / 8).is_err());
    }
}
