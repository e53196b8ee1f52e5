//! Every `encode_*` writes into any writer, and every `decode_*` reads from any reader.

use std::io::{self, Cursor, Read, Write};

use holo_core::DynImage;
use holo_io::{
    ColorEncoding, Compression, Error, ExrChannel, Limits, MatArray, MatOptions, MatValue, MatVariable, Pfm,
    decode_exr, decode_exr_rgb, decode_hdr, decode_mat, decode_pfm, decode_png, encode_exr, encode_mat, encode_png,
};
use ndarray::{Array2, Array3, array};

const SIZE: (usize, usize, usize) = (30, 40, 3);

/// A pipe at its worst: one byte at a time, each second call interrupted, and from byte `end` on an error.
struct Pipe<T> {
    inner: T,
    end: usize,
    bytes: usize,
    is_interrupted: bool,
}

fn pipe<T>(inner: T, end: usize) -> Pipe<T> {
    Pipe { inner, end, bytes: 0, is_interrupted: false }
}

impl<T> Pipe<T> {
    fn turn(&mut self) -> io::Result<()> {
        self.is_interrupted = !self.is_interrupted;
        if self.is_interrupted {
            return Err(io::ErrorKind::Interrupted.into());
        }
        if self.bytes == self.end {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.bytes += 1;
        Ok(())
    }
}

impl<T: Read> Read for Pipe<T> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.turn()?;
        let end = buffer.len().min(1);
        self.inner.read(&mut buffer[..end])
    }
}

impl<T: Write> Write for Pipe<T> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        self.turn()?;
        self.inner.write(&data[..data.len().min(1)])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

type Encode = Box<dyn Fn(&mut dyn Write) -> Result<(), Error>>;
type Decode = fn(&mut dyn Read) -> Result<bool, Error>;

fn codes() -> Array3<u16> {
    Array3::from_shape_fn(SIZE, |(row, column, channel)| (row * 1999 + column * 37 + channel * 7) as u16)
}

fn plane() -> Array2<f32> {
    Array2::from_shape_fn((SIZE.0, SIZE.1), |(row, column)| (row * 40 + column) as f32 / 7.0)
}

/// The formats: how an image is encoded, and whether what is decoded is that image.
fn formats() -> Vec<(&'static str, Encode, Decode)> {
    let png = |compression| -> Encode {
        Box::new(move |out| encode_png(out, codes().view(), ColorEncoding::Linear, compression))
    };
    let mat = |is_compressed| -> Encode {
        let options = MatOptions::default().compressed(is_compressed);
        Box::new(move |out| {
            let plane = plane().into_dyn();
            encode_mat(out, &[MatVariable { name: "x", value: MatValue::F32(plane.view()) }], &options)
        })
    };
    let read_png: Decode = |source| Ok(decode_png(source, &Limits::default())? == DynImage::U16(codes()));
    let read_mat: Decode =
        |source| Ok(decode_mat(source, &Limits::default())? == [("x".to_owned(), MatArray::F32(plane().into_dyn()))]);
    vec![
        ("png, fast", png(Compression::Fast), read_png),
        ("png, best", png(Compression::Best), read_png),
        (
            "pfm",
            Box::new(|out| Pfm { values: plane().insert_axis(ndarray::Axis(2)), scale: 1.0 }.encode(out)),
            |source| Ok(decode_pfm(source, &Limits::default())?.values.remove_axis(ndarray::Axis(2)) == plane()),
        ),
        ("exr", Box::new(|out| encode_exr(out, &[ExrChannel::float("Y", plane().view())])), |source| {
            Ok(decode_exr(source, &Limits::default())?.channel("Y") == Some(&plane()))
        }),
        ("exr as color", Box::new(|out| encode_exr(out, &[ExrChannel::float("Y", plane().view())])), |source| {
            Ok(decode_exr_rgb(source, &Limits::default())?.index_axis(ndarray::Axis(2), 1) == plane())
        }),
        ("mat", mat(false), read_mat),
        ("mat, compressed", mat(true), read_mat),
        (
            "hdr",
            Box::new(|out| {
                let bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x81";
                out.write_all(bytes).map_err(|source| Error::Io { action: "write", path: "hdr".into(), error: source })
            }),
            |source| Ok(decode_hdr(source, &Limits::default())? == array![[[1.0, 0.5, 0.25]]]),
        ),
    ]
}

#[test]
fn bytes_that_arrive_one_by_one_are_the_same_image() {
    for (name, encode, decode) in formats() {
        let mut whole = Vec::new();
        encode(&mut whole).unwrap();
        let mut slow = pipe(Vec::new(), usize::MAX);
        encode(&mut slow).unwrap();
        assert_eq!(slow.inner, whole, "{name}");
        assert!(decode(&mut whole.as_slice()).unwrap(), "{name}");
        assert!(decode(&mut pipe(Cursor::new(&whole), usize::MAX)).unwrap(), "{name}");
    }
}

#[test]
fn the_error_of_a_stream_is_the_error() {
    let is_full =
        |error: &Error| matches!(error, Error::Io { error: source, .. } if source.kind() == io::ErrorKind::StorageFull);
    for (name, encode, decode) in formats() {
        let mut whole = Vec::new();
        encode(&mut whole).unwrap();
        for end in [0, 1, whole.len() / 2, whole.len() - 1] {
            let error = encode(&mut pipe(Vec::new(), end)).unwrap_err();
            assert!(is_full(&error), "{name} at {end}: {error:?}");
            let error = decode(&mut pipe(Cursor::new(&whole), end)).unwrap_err();
            assert!(is_full(&error), "{name} at {end}: {error:?}");
        }
    }
}

#[test]
fn a_stream_without_end_is_too_large() {
    let limits = Limits { max_bytes: 1000 };
    for decode in [
        |source: io::Repeat, limits| decode_png(source, limits).map(drop),
        |source: io::Repeat, limits| decode_pfm(source, limits).map(drop),
        |source: io::Repeat, limits| decode_exr(source, limits).map(drop),
        |source: io::Repeat, limits| decode_mat(source, limits).map(drop),
    ] as [fn(io::Repeat, &Limits) -> Result<(), Error>; 4]
    {
        let error = decode(io::repeat(7), &limits).unwrap_err();
        assert!(matches!(error, Error::TooLarge { what: "encoded file", .. }), "{error:?}");
    }
}
