//! Rounds of samples: a render with a target for the error after the reconstruction across views.
//!
//! In the first round one of 16 pixels has a sample, in each later one twice as many have one, until all have; then every
//! round has as many samples as all before it. Before each, the error that reconstructed pixels would have is estimated,
//! and the packets in which it exceeds the target take part. The samples of a pixel in all rounds are a part of the run of
//! its sequence.
//!
//! # Bias
//! As in [`crate::film::adaptive`], a pixel whose first samples happen to agree gets fewer. The error is estimated over
//! many pixels together, so single pixels decide little.

use super::request::{Denoise, Request};
use crate::integrator::path::Round;
use crate::sampling::SamplesPerPixel;

/// In the first round one of so many pixels has a sample.
const FIRST: u32 = 16;

/// The target of the error after the reconstruction, if there is one.
pub(super) fn target(request: &Request) -> Option<f32> {
    let target = request.transport.target_error.filter(|_| request.denoise == Denoise::Views);
    target.map(|target| target as f32)
}

/// All rounds; a single one without a target.
pub(super) fn rounds(request: &Request) -> Vec<Round> {
    let most = request.transport.samples;
    if target(request).is_none() {
        return vec![Round::whole(most)];
    }
    let first = SamplesPerPixel::one_in(FIRST.max(most.pixels())).unwrap_or(most);
    let mut rounds = vec![Round::whole(first)];
    let mut ranks = first.ranks();
    while ranks < most.ranks() {
        rounds.push(Round { samples: 0..1, ranks: ranks..2 * ranks });
        ranks *= 2;
    }
    let mut samples = 1;
    while samples < most.of_traced() {
        let end = (2 * samples).min(most.of_traced());
        rounds.push(Round { samples: samples..end, ranks: 0..ranks });
        samples = end;
    }
    rounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::{GridSize, LightFieldShape, Rig};

    #[test]
    fn rounds_hold_every_sample_once() {
        let shape = LightFieldShape::new(GridSize::new(2, 2), GridSize::new(2, 2)).expect("sizes");
        let request = Request::new(Rig::builder(shape).build().expect("a rig")).denoise(Denoise::Views);
        let few = [2, 8, 16, 64].map(|pixels| SamplesPerPixel::one_in(pixels).expect("a power of two"));
        for samples in [1, 2, 4, 5, 100, 65_536].map(SamplesPerPixel::from).into_iter().chain(few) {
            let one = request.clone().samples(samples);
            assert_eq!(rounds(&one), vec![Round::whole(samples)]);
            let found = rounds(&one.target_error(Some(0.02)));
            assert!(found[0].is_first() && !found[1..].iter().any(Round::is_first));
            let count: u32 = found.iter().map(|round| round.samples.len() as u32 * round.ranks.len() as u32).sum();
            assert_eq!(count, samples.of_traced() * samples.ranks());
            assert!(found.windows(2).all(|pair| {
                let next = &pair[1];
                let continues = pair[0].ranks.end == next.ranks.start && next.samples == (0..1);
                continues || (pair[0].samples.end == next.samples.start && next.ranks.start == 0)
            }));
        }
    }
}
