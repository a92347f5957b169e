//! Datagrams to the published camera.
#![no_main]

#[path = "../publish/mod.rs"]
mod publish;
#[path = "../session.rs"]
mod session;

use peak_alloc::PeakAlloc;
use shadowgauge::frame;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    session::session(&[]);
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    session::session(bytes);
    let most = HEAP.peak_usage().saturating_sub(before);
    // the camera's own memory, cloned for the session, is 0.3 MiB of registers and XML
    assert!(most <= session::STATE + (1 << 20), "{most} bytes");
});
