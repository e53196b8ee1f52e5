//! Objectives of expired patents.

use super::{Medium, Prescription, Surface};
use crate::Error;

/// A published objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Objective {
    /// The name of the preset.
    pub name: &'static str,
    /// The kind of lens, its f-number and field, and the patent.
    pub about: &'static str,
    /// Radius, thickness, semi-aperture, index and Abbe number behind the surface, from the scene to the sensor, in units of
    /// the patent; an Abbe number of 0 for air, a radius of 0 for a plane, an index of 0 for the stop.
    rows: &'static [[f64; 5]],
    /// The focal length of the preset, m.
    focal_length_m: f64,
}

impl Objective {
    /// Returns the objective of a name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<&'static Self> {
        OBJECTIVES.iter().find(|objective| objective.name == name)
    }

    /// Returns its surfaces, scaled to the focal length of the preset.
    ///
    /// # Errors
    ///
    /// None for the objectives of this table.
    pub fn prescription(&self) -> Result<Prescription, Error> {
        let surface = |&[radius, thickness, semi_aperture, nd, vd]: &[f64; 5]| {
            let [radius, thickness, semi_aperture] = [radius, thickness, semi_aperture].map(|x| 1e-3 * x);
            match nd {
                0.0 => Surface::stop(thickness, semi_aperture),
                1.0 => Surface::sphere(radius, thickness, semi_aperture, Medium::Air),
                _ => Surface::sphere(radius, thickness, semi_aperture, Medium::Abbe { nd, vd: Some(vd) }),
            }
        };
        Prescription::new(self.rows.iter().map(surface).collect())?.scaled_to(self.focal_length_m)
    }
}

/// Returns the objectives.
#[must_use]
pub const fn objectives() -> &'static [Objective] {
    OBJECTIVES
}

const OBJECTIVES: &[Objective] = &[
    Objective {
        name: "double-gauss",
        about: "double Gauss, f/2, 44 degrees: A. W. Tronnier, US patent 2,673,491 (1954)",
        focal_length_m: 50e-3,
        rows: &[
            [58.95, 7.52, 25.2, 1.67, 47.1],
            [169.66, 0.24, 25.2, 1.0, 0.0],
            [38.55, 8.05, 23.0, 1.67, 47.1],
            [81.54, 6.55, 23.0, 1.699, 30.1],
            [25.5, 11.41, 18.0, 1.0, 0.0],
            [0.0, 9.0, 17.1, 0.0, 0.0],
            [-28.99, 2.36, 17.0, 1.603, 38.0],
            [81.54, 12.13, 20.0, 1.658, 57.3],
            [-40.77, 0.38, 20.0, 1.0, 0.0],
            [874.13, 6.44, 20.0, 1.717, 48.0],
            [-79.46, 0.0, 20.0, 1.0, 0.0],
        ],
    },
    Objective {
        name: "double-gauss-baker",
        // The patent has neither apertures nor the place of the stop, which its drawing shows in the middle of the central space.
        about: "double Gauss, f/2: J. G. Baker, US patent 2,532,751 (Perkin-Elmer, 1950)",
        focal_length_m: 50e-3,
        rows: &[
            [0.578, 0.088, 0.34, 1.617, 55.0],
            [1.896, 0.003, 0.34, 1.0, 0.0],
            [0.351, 0.125, 0.265, 1.611, 57.2],
            [0.0, 0.038, 0.265, 1.605, 38.0],
            [0.216, 0.141, 0.19, 1.0, 0.0],
            [0.0, 0.141, 0.1594, 0.0, 0.0],
            [-0.272, 0.038, 0.19, 1.605, 38.0],
            [0.0, 0.109, 0.235, 1.62, 60.3],
            [-0.352, 0.003, 0.235, 1.0, 0.0],
            [5.902, 0.069, 0.245, 1.62, 60.3],
            [-0.635, 0.0, 0.245, 1.0, 0.0],
        ],
    },
    Objective {
        name: "double-gauss-fast",
        about: "double Gauss of eight elements, f/1.1: P. Angenieux, US patent 2,701,982 (1955)",
        focal_length_m: 50e-3,
        rows: &[
            [164.13, 10.99, 54.0, 1.6751, 32.3],
            [559.2, 0.23, 54.0, 1.0, 0.0],
            [100.12, 11.45, 51.0, 1.6689, 46.7],
            [213.54, 0.23, 51.0, 1.0, 0.0],
            [58.04, 22.95, 41.0, 1.6913, 53.8],
            [2551.1, 2.58, 41.0, 1.6751, 32.3],
            [32.39, 15.66, 27.0, 1.0, 0.0],
            [0.0, 15.0, 25.5, 0.0, 0.0],
            [-40.42, 2.74, 25.0, 1.6992, 30.2],
            [192.98, 27.92, 36.0, 1.6204, 60.2],
            [-55.53, 0.23, 36.0, 1.0, 0.0],
            [192.98, 7.98, 35.0, 1.6913, 53.8],
            [-225.3, 0.23, 35.0, 1.0, 0.0],
            [175.09, 8.48, 35.0, 1.6913, 53.8],
            [-203.55, 0.0, 35.0, 1.0, 0.0],
        ],
    },
    Objective {
        name: "petzval",
        about: "Petzval type of narrow field, f/2.2: US patent 2,500,046 (Kodak, 1950)",
        focal_length_m: 100e-3,
        rows: &[
            [70.97, 15.0, 23.0, 1.523, 58.6],
            [-56.79, 4.5, 23.0, 1.617, 38.5],
            [0.0, 24.0, 23.0, 1.0, 0.0],
            [0.0, 25.3, 18.0, 0.0, 0.0],
            [119.91, 3.8, 15.0, 1.649, 33.8],
            [40.87, 0.9, 15.0, 1.0, 0.0],
            [46.87, 7.4, 15.0, 1.697, 56.1],
            [-282.05, 0.0, 15.0, 1.0, 0.0],
        ],
    },
    Objective {
        name: "retrofocus",
        about: "retrofocus wide-angle, f/2, 63 degrees: US patent 3,506,336 (Asahi, 1970)",
        focal_length_m: 35e-3,
        rows: &[
            [450.0, 7.0, 64.3, 1.58913, 61.2],
            [80.137, 47.0, 61.1, 1.0, 0.0],
            [-2300.0, 10.0, 48.3, 1.762, 40.3],
            [-292.234, 2.0, 46.9, 1.0, 0.0],
            [95.7, 18.0, 46.0, 1.77252, 49.6],
            [-707.468, 1.0, 38.3, 1.0, 0.0],
            [80.0, 8.0, 37.7, 1.53172, 48.9],
            [84.488, 9.0, 32.3, 1.0, 0.0],
            [0.0, 9.0, 26.3, 0.0, 0.0],
            [-91.5, 6.5, 32.9, 1.74077, 27.7],
            [98.025, 8.0, 34.9, 1.0, 0.0],
            [1000.0, 4.0, 34.9, 1.834, 37.2],
            [71.0, 19.0, 36.0, 1.77252, 49.6],
            [-89.354, 0.5, 36.0, 1.0, 0.0],
            [-600.0, 10.0, 45.7, 1.77252, 49.6],
            [-110.648, 0.0, 46.9, 1.0, 0.0],
        ],
    },
    Objective {
        name: "telephoto",
        about: "telephoto of internal focus, f/2.8, 14 degrees: S. Matsui, US patent 4,338,001 (Nikon, 1982)",
        focal_length_m: 180e-3,
        rows: &[
            [55.012, 6.389, 19.5, 1.50032, 81.9],
            [-78.244, 1.167, 17.8, 1.0, 0.0],
            [-76.698, 2.056, 17.5, 1.7495, 35.0],
            [207.222, 3.5, 17.3, 1.0, 0.0],
            [43.208, 5.111, 17.3, 1.65844, 50.8],
            [133.333, 30.0, 16.4, 1.0, 0.0],
            [0.0, 20.5, 8.97, 0.0, 0.0],
            [-19.722, 1.0, 10.3, 1.51454, 54.6],
            [-305.556, 0.278, 10.3, 1.0, 0.0],
            [122.222, 2.778, 10.6, 1.79668, 45.4],
            [-90.107, 0.0, 10.9, 1.0, 0.0],
        ],
    },
    Objective {
        name: "tessar",
        about: "Tessar, f/5.5, 60 degrees: P. Rudolph, US patent 721,240 (Zeiss, 1903)",
        focal_length_m: 50e-3,
        rows: &[
            [21.5, 3.8, 11.46, 1.6132, 58.0],
            [0.0, 1.9, 10.56, 1.0, 0.0],
            [-74.3, 1.1, 9.44, 1.60457, 38.0],
            [20.8, 3.0, 9.1, 1.0, 0.0],
            [0.0, 3.0, 7.71, 0.0, 0.0],
            [-111.3, 1.1, 8.61, 1.5211, 51.0],
            [25.2, 3.0, 8.61, 1.61132, 57.0],
            [-36.7, 0.0, 8.61, 1.0, 0.0],
        ],
    },
    Objective {
        name: "triplet",
        // The patent has neither apertures nor the place of the stop.
        about: "triplet, f/2.7: Pestrecov, US patent 2,453,260 (1948)",
        focal_length_m: 100e-3,
        rows: &[
            [40.94, 8.74, 20.0, 1.617, 55.0],
            [0.0, 11.05, 20.0, 1.0, 0.0],
            [-55.65, 2.78, 16.0, 1.649, 33.8],
            [39.75, 3.8, 15.0, 1.0, 0.0],
            [0.0, 3.83, 14.14, 0.0, 0.0],
            [107.56, 9.54, 17.0, 1.617, 55.0],
            [-43.33, 0.0, 17.0, 1.0, 0.0],
        ],
    },
];
