//! How much work an estimate is worth.

/// How much work an estimate is worth: from a look at a handful of views to all that helps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Effort {
    /// A cross of up to 8 views in gray, planes one pixel of the outermost view apart, refined once.
    Draft,
    /// A cross of up to 16 views in color, refined twice.
    Fast,
    /// A star of up to 32 views in color, planes half a pixel apart, refined four times.
    #[default]
    Balanced,
    /// A star of up to 64 views in color, planes 0.35 pixels apart, refined six times.
    Thorough,
}

/// What an effort stands for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    pub(super) is_grey: bool,
    pub(super) has_diagonals: bool,
    pub(super) views_per_arm: usize,
    /// How far the outermost view moves from plane to plane.
    pub(super) step_px: f32,
    pub(super) refinements: usize,
    /// Half the side of the square to which planes are fitted.
    pub(super) radius_px: usize,
}

impl Effort {
    pub(super) fn settings(self) -> Settings {
        let balanced = Settings {
            is_grey: false,
            has_diagonals: true,
            views_per_arm: 4,
            step_px: 0.5,
            refinements: 4,
            radius_px: 7,
        };
        match self {
            Self::Draft => Settings {
                is_grey: true,
                has_diagonals: false,
                views_per_arm: 2,
                step_px: 1.0,
                refinements: 1,
                radius_px: 3,
            },
            Self::Fast => Settings { has_diagonals: false, step_px: 0.75, refinements: 2, radius_px: 5, ..balanced },
            Self::Balanced => balanced,
            Self::Thorough => Settings { views_per_arm: 8, step_px: 0.35, refinements: 6, radius_px: 9, ..balanced },
        }
    }
}
