//! Models of turned parts: bytes of STL files. Compiled from the program's own files: nothing of them is public for the sake of fuzzing.
#![no_main]
#![allow(dead_code, unused_imports, reason = "a part of the rooms")]

#[path = "../model.rs"]
mod model;
#[path = "../../src/outline/mod.rs"]
mod outline;
#[path = "../../src/setting.rs"]
mod setting;
#[path = "../../src/stl/mod.rs"]
mod stl;

use shadowgauge::shaft;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    model::model(bytes);
});
