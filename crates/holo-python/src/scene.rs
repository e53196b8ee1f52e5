//! Scenes: of files, of the gallery, of arrays.

use std::path::PathBuf;

use holo_dataset::SceneSource;
use holo_scene::{
    Camera, CameraProjection, Instance, Light, LightKind, Material, Mesh, Scene, Transform, gallery, gltf,
};
use numpy::{PyReadonlyArray2, ndarray::ArrayView2};
use pyo3::prelude::*;

use crate::failure::Failure;

/// A scene: its name, and the path of its file or its `.glb`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Source {
    name: String,
    path: Option<PathBuf>,
    glb: Option<Vec<u8>>,
    gallery: bool,
}

impl Source {
    pub fn open(self) -> Result<SceneSource, Failure> {
        match (self.path, self.glb) {
            (Some(path), _) => Ok(SceneSource::File(path)),
            (None, _) if self.gallery => Ok(SceneSource::gallery(&self.name)?),
            (None, Some(glb)) => Ok(SceneSource::Memory(self.name, glb.into())),
            (None, None) => Err(Failure::Usage("a scene needs a path or the bytes of a .glb".into())),
        }
    }
}

/// The names of the gallery's scenes.
#[pyfunction]
pub fn gallery_names() -> Vec<&'static str> {
    gallery::NAMES.to_vec()
}

/// A scene of the gallery as a `.glb`.
#[pyfunction]
pub fn gallery_glb(py: Python<'_>, name: String) -> Result<Vec<u8>, Failure> {
    match py.detach(|| SceneSource::gallery(&name))? {
        SceneSource::Gallery(_, glb) | SceneSource::Memory(_, glb) => Ok(glb.to_vec()),
        SceneSource::Recipe(drawing) => Err(Failure::Failed(format!("{} is drawn", drawing.recipe().name()))),
        SceneSource::File(path) => Err(Failure::Failed(format!("{} is a file", path.display()))),
    }
}

/// A mesh: arrays of vertices and triangles, and its material.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct MeshArrays<'py> {
    name: String,
    vertices: PyReadonlyArray2<'py, f32>,
    faces: PyReadonlyArray2<'py, u32>,
    normals: Option<PyReadonlyArray2<'py, f32>>,
    colors: Option<PyReadonlyArray2<'py, f32>>,
    base_color: [f32; 4],
    metallic: f32,
    roughness: f32,
    emission: [f32; 3],
    transmission: f32,
    ior: f32,
    double_sided: bool,
}

/// A light: kind, linear RGB intensity, position and direction.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct LightNumbers {
    kind: String,
    intensity: [f64; 3],
    position: [f64; 3],
    direction: [f64; 3],
}

/// A camera: where it is, what it looks at, and its vertical angle of view in radians.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct CameraNumbers {
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    vertical_angle_rad: f64,
}

/// A `.glb` of meshes, lights and a camera.
#[pyfunction]
pub fn meshes_to_glb(
    meshes: Vec<MeshArrays<'_>>,
    lights: Vec<LightNumbers>,
    camera: Option<CameraNumbers>,
) -> Result<Vec<u8>, Failure> {
    let mut scene = Scene::default();
    for (number, mesh) in meshes.iter().enumerate() {
        scene.meshes.push(Mesh {
            name: mesh.name.clone(),
            positions: rows("vertices", mesh.vertices.as_array())?,
            normals: mesh.normals.as_ref().map_or(Ok(Vec::new()), |array| rows("normals", array.as_array()))?,
            colors: mesh.colors.as_ref().map_or(Ok(Vec::new()), |array| rows("colors", array.as_array()))?,
            triangles: rows("faces", mesh.faces.as_array())?,
            material: number,
            ..Mesh::default()
        });
        scene.materials.push(Material {
            name: mesh.name.clone(),
            base_color: mesh.base_color,
            metallic: mesh.metallic,
            roughness: mesh.roughness,
            emission: mesh.emission,
            transmission: mesh.transmission,
            ior: mesh.ior,
            double_sided: mesh.double_sided,
            ..Material::default()
        });
        scene.instances.push(Instance { name: mesh.name.clone(), mesh: number, transform: Transform::IDENTITY });
    }
    for light in &lights {
        scene.lights.push(Light { name: light.kind.clone(), intensity: light.intensity, kind: light.kind()? });
    }
    if let Some(camera) = camera {
        scene.cameras.push(Camera {
            name: "camera".into(),
            pose: Transform::look_at(camera.eye, camera.target, camera.up),
            projection: CameraProjection::Perspective {
                vertical_angle_rad: camera.vertical_angle_rad,
                aspect_ratio: None,
            },
        });
    }
    Ok(gltf::to_glb(&scene)?)
}

impl LightNumbers {
    fn kind(&self) -> Result<LightKind, Failure> {
        let (position, direction) = (self.position, self.direction);
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = direction.map(|x| x / length.max(f64::MIN_POSITIVE));
        match self.kind.as_str() {
            "directional" => Ok(LightKind::Directional { direction, angular_diameter_rad: 0.0 }),
            "point" => Ok(LightKind::Point { position, range: None }),
            other => Err(Failure::Usage(format!("a light '{other}': give directional or point"))),
        }
    }
}

/// The rows of an array of `N` columns.
fn rows<T: Copy + numpy::Element, const N: usize>(name: &str, array: ArrayView2<T>) -> Result<Vec<[T; N]>, Failure> {
    if array.ncols() != N {
        let (rows, columns) = array.dim();
        return Err(Failure::Usage(format!("{name} of shape ({rows}, {columns}); they must be ({rows}, {N})")));
    }
    Ok(array.rows().into_iter().map(|row| std::array::from_fn(|column| row[column])).collect())
}
