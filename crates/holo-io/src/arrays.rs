//! Arrays: MAT, HDF5 and NPY.

#[cfg(feature = "hdf5")]
pub(crate) mod hdf5;
pub(crate) mod mat;
pub(crate) mod npy;
pub(crate) mod rig_values;
