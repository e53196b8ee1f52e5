//! Vertices of a primitive in the pose of a node: morph targets, then the skin.

use super::accessors::{Checker, Use};
use super::handle::Handle;
use super::json::{Object, bad};
use super::poses::Weights;
use super::skins::Skin;
use super::values::PrimitiveValues;
use super::warnings::Warnings;
use crate::Error;
use crate::Transform;

/// A morph target with a weight that is not 0.
struct Morph {
    weight: f64,
    positions: Option<Handle>,
    normals: Option<Handle>,
    tangents: Option<Handle>,
}

/// What moves the vertices of a primitive, with validated accessors.
#[derive(Default)]
pub(super) struct Deformation {
    morphs: Vec<Morph>,
    /// The skin, and joints and weights of the vertices, four of each a set.
    skin: Option<(usize, Vec<(Handle, Handle)>)>,
}

/// Vertices that are moved.
pub(super) struct Vertices<'v> {
    pub(super) positions: &'v mut [[f32; 3]],
    /// One a vertex, or none.
    pub(super) normals: &'v mut [[f32; 3]],
    /// One a vertex, or none.
    pub(super) tangents: &'v mut [[f32; 4]],
    pub(super) triangles: &'v mut [[u32; 3]],
}

/// Validates the morph targets and the skin of a primitive that is shown with these `weights` and this `skin`.
pub(super) fn plan(
    primitive: &Object<'_>,
    accessors: &mut Checker<'_>,
    count: usize,
    (weights, skin): (&Weights, Option<usize>),
    warnings: &mut Warnings,
) -> Result<Deformation, Error> {
    let mut check = |object: &Object<'_>, key: &str, wanted: Use| -> Result<Option<Handle>, Error> {
        let Some(number) = object.index(key, "accessors", accessors.len())? else { return Ok(None) };
        let handle = accessors.check(number, wanted, &object.at(key))?;
        if handle.count == count {
            return Ok(Some(handle));
        }
        Err(bad(object.at(key), format!("has {} elements, POSITION has {count}", handle.count)))
    };
    let mut deformation = Deformation::default();
    for &(k, weight) in weights {
        let Some(target) = primitive.object_at("targets", k)? else { break };
        let positions = check(&target, "POSITION", Use::Positions)?;
        let normals = check(&target, "NORMAL", Use::Normals)?;
        let tangents = check(&target, "TANGENT", Use::Normals)?;
        target.each(|key, _| {
            if key.starts_with("TEXCOORD_") || key.starts_with("COLOR_") {
                warnings.note("morph targets of colors and texture coordinates are ignored", || target.at(key));
            }
        });
        deformation.morphs.push(Morph { weight, positions, normals, tangents });
    }
    let attributes = primitive.object("attributes")?;
    if let (Some(skin), Some(attributes)) = (skin, attributes) {
        let mut sets = Vec::new();
        while let Some(joints) = check(&attributes, &format!("JOINTS_{}", sets.len()), Use::Joints)? {
            let key = format!("WEIGHTS_{}", sets.len());
            let weights = check(&attributes, &key, Use::Weights)?.ok_or_else(|| attributes.missing(&key))?;
            sets.push((joints, weights));
        }
        if sets.is_empty() {
            let text = "the node has a skin, the primitive no joints: drawn with the transform of the node";
            warnings.note(text, || primitive.path().to_owned());
        } else {
            deformation.skin = Some((skin, sets));
        }
    }
    Ok(deformation)
}

impl Deformation {
    /// The skin that places the vertices in the world.
    pub(super) fn skin(&self) -> Option<usize> {
        self.skin.as_ref().map(|(skin, _)| *skin)
    }

    /// How often all vertices are read, beyond the first time.
    pub(super) fn passes(&self) -> usize {
        self.morphs.len() + self.skin.as_ref().map_or(0, |(_, sets)| sets.len())
    }

    /// Moves the vertices. Normals and tangents keep no particular length.
    pub(super) fn apply(
        &self,
        values: &PrimitiveValues<'_, '_>,
        skins: &[Option<Skin>],
        vertices: Vertices<'_>,
        at: &str,
    ) -> Result<(), Error> {
        let Vertices { positions, normals, tangents, triangles } = vertices;
        let mut along: Vec<[f32; 3]> = tangents.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
        let handles: [fn(&Morph) -> Option<Handle>; 3] = [|m| m.positions, |m| m.normals, |m| m.tangents];
        for (list, handle) in [&mut *positions, &mut *normals, &mut *along].into_iter().zip(handles) {
            if list.is_empty() || self.morphs.iter().all(|morph| handle(morph).is_none()) {
                continue;
            }
            let mut sums: Vec<[f64; 3]> = list.iter().map(|v| v.map(f64::from)).collect();
            for morph in &self.morphs {
                let Some(handle) = handle(morph) else { continue };
                for (sum, offset) in sums.iter_mut().zip(values.vectors(handle)?) {
                    sum.iter_mut().zip(offset).for_each(|(sum, x)| *sum += morph.weight * f64::from(x));
                }
            }
            list.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum.map(|x| x as f32));
        }
        for (tangent, [x, y, z]) in tangents.iter_mut().zip(along) {
            *tangent = [x, y, z, tangent[3]];
        }
        let Some((skin, sets)) = &self.skin else { return Ok(()) };
        let Some(Some(skin)) = skins.get(*skin) else { return Err(bad(at, "its skin was not loaded")) };
        let blended = blend(values, skin, sets, positions.len(), at)?;
        let mut mirrored = 0_usize;
        for (k, transform) in blended.into_iter().enumerate() {
            let mirrors = transform.determinant() < 0.0;
            mirrored += usize::from(mirrors);
            positions[k] = transform.point(positions[k].map(f64::from)).map(|x| x as f32);
            if let Some(normal) = normals.get_mut(k) {
                let [x, y, z] = transform.normal_columns();
                let n = normal.map(f64::from);
                // The inverse transpose is the cofactors over the determinant, of which only the sign matters.
                let sign = if mirrors { -1.0 } else { 1.0 };
                let turned: [f64; 3] = std::array::from_fn(|k| sign * (x[k] * n[0] + y[k] * n[1] + z[k] * n[2]));
                let largest = turned.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
                // Scaled, because the cofactors of small bodies underflow in single precision.
                *normal = turned.map(|x| if largest > 0.0 { (x / largest) as f32 } else { 0.0 });
            }
            if let Some([x, y, z, w]) = tangents.get_mut(k) {
                let turned = transform.vector([*x, *y, *z].map(f64::from));
                [*x, *y, *z] = turned.map(|x| x as f32);
                *w *= if mirrors { -1.0 } else { 1.0 };
            }
        }
        if mirrored * 2 > positions.len() {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(())
    }
}

/// For each vertex the weighted sum of the transforms of its joints.
fn blend(
    values: &PrimitiveValues<'_, '_>,
    skin: &Skin,
    sets: &[(Handle, Handle)],
    count: usize,
    at: &str,
) -> Result<Vec<Transform>, Error> {
    let zero = Transform { columns: [[0.0; 3]; 3], translation: [0.0; 3] };
    let mut sums = Vec::new();
    sums.try_reserve_exact(count).map_err(|_| bad(at, format!("{count} vertices do not fit into memory")))?;
    sums.resize(count, (zero, 0.0_f64));
    let mut first = vec![0_u16; count];
    for (set, &(joints, weights)) in sets.iter().enumerate() {
        for (k, (joints, weights)) in values.joints(joints)?.into_iter().zip(values.weights(weights)?).enumerate() {
            if set == 0 {
                first[k] = joints[0];
            }
            let (sum, total) = &mut sums[k];
            for (joint, weight) in joints.into_iter().zip(weights.map(f64::from)) {
                if weight > 0.0 && weight.is_finite() {
                    add(sum, joint_of(skin, joint, at)?, weight);
                    *total += weight;
                }
            }
        }
    }
    // Exporters round weights, so that their sum is not exactly 1. Vertices without weights follow their first joint.
    let mut blended = Vec::with_capacity(count);
    for ((sum, total), first) in sums.into_iter().zip(first) {
        blended.push(if total > 0.0 {
            Transform {
                columns: sum.columns.map(|column| column.map(|x| x / total)),
                translation: sum.translation.map(|x| x / total),
            }
        } else {
            *joint_of(skin, first, at)?
        });
    }
    Ok(blended)
}

fn joint_of<'s>(skin: &'s Skin, joint: u16, at: &str) -> Result<&'s Transform, Error> {
    skin.joints.get(usize::from(joint)).ok_or_else(|| {
        bad(at, format!("a vertex follows joint {joint}, but its skin has {} joints", skin.joints.len()))
    })
}

fn add(sum: &mut Transform, joint: &Transform, weight: f64) {
    let columns = sum.columns.iter_mut().flatten().zip(joint.columns.iter().flatten());
    let translation = sum.translation.iter_mut().zip(&joint.translation);
    columns.chain(translation).for_each(|(sum, x)| *sum += weight * x);
}
