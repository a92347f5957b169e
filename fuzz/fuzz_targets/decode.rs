//! Image bytes: a frame of sane size within twice its memory, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use peak_alloc::PeakAlloc;
use shadowgauge::frame::FrameMeta;
use shadowgauge::source::decode;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Scratch of a decoder, as in tests/allocation.rs.
const DECODER: usize = 512 << 10;

fuzz_target!(|bytes: &[u8]| {
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    let decoded = decode(bytes, None, FrameMeta::default());
    let most = HEAP.peak_usage().saturating_sub(before);
    if let Ok(frame) = decoded {
        let view = frame.view();
        assert!(view.rows() <= 65_535 && view.columns() <= 65_535);
        let each = usize::from(view.format().bit_depth().div_ceil(8));
        assert!(most <= 2 * view.rows() * view.columns() * each + DECODER, "{most} bytes");
    }
});
