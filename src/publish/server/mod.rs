//! The camera on a network: `std::net` and four kinds of threads.
//!
//! In: a camera, its sockets, what makes frames, and a flag that ends it. Out: datagrams. `sockets`
//! binds addresses, `shared` is what the threads share, `control` answers commands and resend
//! requests, `making` takes the next task and has the frame made while the last one is sent,
//! `sending` lays it out and paces its packets, `ring` keeps frames for resend requests. Memory is
//! bounded: a frame that is made, one that waits, one that is sent, and those of the ring.

mod control;
mod making;
mod ring;
mod sending;
mod shared;
mod sockets;

pub(crate) use sockets::{BindError, Sockets};

use std::sync::atomic::AtomicBool;
use std::sync::mpsc::sync_channel;

use self::shared::Shared;
use super::camera::Camera;
use super::head::FrameMaker;

/// Serves until `stop` becomes true.
pub(crate) fn serve(
    camera: Camera,
    sockets: &Sockets,
    maker: &mut (dyn FrameMaker + Send),
    stop: &AtomicBool,
) {
    let shared = &Shared::new(camera, sockets, stop);
    // one frame waits while one is sent and one is made
    let (made, to_send) = sync_channel(1);
    let (spent, spare) = sync_channel(4);
    std::thread::scope(|threads| {
        threads.spawn(move || making::make(shared, maker, &made, &spare));
        threads.spawn(move || sending::send(shared, &to_send, &spent));
        for socket in &sockets.broadcast {
            threads.spawn(move || control::discover(shared, socket));
        }
        control::answer(shared);
    });
}
