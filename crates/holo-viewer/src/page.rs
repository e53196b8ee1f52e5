//! The HTML of the page: style and scripts from `page/`, and the data.
//!
//! The order is style, body, data, scripts, so that a browser shows the page before it parses the data. The data are
//! text elements that are not executed. The image is divided into blocks, an element each, which the scripts remove as
//! soon as they are decoded.

use std::io::{self, Read, Write};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use holo_core::{Disparity, GridSize, Projection, Rig};
use ndarray::Array2;
use serde_json::{Value, json};

use crate::contents::Page;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/style.css");

/// The scripts in the order of their dependencies.
const SCRIPTS: [&str; 16] = [
    include_str!("page/embedded.js"),
    include_str!("page/geometry.js"),
    include_str!("page/state.js"),
    include_str!("page/colors.js"),
    include_str!("page/frame.js"),
    include_str!("page/shaders.js"),
    include_str!("page/tiles.js"),
    include_str!("page/webgl.js"),
    include_str!("page/canvas.js"),
    include_str!("page/drawing.js"),
    include_str!("page/readout.js"),
    include_str!("page/inset.js"),
    include_str!("page/controls.js"),
    include_str!("page/gestures.js"),
    include_str!("page/surface.js"),
    include_str!("page/main.js"),
];

/// Placeholders of `page.html` in order.
const PLACEHOLDERS: [&str; 4] = ["{{title}}", "{{style}}", "{{data}}", "{{scripts}}"];

/// Bytes of one block: a multiple of three, so that only the last one is padded.
const BLOCK_BYTES: usize = 3 << 20;

impl Page {
    /// Writes the page as HTML.
    ///
    /// # Errors
    ///
    /// Those of `out`, and of reading the file of the raw image.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut rest = PAGE;
        for placeholder in PLACEHOLDERS {
            // A test checks that the page has every placeholder.
            let (before, after) = rest.split_once(placeholder).unwrap_or((rest, ""));
            out.write_all(before.as_bytes())?;
            match placeholder {
                "{{title}}" => out.write_all(escaped(&self.title).as_bytes())?,
                "{{style}}" => out.write_all(STYLE.as_bytes())?,
                "{{data}}" => write_data(out, self)?,
                _ => SCRIPTS.iter().try_for_each(|script| out.write_all(script.as_bytes()))?,
            }
            rest = after;
        }
        out.write_all(rest.as_bytes())
    }
}

fn write_data(out: &mut impl Write, contents: &Page) -> io::Result<()> {
    // Only `</script` ends an element of this kind.
    let numbers = numbers(contents).to_string().replace('<', "\\u003c");
    writeln!(out, "<script type=\"application/json\" id=\"numbers\">{numbers}</script>")?;
    let maps =
        [("depth", &contents.depth_m), ("disparity", &contents.disparity_px), ("estimate", &contents.estimate_px)];
    for (name, map) in maps {
        if let Some(map) = map {
            write_blocks(out, name, &mut little_endian(map).as_slice())?;
        }
    }
    write_blocks(out, "image", &mut contents.image.bytes()?)
}

/// Writes bytes as elements of at most 4 MiB of base64 each.
fn write_blocks(out: &mut impl Write, name: &str, source: &mut impl Read) -> io::Result<()> {
    let mut block = Vec::with_capacity(BLOCK_BYTES);
    loop {
        block.clear();
        if source.by_ref().take(BLOCK_BYTES as u64).read_to_end(&mut block)? == 0 {
            return Ok(());
        }
        write!(out, "<script type=\"text/plain\" data-block=\"{name}\">")?;
        let mut text = EncoderWriter::new(&mut *out, &STANDARD);
        text.write_all(&block)?;
        text.finish()?;
        drop(text);
        writeln!(out, "</script>")?;
    }
}

fn little_endian(map: &Array2<f32>) -> Vec<u8> {
    map.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Title, counts, and the parameters of the rig for Eq. 3: k and F.
fn numbers(contents: &Page) -> Value {
    let size = |size: GridSize| json!({"columns": size.columns, "rows": size.rows});
    json!({
        "title": contents.title,
        "version": env!("CARGO_PKG_VERSION"),
        "views": size(contents.shape.views()),
        "lenses": size(contents.shape.lenses()),
        "rig": contents.rig.as_ref().map(rig),
    })
}

fn rig(rig: &Rig) -> Value {
    let (x, y): (Disparity, Disparity) = (rig.disparity_x(), rig.disparity_y());
    let focus_m = x.focus_distance_m();
    json!({
        "scale_m_px": {"x": x.scale_m_px(), "y": y.scale_m_px()},
        // JSON has no infinity.
        "focus_distance_m": if focus_m.is_finite() { json!(focus_m) } else { Value::Null },
        "orthographic": x.projection() == Projection::Orthographic,
    })
}

fn escaped(text: &str) -> String {
    holo_core::shown(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_placeholder_occurs_once_and_in_order() {
        let found: Vec<_> = PLACEHOLDERS.map(|placeholder| PAGE.find(placeholder).expect(placeholder)).into();
        assert!(found.is_sorted(), "{found:?}");
        assert!(PLACEHOLDERS.iter().all(|placeholder| PAGE.matches(placeholder).count() == 1));
    }

    /// A page that uses the network contains an address or one of these calls.
    #[test]
    fn nothing_refers_to_another_resource() {
        for text in [PAGE, STYLE].into_iter().chain(SCRIPTS) {
            for word in ["http:", "https:", "@import", "fetch(", "XMLHttpRequest", "src=\"//", "</script"] {
                assert!(!text.contains(word) || (text == PAGE && word == "</script"), "{word} in: {text:.60}");
            }
        }
    }

    #[test]
    fn titles_cannot_leave_their_element() {
        assert_eq!(escaped("</title><b a=\"&\">"), "&lt;/title&gt;&lt;b a=&quot;&amp;&quot;&gt;");
    }
}
