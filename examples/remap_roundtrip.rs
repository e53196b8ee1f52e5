//! Views to elemental images and back: the same samples in two orders, bit for bit.

use holo_core::{GridSize, LightField, LightFieldShape};
use ndarray::Array3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The paper's 8K sensor with 100 x 100 views: 79 x 53 px a view.
    let split = LightFieldShape::new(GridSize::new(100, 100), GridSize::new(53, 79))?;
    let size = split.raw_size();
    let views = Array3::from_shape_fn((size.rows, size.columns, 3), |(y, x, c)| (y * 7 + x * 3 + c * 85) as u8);

    let elemental = LightField::from_viewpoint_grid(views.view(), split)?.to_elemental_grid();
    let back = LightField::from_elemental_grid(elemental.view(), split)?.to_viewpoint_grid();
    assert_eq!(views, back);

    // Pixel (v, u) of view (t, s) is pixel (t, s) behind lens (v, u).
    let (v, u, t, s) = (10, 20, 30, 40);
    assert_eq!(views[[t * 53 + v, s * 79 + u, 0]], elemental[[v * 100 + t, u * 100 + s, 0]]);
    println!("{} x {} px there and back: every byte the same", size.columns, size.rows);
    Ok(())
}
