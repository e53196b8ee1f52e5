//! The element types of pictures.

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for f32 {}
}

/// `u8`, `u16` or `f32`: an element of a picture or of a light field that is measured or refocused.
///
/// Values are taken as they are: no gamma curve is undone and nothing is scaled.
pub trait Sample: sealed::Sealed + Copy + PartialEq + Send + Sync + 'static {
    /// Widens to `f32`, which is exact for all three.
    fn to_f32(self) -> f32;

    /// Widens to `f64`, which is exact.
    fn to_f64(self) -> f64 {
        f64::from(self.to_f32())
    }
}

impl Sample for u8 {
    fn to_f32(self) -> f32 {
        f32::from(self)
    }
}

impl Sample for u16 {
    fn to_f32(self) -> f32 {
        f32::from(self)
    }
}

impl Sample for f32 {
    fn to_f32(self) -> f32 {
        self
    }
}
