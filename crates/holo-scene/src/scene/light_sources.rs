//! Whether a scene has light sources.

use crate::{Material, Scene};

impl Scene {
    /// Whether anything in the scene gives light: a light that is not black, a surface that emits light or is unlit, or
    /// an environment map that is not black. Without any, every image of the scene is black.
    ///
    /// Surfaces count where an instance shows them. An emission texture that is black everywhere gives no light.
    #[must_use]
    pub fn has_light_sources(&self) -> bool {
        let lights = self.lights.iter().any(|light| light.intensity.iter().any(|&c| c > 0.0));
        let environment =
            self.environment.as_ref().is_some_and(|environment| environment.radiance.iter().any(|&c| c > 0.0));
        lights || environment || self.has_luminous_surfaces()
    }

    fn has_luminous_surfaces(&self) -> bool {
        let luminous: Vec<bool> = self.materials.iter().map(|material| self.is_luminous(material)).collect();
        luminous.contains(&true)
            && self
                .instances
                .iter()
                .filter_map(|instance| self.meshes.get(instance.mesh))
                .any(|mesh| !mesh.triangles.is_empty() && luminous.get(mesh.material) == Some(&true))
    }

    fn is_luminous(&self, material: &Material) -> bool {
        let texels = |texture: usize| self.textures.get(texture).map_or(&[][..], |texture| &texture.texels);
        let emits = |channel: usize| {
            let texture = material.emission_texture.map(|info| info.texture);
            material.emission[channel] > 0.0
                && texture.is_none_or(|texture| texels(texture).iter().any(|texel| texel[channel] > 0))
        };
        material.unlit || (0..3).any(emits)
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        Environment, Filter, Instance, Light, LightKind, Material, Mesh, Scene, Texture, TextureInfo, Transform, Wrap,
    };

    fn scene(material: Material) -> Scene {
        let mesh = Mesh { positions: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 2]], ..Mesh::default() };
        let instance = Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY };
        Scene { meshes: vec![mesh], instances: vec![instance], materials: vec![material], ..Scene::default() }
    }

    #[test]
    fn every_kind_of_light_source_counts() {
        assert!(!Scene::default().has_light_sources() && !scene(Material::default()).has_light_sources());
        let kind = LightKind::Point { position: [0.0; 3], range: None };
        let light = |blue| Light { name: String::new(), intensity: [0.0, 0.0, blue], kind };
        let lit = |blue| Scene { lights: vec![light(blue)], ..Scene::default() };
        assert!(lit(1.0).has_light_sources() && !lit(0.0).has_light_sources(), "a light of 0 cd is none");
        let sky =
            |value| Scene { environment: Some(Environment { radiance: ndarray::arr3(&[[[value]]]) }), ..lit(0.0) };
        assert!(sky(0.1).has_light_sources() && !sky(0.0).has_light_sources());
        assert!(scene(Material { unlit: true, ..Material::default() }).has_light_sources());
        let emissive = Material { emission: [0.0, 2.0, 0.0], ..Material::default() };
        assert!(scene(emissive.clone()).has_light_sources());
        let hidden = Scene { instances: vec![], ..scene(emissive.clone()) };
        assert!(!hidden.has_light_sources(), "no instance shows it");
    }

    #[test]
    fn emission_textures_must_have_light() {
        let emission_texture = Some(TextureInfo::new(0));
        let textured = |texel: [u8; 4]| {
            let mut scene = scene(Material { emission: [0.0, 2.0, 0.0], emission_texture, ..Material::default() });
            scene.textures.push(Texture {
                name: String::new(),
                width: 2,
                height: 1,
                texels: vec![[0, 0, 0, 255], texel],
                wrap_u: Wrap::Repeat,
                wrap_v: Wrap::Repeat,
                filter: Filter::Linear,
            });
            scene
        };
        assert!(textured([0, 1, 0, 255]).has_light_sources());
        assert!(!textured([9, 0, 9, 255]).has_light_sources(), "the factor of red and blue is 0");
    }
}
