//! Over the loopback interface: discovery, streams to the bit, resends, faults, control.

use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::gige_client::{Client, Received, chunks};
use super::{DrawnHead, grey, sheet};
use shadowgauge::publish::gvsp::StreamFormat;
use shadowgauge::publish::{Camera, DataSheet, Sockets, serve};

const LONG: Duration = Duration::from_secs(20);

/// Serves a head on a port of its own while `test` runs, then ends it.
fn with_head(sheet: DataSheet, test: impl FnOnce(SocketAddrV4) + std::panic::UnwindSafe) -> DrawnHead {
    let sockets = Sockets::bind(Ipv4Addr::LOCALHOST, 8, 0).unwrap();
    let (mut head, stop) = (DrawnHead::default(), AtomicBool::new(false));
    let place = sockets.place().unwrap();
    let failed = std::thread::scope(|threads| {
        threads.spawn(|| serve(Camera::new(sheet), &sockets, &mut head, &stop));
        let result = std::panic::catch_unwind(|| test(place));
        stop.store(true, Ordering::Relaxed);
        result.err()
    });
    if let Some(panic) = failed {
        std::panic::resume_unwind(panic);
    }
    head
}

/// A client in control, its stream open with packets of `bytes` bytes.
fn in_control(place: SocketAddrV4, bytes: u32) -> Client {
    let mut client = Client::new(place);
    client.take_control(2).unwrap();
    client.open_stream(bytes);
    client
}

/// Grey values of a payload, bit by bit or byte by byte: written from the published layouts.
fn unpacked(format: StreamFormat, bytes: &[u8], count: usize) -> Vec<u16> {
    let bit = |at: usize| u16::from(bytes[at / 8] >> (at % 8) & 1);
    let stream = |bits: usize, k: usize| (0..bits).map(|b| bit(k * bits + b) << b).sum();
    let pixel = |k: usize| match format {
        StreamFormat::Mono8 => u16::from(bytes[k]),
        StreamFormat::Mono10p => stream(10, k),
        StreamFormat::Mono12p => stream(12, k),
        StreamFormat::Mono12Packed => {
            let (base, upper) = (k / 2 * 3, |byte: u8| u16::from(byte) << 4);
            match k % 2 {
                0 => upper(bytes[base]) | u16::from(bytes[base + 1] & 0x0f),
                _ => upper(bytes[base + 2]) | u16::from(bytes[base + 1] >> 4),
            }
        }
        _ => u16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]),
    };
    (0..count).map(pixel).collect()
}

/// Whether a frame is number `number` of its acquisition, in this format.
fn assert_is(frame: &Received, number: u64, format: StreamFormat) {
    assert_eq!((frame.missing, frame.format), (0, format.code()));
    let mask = format.grey().full_scale().unwrap();
    let (rows, columns) = (frame.rows, frame.columns);
    let place = |k: u32| (frame.row + k / columns, frame.column + k % columns);
    let wanted: Vec<u16> = (0..rows * columns).map(place).map(|(r, c)| grey(number, r, c) & mask).collect();
    let bytes = wanted.len() * format.bits() / 8;
    assert!(frame.payload.len() >= bytes);
    assert_eq!(unpacked(format, &frame.payload, wanted.len()), wanted, "frame {number}");
}

#[test]
fn the_head_is_found_at_its_address_and_by_broadcast() {
    with_head(sheet(), |place| {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        socket.set_broadcast(true).unwrap();
        socket.set_read_timeout(Some(LONG)).unwrap();
        for (to, id) in [(Ipv4Addr::LOCALHOST, 0xffff_u16), (Ipv4Addr::new(127, 255, 255, 255), 0x0102)] {
            let mut datagram = vec![0x42, 0x11, 0, 2, 0, 0];
            datagram.extend(id.to_be_bytes());
            socket.send_to(&datagram, (to, place.port())).unwrap();
            let mut answer = [0; 600];
            let (length, from) = socket.recv_from(&mut answer).unwrap();
            assert_eq!((length, from.port()), (256, place.port()));
            assert_eq!(answer[..8], [0, 0, 0, 3, 0, 248, (id >> 8) as u8, id as u8]);
            assert_eq!((&answer[44..48], &answer[80..91]), (&[127, 0, 0, 1][..], &b"shadowgauge"[..]));
        }
    });
}

#[test]
fn fifty_frames_arrive_to_the_bit_in_every_format_window_and_width_of_ids() {
    with_head(sheet(), |place| {
        let mut client = in_control(place, 1500);
        client.set("AcquisitionMode", 2);
        client.set_float("AcquisitionFrameRate", 1000.0);
        for (k, (format, name)) in StreamFormat::ALL.into_iter().enumerate() {
            let frames = if k == 0 { 50 } else { 5 };
            client.set("AcquisitionFrameCount", frames);
            client.set("PixelFormat", format.code());
            client.set("Width", 64 - 3 * k as u32);
            client.set("OffsetX", 3 * k as u32);
            client.set("Height", 48 - k as u32);
            let extended = k % 2 == 0;
            client.write_register(0x0960, if extended { 0x4000_0000 } else { 0 }).unwrap();
            client.open_stream([576, 1500, 9000][k % 3]);
            client.set("AcquisitionStart", 1);
            for number in 0..frames {
                let frame = client.frame(LONG).unwrap_or_else(|| panic!("{name}: no frame {number}"));
                assert_eq!((frame.block, frame.extended), (u64::from(number) + 1, extended));
                assert_eq!((frame.columns, frame.column), (64 - 3 * k as u32, 3 * k as u32));
                assert_eq!(frame.payload.len(), client.get("PayloadSize") as usize);
                assert_is(&frame, number.into(), format);
            }
            client.set("OffsetX", 0);
        }
    });
}

#[test]
fn packets_that_are_lost_come_again_when_asked_for_the_trailer_included() {
    with_head(sheet(), |place| {
        let mut client = in_control(place, 576);
        client.set("FaultPacketLoss", 100);
        client.set("FaultSeed", 11);
        client.set("AcquisitionMode", 2);
        client.set("AcquisitionFrameCount", 60);
        // the head keeps twelve frames: 0.4 s for the requests
        client.set_float("AcquisitionFrameRate", 30.0);
        client.set("AcquisitionStart", 1);
        for number in 0..60 {
            let frame = client.frame(LONG).unwrap_or_else(|| panic!("no frame {number}"));
            assert_is(&frame, number, StreamFormat::Mono12);
        }
        // 60 frames of 14 packets, a tenth lost: 84 ± 9
        assert!((40..400).contains(&client.asked_again), "{}", client.asked_again);
        assert!(client.get("PacketsResent") >= 40);
        // a frame that is not kept (any more) is answered by a packet that states so
        let request =
            [0x42, 0x10, 0, 0x40, 0, 20, 9, 9, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 9, 0, 0, 0, 9];
        client.stream.send_to(&request, place).unwrap();
        let gone = std::iter::from_fn(|| client.packet(LONG)).find(|p| p.status != 0).unwrap();
        assert_eq!((gone.status, gone.block, gone.number), (0x800c, (9 << 32) + 9, 1));
        // and so is one that is kept, where the fault is asked for
        client.set("FaultPacketLoss", 0);
        client.set("FaultResendRefused", 1);
        client.set("AcquisitionFrameCount", 1);
        client.set("AcquisitionStart", 1);
        let block = client.frame(LONG).unwrap().block;
        let kept = [&request[..20], &block.to_be_bytes()].concat();
        client.stream.send_to(&kept, place).unwrap();
        let gone = std::iter::from_fn(|| client.packet(LONG)).find(|p| p.status != 0).unwrap();
        assert_eq!((gone.status, gone.block, gone.number), (0x800c, block, 1));
    });
}

#[test]
fn a_client_that_is_gone_frees_the_head_and_its_stream_ends() {
    with_head(sheet(), |place| {
        let mut first = in_control(place, 1500);
        first.set("GevHeartbeatTimeout", 500);
        first.set("AcquisitionStart", 1);
        assert!(first.frame(LONG).is_some());
        let mut second = Client::new(place);
        assert_eq!(second.take_control(2), Err(0x8006), "the first is still there");
        let begun = Instant::now();
        while second.take_control(1).is_err() {
            assert!(begun.elapsed() < LONG, "control is not released");
            std::thread::sleep(Duration::from_millis(20));
        }
        assert_eq!(first.read_register(0x0938), Err(0x8006), "none under exclusive");
        while first.packet(Duration::from_millis(300)).is_some() {}
        assert_eq!(second.get("FramesSent"), second.get("FramesSent"), "the stream has ended");
    });
}

#[test]
fn triggers_take_a_frame_each_and_chunks_state_what_was_ordered() {
    with_head(sheet(), |place| {
        let mut client = in_control(place, 1500);
        client.set("TriggerMode", 1);
        client.set("ChunkModeActive", 1);
        client.set("AcquisitionStart", 1);
        for (number, angle_deg) in [(0, 157.5), (1, -30.0), (2, 0.1)] {
            client.set_float("SpindleAngle", angle_deg);
            client.set_float("CarriageZ", 7.25 + angle_deg);
            client.set("TriggerSoftware", 1);
            let frame = client.frame(LONG).unwrap();
            assert_is(&frame, number, StreamFormat::Mono12);
            assert_eq!(
                (frame.payload_type, frame.payload.len()),
                (0x4001, client.get("PayloadSize") as usize)
            );
            let all = chunks(&frame.payload);
            let ids: Vec<u32> = all.keys().map(|id| id - 0x5347_0000).collect();
            assert_eq!(ids, [1, 2, 3, 4, 5, 6]);
            let float = |bytes: &[u8]| f64::from_be_bytes(bytes.try_into().unwrap());
            let encoders = &all[&0x5347_0006];
            assert_eq!((float(&encoders[..8]), float(&encoders[8..])), (angle_deg, 7.25 + angle_deg));
            assert_eq!(all[&0x5347_0003], (number + 1).to_be_bytes());
            assert_eq!(all[&0x5347_0002], frame.timestamp_ns.to_be_bytes());
        }
        assert!(client.frame(Duration::from_millis(300)).is_none(), "a frame without a trigger");
    });
}

#[test]
fn the_spindle_turns_by_the_period_of_a_free_run() {
    with_head(sheet(), |place| {
        let mut client = in_control(place, 1500);
        client.set("ChunkModeActive", 1);
        client.set_float("SpindleSpeed", 600.0);
        client.set_float("SpindleAngle", 10.0);
        client.set_float("AcquisitionFrameRate", 100.0);
        client.set("AcquisitionStart", 1);
        for number in 0..12 {
            let frame = client.frame(LONG).unwrap();
            let bytes = chunks(&frame.payload)[&0x5347_0006][..8].try_into().unwrap();
            // 600 rev/min: 3.6° a millisecond
            let wanted = (10.0 + 36.0 * f64::from(number)).rem_euclid(360.0);
            assert!((f64::from_be_bytes(bytes) - wanted).abs() < 1e-9, "frame {number}");
        }
    });
}

#[test]
fn faults_are_those_that_were_asked_for() {
    with_head(sheet(), |place| {
        let mut client = in_control(place, 9000);
        client.resends = false;
        client.set("AcquisitionMode", 2);
        client.set("AcquisitionFrameCount", 6);
        client.set("FaultWrongSize", 3);
        client.set("AcquisitionStart", 1);
        let rows: Vec<u32> = (0..6).map(|_| client.frame(LONG).unwrap().rows).collect();
        assert_eq!(rows, [48, 48, 47, 48, 48, 47]);
        client.set("FaultWrongSize", 0);
        client.set("FaultDuplicate", 2);
        client.open_stream(9000);
        client.set("AcquisitionStart", 1);
        let packets: Vec<u64> = (0..27).map(|_| client.packet(LONG).unwrap().block).collect();
        let counts: Vec<usize> = (1..=6).map(|b| packets.iter().filter(|p| **p == b).count()).collect();
        assert_eq!(counts, [3, 6, 3, 6, 3, 6], "three packets a frame, every second one twice");
        client.set("FaultDuplicate", 0);
        client.set("FaultStreamSilence", 1);
        client.set("AcquisitionStart", 1);
        assert!(client.packet(Duration::from_millis(300)).is_none(), "a packet of a silent stream");
        client.set("FaultStreamSilence", 0);
        client.set("FaultSilence", 600);
        let payload = 0x0a00_u32.to_be_bytes();
        client.control.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
        assert_eq!(client.try_command(50_000, 0x80, &payload), None, "an answer of a silent head");
        client.control.set_read_timeout(Some(Duration::from_millis(1500))).unwrap();
        assert_eq!(client.command_by_id(50_001, 0x80, &payload).0, 0, "back again");
    });
}

#[test]
fn triggers_are_ignored_and_doubled_on_demand() {
    with_head(sheet(), |place| {
        let mut client = in_control(place, 9000);
        client.set("TriggerMode", 1);
        client.set("FaultTriggerIgnored", 2);
        client.set("FaultTriggerDoubled", 3);
        client.set("AcquisitionStart", 1);
        let mut frames = Vec::new();
        for _ in 0..3 {
            client.set("TriggerSoftware", 1);
            let taken = std::iter::from_fn(|| client.frame(Duration::from_millis(300))).count();
            frames.push(taken);
        }
        assert_eq!(frames, [1, 0, 2]);
        assert_eq!(client.get("TriggersMissed"), 1);
    });
}

#[test]
fn passes_are_cut_and_refused_with_the_reason() {
    let head = with_head(sheet(), |place| {
        let mut client = in_control(place, 1500);
        let cut = |client: &mut Client| {
            client.set("PassCut", 1);
            let begun = Instant::now();
            while client.get("PassState") == 1 {
                assert!(begun.elapsed() < LONG);
            }
            (client.get("PassState"), client.text("HeadMessage", 128))
        };
        client.set("PassNumber", 2);
        assert_eq!(client.float("PassNominalDiameter"), 11.0);
        let offsets = client.address("PassOffset");
        client.write_memory(offsets + 8, &0.25_f64.to_be_bytes()).unwrap();
        assert_eq!(cut(&mut client), (2, String::new()));
        client.write_memory(offsets, &2.0_f64.to_be_bytes()).unwrap();
        assert_eq!(cut(&mut client), (3, "an offset of more than 1 mm".to_owned()));
        // a frame that cannot be taken ends the acquisition, with its reason
        client.set_float("ShaftDiameter", 3.0);
        client.set("AcquisitionStart", 1);
        assert!(client.frame(Duration::from_millis(300)).is_none());
        assert_eq!(client.text("HeadMessage", 128), "no shaft of 3 mm");
    });
    assert_eq!(head.passes.len(), 1);
    assert_eq!((head.passes[0].pass, &head.passes[0].offset_mm[..]), (2, &[0.0, 0.25, 0.0][..]));
}

#[test]
fn an_address_in_use_or_of_another_machine_is_named() {
    let first = Sockets::bind(Ipv4Addr::LOCALHOST, 8, 0).unwrap();
    let place = first.place().unwrap();
    let taken = Sockets::bind(*place.ip(), 8, place.port()).unwrap_err().to_string();
    assert!(taken.contains(&place.to_string()) && taken.contains("127.0.0.2"), "{taken}");
    // TEST-NET-1 of RFC 5737
    let foreign = Sockets::bind(Ipv4Addr::new(192, 0, 2, 1), 24, 0).unwrap_err().to_string();
    assert!(foreign.contains("192.0.2.1 is no address of this machine"), "{foreign}");
}
