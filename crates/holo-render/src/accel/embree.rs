//! The Embree engine: Intel Embree 4, loaded at run time through a small binding of its C interface.
//!
//! This is one of the two files of this crate that contain `unsafe`. Its soundness rests on the following:
//!
//! - The functions are those of the public C header `embree4/rtcore.h`; their signatures are in [`Api`]. The ABI of a
//!   major version does not change, and [`Api::load`] rejects any library whose version is not 4.x.
//! - The library has one level of instances, as every packaged build has (`RTC_MAX_INSTANCE_LEVEL_COUNT` = 1). Scenes
//!   here use at most one: triangles, and placements of prototypes that contain only triangles.
//! - Queries pass no context; the library then creates one with an empty instance stack (Embree manual,
//!   "rtcIntersect16").
//! - A packet is [`RayHits`], whose size and alignment are asserted at compile time and equal those of `RTCRayHit16` of
//!   Embree 4.3 and later. Versions 4.0 to 4.2 lack the last field (`instPrimID`) and write less. A test surrounds
//!   packets with canaries and verifies that the installed version writes nothing else.
//! - Where the library does not take sixteen rays at once it would take them one by one (without AVX-512); it gets two
//!   packets of eight, [`Half`], of the size and alignment of `RTCRayHit8` and `RTCRay8`.
//! - Vertex and index buffers are shared, not copied: the engine holds the immutable [`Geometry`] that owns them, and
//!   releases the scenes first. Vertices are padded by one entry, because Embree reads 16 bytes for each.
//! - A committed scene may be queried from any thread (Embree manual, "rtcCommitScene").

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::ptr::{self, NonNull};
use std::sync::{Arc, OnceLock};

use libloading::Library;

use super::library::{Candidate, candidates};
use super::{Coherence, Engine, Half, NO_TRIANGLE, RayHits, Rays};
use crate::error::Error;
use crate::geometry::{FLATTENED, Geometry};
use crate::simd::{LANES, Lanes};

/// An opaque handle of Embree.
type Handle = *mut c_void;

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which have the same layout.
#[repr(C)]
struct QueryArguments {
    flags: c_uint,
    feature_mask: c_uint,
    context: *const c_void,
    filter: *const c_void,
    function: *const c_void,
}

impl QueryArguments {
    const fn new(coherence: Coherence) -> Self {
        let flags = match coherence {
            Coherence::Coherent => RAY_QUERY_FLAG_COHERENT,
            Coherence::Incoherent => 0,
        };
        let null = ptr::null();
        Self { flags, feature_mask: c_uint::MAX, context: null, filter: null, function: null }
    }
}

const RAY_QUERY_FLAG_COHERENT: c_uint = 1 << 16;
const DEVICE_PROPERTY_VERSION: c_int = 0;
const DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED: c_int = 33;
const DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED: c_int = 34;
const DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED: c_int = 65;
const DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED: c_int = 96;
const GEOMETRY_TYPE_TRIANGLE: c_int = 0;
const GEOMETRY_TYPE_INSTANCE: c_int = 121;
const BUFFER_TYPE_INDEX: c_int = 0;
const BUFFER_TYPE_VERTEX: c_int = 1;
const FORMAT_UINT3: c_int = 0x5003;
const FORMAT_FLOAT3: c_int = 0x9003;
const FORMAT_FLOAT3X4_COLUMN_MAJOR: c_int = 0x9234;
/// `RTC_SCENE_FLAG_ROBUST`: a ray through an edge hits one of its triangles (for vertices see the tests of
/// watertightness).
const SCENE_FLAG_ROBUST: c_int = 1 << 2;
const BUILD_QUALITY_MEDIUM: c_int = 1;
const ERROR_OUT_OF_MEMORY: c_int = 4;
const ERROR_UNSUPPORTED_CPU: c_int = 5;

/// Declares the function table and its loader from one list.
macro_rules! api {
    ($($(#[$attribute:meta])* $name:ident: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of a loaded library, which stays loaded as long as the table exists.
        #[allow(non_snake_case, reason = "the names of the C header")]
        struct Api {
            $($(#[$attribute])* $name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            /// The file, if it is known.
            path: Option<PathBuf>,
            _library: Library,
        }

        impl Api {
            fn from_library(library: Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    $(
                        $(#[$attribute])*
                        $name: {
                            let symbol = concat!(stringify!($name), "\0").as_bytes();
                            // SAFETY: the signature is that of the public header (see the module documentation), and
                            // the pointer does not outlive `_library`, which is stored beside it.
                            unsafe { *library.get(symbol)? }
                        },
                    )*
                    path: None,
                    _library: library,
                })
            }
        }
    };
}

api! {
    rtcNewDevice: fn(*const c_char) -> Handle;
    rtcReleaseDevice: fn(Handle);
    rtcGetDeviceProperty: fn(Handle, c_int) -> isize;
    rtcGetDeviceError: fn(Handle) -> c_int;
    rtcNewScene: fn(Handle) -> Handle;
    rtcSetSceneFlags: fn(Handle, c_int);
    rtcSetSceneBuildQuality: fn(Handle, c_int);
    rtcCommitScene: fn(Handle);
    rtcReleaseScene: fn(Handle);
    rtcNewGeometry: fn(Handle, c_int) -> Handle;
    rtcSetSharedGeometryBuffer: fn(Handle, c_int, c_uint, c_int, *const c_void, usize, usize, usize);
    rtcCommitGeometry: fn(Handle);
    rtcAttachGeometryByID: fn(Handle, Handle, c_uint);
    rtcSetGeometryInstancedScene: fn(Handle, Handle);
    rtcSetGeometryTransform: fn(Handle, c_uint, c_int, *const c_void);
    rtcReleaseGeometry: fn(Handle);
    rtcIntersect8: fn(*const c_int, Handle, *mut c_void, *const QueryArguments);
    rtcIntersect16: fn(*const c_int, Handle, *mut c_void, *const QueryArguments);
    #[cfg(feature = "bench")]
    rtcIntersect1: fn(Handle, *mut c_void, *const QueryArguments);
    rtcOccluded8: fn(*const c_int, Handle, *mut c_void, *const QueryArguments);
    rtcOccluded16: fn(*const c_int, Handle, *mut c_void, *const QueryArguments);
}

impl Api {
    /// The library. It is searched for once per process.
    fn get() -> Result<Arc<Self>, Error> {
        static API: OnceLock<Result<Arc<Api>, String>> = OnceLock::new();
        API.get_or_init(|| Self::load().map(Arc::new)).clone().map_err(Error::Embree)
    }

    fn load() -> Result<Self, String> {
        let mut tried = Vec::new();
        for Candidate { path: candidate, refused } in candidates() {
            if let Some(why) = refused {
                tried.push(format!("{}: {why}", candidate.display()));
                continue;
            }
            // SAFETY: loading runs the initializers of the library, which by its name is Embree (with TBB), and which the
            // user named, the system's loader finds, or nobody else could have put there (`library`).
            let loaded = unsafe { Library::new(&candidate) }.map_err(|why| why.to_string());
            match loaded.and_then(|library| Self::from_library(library).map_err(|why| why.to_string())) {
                Ok(api) => match api.check() {
                    Ok(()) => {
                        let path = file_of(api.rtcNewDevice as *const c_void).or(Some(candidate));
                        return Ok(Self { path: path.filter(|path| path.is_absolute()), ..api });
                    }
                    Err(why) => tried.push(format!("{}: {why}", candidate.display())),
                },
                // A bare file name that is not found needs no explanation.
                Err(_) if candidate.parent().is_none_or(|p| p.as_os_str().is_empty()) => {
                    tried.push(candidate.display().to_string());
                }
                Err(why) => tried.push(format!("{}: {why}", candidate.display())),
            }
        }
        Err(format!(
            "no Embree 4 found (tried {}); install libembree4, or run `cargo xtask embree`, or set HOLO_EMBREE_LIB",
            tried.join(", ")
        ))
    }

    /// Checks the version and the features that this file relies on.
    fn check(&self) -> Result<(), String> {
        // SAFETY: a null configuration selects the defaults; the device is checked, queried and released here.
        unsafe {
            let device = (self.rtcNewDevice)(ptr::null());
            if device.is_null() {
                let code = (self.rtcGetDeviceError)(ptr::null_mut());
                return Err(format!("cannot create a device: {} (error {code})", device_failure(code)));
            }
            let property = |which| (self.rtcGetDeviceProperty)(device, which);
            let version = property(DEVICE_PROPERTY_VERSION);
            let triangles = property(DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED) != 0;
            let one_sided = property(DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED) != 0;
            // No property reports support for instances; without it the library cannot create one.
            let instance = (self.rtcNewGeometry)(device, GEOMETRY_TYPE_INSTANCE);
            if !instance.is_null() {
                (self.rtcReleaseGeometry)(instance);
            }
            (self.rtcReleaseDevice)(device);
            if !(40_000..50_000).contains(&version) {
                return Err(format!("it is version {version}, and this program needs 4.x"));
            }
            if !triangles || one_sided || instance.is_null() {
                return Err("it was built without triangles or instances, or with one-sided triangles".into());
            }
        }
        Ok(())
    }
}

/// The file that a function was loaded from.
#[cfg(unix)]
fn file_of(function: *const c_void) -> Option<PathBuf> {
    use std::ffi::{CStr, OsStr};
    use std::os::unix::ffi::OsStrExt;

    let mut found = std::mem::MaybeUninit::<libc::Dl_info>::zeroed();
    // SAFETY: `dladdr` writes the structure; zeros are a valid one.
    let (is_found, found) = unsafe { (libc::dladdr(function, found.as_mut_ptr()), found.assume_init()) };
    if is_found == 0 || found.dli_fname.is_null() {
        return None;
    }
    // SAFETY: the name ends in NUL and lives as long as the library is loaded, which `function` is of.
    let name = unsafe { CStr::from_ptr(found.dli_fname) };
    Some(Path::new(OsStr::from_bytes(name.to_bytes())).to_owned())
}

/// Windows loads from absolute paths only ([`candidates`]).
#[cfg(not(unix))]
fn file_of(_: *const c_void) -> Option<PathBuf> {
    None
}

/// Why a device could not be created, by the error that the library keeps for this case.
fn device_failure(code: c_int) -> &'static str {
    match code {
        ERROR_OUT_OF_MEMORY => "memory is missing; close other programs, or render less at once",
        ERROR_UNSUPPORTED_CPU => "it does not know this processor",
        _ => "the library does not say why",
    }
}

/// The instruction set that HOLO_EMBREE_ISA names: intersections with AVX-512 and with AVX2 differ in their last bits, so that
/// the bytes of another processor need its set.
fn instruction_set() -> Result<Option<&'static str>, Error> {
    let Some(isa) = std::env::var_os("HOLO_EMBREE_ISA") else { return Ok(None) };
    match ["sse2", "sse4.2", "avx", "avx2", "avx512"].into_iter().find(|&name| isa == name) {
        Some(known) => Ok(Some(known)),
        None => Err(Error::Embree(format!("HOLO_EMBREE_ISA is {isa:?}; it can be avx512, avx2, avx, sse4.2 or sse2"))),
    }
}

/// The Embree engine: a device and a committed scene, which contains the flattened triangles as one mesh and the
/// placements of prototype scenes with one mesh each.
pub(crate) struct Embree {
    api: Arc<Api>,
    device: NonNull<c_void>,
    scene: NonNull<c_void>,
    /// The flags of all scenes.
    flags: c_int,
    /// Whether packets are given in two halves.
    halves: bool,
    /// One scene for every prototype mesh.
    prototypes: Vec<NonNull<c_void>>,
    name: String,
    /// Owns the buffers that the scenes share.
    geometry: Arc<Geometry>,
}

// SAFETY: Embree's device and scene handles are reference-counted objects without thread affinity.
unsafe impl Send for Embree {}
// SAFETY: the scene is committed and never changes; queries on it are thread-safe (module documentation).
unsafe impl Sync for Embree {}

impl Embree {
    /// Whether a library can be loaded.
    pub fn available() -> Result<(), Error> {
        Api::get().map(drop)
    }

    /// Builds the acceleration structure over `geometry` with `threads` threads (0: all).
    pub fn build(geometry: &Arc<Geometry>, threads: usize) -> Result<Self, Error> {
        Self::with_flags(geometry, threads, SCENE_FLAG_ROBUST)
    }

    /// As `build`, without the flag for watertight edges.
    #[cfg(test)]
    pub fn without_robust(geometry: &Arc<Geometry>, threads: usize) -> Result<Self, Error> {
        Self::with_flags(geometry, threads, 0)
    }

    fn with_flags(geometry: &Arc<Geometry>, threads: usize, flags: c_int) -> Result<Self, Error> {
        let api = Api::get()?;
        let isa = instruction_set()?;
        let mut config = format!("threads={threads}");
        if let Some(isa) = isa {
            config = format!("{config},isa={isa}");
        }
        let config = CString::new(config).map_err(|why| Error::Embree(why.to_string()))?;
        // SAFETY: `config` is a NUL-terminated string that outlives the call.
        let device = NonNull::new(unsafe { (api.rtcNewDevice)(config.as_ptr()) }).ok_or_else(|| {
            let hint =
                if isa.is_some() { "; perhaps the processor lacks the set that HOLO_EMBREE_ISA names" } else { "" };
            // SAFETY: without a device this returns the error of its creation on this thread.
            match unsafe { (api.rtcGetDeviceError)(ptr::null_mut()) } {
                ERROR_OUT_OF_MEMORY => Error::OutOfMemory("Embree cannot create a device".into()),
                code => Error::Embree(format!("cannot create a device: {}{hint}", device_failure(code))),
            }
        })?;
        // SAFETY: the device was just created.
        let property = |which| unsafe { (api.rtcGetDeviceProperty)(device.as_ptr(), which) };
        let version = property(DEVICE_PROPERTY_VERSION);
        let [eight, sixteen] = [DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED, DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED]
            .map(|which| property(which) != 0);
        let mut name = format!("embree {}.{}.{}", version / 10_000, version / 100 % 100, version % 100);
        if let Some(isa) = isa {
            // Other values: not to be mixed with those of the automatic choice.
            name = format!("{name} {isa}");
        }
        // SAFETY: the device is alive.
        let Some(scene) = NonNull::new(unsafe { (api.rtcNewScene)(device.as_ptr()) }) else {
            // SAFETY: as above.
            unsafe { (api.rtcReleaseDevice)(device.as_ptr()) };
            return Err(Error::Embree("cannot create a scene".into()));
        };
        // From here on `Drop` releases the device and the scenes.
        let geometry = Arc::clone(geometry);
        let halves = eight && !sixteen;
        let mut engine = Self { api, device, scene, flags, halves, prototypes: Vec::new(), name, geometry };
        engine.fill()?;
        Ok(engine)
    }

    /// Attaches the geometry to the scene and builds it.
    fn fill(&mut self) -> Result<(), Error> {
        let geometry = Arc::clone(&self.geometry);
        for triangles in geometry.prototypes() {
            // SAFETY: the device is alive.
            let made = NonNull::new(unsafe { (self.api.rtcNewScene)(self.device.as_ptr()) });
            let Some(scene) = made else { return Err(self.failure()) };
            self.prototypes.push(scene);
            self.attach_triangles(scene, triangles.clone(), 0)?;
            self.commit(scene)?;
        }
        let placements = geometry.placements();
        for (id, place) in placements.iter().enumerate() {
            let matrix = place.matrix();
            let instance = self.new_geometry(GEOMETRY_TYPE_INSTANCE)?;
            // SAFETY: all handles are alive; `matrix` is twelve floats in column-major order, which the call copies.
            // The scene holds a reference to the geometry, so that ours can be released. Each placement has an id of
            // its own.
            unsafe {
                let instance = instance.as_ptr();
                let prototype = self.prototypes[place.prototype as usize].as_ptr();
                (self.api.rtcSetGeometryInstancedScene)(instance, prototype);
                let format = FORMAT_FLOAT3X4_COLUMN_MAJOR;
                (self.api.rtcSetGeometryTransform)(instance, 0, format, matrix.as_ptr().cast());
                (self.api.rtcCommitGeometry)(instance);
                (self.api.rtcAttachGeometryByID)(self.scene.as_ptr(), instance, id as c_uint);
                (self.api.rtcReleaseGeometry)(instance);
            }
        }
        if geometry.flattened_count() > 0 {
            self.attach_triangles(self.scene, 0..geometry.flattened_count(), placements.len() as c_uint)?;
        }
        self.commit(self.scene)
    }

    fn new_geometry(&self, kind: c_int) -> Result<NonNull<c_void>, Error> {
        // SAFETY: the device is alive.
        NonNull::new(unsafe { (self.api.rtcNewGeometry)(self.device.as_ptr(), kind) }).ok_or_else(|| self.failure())
    }

    /// Attaches a range of the triangles to a scene, with the geometry id `id`.
    fn attach_triangles(&self, scene: NonNull<c_void>, range: Range<usize>, id: c_uint) -> Result<(), Error> {
        let (api, geometry) = (&self.api, &self.geometry);
        let mesh = self.new_geometry(GEOMETRY_TYPE_TRIANGLE)?.as_ptr();
        let share = |kind, format, data: *const c_void, count| {
            // SAFETY: the mesh is alive; the buffers belong to the immutable geometry, which `self` keeps alive; counts
            // and strides are those of the slices, and the vertices have one more entry than is passed.
            unsafe { (api.rtcSetSharedGeometryBuffer)(mesh, kind, 0, format, data, 0, 12, count) };
        };
        let vertices = geometry.padded_positions();
        share(BUFFER_TYPE_VERTEX, FORMAT_FLOAT3, vertices.as_ptr().cast(), vertices.len() - 1);
        let triangles = &geometry.triangles()[range];
        share(BUFFER_TYPE_INDEX, FORMAT_UINT3, triangles.as_ptr().cast(), triangles.len());
        // SAFETY: mesh and scene are alive; the scene holds a reference to the mesh, so that ours can be released.
        unsafe {
            (api.rtcCommitGeometry)(mesh);
            (api.rtcAttachGeometryByID)(scene.as_ptr(), mesh, id);
            (api.rtcReleaseGeometry)(mesh);
        }
        Ok(())
    }

    /// Builds the acceleration structure of a scene with all geometries attached.
    fn commit(&self, scene: NonNull<c_void>) -> Result<(), Error> {
        // SAFETY: device and scene are alive, and so are the buffers of the scene (see `attach_triangles`).
        let code = unsafe {
            (self.api.rtcSetSceneFlags)(scene.as_ptr(), self.flags);
            (self.api.rtcSetSceneBuildQuality)(scene.as_ptr(), BUILD_QUALITY_MEDIUM);
            (self.api.rtcCommitScene)(scene.as_ptr());
            (self.api.rtcGetDeviceError)(self.device.as_ptr())
        };
        if code == 0 { Ok(()) } else { Err(self.error(code)) }
    }

    /// The last error of the library.
    fn failure(&self) -> Error {
        // SAFETY: the device is alive.
        self.error(unsafe { (self.api.rtcGetDeviceError)(self.device.as_ptr()) })
    }

    fn error(&self, code: c_int) -> Error {
        let (triangles, places) = (self.geometry.triangles().len(), self.geometry.placements().len());
        match (code, places) {
            (ERROR_OUT_OF_MEMORY, 0) => Error::OutOfMemory(format!("Embree, over {triangles} triangles")),
            (ERROR_OUT_OF_MEMORY, _) => {
                Error::OutOfMemory(format!("Embree, over {triangles} triangles and {places} instances"))
            }
            (code, _) => Error::Embree(format!("building failed with error code {code}")),
        }
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: all handles were created by `build` and are released once. The scenes are released first (the top
        // scene before the prototypes that it refers to); the buffers outlive them.
        unsafe {
            (self.api.rtcReleaseScene)(self.scene.as_ptr());
            for prototype in &self.prototypes {
                (self.api.rtcReleaseScene)(prototype.as_ptr());
            }
            (self.api.rtcReleaseDevice)(self.device.as_ptr());
        }
    }
}

/// Converts triangle indices within a prototype into indices into all triangles.
///
/// Not inlined, because scenes without placements do not need it.
#[inline(never)]
fn number_triangles(geometry: &Geometry, valid: &Lanes<i32>, packet: &mut RayHits) {
    let hits = &mut packet.hits;
    for lane in 0..LANES {
        let instance = hits.instance[lane];
        if valid.0[lane] != 0 && hits.triangle[lane] != NO_TRIANGLE && instance != FLATTENED {
            let prototype = geometry.placements()[instance as usize].prototype;
            hits.triangle[lane] += geometry.prototypes()[prototype as usize].start as u32;
        }
    }
}

/// The halves of a packet that have a valid lane, with the lanes' flags.
fn halves(valid: &Lanes<i32>) -> impl Iterator<Item = (usize, &[i32])> {
    valid.0.chunks(LANES / 2).enumerate().filter(|(_, valid)| valid.iter().any(|&lane| lane != 0))
}

impl Engine for Embree {
    #[inline]
    fn intersect(&self, valid: &Lanes<i32>, packet: &mut RayHits, coherence: Coherence) {
        let arguments = QueryArguments::new(coherence);
        if self.halves {
            for (half, valid) in halves(valid) {
                let mut rays = Half::of(packet, half);
                // SAFETY: as below, with `RTCRayHit8`; half of `valid` is aligned to 32 bytes.
                unsafe {
                    let rays = (&raw mut rays).cast();
                    (self.api.rtcIntersect8)(valid.as_ptr(), self.scene.as_ptr(), rays, &raw const arguments);
                }
                rays.write(packet, half);
            }
        } else {
            // SAFETY: the scene is committed; `valid` and `packet` have the size and alignment of Embree's types.
            unsafe {
                let packet: *mut RayHits = packet;
                (self.api.rtcIntersect16)(valid.0.as_ptr(), self.scene.as_ptr(), packet.cast(), &raw const arguments);
            }
        }
        if self.geometry.is_instanced() {
            number_triangles(&self.geometry, valid, packet);
        }
    }

    #[inline]
    fn occluded(&self, valid: &Lanes<i32>, rays: &mut Rays, coherence: Coherence) {
        let arguments = QueryArguments::new(coherence);
        if self.halves {
            for (half, valid) in halves(valid) {
                let mut of_half = Half::of_rays(rays, half);
                // SAFETY: as in `intersect`, with `RTCRay8` and half of `valid`.
                unsafe {
                    let of_half = (&raw mut of_half).cast();
                    (self.api.rtcOccluded8)(valid.as_ptr(), self.scene.as_ptr(), of_half, &raw const arguments);
                }
                of_half.write_ends(rays, half);
            }
            return;
        }
        // SAFETY: as in `intersect`, with `RTCRay16`.
        unsafe {
            let rays: *mut Rays = rays;
            (self.api.rtcOccluded16)(valid.0.as_ptr(), self.scene.as_ptr(), rays.cast(), &raw const arguments);
        }
    }

    #[cfg(feature = "bench")]
    fn intersect_singly(&self, valid: &Lanes<i32>, packet: &mut RayHits) {
        /// `RTCRayHit`: 96 bytes, one word per field.
        #[repr(C, align(16))]
        struct One([f32; 24]);
        let arguments = QueryArguments::new(Coherence::Coherent);
        for lane in (0..LANES).filter(|&lane| valid.0[lane] != 0) {
            let rays = &packet.rays;
            let mut one = One([0.0; 24]);
            for axis in 0..3 {
                one.0[axis] = rays.origin[axis][lane];
                one.0[4 + axis] = rays.direction[axis][lane];
            }
            one.0[3] = rays.near[lane];
            one.0[8] = rays.far[lane];
            one.0[9] = f32::from_bits(u32::MAX);
            one.0[18] = f32::from_bits(u32::MAX);
            one.0[19] = f32::from_bits(FLATTENED);
            // SAFETY: as in `intersect`, with `RTCRayHit`.
            unsafe {
                (self.api.rtcIntersect1)(self.scene.as_ptr(), (&raw mut one).cast(), &raw const arguments);
            }
            packet.rays.far[lane] = one.0[8];
            packet.hits.triangle[lane] = if one.0[18].to_bits() == u32::MAX { u32::MAX } else { one.0[17].to_bits() };
            packet.hits.instance[lane] = one.0[19].to_bits();
        }
        if self.geometry.is_instanced() {
            number_triangles(&self.geometry, valid, packet);
        }
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn library(&self) -> Option<&Path> {
        self.api.path.as_deref()
    }
}

#[cfg(test)]
mod tests;
