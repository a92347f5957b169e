//! A curve over a range by one of the models; outside the range none has a value.

use crate::numerics::chebyshev::Chebyshev;
use crate::numerics::cubic_spline::CubicSpline;
use crate::numerics::neural_net::{NeuralNet, Samples, Training};
use crate::numerics::p_spline::PSpline;

/// Starts of a net, of which the one with the least error on samples left out is taken.
const STARTS: u64 = 8;
/// Most steps of a net's fit: beyond, 1-15-1 follows the noise of 51 samples (error .0077 at 100
/// steps, .0118 at 300, with noise .01).
const STEPS: usize = 100;
/// Of so many samples one is left out, to choose among starts and models.
const LEFT_OUT: usize = 5;
/// Segments a sample of a penalised spline: more change its error by less than a tenth.
const SEGMENTS_A_SAMPLE: f64 = 0.5;

/// A kind of model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CurveKind {
    /// The paper's net 1-N-1.
    Net {
        /// Hidden units.
        hidden: usize,
    },
    /// A penalised spline, its smoothness by generalised cross-validation.
    PSpline,
    /// The spline through all samples.
    CubicSpline,
    /// A polynomial of least squares.
    Chebyshev {
        /// Its degree.
        degree: usize,
    },
}

impl CurveKind {
    /// Whether it is a net.
    pub(crate) fn is_net(self) -> bool {
        matches!(self, Self::Net { .. })
    }

    /// Its name.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Net { hidden } => format!("net 1-{hidden}-1"),
            Self::PSpline => "penalised spline".to_owned(),
            Self::CubicSpline => "cubic spline".to_owned(),
            Self::Chebyshev { degree } => format!("Chebyshev, degree {degree}"),
        }
    }
}

enum Fitted {
    Net(NeuralNet),
    PSpline(PSpline),
    CubicSpline(CubicSpline),
    Chebyshev(Chebyshev),
}

/// A fitted curve.
pub(crate) struct CurveModel {
    range: [f64; 2],
    fitted: Fitted,
}

impl CurveModel {
    /// A curve through samples at ascending places, from the first to the last of them; none where
    /// there are too few for the model.
    pub(crate) fn fitted(kind: CurveKind, x: &[f64], y: &[f64]) -> Option<Self> {
        let range = [*x.first()?, *x.last()?];
        let fitted = match kind {
            CurveKind::Net { hidden } => Fitted::Net(best_net(x, y, hidden)?),
            CurveKind::PSpline => {
                let segments = ((x.len() as f64 * SEGMENTS_A_SAMPLE) as usize).max(1);
                Fitted::PSpline(PSpline::fitted(x, y, range, segments)?)
            }
            CurveKind::CubicSpline => Fitted::CubicSpline(CubicSpline::natural(x, y)?),
            CurveKind::Chebyshev { degree } => Fitted::Chebyshev(Chebyshev::fitted(x, y, range, degree)?),
        };
        Some(Self { range, fitted })
    }

    /// Effective number of parameters and estimated noise of a penalised spline.
    pub(crate) fn smoothness(&self) -> Option<(f64, f64)> {
        match &self.fitted {
            Fitted::PSpline(spline) => Some((spline.parameters, spline.noise)),
            _ => None,
        }
    }

    /// The value at a place; none outside the range of the samples.
    pub(crate) fn value(&self, x: f64) -> Option<f64> {
        if !(self.range[0]..=self.range[1]).contains(&x) {
            return None;
        }
        match &self.fitted {
            Fitted::Net(net) => Some(net.value(x)),
            Fitted::PSpline(spline) => spline.value(x),
            Fitted::CubicSpline(spline) => spline.value(x),
            Fitted::Chebyshev(polynomial) => polynomial.value(x),
        }
    }
}

/// Error of a model at samples that it is not given, each fifth one but the ends, rms; none where
/// too few are left.
pub(crate) fn left_out(kind: CurveKind, x: &[f64], y: &[f64]) -> Option<f64> {
    let ([own_x, own_y], [out_x, out_y]) = parted(x, y);
    let model = CurveModel::fitted(kind, &own_x, &own_y)?;
    let off = out_x.iter().zip(&out_y).map(|(x, y)| Some((model.value(*x)? - y).powi(2)));
    let squares: Option<Vec<f64>> = off.collect();
    squares.filter(|s| !s.is_empty()).map(|s| (s.iter().sum::<f64>() / s.len() as f64).sqrt())
}

/// The samples that a model is given, and those left out.
fn parted(x: &[f64], y: &[f64]) -> ([Vec<f64>; 2], [Vec<f64>; 2]) {
    let is_out = |k: &usize| k % LEFT_OUT == LEFT_OUT / 2 && *k > 0 && k + 1 < x.len();
    let of = |wanted: bool| {
        let picked = |values: &[f64]| {
            (0..x.len()).filter(|k| is_out(k) == wanted).map(|k| values[k]).collect::<Vec<f64>>()
        };
        [picked(x), picked(y)]
    };
    (of(false), of(true))
}

/// The start with the least error on the samples left out, fitted to all.
fn best_net(x: &[f64], y: &[f64], hidden: usize) -> Option<NeuralNet> {
    let ([own_x, own_y], [out_x, out_y]) = parted(x, y);
    let fit = |x: &[f64], y: &[f64], seed: u64| {
        NeuralNet::fitted(&Samples::curve(x, y), &Training { hidden, steps: STEPS, seed })
    };
    let scored = (0..STARTS).filter_map(|seed| {
        let net = fit(&own_x, &own_y, seed)?;
        Some((out_x.iter().zip(&out_y).map(|(x, y)| (net.value(*x) - y).powi(2)).sum::<f64>(), seed))
    });
    let (_, seed) = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
    fit(x, y, seed)
}
