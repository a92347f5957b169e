//! What all routes share.

use std::sync::{Arc, Mutex};

use tokio::sync::{Semaphore, watch};

use super::health::Health;
use super::hub::Hub;
use super::jobs::Jobs;
use super::making::Making;
use super::picture_file::PictureFile;
use super::settings::ServeSettings;
use super::store_check::Checked;
use super::workshop::Workshop;

/// Open event streams at most: each holds a connection for as long as its page is open.
pub(super) const MOST_STREAMS: usize = 100;

/// Settings, live lines, runs.
#[derive(Debug)]
pub(super) struct State {
    pub settings: ServeSettings,
    pub hub: Hub,
    pub jobs: Jobs,
    pub workshop: Workshop,
    pub making: Making,
    /// Where the source's newest frame is; none without a source.
    pub picture: Option<PictureFile>,
    /// Held from the reading of a document to its change.
    pub documents: Mutex<()>,
    pub streams: Arc<Semaphore>,
    /// One place: a check reads all of the store, which takes seconds of a large one.
    pub checking: Arc<Semaphore>,
    /// The last check, with the file as it was then.
    pub checked: Mutex<Option<Checked>>,
    /// Window and drift of the source that is watched.
    pub health: Health,
    /// Becomes true at the end.
    pub ends: watch::Receiver<bool>,
}

/// As routes have it.
pub(super) type Shared = Arc<State>;
