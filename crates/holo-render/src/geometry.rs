//! The geometry of the scene for ray tracing: one list of triangles in camera coordinates.
//!
//! If the engine supports instances and a mesh is repeated often enough ([`instancing`]), the mesh is a prototype: it
//! is stored once, in mesh coordinates, after the flattened triangles in the same list. Each placement of it is an
//! affine map to camera coordinates ([`placement`]). A [`Hit`] identifies a triangle and a placement.
//!
//! The center of the rig is subtracted in f64 before positions are rounded to f32, and the world is rotated into the
//! frame of the camera. Rays therefore start near the origin, and the ray parameter is planar depth. A rig with a
//! baseline of 10 um at the world coordinate 1e6 m sees the same scene as one at the origin.

mod instancing;
mod placement;

use std::ops::Range;

use rayon::prelude::*;

pub(crate) use instancing::Instancing;
pub(crate) use placement::Placement;

use crate::error::Error;
use holo_scene::{Mesh, Scene, Transform};

/// The upper bound of coordinates, m.
pub(crate) const MAX_COORDINATE_M: f64 = 1e18;

/// The placement of flattened triangles.
pub(crate) const FLATTENED: u32 = u32::MAX;

/// A triangle, and its placement if it belongs to a prototype.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hit {
    pub triangle: u32,
    /// Index into [`Geometry::placements`], or [`FLATTENED`].
    pub placement: u32,
}

impl Hit {
    pub fn flattened(triangle: usize) -> Self {
        Self { triangle: triangle as u32, placement: FLATTENED }
    }
}

/// The triangles of all instances in camera coordinates (right-handed, +Y up, the camera looks along -Z), m, followed
/// by the triangles of the prototypes in mesh coordinates.
pub(crate) struct Geometry {
    /// Positions for the ray tracing engines. The last entry is padding: Embree reads 16 bytes of every vertex.
    positions: Vec<[f32; 3]>,
    /// Indices into the vertex arrays.
    triangles: Vec<[u32; 3]>,
    /// The data that hits need, in the order of `triangles`.
    records: Vec<TriangleRecord>,
    /// Unit vertex normals; zero where the mesh has none.
    normals: Vec<[f32; 3]>,
    /// The two sets of texture coordinates.
    texture_coordinates: [Vec<[f32; 2]>; 2],
    colors: Vec<[f32; 4]>,
    /// Unit vertex tangents with the signs of their bitangents, of the meshes that have some alone.
    tangents: Vec<[f32; 4]>,
    /// The flattened instances, then those of `placements`.
    instances: Vec<InstanceData>,
    /// The number of flattened triangles.
    flattened: usize,
    /// The range of triangles of every prototype.
    prototypes: Vec<Range<usize>>,
    /// The placements of the prototypes.
    placements: Vec<Placement>,
}

/// The triangle record that hits read: one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct TriangleRecord {
    plane: Plane,
    /// Indices into the vertex arrays.
    corners: [u32; 3],
    /// Index into the instances; without meaning for prototypes.
    instance: u32,
    /// The largest coordinate of the corners.
    extent: f32,
}

/// A plane `normal . x = offset`, from f64 positions. The normal has length 1, or 0 for a triangle without area; it
/// points to the side from which the triangle is counter-clockwise.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plane {
    pub normal: [f64; 3],
    pub offset: f64,
}

/// What the triangles of one instance have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InstanceData {
    pub material: u32,
    /// Index into [`Scene::instances`].
    pub object: u32,
    pub smooth: bool,
    /// Which of the two sets of texture coordinates the mesh has.
    pub textured: [bool; 2],
    pub colored: bool,
    /// What is added to the number of a vertex to get that of its tangent, modulo 2^32; `None` without tangents.
    tangents: Option<u32>,
}

fn bad_scene(at: String, what: String) -> Error {
    Error::Scene(holo_scene::Error::BadScene { at, what })
}

/// The group of item number `index` of `count`, of at most `groups`: a group for every item, or for runs of neighbors where
/// there are more items.
#[inline(always)]
fn group(index: u32, count: usize, groups: u32) -> u32 {
    if count <= groups as usize { index } else { (u64::from(index) * u64::from(groups) / count as u64) as u32 }
}

impl Geometry {
    /// Transforms `scene` to the frame of a camera at `pose`.
    pub fn build(scene: &Scene, pose: &Transform, instancing: Instancing) -> Result<Self, Error> {
        let too_many = |what: &str, count: usize| {
            bad_scene("scene".into(), format!("{count} {what} in the world; at most {} fit", u32::MAX - 1))
        };
        let plan = instancing::plan(scene, pose, instancing);
        let has_placement = |object: &usize| plan.placements[*object].is_some();
        let objects = || 0..scene.instances.len();
        let mesh_of = |object: usize| &scene.meshes[scene.instances[object].mesh];
        let flattened: Vec<usize> = objects().filter(|object| !has_placement(object)).collect();
        let placed: Vec<usize> = objects().filter(has_placement).collect();
        let prototypes: Vec<&Mesh> = plan.prototypes.iter().map(|&mesh| &scene.meshes[mesh]).collect();
        let meshes = || flattened.iter().map(|&object| mesh_of(object)).chain(prototypes.iter().copied());
        let vertex_count = meshes().map(|m| m.positions.len()).fold(0usize, usize::saturating_add);
        let triangle_count = meshes().map(|m| m.triangles.len()).fold(0usize, usize::saturating_add);
        let flattened_count: usize = flattened.iter().map(|&object| mesh_of(object).triangles.len()).sum();
        if vertex_count >= u32::MAX as usize {
            return Err(too_many("vertices", vertex_count));
        }
        if triangle_count >= u32::MAX as usize {
            return Err(too_many("triangles", triangle_count));
        }
        if scene.instances.len() >= u32::MAX as usize {
            return Err(too_many("instances", scene.instances.len()));
        }
        let any = |f: fn(&Mesh) -> bool| meshes().any(f);
        let per_vertex = |wanted: bool| if wanted { vertex_count } else { 0 };
        let with_normals = any(|m| !m.normals.is_empty());
        let with_coordinates = any(|m| !m.texture_coordinates.is_empty());
        let with_second = any(|m| !m.second_texture_coordinates.is_empty());
        let with_colors = any(|m| !m.colors.is_empty());
        let with = [with_normals, with_coordinates, with_second, with_colors];
        let mut geometry = Self {
            positions: Vec::with_capacity(vertex_count + 1),
            triangles: Vec::with_capacity(triangle_count),
            records: Vec::with_capacity(triangle_count),
            normals: Vec::with_capacity(per_vertex(with_normals)),
            texture_coordinates: [with_coordinates, with_second].map(|wanted| Vec::with_capacity(per_vertex(wanted))),
            colors: Vec::with_capacity(per_vertex(with_colors)),
            tangents: Vec::new(),
            instances: Vec::with_capacity(scene.instances.len()),
            flattened: flattened_count,
            prototypes: Vec::with_capacity(prototypes.len()),
            placements: Vec::new(),
        };
        for object in flattened {
            let transform = &scene.instances[object].transform;
            let tangents = geometry.append(mesh_of(object), &to_camera(transform, pose), with)?;
            geometry.instances.push(InstanceData { tangents, ..InstanceData::new(mesh_of(object), object) });
        }
        let mut tangents_of = Vec::with_capacity(prototypes.len());
        for &mesh in &prototypes {
            let first = geometry.triangles.len();
            tangents_of.push(geometry.append(mesh, &Transform::IDENTITY, with)?);
            geometry.prototypes.push(first..geometry.triangles.len());
        }
        geometry.positions.push([0.0; 3]);
        geometry.placements = plan.placements.into_iter().flatten().collect();
        let instances = placed.into_iter().zip(&geometry.placements).map(|(object, placement)| InstanceData {
            tangents: tangents_of[placement.prototype as usize],
            ..InstanceData::new(mesh_of(object), object)
        });
        geometry.instances.extend(instances);
        Ok(geometry)
    }

    /// Appends the vertices and triangles of a mesh; returns [`InstanceData::tangents`].
    fn append(&mut self, mesh: &Mesh, to_camera: &Transform, with: [bool; 4]) -> Result<Option<u32>, Error> {
        let first_vertex = self.positions.len() as u32;
        let exact: Vec<[f64; 3]> = mesh.positions.par_iter().map(|p| to_camera.point(p.map(f64::from))).collect();
        // Larger squares and products would overflow f32 inside a ray tracing engine.
        if let Some(bad) = exact.par_iter().flatten().find_any(|x| x.is_nan() || x.abs() >= MAX_COORDINATE_M) {
            let what = format!("a vertex is {bad:e} m from the camera; coordinates must stay below 1e18 m");
            return Err(bad_scene(format!("mesh '{}'", holo_core::shown(&mesh.name)), what));
        }
        self.positions.par_extend(exact.par_iter().map(|p| p.map(|x| x as f32)));
        // A mirroring map reverses the orientation of triangles; swapping two corners restores it.
        let mirrored = to_camera.determinant() < 0.0;
        let order = if mirrored { [0, 2, 1] } else { [0, 1, 2] };
        self.triangles.par_extend(mesh.triangles.par_iter().map(|t| order.map(|k| t[k] + first_vertex)));
        let instance = self.instances.len() as u32;
        self.records.par_extend(mesh.triangles.par_iter().map(|t| TriangleRecord {
            plane: Plane::through(order.map(|k| exact[t[k] as usize])),
            corners: order.map(|k| t[k] + first_vertex),
            instance,
            extent: t.iter().flat_map(|&k| exact[k as usize]).fold(0.0, |largest, x| x.abs().max(largest)) as f32,
        }));
        let [with_normals, with_coordinates, with_second, with_colors] = with;
        if with_normals {
            let columns = to_camera.normal_columns();
            // The cofactor matrix of a mirroring map also reverses normals; the sign restores them.
            let sign = if mirrored { -1.0 } else { 1.0 };
            let normal_map = Transform { columns, translation: [0.0; 3] };
            let turn = |n: &[f32; 3]| {
                let n = glam::DVec3::from(normal_map.vector(n.map(f64::from))) * sign;
                n.normalize_or_zero().as_vec3().to_array()
            };
            if mesh.normals.is_empty() {
                self.normals.resize(self.positions.len(), [0.0; 3]);
            } else {
                self.normals.par_extend(mesh.normals.par_iter().map(turn));
            }
        }
        let sets = [(with_coordinates, &mesh.texture_coordinates), (with_second, &mesh.second_texture_coordinates)];
        for (all, (_, own)) in self.texture_coordinates.iter_mut().zip(sets).filter(|(_, (with, _))| *with) {
            all.extend_from_slice(own);
            all.resize(self.positions.len(), [0.0; 2]);
        }
        if with_colors {
            self.colors.extend_from_slice(&mesh.colors);
            self.colors.resize(self.positions.len(), [1.0; 4]);
        }
        Ok(self.append_tangents(mesh, to_camera, first_vertex))
    }

    fn append_tangents(&mut self, mesh: &Mesh, to_camera: &Transform, first_vertex: u32) -> Option<u32> {
        if mesh.tangents.is_empty() || mesh.normals.is_empty() {
            return None;
        }
        let first = self.tangents.len() as u32;
        // A mirroring map also reverses cross products.
        let sign = if to_camera.determinant() < 0.0 { -1.0 } else { 1.0 };
        self.tangents.par_extend(mesh.tangents.par_iter().map(|&[x, y, z, w]| {
            let along = glam::DVec3::from(to_camera.vector([x, y, z].map(f64::from))).normalize_or_zero().as_vec3();
            [along.x, along.y, along.z, w * sign]
        }));
        Some(first.wrapping_sub(first_vertex))
    }

    /// Vertex positions without the padding.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions[..self.positions.len() - 1]
    }

    /// Vertex positions with one entry of padding at the end, for engines that read 16 bytes per vertex.
    pub fn padded_positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// All triangles: the flattened ones, then those of the prototypes.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The number of flattened triangles, which come first.
    pub fn flattened_count(&self) -> usize {
        self.flattened
    }

    /// The range of triangles of every prototype; they are in mesh coordinates.
    pub fn prototypes(&self) -> &[Range<usize>] {
        &self.prototypes
    }

    /// The placements of the prototypes.
    pub fn placements(&self) -> &[Placement] {
        &self.placements
    }

    /// Whether there are placements of prototypes.
    #[inline(always)]
    pub fn is_instanced(&self) -> bool {
        !self.placements.is_empty()
    }

    /// The corners of a triangle in camera coordinates, in the order of the barycentrics of a hit: clockwise seen from
    /// the front for a prototype under a mirroring placement.
    #[inline(always)]
    pub fn corners(&self, hit: Hit) -> [[f32; 3]; 3] {
        let corners = self.triangles[hit.triangle as usize].map(|k| self.positions[k as usize]);
        if hit.placement == FLATTENED {
            return corners;
        }
        let placement = &self.placements[hit.placement as usize];
        corners.map(|p| placement.point(p))
    }

    /// The plane of a triangle in camera coordinates.
    #[inline(always)]
    pub fn plane(&self, hit: Hit) -> Plane {
        let plane = self.records[hit.triangle as usize].plane;
        if hit.placement == FLATTENED { plane } else { self.placements[hit.placement as usize].plane(&plane) }
    }

    /// The error bound of the position of a hit on a triangle, divided by 2^-24: the largest coordinate of its corners,
    /// or that of its placement.
    #[inline(always)]
    pub fn extent(&self, hit: Hit) -> f32 {
        if hit.placement == FLATTENED {
            self.records[hit.triangle as usize].extent
        } else {
            self.placements[hit.placement as usize].extent
        }
    }

    /// 1 if the corners of a triangle are counter-clockwise seen from the front, -1 under a mirroring placement.
    #[inline(always)]
    pub fn orientation(&self, hit: Hit) -> f32 {
        if hit.placement == FLATTENED { 1.0 } else { self.placements[hit.placement as usize].orientation }
    }

    #[inline(always)]
    pub fn instance_index(&self, hit: Hit) -> u32 {
        if hit.placement == FLATTENED {
            self.records[hit.triangle as usize].instance
        } else {
            (self.instances.len() - self.placements.len()) as u32 + hit.placement
        }
    }

    /// The group of the instance that is hit, see [`group`].
    #[inline(always)]
    pub fn instance_group(&self, hit: Hit, groups: u32) -> u32 {
        group(self.instance_index(hit), self.instances.len(), groups)
    }

    #[inline(always)]
    pub fn instance(&self, index: u32) -> &InstanceData {
        &self.instances[index as usize]
    }

    /// Unit normals of the corners in camera coordinates; zero where the mesh has none.
    #[inline(always)]
    pub fn normals_of(&self, hit: Hit) -> [[f32; 3]; 3] {
        let [a, b, c] = self.records[hit.triangle as usize].corners;
        let [a, b, c] = [self.normals[a as usize], self.normals[b as usize], self.normals[c as usize]];
        if hit.placement == FLATTENED {
            return [a, b, c];
        }
        let placement = &self.placements[hit.placement as usize];
        [placement.normal(a), placement.normal(b), placement.normal(c)]
    }

    /// Tangents of the corners of a triangle of `instance` in camera coordinates, with the signs of their bitangents;
    /// `None` if the mesh has none.
    pub fn tangents_of(&self, instance: &InstanceData, hit: Hit) -> Option<[[f32; 4]; 3]> {
        let shift = instance.tangents?;
        let corners = self.records[hit.triangle as usize].corners;
        let tangents = corners.map(|k| self.tangents[k.wrapping_add(shift) as usize]);
        if hit.placement == FLATTENED {
            return Some(tangents);
        }
        let placement = &self.placements[hit.placement as usize];
        Some(tangents.map(|tangent| placement.tangent(tangent)))
    }

    /// The texture coordinates of the corners; `set` is 0 or 1.
    #[inline(always)]
    pub fn texture_coordinates_of(&self, hit: Hit, set: usize) -> [[f32; 2]; 3] {
        let [a, b, c] = self.records[hit.triangle as usize].corners;
        let all = &self.texture_coordinates[set];
        [all[a as usize], all[b as usize], all[c as usize]]
    }

    #[inline(always)]
    pub fn colors_of(&self, hit: Hit) -> [[f32; 4]; 3] {
        let [a, b, c] = self.records[hit.triangle as usize].corners;
        [self.colors[a as usize], self.colors[b as usize], self.colors[c as usize]]
    }
}

impl InstanceData {
    fn new(mesh: &Mesh, object: usize) -> Self {
        Self {
            material: mesh.material as u32,
            object: object as u32,
            smooth: !mesh.normals.is_empty(),
            textured: [!mesh.texture_coordinates.is_empty(), !mesh.second_texture_coordinates.is_empty()],
            colored: !mesh.colors.is_empty(),
            tangents: None,
        }
    }
}

impl Plane {
    pub fn through([a, b, c]: [[f64; 3]; 3]) -> Self {
        let [a, b, c] = [a, b, c].map(glam::DVec3::from);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Self { normal: normal.to_array(), offset: normal.dot(a) }
    }
}

/// Object to camera coordinates. The position of the camera is subtracted first: both positions may be large, and their
/// difference is exact for nearby objects.
fn to_camera(object: &Transform, pose: &Transform) -> Transform {
    let shifted = Transform {
        columns: object.columns,
        translation: std::array::from_fn(|k| object.translation[k] - pose.translation[k]),
    };
    world_to_camera_rotation(pose).after(&shifted)
}

/// The inverse of the rotation of the pose (its transpose), without the translation.
pub(crate) fn world_to_camera_rotation(pose: &Transform) -> Transform {
    let c = pose.columns;
    Transform { columns: std::array::from_fn(|k| [c[0][k], c[1][k], c[2][k]]), translation: [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_scene::Instance;

    fn one_triangle(transform: Transform) -> Scene {
        Scene {
            meshes: vec![Mesh {
                positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                normals: vec![[0.0, 0.0, 1.0]; 3],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            }],
            instances: vec![Instance { name: String::new(), mesh: 0, transform }],
            materials: vec![holo_scene::Material::default()],
            ..Scene::default()
        }
    }

    #[test]
    fn groups_are_items_or_runs_of_neighbors() {
        for count in [1, 5, 1022, 1023, 1024, 5000] {
            let groups: Vec<u32> = (0..count).map(|index| group(index, count as usize, 1023)).collect();
            assert!(groups.windows(2).all(|pair| pair[1] - pair[0] <= 1), "neighbors, and none left out");
            assert_eq!((groups[0], groups[groups.len() - 1]), (0, count.min(1023) - 1));
        }
    }

    #[test]
    fn a_mirrored_triangle_keeps_its_front_and_its_normal() {
        let mut mirrored = Transform::IDENTITY;
        mirrored.columns[0][0] = -2.0;
        let g = Geometry::build(&one_triangle(mirrored), &Transform::IDENTITY, Instancing::Never).unwrap();
        assert!(g.plane(Hit::flattened(0)).normal[2] > 0.0, "front side turned over");
        assert_eq!(g.normals_of(Hit::flattened(0))[0], [0.0, 0.0, 1.0]);
    }

    /// Rays start as far off a surface as its own triangle needs, not as far as the largest one of the mesh.
    #[test]
    fn a_far_triangle_does_not_push_rays_off_a_near_one() {
        let mut scene = one_triangle(Transform::IDENTITY);
        scene.meshes[0].positions.extend([[1000.0, 0.0, 0.0], [1000.0, 1.0, 0.0], [1000.0, 0.0, 1.0]]);
        scene.meshes[0].normals.resize(6, [0.0, 0.0, 1.0]);
        scene.meshes[0].triangles.push([3, 4, 5]);
        let g = Geometry::build(&scene, &Transform::IDENTITY, Instancing::Never).unwrap();
        assert_eq!([0, 1].map(|triangle| g.extent(Hit::flattened(triangle))), [1.0, 1000.0]);
    }

    #[test]
    fn a_far_world_is_the_near_world() {
        // Powers of two: the difference of the translations is exact, so the results must be equal.
        let far = [f64::from(1 << 20), -f64::from(1 << 21), f64::from(1 << 22)];
        let small = Transform { columns: [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]], translation: far };
        let near = Transform { translation: [0.0; 3], ..small };
        let a = Geometry::build(&one_triangle(small), &Transform::from_translation(far), Instancing::Never).unwrap();
        let b = Geometry::build(&one_triangle(near), &Transform::IDENTITY, Instancing::Never).unwrap();
        assert_eq!(a.positions(), b.positions());
        assert_eq!(a.plane(Hit::flattened(0)).normal, b.plane(Hit::flattened(0)).normal);
    }

    #[test]
    fn positions_beyond_f32_are_an_error() {
        let far = Transform::from_translation([1e30, 0.0, 0.0]);
        for instancing in [Instancing::Never, Instancing::Always] {
            let built = Geometry::build(&one_triangle(far), &Transform::IDENTITY, instancing);
            assert!(matches!(built, Err(Error::Scene(holo_scene::Error::BadScene { .. }))));
        }
    }
}
