//! What a reproduction of a paper reports: its figure, ours, and the verdict.

use serde::Serialize;

/// Verdict on one of a paper's figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Ours agrees from the paper's own statements.
    Reproduced,
    /// Ours agrees within wider limits or with an assumption that the reason names.
    Consistent,
    /// The paper's figure cannot be right, or contradicts another of its figures; the reason says how.
    Contradiction,
}

/// A figure of the paper beside ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Where it stands in the paper, dotted.
    pub id: String,
    /// What it is.
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
}

impl Row {
    /// A row judged by hand.
    pub fn judged(
        (id, quantity, unit): (&str, &str, &str),
        paper: Option<f64>,
        ours: f64,
        verdict: Verdict,
        reason: impl Into<String>,
    ) -> Self {
        Self {
            id: id.to_owned(),
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            paper,
            ours,
            difference: paper.map(|p| ours - p),
            verdict,
            reason: reason.into(),
        }
    }

    /// Reproduced where ours lies within `limit` (relative) of the paper's figure, else a contradiction; the reason
    /// gets the deviation.
    pub fn within(names: (&str, &str, &str), paper: f64, ours: f64, limit: f64, reason: &str) -> Self {
        let deviation = ours / paper - 1.0;
        let inside = deviation.abs() <= limit;
        let verdict = if inside { Verdict::Reproduced } else { Verdict::Contradiction };
        let side = if inside { "within" } else { "outside" };
        let text = format!("{:+.2} %, {side} {} %; {reason}", 100.0 * deviation, 100.0 * limit);
        Self::judged(names, Some(paper), ours, verdict, text)
    }

    /// Ours should be zero to `limit`: an identity of the paper's equations.
    pub fn identity(names: (&str, &str, &str), ours: f64, limit: f64, reason: &str) -> Self {
        let verdict = if ours.abs() <= limit { Verdict::Reproduced } else { Verdict::Contradiction };
        Self::judged(names, Some(0.0), ours, verdict, reason)
    }

    /// Takes a reproduced row down to consistent: it needs an assumption that the paper does not state.
    #[must_use]
    pub fn by_assumption(mut self) -> Self {
        if self.verdict == Verdict::Reproduced {
            self.verdict = Verdict::Consistent;
        }
        self
    }
}
