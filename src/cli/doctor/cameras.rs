//! Cameras by network interface, and what would keep their frames from arriving.
#![cfg_attr(
    not(feature = "camera"),
    allow(dead_code, reason = "a program without cameras states that, and lists none")
)]

use serde::Serialize;

#[cfg(feature = "camera")]
use super::network::{burst_bytes, receive_buffer_bytes};
#[cfg(feature = "camera")]
use crate::source::camera::{
    AccessStatus, FoundCamera as Found, NetworkInterface, TestPackets, interfaces, test_packets,
};

/// Packets as large as jumbo frames carry, bytes.
#[cfg(feature = "camera")]
const JUMBO: u32 = 9000;

/// What is known of cameras.
#[derive(Debug, Default, Serialize)]
pub(super) struct CameraFindings {
    /// Whether this program has cameras at all.
    is_built: bool,
    interfaces: Vec<InterfaceFindings>,
    /// `net.core.rmem_max`, bytes.
    receive_buffer_bytes: Option<u64>,
    /// What would be better, in words.
    hints: Vec<String>,
}

/// An interface with its cameras.
#[derive(Debug, Serialize)]
struct InterfaceFindings {
    name: String,
    addresses: Vec<String>,
    mtu_bytes: u32,
    cameras: Vec<FoundCamera>,
}

/// A camera that answered.
#[derive(Debug, Serialize)]
struct FoundCamera {
    address: String,
    manufacturer: String,
    model: String,
    serial_number: String,
    user_name: String,
    /// free, controlled, exclusive or unknown.
    access: &'static str,
    is_in_subnet: bool,
    frame_bytes: Option<u64>,
    /// Largest test packet that arrived, bytes; left out where none was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    test_packet_bytes: Option<u32>,
}

impl CameraFindings {
    /// Looks for cameras on every interface; `tests` has those that are free send test packets.
    #[cfg(feature = "camera")]
    pub(super) fn look(tests: bool) -> Self {
        let receive_buffer_bytes = receive_buffer_bytes();
        let mut findings = Self { is_built: true, receive_buffer_bytes, ..Self::default() };
        let all = match interfaces() {
            Ok(all) => all,
            Err(why) => {
                findings.hints.push(why.to_string());
                return findings;
            }
        };
        for interface in &all {
            let tested = tests.then(|| tested(interface, &mut findings.hints));
            findings.add(interface, &tested.unwrap_or_default());
        }
        findings
    }

    /// There is no client in this build.
    #[cfg(not(feature = "camera"))]
    pub(super) fn look(_tests: bool) -> Self {
        Self::default()
    }

    #[cfg(feature = "camera")]
    fn add(&mut self, interface: &NetworkInterface, tested: &[Option<TestPackets>]) {
        let cameras = interface.cameras.iter().enumerate().map(|(at, camera)| FoundCamera {
            address: camera.address.to_string(),
            manufacturer: camera.manufacturer.clone(),
            model: camera.model.clone(),
            serial_number: camera.serial_number.clone(),
            user_name: camera.user_name.clone(),
            access: camera.access.word(),
            is_in_subnet: camera.is_in_subnet,
            frame_bytes: camera.frame_bytes,
            test_packet_bytes: tested.get(at).copied().flatten().and_then(|packets| packets.largest_bytes),
        });
        self.hints.extend(hints(interface, self.receive_buffer_bytes));
        self.interfaces.push(InterfaceFindings {
            name: interface.name.clone(),
            addresses: interface.addresses.iter().map(ToString::to_string).collect(),
            mtu_bytes: interface.mtu_bytes,
            cameras: cameras.collect(),
        });
    }

    /// Prints the findings.
    pub(super) fn print(&self) {
        if !self.is_built {
            say_line!("cameras: this program was built without the feature camera");
            return;
        }
        for interface in &self.interfaces {
            let InterfaceFindings { name, addresses, mtu_bytes, cameras } = interface;
            let addresses = addresses.join(", ");
            let none = if cameras.is_empty() { ": no camera answers" } else { "" };
            say_line!("interface {name} ({addresses}), packets up to {mtu_bytes} bytes{none}");
            for camera in cameras {
                let FoundCamera { address, manufacturer, model, serial_number, user_name, access, .. } =
                    camera;
                let called = match user_name.as_str() {
                    "" => String::new(),
                    user_name => format!(" \"{user_name}\""),
                };
                let frame = camera.frame_bytes.map_or_else(String::new, |b| format!(", frames of {b} bytes"));
                let test = camera.test_packet_bytes;
                let test = test.map_or_else(String::new, |b| format!(", a test packet of {b} bytes arrives"));
                say_line!(
                    "  camera {address}: {manufacturer} {model}, serial number {serial_number}{called}, {access}{frame}{test}"
                );
            }
        }
        for hint in &self.hints {
            say_line!("  hint: {hint}");
        }
    }
}

/// Test packets of the cameras that are free; what that shows is added to the hints.
#[cfg(feature = "camera")]
fn tested(interface: &NetworkInterface, hints: &mut Vec<String>) -> Vec<Option<TestPackets>> {
    let test = |camera: &Found| {
        if camera.access != AccessStatus::Free || !camera.is_in_subnet {
            return None;
        }
        let address = camera.address;
        match test_packets(address, interface.mtu_bytes) {
            Ok(packets) => {
                hints.extend(of_packets(&address.to_string(), packets));
                Some(packets)
            }
            Err(why) => {
                hints.push(format!("{address}: no test packet was asked for: {why}"));
                None
            }
        }
    };
    interface.cameras.iter().map(test).collect()
}

/// What test packets show.
#[cfg(feature = "camera")]
fn of_packets(address: &str, packets: TestPackets) -> Option<String> {
    let TestPackets { largest_bytes, wanted_bytes } = packets;
    match largest_bytes {
        None => Some(format!(
            "{address}: it answers, but no test packet comes: a firewall drops UDP from {address} to this machine, or the \
             camera sends no test packets"
        )),
        Some(bytes) if bytes < wanted_bytes => Some(format!(
            "{address}: packets of {wanted_bytes} bytes do not arrive, those of {bytes} do: a switch on the way, or the \
             camera, carries no larger ones"
        )),
        Some(_) => None,
    }
}

/// What an interface and the receive buffer would keep from arriving.
#[cfg(feature = "camera")]
fn hints(interface: &NetworkInterface, buffer_bytes: Option<u64>) -> Vec<String> {
    let (name, mtu) = (&interface.name, interface.mtu_bytes);
    let mut hints = Vec::new();
    if !interface.cameras.is_empty() && !interface.is_loopback() && mtu < JUMBO {
        hints.push(format!(
            "{name} carries packets of {mtu} bytes: with jumbo frames (`ip link set {name} mtu {JUMBO}`, and a switch that \
             carries them) a frame is a sixth of the packets"
        ));
    }
    for camera in &interface.cameras {
        let address = camera.address;
        if !camera.is_in_subnet {
            hints.push(format!(
                "{address} is in another subnet than {name}: it answers broadcasts and cannot be opened; give it an address \
                 of this subnet"
            ));
        }
        if matches!(camera.access, AccessStatus::Exclusive | AccessStatus::Controlled) {
            hints.push(format!("{address} is busy: another program has control of it; end that one"));
        }
        if let (Some(frame_bytes), Some(buffer_bytes)) = (camera.frame_bytes, buffer_bytes) {
            let needed = burst_bytes(frame_bytes, mtu);
            if needed > buffer_bytes {
                hints.push(format!(
                    "{address}: a frame of {frame_bytes} bytes in one burst needs a receive buffer of {needed} bytes, and \
                     net.core.rmem_max is {buffer_bytes}: `sysctl -w net.core.rmem_max={needed}`, or slow its packets down \
                     (GevSCPD)"
                ));
            }
        }
    }
    hints
}

#[cfg(all(test, feature = "camera"))]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    fn camera(access: AccessStatus, is_in_subnet: bool, frame_bytes: u64) -> Found {
        Found {
            address: Ipv4Addr::new(192, 168, 1, 20),
            manufacturer: "M".to_owned(),
            model: "X".to_owned(),
            serial_number: "40001".to_owned(),
            user_name: String::new(),
            access,
            is_in_subnet,
            frame_bytes: Some(frame_bytes),
        }
    }

    fn interface(mtu_bytes: u32, cameras: Vec<Found>) -> NetworkInterface {
        let addresses = vec![Ipv4Addr::new(192, 168, 1, 5)];
        NetworkInterface { name: "eth1".to_owned(), addresses, mtu_bytes, cameras }
    }

    #[test]
    fn what_keeps_frames_from_arriving_is_named_with_what_would_be_right() {
        assert!(hints(&interface(1500, Vec::new()), Some(212_992)).is_empty(), "no camera, no hint");
        let all = |mtu, of: Found, buffer| hints(&interface(mtu, vec![of]), Some(buffer)).join("\n");
        let good = all(9000, camera(AccessStatus::Free, true, 4 << 20), 16 << 20);
        assert_eq!(good, "");
        let short = all(9000, camera(AccessStatus::Free, true, 4 << 20), 212_992);
        assert!(short.contains("net.core.rmem_max is 212992") && short.contains("192.168.1.20"), "{short}");
        let words = all(1500, camera(AccessStatus::Controlled, false, 1), 1 << 20);
        assert!(words.contains("eth1 mtu 9000") && words.contains("another subnet"), "{words}");
        assert!(words.contains("is busy"), "{words}");
    }

    #[test]
    fn a_firewall_and_a_switch_differ_in_their_test_packets() {
        let of =
            |largest_bytes| of_packets("192.168.1.20", TestPackets { largest_bytes, wanted_bytes: 9000 });
        assert_eq!(of(Some(9000)), None);
        assert!(of(Some(1500)).unwrap().contains("those of 1500 do: a switch"));
        assert!(of(None).unwrap().contains("firewall"));
    }
}
