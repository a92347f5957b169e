//! Figures of a variant: what of the readings is right, what is lost, what misleads.

use serde::{Deserialize, Serialize};

/// Counts and sums over readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Counts {
    /// Frames.
    pub frames: usize,
    /// Frames refused as a whole.
    pub refused: usize,
    /// Clean stations with one true value (a disc's edge, a setup's diameter count as one, too).
    pub clean: usize,
    /// Of them those without a value.
    pub lost: usize,
    /// Values of clean stations within U.
    pub covered: usize,
    /// Values of stations with contamination, or of frames without a part.
    pub kept: usize,
    /// Of them those off by more than U and the limit of the contamination study.
    pub mishandled: usize,
    /// Σ (error/u)² of the clean values.
    pub square_over_u: f64,
    /// Σ error² of the clean values, px².
    pub square_px: f64,
}

impl Counts {
    /// Adds another's.
    pub(crate) fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.refused += other.refused;
        self.clean += other.clean;
        self.lost += other.lost;
        self.covered += other.covered;
        self.kept += other.kept;
        self.mishandled += other.mishandled;
        self.square_over_u += other.square_over_u;
        self.square_px += other.square_px;
    }

    /// The figures that are printed.
    pub(crate) fn figures(&self) -> Figures {
        let values = (self.clean - self.lost).max(1) as f64;
        Figures {
            coverage: self.covered as f64 / values,
            rms_error_over_u: (self.square_over_u / values).sqrt(),
            mishandled: self.mishandled,
            lost: self.lost,
            refused: self.refused,
            rms_error_px: (self.square_px / values).sqrt(),
        }
    }
}

/// Figures of a variant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// Share of the clean values whose true one lies within U (k = 2; the 95 % interval of a
    /// calibrated setup).
    pub coverage: f64,
    /// rms of error over u of the clean values.
    pub rms_error_over_u: f64,
    /// Values off by more than U and the limit of the contamination study.
    pub mishandled: usize,
    /// Clean stations without a value.
    pub lost: usize,
    /// Frames refused.
    pub refused: usize,
    /// rms error of the clean values, px.
    pub rms_error_px: f64,
}

/// By how much figures differ from the default's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Change {
    /// Of the coverage, in percent of all values.
    pub coverage_percent: f64,
    /// Of the rms of error over u, in percent of it.
    pub rms_error_over_u_percent: f64,
    /// Of the values mishandled.
    pub mishandled: i64,
    /// Of the clean stations lost.
    pub lost: i64,
    /// Of the frames refused.
    pub refused: i64,
    /// Of the rms error, in percent of it.
    pub rms_error_percent: f64,
}

impl Change {
    /// From the default's figures to a variant's.
    pub(crate) fn between(default: &Figures, variant: &Figures) -> Self {
        let whole = |before: usize, after: usize| after as i64 - before as i64;
        let percent = |before: f64, after: f64| {
            if before > 0.0 { 1e2 * (after / before - 1.0) } else { 0.0 }
        };
        Self {
            coverage_percent: 1e2 * (variant.coverage - default.coverage),
            rms_error_over_u_percent: percent(default.rms_error_over_u, variant.rms_error_over_u),
            mishandled: whole(default.mishandled, variant.mishandled),
            lost: whole(default.lost, variant.lost),
            refused: whole(default.refused, variant.refused),
            rms_error_percent: percent(default.rms_error_px, variant.rms_error_px),
        }
    }

    /// Size by which variants are sorted: a point of coverage, a value mishandled, a station lost,
    /// a frame refused and 10 % of accuracy count alike. It ranks rows and judges nothing.
    pub(crate) fn size(&self) -> f64 {
        let whole = (self.mishandled.abs() + self.lost.abs() + self.refused.abs()) as f64;
        let tenths = 0.1 * (self.rms_error_over_u_percent.abs() + self.rms_error_percent.abs());
        self.coverage_percent.abs() + whole + tenths
    }

    /// Whether a figure changes by as much as is printed.
    pub(crate) fn shows(&self) -> bool {
        let percents = [self.coverage_percent, self.rms_error_over_u_percent, self.rms_error_percent];
        self.mishandled != 0
            || self.lost != 0
            || self.refused != 0
            || percents.iter().any(|percent| percent.abs() >= 0.05)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_of_the_values_that_there_are() {
        let counts = Counts {
            clean: 12,
            lost: 2,
            covered: 9,
            square_over_u: 40.0,
            square_px: 0.1,
            ..Counts::default()
        };
        let figures = counts.figures();
        assert_eq!((figures.coverage, figures.rms_error_over_u, figures.lost), (0.9, 2.0, 2));
        assert!((figures.rms_error_px - 0.1).abs() < 1e-12);
        let change = Change::between(&figures, &Figures { lost: 1, rms_error_px: 0.11, ..figures });
        assert_eq!((change.lost, change.refused, change.shows()), (-1, 0, true));
        assert!((change.rms_error_percent - 10.0).abs() < 1e-9 && (change.size() - 2.0).abs() < 1e-9);
        assert!(!Change::between(&figures, &figures).shows());
    }
}
