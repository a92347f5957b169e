//! Index pulses of an encoder from a table that may grow: `--encoder-index FILE.csv`.

use std::path::Path;

use super::encoder_samples::{CLOCKS, sample_clock};
use super::growing_table::GrowingTable;
use crate::source::live::{IndexTimes, SampleClock};

/// A table of the times of index pulses.
#[derive(Debug)]
pub(super) struct IndexTable {
    table: GrowingTable<0>,
    /// Read, and not given yet, ns.
    read: Vec<u64>,
    /// Time of the last pulse, ns.
    last_ns: Option<u64>,
}

impl IndexTable {
    /// The table in a file, whose header states the clock of its times.
    ///
    /// # Errors
    /// A file that cannot be read, a header without times: the message names the file.
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        let table = GrowingTable::new(path, []).of_clocks(&CLOCKS);
        let mut open = Self { table, read: Vec::new(), last_ns: None };
        open.read_on()?;
        match open.clock() {
            Some(_) => Ok(open),
            None => Err(format!(
                "{}: no header yet; one of {} is needed in its first line",
                path.display(),
                CLOCKS.join(", ")
            )),
        }
    }

    fn read_on(&mut self) -> Result<(), String> {
        for row in self.table.look()? {
            let pulse_ns = row?.t_ns;
            // a table that is written anew may hold rows that were taken
            if self.last_ns.is_none_or(|last_ns| pulse_ns > last_ns) {
                self.last_ns = Some(pulse_ns);
                self.read.push(pulse_ns);
            }
        }
        Ok(())
    }
}

impl IndexTimes for IndexTable {
    fn look(&mut self) -> Result<Vec<u64>, String> {
        self.read_on()?;
        Ok(std::mem::take(&mut self.read))
    }

    fn clock(&self) -> Option<SampleClock> {
        self.table.clock().map(sample_clock)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_are_read_with_their_clock_and_mistakes_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("index.csv");
        let open = |text: &str| {
            std::fs::write(&path, text).unwrap();
            IndexTable::open(&path)
        };
        let mut table = open("host_t_ns\n10\n20\n20\n15\n").unwrap();
        assert_eq!((table.look(), table.clock()), (Ok(vec![10, 20]), Some(SampleClock::Host)));
        assert_eq!(table.look(), Ok(vec![]));
        assert_eq!(open("turn,t_ns\n1,7\n").unwrap().clock(), Some(SampleClock::Frames));
        for (text, word) in [
            ("", "no header yet"),
            ("count\n1\n", "no column t_ns or device_t_ns or host_t_ns"),
            ("t_ns\nx\n", "row 2: t_ns \"x\""),
        ] {
            let why = open(text).unwrap_err();
            assert!(why.contains("index.csv") && why.contains(word), "{text:?}: {why}");
        }
    }
}
