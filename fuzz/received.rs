//! What the receiver takes apart of a camera's stream: packets, and payloads with chunks, both by the crate viva-genicam. The body of
//! the fuzz target `receiver`, which a plain test runs as well (src/source/camera/chunks.rs). A panic is a finding.

use viva_genicam::gige::{parse_chunks, parse_packet_ref};

/// A payload with chunks: they lie one after another, each followed by its tag, and fill the payload; or an error that says something.
/// Whether there are chunks.
pub(crate) fn chunks(payload: &[u8]) -> bool {
    let chunks = match parse_chunks(payload) {
        Ok(chunks) => chunks,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return false;
        }
    };
    let mut at = 0;
    for chunk in &chunks {
        assert_eq!(chunk.offset, at);
        let end = at + chunk.data.len();
        assert_eq!(&payload[at..end], chunk.data);
        let tag = [chunk.id.to_be_bytes(), (chunk.data.len() as u32).to_be_bytes()].concat();
        assert_eq!(&payload[end..end + 8], tag);
        at = end + 8;
    }
    assert_eq!(at, payload.len());
    !chunks.is_empty()
}

/// A packet: parsed or refused. Whether it is one.
pub(crate) fn packet(bytes: &[u8]) -> bool {
    match parse_packet_ref(bytes) {
        Ok(_) => true,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}
