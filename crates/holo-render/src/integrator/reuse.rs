//! Path reuse: the views of a packet share the light that their rays find.
//!
//! The sixteen rays of a packet are of neighboring views of one microlens and hit about the same spot. Each of them
//! samples the environment and scatters a ray, and all of them use all sixteen samples (Bekaert, Sbert and Halton,
//! "Accelerating path tracing by re-using paths", 2002).
//!
//! # Estimator
//! A direction of the environment map is sampled with the same density by every lane, so lane j takes the mean over the
//! samples of all lanes, each with its own BSDF and visibility.
//!
//! A ray that lane k scatters finds a point or direction x with the density p_k(x) if x is visible from lane k, V_k(x) = 1.
//! The balance heuristic over the lanes gives, for the integrand f_j(x) V_j(x) L(x) of lane j,
//!
//! > sum over the found x of f_j(x) V_j(x) L(x) / sum over k of p_k(x) V_k(x).
//!
//! Points have densities per area, directions per solid angle. L is the constant sky, the environment map, emission and
//! the light that a diffuse surface reflects: all the same for every lane on one side of a surface. What light sampling
//! finds too has the weight of lane j against light sampling in L ([`super::mis`]). Both sums are unbiased: every x that
//! lane j sees is found by itself, if by no other.
//!
//! For a lane alone are: samples of emissive surfaces, whose selection is its own; what delta lobes find, discs of distant
//! lights, unlit surfaces, and light that metal, glass and coats at x reflect.
//!
//! # What it gains
//! Paths of packets that show texture, edges or gloss are not shared: most of their noise comes from there. The noise of
//! the views of a packet is correlated: less of it in every view, about the same in their mean. Measurements:
//! `holo-bench`, `reuse`.
//!
//! # Order
//! Camera rays whose packet shares scatter rays for the sums of [`SharedLight`] ([`Step::Scatters`]). At the next vertex
//! these become paths of their lane again, except for the light that can be shared ([`Step::Finds`]). When all paths have
//! ended, the camera rays are traced again and receive the light ([`Step::Gathers`]).

mod light;

use super::SceneData;
use super::paths::PathPacket;
use super::vertex::Shading;
use crate::material::media::MediaStack;
use crate::material::{MaterialFlags, SurfaceInteraction};
use crate::simd::{LANES, Lanes};

pub(super) use light::FoundLight;

/// The largest difference of the base colors of lanes that share light, relative to the first.
const MAX_COLOR_DIFFERENCE: f32 = 0.25;

/// The smallest cosine between the shading normals of lanes that share light.
const MIN_NORMAL_COSINE: f32 = 0.9;

/// The place of a ray that is not shared.
const NOT_SHARED: u32 = u32::MAX;

/// What a scattered ray has found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Found {
    /// Nothing that others could use.
    #[default]
    Nothing,
    /// The environment in the direction `place`.
    Direction,
    /// The point `place` of a surface, which emits light or reflects it diffusely.
    Point,
}

/// The part of a camera packet in the reuse of paths.
pub(crate) enum Step<'a> {
    /// None: its paths are its own.
    Alone,
    /// Its rays are scattered; they find light for `shared`, the packet number `target` of the sums of light.
    Scatters { shared: &'a mut Shared, target: u32 },
    /// Its rays, of any packets, have found surfaces for these places of `shared`.
    Finds { shared: &'a mut SharedLight, places: &'a Places },
    /// It receives direct light and the light that its rays have found.
    Gathers(&'a Shared),
}

/// What the scattered rays of a packet have found.
#[derive(Clone, Copy)]
pub(crate) struct Shared {
    pub found: [Found; LANES],
    /// The radiance from there that only scattered rays find: the constant sky, reflected light.
    pub radiance: [[f32; LANES]; 3],
    /// The radiance from there that light sampling finds too: emission, the environment map.
    pub emitted: [[f32; LANES]; 3],
    /// BSDF * |cosine| / pdf of the scattered rays: the throughput of a path that is not shared.
    pub throughput: [[f32; LANES]; 3],
    pub place: [[f32; LANES]; 3],
    /// The unit normals of points, on the side from which the rays came.
    pub normal: [[f32; LANES]; 3],
    /// 1 for points on the front of their triangles, -1 on the back.
    pub side: [f32; LANES],
    /// The instances of points.
    pub instance: [u32; LANES],
    /// The light-sampling pdf of directions.
    pub light_pdf: [f32; LANES],
    /// The packet in the tile; `None` if its rays are not shared.
    pub packet: Option<u32>,
}

impl Shared {
    /// Nothing yet.
    pub const EMPTY: Self = Self {
        found: [Found::Nothing; LANES],
        radiance: [[0.0; LANES]; 3],
        emitted: [[0.0; LANES]; 3],
        throughput: [[0.0; LANES]; 3],
        place: [[0.0; LANES]; 3],
        normal: [[0.0; LANES]; 3],
        side: [1.0; LANES],
        instance: [0; LANES],
        light_pdf: [0.0; LANES],
        packet: None,
    };

    /// Whether the ray of `lane` has found light.
    #[inline(always)]
    pub fn is_lit(&self, lane: usize) -> bool {
        let mut sum = 0.0;
        for c in 0..3 {
            sum += self.radiance[c][lane] + self.emitted[c][lane];
        }
        self.found[lane] != Found::Nothing && sum > 0.0
    }

    /// Records the point that the ray of lane `from` has hit.
    #[inline(always)]
    fn hit(&mut self, from: usize, hit: &SurfaceInteraction, lane: usize, instance: u32) {
        self.found[from] = Found::Point;
        self.side[from] = hit.side[lane];
        self.instance[from] = instance;
        for axis in 0..3 {
            self.place[axis][from] = hit.position[axis][lane];
            self.normal[axis][from] = hit.geometric_normal[axis][lane];
        }
    }
}

/// The places of sixteen rays in the shared light: packet * 16 + lane, or [`NOT_SHARED`].
pub(crate) struct Places([u32; LANES]);

impl Places {
    /// The packet and the lane of the ray of `lane`, if it is shared.
    #[inline(always)]
    fn get(&self, lane: usize) -> Option<[usize; 2]> {
        let place = self.0[lane] as usize;
        (self.0[lane] != NOT_SHARED).then_some([place / LANES, place % LANES])
    }
}

/// What the shared rays of a pass have found: a packet for every camera packet of every sample.
///
/// A path with the pixel number 16 p + l of a tile of n packets adds its light to the pixel of packet p and lane l if p <
/// n, else to lane l of packet p - n here.
#[derive(Default)]
pub(crate) struct SharedLight {
    packets: Vec<Shared>,
    /// The packets of the tile.
    per_sample: usize,
}

impl SharedLight {
    /// Begins a pass of this many camera packets over a tile.
    pub fn begin(&mut self, packets: usize, per_sample: usize) {
        self.packets.clear();
        self.packets.resize(packets, Shared::EMPTY);
        self.per_sample = per_sample;
    }

    /// Whether camera packet number `k` of the pass shares light.
    pub fn is_active(&self, k: usize) -> bool {
        self.packets[k].packet.is_some()
    }

    /// The step in which camera packet number `k` of the pass, which is `packet` of the tile, scatters its rays.
    #[inline(always)]
    pub fn scatters(&mut self, k: usize, packet: u32) -> Step<'_> {
        let target = (self.per_sample + k) as u32;
        self.packets[k].packet = Some(packet / LANES as u32);
        Step::Scatters { shared: &mut self.packets[k], target }
    }

    /// The step in which camera packet number `k` receives light.
    #[inline(always)]
    pub fn gathers(&self, k: usize) -> Step<'_> {
        Step::Gathers(&self.packets[k])
    }

    /// The sum of the light for `packet` of a path; `None` if it belongs to a pixel.
    #[inline(always)]
    pub fn sum(&mut self, packet: usize) -> Option<&mut [[f32; LANES]; 3]> {
        let place = packet.checked_sub(self.per_sample)?;
        self.packets.get_mut(place).map(|shared| &mut shared.radiance)
    }

    /// The packet of the tile whose random numbers a path takes.
    #[inline(always)]
    pub fn packet_of_tile(&self, packet: usize) -> usize {
        match packet.checked_sub(self.per_sample).and_then(|place| self.packets.get(place)) {
            Some(shared) => shared.packet.unwrap_or(0) as usize,
            None => packet,
        }
    }

    /// Gives shared rays the throughput and the pixel of paths of their own. `None` if there are no shared rays.
    #[inline(always)]
    pub fn take_back(&self, paths: &mut PathPacket) -> Option<Places> {
        let pixels = (self.per_sample * LANES) as u32;
        let mut places = Places([NOT_SHARED; LANES]);
        for lane in 0..LANES {
            if (paths.pixel[lane] >= pixels) & (paths.valid.0[lane] != 0) {
                let place = paths.pixel[lane] - pixels;
                let (shared, from) = (&self.packets[place as usize / LANES], place as usize % LANES);
                for c in 0..3 {
                    paths.throughput[c][lane] = shared.throughput[c][from];
                }
                paths.pixel[lane] = shared.packet.unwrap_or(0) * LANES as u32 + from as u32;
                places.0[lane] = place;
            }
        }
        places.0.iter().any(|&place| place != NOT_SHARED).then_some(places)
    }

    /// Shares the sky and the environment map that shared rays see. Returns the lanes.
    #[inline(always)]
    pub fn environment(
        &mut self,
        scene: &SceneData,
        places: &Places,
        misses: &[bool; LANES],
        direction: &[[f32; LANES]; 3],
    ) -> [bool; LANES] {
        let mut out = [false; LANES];
        let (mut emitted, mut light_pdf) = ([[0.0; LANES]; 3], [0.0; LANES]);
        if let Some(environment) = scene.environment
            && misses.contains(&true)
        {
            (emitted, light_pdf) = (environment.radiance(direction), environment.pdf(direction));
        }
        for lane in 0..LANES {
            if let Some([packet, from]) = places.get(lane)
                && misses[lane]
            {
                let shared = &mut self.packets[packet];
                shared.found[from] = Found::Direction;
                shared.light_pdf[from] = light_pdf[lane];
                for k in 0..3 {
                    shared.place[k][from] = direction[k][lane];
                    shared.radiance[k][from] = scene.sky[k];
                    shared.emitted[k][from] = emitted[k][lane];
                }
                out[lane] = true;
            }
        }
        out
    }

    /// Shares the emission of the surfaces that shared rays hit. Returns the lanes.
    #[inline(always)]
    pub fn emission(
        &mut self,
        scene: &SceneData,
        places: &Places,
        interaction: &SurfaceInteraction,
        hit: &[bool; LANES],
        emitted: &[[f32; LANES]; 3],
    ) -> [bool; LANES] {
        let mut out = [false; LANES];
        for lane in 0..LANES {
            if let Some([packet, from]) = places.get(lane)
                && hit[lane]
                && !interaction.flags[lane].has(MaterialFlags::UNLIT)
            {
                let instance = scene.geometry.instance_index(interaction.triangle[lane]);
                let shared = &mut self.packets[packet];
                shared.hit(from, interaction, lane, instance);
                for c in 0..3 {
                    shared.emitted[c][from] = emitted[c][lane];
                }
                out[lane] = true;
            }
        }
        out
    }

    /// Shares the diffuse surfaces that shared rays hit: their paths go on for all lanes.
    #[inline(always)]
    pub fn surfaces(&mut self, scene: &SceneData, places: &Places, here: &mut Shading) {
        let interaction = here.interaction;
        for lane in 0..LANES {
            if let Some([packet, from]) = places.get(lane)
                && here.hit[lane]
                && !interaction.flags[lane].has(MaterialFlags::GLOSSY)
            {
                let instance = scene.geometry.instance_index(interaction.triangle[lane]);
                self.packets[packet].hit(from, interaction, lane, instance);
                for c in 0..3 {
                    here.paths.throughput[c][lane] = 1.0;
                }
                here.paths.pixel[lane] = (self.per_sample * LANES) as u32 + places.0[lane];
            }
        }
    }
}

/// Whether a camera packet shares its light: paths if all its lanes show one diffuse surface, the light of a single bounce
/// always, except from bodies of glass or inside them.
#[inline(always)]
pub(super) fn pays(max_bounces: u32, here: &Shading, valid: &Lanes<i32>) -> bool {
    let interaction = here.interaction;
    let mut in_air = !interaction.any_flags.has(MaterialFlags::VOLUME);
    let mut same = !interaction.any_flags.has(MaterialFlags::GLOSSY);
    let mut bright = [0.0; LANES];
    for c in 0..3 {
        for lane in 0..LANES {
            bright[lane] += interaction.base_color[c][lane];
        }
    }
    // Lane 0 of a packet is valid.
    for lane in 0..LANES {
        let mut cosine = 0.0;
        for axis in 0..3 {
            cosine += interaction.shading_normal[axis][lane] * interaction.shading_normal[axis][0];
        }
        let differs = (bright[lane] - bright[0]).abs() > MAX_COLOR_DIFFERENCE * bright[0];
        same &= here.hit[lane] & (cosine >= MIN_NORMAL_COSINE) & !differs | (valid.0[lane] == 0);
        in_air &= here.paths.media[lane] == MediaStack::AIR;
    }
    in_air & (same | (max_bounces == 1))
}
