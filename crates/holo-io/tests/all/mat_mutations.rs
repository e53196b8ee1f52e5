//! Truncated and damaged MAT files: errors, and no panic outside the panic guard.

use std::fs;

use crate::common::data;
use crate::encoded::encoded;
use crate::panics;
use holo_io::{Error, Limits, MatOptions, MatValue, MatVariable, decode_mat, encode_mat};
use ndarray::ArrayD;

#[test]
fn truncated_and_mutated_files_are_errors_and_never_panics() {
    const LIMITS: Limits = Limits { max_bytes: 1 << 20 };
    let mut files = Vec::new();
    for name in ["scipy_plain.mat", "scipy_compressed.mat", "scipy_classes.mat"] {
        files.push((name, fs::read(data(name)).unwrap()));
    }
    let array = ArrayD::from_shape_fn(vec![5, 6, 2], |at| at[0] as f32 - at[2] as f32);
    let variables = [
        MatVariable { name: "array", value: MatValue::F32(array.view()) },
        MatVariable { name: "word", value: MatValue::Text("µm") },
    ];
    for is_compressed in [false, true] {
        let options = MatOptions::new().compressed(is_compressed);
        files.push(("ours", encoded(|out| encode_mat(out, &variables, &options)).unwrap()));
    }
    let panics = panics::count(|| {
        for (name, whole) in &files {
            // Truncated between two variables, the file is valid with fewer variables: the format has no end mark.
            let count = |bytes: &[u8]| decode_mat(bytes, &LIMITS).map(|variables| variables.len());
            let all = count(whole).unwrap_or(usize::MAX);
            for end in 0..whole.len() {
                match count(&whole[..end]) {
                    Ok(fewer) => assert!(fewer < all, "{name} truncated at {end}"),
                    Err(Error::Broken { .. } | Error::Unsupported { .. }) => {}
                    Err(error) => panic!("{name} truncated at {end}: {error}"),
                }
            }
            let mut state = 1_u64;
            for _ in 0..4000 {
                let mut bytes = whole.clone();
                for _ in 0..3 {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    let at = (state >> 33) as usize % bytes.len();
                    bytes[at] =
                        if state & 1 << 20 == 0 { (state >> 24) as u8 } else { bytes[at] ^ 1 << (state >> 21 & 7) };
                }
                let _ = decode_mat(&bytes[..], &LIMITS);
            }
        }
    });
    // Not even inside the guard: everything is checked before the decoder reads it.
    assert_eq!((panics.guarded, panics.unguarded), (0, 0));
}

#[test]
fn a_small_file_that_announces_gigabytes_is_refused() {
    // Zeros compress a thousandfold: 64 MB in 64 KB. One MiB is allowed.
    let zeros = ArrayD::<u8>::zeros(vec![8000, 8000]);
    let options = MatOptions::new().compressed(true);
    let bytes =
        encoded(|out| encode_mat(out, &[MatVariable { name: "zeros", value: MatValue::U8(zeros.view()) }], &options))
            .unwrap();
    assert!(bytes.len() < 200_000, "{}", bytes.len());
    let error = decode_mat(&bytes[..], &Limits { max_bytes: 1 << 20 }).unwrap_err();
    assert!(matches!(error, Error::TooLarge { needed: 64_000_000, .. }), "{error}");
}
