//! Helpers of the modules: the folder of the collection, and runs of the program.
#![allow(dead_code, reason = "not every module uses every helper")]

use std::path::{Path, PathBuf};

use serde_json::Value;

pub(crate) use crate::inside::field::program::{json, said, shadowgauge, text};

/// The path of `name` in the collection, or `None` with a notice where `$SHADOWGAUGE_FIELD` is not
/// set.
pub(crate) fn collected(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("SHADOWGAUGE_FIELD").map(|folder| Path::new(&folder).join(name));
    match path {
        Some(path) => {
            assert!(path.exists(), "SHADOWGAUGE_FIELD holds no {}", path.display());
            Some(path)
        }
        None => {
            eprintln!("SKIPPED: SHADOWGAUGE_FIELD is not set; {name} is not tested");
            None
        }
    }
}

/// The document that `measure --json` prints for `file` at 1000 µm per pixel (millimetres read as
/// pixels), with further `options`; panics with the program's message where it refuses.
pub(crate) fn measured(file: &Path, options: &[&str]) -> Value {
    let mut arguments = vec!["measure".as_ref(), file.as_os_str()];
    arguments.extend(["--um-per-px", "1000", "--json"].map(std::ffi::OsStr::new));
    arguments.extend(options.iter().map(std::ffi::OsStr::new));
    let output = shadowgauge(arguments);
    assert!(!output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON on stdout")
}
