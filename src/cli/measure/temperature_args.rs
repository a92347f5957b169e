//! Arguments of temperatures over time: a table whose clock is that of the frames.

use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use crate::measurement::{Stream, TemperatureAge, TemperatureSample, Temperatures};

/// Limits of a thermometer that states none, ± K: those of a reading with unstated limits.
const UNSTATED_K: f64 = 1.0;

/// Arguments of the part's temperature over time.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct TemperatureArgs {
    /// Temperatures of the part over time (CSV: t_ns on the clock of frames.csv, part_c, limit_k):
    /// each frame has the last one before it; its limits grow by 0.02 K/s after 10 s.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "part_temperature")]
    temperatures: Option<PathBuf>,
    /// Refuses frames whose last temperature is older.
    #[arg(long, value_name = "S", requires = "temperatures", value_parser = seconds)]
    temperature_max_s: Option<f64>,
}

fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|s| *s > 0.0 && s.is_finite());
    value.ok_or_else(|| "a number of seconds above 0 is needed, for instance 60".to_owned())
}

impl TemperatureArgs {
    /// The table, which no output may replace.
    pub(super) fn file(&self) -> Option<PathBuf> {
        self.temperatures.clone()
    }

    /// Reads the table.
    ///
    /// # Errors
    /// Exit 3 for a file that cannot be read, 2 for rows that are wrong.
    pub(super) fn read(&self) -> Result<Option<Temperatures>, Failure> {
        let Some(path) = &self.temperatures else { return Ok(None) };
        let text = std::fs::read_to_string(path)
            .map_err(|error| Failure::fail(format!("{}: {error}", path.display())))?;
        let age = TemperatureAge::default();
        let refused_age_s = self.temperature_max_s.unwrap_or(age.refused_age_s);
        let samples = samples(&text).map_err(|why| refuse(path, &why))?;
        let read = Temperatures::new(samples, TemperatureAge { refused_age_s, ..age });
        read.map(Some).map_err(|why| refuse(path, &why))
    }
}

fn refuse(path: &Path, why: &str) -> Failure {
    Failure::refuse(format!("{}: {why}", path.display()))
}

/// Gives the stream the part's temperature at a frame.
///
/// # Errors
/// A frame without time, or whose last temperature is too old.
pub(super) fn take_temperature(
    stream: &mut Stream,
    temperatures: Option<&Temperatures>,
    t_ns: u64,
) -> Result<(), String> {
    let Some(temperatures) = temperatures else { return Ok(()) };
    if t_ns == 0 {
        return Err("no t_ns in frames.csv, which --temperatures needs".to_owned());
    }
    let (part_c, limit_k) = temperatures.at(t_ns)?;
    stream.set_part_temperature(part_c, limit_k);
    Ok(())
}

/// Rows of a table with commas or semicolons.
fn samples(text: &str) -> Result<Vec<TemperatureSample>, String> {
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty());
    let Some((header, _)) = lines.next() else { return Err("is empty".to_owned()) };
    let separator = if header.contains(';') { ';' } else { ',' };
    let names: Vec<String> = header.split(separator).map(|n| n.trim().to_ascii_lowercase()).collect();
    let column = |name: &str| names.iter().position(|n| n == name);
    let needed = |name: &str| {
        column(name).ok_or_else(|| format!("no column {name}; t_ns, part_c and, if known, limit_k are right"))
    };
    let (time, part, limit) = (needed("t_ns")?, needed("part_c")?, column("limit_k"));
    let row = |(line, number): (&str, usize)| {
        let fields: Vec<&str> = line.split(separator).map(str::trim).collect();
        let field = |i: usize| fields.get(i).copied().unwrap_or("");
        let wrong = |i: usize| format!("row {number}: {} {:?} is no number", names[i], field(i));
        let value = |i: usize| {
            let text = if separator == ';' { field(i).replace(',', ".") } else { field(i).to_owned() };
            text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| wrong(i))
        };
        Ok(TemperatureSample {
            t_ns: field(time).parse().map_err(|_| wrong(time))?,
            part_c: value(part)?,
            limit_k: limit.filter(|i| !field(*i).is_empty()).map_or(Ok(UNSTATED_K), value)?,
        })
    };
    lines.map(row).collect()
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
