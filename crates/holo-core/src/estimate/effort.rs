//! The trade-off between time and error.

/// The trade-off between the time and the error of [`plane_sweep`](crate::plane_sweep).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Effort {
    /// A cross of up to 8 views in gray, planes one pixel of the outermost view apart, refined once.
    Draft,
    /// A cross of up to 16 views in color, refined twice.
    Fast,
    /// A star of up to 32 views in color, planes half a pixel apart, refined three times.
    #[default]
    Balanced,
    /// A grid of up to 9 x 9 views in color, planes half a pixel apart, refined four times.
    Thorough,
}

/// The settings of an effort.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    pub(super) is_grey: bool,
    pub(super) has_diagonals: bool,
    /// Views of an arm of the star; `None`: a grid of views.
    pub(super) views_per_arm: Option<usize>,
    /// The movement of the outermost view from plane to plane, in pixels.
    pub(super) step_px: f32,
    pub(super) refinements: usize,
    /// The gate of a round, in gates of the round before: that of the last is a quarter of the first.
    pub(super) next_gate: f32,
    /// Half the side of the square for plane fits, in pixels.
    pub(super) radius_px: usize,
}

impl Settings {
    /// The largest number of views around the central one.
    pub(super) fn most_views(&self) -> usize {
        let arms = if self.has_diagonals { 8 } else { 4 };
        self.views_per_arm.map_or(80, |views| arms * views)
    }
}

impl Effort {
    pub(super) fn settings(self) -> Settings {
        let balanced = Settings {
            is_grey: false,
            has_diagonals: true,
            views_per_arm: Some(4),
            step_px: 0.5,
            refinements: 3,
            next_gate: 0.5,
            radius_px: 7,
        };
        match self {
            Self::Draft => Settings {
                is_grey: true,
                has_diagonals: false,
                views_per_arm: Some(2),
                step_px: 1.0,
                refinements: 1,
                radius_px: 3,
                ..balanced
            },
            Self::Fast => Settings {
                has_diagonals: false,
                step_px: 0.75,
                refinements: 2,
                next_gate: 0.25,
                radius_px: 5,
                ..balanced
            },
            Self::Balanced => balanced,
            Self::Thorough => Settings { views_per_arm: None, refinements: 4, next_gate: 0.63, ..balanced },
        }
    }
}
