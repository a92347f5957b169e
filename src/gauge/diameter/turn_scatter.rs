//! Scatter of the readings of a revolution that the section's form does not explain.
//!
//! Over a whole revolution every width is measured twice, w(φ) = w(φ + π), whatever the form and
//! the position of the spindle: half the mean square of the n/2 differences is the variance of one
//! width, free of both. Over half a revolution only the even lobes that n/3 of the angles leave to
//! be adjusted (and the filter passes) are form; the remainder is scatter. Either series may be
//! autocorrelated (drift over the revolution): it counts as [`effective_number`] readings, and χ²
//! against the edges' uncertainties tests whether they scatter beyond u.
//!
//! Half a revolution has no opposite edges: with the spindle's axis taken as still at the height m,
//! h(φ + π) = m − bottom(φ). An error of m is a square wave in h over the revolution, ± δm, whose
//! harmonics are odd, 4δm/(πk): they are in the u of the odd lobes. Its least-squares adjustment
//! together with K odd orders leaves u(m) = s·√((XᵀX)⁻¹₀₀), the more the more orders are adjusted:
//! over half a revolution 1 = (4/π)·Σ sin(kφ)/k is itself a sum of odd lobes.

use super::reading_scatter::{ScatterTest, effective_number};
use crate::gauge::limit::limits;

limits! {
    /// What half a revolution determines.
    TurnLimits = "turn_scatter";
    /// Fewest angles of half a revolution whose even lobes leave a residual: a mean and one order
    /// of two terms leave three of six free.
    least_half: usize = 6;
}

/// Scatter of a revolution's widths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TurnScatter {
    /// Standard deviation of one width, mm.
    pub(super) sd_width_mm: f64,
    /// Standard uncertainty of the mean of the widths, mm.
    pub(super) u_mean_mm: f64,
    /// Against the stated uncertainties of the edges.
    pub(crate) test: Option<ScatterTest>,
}

/// Of a whole revolution: `widths_mm` at even angles, an even number; `u_width_mm` states one
/// width.
pub(super) fn of_whole_turn(widths_mm: &[f64], u_width_mm: f64) -> TurnScatter {
    let pairs = widths_mm.len() / 2;
    let differences: Vec<f64> = (0..pairs).map(|i| widths_mm[i] - widths_mm[i + pairs]).collect();
    let square = differences.iter().map(|d| d * d).sum::<f64>();
    scatter(0.5 * square / pairs as f64, pairs as f64, &differences, u_width_mm, widths_mm.len() as f64)
}

/// Over half a revolution: `widths_mm` at even angles over π, filtered at `cutoff_upr`; `None` from
/// too few angles to separate form from scatter.
pub(super) fn of_half_turn(widths_mm: &[f64], cutoff_upr: f64, u_width_mm: f64) -> Option<TurnScatter> {
    let n = widths_mm.len();
    if n < TurnLimits::get().least_half {
        return None;
    }
    // 1 + 2 for each even order up to K, at most two thirds of the readings.
    let orders = ((2 * n / 3 - 1) / 2).min((0.5 * cutoff_upr) as usize);
    let mean = widths_mm.iter().sum::<f64>() / n as f64;
    let mut residual: Vec<f64> = widths_mm.iter().map(|w| w - mean).collect();
    for order in 1..=orders {
        let turned = |i: usize| std::f64::consts::TAU * (order * i) as f64 / n as f64;
        let part = |f: fn(f64) -> f64| {
            2.0 / n as f64 * widths_mm.iter().enumerate().map(|(i, w)| (w - mean) * f(turned(i))).sum::<f64>()
        };
        let (a, b) = (part(f64::cos), part(f64::sin));
        for (i, r) in residual.iter_mut().enumerate() {
            *r -= a * turned(i).cos() + b * turned(i).sin();
        }
    }
    let freedom = (n - 1 - 2 * orders) as f64;
    let square = residual.iter().map(|r| r * r).sum::<f64>();
    Some(scatter(square / freedom, freedom, &residual, u_width_mm, n as f64))
}

fn scatter(variance: f64, freedom: f64, series: &[f64], u_width_mm: f64, n: f64) -> TurnScatter {
    let counted = series.len() as f64 / effective_number(series);
    let test = (u_width_mm > 0.0)
        .then(|| ScatterTest::against(freedom * variance / u_width_mm.powi(2), freedom))
        .flatten();
    TurnScatter { sd_width_mm: variance.sqrt(), u_mean_mm: (variance * counted / n).sqrt(), test }
}

/// Height of the spindle's axis from the middles over half a revolution, and its standard
/// uncertainty.
///
/// The middle is the axis plus odd harmonics of the revolution (eccentricity, odd lobes), whose
/// mean over half a revolution is not zero: both are adjusted together, as many orders as a third
/// of the angles allows. `middles` are (angle in degrees, height in mm), `u_middle_mm` states one;
/// where they scatter more, that counts. `None` where they do not determine it.
pub(super) fn axis_of_half_turn(middles: &[(f64, f64)], u_middle_mm: f64) -> Option<(f64, f64)> {
    let rows = middles.len();
    let orders = (rows.saturating_sub(3) / 6).clamp(1, 3);
    let columns = 1 + 2 * orders;
    let basis = nalgebra::DMatrix::from_fn(rows, columns, |row, column| {
        let turned = (2.0 * column.div_ceil(2) as f64 - 1.0) * middles[row].0.to_radians();
        match column {
            0 => 1.0,
            c if c % 2 == 1 => turned.cos(),
            _ => turned.sin(),
        }
    });
    let heights = nalgebra::DVector::from_iterator(rows, middles.iter().map(|m| m.1));
    let solution = basis.clone().svd(true, true).solve(&heights, 1e-12).ok()?;
    let gain = (basis.transpose() * &basis).try_inverse()?[(0, 0)];
    let residual: Vec<f64> = (&heights - &basis * &solution).iter().copied().collect();
    let freedom = rows.saturating_sub(columns) as f64;
    let square = residual.iter().map(|r| r * r).sum::<f64>();
    let scattered = if freedom > 0.0 { square / freedom } else { 0.0 };
    let counted = rows as f64 / effective_number(&residual);
    let variance = u_middle_mm.powi(2).max(scattered * counted);
    Some((solution[0], (gain * variance).sqrt()))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    use super::*;

    /// Widths with two and four lobes, noise and a drift over the revolution.
    fn widths(n: usize, span: f64, sd: f64, drift: f64, rng: &mut Pcg64) -> Vec<f64> {
        let noise = Normal::new(0.0, sd).unwrap();
        (0..n)
            .map(|i| {
                let (share, angle) = (i as f64 / n as f64, span * i as f64 / n as f64);
                20.0 + 0.01 * (2.0 * angle).cos()
                    + 0.003 * (4.0 * angle + 1.0).sin()
                    + drift * share
                    + noise.sample(rng)
            })
            .collect()
    }

    #[test]
    fn the_scatter_of_a_turn_is_what_its_mean_scatters_by() {
        use std::f64::consts::{PI, TAU};
        let mut rng = Pcg64::seed_from_u64(4);
        let sd = 1e-4;
        let (mut whole, mut half, mut alarms) = (0.0, 0.0, 0);
        for _ in 0..600 {
            let of = of_whole_turn(&widths(72, TAU, sd, 0.0, &mut rng), sd);
            whole += of.u_mean_mm.powi(2) / 600.0;
            alarms += u32::from(of.test.unwrap().beyond_u);
            let of = of_half_turn(&widths(36, PI, sd, 0.0, &mut rng), 50.0, sd).unwrap();
            half += of.u_mean_mm.powi(2) / 600.0;
            alarms += u32::from(of.test.unwrap().beyond_u);
        }
        for (found, n) in [(whole, 72.0_f64), (half, 36.0)] {
            assert!((found.sqrt() / (sd / n.sqrt()) - 1.0).abs() < 0.12, "{n}: {}", found.sqrt());
        }
        assert!(alarms <= 6, "{alarms} of 1200 at a false alarm of 0.1 %");
        // Stated too small by a factor of five: detected.
        assert!(of_whole_turn(&widths(72, TAU, 5.0 * sd, 0.0, &mut rng), sd).test.unwrap().beyond_u);
        // A drift of 20 sd over the revolution: half of it between opposite readings, and the mean
        // is off by no less than a fifth of it.
        let drifting = of_whole_turn(&widths(72, TAU, sd, 20.0 * sd, &mut rng), sd);
        assert!(drifting.test.unwrap().beyond_u && drifting.u_mean_mm > 3.0 * sd, "{drifting:?}");
        assert!(of_half_turn(&[1.0; 5], 50.0, sd).is_none());
    }

    /// Odd lobes that are adjusted and noise: the axis scatters as its uncertainty states. Its gain
    /// over a mean of 36 is √15.
    #[test]
    fn the_axis_of_half_a_turn_is_as_uncertain_as_it_says() {
        let mut rng = Pcg64::seed_from_u64(5);
        let noise = Normal::new(0.0, 1e-4).unwrap();
        let (mut square, mut u_square, runs) = (0.0, 0.0, 800);
        for _ in 0..runs {
            let middles: Vec<(f64, f64)> = (0..36)
                .map(|i| 5.0 * f64::from(i))
                .map(|deg| {
                    let a = f64::to_radians(deg);
                    (
                        deg,
                        3.0 + 5e-3 * (a - 1.0).cos() + 1e-3 * (3.0 * a + 0.4).cos() + noise.sample(&mut rng),
                    )
                })
                .collect();
            let (axis, u) = axis_of_half_turn(&middles, 1e-4).unwrap();
            square += (axis - 3.0).powi(2);
            u_square += u * u;
        }
        let (sd, u) = (f64::sqrt(square / f64::from(runs)), f64::sqrt(u_square / f64::from(runs)));
        assert!((0.85..1.2).contains(&(u / sd)), "{u} {sd}");
        assert!((0.5..0.8).contains(&(sd / 1e-4)), "{sd}");
    }
}
