//! libFuzzer's main loop around [`holo_fuzz`]'s target `hdf5`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| holo_fuzz::hdf5(data));
