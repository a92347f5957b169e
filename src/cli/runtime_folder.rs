//! Keeps a library's own words off the user's terminal.

use std::path::Path;

/// Gives `XDG_RUNTIME_DIR` a folder where the environment has none (containers, cron, ssh without a login session):
/// Mesa's drivers look for a Wayland display, and its client library then prints an error of its own on stderr. No
/// display is wanted here; any folder without one keeps it silent.
///
/// To be called at the start of the process, before any thread is.
pub(super) fn provide() {
    let stands = |value: std::ffi::OsString| Path::new(&value).is_dir();
    if cfg!(unix) && !std::env::var_os("XDG_RUNTIME_DIR").is_some_and(stands) {
        set("XDG_RUNTIME_DIR", &std::env::temp_dir());
    }
}

#[expect(
    unsafe_code,
    reason = "the environment is changed while the process has one thread: no one reads it meanwhile"
)]
fn set(name: &str, value: &Path) {
    // SAFETY: first statement of `main`: no other thread is there to read or write the environment.
    unsafe { std::env::set_var(name, value) };
}
