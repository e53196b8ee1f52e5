//! The node hierarchy: a forest, traversed without recursion, composed in f64.

use super::extensions::NODE_VISIBILITY;
use super::json::{Object, bad};
use super::warnings::Warnings;
use crate::Error;
use crate::Transform;

/// Maximum deviation of the last row of a matrix from 0 0 0 1, which allows for single-precision exporters.
const AFFINE_TOLERANCE: f64 = 1e-6;

/// The nodes of the file and their transforms in the loaded scene.
pub(super) struct Nodes<'f> {
    pub(super) nodes: Vec<Object<'f>>,
    /// Node to world; `None` for nodes that are neither in the scene nor joints of a skin.
    world: Vec<Option<Transform>>,
    /// Whether the node is in the scene.
    in_scene: Vec<bool>,
    /// Whether `KHR_node_visibility` hides the node or one of its ancestors.
    hidden: Vec<bool>,
}

impl<'f> Nodes<'f> {
    /// The nodes of the scene, in the order of the file.
    pub(super) fn in_scene(&self) -> impl Iterator<Item = Placed<'_, 'f>> {
        let all = self.nodes.iter().enumerate().filter(|&(k, _)| self.in_scene[k]);
        all.filter_map(|(index, node)| {
            Some(Placed { index, node, world: self.world[index]?, hidden: self.hidden[index] })
        })
    }

    /// The world transform of a joint of a skin.
    pub(super) fn joint(&self, node: usize) -> Option<Transform> {
        self.world.get(node).copied().flatten()
    }
}

/// A node of the scene.
pub(super) struct Placed<'n, 'f> {
    pub(super) index: usize,
    pub(super) node: &'n Object<'f>,
    /// Node to world.
    pub(super) world: Transform,
    /// Whether its meshes and lights are not drawn.
    pub(super) hidden: bool,
}

/// Reads the hierarchy of the default scene, and the transforms of the joints of all skins.
///
/// # Errors
/// Cycles, nodes with two parents, transforms that are not affine or overflow.
pub(super) fn load<'f>(root: &Object<'f>, warnings: &mut Warnings) -> Result<Nodes<'f>, Error> {
    let nodes = root.objects("nodes")?;
    let count = nodes.len();
    let children: Vec<Vec<usize>> =
        nodes.iter().map(|node| node.indices("children", "nodes", count)).collect::<Result<_, Error>>()?;
    let parents = parents(&children)?;
    check_cycles(&children, &parents)?;

    let mut in_scene = vec![false; count];
    let tops = roots(root, &parents, warnings)?;
    let mut open = tops.clone();
    // Joints may lie outside of the scene.
    let mut needed = vec![false; count];
    for skin in root.objects("skins")? {
        skin.indices("joints", "nodes", count)?
            .into_iter()
            .for_each(|joint| mark_with_ancestors(joint, &parents, &mut needed));
    }
    open.iter().for_each(|&top| mark_with_ancestors(top, &parents, &mut needed));
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut in_scene[node], true) {
            needed[node] = true;
            open.extend(&children[node]);
        }
    }

    let mut world: Vec<Option<Transform>> = vec![None; count];
    let mut hidden = vec![false; count];
    let mut open: Vec<usize> = (0..count).filter(|&k| parents[k].is_none() && needed[k]).collect();
    while let Some(node) = open.pop() {
        let own = local(&nodes[node], warnings)?;
        let outer = parents[node].and_then(|parent| Some((world[parent]?, hidden[parent])));
        let composed = outer.map_or(own, |(outer, _)| outer.after(&own));
        if !composed.is_finite() {
            return Err(bad(nodes[node].path(), "its transform overflows with those of its parents"));
        }
        world[node] = Some(composed);
        hidden[node] = outer.is_some_and(|(_, hidden)| hidden) || !is_visible(&nodes[node])?;
        open.extend(children[node].iter().copied().filter(|&child| needed[child]));
    }
    // Some exporters list a child among the roots of the scene. Blender draws it once, below its parent; three.js once,
    // without the parent.
    for &top in &tops {
        if parents[top].and_then(|parent| world[parent]).is_some_and(|outer| outer != Transform::IDENTITY) {
            warnings.note("is a root of the scene and the child of a node: drawn once, as that child", || {
                nodes[top].path().to_owned()
            });
        }
    }
    Ok(Nodes { nodes, world, in_scene, hidden })
}

fn is_visible(node: &Object<'_>) -> Result<bool, Error> {
    let Some(extension) = node.extension(NODE_VISIBILITY)? else { return Ok(true) };
    Ok(extension.boolean("visible")?.unwrap_or(true))
}

/// Marks a node and its ancestors. Ancestors of a marked node are marked already.
fn mark_with_ancestors(node: usize, parents: &[Option<usize>], marked: &mut [bool]) {
    let mut next = Some(node);
    while let Some(node) = next.filter(|&node| !std::mem::replace(&mut marked[node], true)) {
        next = parents[node];
    }
}

fn parents(children: &[Vec<usize>]) -> Result<Vec<Option<usize>>, Error> {
    let mut parents: Vec<Option<usize>> = vec![None; children.len()];
    for (parent, children) in children.iter().enumerate() {
        for &child in children {
            if let Some(other) = parents[child] {
                let what = format!("is a child of nodes[{other}] and again of nodes[{parent}]; a node has one parent");
                return Err(bad(format!("nodes[{child}]"), what));
            }
            parents[child] = Some(parent);
        }
    }
    Ok(parents)
}

/// Every node has at most one parent, so nodes that cannot be reached from a root are in a cycle or behind one.
fn check_cycles(children: &[Vec<usize>], parents: &[Option<usize>]) -> Result<(), Error> {
    let mut reached = vec![false; children.len()];
    let mut open: Vec<usize> = (0..children.len()).filter(|&k| parents[k].is_none()).collect();
    while let Some(node) = open.pop() {
        reached[node] = true;
        open.extend(&children[node]);
    }
    match reached.iter().position(|reached| !reached) {
        Some(node) => Err(bad(format!("nodes[{node}]"), "lies in a cycle: it is its own ancestor or a child of one")),
        None => Ok(()),
    }
}

/// The roots of the loaded scene: of the default scene, else of the first, else all nodes without a parent.
fn roots(root: &Object<'_>, parents: &[Option<usize>], warnings: &mut Warnings) -> Result<Vec<usize>, Error> {
    let scenes = root.objects("scenes")?;
    let shown = root.index("scene", "scenes", scenes.len())?;
    if scenes.len() > 1 {
        let others = scenes.len() - 1;
        let text = format!("only scenes[{}] is loaded; {others} more are left out", shown.unwrap_or(0));
        warnings.note(&text, String::new);
    }
    let Some(scene) = scenes.get(shown.unwrap_or(0)) else {
        return Ok((0..parents.len()).filter(|&k| parents[k].is_none()).collect());
    };
    let mut roots = scene.indices("nodes", "nodes", parents.len())?;
    let listed = roots.len();
    roots.sort_unstable();
    roots.dedup();
    if roots.len() < listed {
        warnings.note("the scene lists a node twice: drawn once", || scene.path().to_owned());
    }
    Ok(roots)
}

/// The local transform of a node.
fn local(node: &Object<'_>, warnings: &mut Warnings) -> Result<Transform, Error> {
    let translation = node.numbers::<3>("translation")?;
    let rotation = node.numbers::<4>("rotation")?;
    let scale = node.numbers::<3>("scale")?;
    let transform = match node.numbers::<16>("matrix")? {
        Some(matrix) => {
            if translation.is_some() || rotation.is_some() || scale.is_some() {
                warnings.note("has a matrix and separate parts: the matrix is used", || node.path().to_owned());
            }
            from_matrix(&matrix).ok_or_else(|| bad(node.at("matrix"), "its last row must be 0 0 0 1"))?
        }
        None => {
            let rotation = rotation.map_or([0.0, 0.0, 0.0, 1.0], |rotation| {
                let largest = rotation.iter().fold(0.0_f64, |largest, q| largest.max(q.abs()));
                // Scaled first: squares of very large or small numbers overflow or underflow.
                if largest > 0.0 { rotation.map(|q| q / largest) } else { rotation }
            });
            if rotation == [0.0; 4] {
                warnings.note("has a rotation of length zero: drawn without", || node.path().to_owned());
            }
            Transform::from_parts(translation.unwrap_or([0.0; 3]), rotation, scale.unwrap_or([1.0; 3]))
        }
    };
    if transform.is_finite() { Ok(transform) } else { Err(bad(node.path(), "its transform overflows")) }
}

/// From glTF's column-major order.
pub(super) fn from_matrix(m: &[f64; 16]) -> Option<Transform> {
    let last_row = [m[3], m[7], m[11], m[15] - 1.0];
    let affine = last_row.iter().all(|x| x.abs() <= AFFINE_TOLERANCE);
    let columns = [[m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]]];
    affine.then_some(Transform { columns, translation: [m[12], m[13], m[14]] })
}
