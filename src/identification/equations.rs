//! The readings as equations in the unknowns.

use super::instrument::{Instrument, Quantity, is_straightness};
use super::observation::{Term, terms};
use super::reading::{Reading, Setup};
use super::reading_set::{Datum, ReadingSet};
use super::settings::Prior;
use super::spline_basis::SplineBasis;
use super::unknowns::{Group, Unknowns};
use crate::machine::{ErrorName, MachineSettings};
use crate::setting::SettingError;

/// How much wider than the machine's errors the datum of a set may be: it is set by hand.
const DATUM_BY_PRIOR: f64 = 1e2;
/// Parts into which positions are dealt for the held-out error: every fifth is left out in turn.
pub(crate) const FOLDS: usize = 5;

/// A set of readings that are checked.
#[derive(Clone, Debug)]
pub(crate) struct CheckedSet {
    /// Its settings.
    pub set: ReadingSet,
    /// Its readings.
    pub readings: Vec<Reading>,
}

/// A reading as an equation: Σ factor·unknown = value ± u.
#[derive(Clone, Debug)]
pub(crate) struct Equation {
    /// Index of its set.
    pub set: usize,
    /// The unknowns with their factors.
    pub factors: Vec<(usize, f64)>,
    /// Value, mm or rad.
    pub value: f64,
    /// Standard uncertainty of the value, mm or rad.
    pub u: f64,
    /// Which fold its position belongs to.
    pub fold: usize,
}

/// What the equations are made of.
pub(crate) struct Sources<'a> {
    /// The machine's geometry.
    pub machine: &'a MachineSettings,
    /// The sets that are used, in the order of the config.
    pub sets: &'a [CheckedSet],
    /// The errors that are sought.
    pub sought: &'a [ErrorName],
    /// The class of the machine.
    pub prior: &'a Prior,
    /// Whether straightnesses keep their slopes.
    pub keeps_lines: bool,
}

/// The unknowns and equations of all readings.
///
/// # Errors
/// An error that the readings do not hold.
pub(crate) fn equations(from: &Sources<'_>) -> Result<(Unknowns, Vec<Equation>), SettingError> {
    let of_set = |checked: &CheckedSet| {
        let terms = |reading: &Reading| terms(from.machine, &checked.set, reading, from.sought);
        checked.readings.iter().map(terms).collect::<Vec<_>>()
    };
    let all: Vec<Vec<Vec<Term>>> = from.sets.iter().map(of_set).collect();
    let mut unknowns = Unknowns::of(from.sought, &all, from.prior, from.keeps_lines)?;
    let mut equations = Vec::new();
    for (k, (checked, terms)) in from.sets.iter().zip(&all).enumerate() {
        let own = OwnUnknowns::of(k, checked, from.prior, &mut unknowns);
        let positions = positions(&checked.readings);
        for (reading, terms) in checked.readings.iter().zip(terms) {
            let mut factors = own.factors(checked, reading);
            for term in terms {
                let Some(error) = unknowns.error(term.error) else { continue };
                let row = error.row(term.position_mm, term.direction);
                factors.extend(row.into_iter().map(|(k, v)| (k, term.factor * v)));
            }
            let place = positions.iter().position(|p| *p == reading.position_mm).unwrap_or(0);
            equations.push(Equation {
                set: k,
                factors,
                value: reading.value - computed_sag_mm(&checked.set, reading),
                u: checked.set.u_of(reading.quantity) / f64::from(reading.rows).sqrt(),
                fold: place % FOLDS,
            });
        }
    }
    Ok((unknowns, equations))
}

/// The unknowns that a set has besides the errors.
struct OwnUnknowns {
    /// Mean values with their slopes, by quantity and set-up.
    datums: Vec<(Quantity, Setup, usize, bool)>,
    artefact: Option<(SplineBasis, usize)>,
    sag: Option<usize>,
    tailstock: Option<usize>,
    middle: f64,
    half: f64,
}

impl OwnUnknowns {
    fn of(k: usize, checked: &CheckedSet, prior: &Prior, unknowns: &mut Unknowns) -> Self {
        let (set, readings) = (&checked.set, &checked.readings);
        let positions = positions(readings);
        let (from, to) = (positions[0], positions[positions.len() - 1]);
        let (length, angle) = (1e-3 * prior.length_um, 1e-6 * prior.angle_urad);
        let mut datums: Vec<(Quantity, Setup, usize, bool)> = Vec::new();
        for reading in readings {
            let (quantity, setup) = (reading.quantity, reading.setup);
            if datums.iter().any(|(q, s, ..)| (*q, *s) == (quantity, setup)) {
                continue;
            }
            let size = DATUM_BY_PRIOR * if quantity.is_length() { length } else { angle };
            let first = unknowns.add(Group::Datum(k), size);
            let has_line = has_line(set, quantity);
            if has_line {
                unknowns.add(Group::Datum(k), size);
            }
            datums.push((quantity, setup, first, has_line));
        }
        let artefact = (set.instrument == Instrument::Straightedge)
            .then(|| SplineBasis::new(from, to, positions.len().saturating_sub(3).max(1)))
            .flatten()
            .map(|basis| {
                let first = unknowns.all.len();
                (0..basis.shapes()).for_each(|_| {
                    unknowns.add(Group::Artefact(k), length);
                });
                (basis, first)
            });
        let has_midline = readings.iter().any(|r| matches!(r.quantity, Quantity::Midline | Quantity::Slope));
        let part = set.part.filter(|_| has_midline);
        let sag = part.filter(|part| part.gravity_x != 0.0);
        let sag = sag.map(|part| unknowns.add(Group::Sag(k), part.sag_u_relative));
        let tailstock = part.filter(|part| part.tailstock(0.0).is_some());
        let tailstock = tailstock.map(|part| unknowns.add(Group::Tailstock(k), 1e-3 * part.tailstock_u_um));
        Self { datums, artefact, sag, tailstock, middle: 0.5 * (from + to), half: 0.5 * (to - from) }
    }

    fn factors(&self, checked: &CheckedSet, reading: &Reading) -> Vec<(usize, f64)> {
        let p = reading.position_mm;
        let mut factors = Vec::new();
        let own =
            |(q, s, ..): &&(Quantity, Setup, usize, bool)| (*q, *s) == (reading.quantity, reading.setup);
        if let Some((.., first, has_line)) = self.datums.iter().find(own) {
            factors.push((*first, 1.0));
            if *has_line {
                factors.push((*first + 1, (p - self.middle) / self.half.max(f64::MIN_POSITIVE)));
            }
        }
        if let Some((basis, first)) = &self.artefact {
            factors.extend(basis.shape(p).into_iter().enumerate().map(|(i, v)| (first + i, v)));
        }
        if let Some(k) = self.sag {
            factors.push((k, computed_sag_mm(&checked.set, reading)));
        }
        if let (Some(k), Some(part)) = (self.tailstock, &checked.set.part) {
            let at = |z: f64| part.tailstock(z).unwrap_or(0.0);
            factors.push((k, along(reading.quantity, p, at)));
        }
        factors
    }
}

/// The computed sag in a midline, or its slope in one of a slope.
fn computed_sag_mm(set: &ReadingSet, reading: &Reading) -> f64 {
    let is_axis = matches!(reading.quantity, Quantity::Midline | Quantity::Slope);
    let Some(part) = set.part.filter(|part| is_axis && part.gravity_x != 0.0) else { return 0.0 };
    along(reading.quantity, reading.position_mm, |z| part.gravity_x * part.sag_mm(z))
}

/// A line of the axis as a midline holds it: itself, or its slope (by a central difference over
/// 0.02 mm: both are polynomials of the fourth degree over tens of mm).
fn along(quantity: Quantity, z_mm: f64, line: impl Fn(f64) -> f64) -> f64 {
    const STEP_MM: f64 = 0.01;
    match quantity {
        Quantity::Slope => (line(z_mm + STEP_MM) - line(z_mm - STEP_MM)) / (2.0 * STEP_MM),
        _ => line(z_mm),
    }
}

/// Whether a slope of the readings is that of how the instrument was set up.
fn has_line(set: &ReadingSet, quantity: Quantity) -> bool {
    match quantity {
        Quantity::Error(name) => is_straightness(name),
        Quantity::Radius | Quantity::Height => set.datum == Some(Datum::Line),
        Quantity::Midline | Quantity::Slope => false,
    }
}

/// The positions of readings, ascending, each once.
pub(crate) fn positions(readings: &[Reading]) -> Vec<f64> {
    let mut all: Vec<f64> = readings.iter().map(|reading| reading.position_mm).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

impl ReadingSet {
    /// Standard uncertainty of a reading, mm or rad; what a check has assured is stated.
    fn u_of(&self, quantity: Quantity) -> f64 {
        let stated =
            if quantity.is_length() { self.u_um.map(|u| 1e-3 * u) } else { self.u_urad.map(|u| 1e-6 * u) };
        stated.unwrap_or(1.0)
    }
}

/// Residuals by their u, rms; none without equations.
pub(crate) fn residual_rms_by_u(equations: &[&Equation], values: &[f64]) -> Option<f64> {
    let left = |equation: &&Equation| {
        let given: f64 = equation.factors.iter().map(|(k, factor)| factor * values[*k]).sum();
        ((equation.value - given) / equation.u).powi(2)
    };
    let sum: f64 = equations.iter().map(left).sum();
    (!equations.is_empty()).then(|| (sum / equations.len() as f64).sqrt())
}

/// The factors of an equation, of unknowns in units of their prior, by its u.
pub(super) fn scaled(equation: &Equation, unknowns: &Unknowns) -> Vec<(usize, f64)> {
    let scale = |(k, factor): &(usize, f64)| (*k, factor * unknowns.all[*k].prior / equation.u);
    equation.factors.iter().map(scale).collect()
}
