//! Where programs and readings are made: child processes, bounded in number and time.

use std::path::Path;
use std::sync::Arc;

use axum::http::StatusCode;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::child::{self, Ended};
use super::problem::Problem;

/// Jobs at a time, and those that wait: the smallest machine has two cores, and a job has its
/// inputs and outputs in memory once.
const AT_A_TIME: usize = 2;
const MOST_WAITING: usize = 16;

/// Places of jobs.
#[derive(Debug)]
pub(super) struct Workshop {
    places: Arc<Semaphore>,
    queue: Arc<Semaphore>,
}

impl Workshop {
    pub(super) fn new() -> Self {
        let of = |places| Arc::new(Semaphore::new(places));
        Self { places: of(AT_A_TIME), queue: of(AT_A_TIME + MOST_WAITING) }
    }

    /// A place in the queue; refused where it is full.
    pub(super) fn queue(&self) -> Result<OwnedSemaphorePermit, Problem> {
        Arc::clone(&self.queue).try_acquire_owned().map_err(|_| {
            let words = format!("{} jobs wait, as many as may: try again", AT_A_TIME + MOST_WAITING);
            Problem::new(StatusCode::SERVICE_UNAVAILABLE, words)
        })
    }

    /// A place to work, once one is free.
    pub(super) async fn place(&self) -> Result<[OwnedSemaphorePermit; 2], Problem> {
        let waiting = self.queue()?;
        let place = Arc::clone(&self.places).acquire_owned().await.map_err(Problem::failed)?;
        Ok([waiting, place])
    }
}

/// Runs a command of this program in a folder; exit codes 0 and 1 (a verdict) are results.
///
/// # Errors
/// 422 with the command's own words where it refuses.
pub(super) async fn run(folder: &Path, arguments: &[&str]) -> Result<Ended, Problem> {
    let arguments: Vec<String> = arguments.iter().map(|&a| a.to_owned()).collect();
    let ended = child::finished(&arguments, folder).await.map_err(Problem::failed)?;
    match ended.exit {
        Some(0 | 1) => Ok(ended),
        Some(_) if ended.words.is_empty() => Err(Problem::refused(ended.warnings.join("; "))),
        Some(_) => Err(Problem::refused(ended.words)),
        None => Err(Problem::failed(format!("the job was ended: {}", ended.words))),
    }
}
