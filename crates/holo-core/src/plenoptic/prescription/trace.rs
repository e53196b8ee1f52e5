//! Rays through the surfaces of a lens, from the sensor to the scene.

use super::Prescription;

/// Newton's steps to a place on an aspheric surface.
const STEPS: usize = 20;

/// Rays on their way through a lens, in a frame with x to the right and y up as the scene is, and z towards the scene from the
/// last surface.
///
/// # Units
///
/// Meters; directions have the length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensRays<const N: usize> {
    /// Places on the rays: x, y and z.
    pub position_m: [[f64; N]; 3],
    /// Directions, whose z is above 0.
    pub direction: [[f64; N]; 3],
    /// Below 0 for a ray that the lens stops.
    pub clearance: [f64; N],
}

impl<const N: usize> LensRays<N> {
    /// Returns rays from places in a plane behind the lens, with their slopes per meter towards the scene.
    #[inline(always)]
    #[must_use]
    pub fn new(place_m: [[f64; N]; 2], z_m: f64, slope: [[f64; N]; 2]) -> Self {
        let mut rays =
            Self { position_m: [place_m[0], place_m[1], [z_m; N]], direction: [[0.0; N]; 3], clearance: [1.0; N] };
        for k in 0..N {
            let (x, y) = (slope[0][k], slope[1][k]);
            let along = 1.0 / (1.0 + x * x + y * y).sqrt();
            rays.direction[0][k] = x * along;
            rays.direction[1][k] = y * along;
            rays.direction[2][k] = along;
        }
        rays
    }
}

/// A surface, seen from the sensor.
#[derive(Debug, Clone, PartialEq)]
struct TracedSurface {
    /// The place of the vertex, towards the scene from the last surface, m.
    vertex_m: f64,
    /// 1 / radius, above 0 where the center of curvature lies towards the scene.
    curvature_per_m: f64,
    conic: f64,
    /// The coefficients of r^4, r^6 and so on, towards the scene.
    aspheric: Vec<f64>,
    semi_aperture_squared: f64,
    /// The index towards the sensor / that towards the scene.
    ratio: f64,
    is_stop: bool,
}

/// A lens ready to trace rays of one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::plenoptic) struct TracedLens {
    /// From the sensor to the scene.
    surfaces: Vec<TracedSurface>,
    /// The plane of the entrance pupil, towards the scene from the last surface, m.
    entrance_pupil_m: f64,
    /// The stop's number from the sensor.
    stop: usize,
}

impl TracedLens {
    /// Prepares a lens; the plane of the entrance pupil is that of the d line for every wavelength.
    pub fn new(lens: &Prescription, wavelength_nm: f64) -> Self {
        let mut before = 1.0;
        let mut from_first_m = 0.0;
        let length_m = lens.paraxial().length_m;
        let traced = |surface: &super::Surface| {
            let behind = surface.medium.index(wavelength_nm);
            let out = TracedSurface {
                vertex_m: length_m - from_first_m,
                curvature_per_m: -surface.curvature_per_m(),
                conic: surface.conic,
                aspheric: surface.aspheric.iter().map(|a| -a).collect(),
                semi_aperture_squared: surface.semi_aperture_m * surface.semi_aperture_m,
                ratio: behind / before,
                is_stop: surface.is_stop,
            };
            from_first_m += surface.thickness_m;
            before = behind;
            out
        };
        let mut surfaces: Vec<_> = lens.surfaces().iter().map(traced).collect();
        surfaces.reverse();
        let stop = surfaces.iter().position(|surface| surface.is_stop).unwrap_or(0);
        Self { surfaces, entrance_pupil_m: length_m - lens.paraxial().entrance_pupil_m, stop }
    }

    /// Where the first surface lies, as a depth from the entrance pupil, m.
    pub fn front_depth_m(&self) -> f64 {
        self.surfaces.last().map_or(0.0, |front| front.vertex_m) - self.entrance_pupil_m
    }

    /// Traces rays to the scene: their places in the plane of the entrance pupil and their displacements per meter of depth.
    #[inline(always)]
    pub fn trace<const N: usize>(&self, rays: &mut LensRays<N>) -> [[[f64; N]; 2]; 2] {
        for surface in &self.surfaces {
            surface.refract(rays);
        }
        let mut out = [[[0.0; N]; 2]; 2];
        for k in 0..N {
            let per_depth = 1.0 / rays.direction[2][k];
            let way = self.entrance_pupil_m - rays.position_m[2][k];
            for axis in 0..2 {
                let slope = rays.direction[axis][k] * per_depth;
                out[0][axis][k] = rays.position_m[axis][k] + slope * way;
                out[1][axis][k] = slope;
            }
        }
        out
    }

    /// Where a ray meets the plane of the stop, if the apertures of the surfaces did not end it: x, m from the axis.
    pub fn at_stop_m(&self, mut rays: LensRays<1>) -> f64 {
        for surface in &self.surfaces[..self.stop] {
            surface.refract(&mut rays);
        }
        let stop = &self.surfaces[self.stop];
        stop.meet(&mut rays);
        rays.position_m[0][0]
    }
}

impl TracedSurface {
    /// Moves rays to the surface and refracts them; `clearance` is then below 0 for those that miss it or its aperture, or that
    /// it reflects totally.
    #[inline(always)]
    fn refract<const N: usize>(&self, rays: &mut LensRays<N>) {
        self.meet(rays);
        let normal = self.normal(rays);
        let mu = self.ratio;
        for k in 0..N {
            let [x, y] = [rays.position_m[0][k], rays.position_m[1][k]];
            let mut clearance = lesser(rays.clearance[k], self.semi_aperture_squared - (x * x + y * y));
            let along = (0..3).map(|axis| rays.direction[axis][k] * normal[axis][k]).sum::<f64>();
            let squared = 1.0 - mu * mu * (1.0 - along * along);
            clearance = lesser(clearance, squared);
            let onwards = if squared > 0.0 { squared } else { 0.0 }.sqrt() - mu * along;
            for axis in 0..3 {
                rays.direction[axis][k] = mu * rays.direction[axis][k] + onwards * normal[axis][k];
            }
            // Rays that do not go on towards the scene end.
            rays.clearance[k] = lesser(clearance, rays.direction[2][k]);
        }
    }

    /// Moves rays to the surface.
    #[inline(always)]
    fn meet<const N: usize>(&self, rays: &mut LensRays<N>) {
        let (curvature, conic) = (self.curvature_per_m, self.conic);
        for k in 0..N {
            let [dx, dy, dz] = [rays.direction[0][k], rays.direction[1][k], rays.direction[2][k]];
            // To the plane of the vertex first: from there the nearer of both crossings is the one of the lens.
            let to_plane = (self.vertex_m - rays.position_m[2][k]) / dz;
            let [x, y] = [rays.position_m[0][k] + to_plane * dx, rays.position_m[1][k] + to_plane * dy];
            // A t^2 - 2 B t + C = 0 for the way t to c (x^2 + y^2 + (1 + conic) z^2) = 2 z.
            let a = curvature * (1.0 + conic * dz * dz);
            let b = dz - curvature * (x * dx + y * dy);
            let c = curvature * (x * x + y * y);
            let squared = b * b - a * c;
            let root = if squared > 0.0 { squared } else { 0.0 }.sqrt();
            let way = c / (b + root);
            rays.clearance[k] = lesser(lesser(rays.clearance[k], squared), b + root);
            rays.position_m[0][k] = x + way * dx;
            rays.position_m[1][k] = y + way * dy;
            rays.position_m[2][k] = self.vertex_m + way * dz;
        }
        if !self.aspheric.is_empty() {
            for k in 0..N {
                self.approach(rays, k);
            }
        }
    }

    /// Moves a ray from a conic surface to the aspheric one.
    #[inline(never)]
    fn approach<const N: usize>(&self, rays: &mut LensRays<N>, k: usize) {
        let direction = [0, 1, 2].map(|axis| rays.direction[axis][k]);
        for _ in 0..STEPS {
            let [x, y, z] = [0, 1, 2].map(|axis| rays.position_m[axis][k]);
            let (sag, slope) = self.sag(x * x + y * y);
            let away = z - self.vertex_m - sag;
            let way = -away / (direction[2] - slope * (x * direction[0] + y * direction[1]));
            for (axis, along) in direction.iter().enumerate() {
                rays.position_m[axis][k] += way * along;
            }
            if way.abs() <= 1e-16 {
                return;
            }
            if !way.is_finite() {
                break;
            }
        }
        let [x, y, z] = [0, 1, 2].map(|axis| rays.position_m[axis][k]);
        let away = z - self.vertex_m - self.sag(x * x + y * y).0;
        // It may swing by the rounding of lengths.
        if away.is_nan() || away.abs() > 1e-12 {
            rays.clearance[k] = -1.0;
        }
    }

    /// The sag at the square of a distance from the axis, and twice its derivative by that square: the slope along x over x.
    fn sag(&self, squared: f64) -> (f64, f64) {
        let (c, conic) = (self.curvature_per_m, self.conic);
        let root = (1.0 - (1.0 + conic) * c * c * squared).max(0.0).sqrt();
        let (mut sag, mut slope) = (c * squared / (1.0 + root), c / root);
        let mut power = squared;
        for (a, exponent) in self.aspheric.iter().zip((4..).step_by(2)) {
            // a r^exponent, and a exponent r^(exponent - 2).
            slope += a * f64::from(exponent) * power;
            power *= squared;
            sag += a * power;
        }
        (sag, slope)
    }

    /// The normal of the surface, of length 1, where rays meet it.
    #[inline(always)]
    fn normal<const N: usize>(&self, rays: &LensRays<N>) -> [[f64; N]; 3] {
        let mut normal = [[0.0; N]; 3];
        let (curvature, conic) = (self.curvature_per_m, self.conic);
        if !self.aspheric.is_empty() {
            for k in 0..N {
                let [x, y] = [rays.position_m[0][k], rays.position_m[1][k]];
                let slope = self.sag(x * x + y * y).1;
                let length = 1.0 / (1.0 + slope * slope * (x * x + y * y)).sqrt();
                [normal[0][k], normal[1][k], normal[2][k]] = [-slope * x * length, -slope * y * length, length];
            }
            return normal;
        }
        for k in 0..N {
            let [x, y] = [rays.position_m[0][k], rays.position_m[1][k]];
            let z = rays.position_m[2][k] - self.vertex_m;
            let [nx, ny, nz] = [-curvature * x, -curvature * y, 1.0 - curvature * (1.0 + conic) * z];
            // 1 for a sphere.
            let length = if conic == 0.0 { 1.0 } else { 1.0 / (nx * nx + ny * ny + nz * nz).sqrt() };
            [normal[0][k], normal[1][k], normal[2][k]] = [nx * length, ny * length, nz * length];
        }
        normal
    }
}

/// The lesser of two numbers; the first if the other is none.
#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if b < a || b.is_nan() { b } else { a }
}
