//! The documents: generated references, links, commands and the tables of file formats.
//!
//! `BLESS=docs` writes the references anew. A `sh` block of README.md and docs/ is run, the blocks
//! of a document in one folder; after `<!-- long -->` or `<!-- yours -->` it is parsed only.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod commands;
mod formats;
mod links;
mod markdown;
mod references;
