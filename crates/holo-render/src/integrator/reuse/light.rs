//! The light that one scattered ray has found, as the sixteen lanes of its packet see it.

use super::{Found, Shared};
use crate::accel::{Coherence, Rays};
use crate::integrator::Context;
use crate::integrator::light_sampling::{LightSample, candidates};
use crate::integrator::mis::balance;
use crate::integrator::scatterer::Response;
use crate::integrator::vertex::Shading;
use crate::light::SHADOW_REACH;
use crate::simd::{LANES, Lanes, at, count};
use holo_scene::MAX_RADIANCE;

/// What belongs to a light sample that one lane has found for all.
pub(in crate::integrator) struct FoundLight {
    /// The lane that has found it.
    from: usize,
    emitted: [f32; 3],
    /// The density per area (per solid angle for directions) of a density per solid angle of the lane; 0 for lanes behind
    /// the surface of the point.
    geometry: [f32; LANES],
    /// The weighted light-sampling pdf per solid angle.
    light_pdf: [f32; LANES],
}

impl FoundLight {
    /// What the ray of lane `from` has found, as a light sample, whose strength is without emission.
    #[inline(always)]
    pub fn new(context: &Context, here: &Shading, shared: &Shared, from: usize) -> (LightSample, Self) {
        let (place, normal, radiance) = (at(&shared.place, from), at(&shared.normal, from), at(&shared.radiance, from));
        let mut sample = LightSample {
            to_light: [[0.0; LANES]; 3],
            inverse_length: [1.0; LANES],
            far: [f32::INFINITY; LANES],
            strength: [[0.0; LANES]; 3],
            pdf: [0.0; LANES],
        };
        for k in 0..3 {
            sample.to_light[k] = [place[k]; LANES];
            sample.strength[k] = [radiance[k]; LANES];
        }
        let emitted = at(&shared.emitted, from);
        if shared.found[from] == Found::Direction {
            let light_pdf = [shared.light_pdf[from]; LANES];
            return (sample, Self { from, emitted, geometry: [1.0; LANES], light_pdf });
        }
        sample.far = [SHADOW_REACH; LANES];
        let [mut geometry, mut squared, mut cosine] = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let mut facing = 0.0;
            for axis in 0..3 {
                let step = place[axis] - here.interaction.start[axis][lane];
                sample.to_light[axis][lane] = step;
                squared[lane] += step * step;
                facing -= step * normal[axis];
            }
            let inverse = if squared[lane] > 0.0 { 1.0 / squared[lane].sqrt() } else { 0.0 };
            sample.inverse_length[lane] = inverse;
            geometry[lane] = facing.max(0.0) * inverse * inverse * inverse;
            cosine[lane] = shared.side[from] * facing * inverse;
        }
        let mut light_pdf = [0.0; LANES];
        if let Some(emitters) = context.scene.emitters
            && emitted[0] + emitted[1] + emitted[2] > 0.0
        {
            light_pdf = emitters.pdf(&[shared.instance[from]; LANES], &squared, &cosine);
            let (_, weight) = candidates(here.vertex, true);
            for lane in 0..LANES {
                light_pdf[lane] *= weight;
            }
        }
        (sample, Self { from, emitted, geometry, light_pdf })
    }

    /// Adds the light to all lanes that see it; returns the number of shadow rays.
    #[inline(always)]
    pub fn add(
        &self,
        context: &Context,
        here: &Shading,
        sample: &LightSample,
        response: &Response,
        radiance: &mut [[f32; LANES]; 3],
    ) -> u64 {
        let mut pdf = [0.0; LANES];
        let mut lit = Lanes([0; LANES]);
        for lane in 0..LANES {
            let sent = response.value[0][lane] + response.value[1][lane] + response.value[2][lane];
            let density = response.bsdf_pdf[lane] * self.geometry[lane];
            // Points closer than 1e-19 m have no finite density.
            let shares = here.hit[lane] & (sent > 0.0) & (density > 0.0) & (density < f32::INFINITY);
            pdf[lane] = if shares { density } else { 0.0 };
            lit.0[lane] = -i32::from(shares);
        }
        // The lane itself has found it.
        let mut tested = lit;
        tested.0[self.from] = 0;
        let mut rays = Rays { origin: response.start, direction: sample.to_light, far: sample.far, ..Rays::EMPTY };
        let tests = count(&tested);
        if tests > 0 {
            context.scene.engine.occluded(&tested, &mut rays, Coherence::Coherent);
        }
        let mut all = 0.0;
        for lane in 0..LANES {
            pdf[lane] = if (lit.0[lane] != 0) & (rays.far[lane] >= 0.0) { pdf[lane] } else { 0.0 };
            all += pdf[lane];
        }
        let inverse = if all > 0.0 { 1.0 / all } else { 0.0 };
        for lane in 0..LANES {
            let factor = if pdf[lane] > 0.0 { self.geometry[lane] * inverse } else { 0.0 };
            let weight = balance(response.bsdf_pdf[lane], self.light_pdf[lane]);
            for c in 0..3 {
                let sent = here.paths.throughput[c][lane] * response.value[c][lane];
                let arriving = sample.strength[c][lane] + self.emitted[c] * weight;
                let found = (sent * (arriving * factor)).min(MAX_RADIANCE);
                radiance[c][lane] += if pdf[lane] > 0.0 { found } else { 0.0 };
            }
        }
        tests
    }
}
