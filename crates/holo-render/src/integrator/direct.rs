//! Direct light: a single bounce.
//!
//! For a Lambertian surface the radiance is base color / pi * sum over lights of (irradiance * cosine * visibility) +
//! base color * (cosine-weighted share of the sky that is visible) * sky; for a miss it is the radiance of the
//! environment. Punctual lights have hard shadows. Mirrors and glass show only the environment or the emissive surface
//! that their one scattered ray meets; everything else in them is black.
//!
//! The visible share of the sky is estimated with one ray per sample (unbiased). The contribution of punctual lights to
//! Lambertian surfaces is exact for each camera ray. The implementation is [`super::path`] with one bounce.

/// The number of bounces.
pub(crate) const BOUNCES: u32 = 1;
