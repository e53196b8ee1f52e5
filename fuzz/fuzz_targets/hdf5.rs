#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| holo_fuzz::hdf5(data));
