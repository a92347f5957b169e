//! What the threads of a camera share.

use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::ring::Ring;
use super::sockets::Sockets;
use crate::publish::camera::{Camera, Task};

/// Time after which a thread that waits looks for the end again.
pub(crate) const LOOK: Duration = Duration::from_millis(50);

/// The camera, its clock and its sockets.
#[derive(Debug)]
pub(crate) struct Shared<'a> {
    camera: Mutex<Camera>,
    wake: Condvar,
    pub(super) ring: Mutex<Ring>,
    pub(super) control: &'a UdpSocket,
    pub(super) stream: &'a UdpSocket,
    began: Instant,
    channel: AtomicU64,
    stop: &'a AtomicBool,
}

impl<'a> Shared<'a> {
    pub(super) fn new(mut camera: Camera, sockets: &'a Sockets, stop: &'a AtomicBool) -> Self {
        camera.set_source_port(sockets.stream_port());
        Self {
            channel: AtomicU64::new(camera.channel()),
            camera: Mutex::new(camera),
            wake: Condvar::new(),
            ring: Mutex::default(),
            control: &sockets.control,
            stream: &sockets.stream,
            began: Instant::now(),
            stop,
        }
    }

    /// Time of the head's clock, ns.
    pub(super) fn now_ns(&self) -> u64 {
        u64::try_from(self.began.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    pub(super) fn ends(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Reads or changes the camera; threads that wait for a task look again.
    pub(super) fn with<T>(&self, change: impl FnOnce(&mut Camera) -> T) -> T {
        let mut camera = self.lock();
        let result = change(&mut camera);
        self.channel.store(camera.channel(), Ordering::Relaxed);
        drop(camera);
        self.wake.notify_all();
        result
    }

    fn lock(&self) -> MutexGuard<'_, Camera> {
        self.camera.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the stream is still that of a frame's order.
    pub(super) fn is_open(&self, channel: u64) -> bool {
        self.channel.load(Ordering::Relaxed) == channel && !self.ends()
    }

    /// Whether the head sends nothing by a fault that was asked for.
    pub(super) fn is_silent(&self) -> bool {
        self.lock().is_silent(self.now_ns())
    }

    /// The next task, or `None` at the end.
    pub(super) fn next_task(&self) -> Option<Task> {
        let mut camera = self.lock();
        while !self.ends() {
            if let Some(task) = camera.next_task(self.now_ns()) {
                return Some(task);
            }
            let waited = self.wake.wait_timeout(camera, LOOK);
            camera = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        None
    }
}
