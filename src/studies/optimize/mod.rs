//! Choice of cutting data (equations 4 to 10 of the slender-shaft paper): the shortest machining
//! time under limits of size error, roughness and machine.
//!
//! ```text
//! min t = t_j + t_h·t_j/T + t_q          t_j = π·L·(D - 2·n·a_p)/(1000·f·v)       (4, 5)
//! 2·w·F(a_p, f, v) ≤ ΔD - reserve        w: largest compliance of the held shaft  (6, 7)
//! f²/8r ≤ R_a/1000,  bounds on a_p, f, v                                          (8, 9)
//! T = (C_T/(v·f^y·a_p^x))^(1/m)          Taylor's tool life
//! ```
//!
//! `genetic` is the paper's method, `exact` a branch and bound that bounds the distance of any
//! point from the optimum, `front` the paper's next step: time against size error.

mod config;
pub(crate) mod exact;
pub(crate) mod front;
pub(crate) mod genetic;
mod point;
mod problem;
mod timed;

#[cfg(test)]
pub(crate) use config::GeneticSettings;
pub(crate) use config::OptimizeConfig;
pub(crate) use point::Point;
pub(crate) use problem::{Conflict, Constraint, Problem, Solution};
pub use timed::TimedProblem;

use serde::Serialize;

/// Results of a study of one problem.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Study {
    /// Whether any cutting data satisfy all limits.
    pub feasible: bool,
    /// Why not.
    pub conflict: Option<Conflict>,
    /// The optimum.
    pub optimum: Option<Solution>,
    /// Proven bound on how much shorter any other feasible point could be, relative.
    pub proven_gap: Option<f64>,
    /// Result of the genetic algorithm.
    pub genetic: Option<GeneticResult>,
    /// Points given for comparison.
    pub references: Vec<ReferenceResult>,
    /// Time against size error.
    pub front: Vec<Solution>,
    /// Time against the number of passes, at the optimum; empty without one.
    pub passes: Vec<PassTime>,
    /// Where the force law was used outside its data.
    pub notes: Vec<String>,
}

/// The genetic algorithm's answer beside the optimum.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct GeneticResult {
    /// The best individual.
    pub solution: Solution,
    /// How much longer it takes than the optimum, relative.
    pub gap: f64,
    /// Evaluations of the model.
    pub evaluations: usize,
    /// Seed.
    pub seed: u64,
    /// The best of every generation.
    pub generations: Vec<genetic::Generation>,
}

/// Time against the number of passes, at the optimum's cutting data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct PassTime {
    /// n.
    pub passes: u32,
    /// Equation 5 as printed: the time of the last of n passes, min.
    pub equation_5_min: f64,
    /// All n passes with their tool changes and the auxiliary time, min.
    pub total_min: f64,
}

/// Number of passes up to which the time is plotted.
pub(crate) const MOST_PASSES: u32 = 8;

/// Time over the number of passes at a point, from one pass to [`MOST_PASSES`], as far as the
/// diameter of the stock allows.
pub(crate) fn times_over_passes(problem: &Problem, point: &Point) -> Vec<PassTime> {
    (1..=MOST_PASSES)
        .map_while(|passes| {
            let total_min = problem.total_time_min(point, passes)?;
            Some(PassTime { passes, equation_5_min: problem.pass_time_min(point, passes), total_min })
        })
        .collect()
}

/// A given point beside the optimum.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ReferenceResult {
    /// Its name.
    pub name: String,
    /// The point.
    pub solution: Solution,
    /// How much longer it takes than the optimum, relative.
    pub gap: Option<f64>,
    /// The limits that it violates.
    pub violated: Vec<Constraint>,
}

/// Searches that [`study`] makes: both methods, the fastest end of the front and its points.
pub(crate) fn searches(config: &OptimizeConfig) -> usize {
    3 + config.front_points
}

/// Solves a problem by both methods and computes its front; `done` is called after each search.
pub(crate) fn study(problem: &Problem, config: &OptimizeConfig, done: &dyn Fn()) -> Study {
    let found = exact::minimise(problem, exact::DEFAULT_GAP);
    done();
    let longer = |time: f64| found.as_ref().map(|f| time / f.solution.time_min - 1.0);
    let genetic = genetic::minimise(problem, &config.genetic, config.genetic.seed);
    done();
    let references = config.reference.iter().map(|reference| {
        let point = reference.point();
        let solution = problem.solution(point);
        ReferenceResult {
            name: reference.name.clone(),
            gap: longer(solution.time_min),
            violated: problem.violated(&point),
            solution,
        }
    });
    Study {
        feasible: found.is_some(),
        conflict: found.is_none().then(|| problem.conflict()),
        optimum: found.as_ref().map(|f| f.solution.clone()),
        proven_gap: found.as_ref().map(|f| f.proven_gap),
        genetic: genetic.and_then(|g| {
            longer(g.solution.time_min).map(|gap| GeneticResult {
                solution: g.solution,
                gap,
                evaluations: g.evaluations,
                seed: config.genetic.seed,
                generations: g.generations,
            })
        }),
        references: references.collect(),
        front: front::time_against_error(problem, config.front_points, done),
        passes: found.as_ref().map_or(Vec::new(), |f| times_over_passes(problem, &f.solution.point)),
        notes: found.as_ref().map_or(Vec::new(), |f| problem.notes(&f.solution.point)),
    }
}
