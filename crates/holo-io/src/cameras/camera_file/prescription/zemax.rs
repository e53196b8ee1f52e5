//! Prescriptions of Zemax: what sequential files of refracting lenses need.

use holo_core::plenoptic::{Medium, Surface};

use super::{Row, by_numbers, glass};

/// What a block `SURF` says.
#[derive(Default)]
struct Block {
    line: usize,
    kind: String,
    curvature: f64,
    /// `None`: infinite.
    thickness: Option<f64>,
    glass: Option<(String, f64, f64)>,
    semi_aperture: f64,
    conic: f64,
    /// Of r^2, r^4 and so on.
    parameters: Vec<f64>,
    is_stop: bool,
}

pub(super) fn surfaces(text: &str) -> Result<Vec<Surface>, String> {
    let (blocks, unit_mm) = blocks(text)?;
    // The first is the object and the last the image.
    let Some((_, [lens @ .., _])) = blocks.split_first() else { return Err("it has no surfaces".into()) };
    let read =
        |block: &Block| row(block, unit_mm).map(Row::surface).map_err(|why| format!("line {}: {why}", block.line));
    lens.iter().map(read).collect()
}

/// The blocks of a file, and its unit of length in mm.
fn blocks(text: &str) -> Result<(Vec<Block>, f64), String> {
    let (mut blocks, mut unit_mm): (Vec<Block>, f64) = (Vec::new(), 1.0);
    for (line, text) in text.lines().enumerate().map(|(k, text)| (k + 1, text)) {
        let mut words = text.split_whitespace();
        let Some(key) = words.next() else { continue };
        let rest: Vec<&str> = words.collect();
        let number = |k: usize| {
            let word = rest.get(k).copied().unwrap_or_default();
            let found = word.parse::<f64>().ok().filter(|value| value.is_finite());
            found.ok_or_else(|| format!("line {line}: '{}' is no number for {key}", crate::shown(word)))
        };
        match (key, blocks.last_mut()) {
            ("UNIT", _) => {
                unit_mm = match rest.first().copied().unwrap_or_default() {
                    "MM" => 1.0,
                    "CM" => 10.0,
                    "IN" => 25.4,
                    "METER" | "M" => 1e3,
                    other => return Err(format!("line {line}: the unit '{}' is not read", crate::shown(other))),
                }
            }
            ("MODE", _) if rest.first() != Some(&"SEQ") => return Err(format!("line {line}: it is not sequential")),
            ("SURF", _) => blocks.push(Block { line, thickness: Some(0.0), ..Block::default() }),
            ("STOP", Some(block)) => block.is_stop = true,
            ("TYPE", Some(block)) => block.kind = rest.first().copied().unwrap_or_default().into(),
            ("CURV", Some(block)) => block.curvature = number(0)?,
            ("DISZ", Some(block)) => {
                block.thickness = if rest.first() == Some(&"INFINITY") { None } else { Some(number(0)?) };
            }
            ("GLAS", Some(block)) => {
                let name = rest.first().copied().unwrap_or_default();
                block.glass = Some((name.into(), number(3).unwrap_or(0.0), number(4).unwrap_or(0.0)));
            }
            ("DIAM", Some(block)) => block.semi_aperture = number(0)?,
            ("CONI", Some(block)) => block.conic = number(0)?,
            ("PARM", Some(block)) => {
                let index = number(0)?;
                if !(1.0..=8.0).contains(&index) {
                    continue;
                }
                let index = index as usize;
                block.parameters.resize(index.max(block.parameters.len()), 0.0);
                block.parameters[index - 1] = number(1)?;
            }
            _ => {}
        }
    }
    Ok((blocks, unit_mm))
}

fn row(block: &Block, unit_mm: f64) -> Result<Row, String> {
    let is_aspheric = block.kind == "EVENASPH";
    if !is_aspheric && block.kind != "STANDARD" {
        return Err(format!("a surface of type {}; STANDARD and EVENASPH are read", crate::shown(&block.kind)));
    }
    let thickness = block.thickness.ok_or("a surface within the lens has an infinite thickness")?;
    if block.semi_aperture <= 0.0 {
        return Err("a surface has no DIAM, its semi-aperture".into());
    }
    let medium = match &block.glass {
        None => Medium::Air,
        Some((name, ..)) if name == "MIRROR" => return Err("a mirror; only refracting lenses are read".into()),
        Some((name, nd, vd)) => match glass(name) {
            Ok(found) => found,
            Err(_) if *nd > 1.0 => by_numbers(*nd, *vd),
            Err(why) => return Err(why),
        },
    };
    let parameters = if is_aspheric { block.parameters.as_slice() } else { &[] };
    if parameters.first().is_some_and(|&a| a != 0.0) {
        return Err("a sag with a term of r^2; bring that into the curvature".into());
    }
    // Coefficients of a sag in the unit, as lengths of it.
    let scaled = |(a, k): (&f64, i32)| a / unit_mm.powi(3 + 2 * k);
    Ok(Row {
        radius_mm: if block.curvature == 0.0 { 0.0 } else { unit_mm / block.curvature },
        thickness_mm: unit_mm * thickness,
        semi_aperture_mm: unit_mm * block.semi_aperture,
        medium,
        conic: block.conic,
        aspheric: parameters.iter().skip(1).zip(0..).map(scaled).collect(),
        is_stop: block.is_stop,
    })
}
