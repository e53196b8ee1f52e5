//! The names of the files in an HCI folder.

use super::{HciQuantity, HciResolution};
use crate::files::names::{HCI_VIEW, hci_number, hci_view_number};

const TRUTH: &str = "gt_";
const CAMERA: &str = "_Cam";

/// A file of an HCI folder, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Name {
    /// The image of a view.
    View(usize),
    /// A ground truth map: of one view, or without a number of the central one.
    Truth { depth: bool, high: bool, view: Option<usize> },
}

impl Name {
    pub(super) fn truth(quantity: HciQuantity, resolution: HciResolution, view: Option<usize>) -> Self {
        Self::Truth { depth: quantity == HciQuantity::Depth, high: resolution == HciResolution::High, view }
    }

    /// Parses a file name; `None` for other files.
    pub(super) fn parse(name: &str) -> Option<Self> {
        if let Some(number) = hci_view_number(name) {
            return Some(Self::View(number));
        }
        let rest = name.strip_prefix(TRUTH)?.strip_suffix(".pfm")?;
        let (rest, view) = match rest.split_once(CAMERA) {
            Some((rest, number)) => (rest, Some(hci_number(number)?)),
            None => (rest, None),
        };
        let (depth, high) = match rest {
            "disp_lowres" => (false, false),
            "disp_highres" => (false, true),
            "depth_lowres" => (true, false),
            "depth_highres" => (true, true),
            _ => return None,
        };
        Some(Self::Truth { depth, high, view })
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::View(index) => write!(f, "{HCI_VIEW}{index:03}.png"),
            Self::Truth { depth, high, view } => {
                let quantity = if depth { "depth" } else { "disp" };
                let resolution = if high { "highres" } else { "lowres" };
                write!(f, "{TRUTH}{quantity}_{resolution}")?;
                view.map_or(Ok(()), |index| write!(f, "{CAMERA}{index:03}"))?;
                write!(f, ".pfm")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_hci_tools() {
        let truth = |quantity, resolution, view| Name::truth(quantity, resolution, view);
        for (name, text) in [
            (Name::View(0), "input_Cam000.png"),
            (Name::View(80), "input_Cam080.png"),
            (Name::View(999), "input_Cam999.png"),
            (Name::View(1000), "input_Cam1000.png"),
            (Name::View(12_345), "input_Cam12345.png"),
            (truth(HciQuantity::Disparity, HciResolution::Low, None), "gt_disp_lowres.pfm"),
            (truth(HciQuantity::Depth, HciResolution::High, None), "gt_depth_highres.pfm"),
            (truth(HciQuantity::Depth, HciResolution::Low, Some(7)), "gt_depth_lowres_Cam007.pfm"),
            (truth(HciQuantity::Disparity, HciResolution::High, Some(1000)), "gt_disp_highres_Cam1000.pfm"),
        ] {
            assert_eq!(name.to_string(), text);
            assert_eq!(Name::parse(text), Some(name));
        }
    }

    #[test]
    fn any_number_of_leading_zeros_is_parsed_and_nothing_else() {
        for text in ["input_Cam7.png", "input_Cam07.png", "input_Cam0007.png"] {
            assert_eq!(Name::parse(text), Some(Name::View(7)));
        }
        for text in [
            "input_Cam.png",
            "input_Cam+07.png",
            "input_Cam-7.png",
            "input_Cam007.PNG",
            "input_Cam007.png.png",
            "xinput_Cam007.png",
            "input_Cam99999999999999999999.png",
            "gt_disp_lowres_Cam.pfm",
            "gt_disp.pfm",
            "gt_disp_lowres.png",
            "gt_mask_lowres.pfm",
            ".input_Cam007.png.12-1.part",
            "",
        ] {
            assert_eq!(Name::parse(text), None, "{text}");
        }
    }
}
