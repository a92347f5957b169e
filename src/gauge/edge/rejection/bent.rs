//! A bent shaft: its middles follow a smooth curve and its widths do not change with it.
//!
//! Contamination on one side widens the shadow by twice the displacement of the middle; bending of
//! the axis does not change the width.

use nalgebra::SVector;

use super::centreline::CentrelineLimits;
use super::departures::Block;
use crate::gauge::limit::limits;
use crate::numerics::normal_equations::NormalEquations;

limits! {
    /// When an axis is bent and nothing contaminates it.
    BentLimits = "bent";
    /// Largest departure of a width from its line over the largest departure of a middle from its
    /// line: a quarter of the ratio that contamination gives, 2.
    most_widening: f64 = 0.5;
    /// Fewest blocks from which such a curve is fitted: four for each of its coefficients.
    least_blocks: usize = 4 * TERMS;
}

/// Coefficients of the curve: half a sine over two fields is approximated to 1e-4 of its height.
const TERMS: usize = 6;

/// Whether the middle of every block lies on a smooth curve while the widths stay on a line.
pub(super) fn is_bent(blocks: &[Block]) -> bool {
    let limits = BentLimits::get();
    let centreline_limits = CentrelineLimits::get();
    if blocks.len() < limits.least_blocks {
        return false;
    }
    let Some(off_curve) = largest(blocks, |b| b.middle, TERMS) else { return false };
    let Some(off_line) = largest(blocks, |b| b.middle, 2) else { return false };
    let Some(widening) = largest(blocks, |b| b.width, 2) else { return false };
    off_curve < centreline_limits.calm_px && widening < limits.most_widening * off_line
}

/// Largest departure from the least-squares polynomial of `terms` coefficients; `None` where a
/// value is missing.
fn largest(blocks: &[Block], value: impl Fn(&Block) -> f64, terms: usize) -> Option<f64> {
    let mut fit = NormalEquations::<TERMS>::new();
    (terms..TERMS).for_each(|k| fit.normal[(k, k)] = 1.0);
    let basis =
        |b: &Block| SVector::<f64, TERMS>::from_fn(|k, _| if k < terms { b.x.powi(k as i32) } else { 0.0 });
    for block in blocks {
        fit.add(basis(block), value(block), 1.0);
    }
    let found = fit.by_inverse()?;
    let mut off = blocks.iter().map(|b| (value(b) - found.dot(&basis(b))).abs());
    off.try_fold(0.0_f64, |most, d| d.is_finite().then(|| most.max(d)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(middle: impl Fn(f64) -> f64, width: impl Fn(f64) -> f64) -> Vec<Block> {
        (0..80)
            .map(|index| {
                let x = 2.0 * (index as f64 + 0.5) / 80.0 - 1.0;
                Block { index, x, middle: middle(x), width: width(x) }
            })
            .collect()
    }

    #[test]
    fn a_bent_axis_is_no_matter_and_matter_is_no_bent_axis() {
        let bend = |x: f64| 3.0 * (1.2 * x + 0.4).sin();
        assert!(is_bent(&blocks(bend, |_| 0.0)) && is_bent(&blocks(bend, |x| 0.3 * x)));
        // A long protrusion on one side: the middle moves by half of what the width grows by.
        let bump = |x: f64| (-4.0 * x * x).exp();
        assert!(!is_bent(&blocks(|x| 0.5 * bump(x), bump)));
        assert!(!is_bent(&blocks(|x| bend(x) + 0.5 * bump(x), |x| 2.0 * bump(x))));
        // A short chip leaves the curve.
        let chip = |x: f64| if x.abs() < 0.05 { 0.4 } else { 0.0 };
        assert!(!is_bent(&blocks(|x| bend(x) + 0.5 * chip(x), chip)));
        assert!(!is_bent(&blocks(bend, |_| f64::NAN)) && !is_bent(&blocks(bend, |_| 0.0)[..10]));
    }
}
