//! The node hierarchy: a forest, traversed without recursion, composed in f64.

use super::json::{Object, bad};
use super::warnings::Warnings;
use crate::Error;
use crate::Transform;

/// Maximum deviation of the last row of a matrix from 0 0 0 1, which allows for single-precision exporters.
const AFFINE_TOLERANCE: f64 = 1e-6;

/// The nodes of the file and their transforms in the loaded scene.
pub(super) struct Nodes<'f> {
    pub(super) nodes: Vec<Object<'f>>,
    /// Node to world; `None` for nodes that are not in the scene.
    pub(super) world: Vec<Option<Transform>>,
}

/// Reads the hierarchy of the default scene.
///
/// # Errors
/// Cycles, nodes with two parents, transforms that are not affine or overflow.
pub(super) fn load<'f>(root: &Object<'f>, warnings: &mut Warnings) -> Result<Nodes<'f>, Error> {
    let nodes = root.objects("nodes")?;
    let children: Vec<Vec<usize>> =
        nodes.iter().map(|node| node.indices("children", "nodes", nodes.len())).collect::<Result<_, Error>>()?;
    let parents = parents(&children)?;
    check_cycles(&children, &parents)?;
    let roots = roots(root, &parents, warnings)?;

    let mut world: Vec<Option<Transform>> = vec![None; nodes.len()];
    let mut open = Vec::new();
    for top in roots {
        world[top] = Some(local(&nodes[top], warnings)?);
        open.push(top);
        while let Some(parent) = open.pop() {
            let Some(outer) = world[parent] else { continue };
            for &child in &children[parent] {
                let composed = outer.after(&local(&nodes[child], warnings)?);
                if !composed.is_finite() {
                    return Err(bad(nodes[child].path(), "its transform overflows with those of its parents"));
                }
                world[child] = Some(composed);
                open.push(child);
            }
        }
    }
    Ok(Nodes { nodes, world })
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
    let roots = scene.indices("nodes", "nodes", parents.len())?;
    let mut seen = vec![false; parents.len()];
    for (k, &node) in roots.iter().enumerate() {
        let at = || format!("{}.nodes[{k}]", scene.path());
        if let Some(parent) = parents[node] {
            return Err(bad(at(), format!("nodes[{node}] is no root: it is a child of nodes[{parent}]")));
        }
        if std::mem::replace(&mut seen[node], true) {
            return Err(bad(at(), format!("lists nodes[{node}] again")));
        }
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
            let rotation = rotation.map_or(Ok([0.0, 0.0, 0.0, 1.0]), |rotation| {
                let largest = rotation.iter().fold(0.0_f64, |largest, q| largest.max(q.abs()));
                // Scaled first: squares of very large or small numbers overflow or underflow.
                if largest > 0.0 { Ok(rotation.map(|q| q / largest)) } else { Err(bad(node.at("rotation"), "is zero")) }
            })?;
            Transform::from_parts(translation.unwrap_or([0.0; 3]), rotation, scale.unwrap_or([1.0; 3]))
        }
    };
    if transform.is_finite() { Ok(transform) } else { Err(bad(node.path(), "its transform overflows")) }
}

/// From glTF's column-major order.
fn from_matrix(m: &[f64; 16]) -> Option<Transform> {
    let last_row = [m[3], m[7], m[11], m[15] - 1.0];
    let affine = last_row.iter().all(|x| x.abs() <= AFFINE_TOLERANCE);
    let columns = [[m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]]];
    affine.then_some(Transform { columns, translation: [m[12], m[13], m[14]] })
}
