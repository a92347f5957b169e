//! The paper's curves by every model.

use serde::Serialize;

use super::asked::ModelsAsked;
use super::curve_model::{CurveKind, CurveModel, left_out};
use super::paper_samples::{Curve, PaperSamples};

/// The models of a curve: the paper's nets with the numbers of units that its samples allow, and
/// what is done without a net.
pub(super) const KINDS: [CurveKind; 6] = [
    CurveKind::Net { hidden: 8 },
    CurveKind::Net { hidden: 12 },
    CurveKind::Net { hidden: 15 },
    CurveKind::PSpline,
    CurveKind::CubicSpline,
    CurveKind::Chebyshev { degree: 12 },
];

/// A curve by a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct CurveRow {
    /// Which of the paper's curves.
    pub curve: &'static str,
    /// The model.
    pub model: String,
    /// Peak to valley of the curve, µm.
    pub range_um: f64,
    /// Error between the samples against the truth, rms, µm; none where the samples are too few.
    pub held_out_um: Option<f64>,
    /// Error at samples left out, their noise in it, rms, µm: what a user can see.
    pub left_out_um: Option<f64>,
    /// Effective number of parameters of a penalised spline.
    pub parameters: Option<f64>,
    /// Noise of a sample as a penalised spline estimates it, µm.
    pub estimated_noise_um: Option<f64>,
    /// Whether that at samples left out is the least of the curve's models.
    pub is_least: bool,
}

pub(super) fn rows(samples: &PaperSamples<'_>, asked: &ModelsAsked) -> Vec<CurveRow> {
    Curve::ALL.into_iter().flat_map(|curve| of_curve(samples, curve, asked.nets)).collect()
}

fn of_curve(samples: &PaperSamples<'_>, curve: Curve, nets: bool) -> Vec<CurveRow> {
    let x = samples.positions(curve);
    let y = samples.read_um(curve);
    let between = PaperSamples::between(x);
    let truth: Vec<f64> = between.iter().map(|p| samples.value_um(curve, *p)).collect();
    let (low, high) = truth.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let row = |kind: CurveKind| {
        let model = CurveModel::fitted(kind, x, &y);
        let smoothness = model.as_ref().and_then(CurveModel::smoothness);
        CurveRow {
            curve: curve.name(),
            model: kind.name(),
            range_um: high - low,
            held_out_um: model.and_then(|model| off(&model, &between, &truth)),
            left_out_um: left_out(kind, x, &y),
            parameters: smoothness.map(|s| s.0),
            estimated_noise_um: smoothness.map(|s| s.1),
            is_least: false,
        }
    };
    let mut rows: Vec<CurveRow> = KINDS.into_iter().filter(|kind| nets || !kind.is_net()).map(row).collect();
    let least = rows.iter().filter_map(|row| row.left_out_um).fold(f64::INFINITY, f64::min);
    rows.iter_mut().for_each(|row| row.is_least = row.left_out_um == Some(least));
    rows
}

/// Rms of a model less the truth.
fn off(model: &CurveModel, at: &[f64], truth: &[f64]) -> Option<f64> {
    let squares: Option<Vec<f64>> =
        at.iter().zip(truth).map(|(p, right)| Some((model.value(*p)? - right).powi(2))).collect();
    squares.map(|s| (s.iter().sum::<f64>() / s.len().max(1) as f64).sqrt())
}
