//! The host's clock: when an image came.

use std::time::{SystemTime, UNIX_EPOCH};

/// Now, ns since 1970; 0 before.
pub(crate) fn host_t_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}
