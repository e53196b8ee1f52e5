//! Footprints in texture coordinates.

use crate::simd::LANES;

/// A footprint in texture coordinates.
#[derive(Clone, Copy)]
pub(crate) struct TextureFootprint {
    pub sides: [[f32; 2]; 2],
    /// Whether its center was hit, as by single samples through the centers of their pixels. Other hits lie anywhere in it.
    pub is_centered: bool,
}

/// The footprints of sixteen camera rays in texture coordinates.
pub(crate) struct TextureFootprints {
    pub sides: [[[f32; LANES]; 2]; 2],
    pub is_centered: [bool; LANES],
    /// Whether the filter of the footprint lies in its triangle.
    pub is_inside: [bool; LANES],
}

impl TextureFootprints {
    /// No footprints.
    pub const NONE: Self =
        Self { sides: [[[0.0; LANES]; 2]; 2], is_centered: [false; LANES], is_inside: [false; LANES] };

    /// That of a lane.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> TextureFootprint {
        let [[a, b], [c, d]] = &self.sides;
        TextureFootprint { sides: [[a[lane], b[lane]], [c[lane], d[lane]]], is_centered: self.is_centered[lane] }
    }
}
