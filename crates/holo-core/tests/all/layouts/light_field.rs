//! Eq. 5: one 5D view over both layouts, without copying, for any strides and storage.

use super::samples::*;
use holo_core::{Error, GridSize, Layout, LightField, LightFieldShape};
use ndarray::{Array3, Array5, ArrayView5, aview0, s};
use proptest::prelude::*;
#[cfg(feature = "rayon")]
use rayon::prelude::*;

fn small() -> LightFieldShape {
    LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap()
}

/// A light field whose samples are their indices.
fn labeled(shape: LightFieldShape, channels: usize) -> LightField<ndarray::OwnedRepr<[usize; 5]>> {
    LightField::new(Array5::from_shape_fn(shape.array_shape(channels), |(v, u, t, s, c)| [v, u, t, s, c])).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    /// Every sample of the 5D array has the address of the pixel of Eq. 5.
    #[test]
    fn wrapping_copies_nothing(shape in shapes(), channels in channels(), strides in any_strides()) {
        let raw = shape.raw_size();
        let memory = store(&image::<u16>(raw.rows, raw.columns, channels), strides);
        let source = arranged(&memory, strides);
        let elemental = LightField::from_elemental_grid_view(&source, shape).unwrap();
        let viewpoint = LightField::from_viewpoint_grid_view(&source, shape).unwrap();
        prop_assert_eq!(elemental.shape(), shape);
        prop_assert_eq!(elemental.channels(), channels);
        let (views, lenses) = (shape.views(), shape.lenses());
        let (elemental, viewpoint) = (elemental.samples(), viewpoint.samples());
        for ((v, u, t, s, c), sample) in elemental.indexed_iter() {
            prop_assert!(std::ptr::eq(sample, &source[[v * views.rows + t, u * views.columns + s, c]]));
        }
        for ((v, u, t, s, c), sample) in viewpoint.indexed_iter() {
            prop_assert!(std::ptr::eq(sample, &source[[t * lenses.rows + v, s * lenses.columns + u, c]]));
        }
    }

    /// Dense images of any axis order, direction and storage are wrapped in place.
    #[test]
    fn any_storage_is_wrapped_in_place(shape in shapes(), channels in channels(), strides in dense_strides()) {
        let raw = shape.raw_size();
        let plain = image::<u8>(raw.rows, raw.columns, channels);
        let mut memory = store(&plain, strides);
        let expected = LightField::from_elemental_grid_view(&plain, shape).unwrap();
        {
            let view = arranged(&memory, strides);
            let light_field = LightField::from_elemental_grid(view, shape).unwrap();
            prop_assert!(light_field == expected);
            let first = light_field.samples();
            prop_assert!(std::ptr::eq(&first[[0, 0, 0, 0, 0]], &view[[0, 0, 0]]));
            let by_views = LightField::from_viewpoint_grid(view, shape).unwrap();
            prop_assert!(by_views == LightField::from_viewpoint_grid_view(&plain, shape).unwrap());
        }
        // Mutable: writes to the light field change the image.
        let mut back = [0; 3];
        for (position, &axis) in strides.order.iter().enumerate() {
            back[axis] = position;
        }
        {
            let mut view = memory.view_mut().permuted_axes(back);
            for axis in (0..3).filter(|&axis| strides.reversed[axis]) {
                view.invert_axis(ndarray::Axis(axis));
            }
            let mut light_field = LightField::from_elemental_grid(view, shape).unwrap();
            light_field.samples_mut().mapv_inplace(|sample| !sample);
        }
        prop_assert!(same(arranged(&memory, strides), plain.mapv(|sample| !sample).view()));
        // Owned: the memory of the array is reused.
        let address = memory.as_ptr();
        let mut owned = memory.permuted_axes(back);
        for axis in (0..3).filter(|&axis| strides.reversed[axis]) {
            owned.invert_axis(ndarray::Axis(axis));
        }
        let light_field = LightField::from_elemental_grid(owned, shape).unwrap();
        let samples = light_field.samples();
        prop_assert_eq!(samples.as_slice_memory_order().unwrap().as_ptr(), address);
    }

    /// Both layouts of one light field are equal, and `as_*_grid` returns the image without copying.
    #[test]
    fn layouts_share_one_view(shape in shapes(), channels in channels()) {
        let original = labeled(shape, channels);
        let by_lens = LightField::from_elemental_grid(original.to_elemental_grid().unwrap(), shape).unwrap();
        let by_view = LightField::from_viewpoint_grid(original.to_viewpoint_grid().unwrap(), shape).unwrap();
        prop_assert!(by_lens == by_view && by_lens == original);
        prop_assert_eq!(by_lens.as_elemental_grid().unwrap(), original.to_elemental_grid().unwrap());
        prop_assert_eq!(by_view.as_viewpoint_grid().unwrap(), original.to_viewpoint_grid().unwrap());
        let address = by_lens.as_elemental_grid().unwrap().as_ptr();
        prop_assert_eq!(by_lens.into_elemental_grid().unwrap().as_ptr(), address);
    }

    #[test]
    fn images_and_slices_have_the_samples_of_their_indices(shape in shapes(), channels in channels()) {
        let light_field = labeled(shape, channels);
        let (views, lenses) = (shape.views(), shape.lenses());
        for t in 0..views.rows {
            for s in 0..views.columns {
                let view = light_field.view(t, s).unwrap();
                prop_assert_eq!(view.dim(), (lenses.rows, lenses.columns, channels));
                prop_assert!(view.indexed_iter().all(|((v, u, c), sample)| *sample == [v, u, t, s, c]));
            }
        }
        for v in 0..lenses.rows {
            for u in 0..lenses.columns {
                let elemental = light_field.elemental_image(v, u).unwrap();
                prop_assert_eq!(elemental.dim(), (views.rows, views.columns, channels));
                prop_assert!(elemental.indexed_iter().all(|((t, s, c), sample)| *sample == [v, u, t, s, c]));
            }
        }
        for (v, t) in (0..lenses.rows).flat_map(|v| (0..views.rows).map(move |t| (v, t))) {
            let epi = light_field.epi_row(v, t).unwrap();
            prop_assert_eq!(epi.dim(), (views.columns, lenses.columns, channels));
            prop_assert!(epi.indexed_iter().all(|((s, u, c), sample)| *sample == [v, u, t, s, c]));
        }
        for (u, s) in (0..lenses.columns).flat_map(|u| (0..views.columns).map(move |s| (u, s))) {
            let epi = light_field.epi_column(u, s).unwrap();
            prop_assert_eq!(epi.dim(), (views.rows, lenses.rows, channels));
            prop_assert!(epi.indexed_iter().all(|((t, v, c), sample)| *sample == [v, u, t, s, c]));
        }
    }

    /// Iterators visit every image once, row by row, with its index.
    #[test]
    fn iterators_visit_everything_in_order(shape in shapes(), channels in channels()) {
        let mut light_field = labeled(shape, channels);
        let (views, lenses) = (shape.views(), shape.lenses());
        let view_indices: Vec<_> = (0..views.rows).flat_map(|t| (0..views.columns).map(move |s| (t, s))).collect();
        let lens_indices: Vec<_> = (0..lenses.rows).flat_map(|v| (0..lenses.columns).map(move |u| (v, u))).collect();
        let is_view = |t: usize, s: usize, sample: &[usize; 5]| sample[2..4] == [t, s];
        let is_lens = |v: usize, u: usize, sample: &[usize; 5]| sample[..2] == [v, u];

        prop_assert_eq!(light_field.views().len(), view_indices.len());
        prop_assert!(light_field.views().map(|(index, _)| index).eq(view_indices.iter().copied()));
        prop_assert!(light_field.views().all(|((t, s), image)| image.iter().all(|sample| is_view(t, s, sample))));
        prop_assert!(light_field.views().rev().map(|(index, _)| index).eq(view_indices.iter().rev().copied()));
        prop_assert!(light_field.elemental_images().map(|(index, _)| index).eq(lens_indices.iter().copied()));
        let is_whole_lens = |((v, u), image): (_, ndarray::ArrayView3<'_, _>)| image.iter().all(|x| is_lens(v, u, x));
        prop_assert!(light_field.elemental_images().all(is_whole_lens));

        // Every mutable iterator adds one to every channel index; two of them make two.
        type Image<'a> = ndarray::ArrayViewMut3<'a, [usize; 5]>;
        let bump = |mut image: Image<'_>| image.iter_mut().for_each(|sample| sample[4] += 1);
        let mut seen = Vec::new();
        light_field.views_mut().for_each(|(index, image)| { seen.push(index); bump(image) });
        prop_assert_eq!(&seen, &view_indices);
        seen.clear();
        light_field.elemental_images_mut().for_each(|(index, image)| { seen.push(index); bump(image) });
        prop_assert_eq!(&seen, &lens_indices);
        let bumped = labeled(shape, channels).map(|&[v, u, t, s, c]| [v, u, t, s, c + 2]).unwrap();
        prop_assert!(light_field == bumped);
    }
}

#[cfg(feature = "rayon")]
proptest! {
    /// Parallel iterators visit what the serial ones do.
    #[test]
    fn parallel_iterators_are_the_serial_ones(shape in shapes(), channels in channels()) {
        let mut light_field = labeled(shape, channels);
        let parallel: Vec<_> = light_field.par_views().collect();
        prop_assert_eq!(parallel, light_field.views().collect::<Vec<_>>());
        let parallel: Vec<_> = light_field.par_elemental_images().collect();
        prop_assert_eq!(parallel, light_field.elemental_images().collect::<Vec<_>>());

        // Each adds one to every channel index; two of them make two.
        light_field.par_views_mut().for_each(|((t, s), mut image)| {
            assert!(image.iter().all(|sample| sample[2..4] == [t, s]));
            image.iter_mut().for_each(|sample| sample[4] += 1);
        });
        light_field.par_elemental_images_mut().for_each(|((v, u), mut image)| {
            assert!(image.iter().all(|sample| sample[..2] == [v, u]));
            image.iter_mut().for_each(|sample| sample[4] += 1);
        });
        let bumped = labeled(shape, channels).map(|&[v, u, t, s, c]| [v, u, t, s, c + 2]).unwrap();
        prop_assert!(light_field == bumped);
    }
}

#[test]
fn mutable_views_and_elemental_images_write_to_their_samples() {
    let mut light_field = LightField::filled(small(), 1, Layout::ViewpointGrid, 0_u8).unwrap();
    light_field.view_mut(1, 2).unwrap().fill(1);
    light_field.elemental_image_mut(3, 4).unwrap().mapv_inplace(|sample| sample + 2);
    for ((v, u, t, s, _), &sample) in light_field.samples().indexed_iter() {
        assert_eq!(sample, u8::from((t, s) == (1, 2)) + 2 * u8::from((v, u) == (3, 4)));
    }
    assert!(light_field.view_mut(2, 0).is_err() && light_field.elemental_image_mut(0, 5).is_err());
}

#[test]
fn indices_out_of_range_are_errors() {
    let light_field = labeled(small(), 1);
    let out_of_range = |what, index, count| Err(Error::OutOfRange { what, index, count, first: 0 });
    assert_eq!(light_field.view(2, 0).map(|_| ()), out_of_range("view row", 2, 2));
    assert_eq!(light_field.view(0, 3).map(|_| ()), out_of_range("view column", 3, 3));
    assert_eq!(light_field.elemental_image(4, 0).map(|_| ()), out_of_range("lens row", 4, 4));
    assert_eq!(light_field.elemental_image(0, usize::MAX).map(|_| ()), out_of_range("lens column", usize::MAX, 5));
    assert!(light_field.epi_row(4, 0).is_err() && light_field.epi_row(0, 2).is_err());
    assert!(light_field.epi_column(5, 0).is_err() && light_field.epi_column(0, 3).is_err());
}

#[test]
fn impossible_shapes_are_errors() {
    let shape = small();
    for size in [(8, 14, 3), (9, 15, 3), (15, 8, 3), (0, 0, 3)] {
        let image = Array3::<u8>::zeros(size);
        assert!(matches!(LightField::from_elemental_grid_view(&image, shape), Err(Error::Shape { .. })), "{size:?}");
        assert!(matches!(LightField::from_viewpoint_grid(image, shape), Err(Error::Shape { .. })), "{size:?}");
    }
    let none = Array3::<u8>::zeros((8, 15, 0));
    assert_eq!(LightField::from_elemental_grid_view(&none, shape), Err(Error::ZeroCount { what: "channels" }));
    assert_eq!(LightField::from_elemental_grid(none, shape), Err(Error::ZeroCount { what: "channels" }));
    for axis in 0..5 {
        let mut shape = [2; 5];
        shape[axis] = 0;
        assert!(matches!(LightField::new(Array5::<u8>::zeros(shape)), Err(Error::ZeroCount { .. })), "axis {axis}");
    }
}

/// An image with gaps cannot be split in place; the error names the alternative.
#[test]
fn gaps_are_errors_by_value_and_allowed_by_reference() {
    let image = Array3::<u8>::zeros((8, 16, 3));
    let crop = image.slice(s![.., ..15, ..]);
    let error = LightField::from_elemental_grid(crop, small()).unwrap_err();
    assert!(matches!(error, Error::NotDense { .. }));
    assert!(error.to_string().contains("from_elemental_grid_view"), "{error}");
    assert!(LightField::from_elemental_grid_view(&crop, small()).is_ok());
}

/// Sizes are checked before memory is allocated.
#[test]
fn overflowing_sizes_are_errors_and_allocate_nothing() {
    let shape = |count: usize| LightFieldShape::new(GridSize::new(count, count), GridSize::new(count, count)).unwrap();
    let too_large = || Error::TooLarge { what: "light field" };
    // 2^60 samples: 2^63 bytes of f64 overflow, and so do 16 channels of u8.
    assert_eq!(LightField::filled(shape(1 << 15), 1, Layout::ElementalGrid, 0.0_f64).unwrap_err(), too_large());
    assert_eq!(LightField::filled(shape(1 << 15), 16, Layout::ElementalGrid, 0_u8).unwrap_err(), too_large());
    assert_eq!(
        LightField::filled(shape(1), 0, Layout::ElementalGrid, 0_u8).unwrap_err(),
        Error::ZeroCount { what: "channels" }
    );
    // 2^60 bytes do not overflow, but the allocation fails: an error, not an abort.
    let error = LightField::filled(shape(1 << 15), 1, Layout::ElementalGrid, 0_u8).unwrap_err();
    assert_eq!(error, Error::OutOfMemory { what: "a light field", bytes: 1 << 60 });
    // The copy of an array that repeats one sample has the full size.
    let sample = 1.0_f64;
    let endless: ArrayView5<'_, f64> = aview0(&sample).broadcast_with([1 << 15, 1 << 15, 1 << 15, 1 << 15, 1]);
    assert_eq!(LightField::new(endless).unwrap_err(), too_large());
}

/// Shorthand for a broadcast of a scalar view that outlives the call.
trait Broadcast<'a, T> {
    fn broadcast_with(self, shape: [usize; 5]) -> ArrayView5<'a, T>;
}

impl<'a, T> Broadcast<'a, T> for ndarray::ArrayView0<'a, T> {
    fn broadcast_with(self, shape: [usize; 5]) -> ArrayView5<'a, T> {
        // `broadcast` borrows the view, so go through a leaked box of it: a few bytes in a test.
        Box::leak(Box::new(self)).broadcast(shape).unwrap()
    }
}

#[test]
fn filled_light_fields_become_images_without_copying() {
    let light_field = LightField::filled(small(), 3, Layout::ElementalGrid, 1_u8).unwrap();
    assert!(light_field.as_viewpoint_grid().is_none());
    let address = light_field.samples().as_ptr();
    // The other layout returns the light field unchanged.
    let light_field = light_field.into_viewpoint_grid().unwrap_err();
    let image = light_field.into_elemental_grid().unwrap();
    assert_eq!((image.dim(), image.as_ptr()), ((8, 15, 3), address));
}

#[test]
fn debug_output_is_short() {
    let text = format!("{:?}", labeled(small(), 3));
    assert!(text.starts_with("LightField { shape: [4, 5, 2, 3, 3], strides: ["), "{text}");
    assert!(text.len() < 120, "{text}");
}
