//! Answers commands, resend requests and discoveries.

use std::io;
use std::net::{SocketAddr, SocketAddrV4, UdpSocket};

use super::sending::resend;
use super::shared::{LOOK, Shared};
use crate::publish::camera::{Action, Reply};
use crate::publish::gvcp::{self, Command};

/// Bytes that are taken of a datagram: longer ones are no commands, and are recognised as such.
const TAKEN_BYTES: usize = 1024;

/// Answers commands until the end.
pub(super) fn answer(shared: &Shared<'_>) {
    // without a time-out the end would be seen with the next datagram only
    if let Err(error) = shared.control.set_read_timeout(Some(LOOK)) {
        tracing::debug!("no time-out: {error}");
    }
    let mut buffer = [0; TAKEN_BYTES];
    while !shared.ends() {
        let taken = take(shared.control, &mut buffer);
        let now_ns = shared.now_ns();
        let reply = shared.with(|camera| {
            let reply = taken.map(|(length, from)| (camera.answer(&buffer[..length], from, now_ns), from));
            camera.tick(now_ns);
            reply
        });
        if let Some((reply, from)) = reply {
            act(shared, reply, from);
        }
    }
}

/// A datagram of IPv4; errors of the socket belong to earlier answers.
fn take(socket: &UdpSocket, buffer: &mut [u8]) -> Option<(usize, SocketAddrV4)> {
    match socket.recv_from(buffer) {
        Ok((length, SocketAddr::V4(from))) => Some((length, from)),
        Ok(_) => None,
        Err(error) => {
            if !matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) {
                tracing::debug!("a datagram was not taken: {error}");
            }
            None
        }
    }
}

fn act(shared: &Shared<'_>, reply: Reply, from: SocketAddrV4) {
    if let Some(datagram) = reply.datagram {
        put(shared.control, &datagram, from);
    }
    match reply.action {
        Some(Action::Resend(request)) => {
            if let Some(stream) = shared.with(|camera| camera.stream()) {
                resend(shared, &request, &stream);
            }
        }
        Some(Action::TestPacket(to, bytes)) => put(shared.stream, &vec![0; bytes], to),
        None => {}
    }
}

/// An answer that cannot be sent is lost, and the client asks again.
fn put(socket: &UdpSocket, datagram: &[u8], to: SocketAddrV4) {
    if let Err(error) = socket.send_to(datagram, to) {
        tracing::debug!("{} bytes to {to} were lost: {error}", datagram.len());
    }
}

/// Answers discoveries to all, from the address of the camera.
pub(super) fn discover(shared: &Shared<'_>, socket: &UdpSocket) {
    if let Err(error) = socket.set_read_timeout(Some(LOOK)) {
        tracing::debug!("no time-out: {error}");
    }
    let mut buffer = [0; TAKEN_BYTES];
    while !shared.ends() {
        let Some((length, from)) = take(socket, &mut buffer) else { continue };
        let is_discovery =
            gvcp::parse(&buffer[..length]).is_ok_and(|request| request.command == Command::Discovery);
        if is_discovery {
            let now_ns = shared.now_ns();
            let reply = shared.with(|camera| camera.answer(&buffer[..length], from, now_ns));
            act(shared, reply, from);
        }
    }
}
