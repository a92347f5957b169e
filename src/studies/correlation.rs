//! `study correlation`: one gauge's readings of parts beside another's.
//!
//! ```text
//! E_n = (d − D)/√(U(d)² + U(D)²)               one a part, after ISO/IEC 17043: agrees up to 1
//! d − D = Δ + (b − 1)(D − D̄)                   the line with both uncertain (Deming, York)
//! ```
//!
//! A constant Δ is the edge, the finish or a contact's peaks; a slope is the scale or the
//! temperature; a scatter beyond what both state is form, or an uncertainty that is too small.

use serde::Serialize;

use crate::numerics::both_uncertain::{UncertainLine, UncertainPoint};
use crate::numerics::distributions::chi2_ratio_limit;

/// Coverage factor of stated U.
const K: f64 = 2.0;
/// Least parts: a line has two parameters and needs one more to be judged.
const LEAST_PARTS: usize = 3;
/// Normal quantile beyond which a scatter is more than stated: 1 in 40 of pairs that state right.
const SCATTER_Z: f64 = 1.96;

/// A part as two gauges read it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ComparedPart {
    /// Its name.
    pub part: String,
    /// This gauge's diameter, mm.
    pub d_mm: f64,
    /// Its U (k = 2), mm.
    pub expanded_u_mm: f64,
    /// The other's diameter, mm.
    pub reference_mm: f64,
    /// Its U (k = 2), mm.
    pub reference_expanded_u_mm: f64,
}

/// A part's difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PartDifference {
    /// Its name.
    pub part: String,
    /// The other's diameter, mm.
    pub reference_mm: f64,
    /// This gauge's less the other's, µm.
    pub difference_um: f64,
    /// U of the difference (k = 2), µm.
    pub expanded_u_um: f64,
    /// E_n, with its sign.
    pub e_n: f64,
    /// Whether |E_n| ≤ 1.
    pub agrees: bool,
}

/// Two gauges on the same parts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Correlation {
    /// The parts.
    pub parts: Vec<PartDifference>,
    /// Diameter at the middle of the line, mm.
    pub middle_mm: f64,
    /// Difference there by the line, µm.
    pub offset_um: f64,
    /// Its U (k = 2), µm.
    pub expanded_u_offset_um: f64,
    /// Slope less 1, µm of difference a mm of diameter.
    pub slope_um_per_mm: f64,
    /// Its U (k = 2).
    pub expanded_u_slope_um_per_mm: f64,
    /// Scatter about the line over what both state: 1 where it is as stated.
    pub scatter_ratio: f64,
    /// Whether the scatter is more than stated.
    pub scatters_more: bool,
    /// Parts with |E_n| > 1.
    pub disagreeing: usize,
    /// What it shows, in words.
    pub words: Vec<String>,
}

/// Why parts cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum CorrelationError {
    /// Too few.
    #[error("{0} parts: at least {LEAST_PARTS} are needed for a line")]
    TooFew(usize),
    /// A value that cannot be right.
    #[error("part {part}: {column} = {value}: must be above 0")]
    Value {
        /// The part.
        part: String,
        /// The column.
        column: &'static str,
        /// The value.
        value: f64,
    },
    /// Parts of one size.
    #[error("the parts are of one diameter: parts of at least two sizes give a line")]
    OneSize,
}

/// Compares two gauges.
///
/// # Errors
/// Fewer than three parts, parts of one size, diameters or uncertainties that are not above 0.
pub(crate) fn correlation(parts: &[ComparedPart]) -> Result<Correlation, CorrelationError> {
    if parts.len() < LEAST_PARTS {
        return Err(CorrelationError::TooFew(parts.len()));
    }
    parts.iter().try_for_each(check)?;
    let first_mm = parts[0].reference_mm;
    if parts.iter().all(|p| (p.reference_mm - first_mm).abs() <= 1e-3 * first_mm) {
        return Err(CorrelationError::OneSize);
    }
    let point = |p: &ComparedPart| UncertainPoint {
        x: p.reference_mm,
        u_x: p.reference_expanded_u_mm / K,
        y: p.d_mm,
        u_y: p.expanded_u_mm / K,
    };
    let points: Vec<UncertainPoint> = parts.iter().map(point).collect();
    let line = UncertainLine::through(&points).ok_or(CorrelationError::OneSize)?;
    let freedom = (parts.len() - 2) as f64;
    let scatter_ratio = (line.chi2 / freedom).sqrt();
    let parts: Vec<PartDifference> = parts.iter().map(difference).collect();
    let disagreeing = parts.iter().filter(|p| !p.agrees).count();
    let mut found = Correlation {
        parts,
        middle_mm: line.middle_x,
        offset_um: 1e3 * (line.middle_y - line.middle_x),
        expanded_u_offset_um: 1e3 * K * line.u_middle_y,
        slope_um_per_mm: 1e3 * (line.slope - 1.0),
        expanded_u_slope_um_per_mm: 1e3 * K * line.u_slope,
        scatter_ratio,
        scatters_more: line.chi2 / freedom > chi2_ratio_limit(freedom, SCATTER_Z),
        disagreeing,
        words: Vec::new(),
    };
    found.words = words(&found);
    Ok(found)
}

fn check(part: &ComparedPart) -> Result<(), CorrelationError> {
    let columns = [
        ("d_mm", part.d_mm),
        ("expanded_u_mm", part.expanded_u_mm),
        ("reference_mm", part.reference_mm),
        ("reference_expanded_u_mm", part.reference_expanded_u_mm),
    ];
    match columns.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        Some((column, value)) => Err(CorrelationError::Value { part: part.part.clone(), column, value }),
        None => Ok(()),
    }
}

fn difference(part: &ComparedPart) -> PartDifference {
    let expanded_u_um = 1e3 * part.expanded_u_mm.hypot(part.reference_expanded_u_mm);
    let difference_um = 1e3 * (part.d_mm - part.reference_mm);
    let e_n = difference_um / expanded_u_um;
    PartDifference {
        part: part.part.clone(),
        reference_mm: part.reference_mm,
        difference_um,
        expanded_u_um,
        e_n,
        agrees: e_n.abs() <= 1.0,
    }
}

/// What the figures mean for one who has to act on them.
fn words(found: &Correlation) -> Vec<String> {
    let mut words = Vec::new();
    if found.offset_um.abs() > found.expanded_u_offset_um {
        words.push(format!(
            "a constant difference of {:+.2} ± {:.2} µm at {:.2} mm: the edge (limb, finish, material), or a contact that touches peaks where a \
             silhouette follows the mean line",
            found.offset_um, found.expanded_u_offset_um, found.middle_mm
        ));
    }
    if found.slope_um_per_mm.abs() > found.expanded_u_slope_um_per_mm {
        words.push(format!(
            "a difference that grows by {:+.3} ± {:.3} µm a mm of diameter: the scale, or temperatures ({:.1} K of steel make as much)",
            found.slope_um_per_mm,
            found.expanded_u_slope_um_per_mm,
            found.slope_um_per_mm / 11.5e-3
        ));
    }
    if found.scatters_more {
        words.push(format!(
            "the parts scatter about the line {:.2} times as much as both uncertainties state: form (places that differ), or U that is too small",
            found.scatter_ratio
        ));
    }
    if words.is_empty() {
        words.push("the line shows neither an offset nor a slope beyond its uncertainty".to_owned());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(d_mm: f64, reference_mm: f64) -> ComparedPart {
        let part = format!("{reference_mm}");
        ComparedPart { part, d_mm, expanded_u_mm: 6e-4, reference_mm, reference_expanded_u_mm: 8e-4 }
    }

    /// U of a difference is 1 µm: E_n is the difference in µm.
    #[test]
    fn a_constant_difference_and_a_slope_are_told_apart() {
        let apart: Vec<_> = [10.0, 15.0, 20.0, 25.0].map(|d| part(d + 1.5e-3, d)).to_vec();
        let found = correlation(&apart).unwrap();
        assert!(found.parts.iter().all(|p| (p.e_n - 1.5).abs() < 1e-6 && !p.agrees));
        assert!((found.offset_um - 1.5).abs() < 1e-6 && found.slope_um_per_mm.abs() < 1e-6);
        assert!(found.scatter_ratio < 1e-3 && !found.scatters_more && found.words.len() == 1);
        // √(1 µm² / 4) of a mean of four.
        assert!((found.expanded_u_offset_um - 0.5).abs() < 1e-3, "{}", found.expanded_u_offset_um);
        let steep: Vec<_> = [10.0, 15.0, 20.0, 25.0].map(|d| part(d + 2e-4 * (d - 17.5), d)).to_vec();
        let found = correlation(&steep).unwrap();
        assert!((found.slope_um_per_mm - 0.2).abs() < 1e-6 && found.offset_um.abs() < 1e-6);
        assert!(found.words[0].contains("grows by +0.200"), "{:?}", found.words);
    }

    #[test]
    fn a_scatter_beyond_what_is_stated_is_named() {
        let signs = [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0];
        let parts: Vec<_> =
            signs.iter().zip(10..).map(|(s, d)| part(f64::from(d) + 3e-3 * s, f64::from(d))).collect();
        let found = correlation(&parts).unwrap();
        assert!(found.scatters_more && found.disagreeing == 8, "{found:?}");
    }

    #[test]
    fn parts_that_cannot_be_compared_are_refused() {
        assert_eq!(correlation(&[part(10.0, 10.0)]), Err(CorrelationError::TooFew(1)));
        let same = [part(10.0, 10.0), part(10.001, 10.0), part(10.0, 10.001)];
        assert_eq!(correlation(&same), Err(CorrelationError::OneSize));
        let wrong = ComparedPart { expanded_u_mm: 0.0, ..part(10.0, 10.0) };
        let parts = [wrong, part(11.0, 11.0), part(12.0, 12.0)];
        assert!(matches!(correlation(&parts), Err(CorrelationError::Value { column: "expanded_u_mm", .. })));
    }
}
