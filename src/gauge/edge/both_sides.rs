//! Both sides of a frame at once.

/// Runs both sides in parallel where requested and where there are threads, one after the other
/// otherwise. They are independent, so that the result is the same.
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
