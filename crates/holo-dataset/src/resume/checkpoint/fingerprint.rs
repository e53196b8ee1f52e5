//! The digest of everything that determines the tiles of a render.

use std::fmt::{self, Debug, Write};
use std::fs::File;
use std::path::PathBuf;
use std::sync::LazyLock;

use holo_io::{Manifest, Sha256};
use holo_scene::{Environment, Mesh, Scene, Texture};

/// The bytes that are hashed at a time.
const BLOCK_BYTES: usize = 1 << 20;

/// Computes the digest for a scene, a request with the pose of its camera, and the versions of `identity`. Settings that
/// decide only how the tiles are encoded are not among them.
pub(super) fn of(scene: &Scene, request: &impl Debug, identity: &Manifest) -> Sha256 {
    let mut hash = Hash::default();
    // With the ray tracing backend.
    hash.debug(&identity.versions);
    // With the camera, the seed and the rows. Equal numbers have equal text, different ones have different text.
    hash.debug(request);
    // As it was loaded, because its file may refer to others.
    hash.scene(scene);
    hash.debug(&*PROGRAM);
    hash.finish()
}

/// The digest of the program that runs: two builds of one version may render differently. `None` if it cannot be read.
static PROGRAM: LazyLock<Option<Sha256>> = LazyLock::new(|| {
    // On Linux the first path leads to the program that runs, even if its file was replaced meanwhile.
    let running = Some(PathBuf::from("/proc/self/exe")).filter(|path| File::open(path).is_ok());
    let path = running.or_else(|| std::env::current_exe().ok())?;
    Some(holo_io::hash_file(path).ok()?.sha256)
});

/// A digest of a sequence of values: of the digests of its blocks.
#[derive(Default)]
struct Hash {
    digests: Vec<u8>,
    block: Vec<u8>,
}

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

impl Hash {
    fn bytes(&mut self, bytes: &[u8]) {
        self.block.extend_from_slice(bytes);
        if self.block.len() >= BLOCK_BYTES {
            self.end_block();
        }
    }

    fn end_block(&mut self) {
        self.digests.extend(Sha256::of(&self.block).0);
        self.block.clear();
    }

    fn finish(mut self) -> Sha256 {
        self.end_block();
        Sha256::of(&self.digests)
    }

    /// Adds a value of few fields. Its text ends with a zero byte, which text does not contain.
    fn debug(&mut self, value: &impl Debug) {
        // Writing into memory cannot fail.
        let _ = write!(self, "{value:?}\0");
    }

    /// Adds a long list, its length first.
    fn list<const N: usize>(&mut self, values: &[impl Copy], bytes: impl Fn(usize) -> [u8; N]) {
        self.bytes(&(values.len() as u64).to_le_bytes());
        (0..values.len()).for_each(|k| self.bytes(&bytes(k)));
    }

    fn scene(&mut self, scene: &Scene) {
        // All fields are named, so that a new one is not forgotten.
        let Scene { meshes, instances, materials, textures, lights, environment, cameras } = scene;
        self.debug(&(instances, materials, lights, cameras, meshes.len(), textures.len(), environment.is_some()));
        meshes.iter().for_each(|mesh| self.mesh(mesh));
        for texture in textures {
            let Texture { name, width, height, texels, wrap_u, wrap_v, filter } = texture;
            self.debug(&(name, width, height, wrap_u, wrap_v, filter));
            self.list(texels, |k| texels[k]);
        }
        if let Some(Environment { radiance }) = environment {
            self.debug(&radiance.dim());
            radiance.iter().for_each(|value| self.bytes(&value.to_le_bytes()));
        }
    }

    fn mesh(&mut self, mesh: &Mesh) {
        let Mesh {
            name,
            positions,
            normals,
            tangents,
            texture_coordinates,
            second_texture_coordinates,
            colors,
            triangles,
            material,
        } = mesh;
        self.debug(&(name, material));
        for vectors in [positions, normals] {
            self.list(vectors, |k| bytes::<3, 12>(vectors[k].map(f32::to_le_bytes)));
        }
        for coordinates in [texture_coordinates, second_texture_coordinates] {
            self.list(coordinates, |k| bytes::<2, 8>(coordinates[k].map(f32::to_le_bytes)));
        }
        for vectors in [tangents, colors] {
            self.list(vectors, |k| bytes::<4, 16>(vectors[k].map(f32::to_le_bytes)));
        }
        self.list(triangles, |k| bytes::<3, 12>(triangles[k].map(u32::to_le_bytes)));
    }
}

/// N numbers of 4 bytes as B bytes.
fn bytes<const N: usize, const B: usize>(numbers: [[u8; 4]; N]) -> [u8; B] {
    let mut joined = [0; B];
    joined.copy_from_slice(numbers.as_flattened());
    joined
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_scene::gallery;

    #[test]
    fn any_change_of_the_scene_changes_the_digest() {
        let digest = |scene: &Scene| {
            let mut hash = Hash::default();
            hash.scene(scene);
            hash.finish()
        };
        let original = gallery::scene("chess").expect("a scene of the gallery");
        assert!(!original.textures.is_empty() && !original.lights.is_empty(), "the test needs both");
        let first = digest(&original);
        assert_eq!(digest(&original.clone()), first);
        let changes: [fn(&mut Scene); 8] = [
            |scene| scene.meshes[0].positions[0][1] = f32::from_bits(scene.meshes[0].positions[0][1].to_bits() ^ 1),
            |scene| scene.meshes[0].triangles.reverse(),
            |scene| drop(scene.meshes.pop()),
            |scene| scene.materials[0].roughness += 1e-6,
            |scene| scene.textures[0].texels[5][3] ^= 1,
            |scene| scene.lights[0].intensity[2] += 1e-9,
            |scene| scene.instances[0].transform.translation[0] += 1e-9,
            |scene| scene.environment = Some(Environment { radiance: ndarray::Array3::zeros((1, 1, 3)) }),
        ];
        let mut digests = vec![first];
        for change in changes {
            let mut scene = original.clone();
            change(&mut scene);
            digests.push(digest(&scene));
        }
        digests.sort();
        digests.dedup();
        assert_eq!(digests.len(), 9);
    }
}
