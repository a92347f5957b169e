//! The axis about which the vertices of every turn have one Z and one radius: Levenberg-Marquardt.
//!
//! Two tilts (a, b) and two shifts (u, v) of the axis change Z of the vertex (x, y, z) by (a·x +
//! b·y) and its radius r by −((u + a·z)·x + (v + b·z)·y)/r. The means of a turn are taken off both
//! the residuals and their derivatives: they are eliminated. Each step turns the frame into the new
//! axis, so that all four begin at zero. Turns that scatter more than a scale count less; the scale
//! shrinks to that of a file's digits, so that an eccentric journal does not move the axis.

use nalgebra::{Matrix4, Vector4};
use rayon::slice::ParallelSliceMut;

use super::axis::Axis;
use super::mesh::Mesh;
use super::rings::{GAP_SHARE, Ring, clusters, turned};

/// Gaps of the clusters one after the other, as shares of the body's size, and the steps taken with
/// each: from where the normals leave the axis down to the digits of a file.
const GAPS: [(f64, usize); 5] = [(1e-3, 4), (3e-4, 3), (1e-4, 3), (3e-5, 3), (GAP_SHARE, 4)];
/// Scale of a turn's scatter in units of the gap at which it counts a quarter.
const SCALE: f64 = 1.0;
/// Vertices that are fitted, in runs along the axis: with the digits of single precision a tilt by
/// 1e-9 rad is left, and a mesh of a million facets costs no more than one of a tenth.
const MOST_VERTICES: usize = 60_000;
const RUNS: usize = 12;
/// Damping of Levenberg and Marquardt at the first step, and its factors.
const DAMPING: f64 = 1e-6;
const EASE: f64 = 0.1;
const BRAKE: f64 = 10.0;

/// Sums of a fit: the normal matrix, the gradient, and the weighted square sum of residuals.
type Sums = (Matrix4<f64>, Vector4<f64>, f64);

/// The axis refined on its turns.
pub(super) fn refined(mesh: &Mesh, first: Axis) -> Axis {
    let mut axis = centred(mesh, first);
    let chosen = chosen(mesh, &axis);
    for (share, steps) in GAPS {
        let gap_mm = share * mesh.size_mm;
        let rings: Vec<Vec<u32>> =
            usable(clusters(turned(mesh, &axis, chosen.iter().copied()), gap_mm), gap_mm);
        let mut damping = DAMPING;
        let mut now = sums(mesh, &axis, &rings, gap_mm);
        for _ in 0..steps {
            let damped = now.0 + Matrix4::from_diagonal(&now.0.diagonal()) * damping;
            let Some(step) = damped.cholesky().map(|c| c.solve(&-now.1)) else { break };
            let next = stepped(&axis, step);
            let then = sums(mesh, &next, &rings, gap_mm);
            if then.2 <= now.2 {
                (axis, now, damping) = (next, then, damping * EASE);
            } else {
                damping *= BRAKE;
            }
        }
    }
    axis
}

/// The same line by its point next to the middle of the vertices: tilts then move it least.
fn centred(mesh: &Mesh, axis: Axis) -> Axis {
    let middle = mesh.vertices.iter().sum::<glam::DVec3>() / mesh.vertices.len() as f64;
    Axis { point: axis.point + (middle - axis.point).dot(axis.direction) * axis.direction, ..axis }
}

/// All vertices, or of many those of some stretches along the axis, both ends among them: whole
/// turns but for the first and last of a stretch.
fn chosen(mesh: &Mesh, axis: &Axis) -> Vec<u32> {
    let count = mesh.vertices.len();
    if count <= MOST_VERTICES {
        return (0..count as u32).collect();
    }
    let along = |at: &glam::DVec3| at.dot(axis.direction);
    let mut order: Vec<(f64, u32)> = mesh.vertices.iter().map(along).zip(0..).collect();
    order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let each = MOST_VERTICES / RUNS;
    let start = |run: usize| run * (count - each) / (RUNS - 1);
    (0..RUNS).flat_map(|run| order[start(run)..][..each].iter().map(|(_, vertex)| *vertex)).collect()
}

/// Vertices of the clusters that look like a turn.
fn usable(rings: Vec<Ring>, gap_mm: f64) -> Vec<Vec<u32>> {
    let fits = |ring: &Ring| ring.is_closed() && ring.r > 10.0 * gap_mm;
    let members = |ring: Ring| ring.members.iter().map(|t| t.vertex).collect();
    rings.into_iter().filter(fits).map(members).collect()
}

fn stepped(axis: &Axis, step: Vector4<f64>) -> Axis {
    let (e1, e2) = axis.across();
    Axis {
        direction: (axis.direction + step[0] * e1 + step[1] * e2).normalize(),
        point: axis.point + step[2] * e1 + step[3] * e2,
    }
}

/// Normal matrix, gradient and square sum over all turns.
fn sums(mesh: &Mesh, axis: &Axis, rings: &[Vec<u32>], gap_mm: f64) -> Sums {
    let mut total = (Matrix4::zeros(), Vector4::zeros(), 0.0);
    for ring in rings {
        let (normal, gradient, square) = of_ring(mesh, axis, ring);
        let scatter = square / ring.len() as f64;
        let scale = SCALE * gap_mm * gap_mm;
        // the cost of Geman and McClure, s²·σ²/(s² + σ²), and its derivative as the weight
        let weight = (scale / (scale + scatter)).powi(2);
        total.0 += normal * weight;
        total.1 += gradient * weight;
        total.2 += square * scale / (scale + scatter);
    }
    total
}

fn of_ring(mesh: &Mesh, axis: &Axis, ring: &[u32]) -> Sums {
    let (e1, e2) = axis.across();
    let rows: Vec<[(Vector4<f64>, f64); 2]> = ring
        .iter()
        .map(|&i| {
            let from = mesh.vertices[i as usize] - axis.point;
            let (x, y, z) = (from.dot(e1), from.dot(e2), from.dot(axis.direction));
            let r = x.hypot(y);
            [(Vector4::new(x, y, 0.0, 0.0), z), (-Vector4::new(z * x, z * y, x, y) / r, r)]
        })
        .collect();
    let mut sums = (Matrix4::zeros(), Vector4::zeros(), 0.0);
    for k in 0..2 {
        let n = rows.len() as f64;
        let mean = rows.iter().map(|row| row[k].0).sum::<Vector4<f64>>() / n;
        let level = rows.iter().map(|row| row[k].1).sum::<f64>() / n;
        for row in &rows {
            let (terms, residual) = (row[k].0 - mean, row[k].1 - level);
            sums.0 += terms * terms.transpose();
            sums.1 += terms * residual;
            sums.2 += residual * residual;
        }
    }
    sums
}
