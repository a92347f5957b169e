//! A small GigE Vision client for tests, written from the published layouts and sharing no code
//! with the publisher: finds, takes control, reads and writes features by the camera's own XML,
//! receives frames, asks for lost packets.
#![allow(dead_code, reason = "two tests use different parts")]

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

/// A command is repeated so often, each time after [`WAIT`].
const TRIES: usize = 4;
const WAIT: Duration = Duration::from_millis(1500);

pub struct Client {
    pub control: UdpSocket,
    pub stream: UdpSocket,
    pub camera: SocketAddrV4,
    id: u16,
    xml: String,
    /// Packets of frames that are not complete, and the last frame that was.
    frames: BTreeMap<u64, BTreeMap<u32, Packet>>,
    delivered: u64,
    /// Whether lost packets are asked for again.
    pub resends: bool,
    pub asked_again: usize,
}

#[derive(Clone, Debug)]
pub struct Packet {
    pub status: u16,
    pub block: u64,
    pub kind: u8,
    pub number: u32,
    pub extended: bool,
    pub body: Vec<u8>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Received {
    pub block: u64,
    pub payload_type: u16,
    pub timestamp_ns: u64,
    pub format: u32,
    pub columns: u32,
    pub rows: u32,
    pub column: u32,
    pub row: u32,
    pub payload: Vec<u8>,
    pub extended: bool,
    pub missing: usize,
}

fn be32(bytes: &[u8]) -> u32 {
    u32::from_be_bytes(bytes[..4].try_into().unwrap())
}

impl Packet {
    fn parse(bytes: &[u8]) -> Self {
        let status = u16::from_be_bytes([bytes[0], bytes[1]]);
        if bytes[4] & 0x80 == 0 {
            let number = be32(&bytes[4..]) & 0x00ff_ffff;
            let block = u64::from(u16::from_be_bytes([bytes[2], bytes[3]]));
            return Self {
                status,
                block,
                kind: bytes[4],
                number,
                extended: false,
                body: bytes[8..].to_vec(),
            };
        }
        let block = u64::from(be32(&bytes[8..])) << 32 | u64::from(be32(&bytes[12..]));
        let (kind, number) = (bytes[4] & 0x7f, be32(&bytes[16..]));
        Self { status, block, kind, number, extended: true, body: bytes[20..].to_vec() }
    }
}

impl Client {
    pub fn new(camera: SocketAddrV4) -> Self {
        let control = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let stream = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        control.set_read_timeout(Some(WAIT)).unwrap();
        let (xml, frames) = (String::new(), BTreeMap::new());
        Self { control, stream, camera, id: 0, xml, frames, delivered: 0, resends: true, asked_again: 0 }
    }

    /// Sends a command of `code`; status and payload of its answer.
    pub fn command(&mut self, code: u16, payload: &[u8]) -> (u16, Vec<u8>) {
        self.id = self.id % 0xffff + 1;
        self.command_by_id(self.id, code, payload)
    }

    pub fn command_by_id(&mut self, id: u16, code: u16, payload: &[u8]) -> (u16, Vec<u8>) {
        for _ in 0..TRIES {
            if let Some(answer) = self.try_command(id, code, payload) {
                return answer;
            }
        }
        panic!("no answer to command {code:#06x} of {}", self.camera);
    }

    /// One try; `None` where no answer comes in time.
    pub fn try_command(&mut self, id: u16, code: u16, payload: &[u8]) -> Option<(u16, Vec<u8>)> {
        let mut datagram = vec![0x42, 1];
        for word in [code, payload.len() as u16, id] {
            datagram.extend(word.to_be_bytes());
        }
        datagram.extend(payload);
        self.control.send_to(&datagram, self.camera).unwrap();
        let mut buffer = [0; 2048];
        loop {
            let length = match self.control.recv_from(&mut buffer) {
                Ok((length, _)) => length,
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => return None,
                Err(e) => panic!("{e}"),
            };
            let word = |at: usize| u16::from_be_bytes([buffer[at], buffer[at + 1]]);
            assert_eq!(length, 8 + usize::from(word(4)), "an answer states another length than it has");
            if word(6) == id {
                assert_eq!(word(2), code + 1, "an answer to another command");
                return Some((word(0), buffer[8..length].to_vec()));
            }
        }
    }

    pub fn read_register(&mut self, address: u32) -> Result<u32, u16> {
        let (status, payload) = self.command(0x80, &address.to_be_bytes());
        if status == 0 { Ok(be32(&payload)) } else { Err(status) }
    }

    pub fn write_register(&mut self, address: u32, value: u32) -> Result<(), u16> {
        let (status, _) = self.command(0x82, &[address.to_be_bytes(), value.to_be_bytes()].concat());
        if status == 0 { Ok(()) } else { Err(status) }
    }

    pub fn read_memory(&mut self, address: u32, length: u32) -> Result<Vec<u8>, u16> {
        let (status, payload) = self.command(0x84, &[address.to_be_bytes(), length.to_be_bytes()].concat());
        if status == 0 { Ok(payload[4..].to_vec()) } else { Err(status) }
    }

    pub fn write_memory(&mut self, address: u32, data: &[u8]) -> Result<(), u16> {
        let (status, _) = self.command(0x86, &[&address.to_be_bytes()[..], data].concat());
        if status == 0 { Ok(()) } else { Err(status) }
    }

    /// 1 exclusive, 2 control, 0 gives it up.
    pub fn take_control(&mut self, privilege: u32) -> Result<(), u16> {
        self.write_register(0x0a00, privilege)
    }

    /// The camera's XML, from where its first URL states.
    pub fn xml(&mut self) -> String {
        if self.xml.is_empty() {
            let url = self.read_memory(0x0200, 512).unwrap();
            let url = String::from_utf8(url.into_iter().take_while(|b| *b != 0).collect()).unwrap();
            let parts: Vec<&str> = url.split(';').collect();
            assert!(url.starts_with("Local:") && parts.len() == 3, "{url}");
            let hex = |text: &str| u32::from_str_radix(text, 16).unwrap();
            let (from, bytes) = (hex(parts[1]), hex(parts[2]));
            let pieces = (0..bytes.div_ceil(512)).map(|k| (from + 512 * k, (bytes - 512 * k).min(512)));
            let read: Vec<u8> =
                pieces.flat_map(|(at, length)| self.read_memory(at, length).unwrap()).collect();
            self.xml = String::from_utf8(read).unwrap();
        }
        self.xml.clone()
    }

    /// Address of a feature's register, by the XML.
    pub fn address(&mut self, feature: &str) -> u32 {
        let xml = self.xml();
        let node = xml
            .split_once(&format!("Name=\"{feature}_Reg\""))
            .or_else(|| xml.split_once(&format!("<StringReg Name=\"{feature}\"")));
        let node = node.unwrap_or_else(|| panic!("the XML has no {feature}")).1;
        let text = node.split_once("<Address>0x").unwrap().1.split_once('<').unwrap().0;
        u32::from_str_radix(text, 16).unwrap()
    }

    pub fn set(&mut self, feature: &str, value: u32) {
        let address = self.address(feature);
        let written = self.write_register(address, value);
        assert_eq!(written, Ok(()), "{feature} = {value}");
    }

    pub fn get(&mut self, feature: &str) -> u32 {
        let address = self.address(feature);
        self.read_register(address).unwrap()
    }

    pub fn set_float(&mut self, feature: &str, value: f64) {
        let address = self.address(feature);
        assert_eq!(self.write_memory(address, &value.to_be_bytes()), Ok(()), "{feature} = {value}");
    }

    pub fn float(&mut self, feature: &str) -> f64 {
        let address = self.address(feature);
        f64::from_be_bytes(self.read_memory(address, 8).unwrap().try_into().unwrap())
    }

    pub fn text(&mut self, feature: &str, bytes: u32) -> String {
        let address = self.address(feature);
        let bytes = self.read_memory(address, bytes).unwrap();
        String::from_utf8(bytes.into_iter().take_while(|b| *b != 0).collect()).unwrap()
    }

    /// Opens the stream to this client, with packets of `bytes` bytes.
    pub fn open_stream(&mut self, bytes: u32) {
        self.frames.clear();
        self.delivered = 0;
        let SocketAddr::V4(here) = self.stream.local_addr().unwrap() else { panic!("IPv4") };
        self.write_register(0x0d18, (*here.ip()).into()).unwrap();
        self.write_register(0x0d04, bytes).unwrap();
        self.write_register(0x0d00, here.port().into()).unwrap();
    }

    /// The next packet of the stream; `None` where none comes within `wait`.
    pub fn packet(&mut self, wait: Duration) -> Option<Packet> {
        self.stream.set_read_timeout(Some(wait)).unwrap();
        let mut buffer = vec![0; 65_536];
        match self.stream.recv_from(&mut buffer) {
            Ok((length, _)) => Some(Packet::parse(&buffer[..length])),
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => None,
            Err(e) => panic!("{e}"),
        }
    }

    /// The next frame, in order. Lost packets are asked for again where `resends` is set; without
    /// it a frame ends with its trailer, or with a packet of a later one.
    pub fn frame(&mut self, wait: Duration) -> Option<Received> {
        let until = Instant::now() + wait;
        let mut asked: Option<(u64, Instant)> = None;
        while Instant::now() < until {
            let packet = self.packet(Duration::from_millis(20));
            let is_idle = packet.is_none();
            if let Some(packet) = packet.filter(|p| p.status == 0 && p.block > self.delivered) {
                self.frames.entry(packet.block).or_default().insert(packet.number, packet);
            }
            let Some((block, packets)) = self.frames.first_key_value() else { continue };
            let (block, frame) = (*block, joined(packets));
            let has_ended = packets.values().any(|p| p.kind == 2) || self.frames.len() > 1;
            if frame.missing == 0 || !self.resends && has_ended {
                self.frames.remove(&block);
                self.delivered = block;
                return Some(frame);
            }
            let waits = asked.is_some_and(|(b, at)| b == block && at.elapsed() < Duration::from_millis(10));
            if self.resends && (has_ended || is_idle) && !waits {
                self.ask(block);
                asked = Some((block, Instant::now()));
            }
        }
        None
    }

    /// Asks for the packets of a frame that are missing, the one behind the last that came
    /// included.
    fn ask(&mut self, block: u64) {
        let Some(packets) = self.frames.get(&block) else { return };
        let extended = packets.values().any(|p| p.extended);
        let has_trailer = packets.values().any(|p| p.kind == 2);
        let end = packets.keys().last().copied().unwrap_or(0) + u32::from(!has_trailer);
        let missing: Vec<u32> = (0..=end).filter(|number| !packets.contains_key(number)).collect();
        for number in missing {
            self.asked_again += 1;
            let words = match extended {
                true => vec![0, number, number, (block >> 32) as u32, block as u32],
                false => vec![block as u32, number, number],
            };
            let payload: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
            self.id = self.id % 0xffff + 1;
            let mut datagram = vec![0x42, if extended { 0x10 } else { 0 }];
            for word in [0x40, payload.len() as u16, self.id] {
                datagram.extend(word.to_be_bytes());
            }
            datagram.extend(payload);
            self.stream.send_to(&datagram, self.camera).unwrap();
        }
    }
}

/// A frame of the packets that are there; without leader or trailer more are missing than counted.
fn joined(packets: &BTreeMap<u32, Packet>) -> Received {
    let trailer = packets.values().find(|p| p.kind == 2).map(|p| p.number);
    let end = trailer.unwrap_or_else(|| packets.keys().last().copied().unwrap_or(0) + 1);
    let missing = (0..=end).filter(|number| !packets.contains_key(number)).count();
    let Some(leader) = packets.get(&0) else { return Received { missing, ..Received::default() } };
    let body = &leader.body;
    assert_eq!((leader.kind, body.len()), (1, 36), "a leader of an image");
    Received {
        block: leader.block,
        payload_type: u16::from_be_bytes([body[2], body[3]]),
        timestamp_ns: u64::from(be32(&body[4..])) << 32 | u64::from(be32(&body[8..])),
        format: be32(&body[12..]),
        columns: be32(&body[16..]),
        rows: be32(&body[20..]),
        column: be32(&body[24..]),
        row: be32(&body[28..]),
        payload: packets.values().filter(|p| p.kind == 3).flat_map(|p| p.body.clone()).collect(),
        extended: leader.extended,
        missing,
    }
}

/// The chunks of a payload by their ids, read from its end.
pub fn chunks(payload: &[u8]) -> BTreeMap<u32, Vec<u8>> {
    let (mut end, mut all) = (payload.len(), BTreeMap::new());
    while end > 0 {
        let (id, length) = (be32(&payload[end - 8..]), be32(&payload[end - 4..]) as usize);
        all.insert(id, payload[end - 8 - length..end - 8].to_vec());
        end -= 8 + length;
    }
    all
}
