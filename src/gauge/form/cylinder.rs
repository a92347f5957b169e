//! Least-squares cylinder (LSCY, ISO 12180), axis near z.
//!
//! The axis passes (x0, y0, 0) in direction (a, b, 1)/s, s = √(1 + a² + b²). With q = p − (x0, y0,
//! 0) and w the unit direction, the distance is r = |q − w(w·q)| and, u its unit vector, ∂r/∂x0 =
//! −u_x, ∂r/∂a = −(w·q)·u_x/s, and the same in y. Gauss-Newton; it converges as
//! (deviation/radius)^n. From silhouettes the cylinder is linear: the support function of a circle
//! about c is exactly h = R + c·n, so h(z, α) = R + (x0 + a·z)·cos α + (y0 + b·z)·sin α; the tilt's
//! cosine (½(a² + b²) of R) is left out there. The least circumscribed cylinder (ISO 14405-1, GN)
//! is the least R with h ≤ of that everywhere, a linear programme.

use glam::DVec3;
use nalgebra::{SMatrix, SVector};

use super::error::FormError;
use super::linear_program::{LinearProgram, Row};

/// A cylinder with its axis near z, in the points' unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Axis x at z = 0.
    pub x0: f64,
    /// Axis y at z = 0.
    pub y0: f64,
    /// Axis slope dx/dz.
    pub slope_x: f64,
    /// Axis slope dy/dz.
    pub slope_y: f64,
    /// Radius.
    pub radius: f64,
}

impl Cylinder {
    /// Signed distance of a point from the cylinder, positive outside.
    pub(crate) fn deviation(&self, point: DVec3) -> f64 {
        self.arm(point).0.length() - self.radius
    }

    /// Vector from the axis square to it, and the distance along it.
    fn arm(&self, point: DVec3) -> (DVec3, f64) {
        let w = DVec3::new(self.slope_x, self.slope_y, 1.0).normalize();
        let q = point - DVec3::new(self.x0, self.y0, 0.0);
        (q - w * w.dot(q), w.dot(q))
    }
}

/// A least-squares cylinder and the cylindricity parameters about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderFit {
    /// The cylinder.
    pub cylinder: Cylinder,
    /// Peak to valley, CYLt.
    pub cyl_t: f64,
    /// Peak to reference, CYLp.
    pub cyl_p: f64,
    /// Reference to valley, CYLv.
    pub cyl_v: f64,
    /// Root mean square, CYLq.
    pub cyl_q: f64,
    /// Length of the last step at the points, in their unit: what a further iteration would change.
    pub remaining: f64,
}

fn parameters(cylinder: Cylinder, remaining: f64, deviations: impl Iterator<Item = f64>) -> CylinderFit {
    let (mut low, mut high, mut squares, mut n) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0_f64);
    for e in deviations {
        low = low.min(e);
        high = high.max(e);
        squares += e * e;
        n += 1.0;
    }
    let cyl_q = (squares / n).sqrt();
    CylinderFit { cylinder, cyl_t: high - low, cyl_p: high, cyl_v: -low, cyl_q, remaining }
}

/// Solves the normal equations of rows; `None` if the columns are dependent.
fn solve(normal: &SMatrix<f64, 5, 5>, right: &SVector<f64, 5>) -> Option<SVector<f64, 5>> {
    let eigenvalues = normal.symmetric_eigenvalues();
    if eigenvalues.min() <= 1e-12 * eigenvalues.max() {
        return None;
    }
    normal.cholesky().map(|c| c.solve(right))
}

/// Middle and half length of z.
fn extent(z: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = z.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
    (0.5 * (low + high), 0.5 * (high - low))
}

/// Least-squares cylinder of points all around an axis near z (slopes up to about 0.2). At least
/// five points.
///
/// # Errors
/// Too few or non-finite points, points of one section only, no convergence.
pub fn least_squares_cylinder(points: &[DVec3]) -> Result<CylinderFit, FormError> {
    let feature = "least-squares cylinder";
    if points.len() < 5 {
        return Err(FormError::TooFew { feature, found: points.len(), needed: 5 });
    }
    if let Some(index) = points.iter().position(|p| !p.is_finite()) {
        return Err(FormError::NotFinite { index });
    }
    let (middle, half) = extent(points.iter().map(|p| p.z));
    if half <= 0.0 {
        return Err(FormError::Degenerate { feature });
    }
    let mean = points.iter().copied().sum::<DVec3>() / points.len() as f64;
    let shift = DVec3::new(mean.x, mean.y, middle);
    let local: Vec<DVec3> = points.iter().map(|p| *p - shift).collect();
    let radius = local.iter().map(|p| p.truncate().length()).sum::<f64>() / local.len() as f64;
    let mut cylinder = Cylinder { x0: 0.0, y0: 0.0, slope_x: 0.0, slope_y: 0.0, radius };
    let mut remaining = f64::INFINITY;
    for _ in 0..100 {
        let step = gauss_newton_step(&local, &cylinder, half).ok_or(FormError::Degenerate { feature })?;
        cylinder.x0 += step[0];
        cylinder.y0 += step[1];
        cylinder.slope_x += step[2] / half;
        cylinder.slope_y += step[3] / half;
        cylinder.radius += step[4];
        let length = step.norm();
        let settled = length <= 1e-15 * radius || (length <= 1e-11 * radius && length >= remaining);
        remaining = length;
        if settled {
            break;
        }
    }
    if remaining.is_nan() || remaining > 1e-9 * radius {
        return Err(FormError::NotConverged { feature });
    }
    cylinder.x0 += shift.x - cylinder.slope_x * middle;
    cylinder.y0 += shift.y - cylinder.slope_y * middle;
    Ok(parameters(cylinder, remaining, points.iter().map(|p| cylinder.deviation(*p))))
}

fn gauss_newton_step(points: &[DVec3], cylinder: &Cylinder, half: f64) -> Option<SVector<f64, 5>> {
    let s = (1.0 + cylinder.slope_x.powi(2) + cylinder.slope_y.powi(2)).sqrt();
    let (mut normal, mut right) = (SMatrix::zeros(), SVector::zeros());
    for p in points {
        let (arm, along) = cylinder.arm(*p);
        let r = arm.length();
        let u = arm / r.max(f64::MIN_POSITIVE);
        let lever = along / (s * half);
        let row = SVector::<f64, 5>::from([u.x, u.y, lever * u.x, lever * u.y, 1.0]);
        normal += row * row.transpose();
        right += row * (r - cylinder.radius);
    }
    solve(&normal, &right)
}

/// Least-squares cylinder of support samples (z, α, h): position along the axis, direction of the
/// tangent's normal in radians, distance of the tangent from the z axis. At least five samples.
///
/// # Errors
/// Too few or non-finite samples; samples of one section or of too few directions.
pub fn silhouette_cylinder(samples: &[[f64; 3]]) -> Result<CylinderFit, FormError> {
    let feature = "least-squares cylinder";
    if samples.len() < 5 {
        return Err(FormError::TooFew { feature, found: samples.len(), needed: 5 });
    }
    if let Some(index) = samples.iter().position(|s| s.iter().any(|v| !v.is_finite())) {
        return Err(FormError::NotFinite { index });
    }
    let (middle, half) = extent(samples.iter().map(|s| s[0]));
    if half <= 0.0 {
        return Err(FormError::Degenerate { feature });
    }
    let mean = samples.iter().map(|s| s[2]).sum::<f64>() / samples.len() as f64;
    let row = |s: &[f64; 3]| {
        let (sin, cos) = s[1].sin_cos();
        let lever = (s[0] - middle) / half;
        SVector::<f64, 5>::from([cos, sin, lever * cos, lever * sin, 1.0])
    };
    let (mut normal, mut right) = (SMatrix::zeros(), SVector::zeros());
    for s in samples {
        normal += row(s) * row(s).transpose();
        right += row(s) * (s[2] - mean);
    }
    let x = solve(&normal, &right).ok_or(FormError::Degenerate { feature })?;
    let (slope_x, slope_y) = (x[2] / half, x[3] / half);
    let cylinder = Cylinder {
        x0: x[0] - slope_x * middle,
        y0: x[1] - slope_y * middle,
        slope_x,
        slope_y,
        radius: mean + x[4],
    };
    Ok(parameters(cylinder, 0.0, samples.iter().map(|s| s[2] - mean - row(s).dot(&x))))
}

/// Least circumscribed cylinder of support samples (z, α, h), as [`silhouette_cylinder`] takes
/// them: of the body whose silhouettes they are. What lies between the samples is not seen.
///
/// # Errors
/// As [`silhouette_cylinder`]; rounding that defeats the linear programme.
pub fn circumscribed_cylinder(samples: &[[f64; 3]]) -> Result<Cylinder, FormError> {
    let feature = "least circumscribed cylinder";
    let start = silhouette_cylinder(samples)?.cylinder;
    let (middle, half) = extent(samples.iter().map(|s| s[0]));
    let direction = |s: &[f64; 3]| {
        let ((sin, cos), lever) = (s[1].sin_cos(), (s[0] - middle) / half);
        [cos, sin, lever * cos, lever * sin, 1.0]
    };
    let dot = |a: &[f64; 5], x: &[f64; 5]| a.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
    let (sx, sy) = (start.slope_x * half, start.slope_y * half);
    let mut x = [start.x0 + start.slope_x * middle, start.y0 + start.slope_y * middle, sx, sy, start.radius];
    let reach = samples.iter().map(|s| (s[2] - dot(&direction(s), &x)).abs()).fold(0.0, f64::max);
    let mut bound = 8.0 * reach + 1e-12 * start.radius.abs();
    // In a shrinking box about what was found, so that the programme's tie-breaking cost vanishes.
    for _ in 0..3 {
        let rows: Vec<Row<5>> =
            samples.iter().map(|s| Row { a: direction(s), b: s[2] - dot(&direction(s), &x) }).collect();
        let lp = LinearProgram {
            cost: [0.0, 0.0, 0.0, 0.0, 1.0],
            lower: [-bound; 5],
            upper: [bound; 5],
            tolerance: 1e-15 * start.radius.abs(),
        };
        let step = lp.solve(&rows).ok_or(FormError::NotConverged { feature })?;
        x.iter_mut().zip(step).for_each(|(x, step)| *x += step);
        bound *= 0.05;
    }
    let (slope_x, slope_y) = (x[2] / half, x[3] / half);
    Ok(Cylinder { x0: x[0] - slope_x * middle, y0: x[1] - slope_y * middle, slope_x, slope_y, radius: x[4] })
}

#[cfg(test)]
mod circumscribed_tests {
    use super::*;
    use std::f64::consts::TAU;

    fn samples(h: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
        let at = |z: usize, k: usize| (5.0 * z as f64, TAU * k as f64 / 72.0);
        (0..21).flat_map(|z| (0..72).map(move |k| at(z, k))).map(|(z, a)| [z, a, h(z, a)]).collect()
    }

    /// A tilted cylinder is its own; a bent one of sagitta s needs R + s/2; a cone its larger end;
    /// a bump on one side half its height.
    #[test]
    fn closed_forms_of_the_least_circumscribed_cylinder() {
        let tilted = |z: f64, a: f64| (3.0 + 0.01 * z) * a.cos() - (1.0 + 0.02 * z) * a.sin();
        let radius =
            |h: &dyn Fn(f64, f64) -> f64| circumscribed_cylinder(&samples(h)).map(|c| c.radius).unwrap();
        assert!((radius(&|z, a| 12.5 + tilted(z, a)) - 12.5).abs() < 1e-9);
        let bent = |z: f64| 0.04 * (1.0 - (z / 50.0 - 1.0).powi(2));
        let found = radius(&|z, a| 12.5 + tilted(z, a) + bent(z) * a.cos());
        assert!((found - 12.52).abs() < 1e-6, "{found}");
        let cone = radius(&|z, a| 12.5 + 1e-3 * z + tilted(z, a));
        assert!((cone - 12.6).abs() < 1e-6, "{cone}");
        // A bump at one place and angle: it and the whole of the other side touch.
        let bump = radius(&|z, a| if z == 50.0 && a == 0.0 { 12.6 } else { 12.5 });
        assert!(bump > 12.5 && bump < 12.56, "{bump}");
    }

    /// Everything lies inside, and no cylinder of a little less radius about a nearby axis holds
    /// it.
    #[test]
    fn it_holds_every_sample_and_is_the_least() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_pcg::Pcg64::seed_from_u64(3);
        let noisy: Vec<[f64; 3]> = samples(|z, a| 10.0 + 0.02 * (2.0 * a).cos() + 1e-3 * z * a.sin())
            .into_iter()
            .map(|s| [s[0], s[1], s[2] + 0.01 * random.random::<f64>()])
            .collect();
        let found = circumscribed_cylinder(&noisy).unwrap();
        let outside = |c: &Cylinder| {
            let of = |s: &[f64; 3]| {
                let (sin, cos) = s[1].sin_cos();
                s[2] - (c.x0 + c.slope_x * s[0]) * cos - (c.y0 + c.slope_y * s[0]) * sin
            };
            noisy.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
        };
        assert!((outside(&found) - found.radius).abs() < 1e-9);
        for _ in 0..2000 {
            let mut other = found;
            other.x0 += 2e-3 * (random.random::<f64>() - 0.5);
            other.y0 += 2e-3 * (random.random::<f64>() - 0.5);
            other.slope_x += 4e-5 * (random.random::<f64>() - 0.5);
            other.slope_y += 4e-5 * (random.random::<f64>() - 0.5);
            assert!(outside(&other) >= found.radius - 1e-9);
        }
    }
}
