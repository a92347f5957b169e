//! Frames in files: single images, stacks and folders, with the entries of `frames.csv`.

use std::collections::HashMap;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::decode::{Wanted, pages};
use super::extension::is_image_extension;
use super::frame_info::FrameInfo;
use super::frame_table::{FrameTable, TableError};
use super::natural_order::natural;
use super::raster::Channel;
use super::read_error::{LARGEST_FILE, ReadError};
use super::spare::Spare;
use super::stored::{Arrival, Coded, StoredFrame, Taken, Undecoded};
use crate::frame::{Frame, FrameMeta, FrameSource, SourceError};
use crate::position::EncoderSettings;

/// Rows of a table that a notice names one by one.
const NAMED_ROWS: usize = 5;

/// Images of a folder in the order of the numbers in their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Listing {
    /// The images.
    pub images: Vec<PathBuf>,
    /// Two names whose alphabetical order is reversed (`img10`, `img2`), where there are any.
    pub reordered: Option<(String, String)>,
}

/// As [`listing`], the images alone.
///
/// # Errors
/// As [`listing`].
pub(crate) fn list_images(path: &Path) -> Result<Vec<PathBuf>, ReadError> {
    listing(path).map(|l| l.images)
}

/// Images of a folder (or of its `frames` folder), in natural order of their names; a file is
/// itself.
///
/// # Errors
/// Where the path cannot be read or the folder holds no image.
pub(crate) fn listing(path: &Path) -> Result<Listing, ReadError> {
    let io = |cause| ReadError::Io { path: path.display().to_string(), cause };
    let kind = fs::metadata(path).map_err(io)?;
    if !kind.is_dir() {
        return Ok(Listing { images: vec![path.to_owned()], reordered: None });
    }
    let mut images = images_in(path).map_err(io)?;
    if images.is_empty() && path.join("frames").is_dir() {
        images = images_in(&path.join("frames")).map_err(io)?;
    }
    if images.is_empty() {
        return Err(ReadError::NoImages { path: path.display().to_string() });
    }
    let reordered = out_of_order(&images);
    images.sort_by(|a, b| natural(&name(a), &name(b)));
    Ok(Listing { images, reordered })
}

/// The first two neighbours of a list that natural order reverses.
pub(crate) fn out_of_order(images: &[PathBuf]) -> Option<(String, String)> {
    let pair = images.windows(2).find(|pair| natural(&name(&pair[0]), &name(&pair[1])).is_gt())?;
    Some((name(&pair[0]), name(&pair[1])))
}

/// The images of a folder, in alphabetical order.
pub(super) fn images_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut images = Vec::new();
    each_image(folder, |name| images.push(folder.join(name)))?;
    images.sort();
    Ok(images)
}

/// Lists a folder: the names of its images, in the order of the system. A file is asked for its
/// kind only where the folder does not state it.
pub(super) fn each_image(folder: &Path, mut take: impl FnMut(OsString)) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        if is_image_name(&name) && is_file(&entry) {
            take(name);
        }
    }
    Ok(())
}

/// Some systems leave a hidden `._name.png` beside every file.
fn is_image_name(name: &OsStr) -> bool {
    let extension = Path::new(name).extension().map(OsStr::to_string_lossy);
    !name.as_encoded_bytes().starts_with(b".") && extension.is_some_and(|e| is_image_extension(&e))
}

/// Whether an entry is a file, or a link to one. A link to nothing is one that cannot be read: left
/// out it would be a frame that nothing shows the lack of.
fn is_file(entry: &fs::DirEntry) -> bool {
    match entry.file_type() {
        Ok(kind) if !kind.is_symlink() => kind.is_file(),
        _ => fs::metadata(entry.path()).map_or(true, |found| found.is_file()),
    }
}

pub(super) fn name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

/// The file whose frames come next.
#[derive(Debug)]
struct Open {
    path: PathBuf,
    content: Result<Arc<Vec<u8>>, ReadError>,
    pages: Vec<u64>,
    page: usize,
}

impl Open {
    fn stem(&self) -> String {
        let stem = stem(&self.path);
        if self.pages.len() > 1 { format!("{stem}#{}", self.page) } else { stem }
    }
}

/// The frames of a list of files, one after another.
#[derive(Debug, Default)]
pub struct FileFrames {
    paths: Vec<PathBuf>,
    next: usize,
    open: Option<Open>,
    given: u64,
    channel: Option<Channel>,
    encoder: Option<EncoderSettings>,
    tables: HashMap<PathBuf, FrameTable>,
    notices: Vec<String>,
    spare: Spare,
}

impl FileFrames {
    /// Frames of these files, in this order.
    pub fn new(paths: Vec<PathBuf>) -> Self {
        Self { paths, ..Self::default() }
    }

    /// Chooses the channel of colour images.
    #[must_use]
    pub fn of_channel(self, channel: Option<Channel>) -> Self {
        Self { channel, ..self }
    }

    /// Takes the spindle angles from the encoder counts in `frames.csv`.
    #[must_use]
    pub fn by_encoder(self, encoder: Option<EncoderSettings>) -> Self {
        Self { encoder, ..self }
    }

    /// Reads files into spare memory.
    #[must_use]
    pub(crate) fn reusing(self, spare: Spare) -> Self {
        Self { spare, ..self }
    }

    /// Notes for the user on the files since the last call.
    pub fn take_notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }

    /// Name of the frame that comes next; opens its file.
    pub fn next_stem(&mut self) -> Option<String> {
        self.open_next()?;
        self.open.as_ref().map(Open::stem)
    }

    /// Reads the next frame; `None` at the end. After an error the next call continues with the
    /// next one.
    pub fn next_stored(&mut self) -> Option<Result<StoredFrame, ReadError>> {
        let (_, read) = self.next_undecoded()?;
        Some(read.and_then(|undecoded| undecoded.decode(&self.spare)))
    }

    /// As [`Self::next_stored`], to be decoded elsewhere.
    pub(super) fn next_undecoded(&mut self) -> Option<(Arrival, Result<Undecoded, ReadError>)> {
        self.open_next()?;
        let mut open = self.open.take()?;
        let mut arrival = Arrival { stem: open.stem(), ..Arrival::default() };
        let content = match &open.content {
            Ok(bytes) => Ok(Arc::clone(bytes)),
            Err(_) => std::mem::replace(&mut open.content, Ok(Arc::default())),
        };
        let read = content.and_then(|content| self.read(&open, content, &mut arrival));
        open.page += 1;
        self.given += 1;
        if open.page < open.pages.len() {
            self.open = Some(open);
        }
        Some((arrival, read))
    }

    /// All frames, to be decoded elsewhere, each with the notes on its file.
    pub(crate) fn undecoded(mut self) -> impl Iterator<Item = Taken> + Send {
        std::iter::from_fn(move || {
            let (mut arrival, read) = self.next_undecoded()?;
            arrival.notices = self.take_notices();
            Some(Ok((arrival, read)))
        })
    }

    /// Continues with another file, the frames counted on; what was still open is left.
    pub(super) fn turn_to(&mut self, path: PathBuf) {
        (self.paths, self.next, self.open) = (vec![path], 0, None);
    }

    /// As if no more than so many frames had been given: the open file is left, to be looked at
    /// again.
    pub(super) fn take_back(&mut self, given: u64) {
        (self.given, self.open) = (given, None);
    }

    /// Frames given so far.
    pub(super) fn given(&self) -> u64 {
        self.given
    }

    /// Reads the tables of frames anew.
    pub(super) fn forget_tables(&mut self) {
        self.tables.clear();
    }

    /// Whether no table has a row for an image so far.
    pub(super) fn has_no_table(&self) -> bool {
        self.tables.values().all(FrameTable::is_empty)
    }

    /// The last page of the file that a frame was the first of.
    pub(super) fn last_page(&self, first: &Undecoded) -> Undecoded {
        let mut last = first.clone();
        if let Some(place) = self.open.as_ref().and_then(|open| open.pages.last()) {
            last.wanted.place = Some(*place);
        }
        last
    }

    /// Whether more pages of the open file are to come.
    pub(super) fn has_pages(&self) -> bool {
        self.open.is_some()
    }

    fn open_next(&mut self) -> Option<()> {
        if self.open.is_none() {
            let path = self.paths.get(self.next)?.clone();
            self.next += 1;
            let content = bytes_of(&path, self.spare.file()).map(Arc::new);
            let pages = content.as_ref().map_or_else(|_| vec![0], |bytes| pages(bytes));
            self.open = Some(Open { path, content, pages, page: 0 });
        }
        Some(())
    }

    fn read(
        &mut self,
        open: &Open,
        content: Arc<Vec<u8>>,
        arrival: &mut Arrival,
    ) -> Result<Undecoded, ReadError> {
        let info = self.info(&open.path, &arrival.stem)?;
        arrival.device_t_ns = info.t_ns;
        let meta = FrameMeta {
            frame_id: arrival.stem.parse().unwrap_or(self.given),
            t_ns: info.t_ns.unwrap_or(0),
            exposure_us: info.exposure_us,
            angle_deg: info.angle_deg,
            sweep_deg: info.sweep_deg,
            z_mm: info.z_mm,
            ..FrameMeta::default()
        };
        let wanted = Wanted {
            bit_depth: info.bit_depth,
            channel: self.channel,
            place: open.pages.get(open.page).copied(),
        };
        Ok(Undecoded {
            stem: arrival.stem.clone(),
            named: page_name(open),
            coded: Coded::Image,
            content,
            wanted,
            meta,
            stated: info.um_per_px.map(|um_per_px| (um_per_px, info.row)),
        })
    }

    /// The row of a frame; the default where there is no table.
    fn info(&mut self, path: &Path, stem: &str) -> Result<FrameInfo, ReadError> {
        let folder = path.parent().unwrap_or(Path::new(".")).to_owned();
        if !self.tables.contains_key(&folder) {
            let table = table_of(&folder, &mut self.notices)?.by_encoder(self.encoder.as_ref())?;
            self.tables.insert(folder.clone(), table);
        }
        let Some(table) = self.tables.get(&folder).filter(|t| !t.is_empty()) else {
            return Ok(FrameInfo::default());
        };
        let info = table.of(stem).cloned().ok_or_else(|| ReadError::NoRow {
            path: path.display().to_string(),
            table: table.path.display().to_string(),
            frame: stem.to_owned(),
        })?;
        match info.void {
            Some(why) => Err(ReadError::Void { path: path.display().to_string(), why }),
            None => Ok(info),
        }
    }
}

fn page_name(open: &Open) -> String {
    let path = open.path.display();
    if open.pages.len() > 1 { format!("{path}#{}", open.page) } else { path.to_string() }
}

/// All bytes of a file, in empty memory.
pub(super) fn bytes_of(path: &Path, mut bytes: Vec<u8>) -> Result<Vec<u8>, ReadError> {
    let io = |cause| ReadError::Io { path: path.display().to_string(), cause };
    let file = fs::File::open(path).map_err(io)?;
    // As much as the file has, so that its bytes are not copied from one place to a larger one.
    let size = file.metadata().map_or(0, |m| m.len()).min(LARGEST_FILE);
    bytes.reserve_exact(size as usize);
    file.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(ReadError::TooLarge { path: path.display().to_string() });
    }
    Ok(bytes)
}

/// The table beside the images of a folder, or in the parent folder where it lists them; empty
/// where there is none.
fn table_of(folder: &Path, notices: &mut Vec<String>) -> Result<FrameTable, TableError> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let beside = here.join("frames.csv");
    let above = here.canonicalize().ok().and_then(|f| Some(f.parent()?.join("frames.csv")));
    let (path, is_above) = if beside.is_file() {
        (beside, false)
    } else if let Some(above) = above.filter(|path| path.is_file()) {
        (above, true)
    } else {
        return Ok(FrameTable::default());
    };
    let table = FrameTable::read(&path)?;
    let stems: Vec<String> = images_in(here).unwrap_or_default().iter().map(|p| stem(p)).collect();
    if is_above && !table.knows_any(&stems) {
        notices.push(format!(
            "{}: not used, no row is that of an image in {}",
            path.display(),
            here.display()
        ));
        return Ok(FrameTable::default());
    }
    let missing = table.without_image(&stems);
    if let Some(first) = missing.first() {
        let named = missing.iter().take(NAMED_ROWS).map(|i| format!("{} ({})", i.row, i.frame));
        let named = named.collect::<Vec<_>>().join(", ");
        let more = if missing.len() > NAMED_ROWS { ", …" } else { "" };
        notices.push(if missing.len() == 1 {
            format!(
                "{}, row {}: no image of frame {} in {}",
                path.display(),
                first.row,
                first.frame,
                here.display()
            )
        } else {
            format!(
                "{}: {} rows without an image in {}: {named}{more}",
                path.display(),
                missing.len(),
                here.display()
            )
        });
    }
    Ok(table)
}

impl FrameSource for FileFrames {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        match self.next_stored() {
            None => Ok(None),
            Some(Ok(stored)) => Ok(Some(stored.frame)),
            Some(Err(error)) => Err(SourceError { what: error.to_string(), cause: Some(Box::new(error)) }),
        }
    }

    /// Files to come; a stack that is not opened yet counts as one frame.
    fn remaining(&self) -> Option<usize> {
        let open = self.open.as_ref().map_or(0, |open| open.pages.len() - open.page);
        Some(self.paths.len() - self.next + open)
    }
}
