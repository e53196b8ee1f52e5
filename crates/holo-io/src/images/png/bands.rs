//! One zlib stream of bands of rows that are compressed in parallel.
//!
//! Every band but the last ends in an empty stored block (deflate's "sync flush"), so it ends on a whole byte and bands
//! can be concatenated. No band refers back to an earlier one: that costs a few hundred bytes a band, and makes the
//! result the same for any number of threads.

use rayon::prelude::*;

use super::filter::Filter;
use crate::files::zlib::{ZLIB_HEADER, adler32, combine_adler32, deflate_band};

/// Filtered bytes of a band: many compared with the cost of a band, few enough for many threads.
const BAND_BYTES: usize = 1 << 20;

/// Minimum number of rows that a thread gathers.
const MIN_ROWS: usize = 8;

/// Maximum size of the rows that wait for compression, in bytes, unless one band is larger.
const GROUP_BYTES: usize = 64 << 20;

/// The stream of one image, row by row.
pub(super) struct Bands {
    pixel_bytes: usize,
    row_bytes: usize,
    rows_of_band: usize,
    rows_of_group: usize,
    /// Rows that have not been pushed yet.
    missing: usize,
    /// Rows that wait for compression, and the row above them, if there is one.
    waiting: Vec<u8>,
    above: Option<Vec<u8>>,
    adler: u32,
    /// Bytes to write before the next band.
    head: Vec<u8>,
}

impl Bands {
    /// `row_bytes` is the size of a row without its filter byte.
    pub fn new(rows: usize, row_bytes: usize, pixel_bytes: usize) -> Self {
        let rows_of_band = (BAND_BYTES / (row_bytes + 1)).max(1);
        // A few bands a thread are in memory, whatever the size of the image.
        let group = (GROUP_BYTES / (rows_of_band * row_bytes)).clamp(1, 4 * rayon::current_num_threads());
        Self {
            pixel_bytes,
            row_bytes,
            rows_of_band,
            rows_of_group: group * rows_of_band,
            missing: rows,
            waiting: Vec::new(),
            above: None,
            adler: 1,
            head: ZLIB_HEADER.to_vec(),
        }
    }

    /// Pushes `rows` more rows: `gather` writes the row of a number into its bytes. Passes compressed bytes to `take`.
    pub fn push<E: From<std::io::Error>>(
        &mut self,
        rows: usize,
        gather: impl Fn(usize, &mut [u8]) + Sync,
        mut take: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut next = 0;
        while next < rows {
            let start = self.waiting.len();
            let count = (self.rows_of_group - start / self.row_bytes).min(rows - next);
            self.waiting.resize(start + count * self.row_bytes, 0);
            let lines = self.waiting[start..].par_chunks_exact_mut(self.row_bytes).enumerate();
            lines.with_min_len(MIN_ROWS).for_each(|(line, bytes)| gather(next + line, bytes));
            next += count;
            self.missing = self.missing.saturating_sub(count);
            if self.missing == 0 || self.waiting.len() == self.rows_of_group * self.row_bytes {
                self.compress(&mut take)?;
            }
        }
        Ok(())
    }

    /// Compresses the waiting rows.
    fn compress<E: From<std::io::Error>>(&mut self, take: &mut impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let bands: Vec<&[u8]> = self.waiting.chunks(self.rows_of_band * self.row_bytes).collect();
        let compressed: Vec<std::io::Result<(Vec<u8>, u32, usize)>> = (0..bands.len())
            .into_par_iter()
            .map(|number| {
                let mut filter = Filter::new(self.row_bytes, self.pixel_bytes);
                let above = match number.checked_sub(1) {
                    Some(before) => Some(&bands[before][bands[before].len() - self.row_bytes..]),
                    None => self.above.as_deref(),
                };
                if let Some(above) = above {
                    filter.set_above(above);
                }
                let rows = bands[number].chunks_exact(self.row_bytes);
                let mut filtered = Vec::with_capacity(rows.len() * (self.row_bytes + 1));
                rows.for_each(|row| filter.append(row, &mut filtered));
                let is_last = self.missing == 0 && number + 1 == bands.len();
                Ok((deflate_band(&filtered, is_last)?, adler32(&filtered), filtered.len()))
            })
            .collect();
        for band in compressed {
            let (bytes, band_adler, length) = band?;
            self.adler = combine_adler32(self.adler, band_adler, length);
            self.head.extend_from_slice(&bytes);
            take(&self.head)?;
            self.head.clear();
        }
        let above = self.above.get_or_insert_default();
        above.clear();
        above.extend_from_slice(&self.waiting[self.waiting.len() - self.row_bytes..]);
        self.waiting.clear();
        if self.missing == 0 { take(&self.adler.to_be_bytes()) } else { Ok(()) }
    }
}
