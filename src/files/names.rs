//! Fixed names of outputs that are not yet complete.

/// How all temporary names begin.
pub(crate) const TEMPORARY: &str = ".tmp-";
/// The lock in a folder that is written to.
pub(crate) const LOCK_NAME: &str = ".tmp-lock";
