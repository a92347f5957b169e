//! Coverage of a budget: k and U for a probability.
//!
//! k is Student's t at the effective degrees of freedom (GUM G.3, G.4), as long as the sum of the
//! rows is a normal's. A row of which only limits are known bounds its errors: where such rows are
//! a good part of the variance, k·u would state more than the sum can be off with that probability,
//! up to 2u = 1.15 half widths of a single rectangle. There k is that of the convolution of the
//! rectangles with the rest (JCGM 101, 5.2 and 7.7, for the linear model), never above t:
//!
//! ```text
//! P(|X| ≤ w) = ∫ g(r)·[Φ((w − r)/s) − Φ((−w − r)/s)] dr    g  density of the sum of rectangles
//! ```
//!
//! with s the standard uncertainty of the rest; from fewer than `coverage.few_freedom` degrees of
//! freedom Student's t stands in place of Φ.

use rand_pcg::Pcg64;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::budget::{Budget, Contribution, DRAWS, PROBABILITY, Shape};
use super::monte_carlo::Distribution;
use crate::gauge::limit::limits;
use crate::gauge::width::reused::Reused;
use crate::numerics::distributions::{phi_cdf, student};

limits! {
    /// When rectangles are convolved with the rest.
    CoverageLimits = "coverage";
    /// Share of rectangles in the variance up to which their density is not evaluated: their sum
    /// with the rest is then a normal to 0.1 % of k.
    least_share: f64 = 0.1;
    /// Cells of the rectangles' density: one is 0.8 % of their reach to either side, and within it
    /// the sum is a line.
    cells: usize = 256;
    /// Degrees of freedom from which on t is a normal that is wider by 4 %: student(30, 0.9545)/2.
    few_freedom: f64 = 30.0;
}

impl Contribution {
    /// Its distribution, scaled to the diameter.
    pub(crate) fn distribution(&self) -> Distribution {
        match (self.shape, self.freedom) {
            (Shape::Rectangular, _) => Distribution::Rectangular { half: self.u_mm * 3.0_f64.sqrt() },
            (Shape::Product { known }, _) => Distribution::Product { u: self.u_mm, known },
            (Shape::Normal, Some(freedom)) if freedom < 100.0 => {
                Distribution::StudentT { scale: self.u_mm, freedom: freedom.max(2.1) }
            }
            (Shape::Normal, _) => Distribution::Normal { u: self.u_mm },
        }
    }
}

impl Budget {
    /// Coverage factor for a probability: see the module.
    pub(crate) fn coverage_factor(&self, probability: f64) -> f64 {
        let factor = student(self.effective_freedom(), probability);
        match self.bounded_half_width(probability) {
            Some(half) => factor.min(half / self.u_mm()),
            None => factor,
        }
    }

    /// The coverage factor given, else that of [`PROBABILITY`] at the effective degrees of freedom,
    /// to four decimals: 2 where there are many.
    pub(crate) fn factor_or(&self, given: Option<f64>) -> f64 {
        given.unwrap_or_else(|| (1e4 * self.coverage_factor(PROBABILITY)).round() / 1e4)
    }

    /// Half width of the interval about the diameter that holds a probability when every row has
    /// its own distribution (JCGM 101 for the linear model, [`DRAWS`] draws, always the same): with
    /// one dominant rectangular row it is narrower than k·u of a normal.
    pub(crate) fn half_width_mm(&self, probability: f64) -> f64 {
        let mut random = Pcg64::new(0x6275_6467_6574, 1);
        let distributions: Vec<Distribution> =
            self.contributions.iter().map(Contribution::distribution).collect();
        let mut sums: Vec<f64> = (0..DRAWS)
            .map(|_| distributions.iter().map(|d| d.draw(&mut random)).sum::<f64>().abs())
            .collect();
        let at = ((probability * DRAWS as f64) as usize).min(DRAWS - 1);
        *sums.select_nth_unstable_by(at, f64::total_cmp).1
    }

    /// Half width by the convolution of the rectangular rows with the rest; `None` where they
    /// hardly make a difference.
    fn bounded_half_width(&self, probability: f64) -> Option<f64> {
        let limits = CoverageLimits::get();
        // A product whose factor is known to 5 % is the rectangle of its other factor.
        let rectangle =
            |shape| shape == Shape::Rectangular || matches!(shape, Shape::Product { known } if known > 0.95);
        let bounded = |c: &&Contribution| rectangle(c.shape) && c.u_mm > 0.0;
        let halves: Reused<f64> =
            self.contributions.iter().filter(bounded).map(|c| c.u_mm * 3.0_f64.sqrt()).collect();
        let variance = halves.iter().map(|a| a * a / 3.0).sum::<f64>();
        let total = self.u_mm().powi(2);
        if !(variance > limits.least_share * total) || !total.is_finite() {
            return None;
        }
        let others = || self.contributions.iter().filter(|c| !bounded(c));
        let rest = others().map(|c| c.u_mm * c.u_mm).sum::<f64>().sqrt();
        let fourth: f64 = others().filter_map(|c| c.freedom.map(|n| c.u_mm.powi(4) / n.max(1.0))).sum();
        let freedom = if fourth > 0.0 { rest.powi(4) / fourth } else { f64::INFINITY };
        Some(half_width(&halves, &Rest::new(rest, freedom, probability), probability))
    }
}

/// The part added to the rectangles: a normal distribution, or Student's t where it has few degrees
/// of freedom.
struct Rest {
    s: f64,
    student: Option<StudentsT>,
}

impl Rest {
    fn new(u: f64, freedom: f64, probability: f64) -> Self {
        if freedom < CoverageLimits::get().few_freedom {
            // As in the draws: below two degrees of freedom there is no standard deviation.
            return Self { s: u, student: StudentsT::new(0.0, 1.0, freedom.max(2.1)).ok() };
        }
        // Widened to its t distribution alone: beside rectangles within 1 %.
        let wider = student(freedom, probability) / student(f64::INFINITY, probability);
        Self { s: u * wider, student: None }
    }

    fn cdf(&self, x: f64) -> f64 {
        self.student.as_ref().map_or_else(|| phi_cdf(x / self.s), |t| t.cdf(x / self.s))
    }
}

/// Half width that holds a probability of the sum of rectangles ± `halves` and the rest.
fn half_width(halves: &[f64], rest: &Rest, probability: f64) -> f64 {
    let reach: f64 = halves.iter().sum();
    let density = Density::of(halves, reach);
    let rest = &Rest { s: rest.s.max(1e-3 * reach / CoverageLimits::get().cells as f64), ..*rest };
    let s = rest.s;
    let covered = |w: f64| {
        let of = |(j, mass): (usize, &f64)| {
            let r = density.middle(j);
            mass * (rest.cdf(w - r) - rest.cdf(-w - r))
        };
        density.masses.iter().enumerate().map(of).sum::<f64>()
    };
    let (mut low, mut high) = (0.0, reach + 8.0 * s);
    while covered(high) < probability && high < 1e3 * (reach + s) {
        high *= 2.0;
    }
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if covered(middle) < probability { low = middle } else { high = middle }
    }
    high
}

/// Density of a sum of rectangles in equal cells over ± `reach`.
struct Density {
    masses: Reused<f64>,
    reach: f64,
}

impl Density {
    /// Convolves one rectangle after the other, the largest first, through the integral of the
    /// density.
    fn of(halves: &[f64], reach: f64) -> Self {
        let limits = CoverageLimits::get();
        let mut sorted: Reused<f64> = halves.iter().copied().collect();
        sorted.sort_by(|a, b| b.total_cmp(a));
        let border = |k: usize| reach * (2.0 * k as f64 / limits.cells as f64 - 1.0);
        let (first, others) = sorted.split_first().map_or((reach, &[][..]), |(f, o)| (*f, o));
        let mut integral: Reused<f64> = (0..=limits.cells)
            .map(|k| (0.5 + 0.5 * border(k) / first.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0))
            .collect();
        for half in others {
            // The integral of the integral, so that a rectangle narrower than a cell still widens
            // the sum.
            let mut twice: Reused<f64> = std::iter::repeat_n(0.0, limits.cells + 1).collect();
            for k in 0..limits.cells {
                twice[k + 1] = twice[k] + 0.5 * (integral[k] + integral[k + 1]);
            }
            let cell = 2.0 * reach / limits.cells as f64;
            let at = |x: f64| {
                let place = (x + reach) / cell;
                if place <= 0.0 {
                    return 0.0;
                }
                let k = (place as usize).min(limits.cells);
                let t = place - k as f64;
                let next = integral.get(k + 1).copied().unwrap_or(1.0);
                cell * (twice[k] + t * (integral[k] + 0.5 * t * (next - integral[k])))
            };
            integral = (0..=limits.cells)
                .map(|k| (at(border(k) + half) - at(border(k) - half)) / (2.0 * half))
                .collect();
        }
        Self { masses: integral.windows(2).map(|w| (w[1] - w[0]).max(0.0)).collect(), reach }
    }

    fn middle(&self, cell: usize) -> f64 {
        self.reach * ((2.0 * cell as f64 + 1.0) / CoverageLimits::get().cells as f64 - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use statrs::distribution::Normal;

    use super::*;
    use crate::gauge::uncertainty::budget::Share;

    fn row(u_mm: f64, share: Share, freedom: Option<f64>) -> Contribution {
        Contribution { source: "x".into(), input: String::new(), shape: Shape::Normal, share, freedom, u_mm }
    }

    fn rectangle(half: f64) -> Contribution {
        Contribution { shape: Shape::Rectangular, ..row(half / 3.0_f64.sqrt(), Share::Common, None) }
    }

    fn budget(contributions: Vec<Contribution>) -> Budget {
        Budget { diameter_mm: 50.0, contributions }
    }

    /// One rectangle of half width 1 covers p within p; two equal ones (a triangle of half base 2)
    /// within 2(1 − √(1 − p)).
    #[test]
    fn rectangles_do_not_make_u_exceed_their_bounds() {
        let p = PROBABILITY;
        let u = |rows: Vec<Contribution>| {
            let b = budget(rows);
            b.factor_or(None) * b.u_mm()
        };
        assert!((u(vec![rectangle(1.0)]) / p - 1.0).abs() < 5e-3);
        let triangle = 2.0 * (1.0 - (1.0 - p).sqrt());
        assert!((u(vec![rectangle(1.0), rectangle(1.0)]) / triangle - 1.0).abs() < 5e-3);
        // A normal as large as the rectangle, and a twentieth of it, against draws.
        for (normal, freedom) in [(0.577, None), (0.03, None), (0.2, Some(4.0))] {
            let rows = vec![rectangle(1.0), rectangle(0.05), row(normal, Share::Random, freedom)];
            let drawn = budget(rows.clone()).half_width_mm(p);
            assert!((u(rows.clone()) / drawn - 1.0).abs() < 0.025, "{normal}: {} {drawn}", u(rows));
        }
        // Many small rectangles are a normal, and k given is k.
        let many = budget((0..30).map(|_| rectangle(0.1)).collect());
        assert!((1.97..=2.0).contains(&many.factor_or(None)), "{}", many.factor_or(None));
        assert_eq!(many.factor_or(Some(3.0)), 3.0);
    }

    /// GUM G.3: with 10 degrees of freedom 95.45 % need k = 2.28 (table G.2), not 2.
    #[test]
    fn few_degrees_of_freedom_widen_the_interval() {
        let mut budget = Budget { diameter_mm: 50.0, contributions: Vec::new() };
        budget.push(row(1e-3, Share::Random, Some(10.0)));
        assert!((budget.factor_or(None) - 2.28).abs() < 0.005, "{}", budget.factor_or(None));
        assert_eq!(budget.factor_or(Some(2.0)), 2.0);
        let table = budget.to_table(None);
        assert!(table.contains("(k = 2.284 covers 95.45 % at 10.0 effective"), "{table}");
        assert!(
            budget.to_table(Some(2.0)).contains("(k = 2; 2.284 covers 95.45 %"),
            "{}",
            budget.to_table(Some(2.0))
        );
        let mut known = Budget { diameter_mm: 50.0, contributions: Vec::new() };
        known.push(row(1e-3, Share::Common, None));
        assert!((known.factor_or(None) - 2.0).abs() < 1e-6 && known.to_table(None).contains("(k = 2 covers"));
    }

    /// A factor known exactly leaves the rectangle of the limits, 0.95·√3·u; one around 0 has a
    /// normal's long tails in a rectangle: P(|√3·u·R·Z| ≤ w) = ∫₀¹ erf(w/(√6·u·r)) dr by sums.
    #[test]
    fn a_product_is_drawn_as_one() {
        let half = |known| {
            let shape = Shape::Product { known };
            let contributions = vec![Contribution { shape, ..row(1.0, Share::Common, None) }];
            Budget { diameter_mm: 50.0, contributions }.half_width_mm(0.95)
        };
        assert!((half(1.0) / (0.95 * 3.0_f64.sqrt()) - 1.0).abs() < 0.01, "{}", half(1.0));
        let n = 2000;
        let covered = |w: f64| {
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
            let normal = Normal::standard();
            (0..n).map(|i| 2.0 * normal.cdf(w / (3.0_f64.sqrt() * at(i))) - 1.0).sum::<f64>() / f64::from(n)
        };
        assert!((covered(half(0.0)) - 0.95).abs() < 0.005, "{} {}", half(0.0), covered(half(0.0)));
        assert!(half(0.0) > 2.0);
    }
}
