//! The results of frames as they come: a table, a JSON document or a line a frame; edges; warnings.
//!
//! Of input that is finished nothing is written before a frame could be measured: where none can,
//! there is the error alone. Of more than [`MOST_HELD`] refused frames before the first that is
//! measured, and of a stream, every frame is written at once.

use serde_json::{Map, Value, json};

use super::document::{Lines, Whole};
use super::edges_file::{EdgesFile, FrameRows};
use super::legend::Legend;
use super::offsets::OffsetResult;
use super::table::{print_header, print_row, print_series};
use super::warnings::{FrameWarnings, report_uncalibrated};
use crate::cli::failure::Failure;
use crate::gauge::FrameEdges;
use crate::measurement::{Measurement, Series, Stream};
use crate::profile::Reason;
use crate::source::Arrival;

/// Most refused frames that wait for one that can be measured: more than a person looks through,
/// in some hundred kilobytes. Of a folder that holds more the first results are those that are
/// refused.
const MOST_HELD: usize = 1000;

/// How frames are printed.
pub(super) enum Printed {
    /// Not at all: stdout takes the edges.
    Nothing,
    /// A row each; budgets by this coverage factor, where given.
    Table {
        /// k of the budgets.
        coverage_factor: Option<f64>,
        /// Probability behind the judgements.
        probability: f64,
        /// Whether frames are averaged.
        averages: bool,
        /// Whether the names of the columns are printed.
        has_header: bool,
        /// The judgements that were printed.
        legend: Legend,
    },
    /// One document.
    Whole(Whole),
    /// One document that has the times of a benchmark before its frames.
    Timed(Vec<Value>),
    /// A line each, and one of the series.
    Lines(Lines),
}

impl Printed {
    fn frame(&mut self, frame: &Measurement, arrival: &Arrival) {
        match self {
            Self::Nothing => {}
            Self::Table { coverage_factor, averages, has_header, legend, .. } => {
                if !std::mem::replace(has_header, true) {
                    print_header(*averages);
                }
                print_row(&json!(frame), *averages);
                legend.note(frame.judgement);
                if let Some(budget) = &frame.budget {
                    say_line!("\nbudget of the largest diameter of frame {}", frame.frame);
                    say_line!("{}", budget.to_table(*coverage_factor));
                }
            }
            Self::Whole(whole) => whole.frame(&json!(frame)),
            Self::Timed(frames) => frames.push(json!(frame)),
            Self::Lines(lines) => lines.frame(json!(frame), arrival),
        }
    }

    fn end(self, series: &Series, Beside { bench, offsets }: Beside) {
        let mut keys = match json!(series) {
            Value::Object(keys) => keys,
            _ => Map::new(),
        };
        if let Some(offsets) = &offsets {
            keys.insert("offsets".to_owned(), offsets.to_json());
        }
        match self {
            Self::Nothing => {}
            Self::Table { legend, probability, .. } => {
                print_series(&keys, bench.as_ref());
                legend.print(probability);
                if let Some(offsets) = &offsets {
                    say!("{}", offsets.to_table());
                }
            }
            Self::Whole(mut whole) => whole.end(&keys),
            Self::Timed(frames) => {
                let mut head = head(series.conditions.as_ref());
                head.extend(bench.map(|bench| ("bench".to_owned(), bench)));
                let mut whole = Whole::new(head);
                frames.iter().for_each(|frame| whole.frame(frame));
                whole.end(&keys);
            }
            Self::Lines(_) => say_line!("{}", Value::Object(keys)),
        }
    }
}

/// The keys of the document before `frames`.
pub(super) fn head(conditions: Option<&impl serde::Serialize>) -> Map<String, Value> {
    conditions.map(|conditions| ("conditions".to_owned(), json!(conditions))).into_iter().collect()
}

/// What is printed beside the series.
pub(super) struct Beside {
    /// The times of a benchmark.
    pub(super) bench: Option<Value>,
    /// The offsets of the next part.
    pub(super) offsets: Option<OffsetResult>,
}

/// Where the results of frames go.
pub(super) struct Results {
    printed: Printed,
    edges: Option<EdgesFile>,
    warnings: FrameWarnings,
    /// Refused frames before the first that could be measured; `None` once there is one, and of
    /// streams.
    held: Option<Vec<(Measurement, Arrival)>>,
}

impl Results {
    /// Results that are printed, with their edges in a file.
    pub(super) fn new(printed: Printed, edges: Option<EdgesFile>, is_stream: bool) -> Self {
        let held = (!is_stream).then(Vec::new);
        Self { printed, edges, warnings: FrameWarnings::default(), held }
    }

    /// Takes the frame that a stream measured last.
    ///
    /// # Errors
    /// Edges that cannot be written.
    pub(super) fn frame(&mut self, stream: &Stream, arrival: &Arrival) -> Result<(), Failure> {
        let frame = stream.measurement();
        if !self.warnings.count(frame)
            && let Some(held) = self.held.as_mut().filter(|held| held.len() < MOST_HELD)
        {
            held.push((frame.clone(), arrival.clone()));
            return Ok(());
        }
        if let Some(held) = self.held.take() {
            report_uncalibrated(stream);
            for (frame, arrival) in held {
                self.write(&frame, None, &arrival)?;
            }
        }
        self.write(frame, stream.edges(), arrival)
    }

    fn write(
        &mut self,
        frame: &Measurement,
        edges: Option<&FrameEdges>,
        arrival: &Arrival,
    ) -> Result<(), Failure> {
        self.warnings.report(frame);
        if let Some(file) = &mut self.edges {
            let reason = frame.refusal.as_ref().map_or(Reason::Unreadable, |refusal| refusal.reason);
            file.frame(FrameRows {
                stem: &frame.frame,
                columns: frame.columns,
                result: edges.ok_or(reason),
            })?;
        }
        self.printed.frame(frame, arrival);
        Ok(())
    }

    /// Fails where no frame could be measured.
    ///
    /// # Errors
    /// The first frame's reason.
    pub(super) fn check_measured(&self) -> Result<(), Failure> {
        self.warnings.check_measured()
    }

    /// Ends the file of edges.
    ///
    /// # Errors
    /// A disk or permissions that refuse.
    pub(super) fn finish_edges(&mut self) -> Result<(), Failure> {
        self.edges.take().map_or(Ok(()), EdgesFile::finish)
    }

    /// Ends what is printed.
    pub(super) fn end(self, series: &Series, beside: Beside) {
        series.warnings.iter().for_each(|warning| tracing::warn!("{warning}"));
        self.printed.end(series, beside);
    }
}
