//! Where the frames of `measure` come from: files, a folder that is followed, or stdin.

use std::io::{BufReader, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::frames::paths;
use crate::cli::failure::Failure;
use crate::cli::process::interrupt;
use crate::position::EncoderSettings;
use crate::source::{Ahead, Channel, FileFrames, Follow, Piped};

/// Memory of the reader of stdin, bytes: what a pipe holds.
const PIPE: usize = 1 << 16;

/// Arguments of the input.
#[derive(Debug, clap::Args)]
pub(crate) struct InputArgs {
    /// Images, stacks or folders of images (grey PNG, TIFF, JPEG, BMP, PGM), in this order; a
    /// folder's by the numbers in their names. `-`: images one after another on stdin (PNG, raw PGM
    /// and its kin, BMP, JPEG).
    #[arg(required_unless_present = "follow", conflicts_with = "follow")]
    input: Vec<PathBuf>,
    /// Folder that a camera drops images into: each is measured once, as soon as it is whole. Ends
    /// on Ctrl-C or by --idle-s.
    #[arg(long, value_name = "DIR")]
    follow: Option<PathBuf>,
    /// Ends --follow after S seconds without a new image.
    #[arg(long, value_name = "S", value_parser = seconds)]
    idle_s: Option<Duration>,
}

impl InputArgs {
    /// The inputs as they were named.
    pub(crate) fn named(&self) -> Vec<PathBuf> {
        self.input.iter().chain(&self.follow).cloned().collect()
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let right = || "a number of seconds above 0 is needed, for instance 2.5".to_owned();
    let value: f64 = text.parse().map_err(|_| right())?;
    Some(value).filter(|s| *s > 0.0).and_then(|s| Duration::try_from_secs_f64(s).ok()).ok_or_else(right)
}

/// Where frames come from.
pub(crate) enum Input {
    /// Files that are there.
    Files(Vec<PathBuf>),
    /// A folder that a camera drops images into, and the time without a new one that ends it.
    Folder(PathBuf, Option<Duration>),
    /// Images one after another on stdin.
    Stdin,
}

/// The frames of an input, decoded ahead.
pub(crate) struct Opened {
    pub(crate) frames: Ahead,
    /// Whether Ctrl-C ended a stream; `None` for files.
    pub(crate) stop: Option<Arc<AtomicBool>>,
}

impl Input {
    /// The input of the arguments.
    ///
    /// # Errors
    /// An input that cannot be read, a folder without images; exit 2 for `-` beside files and for a
    /// terminal.
    pub(crate) fn of(args: &InputArgs) -> Result<Self, Failure> {
        if let Some(folder) = &args.follow {
            return Ok(Self::Folder(folder.clone(), args.idle_s));
        }
        // Clap leaves the requirement out, because --follow excludes the inputs that are there.
        if args.idle_s.is_some() {
            return Err(Failure::refuse("--idle-s ends --follow DIR: give the folder by --follow"));
        }
        if !args.input.iter().any(|path| path == Path::new("-")) {
            return paths(&args.input).map(Self::Files);
        }
        if args.input.len() > 1 {
            return Err(Failure::refuse("- (images on stdin) stands alone; a file of that name is ./-"));
        }
        if std::io::stdin().is_terminal() {
            return Err(Failure::refuse("-: stdin is a terminal; pipe images into it"));
        }
        Ok(Self::Stdin)
    }

    /// Its files, where these are there already.
    pub(crate) fn files(&self) -> &[PathBuf] {
        match self {
            Self::Files(paths) => paths,
            Self::Folder(..) | Self::Stdin => &[],
        }
    }

    /// Whether frames come as a camera takes them, their number unknown.
    pub(crate) fn is_stream(&self) -> bool {
        !matches!(self, Self::Files(_))
    }

    /// Begins to read it and to decode on so many threads, of colour images this channel, of files
    /// with the angles of this encoder.
    ///
    /// # Errors
    /// A folder that cannot be listed; a system that refuses threads.
    pub(crate) fn open(
        self,
        channel: Option<Channel>,
        encoder: Option<EncoderSettings>,
        threads: usize,
    ) -> Result<Opened, Failure> {
        let stop = self.is_stream().then(interrupt::requested);
        let (ended, spare) = (stop.clone(), Ahead::spare(threads));
        let frames = match self {
            Self::Files(paths) => {
                let files = FileFrames::new(paths).of_channel(channel).by_encoder(encoder);
                let files = files.reusing(spare.clone());
                Ahead::new(files.undecoded(), threads, ended, spare)
            }
            Self::Folder(folder, idle) => {
                let follow = Follow::new(folder, channel, idle, stop.clone().unwrap_or_default());
                let follow = follow.map_err(Failure::fail)?.reusing(spare.clone());
                Ahead::new(follow, threads, ended, spare)
            }
            Self::Stdin => {
                let stdin = BufReader::with_capacity(PIPE, std::io::stdin());
                let piped = Piped::new(stdin, "stdin", channel).reusing(spare.clone());
                Ahead::new(piped, threads, ended, spare)
            }
        };
        Ok(Opened { frames: frames.map_err(Failure::fail)?, stop })
    }
}
