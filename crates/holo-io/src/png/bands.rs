//! One zlib stream out of bands of rows that are compressed side by side.
//!
//! Every band but the last ends in an empty stored block (deflate's "sync flush"), so it ends on a whole byte and the
//! bands can simply follow one another. Nothing in a band refers back to an earlier one: that costs a few hundred bytes
//! a band, and makes the result the same for any number of threads.

use rayon::prelude::*;

use super::filter::Filter;
use crate::zlib::{ZLIB_HEADER, adler32, combine_adler32, deflate_band};

/// Filtered bytes in a band: enough to forget the start of a band, few enough for many threads.
const BAND_BYTES: usize = 1 << 20;

/// Rows that are gathered by one thread at least.
const MIN_ROWS: usize = 8;

/// Rows that wait to be compressed take at most this many bytes, if a band is not more.
const GROUP_BYTES: usize = 64 << 20;

/// The stream of one image, row by row.
pub(super) struct Bands {
    pixel_bytes: usize,
    row_bytes: usize,
    rows_of_band: usize,
    rows_of_group: usize,
    /// Rows that have not come yet.
    missing: usize,
    /// Whole rows that wait to be compressed, and the row above them, if there is one.
    waiting: Vec<u8>,
    above: Option<Vec<u8>>,
    adler: u32,
    /// What comes before the next band.
    head: Vec<u8>,
}

impl Bands {
    /// `row_bytes` are those of a row before it is filtered.
    pub fn new(rows: usize, row_bytes: usize, pixel_bytes: usize) -> Self {
        let rows_of_band = (BAND_BYTES / (row_bytes + 1)).max(1);
        // Only a few bands a thread are held at a time, whatever the size of the image.
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

    /// Takes `rows` more rows, which `gather` puts into place by their number, and hands what becomes of them to `take`.
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

    /// Compresses what waits.
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
