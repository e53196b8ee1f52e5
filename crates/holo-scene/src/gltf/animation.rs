//! Animations: what the JSON of a file says at a point in time.
//!
//! An animation changes properties: translation, rotation, scale and weights of nodes, and with `KHR_animation_pointer`
//! numbers anywhere in the file. [`at`] returns the file with the values of the time in their places. Whatever reads the
//! file afterwards reads a file in one pose, so that skins, morph targets, cameras and lights follow their nodes.
//!
//! Source: the glTF 2.0 specification, section 3.11 and appendix C (interpolation).

mod interpolation;

use std::collections::BTreeSet;

use ::gltf::json::accessor::Type;
use serde_json::{Map, Value};

use self::interpolation::{Interpolation, Keys};
use super::Limits;
use super::accessors::{Checker, Use};
use super::buffer_views::BufferViews;
use super::extensions::ANIMATION_POINTER;
use super::handle::Handle;
use super::json::{Object, bad};
use super::options::LoadOptions;
use super::uri::shorten;
use super::values::Values;
use super::warnings::Warnings;
use crate::Error;

/// The most values of all animations together, and of one key: far above those of real files, and small enough that an
/// accessor without data, which has any number of zeros, needs little memory.
const MAX_VALUES: u64 = 1 << 24;
const MAX_VALUES_A_KEY: usize = 1 << 16;

/// JSON pointers of `KHR_animation_pointer` are shorter.
const MAX_SEGMENTS: usize = 16;

/// One property over time, with validated accessors.
struct Channel {
    at: String,
    /// The keys and indices from the root of the file to the property.
    target: Vec<String>,
    input: Handle,
    output: Handle,
    interpolation: Interpolation,
    /// Whether values are unit quaternions.
    is_rotation: bool,
}

/// Returns the file as it is at the time of `options`; `None` if it is not animated, or wanted without.
///
/// # Errors
/// A time that is not finite; an animation that the file does not have; channels that break the rules of glTF.
pub(super) fn at(
    file: &Value,
    root: &Object<'_>,
    buffer_views: &BufferViews<'_>,
    options: &LoadOptions,
    warnings: &mut Warnings,
) -> Result<Option<Value>, Error> {
    let animations = root.objects("animations")?;
    let Some(time_s) = options.time_s else {
        if !animations.is_empty() {
            warnings.note("animations are ignored: the scene is drawn in the pose of its nodes", String::new);
        }
        return Ok(None);
    };
    if !time_s.is_finite() {
        return Err(bad("animations", format!("the time is {time_s} s; it must be finite")));
    }
    let played = choose(&animations, options.animation.as_deref())?;
    if played.is_empty() {
        warnings.note("the file has no animations: it looks the same at all times", String::new);
        return Ok(None);
    }
    let mut accessors = Checker::new(root, buffer_views)?;
    let channels = channels(&played, root, &mut accessors, &options.limits, warnings)?;
    let values = Values::of(accessors);
    let mut posed = file.clone();
    for channel in &channels {
        let value = channel.value(&values, time_s)?;
        if replaces_a_matrix(&posed, &channel.target) {
            warnings.note("is animated and has a matrix, which is not used", || channel.target.join("/"));
        }
        if !assign(&mut posed, &channel.target, value) {
            warnings.note("animates a property that the file does not have: ignored", || channel.at.clone());
        }
    }
    Ok(Some(posed))
}

/// An animation of a file.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct AnimationSummary {
    /// Its name; may be empty.
    pub name: String,
    /// The time of its last key, s, as its accessors state it.
    pub seconds: f64,
}

/// Names and lengths of the animations of a file. What is wrong in them is found when they are played.
pub(super) fn summaries(root: &Object<'_>) -> Result<Vec<AnimationSummary>, Error> {
    let accessors = root.objects("accessors")?;
    let end = |sampler: &Object<'_>| {
        let input = sampler.index("input", "accessors", accessors.len()).ok().flatten()?;
        accessors[input].numbers::<1>("max").ok().flatten().map(|[end]| end)
    };
    let summary = |animation: &Object<'_>| {
        let samplers = animation.objects("samplers").unwrap_or_default();
        let seconds = samplers.iter().filter_map(end).fold(0.0, f64::max);
        AnimationSummary { name: animation.name().unwrap_or_default().to_owned(), seconds }
    };
    Ok(root.objects("animations")?.iter().map(summary).collect())
}

/// All animations, or the one with this name; a number is an index, unless an animation has that name.
fn choose<'a, 'f>(animations: &'a [Object<'f>], wanted: Option<&str>) -> Result<Vec<&'a Object<'f>>, Error> {
    let Some(wanted) = wanted else { return Ok(animations.iter().collect()) };
    let names: Vec<&str> = animations.iter().map(Object::name).collect::<Result<_, Error>>()?;
    let by_index = || wanted.parse().ok().filter(|&k: &usize| k < names.len());
    let chosen = names.iter().position(|name| *name == wanted).or_else(by_index);
    chosen.map(|k| vec![&animations[k]]).ok_or_else(|| {
        let known: Vec<String> = names.iter().map(|name| format!("'{}'", shorten(name))).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        bad("animations", format!("there is no animation '{}'; the file has {known}", shorten(wanted)))
    })
}

/// The channels of the animations. Where several change the same property, the first does.
fn channels(
    played: &[&Object<'_>],
    root: &Object<'_>,
    accessors: &mut Checker<'_>,
    limits: &Limits,
    warnings: &mut Warnings,
) -> Result<Vec<Channel>, Error> {
    let node_count = root.list("nodes")?.len();
    let mut changed: BTreeSet<Vec<String>> = BTreeSet::new();
    let mut channels = Vec::new();
    let mut elements = 0_u64;
    for animation in played {
        let samplers = animation.objects("samplers")?;
        for channel in animation.objects("channels")? {
            let target = channel.object("target")?.ok_or_else(|| channel.missing("target"))?;
            let Some(property) = property(&target, node_count)? else { continue };
            if !changed.insert(property.clone()) {
                let text = "several animations change the same property: the first is played; choose one by its name";
                warnings.note(text, || target.path().to_owned());
                continue;
            }
            let sampler = channel.index("sampler", "samplers", samplers.len())?;
            let sampler = &samplers[sampler.ok_or_else(|| channel.missing("sampler"))?];
            let channel = Channel::new(sampler, property, accessors)?;
            elements = elements.saturating_add(channel.input.count as u64 + channel.output.count as u64);
            let most = limits.max_vertices.min(MAX_VALUES);
            if elements > most || channel.output.count / channel.input.count > MAX_VALUES_A_KEY {
                return Err(bad(channel.at, format!("the animations exceed the limit of {most} values")));
            }
            channels.push(channel);
        }
    }
    Ok(channels)
}

/// The path of the property that a channel changes; `None` for a channel without a node, which is to be ignored.
fn property(target: &Object<'_>, node_count: usize) -> Result<Option<Vec<String>>, Error> {
    let path = target.string("path")?.ok_or_else(|| target.missing("path"))?;
    if path == "pointer" {
        let extension = target.extension(ANIMATION_POINTER)?.ok_or_else(|| target.missing(ANIMATION_POINTER))?;
        let pointer = extension.string("pointer")?.ok_or_else(|| extension.missing("pointer"))?;
        let mut segments = pointer.split('/').map(|part| part.replace("~1", "/").replace("~0", "~"));
        let starts = segments.next().is_some_and(|first| first.is_empty());
        let segments: Vec<String> = segments.take(MAX_SEGMENTS + 1).collect();
        if !starts || segments.is_empty() || segments.len() > MAX_SEGMENTS {
            return Err(bad(extension.at("pointer"), format!("'{}' is no pointer into the file", shorten(pointer))));
        }
        return Ok(Some(segments));
    }
    if !matches!(path, "translation" | "rotation" | "scale" | "weights") {
        return Err(bad(target.at("path"), format!("'{}' is no property of a node", shorten(path))));
    }
    let node = target.index("node", "nodes", node_count)?;
    Ok(node.map(|node| vec!["nodes".to_owned(), node.to_string(), path.to_owned()]))
}

impl Channel {
    fn new(sampler: &Object<'_>, target: Vec<String>, accessors: &mut Checker<'_>) -> Result<Self, Error> {
        let mut handle = |key: &str, wanted: Option<Use>| -> Result<Handle, Error> {
            let number = sampler.index(key, "accessors", accessors.len())?.ok_or_else(|| sampler.missing(key))?;
            let wanted = match wanted {
                Some(wanted) => wanted,
                None => Use::Animated(accessors.shape(number)?),
            };
            accessors.check(number, wanted, &sampler.at(key))
        };
        let of_node = (target.len() == 3 && target[0] == "nodes").then(|| target[2].as_str());
        let shape = match of_node {
            Some("translation" | "scale") => Some(Type::Vec3),
            Some("rotation") => Some(Type::Vec4),
            Some("weights") => Some(Type::Scalar),
            _ => None,
        };
        let input = handle("input", Some(Use::Times))?;
        let output = handle("output", shape.map(Use::Animated))?;
        let interpolation = Interpolation::read(sampler)?;
        let is_rotation = of_node == Some("rotation");
        let channel = Self { at: sampler.path().to_owned(), target, input, output, interpolation, is_rotation };
        let per_key = channel.interpolation.elements_a_key();
        let fits = channel.output.count.is_multiple_of(input.count * per_key);
        // Weights are scalars, one for every target.
        let is_list = shape.is_none_or(|shape| shape == Type::Scalar);
        if !fits || (!is_list && channel.output.count != input.count * per_key) {
            let what = format!("has {} values for {} times", channel.output.count, input.count);
            return Err(bad(sampler.at("output"), what));
        }
        Ok(channel)
    }

    /// The value at a time, as the property has it.
    fn value(&self, values: &Values<'_>, time_s: f64) -> Result<Value, Error> {
        let wide = |list: Vec<f32>| list.into_iter().map(f64::from).collect::<Vec<f64>>();
        let (times, components) = (wide(values.components(self.input)?), wide(values.components(self.output)?));
        if let Some(k) = times.windows(2).position(|pair| !matches!(pair, [a, b] if a < b)) {
            return Err(bad(format!("accessors[{}]", self.input.number), format!("time {} does not increase", k + 1)));
        }
        if let Some(k) = times.iter().position(|time| !time.is_finite()) {
            return Err(bad(format!("accessors[{}]", self.input.number), format!("time {k} is {}", times[k])));
        }
        if let Some(k) = components.iter().position(|x| !x.is_finite()) {
            let what = format!("component {k} is {}: repair the animation", components[k]);
            return Err(bad(format!("accessors[{}]", self.output.number), what));
        }
        let keys = Keys { times: &times, components: &components, is_rotation: self.is_rotation };
        let now = keys.at(time_s, self.interpolation);
        // Weights and other lists stay lists, whatever their length.
        let is_list = matches!(self.target.last().map(String::as_str), Some("weights")) || now.len() > 1;
        Ok(match now.first() {
            Some(&first) if self.target.last().is_some_and(|key| key == "visible") => Value::from(first > 0.5),
            Some(&first) if !is_list => Value::from(first),
            _ => Value::from(now),
        })
    }
}

/// Whether a target is a part of the transform of a node that has a matrix, against the specification.
fn replaces_a_matrix(file: &Value, target: &[String]) -> bool {
    let [list, node, part] = target else { return false };
    let is_part = matches!(part.as_str(), "translation" | "rotation" | "scale");
    let node = file.get(list).zip(node.parse::<usize>().ok()).and_then(|(nodes, node)| nodes.get(node));
    list == "nodes" && is_part && node.is_some_and(|node| node.get("matrix").is_some())
}

/// Puts a value into the place of a property. Objects on the way to it are created, entries of lists are not.
fn assign(file: &mut Value, target: &[String], value: Value) -> bool {
    let Some((last, parents)) = target.split_last() else { return false };
    let mut place = file;
    for key in parents {
        let next = match place {
            Value::Array(list) => key.parse::<usize>().ok().and_then(|k| list.get_mut(k)),
            Value::Object(map) => Some(map.entry(key.clone()).or_insert_with(|| Value::Object(Map::new()))),
            _ => None,
        };
        let Some(next) = next else { return false };
        place = next;
    }
    match place {
        Value::Array(list) => match last.parse::<usize>().ok().and_then(|k| list.get_mut(k)) {
            Some(entry) => *entry = value,
            None => return false,
        },
        Value::Object(map) => {
            // A matrix would hide the parts that are animated; the specification forbids it.
            if matches!(last.as_str(), "translation" | "rotation" | "scale") {
                map.remove("matrix");
            }
            map.insert(last.clone(), value);
        }
        _ => return false,
    }
    true
}
