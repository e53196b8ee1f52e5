//! Mesh primitives: triangles, strips and fans, indexed or not; one [`Mesh`] each.

use rayon::prelude::*;

use super::Limits;
use super::accessors::{Checker, Use};
use super::deform::{self, Deformation, Vertices};
use super::draco::{Stream, Triangles};
use super::extensions::DRACO;
use super::handle::Handle;
use super::json::{Object, bad};
use super::materials::{CoordinateSets, Materials};
use super::panic_guard;
use super::poses::{Poses, Weights};
use super::skins::Skin;
use super::values::{PrimitiveValues, Values};
use super::variants;
use super::warnings::Warnings;
use crate::Error;
use crate::Mesh;
use crate::scene::tangents;

/// Normals with a squared length this close to 1 are kept unchanged; others are normalized.
const UNIT_TOLERANCE: f64 = 1e-3;

/// The meshes of the scene, and for each entry of [`Poses::list`] the range of meshes of its primitives.
pub(super) struct Meshes {
    pub(super) meshes: Vec<Mesh>,
    pub(super) ranges: Vec<std::ops::Range<usize>>,
    /// For each mesh of the scene the skin that has placed its vertices.
    pub(super) skins: Vec<Option<usize>>,
}

/// Validated primitives, before their values are read.
pub(super) struct Plans<'f> {
    plans: Vec<Plan<'f>>,
    ranges: Vec<std::ops::Range<usize>>,
}

/// What the primitives depend on beyond their own JSON.
pub(super) struct Context<'c> {
    pub(super) poses: &'c Poses,
    pub(super) limits: &'c Limits,
    /// The chosen variant of `KHR_materials_variants`.
    pub(super) variant: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    /// The number of triangles of `count` vertices. An incomplete triangle is ignored, as by a GPU.
    fn triangles(self, count: usize) -> usize {
        match self {
            Self::Triangles => count / 3,
            Self::Strip | Self::Fan => count.saturating_sub(2),
        }
    }
}

/// A primitive with validated accessors, before its values are read.
struct Plan<'f> {
    at: String,
    name: String,
    mode: Mode,
    material: usize,
    positions: Handle,
    normals: Option<Handle>,
    tangents: Option<Handle>,
    coordinates: [Option<Handle>; 2],
    colors: Option<Handle>,
    indices: Option<Handle>,
    draco: Option<Stream<'f>>,
    deformation: Deformation,
}

/// Validates all primitives of the meshes of the scene.
pub(super) fn plan_all<'f>(
    root: &Object<'_>,
    accessors: &mut Checker<'f>,
    materials: &mut Materials,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Plans<'f>, Error> {
    let limits = context.limits;
    let material_count = materials.materials.len();
    let mut default_material = None;
    let (mut plans, mut ranges) = (Vec::new(), Vec::new());
    let (mut vertices, mut triangles, mut posed) = (0_u64, 0_u64, 0_usize);
    let meshes = root.objects("meshes")?;
    for pose in &context.poses.list {
        let mesh = &meshes[pose.mesh];
        let first = plans.len();
        let name = mesh.name()?;
        let primitives = mesh.objects("primitives")?;
        let weights = pose.weights.as_ref().unwrap_or(&context.poses.weights[pose.mesh]);
        for (k, primitive) in primitives.iter().enumerate() {
            posed += usize::from(pose.is_posed());
            let Some(mode) = mode(primitive, warnings)? else { continue };
            let material = match variants::material(primitive, context.variant, material_count)? {
                Some(material) => material,
                None => *default_material.get_or_insert_with(|| materials.default_material()),
            };
            let name = if primitives.len() > 1 && !name.is_empty() { format!("{name}[{k}]") } else { name.to_owned() };
            let sets = &materials.coordinate_sets[material];
            let deformed = (weights, pose.skin);
            let tangents = materials.materials[material].tangent_set().is_some();
            let plan = plan(primitive, accessors, (name, mode, material), (sets, tangents, deformed), warnings)?;
            let Some(plan) = plan else { continue };
            vertices = vertices.saturating_add(plan.vertices_read());
            triangles += plan.mode.triangles(plan.indices.unwrap_or(plan.positions).count) as u64;
            // Many primitives may share one accessor, so a small file can require more memory than it has bytes.
            if vertices > limits.max_vertices || triangles > limits.max_triangles || posed > limits.max_instances {
                let (v, t) = (limits.max_vertices, limits.max_triangles);
                return Err(bad(&plan.at, format!("the meshes exceed the limit of {t} triangles or {v} vertices")));
            }
            plans.push(plan);
        }
        ranges.push(first..plans.len());
    }
    Ok(Plans { plans, ranges })
}

impl Plans<'_> {
    /// Reads the meshes.
    pub(super) fn read(
        self,
        values: &Values<'_>,
        skins: &[Option<Skin>],
        warnings: &mut Warnings,
    ) -> Result<Meshes, Error> {
        let read: Vec<(Mesh, Warnings)> = self
            .plans
            .par_iter()
            .map(|plan| panic_guard::guarded(|| plan.read(values, skins)))
            .collect::<Result<_, Error>>()?;
        let mut meshes = Vec::with_capacity(read.len());
        for (mesh, its_warnings) in read {
            meshes.push(mesh);
            warnings.append(its_warnings);
        }
        let skins = self.plans.iter().map(|plan| plan.deformation.skin()).collect();
        Ok(Meshes { meshes, ranges: self.ranges, skins })
    }
}

fn mode(primitive: &Object<'_>, warnings: &mut Warnings) -> Result<Option<Mode>, Error> {
    Ok(match primitive.unsigned("mode")? {
        None | Some(4) => Some(Mode::Triangles),
        Some(5) => Some(Mode::Strip),
        Some(6) => Some(Mode::Fan),
        Some(0..=3) => {
            warnings.note("points and lines have no surface: left out", || primitive.path().to_owned());
            None
        }
        Some(other) => return Err(bad(primitive.at("mode"), format!("is {other}, which is no mode of glTF"))),
    })
}

fn plan<'f>(
    primitive: &Object<'_>,
    accessors: &mut Checker<'f>,
    (name, mode, material): (String, Mode, usize),
    (sets, with_tangents, deformed): (&CoordinateSets, bool, (&Weights, Option<usize>)),
    warnings: &mut Warnings,
) -> Result<Option<Plan<'f>>, Error> {
    let attributes = primitive.object("attributes")?.ok_or_else(|| primitive.missing("attributes"))?;
    let count = accessors.len();
    let mut handle = |object: &Object<'_>, key: &str, wanted: Use| -> Result<Option<Handle>, Error> {
        let Some(number) = object.index(key, "accessors", count)? else { return Ok(None) };
        accessors.check(number, wanted, &object.at(key)).map(Some)
    };
    let Some(positions) = handle(&attributes, "POSITION", Use::Positions)? else {
        warnings.note("a primitive without positions is left out", || primitive.path().to_owned());
        return Ok(None);
    };
    let normals = handle(&attributes, "NORMAL", Use::Normals)?;
    // Without normals, glTF wants tangents to be ignored.
    let with_tangents = with_tangents && normals.is_some();
    let tangents = if with_tangents { handle(&attributes, "TANGENT", Use::Tangents)? } else { None };
    let mut coordinates = [None; 2];
    for (coordinates, set) in coordinates.iter_mut().zip(sets.numbers) {
        *coordinates = handle(&attributes, &format!("TEXCOORD_{set}"), Use::TextureCoordinates)?;
    }
    let colors = handle(&attributes, "COLOR_0", Use::Colors)?;
    let indices = handle(primitive, "indices", Use::Indices)?;
    let [first, second] = coordinates;
    let others = [("TEXCOORD", first), ("TEXCOORD", second), ("COLOR_0", colors)];
    for (key, attribute) in [("NORMAL", normals), ("TANGENT", tangents)].into_iter().chain(others) {
        if let Some(attribute) = attribute.filter(|attribute| attribute.count != positions.count) {
            let what = format!("{key} has {} elements, POSITION has {}", attribute.count, positions.count);
            return Err(bad(attributes.path(), what));
        }
    }
    let draco = match primitive.extension(DRACO)? {
        Some(extension) if mode == Mode::Fan || indices.is_none() => {
            return Err(bad(extension.path(), "needs a primitive of triangles or a strip, with indices"));
        }
        Some(extension) => Stream::new(&extension, &attributes, accessors)?,
        None => None,
    };
    let at = || primitive.path().to_owned();
    if coordinates.iter().zip(sets.wanted).any(|(coordinates, wanted)| wanted && coordinates.is_none()) {
        warnings.note("the material has a texture, the primitive no coordinates for it: its first texel is used", at);
    }
    let corners = indices.unwrap_or(positions).count;
    if corners < 3 || (mode == Mode::Triangles && corners % 3 != 0) {
        warnings.note("the corners do not make whole triangles: the rest is left out", at);
    }
    let deformation = deform::plan(primitive, accessors, positions.count, deformed, warnings)?;
    Ok(Some(Plan {
        at: at(),
        name,
        mode,
        material,
        positions,
        normals,
        tangents,
        coordinates,
        colors,
        indices,
        draco,
        deformation,
    }))
}

impl Plan<'_> {
    /// How many vertices are read, each pass of a morph target or a skin counted.
    fn vertices_read(&self) -> u64 {
        (self.positions.count as u64).saturating_mul(1 + self.deformation.passes() as u64)
    }

    fn read(&self, values: &Values<'_>, skins: &[Option<Skin>]) -> Result<(Mesh, Warnings), Error> {
        let mut warnings = Warnings::default();
        let number = self.mode.triangles(self.indices.unwrap_or(self.positions).count);
        // A strip has at least two indices more than triangles; where it begins anew, it has more.
        let is_strip = self.mode == Mode::Strip;
        let triangles = if is_strip { Triangles::AtMost(number) } else { Triangles::Exactly(number) };
        let decode = |stream| Stream::decode(stream, self.positions.count, triangles);
        let decoded = self.draco.as_ref().map(decode).transpose()?;
        let values = values.with(decoded.as_ref());
        let mut positions = values.vectors(self.positions)?;
        self.check_finite(&positions, self.positions, "POSITION")?;
        let mut triangles = self.triangles(&values, positions.len())?;
        let mut normals = self.normals.map(|handle| values.vectors(handle)).transpose()?.unwrap_or_default();
        let mut tangents = self.tangents.map(|handle| values.tangents(handle)).transpose()?.unwrap_or_default();
        if self.deformation.passes() > 0 {
            let (positions, normals, triangles) = (&mut *positions, &mut *normals, &mut *triangles);
            let vertices = Vertices { positions, normals, tangents: &mut tangents, triangles };
            self.deformation.apply(&values, skins, vertices, &self.at)?;
        }
        self.check_finite(&positions, self.positions, "POSITION, moved by morph targets and skin,")?;
        if !normalize(&mut normals, &positions, &triangles) {
            let text = "normals that are zero or not finite were replaced by those of the faces around";
            warnings.note(text, || self.at.clone());
        }
        // Any tangent does where the file has none.
        tangents.iter_mut().zip(&normals).for_each(|(tangent, normal)| *tangent = tangents::across(*tangent, *normal));
        let mut coordinates = [Vec::new(), Vec::new()];
        for (coordinates, handle) in coordinates.iter_mut().zip(self.coordinates) {
            let Some(handle) = handle else { continue };
            *coordinates = values.texture_coordinates(handle)?;
            self.check_finite(coordinates, handle, "TEXCOORD")?;
        }
        let [texture_coordinates, second_texture_coordinates] = coordinates;
        let mut colors = self.colors.map(|handle| values.colors(handle)).transpose()?.unwrap_or_default();
        if let Some(handle) = self.colors {
            self.check_finite(&colors, handle, "COLOR_0")?;
            // Required by the specification, and for energy conservation.
            colors.iter_mut().flatten().for_each(|c| *c = c.clamp(0.0, 1.0));
        }
        let (name, material) = (self.name.clone(), self.material);
        Ok((
            Mesh {
                name,
                positions,
                normals,
                tangents,
                texture_coordinates,
                second_texture_coordinates,
                colors,
                triangles,
                material,
            },
            warnings,
        ))
    }

    fn check_finite<const N: usize>(&self, list: &[[f32; N]], handle: Handle, key: &str) -> Result<(), Error> {
        match list.iter().position(|element| element.iter().any(|x| !x.is_finite())) {
            None => Ok(()),
            Some(k) => {
                let what = format!("element {k} is {:?} ({key} of {}): repair the mesh", list[k], self.at);
                Err(bad(format!("accessors[{}]", handle.number), what))
            }
        }
    }

    fn triangles(&self, values: &PrimitiveValues<'_, '_>, vertices: usize) -> Result<Vec<[u32; 3]>, Error> {
        let Some(indices) = self.indices else {
            return self.assemble(&mut (0..vertices as u32), vertices);
        };
        let triangles = match values.triangles() {
            Some(triangles) => triangles?,
            None => values.with_indices(indices, |corners| self.assemble(corners, indices.count))??,
        };
        // The first pass finds the largest index; it is reported only if it is out of range.
        let largest = triangles.iter().flatten().copied().max().unwrap_or(0);
        if largest as usize >= vertices {
            let what = format!("refers to vertex {largest}, but {} has {vertices} vertices", self.at);
            return Err(bad(format!("accessors[{}]", indices.number), what));
        }
        Ok(triangles)
    }

    /// Assembles vertices to triangles in the order of the specification.
    fn assemble(&self, corners: &mut dyn Iterator<Item = u32>, count: usize) -> Result<Vec<[u32; 3]>, Error> {
        let mut triangles = Vec::new();
        let number = self.mode.triangles(count);
        triangles
            .try_reserve_exact(number)
            .map_err(|_| bad(&self.at, format!("{number} triangles do not fit into memory")))?;
        let mut next = || corners.next();
        match self.mode {
            Mode::Triangles => {
                while let (Some(a), Some(b), Some(c)) = (next(), next(), next()) {
                    triangles.push([a, b, c]);
                }
            }
            Mode::Strip => {
                if let (Some(mut a), Some(mut b)) = (next(), next()) {
                    while let Some(c) = next() {
                        // Every second triangle of a strip has the opposite orientation.
                        triangles.push(if triangles.len() % 2 == 0 { [a, b, c] } else { [a, c, b] });
                        (a, b) = (b, c);
                    }
                }
            }
            Mode::Fan => {
                if let (Some(center), Some(mut b)) = (next(), next()) {
                    while let Some(c) = next() {
                        triangles.push([b, c, center]);
                        b = c;
                    }
                }
            }
        }
        Ok(triangles)
    }
}

/// Normalizes normals. Normals that are zero or not finite are replaced by the mean of the faces around their vertex;
/// the result is then `false`.
fn normalize(normals: &mut [[f32; 3]], positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> bool {
    let mut zeros = false;
    for normal in normals.iter_mut() {
        let squared = squared_length(normal.map(f64::from));
        // NaN fails the comparison.
        let is_unit = (squared - 1.0).abs() <= UNIT_TOLERANCE;
        if !is_unit {
            match unit(normal.map(f64::from)) {
                Some(unit) => *normal = unit,
                None => {
                    *normal = [0.0; 3];
                    zeros = true;
                }
            }
        }
    }
    if !zeros {
        return true;
    }
    let mut sums = vec![[0.0_f64; 3]; normals.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|k| positions[k as usize].map(f64::from));
        let (ab, ac) = (minus(b, a), minus(c, a));
        // Not normalized: weighted by area.
        let face = [ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]];
        for &k in triangle {
            sums[k as usize].iter_mut().zip(face).for_each(|(sum, x)| *sum += x);
        }
    }
    for (normal, sum) in normals.iter_mut().zip(sums).filter(|(normal, _)| **normal == [0.0; 3]) {
        // A vertex without faces, or with degenerate ones, is never visible.
        *normal = unit(sum).unwrap_or([0.0, 0.0, 1.0]);
    }
    false
}

fn unit(v: [f64; 3]) -> Option<[f32; 3]> {
    let length = squared_length(v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| (x / length) as f32))
}

fn squared_length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
