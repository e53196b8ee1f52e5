//! Compression of one block, in the codings that are written.

use exr::block::chunk::CompressedBlock;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::attribute::Compression;
use exr::meta::header::Header;
use exr::prelude::Vec2;

use super::samples::ByteOrder;
use crate::files::zlib::zlib_stream;

/// Compression of an EXR. All are lossless.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum ExrCompression {
    /// ZIP over blocks of 16 lines: readable by every program.
    #[default]
    Zip,
    /// ZIP over single lines: larger, for programs that read line by line.
    Zips,
    /// Wavelets over blocks of 32 lines: smaller for noisy images, slower to read.
    Piz,
    /// Uncompressed.
    None,
}

impl ExrCompression {
    pub(super) fn coding(self) -> Compression {
        match self {
            Self::Zip => Compression::ZIP16,
            Self::Zips => Compression::ZIP1,
            Self::Piz => Compression::PIZ,
            Self::None => Compression::Uncompressed,
        }
    }

    /// Lines in a block.
    pub(super) fn lines(self) -> usize {
        self.coding().scan_lines_per_block()
    }

    /// The byte order of the samples for [`compress`](Self::compress).
    pub(super) fn byte_order(self) -> ByteOrder {
        match self {
            Self::Piz => ByteOrder::Native,
            _ => ByteOrder::Little,
        }
    }

    /// Compresses the block that begins with line `first`. `samples` contains for every line all samples of the first
    /// channel, then all of the second.
    pub(super) fn compress(self, samples: Vec<u8>, first: usize, headers: &[Header]) -> exr::error::Result<Vec<u8>> {
        match self {
            Self::None => Ok(samples),
            Self::Zip | Self::Zips => {
                let compressed = zlib_stream(&differences(&samples))?;
                // A block that does not become smaller is stored uncompressed; readers recognize it by its length.
                Ok(if compressed.len() < samples.len() { compressed } else { samples })
            }
            Self::Piz => {
                let line_bytes = headers[0].channels.bytes_per_pixel * headers[0].layer_size.width();
                let size = Vec2(headers[0].layer_size.width(), samples.len() / line_bytes);
                let index =
                    BlockIndex { layer: 0, pixel_position: Vec2(0, first), pixel_size: size, level: Vec2(0, 0) };
                let chunk = UncompressedBlock { index, data: samples }.compress_to_chunk(headers)?;
                match chunk.compressed_block {
                    CompressedBlock::ScanLine(block) => Ok(block.compressed_pixels_le),
                    _ => Err(exr::error::Error::Invalid("a scanline block became another kind".into())),
                }
            }
        }
    }
}

/// The predictor of the format: the bytes at even positions, then those at odd positions, each as its difference from
/// the previous one, plus 128.
fn differences(samples: &[u8]) -> Vec<u8> {
    let half = samples.len().div_ceil(2);
    let mut apart = vec![0; samples.len()];
    let (even, odd) = apart.split_at_mut(half);
    let pairs = samples.chunks_exact(2);
    if let [last] = pairs.remainder() {
        even[half - 1] = *last;
    }
    for ((pair, even), odd) in pairs.zip(even).zip(odd) {
        [*even, *odd] = [pair[0], pair[1]];
    }
    let mut differences = apart.clone();
    for (difference, pair) in differences[1..].iter_mut().zip(apart.windows(2)) {
        *difference = pair[1].wrapping_sub(pair[0]).wrapping_add(128);
    }
    differences
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_separated_and_subtracted() {
        assert_eq!(differences(&[7]), [7]);
        assert_eq!(differences(&[10, 20, 11, 21]), [10, 129, 137, 129]);
        assert_eq!(differences(&[10, 20, 12]), [10, 130, 136]);
    }
}
