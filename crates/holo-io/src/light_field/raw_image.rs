//! The layout of a raw image, from its file name.

use std::path::Path;

use holo_core::Layout;

/// Returns the layout of a raw image from its file name: that of the last word `el` or `vpi` that follows `_`, `-`, `.`
/// or a space. `None` if there is no such word.
///
/// # Examples
///
/// ```
/// use holo_core::Layout;
/// use holo_io::layout_of_file_name;
///
/// assert_eq!(layout_of_file_name("out/scene_el.png"), Some(Layout::ElementalGrid));
/// assert_eq!(layout_of_file_name("scene_vpi_16bit.png"), Some(Layout::ViewpointGrid));
/// assert_eq!(layout_of_file_name("scene_elephant.png"), None);
/// ```
#[must_use]
pub fn layout_of_file_name(path: impl AsRef<Path>) -> Option<Layout> {
    let stem = path.as_ref().file_stem()?.to_str()?;
    stem.split(['_', '-', '.', ' ']).skip(1).fold(None, |found, word| match word {
        "el" => Some(Layout::ElementalGrid),
        "vpi" => Some(Layout::ViewpointGrid),
        _ => found,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::names;

    #[test]
    fn whole_words_specify_the_layout() {
        for (name, layout) in [
            ("scene_el.png", Some(Layout::ElementalGrid)),
            ("/a_vpi/scene_el.png", Some(Layout::ElementalGrid)),
            ("my_el_vpi.png", Some(Layout::ViewpointGrid)),
            ("x-el.png", Some(Layout::ElementalGrid)),
            ("el.png", None),
            ("el_x.png", None),
            ("scene.png", None),
            ("scene_EL.png", None),
            ("", None),
            ("..", None),
        ] {
            assert_eq!(layout_of_file_name(name), layout, "{name}");
        }
        assert_eq!(layout_of_file_name(names::ELEMENTAL_PNG), Some(Layout::ElementalGrid));
        assert_eq!(layout_of_file_name(names::VIEWPOINT_PNG), Some(Layout::ViewpointGrid));
    }
}
