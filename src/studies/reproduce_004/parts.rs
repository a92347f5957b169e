//! Table 4: readings of the four workpieces, their means and the reductions of the error.

use super::inputs::{Inputs, MICROMETRE_MM, PrintedPart, ROUNDING_MM};
use crate::numerics::distributions::student;
use crate::studies::reproduction::{Accept, Row};

/// What is measured of each workpiece.
pub(super) const MEASURED: [&str; 4] = [
    "length of the cylinder behind the cone",
    "large diameter of the cone",
    "radius of the arc",
    "diameter of the cylinder",
];
/// Last digit of the printed rates, %: they are rounded or cut off.
pub(super) const RATE_PERCENT: f64 = 0.1;

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    let mut rows: Vec<Row> = inputs.parts.iter().enumerate().flat_map(|(k, part)| of_part(k, part)).collect();
    let largest = |of: fn(&PrintedPart) -> f64| inputs.parts.iter().map(of).fold(0.0, f64::max);
    rows.push(Row::printed(
        ("rate.largest", "largest of the four rates (abstract)", "%"),
        Some(79.2),
        largest(|p| p.rate_percent),
        Accept::Absolute(1e-9),
        "of the rates in Table 4; of the readings themselves the largest is 81.05 %",
    ));
    rows
}

fn of_part(k: usize, part: &PrintedPart) -> Vec<Row> {
    let (number, what) = (k + 1, MEASURED[k]);
    let mean = |state: &str, readings: &[f64; 4], paper: f64| {
        let names =
            (format!("part{number}.{state}"), format!("mean error of the {what}, {state} compensation"));
        Row::printed(
            (&names.0, &names.1, "mm"),
            Some(paper),
            PrintedPart::mean_mm(readings),
            Accept::Absolute(MICROMETRE_MM + ROUNDING_MM),
            "mean of the four readings in Table 4, rounded to a micrometre",
        )
    };
    let id = |name: &str| format!("part{number}.{name}");
    let (raw, printed) = (part.raw_percent(), part.printed_means_percent());
    let near =
        if (raw - part.rate_percent).abs() < (printed - part.rate_percent).abs() { raw } else { printed };
    vec![
        mean("before", &part.before_mm, part.mean_before_mm),
        mean("after", &part.after_mm, part.mean_after_mm),
        Row::printed(
            (&id("rate"), "reduction of the mean error", "%"),
            Some(part.rate_percent),
            near,
            Accept::Absolute(RATE_PERCENT),
            format!("of the raw readings {raw:.2} %, of the printed means {printed:.2} %: the nearer one"),
        ),
        Row::ours(
            (&id("rate.raw"), "reduction of the mean of the raw readings", "%"),
            raw,
            "(before − after)/before",
        ),
        Row::ours((&id("rate.means"), "reduction of the printed means", "%"), printed, "the same"),
        Row::ours(
            (&id("rate.U"), "expanded uncertainty of the reduction, 95 %", "%"),
            // each mean has 3 degrees of freedom
            student(3.0, 0.95) * part.u_percent(),
            "scatter of four parts before and four after, as a ratio of means, Student's t of 3 degrees of freedom",
        ),
    ]
}
