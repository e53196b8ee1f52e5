//! libFuzzer's main loop around [`holo_fuzz`]'s target `draco`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| holo_fuzz::draco(data));
