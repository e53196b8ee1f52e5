//! The light field and its two layouts.

mod clip;
mod light_field;
mod rearrange;
mod samples;
