//! Arguments of temperatures over time: a table whose clock is that of the frames.

use std::path::{Path, PathBuf};

use super::scale_drift_args::ScaleDriftArgs;
use super::time_table::{TimeRow, TimeTable, Wanted};
use crate::cli::failure::Failure;
use crate::measurement::{ScaleDrift, Stream, TemperatureAge, TemperatureSample, Temperatures};

/// Limits of a thermometer that states none, ± K: those of a reading with unstated limits.
pub(crate) const UNSTATED_K: f64 = 1.0;

/// Arguments of the part's temperature over time.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct TemperatureArgs {
    /// Temperatures over time (CSV: t_ns on the clock of frames.csv, part_c, and where they are
    /// known limit_k, head_c, scale_c):
    /// each frame has the last one before it; its limits grow by 0.02 K/s after 10 s.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "part_temperature")]
    temperatures: Option<PathBuf>,
    /// Refuses frames whose last temperature is older.
    #[arg(
        long,
        value_name = "S",
        visible_alias = "temperature-max-age-s",
        requires = "temperatures",
        value_parser = seconds
    )]
    temperature_max_s: Option<f64>,
    #[command(flatten)]
    scale: ScaleDriftArgs,
}

/// Temperatures over time, and what follows from them beside the part's.
#[derive(Debug)]
pub(super) struct StatedTemperatures {
    /// `None` where the head's own is all there is.
    temperatures: Option<Temperatures>,
    scale: Option<ScaleDrift>,
}

/// Parses an age.
///
/// # Errors
/// What is no number of seconds above 0.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|s| *s > 0.0 && s.is_finite());
    value.ok_or_else(|| "a number of seconds above 0 is needed, for instance 60".to_owned())
}

impl TemperatureArgs {
    /// The table, which no output may replace.
    pub(super) fn file(&self) -> Option<PathBuf> {
        self.temperatures.clone()
    }

    /// Reads the table. Frames of a stream may have the temperature of their head with them.
    ///
    /// # Errors
    /// Exit 3 for a file that cannot be read, 2 for rows that are wrong.
    pub(super) fn read(&self, is_stream: bool) -> Result<Option<StatedTemperatures>, Failure> {
        self.scale.check(self.temperatures.is_some() || is_stream)?;
        let temperatures = self.temperatures.as_deref().map(|path| self.table(path)).transpose()?;
        let scale = self.scale.drift();
        let is_any = temperatures.is_some() || scale.is_some();
        Ok(is_any.then_some(StatedTemperatures { temperatures, scale }))
    }

    fn table(&self, path: &Path) -> Result<Temperatures, Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Failure::fail(format!("{}: {error}", path.display())))?;
        let age = TemperatureAge::default();
        let refused_age_s = self.temperature_max_s.unwrap_or(age.refused_age_s);
        let samples = samples(&text).map_err(|why| refuse(path, &why))?;
        let read = Temperatures::new(samples, TemperatureAge { refused_age_s, ..age });
        read.map_err(|why| refuse(path, &why))
    }
}

fn refuse(path: &Path, why: &str) -> Failure {
    Failure::refuse(format!("{}: {why}", path.display()))
}

/// Gives the stream the part's temperature at a frame, and the scale's: that of the table, else
/// `own_c` of the head.
///
/// # Errors
/// A frame without time, or whose last temperature is too old; no temperature of the scale.
pub(super) fn take_temperature(
    stream: &mut Stream,
    stated: Option<&StatedTemperatures>,
    t_ns: u64,
    own_c: Option<f64>,
) -> Result<(), String> {
    let Some(StatedTemperatures { temperatures, scale }) = stated else { return Ok(()) };
    let mut of_table = None;
    if let Some(temperatures) = temperatures {
        if t_ns == 0 {
            return Err("no t_ns in frames.csv, which --temperatures needs".to_owned());
        }
        let (part_c, limit_k) = temperatures.at(t_ns)?;
        stream.set_part_temperature(part_c, limit_k);
        of_table = temperatures.scale_at(t_ns)?;
    }
    match scale {
        None => Ok(()),
        // the head's own comes with the frame, or is read every five seconds: it is not stale
        Some(drift) => take_scale(stream, drift, of_table.or(own_c.map(|c| (c, 0.0)))),
    }
}

/// Gives the stream the drift of the scale at its temperature, °C, with what it may have changed by
/// since, K.
///
/// # Errors
/// No temperature.
pub(crate) fn take_scale(
    stream: &mut Stream,
    drift: &ScaleDrift,
    scale: Option<(f64, f64)>,
) -> Result<(), String> {
    let Some((scale_c, stale_k)) = scale else {
        return Err(
            "--scale-ppm-per-k needs the temperature of the scale (scale_c or head_c, or the camera's own)"
                .to_owned(),
        );
    };
    stream.set_scale_drift(drift.limit_ppm(scale_c, stale_k));
    Ok(())
}

/// Columns of temperatures over time.
pub(crate) const TEMPERATURES: [Wanted; 4] = [
    Wanted { name: "part_c", is_needed: true },
    Wanted { name: "limit_k", is_needed: false },
    Wanted { name: "head_c", is_needed: false },
    Wanted { name: "scale_c", is_needed: false },
];

/// The sample of a row; limits that are not stated are those of a reading of an unstated
/// thermometer.
pub(crate) fn sample(row: TimeRow<4>) -> TemperatureSample {
    let [part_c, limit_k, head_c, scale_c] = row.values;
    TemperatureSample {
        t_ns: row.t_ns,
        part_c: part_c.unwrap_or(f64::NAN),
        limit_k: limit_k.unwrap_or(UNSTATED_K),
        head_c,
        scale_c,
    }
}

fn samples(text: &str) -> Result<Vec<TemperatureSample>, String> {
    let mut lines = text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty());
    let Some((header, _)) = lines.next() else { return Err("is empty".to_owned()) };
    let table = TimeTable::of_header(header, TEMPERATURES)?;
    lines.map(|(line, number)| table.row(line, number).map(sample)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_and_mistakes_named() {
        let read = samples("t_ns;part_c;limit_k\n10;20,5;0,2\n\n20;21;\n").unwrap();
        let found: Vec<(u64, f64, f64)> = read.iter().map(|s| (s.t_ns, s.part_c, s.limit_k)).collect();
        assert_eq!(found, [(10, 20.5, 0.2), (20, 21.0, UNSTATED_K)]);
        for (text, word) in [
            ("", "is empty"),
            ("t_ns,c\n", "no column part_c"),
            ("t_ns,part_c\n1,warm\n", "row 2: part_c \"warm\""),
            ("t_ns,part_c\n-1,20\n", "row 2: t_ns"),
        ] {
            assert!(samples(text).unwrap_err().contains(word), "{text:?}");
        }
    }
}
