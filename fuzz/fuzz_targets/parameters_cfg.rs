//! libFuzzer's main loop around [`holo_fuzz`]'s target `parameters_cfg`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| holo_fuzz::io::parameters_cfg(data));
