//! Clipping and rotation.

use std::ops::Range;

use super::samples::*;
use holo_core::{Error, GridSize, LightField, LightFieldShape};
use ndarray::{Array5, Axis};
use proptest::prelude::*;

fn labeled(shape: LightFieldShape) -> LightField<ndarray::OwnedRepr<[usize; 5]>> {
    LightField::new(Array5::from_shape_fn(shape.array_shape(2), |(v, u, t, s, c)| [v, u, t, s, c])).unwrap()
}

/// A range within `0..count`, and one within that range.
fn nested(count: usize) -> impl Strategy<Value = (Range<usize>, Range<usize>)> {
    let range = |count: usize| {
        (0..count).prop_flat_map(move |start| (Just(start), start + 1..=count)).prop_map(|(start, end)| start..end)
    };
    range(count).prop_flat_map(move |outer| (Just(outer.clone()), range(outer.len())))
}

/// An inner range in the axis of the outer one.
fn within(outer: &Range<usize>, inner: &Range<usize>) -> Range<usize> {
    outer.start + inner.start..outer.start + inner.end
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn a_clip_of_a_clip_is_a_clip(
        (shape, t, s, v, u) in shapes().prop_flat_map(|shape| (
            Just(shape),
            nested(shape.views().rows),
            nested(shape.views().columns),
            nested(shape.lenses().rows),
            nested(shape.lenses().columns),
        ))
    ) {
        let light_field = labeled(shape);
        let first = light_field.clip_views(t.0.clone(), s.0.clone()).unwrap();
        let second = first.clip_views(t.1.clone(), s.1.clone()).unwrap();
        let at_once = light_field.clip_views(within(&t.0, &t.1), within(&s.0, &s.1)).unwrap();
        prop_assert!(second == at_once);
        // The first sample is still the one in the original memory.
        let offset = [0, 0, within(&t.0, &t.1).start, within(&s.0, &s.1).start, 0];
        prop_assert!(std::ptr::eq(&second.samples()[[0; 5]], &light_field.samples()[offset]));

        let first = light_field.clip_lenses(v.0.clone(), u.0.clone()).unwrap();
        let second = first.clip_lenses(v.1.clone(), u.1.clone()).unwrap();
        let at_once = light_field.clip_lenses(within(&v.0, &v.1), within(&u.0, &u.1)).unwrap();
        prop_assert!(second == at_once);

        // Views and lenses may be clipped in either order.
        let views_first = light_field.clip_views(t.0.clone(), s.0.clone()).unwrap();
        let views_first = views_first.clip_lenses(v.0.clone(), u.0.clone()).unwrap();
        let lenses_first = light_field.clip_lenses(v.0.clone(), u.0.clone()).unwrap();
        let lenses_first = lenses_first.clip_views(t.0.clone(), s.0.clone()).unwrap();
        prop_assert!(views_first == lenses_first);
        for ((dv, du, dt, ds, c), sample) in views_first.samples().indexed_iter() {
            prop_assert_eq!(*sample, [v.0.start + dv, u.0.start + du, t.0.start + dt, s.0.start + ds, c]);
        }
        prop_assert!(views_first.to_owned().unwrap() == views_first);
    }

    /// A rotation of the raw image reverses both of its axes, in either layout; one of each EI reverses both axes of
    /// the EI.
    #[test]
    fn rotations_reverse_both_axes(shape in shapes(), channels in channels()) {
        let raw = shape.raw_size();
        let image = image::<u16>(raw.rows, raw.columns, channels);
        let mut turned = image.view();
        turned.invert_axis(Axis(0));
        turned.invert_axis(Axis(1));
        for by_view in [false, true] {
            let grid = |light_field: holo_core::LightFieldRef<'_, u16>| {
                let grid = if by_view { light_field.to_viewpoint_grid() } else { light_field.to_elemental_grid() };
                grid.unwrap()
            };
            let light_field = if by_view {
                LightField::from_viewpoint_grid(image.view(), shape).unwrap()
            } else {
                LightField::from_elemental_grid(image.view(), shape).unwrap()
            };
            prop_assert_eq!(grid(light_field.rotate_raw()), turned);
            prop_assert!(light_field.rotate_raw().rotate_raw() == light_field);

            let display = light_field.rotate_elemental_images();
            for ((v, u), elemental) in light_field.elemental_images() {
                let mut expected = elemental;
                expected.invert_axis(Axis(0));
                expected.invert_axis(Axis(1));
                prop_assert_eq!(display.elemental_image(v, u).unwrap(), expected);
            }
            prop_assert!(display.rotate_elemental_images() == light_field);
        }
    }
}

#[test]
#[allow(clippy::reversed_empty_ranges, reason = "reversed ranges are under test")]
fn bad_ranges_are_errors() {
    let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap();
    let light_field = labeled(shape);
    for range in [0..0, 2..1, 0..6, 5..6, usize::MAX..usize::MAX, 1..usize::MAX] {
        assert!(light_field.clip_views(range.clone(), 0..1).is_err(), "{range:?}");
        assert!(light_field.clip_views(0..1, range.clone()).is_err(), "{range:?}");
        assert!(light_field.clip_lenses(range.clone(), 0..1).is_err(), "{range:?}");
        assert!(light_field.clip_lenses(0..1, range.clone()).is_err(), "{range:?}");
    }
    assert_eq!(
        light_field.clip_views(0..3, 0..3).unwrap_err(),
        Error::BadRange { what: "view rows", start: 0, end: 3, count: 2 }
    );
}

#[test]
fn mutable_clips_write_only_inside() {
    let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 5)).unwrap();
    let mut light_field = labeled(shape);
    light_field.as_light_field_mut().into_clip_views(1..2, 0..2).unwrap().samples_mut().fill([9; 5]);
    light_field.as_light_field_mut().into_clip_lenses(3..4, 4..5).unwrap().samples_mut().fill([8; 5]);
    for ((v, u, t, s, c), sample) in light_field.samples().indexed_iter() {
        let expected = match () {
            () if (v, u) == (3, 4) => [8; 5],
            () if t == 1 && s < 2 => [9; 5],
            () => [v, u, t, s, c],
        };
        assert_eq!(*sample, expected);
    }
}
