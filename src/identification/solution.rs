//! A model of the machine's errors, fitted: its errors and the tool's, with their uncertainty.

use super::equations::{CheckedSet, Equation, Sources, equations, residual_rms_by_u};
use super::instrument::{Instrument, Quantity};
use super::least_squares::{Estimate, estimate};
use super::observation::{terms, tool_terms};
use super::rank::{Rank, rank};
use super::reading::Reading;
use super::settings::IdentificationConfig;
use super::unknowns::{LEAST_POSITIONS, SoughtError, Unknowns};
use crate::machine::conditions::Direction;
use crate::machine::{ErrorName, MachineSettings};
use crate::setting::SettingError;

/// A fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// The errors that it has.
    pub errors: Vec<ErrorName>,
    /// Its unknowns.
    pub unknowns: Unknowns,
    /// Their estimate.
    pub estimate: Estimate,
    /// What the readings determine of them.
    pub rank: Rank,
    /// Residuals of each set by their u, rms; none of a set that took no part.
    pub residual_by_u: Vec<Option<f64>>,
}

/// A value with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Valued {
    /// The value, mm or rad.
    pub value: f64,
    /// Its standard uncertainty, mm or rad.
    pub u: f64,
}

/// The errors through the kinematic chain, from all readings.
///
/// # Errors
/// An error that the readings do not hold.
pub(crate) fn structured(
    config: &IdentificationConfig,
    sets: &[CheckedSet],
    sought: &[ErrorName],
) -> Result<Solution, SettingError> {
    let from = Sources { machine: &config.machine, sets, sought, prior: &config.prior, keeps_lines: false };
    Solution::of(&from)
}

/// The errors that a sum of functions of x and of z has, as the tool shows them.
const SUMS: [ErrorName; 4] = [ErrorName::Exx, ErrorName::Ezx, ErrorName::Exz, ErrorName::Ezz];

/// A function of x and one of z for each direction of the tool, from the readings of turned parts
/// and of lengths; none unless these hold every one of the four that is sought.
///
/// # Errors
/// As [`structured`].
pub(crate) fn splines(
    config: &IdentificationConfig,
    sets: &[CheckedSet],
    sought: &[ErrorName],
) -> Result<Option<Solution>, SettingError> {
    let sums: Vec<ErrorName> = SUMS.into_iter().filter(|name| sought.contains(name)).collect();
    let used: Vec<Option<CheckedSet>> = sets.iter().map(of_lengths).collect();
    let own: Vec<CheckedSet> = used.iter().flatten().cloned().collect();
    let has_part = own.iter().any(|checked| checked.set.instrument.is_part());
    if !has_part || !sums.iter().all(|name| is_held(config, &own, *name)) {
        return Ok(None);
    }
    let (machine, prior) = (&config.machine, &config.prior);
    let from = Sources { machine, sets: &own, sought: &sums, prior, keeps_lines: true };
    let mut solution = Solution::of(&from)?;
    let mut residuals = solution.residual_by_u.into_iter();
    solution.residual_by_u =
        used.iter().map(|used| used.as_ref().and_then(|_| residuals.next().flatten())).collect();
    Ok(Some(solution))
}

/// What of a set a sum of functions takes: turned parts, and lengths of a slide.
fn of_lengths(checked: &CheckedSet) -> Option<CheckedSet> {
    let is_taken = |reading: &&Reading| match reading.quantity {
        Quantity::Error(name) => SUMS.contains(&name),
        other => matches!(other, Quantity::Radius | Quantity::Height),
    };
    let readings: Vec<Reading> = checked.readings.iter().filter(is_taken).copied().collect();
    (!readings.is_empty()).then(|| CheckedSet { set: checked.set.clone(), readings })
}

/// Whether readings hold an error at enough positions for a function of its own.
fn is_held(config: &IdentificationConfig, sets: &[CheckedSet], name: ErrorName) -> bool {
    let own = sets.iter().flat_map(|checked| {
        checked.readings.iter().flat_map(|r| terms(&config.machine, &checked.set, r, &[name]))
    });
    let mut places: Vec<f64> = own.map(|term| term.position_mm).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places.len() >= LEAST_POSITIONS
}

/// The sets of turned parts of which there is another of the same kind: what is left out is then
/// still predicted by one.
fn parts_of_several(sets: &[CheckedSet]) -> Vec<usize> {
    let kind = |k: usize| sets[k].set.instrument;
    let has_other =
        |k: &usize| kind(*k).is_part() && (0..sets.len()).any(|other| other != *k && kind(other) == kind(*k));
    (0..sets.len()).filter(has_other).collect()
}

impl Solution {
    fn of(from: &Sources<'_>) -> Result<Self, SettingError> {
        let (unknowns, equations) = equations(from)?;
        let why = "the normal equations of these readings are not positive definite: is an uncertainty of 1e-12 among them?";
        let rank = rank(&unknowns, &equations);
        let estimate = estimate(&unknowns, &equations, &rank, &parts_of_several(from.sets))
            .ok_or_else(|| SettingError::at("readings", why))?;
        let of_set = |k: usize| {
            let own: Vec<&Equation> = equations.iter().filter(|equation| equation.set == k).collect();
            residual_rms_by_u(&own, &estimate.values)
        };
        Ok(Self {
            errors: from.sought.to_vec(),
            rank,
            residual_by_u: (0..from.sets.len()).map(of_set).collect(),
            unknowns,
            estimate,
        })
    }

    /// An error that is sought at a position of its slide.
    pub(crate) fn error(&self, sought: &SoughtError, position_mm: f64, direction: Direction) -> Valued {
        self.valued(&sought.row(position_mm, direction))
    }

    /// The tool's error along a direction (0, 1, 2: X, Y, Z) with the slides at [x, z], mm.
    pub(crate) fn tool(
        &self,
        machine: &MachineSettings,
        at_mm: [f64; 2],
        along: usize,
        direction: Direction,
    ) -> Valued {
        self.valued(&self.tool_factors(machine, at_mm, along, direction))
    }

    /// The tool's error at the second of two places less that at the first, where the tool was set,
    /// mm: what both places have in common is in neither value nor uncertainty.
    pub(crate) fn tool_between(
        &self,
        machine: &MachineSettings,
        [set_mm, at_mm]: [[f64; 2]; 2],
        along: usize,
        direction: Direction,
    ) -> Valued {
        let mut factors = self.tool_factors(machine, at_mm, along, direction);
        let set = self.tool_factors(machine, set_mm, along, direction);
        factors.extend(set.into_iter().map(|(k, factor)| (k, -factor)));
        self.valued(&factors)
    }

    fn tool_factors(
        &self,
        machine: &MachineSettings,
        at_mm: [f64; 2],
        along: usize,
        direction: Direction,
    ) -> Vec<(usize, f64)> {
        let mut factors = Vec::new();
        for term in tool_terms(machine, at_mm, along, direction, &self.errors) {
            let Some(sought) = self.unknowns.error(term.error) else { continue };
            let row = sought.row(term.position_mm, direction);
            factors.extend(row.into_iter().map(|(k, v)| (k, term.factor * v)));
        }
        factors
    }

    /// A linear combination of the unknowns.
    fn valued(&self, factors: &[(usize, f64)]) -> Valued {
        let value = factors.iter().map(|(k, factor)| factor * self.estimate.values[*k]).sum();
        let square: f64 = factors
            .iter()
            .flat_map(|(i, a)| factors.iter().map(move |(j, b)| (*i, *j, a * b)))
            .map(|(i, j, ab)| ab * self.estimate.covariance[(i, j)])
            .sum();
        Valued { value, u: square.max(0.0).sqrt() }
    }

    /// The range of positions over which all errors of a slide are identified, mm; none where no
    /// error of it is. `is_x`: of X, else of Z.
    pub(crate) fn range_mm(&self, is_x: bool) -> Option<[f64; 2]> {
        let axis = if is_x { crate::machine::Axis::X } else { crate::machine::Axis::Z };
        let own = self.unknowns.errors.iter().filter(|sought| sought.error.axis() == axis);
        let ranges =
            own.filter_map(|sought| sought.basis.as_ref().map(super::spline_basis::SplineBasis::range));
        ranges.reduce(|[a, b], [c, d]| [a.max(c), b.min(d)])
    }
}

/// Name of a set in results: its file, or what is simulated.
pub(crate) fn set_name(config: &IdentificationConfig, k: usize) -> String {
    let set = config.readings.get(k);
    let file = set.and_then(|set| set.file.clone());
    file.unwrap_or_else(|| {
        let kind = set.map_or("readings", |set| Instrument::name(set.instrument));
        format!("readings[{k}] ({kind})")
    })
}
