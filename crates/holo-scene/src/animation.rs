//! Movements of rigid things over time, as [`to_glb_animated`](crate::gltf::to_glb_animated) writes them.

/// An animation: how instances and cameras of a [`Scene`](crate::Scene) move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// A name for messages and for those who choose among several.
    pub name: String,
    /// The movements, at most one for each target.
    pub tracks: Vec<Track>,
}

/// The movement of one thing. Before its first key and after its last it rests; between keys it moves in a straight
/// line and turns evenly, the shorter way.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// What moves.
    pub target: Target,
    /// One or more places, in the order of their times.
    pub keys: Vec<Key>,
}

/// What an animation moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// An instance, by its index in [`Scene::instances`](crate::Scene::instances).
    Instance(usize),
    /// A camera, by its index in [`Scene::cameras`](crate::Scene::cameras).
    Camera(usize),
}

/// A place at a time. Files hold it in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// s.
    pub time_s: f32,
    /// Position in the world, m.
    pub translation: [f32; 3],
    /// Unit quaternion (x, y, z, w).
    pub rotation: [f32; 4],
}
