//! The condensed beam against closed forms and published values.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use shadowgauge::process::beam::{Part, Supports, travelling_load};
use shadowgauge::process::{MaterialSettings, Section};

const LENGTH_MM: f64 = 1000.0;
const DIAMETER_MM: f64 = 50.0;

fn reference_section() -> Section {
    Section::circular(DIAMETER_MM, &MaterialSettings::default())
}

fn clamped_and(tailstock: Part) -> Supports {
    Supports { chuck: Part::clamped(0.0, 0.0), tailstock, steady_rests: Vec::new() }
}

fn uniform(elements: usize, section: Section, supports: &Supports) -> Vec<f64> {
    travelling_load(LENGTH_MM / elements as f64, &vec![section; elements], supports)
}

fn assert_relative(found: f64, expected: f64, limit: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs();
    assert!(error <= limit, "{what}: {found:e} against {expected:e}, relative error {error:e}");
}

/// Euler-Bernoulli, clamped and rigidly propped: u(a)/F = a³b²(4L - a)/(12·E·I·L³).
fn propped_euler_bernoulli(a: f64, ei: f64) -> f64 {
    let b = LENGTH_MM - a;
    a.powi(3) * b * b * (4.0 * LENGTH_MM - a) / (12.0 * ei * LENGTH_MM.powi(3))
}

/// Timoshenko, clamped and rigidly propped, by the force method: the tip reaction R closes the gap.
fn propped_timoshenko(a: f64, section: &Section) -> f64 {
    let (ei, s, l) = (section.bending_n_mm2, section.shear_n, LENGTH_MM);
    let tip_from_load = a * a * (3.0 * l - a) / (6.0 * ei) + a / s;
    let tip_from_tip = l.powi(3) / (3.0 * ei) + l / s;
    let own = a.powi(3) / (3.0 * ei) + a / s;
    own - tip_from_load * tip_from_load / tip_from_tip
}

#[test]
fn a_cantilever_follows_its_closed_form() {
    let section = reference_section();
    let found = uniform(1000, section, &clamped_and(Part::hinged(f64::INFINITY)));
    for (node, compliance) in found.iter().enumerate().skip(1) {
        let a = node as f64;
        let expected = a.powi(3) / (3.0 * section.bending_n_mm2) + a / section.shear_n;
        assert_relative(*compliance, expected, 1e-11, "cantilever");
    }
}

#[test]
fn a_propped_beam_follows_euler_bernoulli_at_any_mesh() {
    let section = reference_section().without_shear();
    for elements in [10, 100, 1000, 10_000] {
        let found = uniform(elements, section, &clamped_and(Part::hinged(0.0)));
        for (node, compliance) in found.iter().enumerate().take(elements).skip(1) {
            let a = node as f64 * LENGTH_MM / elements as f64;
            assert_relative(*compliance, propped_euler_bernoulli(a, section.bending_n_mm2), 1e-9, "propped");
        }
        assert_eq!((found[0], found[elements]), (0.0, 0.0));
    }
}

#[test]
fn a_propped_timoshenko_beam_follows_the_force_method() {
    let section = reference_section();
    let found = uniform(1000, section, &clamped_and(Part::hinged(0.0)));
    for (node, compliance) in found.iter().enumerate().take(1000).skip(1) {
        assert_relative(*compliance, propped_timoshenko(node as f64, &section), 1e-9, "propped Timoshenko");
    }
}

#[test]
fn reference_values_at_500_mm() {
    let supports = clamped_and(Part::hinged(0.0));
    let section = reference_section();
    let timoshenko = uniform(1000, section, &supports)[500];
    let euler_bernoulli = uniform(1000, section.without_shear(), &supports)[500];
    assert_relative(euler_bernoulli, 1.414710605261e-4, 1e-9, "Euler-Bernoulli");
    assert_relative(timoshenko, 1.434993110672e-4, 1e-9, "Timoshenko");
}

/// Position of the maximum by a parabola through the three nodes around it.
fn position_of_maximum(values: &[f64], step: f64) -> f64 {
    let top = (1..values.len() - 1).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap();
    let (l, m, r) = (values[top - 1], values[top], values[top + 1]);
    step * (top as f64 + 0.5 * (l - r) / (l - 2.0 * m + r))
}

#[test]
fn the_maximum_lies_where_it_should() {
    let supports = clamped_and(Part::hinged(0.0));
    let section = reference_section();
    let bending_only = position_of_maximum(&uniform(10_000, section.without_shear(), &supports), 0.1);
    assert!((bending_only - (2.0 - 2f64.sqrt()) * LENGTH_MM).abs() < 0.01, "{bending_only}");
    let with_shear = position_of_maximum(&uniform(10_000, section, &supports), 0.1);
    assert!((with_shear - 585.21).abs() < 0.01, "{with_shear}");
}
