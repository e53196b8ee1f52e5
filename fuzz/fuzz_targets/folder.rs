//! libFuzzer's main loop around [`holo_fuzz`]'s target `folder`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| holo_fuzz::folder(data));
