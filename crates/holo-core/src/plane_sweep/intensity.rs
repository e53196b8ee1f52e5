//! The sample types that can be matched, and how they become numbers around 0 to 1.

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for f32 {}
}

/// `u8`, `u16` or `f32`: a sample of a light field whose depth can be estimated.
///
/// Integers are taken from 0 to 1 as they are, without undoing a tone curve. Floats may have any scale: they are divided by what
/// spans the central view.
pub trait Intensity: sealed::Sealed + Copy + Send + Sync + 'static {
    /// Whether the samples have no scale of their own.
    const IS_UNSCALED: bool;

    /// Widens to `f32`; integers become 0 to 1.
    fn to_unit(self) -> f32;
}

impl Intensity for u8 {
    const IS_UNSCALED: bool = false;

    fn to_unit(self) -> f32 {
        f32::from(self) / 255.0
    }
}

impl Intensity for u16 {
    const IS_UNSCALED: bool = false;

    fn to_unit(self) -> f32 {
        f32::from(self) / 65535.0
    }
}

impl Intensity for f32 {
    const IS_UNSCALED: bool = true;

    fn to_unit(self) -> f32 {
        self
    }
}
