//! Cameras by their IPv4 address, serial number or user-defined name.

use std::net::Ipv4Addr;
use std::time::Duration;

use viva_genicam::blocking;
use viva_genicam::gige::{DeviceInfo, DiscoveryOptions};

use super::error::CameraError;

/// Wait for answers to a discovery: GigE Vision 1.2, 14.3.2, allows a device to delay its answer to
/// a broadcast by up to a second, which devices use on request alone.
pub(super) const ANSWERS: Duration = Duration::from_millis(500);
/// Discoveries of an address: a datagram may be lost.
const TRIES: usize = 2;

/// The camera of a name.
///
/// # Errors
/// None, or more than one, that answers; a system without network.
pub(super) fn find(name: &str) -> Result<DeviceInfo, CameraError> {
    if let Ok(address) = name.parse::<Ipv4Addr>() {
        let mut answers = (0..TRIES).map(|_| at(address, ANSWERS));
        return answers.find_map(Result::transpose).unwrap_or(Err(CameraError::NoAnswer(address)));
    }
    let options = DiscoveryOptions::new().include_loopback(true);
    let all = blocking::discover_with(ANSWERS, &options);
    named(name, all.map_err(|error| CameraError::failed("discovery of cameras", error))?)
}

/// The camera at an address, where one answers within the time.
///
/// # Errors
/// A system without network.
pub(super) fn at(address: Ipv4Addr, wait: Duration) -> Result<Option<DeviceInfo>, CameraError> {
    blocking::discover_ip(address, wait).map_err(|error| CameraError::failed("discovery of a camera", error))
}

/// The one camera with a serial number or a user-defined name.
fn named(name: &str, all: Vec<DeviceInfo>) -> Result<DeviceInfo, CameraError> {
    let words: Vec<String> = all.iter().map(shown).collect();
    let found = if words.is_empty() {
        "none answered: give the IP address where cameras are behind a router".to_owned()
    } else {
        format!("there are {}", words.join("; "))
    };
    let is_it = |camera: &DeviceInfo| {
        [&camera.serial, &camera.user_name].into_iter().flatten().any(|known| known.trim() == name)
    };
    let mut of_name: Vec<DeviceInfo> = all.into_iter().filter(is_it).collect();
    // A camera answers on each interface that reaches it.
    of_name.dedup_by_key(|camera| (camera.ip, camera.mac));
    let none = |name, found| CameraError::NoSuchName { name, found };
    the_one(of_name, (name, found), none)
}

/// The only camera of a name; `none` is the error where there is none, of the name and of what was
/// found.
pub(super) fn the_one<D>(
    mut of_name: Vec<D>,
    (name, found): (&str, String),
    none: impl FnOnce(String, String) -> CameraError,
) -> Result<D, CameraError> {
    let name = name.to_owned();
    match (of_name.pop(), of_name.len()) {
        (None, _) => Err(none(name, found)),
        (Some(camera), 0) => Ok(camera),
        (Some(_), others) => Err(CameraError::NotOne { name, count: others + 1, found }),
    }
}

/// Maker, model, serial number and address of a camera.
pub(super) fn shown(camera: &DeviceInfo) -> String {
    let of = |text: &Option<String>| text.clone().unwrap_or_default();
    let name = of(&camera.user_name);
    let name = if name.is_empty() { name } else { format!(" \"{name}\"") };
    format!(
        "{} {}, serial number {},{name} at {}",
        of(&camera.manufacturer),
        of(&camera.model),
        of(&camera.serial),
        camera.ip
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(last: u8, serial: &str, name: &str) -> DeviceInfo {
        let mut camera = DeviceInfo::from_ip(Ipv4Addr::new(192, 168, 1, last));
        (camera.serial, camera.user_name) = (Some(serial.into()), Some(name.into()));
        camera
    }

    #[test]
    fn a_name_is_a_serial_number_or_a_user_defined_name_of_one_camera() {
        let all =
            || vec![camera(2, "40001", "left"), camera(3, "40002", "right"), camera(4, "40003", "right")];
        assert_eq!(named("40002", all()).unwrap().ip, Ipv4Addr::new(192, 168, 1, 3));
        assert_eq!(named("left", all()).unwrap().ip, Ipv4Addr::new(192, 168, 1, 2));
        let why = named("right", all()).unwrap_err().to_string();
        assert!(why.starts_with("2 cameras have the name \"right\"") && why.contains("192.168.1.4"), "{why}");
        let why = named("40009", all()).unwrap_err().to_string();
        assert!(why.contains("\"40009\"; there are") && why.contains("40001"), "{why}");
        let twice = vec![camera(2, "40001", "left"), camera(2, "40001", "left")];
        assert_eq!(named("left", twice).unwrap().serial.as_deref(), Some("40001"));
        assert!(named("left", Vec::new()).unwrap_err().to_string().contains("none answered"));
    }
}
