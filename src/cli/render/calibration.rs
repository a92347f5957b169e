//! `shadowgauge render` of a calibration's file with `[simulate]`: the frames that `calibrate`
//! measures, in folders, with their true edges, and the calibration's config for these folders.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use indicatif::ProgressBar;

use super::args::RenderArgs;
use super::folder_files::{FRAMES_HEADER, describe, of_render, put};
use super::frame_files::encode;
use crate::cli::calibration_plan::{self, LoadedPlan};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::terminal::progress;
use crate::files::OutputFolder;
use crate::frame::Frame;
use crate::gauge::calibration::Date;
use crate::render::Renderer;
use crate::studies::calibration::{CalibrationPlan, Recordings, SimulatedRecordings};
use crate::truth;

/// Draws the fields and pins of the plan in `file`.
///
/// # Errors
/// Exit 2 for a plan, a command line or a folder that is refused; 3 for a device or a disk that
/// fails.
pub(crate) fn run(args: &RenderArgs, file: &Path) -> CommandResult {
    let LoadedPlan { plan, text, .. } = calibration_plan::load(file, Date::of(SystemTime::now()))?;
    if plan.simulate.is_none() {
        return Err(
            text.refuse("is the calibration of recorded frames: there is nothing to draw without [simulate]")
        );
    }
    plan.validate().map_err(|e| text.refuse_at(e))?;
    let Some(out) = &args.out else {
        return Err(Failure::refuse(
            "--bench is for a job's config: a calibration's is drawn with --out DIR",
        ));
    };
    if args.frames.is_some() || args.windows.is_some() {
        return Err(Failure::refuse(
            "--frames and --windows are for a job's config: a calibration says what it needs",
        ));
    }
    let folder = OutputFolder::claim(out)?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let positions: usize = plan.masters.iter().chain(&plan.check).map(|pin| pin.positions.len()).sum();
    let bar = progress::bar((positions + plan.fields.flats.len()) as u64, "drawing", "recordings");
    let writer = Writer { args, plan: &plan, folder: &folder, um_per_px: 0.0, count: 0, bar: bar.clone() };
    let count = writer.write(&renderer)?;
    bar.finish_and_clear();
    folder.finish()?;
    say_line!(
        "{count} frames of {} pins and {} flat fields by {} ({}) in {}; calibrate them by {}",
        plan.masters.len() + usize::from(plan.check.is_some()),
        plan.fields.flats.len(),
        renderer.backend_name(),
        renderer.adapter_name(),
        out.display(),
        out.join(RECORDED).display()
    );
    Ok(Outcome::Done)
}

/// The calibration of the folders.
const RECORDED: &str = "calibrate.toml";

struct Writer<'a> {
    args: &'a RenderArgs,
    plan: &'a CalibrationPlan,
    folder: &'a OutputFolder,
    um_per_px: f64,
    count: usize,
    bar: ProgressBar,
}

impl Writer<'_> {
    /// Everything in the order of `calibrate`: frame numbers, and with them the noise, are then the
    /// same.
    fn write(mut self, renderer: &Renderer) -> Result<usize, Failure> {
        let mut recordings = SimulatedRecordings::new(self.plan, renderer).map_err(Failure::refuse)?;
        let simulate = self.plan.simulate.clone().unwrap_or_default();
        self.um_per_px = 1e3 * simulate.setup().nominal_pixel_mm();
        let mut recorded = CalibrationPlan { simulate: None, ..self.plan.clone() };
        let dark = recordings.dark(self.plan).map_err(Failure::fail)?;
        if !dark.is_empty() {
            self.put_all("dark", &dark)?;
            recorded.fields.dark = Some(PathBuf::from("dark"));
        }
        for (index, flat) in recorded.fields.flats.iter_mut().enumerate() {
            let frames = recordings.flat(self.plan, index).map_err(Failure::fail)?;
            let name = format!("flat_{index}");
            self.put_all(&name, &frames)?;
            flat.frames = Some(PathBuf::from(name));
        }
        let mut truth_csv = String::from("frame,column,top_px,bottom_px\n");
        let pins = recorded.masters.iter_mut().chain(recorded.check.as_mut());
        for (index, pin) in pins.enumerate() {
            for (place, position) in pin.positions.iter_mut().enumerate() {
                let name = format!("pin_{index}_{place}");
                let mut frames = Vec::new();
                for (k, (laid, number)) in recordings.laid(index, position).into_iter().enumerate() {
                    let setup = recordings.setup();
                    frames.push(setup.numbered(&laid, number, !self.args.no_noise).map_err(of_render)?);
                    let request = crate::render::FrameRequest::default();
                    let scene = setup.scene(&laid).map_err(of_render)?;
                    for (column, e) in
                        truth::true_edges(&scene, &request).map_err(of_render)?.iter().enumerate()
                    {
                        let _ =
                            writeln!(truth_csv, "{name}/{k:06},{column},{:.6},{:.6}", e.top_px, e.bottom_px);
                    }
                }
                self.put_all(&name, &frames)?;
                position.frames = Some(PathBuf::from(name));
            }
        }
        put(self.folder, "truth.csv", Ok(truth_csv.into_bytes()))?;
        let text = toml::to_string(&recorded).map_err(Failure::fail)?;
        put(self.folder, RECORDED, Ok(text.into_bytes()))?;
        Ok(self.count)
    }

    fn put_all(&mut self, name: &str, frames: &[Frame]) -> Result<(), Failure> {
        let mut table = String::from(FRAMES_HEADER);
        for (k, frame) in frames.iter().enumerate() {
            let file = format!("{name}/{k:06}.{}", self.args.format.extension());
            put(self.folder, &file, encode(frame, self.args.format, self.um_per_px))?;
            describe(&mut table, &format!("{k:06}"), frame, self.um_per_px);
        }
        put(self.folder, &format!("{name}/frames.csv"), Ok(table.into_bytes()))?;
        self.count += frames.len();
        self.bar.inc(1);
        Ok(())
    }
}
