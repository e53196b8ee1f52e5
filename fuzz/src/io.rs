//! The readers of `holo-io`: any bytes are read or refused, and what was read can be written and reads back equal.

use holo_io::{
    Compression, Limits, Manifest, Meaning, ParametersCfg, PngSamples, decode_pfm, decode_png, encode_png_u8,
    encode_png_u16,
};

/// Small, so that a few bytes that announce much are refused quickly.
const LIMITS: Limits = Limits { max_bytes: 1 << 20 };

/// PNG: read, written at both strengths, read again.
///
/// # Panics
///
/// If a property does not hold.
pub fn png(data: &[u8]) {
    let Ok(samples) = decode_png(data, &LIMITS) else { return };
    for compression in [Compression::Scratch, Compression::Published] {
        let bytes = match &samples {
            PngSamples::U8(samples) => encode_png_u8(samples.view(), Meaning::Srgb, compression),
            PngSamples::U16(samples) => encode_png_u16(samples.view(), Meaning::Data, compression),
        };
        let bytes = bytes.expect("what was read can be written");
        assert_eq!(decode_png(&bytes, &LIMITS).expect("what was written can be read"), samples);
    }
}

/// PFM: read, written, read again; compared as bytes, so that NaN counts.
///
/// # Panics
///
/// If a property does not hold.
pub fn pfm(data: &[u8]) {
    let Ok(image) = decode_pfm(data, &LIMITS) else { return };
    let bytes = image.to_bytes().expect("what was read can be written");
    let again = decode_pfm(&bytes, &LIMITS).expect("what was written can be read");
    assert_eq!((again.values.dim(), again.scale), (image.values.dim(), image.scale));
    assert_eq!(again.to_bytes().expect("what was read can be written"), bytes);
}

/// `parameters.cfg`: read, written, read again; compared as text, so that NaN counts.
///
/// # Panics
///
/// If a property does not hold.
pub fn parameters_cfg(data: &[u8]) {
    let Ok(parameters) = ParametersCfg::from_text(&String::from_utf8_lossy(data)) else { return };
    let text = parameters.to_text().expect("what was read can be written");
    let again = ParametersCfg::from_text(&text).expect("what was written can be read");
    assert_eq!(again.to_text().expect("what was read can be written"), text);
    // Numbers out of a file may make an impossible rig; that must be an error and nothing else.
    let _ = parameters.rig_parameters().map(holo_core::Rig::new);
}

/// `manifest.json`: read, written, read again; compared as text, so that NaN counts.
///
/// # Panics
///
/// If a property does not hold.
pub fn manifest(data: &[u8]) {
    let Ok(manifest) = Manifest::from_json(&String::from_utf8_lossy(data)) else { return };
    let text = manifest.to_json().expect("what was read can be written");
    let again = Manifest::from_json(&text).expect("what was written can be read");
    assert_eq!(again.to_json().expect("what was read can be written"), text);
    let _ = manifest.rig.map(|rig| rig.parameters().map(holo_core::Rig::new));
}
