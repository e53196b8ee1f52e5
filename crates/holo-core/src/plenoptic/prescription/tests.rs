use super::*;

fn medium(nd: f64) -> Medium {
    Medium::Abbe { nd, vd: None }
}

/// The height and the slope of rays of the plane x, y = 0 that start at heights in a plane behind the last surface.
fn traced(lens: &Prescription, behind_m: f64, height_m: f64, slope: f64) -> Option<[f64; 2]> {
    let mut rays = LensRays::new([[height_m], [0.0]], -behind_m, [[slope], [0.0]]);
    let [origin, direction] = TracedLens::new(lens, glass::D_LINE_NM).trace(&mut rays);
    (rays.clearance[0] >= 0.0).then_some([origin[0][0], direction[0][0]])
}

/// A plane and a hyperboloid of the conic constant -n^2 collimate all light of the focus of the hyperboloid.
#[test]
fn a_hyperboloid_collimates() {
    let n: f64 = 1.6;
    let surfaces = vec![
        Surface { is_stop: true, ..Surface::sphere(0.0, 0.02, 0.03, medium(n)) },
        Surface { conic: -n * n, ..Surface::sphere(-0.03, 0.0, 0.03, Medium::Air) },
    ];
    let lens = Prescription::new(surfaces).expect("a lens");
    let focus_m = 0.03 / (n - 1.0);
    assert!((lens.paraxial().focal_length_m - focus_m).abs() < 1e-15);
    for k in 1..=40 {
        let slope = f64::from(k) * 0.01;
        let [height, direction] = traced(&lens, focus_m, 0.0, slope).expect("light passes");
        // By Snell's law in polar form the height of the ray grows with the slope; it leaves along the axis.
        assert!(direction.abs() < 1e-14, "{slope}: {direction}");
        assert!(height > 0.0);
    }
    // The same surface with coefficients that are 0 takes the way of aspheric ones.
    let mut same = lens.surfaces().to_vec();
    same[1].aspheric = vec![0.0, 0.0];
    let same = Prescription::new(same).expect("a lens");
    for k in 1..=40 {
        let slope = f64::from(k) * 0.01;
        let (found, expected) = (traced(&same, focus_m, 1e-3, slope), traced(&lens, focus_m, 1e-3, slope));
        let (found, expected) = (found.expect("light passes"), expected.expect("light passes"));
        assert!((found[0] - expected[0]).abs() < 1e-15 && (found[1] - expected[1]).abs() < 1e-14);
    }
}

/// A sphere images its aplanatic point without aberration: light towards the point n R from the center of a ball of index n seems
/// to come from R / n.
#[test]
fn a_sphere_has_aplanatic_points() {
    let (n, radius) = (1.5, 0.05);
    let surfaces = vec![
        Surface::sphere(radius, 0.02, 0.049, medium(n)),
        Surface { is_stop: true, ..Surface::sphere(0.0, 0.0, 0.049, Medium::Air) },
    ];
    let lens = TracedLens::new(&Prescription::new(surfaces).expect("a lens"), glass::D_LINE_NM);
    // Within the glass the rays cross the axis R / n behind the center of the sphere, and in front of it n R behind the center.
    let inside_m = radius + radius / n;
    for k in 1..=20 {
        let angle = f64::from(k) * 0.02;
        // Where the ray crosses the plane, and its slope behind it.
        let height = (inside_m - 0.02) * angle.tan();
        let sine = n * angle.sin();
        let slope = sine / (1.0 - sine * sine).sqrt();
        let mut rays = LensRays::new([[height], [0.0]], 0.0, [[slope], [0.0]]);
        let [origin, direction] = lens.trace(&mut rays);
        assert!(rays.clearance[0] >= 0.0);
        // Where it crosses the axis, from the first surface towards the sensor.
        let at_front = origin[0][0] + lens.front_depth_m() * direction[0][0];
        let behind = at_front / direction[0][0];
        assert!((behind - (radius + n * radius)).abs() < 1e-12, "{angle}: {behind}");
    }
}

/// The sag of an aspheric surface is where its rays end.
#[test]
fn aspheric_surfaces_are_met() {
    let surface =
        Surface { aspheric: vec![40.0, -3e4, 1e6], conic: -0.7, ..Surface::sphere(0.05, 0.0, 0.02, Medium::Air) };
    let stop = Surface::stop(0.01, 0.02);
    let weak = vec![
        stop,
        Surface { medium: medium(1.5), thickness_m: 0.004, ..surface },
        Surface::sphere(-0.2, 0.0, 0.02, Medium::Air),
    ];
    let lens = Prescription::new(weak).expect("a lens");
    let (c, k) = (1.0 / 0.05, -0.7);
    let sag = |x: f64| {
        let squared = x * x;
        c * squared / (1.0 + (1.0 - (1.0 + k) * c * c * squared).sqrt()) + 40.0 * squared.powi(2)
            - 3e4 * squared.powi(3)
            + 1e6 * squared.powi(4)
    };
    // Traced by hand: the ray in the glass is bisected against the sag, and refracted at a normal of differences.
    for height in [-0.012, -0.004, 0.003, 0.015] {
        let slope = 0.1;
        let Some([_, direction]) = traced(&lens, 0.03, height, slope) else { panic!("light passes at {height}") };
        // First the rear sphere, by bisection too; z towards the scene from the last surface.
        let rear = |x: f64| 0.2 - (0.2f64 * 0.2 - x * x).sqrt();
        let meet = |from: [f64; 2], slope: f64, surface: &dyn Fn(f64) -> f64| {
            let (mut low, mut high) = (0.0, 0.06);
            for _ in 0..200 {
                let middle = (low + high) / 2.0;
                let x = from[0] + slope * (middle - from[1]);
                if middle < surface(x) { low = middle } else { high = middle }
            }
            [from[0] + slope * (low - from[1]), low]
        };
        let refract = |slope: f64, normal_slope: f64, ratio: f64| {
            // Angles to the axis: of the ray, and of the normal.
            let (ray, normal) = (slope.atan(), -normal_slope.atan());
            (((ray - normal).sin() * ratio).asin() + normal).tan()
        };
        let gradient = |surface: &dyn Fn(f64) -> f64, x: f64| (surface(x + 1e-7) - surface(x - 1e-7)) / 2e-7;
        let first = meet([height, -0.03], slope, &rear);
        let inside = refract(slope, gradient(&rear, first[0]), 1.0 / 1.5);
        let front = |x: f64| 0.004 - sag(x);
        let second = meet(first, inside, &front);
        let outside = refract(inside, gradient(&front, second[0]), 1.5);
        // The differences of the gradient leave eight digits.
        assert!((direction - outside).abs() < 1e-8, "{height}: {direction} {outside}");
    }
}

/// The objectives have the focal lengths and f-numbers of their patents.
#[test]
fn objectives_are_those_of_their_patents() {
    // The focal lengths of these transcriptions, 100 unless their units are others, and the distances of the images.
    for (name, f_number, back_focal, tolerance) in [
        ("double-gauss", 2.0, 0.72228 / 0.9999, 0.01),
        // The focal length of the patent is 1, of three digits, and 1.005 here; the distance is that of a calculation apart.
        ("double-gauss-baker", 2.0, 0.632767 / 1.004990, 1e-5),
        ("double-gauss-fast", 1.1, 0.55724 / 0.99446, 0.01),
        ("petzval", 2.2, 0.56475 / 0.99945, 0.01),
        ("retrofocus", 2.0, 36.386628 / 34.999868, 1e-5),
        ("telephoto", 2.8, 41.260824 / 180.004, 1e-5),
        ("tessar", 5.5, 0.9007, 0.01),
        ("triplet", 2.7, 0.7934, 1e-4),
    ] {
        let objective = Objective::by_name(name).expect("an objective");
        let lens = objective.prescription().expect("a lens");
        let paraxial = lens.paraxial();
        assert!((paraxial.f_number / f_number - 1.0).abs() < 0.04, "{name}: {paraxial:?}");
        let found = paraxial.back_focal_m / paraxial.focal_length_m;
        assert!((found / back_focal - 1.0).abs() < tolerance, "{name}: {found} {back_focal}");
        // The pupils are images of each other.
        let (f, w) = (paraxial.focal_length_m, paraxial.exit_pupil_from_principal_m());
        assert!((f * w / (w - f) - paraxial.entrance_pupil_from_principal_m()).abs() < 1e-12, "{name}");
    }
    assert_eq!(objectives().len(), 8);
}

/// Surfaces of the telephoto that move focus it, while sensor and front stay: rays near the axis that are traced meet at the depth.
#[test]
fn a_group_focuses() {
    let lens = Objective::by_name("telephoto").expect("an objective").prescription().expect("a lens");
    let length = |lens: &Prescription| -> f64 { lens.paraxial().length_m };
    let sensor_m = length(&lens) + lens.paraxial().back_focal_m;
    for (group, depths_m) in [(7..=10, [1e4, 20.0, 5.0]), (0..=5, [1e4, 20.0, 2.5]), (4..=5, [1e4, 100.0, 30.0])] {
        let mut moved_m = 0.0;
        for depth_m in depths_m {
            let found =
                lens.focused_by(group.clone(), depth_m).unwrap_or_else(|why| panic!("{group:?} {depth_m}: {why}"));
            // Where the sensor is: as far from a surface that stays.
            let behind_m = match *group.start() {
                0 => lens.paraxial().back_focal_m,
                _ => sensor_m - length(&found),
            };
            let [height, slope] = traced(&found, behind_m, 0.0, 1e-5).expect("light passes");
            // From the entrance pupil, where rays are returned.
            assert!((-height / slope / depth_m - 1.0).abs() < 1e-5, "{group:?} {depth_m}: {}", -height / slope);
            let (number, last) = (*group.start(), *group.end());
            let by_m = match number {
                0 => found.surfaces()[last].thickness_m - lens.surfaces()[last].thickness_m,
                _ => found.surfaces()[number - 1].thickness_m - lens.surfaces()[number - 1].thickness_m,
            };
            assert!(by_m.abs() > moved_m, "{group:?} moves by {by_m}, before by {moved_m}");
            moved_m = by_m.abs();
        }
        assert_eq!(lens.focused_by(group, f64::INFINITY).expect("a lens"), lens);
    }
    let why = |group, depth_m| lens.focused_by(group, depth_m).expect_err("no focus").to_string();
    assert!(why(7..=10, 0.2).contains("within the space around them"));
    assert!(why(7..=11, 5.0).contains("surfaces that focus") && why(0..=10, 5.0).contains("not all"));
    assert!(why(8..=10, 5.0).contains("as a whole"));
}

#[test]
fn glasses_have_the_indices_of_their_catalog() {
    // nd and vd of the data sheets.
    for (name, nd, vd) in
        [("N-BK7", 1.51680, 64.17), ("SF6", 1.80518, 25.43), ("N-SK16", 1.62041, 60.32), ("F2", 1.62004, 36.37)]
    {
        let glass = Medium::Glass(Glass::by_name(name).expect("a glass"));
        let found = glass.index(glass::D_LINE_NM);
        assert!((found - nd).abs() < 6e-6, "{name}: {found}");
        let abbe = (found - 1.0) / (glass.index(486.1327) - glass.index(656.2725));
        assert!((abbe - vd).abs() < 0.006, "{name}: {abbe}");
        // By its numbers.
        let simple = Medium::Abbe { nd, vd: Some(vd) };
        for nm in [450.0, 500.0, 600.0, 700.0] {
            assert!((simple.index(nm) - glass.index(nm)).abs() < 3e-3, "{name} at {nm}");
        }
    }
    assert!(glasses().iter().all(|glass| (1.4..2.1).contains(&glass.index(550.0))));
}

#[test]
fn impossible_lenses_are_refused() {
    let good = vec![
        Surface::sphere(0.05, 0.005, 0.01, medium(1.5)),
        Surface::sphere(-0.05, 0.001, 0.01, Medium::Air),
        Surface::stop(0.0, 0.008),
    ];
    assert!(Prescription::new(good.clone()).is_ok());
    let changed = |change: &dyn Fn(&mut Vec<Surface>)| {
        let mut surfaces = good.clone();
        change(&mut surfaces);
        Prescription::new(surfaces).expect_err("an impossible lens").to_string()
    };
    assert!(changed(&|s| s.clear()).contains("surfaces"));
    assert!(changed(&|s| s[2].is_stop = false).contains("stops"));
    assert!(changed(&|s| s[0].is_stop = true).contains("stops"));
    assert!(changed(&|s| s[0].radius_m = f64::NAN).contains("radius"));
    assert!(changed(&|s| s[0].thickness_m = -1.0).contains("thickness"));
    assert!(changed(&|s| s[0].semi_aperture_m = 0.0).contains("semi-aperture"));
    assert!(changed(&|s| s[0].medium = medium(0.5)).contains("index"));
    assert!(changed(&|s| s[2].medium = medium(1.5)).contains("behind the last"));
    assert!(changed(&|s| s[0].medium = Medium::Abbe { nd: 1.5, vd: Some(0.0) }).contains("Abbe"));
    assert!(changed(&|s| s[0].radius_m = -0.04).contains("focal length"));
    assert!(changed(&|s| s[0].aspheric = vec![0.0; 9]).contains("coefficients"));
    assert!(changed(&|s| s[0].conic = f64::INFINITY).contains("conic"));
    let lens = Prescription::new(good).expect("a lens");
    assert!(lens.stopped_down(1.0).is_err() && lens.scaled_to(0.0).is_err());
    assert!((lens.stopped_down(8.0).expect("a lens").paraxial().f_number - 8.0).abs() < 1e-12);
    let scaled = lens.scaled_to(0.1).expect("a lens");
    assert!((scaled.paraxial().focal_length_m - 0.1).abs() < 1e-15);
    assert!((scaled.paraxial().f_number - lens.paraxial().f_number).abs() < 1e-12);
}

/// The lens of the reference that is no objective: conic and aspheric.
fn asphere() -> Prescription {
    let glass = |nd, vd| Medium::Abbe { nd, vd: Some(vd) };
    let front = Surface::sphere(0.03, 0.006, 0.014, glass(1.6, 50.0));
    let rear = Surface::sphere(-0.09, 0.002, 0.014, Medium::Air);
    Prescription::new(vec![
        Surface { conic: -0.8, aspheric: vec![2e-6 * 1e9, -3e-9 * 1e15], ..front },
        Surface { aspheric: vec![4e-6 * 1e9], ..rear },
        Surface::stop(0.003, 0.008),
        Surface::sphere(-0.06, 0.002, 0.012, glass(1.7, 30.0)),
        Surface::sphere(0.2, 0.0, 0.012, Medium::Air),
    ])
    .expect("a lens")
}

/// Every ray that Optiland 0.6.3 traced from the scene to the sensor comes back the same way, at three wavelengths; and pupils and
/// focal lengths are its. Remade by `crates/holo-bench/peers/optiland_rays.py`.
#[test]
fn rays_are_those_of_optiland() {
    let (mut rays, mut lenses) = (0, 0);
    let mut all: std::collections::BTreeMap<&str, [f64; 2]> = std::collections::BTreeMap::new();
    for line in include_str!("tests/optiland.csv").lines() {
        let mut words = line.split(',');
        let (kind, name) = (words.next().expect("a kind"), words.next().expect("a name"));
        let numbers: Vec<f64> = words.map(|word| word.parse().expect("a number")).collect();
        let lens = Objective::by_name(name).map_or_else(asphere, |objective| objective.prescription().expect("a lens"));
        if kind == "lens" {
            let found = Paraxial::at(lens.surfaces(), numbers[0]).expect("a lens");
            // Its image is 1 mm behind the last surface.
            let expected = [numbers[1], numbers[2] + 1.0, numbers[3], numbers[4] + 1.0, numbers[1] / numbers[5]];
            let found = [
                found.focal_length_m * 1e3,
                found.back_focal_m * 1e3,
                found.entrance_pupil_m * 1e3,
                found.exit_pupil_m * 1e3,
                found.f_number,
            ];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-9, "{name}: {found} {expected}");
            }
            lenses += 1;
            continue;
        }
        let &[nm, x, y, sx, sy, bx, by, tx, ty] = numbers.as_slice() else { panic!("{line}") };
        let traced = TracedLens::new(&lens, nm);
        let worst = all.entry(name).or_default();
        // Places and slopes turn with the axis.
        let mut ray = LensRays::new([[bx * 1e-3], [by * 1e-3]], -1e-3, [[-tx], [-ty]]);
        let [origin, direction] = traced.trace(&mut ray);
        let front_m = traced.front_depth_m();
        for (axis, (place, slope)) in [(x, sx), (y, sy)].into_iter().enumerate() {
            let found = origin[axis][0] + front_m * direction[axis][0];
            worst[0] = worst[0].max((found - place * 1e-3).abs());
            worst[1] = worst[1].max((direction[axis][0] + slope).abs());
        }
        rays += 1;
    }
    assert!(rays > 550 && lenses == 18, "{rays} {lenses}");
    println!("{rays} rays: {all:?}");
    for (name, [place_m, slope]) in all {
        assert!(place_m < 1e-15 && slope < 1e-13, "{name}: {place_m:e} m, {slope:e}");
    }
}
