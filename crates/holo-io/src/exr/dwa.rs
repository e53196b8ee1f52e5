//! The sizes that a DWA block announces, checked before the decoder believes them.
//!
//! A DWA block begins with eleven 64-bit counters. The crate `exr` 1.74 allocates what they say, and an allocation that
//! fails ends the process, which no net catches. So they are compared with what a block of that size can hold.

use exr::block::chunk::CompressedBlock;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;

/// Whether a block may be handed to the decoder. Every block of another coding may.
pub(super) fn is_plausible(header: &Header, block: &CompressedBlock) -> exr::error::Result<bool> {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(true);
    }
    let bytes = match block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(true),
    };
    let area = header.get_absolute_block_pixel_coordinates(header.get_block_data_indices(block)?)?.size;
    let (width, height) = (area.width() as u64, area.height() as u64);
    let uncompressed = width.saturating_mul(height).saturating_mul(header.channels.bytes_per_pixel as u64);
    // Such a block is not compressed.
    if bytes.len() as u64 == uncompressed {
        return Ok(true);
    }
    // The transform works on 8 x 8 pixels of one channel, so a block is padded to whole ones.
    let padded = width.next_multiple_of(8).saturating_mul(height.next_multiple_of(8));
    let coefficients = padded.saturating_mul(header.channels.list.len() as u64);
    let at_most = [
        // Number of the counter, and its bound: what is neither transformed nor run-length coded,
        (1, uncompressed),
        // run-length codes (one byte of a code for one of data at worst), and what they stand for,
        (6, uncompressed.saturating_mul(2).saturating_add(2)),
        (7, uncompressed),
        // and the two kinds of coefficients.
        (8, coefficients),
        (9, coefficients),
    ];
    // A block that ends early is the decoder's to refuse.
    let counter = |index: usize| Some(u64::from_le_bytes(*bytes.get(8 * index..)?.first_chunk()?));
    Ok(at_most.iter().all(|&(index, bound)| counter(index).is_none_or(|counter| counter <= bound)))
}
