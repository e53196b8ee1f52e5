//! Skins in the pose of the nodes of the file.
//!
//! A vertex moves with its joints: by the sum, weighted, of joint node to world times inverse bind matrix. The transform
//! of the node that shows the mesh has no effect. Source: the glTF 2.0 specification, section 3.7.3.

use super::accessors::{Checker, Use};
use super::handle::Handle;
use super::json::{Object, bad};
use super::nodes::{Nodes, from_matrix};
use super::poses::Poses;
use super::values::Values;
use crate::Error;
use crate::Transform;

/// The numbers of joints have 16 bits.
const MAX_JOINTS: usize = 1 << 16;

/// A skin in the pose of the scene.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    /// For each joint, mesh coordinates to world coordinates minus [`Skin::origin`].
    pub(super) joints: Vec<Transform>,
    /// The place of the first joint in the world, m: vertices are single precision and count from here.
    pub(super) origin: [f64; 3],
}

/// A skin with validated accessors.
pub(super) struct SkinPlan {
    at: String,
    joints: Vec<usize>,
    matrices: Option<Handle>,
}

/// Validates the skins that meshes of the scene use.
pub(super) fn plan(
    root: &Object<'_>,
    poses: &Poses,
    accessors: &mut Checker<'_>,
) -> Result<Vec<Option<SkinPlan>>, Error> {
    let skins = root.objects("skins")?;
    let node_count = root.list("nodes")?.len();
    let mut used = vec![false; skins.len()];
    poses.list.iter().filter_map(|pose| pose.skin).for_each(|skin| used[skin] = true);
    let plan = |(skin, used): (&Object<'_>, bool)| {
        if !used {
            return Ok(None);
        }
        let joints = skin.indices("joints", "nodes", node_count)?;
        if joints.is_empty() || joints.len() > MAX_JOINTS {
            return Err(bad(skin.at("joints"), format!("has {} joints; it must have 1..{MAX_JOINTS}", joints.len())));
        }
        let matrices = match skin.index("inverseBindMatrices", "accessors", accessors.len())? {
            Some(number) => Some(accessors.check(number, Use::Matrices, &skin.at("inverseBindMatrices"))?),
            None => None,
        };
        if let Some(matrices) = matrices.filter(|matrices| matrices.count < joints.len()) {
            let what = format!("has {} matrices for {} joints", matrices.count, joints.len());
            return Err(bad(skin.at("inverseBindMatrices"), what));
        }
        Ok(Some(SkinPlan { at: skin.path().to_owned(), joints, matrices }))
    };
    skins.iter().zip(used).map(plan).collect()
}

/// Computes the matrices of the joints.
pub(super) fn load(
    plans: Vec<Option<SkinPlan>>,
    values: &Values<'_>,
    nodes: &Nodes<'_>,
) -> Result<Vec<Option<Skin>>, Error> {
    plans.into_iter().map(|plan| plan.map(|plan| plan.load(values, nodes)).transpose()).collect()
}

impl SkinPlan {
    fn load(&self, values: &Values<'_>, nodes: &Nodes<'_>) -> Result<Skin, Error> {
        // Skins may share a longer list.
        let needed = |handle| Handle { count: self.joints.len(), ..handle };
        let matrices = self.matrices.map(|handle| values.matrices(needed(handle))).transpose()?;
        let mut joints = Vec::with_capacity(self.joints.len());
        for (k, &node) in self.joints.iter().enumerate() {
            let at = || format!("{}.joints[{k}]", self.at);
            let world = nodes.joint(node).ok_or_else(|| bad(at(), "has no place in the world"))?;
            let inverse = match matrices.as_ref().and_then(|matrices| matrices.get(k)) {
                Some(matrix) => inverse_bind(matrix).ok_or_else(|| {
                    bad(
                        format!("{}.inverseBindMatrices", self.at),
                        format!("number {k} is not affine: repair the skin"),
                    )
                })?,
                None => Transform::IDENTITY,
            };
            let joint = world.after(&inverse);
            if !joint.is_finite() {
                return Err(bad(at(), "its transform overflows"));
            }
            joints.push(joint);
        }
        let origin = nodes.joint(self.joints[0]).map(|world| world.translation).unwrap_or_default();
        for joint in &mut joints {
            joint.translation = std::array::from_fn(|k| joint.translation[k] - origin[k]);
        }
        Ok(Skin { joints, origin })
    }
}

fn inverse_bind(columns: &[[f32; 4]; 4]) -> Option<Transform> {
    let mut matrix = [0.0; 16];
    matrix.iter_mut().zip(columns.iter().flatten()).for_each(|(out, x)| *out = f64::from(*x));
    from_matrix(&matrix).filter(Transform::is_finite)
}
