//! Packets and payloads of a camera's stream.
#![no_main]

#[path = "../received.rs"]
mod received;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    received::packet(bytes);
    received::chunks(bytes);
});
