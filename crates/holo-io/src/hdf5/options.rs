//! What a file holds beside the samples, and how it is stored.

/// A map of ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Hdf5Map {
    /// Planar depth in metres.
    Depth,
    /// Length of the ray in metres.
    RayLength,
    /// Disparity in pixels between adjacent views.
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

    /// Returns the unit, as the attribute `units` says it.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Depth | Self::RayLength => "m",
            Self::Disparity => "px",
        }
    }
}

/// How an HDF5 file is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Hdf5Options {
    /// Level of gzip behind shuffle, 1 to 9; 0 stores samples as they are.
    pub gzip_level: u8,
    /// Lens rows and columns, view rows and columns of one chunk; `None` for what the module's table recommends. Each
    /// chunk holds all channels.
    pub chunk: Option<[usize; 4]>,
}

impl Default for Hdf5Options {
    /// Level 1, the fastest: linear radiance is noisy.
    fn default() -> Self {
        Self { gzip_level: 1, chunk: None }
    }
}

/// Lens rows, lens columns, view rows and view columns of a chunk that suits both ways of reading.
const CHUNK: [usize; 4] = [4, 4, 10, 10];

/// Bytes of the rows of a chunk, as far as the default chunk can be made to fit.
const MAX_BAND_BYTES: usize = 256 << 20;

impl Hdf5Options {
    /// The chunk for samples of this shape: never larger than the whole.
    ///
    /// The rows of a chunk are in memory when it is written. Where lens rows are so long that these would be too much, the
    /// chunk is lower and wider instead, as far as it can.
    pub(crate) fn chunk_of(&self, shape: &[usize], element_bytes: usize) -> Vec<usize> {
        let mut wanted = self.chunk.unwrap_or(CHUNK);
        let row_bytes = shape[1..].iter().product::<usize>().saturating_mul(element_bytes);
        while self.chunk.is_none() && wanted[0] > 1 && row_bytes.saturating_mul(wanted[0]) > MAX_BAND_BYTES {
            wanted[0] /= 2;
            wanted[1] *= 2;
        }
        let side = |(axis, &count): (usize, &usize)| wanted.get(axis).map_or(count, |&side| side.clamp(1, count));
        shape.iter().enumerate().map(side).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_lower_where_rows_are_long() {
        let chunk = |shape: [usize; 5], bytes| Hdf5Options::default().chunk_of(&shape, bytes);
        assert_eq!(chunk([53, 79, 100, 100, 3], 4), [4, 4, 10, 10, 3]);
        assert_eq!(chunk([3, 2, 5, 100, 1], 4), [3, 2, 5, 10, 1]);
        // 64K pixels wide: a lens row is 79 MB.
        assert_eq!(chunk([430, 655, 100, 100, 3], 4), [2, 8, 10, 10, 3]);
        assert_eq!(chunk([430, 655, 100, 100, 3], 1), [4, 4, 10, 10, 3]);
        let own = Hdf5Options { chunk: Some([4, 4, 10, 10]), ..Hdf5Options::default() };
        assert_eq!(own.chunk_of(&[430, 655, 100, 100, 3], 4), [4, 4, 10, 10, 3]);
    }
}
