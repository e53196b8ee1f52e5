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
pub(crate) const CHUNK: [usize; 4] = [4, 4, 10, 10];

impl Hdf5Options {
    /// The chunk for samples of this shape: never larger than the whole.
    pub(super) fn chunk_of(&self, shape: &[usize]) -> Vec<usize> {
        let wanted = self.chunk.unwrap_or(CHUNK);
        let side = |(axis, &count): (usize, &usize)| wanted.get(axis).map_or(count, |&side| side.clamp(1, count));
        shape.iter().enumerate().map(side).collect()
    }
}
