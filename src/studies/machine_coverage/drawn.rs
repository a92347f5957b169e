//! A machine of a class: the errors that are sought as waves of drawn lengths, sizes and phases, by
//! the conventions of ISO 230-1.

use std::f64::consts::TAU;

use rand::{RngExt as _, SeedableRng as _};
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;

use crate::identification::IdentificationConfig;
use crate::machine::error_name::Component;
use crate::machine::table_file::Columns;
use crate::machine::{Axis, ErrorName, MachineSettings};
use crate::setting::SettingError;

/// Stream of the draws.
const STREAM: u64 = 0x6d61_6368_696e_6573;
/// Waves of an error, of amplitudes that fall as 1, 1/2, 1/3.
const WAVES: usize = 3;
/// Wavelengths over the travel: a fifth of it is as short as ten readings a wave of acceptance
/// tests hold, twice of it is a bow.
const WAVELENGTH: [f64; 2] = [0.2, 2.0];
/// Decades below the class (its prior) between which a machine's errors lie.
const DECADES_BELOW: [f64; 2] = [0.5, 2.0];
/// Reversal, by the size of the error.
const REVERSAL: f64 = 0.3;
/// Intervals of the table: a line across one leaves 2 ppm of a wave's height.
const INTERVALS: usize = 400;

/// A machine with the geometry of a config and drawn errors.
///
/// # Errors
/// As [`IdentificationConfig::check`].
pub(super) fn machine(config: &IdentificationConfig, seed: u64) -> Result<MachineSettings, SettingError> {
    let mut machine = config.machine.clone();
    let mut random = Pcg64::seed_from_u64(seed ^ STREAM);
    for name in config.check()? {
        let size = if name.is_length() { config.prior.length_um } else { config.prior.angle_urad };
        if matches!(name.component(), Component::Orientation(_)) {
            let urad = size * normal(&mut random);
            match name {
                ErrorName::B0x => machine.b0x_urad = urad,
                ErrorName::A0c => machine.a0c_urad = urad,
                _ => machine.b0c_urad = urad,
            }
            continue;
        }
        let travel = if name.axis() == Axis::X { machine.x_travel_mm } else { machine.z_travel_mm };
        machine.errors.all_mut()[name as usize].fill(columns(name, travel, size, &mut random));
    }
    Ok(machine)
}

fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}

fn columns(name: ErrorName, [from, to]: [f64; 2], class: f64, random: &mut Pcg64) -> Columns {
    let [most, least] = DECADES_BELOW;
    let size = class * 10.0_f64.powf(-random.random_range(most..least));
    let waves: [[f64; 3]; WAVES] = std::array::from_fn(|k| {
        let [short, long] = WAVELENGTH.map(f64::ln);
        let length = (to - from) * random.random_range(short..long).exp();
        [length, size * normal(random) / (1.0 + k as f64), random.random_range(0.0..TAU)]
    });
    let at = |k: usize| from + (to - from) * k as f64 / INTERVALS as f64;
    let position: Vec<f64> = (0..=INTERVALS).map(at).collect();
    let wave =
        |p: f64| -> f64 { waves.iter().map(|[length, a, phase]| a * (TAU * p / length + phase).cos()).sum() };
    let mut forward: Vec<f64> = position.iter().map(|p| wave(*p)).collect();
    let own = if name.axis() == Axis::X { 0 } else { 2 };
    if matches!(name.component(), Component::Along(k) if k != own) {
        less_its_line(&mut forward);
    }
    let reversal = REVERSAL * size * normal(random);
    let backward = forward.iter().map(|v| v - reversal).collect();
    Columns { position, forward, backward }
}

/// Takes the line of least squares out of values at even places: a straightness has neither offset
/// nor slope.
fn less_its_line(values: &mut [f64]) {
    let middle = 0.5 * (values.len() as f64 - 1.0);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (mut product, mut square) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let s = k as f64 - middle;
        (product, square) = (product + s * value, square + s * s);
    }
    let slope = product / square;
    values.iter_mut().enumerate().for_each(|(k, value)| *value -= mean + slope * (k as f64 - middle));
}

#[cfg(test)]
mod tests {
    use super::less_its_line;

    #[test]
    fn a_line_leaves_nothing_and_a_bow_its_own() {
        let mut line: Vec<f64> = (0..51).map(|k| 2.0 - 0.3 * f64::from(k)).collect();
        less_its_line(&mut line);
        assert!(line.iter().all(|v| v.abs() < 1e-12));
        let bow: Vec<f64> = (0..51).map(|k| (f64::from(k) - 25.0).powi(2)).collect();
        let mut own = bow.clone();
        less_its_line(&mut own);
        // of s² with s from −25 to 25 the mean, 25·26/3
        assert!(own.iter().zip(&bow).all(|(o, b)| (b - o - 650.0 / 3.0).abs() < 1e-9));
    }
}
