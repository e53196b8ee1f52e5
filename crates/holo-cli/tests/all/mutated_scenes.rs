//! Damaged .glb files through the binary: bit flips, overwritten bytes, truncations. Every run ends by itself with exit
//! code 0 or 1, soon, without a panic, and a failing render leaves nothing.
//!
//! 60 files, 1,000 with `HOLO_THOROUGH=1`.

use crate::common;
use std::process::Stdio;
use std::time::Duration;

use crate::common::{Bench, Outcome, SMALL};
use holo_scene::{Texture, TextureInfo, Wrap};

/// A small generator with a stable sequence (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// The tiny scene with a texture, so that an image decoder is among the victims.
fn original() -> Vec<u8> {
    let mut scene = common::tiny_scene();
    scene.meshes[0].texture_coordinates = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    scene.textures.push(Texture {
        name: "squares".into(),
        width: 8,
        height: 8,
        texels: (0..64).map(|k| [(k * 4) as u8, (k * 37) as u8, 200, 255]).collect(),
        wrap_u: Wrap::Mirror,
        wrap_v: Wrap::Clamp,
        filter: holo_scene::Filter::Linear,
    });
    scene.materials[0].base_color_texture = Some(TextureInfo::new(0));
    holo_scene::gltf::to_glb(&scene).unwrap()
}

fn mutated(original: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = original.to_vec();
    let json = u32::from_le_bytes(original[12..16].try_into().unwrap()) as usize;
    match random.below(8) {
        0 => bytes.truncate(random.below(original.len())),
        // Cut short with headers that agree: the chunks' contents must be looked at to notice.
        1 => {
            bytes.truncate(20 + json + 8 + random.below(original.len() - json - 28));
            let (total, binary) = (bytes.len() as u32, (bytes.len() - json - 28) as u32);
            bytes[8..12].copy_from_slice(&total.to_le_bytes());
            bytes[20 + json..24 + json].copy_from_slice(&binary.to_le_bytes());
        }
        // Digits for digits: JSON that stays JSON.
        2..=4 => {
            let digits: Vec<usize> = (20..20 + json).filter(|&at| bytes[at].is_ascii_digit()).collect();
            for _ in 0..=random.below(3) {
                bytes[digits[random.below(digits.len())]] = b'0' + random.below(10) as u8;
            }
        }
        // Floats, indices and texels.
        5 | 6 => {
            for _ in 0..=random.below(8) {
                let at = 20 + json + 8 + random.below(original.len() - json - 28);
                bytes[at] = [0, 0xFF, 0x7F, random.next() as u8][random.below(4)];
            }
        }
        _ => {
            for _ in 0..=random.below(8) {
                let at = random.below(bytes.len());
                bytes[at] ^= 1 << random.below(8);
            }
        }
    }
    bytes
}

/// Runs, and checks what holds for every run.
fn run(bench: &Bench, arguments: &str, what: &str) -> Outcome {
    let child = bench.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let outcome = common::wait(child, Duration::from_secs(10)).unwrap_or_else(|| panic!("{what}: {arguments}: hangs"));
    assert!(matches!(outcome.code, Some(0 | 1)), "{what}: {arguments}: {outcome:?}");
    assert!(!outcome.stderr.contains("panicked"), "{what}: {arguments}: {outcome:?}");
    outcome
}

#[test]
fn damaged_scenes_are_drawn_or_refused() {
    let count = if common::is_thorough() { 1000 } else { 60 };
    let bench = Bench::new();
    let original = original();
    let mut random = Random(2026);
    let (mut loaded, mut refused, mut slowest) = (0, 0, Duration::ZERO);
    for k in 0..count {
        let what = format!("mutation {k}");
        std::fs::write(bench.path("x.glb"), mutated(&original, &mut random)).unwrap();
        let info = run(&bench, &format!("info x.glb {SMALL} --threads 1"), &what);
        let render = run(&bench, &format!("render x.glb --out out {SMALL} --spp 1 --threads 1"), &what);
        slowest = slowest.max(info.took).max(render.took);
        assert_eq!(info.code, render.code, "{what}: {info:?} {render:?}");
        if render.code == Some(0) {
            loaded += 1;
            assert!(bench.list("out").contains(&"manifest.json".into()), "{what}");
            assert!(bench.list("out").iter().all(|name| !name.ends_with(".part")), "{what}");
            std::fs::remove_dir_all(bench.path("out")).unwrap();
        } else {
            refused += 1;
            assert!(render.stderr.contains("x.glb"), "{what}: which file? {render:?}");
            assert_eq!(bench.list(""), [common::SCENE, "x.glb"], "{what}");
        }
    }
    println!("{count} files: {loaded} drawn, {refused} refused; slowest run {slowest:.2?}");
    assert!(count < 60 || (loaded > 5 && refused > 5), "{loaded} drawn, {refused} refused: the damage is one-sided");
}
