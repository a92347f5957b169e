//! Where the frames of a command come from: files, a folder that is followed, or a stream: stdin,
//! raw pixels, Y4M, the simulated head, a camera, a recording.
//!
//! One more kind of source is a variant of [`Address`](crate::source) and an arm of
//! [`StreamSource`]: images to be decoded are an iterator, a source with events of its own (a
//! camera, a recording) is a [`Producer`](crate::source::live::Producer).

use std::fs::File;
use std::io::{BufReader, IsTerminal as _, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::camera_source::CameraSource;
use super::closing::Closing;
use super::encoder_args::{EncoderOf, bound};
use super::frames::paths;
use crate::cell::{HeadPace, SimulatedHead};
use crate::cli::failure::Failure;
use crate::cli::process::interrupt;
use crate::config;
use crate::frame::{BoundSource, CameraBinding};
use crate::position::EncoderSettings;
use crate::render::{BackendChoice, Renderer};
use crate::source::live::{Binding, Live, LiveSettings, Policy, Producer, StoredProducer, taken};
#[cfg(feature = "mcap")]
use crate::source::mcap::Replay;
use crate::source::raw::{RawLayout, RawStream, begins_y4m};
use crate::source::{Address, Ahead, Channel, FileFrames, Follow, Piped, Spare, Taken};

/// Memory of the reader of a pipe, bytes: what a pipe holds.
const PIPE: usize = 1 << 16;
/// Frames of a live source that wait while one is measured: as many as are decoded ahead at least.
const WAITING: usize = 4;
/// Frames of a camera that wait: a camera does not wait itself, and half a second at 30 frames/s
/// covers what a loaded machine does beside.
const OF_CAMERA: usize = 16;

/// Images to be decoded on other threads.
type Images = Box<dyn Iterator<Item = Taken> + Send>;

/// Arguments of the input.
#[derive(Debug, clap::Args)]
pub(crate) struct InputArgs {
    /// Images, stacks or folders of images (grey PNG, TIFF, JPEG, BMP, PGM), in this order; a
    /// folder's by the numbers in their names. Or one stream: `-` is images one after another on
    /// stdin (PNG, raw PGM and its kin, BMP, JPEG) or Y4M, FILE.y4m its grey frames, `raw:-` and
    /// `raw:FILE` pixels as --raw states them, `sim:CONFIG.toml` one scan of a config's shaft,
    /// `replay:FILE.mcap` a recording, `gige:IP` and `gige:NAME` (serial number or user-defined
    /// name) a GigE Vision camera until Ctrl-C.
    #[arg(required_unless_present = "follow", conflicts_with = "follow")]
    input: Vec<PathBuf>,
    #[command(flatten)]
    stream: StreamArgs,
    /// Folder that a camera drops images into: each is measured once, as soon as it is whole. Ends
    /// on Ctrl-C or by --idle-s.
    #[arg(long, value_name = "DIR")]
    follow: Option<PathBuf>,
    /// Ends --follow after S seconds without a new image.
    #[arg(long, value_name = "S", value_parser = seconds)]
    idle_s: Option<Duration>,
}

/// What a stream needs besides its name.
#[derive(Debug, clap::Args)]
pub(crate) struct StreamArgs {
    /// Size and pixel format of `raw:-` and `raw:FILE`: mono8, mono10, mono12, mono16 (little
    /// endian), mono10p, mono12p, mono12packed.
    #[arg(long, value_name = "WIDTHxHEIGHT:FORMAT")]
    raw: Option<RawLayout>,
    /// Exposure time that a camera (`gige:`) is set to, µs; it has its own back at the end. Without
    /// it the camera's own is left.
    #[arg(long, value_name = "US", value_parser = exposure_us)]
    exposure_us: Option<f64>,
    /// Gain that a camera (`gige:`) is set to, dB; it has its own back at the end. Without it the
    /// camera's own is left.
    #[arg(long, value_name = "DB", value_parser = gain_db, allow_negative_numbers = true)]
    gain_db: Option<f64>,
    /// Feature that a camera (`gige:`, `usb:`) is set to, by its name: TriggerMode=On, Width=512,
    /// GevSCPD=1000, GevSCPSPacketSize=1500; again for more, which are set in their order. It has
    /// its own back at the end.
    #[arg(long = "feature", value_name = "NAME=VALUE")]
    features: Vec<String>,
    /// Takes a camera whose shutter exposes row after row, which is refused without: a part that
    /// turns or moves is sheared in its frames, and one at rest is not.
    #[arg(long)]
    accept_rolling_shutter: bool,
}

impl StreamArgs {
    /// A camera as it is asked for.
    fn camera(&self, link: &'static str, name: String) -> CameraSource {
        let (exposure_us, gain_db) = (self.exposure_us, self.gain_db);
        let (features, accepts_rolling_shutter) = (self.features.clone(), self.accept_rolling_shutter);
        CameraSource { link, name, exposure_us, gain_db, features, accepts_rolling_shutter }
    }

    /// The option of a camera that is given, for messages.
    fn of_camera(&self) -> Option<&'static str> {
        let exposure = self.exposure_us.map(|_| "--exposure-us");
        let shutter = self.accept_rolling_shutter.then_some("--accept-rolling-shutter");
        let feature = (!self.features.is_empty()).then_some("--feature");
        exposure.or(self.gain_db.map(|_| "--gain-db")).or(feature).or(shutter)
    }
}

impl InputArgs {
    /// The inputs as they were named.
    pub(crate) fn named(&self) -> Vec<PathBuf> {
        self.input.iter().chain(&self.follow).cloned().collect()
    }
}

/// Parses a time.
///
/// # Errors
/// What is no number of seconds above 0.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let right = || "a number of seconds above 0 is needed, for instance 2.5".to_owned();
    let value: f64 = text.parse().map_err(|_| right())?;
    Some(value).filter(|s| *s > 0.0).and_then(|s| Duration::try_from_secs_f64(s).ok()).ok_or_else(right)
}

/// Parses an exposure time.
///
/// # Errors
/// What is no time above 0.
pub(crate) fn exposure_us(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|us: &f64| us.is_finite() && *us > 0.0);
    value.ok_or_else(|| "a time above 0 is needed, in µs, for instance 50".to_owned())
}

/// Parses a gain.
///
/// # Errors
/// What is no number.
pub(crate) fn gain_db(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|db: &f64| db.is_finite());
    value.ok_or_else(|| "a number of dB is needed, for instance 6".to_owned())
}

/// A camera or a recording that is open, and how its frames are given on.
pub(crate) struct OpenedStream {
    producer: Box<dyn Producer>,
    policy: Policy,
    waiting: usize,
    name: String,
    of: BoundSource,
}

/// A source whose frames come one after another, their number unknown.
pub(crate) enum StreamSource {
    /// Images or Y4M on stdin.
    Stdin,
    /// Raw pixels on stdin.
    RawStdin(RawLayout),
    /// Raw pixels in a file.
    RawFile(PathBuf, RawLayout),
    /// A Y4M file.
    Y4m(PathBuf),
    /// The simulated head of a config.
    Simulation(PathBuf),
    /// A camera, by its address or name.
    Camera(CameraSource),
    /// A recording.
    #[cfg(feature = "mcap")]
    Recording(PathBuf),
    /// A camera or a recording that is open already.
    Opened(OpenedStream),
}

impl StreamSource {
    /// The stream of a source; `None` for files and folders.
    ///
    /// # Errors
    /// Exit 2 for a source that there is not in this build, a terminal, raw pixels without a layout
    /// and a layout without raw pixels.
    pub(crate) fn of(text: &Path, args: &StreamArgs) -> Result<Option<Self>, Failure> {
        let address = Address::of(text).map_err(Failure::refuse)?;
        let layout = || {
            args.raw.ok_or_else(|| {
                let shown = text.display();
                Failure::refuse(format!(
                    "{shown} states no size: give --raw WIDTHxHEIGHT:FORMAT, for instance 2448x2048:mono12"
                ))
            })
        };
        let stream = match address {
            Address::Path(_) => None,
            Address::Stdin => Some(Self::Stdin),
            Address::RawStdin => Some(Self::RawStdin(layout()?)),
            Address::RawFile(path) => Some(Self::RawFile(path, layout()?)),
            Address::Y4m(path) => Some(Self::Y4m(path)),
            Address::Simulation(path) => Some(Self::Simulation(path)),
            Address::Camera(name) => Some(Self::Camera(args.camera("gige", name))),
            Address::UsbCamera(serial) => Some(Self::Camera(args.camera("usb", serial))),
            #[cfg(feature = "mcap")]
            Address::Recording(path) => Some(Self::Recording(path)),
            #[cfg(not(feature = "mcap"))]
            Address::Recording(path) => {
                return Err(Failure::refuse(format!(
                    "replay:{}: this build reads no MCAP recordings; give a folder of images",
                    path.display()
                )));
            }
        };
        if let Some(option) = args.of_camera().filter(|_| !matches!(stream, Some(Self::Camera(_)))) {
            return Err(Failure::refuse(format!(
                "{option} sets a camera (gige:IP, gige:NAME, usb:SERIAL), and {} is none",
                text.display()
            )));
        }
        if args.raw.is_some() && !matches!(stream, Some(Self::RawStdin(_) | Self::RawFile(..))) {
            return Err(Failure::refuse(format!(
                "--raw states the size of raw:- and raw:FILE; {} has its own",
                text.display()
            )));
        }
        let is_stdin = matches!(stream, Some(Self::Stdin | Self::RawStdin(_)));
        if is_stdin && std::io::stdin().is_terminal() {
            return Err(Failure::refuse(format!(
                "{}: stdin is a terminal; pipe images into it",
                text.display()
            )));
        }
        Ok(stream)
    }

    /// Whether its frames stand in a file and wait.
    pub(crate) fn is_file(&self) -> bool {
        #[cfg(feature = "mcap")]
        if matches!(self, Self::Recording(_)) {
            return true;
        }
        matches!(self, Self::RawFile(..) | Self::Y4m(_))
    }

    /// Whether its frames have times of their exposure.
    pub(crate) fn has_times(&self) -> bool {
        !matches!(self, Self::Stdin | Self::RawStdin(_) | Self::RawFile(..) | Self::Y4m(_))
    }

    /// Whether it is a camera or a recording, to which a calibration is bound.
    pub(crate) fn bound_source(&self) -> Option<BoundSource> {
        match self {
            Self::Camera(_) => Some(BoundSource::Camera),
            #[cfg(feature = "mcap")]
            Self::Recording(_) => Some(BoundSource::Recording),
            Self::Opened(stream) => Some(stream.of),
            _ => None,
        }
    }

    /// Opens a camera or a recording, so that it states what a calibration is bound to before
    /// anything is measured; others stay as they are.
    ///
    /// # Errors
    /// One that cannot be opened.
    fn opened(self) -> Result<Self, Failure> {
        Ok(match self {
            Self::Camera(camera) => {
                let name = format!("{}:{}", camera.link, camera.name);
                let (producer, of) = (camera.producer(false)?, BoundSource::Camera);
                let policy = Policy::DropNewest;
                Self::Opened(OpenedStream { producer, policy, waiting: OF_CAMERA, name, of })
            }
            #[cfg(feature = "mcap")]
            Self::Recording(path) => {
                let (producer, of) = (replay(&path)?, BoundSource::Recording);
                let (name, policy) = (path.display().to_string(), Policy::Block);
                Self::Opened(OpenedStream { producer, policy, waiting: WAITING, name, of })
            }
            other => other,
        })
    }

    /// The frames, every one in its order, bound to an encoder beside them where one is given.
    ///
    /// # Errors
    /// A file that cannot be opened, a config that is refused, an encoder beside frames without
    /// times; a system that refuses threads.
    pub(crate) fn ahead(self, read: &Reading, beside: Option<Binding>) -> Result<Ahead, Failure> {
        let (producer, policy, waiting, name) = match self.opened()? {
            Self::Simulation(config) => {
                let name = format!("sim:{}", config.display());
                (head(&config, HeadPace::Scan)?, Policy::Block, WAITING, name)
            }
            Self::Opened(OpenedStream { producer, policy, waiting, name, .. }) => {
                (producer, policy, waiting, name)
            }
            other => {
                check_untimed(beside.as_ref())?;
                return read.ahead(other.images(read)?);
            }
        };
        let settings = LiveSettings { policy, waiting, held: 1 };
        // what does not wait for this program is live
        let is_live = policy != Policy::Block;
        read.live(bound(producer, beside, is_live), settings, name)
    }

    /// The source as a producer of live frames.
    ///
    /// # Errors
    /// As [`Self::ahead`].
    pub(crate) fn producer(self, read: &Reading) -> Result<Box<dyn Producer>, Failure> {
        match self {
            Self::Simulation(config) => head(&config, HeadPace::Live),
            Self::Camera(camera) => camera.producer(true),
            #[cfg(feature = "mcap")]
            Self::Recording(path) => replay(&path),
            Self::Opened(stream) => Ok(stream.producer),
            other => Ok(Box::new(StoredProducer::new(read.ahead(other.images(read)?)?))),
        }
    }

    /// Images to be decoded.
    fn images(self, read: &Reading) -> Result<Images, Failure> {
        let (spare, channel) = (read.spare.clone(), read.channel);
        Ok(match self {
            Self::Stdin => {
                let mut stdin = buffered(std::io::stdin());
                let mut images: Option<Images> = None;
                // The first bytes decide; they are waited for on the reading thread.
                Box::new(std::iter::from_fn(move || {
                    let images = images.get_or_insert_with(|| {
                        let is_y4m = begins_y4m(&mut stdin).unwrap_or(false);
                        let input = std::mem::replace(&mut stdin, buffered(std::io::stdin()));
                        if is_y4m {
                            Box::new(RawStream::y4m(input, "stdin".to_owned()).reusing(spare.clone()))
                        } else {
                            Box::new(Piped::new(input, "stdin", channel).reusing(spare.clone()))
                        }
                    });
                    images.next()
                }))
            }
            Self::RawStdin(layout) => {
                let stdin = buffered(std::io::stdin());
                Box::new(RawStream::new(stdin, "stdin".to_owned(), layout).reusing(spare))
            }
            Self::RawFile(path, layout) => {
                let name = path.display().to_string();
                Box::new(RawStream::new(buffered(opened(&path)?), name, layout).reusing(spare))
            }
            Self::Y4m(path) => {
                let name = path.display().to_string();
                Box::new(RawStream::y4m(buffered(opened(&path)?), name).reusing(spare))
            }
            // Sources with events of their own.
            Self::Simulation(_) | Self::Camera(_) | Self::Opened(_) => Box::new(std::iter::empty()),
            #[cfg(feature = "mcap")]
            Self::Recording(_) => Box::new(std::iter::empty()),
        })
    }
}

/// Refuses an encoder beside frames that come without times.
///
/// # Errors
/// Exit 2 where one is given.
pub(crate) fn check_untimed(beside: Option<&Binding>) -> Result<(), Failure> {
    match beside {
        None => Ok(()),
        Some(_) => Err(Failure::refuse(
            "--encoder-samples and --encoder-triggers need the times of the exposures, which stdin, raw pixels and Y4M have \
             not; give files with frames.csv (t_ns), a recording or a camera",
        )),
    }
}

fn buffered<R: Read>(input: R) -> BufReader<R> {
    BufReader::with_capacity(PIPE, input)
}

fn opened(path: &Path) -> Result<File, Failure> {
    File::open(path).map_err(|error| Failure::fail(format!("{}: {error}", path.display())))
}

/// A recording.
#[cfg(feature = "mcap")]
fn replay(path: &Path) -> Result<Box<dyn Producer>, Failure> {
    match Replay::open(path) {
        Ok(replay) => Ok(Box::new(replay)),
        Err(error) => Err(Failure::fail(format!("{}: {error}", path.display()))),
    }
}

/// The simulated head of a config.
fn head(config: &Path, pace: HeadPace) -> Result<Box<dyn Producer>, Failure> {
    let job = config::load_scene(config).map_err(Failure::refused)?;
    let renderer = Renderer::new(BackendChoice::Auto).map_err(Failure::fail)?;
    let head = SimulatedHead::new(job, renderer, pace).map_err(Failure::refuse)?;
    Ok(Box::new(head))
}

/// How images are read: the channel of colour ones, the threads that decode, the memory, and what
/// becomes true at Ctrl-C.
pub(crate) struct Reading {
    channel: Option<Channel>,
    threads: usize,
    spare: Spare,
    stop: Option<Arc<AtomicBool>>,
    closing: Closing,
}

impl Reading {
    /// On so many threads, of colour images this channel; a stream ends at Ctrl-C.
    pub(crate) fn new(channel: Option<Channel>, threads: usize, is_stream: bool) -> Self {
        let stop = is_stream.then(interrupt::requested);
        Self { channel, threads, spare: Ahead::spare(threads), stop, closing: Closing::new() }
    }

    /// Begins to read images and to decode them.
    fn ahead(&self, images: impl Iterator<Item = Taken> + Send + 'static) -> Result<Ahead, Failure> {
        Ahead::new(images, self.threads, self.stop.clone(), self.spare.clone()).map_err(Failure::fail)
    }

    /// Begins to take the frames of a producer.
    fn live(
        &self,
        producer: Box<dyn Producer>,
        settings: LiveSettings,
        name: String,
    ) -> Result<Ahead, Failure> {
        let live = Live::new(producer, settings).map_err(Failure::fail)?;
        let frames = taken(live, name, self.stop.clone().unwrap_or_default());
        self.ahead(self.closing.guarded(frames))
    }

    /// Frames that are stored, bound to an encoder beside them where one is given.
    fn bound(&self, frames: Ahead, beside: Option<Binding>, name: &str) -> Result<Ahead, Failure> {
        if beside.is_none() {
            return Ok(frames);
        }
        let producer = bound(Box::new(StoredProducer::new(frames)), beside, false);
        let settings = LiveSettings { policy: Policy::Block, waiting: WAITING, held: 1 };
        self.live(producer, settings, name.to_owned())
    }

    /// The frames of a folder as they come, until none has come for the time `idle`.
    ///
    /// # Errors
    /// A folder that cannot be listed; a system that refuses threads.
    pub(crate) fn followed(&self, folder: PathBuf, idle: Option<Duration>) -> Result<Ahead, Failure> {
        let follow = Follow::new(folder, self.channel, idle, self.stop.clone().unwrap_or_default());
        self.ahead(follow.map_err(Failure::fail)?.reusing(self.spare.clone()))
    }

    /// The frames of files, their angles from the counts of this encoder where one is given.
    ///
    /// # Errors
    /// A system that refuses threads.
    pub(crate) fn files(
        &self,
        paths: Vec<PathBuf>,
        encoder: Option<EncoderSettings>,
    ) -> Result<Ahead, Failure> {
        let files = FileFrames::new(paths).of_channel(self.channel).by_encoder(encoder);
        self.ahead(files.reusing(self.spare.clone()).undecoded())
    }
}

/// Where frames come from.
pub(crate) enum Input {
    /// Files that are there.
    Files(Vec<PathBuf>),
    /// A folder that a camera drops images into, and the time without a new one that ends it.
    Folder(PathBuf, Option<Duration>),
    /// Frames one after another.
    Stream(StreamSource),
}

/// The frames of an input, decoded ahead.
pub(crate) struct Opened {
    pub(crate) frames: Ahead,
    /// Whether Ctrl-C ended a stream; `None` for files.
    pub(crate) stop: Option<Arc<AtomicBool>>,
    /// Waits for the source to close, when it is dropped after the frames.
    _closing: Closing,
}

impl Input {
    /// The input of the arguments.
    ///
    /// # Errors
    /// An input that cannot be read, a folder without images; exit 2 for a stream beside files, and
    /// as [`StreamSource::of`].
    pub(crate) fn of(args: &InputArgs) -> Result<Self, Failure> {
        if args.follow.is_some() && args.stream.raw.is_some() {
            return Err(Failure::refuse("--raw belongs to raw:- and raw:FILE, not to --follow DIR"));
        }
        if let Some(folder) = &args.follow {
            return Ok(Self::Folder(folder.clone(), args.idle_s));
        }
        // Clap leaves the requirement out, because --follow excludes the inputs that are there.
        if args.idle_s.is_some() {
            return Err(Failure::refuse("--idle-s ends --follow DIR: give the folder by --follow"));
        }
        for text in &args.input {
            let is_alone = args.input.len() == 1;
            match StreamSource::of(text, &args.stream)? {
                Some(stream) if is_alone => return Ok(Self::Stream(stream)),
                Some(_) => {
                    let shown = text.display();
                    return Err(Failure::refuse(format!(
                        "{shown} (a stream) stands alone; a file of that name is ./{shown}"
                    )));
                }
                None => {}
            }
        }
        paths(&args.input).map(Self::Files)
    }

    /// Its files, where these are there already.
    pub(crate) fn files(&self) -> &[PathBuf] {
        match self {
            Self::Files(paths) => paths,
            Self::Folder(..) | Self::Stream(_) => &[],
        }
    }

    /// Opens a camera or a recording; see [`Self::bound_to`].
    ///
    /// # Errors
    /// One that cannot be opened.
    pub(crate) fn opened(self) -> Result<Self, Failure> {
        Ok(match self {
            Self::Stream(stream) => Self::Stream(stream.opened()?),
            other => other,
        })
    }

    /// The camera of an open camera or recording, where it is known; `None` for other inputs.
    pub(crate) fn bound_to(&self) -> Option<(BoundSource, Option<&CameraBinding>)> {
        match self {
            Self::Stream(StreamSource::Opened(stream)) => Some((stream.of, stream.producer.camera())),
            _ => None,
        }
    }

    /// Whether frames come as a camera takes them, their number unknown.
    pub(crate) fn is_stream(&self) -> bool {
        !matches!(self, Self::Files(_))
    }

    /// Begins to read it and to decode on so many threads, of colour images this channel, with the
    /// angles of this encoder.
    ///
    /// # Errors
    /// A folder that cannot be listed, a file that cannot be opened; a system that refuses threads.
    pub(crate) fn open(
        self,
        channel: Option<Channel>,
        encoder: EncoderOf,
        threads: usize,
    ) -> Result<Opened, Failure> {
        let read = Reading::new(channel, threads, self.is_stream());
        let EncoderOf { in_table, beside } = encoder;
        let frames = match self {
            Self::Files(paths) => {
                read.files(paths, in_table).and_then(|frames| read.bound(frames, beside, "frames"))
            }
            Self::Folder(folder, idle) => {
                let name = folder.display().to_string();
                read.followed(folder, idle).and_then(|frames| read.bound(frames, beside, &name))
            }
            Self::Stream(stream) => stream.ahead(&read, beside),
        };
        Ok(Opened { frames: frames?, stop: read.stop, _closing: read.closing })
    }
}
