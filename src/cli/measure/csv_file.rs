//! Diameters of every frame as CSV (RFC 4180): the file of `--csv`.
//!
//! In: a measurement a frame. Out: a row of the frame, then one a station of it; numbers with every
//! digit, as JSON has them. A refused frame has empty numbers and the reason.

use std::io::Write;

use crate::cli::failure::Failure;
use crate::files::OpenOutput;
use crate::measurement::{Measurement, StationResult, Verdict};
use crate::profile::{Diameter, Reading};

/// The columns, in their order; docs/reference/files.md explains them.
const COLUMNS: [&str; 18] = [
    "frame",
    "row",
    "z_mm",
    "diameter_mm",
    "expanded_u_mm",
    "k",
    "mean_mm",
    "expanded_u_mean_mm",
    "average_mm",
    "expanded_u_average_mm",
    "k_mean",
    "judgement",
    "judged_by",
    "valid_columns",
    "columns",
    "refused",
    "flags",
    "warnings",
];

/// A row under construction: cells by the names of their columns.
#[derive(Default)]
struct Row<'a> {
    kind: &'static str,
    frame: &'a str,
    z_mm: Option<f64>,
    /// Diameter, U and k.
    diameter: Option<[f64; 3]>,
    /// Mean and average with their U.
    means: [Option<[f64; 2]>; 2],
    k_mean: Option<f64>,
    judgement: &'static str,
    judged_by: &'static str,
    /// Valid columns and all.
    columns: Option<[usize; 2]>,
    refused: &'static str,
    flags: String,
    warnings: String,
}

/// A number with every digit, or nothing.
fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(String::new, |v| v.to_string())
}

impl Row<'_> {
    fn cells(self) -> [String; COLUMNS.len()] {
        let diameter = |k: usize| number(self.diameter.map(|d| d[k]));
        let mean = |which: usize, k: usize| number(self.means[which].map(|d| d[k]));
        let count = |k: usize| self.columns.map_or_else(String::new, |c| c[k].to_string());
        [
            self.frame.to_owned(),
            self.kind.to_owned(),
            number(self.z_mm),
            diameter(0),
            diameter(1),
            diameter(2),
            mean(0, 0),
            mean(0, 1),
            mean(1, 0),
            mean(1, 1),
            number(self.k_mean),
            self.judgement.to_owned(),
            self.judged_by.to_owned(),
            count(0),
            count(1),
            self.refused.to_owned(),
            self.flags,
            self.warnings,
        ]
    }
}

/// The rows of the frames that were added.
#[derive(Debug)]
pub(super) struct DiameterRows<W: Write> {
    csv: csv::Writer<W>,
    /// Coverage factor of means, averages and stations.
    k_mean: f64,
}

impl<W: Write> DiameterRows<W> {
    /// The header alone; `k_mean` is the coverage factor of means, averages and stations.
    ///
    /// # Errors
    /// Where `out` cannot be written.
    pub(super) fn begin(out: W, k_mean: f64) -> Result<Self, csv::Error> {
        let mut csv = csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(out);
        csv.write_record(COLUMNS)?;
        Ok(Self { csv, k_mean })
    }

    /// Adds a frame and its stations.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(super) fn add(&mut self, measured: &Measurement) -> Result<(), csv::Error> {
        self.csv.write_record(self.frame(measured).cells())?;
        for station in measured.stations.as_deref().unwrap_or_default() {
            self.csv.write_record(self.station(&measured.frame, station).cells())?;
        }
        Ok(())
    }

    fn expanded(&self, d: Diameter) -> [f64; 2] {
        [d.d_mm, self.k_mean * d.u_mm()]
    }

    fn frame<'a>(&self, m: &'a Measurement) -> Row<'a> {
        let largest = m.diameter.as_ref();
        let flags: Vec<String> =
            m.flags.iter().map(|(reason, columns)| format!("{reason}: {columns}")).collect();
        let mut warnings: Vec<String> = m.warnings.iter().map(ToString::to_string).collect();
        warnings.extend(m.jumps.iter().map(ToString::to_string));
        warnings.extend(m.refusal.as_ref().map(|refusal| refusal.why.clone()));
        Row {
            kind: "frame",
            frame: &m.frame,
            z_mm: m.place.filter(|_| largest.is_some()).map(|place| place.z_mm),
            diameter: largest.map(|d| [d.diameter.d_mm, d.expanded_u_mm, d.coverage_factor]),
            means: [m.mean, m.average].map(|d| d.map(|d| self.expanded(d))),
            k_mean: m.mean.or(m.average).map(|_| self.k_mean),
            judgement: m.judgement.word(),
            judged_by: m.judged.as_ref().map_or("", |judged| judged.what),
            columns: Some([m.valid, m.columns]),
            refused: m.refusal.as_ref().map_or("", |refusal| refusal.reason.as_str()),
            flags: flags.join("; "),
            warnings: warnings.join("; "),
        }
    }

    fn station<'a>(&self, frame: &'a str, station: &StationResult) -> Row<'a> {
        let (diameter, refused) = match station.reading {
            Reading::Value(d) => (Some([d.d_mm, self.k_mean * d.u_mm(), self.k_mean]), ""),
            Reading::Gap(reason) => (None, reason.as_str()),
        };
        let verdict = station.judged.map(|judged| judged.judgement.map_or(Verdict::NotProven, Verdict::Is));
        Row {
            kind: "station",
            frame,
            z_mm: Some(station.z_mm),
            diameter,
            judgement: verdict.unwrap_or_default().word(),
            refused,
            ..Row::default()
        }
    }

    /// Gives on what was added.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(super) fn flush(&mut self) -> std::io::Result<()> {
        self.csv.flush()
    }

    /// What the table was written to.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(super) fn finish(self) -> Result<W, std::io::Error> {
        self.csv.into_inner().map_err(csv::IntoInnerError::into_error)
    }
}

impl DiameterRows<OpenOutput> {
    /// That it could not be written.
    pub(super) fn failed(&self, error: csv::Error) -> Failure {
        named(self.csv.get_ref(), error)
    }
}

/// What of a table's file could not be written.
pub(super) fn named(file: &OpenOutput, error: csv::Error) -> Failure {
    let cause = match error.into_kind() {
        csv::ErrorKind::Io(cause) => cause,
        other => std::io::Error::other(format!("{other:?}")),
    };
    file.failed(cause).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::{Refusal, StationJudgement};
    use crate::profile::Reason;

    #[test]
    fn rows_end_as_the_standard_has_it_and_a_refused_frame_has_its_reason() {
        let mut rows = DiameterRows::begin(Vec::new(), 2.0).unwrap();
        let refusal = Some(Refusal { reason: Reason::LowContrast, why: "dark, \"all\" of it".to_owned() });
        let refused = Measurement { frame: "a,b".to_owned(), columns: 9, refusal, ..Measurement::default() };
        rows.add(&refused).unwrap();
        let diameter = Diameter { d_mm: 24.5, u_random_mm: 3.0, u_common_mm: 4.0 };
        let stations =
            [Reading::Value(diameter), Reading::Gap(Reason::NoEdge)].map(|reading| StationResult {
                z_mm: 1.5,
                reading,
                judged: Some(StationJudgement { judgement: None, guard_mm: None }),
            });
        let measured = Measurement {
            frame: "c".to_owned(),
            columns: 9,
            valid: 7,
            mean: Some(diameter),
            stations: Some(stations.into()),
            ..Measurement::default()
        };
        rows.add(&measured).unwrap();
        let text = String::from_utf8(rows.finish().unwrap()).unwrap();
        let lines: Vec<&str> = text.split("\r\n").collect();
        assert_eq!(lines[0], COLUMNS.join(","));
        assert_eq!(lines[1], "\"a,b\",frame,,,,,,,,,,,,0,9,low_contrast,,\"dark, \"\"all\"\" of it\"");
        assert_eq!(lines[2], "c,frame,,,,,24.5,10,,,2,,,7,9,,,");
        assert_eq!(lines[3], "c,station,1.5,24.5,10,2,,,,,,not_proven,,,,,,");
        assert_eq!(lines[4], "c,station,1.5,,,,,,,,,not_proven,,,,no_edge,,");
        assert_eq!(lines[5..], [""]);
    }
}
