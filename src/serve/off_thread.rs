//! Work that blocks (disk, store, computing), off the thread that answers.

use super::problem::Problem;

/// Does what waits for a disk on a thread of its own.
pub(super) async fn off_thread<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    tokio::task::spawn_blocking(work).await.map_err(Problem::failed)?
}
