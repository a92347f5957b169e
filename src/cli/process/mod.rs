//! The process: workarounds for graphics drivers (their messages on stderr, crashes at the end of
//! the process), and Ctrl-C (`interrupt`).
#![expect(unsafe_code, reason = "two calls of the C library that the standard library has no safe form of")]

pub(super) mod interrupt;

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use crate::render::gpu;

/// Gives `XDG_RUNTIME_DIR` a folder where the environment has none (containers, cron, ssh without a
/// login session): Mesa's drivers look for a Wayland display, and its client library then prints an
/// error of its own on stderr. No display is needed here; any folder without one avoids the
/// message.
///
/// Must be called at the start of the process, before any thread is started.
pub(super) fn provide_runtime_folder() {
    let stands = |value: std::ffi::OsString| Path::new(&value).is_dir();
    if cfg!(unix) && !std::env::var_os("XDG_RUNTIME_DIR").is_some_and(stands) {
        set("XDG_RUNTIME_DIR", &std::env::temp_dir());
    }
}

fn set(name: &str, value: &Path) {
    // SAFETY: first statement of `main`: no other thread exists that could read or write the
    // environment.
    unsafe { std::env::set_var(name, value) };
}

unsafe extern "C" {
    /// POSIX `_exit`: ends the process at once, without `atexit` handlers and destructors of
    /// libraries.
    safe fn _exit(status: std::ffi::c_int) -> !;
}

/// Ends the process with `status` at once, from any thread: no destructor of a driver's library
/// runs.
pub(super) fn end_at_once(status: u8) -> ! {
    let _ = (std::io::stdout().flush(), std::io::stderr().flush());
    #[cfg(unix)]
    _exit(i32::from(status));
    #[cfg(not(unix))]
    std::process::exit(i32::from(status));
}

/// Ends the process with `status` once everything is written. Where a driver was opened, its
/// libraries' destructors are not run: threads that have used the driver end at the same time, and
/// one run in 50 to 200 (Mesa 22.3, OpenGL; Vulkan and OpenGL together) ended in a double free or a
/// segmentation fault after its work was done.
pub(super) fn leave(status: u8) -> ExitCode {
    let _ = (std::io::stdout().flush(), std::io::stderr().flush());
    if cfg!(unix) && gpu::was_opened() {
        _exit(i32::from(status));
    }
    ExitCode::from(status)
}
