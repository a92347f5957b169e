//! The unknowns: what of each error is sought, and what the readings hold besides.
//!
//! By the conventions of ISO 230-1 an error of motion is zero at its datum: no offsets; the slope
//! of a straightness is that of its axis, an orientation (the model of splines, which has none,
//! keeps it). Positioning and angles keep their slopes. Where an error is read in both directions,
//! its reversal B is a line over the position, half of it with the direction's sign.

use super::instrument::is_straightness;
use super::observation::Term;
use super::settings::Prior;
use super::spline_basis::SplineBasis;
use crate::machine::conditions::Direction;
use crate::machine::error_name::{Component, ErrorName};
use crate::setting::SettingError;

/// Most segments of an error's spline: knots every twenty-fourth of the range follow waves down to
/// a twelfth of it, as finely as positions of acceptance tests stand.
const MOST_SEGMENTS: usize = 24;
/// Fewest positions at which an error must be read: a line and two of its shape.
pub(crate) const LEAST_POSITIONS: usize = 4;
/// Positions closer than this are one, mm.
const SAME_MM: f64 = 1e-6;

/// What of an error, or of a set, an unknown is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    /// The slope over the range.
    Slope(ErrorName),
    /// What is left of a straight line.
    Shape(ErrorName),
    /// Reversal: its mean and its slope.
    Reversal(ErrorName),
    /// An orientation.
    Orientation(ErrorName),
    /// The mean value of a set, or its line.
    Datum(usize),
    /// The shape of a set's straightedge.
    Artefact(usize),
    /// The sag of a set's part, relative to the computed one.
    Sag(usize),
    /// The place of a set's tailstock.
    Tailstock(usize),
}

impl Group {
    /// The error that it is of, where it is of one.
    pub(crate) fn error(&self) -> Option<ErrorName> {
        match self {
            Self::Slope(e) | Self::Shape(e) | Self::Reversal(e) | Self::Orientation(e) => Some(*e),
            _ => None,
        }
    }
}

/// An unknown.
#[derive(Clone, Debug)]
pub(crate) struct Unknown {
    /// What it is.
    pub group: Group,
    /// Its standard deviation before any reading, mm or rad; a number of a sag.
    pub prior: f64,
}

/// An error as a function of its slide's position.
#[derive(Clone, Debug)]
pub(crate) struct SoughtError {
    /// Which.
    pub error: ErrorName,
    /// Over the positions at which it is read; none of an orientation.
    pub basis: Option<SplineBasis>,
    /// Index of its first unknown.
    pub first: usize,
    /// Whether its slope is an unknown.
    pub has_slope: bool,
    /// Index of the unknowns of its reversal.
    pub reversal: Option<usize>,
}

/// All errors that are sought, and all unknowns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unknowns {
    /// The errors.
    pub errors: Vec<SoughtError>,
    /// The unknowns, those of errors first.
    pub all: Vec<Unknown>,
}

impl Unknowns {
    /// The unknowns of errors by where the terms of all readings, set by set, have them. With
    /// `keeps_lines` straightnesses keep their slopes.
    ///
    /// # Errors
    /// An error that no reading holds, or at too few positions.
    pub(crate) fn of(
        sought: &[ErrorName],
        terms: &[Vec<Vec<Term>>],
        prior: &Prior,
        keeps_lines: bool,
    ) -> Result<Self, SettingError> {
        let mut unknowns = Self::default();
        for error in sought {
            let of = |set: &Vec<Vec<Term>>| -> Vec<Term> {
                set.iter().flatten().filter(|term| term.error == *error).copied().collect()
            };
            let own: Vec<Vec<Term>> = terms.iter().map(of).collect();
            if own.iter().all(Vec::is_empty) {
                let why = format!(
                    "{} is in no reading: add readings that hold it ({}), or leave it out",
                    error.code(),
                    error.meaning()
                );
                return Err(SettingError::at("identify", why));
            }
            unknowns.push(*error, &own, prior, keeps_lines)?;
        }
        Ok(unknowns)
    }

    fn push(
        &mut self,
        error: ErrorName,
        own: &[Vec<Term>],
        prior: &Prior,
        keeps_lines: bool,
    ) -> Result<(), SettingError> {
        let size = if error.is_length() { 1e-3 * prior.length_um } else { 1e-6 * prior.angle_urad };
        let first = self.all.len();
        let mut add = |group: Group, prior: f64| self.all.push(Unknown { group, prior });
        if matches!(error.component(), Component::Orientation(_)) {
            add(Group::Orientation(error), size);
            self.errors.push(SoughtError { error, basis: None, first, has_slope: false, reversal: None });
            return Ok(());
        }
        let all: Vec<Term> = own.iter().flatten().copied().collect();
        let (positions, has_both) = places(&all);
        let in_one_set = own.iter().map(|set| places(set).0.len()).max().unwrap_or(0);
        if positions.len() < LEAST_POSITIONS {
            let why = format!(
                "{} is read at {} positions of its slide ({:?} mm): at least {LEAST_POSITIONS} are needed, or leave it out",
                error.code(),
                positions.len(),
                positions
            );
            return Err(SettingError::at("identify", why));
        }
        // with its datum and a slope, as many unknowns as positions of the set that has the most
        let segments = in_one_set.saturating_sub(3).clamp(1, MOST_SEGMENTS);
        let basis = SplineBasis::new(positions[0], positions[positions.len() - 1], segments);
        let shapes = basis.as_ref().map_or(0, SplineBasis::shapes);
        let has_slope = keeps_lines || !is_straightness(error);
        if has_slope {
            add(Group::Slope(error), size);
        }
        (0..shapes).for_each(|_| add(Group::Shape(error), size));
        let reversal = has_both.then_some(first + usize::from(has_slope) + shapes);
        if has_both {
            (0..2).for_each(|_| add(Group::Reversal(error), size));
        }
        self.errors.push(SoughtError { error, basis, first, has_slope, reversal });
        Ok(())
    }

    /// An unknown beside the errors; its index.
    pub(crate) fn add(&mut self, group: Group, prior: f64) -> usize {
        self.all.push(Unknown { group, prior });
        self.all.len() - 1
    }

    /// An error that is sought.
    pub(crate) fn error(&self, name: ErrorName) -> Option<&SoughtError> {
        self.errors.iter().find(|sought| sought.error == name)
    }
}

impl SoughtError {
    /// The unknowns of its value at a position with their coefficients.
    pub(crate) fn row(&self, position_mm: f64, direction: Direction) -> Vec<(usize, f64)> {
        let Some(basis) = &self.basis else { return vec![(self.first, 1.0)] };
        let s = basis.slope(position_mm);
        let mut row = Vec::with_capacity(basis.shapes() + 3);
        if self.has_slope {
            row.push((self.first, s));
        }
        let first = self.first + usize::from(self.has_slope);
        row.extend(basis.shape(position_mm).into_iter().enumerate().map(|(k, v)| (first + k, v)));
        if let Some(reversal) = self.reversal {
            let half = if direction == Direction::Backward { -0.5 } else { 0.5 };
            row.extend([(reversal, half), (reversal + 1, half * s)]);
        }
        row
    }
}

/// The positions of terms, ascending, each once, and whether both directions are among them.
fn places(terms: &[Term]) -> (Vec<f64>, bool) {
    let mut positions: Vec<f64> = terms.iter().map(|term| term.position_mm).collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|a, b| (*a - *b).abs() <= SAME_MM);
    let is_back = |term: &&Term| term.direction == Direction::Backward;
    let back = terms.iter().filter(is_back).count();
    (positions, back > 0 && back < terms.len())
}
