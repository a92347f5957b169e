//! Tables of numbers over time (CSV with commas or semicolons): `t_ns` and columns found by name.
//! Where times may be of several clocks, the name of their column states which.

/// A column that is wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// Its name in the header.
    pub(crate) name: &'static str,
    /// Whether every row needs it.
    pub(crate) is_needed: bool,
}

/// A row: its time, ns, and its values in the order of the columns wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeRow<const N: usize> {
    pub(crate) t_ns: u64,
    pub(crate) values: [Option<f64>; N],
}

/// Where the columns of a table stand, by its header.
#[derive(Clone, Debug)]
pub(crate) struct TimeTable<const N: usize> {
    separator: char,
    time: usize,
    /// Place of the clock among those that may be named.
    clock: usize,
    columns: [(Wanted, Option<usize>); N],
}

impl<const N: usize> TimeTable<N> {
    /// Finds the columns in a header.
    ///
    /// # Errors
    /// A needed column that is not there; the message names all that are read.
    pub(crate) fn of_header(header: &str, wanted: [Wanted; N]) -> Result<Self, String> {
        Self::of_clocks(header, wanted, &["t_ns"])
    }

    /// Finds the columns in a header whose times have one of these names.
    ///
    /// # Errors
    /// As [`Self::of_header`]; times of two clocks.
    pub(crate) fn of_clocks(
        header: &str,
        wanted: [Wanted; N],
        clocks: &[&'static str],
    ) -> Result<Self, String> {
        let header = header.trim_start_matches('\u{feff}');
        let separator = if header.contains(';') { ';' } else { ',' };
        let names: Vec<String> = header.split(separator).map(|n| n.trim().to_ascii_lowercase()).collect();
        let place = |name: &str| names.iter().position(|n| n == name);
        let columns = wanted.map(|column| (column, place(column.name)));
        let lacks = columns.iter().find(|(column, place)| column.is_needed && place.is_none());
        let times = clocks.join(" or ");
        let lacking = lacks.map_or(times.as_str(), |(column, _)| column.name);
        let mut found = (0..).zip(clocks).filter_map(|(clock, name)| Some((clock, place(name)?)));
        let first = found.next();
        if first.is_some() && found.next().is_some() {
            return Err(format!("times of two clocks; one of {times} is right"));
        }
        let Some((clock, time)) = first.filter(|_| lacks.is_none()) else {
            let named = |is_needed: bool| {
                let names = wanted.iter().filter(move |column| column.is_needed == is_needed);
                names.map(|column| column.name).collect::<Vec<_>>()
            };
            let (needed, known) =
                ([vec![times.as_str()], named(true)].concat().join(", "), named(false).join(", "));
            let known = if known.is_empty() { known } else { format!(" and, if known, {known}") };
            return Err(format!("no column {lacking}; {needed}{known} are right"));
        };
        Ok(Self { separator, time, clock, columns })
    }

    /// Which of the clocks that may be named its times are of.
    pub(crate) fn clock(&self) -> usize {
        self.clock
    }

    /// Reads a row; `number` is its line in the file.
    ///
    /// # Errors
    /// A value that is no number, or a needed one that is not there: the message names row and
    /// column.
    pub(crate) fn row(&self, line: &str, number: usize) -> Result<TimeRow<N>, String> {
        let fields: Vec<&str> = line.split(self.separator).map(str::trim).collect();
        let field = |i: usize| fields.get(i).copied().unwrap_or("");
        let wrong = |name: &str, i: usize| format!("row {number}: {name} {:?} is no number", field(i));
        let t_ns = field(self.time).parse().map_err(|_| wrong("t_ns", self.time))?;
        let mut values = [None; N];
        for (value, (column, place)) in values.iter_mut().zip(&self.columns) {
            let Some(i) = place.filter(|i| column.is_needed || !field(*i).is_empty()) else { continue };
            let decimal =
                if self.separator == ';' { field(i).replace(',', ".") } else { field(i).to_owned() };
            let read = decimal.parse::<f64>().ok().filter(|v| v.is_finite());
            *value = Some(read.ok_or_else(|| wrong(column.name, i))?);
        }
        Ok(TimeRow { t_ns, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: [Wanted; 2] =
        [Wanted { name: "part_c", is_needed: true }, Wanted { name: "limit_k", is_needed: false }];

    #[test]
    fn columns_are_found_by_name_and_mistakes_have_their_row() {
        let table = TimeTable::of_header("\u{feff}Limit_K; other; t_ns;PART_C", WANTED).unwrap();
        assert_eq!(
            table.row("0,2;x;10;20,5", 2).unwrap(),
            TimeRow { t_ns: 10, values: [Some(20.5), Some(0.2)] }
        );
        assert_eq!(table.row(";;11;21", 3).unwrap().values, [Some(21.0), None]);
        assert!(table.row(";;11;", 4).unwrap_err().contains("row 4: part_c \"\""));
        assert!(table.row(";;-1;20", 5).unwrap_err().contains("row 5: t_ns \"-1\""));
        for (header, word) in [
            ("t_ns,c", "no column part_c; t_ns, part_c and, if known, limit_k are right"),
            ("part_c", "no column t_ns"),
        ] {
            assert!(TimeTable::of_header(header, WANTED).unwrap_err().contains(word), "{header}");
        }
        let of = |header| TimeTable::of_clocks(header, WANTED, &["t_ns", "host_t_ns"]).map(|t| t.clock());
        assert_eq!((of("part_c,host_t_ns"), of("t_ns,part_c")), (Ok(1), Ok(0)));
        assert!(of("t_ns,host_t_ns,part_c").unwrap_err().contains("two clocks"));
        assert!(of("part_c").unwrap_err().contains("no column t_ns or host_t_ns"));
    }
}
