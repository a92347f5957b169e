//! The condensed beam against closed forms and published values.

use shadowgauge::process::beam::{Part, SteadyRest, Supports, travelling_load};
use shadowgauge::process::fem::deflection_line_mm;
use shadowgauge::process::geometry::{diameter_after_mm, radial_error_mm, tangential_error_mm};
use shadowgauge::process::stepped::{Piece, SteppedShaft};
use shadowgauge::process::{MaterialSettings, Section};

const LENGTH_MM: f64 = 1000.0;
const DIAMETER_MM: f64 = 50.0;

fn reference_section() -> Section {
    Section::circular(DIAMETER_MM, &MaterialSettings::default().resolve().unwrap())
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

/// Sections of a half-cut shaft: 48 mm ahead of the tool at `node`, 50 mm behind it.
fn half_cut(elements: usize, node: usize) -> Vec<Section> {
    let steel = MaterialSettings::default().resolve().unwrap();
    (0..elements).map(|i| Section::circular(if i < node { 50.0 } else { 48.0 }, &steel)).collect()
}

fn held(chuck_n_per_um: f64, tailstock_n_per_um: f64, rests: &[(f64, f64)]) -> Supports {
    Supports {
        chuck: Part::clamped(1e-3 / chuck_n_per_um, 0.0),
        tailstock: Part::hinged(1e-3 / tailstock_n_per_um),
        steady_rests: rests
            .iter()
            .map(|&(z_mm, k)| SteadyRest { z_mm, compliance_mm_per_n: 1e-3 / k })
            .collect(),
    }
}

#[test]
fn condensation_agrees_with_assembled_elements() {
    let rigid = f64::INFINITY;
    let cases = [
        held(50.0, 20.0, &[]),
        held(rigid, rigid, &[]),
        held(50.0, 20.0, &[(400.0, 30.0)]),
        held(50.0, 20.0, &[(400.0, rigid), (700.0, 10.0)]),
        held(50.0, 0.0, &[(600.0, rigid)]),
        held(50.0, 20.0, &[(1000.0, 5.0)]),
    ];
    for (case, supports) in cases.iter().enumerate() {
        for node in [5, 25, 30, 35, 45] {
            let sections = half_cut(50, node);
            let condensed = travelling_load(20.0, &sections, supports)[node];
            let assembled = deflection_line_mm(20.0, &sections, supports, &[(node, 1.0)]).unwrap()[node];
            let error = (condensed - assembled).abs();
            assert!(
                error <= 1e-8 * assembled.abs() + 1e-15,
                "case {case}, node {node}: {condensed:e} {assembled:e}"
            );
        }
    }
}

#[test]
fn a_stepped_cantilever_follows_its_closed_form() {
    // Thick for 600 mm, thin for 400 mm; load at the end: ∫ (L - s)²/EI + 1/κGA.
    let steel = MaterialSettings::default().resolve().unwrap();
    let (thick, thin) = (Section::circular(50.0, &steel), Section::circular(40.0, &steel));
    let sections: Vec<Section> = (0..1000).map(|i| if i < 600 { thick } else { thin }).collect();
    let found = travelling_load(1.0, &sections, &clamped_and(Part::hinged(f64::INFINITY)))[1000];
    let third = |from: f64, to: f64, s: &Section| (to.powi(3) - from.powi(3)) / (3.0 * s.bending_n_mm2);
    let expected = third(400.0, 1000.0, &thick)
        + third(0.0, 400.0, &thin)
        + 600.0 / thick.shear_n
        + 400.0 / thin.shear_n;
    assert_relative(found, expected, 1e-11, "stepped");
}

#[test]
fn a_shaft_between_centres_follows_its_closed_form() {
    let section = reference_section().without_shear();
    let supports =
        Supports { chuck: Part::hinged(0.0), tailstock: Part::hinged(0.0), steady_rests: Vec::new() };
    let found = uniform(1000, section, &supports);
    for a in [1.0, 250.0, 500.0, 900.0] {
        let b = LENGTH_MM - a;
        let expected = a * a * b * b / (3.0 * section.bending_n_mm2 * LENGTH_MM);
        assert_relative(found[a as usize], expected, 1e-9, "between centres");
    }
}

#[test]
fn a_line_under_two_loads_is_the_sum_of_its_parts() {
    let (sections, supports) = (half_cut(50, 20), held(50.0, 20.0, &[]));
    let line = |forces: &[(usize, f64)]| deflection_line_mm(20.0, &sections, &supports, forces).unwrap();
    let (both, one, other) = (line(&[(10, 3.0), (40, 2.0)]), line(&[(10, 3.0)]), line(&[(40, 2.0)]));
    for node in 0..=50 {
        assert!((both[node] - one[node] - other[node]).abs() < 1e-12);
    }
    // Maxwell: the deflection at 40 by a load at 10 equals that at 10 by a load at 40.
    assert_relative(one[40] / 3.0, other[10] / 2.0, 1e-8, "reciprocity");
    assert!(deflection_line_mm(20.0, &sections, &supports, &[(51, 1.0)]).is_none());
}

#[test]
fn a_tangential_deflection_hardly_matters() {
    let (commanded, radial, tangential) = (25.0, 0.02, 0.05);
    let both = diameter_after_mm(commanded, radial, tangential) - commanded;
    assert!((both - radial_error_mm(radial) - tangential_error_mm(commanded, tangential)).abs() < 1e-6);
    assert!((tangential_error_mm(commanded, tangential) - 2.0 * 0.05 * 0.05 / 25.0).abs() < 1e-8);
    assert_eq!(radial_error_mm(radial), 0.04);
}

#[test]
fn pieces_without_a_mesh_agree_with_the_mesh() {
    let steel = MaterialSettings::default().resolve().unwrap();
    let (thick, thin) = (Section::circular(50.0, &steel), Section::circular(48.0, &steel));
    let supports = held(50.0, 20.0, &[(400.0, 30.0), (700.0, f64::INFINITY)]);
    let uniform = |length_mm| Piece { length_mm, ahead: thick, behind: thin };
    let shaft = SteppedShaft { pieces: vec![uniform(300.0), uniform(700.0)], supports: supports.clone() };
    for node in [5, 20, 25, 35, 36, 45, 50] {
        let z = 20.0 * node as f64;
        let meshed = travelling_load(20.0, &half_cut(50, node), &supports)[node];
        let found = shaft.compliance_mm_per_n(z);
        assert!((found - meshed).abs() <= 1e-10 * meshed.abs() + 1e-16, "{z}: {found:e} {meshed:e}");
    }
}
