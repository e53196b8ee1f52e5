//! libFuzzer's main loop around [`holo_fuzz`]'s target `camera`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| holo_fuzz::io::camera(data));
