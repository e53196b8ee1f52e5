//! The element types of pictures.

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for f32 {}
}

/// `u8`, `u16` or `f32`: an element of a picture or of a light field that is measured or refocused.
///
/// Values are taken as they are: no tone curve is undone.
pub trait Sample: sealed::Sealed + Copy + PartialEq + Send + Sync + 'static {
    /// The largest value of an integer; floats have no scale of their own.
    const WHITE: Option<f32>;

    /// Widens to `f32`, which is exact for all three.
    fn to_f32(self) -> f32;

    /// Widens to `f64`, which is exact.
    fn to_f64(self) -> f64 {
        f64::from(self.to_f32())
    }
}

impl Sample for u8 {
    const WHITE: Option<f32> = Some(255.0);

    fn to_f32(self) -> f32 {
        f32::from(self)
    }
}

impl Sample for u16 {
    const WHITE: Option<f32> = Some(65_535.0);

    fn to_f32(self) -> f32 {
        f32::from(self)
    }
}

impl Sample for f32 {
    const WHITE: Option<f32> = None;

    fn to_f32(self) -> f32 {
        self
    }
}
