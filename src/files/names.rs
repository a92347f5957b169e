//! Fixed names of outputs that are not yet complete.

/// How all temporary names begin.
pub const TEMPORARY: &str = ".tmp-";
/// The lock in a folder that is written to.
pub const LOCK_NAME: &str = ".tmp-lock";
