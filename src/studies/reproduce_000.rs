//! Paper 000: least-squares compensation of a single shaft through macro variables.

pub(crate) mod experiment;

use super::reproduction::{Accept, Row};
use crate::control::fit;
use crate::nc::{LineFit, MacroProgram, MacroValues, NcSettings, Workpiece, fit_line};
use crate::plan::CuttingData;

/// Inputs of the paper's rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Inputs {
    /// Errors at x = 1/6 … 1, in `unit_mm`. The paper's table is lost: these are the smoothest
    /// values, to one decimal, that give its a and b.
    pub error: Vec<f64>,
    /// Unit of the errors, mm.
    pub unit_mm: f64,
    /// Target of the experiment, mm.
    pub target_mm: f64,
    /// Mean diameter of the compensated group, mm.
    pub compensated_mm: f64,
    /// Mean diameter of the group without compensation, mm.
    pub uncompensated_mm: f64,
    /// b as printed, in `unit_mm`.
    pub slope: f64,
    /// a as printed, in `unit_mm`.
    pub intercept: f64,
    /// Reduction of the limit error as printed, %.
    pub reduction_percent: f64,
    /// Limit errors without and with compensation, mm: Fig. 2's data, which are lost.
    pub limit_error_mm: Option<[f64; 2]>,
    /// Tolerance on the diameter on either side of the target, mm; not printed.
    pub tolerance_mm: Option<f64>,
    /// Whether the errors are Table 1's own; they are lost.
    pub table_1: bool,
}

impl Default for Inputs {
    fn default() -> Self {
        Self {
            error: vec![4.4, 4.6, 4.8, 5.0, 5.1, 5.4],
            unit_mm: 0.01,
            target_mm: 23.2,
            compensated_mm: 23.389,
            uncompensated_mm: 23.432,
            slope: 1.14857,
            intercept: 4.21333,
            reduction_percent: 52.5,
            limit_error_mm: None,
            tolerance_mm: None,
            table_1: false,
        }
    }
}

/// Inputs that no row can be computed from.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct InputError(String);

/// Six significant digits are printed.
const DIGITS: f64 = 5e-6;
/// Agreement required of the change of the mean diameter, relative: the groups' numbers of parts
/// and their scatter are not printed; means of five parts within 10 µm differ by as much.
pub(crate) const CHANGE: f64 = 0.20;

/// The error line through the inputs' errors.
///
/// # Errors
/// Other than six finite errors, a unit that is not positive, or diameters that are not finite.
pub(crate) fn line(inputs: &Inputs) -> Result<LineFit, InputError> {
    if inputs.error.len() != 6 || inputs.error.iter().any(|e| !e.is_finite()) {
        let text = format!("six finite errors at x = 1/6 to 1 are needed, {} were given", inputs.error.len());
        return Err(InputError(text));
    }
    let lengths = [inputs.unit_mm, inputs.target_mm, inputs.compensated_mm, inputs.uncompensated_mm];
    if lengths.iter().any(|l| !(l.is_finite() && *l > 0.0)) {
        return Err(InputError("unit and diameters must be positive numbers".into()));
    }
    fit_line(&positions(), &inputs.error).ok_or_else(|| InputError("no line through these errors".into()))
}

/// x = 1/6 … 1.
fn positions() -> Vec<f64> {
    (1..=6).map(|i| f64::from(i) / 6.0).collect()
}

/// Computes every row except those of the experiment through frames ([`experiment`]).
///
/// # Errors
/// As [`line()`].
pub(crate) fn run(inputs: &Inputs) -> Result<Vec<Row>, InputError> {
    let line = line(inputs)?;
    let x = positions();
    let settings = NcSettings::default();
    let values = program(inputs, line, &settings).values();
    let mut rows = data_rows(inputs);
    rows.extend(definition_rows(inputs));
    rows.extend(fit_rows(inputs, &x, &line));
    rows.extend(newton_rows(inputs, &x, &line));
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
    // x = i/6: x̄ = 7/12, x − x̄ = (2i − 7)/12, Σ(x − x̄)² = 35/72, so Σε = 6(a + b·7/12) and Σ(2i
    // − 7)ε = b·35/6
    let (b, a) = (inputs.slope, inputs.intercept);
    let (from_a, from_b) = (6.0 * (a + b * 7.0 / 12.0), b * 35.0 / 6.0);
    let row = |names: (&str, &str, &str), paper: f64, ours: f64| {
        Row::in_sample(names, Some(paper), ours, Accept::Relative(1e-5), why)
    };
    vec![
        row(("table1.sum", "sum of the errors", ".01 mm"), from_a, sum),
        row(("table1.moment", "sum of (2i − 7) ε", ".01 mm"), from_b, moment),
    ]
}

/// Equation 1: the distance of the measured from the ideal point.
fn distance(measured: [f64; 3], ideal: [f64; 3]) -> f64 {
    measured.iter().zip(ideal).map(|(m, s)| (m - s).powi(2)).sum::<f64>().sqrt()
}

/// Equations 1 to 3 at the six points, the part along z and the probe in the plane y = 0.
fn definition_rows(inputs: &Inputs) -> Vec<Row> {
    let radius = 0.5 * inputs.target_mm;
    let point = |x: f64| [x, 0.0, 10.0];
    let largest = |of: &dyn Fn(f64) -> f64| {
        inputs.error.iter().map(|e| inputs.unit_mm * e).map(of).map(f64::abs).fold(0.0, f64::max)
    };
    // Rounding error of the coordinates, mm.
    let rounding = 1e-12;
    let at = |e: f64| distance(point(radius + e), point(radius));
    vec![
        Row::identity(
            ("eq1", "eq. 1 less |x_m − x_s| with y and z of the ideal point, largest of six", "mm"),
            largest(&|e| at(e) - e.abs()),
            rounding,
            "the distance in space is the radial one where y and z agree",
        ),
        Row::identity(
            ("eq2", "eq. 2 less eq. 3, largest of six", "mm"),
            largest(&|e| at(e) - e),
            rounding,
            "the root is the signed difference for errors above zero, as all of the table's are",
        ),
        Row::identity(
            ("eq3", "eq. 3: sign of x_m − x_s less the sign that the text gives it, largest of six", ""),
            largest(&|e| (radius + e - radius).signum() - e.signum()),
            rounding,
            "positive where the part is too large",
        ),
        Row::ours(
            (
                "eq2.negative",
                "eq. 2's root less eq. 3 for a part that is too small by as much, largest of six",
                "mm",
            ),
            largest(&|e| at(-e) + e),
            "the root of eq. 2 is never negative: only eq. 3 can be used on either side of zero",
        ),
        Row::ours(
            (
                "eq1.z",
                "eq. 1 less eq. 3 with an error along z as large as the radial one, largest of six",
                "mm",
            ),
            largest(&|e| distance([radius + e, 0.0, 10.0 + e], point(radius)) - e),
            "eq. 1 needs the neglect of z that the text states, eq. 3 does not",
        ),
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
    let six = "six significant digits are printed; the errors are reconstructed from them";
    let (b, a) = (Some(inputs.slope), Some(inputs.intercept));
    vec![
        Row::in_sample(
            ("eq5.b", "slope b of the error line", ".01 mm"),
            b,
            line.b,
            Accept::Relative(DIGITS),
            six,
        ),
        Row::in_sample(
            ("eq6.a", "intercept a of the error line", ".01 mm"),
            a,
            line.a,
            Accept::Relative(DIGITS),
            six,
        ),
        Row::identity(
            ("eq4.independent", "eqs 5-6 less a singular-value solution", ".01 mm"),
            apart,
            1e-12,
            "two ways to the same line",
        ),
        Row::ours(
            ("eq4.residual", "standard deviation about the line", ".01 mm"),
            spread,
            "with the reconstructed errors",
        ),
        Row::ours(
            ("eq4.parabola", "coefficient of x² in a least-squares parabola", ".01 mm"),
            bend,
            "with the reconstructed errors",
        ),
    ]
}

/// Newton's divided differences: the coefficients of his interpolation polynomial, order by order.
fn divided_differences(x: &[f64], y: &[f64]) -> Vec<f64> {
    let mut column = y.to_vec();
    let mut coefficients = vec![];
    for order in 0..x.len() {
        coefficients.push(column[0]);
        column =
            column.windows(2).enumerate().map(|(i, w)| (w[1] - w[0]) / (x[i + order + 1] - x[i])).collect();
    }
    coefficients
}

/// "If the quadratic Newton polynomial is used …, the high order coefficient is very small."
fn newton_rows(inputs: &Inputs, x: &[f64], line: &LineFit) -> Vec<Row> {
    let through = |nodes: &[usize]| {
        let pick = |values: &[f64]| nodes.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        divided_differences(&pick(x), &pick(&inputs.error))
    };
    let quadratic = through(&[0, 2, 5]);
    let others = [1, 3, 4].map(|middle| through(&[0, middle, 5])[2]);
    let all = through(&[0, 1, 2, 3, 4, 5]);
    let largest = all[2..].iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let small = 0.1 * line.b.abs();
    vec![
        Row::predicted(
            ("eq4.quadratic", "second divided difference of Newton's polynomial through x = 1/6, 1/2, 1, very small", ".01 mm"),
            None,
            quadratic[2],
            Accept::Range(-small, small),
            format!(
                "less than a tenth of b with the reconstructed errors; through 1/3, 2/3 or 5/6 in the middle {:.3}, {:.3}, {:.3}",
                others[0], others[1], others[2]
            ),
        )
        .needs(&[("the errors of Table 1", inputs.table_1)]),
        Row::ours(
            ("eq4.newton", "largest coefficient of order 2 to 5 of Newton's polynomial through all six points", ".01 mm"),
            largest,
            "high orders answer to the last digit of the errors: the line is the better model, as the paper says",
        ),
    ]
}

fn macro_rows(inputs: &Inputs, v: &MacroValues) -> Vec<Row> {
    let (a, b) = (inputs.intercept, inputs.slope);
    let digits = "from the a and b printed";
    let start = b / 6.0 + a;
    let taken_off = |order: &[u32], runs: usize| compensation_at_start(inputs, order, runs);
    let row = |names: (&str, &str, &str), paper: f64, ours: f64| {
        Row::in_sample(names, Some(paper), ours, Accept::Relative(DIGITS), digits)
    };
    let order = "evaluated in the order 9, 10, 7, 8 into a fresh variable";
    vec![
        row(("eq9.804", "#804, compensation at the start", ".01 mm"), start, v.v804),
        row(("eq10.805", "#805, compensation at the end", ".01 mm"), b + a, v.v805),
        Row::ours(("eq7.800", "diameter cut at the start (#800 less #804)", "mm"), v.v810, order),
        Row::ours(("eq8.801", "diameter cut at the end (#801 less #805)", "mm"), v.v811, order),
        Row::printed(
            ("eq7-10.order", "compensation at the start in the printed order", ".01 mm"),
            Some(start),
            taken_off(&[7, 8, 9, 10], 1),
            Accept::Relative(DIGITS),
            "7 and 8 are printed before 9 and 10, whose results they need: the first run compensates nothing",
        ),
        Row::printed(
            ("eq7.again", "compensation at the start after the program ran twice", ".01 mm"),
            Some(start),
            taken_off(&[9, 10, 7, 8], 2),
            Accept::Relative(DIGITS),
            "#800 = #800 − #804 compensates again at every run; fresh variables and a used-once flag do not",
        ),
    ]
}

/// Equations 7 to 10 as printed, each into the variable that it names, in `order` and `runs` times:
/// the final correction of the diameter at the start, in the unit of the errors. An unset variable
/// counts as 0.
fn compensation_at_start(inputs: &Inputs, order: &[u32], runs: usize) -> f64 {
    // #800 to #805; the first two less the target diameter, in that unit.
    let mut v = [0.0, 0.0, inputs.slope, inputs.intercept, 0.0, 0.0];
    for equation in order.iter().cycle().take(runs * order.len()) {
        match equation {
            7 => v[0] -= v[4],
            8 => v[1] -= v[5],
            9 => v[4] = v[2] / 6.0 + v[3],
            _ => v[5] = v[2] + v[3],
        }
    }
    0.0 - v[0]
}

/// Fig. 2's data, and whether they are given.
fn limit_errors(inputs: &Inputs) -> (&'static str, bool) {
    ("the limit errors of both groups (the data of Fig. 2)", inputs.limit_error_mm.is_some())
}

fn experiment_rows(inputs: &Inputs, line: &LineFit) -> Vec<Row> {
    let i = inputs;
    let observed = i.uncompensated_mm - i.compensated_mm;
    // mean of the line over the part, x from 1/6 to 1
    let corrected = (line.a + line.b * (1.0 / 6.0 + 1.0) / 2.0) * i.unit_mm;
    let of_means = 100.0 * observed / (i.uncompensated_mm - i.target_mm);
    let reduced = i.limit_error_mm.map_or(of_means, |[without, with]| 100.0 * (1.0 - with / without));
    let left = i.compensated_mm - i.target_mm;
    let tolerance = i.tolerance_mm.unwrap_or(f64::NAN);
    vec![
        Row::in_sample(
            ("experiment.change", "change of the mean diameter by compensation", "mm"),
            Some(observed),
            corrected,
            Accept::Relative(CHANGE),
            "the mean correction against the observed change of the means; the unit .01 mm is ours, chosen to agree",
        ),
        Row::ours(
            ("experiment.gain", "observed over commanded change (plant gain)", ""),
            observed / corrected,
            "near 1 a correction has reached the right place with the right sign",
        ),
        Row::printed(
            ("experiment.reduction", "reduction of the limit error", "%"),
            Some(i.reduction_percent),
            reduced,
            Accept::Absolute(1.0),
            format!("of the mean errors the printed means and target give {of_means:.1} %; a limit error is another quantity"),
        )
        .needs(&[limit_errors(i)]),
        Row::printed(
            ("experiment.left", "mean error left after compensation, \"within the allowable range\"", "mm"),
            None,
            left,
            Accept::Range(-tolerance, tolerance),
            format!("{:.1} times the whole correction", left / corrected),
        )
        .needs(&[("the tolerance", i.tolerance_mm.is_some())]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Through points of 2 + 3(x-1) + 5(x-1)(x-2) - 7(x-1)(x-2)(x-4), Newton's coefficients are
    /// these four and no more.
    #[test]
    fn divided_differences_are_newtons_coefficients() {
        let x: [f64; 5] = [1.0, 2.0, 4.0, 4.5, 7.0];
        let f = |x: f64| {
            2.0 + 3.0 * (x - 1.0) + 5.0 * (x - 1.0) * (x - 2.0) - 7.0 * (x - 1.0) * (x - 2.0) * (x - 4.0)
        };
        let found = divided_differences(&x, &x.map(f));
        for (found, expected) in found.iter().zip([2.0, 3.0, 5.0, -7.0, 0.0]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}
