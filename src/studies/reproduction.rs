//! The report of a reproduction: the paper's figure, ours, the range accepted for ours, and the
//! resulting verdict.
//!
//! Verdicts are computed from the figure, ours, the range and the basis of ours ([`Basis`]).
//!
//! | basis | ours inside the range | outside |
//! |---|---|---|
//! | [`Basis::Prediction`] | reproduced | not reproduced |
//! | [`Basis::InSample`] | consistent | not reproduced |
//! | [`Basis::Printed`] | consistent | contradiction |
//!
//! A row that needs data which the paper lacks is undetermined; one without figure and range is not
//! in the paper. Only [`Basis::Printed`], which uses the paper's own figures and equations alone,
//! can end in a contradiction.

use serde::Serialize;

/// Verdict on one of a paper's figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// A prediction that was not fitted to the figure agrees with it.
    Reproduced,
    /// A fit to the figure, an identity of the paper's equations or an unchanged input agrees with
    /// it.
    Consistent,
    /// The paper's own figures and equations contradict each other, by arithmetic or geometry
    /// without a constant of ours.
    Contradiction,
    /// The paper lacks data needed for the figure.
    Undetermined,
    /// Ours misses the figure.
    NotReproduced,
    /// The paper has no such figure.
    NotInPaper,
}

impl Verdict {
    /// All, in the order of a summary.
    pub(crate) const ALL: [Self; 6] = [
        Self::Reproduced,
        Self::Consistent,
        Self::Contradiction,
        Self::Undetermined,
        Self::NotReproduced,
        Self::NotInPaper,
    ];

    /// The verdict in words.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Consistent => "consistent",
            Self::Contradiction => "contradiction",
            Self::Undetermined => "undetermined",
            Self::NotReproduced => "not reproduced",
            Self::NotInPaper => "not in the paper",
        }
    }
}

/// The basis of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Basis {
    /// A model whose constants were not fitted to the figure.
    Prediction,
    /// Constants fitted to the figure, an identity of the paper's equations, or an input.
    InSample,
    /// The paper's own figures and equations, and no constant of ours.
    Printed,
    /// Ours alone: there is no figure to compare with.
    Ours,
}

/// The range accepted for ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Accept {
    /// The paper's figure ± this share of it.
    Relative(f64),
    /// The paper's figure ± this value.
    Absolute(f64),
    /// From and to, for what the paper states without a number, or as a limit; either may be
    /// infinite.
    Range(f64, f64),
}

/// A figure of the paper beside ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Row {
    /// Its place in the paper, dotted.
    pub id: String,
    /// Its description.
    pub quantity: String,
    /// Its unit; empty for a number.
    pub unit: String,
    /// The paper's figure; absent where the paper states something without a number.
    pub paper: Option<f64>,
    /// Ours, computed now.
    pub ours: f64,
    /// Ours less the paper's.
    pub difference: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// Why.
    pub reason: String,
    /// The basis of ours.
    pub basis: Basis,
    /// Least accepted for ours; absent where nothing is compared.
    pub accepted_from: Option<f64>,
    /// Most accepted for ours.
    pub accepted_to: Option<f64>,
    /// Data that the paper lacks; absent where nothing is missing.
    pub missing: Option<String>,
    /// The known reason why a figure is not reproduced; absent for any other.
    pub known_miss: Option<String>,
}

/// A figure that is known not to be reproduced: by how much, and why. A different miss is not a
/// known one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KnownMiss {
    /// The row.
    pub id: &'static str,
    /// Ours, in the row's unit; the miss is the known one within 5 % of the largest of it, the
    /// figure and their difference.
    pub ours: f64,
    /// Why ours misses.
    pub reason: &'static str,
}

impl Row {
    fn new(
        (id, quantity, unit): (&str, &str, &str),
        paper: Option<f64>,
        ours: f64,
        (basis, accept): (Basis, Option<Accept>),
        reason: impl Into<String>,
    ) -> Self {
        let range = accept.and_then(|accept| accept.range(paper));
        let mut row = Self {
            id: id.to_owned(),
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            paper,
            ours,
            difference: paper.map(|p| ours - p),
            verdict: Verdict::NotInPaper,
            reason: reason.into(),
            basis,
            accepted_from: range.map(|r| r.0),
            accepted_to: range.map(|r| r.1),
            missing: None,
            known_miss: None,
        };
        row.verdict = row.judged();
        row
    }

    /// A prediction that was not fitted to the paper's figure, or, without one, to its statement.
    pub(crate) fn predicted(
        names: (&str, &str, &str),
        paper: Option<f64>,
        ours: f64,
        accept: Accept,
        reason: impl Into<String>,
    ) -> Self {
        Self::new(names, paper, ours, (Basis::Prediction, Some(accept)), reason)
    }

    /// A fit to the figure, an identity, or an input.
    pub(crate) fn in_sample(
        names: (&str, &str, &str),
        paper: Option<f64>,
        ours: f64,
        accept: Accept,
        reason: impl Into<String>,
    ) -> Self {
        Self::new(names, paper, ours, (Basis::InSample, Some(accept)), reason)
    }

    /// An identity of the paper's equations: ours should be zero to `limit`.
    pub(crate) fn identity(names: (&str, &str, &str), ours: f64, limit: f64, reason: &str) -> Self {
        Self::in_sample(names, Some(0.0), ours, Accept::Absolute(limit), reason)
    }

    /// One of the paper's figures against the value from its other figures and equations. `ours`
    /// must contain no constant of ours.
    pub(crate) fn printed(
        names: (&str, &str, &str),
        paper: Option<f64>,
        ours: f64,
        accept: Accept,
        reason: impl Into<String>,
    ) -> Self {
        Self::new(names, paper, ours, (Basis::Printed, Some(accept)), reason)
    }

    /// A figure that the paper does not have.
    pub(crate) fn ours(names: (&str, &str, &str), ours: f64, reason: impl Into<String>) -> Self {
        Self::new(names, None, ours, (Basis::Ours, None), reason)
    }

    /// The data that the row needs from the paper, each with whether the paper has it.
    #[must_use]
    pub(crate) fn needs(mut self, data: &[(&str, bool)]) -> Self {
        let missing: Vec<&str> = data.iter().filter(|(_, given)| !given).map(|(name, _)| *name).collect();
        self.missing = (!missing.is_empty()).then(|| missing.join(", "));
        self.verdict = self.judged();
        self
    }

    /// Whether ours lies in the accepted range; `None` where nothing is compared.
    pub(crate) fn inside(&self) -> Option<bool> {
        let (from, to) = self.accepted_from.zip(self.accepted_to)?;
        Some(self.ours >= from && self.ours <= to)
    }

    /// The verdict that follows from the other fields.
    pub(crate) fn judged(&self) -> Verdict {
        if self.missing.is_some() {
            return Verdict::Undetermined;
        }
        match (self.basis, self.inside()) {
            (_, None) | (Basis::Ours, _) => Verdict::NotInPaper,
            (Basis::Prediction, Some(true)) => Verdict::Reproduced,
            (Basis::InSample | Basis::Printed, Some(true)) => Verdict::Consistent,
            // NaN does not contradict a figure.
            (Basis::Printed, Some(false)) if self.ours.is_finite() => Verdict::Contradiction,
            (_, Some(false)) => Verdict::NotReproduced,
        }
    }

    /// Whether a figure is missed without a known reason.
    pub(crate) fn is_unexplained_miss(&self) -> bool {
        self.verdict == Verdict::NotReproduced && self.known_miss.is_none()
    }
}

impl Accept {
    fn range(self, paper: Option<f64>) -> Option<(f64, f64)> {
        match self {
            Self::Relative(share) => paper.map(|p| (p - share * p.abs(), p + share * p.abs())),
            Self::Absolute(limit) => paper.map(|p| (p - limit, p + limit)),
            Self::Range(from, to) => Some((from, to)),
        }
    }
}

/// Relative difference within which a miss is the known one.
const SAME_MISS: f64 = 0.05;

/// Adds the known reasons to the rows that miss.
pub(crate) fn explain(rows: &mut [Row], known: &[KnownMiss]) {
    for row in rows.iter_mut().filter(|row| row.verdict == Verdict::NotReproduced) {
        let size = row.difference.unwrap_or(0.0).abs().max(row.paper.unwrap_or(0.0).abs());
        let reason = known
            .iter()
            .filter(|miss| miss.id == row.id)
            .find(|miss| (row.ours - miss.ours).abs() <= SAME_MISS * size.max(miss.ours.abs()));
        row.known_miss = reason.map(|miss| miss.reason.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: (&str, &str, &str) = ("t", "a figure", "mm");

    #[test]
    fn the_verdict_follows_from_basis_and_range() {
        let at = |ours: f64| {
            [
                Row::predicted(NAMES, Some(10.0), ours, Accept::Relative(0.1), ""),
                Row::in_sample(NAMES, Some(10.0), ours, Accept::Absolute(1.0), ""),
                Row::printed(NAMES, None, ours, Accept::Range(9.0, 11.0), ""),
                Row::ours(NAMES, ours, ""),
            ]
            .map(|row| row.verdict)
        };
        let inside = [Verdict::Reproduced, Verdict::Consistent, Verdict::Consistent, Verdict::NotInPaper];
        let outside =
            [Verdict::NotReproduced, Verdict::NotReproduced, Verdict::Contradiction, Verdict::NotInPaper];
        assert_eq!((at(10.9), at(9.1)), (inside, inside));
        assert_eq!((at(11.1), at(8.9)), (outside, outside));
        // NaN does not contradict a figure.
        assert_eq!(at(f64::NAN)[..3], [Verdict::NotReproduced; 3]);
        let negative = Row::predicted(NAMES, Some(-10.0), -10.5, Accept::Relative(0.1), "");
        assert_eq!(negative.verdict, Verdict::Reproduced);
    }

    #[test]
    fn what_the_paper_lacks_leaves_a_figure_undetermined() {
        let row = Row::printed(NAMES, Some(1.0), 5.0, Accept::Absolute(0.1), "");
        assert_eq!(row.clone().needs(&[("n", true)]).verdict, Verdict::Contradiction);
        let lacking = row.needs(&[("n", true), ("t_h", false), ("t_q", false)]);
        assert_eq!((lacking.verdict, lacking.missing.as_deref()), (Verdict::Undetermined, Some("t_h, t_q")));
    }

    #[test]
    fn a_known_miss_is_known_at_its_size_only() {
        let known = [KnownMiss { id: "t", ours: 2.45, reason: "why" }];
        let of = |ours: f64| {
            let mut rows = [Row::predicted(NAMES, Some(2.1), ours, Accept::Relative(0.08), "")];
            explain(&mut rows, &known);
            (rows[0].known_miss.is_some(), rows[0].is_unexplained_miss())
        };
        assert_eq!(of(2.45), (true, false));
        assert_eq!(of(2.9), (false, true));
        assert_eq!(of(2.1), (false, false));
    }
}
