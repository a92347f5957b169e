//! The whole deflection line against closed forms.

use shadowgauge::process::beam::{Part, SteadyRest, Supports, travelling_load};
use shadowgauge::process::bending::{
    BendingSettings, ForceAt, HeldShaft, axis_at, sum_of_lines, weight_n_per_mm,
};
use shadowgauge::process::fem;
use shadowgauge::process::line::{Action, PointForce, Span, deflection_line_mm};
use shadowgauge::process::{Components, MaterialSettings, Section};
use shadowgauge::shaft::AxisKnot;

const L: f64 = 1000.0;
const W: f64 = 0.15;

fn section() -> Section {
    Section::circular(50.0, &MaterialSettings::default().resolve().unwrap())
}

fn spans(elements: usize, section: Section, load: f64) -> Vec<Span> {
    vec![Span { length_mm: L / elements as f64, section, load_n_per_mm: load }; elements]
}

fn held(chuck: Part, tailstock: Part) -> Supports {
    Supports { chuck, tailstock, steady_rests: Vec::new() }
}

fn line(elements: usize, section: Section, load: f64, supports: &Supports, action: &Action) -> Vec<f64> {
    deflection_line_mm(&spans(elements, section, load), supports, action).unwrap()
}

fn check(found: &[f64], expected: impl Fn(f64) -> f64, what: &str) {
    let elements = found.len() - 1;
    let z = |node: usize| node as f64 * L / elements as f64;
    let largest = (0..found.len()).map(|n| expected(z(n)).abs()).fold(0.0, f64::max);
    for (node, u) in found.iter().enumerate() {
        let error = (u - expected(z(node))).abs() / largest;
        assert!(
            error < 1e-9,
            "{what}, {elements} elements, z = {}: {u:e} against {:e}",
            z(node),
            expected(z(node))
        );
    }
}

/// Sag of every support: cantilever, clamped and propped (also on a yielding centre), between
/// centres, clamped at both ends.
#[test]
fn sag_of_every_support_follows_its_closed_form() {
    let s = section();
    let (ei, ga) = (s.bending_n_mm2, s.shear_n);
    let clamped = Part::clamped(0.0, 0.0);
    let cantilever =
        |z: f64| W * z * z * (6.0 * L * L - 4.0 * L * z + z * z) / (24.0 * ei) + W * z * (L - z / 2.0) / ga;
    let tip = |z: f64| z * z * (3.0 * L - z) / (6.0 * ei) + z / ga;
    for elements in [2, 7, 500, 2000] {
        let none = Action::default();
        let free = held(clamped, Part::hinged(f64::INFINITY));
        check(&line(elements, s, W, &free, &none), cantilever, "cantilever");
        for compliance in [0.0, 5e-5] {
            let reaction = cantilever(L) / (tip(L) + compliance);
            let propped = held(clamped, Part::hinged(compliance));
            check(&line(elements, s, W, &propped, &none), |z| cantilever(z) - reaction * tip(z), "propped");
        }
        // The chuck yields and tilts: its contribution to the line is straight.
        let (yields, tilts) = (2e-5, 1e-9);
        let total = |z: f64| cantilever(z) + W * L * yields + z * tilts * W * L * L / 2.0;
        let soft = |z: f64| tip(z) + yields + z * tilts * L;
        let reaction = total(L) / soft(L);
        let supports = held(Part::clamped(yields, tilts), Part::hinged(0.0));
        check(&line(elements, s, W, &supports, &none), |z| total(z) - reaction * soft(z), "yielding chuck");
        let centres = held(Part::hinged(0.0), Part::hinged(0.0));
        let simple = |z: f64| {
            W * z * (L.powi(3) - 2.0 * L * z * z + z.powi(3)) / (24.0 * ei) + W * z * (L - z) / (2.0 * ga)
        };
        check(&line(elements, s, W, &centres, &none), simple, "between centres");
        let both = held(clamped, clamped);
        let fixed = |z: f64| W * z * z * (L - z).powi(2) / (24.0 * ei) + W * z * (L - z) / (2.0 * ga);
        check(&line(elements, s, W, &both, &none), fixed, "clamped at both ends");
    }
    // The preset's shaft, by hand: w L⁴/185 EI at Ø 27 and 500 mm between rigid supports (maximum
    // .0054161 w L⁴/EI).
    let material = MaterialSettings::default().resolve().unwrap();
    let w = weight_n_per_mm(27.0, &material);
    assert!((w - 0.044_077).abs() < 1e-6, "{w}");
}

/// A load at any place, on a node or off it: the whole line of a propped shaft by the force method.
#[test]
fn a_load_at_any_place_follows_its_closed_form() {
    let s = section();
    let (ei, ga) = (s.bending_n_mm2, s.shear_n);
    for a in [0.7, 123.4, 500.0, 730.25, 999.0] {
        let from_load = |z: f64| {
            let near: f64 = z.min(a);
            near * near * (3.0 * a - near) / (6.0 * ei) + (z - near) * a * a / (2.0 * ei) + near / ga
        };
        let tip = |z: f64| z * z * (3.0 * L - z) / (6.0 * ei) + z / ga;
        let reaction = from_load(L) / tip(L);
        let supports = held(Part::clamped(0.0, 0.0), Part::hinged(0.0));
        let action = Action { forces: vec![PointForce { z_mm: a, force_n: 1.0 }], ..Action::default() };
        for elements in [10, 1000] {
            check(&line(elements, s, 0.0, &supports, &action), |z| from_load(z) - reaction * tip(z), "load");
        }
    }
}

/// Offsets of chuck and tailstock bend a clamped and propped shaft: u = e + (d - e)·z²(3L - z)/2L³
/// for a slender one.
#[test]
fn offsets_of_the_ends_follow_their_closed_form() {
    let s = section().without_shear();
    let supports = held(Part::clamped(0.0, 0.0), Part::hinged(0.0));
    let action = Action { chuck_mm: 0.01, tailstock_mm: -0.02, ..Action::default() };
    let expected = |z: f64| 0.01 - 0.03 * z * z * (3.0 * L - z) / (2.0 * L.powi(3));
    check(&line(100, s, 0.0, &supports, &action), expected, "offsets");
}

/// Thrust on a beam-column between centres: EI·u'''' + P·u'' = w has u = w/(P k²)·[(cos k(L/2 -
/// z))/cos(kL/2) - 1] - w z(L - z)/2P.
#[test]
fn thrust_adds_to_a_sag_as_in_a_beam_column_and_buckles_at_eulers_load() {
    let s = section().without_shear();
    let euler = std::f64::consts::PI.powi(2) * s.bending_n_mm2 / (L * L);
    let supports = held(Part::hinged(0.0), Part::hinged(0.0));
    for share in [0.05, 0.5, 0.95] {
        let thrust_n = share * euler;
        let k = (thrust_n / s.bending_n_mm2).sqrt();
        let expected = |z: f64| {
            W / (thrust_n * k * k) * ((k * (L / 2.0 - z)).cos() / (k * L / 2.0).cos() - 1.0)
                - W * z * (L - z) / (2.0 * thrust_n)
        };
        let action = Action { thrust_n, ..Action::default() };
        for elements in [2, 20, 400] {
            check(&line(elements, s, W, &supports, &action), expected, "beam-column");
        }
    }
    // A half-sine bow grows by P/(P_E - P).
    let bow: Vec<AxisKnot> = (0..=2000)
        .map(|i| f64::from(i) * L / 2000.0)
        .map(|z_mm| AxisKnot { z_mm, x_mm: 0.0, y_mm: 0.02 * (std::f64::consts::PI * z_mm / L).sin() })
        .collect();
    let material = MaterialSettings::default().resolve().unwrap();
    let own = std::f64::consts::PI.powi(2) * Section::circular(50.0, &material).bending_n_mm2 / (L * L);
    let bending = BendingSettings { tailstock_push: true, ..BendingSettings::default() };
    let shaft = HeldShaft {
        element_mm: vec![1.0; 1000],
        node_z_mm: (0..=1000).map(f64::from).collect(),
        diameter_mm: vec![50.0; 1000],
        material: &material,
        supports: &supports,
        thrust_n: 0.2 * own,
        bending: &bending,
    };
    let grown = axis_at(&shaft.turning_mm(&bow).unwrap(), L / 2.0);
    // With shear the shaft is slightly softer than Euler's: 0.3 % at this slenderness.
    assert!((grown[1] / 0.02 - 0.25).abs() < 2e-3 && grown[0] == 0.0, "{grown:?}");
}

#[test]
fn rests_anywhere_agree_with_assembled_elements_and_with_the_travelling_load() {
    let s = section();
    let rest = |z_mm, compliance_mm_per_n| SteadyRest { z_mm, compliance_mm_per_n };
    let supports = Supports {
        chuck: Part::clamped(2e-5, 0.0),
        tailstock: Part::hinged(5e-5),
        steady_rests: vec![rest(400.0, 3e-5), rest(700.0, 0.0)],
    };
    let travelling = travelling_load(20.0, &[s; 50], &supports);
    for node in [5, 20, 30, 44] {
        let action = Action {
            forces: vec![PointForce { z_mm: 20.0 * node as f64, force_n: 1.0 }],
            ..Action::default()
        };
        let found = line(50, s, 0.0, &supports, &action);
        let judge = fem::deflection_line_mm(20.0, &[s; 50], &supports, &[(node, 1.0)]).unwrap();
        let largest = judge.iter().map(|u| u.abs()).fold(0.0, f64::max);
        for (a, b) in found.iter().zip(&judge) {
            assert!((a - b).abs() < 1e-8 * largest, "{a:e} {b:e}");
        }
        assert!((found[node] - travelling[node]).abs() < 1e-9 * travelling[node]);
    }
    let free = held(Part::hinged(0.0), Part::hinged(f64::INFINITY));
    assert!(deflection_line_mm(&spans(5, s, 1.0), &free, &Action::default()).is_none());
}

/// Directions: gravity at 180° pulls down in the image; a tool above pushes down, and the force
/// along the speed is against the motion.
#[test]
fn weight_and_force_point_where_the_machine_says() {
    let material = MaterialSettings::default().resolve().unwrap();
    let supports = held(Part::clamped(0.0, 0.0), Part::hinged(0.0));
    let bending = BendingSettings { self_weight: true, ..BendingSettings::default() };
    let shaft = HeldShaft {
        element_mm: vec![5.0; 100],
        node_z_mm: (0..=100).map(|node| 5.0 * f64::from(node)).collect(),
        diameter_mm: vec![27.0; 100],
        material: &material,
        supports: &supports,
        thrust_n: 300.0,
        bending: &bending,
    };
    let [x, y] = axis_at(&shaft.still_mm(None).unwrap(), 290.0);
    let s = Section::circular(27.0, &material);
    let sag = weight_n_per_mm(27.0, &material) * 500f64.powi(4) / (185.0 * s.bending_n_mm2);
    assert!((x / -sag - 1.0).abs() < 0.03 && y.abs() < 1e-12, "{x} {y} against {sag}");
    let force = Components { cutting_n: 100.0, feed_n: 40.0, passive_n: 50.0 };
    for (tool_deg, expected) in [(0.0, [-50.0, -100.0]), (90.0, [100.0, -50.0]), (180.0, [50.0, 100.0])] {
        let found = BendingSettings { tool_deg, ..bending }.force_n(&force);
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{tool_deg}: {found:?}");
    }
    let at = ForceAt { z_mm: 250.0, force };
    let with = axis_at(&shaft.still_mm(Some(&at)).unwrap(), 250.0);
    let without = axis_at(&shaft.still_mm(None).unwrap(), 250.0);
    assert!(((with[1] - without[1]) / (with[0] - without[0]) - 2.0).abs() < 1e-9);
    let sum = sum_of_lines(
        &[AxisKnot { z_mm: 0.0, x_mm: 1.0, y_mm: 0.0 }],
        &[AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm: 0.0 }, AxisKnot { z_mm: 2.0, x_mm: 2.0, y_mm: 4.0 }],
    );
    assert_eq!(axis_at(&sum, 1.0), [2.0, 2.0]);
}
