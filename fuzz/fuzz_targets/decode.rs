//! Image bytes: a frame of sane size or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use shadowgauge::frame::FrameMeta;
use shadowgauge::source::decode;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(frame) = decode(bytes, None, FrameMeta::default()) {
        let view = frame.view();
        assert!(view.rows() <= 65_535 && view.columns() <= 65_535);
    }
});
