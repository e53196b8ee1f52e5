//! `holo render --shard` and `holo merge`: parts of a image make the image, byte for byte.

use crate::common::{Bench, SCENE};

#[test]
fn parts_make_the_whole() {
    let bench = Bench::new();
    for (number, (more, parts)) in [
        // Many views: whole elemental images are the tiles.
        ("--lenses 12x16 --views 10 --spp 2 --sky 0.2,0.3,0.4 --write el,vpi,mat,disparity,depth,exr", 3),
        // Few views: rows of lenses are.
        ("--lenses 40x190 --views 3x2 --spp 5 --sky 0.2,0.3,0.4 --ground-truth all --layers all", 4),
        ("--lenses 40x31 --views 4 --spp 64 --target-error 0.1 --sky 0.2,0.3,0.4 --bit-depth 16 --exposure -1", 2),
        // Parts render the margin that the reconstruction needs.
        ("--lenses 12x36 --views 9 --spp 2 --denoise views --layers color,visibility,error --write el,exr,masks", 2),
        ("--lenses 12x16 --lens-shifts 2 --views 5 --spp 3 --write el,vpi,exr", 2),
        ("--lenses 25x450 --views 1 --integrator depth", 3),
        ("--lenses 30x40 --views 5x4 --max-bounces 3 --integrator path --write hci --ground-truth all", 2),
    ]
    .into_iter()
    .enumerate()
    {
        let whole = bench.run(&format!("render {SCENE} --out whole{number} {more} --quiet"));
        assert_eq!(whole.code, Some(0), "{more}: {whole:?}");
        let mut folders = String::new();
        for part in (1..=parts).rev() {
            let folder = format!("part{number}_{part}");
            let threads = 1 + part % 2;
            let outcome = bench.run(&format!(
                "render {SCENE} --out {folder} {more} --shard {part}/{parts} --threads {threads} --quiet"
            ));
            assert_eq!(outcome.code, Some(0), "{more}: {outcome:?}");
            assert_eq!(bench.run(&format!("verify {folder}")).code, Some(0));
            folders += &format!(" {folder}");
        }
        let merged = bench.run(&format!("merge merged{number} {folders} --quiet"));
        assert_eq!((merged.code, merged.stderr.as_str()), (Some(0), ""), "{more}: {merged:?}");
        let (whole, merged) = (bench.bytes(&format!("whole{number}")), bench.bytes(&format!("merged{number}")));
        assert_eq!(whole.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>(), "{more}");
        for (name, bytes) in &whole {
            assert!(merged[name] == *bytes, "{more}: {name} differs");
        }
    }
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let bench = Bench::new();
    let part = |folder: &str, more: &str| {
        let outcome =
            bench.run(&format!("render {SCENE} --out {folder} --lenses 12x160 --views 3 --spp 1 --quiet {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
    };
    part("one", "--shard 1/2");
    part("two", "--shard 2/2");
    part("three", "--shard 2/3");
    part("seed", "--shard 2/2 --seed 4");
    part("whole", "");
    for (parts, code, message) in [
        ("one", 2, "2/2 missing"),
        ("one one two", 2, "part 1 of 2 is given twice"),
        ("one three", 1, "parts of different images"),
        ("one seed", 1, "parts of different images"),
        ("one whole", 2, "not a part"),
        ("one nowhere", 1, "nowhere"),
    ] {
        let outcome = bench.run(&format!("merge out {parts}"));
        assert_eq!(outcome.code, Some(code), "{parts}: {outcome:?}");
        assert!(outcome.stderr.contains(message), "{parts}: {outcome:?}");
        assert!(!bench.path("out").exists(), "{parts}");
    }
    let damaged = bench.path("two/color.pfm");
    let bytes = std::fs::read(&damaged).unwrap();
    std::fs::write(&damaged, &bytes[..bytes.len() - 4]).unwrap();
    let outcome = bench.run("merge out one two");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("color.pfm") && outcome.stderr.contains("--shard=2/2"), "{outcome:?}");
    assert!(!bench.path("out").exists());
}

#[test]
fn a_picture_has_only_so_many_parts() {
    let bench = Bench::new();
    let outcome = bench.run(&format!("render {SCENE} --out part --lenses 12x16 --views 3 --shard 7/1000"));
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("can be cut into"), "{outcome:?}");
    assert!(!bench.path("part").exists());
}
