//! Choice of cutting data: the optimum against dense search and hand calculation, the genetic
//! algorithm against it.

use std::time::Instant;

use shadowgauge::process::{ForceLaw, PowerLaw};
use shadowgauge::studies::optimize::{
    Constraint, GeneticSettings, OptimizeConfig, Point, Problem, exact, front, genetic, study,
};

fn config() -> OptimizeConfig {
    toml::from_str(include_str!("../../../configs/optimize_003.toml")).unwrap()
}

fn problem() -> Problem {
    Problem::new(&config()).unwrap()
}

fn relative(a: f64, b: f64) -> f64 {
    (a / b - 1.0).abs()
}

#[test]
fn the_model_is_the_papers() {
    let p = Point { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1, depth_mm: 0.25 };
    let problem = problem();
    // π·1000·(40 - 0.5)/(1000·0.1·80)
    assert!(relative(problem.cutting_time_min(&p), std::f64::consts::PI * 39.5 / 8.0) < 1e-12);
    assert!((problem.cutting_time_min(&p) - 15.512).abs() < 5e-4);
    assert!(
        (problem.error_per_force_mm_per_n * 1e3 - 0.74971).abs() < 1e-5,
        "{}",
        problem.error_per_force_mm_per_n
    );
    let life = (291.0 / (80.0 * 0.1f64.powf(0.2) * 0.25f64.powf(0.15))).powf(5.0);
    assert!(relative(1.0 / problem.wear_per_min(&p), life) < 1e-12);
    assert!(
        relative(problem.time_min(&p), std::f64::consts::PI * 39.5 / 8.0 * (1.0 + 1.0 / life) + 0.5) < 1e-5
    );
    assert!((problem.largest_feed_mm_per_rev() - 0.101_193).abs() < 1e-6);
}

#[test]
fn the_optimum_is_proven_and_known() {
    let start = Instant::now();
    let found = exact::minimise(&problem(), exact::DEFAULT_GAP).unwrap();
    eprintln!("{found:?} in {:?}", start.elapsed());
    let s = &found.solution;
    assert!(relative(s.point.speed_m_per_min, 80.0) < 1e-9);
    assert!((s.point.feed_mm_per_rev - 0.101_193).abs() < 1e-6);
    assert!((s.point.depth_mm - 0.33792).abs() < 5e-4, "{}", s.point.depth_mm);
    assert!((s.time_min - 15.7616).abs() < 2e-3, "{}", s.time_min);
    assert_eq!(s.active, [Constraint::SizeError, Constraint::Roughness, Constraint::Speed]);
    assert!(found.proven_gap <= exact::DEFAULT_GAP);
    assert!(problem().violated(&s.point).is_empty());
}

/// A dense grid search: no point of it is shorter than the optimum, and its best point is near.
fn dense_search(problem: &Problem) -> f64 {
    let n = 60;
    let at = |[low, high]: [f64; 2], i: usize| low + (high - low) * i as f64 / (n - 1) as f64;
    let mut best = f64::INFINITY;
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let p = Point {
                    speed_m_per_min: at(problem.limits.speed_m_per_min, i),
                    feed_mm_per_rev: at(problem.limits.feed_mm_per_rev, j),
                    depth_mm: at(problem.limits.depth_mm, k),
                };
                if problem.violation(&p) == 0.0 {
                    best = best.min(problem.time_min(&p));
                }
            }
        }
    }
    best
}

#[test]
fn no_grid_point_beats_the_optimum() {
    let mut interior = config();
    // Long tool changes move the optimum away from the speed bound; loose quality limits release
    // feed and depth.
    interior.limits.speed_m_per_min = [30.0, 300.0];
    interior.time.tool_change_min = 30.0;
    interior.quality.size_error_mm = 0.2;
    interior.quality.roughness_um = 20.0;
    for config in [config(), interior] {
        let problem = Problem::new(&config).unwrap();
        let found = exact::minimise(&problem, exact::DEFAULT_GAP).unwrap();
        let dense = dense_search(&problem);
        eprintln!("{found:?} dense {dense}");
        assert!(dense >= found.solution.time_min * (1.0 - 1e-9), "{dense} {}", found.solution.time_min);
        assert!(dense < found.solution.time_min * 1.1);
        assert!(found.proven_gap <= 1.01 * exact::DEFAULT_GAP, "{}", found.proven_gap);
    }
}

#[test]
fn the_genetic_algorithm_comes_near_at_every_seed() {
    let problem = problem();
    let optimum = exact::minimise(&problem, exact::DEFAULT_GAP).unwrap().solution.time_min;
    let settings = GeneticSettings::default();
    assert_eq!(settings.evaluations, 10_000);
    let mut gaps: Vec<f64> = (0..20)
        .map(|seed| {
            let best = genetic::minimise(&problem, &settings, seed).unwrap();
            assert!(best.evaluations <= 10_000);
            assert_eq!(problem.violation(&best.solution.point), 0.0);
            assert!(problem.violated(&best.solution.point).is_empty());
            best.solution.time_min / optimum - 1.0
        })
        .collect();
    gaps.sort_by(f64::total_cmp);
    let (median, worst) = (0.5 * (gaps[9] + gaps[10]), gaps[19]);
    eprintln!("gap median {:.5} %, worst {:.5} %", 100.0 * median, 100.0 * worst);
    assert!(gaps[0] >= -1e-9, "better than the optimum: {gaps:?}");
    assert!(median <= 5e-4 && worst <= 2e-3, "{gaps:?}");
}

#[test]
fn table_ones_force_makes_it_infeasible_and_it_says_so() {
    let mut config = config();
    config.process.force = ForceLaw::Power(PowerLaw::table_1());
    let problem = Problem::new(&config).unwrap();
    assert!(exact::minimise(&problem, 1e-4).is_none());
    assert!(genetic::minimise(&problem, &config.genetic, 1).is_none());
    let conflict = problem.conflict();
    assert_eq!(conflict.constraints, [Constraint::SizeError]);
    assert!(conflict.nearest.size_error_mm > problem.size_limit_mm);
    assert!(conflict.explanation.contains("size error"), "{}", conflict.explanation);
    config.quality.roughness_um = 1.0;
    let conflict = Problem::new(&config).unwrap().conflict();
    assert_eq!(conflict.constraints, [Constraint::Roughness, Constraint::Feed]);
}

#[test]
fn limits_that_exclude_each_other_together_are_both_named() {
    // A force that decreases with the feed: the roughness requires a small feed, the size error a
    // large one.
    let mut config = config();
    config.process.force =
        ForceLaw::Power(PowerLaw { feed_exponent: -1.5, coefficient_n: 15.0, ..PowerLaw::table_2() });
    let problem = Problem::new(&config).unwrap();
    assert!(problem.size_error_mm(&problem.smallest_error(&problem.limits)) < problem.size_limit_mm);
    assert!(exact::minimise(&problem, 1e-4).is_none());
    assert_eq!(problem.conflict().constraints, [Constraint::SizeError, Constraint::Roughness]);
}

#[test]
fn the_front_trades_time_for_error() {
    let problem = problem();
    let start = Instant::now();
    let front = front::time_against_error(&problem, 24, &|| {});
    eprintln!("front of {} points in {:?}", front.len(), start.elapsed());
    assert!(front.len() >= 20, "{}", front.len());
    for pair in front.windows(2) {
        assert!(pair[1].time_min < pair[0].time_min && pair[1].size_error_mm > pair[0].size_error_mm);
    }
    // No feasible grid point dominates a point of the front.
    for s in front.iter().step_by(5) {
        let tighter = problem.with_size_limit(s.size_error_mm);
        assert!(dense_search(&tighter) >= s.time_min * (1.0 - 1e-6));
    }
}

#[test]
fn the_papers_point_is_slower() {
    let study = study(&problem(), &config(), &|| {});
    let paper = &study.references[0];
    assert!((paper.gap.unwrap() - 0.016).abs() < 2e-3, "{:?}", paper.gap);
    assert!(paper.violated.is_empty());
}
