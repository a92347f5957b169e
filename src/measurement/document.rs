//! The whole document of `shadowgauge measure --json`.

use serde::{Serialize, Serializer};

use super::by_key::by_key;
use super::result::Measurement;
use super::series::Series;

/// Frames and the results over all of them. Its JSON is the document that the command line prints.
#[derive(Clone, Debug)]
pub struct Document<'a> {
    /// The frames in their order.
    pub frames: &'a [Measurement],
    /// The results over them.
    pub series: &'a Series,
    /// Times of a benchmark, where one ran.
    pub bench: Option<serde_json::Value>,
}

#[derive(Serialize)]
struct Keys<'a> {
    frames: &'a [Measurement],
    #[serde(flatten)]
    series: &'a Series,
    #[serde(skip_serializing_if = "Option::is_none")]
    bench: Option<&'a serde_json::Value>,
}

impl Serialize for Document<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { frames, series, bench } = self;
        by_key(&Keys { frames, series, bench: bench.as_ref() }, serializer)
    }
}
