//! Documents of the pages in the store: products, inserts, machines, programs, by their name.

use std::sync::{MutexGuard, PoisonError};

use axum::http::StatusCode;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::access::Who;
use super::problem::Problem;
use super::state::Shared;
use crate::store::{Entry, EntryKind, Store, StoreError, Utc};

/// Documents of a kind at most: more are not looked through by a person.
const MOST: usize = 10_000;
/// Longest name, characters.
const LONGEST_NAME: usize = 64;

/// What is stored under a name.
pub(super) trait Document: Serialize + DeserializeOwned + Send + 'static {
    const KIND: EntryKind;
    /// What it is called in sentences.
    const WORD: &'static str;

    fn name(&self) -> &str;
}

/// Checks a name of a request.
pub(super) fn check_name(name: &str) -> Result<(), Problem> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let is_short = (1..=LONGEST_NAME).contains(&name.len());
    if is_short && name.chars().all(is_plain) && !name.starts_with('.') {
        return Ok(());
    }
    Err(Problem::refused(format!(
        "name {name:?}: 1 to {LONGEST_NAME} letters, digits, -, _ and ., no . first"
    )))
}

fn path(state: &Shared) -> Result<&std::path::Path, Problem> {
    let path = state.settings.store.as_deref();
    path.ok_or_else(|| Problem::absent("this server has no store (--store FILE): nothing is kept here"))
}

fn failed(error: StoreError) -> Problem {
    match error {
        StoreError::Busy { .. } => Problem::new(StatusCode::SERVICE_UNAVAILABLE, error),
        StoreError::Full { .. } => Problem::new(StatusCode::INSUFFICIENT_STORAGE, error),
        StoreError::Unwritable { .. } => Problem::new(StatusCode::SERVICE_UNAVAILABLE, error),
        other => Problem::failed(other),
    }
}

fn parsed<D: Document>(text: &str) -> Result<D, Problem> {
    serde_json::from_str(text).map_err(|e| Problem::failed(format!("a stored {}: {e}", D::WORD)))
}

/// One part of the list, by name, and how many there are.
pub(super) fn list<D: Document>(state: &Shared, at: (usize, usize)) -> Result<(usize, Vec<D>), Problem> {
    let (total, texts) = Store::read(path(state)?).map_err(failed)?.entries(D::KIND, at).map_err(failed)?;
    Ok((total, texts.iter().map(|text| parsed(text)).collect::<Result<_, _>>()?))
}

/// Documents of a kind as texts, the newest first, with the time when each was stored.
pub(super) fn newest(state: &Shared, kind: EntryKind, limit: usize) -> Result<Vec<(Utc, String)>, Problem> {
    Store::read(path(state)?).map_err(failed)?.newest(kind, limit).map_err(failed)
}

/// Stores a document that has no name but its digest.
pub(super) fn put(state: &Shared, who: &Who, entry: &Entry) -> Result<(), Problem> {
    Store::open(path(state)?, &who.0).map_err(failed)?.put(entry).map_err(failed)
}

/// A document by its name.
pub(super) fn get<D: Document>(state: &Shared, name: &str) -> Result<D, Problem> {
    let text = Store::read(path(state)?).map_err(failed)?.entry(D::KIND, name).map_err(failed)?;
    let text = text.ok_or_else(|| Problem::absent(format!("there is no {} {name:?}", D::WORD)))?;
    parsed(&text)
}

/// Others wait from the reading of a document to its change. One that panicked between both has
/// changed nothing: the store has whole documents alone.
fn held(state: &Shared) -> MutexGuard<'_, ()> {
    state.documents.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Stores a new document.
pub(super) fn add<D: Document>(state: &Shared, who: &Who, document: &D) -> Result<(), Problem> {
    check_name(document.name())?;
    let _held = held(state);
    let store = Store::read(path(state)?).map_err(failed)?;
    if store.entry(D::KIND, document.name()).map_err(failed)?.is_some() {
        let words = format!("there is a {} {:?} already", D::WORD, document.name());
        return Err(Problem::new(StatusCode::CONFLICT, words));
    }
    if store.entries(D::KIND, (0, 0)).map_err(failed)?.0 >= MOST {
        let words = format!("there are {MOST} of them, as many as may: delete old ones");
        return Err(Problem::new(StatusCode::INSUFFICIENT_STORAGE, words));
    }
    change(state, who, document)
}

/// Changes a document as it is now, with no other change between.
pub(super) fn update<D: Document>(
    state: &Shared,
    who: &Who,
    name: &str,
    alter: impl FnOnce(&mut D),
) -> Result<(), Problem> {
    let _held = held(state);
    let mut document: D = get(state, name)?;
    alter(&mut document);
    change(state, who, &document)
}

/// Stores a document in place of the one of its name; the audit has both.
pub(super) fn change<D: Document>(state: &Shared, who: &Who, document: &D) -> Result<(), Problem> {
    let text = serde_json::to_string(document).map_err(Problem::failed)?;
    let entry = Entry { kind: D::KIND, key: document.name().to_owned(), document: text };
    put(state, who, &entry)
}

/// Takes a document out; the audit keeps it.
pub(super) fn remove<D: Document>(state: &Shared, who: &Who, name: &str) -> Result<(), Problem> {
    let mut store = Store::open(path(state)?, &who.0).map_err(failed)?;
    match store.take_out(D::KIND, name).map_err(failed)? {
        true => Ok(()),
        false => Err(Problem::absent(format!("there is no {} {name:?}", D::WORD))),
    }
}
