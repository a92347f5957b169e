//! Minimum-zone planes and cylinders: constructed cases whose zone is known, proofs that refuse
//! what is spoilt, and the zone of any other direction.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::gauge::form::{
    FormError, Plane, certify_minimum_zone_plane, least_squares_plane, minimum_zone_cylinder,
    minimum_zone_plane,
};

/// Pseudo-random numbers between 0 and 1 (Knuth's linear congruential generator, upper bits).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// A plane askew with its two directions.
fn frame(draws: &mut Draws) -> (DVec3, DVec3, DVec3, DVec3) {
    let normal = DVec3::new(draws.between(-0.3, 0.3), draws.between(-0.3, 0.3), 1.0).normalize();
    let (u, v) = normal.any_orthonormal_pair();
    (DVec3::new(draws.between(-40.0, 40.0), draws.between(-40.0, 40.0), 7.0), u, v, normal)
}

/// Three contacts about one opposite contact: a zone of known width and middle, and `n` points
/// strictly inside it.
fn plane_case(draws: &mut Draws, n: usize) -> (Vec<DVec3>, f64, DVec3) {
    let (at, u, v, normal) = frame(draws);
    let half = 10_f64.powf(draws.between(-5.0, -2.0));
    let start = draws.between(0.0, TAU);
    let point = |radius: f64, angle: f64, height: f64| {
        at + u * (radius * angle.cos()) + v * (radius * angle.sin()) + normal * height
    };
    let mut points: Vec<DVec3> =
        (0..3).map(|k| point(45.0, start + TAU / 3.0 * f64::from(k), half)).collect();
    points.push(point(draws.between(0.0, 10.0), 1.0, -half));
    for _ in 0..n {
        let height = half * draws.between(-0.95, 0.95);
        points.push(point(50.0 * draws.next().sqrt(), draws.between(0.0, TAU), height));
    }
    (points, 2.0 * half, normal)
}

#[test]
fn planes_of_known_zone() {
    let mut draws = Draws(5);
    let mut worst = 0.0_f64;
    for _ in 0..60 {
        let (points, width, normal) = plane_case(&mut draws, 477);
        let fit = minimum_zone_plane(&points).unwrap();
        worst = worst.max((fit.peak_to_valley() - width).abs());
        assert!(fit.plane.normal.dot(normal) > 1.0 - 1e-12);
        assert!(fit.certificate.proven_within == f64::INFINITY, "{:?}", fit.certificate);
        let least = least_squares_plane(&points).unwrap();
        assert!(least.peak_to_valley() >= fit.peak_to_valley() - 1e-13);
    }
    println!("481 points, 60 planes: zone off by {worst:.1e} mm at most");
    assert!(worst < 1e-12, "{worst}");
}

#[test]
fn two_contacts_against_two_that_cross() {
    // A saddle: the zone of x² - y² over a square of half side 1 is 2.
    let grid = (-10..=10).flat_map(|i| (-10..=10).map(move |k| (f64::from(i) / 10.0, f64::from(k) / 10.0)));
    let points: Vec<DVec3> = grid.map(|(x, y)| DVec3::new(x, y, 1e-3 * (x * x - y * y))).collect();
    let fit = minimum_zone_plane(&points).unwrap();
    assert!((fit.peak_to_valley() - 2e-3).abs() < 1e-15, "{}", fit.peak_to_valley());
    assert_eq!(fit.certificate.proven_within, f64::INFINITY);
}

#[test]
fn a_spoilt_plane_has_no_proof() {
    let mut draws = Draws(9);
    let (points, width, _) = plane_case(&mut draws, 100);
    let fit = minimum_zone_plane(&points).unwrap();
    let tilted = Plane { normal: (fit.plane.normal + 1e-6 * DVec3::X).normalize(), ..fit.plane };
    let spoilt = certify_minimum_zone_plane(&points, tilted);
    assert_eq!(spoilt.proven_within, 0.0);
    assert!(spoilt.gap.is_infinite());
    // And no other direction is narrower.
    for _ in 0..2000 {
        let mut turned = || 1e-2 * draws.between(-1.0, 1.0);
        let normal = (fit.plane.normal + DVec3::new(turned(), turned(), turned())).normalize();
        let other = Plane { normal, ..fit.plane };
        let (low, high) = points
            .iter()
            .map(|p| other.deviation(*p))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(e), h.max(e)));
        assert!(high - low >= width - 1e-12);
    }
}

#[test]
fn the_least_squares_plane_is_that_of_the_normal_equations() {
    // z = 3 + 1e-5·x - 2e-5·y with residuals that are square to 1, x and y.
    let mut points = Vec::new();
    for k in 0..48 {
        let angle = TAU * f64::from(k) / 48.0;
        let (x, y) = (40.0 * angle.cos(), 40.0 * angle.sin());
        points.push(DVec3::new(x, y, 3.0 + 1e-5 * x - 2e-5 * y + 1e-4 * (2.0 * angle).cos()));
    }
    let fit = least_squares_plane(&points).unwrap();
    let slope = |n: DVec3| (-n.x / n.z, -n.y / n.z);
    let (a, b) = slope(fit.plane.normal);
    assert!((a - 1e-5).abs() < 1e-12 && (b + 2e-5).abs() < 1e-12, "{a} {b}");
    assert!((fit.peak_to_valley() - 2e-4).abs() < 1e-12);
}

#[test]
fn planes_that_are_none() {
    let line: Vec<DVec3> = (0..9).map(|k| DVec3::new(f64::from(k), 2.0 * f64::from(k), 1.0)).collect();
    assert!(matches!(
        minimum_zone_plane(&line),
        Err(FormError::Degenerate { feature: "minimum zone plane" })
    ));
    assert!(matches!(minimum_zone_plane(&line[..2]), Err(FormError::TooFew { found: 2, needed: 3, .. })));
    let flat: Vec<DVec3> = (0..9).map(|k| DVec3::new(f64::from(k % 3), f64::from(k / 3), 1.0)).collect();
    assert!(minimum_zone_plane(&flat).unwrap().peak_to_valley() < 1e-14);
}

/// Points of a cylinder askew: radius + the form at (angle, share of the length).
fn cylinder(points: [usize; 2], tilt: [f64; 2], form: impl Fn(f64, f64) -> f64) -> Vec<DVec3> {
    let axis = DVec3::new(tilt[0], tilt[1], 1.0).normalize();
    let u = (DVec3::X - axis * axis.x).normalize();
    let v = axis.cross(u);
    let [sections, around] = points;
    let at = |s: usize, k: usize| {
        let share = s as f64 / (sections - 1) as f64;
        let angle = TAU * k as f64 / around as f64;
        let r = 25.0 + form(angle, share);
        DVec3::new(3.0, -2.0, 10.0) + axis * (100.0 * share) + u * (r * angle.cos()) + v * (r * angle.sin())
    };
    (0..sections).flat_map(|s| (0..around).map(move |k| at(s, k))).collect()
}

#[test]
fn cylinders_of_known_zone() {
    // Two lobes and more at full size in every section: their zone is peak to valley, and the axis
    // cannot move. A barrel cannot be turned away either.
    for (what, width, form) in [
        ("three lobes", 4e-3, (&|a: f64, _: f64| 2e-3 * (3.0 * a).cos()) as &dyn Fn(f64, f64) -> f64),
        ("a barrel", 5e-3, &|_, s| 5e-3 * (1.0 - (2.0 * s - 1.0).powi(2))),
        ("a cone", 6e-3, &|_, s| 6e-3 * s),
    ] {
        let points = cylinder([51, 144], [1e-3, -2e-3], form);
        assert_eq!(points.len(), 7344);
        let found = minimum_zone_cylinder(&points).unwrap();
        println!("{what}: {:.9} µm, gap {:.1e}", 1e3 * found.width, found.gap);
        assert!((found.width - width).abs() < 1e-9, "{what}: {} mm", found.width);
        assert!((found.cylinder.slope_x - 1e-3).abs() < 1e-7, "{what}");
    }
}

#[test]
fn the_bent_cylinder_needs_half_its_sagitta() {
    // An axis bent by the sagitta s in one plane: shifted by s/2 the zone is s.
    let points = cylinder([41, 144], [0.0, 0.0], |a, s| 4e-3 * (1.0 - (2.0 * s - 1.0).powi(2)) * a.cos());
    let found = minimum_zone_cylinder(&points).unwrap();
    assert!((found.width - 4e-3).abs() < 2e-6, "{}", found.width);
    let least = crate::gauge::form::least_squares_cylinder(&points).unwrap();
    assert!(least.cyl_t > found.width + 1e-4, "{} {}", least.cyl_t, found.width);
}

#[test]
fn no_nearby_axis_is_better() {
    let mut draws = Draws(21);
    let noise: Vec<f64> = (0..1200).map(|_| 1e-3 * draws.next()).collect();
    let mut points = cylinder([20, 60], [2e-3, 1e-3], |a, s| 2e-3 * (2.0 * a).cos() + 1e-3 * s * a.sin());
    for (p, n) in points.iter_mut().zip(&noise) {
        let out = DVec3::new(p.x - 3.0, p.y + 2.0, 0.0).normalize();
        *p += out * *n;
    }
    let found = minimum_zone_cylinder(&points).unwrap();
    let width = |c: &crate::gauge::form::Cylinder| {
        let (low, high) = points
            .iter()
            .map(|p| c.deviation(*p))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(e), h.max(e)));
        high - low
    };
    assert!((width(&found.cylinder) - found.width).abs() < 1e-12);
    for k in 0..4000 {
        let size = 10_f64.powi(-(3 + k % 5));
        let mut other = found.cylinder;
        other.x0 += size * draws.between(-1.0, 1.0);
        other.y0 += size * draws.between(-1.0, 1.0);
        other.slope_x += 0.02 * size * draws.between(-1.0, 1.0);
        other.slope_y += 0.02 * size * draws.between(-1.0, 1.0);
        assert!(width(&other) >= found.width - 1e-9, "{} < {}", width(&other), found.width);
    }
}
