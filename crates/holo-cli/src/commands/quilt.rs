//! `holo quilt`: the views of one row as multi-view displays read them.

use holo_core::{DynImage, LightFieldOwned, Sample, for_each_sample};

use super::files;
use crate::arguments::QuiltOptions;
use crate::failure::Failure;

pub fn run(options: &QuiltOptions) -> Result<(), Failure> {
    let light_field = files::read(&options.input)?.light_field;
    let quilt = for_each_sample!(DynLightField, &light_field, field => quilt(field, options))?;
    files::write(&options.out, &quilt)
}

fn quilt<T: Sample>(field: &LightFieldOwned<T>, options: &QuiltOptions) -> Result<DynImage, Failure> {
    let (views, tiles) = (field.shape().views(), options.tiles.count());
    if tiles > views.columns {
        return Err(Failure::Usage(format!(
            "{} x {} tiles need {tiles} views, but a row has {}",
            options.tiles.columns, options.tiles.rows, views.columns
        )));
    }
    let row = options.row.unwrap_or(views.rows / 2);
    let shown: Vec<_> = (0..tiles).map(|tile| (row, evenly(tile, tiles, views.columns))).collect();
    Ok(field.to_quilt(options.tiles, &shown)?.into())
}

/// Number `index` of `count` places spread over 0 to `all` - 1, both ends among them; the middle for one alone.
fn evenly(index: usize, count: usize, all: usize) -> usize {
    if count == 1 {
        return all / 2;
    }
    (2 * index * (all - 1) + (count - 1)) / (2 * (count - 1))
}

#[cfg(test)]
mod tests {
    use super::evenly;

    #[test]
    fn tiles_are_spread_from_end_to_end() {
        let places = |count, all| (0..count).map(|index| evenly(index, count, all)).collect::<Vec<_>>();
        assert_eq!(places(5, 5), [0, 1, 2, 3, 4]);
        assert_eq!(places(3, 9), [0, 4, 8]);
        assert_eq!(places(2, 9), [0, 8]);
        assert_eq!(places(1, 9), [4]);
        let many = places(48, 100);
        assert!(many.windows(2).all(|pair| (2..=3).contains(&(pair[1] - pair[0]))), "{many:?}");
    }
}
