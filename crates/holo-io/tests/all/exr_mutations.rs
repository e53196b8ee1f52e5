//! Truncated and damaged OpenEXR files: errors, and no panic outside the panic guard. A decoder that takes absurd
//! amounts of memory ends the process.

use std::fs;

use crate::common::{data, ramp};
use crate::encoded::encoded;
use crate::panics;
use holo_io::{Error, ExrChannel, Limits, decode_exr, decode_exr_rgb, encode_exr};
use ndarray::Array2;

#[test]
fn truncated_and_mutated_files_are_errors_and_never_panics() {
    const LIMITS: Limits = Limits { max_bytes: 1 << 20 };
    let mut files = Vec::new();
    for name in [
        "openexr_half_zip.exr",
        "openexr_half_tiled.exr",
        "openexr_half_pxr24.exr",
        "openexr_half_b44.exr",
        "openexr_half_dwaa.exr",
        "openexr_float_piz.exr",
        "openexr_luminance_rle.exr",
        "openexr_half_piz.exr",
        "openexr_half_zips.exr",
        "openexr_id_piz.exr",
        "openexr_id_rle_tiled.exr",
        "openexr_parts.exr",
    ] {
        files.push((name, fs::read(data(name)).unwrap()));
    }
    let plane = Array2::from_shape_fn((33, 5), |(row, column)| ramp(row, column, 0));
    let channels = ["R", "G", "B"].map(|name| ExrChannel::float(name, plane.view()));
    files.push(("ours", encoded(|out| encode_exr(out, &channels)).unwrap()));
    let panics = panics::count(|| {
        for (name, whole) in &files {
            for end in 0..whole.len() {
                let error = decode_exr(&whole[..end], &LIMITS).expect_err("cut");
                assert!(matches!(error, Error::Broken { .. }), "{name} cut at {end}: {error}");
            }
            let mut state = 1_u64;
            for _ in 0..1500 {
                let mut bytes = whole.clone();
                for _ in 0..3 {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    let at = (state >> 33) as usize % bytes.len();
                    bytes[at] =
                        if state & 1 << 20 == 0 { (state >> 24) as u8 } else { bytes[at] ^ 1 << (state >> 21 & 7) };
                }
                // Read or refused; most damage to samples cannot be noticed.
                let _ = decode_exr(&bytes[..], &LIMITS);
                let _ = decode_exr_rgb(&bytes[..], &LIMITS);
            }
        }
    });
    assert_eq!(panics.unguarded, 0);
}
