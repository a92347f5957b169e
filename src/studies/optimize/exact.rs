//! The optimum by branch and bound, and a proof of how good it is.
//!
//! On a box of cutting data t_j is smallest at the largest (v, f, a_p), the wear rate 1/T at the
//! smallest, so that t_j,min·(1 + t_h/T_max) + t_q bounds t from below; the force is monotone in
//! each variable, so that a box whose smallest corner violates the limit is empty. Boxes that
//! cannot improve on the best point so far by more than `gap` are dropped, the others halved. A
//! pattern search from the best point closes the remaining gap.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::config::Limits;
use super::point::Point;
use super::problem::{Problem, Solution};

/// Relative gap to which optima are proven.
pub(crate) const DEFAULT_GAP: f64 = 1e-4;
/// Number of boxes after which the search stops and reports the gap reached.
const MOST_BOXES: usize = 200_000;

/// An optimum and its proof.
#[derive(Clone, Debug)]
pub(crate) struct Optimum {
    /// The point.
    pub solution: Solution,
    /// No feasible point is shorter by more than this, relative.
    pub proven_gap: f64,
}

struct Candidate {
    bound: f64,
    limits: Limits,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.bound == other.bound
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    /// Reversed order, because the heap returns its largest element first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

/// The shortest feasible point; `None` where nothing is feasible.
pub(crate) fn minimise(problem: &Problem, gap: f64) -> Option<Optimum> {
    let largest_feed = problem.largest_feed_mm_per_rev();
    if largest_feed < problem.limits.feed_mm_per_rev[0] {
        return None;
    }
    let root =
        Limits { feed_mm_per_rev: [problem.limits.feed_mm_per_rev[0], largest_feed], ..problem.limits };
    let mut best: Option<(Point, f64)> = None;
    let mut heap = BinaryHeap::new();
    consider(problem, root, &mut heap, &mut best, gap);
    let (mut boxes, mut reached) = (0, gap);
    while let Some(candidate) = heap.pop() {
        let Some((_, time)) = best else { break };
        boxes += 1;
        if candidate.bound >= time * (1.0 - gap) || boxes >= MOST_BOXES {
            reached = gap.max(1.0 - candidate.bound / time);
            break;
        }
        for half in halves(&candidate.limits) {
            consider(problem, half, &mut heap, &mut best, gap);
        }
    }
    let point = pattern_search(problem, &root, best?.0);
    let solution = problem.solution(point);
    Some(Optimum { solution, proven_gap: reached })
}

/// Bounds a box, searches it for a good point, and keeps it if it may contain a better one.
fn consider(
    problem: &Problem,
    limits: Limits,
    heap: &mut BinaryHeap<Candidate>,
    best: &mut Option<(Point, f64)>,
    gap: f64,
) {
    if problem.size_error_mm(&problem.smallest_error(&limits)) > problem.size_limit_mm {
        return;
    }
    for corner in Problem::corners(&limits).filter(|corner| corner.depth_mm == limits.depth_mm[1]) {
        if let Some(point) = deepest(problem, &limits, corner) {
            let time = problem.time_min(&point);
            if best.is_none_or(|(_, shortest)| time < shortest) {
                *best = Some((point, time));
            }
        }
    }
    let pick = |end: usize| Point {
        speed_m_per_min: limits.speed_m_per_min[end],
        feed_mm_per_rev: limits.feed_mm_per_rev[end],
        depth_mm: limits.depth_mm[end],
    };
    let bound = problem.time_of(problem.cutting_time_min(&pick(1)), problem.wear_per_min(&pick(0)));
    if best.is_none_or(|(_, shortest)| bound < shortest * (1.0 - gap)) {
        heap.push(Candidate { bound, limits });
    }
}

/// The best depth at the corner's speed and feed: the time over depth has one minimum at most
/// between the ends of the feasible interval, found by golden section beside the ends themselves.
fn deepest(problem: &Problem, limits: &Limits, corner: Point) -> Option<Point> {
    let [low, high] = limits.depth_mm;
    let at = |depth_mm: f64| Point { depth_mm, ..corner };
    let feasible = |depth: f64| problem.size_error_mm(&at(depth)) <= problem.size_limit_mm;
    if !feasible(low) {
        return None;
    }
    let end = if feasible(high) { high } else { bisect(low, high, feasible) };
    let time = |depth: f64| problem.time_min(&at(depth));
    let inner = golden(low, end, time);
    [low, end, inner].into_iter().min_by(|a, b| time(*a).total_cmp(&time(*b))).map(at)
}

/// The last feasible value between a feasible and an infeasible one.
fn bisect(mut feasible: f64, mut infeasible: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (feasible + infeasible);
        if holds(middle) { feasible = middle } else { infeasible = middle }
    }
    feasible
}

fn golden(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..40 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        (low, high) = if value(a) < value(b) { (low, b) } else { (a, high) };
    }
    0.5 * (low + high)
}

/// The box in two along its relatively longest side.
fn halves(limits: &Limits) -> [Limits; 2] {
    let ratio = |[low, high]: [f64; 2]| high / low;
    let middle = |[low, high]: [f64; 2]| (low * high).sqrt();
    let (mut lower, mut upper) = (*limits, *limits);
    let (v, f, a) = (ratio(limits.speed_m_per_min), ratio(limits.feed_mm_per_rev), ratio(limits.depth_mm));
    if v >= f && v >= a {
        let m = middle(limits.speed_m_per_min);
        (lower.speed_m_per_min[1], upper.speed_m_per_min[0]) = (m, m);
    } else if f >= a {
        let m = middle(limits.feed_mm_per_rev);
        (lower.feed_mm_per_rev[1], upper.feed_mm_per_rev[0]) = (m, m);
    } else {
        let m = middle(limits.depth_mm);
        (lower.depth_mm[1], upper.depth_mm[0]) = (m, m);
    }
    [lower, upper]
}

/// Pattern search over speed and feed, the depth at its best, steps from 10 % of the range down to
/// 1e-12.
fn pattern_search(problem: &Problem, limits: &Limits, start: Point) -> Point {
    let clamp = |value: f64, [low, high]: [f64; 2]| value.clamp(low, high);
    let span = |[low, high]: [f64; 2]| high - low;
    let (mut best, mut step) = (start, 0.1);
    while step > 1e-12 {
        let mut improved = false;
        for (i, j) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
            let moved = Point {
                speed_m_per_min: clamp(
                    best.speed_m_per_min + step * f64::from(i) * span(limits.speed_m_per_min),
                    limits.speed_m_per_min,
                ),
                feed_mm_per_rev: clamp(
                    best.feed_mm_per_rev + step * f64::from(j) * span(limits.feed_mm_per_rev),
                    limits.feed_mm_per_rev,
                ),
                ..best
            };
            if let Some(point) =
                deepest(problem, limits, moved).filter(|p| problem.time_min(p) < problem.time_min(&best))
            {
                best = point;
                improved = true;
            }
        }
        if !improved {
            step *= 0.5;
        }
    }
    best
}
