//! Tests of light fields and images of any element type.

use super::*;
use crate::LightField;
use ndarray::Array5;

fn fields() -> [DynLightField; 4] {
    let samples = Array5::from_shape_fn((2, 3, 4, 5, 3), |(v, u, t, s, c)| (((v * 3 + u) * 4 + t) * 5 + s + c) as u8);
    let field = LightField::new(samples).unwrap();
    [
        field.clone().into(),
        field.map(|&x| u16::from(x)).unwrap().into(),
        field.map(|&x| f32::from(x)).unwrap().into(),
        field.map(|&x| f64::from(x)).unwrap().into(),
    ]
}

#[test]
fn every_type_has_the_same_views_and_elemental_images() {
    let kinds = [SampleKind::U8, SampleKind::U16, SampleKind::F32, SampleKind::F64];
    let expected = fields()[2].to_f32().unwrap();
    for (field, kind) in fields().into_iter().zip(kinds) {
        assert_eq!((field.kind(), field.channels()), (kind, 3));
        assert_eq!(field.shape(), LightFieldShape::new(GridSize::new(4, 5), GridSize::new(2, 3)).unwrap());
        let view = field.view(3, 2).unwrap();
        assert_eq!((view.kind(), view.size(), view.channels()), (kind, GridSize::new(2, 3), 3));
        assert_eq!(field.elemental_image(1, 2).unwrap().size(), GridSize::new(4, 5));
        assert_eq!(field.epi_row(1, 2).unwrap().channels(), 3);
        assert!(field.view(4, 0).is_err() && field.epi_column(3, 0).is_err());
        assert_eq!(field.into_f32().unwrap(), expected);
    }
}

#[test]
fn alpha_is_dropped_and_colors_are_kept() {
    for field in fields() {
        assert_eq!(field.clone().without_alpha().unwrap(), field);
        let narrow: DynLightField = for_each_sample!(DynLightField, &field, f => {
            LightField::new(f.samples().slice_axis(Axis(4), Slice::from(..2)).to_owned()).unwrap().into()
        });
        assert_eq!((narrow.channels(), narrow.clone().without_alpha().unwrap().channels()), (2, 1));
        assert_eq!(narrow.without_alpha().unwrap().view(1, 2).unwrap(), {
            let view = field.view(1, 2).unwrap();
            for_each_sample!(DynImageRef, view, v => v.slice_axis_move(Axis(2), Slice::from(..1)).into())
        });
    }
}

#[test]
fn a_part_of_an_image_has_its_pixels_and_stays_inside() {
    for field in fields() {
        let view = field.elemental_image(1, 1).unwrap();
        let part = view.crop(1..3, 2..5).unwrap();
        assert_eq!((part.size(), part.kind()), (GridSize::new(2, 3), field.kind()));
        let same = for_each_sample!(DynImageRef, view, v => {
            let cut = v.slice_axis_move(Axis(0), (1..3).into()).slice_axis_move(Axis(1), (2..5).into());
            cut.into()
        });
        assert_eq!(part, same);
        for (rows, columns) in [(0..5, 0..1), (0..1, 4..6), (2..2, 0..1)] {
            assert!(matches!(view.crop(rows, columns), Err(Error::BadRange { .. })));
        }
    }
}

#[test]
fn grids_of_either_layout_are_the_same_light_field() {
    for field in fields() {
        let shape = field.shape();
        for layout in [Layout::ElementalGrid, Layout::ViewpointGrid] {
            let grid = field.clone().into_grid(layout).unwrap();
            assert_eq!(grid.size(), shape.raw_size());
            assert_eq!(DynLightField::from_grid(grid, layout, shape).unwrap(), field);
        }
    }
}

#[test]
fn raw_images_are_wrapped_in_their_type() {
    let shape = LightFieldShape::new(GridSize::new(4, 5), GridSize::new(2, 3)).unwrap();
    for field in fields() {
        let grid: DynImage = for_each_sample!(DynLightField, &field, f => f.to_viewpoint_grid().unwrap().into());
        assert_eq!(DynLightField::from_grid(grid, Layout::ViewpointGrid, shape).unwrap(), field);
    }
    let wrong: DynImage = Array3::<u8>::zeros((3, 3, 1)).into();
    assert!(DynLightField::from_grid(wrong, Layout::ElementalGrid, shape).is_err());
}
