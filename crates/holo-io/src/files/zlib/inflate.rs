//! The decompressor of a zlib stream as a reader.

use std::io::{self, Read};

use zlib_rs::{Inflate, InflateFlush, Status};

/// Compressed bytes that are read at a time.
const INPUT_BYTES: usize = 64 << 10;

/// A reader of the decompressed bytes of a zlib stream. The checksum is verified at the end of the stream.
///
/// Only as much is inflated as the caller reads, so a small stream of many gigabytes of data takes little memory.
pub(crate) struct Inflated<R> {
    source: R,
    input: Vec<u8>,
    at: usize,
    inflate: Inflate,
    ended: bool,
}

impl<R: Read> Inflated<R> {
    pub(crate) fn new(source: R) -> Self {
        Self { source, input: Vec::new(), at: 0, inflate: Inflate::new(true, 15), ended: false }
    }

    fn fetch(&mut self) -> io::Result<()> {
        self.input.resize(INPUT_BYTES, 0);
        self.at = 0;
        let count = loop {
            match self.source.read(&mut self.input) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                outcome => break outcome?,
            }
        };
        self.input.truncate(count);
        Ok(())
    }
}

impl<R: Read> Read for Inflated<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if out.is_empty() {
            return Ok(0);
        }
        while !self.ended {
            if self.at == self.input.len() {
                self.fetch()?;
                if self.input.is_empty() {
                    return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the compressed data end early"));
                }
            }
            let (read, written) = (self.inflate.total_in(), self.inflate.total_out());
            let status = self
                .inflate
                .decompress(&self.input[self.at..], out, InflateFlush::NoFlush)
                .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.as_str()))?;
            self.at += (self.inflate.total_in() - read) as usize;
            self.ended = status == Status::StreamEnd;
            let count = (self.inflate.total_out() - written) as usize;
            if count > 0 {
                return Ok(count);
            }
            if !self.ended && self.inflate.total_in() == read && self.at < self.input.len() {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "the compressed data are invalid"));
            }
        }
        Ok(0)
    }
}
