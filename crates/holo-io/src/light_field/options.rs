//! Options of reading a light field.

use holo_core::{GridSize, Layout, ViewOrder};

use crate::Limits;

/// Options of reading a light field: limits, and what the files may not specify. By default everything is taken from
/// the files.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Layout};
/// use holo_io::ReadOptions;
///
/// let options = ReadOptions::default().views(GridSize::new(9, 9)).layout(Layout::ElementalGrid);
/// assert_eq!(options.views, Some(GridSize::new(9, 9)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Maximum memory that reading may take.
    pub limits: Limits,
    /// The number of views, T rows and S columns. `None`: the files must specify it. The files must not contradict it. Of a
    /// plenoptic camera so many are decoded.
    pub views: Option<GridSize>,
    /// The layout of a raw image. `None`: the file name must specify it, as in
    /// [`layout_of_file_name`](crate::layout_of_file_name).
    pub layout: Option<Layout>,
    /// Which view each image of a folder of images is. Not used for other formats.
    pub order: ViewOrder,
}

impl ReadOptions {
    /// Sets [`limits`](Self::limits).
    #[must_use]
    pub const fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Sets [`views`](Self::views).
    #[must_use]
    pub fn views(mut self, views: impl Into<Option<GridSize>>) -> Self {
        self.views = views.into();
        self
    }

    /// Sets [`layout`](Self::layout).
    #[must_use]
    pub fn layout(mut self, layout: impl Into<Option<Layout>>) -> Self {
        self.layout = layout.into();
        self
    }

    /// Sets [`order`](Self::order).
    #[must_use]
    pub const fn order(mut self, order: ViewOrder) -> Self {
        self.order = order;
        self
    }
}
