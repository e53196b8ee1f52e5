//! Vertex tangents of meshes that have none: MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008),
//! which glTF prescribes and which programs that bake normal maps use.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use rayon::prelude::*;

use crate::{Error, Mesh, Scene};

impl Scene {
    /// Adds tangents to the meshes that need them and have none: those with vertex normals and texture coordinates
    /// whose material has a normal map (of its clearcoat, too) or an anisotropic roughness. The loader
    /// of glTF files calls it. A mesh that is built in code and is not given tangents keeps the axes of its triangles,
    /// see [`Mesh::tangents`].
    ///
    /// Vertices whose triangles have different tangents (at the seams of mirrored coordinates) are duplicated.
    ///
    /// # Errors
    /// [`Error::BadScene`] for a scene that does not pass [`Scene::validate`]; an error of the algorithm, which is not
    /// known to occur.
    pub fn add_tangents(&mut self) -> Result<(), Error> {
        self.validate()?;
        let sets: Vec<Option<usize>> = self.materials.iter().map(crate::Material::tangent_set).collect();
        self.meshes.par_iter_mut().try_for_each(|mesh| match sets[mesh.material] {
            // Unwind safety: the algorithm only reads the mesh; no panic of it is known.
            Some(set) => catch_unwind(AssertUnwindSafe(|| add(mesh, set))).unwrap_or_else(|_| Err(failed("a mesh"))),
            None => Ok(()),
        })
    }
}

/// Adds the tangents of texture coordinate set `set`.
fn add(mesh: &mut Mesh, set: usize) -> Result<(), Error> {
    let has_coordinates = !coordinates(mesh, set).is_empty();
    if mesh.normals.is_empty() || !has_coordinates || !mesh.tangents.is_empty() || mesh.triangles.is_empty() {
        return Ok(());
    }
    let mut corners = Corners { mesh, set, tangents: vec![None; mesh.triangles.len()] };
    generate_tangents(&mut corners).map_err(|_| failed(&format!("mesh '{}'", holo_core::shown(&mesh.name))))?;
    let tangents = corners.tangents;
    split(mesh, &tangents);
    Ok(())
}

fn failed(at: &str) -> Error {
    Error::BadScene { at: at.to_owned(), what: "its tangents cannot be computed".into() }
}

fn coordinates(mesh: &Mesh, set: usize) -> &[[f32; 2]] {
    if set == 0 { &mesh.texture_coordinates } else { &mesh.second_texture_coordinates }
}

/// The corners of the triangles of a mesh with their tangents; `None` where the algorithm finds none.
struct Corners<'m> {
    mesh: &'m Mesh,
    set: usize,
    tangents: Vec<Option<[[f32; 4]; 3]>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)]
    }

    /// Up in the image is against v, and that is the direction of the bitangent in glTF.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let [u, v] = coordinates(self.mesh, self.set)[self.vertex(face, corner)];
        [u, -v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(space) = space else { return };
        self.tangents[face].get_or_insert([[0.0; 4]; 3])[corner] = space.tangent_encoded();
    }
}

/// Gives every vertex the tangent of its triangles, and duplicates those of which they have several. The first one
/// keeps the number of the vertex.
fn split(mesh: &mut Mesh, tangents: &[Option<[[f32; 4]; 3]>]) {
    let vertices = mesh.positions.len();
    let mut of_vertex: Vec<Option<[f32; 4]>> = vec![None; vertices];
    let mut copies: BTreeMap<(u32, [u32; 4]), u32> = BTreeMap::new();
    let mut sources = Vec::new();
    for (triangle, tangents) in mesh.triangles.iter_mut().zip(tangents) {
        let Some(tangents) = tangents else { continue };
        for (corner, tangent) in triangle.iter_mut().zip(tangents) {
            let normal = mesh.normals[*corner as usize];
            let tangent = across(*tangent, normal);
            let known = of_vertex[*corner as usize].get_or_insert(tangent);
            if *known != tangent {
                let copy = *copies.entry((*corner, tangent.map(f32::to_bits))).or_insert_with(|| {
                    sources.push((*corner as usize, tangent));
                    (vertices + sources.len() - 1) as u32
                });
                *corner = copy;
            }
        }
    }
    let normals = &mesh.normals;
    mesh.tangents = of_vertex.iter().zip(normals).map(|(t, &n)| t.unwrap_or_else(|| across([0.0; 4], n))).collect();
    mesh.tangents.extend(sources.iter().map(|(_, tangent)| *tangent));
    let from: Vec<usize> = sources.into_iter().map(|(vertex, _)| vertex).collect();
    repeat(&mut mesh.positions, &from);
    repeat(&mut mesh.normals, &from);
    repeat(&mut mesh.texture_coordinates, &from);
    repeat(&mut mesh.second_texture_coordinates, &from);
    repeat(&mut mesh.colors, &from);
}

fn repeat<T: Copy>(list: &mut Vec<T>, from: &[usize]) {
    if !list.is_empty() {
        list.extend(from.iter().map(|&vertex| list[vertex]).collect::<Vec<T>>());
    }
}

/// The tangent with unit length; any one across the normal where it vanishes or is not finite.
pub(crate) fn across(tangent: [f32; 4], normal: [f32; 3]) -> [f32; 4] {
    let [x, y, z, w] = tangent.map(f64::from);
    let length = (x * x + y * y + z * z).sqrt();
    let sign = if w < 0.0 { -1.0 } else { 1.0 };
    if length.is_finite() && length > 0.0 {
        let is_unit = (length - 1.0).abs() <= 1e-6;
        let unit = if is_unit { [x, y, z] } else { [x / length, y / length, z / length] };
        let [x, y, z] = unit.map(|x| x as f32);
        return [x, y, z, sign];
    }
    // The axis that is farthest from the normal, made perpendicular to it.
    let n = normal.map(f64::from);
    let least = (0..3).fold(0, |best, k| if n[k].abs() < n[best].abs() { k } else { best });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let perpendicular: [f64; 3] = std::array::from_fn(|k| axis[k] - n[least] * n[k]);
    let length = perpendicular.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = perpendicular.map(|x| (x / length) as f32);
    [x, y, z, sign]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, NormalMap, Texture, TextureInfo};

    #[test]
    fn tangents_have_unit_length() {
        assert_eq!(across([3.0, 0.0, -4.0, -2.0], [0.0, 1.0, 0.0]), [0.6, 0.0, -0.8, -1.0]);
        assert_eq!(across([0.0, 0.3, 0.4, 1.0], [1.0, 0.0, 0.0]), [0.0, 0.6, 0.8, 1.0]);
        for broken in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
            let normal = [0.36, 0.48, 0.8];
            let [x, y, z, sign] = across([broken[0], broken[1], broken[2], 1.0], normal);
            let along = x * normal[0] + y * normal[1] + z * normal[2];
            assert!(along.abs() < 1e-6 && (x * x + y * y + z * z - 1.0).abs() < 1e-6 && sign == 1.0, "{x} {y} {z}");
        }
    }

    /// A square in the plane z = 0 whose left half has mirrored coordinates: u grows away from the middle.
    fn mirrored_halves() -> Scene {
        let map = NormalMap { texture: TextureInfo::new(0), scale: 1.0 };
        let texture = Texture {
            name: String::new(),
            width: 1,
            height: 1,
            texels: vec![[128, 128, 255, 255]],
            wrap_u: crate::Wrap::Repeat,
            wrap_v: crate::Wrap::Repeat,
            filter: crate::Filter::Linear,
        };
        let x = [-1.0, 0.0, 1.0];
        let corners = |y: f32| x.map(|x| ([x, y, 0.0], [x.abs(), (1.0 - y) / 2.0]));
        let vertices = [corners(-1.0), corners(1.0)].concat();
        Scene {
            meshes: vec![Mesh {
                positions: vertices.iter().map(|v| v.0).collect(),
                normals: vec![[0.0, 0.0, 1.0]; 6],
                texture_coordinates: vertices.iter().map(|v| v.1).collect(),
                triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
                ..Mesh::default()
            }],
            materials: vec![Material { normal_map: Some(map), ..Material::default() }],
            textures: vec![texture],
            ..Scene::default()
        }
    }

    /// Tangents point along u, the bitangent `cross(normal, tangent) * w` up in the image; the seam is duplicated.
    #[test]
    fn mirrored_coordinates_have_mirrored_tangents() {
        let mut scene = mirrored_halves();
        scene.add_tangents().expect("a scene");
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions.len(), 8, "two vertices at the seam are there twice");
        scene.validate().expect("a valid scene");
        for triangle in &mesh.triangles {
            let left = triangle.iter().any(|&k| mesh.positions[k as usize][0] < 0.0);
            let side = if left { -1.0 } else { 1.0 };
            for &k in triangle {
                assert_eq!(mesh.tangents[k as usize], [side, 0.0, 0.0, side]);
            }
        }
        let again = scene.clone();
        scene.add_tangents().expect("a scene");
        assert_eq!(scene, again, "tangents that are there stay");
    }

    /// Only meshes that use them have tangents.
    #[test]
    fn plain_materials_need_no_tangents() {
        let mut scene = mirrored_halves();
        scene.materials[0].normal_map = None;
        scene.add_tangents().expect("a scene");
        assert!(scene.meshes[0].tangents.is_empty());
    }

    /// Degenerate and extreme triangles get tangents, too.
    #[test]
    fn any_finite_mesh_has_unit_tangents() {
        for scale in [0.0, 1e-40, 1e-20, 1e20, f32::MAX] {
            for coordinates in [0.0, 1e-38, 1.0, f32::MAX] {
                let mut scene = mirrored_halves();
                let mesh = &mut scene.meshes[0];
                mesh.positions.iter_mut().flatten().for_each(|x| *x *= scale);
                mesh.texture_coordinates.iter_mut().flatten().for_each(|x| *x *= coordinates);
                scene.add_tangents().expect("a scene");
                scene.validate().expect("a valid scene");
            }
        }
    }
}
