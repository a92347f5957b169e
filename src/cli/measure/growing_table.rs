//! A table over time that another program appends to, or writes anew, while it is read.
//!
//! Rows are taken once they are whole: with the end of their line, or once the file has been left
//! alone for a while. What was read is recognised by the last line read: a file that no longer has
//! it in its place was written anew, and is read from its beginning.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::time_table::{TimeRow, TimeTable, Wanted};

/// Time between two looks at the file: a tenth of what temperatures hold for is more.
const LOOK: Duration = Duration::from_millis(200);
/// Age of a file whose last line counts without its end: nothing writes half a line for so long.
const LEFT_ALONE: Duration = Duration::from_secs(1);
/// Most bytes of a look, two million rows; what is left comes with the next one.
const MOST_BYTES: u64 = 1 << 26;

/// A table and how far it was read.
#[derive(Debug)]
pub(crate) struct GrowingTable<const N: usize> {
    path: PathBuf,
    wanted: [Wanted; N],
    clocks: &'static [&'static str],
    columns: Option<TimeTable<N>>,
    /// Bytes and lines read, and the last line of them.
    read: u64,
    lines: usize,
    last: Vec<u8>,
    looked: Option<Instant>,
}

impl<const N: usize> GrowingTable<N> {
    /// A table of these columns.
    pub(crate) fn new(path: &Path, wanted: [Wanted; N]) -> Self {
        Self {
            path: path.to_owned(),
            wanted,
            clocks: &["t_ns"],
            columns: None,
            read: 0,
            lines: 0,
            last: Vec::new(),
            looked: None,
        }
    }

    /// With times of one of these columns, a clock each.
    pub(crate) fn of_clocks(self, clocks: &'static [&'static str]) -> Self {
        Self { clocks, ..self }
    }

    /// Which of the clocks its times are of; `None` before its header is read.
    pub(crate) fn clock(&self) -> Option<usize> {
        self.columns.as_ref().map(TimeTable::clock)
    }

    /// Rows that came since the last look, each with why it cannot be read; at most one look in a
    /// while.
    ///
    /// # Errors
    /// A file that cannot be read, a header without a needed column: the message names the file.
    pub(crate) fn look(&mut self) -> Result<Vec<Result<TimeRow<N>, String>>, String> {
        if self.looked.is_some_and(|looked| looked.elapsed() < LOOK) {
            return Ok(Vec::new());
        }
        self.looked = Some(Instant::now());
        let shown = self.path.display().to_string();
        let text = self.appended().map_err(|error| format!("{shown}: {error}"))?;
        let rows = self.rows(&text).map_err(|why| format!("{shown}: {why}"))?;
        Ok(rows.into_iter().map(|row| row.map_err(|why| format!("{shown}: {why}"))).collect())
    }

    /// Whole lines that were not read yet.
    fn appended(&mut self) -> io::Result<Vec<u8>> {
        let mut file = File::open(&self.path)?;
        if !self.continues(&mut file)? {
            (self.columns, self.read, self.lines) = (None, 0, 0);
            self.last.clear();
        }
        file.seek(SeekFrom::Start(self.read))?;
        let mut text = Vec::new();
        file.by_ref().take(MOST_BYTES).read_to_end(&mut text)?;
        let metadata = file.metadata()?;
        let is_all = self.read + text.len() as u64 >= metadata.len();
        let age = metadata.modified().ok().and_then(|at| at.elapsed().ok());
        if !(is_all && age.is_some_and(|age| age > LEFT_ALONE)) {
            let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
            text.truncate(whole);
        }
        self.read += text.len() as u64;
        if let Some(last) = text.split_inclusive(|byte| *byte == b'\n').next_back() {
            last.clone_into(&mut self.last);
        }
        Ok(text)
    }

    /// Whether the last line read still stands in its place.
    fn continues(&self, file: &mut File) -> io::Result<bool> {
        if file.metadata()?.len() < self.read {
            return Ok(false);
        }
        let mut there = vec![0; self.last.len()];
        file.seek(SeekFrom::Start(self.read - self.last.len() as u64))?;
        file.read_exact(&mut there)?;
        Ok(there == self.last)
    }

    fn rows(&mut self, text: &[u8]) -> Result<Vec<Result<TimeRow<N>, String>>, String> {
        let mut rows = Vec::new();
        for line in String::from_utf8_lossy(text).lines() {
            self.lines += 1;
            match &self.columns {
                _ if line.trim().is_empty() => {}
                Some(columns) => rows.push(columns.row(line, self.lines)),
                None => self.columns = Some(TimeTable::of_clocks(line, self.wanted, self.clocks)?),
            }
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const WANTED: [Wanted; 1] = [Wanted { name: "part_c", is_needed: true }];

    fn taken(table: &mut GrowingTable<1>) -> Vec<u64> {
        table.looked = None;
        table.look().unwrap().into_iter().map(|row| row.unwrap().t_ns).collect()
    }

    #[test]
    fn rows_are_taken_once_whole_and_a_file_written_anew_from_its_beginning() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        fs::write(&path, "t_ns,part_c\n1,20\n2,2").unwrap();
        let mut table = GrowingTable::new(&path, WANTED);
        assert_eq!(taken(&mut table), [1]);
        // No second look at once.
        fs::write(&path, "t_ns,part_c\n1,20\n2,21\n3,22\n").unwrap();
        assert!(table.look().unwrap().is_empty());
        assert_eq!(taken(&mut table), [2, 3]);
        assert!(taken(&mut table).is_empty());
        // Of the same length, with another row in the place of the last.
        fs::write(&path, "t_ns,part_c\n1,20\n2,21\n4,22\n").unwrap();
        assert_eq!(taken(&mut table), [1, 2, 4]);
        fs::write(&path, "t_ns;part_c\n5;20,5\n").unwrap();
        assert_eq!(taken(&mut table), [5]);
    }

    #[test]
    fn a_last_line_without_its_end_counts_once_the_file_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        fs::write(&path, "t_ns,part_c\n1,20").unwrap();
        let mut table = GrowingTable::new(&path, WANTED);
        assert!(taken(&mut table).is_empty());
        let before = std::time::SystemTime::now() - Duration::from_secs(60);
        File::options().write(true).open(&path).unwrap().set_modified(before).unwrap();
        assert_eq!(taken(&mut table), [1]);
        assert!(taken(&mut table).is_empty());
    }

    #[test]
    fn mistakes_name_file_and_row() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let mut table = GrowingTable::new(&path, WANTED);
        assert!(table.look().unwrap_err().contains("t.csv"));
        fs::write(&path, "t_ns,part_c\n1,warm\n2,20\n").unwrap();
        table.looked = None;
        let rows = table.look().unwrap();
        assert!(rows[0].as_ref().unwrap_err().contains("t.csv: row 2: part_c \"warm\""), "{rows:?}");
        assert!(rows[1].is_ok());
        fs::write(&path, "time,part_c\n").unwrap();
        table.looked = None;
        assert!(table.look().unwrap_err().contains("no column t_ns"));
    }
}
