//! libFuzzer's main loop around [`holo_fuzz`]'s target `tiff`.
#![no_main]

libfuzzer_sys::fuzz_target!(init: holo_fuzz::ignore_guarded_panics(), |data: &[u8]| holo_fuzz::io::tiff(data));
