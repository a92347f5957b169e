//! The sockets of a camera: its address for commands, the broadcast addresses for discoveries, one
//! for the stream.

use std::io;
#[cfg(test)]
use std::net::SocketAddr;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};

use thiserror::Error;

/// Why a camera cannot be on a network.
#[derive(Debug, Error)]
pub(crate) enum BindError {
    /// Another camera has the port.
    #[error(
        "{0} is in use: another camera is published at this address; end it, or take another address of this \
         machine by --listen (127.0.0.2 on the loopback interface)"
    )]
    InUse(SocketAddrV4),
    /// The machine has no such address.
    #[error(
        "{0} is no address of this machine: --listen takes the address of one of its network interfaces \
         (`ip -4 address` lists them), or 127.0.0.1"
    )]
    NotOurs(Ipv4Addr),
    /// The system refuses.
    #[error("{0} cannot be listened to: {1}")]
    System(SocketAddrV4, #[source] io::Error),
}

/// The sockets.
#[derive(Debug)]
pub(crate) struct Sockets {
    /// Commands and their answers.
    pub control: UdpSocket,
    /// Where discoveries to all arrive.
    pub broadcast: Vec<UdpSocket>,
    /// Where the stream comes from.
    pub stream: UdpSocket,
    /// Broadcast addresses that another program has.
    pub missed: Vec<SocketAddrV4>,
}

impl Sockets {
    /// Binds `address` of a subnet of `prefix` bits: the port of commands there, at the broadcast
    /// address of the subnet and at 255.255.255.255, without which clients find no camera.
    ///
    /// # Errors
    /// Where the address is in use, is not one of this machine, or the system refuses.
    pub(crate) fn bind(address: Ipv4Addr, prefix: u8, port: u16) -> Result<Self, BindError> {
        let place = SocketAddrV4::new(address, port);
        let refused = |error: io::Error| match error.kind() {
            io::ErrorKind::AddrInUse => BindError::InUse(place),
            io::ErrorKind::AddrNotAvailable => BindError::NotOurs(address),
            _ => BindError::System(place, error),
        };
        let control = UdpSocket::bind(place).map_err(refused)?;
        let stream = UdpSocket::bind((address, 0)).map_err(refused)?;
        let port = control.local_addr().map_or(port, |place| place.port());
        let hosts = u32::MAX.checked_shr(u32::from(prefix)).unwrap_or(0);
        let subnet = Ipv4Addr::from(u32::from(address) | hosts);
        let (mut broadcast, mut missed) = (Vec::new(), Vec::new());
        for to_all in [subnet, Ipv4Addr::BROADCAST] {
            let place = SocketAddrV4::new(to_all, port);
            match UdpSocket::bind(place) {
                Ok(socket) => broadcast.push(socket),
                Err(_) => missed.push(place),
            }
        }
        Ok(Self { control, broadcast, stream, missed })
    }

    /// Port of the stream.
    pub(crate) fn stream_port(&self) -> u16 {
        self.stream.local_addr().map_or(0, |place| place.port())
    }

    /// Where commands arrive.
    #[cfg(test)]
    pub(crate) fn place(&self) -> Option<SocketAddrV4> {
        match self.control.local_addr() {
            Ok(SocketAddr::V4(place)) => Some(place),
            _ => None,
        }
    }
}
