//! Every threshold of the instrument, by name: what `shadowgauge study limits` varies.
//!
//! A group that is not listed here is not varied; `tests/architecture.rs` counts the groups.

use super::edge::estimation::grey_ends::GreyEndLimits;
use super::edge::wire::clipped::WireClipLimits;
use super::limit::{Limit, Limits};

/// Every threshold with its default value.
#[must_use]
pub fn every() -> Vec<Limit> {
    [GreyEndLimits::list(), WireClipLimits::list()].concat()
}
