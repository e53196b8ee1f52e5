//! Fuzz targets as plain functions: each takes any bytes and panics where a property does not hold.
#![forbid(unsafe_code)]

mod gltf;
#[cfg(feature = "hdf5")]
mod hdf5;
pub mod io;

pub use gltf::gltf;
#[cfg(feature = "hdf5")]
pub use hdf5::hdf5;

/// Lets panics that `holo-io` catches pass by: libFuzzer ends at any panic, and the readers promise an error for those
/// of the decoders under their net.
pub fn let_the_net_catch() {
    let end = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !holo_io::is_guarding() {
            end(panic);
        }
    }));
}
