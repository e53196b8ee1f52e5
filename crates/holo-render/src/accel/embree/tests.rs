//! What Embree writes into packets.

use super::*;
use crate::accel::tests::{instanced_soup, soup};

/// A packet between two canaries of known bytes.
#[repr(C, align(64))]
struct WithCanaries<T> {
    before: [u8; 256],
    inner: T,
    after: [u8; 256],
}

/// The installed version writes into the packet and nowhere else.
#[test]
fn embree_writes_nothing_outside_our_packets() {
    for geometry in [soup(500, 1), instanced_soup(500, 1)] {
        nothing_outside_is_written(&Arc::new(geometry));
    }
}

fn nothing_outside_is_written(geometry: &Arc<Geometry>) {
    let mut engine = match Embree::build(geometry, 1) {
        Ok(engine) => engine,
        Err(why) => {
            crate::peer::missing(&format!("Embree 4: {why}"));
            return;
        }
    };
    for coherence in [Coherence::Coherent, Coherence::Incoherent] {
        let valid = Lanes([-1; LANES]);
        let mut packet = WithCanaries { before: [0xA5; 256], inner: RayHits::EMPTY, after: [0x5A; 256] };
        let mut shadow = WithCanaries { before: [0xA5; 256], inner: Rays::EMPTY, after: [0x5A; 256] };
        for lane in 0..LANES {
            packet.inner.rays.direction[0][lane] = lane as f32 * 0.02 - 0.15;
        }
        shadow.inner.direction = packet.inner.rays.direction;
        // Those of eight, whichever width the engine chose.
        let mut half = WithCanaries { before: [0xA5; 256], inner: Half::of(&packet.inner, 1), after: [0x5A; 256] };
        let mut of_half =
            WithCanaries { before: [0xA5; 256], inner: Half::of_rays(&shadow.inner, 1), after: [0x5A; 256] };
        let arguments = QueryArguments::new(coherence);
        // SAFETY: as in `Embree::intersect` and `Embree::occluded`.
        unsafe {
            let (valid, scene) = (valid.0.as_ptr(), engine.scene.as_ptr());
            (engine.api.rtcIntersect8)(valid, scene, (&raw mut half.inner).cast(), &raw const arguments);
            (engine.api.rtcOccluded8)(valid, scene, (&raw mut of_half.inner).cast(), &raw const arguments);
        }
        let (mut hits, mut ends) = (packet.inner, shadow.inner);
        half.inner.write(&mut hits, 1);
        of_half.inner.write_ends(&mut ends, 1);
        assert!(hits.hits.triangle.iter().any(|&k| k != NO_TRIANGLE) && ends.far.contains(&f32::NEG_INFINITY));

        engine.halves = false;
        engine.intersect(&valid, &mut packet.inner, Coherence::Coherent);
        engine.occluded(&valid, &mut shadow.inner, coherence);
        assert!(packet.inner.hits.triangle.iter().any(|&k| k != NO_TRIANGLE), "the rays must hit something");
        assert!(shadow.inner.far.contains(&f32::NEG_INFINITY), "the shadow rays must hit something");
        for canaries in [
            [&packet.before, &packet.after],
            [&shadow.before, &shadow.after],
            [&half.before, &half.after],
            [&of_half.before, &of_half.after],
        ] {
            assert!(canaries[0].iter().all(|&b| b == 0xA5), "wrote before the packet");
            assert!(canaries[1].iter().all(|&b| b == 0x5A), "wrote behind the packet");
        }
    }
}

/// Halves of packets have the hits of whole ones, whichever lanes are valid, and leave the others alone.
#[test]
fn halves_have_the_hits_of_whole_packets() {
    for geometry in [soup(500, 1), instanced_soup(500, 1)].map(Arc::new) {
        let mut engine = match Embree::build(&geometry, 1) {
            Ok(engine) => engine,
            Err(why) => {
                crate::peer::missing(&format!("Embree 4: {why}"));
                return;
            }
        };
        let (mut state, mut count) = (7, 0);
        for round in 0..400 {
            let mut random = || crate::accel::tests::random(&mut state);
            let valid = Lanes(std::array::from_fn(|lane| match round % 4 {
                0 => -1,
                1 => -i32::from(lane < 8),
                2 => -i32::from(lane == 15),
                _ => -i32::from(random() < 0.5),
            }));
            let mut packet = RayHits::EMPTY;
            for lane in 0..LANES {
                for axis in 0..2 {
                    packet.rays.origin[axis][lane] = random() as f32 - 0.5;
                    packet.rays.direction[axis][lane] = random() as f32 - 0.5;
                }
                (packet.hits.triangle[lane], packet.hits.u[lane]) =
                    (if valid.0[lane] == 0 { 3 } else { NO_TRIANGLE }, 0.25);
            }
            let coherence = if round % 8 < 4 { Coherence::Coherent } else { Coherence::Incoherent };
            let found = [false, true].map(|halves| {
                engine.halves = halves;
                let (mut packet, mut shadow) = (packet, packet.rays);
                engine.intersect(&valid, &mut packet, coherence);
                engine.occluded(&valid, &mut shadow, coherence);
                (packet, shadow)
            });
            let [(whole, of_whole), (halved, of_halved)] = found;
            assert_eq!(halved.hits.triangle, whole.hits.triangle, "round {round}");
            assert_eq!(halved.hits.instance, whole.hits.instance, "round {round}");
            assert_eq!(of_halved.far, of_whole.far, "round {round}");
            for lane in 0..LANES {
                // Equal bits are not promised for two widths: a reciprocal may differ in its last bit, 6e-8. The bound is 170
                // times that, for triangles that are seen almost edge-on.
                let near = |a: f32, b: f32| a == b || (a - b).abs() <= 1e-5 * a.abs().max(1.0);
                let (a, b) = (&halved, &whole);
                assert!(
                    near(a.rays.far[lane], b.rays.far[lane]) && near(a.hits.u[lane], b.hits.u[lane]),
                    "round {round}"
                );
                count += usize::from(valid.0[lane] != 0 && a.hits.triangle[lane] != NO_TRIANGLE);
                assert!(valid.0[lane] != 0 || (a.hits.triangle[lane], a.hits.u[lane]) == (3, 0.25), "round {round}");
            }
        }
        assert!(count > 500, "{count} hits");
    }
}
