//! Receives a GigE Vision camera by the crate telegenic.
//!
//! `peer-telegenic IP SECONDS SETTING… [--no-resend]` with settings `Feature=value` (f64, integer
//! or entry, in this order of trial), then prints a line `block checksum` a whole frame (CRC-32 of
//! its bytes) and at the end one line of JSON with telegenic's own counters.

use std::error::Error;
use std::io::Write as _;
use std::net::Ipv4Addr;
use std::time::{Duration, Instant};

use telegenic::gige::stream::{FrameStatus, PacketSize, ResendPolicy};
use telegenic::{GenICamera, StreamConfig};

fn set(camera: &mut GenICamera, setting: &str) -> Result<(), Box<dyn Error>> {
    let (name, value) = setting.split_once('=').ok_or("a setting is Feature=value")?;
    if let Ok(number) = value.parse::<f64>() {
        if camera.set_float(name, number).is_err() {
            camera.set_integer(name, number as i64)?;
        }
        return Ok(());
    }
    Ok(camera.set_enum(name, value)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let resends = !arguments.iter().any(|argument| argument == "--no-resend");
    arguments.retain(|argument| argument != "--no-resend");
    let [address, seconds, settings @ ..] = arguments.as_slice() else {
        return Err("usage: peer-telegenic IP SECONDS Feature=value… [--no-resend]".into());
    };
    let time = Duration::from_secs_f64(seconds.parse()?);
    let mut camera = GenICamera::new(address.parse::<Ipv4Addr>()?);
    camera.connect()?;
    for setting in settings {
        set(&mut camera, setting)?;
    }
    let mut config = StreamConfig::new();
    // what the loopback interface carries in one piece
    config.packet_size = PacketSize::Fixed(60_000);
    if !resends {
        config.resend = ResendPolicy::Never;
    }
    let acquisition = camera.start_acquisition(config)?;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let (begun, mut whole, mut other) = (Instant::now(), 0_u64, 0_u64);
    while begun.elapsed() < time {
        let Some(frame) = acquisition.wait_for(Duration::from_millis(200)) else { continue };
        if frame.status == FrameStatus::Complete {
            whole += 1;
            writeln!(out, "{} {:08x}", frame.frame_id, crc32fast::hash(frame.data()))?;
        } else {
            other += 1;
            let (got, all) = (frame.received_size, frame.data().len());
            eprintln!("block {} after {:?}: {:?}, {got} of {all} bytes", frame.frame_id, begun.elapsed(), frame.status);
        }
    }
    let stats = acquisition.stats();
    let packet = acquisition.packet_size();
    acquisition.stop()?;
    writeln!(
        out,
        "{{\"whole\":{whole},\"not_whole\":{other},\"missing_frames\":{},\"missing_packets\":{},\
         \"resent_packets\":{},\"socket_drops\":{},\"frames_dropped\":{},\"packet_bytes\":{packet}}}",
        stats.missing_frames, stats.missing_packets, stats.resent_packets, stats.socket_drops, stats.frames_dropped
    )?;
    out.flush()?;
    Ok(())
}
