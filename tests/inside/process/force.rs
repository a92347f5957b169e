//! Force laws against closed forms and quadrature.

use shadowgauge::plan::CuttingData;
use shadowgauge::process::kienzle::KienzleLaw;
use shadowgauge::process::{ForceLaw, MaterialSettings, PowerLaw, ToolSettings};

fn steel() -> shadowgauge::process::material::Material {
    MaterialSettings::default().resolve().unwrap()
}

fn kienzle(feed: f64, lead_angle_deg: f64) -> shadowgauge::process::DepthLaw {
    // 6°: the rake behind the tabulated kc1.1.
    let tool = ToolSettings { nose_radius_mm: 0.4, lead_angle_deg, rake_deg: 6.0, ..ToolSettings::default() };
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
    let tool = ToolSettings { nose_radius_mm: 1e-6, rake_deg: 6.0, ..ToolSettings::default() };
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
    // a_p·f over the edge: 0.25·0.1/(0.4·acos(1 - 0.25/0.4)) = 0.05268 mm; shallower cuts have
    // thinner chips.
    let kienzle = ForceLaw::Kienzle(KienzleLaw::default());
    assert!((KienzleLaw::mean_chip_mm(0.1, 0.25, &tool) - 0.05268).abs() < 1e-5);
    assert!(kienzle.extrapolation(&inside, [0.25, 0.3], &tool).is_empty());
    assert!(kienzle.extrapolation(&inside, [0.1, 0.3], &tool)[0].contains("chips"));
}

/// The tool's angles act on every component by the handbook's factors, and not at all on the tool
/// that a law was fitted to.
#[test]
fn the_tools_angles_have_their_handbook_factors() {
    let cutting = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };
    let steel = steel();
    let at = |law: &ForceLaw, tool: &ToolSettings| law.at(&cutting, tool, &steel).components(0.25);
    let law = ForceLaw::default();
    let paper = ToolSettings::default();
    let plain = PowerLaw::default().at(&cutting).components(0.25);
    assert_eq!(at(&law, &paper), plain);
    // Rake 15° -> 0°: between the lines for 10° (1) and 20° (0.9, 0.7, 0.7), relative
    // to 1.1, 1.4, 1.4.
    let blunt = at(&law, &ToolSettings { rake_deg: 0.0, ..paper });
    for (found, was, factor) in [
        (blunt.cutting_n, plain.cutting_n, 1.1 / 0.95),
        (blunt.passive_n, plain.passive_n, 1.4 / 0.85),
        (blunt.feed_n, plain.feed_n, 1.4 / 0.85),
    ] {
        assert!((found / was / factor - 1.0).abs() < 1e-12, "{found} {was} {factor}");
    }
    // Lead angle 90° -> 45°: twice the radial force.
    let oblique = at(&law, &ToolSettings { lead_angle_deg: 45.0, ..paper });
    assert!((oblique.passive_n / plain.passive_n - 2.0).abs() < 1e-12);
    // Relief and minor cutting edge angle have no factor.
    assert_eq!(at(&law, &ToolSettings { relief_deg: 12.0, minor_angle_deg: 5.0, ..paper }), plain);
    // Under Kienzle's law, lead angle and nose are in the integral: rake and inclination remain,
    // relative to 6° and 0°.
    let kienzle = ForceLaw::Kienzle(KienzleLaw::default());
    let tabulated = at(&kienzle, &ToolSettings { rake_deg: 6.0, ..paper });
    let sharper = at(&kienzle, &paper);
    assert!((sharper.passive_n / tabulated.passive_n - 0.85 / 1.16).abs() < 1e-12);
    assert!((sharper.cutting_n / tabulated.cutting_n - 0.95 / 1.04).abs() < 1e-12);
}

#[test]
fn one_set_of_constants_a_table_over_its_own_range() {
    let tool = ToolSettings::default();
    let at = |speed_m_per_min, feed_mm_per_rev| CuttingData { speed_m_per_min, feed_mm_per_rev };
    let (one, two) = (ForceLaw::Power(PowerLaw::table_1()), ForceLaw::Power(PowerLaw::table_2()));
    assert!(one.extrapolation(&at(40.0, 0.1), [0.1, 0.38], &tool).is_empty());
    assert!(two.extrapolation(&at(80.0, 0.1), [0.2, 0.2], &tool).is_empty());
    assert!(one.extrapolation(&at(80.0, 0.1), [0.2, 0.2], &tool)[0].contains("speed"));
    let deeper = two.extrapolation(&at(80.0, 0.1), [0.2, 0.25], &tool);
    assert!(
        deeper.len() == 1 && deeper[0].contains("depth 0.2000-0.2500 mm, fitted over 0.2-0.2"),
        "{deeper:?}"
    );
}
