//! A zlib stream read back as bytes, never more at a time than asked for.

use std::io::{self, Read};

use zlib_rs::{Inflate, InflateFlush, Status};

/// Compressed bytes fetched at a time.
const INPUT_BYTES: usize = 64 << 10;

/// The bytes that a zlib stream holds. Its checksum is verified when its end is reached.
///
/// Only what is asked for is inflated, so a few bytes that stand for gigabytes do no harm.
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
                return Err(io::Error::new(io::ErrorKind::InvalidData, "the compressed data make no sense"));
            }
        }
        Ok(0)
    }
}
