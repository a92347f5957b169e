//! Cameras by network interface: what answers to a discovery, who has control, and how many bytes a
//! frame has.
//!
//! Nothing is written to a camera: the discovery of every interface is one broadcast (on the
//! loopback interface one datagram to its address), and what it does not state is read by a client
//! that takes no control.

use std::net::Ipv4Addr;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use viva_genicam::genapi::RegisterIo as _;
use viva_genicam::gencp::StatusCode;
use viva_genicam::gige::{DeviceInfo, DiscoveryOptions, GigeError, GigeStatus, Iface, mtu};
use viva_genicam::{Access, GenicamError, blocking};

use super::error::CameraError;
use super::features::Features as _;
use super::find::ANSWERS;

/// Control channel privilege (GigE Vision 1.2, 28.1).
const PRIVILEGE: u64 = 0x0A00;
/// Longest time to read what the discovery does not state: a description in XML of 1 MB takes half
/// of it on a free link.
const READ: Duration = Duration::from_millis(500);

/// Whether a camera can be opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AccessStatus {
    /// No program has control.
    Free,
    /// A program has control; others may read.
    Controlled,
    /// A program has control alone.
    Exclusive,
    /// It answers the discovery and nothing else in time.
    Unknown,
}

impl AccessStatus {
    /// Its word in outputs.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Controlled => "controlled",
            Self::Exclusive => "exclusive",
            Self::Unknown => "unknown",
        }
    }

    /// That of the register: bit 31 is exclusive access, bit 30 control access, counted from the
    /// highest.
    fn of_register(value: u32) -> Self {
        match (value & 1, value & 2) {
            (1, _) => Self::Exclusive,
            (_, 2) => Self::Controlled,
            _ => Self::Free,
        }
    }
}

/// A camera that answered.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FoundCamera {
    /// Its address.
    pub address: Ipv4Addr,
    /// Maker.
    pub manufacturer: String,
    /// Model.
    pub model: String,
    /// Serial number.
    pub serial_number: String,
    /// User-defined name (`DeviceUserID`).
    pub user_name: String,
    /// Whether it can be opened.
    pub access: AccessStatus,
    /// Whether it is in the interface's subnet: another one answers broadcasts and nothing else.
    pub is_in_subnet: bool,
    /// Bytes of a frame as it is set (`PayloadSize`), where it was read in time.
    pub frame_bytes: Option<u64>,
}

/// An interface of this machine with an IPv4 address.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NetworkInterface {
    /// Its name.
    pub name: String,
    /// Its IPv4 addresses.
    pub addresses: Vec<Ipv4Addr>,
    /// Largest packet that it carries, bytes with all headers of IP.
    pub mtu_bytes: u32,
    /// Cameras that answered on it, by address.
    pub cameras: Vec<FoundCamera>,
}

impl NetworkInterface {
    /// Whether it is the machine's own, which no cable leaves.
    pub(crate) fn is_loopback(&self) -> bool {
        self.addresses.iter().any(Ipv4Addr::is_loopback)
    }
}

/// The interfaces of this machine with the cameras that answer within a second.
///
/// # Errors
/// A system without network.
pub(crate) fn interfaces() -> Result<Vec<NetworkInterface>, CameraError> {
    let all = Iface::list().map_err(|why| CameraError::failed("the list of network interfaces", why))?;
    let options = DiscoveryOptions::new().include_loopback(true);
    let found = blocking::discover_with(ANSWERS, &options);
    let found = read(found.map_err(|why| CameraError::failed("discovery of cameras", why))?);
    let with_cameras = all.into_iter().filter_map(|interface| {
        let addresses = interface.all_ipv4().unwrap_or_default();
        let on_it = |device: &DeviceInfo| device.local_ip.is_some_and(|ip| addresses.contains(&ip));
        let mut cameras: Vec<FoundCamera> =
            found.iter().filter(|(device, _)| on_it(device)).map(|(_, camera)| camera.clone()).collect();
        cameras.sort_by_key(|camera| camera.address);
        cameras.dedup_by_key(|camera| camera.address);
        let mtu_bytes = mtu(&interface).bytes();
        let name = interface.name().to_owned();
        (!addresses.is_empty()).then_some(NetworkInterface { name, addresses, mtu_bytes, cameras })
    });
    Ok(with_cameras.collect())
}

/// Reads privilege and bytes of a frame of all cameras at once, as far as they answer in time.
fn read(devices: Vec<DeviceInfo>) -> Vec<(DeviceInfo, FoundCamera)> {
    let (give, answers) = channel();
    for (at, device) in devices.iter().enumerate() {
        let (give, device) = (give.clone(), device.clone());
        // A thread that is late ends with the process.
        let read = move || {
            let _ = give.send((at, privilege_and_bytes(&device)));
        };
        if let Err(why) = std::thread::Builder::new().name("doctor".to_owned()).spawn(read) {
            tracing::debug!("{why}");
        }
    }
    drop(give);
    let mut found: Vec<_> = devices.into_iter().map(|device| (described(&device), device)).collect();
    let until = Instant::now() + READ;
    while let Ok((at, (access, frame_bytes))) =
        answers.recv_timeout(until.saturating_duration_since(Instant::now()))
    {
        (found[at].0.access, found[at].0.frame_bytes) = (access, frame_bytes);
    }
    found.into_iter().map(|(camera, device)| (device, camera)).collect()
}

/// What a discovery states.
fn described(device: &DeviceInfo) -> FoundCamera {
    let stated = |text: &Option<String>| text.as_deref().unwrap_or_default().trim().to_owned();
    FoundCamera {
        address: device.ip,
        manufacturer: stated(&device.manufacturer),
        model: stated(&device.model),
        serial_number: stated(&device.serial),
        user_name: stated(&device.user_name),
        access: AccessStatus::Unknown,
        is_in_subnet: device.shares_subnet_with_host().unwrap_or(true),
        frame_bytes: None,
    }
}

fn privilege_and_bytes(device: &DeviceInfo) -> (AccessStatus, Option<u64>) {
    match blocking::connect_as(device, Access::Monitor) {
        Ok((camera, _)) => {
            let register = camera.transport().read(PRIVILEGE, 4).ok();
            let value = register.and_then(|bytes| bytes.try_into().ok()).map(u32::from_be_bytes);
            let bytes = camera.number("PayloadSize").filter(|bytes| *bytes > 0.0).map(|bytes| bytes as u64);
            (value.map_or(AccessStatus::Unknown, AccessStatus::of_register), bytes)
        }
        Err(GenicamError::Gige {
            source: GigeError::Status(GigeStatus::Common(StatusCode::AccessDenied)),
            ..
        }) => (AccessStatus::Exclusive, None),
        Err(why) => {
            tracing::debug!("{}: {why}", device.ip);
            (AccessStatus::Unknown, None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_register_states_who_has_control() {
        let words = [0, 1, 2, 3, 6].map(|value| AccessStatus::of_register(value).word());
        assert_eq!(words, ["free", "exclusive", "controlled", "exclusive", "controlled"]);
    }

    #[test]
    fn a_camera_of_another_subnet_is_known_by_both_masks() {
        let mut device = DeviceInfo::from_ip(Ipv4Addr::new(10, 0, 0, 7));
        device.serial = Some(" 40001 ".to_owned());
        assert!(described(&device).is_in_subnet, "without a mask it is not known");
        device.subnet = Some(Ipv4Addr::new(255, 255, 255, 0));
        device.local_netmask = device.subnet;
        device.local_ip = Some(Ipv4Addr::new(192, 168, 1, 5));
        let camera = described(&device);
        assert_eq!((camera.is_in_subnet, camera.serial_number.as_str()), (false, "40001"));
    }
}
