//! Both components over the working space by every model.

use serde::Serialize;

use super::asked::ModelsAsked;
use super::curve_model::{CurveKind, CurveModel};
use super::paper_samples::{Curve, PaperSamples};
use crate::machine::{Axis, ErrorName, ErrorValues};
use crate::numerics::neural_net::{NeuralNet, Samples, Training};

/// Hidden units of the paper's nets A to D: as many as 51 samples allow.
const HIDDEN: usize = 12;
/// Steps and starts of the net of two inputs: at 40 steps its error is below a hundredth of a
/// micrometre on smooth fields, in half a second.
const STEPS: usize = 40;
const STARTS: u64 = 2;

/// A model of the working space.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FieldRow {
    /// The model.
    pub model: String,
    /// What it is given.
    pub given: &'static str,
    /// Error along X between the samples against the truth, its mean taken out, rms, µm.
    pub e_x_um: f64,
    /// The same along Z.
    pub e_z_um: f64,
    /// The uncompensated error along X over that, rms to rms.
    pub x_factor: f64,
    /// The same along Z.
    pub z_factor: f64,
}

/// A model: both components at a position, µm; none outside its range.
type Model<'a> = Box<dyn Fn(f64, f64) -> Option<[f64; 2]> + 'a>;

pub(super) fn rows(samples: &PaperSamples<'_>, asked: &ModelsAsked) -> Vec<FieldRow> {
    const CURVES: &str = "curves A to D";
    const TABLE: &str = "the paper's table of sums";
    const SPACE: &str = "samples of the working space";
    let compared = Compared::of(samples);
    let table = samples_of(samples, &sums(samples));
    let space = samples_of(samples, &samples.read_field_um());
    let of_net = |given: &Samples| asked.nets.then(|| two_inputs(given, asked)).flatten();
    let nets = CurveKind::Net { hidden: HIDDEN };
    let of_nets = asked.nets.then(|| of_curves(samples, nets)).flatten();
    let two = format!("net 2-{}-2", asked.hidden);
    let models: [(String, &'static str, Option<Model<'_>>); 6] = [
        ("sum of nets A to D".to_owned(), CURVES, of_nets),
        ("sum of penalised splines".to_owned(), CURVES, of_curves(samples, CurveKind::PSpline)),
        (two.clone(), TABLE, of_net(&table)),
        (two, SPACE, of_net(&space)),
        ("f(x) + g(z), penalised splines".to_owned(), SPACE, separable(samples, &space)),
        ("structured: errors through the chain".to_owned(), "each error over its slide", structured(samples)),
    ];
    models.into_iter().filter_map(|(name, given, model)| Some(compared.row(name, given, &model?))).collect()
}

/// The working space between the samples.
struct Compared {
    at: Vec<[f64; 2]>,
    truth: Vec<[f64; 2]>,
}

impl Compared {
    fn of(samples: &PaperSamples<'_>) -> Self {
        let [x, z] = [&samples.x_mm, &samples.z_mm].map(|positions| PaperSamples::between(positions));
        let at: Vec<[f64; 2]> = x.iter().flat_map(|x| z.iter().map(|z| [*x, *z])).collect();
        let truth = at.iter().map(|[x, z]| samples.field_um(*x, *z)).collect();
        Self { at, truth }
    }

    fn row(&self, model: String, given: &'static str, of: &Model<'_>) -> FieldRow {
        let left = |k: usize| {
            let off =
                |(at, right): (&[f64; 2], &[f64; 2])| of(at[0], at[1]).map_or(f64::NAN, |e| e[k] - right[k]);
            spread(&self.at.iter().zip(&self.truth).map(off).collect::<Vec<f64>>())
        };
        let own = |k: usize| spread(&self.truth.iter().map(|e| e[k]).collect::<Vec<f64>>());
        let [e_x_um, e_z_um] = [left(0), left(1)];
        FieldRow { model, given, e_x_um, e_z_um, x_factor: own(0) / e_x_um, z_factor: own(1) / e_z_um }
    }
}

/// Rms about the mean.
fn spread(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// The paper's table: A(z) + B(x) and C(x) + D(z) as they are read, z running fastest.
fn sums(samples: &PaperSamples<'_>) -> Vec<[f64; 2]> {
    let [a, b, c, d] = Curve::ALL.map(|curve| samples.read_um(curve));
    let along = |i: usize| {
        let (a, b, c, d) = (&a, &b, &c, &d);
        (0..samples.z_mm.len()).map(move |j| [a[j] + b[i], c[i] + d[j]])
    };
    (0..samples.x_mm.len()).flat_map(along).collect()
}

/// Values over the raster as samples of a net.
fn samples_of(samples: &PaperSamples<'_>, values: &[[f64; 2]]) -> Samples {
    let at = samples.x_mm.iter().flat_map(|x| samples.z_mm.iter().map(|z| vec![*x, *z]));
    Samples { inputs: at.collect(), outputs: values.iter().map(|v| v.to_vec()).collect() }
}

/// The paper's sums of curves.
fn of_curves<'a>(samples: &PaperSamples<'_>, kind: CurveKind) -> Option<Model<'a>> {
    let fit = |curve: Curve| CurveModel::fitted(kind, samples.positions(curve), &samples.read_um(curve));
    let [a, b, c, d] = [fit(Curve::A)?, fit(Curve::B)?, fit(Curve::C)?, fit(Curve::D)?];
    Some(Box::new(move |x, z| Some([a.value(z)? + b.value(x)?, c.value(x)? + d.value(z)?])))
}

/// One net of two inputs and two outputs: of some starts the one with the least error on every
/// fifth sample, which it was not given.
fn two_inputs<'a>(given: &Samples, asked: &ModelsAsked) -> Option<Model<'a>> {
    let part = |wanted: bool| {
        let picked = |rows: &[Vec<f64>]| {
            (0..rows.len()).filter(|k| (k % 5 == 2) == wanted).map(|k| rows[k].clone()).collect::<Vec<_>>()
        };
        Samples { inputs: picked(&given.inputs), outputs: picked(&given.outputs) }
    };
    let (own, out) = (part(false), part(true));
    let scored = (0..STARTS).filter_map(|start| {
        let seed = asked.seed.wrapping_add(start);
        let net = NeuralNet::fitted(&own, &Training { hidden: asked.hidden, steps: STEPS, seed })?;
        let off = |(input, right): (&Vec<f64>, &Vec<f64>)| {
            net.values(input).iter().zip(right).map(|(v, r)| (v - r).powi(2)).sum::<f64>()
        };
        Some((out.inputs.iter().zip(&out.outputs).map(off).sum::<f64>(), net))
    });
    let (_, net) = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let range = |k: usize| {
        let fold = |(low, high): (f64, f64), row: &Vec<f64>| (low.min(row[k]), high.max(row[k]));
        given.inputs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), fold)
    };
    let [(x_from, x_to), (z_from, z_to)] = [range(0), range(1)];
    Some(Box::new(move |x, z| {
        let inside = (x_from..=x_to).contains(&x) && (z_from..=z_to).contains(&z);
        let values = net.values(&[x, z]);
        inside.then_some([values[0], values[1]])
    }))
}

/// The best f(x) + g(z): penalised splines of the means of rows and columns.
fn separable<'a>(samples: &PaperSamples<'_>, space: &Samples) -> Option<Model<'a>> {
    let (rows, columns) = (samples.x_mm.len(), samples.z_mm.len());
    let value = |i: usize, j: usize, k: usize| space.outputs[i * columns + j][k];
    let fit = |k: usize| {
        let of_row = |i: usize| (0..columns).map(|j| value(i, j, k)).sum::<f64>() / columns as f64;
        let of_column = |j: usize| (0..rows).map(|i| value(i, j, k)).sum::<f64>() / rows as f64;
        let f: Vec<f64> = (0..rows).map(of_row).collect();
        let g: Vec<f64> = (0..columns).map(of_column).collect();
        let f = CurveModel::fitted(CurveKind::PSpline, &samples.x_mm, &f)?;
        Some((f, CurveModel::fitted(CurveKind::PSpline, &samples.z_mm, &g)?))
    };
    let ((fx, gx), (fz, gz)) = (fit(0)?, fit(1)?);
    Some(Box::new(move |x, z| Some([fx.value(x)? + gx.value(z)?, fz.value(x)? + gz.value(z)?])))
}

/// Every error by a penalised spline over its own slide, through the first order of the chain;
/// errors of the spindle and orientations by the mean of their readings.
fn structured<'a>(samples: &'a PaperSamples<'_>) -> Option<Model<'a>> {
    let fit = |name: ErrorName| {
        let read = samples.read_error(name);
        let positions = match name.axis() {
            Axis::X if name != ErrorName::B0x => &samples.x_mm,
            Axis::Z => &samples.z_mm,
            _ => return Some(Err(read.iter().sum::<f64>() / read.len() as f64)),
        };
        CurveModel::fitted(CurveKind::PSpline, positions, &read).map(Ok)
    };
    let models: Option<Vec<Result<CurveModel, f64>>> = ErrorName::ALL.into_iter().map(fit).collect();
    let models = models?;
    Some(Box::new(move |x, z| {
        let mut values = ErrorValues::default();
        for (name, model) in ErrorName::ALL.into_iter().zip(&models) {
            let position = if name.axis() == Axis::X { x } else { z };
            values.0[name as usize] = match model {
                Ok(model) => model.value(position)?,
                Err(mean) => *mean,
            };
        }
        Some(samples.first_order_um(x, z, &values))
    }))
}
