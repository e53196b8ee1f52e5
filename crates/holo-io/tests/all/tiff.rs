//! TIFF: every kind of sample there and back, files of other programs, damaged files, views in folders.

use crate::python;
use holo_core::{DynImage, DynLightField, GridSize, LightField, SampleKind};
use holo_io::{
    ColorEncoding, Error, FileFormat, Limits, ReadOptions, decode_tiff, detect_format, encode_tiff, read_light_field,
    read_tiff, read_tiff_info, write_image, write_tiff,
};
use ndarray::{Array3, Array5};

fn bits(index: usize) -> u64 {
    (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(17)
}

fn image<T>(shape: (usize, usize, usize), sample: impl Fn(u64) -> T) -> Array3<T> {
    Array3::from_shape_fn(shape, |(row, column, c)| sample(bits((row * shape.1 + column) * shape.2 + c)))
}

/// Every type that is written, of 1, 3 and 4 channels, with a size beyond one strip.
fn images() -> Vec<DynImage> {
    let mut all = Vec::new();
    for channels in [1, 3, 4] {
        let shape = (181, 133, channels);
        all.push(image(shape, |bits| bits as u8).into());
        all.push(image(shape, |bits| bits as u16).into());
        all.push(image(shape, |bits| (bits as i32) as f32 / 64.0).into());
        all.push(image(shape, |bits| (bits as i64) as f64 * 1e-9).into());
    }
    let mut special = image((2, 3, 1), |bits| bits as f32);
    special[[0, 0, 0]] = f32::INFINITY;
    special[[1, 2, 0]] = -0.0;
    all.push(special.into());
    all
}

fn encoded(image: &DynImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode_tiff(&mut bytes, image).unwrap();
    bytes
}

#[test]
fn samples_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image");
    for image in images() {
        let written = write_tiff(&path, &image).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!((written.bytes, bytes.len() as u64), (bytes.len() as u64, written.bytes));
        assert_eq!(read_tiff(&path, &Limits::default()).unwrap(), image);
        assert_eq!(encoded(&image), bytes);
        assert_eq!(decode_tiff(&bytes[..], &Limits::default()).unwrap(), image);
        assert_eq!(detect_format(&path).unwrap(), FileFormat::Tiff);
        let info = read_tiff_info(&path).unwrap();
        let (rows, columns, channels) = image.dim();
        assert_eq!((info.size, info.channels, info.kind), (GridSize::new(rows, columns), channels, image.kind()));
    }
    // Any strides.
    let turned = image((40, 30, 3), |bits| bits as u16).reversed_axes();
    let turned = turned.permuted_axes([2, 1, 0]);
    write_tiff(&path, turned.view()).unwrap();
    assert_eq!(read_tiff(&path, &Limits::default()).unwrap(), DynImage::U16(turned));
}

#[test]
fn what_a_tiff_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.tif");
    for shape in [(0, 3, 3), (3, 0, 1), (3, 3, 2), (3, 3, 5)] {
        let error = write_tiff(&path, Array3::<u8>::zeros(shape).view()).unwrap_err();
        assert!(matches!(error, Error::BadInput { .. }), "{shape:?}: {error}");
    }
    assert!(!path.exists());
    let one = Array3::<u8>::zeros((1, 1, 1));
    let endless = one.broadcast((1 << 20, 1 << 20, 1)).unwrap();
    assert!(matches!(write_tiff(&path, endless), Err(Error::BadInput { .. })));
}

#[test]
fn limits_come_before_memory() {
    let image = DynImage::from(image((100, 100, 3), |bits| bits as u16));
    let bytes = encoded(&image);
    assert!(decode_tiff(&bytes[..], &Limits { max_bytes: 60_000 }).is_ok());
    let error = decode_tiff(&bytes[..], &Limits { max_bytes: 59_999 }).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

/// Any byte changed and any length: an image or an error, never a panic.
#[test]
fn damaged_files_are_errors_or_images() {
    let whole = encoded(&DynImage::from(image((9, 7, 3), |bits| bits as u16)));
    let limits = Limits { max_bytes: 1 << 20 };
    for length in 0..whole.len() {
        assert!(decode_tiff(&whole[..length], &limits).is_err(), "{length} of {}", whole.len());
    }
    for place in 0..whole.len() {
        for change in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[place] ^= change;
            let _ = decode_tiff(&bytes[..], &limits);
        }
    }
    let error = decode_tiff(&b"II*\0"[..], &limits).unwrap_err();
    assert!(matches!(error, Error::Broken { .. }), "{error}");
}

#[test]
fn images_and_views_in_folders_may_be_tiff() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let field = LightField::new(Array5::from_shape_fn((4, 5, 2, 3, 3), |(v, u, t, s, c)| {
        (v * 97 + u * 31 + t * 11 + s * 5 + c) as f32 / 8.0
    }))
    .unwrap();
    for (t, s) in (0..2).flat_map(|t| (0..3).map(move |s| (t, s))) {
        write_image(path(&format!("view{}.tif", t * 3 + s)), field.view(t, s).unwrap()).unwrap();
    }
    let options = ReadOptions::default().views(Some(GridSize::new(2, 3)));
    let read = read_light_field(folder.path(), &options).unwrap();
    let expected = DynLightField::from(field.to_owned().unwrap());
    assert_eq!((&read.light_field, read.color_encoding), (&expected, ColorEncoding::Linear));

    let grid = tempfile::tempdir().unwrap();
    let raw = grid.path().join("scene_el.tif");
    write_image(&raw, field.to_elemental_grid().unwrap().view()).unwrap();
    let read = read_light_field(&raw, &options).unwrap();
    assert_eq!((&read.light_field, read.color_encoding), (&expected, ColorEncoding::Linear));
    assert_eq!(holo_io::probe(&raw).unwrap().to_string(), "TIFF image, 15 x 8 pixels, 3 channels of float32");
}

#[test]
fn tifffile_and_opencv_read_ours_and_we_read_theirs() {
    const SCRIPT: &str = r#"
folder = sys.argv[1]
v, u, c = numpy.ogrid[:19, :23, :3]
value = v * 97 + u * 31 + c * 7
for kind, dtype in [("u8", numpy.uint8), ("u16", numpy.uint16), ("f32", numpy.float32), ("f64", numpy.float64)]:
    expected = (value % 251).astype(dtype)
    image = tifffile.imread(f"{folder}/{kind}.tif")
    assert image.dtype == dtype and (image == expected).all(), kind
    if kind != "f64":
        assert (cv2.imread(f"{folder}/{kind}.tif", cv2.IMREAD_UNCHANGED)[:, :, ::-1] == expected).all(), kind
        cv2.imwrite(f"{folder}/cv2_{kind}.tif", expected[:, :, ::-1])
    tifffile.imwrite(f"{folder}/tifffile_{kind}.tif", expected, photometric="rgb")
    tifffile.imwrite(f"{folder}/big_{kind}.tif", expected, photometric="rgb", byteorder=">", bigtiff=True)
    tifffile.imwrite(f"{folder}/tiles_{kind}.tif", expected, photometric="rgb", tile=(16, 16))
tifffile.imwrite(f"{folder}/planes.tif", numpy.zeros((3, 8, 8), numpy.uint8), photometric="rgb", planarconfig="separate")
tifffile.imwrite(f"{folder}/int32.tif", numpy.zeros((8, 8), numpy.int32))
print("fine")
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let values = Array3::from_shape_fn((19, 23, 3), |(v, u, c)| (v * 97 + u * 31 + c * 7) % 251);
    let kinds: [(&str, DynImage); 4] = [
        ("u8", values.mapv(|value| value as u8).into()),
        ("u16", values.mapv(|value| value as u16).into()),
        ("f32", values.mapv(|value| value as f32).into()),
        ("f64", values.mapv(|value| value as f64).into()),
    ];
    for (kind, image) in &kinds {
        write_tiff(path(&format!("{kind}.tif")), image).unwrap();
    }
    let modules = ["numpy", "tifffile", "cv2"];
    let Some(text) = python::run(&modules, SCRIPT, &[folder.path().to_str().unwrap()]) else { return };
    assert_eq!(text.trim(), "fine");
    for (kind, expected) in &kinds {
        for writer in ["tifffile", "big", "tiles", "cv2"] {
            if writer == "cv2" && expected.kind() == SampleKind::F64 {
                continue;
            }
            let found = read_tiff(path(&format!("{writer}_{kind}.tif")), &Limits::default());
            assert_eq!(&found.unwrap(), expected, "{writer} {kind}");
        }
    }
    for (name, part) in [("planes.tif", "separate planes"), ("int32.tif", "32-bit samples")] {
        let error = read_tiff(path(name), &Limits::default()).unwrap_err();
        assert!(matches!(&error, Error::Unsupported { .. }) && error.to_string().contains(part), "{error}");
    }
}
