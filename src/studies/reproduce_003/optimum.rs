//! Equations 4 to 10 and the genetic algorithm's result.

use super::ReproductionError;
use super::inputs::Inputs;
use crate::process::{ForceLaw, PowerLaw};
use crate::studies::optimize::{OptimizeConfig, Point, Problem, Solution, exact, genetic};
use crate::studies::reproduction::{Row, Verdict};

pub(super) fn rows(inputs: &Inputs, config: &OptimizeConfig) -> Result<Vec<Row>, ReproductionError> {
    let problem = Problem::new(config)?;
    let paper = &inputs.optimum;
    let point = Point {
        speed_m_per_min: paper.speed_m_per_min,
        feed_mm_per_rev: paper.feed_mm_per_rev,
        depth_mm: paper.depth_mm,
    };
    let at = problem.solution(point);
    let mut rows = times(inputs, config, &problem, &at);
    rows.extend(limits(inputs, config, &problem, &at));
    rows.extend(best(inputs, config, &problem, &at));
    rows.push(table_1(config)?);
    Ok(rows)
}

fn times(inputs: &Inputs, config: &OptimizeConfig, problem: &Problem, at: &Solution) -> Vec<Row> {
    let cutting = problem.cutting_time_min(&at.point);
    let printed = inputs.optimum.time_min;
    let as_error = std::f64::consts::PI
        * config.part.length_mm
        * (config.quality.size_error_mm - 2.0 * at.point.depth_mm)
        / (1000.0 * at.point.feed_mm_per_rev * at.point.speed_m_per_min);
    vec![
        Row::judged(
            ("eq4", "machining time t at the printed cutting data", "min"),
            Some(printed),
            at.time_min,
            Verdict::Contradiction,
            format!(
                "eq. 5 gives {cutting:.3} min; {printed} min would need {:.1} min of tool change and auxiliary time, which are \
                 not given (ours: {} and {} min)",
                printed - cutting,
                config.time.tool_change_min,
                config.time.auxiliary_min
            ),
        ),
        Row::judged(
            ("eq5", "finishing time t_j at the printed cutting data", "min"),
            None,
            cutting,
            Verdict::Consistent,
            "not printed by itself",
        ),
        Row::judged(
            ("eq5.D", "t_j with D read as the size error, as printed", "min"),
            None,
            as_error,
            Verdict::Contradiction,
            "\"D is the DE\" makes the time negative; D is the diameter",
        ),
        Row::judged(
            ("eq4.T", "tool life T at the printed cutting data", "min"),
            None,
            at.tool_life_min,
            Verdict::Consistent,
            "Taylor's law with handbook constants; the paper gives none. One tool lasts for all passes",
        ),
    ]
}

fn limits(inputs: &Inputs, config: &OptimizeConfig, problem: &Problem, at: &Solution) -> Vec<Row> {
    let paper = &inputs.optimum;
    let feed = at.point.feed_mm_per_rev;
    let mean = 1e3 * feed * feed / (18.0 * 3f64.sqrt() * config.process.tool.nose_radius_mm);
    let bounds = config.limits;
    let inside = problem.violated(&at.point).is_empty();
    vec![
        Row::judged(
            ("eq6", "size error at the printed cutting data", "mm"),
            Some(paper.size_error_mm),
            at.size_error_mm,
            Verdict::Contradiction,
            format!(
                "\"fluctuates around {} mm\" exceeds the paper's own limit of {} mm; ours is with Table 2's force",
                paper.size_error_mm, paper.size_limit_mm
            ),
        ),
        Row::judged(
            ("eq7", "size error that eq. 7 allows the cut", "mm"),
            Some(paper.size_limit_mm - 0.01),
            problem.size_limit_mm,
            if (problem.size_limit_mm - paper.size_limit_mm + 0.01).abs() < 1e-9 {
                Verdict::Reproduced
            } else {
                Verdict::Contradiction
            },
            "ΔD - 0.01 mm",
        ),
        Row::judged(
            ("eq8", "largest feed that the roughness allows", "mm/r"),
            None,
            problem.largest_feed_mm_per_rev(),
            Verdict::Consistent,
            format!(
                "f²/8r ≤ R_a leaves f in [{}, {:.5}] mm/r",
                bounds.feed_mm_per_rev[0],
                problem.largest_feed_mm_per_rev()
            ),
        ),
        Row::judged(
            ("eq8.height", "height of the feed marks f²/8r", "µm"),
            Some(paper.roughness_um),
            at.roughness_um,
            Verdict::Consistent,
            format!(
                "the height is {:.3} µm, the arithmetic mean roughness of the same marks {mean:.3} µm: the printed R_a lies \
                 between, as marks with some side flow do",
                at.roughness_um
            ),
        ),
        Row::judged(
            ("eq9", "limits that the printed cutting data violate", ""),
            Some(0.0),
            problem.violated(&at.point).len() as f64,
            if inside { Verdict::Reproduced } else { Verdict::Contradiction },
            "bounds, size error and roughness (Table 2's force)",
        ),
    ]
}

fn best(inputs: &Inputs, config: &OptimizeConfig, problem: &Problem, at: &Solution) -> Vec<Row> {
    let Some(found) = exact::minimise(problem, exact::DEFAULT_GAP) else {
        let conflict = problem.conflict();
        return vec![Row::judged(
            ("eq10", "shortest feasible time", "min"),
            Some(inputs.optimum.time_min),
            f64::NAN,
            Verdict::Contradiction,
            format!("infeasible: {}", conflict.explanation),
        )];
    };
    let optimum = &found.solution;
    let paper = &inputs.optimum;
    let near = |a: f64, b: f64| {
        if (a / b - 1.0).abs() < 0.02 { Verdict::Consistent } else { Verdict::Contradiction }
    };
    let row = |id: &str, quantity: &str, unit: &str, printed: f64, ours: f64, reason: &str| {
        Row::judged((id, quantity, unit), Some(printed), ours, near(ours, printed), reason)
    };
    let mut gaps: Vec<f64> = (0..inputs.optimum.seeds)
        .filter_map(|seed| genetic::minimise(problem, &config.genetic, seed))
        .map(|best| best.solution.time_min / optimum.time_min - 1.0)
        .collect();
    gaps.sort_by(f64::total_cmp);
    let middle = gaps.get(gaps.len() / 2).copied().unwrap_or(f64::NAN);
    let worst = gaps.last().copied().unwrap_or(f64::NAN);
    let complete = gaps.len() as u64 == inputs.optimum.seeds;
    let good = |ok: bool| if ok && complete { Verdict::Consistent } else { Verdict::Contradiction };
    vec![
        row(
            "eq10.v",
            "optimal cutting speed",
            "m/min",
            paper.speed_m_per_min,
            optimum.point.speed_m_per_min,
            "at its bound",
        ),
        row(
            "eq10.f",
            "optimal feed",
            "mm/r",
            paper.feed_mm_per_rev,
            optimum.point.feed_mm_per_rev,
            "held by the roughness",
        ),
        row(
            "eq10.ap",
            "optimal depth of cut",
            "mm",
            paper.depth_mm,
            optimum.point.depth_mm,
            "held by the size error with Table 2's force; the printed point is not optimal",
        ),
        Row::judged(
            ("eq10.t", "shortest time", "min"),
            None,
            optimum.time_min,
            Verdict::Consistent,
            format!(
                "proven to {:.0e} by branch and bound; the printed point takes {:.2} % longer",
                found.proven_gap,
                100.0 * (at.time_min / optimum.time_min - 1.0)
            ),
        ),
        Row::judged(
            ("ga.median", "median gap of the genetic algorithm to the optimum", "%"),
            None,
            100.0 * middle,
            good(middle <= 5e-4),
            format!("{} seeds of {} evaluations", gaps.len(), config.genetic.evaluations),
        ),
        Row::judged(
            ("ga.worst", "worst gap of the genetic algorithm to the optimum", "%"),
            None,
            100.0 * worst,
            good(worst <= 2e-3),
            "no limit violated",
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
    Ok(Row::judged(
        ("eq10.table1", "smallest size error within the bounds by Table 1's force", "mm"),
        Some(problem.size_limit_mm),
        problem.size_error_mm(&least),
        if feasible { Verdict::Consistent } else { Verdict::Contradiction },
        if feasible {
            "feasible".to_owned()
        } else {
            format!("infeasible with Table 1's force: {}", problem.conflict().explanation)
        },
    ))
}
