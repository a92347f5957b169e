//! The pass along a contour against statics coded apart: the unit-load method on the half-cut shaft
//! instead of the recursion from both ends.

use super::job;
use shadowgauge::plan::{
    Contour, ContourKnot, CuttingData, DiameterOffset, FeedDirection, PassPlan, PlannedForm, Section,
};
use shadowgauge::process::{BaseForm, MaterialSettings, ProcessSettings, Stock, TurningProcess};

const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };

fn section(from: f64, to: f64, relative_mm: f64) -> Section {
    Section {
        name: String::new(),
        ends_mm: (from, to),
        clear_mm: (from, to),
        drawn_mm: 25.0 + relative_mm,
        aim_mm: 0.0,
        relative_mm,
        limits_mm: None,
    }
}

/// Cylinders (to, relative) side by side.
fn steps(of: &[(f64, f64)]) -> Contour {
    let mut contour = Contour { direction: FeedDirection::TowardsChuck, ..Contour::default() };
    let mut from = 0.0;
    for &(to, relative_mm) in of {
        contour.sections.push(section(from, to, relative_mm));
        contour.knots.extend([from, to].map(|z_mm| ContourKnot { z_mm, relative_mm }));
        from = to;
    }
    contour
}

fn plan(contour: Option<&Contour>, stations: &[f64], o_mm: &[f64]) -> PassPlan {
    PassPlan {
        pass: 1,
        nominal_mm: 25.0,
        cutting: CUTTING,
        station_z_mm: stations.to_vec(),
        offset: DiameterOffset { o_mm: o_mm.to_vec() },
        form: contour.map_or(PlannedForm::PLAIN, |c| PlannedForm::stepped(c.clone())),
    }
}

fn settings() -> ProcessSettings {
    let mut settings = ProcessSettings::default();
    (settings.texture.rms_um, settings.texture.lobe_um) = (0.0, 0.0);
    settings
}

fn process(settings: &ProcessSettings, contour: Option<Contour>, length_mm: f64) -> TurningProcess {
    let stock = Stock { diameter_mm: 25.5, length_mm };
    TurningProcess::new(settings, stock, &BaseForm { contour, ..BaseForm::default() }, 1).unwrap()
}

/// A contour without a step is the plain shaft.
#[test]
fn one_cylinder_is_the_plain_shaft() {
    let mut plain = process(&settings(), None, 300.0);
    let contour = steps(&[(300.0, 0.0)]);
    let mut stepped = process(&settings(), Some(contour.clone()), 300.0);
    plain.cut_profile(&plan(None, &[150.0], &[0.0])).unwrap();
    stepped.cut_profile(&plan(Some(&contour), &[150.0], &[0.0])).unwrap();
    let apart = plain.diameter_mm().iter().zip(stepped.diameter_mm()).map(|(a, b)| (a - b).abs());
    assert_eq!(plain.diameter_mm().len(), stepped.diameter_mm().len());
    assert!(apart.fold(0.0, f64::max) < 1e-12);
}

/// A shaft of pieces (from, to, diameter), rigid or yielding chuck, tailstock of compliance `c_t`
/// (infinite for a free end).
struct Statics {
    pieces: Vec<(f64, f64, f64)>,
    length_mm: f64,
    chuck: f64,
    tailstock: f64,
}

impl Statics {
    /// Deflection at b under a unit load at a of the cantilever: the integral of M·m/EI + V·v/κGA,
    /// per piece in closed form (Cowper's κ of a round section).
    fn cantilever(&self, a: f64, b: f64) -> f64 {
        let steel = MaterialSettings::default().resolve().unwrap();
        let (e, nu) = (steel.youngs_modulus_n_per_mm2, steel.poisson_ratio);
        let g = e / (2.0 * (1.0 + nu));
        let kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
        let reach = a.min(b);
        let inside = self.pieces.iter().filter(|p| p.0 < reach);
        let of = |&(from, to, d): &(f64, f64, f64)| {
            let to = to.min(reach);
            let (ei, ga) =
                (e * std::f64::consts::PI * d.powi(4) / 64.0, g * std::f64::consts::PI * d * d / 4.0);
            // Simpson's rule is exact for the parabola (a − s)(b − s).
            let m = |s: f64| (a - s) * (b - s);
            (to - from) * (m(from) + 4.0 * m(0.5 * (from + to)) + m(to)) / (6.0 * ei)
                + (to - from) / (kappa * ga)
        };
        self.chuck + inside.map(of).sum::<f64>()
    }

    fn compliance(&self, a: f64) -> f64 {
        let own = self.cantilever(a, a);
        if self.tailstock.is_infinite() {
            return own;
        }
        let l = self.length_mm;
        own - self.cantilever(a, l).powi(2) / (self.cantilever(l, l) + self.tailstock)
    }
}

/// Elements of the half-cut shaft with the tool at `node`: old diameters ahead, new ones behind,
/// the element at the tool with the diameter of its far end.
fn half_cut(z: &[f64], before: &[f64], after: &[f64], node: usize) -> Vec<(f64, f64, f64)> {
    let diameter = |i: usize| match i {
        _ if i < node => 0.5 * (before[i] + before[i + 1]),
        _ if i == node => after[i + 1],
        _ => 0.5 * (after[i] + after[i + 1]),
    };
    (0..z.len() - 1).map(|i| (z[i], z[i + 1], diameter(i))).collect()
}

/// D = b + 2·w·F(a): the compliance that the cut implies is that of the unit-load method, on a
/// stepped shaft, at shoulders too, with the tailstock yielding or absent.
#[test]
fn the_cut_of_a_stepped_shaft_follows_the_unit_load_method() {
    let contour = steps(&[(80.0, 0.0), (150.0, -5.0), (210.0, -9.0)]);
    for tailstock_n_per_um in [20.0, 0.0] {
        let mut settings = settings();
        settings.support.tailstock_n_per_um = tailstock_n_per_um;
        let mut process = process(&settings, Some(contour.clone()), 210.0);
        let order = plan(Some(&contour), &[40.0, 110.0, 180.0], &[0.0; 3]);
        let followed = process.followed(&order).unwrap();
        let (z, before): (Vec<f64>, Vec<f64>) =
            process.node_z_mm().zip(process.diameter_mm().iter().copied()).unzip();
        process.cut_profile(&order).unwrap();
        let after = process.diameter_mm().to_vec();
        assert_eq!(z.len(), 211 + 2, "a shoulder is two nodes at one place");
        for node in [0, 20, 79, 100, 140, 160, 200, z.len() - 1] {
            let statics = Statics {
                pieces: half_cut(&z, &before, &after, node.min(z.len() - 2)),
                length_mm: 210.0,
                chuck: 1e-3 / settings.support.chuck_n_per_um,
                tailstock: 1e-3 / tailstock_n_per_um,
            };
            let statics = if node + 1 == z.len() {
                Statics { pieces: half_cut(&z, &before, &before, node), ..statics }
            } else {
                statics
            };
            let relative = before[node] - 25.5;
            let implied = (after[node] - (25.0 + relative)) / (2.0 * followed.force(z[node]).passive_n);
            let wanted = statics.compliance(z[node]);
            assert!(
                (implied / wanted - 1.0).abs() < 1e-7,
                "node {node} z {}: {implied:e} {wanted:e}",
                z[node]
            );
        }
    }
}

/// Every section is cut to its own nominal less its own offset: level to its shoulders, which a
/// stiff shaft shows.
#[test]
fn offsets_step_at_a_shoulder() {
    let contour = steps(&[(80.0, 0.0), (160.0, -5.0)]);
    let mut settings = settings();
    settings.support.chuck_n_per_um = f64::INFINITY;
    settings.support.tailstock_n_per_um = f64::INFINITY;
    settings.material.youngs_modulus_n_per_mm2 = Some(1e12);
    let mut process = process(&settings, Some(contour.clone()), 160.0);
    let order = plan(Some(&contour), &[20.0, 60.0, 100.0, 140.0], &[0.01, 0.02, -0.03, -0.01]);
    process.cut_profile(&order).unwrap();
    let z: Vec<f64> = process.node_z_mm().collect();
    let at = |place: f64, last: bool| {
        let mut nodes = (0..z.len()).filter(|i| (z[*i] - place).abs() < 1e-9);
        let node = if last { nodes.next_back() } else { nodes.next() };
        process.diameter_mm()[node.unwrap()]
    };
    for (place, last, wanted) in [
        (5.0, false, 25.0 - 0.01),
        (40.0, false, 25.0 - 0.015),
        (80.0, false, 25.0 - 0.02),
        (80.0, true, 20.0 + 0.03),
        (120.0, false, 20.0 + 0.02),
        (155.0, false, 20.0 + 0.01),
    ] {
        assert!((at(place, last) - wanted).abs() < 1e-6, "{place}: {} {wanted}", at(place, last));
    }
}

/// The body that is rendered has the drawing's shoulders, fillets and tapers, with the allowance of
/// the stock everywhere.
#[test]
fn the_blank_is_the_contour_with_its_allowance() {
    let order = job().loop_job();
    let contour = order.turned_contour().unwrap();
    let stock = Stock { diameter_mm: 29.2, length_mm: 200.0 };
    let form = BaseForm { contour: Some(contour), ..BaseForm::default() };
    let blank = TurningProcess::new(&settings(), stock, &form, 1).unwrap().blank();
    let at = |z: f64| {
        let i = blank.profile.partition_point(|k| k.z_mm < z);
        let (a, b) = (blank.profile[i - 1], blank.profile[i]);
        2.0 * (a.radius_mm + (b.radius_mm - a.radius_mm) * (z - a.z_mm) / (b.z_mm - a.z_mm))
    };
    // Aims: the collar at its nominal, both seats in the middle of h6 (13 µm at 22 mm, 11 at 16).
    for (z, drawn) in [(30.0, 28.0), (69.75, 27.5), (95.0, 21.9935), (180.0, 15.9945)] {
        assert!((at(z) - drawn - 1.2).abs() < 1e-9, "{z}: {} {drawn}", at(z));
    }
    let shoulder = blank.profile.windows(2).any(|k| k[0].z_mm == k[1].z_mm && k[0].z_mm == 70.0);
    assert!(shoulder, "the shoulder is upright");
    assert!((at(140.0) - 1.2 - 20.5).abs() < 0.01, "half way along the taper: {}", at(140.0));
}
