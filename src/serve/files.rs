//! What is uploaded and made, beside the store: files by the SHA-256 of their bytes in
//! `STORE.files/`, and a folder for each job while it runs.
//!
//! No name of a request is the name of a file: a document in the store has the digest of each of
//! its files, the audit has the document, and a file whose bytes have another digest is refused.
//! Files stay when their document is taken out, as the audit still speaks of them.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use sha2::{Digest as _, Sha256};

use super::problem::Problem;
use super::state::Shared;
use crate::source::hexadecimal;

/// Most bytes of all files together: a year of ten noses a day. A disk that is full stops runs,
/// too.
const MOST_BYTES: u64 = 8 << 30;

/// The folder beside the store.
fn root(state: &Shared) -> Result<PathBuf, Problem> {
    let store = state.settings.store.as_ref();
    let store = store.ok_or_else(|| Problem::absent("this server has no store (--store FILE)"))?;
    let mut name = store.file_name().unwrap_or_default().to_owned();
    name.push(".files");
    Ok(store.with_file_name(name))
}

fn failed(path: &Path) -> impl Fn(std::io::Error) -> Problem {
    move |e| Problem::failed(format!("{}: {e}", path.display()))
}

fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Stores bytes; their digest.
pub(super) fn put(state: &Shared, bytes: &[u8]) -> Result<String, Problem> {
    let root = root(state)?;
    fs::create_dir_all(&root).map_err(|e| Problem::unwritten(&root, &e))?;
    let digest = sha256(bytes);
    let path = root.join(&digest);
    if path.is_file() {
        return Ok(digest);
    }
    let there = fs::read_dir(&root).map_err(failed(&root))?.filter_map(Result::ok);
    let taken: u64 = there.filter_map(|entry| entry.metadata().ok()).map(|m| m.len()).sum();
    if taken + bytes.len() as u64 > MOST_BYTES {
        let words = format!("{}: {} GiB are full: move old files away", root.display(), MOST_BYTES >> 30);
        return Err(Problem::new(axum::http::StatusCode::INSUFFICIENT_STORAGE, words));
    }
    // whole or not at all: renamed when it is on the disk
    let beside = root.join(format!("{digest}.{}", next()));
    let written = fs::write(&beside, bytes).and_then(|()| fs::File::open(&beside)?.sync_all());
    let written = written.and_then(|()| fs::rename(&beside, &path));
    if written.is_err() {
        let _ = fs::remove_file(&beside);
    }
    written.map_err(|e| Problem::unwritten(&path, &e)).map(|()| digest)
}

/// The bytes of a digest that a document has.
pub(super) fn get(state: &Shared, digest: &str) -> Result<Vec<u8>, Problem> {
    let is_digest = digest.len() == 64 && digest.bytes().all(|b| b.is_ascii_hexdigit());
    if !is_digest {
        return Err(Problem::failed(format!("{digest:?} is no digest: was the store altered?")));
    }
    let path = root(state)?.join(digest);
    let bytes = fs::read(&path).map_err(failed(&path))?;
    if sha256(&bytes) == digest {
        return Ok(bytes);
    }
    Err(Problem::failed(format!("{}: was altered: its SHA-256 is not its name", path.display())))
}

fn next() -> String {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    format!("{}-{}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed))
}

/// A folder that is removed with its contents.
#[derive(Debug)]
pub(super) struct JobFolder(PathBuf);

impl JobFolder {
    pub(super) fn new(state: &Shared) -> Result<Self, Problem> {
        let path = root(state)?.join("jobs").join(next());
        fs::create_dir_all(&path).map_err(|e| Problem::unwritten(&path, &e))?;
        Ok(Self(path))
    }

    pub(super) fn path(&self) -> &Path {
        &self.0
    }

    pub(super) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Problem> {
        let path = self.0.join(name);
        fs::write(&path, bytes).map_err(|e| Problem::unwritten(&path, &e))
    }

    /// A file of the job; none where it is absent.
    pub(super) fn read(&self, name: &str) -> Option<Vec<u8>> {
        fs::read(self.0.join(name)).ok()
    }
}

impl Drop for JobFolder {
    fn drop(&mut self) {
        // what cannot be removed is cleared when the server starts
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Clears what jobs of a server that was killed have left.
pub(super) fn clear_jobs(state: &Shared) {
    if let Ok(root) = root(state) {
        let _ = fs::remove_dir_all(root.join("jobs"));
    }
}
