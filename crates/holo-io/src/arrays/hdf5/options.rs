//! Ground truth maps and storage options of a file.

/// A ground truth map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Hdf5Map {
    /// Planar depth in meters, `+infinity` without a hit.
    Depth,
    /// Length of the ray from the camera to the hit in meters, `+infinity` without a hit.
    RayLength,
    /// Disparity in pixels between horizontally adjacent views.
    Disparity,
}

impl Hdf5Map {
    /// All maps.
    pub const ALL: [Self; 3] = [Self::Depth, Self::RayLength, Self::Disparity];

    /// Returns the name of the dataset.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth_m",
            Self::RayLength => "ray_length_m",
            Self::Disparity => "disparity_px",
        }
    }

    /// Returns the unit, as in the attribute `units`.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Depth | Self::RayLength => "m",
            Self::Disparity => "px",
        }
    }
}

/// Storage options of an HDF5 file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Hdf5Options {
    /// Level of gzip after shuffle, 1 to 9; 0 stores samples uncompressed. `None`: by the shape, like chunks. Light fields of
    /// up to 10 views along both axes are uncompressed, because training reads their views at random: 1,200 of 512 x 512 px a
    /// second instead of 93, in files half as large again (with h5py, on one AMD EPYC core). Others have level 1.
    pub gzip_level: Option<u8>,
    /// Lens rows, lens columns, view rows and view columns of a chunk; `None` for a chunk by the shape: of up to 10 views
    /// along an axis it has one, so that a view is read alone; of more a tenth of them, as a compromise between views and
    /// elemental images. Each chunk contains all channels.
    pub chunk: Option<[usize; 4]>,
}

impl Default for Hdf5Options {
    /// Compression and chunks by the shape; gzip has level 1, the fastest, because noisy radiance compresses little better at
    /// higher levels.
    fn default() -> Self {
        Self { gzip_level: None, chunk: None }
    }
}

/// Pixels of a default chunk: 48 KB of three floats each.
const CHUNK_PIXELS: usize = 4096;

/// A default chunk has one of so many views along an axis.
const VIEWS_A_CHUNK: usize = 10;

/// Maximum size of the lens rows of a default chunk in bytes, where reducing its rows can reach it.
const MAX_BAND_BYTES: usize = 256 << 20;

impl Hdf5Options {
    /// Sets the level of gzip, 0 to 9.
    #[must_use]
    pub const fn gzip_level(mut self, level: u8) -> Self {
        self.gzip_level = Some(level);
        self
    }

    /// Sets the lens rows, lens columns, view rows and view columns of a chunk; `None` for the default.
    #[must_use]
    pub const fn chunk(mut self, chunk: Option<[usize; 4]>) -> Self {
        self.chunk = chunk;
        self
    }

    /// Returns the level of gzip for a dataset of this shape.
    pub(crate) fn gzip_level_of(&self, shape: &[usize]) -> u8 {
        let has_few_views = matches!(shape, [_, _, rows, columns, ..] if rows.max(columns) <= &VIEWS_A_CHUNK);
        self.gzip_level.unwrap_or(u8::from(!has_few_views))
    }

    /// Returns the chunk for a dataset of this shape, not larger than the dataset.
    ///
    /// All lens rows of a chunk are in memory when it is written. Where they exceed `MAX_BAND_BYTES`, the default chunk
    /// gets fewer lens rows and more lens columns.
    pub(crate) fn chunk_of(&self, shape: &[usize], element_bytes: usize) -> Vec<usize> {
        let mut wanted = self.chunk.unwrap_or_else(|| chunk_by_shape(shape));
        let row_bytes = shape[1..].iter().product::<usize>().saturating_mul(element_bytes);
        while self.chunk.is_none() && wanted[0] > 1 && row_bytes.saturating_mul(wanted[0]) > MAX_BAND_BYTES {
            wanted[0] /= 2;
            wanted[1] *= 2;
        }
        let side = |(axis, &count): (usize, &usize)| wanted.get(axis).map_or(count, |&side| side.clamp(1, count));
        shape.iter().enumerate().map(side).collect()
    }
}

/// The default chunk of a dataset of this shape, before its lens rows are limited.
fn chunk_by_shape(shape: &[usize]) -> [usize; 4] {
    let [rows, columns] = [2, 3].map(|axis| shape.get(axis).map_or(1, |count| count.div_ceil(VIEWS_A_CHUNK)).max(1));
    let lenses = (CHUNK_PIXELS / (rows * columns)).max(1);
    // A power of two near the root.
    let lens_rows = 1 << (lenses.ilog2() / 2);
    [lens_rows, lenses / lens_rows, rows, columns]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_have_fewer_rows_where_rows_are_large() {
        let chunk = |shape: [usize; 5], bytes| Hdf5Options::default().chunk_of(&shape, bytes);
        assert_eq!(chunk([53, 79, 100, 100, 3], 4), [4, 10, 10, 10, 3]);
        assert_eq!(chunk([3, 2, 5, 100, 1], 4), [3, 2, 1, 10, 1]);
        // 64K pixels across.
        assert_eq!(chunk([430, 655, 100, 100, 3], 4), [2, 20, 10, 10, 3]);
        assert_eq!(chunk([430, 655, 100, 100, 3], 1), [4, 10, 10, 10, 3]);
        let own = Hdf5Options { chunk: Some([4, 4, 10, 10]), ..Hdf5Options::default() };
        assert_eq!(own.chunk_of(&[430, 655, 100, 100, 3], 4), [4, 4, 10, 10, 3]);
    }

    #[test]
    fn few_views_are_read_one_by_one() {
        let chunk = |shape: &[usize]| Hdf5Options::default().chunk_of(shape, 4);
        assert_eq!(chunk(&[512, 512, 9, 9, 3]), [64, 64, 1, 1, 3]);
        assert_eq!(chunk(&[265, 397, 20, 20, 3]), [32, 32, 2, 2, 3]);
        assert_eq!(chunk(&[512, 600]), [64, 64]);
        let level = |shape: &[usize]| Hdf5Options::default().gzip_level_of(shape);
        assert_eq!((level(&[512, 512, 9, 9, 3]), level(&[265, 397, 20, 20, 3]), level(&[512, 600])), (0, 1, 1));
        assert_eq!(Hdf5Options::default().gzip_level(2).gzip_level_of(&[512, 512, 9, 9, 3]), 2);
    }
}
