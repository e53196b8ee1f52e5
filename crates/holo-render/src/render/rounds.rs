//! Rounds of samples: a render with a target for the error after the reconstruction across views.
//!
//! The first round has [`FIRST`] samples per pixel, and every later one as many as all before it. Before each, the error
//! that reconstructed pixels would have is estimated, and the packets in which it exceeds the target take part. The
//! samples of all rounds of a pixel are one run of its sequence, so their mean is that of a render with as many samples.
//!
//! # Bias
//! As in [`crate::film::adaptive`], a pixel whose first samples happen to agree gets fewer. The error is estimated over
//! 5 x 5 microlenses and 8 x 8 views together, so single pixels decide little.

use std::ops::Range;

use super::request::{Denoise, Request};

/// The samples of the first round: enough for half differences.
const FIRST: u32 = 4;

/// The target of the error after the reconstruction, if there is one.
pub(super) fn target(request: &Request) -> Option<f32> {
    let target = request.transport.target_error.filter(|_| request.denoise == Denoise::Views);
    target.map(|target| target as f32)
}

/// The numbers of the samples of all rounds; a single round without a target.
pub(super) fn rounds(request: &Request) -> Vec<Range<u32>> {
    if target(request).is_none() {
        return vec![0..request.transport.samples; 1];
    }
    let mut rounds = Vec::new();
    let (mut start, mut end) = (0, FIRST);
    while start < request.transport.samples {
        rounds.push(start..end.min(request.transport.samples));
        (start, end) = (end, end * 2);
    }
    rounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::{GridSize, LightFieldShape, Rig};

    #[test]
    fn rounds_hold_every_sample_once_and_begin_at_powers_of_two() {
        let shape = LightFieldShape::new(GridSize::new(2, 2), GridSize::new(2, 2)).expect("sizes");
        let request = Request::new(Rig::builder(shape).build().expect("a rig")).denoise(Denoise::Views);
        for samples in [1, 2, 4, 5, 100, 65_536] {
            let one = request.clone().samples(samples);
            assert_eq!(rounds(&one), vec![0..samples; 1]);
            let found = rounds(&one.target_error(Some(0.02)));
            assert_eq!(found.iter().map(|round| round.len() as u32).sum::<u32>(), samples);
            assert!(found.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].end.is_power_of_two()));
        }
    }
}
