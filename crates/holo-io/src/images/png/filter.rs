//! The five row filters of PNG and the choice of one for each row.

/// The filters by their number in the file.
const FILTERS: [fn(&mut [u8], &Neighbors<'_>); 5] = [none, sub, up, average, paeth];

/// A row, the row above it, and both shifted by one pixel with zeros at the left edge.
struct Neighbors<'a> {
    row: &'a [u8],
    left: &'a [u8],
    above: &'a [u8],
    above_left: &'a [u8],
}

fn none(out: &mut [u8], n: &Neighbors<'_>) {
    out.copy_from_slice(n.row);
}

fn sub(out: &mut [u8], n: &Neighbors<'_>) {
    for ((out, row), left) in out.iter_mut().zip(n.row).zip(n.left) {
        *out = row.wrapping_sub(*left);
    }
}

fn up(out: &mut [u8], n: &Neighbors<'_>) {
    for ((out, row), above) in out.iter_mut().zip(n.row).zip(n.above) {
        *out = row.wrapping_sub(*above);
    }
}

fn average(out: &mut [u8], n: &Neighbors<'_>) {
    for (((out, row), left), above) in out.iter_mut().zip(n.row).zip(n.left).zip(n.above) {
        *out = row.wrapping_sub(((u16::from(*left) + u16::from(*above)) / 2) as u8);
    }
}

fn paeth(out: &mut [u8], n: &Neighbors<'_>) {
    for ((((out, row), left), above), above_left) in
        out.iter_mut().zip(n.row).zip(n.left).zip(n.above).zip(n.above_left)
    {
        let (a, b, c) = (i16::from(*left), i16::from(*above), i16::from(*above_left));
        // Distances of a + b - c to a, b and c; the nearest is the prediction, in that order for equal distances.
        let (to_a, to_b, to_c) = ((b - c).abs(), (a - c).abs(), (a + b - 2 * c).abs());
        // Without branches, so that the compiler vectorizes it.
        let b_or_c = if to_b <= to_c { *above } else { *above_left };
        let prediction = if (to_a <= to_b) & (to_a <= to_c) { *left } else { b_or_c };
        *out = row.wrapping_sub(prediction);
    }
}

/// Sum of absolute values of the filtered bytes as signed numbers: the heuristic of the PNG specification.
fn cost(filtered: &[u8]) -> u64 {
    // In blocks whose sums fit into 16 bits, for more vector lanes.
    filtered
        .chunks(256)
        .map(|block| u64::from(block.iter().map(|&byte| u16::from((byte as i8).unsigned_abs())).sum::<u16>()))
        .sum()
}

/// Filters the rows of an image or of a band, one after another.
pub(super) struct Filter {
    /// The current row and the row above it, each after one pixel of zeros.
    row: Vec<u8>,
    above: Vec<u8>,
    candidate: Vec<u8>,
    best: Vec<u8>,
    pixel_bytes: usize,
}

impl Filter {
    pub(super) fn new(row_bytes: usize, pixel_bytes: usize) -> Self {
        let padded = vec![0; row_bytes + pixel_bytes];
        let scratch = vec![0; row_bytes];
        Self { row: padded.clone(), above: padded, candidate: scratch.clone(), best: scratch, pixel_bytes }
    }

    /// Sets the row above the next one; initially zeros, as at the top of an image.
    pub(super) fn set_above(&mut self, row: &[u8]) {
        self.above[self.pixel_bytes..].copy_from_slice(row);
    }

    /// Appends the number of the filter of lowest cost and the row filtered by it.
    pub(super) fn append(&mut self, row: &[u8], out: &mut Vec<u8>) {
        self.row[self.pixel_bytes..].copy_from_slice(row);
        let neighbors = Neighbors {
            row: &self.row[self.pixel_bytes..],
            left: &self.row[..row.len()],
            above: &self.above[self.pixel_bytes..],
            above_left: &self.above[..row.len()],
        };
        let mut best = (u64::MAX, 0);
        for (number, filter) in (0_u8..).zip(FILTERS) {
            filter(&mut self.candidate, &neighbors);
            let cost = cost(&self.candidate);
            if cost < best.0 {
                best = (cost, number);
                std::mem::swap(&mut self.candidate, &mut self.best);
            }
        }
        out.push(best.1);
        out.extend_from_slice(&self.best);
        std::mem::swap(&mut self.row, &mut self.above);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reference implementation: the formulas of the standard, one byte at a time.
    fn reference(number: u8, row: &[u8], above: &[u8], pixel_bytes: usize) -> Vec<u8> {
        let predict = |at: usize| {
            let a = if at >= pixel_bytes { i32::from(row[at - pixel_bytes]) } else { 0 };
            let b = i32::from(above[at]);
            let c = if at >= pixel_bytes { i32::from(above[at - pixel_bytes]) } else { 0 };
            match number {
                0 => 0,
                1 => a,
                2 => b,
                3 => (a + b) / 2,
                _ => {
                    let p = a + b - c;
                    let (pa, pb, pc) = ((p - a).abs(), (p - b).abs(), (p - c).abs());
                    if pa <= pb && pa <= pc {
                        a
                    } else if pb <= pc {
                        b
                    } else {
                        c
                    }
                }
            }
        };
        (0..row.len()).map(|at| row[at].wrapping_sub(predict(at) as u8)).collect()
    }

    #[test]
    fn filters_agree_with_the_standard() {
        let mut state = 1_u32;
        let mut noise = |_: usize| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Extremes often, because that is where sums wrap.
            match state >> 30 {
                0 => 0,
                1 => 255,
                _ => (state >> 16) as u8,
            }
        };
        for pixel_bytes in 1..=8 {
            for pixels in [1, 2, 3, 17, 300] {
                let length = pixel_bytes * pixels;
                let [row, above]: [Vec<u8>; 2] = std::array::from_fn(|_| (0..length).map(&mut noise).collect());
                let pad = |bytes: &[u8]| [vec![0; pixel_bytes], bytes.to_vec()].concat();
                let (left, above_left) = (pad(&row), pad(&above));
                let neighbors =
                    Neighbors { row: &row, left: &left[..length], above: &above, above_left: &above_left[..length] };
                for (number, filter) in (0_u8..).zip(FILTERS) {
                    let mut out = vec![0; length];
                    filter(&mut out, &neighbors);
                    assert_eq!(
                        out,
                        reference(number, &row, &above, pixel_bytes),
                        "filter {number}, {pixel_bytes} bytes"
                    );
                }
                let costs = (0..5).map(|number| -> u64 {
                    reference(number, &row, &above, pixel_bytes)
                        .iter()
                        .map(|&b| u64::from((b as i8).unsigned_abs()))
                        .sum()
                });
                let cheapest = costs.enumerate().min_by_key(|&(_, cost)| cost).unwrap().0 as u8;
                let mut filter = Filter::new(length, pixel_bytes);
                filter.set_above(&above);
                let mut out = Vec::new();
                filter.append(&row, &mut out);
                assert_eq!(out[0], cheapest);
                assert_eq!(out[1..], reference(cheapest, &row, &above, pixel_bytes));
                // The row just written is the row above the next one.
                filter.append(&row, &mut out);
                let second = &out[length + 1..];
                assert_eq!(second[1..], reference(second[0], &row, &row, pixel_bytes));
            }
        }
    }

    #[test]
    fn the_cost_of_the_worst_row_does_not_wrap() {
        assert_eq!(cost(&[0x80; 1000]), 128_000);
    }
}
