//! Tables 2 and 3: whether the lathe's figures agree among themselves and with the bars that are
//! turned.

use super::inputs::Inputs;
use crate::studies::reproduction::{Accept, Row};

/// Swing, largest length and largest diameter that it cuts, mm.
const SWING_MM: f64 = 560.0;
const LENGTH_MM: f64 = 500.0;
const DIAMETER_MM: f64 = 360.0;
/// Bore of the spindle and largest bar, mm.
const BORE_MM: f64 = 65.0;
const BAR_MM: f64 = 50.0;
/// Travels along X and Z, mm.
const TRAVEL_MM: [f64; 2] = [200.0, 560.0];
/// Stroke of the tailstock, mm.
const TAILSTOCK_MM: f64 = 450.0;
/// Height and width of a tool's shank, mm.
const SHANK_MM: f64 = 25.0;
/// Least and largest speed of the spindle, 1/min.
const SPEED_PER_MIN: [f64; 2] = [50.0, 4500.0];
/// Positioning accuracy and repeatability along X and Z (Table 3), mm.
const POSITIONING_MM: [f64; 2] = [0.008, 0.008];
/// Diameter of the bars that are turned, and of part 4, mm (section 4).
const TURNED_MM: f64 = 32.0;
const PART_4_MM: f64 = 30.0;

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    [table_2(), more_of_table_2(), table_3(inputs)].concat()
}

/// What the tailstock, the shank and the spindle allow.
fn more_of_table_2() -> Vec<Row> {
    let [slow, fast] = SPEED_PER_MIN.map(|n| 1e-3 * std::f64::consts::PI * TURNED_MM * n);
    vec![
        Row::printed(
            ("table2.tailstock", "stroke of the tailstock less the largest length", "mm"),
            None,
            TAILSTOCK_MM - LENGTH_MM,
            Accept::Range(f64::NEG_INFINITY, 0.0),
            "more than the longest part needs would be of no use",
        ),
        Row::ours(
            ("table2.shank", "second moment of area of the shank", "mm⁴"),
            SHANK_MM.powi(4) / 12.0,
            "25 × 25 mm; the paper gives no overhang, so that no deflection follows",
        ),
        Row::ours(
            ("table2.speed.least", "least cutting speed on the bars", "m/min"),
            slow,
            "π·32 mm at 50/min; the paper gives neither speed nor feed",
        ),
        Row::ours(
            ("table2.speed.most", "largest cutting speed on the bars", "m/min"),
            fast,
            "π·32 mm at 4500/min",
        ),
    ]
}

/// Repeatability is a part of the accuracy of positioning (ISO 230-2).
fn table_3(inputs: &Inputs) -> Vec<Row> {
    let row = |k: usize, axis: &str| {
        Row::printed(
            (
                &format!("table3.{}", axis.to_lowercase()),
                &format!("positioning accuracy less repeatability along {axis}"),
                "mm",
            ),
            None,
            POSITIONING_MM[k] - inputs.repeatability_mm[k],
            Accept::Range(0.0, f64::INFINITY),
            "accuracy holds the repeatability and the deviation of the mean",
        )
    };
    vec![row(0, "X"), row(1, "Z")]
}

fn table_2() -> Vec<Row> {
    let at_least = |names: (&str, &str, &str), ours: f64, least: f64, why: &str| {
        Row::printed(names, None, ours, Accept::Range(least, f64::INFINITY), why)
    };
    vec![
        at_least(
            ("table2.swing", "swing over the bed less the largest diameter", "mm"),
            SWING_MM - DIAMETER_MM,
            0.0,
            "what is cut must turn",
        ),
        at_least(
            ("table2.x", "travel along X less the largest radius", "mm"),
            TRAVEL_MM[0] - 0.5 * DIAMETER_MM,
            0.0,
            "the tool must reach from the axis to the largest diameter",
        ),
        at_least(
            ("table2.z", "travel along Z less the largest length", "mm"),
            TRAVEL_MM[1] - LENGTH_MM,
            0.0,
            "the tool must reach along the longest part",
        ),
        at_least(
            ("table2.bore", "bore of the spindle less the largest bar", "mm"),
            BORE_MM - BAR_MM,
            0.0,
            "a bar must pass",
        ),
        at_least(
            ("table2.bar", "largest bar less the bars turned", "mm"),
            BAR_MM - TURNED_MM,
            0.0,
            "Ø32 of 6061-T6",
        ),
        at_least(
            ("table2.depth", "what is turned off the bars for part 4, on the radius", "mm"),
            0.5 * (TURNED_MM - PART_4_MM),
            0.0,
            "Ø30 from Ø32",
        ),
    ]
}
