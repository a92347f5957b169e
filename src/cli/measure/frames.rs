//! Frames of `measure`: their files and order, their channel, scale and encoding; each note on
//! these is logged once.

use std::collections::HashSet;
use std::path::PathBuf;

use crate::cli::failure::Failure;
use crate::frame::Frame;
use crate::gauge::Calibration;
use crate::source::{
    Ahead, Arrival, Channel, FileFrames, FileScale, SAME_SCALE, StoredFrame, listing, out_of_order,
};

/// How far a camera's nominal scale may lie from a calibrated one: makers specify the magnification
/// of lenses to about 1 %.
const NOMINAL_SCALE: f64 = 0.01;

/// Arguments that say how files are read.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct FrameArgs {
    /// Channel of colour images that is measured; without it red, green and blue must be equal.
    #[arg(long, value_enum, value_name = "r|g|b", hide_possible_values = true)]
    channel: Option<Channel>,
    /// Takes the scale given, or the calibration's, though that of a file (frames.csv, its tags) is
    /// another one.
    #[arg(long)]
    ignore_file_scale: bool,
}

impl FrameArgs {
    /// The channel of colour images.
    pub(crate) fn channel(&self) -> Option<Channel> {
        self.channel
    }
}

/// `--um-per-px`: a scale, or the files' own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ScaleArgument {
    /// µm per pixel.
    Given(f64),
    /// The scale in `frames.csv` or in the file's own tags.
    File,
}

/// Parses `--um-per-px`.
///
/// # Errors
/// An argument that is not a scale: the message gives the valid values.
pub(crate) fn scale_argument(text: &str) -> Result<ScaleArgument, String> {
    if text == "file" {
        return Ok(ScaleArgument::File);
    }
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(ScaleArgument::Given(value)),
        _ => Err("a scale above 0 in µm per pixel is needed, for instance 17.4, or `file`".to_owned()),
    }
}

/// The images of all inputs; folders in the order of the numbers in their names, which is reported
/// where it differs from alphabetical order.
///
/// # Errors
/// An input that cannot be read, a folder without images.
pub(crate) fn paths(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut paths = Vec::new();
    for input in inputs {
        let listed = listing(input).map_err(Failure::fail)?;
        if let Some((first, second)) = &listed.reordered {
            tracing::warn!(
                "{}: frames are taken in the order of their numbers: {second} before {first}",
                input.display()
            );
        }
        paths.extend(listed.images);
    }
    if inputs.len() > 1
        && inputs.is_sorted()
        && let Some((first, second)) = out_of_order(inputs)
    {
        tracing::warn!(
            "frames are taken in the order given, {first} before {second}; give their folder for the order of their numbers"
        );
    }
    Ok(paths)
}

/// The scale in µm/px and the frame that states it: the first one's.
///
/// # Errors
/// Where no file states a scale of the object.
pub(crate) fn scale_of_files(args: &FrameArgs, paths: &[PathBuf]) -> Result<f64, Failure> {
    let mut source = FileFrames::new(paths.to_vec()).of_channel(args.channel);
    let mut first_error = None;
    while let Some(stem) = source.next_stem() {
        let Some(read) = source.next_stored() else { break };
        match read.map_err(|e| e.to_string()).and_then(|stored| own_scale(stored.scale.as_ref())) {
            Ok(scale) => return Ok(scale),
            Err(error) => first_error.get_or_insert(format!("frame {stem}: {error}")),
        };
    }
    Err(Failure::fail(first_error.unwrap_or_else(|| "no frame".to_owned())))
}

fn own_scale(scale: Option<&FileScale>) -> Result<f64, String> {
    let none = "no scale in frames.csv (um_per_px) or in the file's tags (pHYs, TIFF resolution): give it (--um-per-px S)";
    scale.ok_or(none)?.of_object()
}

/// What the source of a frame states of it beside its pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatedOf<'a> {
    /// Name of the frame.
    pub stem: &'a str,
    /// Scale of the table or of the file's own tags.
    pub scale: Option<&'a FileScale>,
    /// Changes made to the values of the file.
    pub changed: &'a [String],
}

/// Whether frames go with a calibration; each note on them is logged once.
pub(crate) struct FrameChecks<'a> {
    args: &'a FrameArgs,
    calibration: Option<&'a Calibration>,
    scale: Option<ScaleArgument>,
    noted: HashSet<String>,
}

impl<'a> FrameChecks<'a> {
    /// Checks of frames that are measured by this calibration; `scale` is the command line's own.
    pub(crate) fn new(
        args: &'a FrameArgs,
        calibration: Option<&'a Calibration>,
        scale: Option<ScaleArgument>,
    ) -> Self {
        Self { args, calibration, scale, noted: HashSet::new() }
    }

    /// Logs changes of grey values at their first occurrence; refuses a scale or encoding other
    /// than the calibration's.
    ///
    /// # Errors
    /// Which, with the frame and what would be right.
    pub(crate) fn check(&mut self, of: StatedOf<'_>, frame: &Frame) -> Result<(), String> {
        self.checked(of, frame).map_err(|e| format!("frame {}: {e}", of.stem))
    }

    fn checked(&mut self, of: StatedOf<'_>, frame: &Frame) -> Result<(), String> {
        for change in of.changed {
            if self.noted.insert(change.clone()) {
                tracing::warn!("frame {}: {change}; this is said once", of.stem);
            }
        }
        let Some(calibration) = self.calibration else { return Ok(()) };
        calibration.check_encoding(frame.meta.encoding).map_err(|e| e.to_string())?;
        let used_um_per_px = 1e3 * calibration.scale_mm_per_px;
        match self.scale {
            Some(ScaleArgument::File) => same_as_first(of, used_um_per_px),
            _ if self.args.ignore_file_scale => Ok(()),
            given => self.same_as_used(of, used_um_per_px, given.is_some()),
        }
    }

    /// A scale given by the user is refused where the file states another one. A calibration on
    /// masters is better than a file's nominal scale: a small difference is then reported once.
    fn same_as_used(&mut self, of: StatedOf<'_>, used_um_per_px: f64, typed: bool) -> Result<(), String> {
        let used = if typed { "--um-per-px" } else { "the calibration" };
        let Some(own) = of.scale else { return Ok(()) };
        let Err(error) = own.check(used_um_per_px, used) else { return Ok(()) };
        if typed || own.departure(used_um_per_px) > NOMINAL_SCALE {
            return Err(format!("{error}: give the right one, correct the file, or say --ignore-file-scale"));
        }
        if self.noted.insert("nominal scale".to_owned()) {
            tracing::warn!("frame {}: {error}; the calibration's is taken; this is said once", of.stem);
        }
        Ok(())
    }
}

/// The frames of a command, one after another.
pub(crate) struct Frames<'a> {
    source: Ahead,
    checks: FrameChecks<'a>,
    /// Why the source ended before its end.
    broken: Option<String>,
}

impl<'a> Frames<'a> {
    /// Frames of a source, checked.
    pub(crate) fn new(source: Ahead, checks: FrameChecks<'a>) -> Self {
        Self { source, checks, broken: None }
    }

    /// The next frame with its name and times, or why it cannot be read.
    pub(crate) fn next_frame(&mut self) -> Option<(Arrival, Result<Frame, String>)> {
        let (arrival, read) = match self.source.next_frame()? {
            Ok(next) => next,
            Err(error) => {
                self.broken = Some(error.to_string());
                return None;
            }
        };
        for notice in &arrival.notices {
            tracing::warn!("{notice}");
        }
        let frame = read.map_err(|e| e.to_string()).and_then(|stored| {
            let StoredFrame { frame, scale, changed, .. } = stored;
            let of = StatedOf { stem: &arrival.stem, scale: scale.as_ref(), changed: &changed };
            self.checks.check(of, &frame).map(|()| frame)
        });
        Some((arrival, frame))
    }

    /// Takes back a frame, whose memory one of the next frames uses.
    pub(crate) fn give_back(&self, frame: Frame) {
        self.source.give_back(frame);
    }

    /// Why the source ended before its end, if it did.
    ///
    /// # Errors
    /// A source that failed.
    pub(crate) fn check_ended(&self) -> Result<(), Failure> {
        self.broken.as_ref().map_or(Ok(()), |why| Err(Failure::fail(why)))
    }
}

fn same_as_first(of: StatedOf<'_>, first_um_per_px: f64) -> Result<(), String> {
    let own = own_scale(of.scale)?;
    if (own / first_um_per_px - 1.0).abs() <= SAME_SCALE {
        return Ok(());
    }
    let origin = of.scale.map_or("", |s: &FileScale| &s.origin);
    Err(format!(
        "{origin}: a scale of {own:.6} µm/px, but the first frame's is {first_um_per_px:.6}; frames of one scale are needed"
    ))
}
