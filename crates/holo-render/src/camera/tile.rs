//! Tiles of a light field: boxes of microlenses and view rows that one thread renders at a time.
//!
//! A tile is a whole elemental image if there are many views, or a row of microlenses if there are few. Its pixels are
//! stored packet by packet during rendering and written to the memory of the light field once at the end.

use std::ops::Range;

use holo_core::LightFieldShape;
use ndarray::{ArrayViewMut5, Axis};

use crate::simd::LANES;

/// The approximate number of pixels of a tile, chosen to fit into the cache.
const PIXELS: usize = 8192;

/// The distribution of the 16 lanes of a packet over lens rows, lens columns, view rows and view columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PacketShape {
    /// Lanes along (v, u, t, s); their product is 16, or a little less where that leaves fewer lanes without a pixel.
    pub size: [usize; 4],
    /// The offsets of every lane along (v, u, t, s) from the first pixel of the packet.
    pub offsets: [[u32; LANES]; 4],
}

impl PacketShape {
    /// The shape for these pixel counts along (v, u, t, s): as square as the counts allow, first along the views, then
    /// along the lenses. Remaining lanes have no pixel. Where blocks of 4 x 4 views would leave many of them, as with 5, 9,
    /// 13 or 15 views an axis, the blocks are of the size that needs the fewest packets.
    pub fn fitting(counts: [usize; 4]) -> Self {
        let mut size = Self::powers_of_two(counts);
        if size == [1, 1, 4, 4] {
            [size[2], size[3]] = block_of_views([counts[2], counts[3]]);
        }
        let mut offsets = [[0; LANES]; 4];
        for lane in 0..LANES {
            let mut rest = lane;
            for axis in (0..4).rev() {
                offsets[axis][lane] = (rest % size[axis]) as u32;
                rest /= size[axis];
            }
        }
        Self { size, offsets }
    }

    /// The number of lanes that may have a pixel.
    fn lanes(&self) -> usize {
        self.size.iter().product()
    }

    /// The most square shape whose sizes are powers of two.
    fn powers_of_two(counts: [usize; 4]) -> [usize; 4] {
        let mut size = [1; 4];
        while size.iter().product::<usize>() < LANES {
            let shortest = |[a, b]: [usize; 2]| {
                let grows = |k: usize| 2 * size[k] <= counts[k];
                let order = if size[b] <= size[a] { [b, a] } else { [a, b] };
                order.into_iter().find(|&k| grows(k))
            };
            let axis = shortest([2, 3]).or_else(|| shortest([0, 1])).unwrap_or(3);
            size[axis] *= 2;
        }
        size
    }
}

/// The rows and columns of views in a packet: 4 x 4 unless another block needs at least a tenth fewer packets. Of several
/// the most square one, which is the most coherent.
fn block_of_views([rows, columns]: [usize; 2]) -> [usize; 2] {
    let packets = |[h, w]: [usize; 2]| rows.div_ceil(h) * columns.div_ceil(w);
    // Longer ones are less coherent.
    let blocks = (2..=8).map(|h| [h, LANES / h]);
    let best = blocks.min_by_key(|&[h, w]| (packets([h, w]), h.abs_diff(w))).unwrap_or([4, 4]);
    if 10 * packets(best) <= 9 * packets([4, 4]) { best } else { [4, 4] }
}

/// The division of a light field, with its pixel counts along the axes (v, u, t, s), into tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tiling {
    counts: [usize; 4],
    shape: PacketShape,
    /// Lens rows, lens columns and view rows of a tile. A tile always has all view columns.
    size: [usize; 3],
}

/// The rendered pixels of a light field: a range of lens rows, all lens columns, some views.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    pub lens_rows: Range<usize>,
    pub lens_columns: usize,
    pub views: SelectedViews,
}

/// The rendered views.
#[derive(Clone, Debug)]
pub(crate) enum SelectedViews {
    /// A whole grid of this many rows and columns.
    Grid([usize; 2]),
    /// A list of views as (row, column), side by side in one row.
    List(Vec<[u32; 2]>),
}

impl Selection {
    /// Every pixel.
    pub fn whole(split: &LightFieldShape) -> Self {
        let (lenses, views) = (split.lenses(), split.views());
        let views = SelectedViews::Grid([views.rows, views.columns]);
        Self { lens_rows: 0..lenses.rows, lens_columns: lenses.columns, views }
    }

    /// Pixel counts along (v, u, t, s). A list counts as one row of views.
    pub fn counts(&self) -> [usize; 4] {
        let [t, s] = match &self.views {
            SelectedViews::Grid(counts) => *counts,
            SelectedViews::List(views) => [1, views.len()],
        };
        [self.lens_rows.len(), self.lens_columns, t, s]
    }

    /// Whether the views are a list. Both view indices then depend on the position along the s axis.
    pub fn is_list(&self) -> bool {
        matches!(self.views, SelectedViews::List(_))
    }

    /// The index in the whole light field of position `k` along one of the axes (v, u, t, s). For a list of views, `k`
    /// is the position in the list for both view axes.
    pub fn index(&self, axis: usize, k: usize) -> u32 {
        match (axis, &self.views) {
            (0, _) => (self.lens_rows.start + k) as u32,
            (2 | 3, SelectedViews::List(views)) => views[k][axis - 2],
            _ => k as u32,
        }
    }
}

/// One tile, in packets along (v, u, t, s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    /// Its first packet among the packets of the whole light field.
    first: [usize; 4],
    packets: [usize; 4],
    /// Lanes of a packet along the four axes.
    lanes: [usize; 4],
}

/// Iterator over the positions of the packets of a tile.
pub(crate) struct PacketPositions {
    tile: Tile,
    next: [usize; 4],
}

impl Iterator for PacketPositions {
    type Item = [usize; 4];

    #[inline(always)]
    fn next(&mut self) -> Option<[usize; 4]> {
        let (first, packets) = (&self.tile.first, &self.tile.packets);
        let [v, u, t, s] = self.next;
        if v == packets[0] {
            return None;
        }
        // Counts up, the last axis fastest.
        self.next[3] += 1;
        for axis in (1..4).rev() {
            if self.next[axis] == packets[axis] {
                self.next[axis] = 0;
                self.next[axis - 1] += 1;
            }
        }
        Some([first[0] + v, first[1] + u, first[2] + t, first[3] + s])
    }
}

impl Tiling {
    pub fn new(counts: [usize; 4]) -> Self {
        Self::with_tiles_of(counts, PIXELS)
    }

    /// A division into tiles of about `pixels` pixels.
    pub fn with_tiles_of(counts: [usize; 4], pixels: usize) -> Self {
        let shape = PacketShape::fitting(counts);
        let along = shape.size;
        let round_up = |count: usize, step: usize| count.div_ceil(step) * step;
        let [v, u, t, s] = counts;
        let along_t = if t * s <= 2 * pixels { round_up(t, along[2]) } else { round_up((pixels / s).max(1), along[2]) };
        let lenses = (pixels / (along_t.min(t) * s)).max(1);
        let along_v = round_up((lenses as f64).sqrt() as usize, along[0]).clamp(1, round_up(v, along[0]));
        // Wide tiles: lens columns are contiguous in memory.
        let along_v = if along[0] == 1 { 1 } else { along_v };
        let along_u = round_up((lenses / along_v).max(1), along[1]).clamp(1, round_up(u, along[1]));
        Self { counts, shape, size: [along_v, along_u, along_t] }
    }

    /// The same division, restricted to this many lens rows. If the rows begin at a multiple of
    /// [`tile_rows`](Self::tile_rows) the tiles are those of the whole light field; at a multiple of
    /// [`packet_rows`](Self::packet_rows) the packets are.
    pub fn lens_rows(self, rows: usize) -> Self {
        let counts = [rows, self.counts[1], self.counts[2], self.counts[3]];
        Self { counts, ..self }
    }

    /// Tiles begin at multiples of this many lens rows.
    pub fn tile_rows(&self) -> usize {
        self.size[0]
    }

    /// The pixels of a packet along (v, u, t, s).
    pub fn packet_size(&self) -> [usize; 4] {
        self.shape.size
    }

    /// Packets begin at multiples of this many lens rows.
    pub fn packet_rows(&self) -> usize {
        self.shape.size[0]
    }

    /// The packets along one of the axes (v, u, t, s): the position of every lane along the axis, and -1 for lanes
    /// within it, else 0.
    pub fn axis_lanes(&self, axis: usize) -> impl Iterator<Item = ([usize; LANES], [i32; LANES])> {
        let (count, size, offsets) = (self.counts[axis], self.shape.size[axis], self.shape.offsets[axis]);
        let lanes = self.shape.lanes();
        (0..count).step_by(size).map(move |start| {
            let wanted = offsets.map(|offset| start + offset as usize);
            let valid = std::array::from_fn(|lane| -i32::from(lane < lanes && wanted[lane] < count));
            (wanted.map(|k| k.min(count - 1)), valid)
        })
    }

    /// Whether the pixels of every packet are behind one microlens.
    pub fn is_one_lens_a_packet(&self) -> bool {
        self.shape.size[0] * self.shape.size[1] == 1
    }

    /// All tiles in a fixed order.
    pub fn tiles(&self) -> Vec<Tile> {
        let [size_v, size_u, size_t] = self.size;
        let [count_v, count_u, count_t, count_s] = self.counts;
        let mut tiles = Vec::new();
        for v in (0..count_v).step_by(size_v) {
            for u in (0..count_u).step_by(size_u) {
                for t in (0..count_t).step_by(size_t) {
                    let extent = [size_v.min(count_v - v), size_u.min(count_u - u), size_t.min(count_t - t), count_s];
                    // Tiles end at packet boundaries.
                    let packet = |axis: usize, start: usize| start / self.shape.size[axis];
                    let first = [packet(0, v), packet(1, u), packet(2, t), 0];
                    let packets = std::array::from_fn(|axis| extent[axis].div_ceil(self.shape.size[axis]));
                    tiles.push(Tile { first, packets, lanes: self.shape.size });
                }
            }
        }
        tiles
    }

    /// Splits `field` into the same tiles in the same order.
    pub fn cut<'a, T>(&self, field: ArrayViewMut5<'a, T>) -> Vec<ArrayViewMut5<'a, T>> {
        let [size_v, size_u, size_t] = self.size;
        let chunks = |output: ArrayViewMut5<'a, T>, axis: usize, size: usize| {
            let mut rest = Some(output);
            std::iter::from_fn(move || {
                let output = rest.take()?;
                if output.len_of(Axis(axis)) <= size {
                    return Some(output);
                }
                let (head, tail) = output.split_at(Axis(axis), size);
                rest = Some(tail);
                Some(head)
            })
        };
        chunks(field, 0, size_v)
            .flat_map(|output| chunks(output, 1, size_u).collect::<Vec<_>>())
            .flat_map(|output| chunks(output, 2, size_t).collect::<Vec<_>>())
            .collect()
    }
}

impl Tile {
    pub fn packet_count(&self) -> usize {
        self.packets.iter().product()
    }

    /// The positions of all packets along the four axes, in the order of the values of the tile.
    #[inline(always)]
    pub fn packet_positions(&self) -> PacketPositions {
        PacketPositions { tile: *self, next: [0; 4] }
    }

    /// Reads values in packet order, as [`write`](Self::write) writes them; 0 for lanes without a pixel.
    pub fn read<const C: usize>(&self, field: &ArrayViewMut5<f32>) -> Vec<[[f32; LANES]; C]> {
        let mut packets = vec![[[0.0; LANES]; C]; self.packet_count()];
        let size_s = self.lanes[3];
        for (v, rows) in field.outer_iter().enumerate() {
            for (u, elemental) in rows.outer_iter().enumerate() {
                for (t, row) in elemental.outer_iter().enumerate() {
                    let [first, lane] = self.start_of([v, u, t]);
                    let mut put = |s: usize, c: usize, value| packets[first + s / size_s][c][lane + s % size_s] = value;
                    if let Some(row) = row.as_slice() {
                        for (s, pixel) in row.chunks_exact(C).enumerate() {
                            for (c, &value) in pixel.iter().enumerate() {
                                put(s, c, value);
                            }
                        }
                    } else {
                        row.indexed_iter().for_each(|((s, c), &value)| put(s, c, value));
                    }
                }
            }
        }
        packets
    }

    /// The first packet of a row of views, and the lane in which the row begins there.
    #[inline(always)]
    fn start_of(&self, [v, u, t]: [usize; 3]) -> [usize; 2] {
        let grid = self.packets;
        let [size_v, size_u, size_t, size_s] = self.lanes;
        let first = ((v / size_v * grid[1] + u / size_u) * grid[2] + t / size_t) * grid[3];
        let lane = ((v % size_v * size_u + u % size_u) * size_t + t % size_t) * size_s;
        [first, lane]
    }

    /// Writes values in packet order (`packets[packet][channel][lane]`), multiplied by `scale`, to the output of the
    /// tile.
    #[inline(always)]
    pub fn write<const C: usize>(&self, packets: &[[[f32; LANES]; C]], scale: f32, field: &mut ArrayViewMut5<f32>) {
        let size_s = self.lanes[3];
        for (v, mut rows) in field.outer_iter_mut().enumerate() {
            for (u, mut elemental) in rows.outer_iter_mut().enumerate() {
                for (t, mut row) in elemental.outer_iter_mut().enumerate() {
                    let [first, lane] = self.start_of([v, u, t]);
                    let put = |s: usize, c: usize| packets[first + s / size_s][c][lane + s % size_s] * scale;
                    if let Some(row) = row.as_slice_mut() {
                        for (s, pixel) in row.chunks_exact_mut(C).enumerate() {
                            for (c, value) in pixel.iter_mut().enumerate() {
                                *value = put(s, c);
                            }
                        }
                    } else {
                        row.indexed_iter_mut().for_each(|((s, c), value)| *value = put(s, c));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array5;

    /// Whatever the number of views, more than seven tenths of the lanes have a pixel.
    #[test]
    fn odd_numbers_of_views_fill_their_packets() {
        for (views, size) in [(5, [3, 5]), (6, [6, 2]), (8, [4, 4]), (9, [3, 5]), (13, [7, 2]), (100, [4, 4])] {
            assert_eq!(
                PacketShape::fitting([30, 45, views, views]).size,
                [1, 1, size[0], size[1]],
                "{views} x {views}"
            );
        }
        for views in 5..=100 {
            let [_, _, h, w] = PacketShape::fitting([30, 45, views, views]).size;
            let lanes = views.div_ceil(h) * views.div_ceil(w) * LANES;
            assert!(10 * views * views > 7 * lanes, "{views} x {views} views in blocks of {h} x {w}");
        }
    }

    #[test]
    fn every_shape_has_sixteen_lanes_and_no_needless_waste() {
        for counts in
            [[53, 79, 100, 100], [132, 198, 1, 1], [1, 1, 1, 10_000], [1, 1, 10_000, 1], [3, 3, 2, 2], [1, 1, 1, 1]]
        {
            let shape = PacketShape::fitting(counts);
            assert_eq!(shape.size.iter().product::<usize>(), LANES, "{counts:?} {shape:?}");
            let mut seen: Vec<[u32; 4]> = (0..LANES).map(|k| shape.offsets.map(|axis| axis[k])).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), LANES);
        }
        assert_eq!(PacketShape::fitting([53, 79, 100, 100]).size, [1, 1, 4, 4]);
        assert_eq!(PacketShape::fitting([132, 198, 1, 1]).size, [4, 4, 1, 1]);
        assert_eq!(PacketShape::fitting([1, 1, 1, 10_000]).size, [1, 1, 1, 16]);
        assert_eq!(PacketShape::fitting([1, 1, 10_000, 1]).size, [1, 1, 16, 1]);
        assert_eq!(PacketShape::fitting([2000, 1, 1, 1]).size, [16, 1, 1, 1]);
    }

    /// Tiles have the size that their caller gives, also those of raw images, which have one axis of packets.
    #[test]
    fn tiles_are_as_large_as_wanted() {
        for counts in [[1, 30_000, 1, 16], [500, 500, 9, 9], [50, 70, 100, 100]] {
            let tiles = Tiling::with_tiles_of(counts, 8192).tiles();
            let lanes: Vec<usize> = tiles.iter().map(|tile| tile.packet_count() * LANES).collect();
            let whole = lanes.iter().filter(|&&lanes| (4096..=16_384).contains(&lanes)).count();
            assert!(10 * whole > 9 * tiles.len(), "{counts:?}: {whole} of {} tiles", tiles.len());
        }
    }

    /// Every pixel lies in one tile, one packet and one lane, and is written to its own position.
    #[test]
    fn tiles_cover_every_pixel_once() {
        for counts in [
            [3, 5, 10, 11],
            [4, 3, 9, 9],
            [2, 7, 5, 5],
            [3, 3, 13, 13],
            [53, 7, 4, 4],
            [1, 1, 1, 70],
            [1, 1, 300, 90],
            [33, 65, 1, 1],
            [2, 3, 1, 2],
        ] {
            let [v, u, t, s] = counts;
            let tiling = Tiling::new(counts);
            let mut field = Array5::<f32>::from_elem((v, u, t, s, 1), -1.0);
            let tiles = tiling.tiles();
            let outputs = tiling.cut(field.view_mut());
            assert_eq!(tiles.len(), outputs.len(), "{counts:?}");
            for (tile, mut output) in tiles.iter().zip(outputs) {
                let mut buffer = vec![[[0.0f32; LANES]; 1]; tile.packet_count()];
                let mut valid = 0;
                assert_eq!(tile.packet_positions().count(), buffer.len());
                for (values, packet) in buffer.iter_mut().zip(tile.packet_positions()) {
                    let axes = [0, 1, 2, 3].map(|axis| tiling.axis_lanes(axis).nth(packet[axis]).expect("a packet"));
                    for lane in (0..LANES).filter(|&lane| axes.iter().all(|(_, valid)| valid[lane] != 0)) {
                        let [pv, pu, pt, ps] = axes.map(|(index, _)| index[lane]);
                        values[0][lane] = (((pv * u + pu) * t + pt) * s + ps) as f32;
                        valid += 1;
                    }
                }
                assert_eq!(valid, output.len(), "valid lanes are the tile's pixels");
                tile.write(&buffer, 1.0, &mut output);
                assert_eq!(tile.read::<1>(&output), buffer, "read as written");
            }
            assert!(field.iter().enumerate().all(|(k, &x)| x == k as f32), "{counts:?}");
        }
    }
}
