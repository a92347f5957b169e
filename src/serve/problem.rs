//! A refusal as the API has it: a status and a sentence.

use std::io;
use std::path::Path;

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

/// Why a request was refused, in the body of every answer that is no success.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct Words {
    /// What is wrong and what would be right.
    pub error: String,
}

/// A refusal.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub status: StatusCode,
    pub words: String,
}

impl Problem {
    pub(super) fn new(status: StatusCode, words: impl std::fmt::Display) -> Self {
        Self { status, words: words.to_string() }
    }

    /// 404.
    pub(super) fn absent(words: impl std::fmt::Display) -> Self {
        Self::new(StatusCode::NOT_FOUND, words)
    }

    /// 422: a value that is not accepted.
    pub(super) fn refused(words: impl std::fmt::Display) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, words)
    }

    /// 507 where there is no room (a full disk, a quota, a limit of the file's length), else 500:
    /// a file that cannot be written.
    pub(super) fn unwritten(path: &Path, error: &io::Error) -> Self {
        use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
        let has_no_room = matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge);
        let status =
            if has_no_room { StatusCode::INSUFFICIENT_STORAGE } else { StatusCode::INTERNAL_SERVER_ERROR };
        Self::new(status, format!("{}: cannot be written: {error}; nothing was stored", path.display()))
    }

    /// 500: a disk or a store that fails.
    pub(super) fn failed(words: impl std::fmt::Display) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, words)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        (self.status, Json(Words { error: self.words })).into_response()
    }
}
