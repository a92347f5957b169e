//! `shadowgauge publish`: the head of a config as a GigE Vision camera, until Ctrl-C.

use std::net::Ipv4Addr;
use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::process::interrupt;
use crate::cli::terminal::output;
use crate::config;
use crate::publish::{BindError, Camera, DataSheet, PORT, SimulatedHead, Sockets, serve};
use crate::render::{BackendChoice, Renderer};

/// Arguments of `publish`.
#[derive(Debug, clap::Args)]
pub(crate) struct PublishArgs {
    /// The job whose head is published: its shaft, its camera, its passes and masters.
    config: PathBuf,
    /// IPv4 address of this machine at which the camera is found, with the bits of its subnet.
    /// Without them 8 on the loopback interface, 24 elsewhere.
    #[arg(long, value_name = "ADDRESS[/BITS]", default_value = "127.0.0.1")]
    listen: String,
    /// Largest packet that the network carries, bytes, headers included: 65535 on the loopback
    /// interface and 1500 elsewhere by default; 9000 with jumbo frames.
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u32).range(576..=65535))]
    mtu: Option<u32>,
    /// Where frames are rendered; auto takes a hardware adapter, else the CPU path (a software
    /// adapter only by name).
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
}

/// Publishes the head of a config.
///
/// # Errors
/// Exit 2 for a config or an address that is refused, 3 for an address that is in use, a network or
/// a device that fails.
pub(crate) fn run(args: &PublishArgs) -> CommandResult {
    let (address, prefix) = listen_address(&args.listen)?;
    let job = config::load_scene(&args.config).map_err(Failure::refused)?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let mut head = SimulatedHead::new(&job, &renderer);
    let mtu = args.mtu.unwrap_or(if address.is_loopback() { 65_535 } else { 1500 });
    let sheet = head.data_sheet(address, prefix, mtu);
    let sheet = sheet.map_err(|why| Failure::refuse(format!("{}: {why}", args.config.display())))?;
    let sockets = Sockets::bind(address, prefix, PORT).map_err(of_bind)?;
    for place in &sockets.missed {
        tracing::warn!("discoveries to {place} reach another program: connect to {address} by its address");
    }
    let camera = Camera::new(sheet.clone());
    introduce(&sheet, &camera.xml_url());
    serve(camera, &sockets, &mut head, &interrupt::requested());
    Ok(Outcome::Done)
}

fn of_bind(error: BindError) -> Failure {
    match error {
        BindError::NotOurs(_) => Failure::refuse(error),
        BindError::InUse(_) | BindError::System(..) => Failure::fail(error),
    }
}

/// Address and bits of the subnet.
fn listen_address(text: &str) -> Result<(Ipv4Addr, u8), Failure> {
    let refuse = |why: &str| {
        let right = "an IPv4 address of this machine and the bits of its subnet, such as 192.168.1.5/24";
        Failure::refuse(format!("--listen {text}: {why}; {right}"))
    };
    let (address, bits) = text.split_once('/').map_or((text, None), |(address, bits)| (address, Some(bits)));
    let address: Ipv4Addr = address.parse().map_err(|_| refuse("no IPv4 address"))?;
    if address.is_unspecified() || address.is_broadcast() || address.is_multicast() {
        return Err(refuse("a camera has one address of its own"));
    }
    let usual = if address.is_loopback() { 8 } else { 24 };
    match bits.map(str::parse::<u8>) {
        None => Ok((address, usual)),
        Some(Ok(bits)) if (1..=30).contains(&bits) => Ok((address, bits)),
        Some(_) => Err(refuse("a subnet has 1 to 30 bits")),
    }
}

/// What is published and how it is found.
fn introduce(sheet: &DataSheet, xml_url: &str) {
    let DataSheet { address, model, serial, columns, rows, .. } = sheet;
    say_line!("GigE Vision camera at {address}, UDP port {PORT}");
    say_line!("  model      {model}, serial number {serial}, shadowgauge {}", env!("CARGO_PKG_VERSION"));
    say_line!("  sensor     {columns} x {rows}, {:?}, {:.2} Hz", sheet.format, sheet.frame_rate_hz);
    say_line!("  packets    up to {} bytes (GevSCPSPacketSize)", sheet.mtu);
    say_line!("  XML        {xml_url}");
    say_line!("  connect    arv-tool-0.8 -a {address} values; docs/cameras.md has other clients");
    say_line!("Ctrl-C ends it.");
    output::flush();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_subnet() {
        let read = |text| listen_address(text).ok();
        assert_eq!(read("127.0.0.1"), Some((Ipv4Addr::LOCALHOST, 8)));
        assert_eq!(read("192.168.1.5"), Some((Ipv4Addr::new(192, 168, 1, 5), 24)));
        assert_eq!(read("10.0.0.5/16"), Some((Ipv4Addr::new(10, 0, 0, 5), 16)));
        for wrong in
            ["0.0.0.0", "255.255.255.255", "224.0.0.1", "::1", "localhost", "10.0.0.5/0", "10.0.0.5/31", ""]
        {
            let message = format!("{:?}", listen_address(wrong).unwrap_err().report);
            assert!(message.contains("192.168.1.5/24"), "{wrong}: {message}");
        }
    }
}
