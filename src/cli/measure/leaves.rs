//! What leaves `measure` beside its table: `--csv`, `--report` and `--midline`.
//!
//! In: every frame as it is measured, then the series. Out: the files, each whole or not at all.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::csv_file::DiameterRows;
use super::edges_file::claim_output;
use crate::cli::failure::Failure;
use crate::cli::store::args::StoreArgs;
use crate::cli::store::measured::MeasuredStore;
use crate::files::{OpenOutput, OutputFile};
use crate::frame::Frame;
use crate::gauge::Calibration;
use crate::gauge::calibration::{Conditions, Date};
use crate::identification::midline_file::MidlineRows;
use crate::measurement::{MeasureSettings, Series, Stream};
use crate::report::measure_report::{MeasureReport, MeasureSetup};

/// Files for people and for other programs.
#[derive(Debug, clap::Args)]
pub(crate) struct LeavesArgs {
    /// Writes the diameters in mm with U and judgement to this CSV file: a row a frame, and with
    /// --station-mm a row a station; `-` is stdout, in place of the table.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Writes a report to this HTML file: verdict, values with U and limits, what was refused and
    /// why, calibration, budget; it needs nothing beside it and prints on A4.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Writes height and slope of the midline of both edges to this CSV file, a row a frame:
    /// readings of `calibrate machine` (instrument = "midline"), by z_mm and angle_deg of
    /// frames.csv.
    #[arg(long, value_name = "FILE.csv")]
    midline: Option<PathBuf>,
    #[command(flatten)]
    store: StoreArgs,
}

impl LeavesArgs {
    /// The first option given, if any.
    pub(super) fn given(&self) -> Option<&'static str> {
        [
            (self.csv.is_some(), "--csv"),
            (self.report.is_some(), "--report"),
            (self.midline.is_some(), "--midline"),
            (self.store.file().is_some(), "--store"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
    }

    /// Whether a report is asked for, which shows a budget.
    pub(super) fn has_report(&self) -> bool {
        self.report.is_some()
    }
}

/// The files that no output may be, and whether stdout takes a document already.
#[derive(Clone, Debug)]
pub(super) struct Inputs<'a> {
    /// The inputs as they were named.
    pub(super) named: &'a [PathBuf],
    /// The images of all of them.
    pub(super) images: &'a [PathBuf],
    /// Files read beside the frames.
    pub(super) others: Vec<PathBuf>,
    /// Whether `--json` goes to stdout.
    pub(super) json: bool,
    /// Whether frames come one by one, so that each row is given on at once.
    pub(super) is_stream: bool,
}

/// With what the frames are measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredBy<'a> {
    pub(super) calibration: Option<&'a Calibration>,
    pub(super) conditions: &'a Conditions,
    pub(super) settings: &'a MeasureSettings,
    /// Whether the budgets that the report needs were asked for by themselves too.
    pub(super) shows_budgets: bool,
}

/// The files while frames are measured.
#[derive(Debug)]
pub(super) struct Leaves {
    csv: Option<DiameterRows<OpenOutput>>,
    report: Option<(OutputFile, MeasureReport)>,
    midline: Option<(OutputFile, MidlineRows)>,
    store: Option<MeasuredStore>,
    is_stdout: bool,
    is_stream: bool,
    shows_budgets: bool,
}

impl Leaves {
    /// Claims the files before anything is measured.
    ///
    /// # Errors
    /// Exit 2 for a file that is an input, stdout twice, diameters without a scale; 3 for one that
    /// cannot be written.
    pub(super) fn begin(
        args: &LeavesArgs,
        inputs: &Inputs<'_>,
        by: &MeasuredBy<'_>,
    ) -> Result<Self, Failure> {
        let calibration = match (args.given(), by.calibration) {
            (Some(name), None) => {
                return Err(Failure::refuse(format!(
                    "{name} needs millimetres: give --calibration or --um-per-px"
                )));
            }
            (_, calibration) => calibration,
        };
        let claim = |name: &str, path: &Path| {
            claim_output(name, path, inputs.images, inputs.others.clone(), inputs.json)
        };
        let csv = args.csv.as_ref().map(|path| claim("--csv", path)).transpose()?;
        let report = args.report.as_ref().map(|path| claim("--report", path)).transpose()?;
        let midline = args.midline.as_ref().map(|path| claim("--midline", path)).transpose()?;
        let named: Vec<String> = inputs.named.iter().map(|path| path.display().to_string()).collect();
        let page = calibration.map(|calibration| {
            MeasureReport::begin(&MeasureSetup {
                inputs: &named,
                date: Date::of(SystemTime::now()),
                calibration,
                conditions: by.conditions,
                settings: by.settings,
            })
        });
        let store = match (args.store.open()?, calibration) {
            (Some(store), Some(calibration)) => Some(MeasuredStore::begin(store, inputs.named, calibration)?),
            _ => None,
        };
        let is_stdout = csv.iter().chain(&report).chain(&midline).any(OutputFile::is_stdout);
        let begin = |file: OutputFile| {
            DiameterRows::begin(file.begin()?, by.settings.factor_of_means()).map_err(Failure::fail)
        };
        Ok(Self {
            csv: csv.map(begin).transpose()?,
            report: report.zip(page),
            midline: midline.map(|file| (file, MidlineRows::default())),
            store,
            is_stdout,
            is_stream: inputs.is_stream,
            shows_budgets: by.shows_budgets,
        })
    }

    /// Whether one of them is stdout, which then has no table.
    pub(super) fn is_stdout(&self) -> bool {
        self.is_stdout
    }

    /// Adds the frame that the stream measured last; a budget that the report alone needs is taken
    /// out of it.
    ///
    /// # Errors
    /// Exit 3 where the disk or the permissions refuse.
    pub(super) fn add(&mut self, stream: &mut Stream, frame: Option<&Frame>) -> Result<(), Failure> {
        if let Some(rows) = &mut self.csv {
            let added = rows.add(stream.measurement());
            let added = added.and_then(|()| if self.is_stream { Ok(rows.flush()?) } else { Ok(()) });
            added.map_err(|error| rows.failed(error))?;
        }
        if let Some((_, report)) = &mut self.report {
            report.add(stream.measurement(), frame);
        }
        if let (Some((_, rows)), Some(frame)) = (&mut self.midline, frame) {
            rows.add(&frame.meta, stream.measurement().midline);
        }
        if let Some(store) = &mut self.store {
            store.add(stream.measurement())?;
        }
        if !self.shows_budgets {
            stream.leave_out_budget();
        }
        Ok(())
    }

    /// Writes them.
    ///
    /// # Errors
    /// Exit 2 for midlines of frames without places, 3 where a chart cannot be drawn, or the disk
    /// or the permissions refuse.
    pub(super) fn finish(self, series: &Series) -> Result<(), Failure> {
        // Page and midline are made before any file appears.
        let of_text = |(file, rows): (OutputFile, MidlineRows)| {
            let text = rows.text().map_err(|why| Failure::refuse(format!("--midline {why}")))?;
            Ok::<_, Failure>((file, text))
        };
        let midline = self.midline.filter(|(_, rows)| !rows.is_empty()).map(of_text).transpose()?;
        let page = self
            .report
            .map(|(file, report)| Ok::<_, Failure>((file, report.finish(series).map_err(Failure::fail)?)));
        let page = page.transpose()?;
        if let Some(mut rows) = self.csv {
            rows.flush().map_err(|error| rows.failed(error.into()))?;
            rows.finish().map_err(Failure::fail)?.finish()?;
        }
        if let Some(mut store) = self.store {
            store.finish()?;
        }
        if let Some((file, html)) = page {
            file.write(html.as_bytes())?;
        }
        if let Some((file, text)) = midline {
            file.write(text.as_bytes())?;
        }
        Ok(())
    }
}
