//! The header of a PFM: magic number, width, height, scale; and the length of the data that follow.

use std::io::{self, BufRead};
use std::path::Path;

use holo_core::GridSize;

use super::PfmInfo;
use crate::Error;

/// Maximum length of a header with its comments, in bytes.
pub(super) const MAX_BYTES: u64 = 4096;

pub(super) struct Header {
    pub(super) info: PfmInfo,
    /// Bytes up to and including the single white space after the scale.
    bytes: u64,
    /// Whether that white space was a carriage return.
    carriage_return: bool,
}

impl Header {
    pub(super) fn read(source: &mut impl BufRead, path: &Path) -> Result<Self, Error> {
        let mut tokens = Tokens { source, path, bytes: 0, last: 0 };
        let channels = match tokens.next("magic number")?.as_str() {
            "Pf" => 1,
            "PF" => 3,
            _ => return Err(Error::broken(path, "PFM", "it does not begin with Pf or PF")),
        };
        let columns = tokens.count("width")?;
        let rows = tokens.count("height")?;
        let scale = tokens.next("scale")?;
        let scale =
            scale.parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0).ok_or_else(|| {
                Error::broken(path, "PFM", format!("the scale {scale:?} is not a number other than 0"))
            })?;
        let info =
            PfmInfo { size: GridSize::new(rows, columns), channels, scale: scale.abs(), little_endian: scale < 0.0 };
        Ok(Self { info, bytes: tokens.bytes, carriage_return: tokens.last == b'\r' })
    }

    /// Checks that data of exactly the announced length follow, and skips the line feed of a Windows line end.
    pub(super) fn check_length(&self, source: &mut impl BufRead, length: u64, path: &Path) -> Result<(), Error> {
        let GridSize { rows, columns } = self.info.size;
        let needed = [rows, columns, self.info.channels, size_of::<f32>()]
            .into_iter()
            .try_fold(1_u64, |product, count| product.checked_mul(count as u64));
        let found = length.saturating_sub(self.bytes);
        // A float may begin with the byte 10, so only the length distinguishes a line feed from data.
        if self.carriage_return && needed.is_some_and(|needed| needed.checked_add(1) == Some(found)) {
            let mut line_feed = [0];
            source.read_exact(&mut line_feed).map_err(|source| read_error(source, path))?;
            if line_feed == *b"\n" {
                return Ok(());
            }
        }
        match needed {
            Some(needed) if needed == found => Ok(()),
            Some(needed) => Err(Error::broken(
                path,
                "PFM",
                format!("{columns} x {rows} pixels need {needed} bytes after the header, but there are {found}"),
            )),
            None => {
                Err(Error::broken(path, "PFM", format!("{columns} x {rows} pixels are more than a file can contain")))
            }
        }
    }
}

/// The words of a header, separated by white space and comments.
struct Tokens<'a, R> {
    source: &'a mut R,
    path: &'a Path,
    bytes: u64,
    last: u8,
}

impl<R: BufRead> Tokens<'_, R> {
    fn byte(&mut self) -> Result<u8, Error> {
        let mut byte = [0];
        self.source.read_exact(&mut byte).map_err(|source| read_error(source, self.path))?;
        self.bytes += 1;
        if self.bytes > MAX_BYTES {
            return Err(Error::broken(self.path, "PFM", format!("the header is longer than {MAX_BYTES} bytes")));
        }
        self.last = byte[0];
        Ok(byte[0])
    }

    /// Returns the next word, and consumes exactly one white space after it.
    fn next(&mut self, what: &str) -> Result<String, Error> {
        let mut word = String::new();
        loop {
            match self.byte()? {
                b'#' if word.is_empty() => while !matches!(self.byte()?, b'\n' | b'\r') {},
                byte if byte.is_ascii_whitespace() => {
                    if !word.is_empty() {
                        return Ok(word);
                    }
                }
                byte if byte.is_ascii_graphic() => word.push(char::from(byte)),
                byte => {
                    return Err(Error::broken(
                        self.path,
                        "PFM",
                        format!("the byte {byte} at offset {} is not part of a {what}", self.bytes - 1),
                    ));
                }
            }
        }
    }

    fn count(&mut self, what: &str) -> Result<usize, Error> {
        let word = self.next(what)?;
        // `parse` alone would accept a sign.
        let digits = word.bytes().all(|byte| byte.is_ascii_digit());
        word.parse().ok().filter(|&count| digits && count > 0).ok_or_else(|| {
            Error::broken(self.path, "PFM", format!("the {what} {word:?} is not a whole number above 0"))
        })
    }
}

/// Converts an error of reading: the end of the file means a broken file.
pub(super) fn read_error(source: io::Error, path: &Path) -> Error {
    if source.kind() == io::ErrorKind::UnexpectedEof {
        Error::broken(path, "PFM", "the file ends early")
    } else {
        Error::io("read", path, source)
    }
}
