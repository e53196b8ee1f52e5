//! Errors of the crate `matfile` 0.5.0 with whole files, the reason why it decodes only numbers here. A test that fails
//! with a later version means that the error is fixed there, and that `mat/v5/numbers.rs` may become simpler.

use crate::encoded::encoded;
use holo_io::{Limits, MatArray, MatOptions, MatValue, MatVariable, decode_mat, encode_mat};
use matfile::{MatFile, NumericData};
use ndarray::ArrayD;

fn file(value: MatValue<'_>) -> Vec<u8> {
    encoded(|out| encode_mat(out, &[MatVariable { name: "numbers", value }], &MatOptions::default())).unwrap()
}

/// Offset of the dimensions of the only variable: after header, matrix tag, flags, and their own tag.
const DIMENSIONS: usize = 128 + 8 + 16 + 8;

/// Parses with `matfile`, which may panic.
fn parse(bytes: &[u8]) -> std::thread::Result<Result<MatFile, matfile::Error>> {
    std::panic::catch_unwind(|| MatFile::parse(bytes))
}

#[test]
fn numbers_are_right() {
    let array = ArrayD::from_shape_fn(vec![3, 4], |at| at[0] as f64 * 0.1 + at[1] as f64);
    let parsed = parse(&file(MatValue::F64(array.view()))).unwrap().unwrap();
    let NumericData::Double { real, .. } = parsed.arrays()[0].data() else { panic!("double") };
    assert!(real.iter().eq(array.t().iter()));
}

#[test]
fn int32_is_refused_by_matfile_and_read_by_this_crate() {
    let array = ArrayD::from_shape_vec(vec![1, 3], vec![i32::MIN, -1, 70_000]).unwrap();
    let bytes = file(MatValue::I32(array.view()));
    assert!(parse(&bytes).unwrap().is_err());
    assert_eq!(decode_mat(&bytes[..], &Limits::default()).unwrap()[0].1, MatArray::I32(array));
}

#[test]
fn truncated_files_are_accepted_by_matfile() {
    let array = ArrayD::<u8>::ones(vec![100, 100]);
    let bytes = file(MatValue::U8(array.view()));
    let cut = &bytes[..bytes.len() / 2];
    assert_eq!(parse(cut).unwrap().unwrap().arrays().len(), 0);
    assert!(decode_mat(cut, &Limits::default()).unwrap_err().to_string().contains("truncated"));
}

#[test]
fn dimensions_are_multiplied_without_a_check() {
    let array = ArrayD::<u8>::ones(vec![4, 4]);
    let mut bytes = file(MatValue::U8(array.view()));
    // 65537 * 65536 is 65536 in 32 bits: a panic with overflow checks, a wrong product without.
    bytes[DIMENSIONS..DIMENSIONS + 8].copy_from_slice(&[65_537_i32, 65_536].map(i32::to_le_bytes).concat());
    let outcome = parse(&bytes);
    assert_eq!(outcome.is_err(), cfg!(debug_assertions) && overflow_checks_of_dependencies(), "{outcome:?}");
    assert!(decode_mat(&bytes[..], &Limits::default()).is_err());
    // Two negative dimensions have a positive product.
    let mut bytes = file(MatValue::U8(array.view()));
    bytes[DIMENSIONS..DIMENSIONS + 8].copy_from_slice(&[-4_i32, -4].map(i32::to_le_bytes).concat());
    assert_eq!(parse(&bytes).unwrap().unwrap().arrays()[0].size()[0], usize::MAX - 3);
    assert!(decode_mat(&bytes[..], &Limits::default()).unwrap_err().to_string().contains("dimension of -4"));
}

/// Whether the profile, which is the same for dependencies, has overflow checks.
fn overflow_checks_of_dependencies() -> bool {
    std::panic::catch_unwind(|| std::hint::black_box(i32::MAX) + 1).is_err()
}

#[test]
fn text_is_ignored_by_matfile() {
    let bytes = file(MatValue::Text("meters"));
    assert_eq!(parse(&bytes).unwrap().unwrap().arrays().len(), 0);
    assert_eq!(decode_mat(&bytes[..], &Limits::default()).unwrap()[0].1, MatArray::Text("meters".into()));
}
