//! Some of the views of a grid: a cross, a star, or any list, as networks for depth estimation take them.

use std::fmt;
use std::str::FromStr;

use holo_core::{GridSize, ViewIndex};

use super::value::Malformed;

/// Some of the views of a grid.
#[derive(Clone, Debug)]
pub enum ViewSubset {
    /// The row and the column of the central view.
    Cross,
    /// The same, and both diagonals through the central view.
    Star,
    /// Any views. Order and repetitions mean nothing.
    List(Vec<ViewIndex>),
}

impl ViewSubset {
    /// Returns the views of a grid, row by row, each once.
    #[must_use]
    pub fn views(&self, views: GridSize) -> Vec<ViewIndex> {
        let central = ViewIndex::new(views.rows / 2, views.columns / 2);
        let belongs = |view: ViewIndex| {
            let (down, right) = (view.row.abs_diff(central.row), view.column.abs_diff(central.column));
            match self {
                Self::Cross => down == 0 || right == 0,
                Self::Star => down == 0 || right == 0 || down == right,
                Self::List(list) => list.contains(&view),
            }
        };
        let all = (0..views.count()).map(|k| ViewIndex::new(k / views.columns, k % views.columns));
        all.filter(|&view| belongs(view)).collect()
    }
}

/// Equal lists have the same views.
impl PartialEq for ViewSubset {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Cross, Self::Cross) | (Self::Star, Self::Star) => true,
            (Self::List(a), Self::List(b)) => sorted(a) == sorted(b),
            _ => false,
        }
    }
}

impl Eq for ViewSubset {}

/// Views row by row, each once.
fn sorted(list: &[ViewIndex]) -> Vec<ViewIndex> {
    let mut views = list.to_vec();
    views.sort_unstable_by_key(|view| (view.row, view.column));
    views.dedup();
    views
}

impl FromStr for ViewSubset {
    type Err = Malformed;

    /// Parses `cross`, `star`, or positions `column,row` separated by `;`.
    fn from_str(text: &str) -> Result<Self, Malformed> {
        match text {
            "cross" => Ok(Self::Cross),
            "star" => Ok(Self::Star),
            list => {
                let position = |text: &str| {
                    let (column, row) = text.trim().split_once(',')?;
                    Some(ViewIndex::new(row.trim().parse().ok()?, column.trim().parse().ok()?))
                };
                let views: Option<Vec<ViewIndex>> = list.split(';').map(position).collect();
                views.map(Self::List).ok_or_else(|| "give cross, star, or views as COLUMN,ROW;COLUMN,ROW ..".into())
            }
        }
    }
}

/// The text from which the same views are parsed, one for equal subsets.
impl fmt::Display for ViewSubset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cross => f.write_str("cross"),
            Self::Star => f.write_str("star"),
            Self::List(list) => {
                let views = sorted(list);
                let views: Vec<String> = views.iter().map(|view| format!("{},{}", view.column, view.row)).collect();
                f.write_str(&views.join(";"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosses_stars_and_lists() {
        let views = |subset: ViewSubset, rows, columns| subset.views(GridSize::new(rows, columns));
        assert_eq!(views(ViewSubset::Cross, 9, 9).len(), 17);
        assert_eq!(views(ViewSubset::Star, 9, 9).len(), 33);
        assert_eq!(views(ViewSubset::Cross, 3, 2), [[0, 1], [1, 0], [1, 1], [2, 1]].map(ViewIndex::from));
        let list: ViewSubset = "2,0; 0,1;2,0".parse().expect("a list");
        assert_eq!(list.to_string(), "2,0;0,1");
        assert_eq!(list, "0,1;2,0".parse::<ViewSubset>().expect("the same list"));
        assert_ne!(list, "0,1".parse::<ViewSubset>().expect("another list"));
        assert_eq!(views(list, 2, 3), [[0, 2], [1, 0]].map(ViewIndex::from));
        for text in ["cross", "star", "2,0;0,1"] {
            assert_eq!(text.parse::<ViewSubset>().expect("a subset").to_string(), text);
        }
        for text in ["", "ring", "1", "1,2;", "1,-2"] {
            assert!(text.parse::<ViewSubset>().is_err(), "{text}");
        }
    }
}
