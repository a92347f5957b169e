//! Equations 4 to 10 and the genetic algorithm's result.

use super::curves::Curves;
use super::error::ReproductionError;
use super::inputs::{Inputs, OptimumInput};
use crate::process::{ForceLaw, PowerLaw};
use crate::studies::optimize::{
    OptimizeConfig, PassTime, Point, Problem, Solution, exact, genetic, times_over_passes,
};
use crate::studies::reproduction::{Accept, Row};

/// Agreement required of the chosen cutting data, relative.
const NEAR: f64 = 0.02;

/// The rows and their curves.
pub(super) fn rows(
    inputs: &Inputs,
    config: &OptimizeConfig,
    curves: &mut Curves,
) -> Result<Vec<Row>, ReproductionError> {
    let config = &completed(inputs, config);
    let problem = Problem::new(config)?;
    let paper = &inputs.optimum;
    let point = Point {
        speed_m_per_min: paper.speed_m_per_min,
        feed_mm_per_rev: paper.feed_mm_per_rev,
        depth_mm: paper.depth_mm,
    };
    let at = problem.solution(point);
    curves.passes = times_over_passes(&problem, &point);
    curves.printed_min = paper.time_min;
    let mut rows = times(inputs, config, &problem, &at, &curves.passes);
    rows.extend(limits(inputs, config, &problem, &at));
    rows.extend(best(inputs, config, &problem, (&at, curves)));
    rows.push(table_1(config)?);
    Ok(rows)
}

/// The problem, completed by the inputs where the paper prints no value.
fn completed(inputs: &Inputs, config: &OptimizeConfig) -> OptimizeConfig {
    let (paper, mut config) = (&inputs.optimum, config.clone());
    config.time.tool_change_min = paper.tool_change_min.unwrap_or(config.time.tool_change_min);
    config.time.auxiliary_min = paper.auxiliary_min.unwrap_or(config.time.auxiliary_min);
    config.part.passes = paper.passes.unwrap_or(config.part.passes);
    if let (Some(coefficient_n), ForceLaw::Power(law)) =
        (paper.force_coefficient_n, &mut config.process.force)
    {
        law.coefficient_n = coefficient_n;
    }
    config
}

fn times(
    inputs: &Inputs,
    config: &OptimizeConfig,
    problem: &Problem,
    at: &Solution,
    passes: &[PassTime],
) -> Vec<Row> {
    let cutting = problem.cutting_time_min(&at.point);
    let paper = &inputs.optimum;
    let printed = paper.time_min;
    let data = [
        ("tool change time t_h", paper.tool_change_min.is_some()),
        ("auxiliary time t_q", paper.auxiliary_min.is_some()),
        ("number of passes n", paper.passes.is_some()),
    ];
    let nearest =
        passes.iter().min_by(|a, b| (a.total_min - printed).abs().total_cmp(&(b.total_min - printed).abs()));
    let over_passes: Vec<String> = passes.iter().take(3).map(|t| format!("{:.2}", t.total_min)).collect();
    vec![
        Row::predicted(
            ("eq4", "machining time t at the printed cutting data", "min"),
            Some(printed),
            at.time_min,
            Accept::Relative(NEAR),
            format!(
                "eq. 5 gives {cutting:.3} min for one pass; {printed} min would need {:.1} min of tool change and auxiliary time \
                 (ours: {} and {} min)",
                printed - cutting,
                config.time.tool_change_min,
                config.time.auxiliary_min
            ),
        )
        .needs(&data),
        Row::ours(
            ("eq5", "finishing time t_j at the printed cutting data", "min"),
            cutting,
            "not printed by itself",
        ),
        Row::predicted(
            ("eq5.total", "total time of the number of passes that comes nearest, at the printed cutting data", "min"),
            Some(printed),
            nearest.map_or(f64::NAN, |t| t.total_min),
            Accept::Relative(NEAR),
            format!(
                "eq. 5 gives the last pass' time alone; 1, 2, 3 passes together take {} min",
                over_passes.join(", ")
            ),
        )
        .needs(&data),
        Row::ours(
            ("eq4.T", "tool life T at the printed cutting data", "min"),
            at.tool_life_min,
            "Taylor's law with handbook constants; the paper gives none. One tool lasts for all passes",
        ),
    ]
}

/// The force law of equation 6, and whether it is given: the paper's two tables differ by nine
/// times.
fn law_of_equation_6(paper: &OptimumInput) -> (&'static str, bool) {
    ("force law F of eq. 6", paper.force_coefficient_n.is_some())
}

fn limits(inputs: &Inputs, config: &OptimizeConfig, problem: &Problem, at: &Solution) -> Vec<Row> {
    let paper = &inputs.optimum;
    let bounds = config.limits;
    vec![
        Row::predicted(
            ("eq6", "size error at the printed cutting data", "mm"),
            Some(paper.size_error_mm),
            at.size_error_mm,
            Accept::Relative(HANDBOOK),
            "ours is with Table 2's force; with Table 1's it is nine times larger",
        )
        .needs(&[law_of_equation_6(paper)]),
        Row::in_sample(
            ("eq7", "size error that eq. 7 allows the cut", "mm"),
            Some(paper.size_limit_mm - 0.01),
            problem.size_limit_mm,
            Accept::Absolute(1e-9),
            "ΔD - 0.01 mm",
        ),
        Row::ours(
            ("eq8", "largest feed that the roughness allows", "mm/r"),
            problem.largest_feed_mm_per_rev(),
            format!(
                "f²/8r ≤ R_a leaves f in [{}, {:.5}] mm/r",
                bounds.feed_mm_per_rev[0],
                problem.largest_feed_mm_per_rev()
            ),
        ),
        Row::predicted(
            ("eq9", "limits that the printed cutting data violate", ""),
            Some(0.0),
            problem.violated(&at.point).len() as f64,
            Accept::Absolute(0.5),
            "bounds, size error and roughness (Table 2's force)",
        )
        .needs(&[law_of_equation_6(paper)]),
    ]
}

/// Scatter of handbook forces, relative.
const HANDBOOK: f64 = 0.20;

fn best(
    inputs: &Inputs,
    config: &OptimizeConfig,
    problem: &Problem,
    (at, curves): (&Solution, &mut Curves),
) -> Vec<Row> {
    let paper = &inputs.optimum;
    let Some(found) = exact::minimise(problem, exact::DEFAULT_GAP) else {
        let reason = format!("infeasible: {}", problem.conflict().explanation);
        let names = ("eq10", "shortest feasible time", "min");
        return vec![Row::predicted(names, Some(paper.time_min), f64::NAN, Accept::Relative(NEAR), reason)];
    };
    let optimum = &found.solution;
    curves.optimum_min = Some(optimum.time_min);
    let row = |names: (&str, &str, &str), printed: f64, ours: f64, reason: &str| {
        Row::predicted(names, Some(printed), ours, Accept::Relative(NEAR), reason)
    };
    let mut rows = vec![
        row(
            ("eq10.v", "optimal cutting speed", "m/min"),
            paper.speed_m_per_min,
            optimum.point.speed_m_per_min,
            "at its bound",
        ),
        row(
            ("eq10.f", "optimal feed", "mm/r"),
            paper.feed_mm_per_rev,
            optimum.point.feed_mm_per_rev,
            "held by the roughness",
        ),
        row(
            ("eq10.ap", "optimal depth of cut", "mm"),
            paper.depth_mm,
            optimum.point.depth_mm,
            "held by the size error with Table 2's force, which is extrapolated there; with it a deeper cut is allowed and faster",
        )
        .needs(&[law_of_equation_6(paper)]),
        Row::ours(
            ("eq10.t", "shortest time", "min"),
            optimum.time_min,
            format!(
                "proven to {:.0e} by branch and bound; the printed point takes {:.2} % longer",
                found.proven_gap,
                100.0 * (at.time_min / optimum.time_min - 1.0)
            ),
        ),
    ];
    rows.extend(genetic_rows(paper.seeds, config, problem, (optimum, curves)));
    rows
}

/// Gap between the genetic algorithm's result and the optimum, by seed.
fn genetic_rows(
    seeds: u64,
    config: &OptimizeConfig,
    problem: &Problem,
    (optimum, curves): (&Solution, &mut Curves),
) -> Vec<Row> {
    let runs: Vec<_> =
        (0..seeds).filter_map(|seed| genetic::minimise(problem, &config.genetic, seed)).collect();
    if let Some(first) = runs.first() {
        curves.generations.clone_from(&first.generations);
    }
    let complete = runs.len() as u64 == seeds;
    // A seed without a feasible result has no gap.
    let failed = if complete { 0.0 } else { f64::NAN };
    let mut gaps: Vec<f64> =
        runs.iter().map(|best| 100.0 * (best.solution.time_min / optimum.time_min - 1.0)).collect();
    gaps.sort_by(f64::total_cmp);
    let middle = failed + gaps.get(gaps.len() / 2).copied().unwrap_or(f64::NAN);
    let worst = failed + gaps.last().copied().unwrap_or(f64::NAN);
    // Rounding may leave a gap of -1e-9.
    let gap = |id: &str, quantity: &str, ours: f64, limit: f64, reason: String| {
        Row::predicted((id, quantity, "%"), None, ours, Accept::Range(-1e-6, limit), reason)
    };
    vec![
        gap(
            "ga.median",
            "median gap of the genetic algorithm to the optimum, which the paper expects it to find",
            middle,
            0.05,
            format!("{} seeds of {} evaluations", gaps.len(), config.genetic.evaluations),
        ),
        gap(
            "ga.worst",
            "worst gap of the genetic algorithm to the optimum",
            worst,
            0.2,
            "no limit violated".to_owned(),
        ),
    ]
}

/// The same problem with Table 1's force.
fn table_1(config: &OptimizeConfig) -> Result<Row, ReproductionError> {
    let mut config = config.clone();
    config.process.force = ForceLaw::Power(PowerLaw::table_1());
    let problem = Problem::new(&config)?;
    let least = problem.smallest_error(&problem.limits);
    let feasible = exact::minimise(&problem, exact::DEFAULT_GAP).is_some();
    Ok(Row::ours(
        ("eq10.table1", "smallest size error within the bounds by Table 1's force", "mm"),
        problem.size_error_mm(&least),
        if feasible {
            format!("feasible: the limit is {:.4} mm", problem.size_limit_mm)
        } else {
            format!("infeasible with Table 1's force: {}", problem.conflict().explanation)
        },
    ))
}
