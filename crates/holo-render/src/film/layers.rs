//! Layers: named outputs beside color (arbitrary output variables, AOVs; the passes of Blender, the layers of OpenEXR).
//!
//! A layer describes the **first hit** of the exact ray through the center of the pixel, for any material: glass and
//! mirrors count as surfaces, and what is visible through or in them does not matter. The ray is the same for any
//! number of color samples, so layers have no noise and no mixed pixels.
//!
//! | layer | channels | unit | value of a miss |
//! |---|---|---|---|
//! | `depth` | 1 | m along the optical axis (planar z) | +infinity |
//! | `ray-length` | 1 | m along the ray, from the plane z = 0 of the rig | +infinity |
//! | `disparity` | 1 | px between horizontally adjacent views (Eq. 3), positive nearer than the focus plane | disparity of infinity |
//! | `geometric-normal` | 3 | unit vector, world | 0 |
//! | `shading-normal` | 3 | unit vector, world | 0 |
//! | `albedo` | 3 | linear RGB, 0 to 1 | 0 |
//! | `object-id` | 1 | index in [`Scene::instances`](holo_scene::Scene::instances) + 1 | 0 |
//! | `material-id` | 1 | index in [`Scene::materials`](holo_scene::Scene::materials) + 1 | 0 |
//! | `hit-mask` | 1 | 1 | 0 |
//! | `reflective` | 1 | 1 for a surface that mirrors light, 2 for one that lets it pass, else 0 | 0 |
//!
//! - **Ray length.** A perspective ray starts at the center of the view, so its length is the distance from the view;
//!   an orthographic ray starts in the plane z = 0.
//! - **Normals** follow the Normal pass of Blender: in world coordinates (here those of glTF, +Y up), flipped where the
//!   ray hits the back of a triangle. The geometric normal therefore always faces the view. The shading normal, which
//!   is interpolated between the vertices and flipped with the geometric normal, may face away from the view at
//!   silhouettes.
//! - **Albedo** is the base color (factor, texture and vertex color) for any kind of material.
//! - **Reflective** is of a material by its numbers, whatever its textures are.
//! - **Ids** of objects and materials are exact; scenes with more than 2^24 of them are rejected.
//!
//! # Accuracy
//! Depth, ray length, disparity and the geometric normal are computed in f64 and rounded to f32 once: a relative error
//! of 2^-24. The shading normal and the albedo depend on the f32 barycentrics of the hit, which have an error of about
//! 1e-6.

use std::fmt;

/// A layer: a kind of output beside color. See the [module](self) for definitions, units and the values of misses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layer {
    /// Planar depth along the optical axis, m; +infinity for a miss.
    Depth,
    /// Distance along the ray from the plane z = 0 of the rig, m; +infinity for a miss.
    RayLength,
    /// Disparity between horizontally adjacent views (Eq. 3), px; positive nearer than the focus plane. If the
    /// baselines differ, [`Rig::disparity_y`](holo_core::Rig::disparity_y) converts depth to the disparity between
    /// vertically adjacent views.
    Disparity,
    /// Unit normal of the triangle in world coordinates, facing the view; 0 for a miss.
    GeometricNormal,
    /// Unit normal for shading in world coordinates (interpolated, with normal map); 0 for a miss.
    ShadingNormal,
    /// Base color, linear RGB; 0 for a miss.
    Albedo,
    /// Index of the instance + 1; 0 for a miss.
    ObjectId,
    /// Index of the material + 1; 0 for a miss.
    MaterialId,
    /// 1 for a hit, 0 for a miss.
    HitMask,
    /// 1 for a hit whose material [mirrors light](holo_scene::Material::is_reflective), 2 if it
    /// [lets light pass](holo_scene::Material::is_transparent), else 0.
    Reflective,
}

impl Layer {
    /// The number of layers.
    pub const COUNT: usize = 10;

    /// All layers.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Depth,
        Self::RayLength,
        Self::Disparity,
        Self::GeometricNormal,
        Self::ShadingNormal,
        Self::Albedo,
        Self::ObjectId,
        Self::MaterialId,
        Self::HitMask,
        Self::Reflective,
    ];

    /// The name on the command line, such as `ray-length`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::RayLength => "ray-length",
            Self::Disparity => "disparity",
            Self::GeometricNormal => "geometric-normal",
            Self::ShadingNormal => "shading-normal",
            Self::Albedo => "albedo",
            Self::ObjectId => "object-id",
            Self::MaterialId => "material-id",
            Self::HitMask => "hit-mask",
            Self::Reflective => "reflective",
        }
    }

    /// Channels of the layer: 1 or 3.
    #[must_use]
    pub const fn channels(self) -> usize {
        match self {
            Self::GeometricNormal | Self::ShadingNormal | Self::Albedo => 3,
            _ => 1,
        }
    }
}

impl fmt::Display for Layer {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of layers.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct LayerSet(u16);

impl LayerSet {
    /// The empty set.
    pub const EMPTY: Self = Self(0);

    /// The set of all layers.
    pub const ALL: Self = Self::of(&Layer::ALL);

    /// The set of the given layers.
    #[must_use]
    pub const fn of(layers: &[Layer]) -> Self {
        let (mut bits, mut k) = (0, 0);
        while k < layers.len() {
            bits |= 1 << layers[k] as u16;
            k += 1;
        }
        Self(bits)
    }

    /// Whether the set contains `layer`.
    #[must_use]
    pub const fn contains(self, layer: Layer) -> bool {
        self.0 & (1 << layer as u16) != 0
    }

    /// Whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The union of two sets.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The intersection of two sets.
    #[must_use]
    pub const fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The difference: the layers of this set that are not in `other`.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Iterates over the layers in the order of [`Layer::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Layer> {
        Layer::ALL.into_iter().filter(move |layer| self.contains(*layer))
    }

    /// The number of channels of all layers together.
    #[must_use]
    pub fn channels(self) -> usize {
        self.iter().map(Layer::channels).sum()
    }
}

impl FromIterator<Layer> for LayerSet {
    fn from_iter<I: IntoIterator<Item = Layer>>(layers: I) -> Self {
        layers.into_iter().fold(Self::EMPTY, |set, layer| set.union(Self::of(&[layer])))
    }
}

impl<const N: usize> From<[Layer; N]> for LayerSet {
    fn from(layers: [Layer; N]) -> Self {
        Self::of(&layers)
    }
}

impl fmt::Debug for LayerSet {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

/// A map from layers to values, such as images or light fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers<T>([Option<T>; Layer::COUNT]);

impl<T> Layers<T> {
    /// The value of `layer`, if there is one.
    #[must_use]
    pub const fn get(&self, layer: Layer) -> Option<&T> {
        self.0[layer as usize].as_ref()
    }

    /// Mutable access to the value of `layer`, if there is one.
    pub const fn get_mut(&mut self, layer: Layer) -> Option<&mut T> {
        self.0[layer as usize].as_mut()
    }

    /// Sets the value of `layer`; returns the previous one.
    pub const fn insert(&mut self, layer: Layer, value: T) -> Option<T> {
        self.0[layer as usize].replace(value)
    }

    /// Removes and returns the value of `layer`.
    pub const fn take(&mut self, layer: Layer) -> Option<T> {
        self.0[layer as usize].take()
    }

    /// The set of layers that have a value.
    #[must_use]
    pub fn set(&self) -> LayerSet {
        self.iter().map(|(layer, _)| layer).collect()
    }

    /// Iterates over layers and values in the order of [`Layer::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Layer, &T)> {
        Layer::ALL.into_iter().zip(&self.0).filter_map(|(layer, value)| Some((layer, value.as_ref()?)))
    }

    /// Iterates mutably over layers and values in the order of [`Layer::ALL`].
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (Layer, &mut T)> {
        Layer::ALL.into_iter().zip(&mut self.0).filter_map(|(layer, value)| Some((layer, value.as_mut()?)))
    }

    /// The value of [`Layer::Depth`]: planar depth, m.
    #[must_use]
    pub const fn depth_m(&self) -> Option<&T> {
        self.get(Layer::Depth)
    }

    /// The value of [`Layer::Disparity`]: disparity between horizontally adjacent views, px.
    #[must_use]
    pub const fn disparity_px(&self) -> Option<&T> {
        self.get(Layer::Disparity)
    }
}

impl<T> Default for Layers<T> {
    /// No values.
    fn default() -> Self {
        Self([const { None }; Layer::COUNT])
    }
}

impl<T> FromIterator<(Layer, T)> for Layers<T> {
    fn from_iter<I: IntoIterator<Item = (Layer, T)>>(values: I) -> Self {
        let mut layers = Self::default();
        layers.extend(values);
        layers
    }
}

impl<T> Extend<(Layer, T)> for Layers<T> {
    fn extend<I: IntoIterator<Item = (Layer, T)>>(&mut self, values: I) {
        for (layer, value) in values {
            self.insert(layer, value);
        }
    }
}

impl<T> IntoIterator for Layers<T> {
    type Item = (Layer, T);
    type IntoIter = std::iter::FilterMap<
        std::iter::Zip<
            std::array::IntoIter<Layer, { Layer::COUNT }>,
            std::array::IntoIter<Option<T>, { Layer::COUNT }>,
        >,
        fn((Layer, Option<T>)) -> Option<(Layer, T)>,
    >;

    fn into_iter(self) -> Self::IntoIter {
        Layer::ALL.into_iter().zip(self.0).filter_map(|(layer, value)| Some((layer, value?)))
    }
}

impl<T> std::ops::Index<Layer> for Layers<T> {
    type Output = T;

    /// The value of `layer`.
    ///
    /// # Panics
    /// If the layer was not rendered; [`Layers::get`] returns `None` then.
    fn index(&self, layer: Layer) -> &T {
        match self.get(layer) {
            Some(value) => value,
            None => panic!("the layer '{layer}' was not rendered"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_layers() {
        for (k, layer) in Layer::ALL.into_iter().enumerate() {
            assert_eq!(layer as usize, k, "the order of the list is that of the enum");
            assert!([1, 3].contains(&layer.channels()));
        }
    }

    #[test]
    fn sets_are_sets() {
        let some = LayerSet::from([Layer::Albedo, Layer::Depth, Layer::Depth]);
        assert_eq!(some.iter().collect::<Vec<_>>(), [Layer::Depth, Layer::Albedo]);
        assert_eq!(some.channels(), 4);
        assert_eq!(LayerSet::ALL.channels(), 16);
        assert_eq!(LayerSet::ALL.without(some).union(some), LayerSet::ALL);
        assert_eq!(LayerSet::ALL.without(some).intersection(some), LayerSet::EMPTY);
        assert!(LayerSet::EMPTY.is_empty() && !some.is_empty());
        assert_eq!(format!("{some:?}"), "{Depth, Albedo}");
    }

    #[test]
    fn layers_hold_what_is_put_in() {
        let mut layers: Layers<u8> = [(Layer::HitMask, 3), (Layer::Depth, 1)].into_iter().collect();
        assert_eq!((layers[Layer::Depth], layers.get(Layer::Albedo)), (1, None));
        assert_eq!(layers.insert(Layer::Albedo, 7), None);
        assert_eq!(layers.take(Layer::Depth), Some(1));
        assert_eq!(layers.set(), LayerSet::from([Layer::Albedo, Layer::HitMask]));
        assert_eq!(layers.into_iter().collect::<Vec<_>>(), [(Layer::Albedo, 7), (Layer::HitMask, 3)]);
    }
}
