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
    pub(super) weights: Option<Vec<f64>>,
}

impl MeshInPose {
    /// Whether the vertices may differ from those of the mesh as nodes without skin and weights show it.
    pub(super) fn is_posed(&self) -> bool {
        self.skin.is_some() || self.weights.is_some()
    }
}

/// The meshes of the scene before their primitives are read, in the order of the file.
pub(super) struct Poses {
    pub(super) list: Vec<MeshInPose>,
    /// For each node of the file the index of its mesh in the list.
    pub(super) of_node: Vec<Option<usize>>,
}

/// Mesh, skin and the bits of the weights. The order is that of the meshes in the file.
type Key = (usize, Option<usize>, Option<Vec<u64>>);

/// Collects the meshes that the nodes of the scene show, and those that no node shows.
pub(super) fn collect(root: &Object<'_>, nodes: &Nodes<'_>) -> Result<Poses, Error> {
    let meshes = root.objects("meshes")?;
    let skins = root.list("skins")?.len();
    let mut known: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    let mut shown = vec![false; meshes.len()];
    for placed in nodes.in_scene() {
        let node = placed.node;
        let Some(mesh) = node.index("mesh", "meshes", meshes.len())? else { continue };
        let skin = node.index("skin", "skins", skins)?;
        if placed.hidden {
            continue;
        }
        let mut weights = node.has("weights").then(|| self::weights(node)).transpose()?;
        // Exporters write weights of zero to the node of a mesh that has none.
        if weights.as_ref().is_some_and(|weights| is_zero(weights)) && is_zero(&self::weights(&meshes[mesh])?) {
            weights = None;
        }
        let bits = weights.map(|weights| weights.into_iter().map(f64::to_bits).collect());
        shown[mesh] = true;
        known.entry((mesh, skin, bits)).or_default().push(placed.index);
    }
    for (mesh, _) in shown.iter().enumerate().filter(|(_, shown)| !**shown) {
        known.insert((mesh, None, None), Vec::new());
    }
    let mut poses = Poses { list: Vec::with_capacity(known.len()), of_node: vec![None; nodes.nodes.len()] };
    for ((mesh, skin, bits), users) in known {
        users.into_iter().for_each(|node| poses.of_node[node] = Some(poses.list.len()));
        let weights = bits.map(|bits| bits.into_iter().map(f64::from_bits).collect());
        poses.list.push(MeshInPose { mesh, skin, weights });
    }
    Ok(poses)
}

/// The morph weights of a mesh or a node; empty if it has none.
pub(super) fn weights(object: &Object<'_>) -> Result<Vec<f64>, Error> {
    let number = |(k, value): (usize, &serde_json::Value)| {
        value.as_f64().ok_or_else(|| bad(format!("{}[{k}]", object.at("weights")), "must be a number"))
    };
    object.list("weights")?.iter().enumerate().map(number).collect()
}

fn is_zero(weights: &[f64]) -> bool {
    weights.iter().all(|&weight| weight == 0.0)
}
