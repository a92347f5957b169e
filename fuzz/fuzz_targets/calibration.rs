//! Calibration files: a finite, positive scale or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use shadowgauge::gauge::Calibration;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(calibration) = Calibration::read(bytes) {
        assert!(calibration.scale_mm_per_px.is_finite() && calibration.scale_mm_per_px > 0.0);
    }
});
