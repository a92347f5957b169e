//! Whether packets of a camera reach this machine: test packets (GigE Vision 1.2, 28.4,
//! `GevSCPSFireTestPacket`), sent to a socket of our own.

use std::net::{Ipv4Addr, UdpSocket};
use std::time::Duration;

use viva_genicam::blocking;
use viva_genicam::genapi::RegisterIo;
use viva_genicam::gige::best_packet_size;

use super::error::CameraError;
use super::find;

/// Registers of stream channel 0: port of the receiver, packet size, address of the receiver.
const PORT: u64 = 0x0D00;
const PACKET_SIZE: u64 = 0x0D04;
const ADDRESS: u64 = 0x0D18;
/// Bits of the packet size: send one now, do not cut it in pieces.
const FIRE: u32 = 0x8000_0000;
const WHOLE: u32 = 0x4000_0000;
/// Sizes that are tried below the interface's: Ethernet's, and the least that every network
/// carries.
const SIZES: [u32; 2] = [1500, 576];
/// Packets of a size: one may be lost.
const TRIES: usize = 2;
/// Wait for a packet: a hundred times what it takes.
const WAIT: Duration = Duration::from_millis(200);

/// What became of the test packets of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TestPackets {
    /// Bytes of the largest one that arrived, with all headers of IP; `None` where none did.
    pub largest_bytes: Option<u32>,
    /// Bytes of the first one that was asked for: what the interface carries.
    pub wanted_bytes: u32,
}

/// Takes control of a camera for a moment and has it send test packets, the largest first.
///
/// # Errors
/// A camera that is gone, busy or refuses its stream's registers.
pub(crate) fn test_packets(address: Ipv4Addr, mtu_bytes: u32) -> Result<TestPackets, CameraError> {
    let device = find::find(&address.to_string())?;
    let camera = blocking::connect(&device).map_err(|why| CameraError::failed("control", why))?;
    let local = device.local_ip.unwrap_or(Ipv4Addr::UNSPECIFIED);
    let failed = |why: &dyn std::fmt::Display| CameraError::failed("a socket for test packets", why);
    let socket = UdpSocket::bind((local, 0)).map_err(|why| failed(&why))?;
    socket.set_read_timeout(Some(WAIT)).map_err(|why| failed(&why))?;
    let port = socket.local_addr().map_err(|why| failed(&why))?.port();
    let io = camera.transport();
    let before = [PORT, ADDRESS, PACKET_SIZE].map(|register| (register, io.read(register, 4).ok()));
    let wanted_bytes = best_packet_size(mtu_bytes);
    let set = write(io, ADDRESS, local.into()).and_then(|()| write(io, PORT, port.into()));
    let largest_bytes = set.map(|()| {
        let sizes = SIZES.into_iter().filter(|size| *size < wanted_bytes);
        std::iter::once(wanted_bytes).chain(sizes).find(|size| arrives(io, &socket, *size))
    });
    for (register, bytes) in before.into_iter().rev() {
        // Without its bits a packet size sends nothing.
        let bytes =
            bytes.filter(|bytes| register != PACKET_SIZE || bytes.first().is_some_and(|b| b & 0x80 == 0));
        if let Some(Err(why)) = bytes.map(|bytes| io.write(register, &bytes)) {
            tracing::debug!("{address}: register {register:#06x} is not restored: {why}");
        }
    }
    Ok(TestPackets { largest_bytes: largest_bytes?, wanted_bytes })
}

fn write(io: &impl RegisterIo, register: u64, value: u32) -> Result<(), CameraError> {
    let written = io.write(register, &value.to_be_bytes());
    written.map_err(|why| CameraError::failed("the stream's registers", why))
}

/// Whether a packet of this size comes; a size that the camera refuses does not.
fn arrives(io: &impl RegisterIo, socket: &UdpSocket, bytes: u32) -> bool {
    let mut buffer = vec![0; 1 << 16];
    (0..TRIES).any(|_| {
        let is_asked = write(io, PACKET_SIZE, FIRE | WHOLE | bytes).is_ok();
        // 28 bytes are the headers of IP and UDP.
        is_asked && socket.recv_from(&mut buffer).is_ok_and(|(length, _)| length + 28 >= bytes as usize)
    })
}
