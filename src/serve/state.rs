//! What all routes share.

use std::sync::Arc;

use tokio::sync::{Semaphore, watch};

use super::hub::Hub;
use super::jobs::Jobs;
use super::settings::ServeSettings;

/// Open event streams at most: each holds a connection for as long as its page is open.
pub(super) const MOST_STREAMS: usize = 100;

/// Settings, live lines, runs.
#[derive(Debug)]
pub(super) struct State {
    pub settings: ServeSettings,
    pub hub: Hub,
    pub jobs: Jobs,
    pub streams: Arc<Semaphore>,
    /// Becomes true at the end.
    pub ends: watch::Receiver<bool>,
}

/// As routes have it.
pub(super) type Shared = Arc<State>;
