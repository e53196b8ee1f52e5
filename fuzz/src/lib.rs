//! Fuzz targets as plain functions: each takes any bytes and panics where a property does not hold.
#![forbid(unsafe_code)]

#[cfg(any(unix, feature = "hdf5"))]
mod bytes;
mod compressed;
#[cfg(unix)]
mod folder;
mod gltf;
#[cfg(feature = "hdf5")]
mod hdf5;
pub mod io;

pub use compressed::{draco, meshopt};
#[cfg(unix)]
pub use folder::folder;
pub use gltf::gltf;
#[cfg(feature = "hdf5")]
pub use hdf5::hdf5;

/// Makes libFuzzer ignore panics inside the panic guard of `holo-io`, which the readers convert to errors.
pub fn ignore_guarded_panics() {
    let end = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !holo_io::is_guarding() {
            end(panic);
        }
    }));
}
