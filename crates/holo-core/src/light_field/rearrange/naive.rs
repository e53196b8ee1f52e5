//! Eq. 4 to the letter: five loops over every sample.
//!
//! This is the oracle that the fast paths are tested against, bit for bit. It is slow on purpose: nothing in it is clever enough to be
//! wrong.

use ndarray::{Array3, ArrayView3};

use crate::{Error, Split};

/// Rearranges an elemental grid into a viewpoint grid, sample by sample: `VPI(t*V + v, s*U + u) = EI(v*T + t, u*S + s)`.
///
/// # Shape
///
/// `(V*T, U*S, C)` in, `(T*V, S*U, C)` out.
///
/// # Errors
///
/// [`Error::Shape`] if the image is not of the split's raw size.
///
/// # Source
///
/// Eq. 4.
pub fn to_viewpoint_grid<T: Copy>(elemental: ArrayView3<'_, T>, split: Split) -> Result<Array3<T>, Error> {
    let (views, lenses, channels) = check("elemental grid", &elemental, &split)?;
    let mut viewpoint = elemental.to_owned();
    for v in 0..lenses.rows {
        for u in 0..lenses.columns {
            for t in 0..views.rows {
                for s in 0..views.columns {
                    for c in 0..channels {
                        viewpoint[[t * lenses.rows + v, s * lenses.columns + u, c]] =
                            elemental[[v * views.rows + t, u * views.columns + s, c]];
                    }
                }
            }
        }
    }
    Ok(viewpoint)
}

/// Rearranges a viewpoint grid into an elemental grid, sample by sample: `EI(v*T + t, u*S + s) = VPI(t*V + v, s*U + u)`.
///
/// # Shape
///
/// `(T*V, S*U, C)` in, `(V*T, U*S, C)` out.
///
/// # Errors
///
/// [`Error::Shape`] if the image is not of the split's raw size.
///
/// # Source
///
/// Eq. 4 read from right to left.
pub fn to_elemental_grid<T: Copy>(viewpoint: ArrayView3<'_, T>, split: Split) -> Result<Array3<T>, Error> {
    let (views, lenses, channels) = check("viewpoint grid", &viewpoint, &split)?;
    let mut elemental = viewpoint.to_owned();
    for t in 0..views.rows {
        for s in 0..views.columns {
            for v in 0..lenses.rows {
                for u in 0..lenses.columns {
                    for c in 0..channels {
                        elemental[[v * views.rows + t, u * views.columns + s, c]] =
                            viewpoint[[t * lenses.rows + v, s * lenses.columns + u, c]];
                    }
                }
            }
        }
    }
    Ok(elemental)
}

fn check<T>(
    what: &'static str,
    image: &ArrayView3<'_, T>,
    split: &Split,
) -> Result<(crate::GridSize, crate::GridSize, usize), Error> {
    let raw = split.raw_size();
    let (rows, columns, channels) = image.dim();
    if (rows, columns) != (raw.rows, raw.columns) {
        let expected = vec![raw.rows, raw.columns, channels];
        return Err(Error::Shape { what, expected, found: vec![rows, columns, channels] });
    }
    Ok((split.views(), split.lenses(), channels))
}
