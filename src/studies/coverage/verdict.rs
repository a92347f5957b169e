//! The study's result, and what is required of it.

use serde::Serialize;

use super::figures::ClassFigures;

/// The study's result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Coverage {
    /// Classes drawn from the budget.
    pub drawn: Vec<ClassFigures>,
    /// All of them together.
    pub drawn_together: ClassFigures,
    /// Classes that deviate inside the limits.
    pub deviating: Vec<ClassFigures>,
    /// All of them together.
    pub deviating_together: ClassFigures,
    /// Round parts drawn from the rows of their limbs.
    pub limbs: Vec<ClassFigures>,
    /// All of them together.
    pub limbs_together: ClassFigures,
    /// Classes outside the limits that are detectable in the frames.
    pub detectable: Vec<ClassFigures>,
    /// Classes outside the limits that are not detectable in any frame.
    pub undetectable: Vec<ClassFigures>,
}

impl Coverage {
    /// The requirements that are missed, of: 94-96 % overall and 92 % per class as drawn; 95 % and
    /// a half width of 1.5 times the 95th percentile of the error inside the limits; 99 % flagged
    /// outside. `slack` widens the limits by that many standard errors.
    pub(crate) fn misses(&self, slack: f64) -> Vec<String> {
        let mut misses = Vec::new();
        let se = |p: f64, n: usize| slack * (p * (1.0 - p) / n.max(1) as f64).sqrt();
        let all = &self.drawn_together;
        let tolerance = se(0.95, all.accepted);
        if !(0.94 - tolerance..=0.96 + tolerance).contains(&all.covered) {
            misses.push(format!("drawn scenes: {:.2} % covered, wanted 94 to 96 %", 1e2 * all.covered));
        }
        for c in &self.drawn {
            if c.covered < 0.92 - se(0.92, c.accepted) {
                misses.push(format!("{}: {:.2} % covered, wanted 92 %", c.name(), 1e2 * c.covered));
            }
        }
        for c in self.deviating.iter().chain([&self.deviating_together]) {
            if c.covered < 0.95 - se(0.95, c.accepted) {
                misses.push(format!("{}: {:.2} % covered, wanted 95 %", c.name(), 1e2 * c.covered));
            }
            if c.half_over_p95() > 1.5 * (1.0 + slack / (c.accepted.max(1) as f64).sqrt()) {
                misses.push(format!(
                    "{}: mean U {:.3} um is {:.2} times the 95th percentile of the error, wanted 1.5",
                    c.name(),
                    c.mean_half_um,
                    c.half_over_p95()
                ));
            }
        }
        misses.extend(self.limb_misses(slack));
        for c in &self.detectable {
            if c.handled() < 0.99 - se(0.99, c.scenes) {
                misses.push(format!("{}: {:.2} % handled, wanted 99 %", c.name(), 1e2 * c.handled()));
            }
        }
        misses
    }

    /// Those of round parts: 94-96 % together, 93-97 % in each light, and a half width of 1.3 times
    /// the 95th percentile of the error.
    fn limb_misses(&self, slack: f64) -> Vec<String> {
        let mut misses = Vec::new();
        let se = |c: &ClassFigures| slack * (0.95 * 0.05 / c.accepted.max(1) as f64).sqrt();
        let each = self.limbs.iter().map(|c| (c, 0.02)).chain([(&self.limbs_together, 0.01)]);
        for (c, off) in each {
            if (c.covered - 0.95).abs() > off + se(c) {
                let (low, high) = (1e2 * (0.95 - off), 1e2 * (0.95 + off));
                let covered = 1e2 * c.covered;
                misses.push(format!("{}: {covered:.2} % covered, wanted {low:.0} to {high:.0} %", c.name()));
            }
            if c.half_over_p95() > 1.3 * (1.0 + slack / (c.accepted.max(1) as f64).sqrt()) {
                let (half, ratio) = (c.mean_half_um, c.half_over_p95());
                misses.push(format!(
                    "{}: mean U {half:.3} um is {ratio:.2} times the 95th percentile of the error, wanted 1.3",
                    c.name()
                ));
            }
        }
        misses
    }
}
