//! Studies of independent scenes, split between processes and machines and joined again.
//!
//! In: a study whose every scene follows from its settings, its seed and the scene's number alone
//! ([`SceneStudy`]). Out: the outcomes of a shard, each with its number, and what identifies the
//! shard ([`Identity`]); [`joined`] checks that shards belong together and are all there, and gives
//! the outcomes in the order of the scenes. From these a study computes what it computes of scenes
//! of its own, so that the figures (exact quantiles among them) are the same to the last bit.
//!
//! `shard_of` is the i of N, `identity` what belongs together, `cell` a row of a table, `study` the
//! interface and its scenes on threads, `join` the check. Files are written and read by
//! `cli/study/shard`. One more study is an implementation of [`SceneStudy`] beside it, and a line
//! in `cli/study/merge`.

mod cell;
mod identity;
mod join;
mod shard_of;
mod study;

pub(crate) use cell::{Cell, ColumnKind, Columns};
pub(crate) use identity::Identity;
pub(crate) use join::{Shard, check_rows, joined};
pub(crate) use shard_of::ShardOf;
pub(crate) use study::{SceneStudy, outcomes};
