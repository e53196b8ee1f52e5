//! The readers of `holo-io`: any bytes are read or are an error, and what was read can be written and read back equal.

use holo_core::SampleKind;
use holo_io::{
    CameraFile, ColorEncoding, Compression, Error, ExrChannel, Limits, Manifest, MatOptions, MatVariable,
    ParametersCfg, decode_exr, decode_exr_rgb, decode_hdr, decode_mat, decode_pfm, decode_png, decode_tiff, encode_exr,
    encode_mat, encode_png, encode_tiff,
};

/// Small, so that large sizes in small files are errors quickly.
const LIMITS: Limits = Limits { max_bytes: 1 << 20 };

/// What an encoder writes, as bytes.
fn encoded(encode: impl FnOnce(&mut Vec<u8>) -> Result<(), Error>) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    encode(&mut bytes).map(|()| bytes)
}

/// PNG: read, written at both compressions, read again.
///
/// # Panics
///
/// If a property does not hold.
pub fn png(data: &[u8]) {
    let Ok(samples) = decode_png(data, &LIMITS) else { return };
    for compression in [Compression::Fast, Compression::Best] {
        let meaning = if samples.kind() == SampleKind::U8 { ColorEncoding::Srgb } else { ColorEncoding::Linear };
        let bytes =
            encoded(|out| encode_png(out, &samples, meaning, compression)).expect("what was read can be written");
        assert_eq!(decode_png(&bytes[..], &LIMITS).expect("what was written can be read"), samples);
    }
}

/// PFM: read, written, read again; compared as bytes, so that NaN is equal.
///
/// # Panics
///
/// If a property does not hold.
pub fn pfm(data: &[u8]) {
    let Ok(image) = decode_pfm(data, &LIMITS) else { return };
    let bytes = encoded(|out| image.encode(out)).expect("what was read can be written");
    let again = decode_pfm(&bytes[..], &LIMITS).expect("what was written can be read");
    assert_eq!((again.values.dim(), again.scale), (image.values.dim(), image.scale));
    assert_eq!(encoded(|out| again.encode(out)).expect("what was read can be written"), bytes);
}

/// OpenEXR: read both ways, written where the format's writer can, read again; compared as bits, so that NaN is equal.
///
/// The reader converts a panic of the decoder to an error.
///
/// # Panics
///
/// If a property does not hold.
pub fn exr(data: &[u8]) {
    let _ = decode_exr_rgb(data, &LIMITS);
    let Ok(image) = decode_exr(data, &LIMITS) else { return };
    let channels: Vec<_> = image.channels.iter().map(|(name, plane)| ExrChannel::float(name, plane.view())).collect();
    // Duplicate names and parts of several sizes can be read but not written.
    let Ok(bytes) = encoded(|out| encode_exr(out, &channels)) else { return };
    let again = decode_exr(&bytes[..], &Limits::default()).expect("what was written can be read");
    assert_eq!(again.channels.len(), image.channels.len());
    for (name, plane) in &image.channels {
        let read = again.channel(name).expect("every channel is there");
        assert!(read.dim() == plane.dim() && read.iter().zip(plane).all(|(a, b)| a.to_bits() == b.to_bits()), "{name}");
    }
}

/// Radiance HDR: read or an error; samples are neither negative nor NaN.
///
/// # Panics
///
/// If a property does not hold.
pub fn hdr(data: &[u8]) {
    let Ok(image) = decode_hdr(data, &LIMITS) else { return };
    assert!(image.dim().2 == 3 && image.iter().all(|&value| value >= 0.0));
}

/// MAT files of version 5: read, written both ways, read again; compared as bytes, so that NaN is equal.
///
/// The reader converts a panic of the decoder to an error.
///
/// # Panics
///
/// If a property does not hold.
pub fn mat(data: &[u8]) {
    let Ok(read) = decode_mat(data, &LIMITS) else { return };
    let variables: Vec<_> = read.iter().map(|(name, value)| MatVariable { name, value: value.view() }).collect();
    let plain = MatOptions::default();
    // Duplicate names, and names that are invalid in MATLAB, can be read but not written.
    let Ok(bytes) = encoded(|out| encode_mat(out, &variables, &plain)) else { return };
    let compressed = encoded(|out| encode_mat(out, &variables, &plain.compressed(true)));
    for again in [&bytes[..], &compressed.expect("what can be written plain can be compressed")] {
        let again = decode_mat(again, &Limits::default()).expect("what was written can be read");
        let variables: Vec<_> = again.iter().map(|(name, value)| MatVariable { name, value: value.view() }).collect();
        let once_more = encoded(|out| encode_mat(out, &variables, &plain));
        assert!(once_more.expect("what was read can be written") == bytes);
    }
}

/// `parameters.cfg`: read, written, read again; compared as text, so that NaN is equal.
///
/// # Panics
///
/// If a property does not hold.
pub fn parameters_cfg(data: &[u8]) {
    let Ok(parameters) = ParametersCfg::from_text(&String::from_utf8_lossy(data)) else { return };
    let text = parameters.to_text().expect("what was read can be written");
    let again = ParametersCfg::from_text(&text).expect("what was written can be read");
    assert_eq!(again.to_text().expect("what was read can be written"), text);
    // The numbers of a file may be an impossible rig; that is an error.
    let _ = parameters.rig();
}

/// Camera files: read, written, read again. What was written has the same text again, up to the rotation, which is in
/// degrees there.
///
/// # Panics
///
/// If a property does not hold.
pub fn camera(data: &[u8]) {
    let Ok(file) = CameraFile::parse(&String::from_utf8_lossy(data), "fuzz") else { return };
    let again = CameraFile::parse(&file.to_toml(), "fuzz").expect("what was written can be read");
    assert_eq!((&again.name, again.camera.sensor().size), (&file.name, file.camera.sensor().size));
    // A ray of any camera is finite, or the camera was refused.
    let corner = file.camera.place_m([0.0, 0.0]);
    let lens = file.camera.owner(corner);
    let ray = file.camera.ray(corner, file.camera.lens_center_m(lens), lens);
    // One that a lens of glass stops has none.
    let Some(ray) = ray else { return };
    assert!(ray.origin_m.iter().chain(&ray.direction).all(|x| x.is_finite()));
}

/// `manifest.json`: read, written, read again; compared as text, so that NaN is equal.
///
/// # Panics
///
/// If a property does not hold.
pub fn manifest(data: &[u8]) {
    let Ok(manifest) = Manifest::from_json(&String::from_utf8_lossy(data)) else { return };
    let text = manifest.to_json().expect("what was read can be written");
    let again = Manifest::from_json(&text).expect("what was written can be read");
    assert_eq!(again.to_json().expect("what was read can be written"), text);
}

/// TIFF: read, written where the writer can, read again; compared as bytes, so that NaN is equal.
///
/// The reader converts a panic of the decoder to an error.
///
/// # Panics
///
/// If a property does not hold.
pub fn tiff(data: &[u8]) {
    let Ok(image) = decode_tiff(data, &LIMITS) else { return };
    // Gray with alpha can be read but not written.
    let Ok(bytes) = encoded(|out| encode_tiff(out, &image)) else { return };
    let again = decode_tiff(&bytes[..], &LIMITS).expect("what was written can be read");
    assert_eq!(encoded(|out| encode_tiff(out, &again)).expect("what was read can be written"), bytes);
}
