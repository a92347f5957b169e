//! Paper 000: least-squares compensation of a single shaft through macro variables.

use super::reproduction::{Row, Verdict};
use crate::control::fit;
use crate::nc::{LineFit, MacroProgram, MacroValues, NcSettings, Workpiece, fit_line};
use crate::plan::CuttingData;

/// What the paper's rows are computed from.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs {
    /// Errors at x = 1/6 … 1, in `unit_mm`. The paper's table is lost: these are the smoothest values, to one decimal,
    /// that give its a and b.
    pub error: Vec<f64>,
    /// Unit of the errors, mm.
    pub unit_mm: f64,
    /// Target of the experiment, mm.
    pub target_mm: f64,
    /// Mean diameter of the compensated group, mm.
    pub compensated_mm: f64,
    /// Mean diameter of the group without compensation, mm.
    pub uncompensated_mm: f64,
}

impl Default for Inputs {
    fn default() -> Self {
        Self {
            error: vec![4.4, 4.6, 4.8, 5.0, 5.1, 5.4],
            unit_mm: 0.01,
            target_mm: 23.2,
            compensated_mm: 23.389,
            uncompensated_mm: 23.432,
        }
    }
}

/// Inputs that no row can be computed from.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct InputError(String);

/// Computes every row.
///
/// # Errors
/// Other than six finite errors, a unit that is not positive, or diameters that are no numbers.
pub fn run(inputs: &Inputs) -> Result<Vec<Row>, InputError> {
    if inputs.error.len() != 6 || inputs.error.iter().any(|e| !e.is_finite()) {
        let text = format!("six finite errors at x = 1/6 to 1 are needed, {} were given", inputs.error.len());
        return Err(InputError(text));
    }
    let lengths = [inputs.unit_mm, inputs.target_mm, inputs.compensated_mm, inputs.uncompensated_mm];
    if lengths.iter().any(|l| !(l.is_finite() && *l > 0.0)) {
        return Err(InputError("unit and diameters must be positive numbers".into()));
    }
    let x: Vec<f64> = (1..=6).map(|i| f64::from(i) / 6.0).collect();
    let line =
        fit_line(&x, &inputs.error).ok_or_else(|| InputError("no line through these errors".into()))?;
    let settings = NcSettings::default();
    let values = program(inputs, line, &settings).values();
    let mut rows = data_rows(inputs);
    rows.extend(fit_rows(inputs, &x, &line));
    rows.extend(macro_rows(inputs, &values));
    rows.extend(experiment_rows(inputs, &line));
    Ok(rows)
}

fn program<'a>(inputs: &Inputs, line: LineFit, settings: &'a NcSettings) -> MacroProgram<'a> {
    MacroProgram {
        line,
        unit_mm: inputs.unit_mm,
        diameter_mm: (inputs.target_mm, inputs.target_mm),
        piece: Workpiece::new(1.0, inputs.target_mm, inputs.target_mm),
        pass: 1,
        cutting: CuttingData { speed_m_per_min: 1.0, feed_mm_per_rev: 0.1 },
        limits_mm: None,
        settings,
    }
}

fn data_rows(inputs: &Inputs) -> Vec<Row> {
    let sum: f64 = inputs.error.iter().sum();
    let moment: f64 = (1..=6).zip(&inputs.error).map(|(i, e)| f64::from(2 * i - 7) * e).sum();
    let why =
        "table 1 is missing from the text: the printed a and b fix this sum, the errors are reconstructed";
    // x = i/6: x̄ = 7/12, x − x̄ = (2i − 7)/12, Σ(x − x̄)² = 35/72, so Σε = 6(a + b·7/12) and Σ(2i − 7)ε = b·35/6
    let (b, a) = (1.14857, 4.21333);
    let (from_a, from_b) = (6.0 * (a + b * 7.0 / 12.0), b * 35.0 / 6.0);
    vec![
        Row::within(("table1.sum", "sum of the errors", ".01 mm"), from_a, sum, 1e-5, why).by_assumption(),
        Row::within(("table1.moment", "sum of (2i − 7) ε", ".01 mm"), from_b, moment, 1e-5, why)
            .by_assumption(),
    ]
}

fn fit_rows(inputs: &Inputs, x: &[f64], line: &LineFit) -> Vec<Row> {
    let design = nalgebra::DMatrix::from_fn(6, 2, |i, j| if j == 0 { 1.0 } else { x[i] });
    let y = nalgebra::DVector::from_column_slice(&inputs.error);
    let one = nalgebra::DVector::from_element(6, 1.0);
    let again = fit::weighted(&design, &y, &one);
    let apart = again
        .as_ref()
        .map_or(f64::NAN, |f| (f.coefficients[0] - line.a).abs().max((f.coefficients[1] - line.b).abs()));
    let parabola = nalgebra::DMatrix::from_fn(6, 3, |i, j| x[i].powi(j as i32));
    let bend = fit::weighted(&parabola, &y, &one).map_or(f64::NAN, |f| f.coefficients[2]);
    let spread = again.map_or(f64::NAN, |f| (f.residuals.norm_squared() / 4.0).sqrt());
    let six = "six significant digits are printed";
    vec![
        Row::within(("eq5.b", "slope b of the error line", ".01 mm"), 1.14857, line.b, 5e-6, six),
        Row::within(("eq6.a", "intercept a of the error line", ".01 mm"), 4.21333, line.a, 5e-6, six),
        Row::identity(
            ("eq4.independent", "eqs 5-6 less a singular-value solution", ".01 mm"),
            apart,
            1e-12,
            "two ways to the same line",
        ),
        Row::judged(
            ("eq4.residual", "standard deviation about the line", ".01 mm"),
            None,
            spread,
            Verdict::Consistent,
            "with the reconstructed errors",
        ),
        Row::judged(
            ("eq4.quadratic", "coefficient of x² in a parabola, said to be very small", ".01 mm"),
            None,
            bend,
            if bend.abs() < 0.1 * line.b.abs() { Verdict::Reproduced } else { Verdict::Contradiction },
            "less than a tenth of b: the line is enough",
        ),
    ]
}

fn macro_rows(inputs: &Inputs, v: &MacroValues) -> Vec<Row> {
    let (a, b) = (4.21333, 1.14857);
    let digits = "from the a and b printed";
    let target = inputs.target_mm;
    // as printed: 7 and 8 run before 9 and 10 have filled #804 and #805, which are empty at the first run
    let printed_first = 0.0;
    vec![
        Row::within(
            ("eq9.804", "#804, compensation at the start", ".01 mm"),
            b / 6.0 + a,
            v.v804,
            5e-6,
            digits,
        ),
        Row::within(("eq10.805", "#805, compensation at the end", ".01 mm"), b + a, v.v805, 5e-6, digits),
        Row::judged(
            ("eq7.800", "diameter cut at the start (#800 less #804)", "mm"),
            None,
            v.v810,
            Verdict::Reproduced,
            "evaluated in the order 9, 10, 7, 8 into a fresh variable",
        ),
        Row::judged(
            ("eq8.801", "diameter cut at the end (#801 less #805)", "mm"),
            None,
            v.v811,
            Verdict::Reproduced,
            "evaluated in the order 9, 10, 7, 8 into a fresh variable",
        ),
        Row::judged(
            ("eq7-10.order", "compensation at the start in the printed order", "mm"),
            Some(v.v804 * inputs.unit_mm),
            printed_first,
            Verdict::Contradiction,
            "7 and 8 are printed before 9 and 10, whose results they need: the first run compensates nothing",
        ),
        Row::judged(
            ("eq7.again", "diameter at the start after the program ran twice", "mm"),
            Some(v.v810),
            target - 2.0 * v.v804 * inputs.unit_mm,
            Verdict::Contradiction,
            "#800 = #800 − #804 compensates again at every run; fresh variables and a used-once flag do not",
        ),
    ]
}

fn experiment_rows(inputs: &Inputs, line: &LineFit) -> Vec<Row> {
    let i = inputs;
    let observed = i.uncompensated_mm - i.compensated_mm;
    // mean of the line over the part, x from 1/6 to 1
    let corrected = (line.a + line.b * (1.0 / 6.0 + 1.0) / 2.0) * i.unit_mm;
    let reduced = 100.0 * observed / (i.uncompensated_mm - i.target_mm);
    let gain = observed / corrected;
    vec![
        Row::judged(
            ("experiment.change", "change of the mean diameter by compensation", "mm"),
            Some(observed),
            corrected,
            if (0.7..=1.1).contains(&gain) { Verdict::Consistent } else { Verdict::Contradiction },
            "the mean correction against the observed change of the means; the unit .01 mm is ours, none is printed",
        ),
        Row::judged(
            ("experiment.gain", "observed over commanded change (plant gain)", ""),
            None,
            gain,
            if (0.6..=1.2).contains(&gain) { Verdict::Consistent } else { Verdict::Contradiction },
            "between .6 and 1.2 a correction has reached the right place with the right sign",
        ),
        Row::judged(
            ("experiment.reduction", "reduction of the limit error", "%"),
            Some(52.5),
            reduced,
            if (reduced - 52.5).abs() < 1.0 { Verdict::Reproduced } else { Verdict::Contradiction },
            "from the printed means and target; the printed 52.5 % does not follow from them",
        ),
        Row::judged(
            ("experiment.left", "mean error left after compensation", "mm"),
            None,
            i.compensated_mm - i.target_mm,
            Verdict::Contradiction,
            "four times the whole correction: \"within the allowable range\" needs a tolerance that is not given",
        ),
    ]
}
