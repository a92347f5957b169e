//! A measured edge: distance and intensity from a file, as from a slanted-edge or knife-edge scan.
//!
//! Two columns, `d_um,intensity`, with an optional header line; lines that start with `#` are
//! skipped; separators and decimal commas as `text_table`. The intensity is that at a point (the
//! pixel's area is integrated later): 0 in the shadow, 1 in the light. Between the samples F runs
//! along the monotone piecewise cubic of Fritsch & Carlson (SIAM J. Numer. Anal. 17, 1980, 238)
//! with the slopes of Fritsch & Butland, which never overshoots.

use std::io::Read;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::table::EdgeSpread;
use crate::render::error::RenderError;
use crate::text_table::{PlainRow, plain_rows};

const KEY: &str = "optics.esf.measured.file";

/// Fewest samples that describe an edge.
const FEWEST: usize = 8;

/// Largest departure of the ends from 0 and 1; a file beyond it is not normalised.
const LEVEL_TOLERANCE: f64 = 0.02;

/// Knots of the table in the smallest distance of two samples.
const KNOTS_PER_SAMPLE: f64 = 4.0;

/// Most knots of the table.
const MOST_KNOTS: f64 = 1e6;

/// What a user sets about a measured edge: a file, read when the config is loaded, or the samples
/// themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MeasuredEsf {
    /// CSV file `d_um,intensity` beside the config; its samples take its place in the resolved
    /// config.
    pub file: Option<String>,
    /// Whether an intensity that falls is refused; false for coherent light, whose rings are real.
    pub monotone: bool,
    /// Distances into the light from the geometric edge, µm on the object, rising.
    pub d_um: Vec<f64>,
    /// Intensity there, 0 in the shadow and 1 in the light.
    pub intensity: Vec<f64>,
}

impl Default for MeasuredEsf {
    fn default() -> Self {
        Self { file: None, monotone: true, d_um: Vec::new(), intensity: Vec::new() }
    }
}

impl MeasuredEsf {
    /// Takes the samples of the file.
    ///
    /// # Errors
    /// As [`MeasuredEdge::read`].
    pub(crate) fn fill(&mut self, from: impl Read) -> Result<(), RenderError> {
        let edge = MeasuredEdge::read(from, self.monotone)?;
        (self.d_um, self.intensity) = edge.samples.into_iter().unzip();
        self.file = None;
        Ok(())
    }

    /// The samples, checked.
    ///
    /// # Errors
    /// As [`MeasuredEdge::read`]; a file that was not read.
    pub(crate) fn edge(&self) -> Result<MeasuredEdge, RenderError> {
        if let Some(file) = &self.file {
            return Err(refuse(
                file,
                "was not read: a config is loaded from a file to find the ones it names",
            ));
        }
        if self.d_um.len() != self.intensity.len() {
            let found = format!("{} distances and {} intensities", self.d_um.len(), self.intensity.len());
            return Err(refuse(&found, "must be as many of the one as of the other"));
        }
        let mut samples = Vec::new();
        for (i, pair) in self.d_um.iter().copied().zip(self.intensity.iter().copied()).enumerate() {
            if !(pair.0.is_finite() && pair.1.is_finite()) {
                return Err(refuse(
                    &format!("sample {}", i + 1),
                    "must be two finite numbers, d_um,intensity",
                ));
            }
            push(&mut samples, pair, i as u64 + 1, self.monotone)?;
        }
        MeasuredEdge::from_samples(samples)
    }
}

/// An edge as samples (d_um, intensity), sorted by distance.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuredEdge {
    samples: Vec<(f64, f64)>,
}

impl MeasuredEdge {
    /// Reads `d_um,intensity` lines. `monotone` refuses an intensity that falls; leave it off for
    /// coherent light, whose rings are real.
    ///
    /// # Errors
    /// Names the line and the valid form: not a number, distances that do not rise, fewer than 8
    /// samples, ends that are not 0 and 1 to 2 %, an intensity that falls where `monotone` is set.
    pub(crate) fn read(mut from: impl Read, monotone: bool) -> Result<Self, RenderError> {
        let right = "must be text with two columns, d_um,intensity";
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).map_err(|e| refuse(&e.to_string(), right))?;
        let mut samples = Vec::new();
        for row in plain_rows(&bytes, &(2..=2)).map_err(|e| refuse(&e.to_string(), right))? {
            match sample(&row) {
                Some(pair) => push(&mut samples, pair, row.line, monotone)?,
                None if samples.is_empty() && row.fields.len() == 2 && row.is_header() => {}
                None => {
                    let found = format!("line {}: '{}'", row.line, row.shown());
                    return Err(refuse(&found, "must be two finite numbers, d_um,intensity"));
                }
            }
        }
        Self::from_samples(samples)
    }

    fn from_samples(samples: Vec<(f64, f64)>) -> Result<Self, RenderError> {
        if samples.len() < FEWEST {
            return Err(refuse(
                &format!("{} samples", samples.len()),
                "must hold at least 8 samples of the edge",
            ));
        }
        let (first, last) = (samples[0], samples[samples.len() - 1]);
        if first.1.abs() > LEVEL_TOLERANCE || (last.1 - 1.0).abs() > LEVEL_TOLERANCE {
            let found = format!("intensity {} at the first sample and {} at the last", first.1, last.1);
            return Err(refuse(
                &found,
                "must be normalised: 0 in the shadow (first) to 1 in the light (last), within 0.02",
            ));
        }
        if first.0 >= 0.0 || last.0 <= 0.0 {
            let found = format!("distances {} to {} µm", first.0, last.0);
            return Err(refuse(&found, "must lie on both sides of the geometric edge at d_um = 0"));
        }
        Ok(Self { samples })
    }

    /// The samples, (µm, intensity).
    #[cfg(test)]
    pub(crate) fn samples(&self) -> &[(f64, f64)] {
        &self.samples
    }

    /// The table. Its outer fifths extend to 0 and 1 beyond the samples.
    ///
    /// # Errors
    /// Refuses samples whose distances differ so much that a table of equal steps would be too
    /// large.
    pub(crate) fn edge_spread(&self) -> Result<EdgeSpread, RenderError> {
        let s = &self.samples;
        let (low, high) = (s[0].0, s[s.len() - 1].0);
        let closest = s.windows(2).map(|w| w[1].0 - w[0].0).fold(f64::INFINITY, f64::min);
        let wanted = ((high - low) / closest * KNOTS_PER_SAMPLE).ceil();
        if wanted > MOST_KNOTS {
            let found = format!("samples {closest} µm apart over {} µm", high - low);
            return Err(refuse(
                &found,
                "needs too fine a table: leave out samples that lie too close together",
            ));
        }
        let slopes = slopes(s);
        // One more step at either end continues the level to 0 and 1.
        let step = (high - low) / wanted;
        let mut knots = vec![(0.0, 0.0)];
        let mut at = 0;
        for i in 0..=wanted as usize {
            let d = (low + i as f64 * step).min(high);
            while at + 2 < s.len() && s[at + 1].0 <= d {
                at += 1;
            }
            knots.push(between(s[at], s[at + 1], slopes[at], slopes[at + 1], d));
        }
        knots.push((1.0, 0.0));
        let truncation = s[0].1.abs().max((1.0 - s[s.len() - 1].1).abs());
        let table = EdgeSpread::from_knots(low - step, step, &knots, 0.0, truncation);
        let error = s.iter().map(|(d, v)| (table.value(*d) - v).abs()).fold(0.0, f64::max);
        Ok(EdgeSpread::from_knots(low - step, step, &knots, error, truncation))
    }
}

fn refuse(found: &str, right: &str) -> RenderError {
    RenderError::setting(KEY, found, right)
}

fn sample(row: &PlainRow) -> Option<(f64, f64)> {
    match row.numbers()?[..] {
        [d_um, intensity] => Some((d_um, intensity)),
        _ => None,
    }
}

fn push(
    samples: &mut Vec<(f64, f64)>,
    pair: (f64, f64),
    line: u64,
    monotone: bool,
) -> Result<(), RenderError> {
    if let Some(before) = samples.last() {
        if pair.0 <= before.0 {
            let found = format!("line {line}: d_um {} after {}", pair.0, before.0);
            return Err(refuse(&found, "distances must rise from line to line"));
        }
        if monotone && pair.1 < before.1 {
            let found = format!("line {line}: intensity {} after {}", pair.1, before.1);
            return Err(refuse(
                &found,
                "must not fall on the way into the light; if the rings are real, set optics.esf.measured.monotone = false",
            ));
        }
    }
    samples.push(pair);
    Ok(())
}

/// Slopes at the samples: weighted harmonic means where both neighbours rise or fall, zero at
/// extrema and ends.
fn slopes(s: &[(f64, f64)]) -> Vec<f64> {
    let mut slopes = vec![0.0; s.len()];
    for i in 1..s.len() - 1 {
        let (before, after) = (s[i].0 - s[i - 1].0, s[i + 1].0 - s[i].0);
        let (left, right) = ((s[i].1 - s[i - 1].1) / before, (s[i + 1].1 - s[i].1) / after);
        if left * right > 0.0 {
            let (w1, w2) = (2.0 * after + before, after + 2.0 * before);
            slopes[i] = (w1 + w2) / (w1 / left + w2 / right);
        }
    }
    slopes
}

fn between(a: (f64, f64), b: (f64, f64), da: f64, db: f64, d: f64) -> (f64, f64) {
    let h = b.0 - a.0;
    let t = (d - a.0) / h;
    let (c1, c2, c3) = (da * h, 3.0 * (b.1 - a.1) - (2.0 * da + db) * h, 2.0 * (a.1 - b.1) + (da + db) * h);
    (a.1 + t * (c1 + t * (c2 + t * c3)), (c1 + t * (2.0 * c2 + t * 3.0 * c3)) / h)
}
