//! Reference circles, lines and cylinders on constructed cases whose answer is known, to 1 nm, and
//! certificates that refuse a solution that is not optimal.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use shadowgauge::gauge::form::{
    Certificate, FormError, Line, Reference, StraightnessReference, certify_circumscribed, certify_inscribed,
    certify_least_squares, certify_minimum_zone, certify_minimum_zone_line, least_squares_circle,
    least_squares_cylinder, least_squares_line, maximum_inscribed_circle, minimum_circumscribed_circle,
    minimum_zone_circle, minimum_zone_line, roundness, silhouette_cylinder, straightness, taper,
};
use shadowgauge::profile::{Diameter, DiameterProfile, Reading, Reason, Station};

const NM: f64 = 1e-6;

/// Points at given radii around a centre.
fn at(centre: DVec2, polar: impl IntoIterator<Item = (f64, f64)>) -> Vec<DVec2> {
    polar.into_iter().map(|(angle, r)| centre + DVec2::from_angle(angle) * r).collect()
}

/// The worst result of several constructed cases.
#[derive(Default)]
struct Worst {
    cases: usize,
    error_mm: f64,
    gap_mm: f64,
}

impl Worst {
    fn see(&mut self, error_mm: f64, proof: &Certificate) {
        self.cases += 1;
        self.error_mm = self.error_mm.max(error_mm);
        self.gap_mm = self.gap_mm.max(proof.gap);
    }

    fn print(&self, what: &str) {
        let Self { cases, error_mm, gap_mm } = self;
        println!(
            "{what}: {cases} constructed cases, worst departure {:.1e} nm (limit 1), optimality certified to {:.1e} nm",
            1e6 * error_mm,
            1e6 * gap_mm
        );
    }
}

/// A case with four alternating contacts of an annulus and all else strictly inside it.
fn annulus_case(random: &mut Pcg64, n: usize) -> (Vec<DVec2>, DVec2, f64, f64) {
    let centre = DVec2::new(random.random_range(-40.0..40.0), random.random_range(-40.0..40.0));
    let radius = random.random_range(1.0..60.0);
    let half = radius * 10f64.powf(random.random_range(-6.0..-2.5));
    let start = random.random_range(0.0..TAU);
    let contact = |k: f64, jitter: f64, r: f64| (start + TAU / 4.0 * k + jitter, r);
    let mut polar: Vec<(f64, f64)> = (0..4)
        .map(|k| {
            let jitter = random.random_range(-0.5..0.5);
            contact(f64::from(k), jitter, radius + if k % 2 == 0 { half } else { -half })
        })
        .collect();
    polar.extend(
        (0..n).map(|_| (random.random_range(0.0..TAU), radius + random.random_range(-0.99..0.99) * half)),
    );
    (at(centre, polar), centre, radius - half, radius + half)
}

#[test]
fn minimum_zone_circle_of_constructed_cases_is_right_to_1_nm() {
    let mut random = Pcg64::seed_from_u64(1);
    let mut worst = Worst::default();
    for case in 0..300 {
        let (points, centre, inner, outer) = annulus_case(&mut random, 4 + 3 * case);
        let fit = minimum_zone_circle(&points).unwrap();
        let error = fit.circle.centre.distance(centre);
        assert!(error < NM, "case {case}: centre off by {error:e}");
        worst.see(
            error.max((fit.inner_radius - inner).abs()).max((fit.outer_radius - outer).abs()),
            &fit.certificate,
        );
        assert!((fit.inner_radius - inner).abs() < NM && (fit.outer_radius - outer).abs() < NM);
        let proof = &fit.certificate;
        assert!(proof.is_proven() && proof.gap < 1e-8 && proof.contacts.len() >= 4, "case {case}: {proof:?}");
    }
    worst.print("minimum-zone circle");
}

/// Three contacts at one radius that surround the centre; the rest on the other side of that
/// circle.
fn three_contacts(random: &mut Pcg64, n: usize, side: f64) -> (Vec<DVec2>, DVec2, f64) {
    let centre = DVec2::new(random.random_range(-40.0..40.0), random.random_range(-40.0..40.0));
    let radius = random.random_range(1.0..60.0);
    let form = radius * 10f64.powf(random.random_range(-6.0..-2.5));
    let start = random.random_range(0.0..TAU);
    let mut polar: Vec<(f64, f64)> =
        (0..3).map(|k| (start + TAU / 3.0 * f64::from(k) + random.random_range(-0.4..0.4), radius)).collect();
    polar.extend(
        (0..n)
            .map(|_| (random.random_range(0.0..TAU), radius + side * form * random.random_range(0.02..1.0))),
    );
    (at(centre, polar), centre, radius)
}

#[test]
fn inscribed_and_circumscribed_circles_of_constructed_cases_are_right_to_1_nm() {
    let mut random = Pcg64::seed_from_u64(2);
    let mut worst = [Worst::default(), Worst::default()];
    for case in 0..300 {
        let n = 20 + 3 * case;
        let (points, centre, radius) = three_contacts(&mut random, n, 1.0);
        let fit = maximum_inscribed_circle(&points).unwrap();
        assert!(fit.circle.centre.distance(centre) < NM && (fit.circle.radius - radius).abs() < NM, "{case}");
        assert!(fit.certificate.is_proven() && fit.certificate.gap < 1e-8, "{case}: {:?}", fit.certificate);
        let off = fit.circle.centre.distance(centre).max((fit.circle.radius - radius).abs());
        worst[0].see(off, &fit.certificate);
        let (points, centre, radius) = three_contacts(&mut random, n, -1.0);
        let fit = minimum_circumscribed_circle(&points).unwrap();
        assert!(fit.circle.centre.distance(centre) < NM && (fit.circle.radius - radius).abs() < NM, "{case}");
        assert!(fit.certificate.proven_within == f64::INFINITY && fit.certificate.gap < 1e-8, "{case}");
        let off = fit.circle.centre.distance(centre).max((fit.circle.radius - radius).abs());
        worst[1].see(off, &fit.certificate);
    }
    worst[0].print("maximum inscribed circle");
    worst[1].print("minimum circumscribed circle");
}

#[test]
fn two_opposed_points_can_determine_the_circumscribed_circle() {
    let points = [DVec2::new(3.0, 5.0), DVec2::new(3.0, -1.0), DVec2::new(5.5, 2.5), DVec2::new(1.0, 1.0)];
    let fit = minimum_circumscribed_circle(&points).unwrap();
    assert!(
        fit.circle.centre.distance(DVec2::new(3.0, 2.0)) < 1e-14 && (fit.circle.radius - 3.0).abs() < 1e-14
    );
    assert!(fit.certificate.is_proven());
}

#[test]
fn least_squares_circle_of_even_lobes_is_the_nominal_one_to_1_nm() {
    // Σ cos(kθ)·u = 0 at even angles for k ≥ 2: the nominal circle is stationary, exactly.
    let centre = DVec2::new(812.5, -377.25);
    let mut worst = Worst::default();
    for (lobes, amplitude) in [(2.0, 0.2), (3.0, 0.05), (17.0, 0.01), (50.0, 0.003)] {
        let polar = (0..720).map(|i| {
            let angle = TAU * f64::from(i) / 720.0;
            (angle, 25.0 + amplitude * (lobes * angle).cos())
        });
        let ls = least_squares_circle(&at(centre, polar)).unwrap();
        let circle = ls.fit.circle;
        assert!(circle.centre.distance(centre) < NM && (circle.radius - 25.0).abs() < NM);
        assert!((ls.rms - amplitude / 2f64.sqrt()).abs() < NM);
        let proof = &ls.fit.certificate;
        assert!(proof.is_proven() && proof.gap < NM && proof.proven_within > 0.5, "{proof:?}");
        worst.see(circle.centre.distance(centre).max((circle.radius - 25.0).abs()), proof);
    }
    worst.print("least-squares circle");
}

#[test]
fn least_squares_circle_of_a_short_arc_is_right() {
    let centre = DVec2::new(-3.0, 7.0);
    let arc = at(centre, (0..50).map(|i| (0.2 + 0.01 * f64::from(i), 25.0)));
    let circle = least_squares_circle(&arc).unwrap().fit.circle;
    assert!(circle.centre.distance(centre) < NM && (circle.radius - 25.0).abs() < NM);
}

#[test]
fn least_squares_covariance_is_the_scatter_of_the_fits() {
    let mut random = Pcg64::seed_from_u64(3);
    let normal = rand_distr::Normal::new(0.0, 1e-3).unwrap();
    let angles: Vec<f64> = (0..40).map(|i| 0.08 * f64::from(i)).collect();
    let (mut squares, runs) = ([0.0; 3], 4000);
    let mut covariance = None;
    for _ in 0..runs {
        let points = at(DVec2::ZERO, angles.iter().map(|a| (*a, 10.0 + random.sample(normal))));
        let ls = least_squares_circle(&points).unwrap();
        let c = ls.fit.circle;
        for (sum, e) in squares.iter_mut().zip([c.centre.x, c.centre.y, c.radius - 10.0]) {
            *sum += e * e / f64::from(runs);
        }
        covariance = Some(ls.covariance);
    }
    for (k, square) in squares.iter().enumerate() {
        let ratio = square.sqrt() / (covariance.unwrap()[(k, k)].sqrt() * 1e-3);
        assert!((ratio - 1.0).abs() < 0.05, "parameter {k}: scatter over stated {ratio}");
    }
}

/// Widths and radii on a fine grid of centres: no grid point may be better than the solutions.
#[test]
fn no_centre_of_a_dense_grid_beats_the_certified_ones() {
    let mut random = Pcg64::seed_from_u64(4);
    for _ in 0..20 {
        let points = at(
            DVec2::new(5.0, 1.0),
            (0..90).map(|i| (TAU * f64::from(i) / 90.0, 10.0 + random.random_range(-0.5..0.5))),
        );
        let span = |c: DVec2| {
            points
                .iter()
                .fold((f64::INFINITY, 0.0_f64), |(l, h), p| (l.min(p.distance(c)), h.max(p.distance(c))))
        };
        let zone = minimum_zone_circle(&points).unwrap();
        let inscribed = maximum_inscribed_circle(&points).unwrap();
        let around = minimum_circumscribed_circle(&points).unwrap();
        for fit in [&zone, &inscribed, &around] {
            assert!(fit.certificate.is_proven(), "{:?}", fit.certificate);
        }
        for i in -100..=100 {
            for j in -100..=100 {
                let (inner, outer) = span(DVec2::new(5.0 + 0.01 * f64::from(i), 1.0 + 0.01 * f64::from(j)));
                assert!(outer - inner >= zone.peak_to_valley() - 1e-9);
                assert!(inner <= inscribed.circle.radius + 1e-9);
                assert!(outer >= around.circle.radius - 1e-9);
            }
        }
    }
}

#[test]
fn certificates_refuse_a_circle_moved_by_a_tenth_of_a_micrometre() {
    let mut random = Pcg64::seed_from_u64(5);
    let (points, ..) = annulus_case(&mut random, 200);
    let off = DVec2::new(1e-4, 0.5e-4);
    let refused = |c: Certificate| !c.is_proven();
    assert!(refused(certify_minimum_zone(
        &points,
        minimum_zone_circle(&points).unwrap().circle.centre + off
    )));
    assert!(refused(certify_inscribed(
        &points,
        maximum_inscribed_circle(&points).unwrap().circle.centre + off
    )));
    let around = minimum_circumscribed_circle(&points).unwrap().circle.centre;
    assert!(refused(certify_circumscribed(&points, around + off)));
    let ls = least_squares_circle(&points).unwrap().fit.circle.centre;
    assert!(certify_least_squares(&points, ls).gap < NM);
    assert!(certify_least_squares(&points, ls + off).gap > 1e-4);
}

#[test]
fn minimum_zone_line_of_constructed_cases_is_right_to_1_nm() {
    let mut random = Pcg64::seed_from_u64(6);
    let mut worst = Worst::default();
    for case in 0..300 {
        let angle = random.random_range(-1.4..1.4);
        let (along, across) = (DVec2::from_angle(angle), DVec2::from_angle(angle).perp());
        let point = DVec2::new(random.random_range(-50.0..50.0), random.random_range(-50.0..50.0));
        let half = 10f64.powf(random.random_range(-4.0..0.0));
        let side = if case % 2 == 0 { 1.0 } else { -1.0 };
        let mut local = vec![(-300.0, side), (random.random_range(-250.0..250.0), -side), (320.0, side)];
        local.extend(
            (0..50 + case).map(|_| (random.random_range(-400.0..400.0), random.random_range(-0.99..0.99))),
        );
        let points: Vec<DVec2> =
            local.iter().map(|(s, w)| point + along * *s + across * (*w * half)).collect();
        let fit = minimum_zone_line(&points).unwrap();
        assert!((fit.peak_to_valley() - 2.0 * half).abs() < NM, "case {case}");
        assert!(
            fit.line.deviation(point).abs() < NM && fit.line.direction.perp_dot(along).abs() * 400.0 < NM
        );
        let proof = &fit.certificate;
        assert!(proof.proven_within == f64::INFINITY && proof.gap < 1e-8, "case {case}: {proof:?}");
        worst.see((fit.peak_to_valley() - 2.0 * half).abs().max(fit.line.deviation(point).abs()), proof);
        let turned = Line { direction: (fit.line.direction + across * 1e-6).normalize(), ..fit.line };
        assert!(!certify_minimum_zone_line(&points, turned).is_proven());
    }
    worst.print("minimum-zone line");
}

#[test]
fn least_squares_line_is_the_principal_axis_and_beats_every_other_direction() {
    // Deviations that sum to zero, with zero first moment, leave the nominal line stationary.
    let (along, across) = (DVec2::from_angle(0.4), DVec2::from_angle(0.4).perp());
    let origin = DVec2::new(100.0, -20.0);
    let points: Vec<DVec2> = (-100..=100)
        .map(|i| {
            let s = f64::from(i);
            origin + along * s + across * (0.01 * (s * s / 1e4 - 0.336_666_666_666_666_67))
        })
        .collect();
    let fit = least_squares_line(&points).unwrap();
    // Σ(s²/1e4) over −100..=100 is 67.67; its mean 0.336667 is subtracted.
    assert!(fit.line.deviation(origin).abs() < NM && fit.line.direction.perp_dot(along).abs() < 1e-9);
    let proof = &fit.certificate;
    assert!(proof.proven_within == f64::INFINITY && proof.gap < NM, "{proof:?}");
    let mut worst = Worst::default();
    worst.see(fit.line.deviation(origin).abs(), proof);
    worst.print("least-squares line");
    let sum = |line: &Line| points.iter().map(|p| line.deviation(*p).powi(2)).sum::<f64>();
    for k in -1000..=1000 {
        let turned = Line { direction: DVec2::from_angle(0.4 + 1e-6 * f64::from(k)), ..fit.line };
        assert!(sum(&turned) >= sum(&fit.line) - 1e-15);
    }
}

#[test]
fn roundness_and_straightness_parameters_are_those_of_the_standards() {
    let lobed = at(
        DVec2::ZERO,
        (0..360).map(|i| {
            let angle = TAU * f64::from(i) / 360.0;
            (angle, 20.0 + 0.004 * (3.0 * angle).cos())
        }),
    );
    let ls = roundness(&lobed, Reference::LeastSquares).unwrap();
    assert!((ls.ron_t - 0.008).abs() < NM && (ls.ron_p.unwrap() - 0.004).abs() < NM);
    assert!((ls.ron_v.unwrap() - 0.004).abs() < NM && (ls.ron_q.unwrap() - 0.004 / 2f64.sqrt()).abs() < NM);
    let zone = roundness(&lobed, Reference::MinimumZone).unwrap();
    for other in [Reference::LeastSquares, Reference::MaximumInscribed, Reference::MinimumCircumscribed] {
        assert!(zone.ron_t <= roundness(&lobed, other).unwrap().ron_t + 1e-12);
    }
    assert!(zone.ron_p.is_none() && (zone.ron_t - 0.008).abs() < NM);
    let bow: Vec<DVec2> = (0..=100)
        .map(|i| {
            let z = f64::from(i);
            DVec2::new(z, 0.01 * (z / 50.0 - 1.0).powi(2))
        })
        .collect();
    let line = straightness(&bow, StraightnessReference::MinimumZone).unwrap();
    assert!((line.str_t - 0.01).abs() < NM);
    let line = straightness(&bow, StraightnessReference::LeastSquares).unwrap();
    assert!(
        (line.str_t - 0.01).abs() < NM
            && (line.str_p.unwrap() + line.str_v.unwrap() - line.str_t).abs() < 1e-15
    );
}

#[test]
fn cylinder_from_points_and_from_silhouettes_finds_a_tilted_axis() {
    let (x0, y0, a, b, radius) = (0.31, -0.12, 2.1e-3, -1.3e-3, 25.0);
    let w = DVec3::new(a, b, 1.0).normalize();
    let (u, v) = (w.any_orthonormal_pair().0, w.any_orthonormal_pair().1);
    let mut points = Vec::new();
    for section in 0..=20 {
        for k in 0..36 {
            let angle = TAU * f64::from(k) / 36.0;
            let s = 50.0 * f64::from(section);
            // A three-lobed form is orthogonal to every parameter of the cylinder at equally spaced
            // angles.
            let r = radius + 0.005 * (3.0 * angle).cos();
            points.push(DVec3::new(x0, y0, 0.0) + w * s + (u * angle.cos() + v * angle.sin()) * r);
        }
    }
    let fit = least_squares_cylinder(&points).unwrap();
    let c = fit.cylinder;
    for (found, expected) in [(c.x0, x0), (c.y0, y0), (c.radius, radius)] {
        assert!((found - expected).abs() < NM, "{found} {expected}");
    }
    assert!(((c.slope_x - a) * 1000.0).abs() < NM && ((c.slope_y - b) * 1000.0).abs() < NM);
    assert!(
        (fit.cyl_t - 0.01).abs() < NM && (fit.cyl_q - 0.005 / 2f64.sqrt()).abs() < NM && fit.remaining < NM
    );
    let samples: Vec<[f64; 3]> = (0..=20)
        .flat_map(|s| (0..36).map(move |k| (50.0 * f64::from(s), TAU * f64::from(k) / 36.0)))
        .map(|(z, angle)| {
            [
                z,
                angle,
                radius
                    + (x0 + a * z) * angle.cos()
                    + (y0 + b * z) * angle.sin()
                    + 0.005 * (3.0 * angle).cos(),
            ]
        })
        .collect();
    let fit = silhouette_cylinder(&samples).unwrap();
    let c = fit.cylinder;
    assert!(
        (c.radius - radius).abs() < NM && (c.x0 - x0).abs() < NM && ((c.slope_y - b) * 1000.0).abs() < NM
    );
    assert!((fit.cyl_t - 0.01).abs() < NM && (fit.cyl_p - 0.005).abs() < NM);
}

fn station(z_mm: f64, d_mm: f64) -> Station {
    let reading = Reading::Value(Diameter { d_mm, u_random_mm: 2e-4, u_common_mm: 1e-3 });
    Station { z_mm, reading, freedom: None }
}

#[test]
fn taper_of_a_cone_with_a_gap_is_its_rate_and_its_uncertainty_is_the_lines() {
    let mut stations: Vec<Station> =
        (0..11).map(|i| station(10.0 * f64::from(i), 50.0 + 1e-4 * 10.0 * f64::from(i))).collect();
    stations[3].reading = Reading::Gap(Reason::Contaminated);
    let t = taper(&DiameterProfile { pass: 1, stations }).unwrap();
    assert!((t.rate - 1e-4).abs() < 1e-12 && t.reduced_chi2 < 1e-9);
    assert!((t.cone_angle_deg - 1e-4_f64.to_degrees()).abs() < 1e-9);
    // Closed form: u = σ/√Σ(z − z̄)² of the ten stations left.
    let z: Vec<f64> = (0..11).filter(|i| *i != 3).map(|i| 10.0 * f64::from(i)).collect();
    let mean = z.iter().sum::<f64>() / 10.0;
    let expected = 2e-4 / z.iter().map(|z| (z - mean).powi(2)).sum::<f64>().sqrt();
    assert!((t.u_rate / expected - 1.0).abs() < 1e-12);
}

#[test]
fn a_perfect_circle_is_round() {
    let points = at(DVec2::new(7.0, -2.0), (0..720).map(|i| (TAU * f64::from(i) / 720.0, 25.0)));
    for fit in [
        minimum_zone_circle(&points),
        maximum_inscribed_circle(&points),
        minimum_circumscribed_circle(&points),
    ] {
        let fit = fit.unwrap();
        assert!(fit.peak_to_valley() < NM && (fit.circle.radius - 25.0).abs() < NM);
    }
}

#[test]
fn degenerate_input_is_refused_with_a_reason() {
    let line: Vec<DVec2> = (0..10).map(|i| DVec2::new(f64::from(i), 2.0 * f64::from(i))).collect();
    assert!(matches!(least_squares_circle(&line), Err(FormError::Degenerate { .. })));
    assert!(matches!(minimum_zone_circle(&line), Err(FormError::Degenerate { .. })));
    assert!(matches!(least_squares_circle(&line[..2]), Err(FormError::TooFew { found: 2, .. })));
    let mut bad = line.clone();
    bad[4].y = f64::NAN;
    assert!(matches!(minimum_zone_line(&bad), Err(FormError::NotFinite { index: 4 })));
    let same = [DVec2::ONE; 5];
    assert!(minimum_circumscribed_circle(&same).is_err() && least_squares_circle(&same).is_err());
    assert!(minimum_zone_line(&same).is_err() && least_squares_line(&same).is_err());
    let one_section: Vec<DVec3> =
        (0..9).map(|i| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), 1.0)).collect();
    assert!(least_squares_cylinder(&one_section).is_err());
}
