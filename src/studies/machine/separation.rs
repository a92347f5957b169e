//! Which separation of spindle and form would serve this spindle: the part that it turned is read
//! by a probe, reversed, stepped, or chucked again before a head that sees both edges.

use serde::Serialize;

use super::config::MachineStudyConfig;
use super::prepared::Prepared;
use crate::machine::spindle::{Separation, donaldson, multi_step, rechucked};
use crate::machine::{Axis, Chain, Conditions, ErrorName, ErrorValues};

/// Readings a turn; all numbers of steps below divide it.
const READINGS: usize = 360;
/// Numbers of steps.
const STEPS: [usize; 6] = [3, 4, 5, 6, 8, 12];

/// What a method leaves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SeparationRow {
    /// The method.
    pub method: String,
    /// Turns that are read.
    pub turns: usize,
    /// Rms of the motion found less the motion of the axis, µm.
    pub motion_off_um: f64,
    /// Rms of the form found less the form, µm; of a head that sees both edges less its odd part.
    pub form_off_um: f64,
    /// Random error of the motion for one of 1 of the probe (of an edge).
    pub noise: f64,
}

/// The methods, at the middle of the travel of Z; none where the spindle has no error motion there.
pub(crate) fn separations(machine: &Prepared, config: &MachineStudyConfig) -> Vec<SeparationRow> {
    let motion: Vec<f64> = (0..READINGS).map(|i| axis_um(machine, config, i)).collect();
    let mean = motion.iter().sum::<f64>() / READINGS as f64;
    let motion: Vec<f64> = motion.iter().map(|um| um - mean).collect();
    if motion.iter().all(|um| um.abs() < 1e-9) {
        return Vec::new();
    }
    // The tool cuts what the axis leaves it: the form that passes it is the motion's negative.
    let form: Vec<f64> = motion.iter().map(|um| -um).collect();
    let row = |method: String, turns: usize, found: Option<Separation>, form: &[f64], noise: f64| {
        let found = found?;
        let [motion_off_um, form_off_um] = [rms(&found.motion, &motion), rms(&found.form, form)];
        Some(SeparationRow { method, turns, motion_off_um, form_off_um, noise })
    };
    let sum = |form: &[f64], sign: f64| pairwise(form, &motion, |p, s| p + sign * s);
    let reversed = donaldson(&sum(&form, 1.0), &sum(&form, -1.0));
    let mut rows = vec![row("reversal".to_owned(), 2, reversed, &form, 0.5_f64.sqrt())];
    for steps in STEPS {
        let turns: Vec<Vec<f64>> =
            (0..steps).map(|j| sum(&begun(&form, j * READINGS / steps), 1.0)).collect();
        let noise = (1.0 / steps as f64).sqrt();
        rows.push(row(format!("{steps} steps"), steps, multi_step(&turns), &form, noise));
    }
    let odd = pairwise(&form, &begun(&form, READINGS / 2), |upper, lower| 0.5 * (upper - lower));
    let midlines = rechucked(&sum(&odd, 1.0), &pairwise(&odd, &motion, |o, s| s - o));
    rows.push(row("both edges, chucked again".to_owned(), 2, midlines, &odd, 0.5));
    rows.into_iter().flatten().collect()
}

/// Motion of the part's axis towards the tool at a reading, by the errors of the spindle alone, µm.
fn axis_um(machine: &Prepared, config: &MachineStudyConfig, reading: usize) -> f64 {
    let [from, to] = machine.settings.z_travel_mm;
    let c_deg = 360.0 * reading as f64 / READINGS as f64;
    let state = Conditions { c_deg, ..machine.state };
    let station = machine.settings.tool(config.part.radius_mm(), 0.5 * (from + to));
    let all = machine.motion.values(station.x_mm, station.z_mm, &state);
    let mut values = ErrorValues::default();
    for name in ErrorName::ALL.into_iter().filter(|name| name.axis() == Axis::C) {
        values.0[name as usize] = all.of(name);
    }
    -1e3 * Chain { topology: machine.settings.chain, values }.pose(&station).shift_mm.x
}

fn pairwise(a: &[f64], b: &[f64], of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| of(*a, *b)).collect()
}

/// A turn begun some readings later.
fn begun(values: &[f64], by: usize) -> Vec<f64> {
    (0..values.len()).map(|i| values[(i + by) % values.len()]).collect()
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (pairwise(a, b, |a, b| (a - b) * (a - b)).iter().sum::<f64>() / a.len() as f64).sqrt()
}
