//! Radial and tangential distortion (Brown, Photogrammetric Engineering 32 (1966) 444; signs as in
//! OpenCV).
//!
//! With u, v the ideal column and row from the centre in units of ρ = half the sensor's diagonal,
//! r² = u² + v²:
//!
//! ```text
//! u' = u(1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 uv + p2(r² + 2u²)
//! v' = v(1 + k1 r² + k2 r⁴ + k3 r⁶) + p1(r² + 2v²) + 2 p2 uv
//! ```
//!
//! k1 = 0.001 moves the corner by 0.1 % of the half diagonal. The inverse is Newton's method on the
//! exact Jacobian; a distortion that folds the image within the sensor is refused.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// Largest coefficient: a metrology lens has 1e-4 to 1e-2, an ordinary wide-angle lens 0.3.
const LARGEST: f64 = 0.5;

/// Newton steps of the inverse; three reach 1e-12 for 10 % of distortion.
const STEPS: usize = 12;

/// Points along the border and the diagonals at which folding is checked.
const PROBES: usize = 64;

/// Coefficients, dimensionless, for lengths in units of half the sensor's diagonal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Distortion {
    /// Radial, third order.
    pub k1: f64,
    /// Radial, fifth order.
    pub k2: f64,
    /// Radial, seventh order.
    pub k3: f64,
    /// Tangential, across the columns' direction.
    pub p1: f64,
    /// Tangential, across the rows' direction.
    pub p2: f64,
}

impl Distortion {
    /// Checks every value against its range, and that the image does not fold over.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("optics.distortion.k1", self.k1, -LARGEST, LARGEST)?;
        within("optics.distortion.k2", self.k2, -LARGEST, LARGEST)?;
        within("optics.distortion.k3", self.k3, -LARGEST, LARGEST)?;
        within("optics.distortion.p1", self.p1, -LARGEST, LARGEST)?;
        within("optics.distortion.p2", self.p2, -LARGEST, LARGEST)?;
        let folds = (0..PROBES * PROBES).any(|i| {
            let at = |k: usize| 2.0 * k as f64 / (PROBES - 1) as f64 - 1.0;
            let (u, v) = (at(i % PROBES), at(i / PROBES));
            let j = self.jacobian(u, v);
            u * u + v * v <= 1.0 && (j[0] <= 0.0 || j[3] <= 0.0 || j[0] * j[3] - j[1] * j[2] <= 0.0)
        });
        if folds {
            let found = format!("{:?}", [self.k1, self.k2, self.k3, self.p1, self.p2]);
            return Err(RenderError::setting(
                "optics.distortion",
                &found,
                "folds the image over: take smaller coefficients",
            ));
        }
        Ok(())
    }

    /// Whether there is no distortion.
    pub(crate) fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Distorted position of the ideal point (u, v), both in half diagonals.
    pub(crate) fn distort(&self, u: f64, v: f64) -> (f64, f64) {
        let r2 = u * u + v * v;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        (
            u * radial + 2.0 * self.p1 * u * v + self.p2 * (r2 + 2.0 * u * u),
            v * radial + self.p1 * (r2 + 2.0 * v * v) + 2.0 * self.p2 * u * v,
        )
    }

    /// ∂u'/∂u, ∂u'/∂v, ∂v'/∂u, ∂v'/∂v.
    fn jacobian(&self, u: f64, v: f64) -> [f64; 4] {
        let r2 = u * u + v * v;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        let steep = 2.0 * (self.k1 + r2 * (2.0 * self.k2 + 3.0 * r2 * self.k3));
        let mixed = steep * u * v + 2.0 * self.p1 * u + 2.0 * self.p2 * v;
        [
            radial + steep * u * u + 2.0 * self.p1 * v + 6.0 * self.p2 * u,
            mixed,
            mixed,
            radial + steep * v * v + 6.0 * self.p1 * v + 2.0 * self.p2 * u,
        ]
    }

    /// The ideal point with the distorted position (u', v').
    pub(crate) fn undistort(&self, u_seen: f64, v_seen: f64) -> (f64, f64) {
        let (mut u, mut v) = (u_seen, v_seen);
        for _ in 0..STEPS {
            let (a, b) = self.distort(u, v);
            let (du, dv) = (a - u_seen, b - v_seen);
            let j = self.jacobian(u, v);
            let determinant = j[0] * j[3] - j[1] * j[2];
            u -= (du * j[3] - dv * j[1]) / determinant;
            v -= (dv * j[0] - du * j[2]) / determinant;
            if du.abs() + dv.abs() < 1e-15 {
                break;
            }
        }
        (u, v)
    }

    /// [`Self::distort`] in pixels of a sensor of `rows` x `columns`: the distorted position of the
    /// ideal point (row, column).
    pub(crate) fn distort_px(&self, row: f64, column: f64, rows: usize, columns: usize) -> (f64, f64) {
        let frame = SensorFrame::new(rows, columns);
        let (u, v) = frame.units(row, column);
        let (u, v) = self.distort(u, v);
        frame.pixels(u, v)
    }

    /// [`Self::undistort`] in pixels of a sensor of `rows` x `columns`.
    pub(crate) fn undistort_px(&self, row: f64, column: f64, rows: usize, columns: usize) -> (f64, f64) {
        let frame = SensorFrame::new(rows, columns);
        let (u, v) = frame.units(row, column);
        let (u, v) = self.undistort(u, v);
        frame.pixels(u, v)
    }

    /// Row at which the ideal edge row = `edge`(column) crosses a column of the distorted image.
    ///
    /// Solves distorted column(c) = `column` for the ideal column c by secant steps; accurate to
    /// 1e-10 px for edges with slopes below about 100.
    pub(crate) fn edge_row(
        &self,
        column: f64,
        rows: usize,
        columns: usize,
        edge: impl Fn(f64) -> f64,
    ) -> f64 {
        let seen = |c: f64| self.distort_px(edge(c), c, rows, columns);
        let start = self.undistort_px(edge(column), column, rows, columns).1;
        let (mut a, mut b) = (column, if start == column { column + 1e-3 } else { start });
        let (mut fa, mut fb) = (seen(a).1 - column, seen(b).1 - column);
        for _ in 0..STEPS {
            if fb.abs() < 1e-12 || fa == fb {
                break;
            }
            let next = b - fb * (b - a) / (fb - fa);
            (a, fa) = (b, fb);
            b = next;
            fb = seen(b).1 - column;
        }
        seen(b).0
    }
}

/// Centre and half diagonal of a sensor.
struct SensorFrame {
    row: f64,
    column: f64,
    half_diagonal: f64,
}

impl SensorFrame {
    fn new(rows: usize, columns: usize) -> Self {
        let (rows, columns) = (rows as f64, columns as f64);
        Self {
            row: 0.5 * (rows - 1.0),
            column: 0.5 * (columns - 1.0),
            half_diagonal: 0.5 * rows.hypot(columns),
        }
    }

    fn units(&self, row: f64, column: f64) -> (f64, f64) {
        ((column - self.column) / self.half_diagonal, (row - self.row) / self.half_diagonal)
    }

    fn pixels(&self, u: f64, v: f64) -> (f64, f64) {
        (self.row + v * self.half_diagonal, self.column + u * self.half_diagonal)
    }
}
