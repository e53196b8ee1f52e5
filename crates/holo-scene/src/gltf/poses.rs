//! Which meshes of the file become meshes of the scene: one for every pose in which a node shows them.
//!
//! Nodes that show a mesh without a skin and with its own morph weights share it. A node with a skin, or with weights
//! of its own, has a mesh of its own, because vertices differ; nodes with the same skin and weights share that.

use std::collections::BTreeMap;

use super::json::{Object, bad};
use super::nodes::Nodes;
use crate::Error;

/// A mesh of the file in a pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MeshInPose {
    /// Its index in the file.
    pub(super) mesh: usize,
    pub(super) skin: Option<usize>,
    /// The morph weights of the node; `None`: those of the mesh.
    pub(super) weights: Option<Weights>,
}

/// The morph weights that are not 0, each with the number of its target.
pub(super) type Weights = Vec<(usize, f64)>;

impl MeshInPose {
    /// Whether the vertices may differ from those of the mesh as nodes without skin and weights show it.
    pub(super) fn is_posed(&self) -> bool {
        self.skin.is_some() || self.weights.is_some()
    }
}

/// The meshes of the scene before their primitives are read, in the order of the file.
pub(super) struct Poses {
    pub(super) list: Vec<MeshInPose>,
    /// The weights of the meshes of the file.
    pub(super) weights: Vec<Weights>,
    /// For each node of the file the index of its mesh in the list.
    pub(super) of_node: Vec<Option<usize>>,
}

/// Mesh, skin and the bits of the weights. The order is that of the meshes in the file.
type Key = (usize, Option<usize>, Option<Vec<(usize, u64)>>);

/// Collects the meshes that the nodes of the scene show, and those that no node shows.
pub(super) fn collect(root: &Object<'_>, nodes: &Nodes<'_>) -> Result<Poses, Error> {
    let meshes = root.objects("meshes")?;
    let skins = root.list("skins")?.len();
    let mut known: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    let mut shown = vec![false; meshes.len()];
    let own: Vec<Weights> = meshes.iter().map(weights).collect::<Result<_, Error>>()?;
    for placed in nodes.in_scene() {
        let node = placed.node;
        let Some(mesh) = node.index("mesh", "meshes", meshes.len())? else { continue };
        let skin = node.index("skin", "skins", skins)?;
        if placed.hidden {
            continue;
        }
        // Exporters write the weights of the mesh again, or zeros to the node of a mesh that has none.
        let weights = node.has("weights").then(|| weights(node)).transpose()?.filter(|weights| *weights != own[mesh]);
        let bits = weights.map(|weights| weights.into_iter().map(|(k, weight)| (k, weight.to_bits())).collect());
        shown[mesh] = true;
        known.entry((mesh, skin, bits)).or_default().push(placed.index);
    }
    for (mesh, _) in shown.iter().enumerate().filter(|(_, shown)| !**shown) {
        known.insert((mesh, None, None), Vec::new());
    }
    let (list, of_node) = (Vec::with_capacity(known.len()), vec![None; nodes.nodes.len()]);
    let mut poses = Poses { list, weights: own, of_node };
    for ((mesh, skin, bits), users) in known {
        users.into_iter().for_each(|node| poses.of_node[node] = Some(poses.list.len()));
        let weights = bits.map(|bits| bits.into_iter().map(|(k, bits)| (k, f64::from_bits(bits))).collect());
        poses.list.push(MeshInPose { mesh, skin, weights });
    }
    Ok(poses)
}

/// The morph weights of a mesh or a node.
fn weights(object: &Object<'_>) -> Result<Weights, Error> {
    let number = |(k, value): (usize, &serde_json::Value)| match value.as_f64() {
        Some(weight) => Ok((k, weight)),
        None => Err(bad(format!("{}[{k}]", object.at("weights")), "must be a number")),
    };
    let all = object.list("weights")?.iter().enumerate().map(number);
    all.filter(|weight| !matches!(weight, Ok((_, 0.0)))).collect()
}
