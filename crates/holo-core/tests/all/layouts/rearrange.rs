//! Eq. 4: the round trip is the identity, and the fast implementation agrees with the reference implementation bit by
//! bit.

use super::samples::*;
use holo_core::rearrange::naive;
use holo_core::{Error, GridSize, Layout, LightField, LightFieldShape};
use ndarray::{Array3, ArrayView3, s};
use proptest::prelude::*;

/// Both round trips with the fast implementation; each half is compared with the reference implementation.
fn round_trips<T: Sample>(shape: LightFieldShape, channels: usize, strides: Strides) -> Result<(), TestCaseError> {
    let raw = shape.raw_size();
    let plain = image::<T>(raw.rows, raw.columns, channels);
    let memory = store(&plain, strides);
    let source = arranged(&memory, strides);
    prop_assert!(same(source, plain.view()), "the helpers of this test agree");

    // The image as an elemental grid: EI -> VPI -> EI.
    let viewpoint = LightField::from_elemental_grid_view(&source, shape).unwrap().to_viewpoint_grid().unwrap();
    prop_assert!(same(viewpoint.view(), naive::to_viewpoint_grid(source, shape).unwrap().view()));
    let back = LightField::from_viewpoint_grid(viewpoint, shape).unwrap().to_elemental_grid().unwrap();
    prop_assert!(same(back.view(), plain.view()));

    // The same image as a viewpoint grid: VPI -> EI -> VPI.
    let elemental = LightField::from_viewpoint_grid_view(&source, shape).unwrap().to_elemental_grid().unwrap();
    prop_assert!(same(elemental.view(), naive::to_elemental_grid(source, shape).unwrap().view()));
    let back = LightField::from_elemental_grid(elemental, shape).unwrap().to_viewpoint_grid().unwrap();
    prop_assert!(same(back.view(), plain.view()));

    // From a layout to itself: a copy.
    let copy = LightField::from_elemental_grid_view(&source, shape).unwrap().to_elemental_grid().unwrap();
    prop_assert!(same(copy.view(), plain.view()));
    let copy = LightField::from_viewpoint_grid_view(&source, shape).unwrap().to_viewpoint_grid().unwrap();
    prop_assert!(same(copy.view(), plain.view()));
    Ok(())
}

macro_rules! for_every_element_type {
    ($($name:ident: $type:ty;)*) => {$(
        proptest! {
            #![proptest_config(ProptestConfig::with_cases(96))]
            #[test]
            fn $name(shape in shapes(), channels in channels(), strides in any_strides()) {
                round_trips::<$type>(shape, channels, strides)?;
                round_trips::<$type>(shape, channels, Strides::PLAIN)?;
            }
        }
    )*};
}

for_every_element_type! {
    round_trips_of_u8: u8;
    round_trips_of_u16: u16;
    round_trips_of_f16: half::f16;
    round_trips_of_f32: f32;
    round_trips_of_f64: f64;
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// A destination of any strides gets the same samples, and its gaps do not change.
    #[test]
    fn destinations_may_have_any_strides(shape in shapes(), channels in channels(), strides in any_strides()) {
        let raw = shape.raw_size();
        let grid = image::<u16>(raw.rows, raw.columns, channels);
        let light_field = LightField::from_elemental_grid(grid, shape).unwrap();
        let expected = light_field.to_viewpoint_grid().unwrap();
        let untouched = 0xabcd;
        let marked = Array3::from_elem(expected.dim(), untouched);
        // Gaps have the filler of `store`, which must not change.
        let before = store(&marked, strides);
        let mut memory = before.clone();
        {
            let mut view = memory.view_mut();
            for axis in 0..3 {
                view.slice_axis_inplace(ndarray::Axis(axis), ndarray::Slice::new(0, None, strides.step as isize));
            }
            let mut back = [0; 3];
            for (position, &axis) in strides.order.iter().enumerate() {
                back[axis] = position;
            }
            let mut view = view.permuted_axes(back);
            for axis in (0..3).filter(|&axis| strides.reversed[axis]) {
                view.invert_axis(ndarray::Axis(axis));
            }
            light_field.to_viewpoint_grid_into(view).unwrap();
        }
        prop_assert!(same(arranged(&memory, strides), expected.view()));
        // `store` of the expected image has the same filler in the gaps and the same samples elsewhere.
        prop_assert!(same(memory.view(), store(&expected, strides).view()));
    }

    /// Clips have gaps between their lines and take another code path.
    #[test]
    fn clips_rearrange_like_copies(
        (shape, rows, columns) in shapes().prop_flat_map(|shape| {
            let range = |count: usize| (0..count).prop_flat_map(move |start| (Just(start), start + 1..=count));
            (Just(shape), range(shape.views().rows), range(shape.views().columns))
        }),
        channels in channels(),
        by_view in any::<bool>(),
    ) {
        let raw = shape.raw_size();
        let image = image::<f32>(raw.rows, raw.columns, channels);
        let light_field = if by_view {
            LightField::from_viewpoint_grid(image, shape).unwrap()
        } else {
            LightField::from_elemental_grid(image, shape).unwrap()
        };
        let clip = light_field.clip_views(rows.0..rows.1, columns.0..columns.1).unwrap();
        let elemental = clip.to_elemental_grid().unwrap();
        let viewpoint = clip.to_viewpoint_grid().unwrap();
        for ((v, u, t, s, c), value) in clip.samples().indexed_iter() {
            let (views, lenses) = (clip.shape().views(), clip.shape().lenses());
            let in_elemental = elemental[[v * views.rows + t, u * views.columns + s, c]];
            let in_viewpoint = viewpoint[[t * lenses.rows + v, s * lenses.columns + u, c]];
            prop_assert_eq!(in_elemental.to_bits(), value.to_bits());
            prop_assert_eq!(in_viewpoint.to_bits(), value.to_bits());
        }
    }
}

/// Sizes at which the threads share the work, and rows above and below the size of the scratch memory.
#[test]
fn large_images_agree_with_the_reference_implementation() {
    fn check<T: Sample>(views: (usize, usize), lenses: (usize, usize), channels: usize) {
        let shape = LightFieldShape::new(GridSize::new(views.0, views.1), GridSize::new(lenses.0, lenses.1)).unwrap();
        let raw = shape.raw_size();
        let image = image::<T>(raw.rows, raw.columns, channels);
        let light_field = LightField::from_elemental_grid(image.view(), shape).unwrap();
        let viewpoint = light_field.to_viewpoint_grid().unwrap();
        assert!(same(viewpoint.view(), naive::to_viewpoint_grid(image.view(), shape).unwrap().view()));
        let back = LightField::from_viewpoint_grid(viewpoint, shape).unwrap().to_elemental_grid().unwrap();
        assert!(same(back.view(), image.view()));
    }
    // 200 KB: just above the parallel threshold; 53 and 79 leave remainders in blocks of any power of two.
    check::<u8>((9, 11), (53, 13), 3);
    check::<u16>((20, 20), (53, 79), 3);
    // Rows of 331*101*3*8 = 802 KB, far above the scratch memory.
    check::<f64>((2, 101), (3, 331), 3);
    check::<u8>((3, 331), (2, 1031), 1);
    // Five channels have no fixed-size pixel; 1.1 MB rows.
    check::<f32>((2, 97), (2, 601), 5);
    // Rows of one group or of one member are plain copies.
    check::<u8>((300, 1), (3, 401), 4);
    check::<u8>((3, 401), (300, 1), 4);
}

/// Zero-sized elements: no division by their size.
#[test]
fn zero_sized_elements_do_not_divide_by_zero() {
    let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 6)).unwrap();
    let light_field = LightField::filled(shape, 3, Layout::ElementalGrid, ()).unwrap();
    assert_eq!(light_field.to_viewpoint_grid().unwrap().dim(), (15, 24, 3));
}

#[test]
fn wrong_destinations_are_errors_and_do_not_change() {
    let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap();
    let light_field = LightField::filled(shape, 3, Layout::ElementalGrid, 7_u8).unwrap();
    for shape in [(8, 15, 4), (8, 14, 3), (9, 15, 3), (15, 8, 3), (0, 15, 3)] {
        let mut image = Array3::zeros(shape);
        let error = light_field.to_viewpoint_grid_into(image.view_mut()).unwrap_err();
        assert!(matches!(error, Error::Shape { what: "viewpoint grid", .. }), "{shape:?}: {error}");
        assert!(light_field.to_elemental_grid_into(image.view_mut()).is_err());
        assert!(image.iter().all(|&sample| sample == 0));
    }
    // A part of a larger image is a valid destination.
    let mut canvas = Array3::zeros((10, 20, 3));
    light_field.to_viewpoint_grid_into(canvas.slice_mut(s![1..9, 2..17, ..])).unwrap();
    assert_eq!(canvas.iter().filter(|&&sample| sample == 7).count(), 8 * 15 * 3);
    assert_eq!(canvas.slice(s![0, .., ..]).iter().max(), Some(&0));
}

#[test]
fn the_reference_implementation_checks_the_size_of_its_image() {
    let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap();
    let wrong: ArrayView3<'_, u8> = ArrayView3::from_shape((1, 2, 3), &[0; 6]).unwrap();
    assert!(naive::to_viewpoint_grid(wrong, shape).is_err());
    assert!(naive::to_elemental_grid(wrong, shape).is_err());
}

/// One light field written by hand, to find an error that both implementations share.
#[test]
fn a_small_raw_image_by_hand() {
    // 1 x 2 views, 2 x 2 microlenses; letters are microlenses, digits are views.
    let elemental = ndarray::array![[["a0"], ["a1"], ["b0"], ["b1"]], [["c0"], ["c1"], ["d0"], ["d1"]]];
    let viewpoint = ndarray::array![[["a0"], ["b0"], ["a1"], ["b1"]], [["c0"], ["d0"], ["c1"], ["d1"]]];
    let shape = LightFieldShape::new(GridSize::new(1, 2), GridSize::new(2, 2)).unwrap();
    assert_eq!(
        LightField::from_elemental_grid(elemental.clone(), shape).unwrap().to_viewpoint_grid().unwrap(),
        viewpoint
    );
    assert_eq!(naive::to_viewpoint_grid(elemental.view(), shape).unwrap(), viewpoint);
    assert_eq!(LightField::from_viewpoint_grid(viewpoint, shape).unwrap().to_elemental_grid().unwrap(), elemental);
}
