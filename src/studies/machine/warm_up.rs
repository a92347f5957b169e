//! The diameter that is cut while the machine warms up (ISO 230-3).

use serde::Serialize;

use super::prepared::Prepared;
use crate::machine::response::{Part, cut_mm};
use crate::machine::{Chain, Conditions, ErrorName};

/// Points over the time.
const POINTS: u32 = 60;
/// Time shown, in the longest time constant: 1 - e⁻⁴ = 98 % of the drift.
const TIME_CONSTANTS: f64 = 4.0;

/// The diameter at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct WarmUpPoint {
    /// Time since the cold start, min.
    pub minutes: f64,
    /// Deviation of the diameter cut in the middle of the part, µm.
    pub cut_um: f64,
    /// Displacement of the tool along Z there, µm.
    pub e_z_um: f64,
}

/// The deviations over time in the middle of the part; none where nothing warms up.
pub(crate) fn warm_up(machine: &Prepared, part: &Part) -> Vec<WarmUpPoint> {
    let drifts = ErrorName::ALL.iter().filter_map(|name| machine.motion.function(*name)).map(|f| f.drift);
    let longest = drifts.filter(|d| d.warm_up != 0.0).map(|d| d.time_constant_min).fold(0.0, f64::max);
    if longest == 0.0 {
        return Vec::new();
    }
    let settings = &machine.settings;
    let [from, to] = settings.z_travel_mm;
    let station = settings.tool(0.5 * part.diameter_mm, 0.5 * (from + to));
    let at = |k: u32| {
        let minutes = TIME_CONSTANTS * longest * f64::from(k) / f64::from(POINTS);
        let state = Conditions { minutes, ..machine.state };
        let values = machine.motion.values(station.x_mm, station.z_mm, &state);
        let pose = Chain { topology: settings.chain, values }.pose(&station);
        WarmUpPoint {
            minutes,
            cut_um: 1e3 * cut_mm(part, settings.tip_above_axis_mm, &pose),
            e_z_um: 1e3 * pose.shift_mm.z,
        }
    };
    (0..=POINTS).map(at).collect()
}
