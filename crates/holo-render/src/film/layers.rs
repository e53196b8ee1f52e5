//! Outputs by name: what else than colour the pixels of a light field can tell about the first surface that they see.
//!
//! **The first surface** is the nearest one along the exact ray through the pixel's centre, whatever it is made of: glass
//! and mirrors are surfaces like any other, and what stands behind or in them is not looked at. That ray is the same for
//! any number of colour samples, so layers have no noise and no mixed pixels.
//!
//! | layer | channels | unit | nothing hit |
//! |---|---|---|---|
//! | `depth` | 1 | m along the optical axis (planar z) | +infinity |
//! | `ray-length` | 1 | m along the ray, from where it leaves the plane z = 0 of the rig | +infinity |
//! | `disparity` | 1 | px between horizontally adjacent views (Eq. 3), nearer is larger | that of infinity |
//! | `geometric-normal` | 3 | unit vector, world | 0 |
//! | `shading-normal` | 3 | unit vector, world | 0 |
//! | `albedo` | 3 | linear RGB, 0 to 1 | 0 |
//! | `object-id` | 1 | index in [`Scene::instances`](holo_scene::Scene::instances) + 1 | 0 |
//! | `material-id` | 1 | index in [`Scene::materials`](holo_scene::Scene::materials) + 1 | 0 |
//! | `hit-mask` | 1 | 1 | 0 |
//!
//! - **Rays.** A perspective ray leaves the view's centre, so its length is the distance from the view; an orthographic one
//!   leaves the plane z = 0 beside it.
//! - **Normals** are those of Blender's Normal pass: in world coordinates (here glTF's, +Y up), turned over where the ray
//!   comes to the back of a triangle. The geometric normal so always looks towards the view; the shading normal, which is
//!   interpolated between the vertices and turned over with it, may look away at silhouettes.
//! - **Albedo** is the base colour - factor, texture and vertex colour - at that point, for any kind of material.
//! - **Numbers** of objects and materials are exact, because more than 2^24 of them are refused.
//!
//! # Accuracy
//! Depth, ray length, disparity and the geometric normal are computed in f64 (`refine.rs`) and rounded to f32 once:
//! 2^-24. The shading normal and the albedo depend on where in the triangle the engine's f32 hit lies: some 1e-6 of the
//! triangle.

use std::fmt;

/// A kind of output beside colour. See the [module](self) for units and for what is where nothing is hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layer {
    /// Planar depth along the optical axis, m; +infinity where nothing is hit.
    Depth,
    /// Distance along the ray from the plane z = 0 of the rig, m; +infinity where nothing is hit.
    RayLength,
    /// Disparity between horizontally adjacent views (Eq. 3), px; nearer is larger. Where the baselines differ, the one
    /// between vertically adjacent views is [`disparity_y`](holo_core::Rig::disparity_y) of the depth.
    Disparity,
    /// Unit normal of the triangle in world coordinates, on the side that is seen; 0 where nothing is hit.
    GeometricNormal,
    /// Unit normal that light is reflected with, in world coordinates; 0 where nothing is hit.
    ShadingNormal,
    /// Base colour, linear RGB; 0 where nothing is hit.
    Albedo,
    /// Number of the instance, from 1; 0 where nothing is hit.
    ObjectId,
    /// Number of the material, from 1; 0 where nothing is hit.
    MaterialId,
    /// 1 where something is hit, else 0.
    HitMask,
}

impl Layer {
    /// How many there are.
    pub const COUNT: usize = 9;

    /// All of them.
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
        }
    }

    /// The layer of that [name](Self::name).
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }

    /// Values a pixel: 1 or 3.
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

/// Some of the layers.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct LayerSet(u16);

impl LayerSet {
    /// None of them.
    pub const EMPTY: Self = Self(0);

    /// All of them.
    pub const ALL: Self = Self::of(&Layer::ALL);

    /// These.
    #[must_use]
    pub const fn of(layers: &[Layer]) -> Self {
        let (mut bits, mut k) = (0, 0);
        while k < layers.len() {
            bits |= 1 << layers[k] as u16;
            k += 1;
        }
        Self(bits)
    }

    /// Whether `layer` is one of them.
    #[must_use]
    pub const fn contains(self, layer: Layer) -> bool {
        self.0 & (1 << layer as u16) != 0
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// What is in either set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// What is in both sets.
    #[must_use]
    pub const fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// What is not in the other set.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// One after the other, in the order of [`Layer::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Layer> {
        Layer::ALL.into_iter().filter(move |layer| self.contains(*layer))
    }

    /// Values a pixel, all of them together.
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

/// One `T` - an image, a light field - for each of some layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers<T>([Option<T>; Layer::COUNT]);

impl<T> Layers<T> {
    /// The one of `layer`, if there is one.
    #[must_use]
    pub const fn get(&self, layer: Layer) -> Option<&T> {
        self.0[layer as usize].as_ref()
    }

    /// The same, to be changed.
    pub const fn get_mut(&mut self, layer: Layer) -> Option<&mut T> {
        self.0[layer as usize].as_mut()
    }

    /// Puts one in; returns what was there before.
    pub const fn insert(&mut self, layer: Layer, value: T) -> Option<T> {
        self.0[layer as usize].replace(value)
    }

    /// Takes one out.
    pub const fn take(&mut self, layer: Layer) -> Option<T> {
        self.0[layer as usize].take()
    }

    /// Which there are.
    #[must_use]
    pub fn set(&self) -> LayerSet {
        self.iter().map(|(layer, _)| layer).collect()
    }

    /// One after the other, in the order of [`Layer::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Layer, &T)> {
        Layer::ALL.into_iter().zip(&self.0).filter_map(|(layer, value)| Some((layer, value.as_ref()?)))
    }

    /// The same, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (Layer, &mut T)> {
        Layer::ALL.into_iter().zip(&mut self.0).filter_map(|(layer, value)| Some((layer, value.as_mut()?)))
    }

    /// Planar depth, m.
    #[must_use]
    pub const fn depth_m(&self) -> Option<&T> {
        self.get(Layer::Depth)
    }

    /// Disparity between horizontally adjacent views, px.
    #[must_use]
    pub const fn disparity_px(&self) -> Option<&T> {
        self.get(Layer::Disparity)
    }
}

impl<T> Default for Layers<T> {
    /// None.
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

    /// The one of `layer`.
    ///
    /// # Panics
    /// If it was not asked for; [`Layers::get`] does not.
    fn index(&self, layer: Layer) -> &T {
        match self.get(layer) {
            Some(value) => value,
            None => panic!("the layer '{layer}' was not asked for"),
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
            assert_eq!(Layer::from_name(layer.name()), Some(layer));
            assert!([1, 3].contains(&layer.channels()));
        }
        assert_eq!(Layer::from_name("ray_length"), None);
    }

    #[test]
    fn sets_are_sets() {
        let some = LayerSet::from([Layer::Albedo, Layer::Depth, Layer::Depth]);
        assert_eq!(some.iter().collect::<Vec<_>>(), [Layer::Depth, Layer::Albedo]);
        assert_eq!(some.channels(), 4);
        assert_eq!(LayerSet::ALL.channels(), 15);
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
