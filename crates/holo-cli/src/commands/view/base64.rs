//! Base64 (RFC 4648) as a stream: bytes go through in blocks, so that a file of any size needs the memory of one.

use std::io::{self, Read, Write};

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Bytes of one block: a multiple of three, so that only the last one is padded.
pub const BLOCK_BYTES: usize = 3 << 20;

/// Fills as much of `block` as `source` still gives, and returns how much that is.
///
/// # Errors
///
/// Those of `source`.
pub fn read_block(source: &mut impl Read, block: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < block.len() {
        match source.read(&mut block[filled..]) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// Writes `bytes` in base64, padded.
///
/// # Errors
///
/// Those of `out`.
pub fn write(out: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    // Text of a whole number of groups at a time: `out` is called a few times a block and not a million times.
    let mut text = Vec::with_capacity(64 << 10);
    for part in bytes.chunks(48 << 10) {
        text.clear();
        for group in part.chunks(3) {
            let at = |index: usize| u32::from(group.get(index).copied().unwrap_or(0));
            let bits = at(0) << 16 | at(1) << 8 | at(2);
            for digit in 0..4 {
                let filled = digit <= group.len();
                text.push(if filled { ALPHABET[(bits >> (18 - 6 * digit) & 63) as usize] } else { b'=' });
            }
        }
        out.write_all(&text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> String {
        let mut out = Vec::new();
        write(&mut out, bytes).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// The examples of RFC 4648, section 10.
    #[test]
    fn the_rfc_s_examples() {
        for (bytes, expected) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")]
        {
            assert_eq!(text(bytes.as_bytes()), expected);
        }
        assert_eq!(text(&[0xfb, 0xff, 0xfe]), "+//+");
    }

    /// The parts of 48 KiB and the blocks are joined without padding between them.
    #[test]
    fn parts_join_without_a_seam() {
        const { assert!(BLOCK_BYTES.is_multiple_of(3) && (48 << 10) % 3 == 0) };
        let bytes: Vec<u8> = (0..150_001_u32).map(|x| ((x * 7) >> 3) as u8).collect();
        let whole = text(&bytes);
        assert_eq!(whole.len(), bytes.len().div_ceil(3) * 4);
        assert_eq!(whole.find('='), Some(whole.len() - 2));
        let groups: String = bytes.chunks(3).map(text).collect();
        assert!(whole == groups);
    }

    /// A source that gives a byte at a time fills blocks all the same.
    #[test]
    fn blocks_are_full_until_the_end() {
        struct Slow<'a>(&'a [u8]);
        impl Read for Slow<'_> {
            fn read(&mut self, block: &mut [u8]) -> io::Result<usize> {
                let count = self.0.len().min(1).min(block.len());
                block[..count].copy_from_slice(&self.0[..count]);
                self.0 = &self.0[count..];
                Ok(count)
            }
        }
        let (mut slow, mut block) = (Slow(b"12345"), [0; 3]);
        assert_eq!(read_block(&mut slow, &mut block).unwrap(), 3);
        assert_eq!(read_block(&mut slow, &mut block).unwrap(), 2);
        assert_eq!(read_block(&mut slow, &mut block).unwrap(), 0);
    }
}
