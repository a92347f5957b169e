//! The camera without a network, compiled from the program's own files: nothing of it is public for the sake of fuzzing.
#![allow(dead_code, unused_imports, reason = "a part of the room, without its sockets")]

#[path = "../../src/publish/camera/mod.rs"]
pub(crate) mod camera;
#[path = "../../src/publish/genicam/mod.rs"]
pub(crate) mod genicam;
#[path = "../../src/publish/gvcp/mod.rs"]
pub(crate) mod gvcp;
#[path = "../../src/publish/gvsp/mod.rs"]
pub(crate) mod gvsp;
#[path = "../../src/publish/head.rs"]
pub(crate) mod head;
#[path = "../sheet.rs"]
mod sheet;

pub(crate) use camera::Camera;
pub(crate) use genicam::DataSheet;
