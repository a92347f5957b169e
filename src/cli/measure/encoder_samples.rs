//! Samples of an encoder from a table that may grow: `--encoder-samples FILE.csv`.

use std::path::Path;

use super::growing_table::GrowingTable;
use super::time_table::{TimeRow, Wanted};
use crate::position::EncoderSample;
use crate::source::live::{EncoderSamples, SampleClock};

/// Columns of the samples.
const COLUMNS: [Wanted; 3] = [
    Wanted { name: "count", is_needed: true },
    Wanted { name: "index", is_needed: false },
    Wanted { name: "z_mm", is_needed: false },
];
/// Names that times may have, a clock each: that of the frames' own times under two names.
pub(super) const CLOCKS: [&str; 3] = ["t_ns", "device_t_ns", "host_t_ns"];

/// A table of samples.
#[derive(Debug)]
pub(super) struct SampleTable {
    table: GrowingTable<3>,
    /// Time of the last sample taken, ns.
    last_ns: Option<u64>,
    shown: String,
}

impl SampleTable {
    /// The table in a file.
    pub(super) fn new(path: &Path) -> Self {
        let table = GrowingTable::new(path, COLUMNS).of_clocks(&CLOCKS);
        Self { table, last_ns: None, shown: path.display().to_string() }
    }

    fn sample(&self, row: &TimeRow<3>) -> Result<EncoderSample, String> {
        let [count, index, z_mm] = row.values;
        // 2^53: beyond it a double leaves counts out
        let whole = |name: &str, value: f64| match value.fract() == 0.0 && value.abs() < 9.0e15 {
            true => Ok(value as i64),
            false => Err(format!("{}: t_ns {}: {name} {value} is no whole number", self.shown, row.t_ns)),
        };
        let index = index.map(|index| whole("index", index)).transpose()?;
        Ok(EncoderSample { t_ns: row.t_ns, count: whole("count", count.unwrap_or(f64::NAN))?, index, z_mm })
    }
}

/// The clock of the times of a table, by its place among [`CLOCKS`].
pub(super) fn sample_clock(clock: usize) -> SampleClock {
    if CLOCKS[clock] == "host_t_ns" { SampleClock::Host } else { SampleClock::Frames }
}

impl EncoderSamples for SampleTable {
    fn look(&mut self) -> Result<Vec<EncoderSample>, String> {
        let mut samples = Vec::new();
        for row in self.table.look()? {
            let sample = self.sample(&row?)?;
            // a table that is written anew may hold rows that were taken
            if self.last_ns.is_none_or(|last_ns| sample.t_ns > last_ns) {
                self.last_ns = Some(sample.t_ns);
                samples.push(sample);
            }
        }
        Ok(samples)
    }

    fn clock(&self) -> Option<SampleClock> {
        self.table.clock().map(sample_clock)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_read_with_their_clock_and_mistakes_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("encoder.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let mut table = SampleTable::new(&path);
            table.look().map(|samples| (samples, table.clock()))
        };
        let (samples, clock) = read("host_t_ns,count,index\n10,-5,-4096\n20,-6,\n").unwrap();
        assert_eq!(clock, Some(SampleClock::Host));
        assert_eq!(samples[0], EncoderSample { t_ns: 10, count: -5, index: Some(-4096), z_mm: None });
        assert_eq!((samples.len(), samples[1].index), (2, None));
        let (samples, clock) = read("count,z_mm,device_t_ns\n1,2.5,7\n1,2.5,7\n").unwrap();
        assert_eq!((samples.len(), samples[0].z_mm, clock), (1, Some(2.5), Some(SampleClock::Frames)));
        for (text, word) in [
            ("t_ns,index\n", "no column count"),
            ("count\n", "no column t_ns or device_t_ns or host_t_ns"),
            ("t_ns,count\n1,2.5\n", "count 2.5 is no whole number"),
            ("t_ns,count\n1,x\n", "row 2: count \"x\""),
        ] {
            let why = read(text).unwrap_err();
            assert!(why.contains("encoder.csv") && why.contains(word), "{text:?}: {why}");
        }
    }
}
