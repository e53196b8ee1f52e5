//! What an encoder writes into a stream, as bytes.

use holo_io::Error;

pub fn encoded(encode: impl FnOnce(&mut Vec<u8>) -> Result<(), Error>) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    encode(&mut bytes).map(|()| bytes)
}
