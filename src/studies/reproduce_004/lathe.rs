//! Table 2: whether the lathe's figures agree among themselves and with the bars that are turned.

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
/// Diameter of the bars that are turned, and of part 4, mm (section 4).
const TURNED_MM: f64 = 32.0;
const PART_4_MM: f64 = 30.0;

pub(super) fn rows() -> Vec<Row> {
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
