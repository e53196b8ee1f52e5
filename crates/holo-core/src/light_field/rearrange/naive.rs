//! The reference implementation of Eq. 4: five loops over every sample.
//!
//! Tests compare the fast implementation with it bit by bit.

use ndarray::{Array3, ArrayView3};

use crate::base::memory::collected;
use crate::{Error, LightFieldShape};

/// Rearranges an elemental grid into a viewpoint grid, sample by sample: `VPI(t*V + v, s*U + u) = EI(v*T + t, u*S +
/// s)`.
///
/// # Shape
///
/// `(V*T, U*S, C)` in, `(T*V, S*U, C)` out.
///
/// # Errors
///
/// [`Error::Shape`] if the image is not of the raw size of `shape`; [`Error::OutOfMemory`] if the allocation fails.
///
/// # Source
///
/// Eq. 4.
pub fn to_viewpoint_grid<T: Copy>(elemental: ArrayView3<'_, T>, shape: LightFieldShape) -> Result<Array3<T>, Error> {
    let mut viewpoint = copied("elemental grid", &elemental, &shape)?;
    for_each_pair(&shape, elemental.dim().2, |in_elemental, in_viewpoint| {
        viewpoint[in_viewpoint] = elemental[in_elemental];
    });
    Ok(viewpoint)
}

/// Rearranges a viewpoint grid into an elemental grid, sample by sample: `EI(v*T + t, u*S + s) = VPI(t*V + v, s*U +
/// u)`.
///
/// # Shape
///
/// `(T*V, S*U, C)` in, `(V*T, U*S, C)` out.
///
/// # Errors
///
/// As [`to_viewpoint_grid`].
///
/// # Source
///
/// Eq. 4, inverted.
pub fn to_elemental_grid<T: Copy>(viewpoint: ArrayView3<'_, T>, shape: LightFieldShape) -> Result<Array3<T>, Error> {
    let mut elemental = copied("viewpoint grid", &viewpoint, &shape)?;
    for_each_pair(&shape, viewpoint.dim().2, |in_elemental, in_viewpoint| {
        elemental[in_elemental] = viewpoint[in_viewpoint];
    });
    Ok(elemental)
}

/// Calls a function with the index of every sample in the elemental grid and in the viewpoint grid.
fn for_each_pair(shape: &LightFieldShape, channels: usize, mut function: impl FnMut([usize; 3], [usize; 3])) {
    let (views, lenses) = (shape.views(), shape.lenses());
    for v in 0..lenses.rows {
        for u in 0..lenses.columns {
            for t in 0..views.rows {
                for s in 0..views.columns {
                    for c in 0..channels {
                        let in_elemental = [v * views.rows + t, u * views.columns + s, c];
                        let in_viewpoint = [t * lenses.rows + v, s * lenses.columns + u, c];
                        function(in_elemental, in_viewpoint);
                    }
                }
            }
        }
    }
}

/// A copy of an image whose size has been checked.
fn copied<T: Copy>(what: &'static str, image: &ArrayView3<'_, T>, shape: &LightFieldShape) -> Result<Array3<T>, Error> {
    let raw = shape.raw_size();
    let (rows, columns, channels) = image.dim();
    if (rows, columns) != (raw.rows, raw.columns) {
        let expected = vec![raw.rows, raw.columns, channels];
        return Err(Error::Shape { what, expected, found: vec![rows, columns, channels] });
    }
    let memory = collected("a raw image", image.iter().copied())?;
    Ok(Array3::from_shape_vec(image.raw_dim(), memory).expect("one sample each"))
}
