//! What a fresh machine needs: Embree, CMake, packages of Python, and how programs are run.

pub(crate) mod cargo;
pub(crate) mod cmake;
pub(crate) mod embree;
pub(crate) mod peers;
pub(crate) mod pip;
pub(crate) mod process;
pub(crate) mod python;
