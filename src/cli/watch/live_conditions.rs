//! The part's temperature and the gauge's drift at a frame, taken into its measurement.

use serde_json::{Map, Value};

use super::condition_args::ConditionArgs;
use super::thermometer::Thermometer;
use crate::cli::failure::Failure;
use crate::cli::measure::growing_table::GrowingTable;
use crate::cli::measure::temperature_args::{TEMPERATURES, sample, take_scale};
use crate::cli::measure::time_table::{TimeRow, Wanted};
use crate::measurement::watch::{Drift, Zero, Zeros};
use crate::measurement::{ScaleDrift, Stream, TemperatureSample, Temperatures};
use crate::source::live::{Clock, LiveMeta};

/// Columns of the zeros.
const ZEROS: [Wanted; 1] = [Wanted { name: "head_c", is_needed: false }];

/// Where temperatures come from.
enum Origin {
    Table(Box<GrowingTable<4>>),
    Command(Thermometer),
}

/// What of the conditions was taken at a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TakenConditions {
    /// The part's temperature, °C, and the limits of its error, ± K.
    part: Option<(f64, f64)>,
    drift: Option<Drift>,
}

impl TakenConditions {
    /// Their keys in the line of a frame.
    pub(super) fn keys(&self) -> Map<String, Value> {
        let pairs = [
            ("part_c", self.part.map(|part| part.0)),
            ("part_limit_k", self.part.map(|part| part.1)),
            ("since_zero_s", self.drift.map(|drift| drift.since_s)),
            ("head_k", self.drift.map(|drift| drift.head_k)),
            ("u_drift_mm", self.drift.map(|drift| drift.u_mm)),
        ];
        pairs.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?.into()))).collect()
    }
}

/// Conditions that change while frames come.
pub(super) struct LiveConditions {
    temperatures: Option<(Temperatures, Origin)>,
    zeros: Option<(Zeros, GrowingTable<1>)>,
    scale: Option<ScaleDrift>,
    /// The last note on a reading or a row, which is not logged again.
    noted: Option<String>,
}

impl LiveConditions {
    /// Opens the tables, and reads the thermometer for the first time.
    ///
    /// # Errors
    /// Exit 2 for a table that is none; 3 for what cannot be read.
    pub(super) fn open(args: &ConditionArgs) -> Result<Self, Failure> {
        let mut open = Self { temperatures: None, zeros: None, scale: args.scale.drift(), noted: None };
        let awaited = || Temperatures::awaited(args.age());
        if let Some(path) = &args.temperatures {
            std::fs::File::open(path).map_err(|e| Failure::fail(format!("{}: {e}", path.display())))?;
            open.temperatures =
                Some((awaited(), Origin::Table(Box::new(GrowingTable::new(path, TEMPERATURES)))));
        }
        if let Some(command) = &args.temperature_cmd {
            let failed = |why: &dyn std::fmt::Display| Failure::fail(format!("--temperature-cmd: {why}"));
            let thermometer = Thermometer::begin(command.clone()).map_err(|error| failed(&error))?;
            let mut temperatures = awaited();
            let first = thermometer.first().and_then(|sample| temperatures.push(sample));
            first.map_err(|why| failed(&why))?;
            open.temperatures = Some((temperatures, Origin::Command(thermometer)));
        }
        if let (Some(path), Some(drift)) = (&args.zero, args.drift()) {
            drift.validate().map_err(Failure::refuse)?;
            std::fs::File::open(path).map_err(|e| Failure::fail(format!("{}: {e}", path.display())))?;
            open.zeros = Some((Zeros::new(drift), GrowingTable::new(path, ZEROS)));
        }
        open.look_at_first()?;
        Ok(open)
    }

    /// Mistakes of what stands in the tables already are those of the command line.
    fn look_at_first(&mut self) -> Result<(), Failure> {
        if let Some((temperatures, Origin::Table(table))) = &mut self.temperatures {
            for row in table.look().map_err(Failure::refuse)? {
                row.and_then(|row| temperatures.push(sample(row))).map_err(Failure::refuse)?;
            }
        }
        if let Some((zeros, table)) = &mut self.zeros {
            for row in table.look().map_err(Failure::refuse)? {
                zeros.push(zero(row.map_err(Failure::refuse)?));
            }
        }
        Ok(())
    }

    /// Takes the conditions at a frame into the measurements from it on.
    ///
    /// # Errors
    /// No temperature, one that is too old, a zero whose interval is over: the frame has no
    /// diameter.
    pub(super) fn take(&mut self, stream: &mut Stream, meta: &LiveMeta) -> Result<TakenConditions, String> {
        let mut taken = TakenConditions::default();
        let is_timed = self.temperatures.is_some() || self.zeros.is_some();
        if !is_timed && self.scale.is_none() {
            return Ok(taken);
        }
        self.look();
        let time_ns = time_ns(meta);
        if is_timed && time_ns.is_none() {
            return Err(
                "the frame has no time, which --temperatures and --zero need (t_ns in frames.csv)".to_owned()
            );
        }
        let t_ns = time_ns.unwrap_or(0);
        let (mut head_c, mut scale) = (None, None);
        if let Some((temperatures, _)) = &self.temperatures {
            let part = temperatures.at(t_ns)?;
            (head_c, scale) = (temperatures.head_at(t_ns)?, temperatures.scale_at(t_ns)?);
            stream.set_part_temperature(part.0, part.1);
            taken.part = Some(part);
        }
        // a thermometer beside the head is stated by the user, that of the camera is its own
        let own_c = meta.head_c.map(|known| known.value);
        let head_c = head_c.or(own_c);
        if let Some(drift) = &self.scale {
            // the camera's own is read every five seconds: it is not stale
            take_scale(stream, drift, scale.or(own_c.map(|c| (c, 0.0))))?;
        }
        if let Some((zeros, _)) = &self.zeros {
            let drift = zeros.at(t_ns, head_c)?;
            stream.set_zero_drift(drift.u_mm, drift.to_string());
            taken.drift = Some(drift);
        }
        Ok(taken)
    }

    /// Takes what came since the last look.
    fn look(&mut self) {
        let Self { temperatures, zeros, noted, .. } = self;
        let mut note = |result: Result<(), String>| {
            if let Err(why) = result
                && noted.as_ref() != Some(&why)
            {
                tracing::warn!("{why}");
                *noted = Some(why);
            }
        };
        match temperatures {
            None => {}
            Some((temperatures, Origin::Command(thermometer))) => {
                thermometer.readings().for_each(|reading| {
                    let pushed = reading.and_then(|sample| temperatures.push(sample));
                    note(pushed.map_err(|why| format!("--temperature-cmd: {why}")));
                });
            }
            Some((temperatures, Origin::Table(table))) => match table.look() {
                Ok(rows) => {
                    rows.into_iter().for_each(|row| note(row.and_then(|row| later(temperatures, row))));
                }
                Err(why) => note(Err(why)),
            },
        }
        if let Some((zeros, table)) = zeros {
            match table.look() {
                Ok(rows) => rows.into_iter().for_each(|row| note(row.map(|row| zeros.push(zero(row))))),
                Err(why) => note(Err(why)),
            }
        }
    }
}

/// Takes a row where it is later than the last one: a table that is written anew may hold rows that
/// were taken.
fn later(temperatures: &mut Temperatures, row: TimeRow<4>) -> Result<(), String> {
    let sample: TemperatureSample = sample(row);
    if temperatures.last_ns().is_some_and(|last_ns| sample.t_ns <= last_ns) {
        return Ok(());
    }
    temperatures.push(sample)
}

fn zero(row: TimeRow<1>) -> Zero {
    Zero { t_ns: row.t_ns, head_c: row.values[0] }
}

/// Time of a frame on the clock of the tables: that of its own table, else this machine's.
fn time_ns(meta: &LiveMeta) -> Option<u64> {
    let own = meta.device_t.filter(|t| t.clock == Clock::Table);
    own.or(meta.exposed_t).or(meta.host_t).map(|t| t.t_ns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::live::Timestamp;

    #[test]
    fn a_table_of_frames_has_its_own_clock_and_all_else_this_machines() {
        let at = |t_ns, clock| Some(Timestamp { t_ns, clock });
        let host =
            LiveMeta { device_t: at(1, Clock::Device), host_t: at(3, Clock::Host), ..LiveMeta::default() };
        assert_eq!(time_ns(&host), Some(3));
        let mapped = LiveMeta { exposed_t: at(2, Clock::Host), ..host.clone() };
        assert_eq!(time_ns(&mapped), Some(2));
        assert_eq!(time_ns(&LiveMeta { device_t: at(1, Clock::Table), ..mapped }), Some(1));
        assert_eq!(time_ns(&LiveMeta { device_t: at(1, Clock::Device), ..LiveMeta::default() }), None);
    }
}
