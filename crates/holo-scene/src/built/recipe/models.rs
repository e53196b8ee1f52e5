//! The user's models and images, which recipes take parts of scenes from.

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::built::parts::studio::Studio;
use crate::gltf::{self, Limits};
use crate::{Error, Filter, Scene, Texture, TextureInfo, Transform, Wrap};

/// A folder may have this many files.
const FILES: usize = 256;

/// Images of models are at most this wide and high.
const SIDE: u32 = 2048;

/// Models and images, read once.
#[derive(Clone, Debug, Default)]
pub(super) struct Models {
    list: Vec<Model>,
    pub images: Vec<Texture>,
    pub files: Vec<PathBuf>,
}

#[derive(Clone, Debug)]
struct Model {
    scene: Scene,
    /// The ball around it.
    center: DVec3,
    radius: f64,
    /// The height of its lowest point in that ball, from -1.
    lowest: f64,
}

impl Models {
    /// Reads `.glb` files of one folder, and PNG and JPEG files of another.
    pub fn read(models: Option<&Path>, images: Option<&Path>) -> Result<Self, Error> {
        let mut out = Self::default();
        for path in models.map_or(Ok(Vec::new()), |folder| files(folder, &["glb", "gltf"]))? {
            let scene = gltf::load(&path, &Limits::default())?.scene;
            out.files.push(path);
            let Some((low, high)) = scene.bounds() else {
                let at = out.files[out.files.len() - 1].display().to_string();
                return Err(Error::BadFile { at, what: "a model has triangles, and this one has none".into() });
            };
            let (low, high) = (DVec3::from(low), DVec3::from(high));
            let (center, radius) = (0.5 * (low + high), 0.5 * low.distance(high));
            if radius > 0.0 {
                out.list.push(Model { scene, center, radius, lowest: (low.y - center.y) / radius });
            }
        }
        for path in images.map_or(Ok(Vec::new()), |folder| files(folder, &["png", "jpg", "jpeg"]))? {
            out.images.push(image(&path)?);
            out.files.push(path);
        }
        Ok(out)
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// The height of the lowest point of a model in its unit ball.
    pub fn lowest(&self, number: usize) -> f64 {
        self.list[number].lowest
    }

    /// Adds a model in the unit ball of a pose: its meshes with materials and textures, without lights.
    pub fn add(&self, number: usize, studio: &mut Studio, pose: &Transform) {
        let Model { scene, center, radius, .. } = &self.list[number];
        let textures: Vec<usize> = scene.textures.iter().map(|texture| studio.texture(texture.clone())).collect();
        let materials: Vec<usize> = scene
            .materials
            .iter()
            .map(|material| {
                let mut material = material.clone();
                let name = std::mem::take(&mut material.name);
                material.each_texture(|_, used| {
                    used.map(|used| TextureInfo { texture: textures.get(used.texture).copied().unwrap_or(0), ..used })
                });
                studio.material(&name, material)
            })
            .collect();
        let meshes: Vec<usize> = scene
            .meshes
            .iter()
            .map(|mesh| studio.add_mesh(&mesh.name, mesh.clone(), materials[mesh.material]))
            .collect();
        for instance in &scene.instances {
            let own = &instance.transform;
            let place = |p: [f64; 3]| pose.point(((DVec3::from(p) - *center) / *radius).to_array());
            let vector = |v: [f64; 3]| pose.vector((DVec3::from(v) / *radius).to_array());
            let transform = Transform { columns: own.columns.map(vector), translation: place(own.translation) };
            studio.add_instance(&instance.name, meshes[instance.mesh], transform);
        }
    }
}

/// The files of a folder with one of these endings, by name.
fn files(folder: &Path, endings: &[&str]) -> Result<Vec<PathBuf>, Error> {
    let failed = |error| Error::Read { path: folder.display().to_string(), error };
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if ending.is_some_and(|ending| endings.contains(&&*ending)) && path.is_file() {
            out.push(path);
        }
    }
    if out.len() > FILES {
        let what = format!("the folder has {} files, and all are kept in memory; take {FILES} or fewer", out.len());
        return Err(Error::BadFile { at: folder.display().to_string(), what });
    }
    out.sort();
    Ok(out)
}

/// An image as a texture.
fn image(path: &Path) -> Result<Texture, Error> {
    let name = path.display().to_string();
    let failed = |error| Error::Read { path: name.clone(), error };
    let mut reader = image::ImageReader::open(path).map_err(failed)?.with_guessed_format().map_err(failed)?;
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(1 << 14), Some(1 << 14));
    reader.limits(limits);
    let bad = |why: image::ImageError| Error::BadFile { at: name.clone(), what: why.to_string() };
    let mut pixels = reader.decode().map_err(bad)?;
    if pixels.width().max(pixels.height()) > SIDE {
        pixels = pixels.resize(SIDE, SIDE, image::imageops::FilterType::Triangle);
    }
    let pixels = pixels.into_rgb8();
    Ok(Texture {
        name: "image".into(),
        width: pixels.width() as usize,
        height: pixels.height() as usize,
        texels: pixels.pixels().map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect(),
        wrap_u: Wrap::Mirror,
        wrap_v: Wrap::Mirror,
        filter: Filter::Linear,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, Mesh, Scene};

    /// A model lies in the unit ball of its pose, whatever its own size and place.
    #[test]
    fn models_fill_their_balls() {
        let positions = vec![[1.0, 5.0, -2.0], [3.0, 5.0, -2.0], [3.0, 9.0, -2.0]];
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() };
        let instance = Instance { name: "x".into(), mesh: 0, transform: Transform::IDENTITY };
        let (meshes, instances) = (vec![mesh], vec![instance]);
        let scene = Scene { meshes, instances, materials: vec![Material::default()], ..Scene::default() };
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("x.glb"), gltf::to_glb(&scene).unwrap()).unwrap();
        let models = Models::read(Some(folder.path()), None).unwrap();
        // Half of the diagonal of 2 x 4 x 0.
        let radius = 5.0_f64.sqrt();
        assert!(models.len() == 1 && (models.lowest(0) + 2.0 / radius).abs() < 1e-6, "{}", models.lowest(0));
        let mut studio = Studio::new(Vec::new());
        models.add(0, &mut studio, &Transform::IDENTITY);
        let (low, high) = studio.with_camera([0.0, 0.0, 5.0], [0.0; 3]).bounds().unwrap();
        for (found, expected) in low.iter().chain(&high).zip([-1.0, -2.0, 0.0, 1.0, 2.0, 0.0]) {
            assert!((found - expected / radius).abs() < 1e-6, "{low:?} {high:?}");
        }
    }
}
