//! The check of the sizes that a DWA block announces.
//!
//! A DWA block begins with eleven 64-bit counters. The crate `exr` 1.74 allocates by them without a check, and an
//! allocation that fails ends the process, which no panic guard prevents. So they are compared with the maximum for a
//! block of that size.

use exr::block::chunk::CompressedBlock;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;

/// Whether a block can be passed to the decoder; true for every block of another coding.
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
    // A block of this length is not compressed.
    if bytes.len() as u64 == uncompressed {
        return Ok(true);
    }
    // The transform works on 8 x 8 pixels of one channel, so a block is padded to whole ones.
    let padded = width.next_multiple_of(8).saturating_mul(height.next_multiple_of(8));
    let coefficients = padded.saturating_mul(header.channels.list.len() as u64);
    let at_most = [
        // Index of a counter and its bound: data that are neither transformed nor run-length coded,
        (1, uncompressed),
        // run-length codes (at worst one byte of code for one of data) and the data of these codes,
        (6, uncompressed.saturating_mul(2).saturating_add(2)),
        (7, uncompressed),
        // and the two kinds of coefficients.
        (8, coefficients),
        (9, coefficients),
    ];
    // The decoder refuses a block that ends early.
    let counter = |index: usize| Some(u64::from_le_bytes(*bytes.get(8 * index..)?.first_chunk()?));
    Ok(at_most.iter().all(|&(index, bound)| counter(index).is_none_or(|counter| counter <= bound)))
}
