//! Raw images in their two layouts, and how a file name tells which one it is.

#[cfg(feature = "png")]
mod read;

use std::path::Path;

use crate::dataset;

#[cfg(feature = "png")]
pub use read::RawImage;

/// Which of the two grids a raw image is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// The elemental grid: lens `(v, u)` owns the T x S block at row `v*T`, column `u*S`.
    Elemental,
    /// The viewpoint grid: view `(t, s)` owns the V x U block at row `t*V`, column `s*U`.
    Viewpoint,
}

impl Layout {
    /// Tells the layout from a file name: the last `_el` or `_vpi` in it, as a whole word.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_io::Layout;
    ///
    /// assert_eq!(Layout::of_file_name("out/scene_el.png"), Some(Layout::Elemental));
    /// assert_eq!(Layout::of_file_name("scene_vpi_16bit.png"), Some(Layout::Viewpoint));
    /// assert_eq!(Layout::of_file_name("scene_elephant.png"), None);
    /// ```
    #[must_use]
    pub fn of_file_name(path: impl AsRef<Path>) -> Option<Self> {
        let stem = path.as_ref().file_stem()?.to_str()?;
        stem.split(['_', '-', '.', ' ']).skip(1).fold(None, |found, word| match word {
            "el" => Some(Self::Elemental),
            "vpi" => Some(Self::Viewpoint),
            _ => found,
        })
    }

    /// Returns the name that an image of this layout has in a dataset folder.
    #[must_use]
    pub const fn file_name(self) -> &'static str {
        match self {
            Self::Elemental => dataset::ELEMENTAL_PNG,
            Self::Viewpoint => dataset::VIEWPOINT_PNG,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_told_by_whole_words() {
        for (name, layout) in [
            ("scene_el.png", Some(Layout::Elemental)),
            ("/a_vpi/scene_el.png", Some(Layout::Elemental)),
            ("my_el_vpi.png", Some(Layout::Viewpoint)),
            ("x-el.png", Some(Layout::Elemental)),
            ("el.png", None),
            ("el_x.png", None),
            ("scene.png", None),
            ("scene_EL.png", None),
            ("", None),
            ("..", None),
        ] {
            assert_eq!(Layout::of_file_name(name), layout, "{name}");
        }
        for layout in [Layout::Elemental, Layout::Viewpoint] {
            assert_eq!(Layout::of_file_name(layout.file_name()), Some(layout));
        }
    }
}
