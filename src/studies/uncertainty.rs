//! The uncertainty of a diameter by the law of propagation and by Monte Carlo (JCGM 101) through the whole measurement:
//! certificates, thermometers, every block of edges of every master's frame → adjustment of the bench → the part's edges,
//! temperature, place and finish → diameter at 20 °C.

use serde::Serialize;

use crate::gauge::Calibration;
use crate::gauge::bench::{Adjustment, Conditions, LensModel, PARAMETERS, Solver, shared_source};
use crate::gauge::monte_carlo::{
    Distribution, Input, LawOfPropagation, Propagated, Validation, law_of_propagation, monte_carlo,
    monte_carlo_adaptive, validate,
};

/// The part whose diameter is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartView {
    /// Column from the frame's centre, px.
    pub column_px: f64,
    /// Rows of its edges from the frame's centre, px.
    pub rows_px: (f64, f64),
    /// Standard uncertainty of its width by noise and levels, px.
    pub u_width_px: f64,
}

/// How many trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trials {
    /// So many.
    Fixed(usize),
    /// Until the figures are stable to a fifth of the numerical tolerance, at most so many.
    Adaptive(usize),
}

/// A source's contribution, inputs of one kind together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Source {
    /// The source.
    pub name: String,
    /// Inputs of its kind.
    pub inputs: usize,
    /// Standard uncertainty it gives the diameter, µm.
    pub u_um: f64,
}

/// Both results side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// By the law of propagation, mm.
    pub y_mm: f64,
    /// Its standard uncertainty, mm.
    pub u_mm: f64,
    /// Its 95 % interval, mm.
    pub interval_mm: (f64, f64),
    /// Sources, largest first.
    pub sources: Vec<Source>,
    /// By Monte Carlo, mm.
    pub monte_carlo: Propagated,
    /// Whether the first is validated by the second, at two and at one significant digits of u (JCGM 101, 8.1).
    pub validation: [Validation; 2],
}

/// Probability of the intervals.
pub const PROBABILITY: f64 = 0.95;

/// Diameter at 20 °C as a function of all inputs.
struct Model<'a> {
    solver: Solver<'a>,
    perfect: LensModel,
    part: PartView,
    deviations: usize,
}

/// Inputs of the part behind those of the adjustment: width, T, α, y, edge, drift.
const OF_PART: usize = 6;

impl Model<'_> {
    fn value(&self, x: &[f64]) -> f64 {
        let [s, o, a, q, g, t]: [f64; PARAMETERS] = self.solver.parameters(&x[..self.deviations]);
        let lens = LensModel {
            radial: a,
            keystone_across: q,
            keystone_along: g,
            telecentricity_per_mm: t,
            ..self.perfect
        };
        let p = &x[self.deviations..self.deviations + OF_PART];
        let PartView { column_px, rows_px, .. } = self.part;
        let width = lens.ideal(column_px, rows_px.1) - lens.ideal(column_px, rows_px.0) + p[0];
        let at_t = s * (1.0 + 1e-6 * p[5]) * (1.0 + t * p[3]) * width + o + 2e-3 * p[4];
        at_t / (1.0 + 1e-6 * p[2] * (p[1] - 20.0))
    }
}

fn inputs(adjustment: &Adjustment, scale: f64, part: &PartView, c: &Conditions) -> Vec<Input> {
    let input = |name: String, estimate, distribution| Input { name, estimate, distribution };
    let normal = |u| Distribution::Normal { u };
    let even = |half| Distribution::Rectangular { half };
    let mut all: Vec<Input> = adjustment
        .observations()
        .iter()
        .zip(adjustment.sigma_mm())
        .map(|(o, sigma)| input("edges of the masters".to_owned(), 0.0, normal(sigma / (scale * o.chord))))
        .collect();
    // Priors count in units of their standard uncertainties.
    let limit = even(3.0_f64.sqrt());
    for name in ["distortion", "keystone", "keystone", "telecentricity of the lens"] {
        all.push(input(name.to_owned(), 0.0, limit));
    }
    for master in adjustment.masters() {
        all.push(input(format!("certificate of {}", master.name), 0.0, normal(1.0)));
    }
    for name in adjustment.laboratories() {
        all.push(input(shared_source(name), 0.0, normal(1.0)));
    }
    all.push(input("temperature of the masters".to_owned(), 0.0, limit));
    all.push(input("expansion of the masters".to_owned(), 0.0, limit));
    while all.len() < adjustment.inputs() {
        all.push(input("levels of the masters' frames".to_owned(), 0.0, normal(1.0)));
    }
    let of_part = [
        ("edges of the part", 0.0, normal(part.u_width_px)),
        ("temperature of the part", c.temperature_c, even(c.limit_temperature_k)),
        ("expansion of the part", c.expansion_um_per_m_k, even(c.limit_expansion_um_per_m_k)),
        ("place of the part's axis", c.axis_y_mm, even(c.limit_axis_y_mm)),
        ("edges unlike the masters'", 0.0, even(c.limit_edge_um)),
        ("drift of the scale", 0.0, even(c.limit_drift_ppm)),
    ];
    all.extend(of_part.map(|(name, estimate, distribution)| input(name.to_owned(), estimate, distribution)));
    all
}

/// Propagates the distributions of everything that a diameter depends on; `None` where the masters determine no bench.
pub fn uncertainty(
    calibration: &Calibration,
    adjustment: &Adjustment,
    part: PartView,
    conditions: &Conditions,
    trials: Trials,
    seed: u64,
) -> Option<Uncertainty> {
    let bench = calibration.bench.as_ref()?;
    let model = Model {
        solver: adjustment.solver()?,
        perfect: LensModel::perfect(bench.rows, bench.columns),
        part,
        deviations: adjustment.inputs(),
    };
    let inputs = inputs(adjustment, calibration.scale_mm_per_px, &part, conditions);
    let value = |x: &[f64]| Some(model.value(x));
    let gum = law_of_propagation(&inputs, value)?;
    let monte_carlo = match trials {
        Trials::Fixed(trials) => monte_carlo(&inputs, value, trials, PROBABILITY, seed)?,
        Trials::Adaptive(most) => {
            let tolerance = 0.2 * crate::gauge::monte_carlo::numerical_tolerance(gum.u, 2);
            monte_carlo_adaptive(&inputs, value, tolerance, most, PROBABILITY, seed)?
        }
    };
    let validation = [2, 1].map(|digits| validate(&gum, &monte_carlo, PROBABILITY, digits));
    Some(Uncertainty {
        y_mm: gum.y,
        u_mm: gum.u,
        interval_mm: gum.interval(PROBABILITY),
        sources: sources(&inputs, &gum),
        monte_carlo,
        validation,
    })
}

/// Contributions of inputs of one name together.
fn sources(inputs: &[Input], gum: &LawOfPropagation) -> Vec<Source> {
    let mut all: Vec<Source> = Vec::new();
    for (input, u) in inputs.iter().zip(&gum.contributions) {
        match all.iter_mut().find(|s| s.name == input.name) {
            Some(source) => {
                source.u_um = source.u_um.hypot(1e3 * u);
                source.inputs += 1;
            }
            None => all.push(Source { name: input.name.clone(), inputs: 1, u_um: 1e3 * u }),
        }
    }
    all.sort_by(|a, b| b.u_um.total_cmp(&a.u_um));
    all
}
