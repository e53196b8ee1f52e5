//! The transposition of one row of pixels in the cache.

use ndarray::ArrayView3;

/// The largest row in bytes that goes through scratch memory: two such rows take half of a usual second-level cache.
const SCRATCH_BYTES: usize = 1 << 18;

/// Columns of a longer row per block, so that the destination lines in use remain in the cache.
const BLOCK: usize = 16;

/// Source rows that are read in parallel: their pixels are neighbors in the destination.
const LANES: usize = 4;

/// Scratch memory of one task.
///
/// The strided accesses of a transposition defeat the prefetcher of the processor. Contiguous copies of the row into
/// and out of this memory leave strided accesses only within the cache.
pub(crate) struct Scratch<T> {
    source: Vec<T>,
    destination: Vec<T>,
}

impl<T: Copy> Scratch<T> {
    pub(crate) const fn new() -> Self {
        Self { source: Vec::new(), destination: Vec::new() }
    }

    /// Transposes a matrix of pixels: `destination[(column, row)] = source[(row, column)]`.
    ///
    /// Both slices hold `rows * columns` pixels of `channels` samples.
    pub(super) fn transpose(&mut self, source: &[T], destination: &mut [T], shape: [usize; 3]) {
        let [rows, columns, channels] = shape;
        debug_assert!(source.len() == rows * columns * channels && destination.len() == source.len());
        if rows == 1 || columns == 1 {
            destination.copy_from_slice(source);
        } else if size_of_val(source) <= SCRATCH_BYTES {
            self.source.clear();
            self.source.extend_from_slice(source);
            self.transpose_scratch(destination, shape);
        } else {
            transpose(source, destination, shape, BLOCK);
        }
    }

    /// Transposes a matrix of pixels `(row, column, channel)` whose rows are slices with gaps between them.
    pub(super) fn transpose_lines(&mut self, source: ArrayView3<'_, T>, destination: &mut [T]) {
        self.source.clear();
        for line in source.outer_iter() {
            self.source.extend_from_slice(line.to_slice().expect("the caller has checked every line"));
        }
        self.transpose_scratch(destination, source.dim().into());
    }

    fn transpose_scratch(&mut self, destination: &mut [T], shape: [usize; 3]) {
        // Old contents may remain: every pixel is overwritten.
        self.destination.resize(self.source.len(), self.source[0]);
        transpose(&self.source, &mut self.destination, shape, shape[1]);
        destination.copy_from_slice(&self.destination);
    }
}

fn transpose<T: Copy>(source: &[T], destination: &mut [T], [rows, columns, channels]: [usize; 3], block: usize) {
    match channels {
        1 => transpose_pixels(source, destination, rows, columns, block),
        2 => transpose_pixels(source.as_chunks::<2>().0, destination.as_chunks_mut::<2>().0, rows, columns, block),
        3 => transpose_triples(source, destination, rows, columns, block),
        4 => transpose_pixels(source.as_chunks::<4>().0, destination.as_chunks_mut::<4>().0, rows, columns, block),
        _ => {
            for (column, line) in destination.chunks_exact_mut(rows * channels).enumerate() {
                for (row, pixel) in line.chunks_exact_mut(channels).enumerate() {
                    let from = (row * columns + column) * channels;
                    pixel.copy_from_slice(&source[from..from + channels]);
                }
            }
        }
    }
}

/// The transposition for pixels of constant size, `block` columns at a time.
fn transpose_pixels<P: Copy>(source: &[P], destination: &mut [P], rows: usize, columns: usize, block: usize) {
    for (index, destination) in destination.chunks_mut(block * rows).enumerate() {
        let first = index * block;
        let count = destination.len() / rows;
        let lane = |row: usize| &source[row * columns + first..][..count];
        let mut row = 0;
        while row + LANES <= rows {
            let lanes = lane(row).iter().zip(lane(row + 1)).zip(lane(row + 2)).zip(lane(row + 3));
            for (line, (((a, b), c), d)) in destination.chunks_exact_mut(rows).zip(lanes) {
                // One by one: a temporary array of four would be stored in parts and loaded as a whole, which stalls
                // the processor.
                let [to_a, to_b, to_c, to_d] = &mut line[row..row + LANES] else { unreachable!("LANES is 4") };
                *to_a = *a;
                *to_b = *b;
                *to_c = *c;
                *to_d = *d;
            }
            row += LANES;
        }
        for row in row..rows {
            for (line, pixel) in destination.chunks_exact_mut(rows).zip(lane(row)) {
                line[row] = *pixel;
            }
        }
    }
}

/// The transposition for three samples per pixel.
///
/// Three bytes take two loads and two stores, four bytes take one each. Every pixel is therefore moved together with
/// the sample behind it, and the next pixel overwrites that sample. The last pixels of a line have no next one and are
/// moved alone.
fn transpose_triples<T: Copy>(source: &[T], destination: &mut [T], rows: usize, columns: usize, block: usize) {
    for (index, destination) in destination.chunks_mut(block * rows * 3).enumerate() {
        let first = index * block;
        let count = destination.len() / (rows * 3);
        let mut row = 0;
        // Strictly less excludes the last row, so that there is always a sample behind.
        while row + LANES < rows {
            let lane = |row: usize| source[(row * columns + first) * 3..][..count * 3 + 1].windows(4).step_by(3);
            let lanes = lane(row).zip(lane(row + 1)).zip(lane(row + 2)).zip(lane(row + 3));
            for (line, (((a, b), c), d)) in destination.chunks_exact_mut(rows * 3).zip(lanes) {
                let line = &mut line[row * 3..][..LANES * 3 + 1];
                line[0..4].copy_from_slice(a);
                line[3..7].copy_from_slice(b);
                line[6..10].copy_from_slice(c);
                line[9..13].copy_from_slice(d);
            }
            row += LANES;
        }
        for row in row..rows {
            let lane = &source[(row * columns + first) * 3..][..count * 3];
            for (line, pixel) in destination.chunks_exact_mut(rows * 3).zip(lane.as_chunks::<3>().0) {
                line[row * 3..][..3].copy_from_slice(pixel);
            }
        }
    }
}
