//! The documents: generated references, links, commands and the tables of file formats.
//!
//! `BLESS=docs` writes the references anew. A `sh` block of README.md and docs/ is run, a document's
//! blocks in one folder; after `<!-- long -->` or `<!-- yours -->` its commands are parsed only.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod commands;
mod formats;
mod links;
mod markdown;
mod references;
