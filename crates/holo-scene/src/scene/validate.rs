//! Validation of scenes.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use crate::{
    Alpha, Camera, CameraProjection, Environment, Error, Light, LightKind, Material, Mesh, Scene, Texture,
    TextureTransform, Transform,
};

/// Maximum deviation of the squared length of a normal from 1; single-precision exporters come close to it.
const NORMAL_TOLERANCE: f64 = 1e-3;
/// Maximum deviation of light directions and camera axes from unit length and right angles.
const DIRECTION_TOLERANCE: f64 = 1e-6;

impl Scene {
    /// Checks everything that a renderer relies on: indices in range, lists of equal length, finite numbers, textures
    /// with the declared number of texels, angles and directions in their ranges.
    ///
    /// # Errors
    /// [`Error::BadScene`] for the first inconsistency, with its path.
    pub fn validate(&self) -> Result<(), Error> {
        let counts = [
            ("meshes", self.meshes.len()),
            ("instances", self.instances.len()),
            ("materials", self.materials.len()),
            ("textures", self.textures.len()),
            ("lights", self.lights.len()),
            ("cameras", self.cameras.len()),
        ];
        for (list, count) in counts {
            check_count(list, count)?;
        }
        self.meshes.par_iter().enumerate().try_for_each(|(k, mesh)| self.check_mesh(k, mesh))?;
        for (k, instance) in self.instances.iter().enumerate() {
            let at = || format!("instances[{k}]");
            check_index(at, "mesh", instance.mesh, "meshes", self.meshes.len())?;
            check_transform(at, "transform", &instance.transform)?;
        }
        for (k, material) in self.materials.iter().enumerate() {
            self.check_material(k, material)?;
        }
        self.textures.iter().enumerate().try_for_each(|(k, texture)| check_texture(k, texture))?;
        self.lights.iter().enumerate().try_for_each(|(k, light)| check_light(k, light))?;
        self.check_environment()?;
        self.cameras.iter().enumerate().try_for_each(|(k, camera)| check_camera(k, camera))
    }

    fn check_mesh(&self, k: usize, mesh: &Mesh) -> Result<(), Error> {
        let at = || format!("meshes[{k}]");
        let vertices = mesh.positions.len();
        check_count(&format!("meshes[{k}].positions"), vertices)?;
        check_count(&format!("meshes[{k}].triangles"), mesh.triangles.len())?;
        check_index(at, "material", mesh.material, "materials", self.materials.len())?;
        let lengths = [
            ("normals", mesh.normals.len()),
            ("tangents", mesh.tangents.len()),
            ("texture_coordinates", mesh.texture_coordinates.len()),
            ("second_texture_coordinates", mesh.second_texture_coordinates.len()),
            ("colors", mesh.colors.len()),
        ];
        for (list, length) in lengths {
            if length != 0 && length != vertices {
                let what = format!("has {length} entries for {vertices} vertices; give one each, or none");
                return Err(bad(format!("meshes[{k}].{list}"), what));
            }
        }
        check_all(k, "positions", &mesh.positions, |p| p.iter().all(|x| x.is_finite()), "must be finite")?;
        let unit = |n: &[f32; 3]| (squared_length(n.map(f64::from)) - 1.0).abs() <= NORMAL_TOLERANCE;
        check_all(k, "normals", &mesh.normals, unit, "must have length 1")?;
        let tangent = |t: &[f32; 4]| unit(&[t[0], t[1], t[2]]) && t[3].abs() == 1.0;
        check_all(k, "tangents", &mesh.tangents, tangent, "must have length 1 and the sign 1 or -1")?;
        let finite = |p: &[f32; 2]| p.iter().all(|x| x.is_finite());
        check_all(k, "texture_coordinates", &mesh.texture_coordinates, finite, "must be finite")?;
        check_all(k, "second_texture_coordinates", &mesh.second_texture_coordinates, finite, "must be finite")?;
        let share = |c: &[f32; 4]| c.iter().all(|x| (0.0..=1.0).contains(x));
        check_all(k, "colors", &mesh.colors, share, "must lie between 0 and 1")?;
        let inside = |t: &[u32; 3]| t.iter().all(|&v| (v as usize) < vertices);
        check_all(k, "triangles", &mesh.triangles, inside, &format!("refers beyond the {vertices} vertices"))
    }

    fn check_material(&self, k: usize, material: &Material) -> Result<(), Error> {
        let at = |field: &str| format!("materials[{k}].{field}");
        let share = |x: &f32| (0.0..=1.0).contains(x);
        let shares: [(&str, &[f32]); 6] = [
            ("base_color", &material.base_color),
            ("metallic", &[material.metallic]),
            ("roughness", &[material.roughness]),
            ("specular", &[material.specular]),
            ("transmission", &[material.transmission]),
            ("volume.attenuation_color", material.volume.as_ref().map_or(&[], |volume| &volume.attenuation_color)),
        ];
        for (field, values) in shares {
            if !values.iter().all(share) {
                return Err(bad(at(field), format!("is {values:?}; it must lie between 0 and 1")));
            }
        }
        check_layers(k, material)?;
        let strongest = f64::from(crate::MAX_RADIANCE);
        let positive: [(&str, &[f32]); 2] =
            [("emission", &material.emission), ("specular_color", &material.specular_color)];
        for (field, values) in positive {
            if !values.iter().all(|&x| (0.0..=strongest).contains(&f64::from(x))) {
                return Err(bad(at(field), format!("is {values:?}; it must lie between 0 and {strongest:e}")));
            }
        }
        if !(1.0..=1e3).contains(&material.ior) {
            return Err(bad(at("ior"), format!("is {}; it must lie between 1 and 1000", material.ior)));
        }
        if let Some(volume) = &material.volume {
            // Infinity means no absorption.
            if volume.attenuation_distance_m.is_nan() || volume.attenuation_distance_m <= 0.0 {
                return Err(bad(at("volume.attenuation_distance_m"), "must be above 0"));
            }
            // The renderer computes the logarithm.
            if !volume.attenuation_color.iter().all(|&c| c >= f32::MIN_POSITIVE) {
                let what = format!("is {:?}; it must be at least {:e}", volume.attenuation_color, f32::MIN_POSITIVE);
                return Err(bad(at("volume.attenuation_color"), what));
            }
        }
        if let Alpha::Mask(cutoff) = material.alpha
            && !(cutoff >= 0.0 && cutoff.is_finite())
        {
            return Err(bad(at("alpha"), format!("has the cutoff {cutoff}; it must be finite and at least 0")));
        }
        let coat_map = material.clearcoat.and_then(|coat| coat.normal_map);
        if coat_map.is_some_and(|map| !map.scale.is_finite()) {
            return Err(bad(at("clearcoat.normal_map.scale"), "must be finite"));
        }
        if material.normal_map.is_some_and(|map| !map.scale.is_finite()) {
            return Err(bad(at("normal_map.scale"), "must be finite"));
        }
        for (field, used) in material.textures() {
            check_index(|| format!("materials[{k}]"), field, used.texture, "textures", self.textures.len())?;
            if used.set > 1 {
                return Err(bad(at(field), format!("wants texture coordinates {}; a mesh has 0 and 1", used.set)));
            }
            let TextureTransform { offset, rotation_rad, scale } = used.transform;
            if !offset.iter().chain(&scale).chain(&[rotation_rad]).all(|x| x.is_finite()) {
                return Err(bad(at(field), "has a transform that is not finite"));
            }
        }
        Ok(())
    }

    fn check_environment(&self) -> Result<(), Error> {
        let Some(Environment { radiance }) = &self.environment else { return Ok(()) };
        let (rows, columns, channels) = radiance.dim();
        check_count("environment.radiance", radiance.len())?;
        if rows == 0 || columns == 0 || channels != 3 {
            let what = format!("is {rows} x {columns} x {channels}; give rows x columns x 3, at least one of each");
            return Err(bad("environment.radiance".into(), what));
        }
        match radiance.indexed_iter().find(|&(_, x)| !(0.0..=crate::MAX_RADIANCE).contains(x)) {
            None => Ok(()),
            Some(((v, u, c), x)) => {
                let what = format!("is {x}; it must lie between 0 and {:e}", crate::MAX_RADIANCE);
                Err(bad(format!("environment.radiance[{v}, {u}, {c}]"), what))
            }
        }
    }
}

/// Checks what the layers of a material have beyond textures.
fn check_layers(k: usize, material: &Material) -> Result<(), Error> {
    let fail = |field: &str, what: String| Err(bad(format!("materials[{k}].{field}"), what));
    let Material { clearcoat, sheen, anisotropy, iridescence, diffuse_transmission, .. } = material;
    let shares: [(&str, &[f32]); 8] = [
        ("clearcoat.factor", &[clearcoat.map_or(0.0, |coat| coat.factor)]),
        ("clearcoat.roughness", &[clearcoat.map_or(0.0, |coat| coat.roughness)]),
        ("sheen.color", &sheen.map_or([0.0; 3], |sheen| sheen.color)),
        ("sheen.roughness", &[sheen.map_or(0.0, |sheen| sheen.roughness)]),
        ("anisotropy.strength", &[anisotropy.map_or(0.0, |anisotropy| anisotropy.strength)]),
        ("iridescence.factor", &[iridescence.map_or(0.0, |film| film.factor)]),
        ("diffuse_transmission.factor", &[diffuse_transmission.map_or(0.0, |through| through.factor)]),
        ("diffuse_transmission.color", &diffuse_transmission.map_or([0.0; 3], |through| through.color)),
    ];
    for (field, values) in shares {
        if !values.iter().all(|x| (0.0..=1.0).contains(x)) {
            return fail(field, format!("is {values:?}; it must lie between 0 and 1"));
        }
    }
    if anisotropy.is_some_and(|anisotropy| !anisotropy.rotation_rad.is_finite()) {
        return fail("anisotropy.rotation_rad", "must be finite".into());
    }
    if let Some(film) = iridescence {
        if !(1.0..=1e3).contains(&film.ior) {
            return fail("iridescence.ior", format!("is {}; it must lie between 1 and 1000", film.ior));
        }
        if !film.thickness_nm.iter().all(|x| (0.0..=f32::MAX).contains(x)) {
            return fail("iridescence.thickness_nm", format!("is {:?}; it must be at least 0", film.thickness_nm));
        }
    }
    if !(0.0..=f32::MAX).contains(&material.dispersion) {
        return fail("dispersion", format!("is {}; it must be at least 0", material.dispersion));
    }
    Ok(())
}

fn bad(at: String, what: impl Into<String>) -> Error {
    Error::BadScene { at, what: what.into() }
}

fn check_count(list: &str, count: usize) -> Result<(), Error> {
    // The largest index is reserved: ray tracing engines use it for "no hit".
    if count < u32::MAX as usize {
        Ok(())
    } else {
        Err(bad(list.to_owned(), format!("has {count} entries; 2^32 - 2 fit")))
    }
}

fn check_index(at: impl Fn() -> String, field: &str, index: usize, list: &str, length: usize) -> Result<(), Error> {
    if index < length {
        return Ok(());
    }
    Err(bad(format!("{}.{field}", at()), format!("is {index}, but there are {length} {list}")))
}

/// Checks every entry of a list in parallel; reports the first one that fails.
fn check_all<T: Sync + std::fmt::Debug>(
    mesh: usize,
    list: &str,
    entries: &[T],
    good: impl Fn(&T) -> bool + Sync,
    what: &str,
) -> Result<(), Error> {
    // Chunks of 16 Ki entries: large enough for one task of a thread.
    let wrong = entries.par_chunks(1 << 14).enumerate().find_map_first(|(chunk, entries)| {
        let wrong = entries.iter().position(|entry| !good(entry))?;
        Some((chunk << 14) + wrong)
    });
    wrong.map_or(Ok(()), |k| Err(bad(format!("meshes[{mesh}].{list}[{k}]"), format!("{:?}: {what}", entries[k]))))
}

fn check_transform(at: impl Fn() -> String, field: &str, transform: &Transform) -> Result<(), Error> {
    if transform.is_finite() { Ok(()) } else { Err(bad(format!("{}.{field}", at()), "must be finite")) }
}

fn check_texture(k: usize, texture: &Texture) -> Result<(), Error> {
    let (width, height) = (texture.width, texture.height);
    let at = || format!("textures[{k}]");
    check_count(&format!("textures[{k}].width"), width)?;
    check_count(&format!("textures[{k}].height"), height)?;
    if width == 0 || height == 0 {
        return Err(bad(at(), format!("is {width} x {height} texels; it needs at least one")));
    }
    if width.checked_mul(height) == Some(texture.texels.len()) {
        return Ok(());
    }
    Err(bad(at(), format!("is {width} x {height} texels, but has {}", texture.texels.len())))
}

fn check_light(k: usize, light: &Light) -> Result<(), Error> {
    let at = |field: &str| format!("lights[{k}].{field}");
    let strongest = f64::from(crate::MAX_RADIANCE);
    if light.intensity.iter().any(|c| !(0.0..=strongest).contains(c)) {
        return Err(bad(
            at("intensity"),
            format!("is {:?}; it must lie between 0 and {:e}", light.intensity, crate::MAX_RADIANCE),
        ));
    }
    let (position, direction, range) = match light.kind {
        LightKind::Directional { direction, angular_diameter_rad } => {
            if !(0.0..=PI).contains(&angular_diameter_rad) {
                return Err(bad(at("angular_diameter_rad"), format!("is {angular_diameter_rad}; need 0 to pi")));
            }
            (None, Some(direction), None)
        }
        LightKind::Point { position, range } => (Some(position), None, range),
        LightKind::Spot { position, direction, range, inner_angle_rad: inner, outer_angle_rad: outer } => {
            if !(0.0 <= inner && inner <= outer && outer <= FRAC_PI_2) {
                let what = format!("are {inner} and {outer} rad; need 0 <= inner <= outer <= pi/2");
                return Err(bad(at("angles"), what));
            }
            (Some(position), Some(direction), range)
        }
    };
    if position.is_some_and(|position| position.iter().any(|x| !x.is_finite())) {
        return Err(bad(at("position"), "must be finite"));
    }
    // NaN fails this comparison.
    if direction.is_some_and(|direction| !is_near(squared_length(direction).sqrt(), 1.0)) {
        return Err(bad(at("direction"), "must have length 1"));
    }
    if range.is_some_and(|range| !(range > 0.0 && range.is_finite())) {
        return Err(bad(at("range"), "must be finite and above 0; leave it out for a light without one"));
    }
    Ok(())
}

impl Transform {
    /// Whether the transform is a pose: finite, a rotation and a translation without scale or mirroring (to 1e-6).
    #[must_use]
    pub fn is_pose(&self) -> bool {
        let [x, y, z] = self.columns;
        let unit = [x, y, z].iter().all(|axis| is_near(squared_length(*axis).sqrt(), 1.0));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let square = [dot(x, y), dot(y, z), dot(z, x)].iter().all(|&cosine| is_near(cosine, 0.0));
        self.is_finite() && unit && square && self.determinant() > 0.0
    }
}

fn check_camera(k: usize, camera: &Camera) -> Result<(), Error> {
    let at = |field: &str| format!("cameras[{k}].{field}");
    check_transform(|| format!("cameras[{k}]"), "pose", &camera.pose)?;
    if !camera.pose.is_pose() {
        return Err(bad(at("pose"), "must be a rotation and a translation, without scale or mirroring"));
    }
    let positive = |x: f64| x > 0.0 && x.is_finite();
    let good = match camera.projection {
        CameraProjection::Perspective { vertical_angle_rad, aspect_ratio } => {
            positive(vertical_angle_rad) && vertical_angle_rad < PI && aspect_ratio.is_none_or(positive)
        }
        CameraProjection::Orthographic { half_width_m, half_height_m } => {
            positive(half_width_m) && positive(half_height_m)
        }
    };
    if good {
        return Ok(());
    }
    Err(bad(at("projection"), format!("is {:?}; need 0 < angle < pi and sizes above 0", camera.projection)))
}

fn is_near(x: f64, wanted: f64) -> bool {
    (x - wanted).abs() <= DIRECTION_TOLERANCE
}

fn squared_length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum()
}
