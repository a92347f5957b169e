//! A cubic spline over a range, taken apart into offset, slope and shape.
//!
//! f(p) = a + b·s + Σ θ_k·φ_k(p) with s from −1 to 1 over the range. The θ are the second
//! differences D·c of the coefficients of a spline with even knots, φ the spline of the columns of
//! D⁺ = Dᵀ(DDᵀ)⁻¹ less its line of least squares over the range: a straight line has no second
//! differences, and the shape holds none of a line. The penalty of a P-spline (Eilers and Marx
//! 1996, second order) is then the sum of the θ², which is a prior of mean 0 and equal spread for
//! every θ.

use nalgebra::DMatrix;

/// Offset, slope and shape of a cubic spline.
#[derive(Clone, Debug)]
pub(crate) struct SplineBasis {
    from: f64,
    to: f64,
    segments: usize,
    /// D⁺: coefficients of the spline for one unit of each second difference.
    shape: DMatrix<f64>,
    /// Mean and slope over the range that each of them would have.
    lines: Vec<[f64; 2]>,
}

/// Places in a segment at which the line of a shape is taken.
const PLACES: usize = 8;

impl SplineBasis {
    /// A spline of some segments, at least one, over a range in mm; none where the range is empty.
    pub(crate) fn new(from: f64, to: f64, segments: usize) -> Option<Self> {
        if segments == 0 || !(to > from) {
            return None;
        }
        let count = segments + 3;
        let mut differences = DMatrix::zeros(count - 2, count);
        for k in 0..count - 2 {
            for (i, d) in [(k, 1.0), (k + 1, -2.0), (k + 2, 1.0)] {
                differences[(k, i)] = d;
            }
        }
        let square = &differences * differences.transpose();
        let shape = square.cholesky()?.solve(&differences).transpose();
        let mut basis = Self { from, to, segments, shape, lines: vec![[0.0; 2]; count - 2] };
        basis.lines = basis.lines_of_shapes();
        Some(basis)
    }

    /// Lines of least squares through the shape functions, over even places.
    fn lines_of_shapes(&self) -> Vec<[f64; 2]> {
        let count = PLACES * self.segments;
        let place = |k: usize| self.from + (self.to - self.from) * (k as f64 + 0.5) / count as f64;
        let mut lines = vec![[0.0; 2]; self.shapes()];
        let square: f64 = (0..count).map(|k| self.slope(place(k)).powi(2)).sum();
        for k in 0..count {
            let s = self.slope(place(k));
            for (line, value) in lines.iter_mut().zip(self.shape(place(k))) {
                line[0] += value / count as f64;
                line[1] += value * s / square;
            }
        }
        lines
    }

    /// Number of shape functions.
    pub(crate) fn shapes(&self) -> usize {
        self.segments + 1
    }

    /// The range, mm.
    pub(crate) fn range(&self) -> [f64; 2] {
        [self.from, self.to]
    }

    /// s at a position: −1 at the start of the range, 1 at its end.
    pub(crate) fn slope(&self, position: f64) -> f64 {
        (2.0 * position - self.from - self.to) / (self.to - self.from)
    }

    /// The shape functions at a position of the range; at its ends beyond it.
    pub(crate) fn shape(&self, position: f64) -> Vec<f64> {
        let place = (position - self.from) / (self.to - self.from) * self.segments as f64;
        let place = place.clamp(0.0, self.segments as f64);
        let first = (place as usize).min(self.segments - 1);
        let values = cubic(place - first as f64);
        let s = self.slope(position);
        let sum = |k: usize| {
            let spline: f64 = (0..4).map(|i| values[i] * self.shape[(first + i, k)]).sum();
            spline - self.lines[k][0] - self.lines[k][1] * s
        };
        (0..self.shapes()).map(sum).collect()
    }
}

/// The four values of the cubic B-splines at the fraction t of a segment.
fn cubic(t: f64) -> [f64; 4] {
    let (s, t2, t3) = (1.0 - t, t * t, t * t * t);
    [
        s * s * s / 6.0,
        (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0,
        (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0,
        t3 / 6.0,
    ]
}
