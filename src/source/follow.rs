//! A folder that a camera drops images into: each image once, as soon as it is whole.
//!
//! The folder is listed again and again. New names are taken in their natural order; one whose
//! image is not whole yet holds back those after it, as frames of a series have an order. A PNG,
//! BMP or JPEG is whole once its own end is there. Other formats state none: they are whole once
//! two looks found the same file and its last page can be decoded. Where a `frames.csv` lies beside
//! the images, its row is part of a frame. What stays unfinished is given as it is, to be refused
//! by its error.
//!
//! A folder of a network drive sends no notices to whom it is mounted; looking works anywhere.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, VecDeque};
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use super::error::damaged;
use super::folder::{FileFrames, each_image, name};
use super::host_clock::host_t_ns;
use super::natural_order::natural;
use super::raster::Channel;
use super::read_error::ReadError;
use super::spare::Spare;
use super::split::{Piece, is_whole_png, next_image};
use super::stored::{Arrival, Taken, Undecoded};

/// Time between two looks: a camera of 20 frames a second is followed frame by frame, and a look at
/// a file costs some microseconds.
const LOOK: Duration = Duration::from_millis(50);
/// A listing takes at most one part in so many of the time: folders of 100 000 files take some tens
/// of milliseconds.
const LISTING_SHARE: u32 = 10;
/// Time after its last change for which a file that is not whole is waited for: longer than a
/// program that still writes pauses between two blocks.
const PATIENCE: Duration = Duration::from_secs(2);

/// The images of a folder, in the order in which they come.
#[derive(Debug)]
pub(crate) struct Follow {
    folder: PathBuf,
    frames: FileFrames,
    idle: Option<Duration>,
    stop: Arc<AtomicBool>,
    known: Known,
    queue: VecDeque<PathBuf>,
    first: Look,
    last_new: Instant,
    next_listing: Instant,
    /// The tables of frames beside the images and above their folder.
    tables: [Option<Stamp>; 2],
    has_ended: bool,
    spare: Spare,
}

/// Names in the folder that were queued already, each with the last listing that found it: about a
/// hundred bytes a file that stays.
#[derive(Debug, Default)]
struct Known {
    names: HashMap<OsString, u64>,
    listings: u64,
}

impl Known {
    /// Lists the folder: the images that are new, in their natural order.
    fn new_in(&mut self, folder: &Path) -> std::io::Result<Vec<PathBuf>> {
        self.listings += 1;
        let (listing, mut new) = (self.listings, Vec::new());
        each_image(folder, |name| match self.names.entry(name) {
            Entry::Occupied(mut last) => *last.get_mut() = listing,
            Entry::Vacant(place) => {
                new.push(folder.join(place.key()));
                place.insert(listing);
            }
        })?;
        // Only names that are still there: what was taken away takes no memory.
        self.names.retain(|_, last| *last == listing);
        new.sort_by(|a, b| natural(&name(a), &name(b)).then_with(|| a.cmp(b)));
        Ok(new)
    }
}

/// Size of a file and time of its last change.
type Stamp = (u64, Option<SystemTime>);

fn stamp(path: &Path) -> std::io::Result<Stamp> {
    let found = std::fs::metadata(path)?;
    Ok((found.len(), found.modified().ok()))
}

/// What the looks at the first file of the queue found.
#[derive(Debug)]
struct Look {
    stamp: Option<Stamp>,
    /// Looks that found this stamp.
    times: u32,
    since: Instant,
}

impl Look {
    fn none() -> Self {
        Self { stamp: None, times: 0, since: Instant::now() }
    }

    /// Whether the file stood unchanged from one look to the next, or for as long before.
    fn is_settled(&self) -> bool {
        let changed = self.stamp.and_then(|(_, changed)| changed);
        let age = changed.and_then(|changed| SystemTime::now().duration_since(changed).ok());
        self.times > 1 || age.is_some_and(|age| age >= 2 * LOOK)
    }
}

/// What of a file is there.
enum Shown {
    /// All of it.
    All,
    /// It ends within the image.
    Part,
    /// Its format does not state it.
    Unknown,
}

/// What is to be done with the first file of the queue.
enum Found {
    /// Its first frame.
    Frame(Box<(Arrival, Result<Undecoded, ReadError>)>),
    /// It may be written still.
    Unfinished,
    /// It was taken away.
    Gone,
}

impl Follow {
    /// Follows a folder until `stop` is true, or until no new image has come for the time `idle`.
    ///
    /// # Errors
    /// A folder that cannot be listed.
    pub(crate) fn new(
        folder: PathBuf,
        channel: Option<Channel>,
        idle: Option<Duration>,
        stop: Arc<AtomicBool>,
    ) -> Result<Self, ReadError> {
        let now = Instant::now();
        let mut this = Self {
            frames: FileFrames::new(Vec::new()).of_channel(channel),
            folder,
            idle,
            stop,
            known: Known::default(),
            queue: VecDeque::new(),
            first: Look::none(),
            last_new: now,
            next_listing: now,
            tables: [None; 2],
            has_ended: false,
            spare: Spare::default(),
        };
        this.list()?;
        Ok(this)
    }

    /// Reads files into spare memory.
    pub(crate) fn reusing(self, spare: Spare) -> Self {
        Self { frames: self.frames.reusing(spare.clone()), spare, ..self }
    }

    /// Queues the images that are new, in their natural order.
    fn list(&mut self) -> Result<(), ReadError> {
        let begun = Instant::now();
        if begun < self.next_listing {
            return Ok(());
        }
        let io = |cause| ReadError::Io { path: self.folder.display().to_string(), cause };
        let new = self.known.new_in(&self.folder).map_err(io)?;
        if !new.is_empty() {
            self.last_new = begun;
        }
        self.queue.extend(new);
        self.next_listing = begun + begun.elapsed() * LISTING_SHARE;
        Ok(())
    }

    /// How long a file that is not whole is waited for.
    fn patience(&self) -> Duration {
        self.idle.map_or(PATIENCE, |idle| idle.min(PATIENCE))
    }

    /// Looks at a file that stands first in the queue.
    fn look_at(&mut self, path: &Path) -> Found {
        let stamp = match stamp(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Found::Gone,
            found => found.ok(),
        };
        if self.first.times > 0 && stamp == self.first.stamp {
            self.first.times += 1;
        } else {
            self.first = Look { stamp, times: 1, since: Instant::now() };
            self.last_new = self.first.since;
        }
        let is_last = self.first.since.elapsed() >= self.patience();
        self.refresh_tables();
        let given = self.frames.given();
        self.frames.turn_to(path.to_owned());
        let Some((arrival, frame)) = self.frames.next_undecoded() else { return Found::Gone };
        match self.shown(&frame) {
            Shown::All => Found::Frame(Box::new((arrival, frame))),
            // Some decoders fill up what is missing.
            Shown::Part if is_last => {
                let cause = damaged("the file ends within it and is not written any more");
                let path = path.display().to_string();
                Found::Frame(Box::new((arrival, Err(ReadError::Decode { path, cause }))))
            }
            Shown::Unknown if is_last => Found::Frame(Box::new((arrival, frame))),
            _ => {
                self.frames.take_back(given);
                Found::Unfinished
            }
        }
    }

    /// What the first frame of a file shows of it.
    fn shown(&self, frame: &Result<Undecoded, ReadError>) -> Shown {
        let Ok(frame) = frame else { return Shown::Unknown };
        match is_whole_png(&frame.content) {
            Some(true) => return Shown::All,
            Some(false) => return Shown::Part,
            None => {}
        }
        match next_image(&mut frame.content.as_slice(), Vec::new()) {
            Ok(Some(Piece::Whole(image))) if !image.starts_with(b"P") => Shown::All,
            Ok(Some(Piece::Cut)) => Shown::Part,
            // Several images may follow one another, and a TIFF does not state where it ends.
            _ if self.first.is_settled() && self.can_decode(self.frames.last_page(frame)) => Shown::All,
            _ => Shown::Unknown,
        }
    }

    fn can_decode(&self, frame: Undecoded) -> bool {
        let decoded = frame.decode(&self.spare).map(|stored| stored.frame.into_buffer());
        decoded.map(|buffer| self.spare.take_buffer(buffer)).is_ok()
    }

    /// Reads the tables of frames anew where they changed, or where none of their rows was that of
    /// an image.
    fn refresh_tables(&mut self) {
        let above = self.folder.canonicalize().ok().and_then(|f| Some(f.parent()?.to_owned()));
        let tables = [Some(self.folder.clone()), above];
        let tables = tables.map(|folder| stamp(&folder?.join("frames.csv")).ok());
        let is_unused = self.frames.has_no_table() && tables.iter().any(Option::is_some);
        if is_unused || tables != self.tables {
            self.frames.forget_tables();
            self.tables = tables;
        }
    }

    /// The next page of the file that is open, or the first of the next file that is whole.
    fn look(&mut self) -> Option<(Arrival, Result<Undecoded, ReadError>)> {
        if self.frames.has_pages() {
            return self.frames.next_undecoded();
        }
        while let Some(path) = self.queue.front().cloned() {
            match self.look_at(&path) {
                Found::Unfinished => return None,
                Found::Gone => self.leave_first(),
                Found::Frame(frame) => {
                    self.leave_first();
                    return Some(*frame);
                }
            }
        }
        None
    }

    fn leave_first(&mut self) {
        self.queue.pop_front();
        self.first = Look::none();
    }

    /// Whether nothing is to be waited for any more.
    fn is_over(&self) -> bool {
        let idle = self.idle.is_some_and(|idle| self.last_new.elapsed() >= idle);
        self.stop.load(Ordering::Relaxed) || idle && self.queue.is_empty()
    }
}

impl Iterator for Follow {
    type Item = Taken;

    fn next(&mut self) -> Option<Taken> {
        while !self.has_ended {
            if let Some((mut arrival, frame)) = self.look() {
                // Rows of images to come are no fault of the table.
                self.frames.take_notices();
                arrival.host_t_ns = Some(host_t_ns());
                return Some(Ok((arrival, frame)));
            }
            if self.is_over() {
                self.has_ended = true;
            } else if self.queue.is_empty()
                && let Err(error) = self.list()
            {
                self.has_ended = true;
                return Some(Err(error));
            } else if self.queue.is_empty() || self.first.times > 0 {
                std::thread::sleep(LOOK);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(grey: u8) -> Vec<u8> {
        let mut out = std::io::Cursor::new(Vec::new());
        let image = image::GrayImage::from_pixel(40, 30, image::Luma([grey]));
        image.write_to(&mut out, image::ImageFormat::Png).unwrap();
        out.into_inner()
    }

    fn follow(folder: &std::path::Path, idle_ms: u64) -> Follow {
        let (idle, stop) = (Some(Duration::from_millis(idle_ms)), Arc::new(AtomicBool::new(false)));
        Follow::new(folder.to_owned(), None, idle, stop).unwrap()
    }

    fn stems(taken: impl Iterator<Item = Taken>) -> Vec<(String, bool)> {
        let one = |taken: Taken| {
            let (arrival, frame) = taken.unwrap();
            (arrival.stem, frame.is_ok_and(|frame| frame.decode(&Spare::default()).is_ok()))
        };
        taken.map(one).collect()
    }

    #[test]
    fn each_image_comes_once_in_natural_order_and_others_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
        write("b10.png", &png(1));
        write("b9.png", &png(2));
        write("b11.pgm", b"P5 1 1 255\nxP5 1 1 255\ny");
        for other in [".b1.png", "b1.png.part", "b1.tmp", "notes.txt"] {
            write(other, &png(3));
        }
        write("c.png", b"");
        let right = [("b9", true), ("b10", true), ("b11#0", true), ("b11#1", true), ("c", false)];
        let found = stems(follow(folder.path(), 300));
        assert_eq!(found, right.map(|(stem, good)| (stem.to_owned(), good)));
    }

    #[test]
    fn a_file_that_is_written_still_is_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let (path, whole) = (folder.path().join("a.png"), png(7));
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        std::fs::write(folder.path().join("b.png"), &whole).unwrap();
        let writer = {
            let (path, rest) = (path, whole[whole.len() / 2..].to_vec());
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(300));
                let mut file = std::fs::OpenOptions::new().append(true).open(path).unwrap();
                std::io::Write::write_all(&mut file, &rest).unwrap();
            })
        };
        let found = stems(follow(folder.path(), 1500));
        writer.join().unwrap();
        assert_eq!(found, [("a".to_owned(), true), ("b".to_owned(), true)]);
    }
}
