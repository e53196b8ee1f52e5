//! Affine transforms in f64.

/// An affine transform `x -> matrix * x + translation`, in f64, so that small baselines at large world coordinates keep
/// their precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// The columns of the 3 x 3 matrix: the images of the x, y and z axes.
    pub columns: [[f64; 3]; 3],
    /// The image of the origin, m.
    pub translation: [f64; 3],
}

/// Axes this close to a right-handed orthonormal frame are kept unchanged, so that `to_glb` round-trips exactly.
pub(crate) const EXACT_FRAME: f64 = 1e-12;

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// The identity.
    pub const IDENTITY: Self =
        Self { columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// A translation by meters along x, y and z.
    #[must_use]
    pub const fn from_translation(translation: [f64; 3]) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// A transform from translation (m), unit quaternion (x, y, z, w; normalized here, the identity if it is zero) and
    /// scale, in the order of glTF: scale first, then rotation, then translation.
    #[must_use]
    pub fn from_parts(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Self {
        let length = rotation.iter().map(|q| q * q).sum::<f64>().sqrt();
        let [x, y, z, w] = if length > 0.0 { rotation.map(|q| q / length) } else { [0.0, 0.0, 0.0, 1.0] };
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let columns = std::array::from_fn(|k| rotation[k].map(|r| r * scale[k]));
        Self { columns, translation }
    }

    /// A camera pose (camera to world coordinates) at `eye` that looks at `target`, with `up` upward in the image. `up`
    /// must not be parallel to the viewing direction.
    #[must_use]
    pub fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Self {
        let back = normalize(std::array::from_fn(|k| eye[k] - target[k]));
        let right = normalize(cross(up, back));
        Self { columns: [right, cross(back, right), back], translation: eye }
    }

    /// Transforms a point.
    #[must_use]
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let v = self.vector(p);
        std::array::from_fn(|k| v[k] + self.translation[k])
    }

    /// Transforms a direction (without translation).
    #[must_use]
    pub fn vector(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| self.columns[0][k] * v[0] + self.columns[1][k] * v[1] + self.columns[2][k] * v[2])
    }

    /// The composition: first `first`, then `self`.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self { columns: first.columns.map(|c| self.vector(c)), translation: self.point(first.translation) }
    }

    /// The determinant of the matrix; negative for mirroring transforms.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        let c = cross(self.columns[0], self.columns[1]);
        (0..3).map(|k| c[k] * self.columns[2][k]).sum()
    }

    /// The cofactor matrix, as columns. It transforms normals (up to their length), also if the matrix is singular.
    #[must_use]
    pub fn normal_columns(&self) -> [[f64; 3]; 3] {
        let [a, b, c] = self.columns;
        [cross(b, c), cross(c, a), cross(a, b)]
    }

    /// The rotation and translation of a transform, as a camera has them: scale and shear are removed such that the viewing
    /// and up directions stay; images are never mirrored. `None` if an axis has no length.
    #[must_use]
    pub fn to_pose(&self) -> Option<Self> {
        Some(Self { columns: holo_core::rotation_of(self.columns)?, translation: self.translation })
    }

    /// Whether every entry is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.columns.iter().flatten().chain(&self.translation).all(|x| x.is_finite())
    }
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The normalized vector; `None` for zero.
pub(crate) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    // Scaled first: squares of very large or small numbers overflow or underflow.
    let largest = v.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v.map(|x| x / largest);
    let length = dot(v, v).sqrt();
    Some(v.map(|x| x / length))
}

pub(crate) fn normalize(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}
