//! Arrays of numpy.

/// Returns the bytes of a `.npy` file: an array in C order.
///
/// `kind` is the type of its samples in numpy's words, such as `"<f8"` for little-endian floats of 64 bits, `bytes` are its samples.
///
/// # Source
///
/// The format of `numpy.lib.format`, version 1.0; the header is padded to 64 bytes.
#[must_use]
pub fn encode_npy(kind: &str, shape: &[usize], bytes: impl Iterator<Item = u8>) -> Vec<u8> {
    const START: &[u8] = b"\x93NUMPY\x01\x00";
    let shape: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({},), }}", shape.join(", "));
    let length = (START.len() + 2 + text.len() + 1).next_multiple_of(64) - START.len() - 2;
    let mut out = START.to_vec();
    // Far below 65,536.
    out.extend_from_slice(&(length as u16).to_le_bytes());
    out.extend_from_slice(text.as_bytes());
    out.resize(START.len() + 2 + length - 1, b' ');
    out.push(b'\n');
    out.extend(bytes);
    out
}
