//! A page to watch: runs, history and a live source in a browser, served by this process alone.
//!
//! In: a folder of runs, a store, a source ([`ServeSettings`]). Out: pages and an API of JSON
//! (`api/openapi.json`), events as they come. Nothing here moves a machine or makes an offset act:
//! runs that are started are simulated ones. Measuring and cutting are done by child processes of
//! this program (`child`): what they do wrong cannot take the page with it, and one that is killed
//! is resumed.
//!
//! Bottom to top: `problem` (refusals with their status), `tls`, `settings` (what is served, to
//! whom), `child`, `hub` (live lines to all readers, newest wins), `health` (window and drift of
//! the source), `store_check` (the last check of the store), `jobs` (runs that were started),
//! `workshop` (where programs and readings are made, `making` of them), `picture_file` (the newest
//! frame), `state` (all of these), `access` (who may do what, headers), `files` (uploads by their
//! digest), `documents` (what the store has by name); the routes `runs`, `run_config` (configs of
//! simulated runs), `run_jobs` (started, stopped), `history`, `live`,
//! `machines`, `products`, `tools`, `calibrations`, `programs` (`program` as stored, `program_job`
//! makes one; with `changed` and `drawn`: what differs, what is drawn); `page` (files compiled in),
//! `server`. One more route is a function in its file with a line in `server::router` and one in
//! `server::Documented`.

mod access;
mod calibrations;
mod changed;
mod child;
mod documents;
mod drawn;
mod files;
mod health;
mod history;
mod hub;
mod jobs;
mod live;
mod machines;
mod making;
mod off_thread;
mod page;
mod picture_file;
mod problem;
mod products;
mod program;
mod program_job;
mod programs;
mod run_config;
mod run_jobs;
mod runs;
mod server;
mod settings;
mod state;
mod store_check;
mod tls;
mod tools;
mod workshop;

#[cfg(test)]
pub(crate) use run_config::named_file;
pub(crate) use server::{ServeError, Server};
pub(crate) use settings::{ServeSettings, Tokens};
pub(crate) use tls::Tls;
