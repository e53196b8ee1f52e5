//! PFM: exact round trips, headers of other programs, and errors for data of another length.

use std::fs;

use holo_io::{Error, Limits, Pfm, decode_pfm, read_pfm, read_pfm_gray, read_pfm_info, write_pfm, write_pfm_rgb};
use ndarray::{Array2, Array3, Axis, Slice, array};
use proptest::prelude::*;

fn decode(bytes: &[u8]) -> Result<Pfm, Error> {
    decode_pfm(bytes, &Limits::default())
}

fn bits(values: impl IntoIterator<Item = f32>) -> Vec<u32> {
    values.into_iter().map(f32::to_bits).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_shape_stride_and_bit_pattern_reads_back(
        rows in 1_usize..20, columns in 1_usize..20, kind in 0_usize..4,
        pattern in prop::collection::vec(any::<u32>(), 7..40),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.pfm");
        let mut at = 0;
        let mut next = || { at += 1; f32::from_bits(pattern[at % pattern.len()]) };
        let map = match kind {
            0 => Array2::from_shape_simple_fn((columns, rows), &mut next).reversed_axes(),
            1 => Array2::from_shape_simple_fn((rows * 3, columns), &mut next)
                .slice_axis_move(Axis(0), Slice::from(..).step_by(-3)),
            2 => {
                let mut map = Array2::from_shape_simple_fn((rows, columns), &mut next);
                map.invert_axis(Axis(1));
                map
            }
            _ => Array2::from_shape_simple_fn((rows, columns), &mut next),
        };
        let written = write_pfm(&path, map.view()).unwrap();
        prop_assert_eq!(written, holo_io::hash_file(&path).unwrap());
        let bytes = fs::read(&path).unwrap();
        let header = format!("Pf\n{columns} {rows}\n-1\n");
        prop_assert!(bytes.starts_with(header.as_bytes()));
        prop_assert_eq!(bytes.len(), header.len() + rows * columns * 4);
        let read = read_pfm_gray(&path, &Limits::default()).unwrap();
        prop_assert_eq!(read.dim(), (rows, columns));
        prop_assert_eq!(bits(read), bits(map.iter().copied()));

        let color = Array3::from_shape_simple_fn((rows, columns, 3), &mut next);
        write_pfm_rgb(&path, color.view()).unwrap();
        let read = read_pfm(&path, &Limits::default()).unwrap();
        prop_assert_eq!(read.values.dim(), (rows, columns, 3));
        prop_assert_eq!(bits(read.values), bits(color));
    }
}

#[test]
fn the_file_is_byte_for_byte_what_the_hci_tools_write() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.pfm");
    // Odd numbers of rows and columns; the bottom row comes first in the file.
    write_pfm(&path, array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]].view()).unwrap();
    let mut expected = b"Pf\n3 3\n-1\n".to_vec();
    for value in [7.0_f32, 8.0, 9.0, 4.0, 5.0, 6.0, 1.0, 2.0, 3.0] {
        expected.extend(value.to_le_bytes());
    }
    assert_eq!(fs::read(&path).unwrap(), expected);
    write_pfm_rgb(&path, Array3::from_elem((1, 1, 3), 1.0).view()).unwrap();
    assert_eq!(fs::read(&path).unwrap(), [b"PF\n1 1\n-1\n".as_slice(), &1.0_f32.to_le_bytes().repeat(3)].concat());
}

#[test]
fn an_image_larger_than_a_block_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.pfm");
    for shape in [(3, 40_000), (40_000, 3), (1, 16_384), (1, 16_385)] {
        let map = Array2::from_shape_fn(shape, |(row, column)| (row * 50_021 + column) as f32);
        write_pfm(&path, map.view()).unwrap();
        assert_eq!(read_pfm_gray(&path, &Limits::default()).unwrap(), map);
    }
}

#[test]
fn headers_of_other_programs_are_read() {
    let little: Vec<u8> = [1.5_f32, -2.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let big: Vec<u8> = [1.5_f32, -2.0].iter().flat_map(|value| value.to_be_bytes()).collect();
    for (header, data, scale) in [
        ("Pf\n1 2\n-1\n", &little, 1.0),
        ("Pf\n1 2\n1\n", &big, 1.0),
        ("Pf\n1 2\n-1.000000\n", &little, 1.0),
        ("Pf 1 2 -1 ", &little, 1.0),
        ("Pf\n1\n2\n-0.25\n", &little, 0.25),
        ("Pf\n# made by hand\n1 2\n# -1\n-1e0\n", &little, 1.0),
        ("Pf #c\n1 #c\n 2\n-1\n", &little, 1.0),
        ("Pf\r\n1 2\r\n-1\r\n", &little, 1.0),
        ("Pf\r1 2\r2\r", &big, 2.0),
        ("Pf\n\t01  2 \n-1\t", &little, 1.0),
    ] {
        let pfm = decode(&[header.as_bytes(), data].concat()).unwrap_or_else(|error| panic!("{header:?}: {error}"));
        // The first row in the file is the bottom one.
        assert_eq!(pfm, Pfm { values: array![[[-2.0]], [[1.5]]], scale }, "{header:?}");
    }
    // Data follow a carriage return after the scale, even if their first byte is a line feed.
    let odd = f32::from_le_bytes([b'\n', 1, 2, 3]);
    assert_eq!(decode(b"Pf\r1 1\r-1\r\n\x01\x02\x03").unwrap().values, array![[[odd]]]);
}

#[test]
fn broken_headers_are_refused() {
    for header in [
        "",
        "P",
        "Pf",
        "PG\n1 1\n-1\n",
        "P6\n1 1\n255\n",
        "pf\n1 1\n-1\n",
        "Pf4\n1 1\n-1\n",
        "Pf\n1\n",
        "Pf\n0 1\n-1\n",
        "Pf\n1 0\n-1\n",
        "Pf\n-1 1\n-1\n",
        "Pf\n+1 1\n-1\n",
        "Pf\n1.0 1\n-1\n",
        "Pf\n1 1\n0\n",
        "Pf\n1 1\n-0.0\n",
        "Pf\n1 1\nnan\n",
        "Pf\n1 1\ninf\n",
        "Pf\n1 1\n-1e999\n",
        "Pf\n1 1\nx\n",
        "Pf\n1 1 1\n-1\n",
        "Pf\n1 1\n-1#\n",
        "Pf\n99999999999999999999999999 1\n-1\n",
        "Pf\n\u{e4}1 1\n-1\n",
    ] {
        let bytes = [header.as_bytes(), &[0; 4]].concat();
        let error = decode(&bytes).expect_err(header);
        assert!(matches!(error, Error::Broken { .. }), "{header:?}: {error}");
    }
    for header in ["Pf\n0 1\n-1\n", "Pf\n1 0\n-1\n"] {
        let error = decode(header.as_bytes()).expect_err(header).to_string();
        assert!(error.contains("above 0"), "{header:?}: {error}");
    }
    let endless = [b"Pf\n#".as_slice(), &[b'x'; 100_000]].concat();
    assert!(decode(&endless).unwrap_err().to_string().contains("longer than 4096"));
}

#[test]
fn the_data_must_have_exactly_the_announced_length() {
    let whole = [b"PF\n2 2\n-1\n".as_slice(), &[0; 48]].concat();
    assert!(decode(&whole).is_ok());
    for end in 0..whole.len() {
        assert!(matches!(decode(&whole[..end]), Err(Error::Broken { .. })), "cut at {end}");
    }
    for more in [1, 2, 4, 100] {
        let error = decode(&[whole.as_slice(), &vec![0; more]].concat()).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "(stream): broken PFM file: 2 x 2 pixels need 48 bytes after the header, but there are {}",
                48 + more
            )
        );
    }
    // The same with a file.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.pfm");
    for length in [whole.len() - 1, whole.len() + 1] {
        let mut bytes = whole.clone();
        bytes.resize(length, 0);
        fs::write(&path, bytes).unwrap();
        assert!(matches!(read_pfm(&path, &Limits::default()), Err(Error::Broken { .. })));
    }
}

#[test]
fn absurd_sizes_take_no_memory() {
    for size in [
        "4000000000 4000000000",
        "18446744073709551615 18446744073709551615",
        "18446744073709551615 1",
        "1 4611686018427387904",
    ] {
        let bytes = format!("Pf\n{size}\n-1\nabcd");
        for limits in [Limits::default(), Limits::NONE] {
            let error = decode_pfm(bytes.as_bytes(), &limits).unwrap_err();
            assert!(matches!(error, Error::Broken { .. }), "{error}");
        }
    }
    let whole = [b"Pf\n2 2\n-1\n".as_slice(), &[0; 16]].concat();
    assert!(decode_pfm(&whole[..], &Limits { max_bytes: 16 }).is_ok());
    let error = decode_pfm(&whole[..], &Limits { max_bytes: 15 }).unwrap_err();
    assert!(matches!(error, Error::TooLarge { needed: 16, allowed: 15, .. }), "{error}");
}

#[test]
fn gray_is_distinguished_from_rgb() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.pfm");
    write_pfm_rgb(&path, Array3::zeros((2, 5, 3)).view()).unwrap();
    assert!(matches!(read_pfm_gray(&path, &Limits::default()), Err(Error::Unsupported { .. })));
    let info = read_pfm_info(&path).unwrap();
    assert_eq!(
        (info.size.rows, info.size.columns, info.channels, info.scale, info.little_endian),
        (2, 5, 3, 1.0, true)
    );
}

#[test]
fn empty_images_are_refused_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.pfm");
    assert!(matches!(write_pfm(&path, Array2::zeros((0, 3)).view()), Err(Error::BadInput { .. })));
    assert!(matches!(write_pfm_rgb(&path, Array3::zeros((3, 0, 3)).view()), Err(Error::BadInput { .. })));
    assert!(matches!(write_pfm_rgb(&path, Array3::zeros((3, 3, 1)).view()), Err(Error::BadInput { .. })));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_read_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        return; // no such tool here
    }
    let map = Array2::from_shape_fn((31, 17), |(row, column)| (row * 17 + column) as f32);
    let (writer_pipe, writer_map) = (pipe.clone(), map.clone());
    // A pipe is not a regular file: the bytes are written into it directly.
    let writer = std::thread::spawn(move || write_pfm(writer_pipe, writer_map.view()).unwrap());
    assert_eq!(read_pfm_gray(&pipe, &Limits::default()).unwrap(), map);
    assert_eq!(writer.join().unwrap().bytes, 12 + 31 * 17 * 4);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported() {
    for size in [1, 300] {
        let error = write_pfm("/dev/full", Array2::zeros((size, size)).view()).unwrap_err();
        let Error::Io { error: source, .. } = &error else { panic!("{error}") };
        assert_eq!(source.kind(), std::io::ErrorKind::StorageFull);
    }
}
