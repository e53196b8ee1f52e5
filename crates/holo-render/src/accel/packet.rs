//! Packets of sixteen rays and their hits, in the layout of Embree's `RTCRayHit16`.

use crate::geometry::{FLATTENED, Hit};
use crate::simd::{LANES, Lanes};

/// The triangle of a ray that hit nothing (Embree's `RTC_INVALID_GEOMETRY_ID`).
pub(crate) const NO_TRIANGLE: u32 = u32::MAX;

/// The bit of [`Rays::id`] that marks camera rays.
pub(crate) const CAMERA_RAY: u32 = 1 << 31;

/// The start of rays: a camera that lies exactly on a surface does not hit it.
const NEAREST: f32 = f32::MIN_POSITIVE;

/// Sixteen rays: `RTCRay16`, 12 words per ray.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays {
    pub origin: [[f32; LANES]; 3],
    pub near: [f32; LANES],
    pub direction: [[f32; LANES]; 3],
    pub time: [f32; LANES],
    pub far: [f32; LANES],
    pub mask: [u32; LANES],
    /// A random number of the ray, for the choice at surfaces that let some rays pass, with the flag [`CAMERA_RAY`].
    pub id: [u32; LANES],
    pub flags: [u32; LANES],
}

/// Sixteen exact rays: camera coordinates, start in the plane z = 0, direction z = -1.
pub(crate) struct ExactRays {
    pub origin_x: [f64; LANES],
    pub origin_y: [f64; LANES],
    pub direction_x: [f64; LANES],
    pub direction_y: [f64; LANES],
}

impl ExactRays {
    /// Prepares `packet` for a query with these rays, rounded to f32.
    #[inline(always)]
    pub fn write(&self, packet: &mut RayHits) {
        packet.reset();
        for lane in 0..LANES {
            packet.rays.origin[0][lane] = self.origin_x[lane] as f32;
            packet.rays.origin[1][lane] = self.origin_y[lane] as f32;
            packet.rays.direction[0][lane] = self.direction_x[lane] as f32;
            packet.rays.direction[1][lane] = self.direction_y[lane] as f32;
        }
        packet.rays.origin[2] = [0.0; LANES];
        packet.rays.direction[2] = [-1.0; LANES];
    }
}

/// The parts of their pixels that sixteen exact rays stand for.
#[derive(Clone, Copy)]
#[allow(clippy::large_enum_variant, reason = "one at a time, on the stack")]
pub(crate) enum Cells {
    /// Squares of an image that pinholes form.
    Squares(RayDifferentials),
    /// Parts of pixels of a sensor, each seen through a part of a microlens.
    Spots(SpotDifferentials),
}

/// How sixteen exact rays change over a part of a pixel of a sensor and over a part of the microlens in front of it.
/// A coordinate of a ray moves by the same factor along both axes of either, so that a part and its spot in the scene are
/// similar.
#[derive(Clone, Copy)]
pub(crate) struct SpotDifferentials {
    /// What origin and direction change by over the width of the part of the pixel, m.
    pub on_sensor: [[f32; LANES]; 2],
    /// What origin and direction change by per meter on the microlens.
    pub on_lens: [[f32; LANES]; 2],
    /// The part of the microlens: 12 times the variances along x and y and the covariance of its points, m^2. That is the
    /// square of the width of a square. Not a number where the part is not lit whole.
    pub lens_part: [[f32; LANES]; 3],
    /// What origin and direction change by, along x and y, to the ray through the middles of both parts.
    pub to_center: [[[f32; LANES]; 2]; 2],
}

/// The differentials of sixteen exact rays: how they change over the pixels, in steps that divide a pixel into cells.
#[derive(Clone, Copy)]
pub(crate) struct RayDifferentials {
    /// What the origin changes by from one cell to the next, along +X for columns and along -Y for rows, m.
    pub origin_step: f32,
    /// The same for the direction.
    pub direction_step: f32,
    /// From the rays to the centers of their cells, in cells along the columns and rows.
    pub to_center: [[f32; LANES]; 2],
}

/// Sixteen hits: `RTCHit16` of Embree 4.3 and later, 9 words per ray. Versions 4.0 to 4.2 lack the last word.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hits {
    pub normal: [[f32; LANES]; 3],
    pub u: [f32; LANES],
    pub v: [f32; LANES],
    /// Index into all triangles of the geometry.
    pub triangle: [u32; LANES],
    pub geometry: [u32; LANES],
    /// Index into [`Geometry::placements`](crate::geometry::Geometry::placements), or [`FLATTENED`] (Embree's
    /// `RTC_INVALID_GEOMETRY_ID`).
    pub instance: [u32; LANES],
    pub instance_primitive: [u32; LANES],
}

/// Sixteen rays with their hits: `RTCRayHit16`, 1344 bytes.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayHits {
    pub rays: Rays,
    pub hits: Hits,
}

/// Eight rays or their hits: `WORDS` words per ray, `RTCRay8` of 12 words or `RTCRayHit8` of 21.
#[repr(C, align(32))]
pub(crate) struct Half<const WORDS: usize>([[u32; LANES / 2]; WORDS]);

/// Where the end of a ray is among the words of [`Rays`], and the first word of [`Hits`] behind them.
const FAR: usize = 8;
const RAY_WORDS: usize = 12;

/// Lanes 0 to 7 or 8 to 15 as bits.
#[inline(always)]
fn part<T: Copy>(lanes: &[T; LANES], half: usize, bits: impl Fn(T) -> u32) -> [u32; LANES / 2] {
    std::array::from_fn(|lane| bits(lanes[half * LANES / 2 + lane]))
}

impl Half<RAY_WORDS> {
    /// Half of a packet of rays.
    #[inline(always)]
    pub fn of_rays(rays: &Rays, half: usize) -> Self {
        let float = |lanes| part(lanes, half, f32::to_bits);
        let [x, y, z] = [0, 1, 2].map(|axis| float(&rays.origin[axis]));
        let [dx, dy, dz] = [0, 1, 2].map(|axis| float(&rays.direction[axis]));
        let [mask, id, flags] = [&rays.mask, &rays.id, &rays.flags].map(|lanes| part(lanes, half, |bits| bits));
        let [near, time, far] = [&rays.near, &rays.time, &rays.far].map(float);
        Self([x, y, z, near, dx, dy, dz, time, far, mask, id, flags])
    }

    /// Writes the ends of the rays back.
    #[inline(always)]
    pub fn write_ends(&self, rays: &mut Rays, half: usize) {
        for (lane, bits) in self.0[FAR].into_iter().enumerate() {
            rays.far[half * LANES / 2 + lane] = f32::from_bits(bits);
        }
    }
}

impl Half<{ RAY_WORDS + 9 }> {
    /// Half of a packet.
    #[inline(always)]
    pub fn of(packet: &RayHits, half: usize) -> Self {
        let hits = &packet.hits;
        let float = |lanes| part(lanes, half, f32::to_bits);
        let [x, y, z] = [0, 1, 2].map(|axis| float(&hits.normal[axis]));
        let [u, v] = [&hits.u, &hits.v].map(float);
        let numbers = [&hits.triangle, &hits.geometry, &hits.instance, &hits.instance_primitive];
        let [triangle, geometry, instance, primitive] = numbers.map(|lanes| part(lanes, half, |bits| bits));
        let mut words = [[0; LANES / 2]; RAY_WORDS + 9];
        words[..RAY_WORDS].copy_from_slice(&Half::of_rays(&packet.rays, half).0);
        words[RAY_WORDS..].copy_from_slice(&[x, y, z, u, v, triangle, geometry, instance, primitive]);
        Self(words)
    }

    /// Writes the ends of the rays and the hits back.
    #[inline(always)]
    pub fn write(&self, packet: &mut RayHits, half: usize) {
        let RayHits { rays, hits } = packet;
        for lane in 0..LANES / 2 {
            let (to, word) = (half * LANES / 2 + lane, |word: usize| self.0[word][lane]);
            let float = |k: usize| f32::from_bits(word(k));
            rays.far[to] = float(FAR);
            for axis in 0..3 {
                hits.normal[axis][to] = float(RAY_WORDS + axis);
            }
            (hits.u[to], hits.v[to]) = (float(RAY_WORDS + 3), float(RAY_WORDS + 4));
            (hits.triangle[to], hits.geometry[to]) = (word(RAY_WORDS + 5), word(RAY_WORDS + 6));
            (hits.instance[to], hits.instance_primitive[to]) = (word(RAY_WORDS + 7), word(RAY_WORDS + 8));
        }
    }
}

impl Rays {
    /// Default rays: from the origin along -Z, of unlimited length.
    pub const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        near: [NEAREST; LANES],
        direction: [[0.0; LANES], [0.0; LANES], [-1.0; LANES]],
        time: [0.0; LANES],
        far: [f32::INFINITY; LANES],
        mask: [u32::MAX; LANES],
        id: [0; LANES],
        flags: [0; LANES],
    };
}

impl Hits {
    /// No hits.
    pub const EMPTY: Self = Self {
        normal: [[0.0; LANES]; 3],
        u: [0.0; LANES],
        v: [0.0; LANES],
        triangle: [NO_TRIANGLE; LANES],
        geometry: [NO_TRIANGLE; LANES],
        instance: [FLATTENED; LANES],
        instance_primitive: [NO_TRIANGLE; LANES],
    };
}

impl RayHits {
    /// Default rays without hits.
    pub const EMPTY: Self = Self { rays: Rays::EMPTY, hits: Hits::EMPTY };

    /// Prepares the packet for another query; the caller then writes origins and directions.
    #[inline(always)]
    pub fn reset(&mut self) {
        self.rays.near = [NEAREST; LANES];
        self.rays.far = [f32::INFINITY; LANES];
        self.hits.triangle = [NO_TRIANGLE; LANES];
        self.hits.geometry = [NO_TRIANGLE; LANES];
        self.hits.instance = [FLATTENED; LANES];
    }

    /// The triangle that lane `lane` hit.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Hit {
        Hit { triangle: self.hits.triangle[lane], placement: self.hits.instance[lane] }
    }
}

// The layout that the binding to Embree relies on.
const _: () = {
    assert!(size_of::<Rays>() == 12 * 64 && align_of::<Rays>() == 64);
    assert!(size_of::<Hits>() == 9 * 64);
    assert!(size_of::<Half<12>>() == 12 * 32 && size_of::<Half<21>>() == 21 * 32 && align_of::<Half<21>>() == 32);
    assert!(size_of::<RayHits>() == 1344 && align_of::<RayHits>() == 64);
    assert!(size_of::<Lanes<i32>>() == 64);
};
