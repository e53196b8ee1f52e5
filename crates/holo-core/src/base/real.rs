//! The floating-point element types of geometry maps.

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`: an element of a depth or disparity map.
///
/// Every map is computed in `f64` and rounded to the element type once, at the end.
pub trait Real: sealed::Sealed + Copy + PartialEq + Send + Sync + 'static {
    /// Widens to `f64`, which is exact.
    fn to_f64(self) -> f64;
    /// Rounds to this type, to nearest.
    fn from_f64(value: f64) -> Self;
}

impl Real for f32 {
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[allow(clippy::cast_possible_truncation, reason = "rounds to nearest, as intended")]
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

impl Real for f64 {
    fn to_f64(self) -> f64 {
        self
    }

    fn from_f64(value: f64) -> Self {
        value
    }
}
