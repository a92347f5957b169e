//! Digests of image files, by which the same image is found again under any name.

use std::path::PathBuf;

use sha2::{Digest as _, Sha256};

use super::folder::bytes_of;
use super::read_error::ReadError;

/// Bytes of a digest that are kept: among a million images two share 8 bytes by chance with a
/// probability of 3e-8 (n²/2·2⁻⁶⁴).
const KEPT_BYTES: usize = 8;

/// Bytes as hexadecimal text, two digits each.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a text as hexadecimal text.
pub(crate) fn sha256_hex(text: &str) -> String {
    hexadecimal(&Sha256::digest(text))
}

fn kept(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes)[..KEPT_BYTES])
}

/// The digest of every file's bytes (SHA-256, its first 8 bytes in hexadecimal), in the order
/// given.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn image_digests(paths: &[PathBuf]) -> Result<Vec<String>, ReadError> {
    paths.iter().map(|path| bytes_of(path, Vec::new()).map(|bytes| kept(&bytes))).collect()
}

/// One digest of all, whatever their order.
pub(crate) fn digest_of_all(digests: &[String]) -> String {
    let mut sorted = digests.to_vec();
    sorted.sort();
    kept(sorted.join("\n").as_bytes())
}
