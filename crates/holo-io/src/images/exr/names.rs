//! Full names of channels, and the choice of the color channels.

use std::collections::HashMap;

use exr::meta::Headers;

/// A channel by its position in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Channel {
    pub part: usize,
    pub channel: usize,
    pub name: String,
}

/// All channels with their full names, in the order of the file.
pub(super) fn all(headers: &Headers) -> Vec<Channel> {
    let several = headers.len() > 1;
    let mut all = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        let layer = header.own_attributes.layer_name.as_ref().filter(|layer| several && !layer.bytes().is_empty());
        let layer = layer.map(|layer| format!("{}.", String::from_utf8_lossy(layer.bytes())));
        for (channel, description) in header.channels.list.iter().enumerate() {
            let own = String::from_utf8_lossy(description.name.bytes());
            let name = match &layer {
                // Some programs write the full name into the channel as well.
                Some(layer) if !own.starts_with(layer.as_str()) => format!("{layer}{own}"),
                _ => own.into_owned(),
            };
            all.push(Channel { part, channel, name });
        }
    }
    all
}

/// Passes that Blender 5 renamed: old name, new name.
const RENAMED_PASSES: [(&str, &str); 11] = [
    ("IndexOB", "Object Index"),
    ("IndexMA", "Material Index"),
    ("DiffCol", "Diffuse Color"),
    ("DiffDir", "Diffuse Direct"),
    ("DiffInd", "Diffuse Indirect"),
    ("GlossCol", "Glossy Color"),
    ("GlossDir", "Glossy Direct"),
    ("GlossInd", "Glossy Indirect"),
    ("TransCol", "Transmission Color"),
    ("TransDir", "Transmission Direct"),
    ("TransInd", "Transmission Indirect"),
];

/// Splits a full name into its layer and its component.
pub(super) fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// Whether a full name is that of a component of a Blender pass, by either name of the pass.
pub(super) fn is_of_pass(name: &str, pass: &str, component: &str) -> bool {
    let (layer, own_component) = split(name);
    let own_pass = split(layer).1;
    let newer = |name| RENAMED_PASSES.iter().find_map(|&(old, new)| (old == name).then_some(new)).unwrap_or(name);
    own_component == component && newer(own_pass) == newer(pass)
}

/// The components that determine whether a layer is color.
const COMPONENTS: [&str; 7] = ["R", "G", "B", "Y", "X", "Z", "RY"];

/// The indices of red, green and blue; three times the same index for luminance.
pub(super) fn color(channels: &[Channel]) -> Option<[usize; 3]> {
    // The layers with the indices of their components, in the order of the file; a map, because a damaged file may have
    // very many.
    let mut places = HashMap::new();
    let mut layers: Vec<(&str, [Option<usize>; COMPONENTS.len()])> = Vec::new();
    for (index, channel) in channels.iter().enumerate() {
        let (layer, component) = split(&channel.name);
        let Some(component) = COMPONENTS.iter().position(|known| *known == component) else { continue };
        let place = *places.entry((channel.part, layer)).or_insert(layers.len());
        if place == layers.len() {
            layers.push((layer, [None; COMPONENTS.len()]));
        }
        layers[place].1[component].get_or_insert(index);
    }
    // Stable: equal ranks stay in the order of the file.
    layers.sort_by_key(|(layer, _)| match *layer {
        "" => 0,
        layer if layer.split('.').any(|word| word == "Combined") => 1,
        _ => 2,
    });
    let rgb = layers.iter().find_map(|(_, components)| Some([components[0]?, components[1]?, components[2]?]));
    // X, Y, Z is a vector or CIE XYZ, and Y, RY, BY is color in another coding.
    rgb.or_else(|| {
        layers.iter().find_map(|(_, components)| match components {
            [.., luminance, None, None, None] => luminance.map(|index| [index; 3]),
            _ => None,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color_of(names: &[&str]) -> Option<[usize; 3]> {
        let channel = |(channel, name): (usize, &&str)| Channel { part: 0, channel, name: (*name).to_owned() };
        color(&names.iter().enumerate().map(channel).collect::<Vec<_>>())
    }

    #[test]
    fn the_color_is_found_by_rank() {
        assert_eq!(color_of(&["A", "B", "G", "R"]), Some([3, 2, 1]));
        assert_eq!(color_of(&["B", "G", "R", "a.Combined.B", "a.Combined.G", "a.Combined.R"]), Some([2, 1, 0]));
        let blender =
            ["V.Albedo.B", "V.Albedo.G", "V.Albedo.R", "V.Combined.A", "V.Combined.B", "V.Combined.G", "V.Combined.R"];
        assert_eq!(color_of(&blender), Some([6, 5, 4]));
        assert_eq!(color_of(&["a.B", "a.G", "a.R", "b.B", "b.G", "b.R"]), Some([2, 1, 0]));
        // Red of one layer and green of another are no color.
        assert_eq!(color_of(&["a.B", "a.G", "b.R"]), None);
    }

    #[test]
    fn passes_are_found_under_either_name() {
        for name in ["ViewLayer.IndexOB.X", "View Layer.Object Index.X", "IndexOB.X"] {
            assert!(is_of_pass(name, "IndexOB", "X") && is_of_pass(name, "Object Index", "X"), "{name}");
            assert!(!is_of_pass(name, "IndexMA", "X") && !is_of_pass(name, "IndexOB", "Y"), "{name}");
        }
        assert!(is_of_pass("V.Depth.Z", "Depth", "Z") && !is_of_pass("V.DepthZ", "Depth", "Z"));
    }

    #[test]
    fn luminance_is_distinguished_from_a_second_axis() {
        assert_eq!(color_of(&["Y"]), Some([0; 3]));
        assert_eq!(color_of(&["A", "Y"]), Some([1; 3]));
        assert_eq!(color_of(&["Normal.X", "Normal.Y", "Normal.Z"]), None);
        assert_eq!(color_of(&["X", "Y", "Z", "light.Y"]), Some([3; 3]));
        assert_eq!(color_of(&["BY", "RY", "Y"]), None);
        assert_eq!(color_of(&["Z"]), None);
    }
}
