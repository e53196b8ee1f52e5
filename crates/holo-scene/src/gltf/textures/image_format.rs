//! The format of an image by its first bytes. Declared MIME types and file names are often wrong.

use image::ImageFormat;

/// The formats that are decoded.
const DECODED: [ImageFormat; 3] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP];

/// First bytes of what files refer to as images, and what it is.
const OTHERS: &[(&[u8], &str)] = &[
    (
        b"\xABKTX 20\xBB\r\n\x1A\n",
        "a KTX2 image (decode it with `npx @gltf-transform/cli ktxdecompress in.glb out.glb`)",
    ),
    (b"\xABKTX 11\xBB\r\n\x1A\n", "a KTX image"),
    (b"version https://git-lfs", "a pointer of Git LFS (fetch the image with `git lfs pull`)"),
    (b"8BPS", "a Photoshop image"),
    (b"<!DOCTYPE", "an HTML page"),
    (b"<!doctype", "an HTML page"),
    (b"<html", "an HTML page"),
    (b"<svg", "an SVG drawing"),
    (b"<?xml", "an XML file, such as an SVG drawing"),
    (b"\xFF\x0A", "a JPEG XL image"),
    (b"\0\0\0\x0CJXL ", "a JPEG XL image"),
    (b"\0\0\0\x0CjP  ", "a JPEG 2000 image"),
    (b"sB", "a Basis Universal image"),
];

/// The format of an image that is decoded, or what it is instead.
pub(super) fn detect(bytes: &[u8]) -> Result<ImageFormat, String> {
    if bytes.is_empty() {
        return Err("empty".into());
    }
    if let Ok(format) = image::guess_format(bytes) {
        return if DECODED.contains(&format) { Ok(format) } else { Err(other(format)) };
    }
    match OTHERS.iter().find(|(start, _)| bytes.starts_with(start)) {
        Some((_, name)) => Err((*name).into()),
        None => Err("neither PNG nor JPEG nor WebP, or it is damaged".into()),
    }
}

fn other(format: ImageFormat) -> String {
    let name = match format {
        ImageFormat::Gif => "GIF",
        ImageFormat::Tiff => "TIFF",
        ImageFormat::Bmp => "BMP",
        ImageFormat::Dds => "DDS",
        ImageFormat::Hdr => "Radiance HDR",
        ImageFormat::OpenExr => "OpenEXR",
        ImageFormat::Avif => "AVIF",
        ImageFormat::Ico => "ICO",
        other => return format!("of the format {other:?} (convert it to PNG)"),
    };
    format!("of the format {name} (convert it to PNG)")
}
