//! The camera of a recording, as a metadata record of MCAP: what a calibration is bound to.
//!
//! One record `shadowgauge.camera` before the first frame, with one entry `binding`: the keys of
//! `camera` in a calibration file, as JSON.

use std::collections::BTreeMap;

use ::mcap::records::Metadata;

use crate::frame::CameraBinding;

/// Name of the record, and key of its entry.
const NAME: &str = "shadowgauge.camera";
const KEY: &str = "binding";

/// The record of a camera.
pub(super) fn record(camera: &CameraBinding) -> Metadata {
    let text = serde_json::to_string(camera).unwrap_or_default();
    Metadata { name: NAME.to_owned(), metadata: BTreeMap::from([(KEY.to_owned(), text)]) }
}

/// The camera of a record; `None` for records of other programs.
///
/// # Errors
/// A record of ours that is damaged, or of a later version.
pub(super) fn camera(record: &Metadata) -> Result<Option<CameraBinding>, String> {
    if record.name != NAME {
        return Ok(None);
    }
    let text = record.metadata.get(KEY).map_or("", String::as_str);
    let read = serde_json::from_str(text);
    read.map(Some).map_err(|why| format!("its camera (metadata {NAME}) cannot be read: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_comes_back_and_other_records_are_passed_over() {
        let mut of = CameraBinding { serial_number: "SG-5".to_owned(), ..CameraBinding::default() };
        of.gain_db = Some(0.1 + 0.2);
        assert_eq!(camera(&record(&of)), Ok(Some(of.clone())));
        assert_eq!(camera(&Metadata { name: "other".to_owned(), ..record(&of) }), Ok(None));
        let why = camera(&Metadata { metadata: BTreeMap::new(), ..record(&of) }).unwrap_err();
        assert!(why.contains("shadowgauge.camera"), "{why}");
    }
}
