//! The corner of the silhouette: two straight stretches of its contour that meet outside of it.

use glam::DVec2;

use super::contour::Run;
use super::error::NoseImageError;
use super::limits::NoseLimits;
use super::settings::NoseSettings;

/// A straight stretch of the contour.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// Unit normal towards the light.
    pub(super) normal: DVec2,
    /// A place on it.
    pub(super) at: DVec2,
    /// The run it belongs to.
    run: usize,
    /// Its places, first and last.
    pub(super) span: (usize, usize),
    /// Places on it.
    pub(super) count: usize,
}

/// The two edges and what lies between.
#[derive(Clone, Debug)]
pub(super) struct Corner {
    /// Edges in the order of the contour, counter-clockwise around the insert.
    pub(super) edges: [Stretch; 2],
    /// First and last place of each edge, the contour's order.
    pub(super) ends: [[DVec2; 2]; 2],
    /// Where they meet.
    pub(super) apex: DVec2,
    /// Included angle, rad.
    pub(super) epsilon_rad: f64,
    /// Places of the nose.
    pub(super) nose: Vec<DVec2>,
}

/// Finds the corner whose edges are longest, and which is the tool's where its angle is known.
pub(super) fn find(
    runs: &[Run],
    size: (usize, usize),
    settings: &NoseSettings,
) -> Result<Corner, NoseImageError> {
    let limits = NoseLimits::get();
    let mut all = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        all.extend(stretches(run, k));
    }
    let mut best: Option<(f64, &Stretch, &Stretch)> = None;
    for first in &all {
        for second in &all {
            let turn = first.normal.perp_dot(second.normal).atan2(first.normal.dot(second.normal));
            let angle = 180.0 - turn.to_degrees();
            let follows = first.run != second.run || first.span.1 <= second.span.0 + 1;
            if !(follows && (limits.least_angle_deg..=limits.most_angle_deg).contains(&angle)) {
                continue;
            }
            let fits =
                settings.expected.is_none_or(|e| (angle - e.epsilon_deg).abs() < 2.0 * limits.direction_deg);
            let score = (first.count.min(second.count) * if fits { 4 } else { 1 }) as f64;
            if best.is_none_or(|(most, ..)| score > most) {
                best = Some((score, first, second));
            }
        }
    }
    let Some((_, first, second)) = best else {
        return Err(NoseImageError::NoNose {
            found: all.len(),
            least: limits.least_edge_px,
            low: limits.least_angle_deg,
            high: limits.most_angle_deg,
        });
    };
    let apex = meet(first, second);
    if first.run != second.run {
        let (rows, columns) = size;
        let least = limits.least_edge_px;
        return Err(NoseImageError::OutsideField { row: -apex.y, column: apex.x, rows, columns, least });
    }
    let run = &runs[first.run];
    let ends = [first, second].map(|s| [run[s.span.0], run[s.span.1]]);
    let turn = first.normal.angle_to(second.normal);
    Ok(Corner {
        nose: run[first.span.1..=second.span.0.max(first.span.1)].to_vec(),
        edges: [first.clone(), second.clone()],
        ends,
        apex,
        epsilon_rad: std::f64::consts::PI - turn,
    })
}

fn meet(a: &Stretch, b: &Stretch) -> DVec2 {
    let (p, q) = (a.normal.dot(a.at), b.normal.dot(b.at));
    let det = a.normal.perp_dot(b.normal);
    DVec2::new(p * b.normal.y - q * a.normal.y, q * a.normal.x - p * b.normal.x) / det
}

/// The straight stretches of a run, the longest first, each without the places of those before.
fn stretches(run: &Run, number: usize) -> Vec<Stretch> {
    let limits = NoseLimits::get();
    let (mut free, mut found) = (vec![true; run.len()], Vec::new());
    while found.len() < limits.most_lines {
        let Some(stretch) = longest(run, &free, number) else { break };
        if (stretch.count as f64) < limits.least_edge_px {
            break;
        }
        (stretch.span.0..=stretch.span.1).for_each(|k| free[k] = false);
        found.push(stretch);
    }
    found
}

/// The longest straight stretch of the places that are free.
fn longest(run: &Run, free: &[bool], number: usize) -> Option<Stretch> {
    let limits = NoseLimits::get();
    let left: Vec<usize> = (0..run.len()).filter(|k| free[*k]).collect();
    let least = limits.least_edge_px as usize;
    if left.len() < least {
        return None;
    }
    let mut best: Option<(usize, DVec2, DVec2)> = None;
    for reach in [least, left.len() / 12, left.len() / 4] {
        let reach = reach.clamp(least / 2, left.len() - 1);
        let step = ((left.len() - reach) / limits.trials).max(1);
        for k in (0..left.len() - reach).step_by(step) {
            let (from, to) = (run[left[k]], run[left[k + reach]]);
            let Some(along) = (to - from).try_normalize() else { continue };
            let (normal, thin) = (-along.perp(), (left.len() / 1500).max(1));
            let on =
                left.iter().step_by(thin).filter(|j| normal.dot(run[**j] - from).abs() < limits.coarse_px);
            let count = on.count() * thin;
            if best.is_none_or(|b| count > b.0) {
                best = Some((count, from, normal));
            }
        }
    }
    let (_, mut at, mut normal) = best?;
    let mut on: Vec<usize> = Vec::new();
    for _ in 0..3 {
        on = left.iter().copied().filter(|k| normal.dot(run[*k] - at).abs() < limits.coarse_px).collect();
        on = main_part(&on);
        let n = on.len().max(1) as f64;
        at = on.iter().map(|k| run[*k]).sum::<DVec2>() / n;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for d in on.iter().map(|k| run[*k] - at) {
            (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
        }
        let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        normal = if along.perp().dot(normal) > 0.0 { along.perp() } else { -along.perp() };
    }
    let span = (*on.first()?, *on.last()?);
    Some(Stretch { normal, at, run: number, span, count: on.len() })
}

/// Without places that other parts of the contour happen to have on the same line: parts that stand
/// farther apart than either is long are not one edge.
fn main_part(on: &[usize]) -> Vec<usize> {
    let (mut parts, mut from) = (Vec::new(), 0);
    for k in 1..=on.len() {
        if k == on.len() || on[k] - on[k - 1] > 3 * (k - from).max(20) {
            parts.push(from..k);
            from = k;
        }
    }
    parts.into_iter().max_by_key(std::ops::Range::len).map_or_else(Vec::new, |part| on[part].to_vec())
}
