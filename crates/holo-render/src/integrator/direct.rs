//! One bounce: what lights, emitters and the sky send to the first surface, which sends it to the pixel.
//!
//! On a Lambertian surface that is base colour/pi * sum over lights of (irradiance * cosine * visibility) + base colour *
//! (share of the sky, weighted by the cosine, that is seen) * sky; where nothing is hit, the sky. The shadows of
//! punctual lights are hard. Mirrors and glass show only the sky or the emitter that their one scattered ray meets;
//! everything else in them is black.
//!
//! The sky's share is estimated with one ray a sample (unbiased); what punctual lights give to Lambertian surfaces is
//! exact for each camera ray. The work is done by [`super::path`], of which this is the shortest case.

/// Scattering events on the way to the pixel.
pub(crate) const BOUNCES: u32 = 1;
