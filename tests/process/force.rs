//! Force laws against closed forms and quadrature.

use shadowgauge::plan::CuttingData;
use shadowgauge::process::kienzle::KienzleLaw;
use shadowgauge::process::{ForceLaw, MaterialSettings, PowerLaw, ToolSettings};

fn steel() -> shadowgauge::process::material::Material {
    MaterialSettings::default().resolve().unwrap()
}

fn kienzle(feed: f64, lead_angle_deg: f64) -> shadowgauge::process::DepthLaw {
    let tool = ToolSettings { nose_radius_mm: 0.4, lead_angle_deg };
    let cutting = CuttingData { speed_m_per_min: 100.0, feed_mm_per_rev: feed };
    ForceLaw::Kienzle(KienzleLaw::default()).at(&cutting, &tool, &steel())
}

/// Midpoint sums over the edge, 20 000 elements on the nose and as many on the straight part.
fn by_summation(depth: f64, feed: f64, lead_angle_deg: f64) -> (f64, f64, f64) {
    let (kc11, exponent, ratio, r): (f64, f64, f64, f64) = (2220.0, 0.86, 0.45, 0.4);
    let lead = lead_angle_deg.to_radians();
    let nose_depth = r * (1.0 - lead.cos());
    let engaged = (1.0 - depth.min(nose_depth) / r).acos();
    let n = 20_000;
    let mut edge: Vec<(f64, f64)> =
        (0..n).map(|i| (engaged * (f64::from(i) + 0.5) / f64::from(n), r * engaged / f64::from(n))).collect();
    edge.push((lead, (depth - nose_depth).max(0.0) / lead.sin()));
    edge.iter().fold((0.0, 0.0, 0.0), |(c, f, p), (kappa, ds)| {
        let cutting = kc11 * (feed * kappa.sin()).powf(exponent) * ds;
        (c + cutting, f + ratio * cutting * kappa.sin(), p + ratio * cutting * kappa.cos())
    })
}

#[test]
fn kienzle_integrates_along_the_edge() {
    for lead in [45.0, 75.0, 90.0] {
        for depth in [0.01, 0.1, 0.25, 0.4, 1.0] {
            let (cutting, feed, passive) = by_summation(depth, 0.1, lead);
            let found = kienzle(0.1, lead).components(depth);
            for (found, expected) in
                [(found.cutting_n, cutting), (found.feed_n, feed), (found.passive_n, passive)]
            {
                assert!(
                    (found / expected - 1.0).abs() < 2e-5,
                    "{lead}° {depth} mm: {found} against {expected}"
                );
            }
        }
    }
}

#[test]
fn kienzle_without_a_nose_is_the_handbook_formula() {
    // κ_r = 90°, depth far above the nose: F_c = kc1.1·f^(1-mc)·a_p.
    let tool = ToolSettings { nose_radius_mm: 1e-6, lead_angle_deg: 90.0 };
    let cutting = CuttingData { speed_m_per_min: 100.0, feed_mm_per_rev: 0.2 };
    let found = ForceLaw::Kienzle(KienzleLaw::default()).at(&cutting, &tool, &steel()).components(2.0);
    let expected = 2220.0 * 0.2f64.powf(0.86) * 2.0;
    assert!((found.cutting_n / expected - 1.0).abs() < 1e-5, "{} {expected}", found.cutting_n);
    assert!(found.passive_n < 1e-3 * expected);
}

#[test]
fn the_radial_share_rises_as_the_cut_gets_shallow() {
    let law = kienzle(0.1, 90.0);
    let share = |depth: f64| law.components(depth).passive_n / law.components(depth).cutting_n;
    assert!(share(0.05) > share(0.2) && share(0.2) > share(0.4) && share(0.4) > share(2.0));
    // With κ_r = 90° only the nose pushes radially.
    assert!((law.force_n(0.4) - law.force_n(3.0)).abs() < 1e-9);
}

#[test]
fn slopes_are_derivatives() {
    let power = PowerLaw::default().at(&CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 });
    for law in [power, kienzle(0.1, 75.0), kienzle(0.1, 90.0).scaled(1.3)] {
        for depth in [0.02, 0.1, 0.25, 0.39, 0.8] {
            let h = 1e-6;
            let numeric = (law.force_n(depth + h) - law.force_n(depth - h)) / (2.0 * h);
            let slope = law.slope_n_per_mm(depth);
            assert!((slope - numeric).abs() < 1e-4 * (1.0 + numeric.abs()), "{depth}: {slope} {numeric}");
        }
    }
}

#[test]
fn the_depth_solves_its_equation() {
    let power = PowerLaw::default().at(&CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 });
    for law in [power, kienzle(0.1, 90.0), kienzle(0.3, 45.0)] {
        for set in [1e-6, 1e-3, 0.05, 0.25, 0.4, 1.0] {
            for compliance in [0.0, 1e-6, 2e-4, 1e-2] {
                let depth = law.depth_mm(set, compliance);
                let residual = depth + compliance * law.force_n(depth) - set;
                assert!(residual.abs() <= 1e-12, "{set} {compliance}: {residual:e}");
            }
        }
        assert_eq!(law.depth_mm(-0.1, 1e-4), 0.0);
    }
}

#[test]
fn extrapolation_is_said() {
    let (law, tool) = (ForceLaw::default(), ToolSettings::default());
    let inside = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };
    assert!(law.extrapolation(&inside, [0.1, 0.3], &tool).is_empty());
    assert_eq!(law.extrapolation(&inside, [0.05, 0.3], &tool).len(), 1);
    let fast = CuttingData { speed_m_per_min: 180.0, feed_mm_per_rev: 0.5 };
    let said = law.extrapolation(&fast, [0.1, 0.5], &tool).join("\n");
    assert!(said.contains("speed") && said.contains("feed") && said.contains("depth"), "{said}");
    // a_p·f over the edge: 0.25·0.1/(0.4·acos(1 - 0.25/0.4)) = 0.05268 mm; shallower cuts have thinner chips.
    let kienzle = ForceLaw::Kienzle(KienzleLaw::default());
    assert!((KienzleLaw::mean_chip_mm(0.1, 0.25, &tool) - 0.05268).abs() < 1e-5);
    assert!(kienzle.extrapolation(&inside, [0.25, 0.3], &tool).is_empty());
    assert!(kienzle.extrapolation(&inside, [0.1, 0.3], &tool)[0].contains("chips"));
}
