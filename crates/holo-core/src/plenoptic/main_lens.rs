//! The main lens: focal length, pupils, focus, further stops and distortion.

use super::{Distortion, Paraxial, Prescription, PupilShape};
use crate::Error;
use crate::base::error::positive;

/// A round stop in front of the main lens, on its axis: a lens hood or the rim of a lens element, which vignettes the
/// borders of the image.
///
/// # Units
///
/// Meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// The distance from the main lens, towards the scene.
    pub distance_m: f64,
    /// The diameter.
    pub diameter_m: f64,
}

/// What the distance between main lens and microlens array follows from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ArrayFocus {
    /// The distance itself, from the array to the main lens, in meters.
    Distance {
        /// The distance, in meters; with a prescription that from the array to the last surface.
        mla_distance_m: f64,
    },
    /// The depth whose image lies at a virtual depth.
    Depth {
        /// The depth from the entrance pupil, in meters; may be infinite.
        depth_m: f64,
        /// Where its image lies, in gaps behind the array towards the sensor: 0 on the array (1.0), 2 for focused
        /// cameras such as Raytrix's (the total covering plane), negative in front of the array (Keplerian).
        virtual_depth: f64,
    },
}

/// A main lens, not validated: a thin lens with an aperture stop, or one of glass.
///
/// # Units
///
/// Meters.
#[derive(Debug, Clone, PartialEq)]
pub struct MainLens {
    /// The focal length.
    pub focal_length_m: f64,
    /// The f-number: focal length / diameter of the entrance pupil.
    pub f_number: f64,
    /// The focus.
    pub focus: ArrayFocus,
    /// The distance from the microlens array to the exit pupil; `None`: the pupil lies in the lens.
    pub exit_pupil_m: Option<f64>,
    /// The shape of the aperture.
    pub aperture: PupilShape,
    /// Further stops.
    pub stops: Vec<Stop>,
    /// The distortion.
    pub distortion: Distortion,
    /// The surfaces of a lens of glass, whose [rays near the axis](Prescription::paraxial) the focal length, the f-number and
    /// the exit pupil then follow from: [`PlenopticCamera::new`](super::PlenopticCamera::new) sets them. Its aperture is round.
    /// A lens with a prescription has no further stops and no other distortion.
    pub prescription: Option<Prescription>,
    /// The surfaces of the prescription that move to focus it; `None`: the whole lens does.
    pub focus_group: Option<FocusGroup>,
}

/// Surfaces of a lens of glass that move along the axis to focus it.
#[derive(Debug, Clone, PartialEq)]
pub struct FocusGroup {
    /// The first and the last surface that move, counted from 0 from the scene.
    pub surfaces: [usize; 2],
    /// The lens when it is focused at infinity.
    pub at_infinity: Prescription,
}

/// The numbers of a main lens that rays need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pupils {
    /// The focal length of the main lens.
    pub focal_m: f64,
    /// From the microlens array to the main lens (D).
    pub lens_m: f64,
    /// From the microlens array to the exit pupil (D_X).
    pub exit_m: f64,
    /// From the main lens to the entrance pupil, towards the scene (o_E).
    pub entrance_offset_m: f64,
    /// Size of the entrance pupil / size of the exit pupil (m); negative if the exit pupil lies behind the focal point.
    pub magnification: f64,
    /// Half of the diameter of the entrance pupil.
    pub entrance_radius_m: f64,
    /// 1 / depth of what the main lens images onto the array; 0 for infinity.
    pub inverse_focus_per_m: f64,
    /// Slope of the chief ray per meter on the array (g).
    pub slope_per_m: f64,
}

impl Pupils {
    /// Those of a microlens that lies this much nearer to the main lens, as on a tilted array.
    pub fn moved(self, nearer_m: f64) -> Self {
        let (lens_m, exit_m) = (self.lens_m - nearer_m, self.exit_m - nearer_m);
        let vergence = 1.0 / self.focal_m - 1.0 / lens_m;
        // 1/F = u / (1 - u o_E), and g = (1 + o_E/F) / D = 1 / (D (1 - u o_E)), with u = 1/f - 1/D.
        let rest = 1.0 - vergence * self.entrance_offset_m;
        Self { lens_m, exit_m, inverse_focus_per_m: vergence / rest, slope_per_m: 1.0 / (lens_m * rest), ..self }
    }

    /// The radius (or half width) of the exit pupil.
    pub fn exit_radius_m(&self) -> f64 {
        self.entrance_radius_m / self.magnification.abs()
    }
}

impl MainLens {
    /// Returns a lens focused at a depth, with a round aperture in the lens.
    #[must_use]
    pub const fn new(focal_length_m: f64, f_number: f64, focus_m: f64) -> Self {
        let focus = ArrayFocus::Depth { depth_m: focus_m, virtual_depth: 0.0 };
        let (aperture, distortion) = (PupilShape::Round, Distortion::NONE);
        Self {
            focal_length_m,
            f_number,
            focus,
            exit_pupil_m: None,
            aperture,
            stops: Vec::new(),
            distortion,
            prescription: None,
            focus_group: None,
        }
    }

    /// Returns a lens of glass.
    #[must_use]
    pub fn of_glass(prescription: Prescription, focus: ArrayFocus) -> Self {
        let Paraxial { focal_length_m, f_number, .. } = *prescription.paraxial();
        Self { focus, prescription: Some(prescription), ..Self::new(focal_length_m, f_number, 1.0) }
    }

    /// Returns a lens of glass that a group of its surfaces focuses at a depth, whose image lies at a virtual depth as that of
    /// [`ArrayFocus::Depth`].
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the group has no surface, all of them, or ends within glass, or reaches no such focus.
    pub fn of_glass_with_group(group: FocusGroup, depth_m: f64, virtual_depth: f64) -> Result<Self, Error> {
        let [first, last] = group.surfaces;
        let moved = group.at_infinity.focused_by(first..=last, depth_m)?;
        let focus = ArrayFocus::Depth { depth_m, virtual_depth };
        Ok(Self { focus_group: Some(group), ..Self::of_glass(moved, focus) })
    }

    /// Returns the lens focused at another depth: its focus group moves, or else the whole lens. The virtual depth stays.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if its focus group does not reach that depth.
    pub fn with_focus(&self, depth_m: f64) -> Result<Self, Error> {
        let virtual_depth = match self.focus {
            ArrayFocus::Depth { virtual_depth, .. } => virtual_depth,
            ArrayFocus::Distance { .. } => 0.0,
        };
        match &self.focus_group {
            Some(group) => Self::of_glass_with_group(group.clone(), depth_m, virtual_depth),
            None => Ok(Self { focus: ArrayFocus::Depth { depth_m, virtual_depth }, ..self.clone() }),
        }
    }

    /// Returns the lens with another f-number: one of glass with its stop closed to it.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if a lens of glass is not that open.
    pub fn with_f_number(&self, f_number: f64) -> Result<Self, Error> {
        let Some(lens) = &self.prescription else { return Ok(Self { f_number, ..self.clone() }) };
        let closed = lens.stopped_down(f_number)?;
        let group = self.focus_group.as_ref();
        let focus_group = group.map(|group| {
            let at_infinity = group.at_infinity.with_stop(closed.stop_m())?;
            Ok(FocusGroup { at_infinity, ..group.clone() })
        });
        Ok(Self { f_number, prescription: Some(closed), focus_group: focus_group.transpose()?, ..self.clone() })
    }

    /// The same lens with the numbers that follow from its prescription, if it has one, in front of an array `gap_m` from the
    /// sensor.
    pub(super) fn resolved(mut self, gap_m: f64) -> Result<Self, Error> {
        let Some(prescription) = &self.prescription else { return Ok(self) };
        if self.aperture != PupilShape::Round || !self.stops.is_empty() || !self.distortion.is_none() {
            let (what, value) =
                ("number of further apertures, stops and distortions of a lens with a prescription", 1.0);
            return Err(Error::BadNumber { what, value, need: "0: they follow from its surfaces" });
        }
        let paraxial = prescription.paraxial();
        (self.focal_length_m, self.f_number) = (paraxial.focal_length_m, paraxial.f_number);
        let lens_m = self.principal_distance(paraxial, gap_m)?;
        self.exit_pupil_m = Some(lens_m - paraxial.exit_pupil_from_principal_m());
        Ok(self)
    }

    /// The distance from the array to the rear principal plane of a lens of glass.
    fn principal_distance(&self, paraxial: &Paraxial, gap_m: f64) -> Result<f64, Error> {
        let f = paraxial.focal_length_m;
        match self.focus {
            ArrayFocus::Distance { mla_distance_m } => {
                let behind_m =
                    positive("distance of the microlens array from the last lens surface in meters", mla_distance_m)?;
                Ok(behind_m - paraxial.rear_principal_m)
            }
            ArrayFocus::Depth { depth_m, virtual_depth } => {
                let from_principal_m = depth_m + paraxial.entrance_pupil_from_principal_m();
                let image_m = 1.0 / (1.0 / f - 1.0 / from_principal_m);
                let lens_m = image_m - virtual_depth * gap_m;
                let behind_m = lens_m + paraxial.rear_principal_m;
                if depth_m.is_nan() || depth_m == 0.0 || !(behind_m.is_finite() && behind_m > 0.0) {
                    let need = "a depth that this lens images behind its last surface";
                    return Err(Error::BadNumber { what: "focus distance in meters", value: depth_m, need });
                }
                Ok(lens_m)
            }
        }
    }

    /// Validates the lens in front of an array `gap_m` from the sensor.
    pub(super) fn pupils(&self, gap_m: f64) -> Result<Pupils, Error> {
        let f = positive("focal length of the main lens in meters", self.focal_length_m)?;
        let f_number = positive("f-number of the main lens", self.f_number)?;
        if let Some(exit_m) = self.exit_pupil_m {
            positive("distance of the exit pupil from the microlens array in meters", exit_m)?;
        }
        let lens_m = match (&self.prescription, self.focus) {
            (Some(lens), _) => self.principal_distance(lens.paraxial(), gap_m)?,
            (None, ArrayFocus::Distance { mla_distance_m }) => mla_distance_m,
            (None, ArrayFocus::Depth { depth_m, virtual_depth }) => {
                self.distance_for(depth_m, virtual_depth * gap_m)?
            }
        };
        let lens_m = positive("distance of the main lens from the microlens array in meters", lens_m)?;
        for stop in &self.stops {
            positive("distance of a stop from the main lens in meters", stop.distance_m)?;
            positive("diameter of a stop in meters", stop.diameter_m)?;
        }
        if let PupilShape::Polygon { blades, rotation_rad } = self.aperture {
            if !(3..=64).contains(&blades) {
                let (what, value) = ("number of blades of the aperture", f64::from(blades));
                return Err(Error::BadNumber { what, value, need: "3 to 64" });
            }
            if !rotation_rad.is_finite() {
                let (what, value) = ("rotation of the aperture in radians", rotation_rad);
                return Err(Error::BadNumber { what, value, need: "finite" });
            }
        }
        let exit_m = self.exit_pupil_m.unwrap_or(lens_m);
        let behind_lens_m = lens_m - exit_m;
        if behind_lens_m == f {
            let what = "distance of the exit pupil from the main lens in meters";
            let need = "not the focal length: the entrance pupil would lie at infinity";
            return Err(Error::BadNumber { what, value: behind_lens_m, need });
        }
        let entrance_offset_m = f * behind_lens_m / (behind_lens_m - f);
        let magnification = f / (f - behind_lens_m);
        let pupils = Pupils {
            focal_m: f,
            lens_m,
            exit_m,
            entrance_offset_m,
            magnification,
            entrance_radius_m: f / f_number / 2.0,
            inverse_focus_per_m: 0.0,
            slope_per_m: 0.0,
        };
        let pupils = pupils.moved(0.0);
        for (what, value) in [
            ("inverse focus distance in 1/m", pupils.inverse_focus_per_m),
            ("slope of the main lens in 1/m", pupils.slope_per_m),
            ("offset of the entrance pupil in meters", entrance_offset_m),
            ("radius of the entrance pupil in meters", pupils.entrance_radius_m),
        ] {
            if !value.is_finite() {
                let need = "finite: the focus distance must not be 0";
                return Err(Error::BadNumber { what, value, need });
            }
        }
        Ok(pupils)
    }

    /// The distance from array to lens at which a depth is imaged `behind_m` behind the array: the root of
    /// 1/f - 1/(D + behind) - 1/(depth + o_E(D)).
    fn distance_for(&self, depth_m: f64, behind_m: f64) -> Result<f64, Error> {
        let f = self.focal_length_m;
        if depth_m.is_nan() || depth_m == 0.0 || !behind_m.is_finite() {
            let (what, need) = ("focus distance in meters", "a number, not 0 (infinity is allowed)");
            return Err(Error::BadNumber { what, value: if behind_m.is_finite() { depth_m } else { behind_m }, need });
        }
        let mut distance_m = 1.0 / (1.0 / f - 1.0 / depth_m) - behind_m;
        let Some(exit_m) = self.exit_pupil_m else { return Ok(distance_m) };
        if depth_m.is_infinite() {
            return Ok(distance_m);
        }
        // Newton's method; the pupil moves by much less than the lens, so it starts close.
        for _ in 0..100 {
            let pupil_m = distance_m - exit_m;
            let from_lens_m = depth_m + f * pupil_m / (pupil_m - f);
            let image_m = distance_m + behind_m;
            let value = 1.0 / f - 1.0 / image_m - 1.0 / from_lens_m;
            let slope = 1.0 / (image_m * image_m) - (f / (pupil_m - f) / from_lens_m).powi(2);
            let step = value / slope;
            distance_m -= step;
            if step.abs() <= 1e-16 * distance_m.abs() {
                break;
            }
        }
        let pupil_m = distance_m - exit_m;
        let rest = 1.0 / f - 1.0 / (distance_m + behind_m) - 1.0 / (depth_m + f * pupil_m / (pupil_m - f));
        if distance_m.is_finite() && rest.abs() < 1e-9 / f {
            return Ok(distance_m);
        }
        let need = "a depth that the main lens can be focused at with this exit pupil";
        Err(Error::BadNumber { what: "focus distance in meters", value: depth_m, need })
    }
}
