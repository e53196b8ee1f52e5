//! Light that is scattered more than once between the microfacets of a rough surface.
//!
//! A GGX lobe f with shadowing and masking is the light that is scattered once. Microfacets with a reflectance of 1
//! scatter a share W(z) of it back, 0.31 to 1; the rest is scattered again, and leaves in a wider lobe of about the same
//! direction. Here that lobe has the shape of f itself, scaled by a gain k of either direction:
//!
//! ```text
//! f(out, into) (F + S (k(out) k(into) - 1))
//! ```
//!
//! k is the solution of k(out) * integral of f(out, into) k(into) |into.z| d into = 1, found by Sinkhorn's iteration
//! ([`super::albedo`]): with F = S = 1 the lobe has an albedo of exactly 1 for every direction, and it is reciprocal.
//! The scaling of Turquin ("Practical Multiple Scattering Compensation for Microfacet Models", 2019), which Cycles uses,
//! has the same albedo, but depends on one of the two directions only. Samples of f need no other lobe: their weight is
//! multiplied by k k.
//!
//! S is what the microfacets leave of the light: every event but the first sees the mean reflectance `<F>`, and a share
//! `<W>` escapes at each, so S = `<F>^2 <W> / (1 - <F> (1 - <W>))` (Kulla and Conty, "Revisiting Physically Based
//! Shading at Imageworks", SIGGRAPH 2017 course, with the correction of Hill, 2018), with `<.>` the cosine-weighted mean
//! over the hemisphere. A thin pane transmits or reflects everything, by the same f: both sides are multiplied by k k.

/// S of the mean reflectance and the mean share `escape` of light that escapes at once.
#[inline(always)]
pub(super) fn repeated(reflectance: f32, escape: f32) -> f32 {
    reflectance * reflectance * escape / (1.0 - reflectance * (1.0 - escape)).max(1e-7)
}

/// The cosine-weighted mean of Schlick's reflectance: the integral of 2 z (1 - z)^5 is 1/21.
#[inline(always)]
pub(super) fn mean_schlick(f0: f32, f90: f32) -> f32 {
    (f0 + (f90 - f0) * (1.0 / 21.0)).clamp(0.0, 1.0)
}
