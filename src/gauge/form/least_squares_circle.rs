//! Least-squares circle (LSCI, ISO 12181) of the geometric distances.
//!
//! Minimise S(c) = mean r² − (mean r)², r_i = |p_i − c|; the radius is mean r. With u_i the unit
//! vectors from the centre, ½∇S = −mean r·u + mean r · mean u and ½∇²S = I − ḡḡᵀ − r̄·mean (I −
//! uuᵀ)/r, ḡ = mean u. Newton's method from the algebraic (Kåsa) circle.

use glam::DVec2;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::certificate::Certificate;
use super::circle::{CircleFit, assemble, centroid, check, radii};
use super::error::FormError;
use crate::numerics::normal_equations::NormalEquations;

/// A least-squares circle and its covariance from the residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastSquaresCircle {
    /// The circle and its proof.
    pub fit: CircleFit,
    /// Root mean square deviation RONq, in the points' unit.
    pub rms: f64,
    /// Covariance of (x, y, radius) for points with independent radial errors of unit variance.
    pub covariance: Matrix3<f64>,
}

/// Half of the gradient and of the Hessian of S, and mean r.
struct Local {
    gradient: Vector2<f64>,
    hessian: Matrix2<f64>,
    mean_radius: f64,
}

fn local(points: &[DVec2], centre: DVec2) -> Local {
    let n = points.len() as f64;
    let (mut mean_r, mut mean_u, mut mean_ru) = (0.0, DVec2::ZERO, DVec2::ZERO);
    let mut bend = Matrix2::zeros();
    for p in points {
        let arm = *p - centre;
        let r = arm.length().max(f64::MIN_POSITIVE);
        let u = arm / r;
        mean_r += r / n;
        mean_u += u / n;
        mean_ru += arm / n;
        bend += Matrix2::new(1.0 - u.x * u.x, -u.x * u.y, -u.x * u.y, 1.0 - u.y * u.y) / (r * n);
    }
    let gradient = mean_u * mean_r - mean_ru;
    let g = Vector2::new(mean_u.x, mean_u.y);
    let hessian = Matrix2::identity() - g * g.transpose() - bend * mean_r;
    Local { gradient: Vector2::new(gradient.x, gradient.y), hessian, mean_radius: mean_r }
}

/// Least-squares circle of points. At least three, not on a line.
///
/// # Errors
/// Too few, non-finite or collinear points; no convergence.
pub fn least_squares_circle(points: &[DVec2]) -> Result<LeastSquaresCircle, FormError> {
    let feature = "least-squares circle";
    check(points, 3, feature)?;
    let origin = centroid(points);
    let shifted: Vec<DVec2> = points.iter().map(|p| *p - origin).collect();
    let mut centre = algebraic_centre(&shifted).ok_or(FormError::Degenerate { feature })?;
    let mut converged = false;
    for _ in 0..100 {
        let at = local(&shifted, centre);
        let step = newton_step(&at).ok_or(FormError::Degenerate { feature })?;
        // Steps of more than a third of the radius leave the region where the quadratic model means
        // anything.
        let length = step.norm();
        let scale = (at.mean_radius / (3.0 * length.max(f64::MIN_POSITIVE))).min(1.0);
        centre += DVec2::new(step.x, step.y) * scale;
        if length <= 4e-16 * at.mean_radius {
            converged = true;
            break;
        }
        if converged {
            break;
        }
        // One more step once below the level at which Newton's error is its square.
        converged = length <= 1e-9 * at.mean_radius;
    }
    if !converged {
        return Err(FormError::NotConverged { feature });
    }
    let radius = local(&shifted, centre).mean_radius;
    let centre = origin + centre;
    let certificate = certify_least_squares(points, centre);
    let fit = assemble(points, centre, |_, _| radius, certificate);
    let rms =
        (points.iter().map(|p| fit.circle.deviation(*p).powi(2)).sum::<f64>() / points.len() as f64).sqrt();
    let covariance = covariance(points, centre).ok_or(FormError::Degenerate { feature })?;
    Ok(LeastSquaresCircle { fit, rms, covariance })
}

fn newton_step(at: &Local) -> Option<Vector2<f64>> {
    let smallest = at.hessian.symmetric_eigenvalues().min();
    if smallest > 1e-12 {
        return at.hessian.try_inverse().map(|inverse| -(inverse * at.gradient));
    }
    // Far from the optimum the Hessian may be indefinite: follow the gradient.
    (smallest.is_finite() && at.gradient.norm() > 0.0).then(|| -at.gradient)
}

/// Kåsa's circle: least squares of x² + y² + ax + by + c.
fn algebraic_centre(points: &[DVec2]) -> Option<DVec2> {
    let scale = points.iter().map(|p| p.length()).fold(0.0, f64::max);
    if scale <= 0.0 {
        return None;
    }
    let mut fit = NormalEquations::new();
    for p in points {
        fit.add(Vector3::new(p.x / scale, p.y / scale, 1.0), p.length_squared() / (scale * scale), 1.0);
    }
    let normal = &fit.normal;
    let spread = Matrix2::new(normal[(0, 0)], normal[(0, 1)], normal[(1, 0)], normal[(1, 1)]);
    let eigenvalues = spread.symmetric_eigenvalues();
    if eigenvalues.min() <= 1e-24 * eigenvalues.max() {
        return None;
    }
    let solution = fit.by_inverse()?;
    Some(DVec2::new(solution.x, solution.y) * (0.5 * scale))
}

/// Covariance of (x, y, radius) at unit variance of each radial deviation: (JᵀJ)⁻¹ with rows (u_x,
/// u_y, 1).
fn covariance(points: &[DVec2], centre: DVec2) -> Option<Matrix3<f64>> {
    let mut normal = Matrix3::zeros();
    for p in points {
        let u = (*p - centre).normalize_or_zero();
        let row = Vector3::new(u.x, u.y, 1.0);
        normal += row * row.transpose();
    }
    normal.try_inverse()
}

/// Certifies that the sum of squares has its minimum at the centre, and how far around there is no
/// other.
///
/// The Hessian's smallest eigenvalue λ divided by a bound of the third derivative gives the ball in
/// which S is convex: for |d| ≤ B = r_min/2, half the third derivative is at most 3/ρ +
/// (2/√3)·(r̄ + B)/ρ², ρ = r_min − B. The gap is twice the Newton step that remains, a distance of
/// the centre.
pub(crate) fn certify_least_squares(points: &[DVec2], centre: DVec2) -> Certificate {
    let at = local(points, centre);
    let (inner, _) = radii(points, centre);
    let smallest = at.hessian.symmetric_eigenvalues().min();
    let reach = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let rounding = 1e-15 * (reach + at.mean_radius);
    let remaining = newton_step(&at).map_or(f64::INFINITY, |s| s.norm());
    if smallest <= 0.0 || inner <= 0.0 {
        return Certificate::none(Vec::new());
    }
    let ball = 0.5 * inner;
    let rho = inner - ball;
    let third = 3.0 / rho + 2.0 / 3.0_f64.sqrt() * (at.mean_radius + ball) / (rho * rho);
    let proven_within = ball.min(smallest / third);
    if remaining > 0.25 * proven_within {
        return Certificate::none(Vec::new());
    }
    Certificate { contacts: Vec::new(), gap: 2.0 * remaining + rounding / smallest, proven_within }
}
