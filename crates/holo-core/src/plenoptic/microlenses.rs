//! The microlens array: lattice, apertures and types of its microlenses.

use crate::Error;
use crate::base::error::positive;

/// The rows of a hexagonal grid are this times the pitch apart.
pub(super) const HEX_ROW: f64 = 0.866_025_403_784_438_6;

/// The largest number of interleaved types of microlenses.
pub(super) const MAX_TYPES: usize = 3;

/// The row and column of a microlens, from the one at the origin of the array; both may be negative. Rows run down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MicrolensIndex {
    /// The row.
    pub row: i32,
    /// The column.
    pub column: i32,
}

/// The arrangement of microlenses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MicrolensGrid {
    /// A square grid.
    Square,
    /// A hexagonal grid of rows. Odd rows are half a pitch further right.
    HexRows,
    /// A hexagonal grid of columns. Odd columns are half a pitch further down.
    HexColumns,
}

/// The aperture of a microlens. Square and hexagonal ones are rotated with the array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LensAperture {
    /// A disc.
    Round {
        /// Its radius, in meters.
        radius_m: f64,
    },
    /// A square.
    Square {
        /// Half of its width, in meters.
        half_width_m: f64,
    },
    /// A regular hexagon whose sides face the six neighbors of a hexagonal grid.
    Hexagon {
        /// The distance of its sides from the center, in meters.
        half_width_m: f64,
    },
}

impl LensAperture {
    /// Returns the area, in square meters.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        match *self {
            Self::Round { radius_m } => std::f64::consts::PI * radius_m * radius_m,
            Self::Square { half_width_m } => 4.0 * half_width_m * half_width_m,
            // Six triangles with the height w and the base 2 w / sqrt(3).
            Self::Hexagon { half_width_m } => 3.0 / HEX_ROW * half_width_m * half_width_m,
        }
    }

    /// Returns the same shape, larger by a factor.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Round { radius_m } => Self::Round { radius_m: factor * radius_m },
            Self::Square { half_width_m } => Self::Square { half_width_m: factor * half_width_m },
            Self::Hexagon { half_width_m } => Self::Hexagon { half_width_m: factor * half_width_m },
        }
    }

    /// Returns the radius of the smallest disc that contains the aperture, in meters.
    #[must_use]
    pub(crate) fn outer_radius_m(&self) -> f64 {
        match *self {
            Self::Round { radius_m } => radius_m,
            Self::Square { half_width_m } => half_width_m * std::f64::consts::SQRT_2,
            Self::Hexagon { half_width_m } => half_width_m / HEX_ROW,
        }
    }

    /// Returns the size that the shape is described by: the radius, or half of the width, in meters.
    #[must_use]
    pub const fn half_width_m(&self) -> f64 {
        match *self {
            Self::Round { radius_m } => radius_m,
            Self::Square { half_width_m } | Self::Hexagon { half_width_m } => half_width_m,
        }
    }
}

/// The focal lengths of the microlenses.
#[derive(Debug, Clone, PartialEq)]
pub enum MicrolensFocus {
    /// One to three focal lengths, in meters, of interleaved types.
    Lengths(Vec<f64>),
    /// The focal length that images the exit pupil of the main lens onto the sensor, so that every pixel sees one point
    /// of the pupil: the plenoptic camera of an ideal rig.
    Pupil,
}

/// A microlens array, not validated.
///
/// # Units
///
/// Meters and radians, in upright coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct MicrolensArray {
    /// The arrangement.
    pub grid: MicrolensGrid,
    /// The distance between the centers of neighboring microlenses, in meters.
    pub pitch_m: f64,
    /// The scale of the grid along y, for arrays that are not quite regular.
    pub scale_y: f64,
    /// The rotation of the array, counterclockwise in the image.
    pub rotation_rad: f64,
    /// The position of microlens (0, 0) from the middle of the sensor, to the right and up.
    pub offset_m: [f64; 2],
    /// The aperture of every microlens.
    pub aperture: LensAperture,
    /// Whether light passes between the apertures, unrefracted; else the array is opaque there.
    pub has_clear_gaps: bool,
    /// The distance from the array to the sensor, in meters.
    pub gap_m: f64,
    /// The tilt of the array against the sensor: by how much the distance grows to the right and up, as angles in radians.
    /// Every microlens stays parallel to the sensor.
    pub tilt_rad: [f64; 2],
    /// The focal lengths.
    pub focus: MicrolensFocus,
}

impl MicrolensArray {
    /// Returns an array of round microlenses that touch each other, with microlens (0, 0) in front of the middle of the
    /// sensor and a focal length equal to the gap.
    #[must_use]
    pub fn new(grid: MicrolensGrid, pitch_m: f64, gap_m: f64) -> Self {
        Self {
            grid,
            pitch_m,
            scale_y: 1.0,
            rotation_rad: 0.0,
            offset_m: [0.0; 2],
            aperture: LensAperture::Round { radius_m: pitch_m / 2.0 },
            has_clear_gaps: false,
            gap_m,
            tilt_rad: [0.0; 2],
            focus: MicrolensFocus::Lengths(vec![gap_m]),
        }
    }

    /// Returns the number of types.
    #[must_use]
    pub fn type_count(&self) -> usize {
        match &self.focus {
            MicrolensFocus::Lengths(lengths) => lengths.len(),
            MicrolensFocus::Pupil => 1,
        }
    }

    /// Returns the type of a microlens, from 0. In a hexagonal array of three types all six neighbors differ from it.
    #[must_use]
    pub fn type_of(&self, lens: MicrolensIndex) -> usize {
        let (row, column) = (i64::from(lens.row), i64::from(lens.column));
        // In axial coordinates of a hexagonal grid, neighbors differ by (1, 0), (0, 1) or (1, -1).
        let number = match self.grid {
            MicrolensGrid::Square => row + column,
            MicrolensGrid::HexRows => column - row.div_euclid(2) - row,
            MicrolensGrid::HexColumns => row - column.div_euclid(2) - column,
        };
        number.rem_euclid(self.type_count().max(1) as i64) as usize
    }

    /// Returns the center of a microlens from the origin of the array, in meters.
    #[must_use]
    pub(super) fn place_m(&self, lens: MicrolensIndex) -> [f64; 2] {
        rotate(self.upright_place_m(lens), self.rotation_rad)
    }

    /// The same before the rotation of the array.
    fn upright_place_m(&self, lens: MicrolensIndex) -> [f64; 2] {
        let (line, place) = match self.grid {
            MicrolensGrid::HexColumns => (lens.column, lens.row),
            _ => (lens.row, lens.column),
        };
        let (start, step) = self.line_m(line);
        [0, 1].map(|k| start[k] + f64::from(place) * step[k])
    }

    /// Returns the microlens whose center is nearest to a place, in meters from the origin of the array.
    #[must_use]
    pub(super) fn nearest(&self, place_m: [f64; 2]) -> MicrolensIndex {
        let upright = rotate(place_m, -self.rotation_rad);
        let [x, y] = [upright[0] / self.pitch_m, -upright[1] / self.pitch_m / self.scale_y];
        // Saturates far outside of any sensor.
        let index = |row: f64, column: f64| MicrolensIndex { row: row as i32, column: column as i32 };
        let odd = |k: f64| k.rem_euclid(2.0) / 2.0;
        let candidates = match self.grid {
            MicrolensGrid::Square => return index(y.round(), x.round()),
            MicrolensGrid::HexRows => [0.0, 1.0].map(|next| {
                let row = (y / HEX_ROW).floor() + next;
                index(row, (x - odd(row)).round())
            }),
            MicrolensGrid::HexColumns => [0.0, 1.0].map(|next| {
                let column = (x / HEX_ROW).floor() + next;
                index((y - odd(column)).round(), column)
            }),
        };
        let distance = |lens: MicrolensIndex| {
            let [x, y] = self.upright_place_m(lens);
            (x - upright[0]).powi(2) + (y - upright[1]).powi(2)
        };
        if distance(candidates[0]) <= distance(candidates[1]) { candidates[0] } else { candidates[1] }
    }

    /// By how much the array is farther from the sensor at a place than at its origin, in meters.
    pub(super) fn raised_m(&self, place_m: [f64; 2]) -> f64 {
        if self.tilt_rad == [0.0; 2] {
            return 0.0;
        }
        [0, 1].map(|k| self.tilt_rad[k].tan() * place_m[k]).iter().sum()
    }

    /// Half of the ways to the neighbors of a microlens on one side: its cell lies between the lines across their ends and
    /// those opposite.
    pub(super) fn cell(&self) -> [[f64; 2]; 3] {
        let (pitch, height) = (self.pitch_m / 2.0, self.pitch_m * self.scale_y / 2.0);
        let ways = match self.grid {
            MicrolensGrid::Square => [[pitch, 0.0], [0.0, height], [pitch, height]],
            MicrolensGrid::HexRows => [[pitch, 0.0], [pitch / 2.0, HEX_ROW * height], [-pitch / 2.0, HEX_ROW * height]],
            MicrolensGrid::HexColumns => {
                [[0.0, height], [HEX_ROW * pitch, height / 2.0], [HEX_ROW * pitch, -height / 2.0]]
            }
        };
        ways.map(|way| rotate(way, self.rotation_rad))
    }

    /// The microlenses around a place, in meters from the origin, with their parts of a linear interpolation: along the two
    /// nearest lines of the grid, and between them.
    pub(super) fn around(&self, place_m: [f64; 2]) -> Vec<(MicrolensIndex, f64)> {
        let [x, y] = rotate(place_m, -self.rotation_rad);
        let [x, y] = [x / self.pitch_m, -y / self.pitch_m / self.scale_y];
        let height = if self.grid == MicrolensGrid::Square { 1.0 } else { HEX_ROW };
        let (along, across) = if self.grid == MicrolensGrid::HexColumns { (y, x) } else { (x, y) };
        let line = (across / height).floor();
        let between = across / height - line;
        let mut out = Vec::with_capacity(4);
        for (line, part) in [(line, 1.0 - between), (line + 1.0, between)] {
            let shift = if self.grid == MicrolensGrid::Square { 0.0 } else { line.rem_euclid(2.0) / 2.0 };
            let place = along - shift;
            let (first, rest) = (place.floor(), place - place.floor());
            for (place, part) in [(first, part * (1.0 - rest)), (first + 1.0, part * rest)] {
                if part > 0.0 {
                    let (line, place) = (line as i32, place as i32);
                    let is_columns = self.grid == MicrolensGrid::HexColumns;
                    let [row, column] = if is_columns { [place, line] } else { [line, place] };
                    out.push((MicrolensIndex { row, column }, part));
                }
            }
        }
        out
    }

    /// Validates the numbers.
    pub(super) fn validate(&self) -> Result<(), Error> {
        positive("pitch of the microlenses in meters", self.pitch_m)?;
        positive("vertical scale of the microlens array", self.scale_y)?;
        positive("gap between microlens array and sensor in meters", self.gap_m)?;
        positive("half width of a microlens in meters", self.aperture.half_width_m())?;
        for (what, value) in [
            ("rotation of the microlens array in radians", self.rotation_rad),
            ("horizontal offset of the microlens array in meters", self.offset_m[0]),
            ("vertical offset of the microlens array in meters", self.offset_m[1]),
            ("horizontal tilt of the microlens array in radians", self.tilt_rad[0]),
            ("vertical tilt of the microlens array in radians", self.tilt_rad[1]),
        ] {
            if !value.is_finite() {
                return Err(Error::BadNumber { what, value, need: "finite" });
            }
        }
        if let MicrolensFocus::Lengths(lengths) = &self.focus {
            if !(1..=MAX_TYPES).contains(&lengths.len()) {
                let (what, value) = ("number of focal lengths of the microlenses", lengths.len() as f64);
                return Err(Error::BadNumber { what, value, need: "1 to 3" });
            }
            for &length in lengths {
                positive("focal length of a microlens in meters", length)?;
            }
        }
        // Apertures may overlap the cells of a slightly irregular array, but not their neighbors' centers.
        let nearest = self.pitch_m * self.scale_y.min(1.0);
        if self.aperture.half_width_m() > 0.51 * nearest {
            let (what, value) =
                ("half width of a microlens as a part of the pitch", self.aperture.half_width_m() / nearest);
            return Err(Error::BadNumber { what, value, need: "at most 0.5, so that microlenses do not overlap" });
        }
        Ok(())
    }
}

/// A place, rotated counterclockwise.
pub(super) fn rotate([x, y]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// The lines of a lattice: rows of microlenses, or columns of a grid of columns.
impl MicrolensArray {
    /// The first place on a line, and the step from one microlens to the next, before rotation.
    fn line_m(&self, line: i32) -> ([f64; 2], [f64; 2]) {
        let (pitch, height) = (self.pitch_m, self.pitch_m * self.scale_y);
        let (number, half) = (f64::from(line), f64::from(line.rem_euclid(2)) / 2.0);
        match self.grid {
            MicrolensGrid::Square => ([0.0, -number * height], [pitch, 0.0]),
            MicrolensGrid::HexRows => ([half * pitch, -number * HEX_ROW * height], [pitch, 0.0]),
            MicrolensGrid::HexColumns => ([number * HEX_ROW * pitch, -half * height], [0.0, -height]),
        }
    }

    /// The lines with microlenses between two opposite corners, in meters from the origin of the array.
    pub(super) fn lines_within(&self, low_m: [f64; 2], high_m: [f64; 2]) -> std::ops::RangeInclusive<i32> {
        let corners = [[low_m[0], low_m[1]], [low_m[0], high_m[1]], [high_m[0], low_m[1]], [high_m[0], high_m[1]]];
        let number = corners.map(|corner| {
            let [x, y] = rotate(corner, -self.rotation_rad);
            match self.grid {
                MicrolensGrid::Square => -y / (self.pitch_m * self.scale_y),
                MicrolensGrid::HexRows => -y / (HEX_ROW * self.pitch_m * self.scale_y),
                MicrolensGrid::HexColumns => x / (HEX_ROW * self.pitch_m),
            }
        });
        let (least, most) = number.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        least.ceil() as i32..=most.floor() as i32
    }

    /// The microlenses of a line between two opposite corners.
    pub(super) fn on_line(
        &self,
        line: i32,
        low_m: [f64; 2],
        high_m: [f64; 2],
    ) -> impl Iterator<Item = MicrolensIndex> + use<> {
        let (start, step) = self.line_m(line);
        let (start, step) = (rotate(start, self.rotation_rad), rotate(step, self.rotation_rad));
        let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..2 {
            let ends = [low_m[axis], high_m[axis]].map(|end| (end - start[axis]) / step[axis]);
            // A line along the other axis lies within for all of its microlenses or for none.
            if step[axis].abs() < 1e-12 * self.pitch_m {
                if start[axis] < low_m[axis] || start[axis] > high_m[axis] {
                    last = f64::NEG_INFINITY;
                }
                continue;
            }
            first = first.max(ends[0].min(ends[1]));
            last = last.min(ends[0].max(ends[1]));
        }
        let by_column = self.grid == MicrolensGrid::HexColumns;
        let index = move |place| match by_column {
            true => MicrolensIndex { row: place, column: line },
            false => MicrolensIndex { row: line, column: place },
        };
        // Empty where the first lies beyond the last.
        let range = (first <= last).then(|| first.ceil() as i32..=last.floor() as i32);
        range.into_iter().flatten().map(index)
    }
}
