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
    assert!(size_of::<RayHits>() == 1344 && align_of::<RayHits>() == 64);
    assert!(size_of::<Lanes<i32>>() == 64);
};
