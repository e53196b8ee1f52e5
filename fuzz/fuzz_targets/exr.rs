#![no_main]

libfuzzer_sys::fuzz_target!(init: holo_fuzz::let_the_net_catch(), |data: &[u8]| holo_fuzz::io::exr(data));
