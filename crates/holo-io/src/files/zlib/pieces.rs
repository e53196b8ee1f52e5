//! A zlib stream of pieces that are compressed independently.

use std::io;

use super::{ZLIB_HEADER, adler32, combine_adler32, deflate_band};

/// An empty final block with fixed Huffman codes.
const END: [u8; 2] = [0x03, 0x00];

/// A piece of a stream: its compressed bytes, and the checksum and length of its data.
pub(crate) struct Piece {
    bytes: Vec<u8>,
    adler: u32,
    length: usize,
}

impl Piece {
    /// Compresses a piece. Pieces are independent of each other, so they can be compressed in parallel.
    pub(crate) fn compress(data: &[u8]) -> io::Result<Self> {
        // Not the last band, so it ends on a whole byte.
        Ok(Self { bytes: deflate_band(data, false)?, adler: adler32(data), length: data.len() })
    }
}

/// A writer of a zlib stream of pieces.
pub(crate) struct Stream<W> {
    out: W,
    adler: u32,
    /// Bytes written so far.
    pub(crate) bytes: u64,
}

impl<W: io::Write> Stream<W> {
    /// Begins a stream.
    pub(crate) fn new(mut out: W) -> io::Result<Self> {
        out.write_all(&ZLIB_HEADER)?;
        Ok(Self { out, adler: 1, bytes: ZLIB_HEADER.len() as u64 })
    }

    /// Appends a piece.
    pub(crate) fn push(&mut self, piece: &Piece) -> io::Result<()> {
        self.out.write_all(&piece.bytes)?;
        self.bytes += piece.bytes.len() as u64;
        self.adler = combine_adler32(self.adler, piece.adler, piece.length);
        Ok(())
    }

    /// Ends the stream and returns how many bytes it has.
    pub(crate) fn finish(mut self) -> io::Result<u64> {
        self.out.write_all(&END)?;
        self.out.write_all(&self.adler.to_be_bytes())?;
        Ok(self.bytes + END.len() as u64 + size_of::<u32>() as u64)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::super::Inflated;
    use super::*;

    #[test]
    fn pieces_of_any_length_make_one_stream() {
        let data: Vec<u8> = (0..300_000_u32).map(|at| (at / 7 % 256) as u8).collect();
        for cuts in [&[][..], &[0, 0], &[1, 299_999], &[100_000, 100_000, 200_000]] {
            let mut bytes = Vec::new();
            let mut stream = Stream::new(&mut bytes).unwrap();
            let mut start = 0;
            for &cut in cuts.iter().chain(&[data.len()]) {
                stream.push(&Piece::compress(&data[start..cut]).unwrap()).unwrap();
                start = cut;
            }
            assert_eq!(stream.finish().unwrap(), bytes.len() as u64);
            let mut back = Vec::new();
            Inflated::new(bytes.as_slice()).read_to_end(&mut back).unwrap();
            assert!(back == data);
        }
    }
}
