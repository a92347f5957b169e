//! JSON with the keys of every object in alphabetical order, whatever the order of the fields: the
//! bytes of the documents that the command line prints.

use serde::ser::Error as _;
use serde::{Serialize, Serializer};

/// Serialises `value` with the keys of all its objects in alphabetical order.
///
/// # Errors
/// Where a value has no JSON: a map whose keys are no text.
pub(crate) fn by_key<T: Serialize, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serde_json::to_value(value).map_err(S::Error::custom)?.serialize(serializer)
}
