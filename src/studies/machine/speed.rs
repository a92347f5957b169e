//! How many positions a second one thread computes e(x, z) at, by the exact chain from tables.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use super::config::MachineStudyConfig;
use super::prepared::Prepared;
use crate::machine::settings::Errors;
use crate::machine::table_file::Columns;
use crate::machine::{Axis, Chain, Conditions, ErrorName, MachineSettings};
use crate::setting::{SettingError, require};

/// Positions of a table, as `machine.json` has them.
const TABLE_POSITIONS: usize = 241;
/// Angles of a table of the spindle.
const TABLE_ANGLES: usize = 360;
/// Most rounds: a second each at least on a raster of 1001 by 1001.
const MOST_ROUNDS: u32 = 10_000;

/// The speed of e(x, z).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Speed {
    /// Positions of a round: the map's.
    pub points: usize,
    /// Rounds.
    pub rounds: u32,
    /// Points a second of the fastest round: what other programs take only slows rounds down.
    pub points_per_s_max: f64,
    /// Of the median round.
    pub points_per_s_median: f64,
}

impl MachineStudyConfig {
    /// Times e(x, z) over the map, a number of rounds, all 18 errors of motion as tables.
    ///
    /// # Errors
    /// As [`Self::run`]; no round.
    pub(crate) fn speed(&self, rounds: u32) -> Result<Speed, SettingError> {
        require((1..=MOST_ROUNDS).contains(&rounds), "--bench", rounds, "between 1 and 10000")?;
        let machine = Prepared::of(self)?;
        let settings = tabulated(&machine);
        let motion = settings.motion()?;
        let state = machine.state;
        let mut seconds: Vec<f64> = Vec::new();
        for _ in 0..rounds {
            let start = Instant::now();
            for x in &machine.x_mm {
                for z in &machine.z_mm {
                    let values = motion.values(*x, *z, &state);
                    let chain = Chain { topology: settings.chain, values };
                    black_box(chain.pose(black_box(&settings.tool(*x, *z))).shift_mm);
                }
            }
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        let points = machine.x_mm.len() * machine.z_mm.len();
        let per_s = |k: usize| points as f64 / seconds[k].max(f64::MIN_POSITIVE);
        Ok(Speed {
            points,
            rounds,
            points_per_s_max: per_s(0),
            points_per_s_median: per_s(seconds.len() / 2),
        })
    }
}

/// The machine with all its errors of motion as tables of what lasts of them.
fn tabulated(machine: &Prepared) -> MachineSettings {
    let mut settings = MachineSettings { errors: Errors::default(), ..machine.settings.clone() };
    for name in ErrorName::ALL.into_iter().take(machine.motion.functions.len()) {
        let unit = if name.is_length() { 1e3 } else { 1e6 };
        let even = |[from, to]: [f64; 2], count: usize| -> Vec<f64> {
            (0..=count).map(|k| from + (to - from) * k as f64 / count as f64).collect()
        };
        let position = match name.axis() {
            Axis::X => even(machine.settings.x_travel_mm, TABLE_POSITIONS - 1),
            Axis::Z => even(machine.settings.z_travel_mm, TABLE_POSITIONS - 1),
            Axis::C => (0..TABLE_ANGLES).map(|k| 360.0 * k as f64 / TABLE_ANGLES as f64).collect(),
        };
        let value = |p: &f64| {
            let state = Conditions { c_deg: *p, ..Conditions::default() };
            unit * machine.motion.value(name, [*p, *p], &state)
        };
        let columns =
            Columns { forward: position.iter().map(value).collect(), position, backward: Vec::new() };
        settings.errors.all_mut()[name as usize].fill(columns);
    }
    settings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_the_machine_and_rounds_are_counted() {
        let text = include_str!("../../../configs/machine_001.toml");
        let config: MachineStudyConfig = toml::from_str(text).unwrap();
        let machine = Prepared::of(&config).unwrap();
        let tables = tabulated(&machine).motion().unwrap();
        let state = Conditions { c_deg: 30.0, ..Conditions::default() };
        for name in ErrorName::ALL {
            let at = |motion: &crate::machine::Motion| motion.value(name, [37.0, 61.0], &state);
            // a line across 0.6 mm of a wave of 25 mm leaves 0.3 % of it
            let (own, right) = (at(&tables), at(&machine.motion));
            assert!((own - right).abs() <= 5e-3 * right.abs() + 1e-9, "{name:?}: {own}, not {right}");
        }
        let speed = config.speed(2).unwrap();
        assert_eq!((speed.points, speed.rounds), (51 * 51, 2));
        assert!(speed.points_per_s_max >= speed.points_per_s_median && speed.points_per_s_median > 0.0);
        assert!(config.speed(0).unwrap_err().to_string().contains("--bench"));
    }
}
