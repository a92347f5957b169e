//! The uncertainty of a diameter by the law of propagation and by Monte Carlo (JCGM 101) through
//! the whole measurement: certificates, thermometers, every block of edges of every master's frame
//! → adjustment of the optical setup → the part's edges, temperature, place and finish → diameter
//! at 20 °C. Its sources are the rows of `measure --budget`, by the same names.

use serde::Serialize;

use crate::gauge::Calibration;
use crate::gauge::budget::{Budget, OF_CONDITIONS, Shape, WidthReading, is_rectangular};
use crate::gauge::calibration::{Adjustment, ColumnSpread, Conditions, LensModel, PARAMETERS, Solver};
use crate::gauge::monte_carlo::{
    Distribution, Input, LawOfPropagation, Propagated, StopRule, Validation, law_of_propagation, monte_carlo,
    monte_carlo_adaptive, validate,
};

/// The part under study: a reading of its diameter and the calibration that converts it to
/// millimetres.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PartView {
    reading: WidthReading,
    /// Its budget: the rows of the study.
    budget: Budget,
}

impl PartView {
    /// A part with a diameter at 20 °C in the middle of the field, with the edge noise of `like`.
    /// The lens model is inverted: its rows are those at which the calibrated lens images this
    /// diameter under the conditions.
    ///
    /// `None` for a calibration without an optical setup, and a part that does not fit the field.
    pub(crate) fn of_diameter(
        diameter_mm: f64,
        like: &WidthReading,
        calibration: &Calibration,
        conditions: &Conditions,
    ) -> Option<Self> {
        let lens = &calibration.setup.as_ref()?.lens;
        let middle = lens.centre_row_px;
        let at = |half_px: f64| WidthReading {
            column_px: lens.centre_column_px,
            rows_px: (middle - half_px, middle + half_px),
            chord: 1.0,
            ..like.clone()
        };
        let found_mm = |half_px: f64| at(half_px).budget(calibration, conditions).diameter_mm;
        // The diameter increases with the rows for every lens with distortions of a few per cent.
        let (mut low, mut high) = (0.0, middle);
        if !(found_mm(low) < diameter_mm && diameter_mm <= found_mm(high)) {
            return None;
        }
        for _ in 0..BISECTIONS {
            let half_px = 0.5 * (low + high);
            if found_mm(half_px) < diameter_mm { low = half_px } else { high = half_px }
        }
        let reading = at(0.5 * (low + high));
        let budget = reading.budget(calibration, conditions);
        Some(Self { reading, budget })
    }
}

impl PartView {
    /// Its budget, by the law of propagation.
    pub(crate) fn budget(&self) -> &Budget {
        &self.budget
    }
}

/// Halvings of the rows' range: a range of thousands of px is reduced to 1e-14 px.
const BISECTIONS: usize = 60;

/// Number of trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trials {
    /// A fixed number.
    Fixed(usize),
    /// Until the figures are stable to a fifth of the numerical tolerance, at most this number.
    Adaptive(usize),
}

/// A source's contribution, inputs of one kind together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Source {
    /// The source.
    pub name: String,
    /// Inputs of its kind.
    pub inputs: usize,
    /// Its contribution to the standard uncertainty of the diameter, µm.
    pub u_um: f64,
}

/// Both results side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Uncertainty {
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
    /// Whether the first is validated by the second, at two and at one significant digits of u
    /// (JCGM 101, 8.1).
    pub validation: [Validation; 2],
}

/// Probability of the intervals.
pub(crate) const PROBABILITY: f64 = 0.95;

/// Diameter at 20 °C as a function of all inputs.
struct Model<'a> {
    solver: Solver<'a>,
    perfect: LensModel,
    reading: WidthReading,
    conditions: Conditions,
    deviations: usize,
}

/// Number of inputs of the part, after those of the adjustment, that are not simply additive: T, α,
/// y, edge, drift.
const OF_PART: usize = 5;

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
        let r = &self.reading;
        let along = ColumnSpread {
            mean_px: r.column_px - lens.centre_column_px,
            variance_px2: r.column_variance_px2,
        };
        let (top, bottom) = (r.rows_px.0 - lens.centre_row_px, r.rows_px.1 - lens.centre_row_px);
        let width = lens.ideal_mean(along, bottom) - lens.ideal_mean(along, top);
        let added: f64 = x[self.deviations + OF_PART..].iter().sum();
        let at_t = s * (1.0 + 1e-6 * p[4]) * (1.0 + t * p[2]) * width + o + 2e-3 * p[3] + added;
        self.conditions.part_mm(at_t) / (1.0 + 1e-6 * p[1] * (p[0] - 20.0))
    }
}

fn inputs(adjustment: &Adjustment, calibration: &Calibration, part: &PartView, c: &Conditions) -> Vec<Input> {
    let scale = calibration.scale_mm_per_px;
    let input = |name: String, estimate, distribution| Input { name, estimate, distribution };
    let even = |half| Distribution::Rectangular { half };
    let sources = adjustment.input_sources();
    let mut all: Vec<Input> = adjustment
        .observations()
        .zip(adjustment.sigma_mm())
        .zip(&sources)
        .map(|((o, sigma), name)| {
            input(name.clone(), 0.0, Distribution::Normal { u: sigma / (scale * o.chord) })
        })
        .collect();
    // Priors are in units of their standard uncertainties; for the lens, temperature and expansion
    // only limits are given.
    all.extend(sources.into_iter().skip(adjustment.observations().len()).map(|name| {
        let limits = is_rectangular(&name);
        let distribution = if limits { even(3.0_f64.sqrt()) } else { Distribution::Normal { u: 1.0 } };
        input(name, 0.0, distribution)
    }));
    let of_part = [
        (c.temperature_c, even(c.limit_temperature_k)),
        (c.expansion_um_per_m_k, even(c.limit_expansion_um_per_m_k)),
        (c.axis_y_mm, even(c.limit_axis_y_mm)),
        (0.0, even(c.limit_edge_um)),
        (0.0, even(c.limit_drift_ppm)),
    ];
    for (name, (estimate, distribution)) in OF_CONDITIONS.iter().zip(of_part) {
        all.push(input((*name).to_owned(), estimate, distribution));
    }
    // Every other row of the budget (noise, levels, form, blur …) is additive.
    let calibrated =
        |source: &str| calibration.setup.as_ref().is_some_and(|b| b.parts.iter().any(|p| p.source == source));
    let others = part.budget.contributions.iter();
    for row in others.filter(|r| !calibrated(&r.source) && !OF_CONDITIONS.contains(&r.source.as_str())) {
        all.push(input(row.source.clone(), 0.0, row.distribution()));
    }
    all
}

/// Number of trials of a Monte Carlo, the seed, and what is called after each trial.
#[derive(Clone, Copy)]
pub(crate) struct Draws<'a> {
    /// Their number.
    pub trials: Trials,
    /// Seed.
    pub seed: u64,
    /// Called after each trial, on any thread.
    pub done: &'a (dyn Fn() + Sync),
}

/// Propagates the distributions of all inputs of a diameter; `None` where the masters do not
/// determine the optical setup.
pub(crate) fn uncertainty(
    calibration: &Calibration,
    adjustment: &Adjustment,
    part: &PartView,
    conditions: &Conditions,
    Draws { trials, seed, done }: Draws<'_>,
) -> Option<Uncertainty> {
    let setup = calibration.setup.as_ref()?;
    let model = Model {
        solver: adjustment.solver()?,
        perfect: LensModel::perfect(setup.rows, setup.columns),
        reading: part.reading.clone(),
        conditions: *conditions,
        deviations: adjustment.inputs(),
    };
    let inputs = inputs(adjustment, calibration, part, conditions);
    let value = |x: &[f64]| Some(model.value(x));
    let gum = law_of_propagation(&inputs, value)?;
    let trial = |x: &[f64]| value(x).inspect(|_| done());
    let monte_carlo = match trials {
        Trials::Fixed(trials) => monte_carlo(&inputs, trial, trials, PROBABILITY, seed)?,
        Trials::Adaptive(most) => {
            let tolerance = 0.2 * crate::gauge::monte_carlo::numerical_tolerance(gum.u, 2);
            monte_carlo_adaptive(&inputs, trial, StopRule { tolerance, most }, PROBABILITY, seed)?
        }
    };
    let validation = [2, 1].map(|digits| validate(&gum, &monte_carlo, PROBABILITY, digits));
    Some(Uncertainty {
        y_mm: gum.y,
        u_mm: gum.u,
        interval_mm: gum.interval(PROBABILITY),
        sources: sources(&inputs, &gum, &part.budget),
        monte_carlo,
        validation,
    })
}

/// Contributions of inputs of one name together. A row of the budget whose input has no term of
/// first order (place of the axis x telecentricity, where that is about zero) is taken from the
/// budget.
fn sources(inputs: &[Input], gum: &LawOfPropagation, budget: &Budget) -> Vec<Source> {
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
    for source in &mut all {
        let row = budget.contributions.iter().find(|r| r.source == source.name);
        if let Some(row) = row.filter(|r| matches!(r.shape, Shape::Product { .. })) {
            source.u_um = source.u_um.max(1e3 * row.u_mm);
        }
    }
    all.retain(|source| source.u_um > 0.0);
    all.sort_by(|a, b| b.u_um.total_cmp(&a.u_um));
    all
}
