//! Both sides of a frame at once.

/// Both sides at once where that is wished and there are threads, one after the other where there are not. Neither sees the other's
/// work, so the result is the same.
pub(crate) fn both<A: Send, B: Send>(
    splits: bool,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if splits && rayon::current_thread_index().is_some() && rayon::current_num_threads() > 1 {
        rayon::join(a, b)
    } else {
        (a(), b())
    }
}
