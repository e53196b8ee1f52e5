"""Writes src/hdf5/nul_terminated_text.h5 with h5py: one attribute, of a type that the HDF5 binding cannot make."""

import sys

import h5py

with h5py.File(sys.argv[1], "w", libver="latest") as file:
    text = h5py.h5t.C_S1.copy()
    text.set_size(16)
    text.set_strpad(h5py.h5t.STR_NULLTERM)
    h5py.h5a.create(file.id, b"CLASS", text, h5py.h5s.create(h5py.h5s.SCALAR))
