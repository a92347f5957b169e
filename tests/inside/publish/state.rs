//! The camera without a network: control, heartbeat, repeated commands, registers, any datagram.

use std::net::{Ipv4Addr, SocketAddrV4};

use proptest::prelude::*;

use super::sheet;
use shadowgauge::publish::Camera;
use shadowgauge::publish::camera::{Action, Task};

const A: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 1), 5000);
const B: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 2), 5000);
const MS: u64 = 1_000_000;

const PRIVILEGE: u32 = 0x0a00;
const HEARTBEAT: u32 = 0x0938;

/// A command with its number; the status and payload of the answer.
fn ask(
    camera: &mut Camera,
    from: SocketAddrV4,
    now_ns: u64,
    (id, code): (u16, u16),
    words: &[u32],
) -> (u16, Vec<u8>) {
    let mut datagram = vec![0x42, 1];
    for word in [code, 4 * words.len() as u16, id] {
        datagram.extend(word.to_be_bytes());
    }
    datagram.extend(words.iter().flat_map(|word| word.to_be_bytes()));
    let answer = camera.answer(&datagram, from, now_ns).datagram.expect("an answer");
    assert_eq!(u16::from_be_bytes([answer[6], answer[7]]), id, "the number of the request");
    (u16::from_be_bytes([answer[0], answer[1]]), answer[8..].to_vec())
}

fn read(camera: &mut Camera, from: SocketAddrV4, now_ns: u64, address: u32) -> Result<u32, u16> {
    let (status, payload) = ask(camera, from, now_ns, (1 + (now_ns / MS) as u16, 0x80), &[address]);
    if status == 0 { Ok(u32::from_be_bytes(payload[..4].try_into().unwrap())) } else { Err(status) }
}

fn write(camera: &mut Camera, from: SocketAddrV4, now_ns: u64, address: u32, value: u32) -> u16 {
    ask(camera, from, now_ns, (1 + (now_ns / MS) as u16, 0x82), &[address, value]).0
}

#[test]
fn one_client_has_control_and_others_read_or_not_by_its_privilege() {
    let mut camera = Camera::new(sheet());
    assert_eq!(write(&mut camera, A, 0, HEARTBEAT, 1000), 0x8006, "without control nothing is written");
    assert_eq!(write(&mut camera, A, MS, PRIVILEGE, 2), 0);
    assert_eq!(write(&mut camera, B, MS, PRIVILEGE, 2), 0x8006, "a second controller");
    assert_eq!(write(&mut camera, B, 2 * MS, PRIVILEGE, 0), 0x8006, "control taken from another");
    assert_eq!(write(&mut camera, B, 3 * MS, HEARTBEAT, 1000), 0x8006);
    assert_eq!(read(&mut camera, B, 4 * MS, HEARTBEAT), Ok(3000), "others read under control");
    assert_eq!(write(&mut camera, A, 5 * MS, PRIVILEGE, 1), 0);
    assert_eq!(read(&mut camera, B, 6 * MS, HEARTBEAT), Err(0x8006), "others do not under exclusive");
    assert_eq!(read(&mut camera, A, 6 * MS, PRIVILEGE), Ok(1));
    assert_eq!(write(&mut camera, A, 7 * MS, PRIVILEGE, 4), 0x8002);
    assert_eq!(write(&mut camera, A, 8 * MS, PRIVILEGE, 0), 0);
    assert_eq!(write(&mut camera, B, 9 * MS, PRIVILEGE, 1), 0, "control is free again");
}

#[test]
fn a_controller_that_is_not_heard_of_loses_control_and_its_stream() {
    let mut camera = Camera::new(sheet());
    write(&mut camera, A, 0, PRIVILEGE, 2);
    for (address, value) in [(0x0d18, 0x7f00_0001), (0x0d00, 4000)] {
        assert_eq!(write(&mut camera, A, u64::from(address) * MS / 2000, address, value), 0);
    }
    let heard = 2 * MS + 0x0d18 * MS / 2000;
    assert_eq!(read(&mut camera, A, heard, HEARTBEAT), Ok(3000));
    camera.tick(heard + 3000 * MS);
    assert_eq!(read(&mut camera, B, heard + 3000 * MS, 0x0d00), Ok(4000), "still in time");
    camera.tick(heard + 3001 * MS);
    assert!(camera.stream().is_none());
    assert_eq!(read(&mut camera, B, heard + 3001 * MS, PRIVILEGE), Ok(0));
    assert_eq!(write(&mut camera, B, heard + 3002 * MS, PRIVILEGE, 2), 0);
}

/// The address of a register, by its name in the XML.
fn address(camera: &mut Camera, name: &str) -> u32 {
    let url = camera.xml_url();
    let mut parts = url.split(';').skip(1).map(|text| u32::from_str_radix(text, 16).unwrap());
    let (from, bytes) = (parts.next().unwrap(), parts.next().unwrap());
    let mut xml = Vec::new();
    for at in (from..from + bytes).step_by(512) {
        let (status, data) = ask(camera, A, 0, (9, 0x84), &[at, (from + bytes - at).min(512)]);
        assert_eq!(status, 0);
        xml.extend_from_slice(&data[4..]);
    }
    let xml = String::from_utf8(xml).unwrap();
    let node = xml.split_once(&format!("Name=\"{name}_Reg\"")).expect("a register").1;
    let text = node.split_once("<Address>0x").unwrap().1.split_once('<').unwrap().0;
    u32::from_str_radix(text, 16).unwrap()
}

#[test]
fn the_number_of_a_frame_is_held_until_control_is_given_up_and_pass_0_is_a_blank() {
    let mut camera = Camera::new(sheet());
    let names = ["TriggerMode", "AcquisitionStart", "TriggerSoftware", "HeadFrame", "PassNumber", "PassCut"];
    let [mode, start, trigger, number, pass, cut] = names.map(|name| address(&mut camera, name));
    let mut now = 10 * MS;
    let mut put = |camera: &mut Camera, address, value| {
        now += MS;
        assert_eq!(write(camera, A, now, address, value), 0, "{address:#x} = {value}");
        camera.next_task(now)
    };
    put(&mut camera, PRIVILEGE, 2);
    put(&mut camera, 0x0d18, 0x7f00_0001);
    put(&mut camera, 0x0d00, 4000);
    put(&mut camera, mode, 1);
    put(&mut camera, start, 1);
    let mut frame = |camera: &mut Camera, held: u32| {
        put(camera, number, held);
        let Some(Task::Frame(task)) = put(camera, trigger, 1) else { panic!("no frame") };
        task.order.of_object
    };
    assert_eq!([3, 3, 1, 0].map(|held| frame(&mut camera, held)), [Some(2), Some(2), Some(0), None]);
    assert_eq!(frame(&mut camera, 9), Some(8));
    assert_eq!(write(&mut camera, A, 900 * MS, pass, 0), 0);
    assert_eq!(write(&mut camera, A, 901 * MS, cut, 1), 0);
    let Some(Task::Cut(order)) = camera.next_task(902 * MS) else { panic!("no blank") };
    assert_eq!(order.pass, 0);
    assert_eq!(write(&mut camera, A, 903 * MS, PRIVILEGE, 0), 0);
    assert_eq!(read(&mut camera, B, 904 * MS, number), Ok(0));
}

#[test]
fn a_repeated_command_is_answered_again_and_not_executed_again() {
    let mut camera = Camera::new(sheet());
    write(&mut camera, A, 0, PRIVILEGE, 2);
    let sent = ["TriggerMode", "AcquisitionStart", "TriggerSoftware"].map(|name| address(&mut camera, name));
    write(&mut camera, A, 10 * MS, 0x0d18, 0x7f00_0001);
    write(&mut camera, A, 11 * MS, 0x0d00, 4000);
    write(&mut camera, A, 12 * MS, sent[0], 1);
    write(&mut camera, A, 13 * MS, sent[1], 1);
    for _ in 0..3 {
        assert_eq!(ask(&mut camera, A, 14 * MS, (77, 0x82), &[sent[2], 1]), (0, vec![0, 0, 0, 1]));
    }
    let mut frames = 0;
    while let Some(Task::Frame(_)) = camera.next_task(15 * MS) {
        frames += 1;
    }
    assert_eq!(frames, 1, "one trigger, three datagrams");
    // the same bytes a minute later are a new command
    ask(&mut camera, A, 60_000 * MS, (77, 0x82), &[sent[2], 1]);
    assert!(camera.next_task(60_001 * MS).is_some());
}

#[test]
fn registers_refuse_what_they_cannot_hold() {
    let mut camera = Camera::new(sheet());
    write(&mut camera, A, 0, PRIVILEGE, 2);
    let [width, offset, payload, stop, start, format, exposure] = [
        "Width",
        "OffsetX",
        "PayloadSize",
        "AcquisitionStop",
        "AcquisitionStart",
        "PixelFormat",
        "ExposureTime",
    ]
    .map(|name| address(&mut camera, name));
    let mut now = 20 * MS;
    let mut put = |camera: &mut Camera, address, value| {
        now += MS;
        write(camera, A, now, address, value)
    };
    assert_eq!(put(&mut camera, width, 65), 0x8002, "wider than the sensor");
    assert_eq!(put(&mut camera, offset, 1), 0x8002, "the window would leave the sensor");
    assert_eq!((put(&mut camera, width, 32), put(&mut camera, offset, 32)), (0, 0));
    assert_eq!(put(&mut camera, format, 0x0210_0014), 0x8002, "no colours");
    assert_eq!(put(&mut camera, format, 0x010c_0047), 0);
    assert_eq!(put(&mut camera, payload, 1), 0x8004, "to read only");
    assert_eq!(read(&mut camera, A, 900 * MS, payload), Ok(32 * 48 * 3 / 2));
    assert_eq!(put(&mut camera, exposure, 1), 0x8003, "half of a register of 64 bits");
    assert_eq!(put(&mut camera, exposure + 2, 1), 0x8005);
    assert_eq!(put(&mut camera, 0x5000, 1), 0x8003);
    assert_eq!(put(&mut camera, 0x0d04, 575), 0x8002, "packets below the least size");
    assert_eq!(put(&mut camera, start, 1), 0);
    assert_eq!(put(&mut camera, width, 16), 0x8004, "not while frames are acquired");
    assert_eq!((put(&mut camera, stop, 1), put(&mut camera, width, 16)), (0, 0));
    // several at once: those before the one that is refused are written, and it is named
    let (status, written) = ask(&mut camera, A, 950 * MS, (5, 0x82), &[width, 8, payload, 1, width, 4]);
    assert_eq!((status, written), (0x8004, vec![0, 0, 0, 1]));
    assert_eq!(read(&mut camera, A, 951 * MS, width), Ok(8));
}

#[test]
fn test_packets_are_sent_within_the_networks_size_only() {
    let mut small = sheet();
    small.mtu = 1500;
    let mut camera = Camera::new(small);
    write(&mut camera, A, 0, PRIVILEGE, 2);
    write(&mut camera, A, MS, 0x0d18, 0x0a00_0001);
    write(&mut camera, A, 2 * MS, 0x0d00, 4000);
    let fire = |camera: &mut Camera, bytes: u32, id: u8| {
        let mut datagram = vec![0x42, 1, 0, 0x82, 0, 8, 0x10, id];
        datagram.extend([0x0d04, 0x8000_0000 | bytes].iter().flat_map(|word: &u32| word.to_be_bytes()));
        camera.answer(&datagram, A, 3 * MS).action
    };
    let to = SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 1), 4000);
    assert_eq!(fire(&mut camera, 1500, 1), Some(Action::TestPacket(to, 1472)));
    assert_eq!(fire(&mut camera, 9000, 2), None, "a packet that would be cut in pieces");
    assert_eq!(read(&mut camera, A, 5 * MS, 0x0d04), Ok(1500));
}

proptest! {
    /// Datagrams of any content, framed as commands or not, from two clients: every answer fits
    /// the protocol, none panics, and control is held by no more than one of them.
    #[test]
    fn any_datagrams_leave_a_camera_that_answers(
        all in prop::collection::vec(
            (any::<bool>(), prop::sample::select(vec![2_u16, 0x40, 0x80, 0x82, 0x84, 0x86, 0x99]),
             prop::collection::vec(any::<u8>(), 0..64), 0_usize..8),
            1..40,
        ),
    ) {
        let mut camera = Camera::new(sheet());
        let known = [PRIVILEGE, 0x0d00, 0x0d04, 0x0d18, 0x1_0000, 0x1_0010, 0x10_0000, 0xffff_fffc];
        for ((from_a, code, mut payload, address), k) in all.into_iter().zip(1_u16..) {
            payload.resize(payload.len().next_multiple_of(4), 0);
            if payload.len() >= 4 {
                payload[..4].copy_from_slice(&known[address].to_be_bytes());
            }
            let mut datagram = vec![0x42, 1];
            for word in [code, payload.len() as u16, k] {
                datagram.extend(word.to_be_bytes());
            }
            datagram.extend(payload);
            let reply = camera.answer(&datagram, if from_a { A } else { B }, u64::from(k) * MS);
            if let Some(answer) = reply.datagram {
                prop_assert!((8..=548).contains(&answer.len()));
            }
            camera.tick(u64::from(k) * MS);
            camera.next_task(u64::from(k) * MS);
        }
        let found = ask(&mut camera, B, 1_000_000 * MS, (500, 2), &[]);
        prop_assert_eq!((found.0, found.1.len()), (0, 248));
    }
}
