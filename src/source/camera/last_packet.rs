//! The last packet of a frame, requested again where the frame is overdue.
//!
//! The receiver of `viva-genicam` asks for packets that lie before the newest one of a block; the
//! trailer, which no packet follows, is not among them, and the block is closed after 100 ms
//! without a packet. Here the next block after the last one that came is overdue when its packets
//! came but for few, and its period and a margin are over or no more packets follow. Its trailer is
//! then asked for by a request of our own (PACKETRESEND, GigE Vision 2.2, 14.10) to the control
//! port, from the address that has control, as the receiver asks from its own socket. The camera
//! sends it to the stream. The receiver takes it, and asks for payload before it that is missing: a
//! trailer that came early would have it ask for all that is under way still, and spend the quarter
//! of the frame's packets that it may ask for. A request for a frame that has arrived meanwhile
//! costs a datagram each way.

use std::net::{SocketAddr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

use viva_genicam::gige::{GVSP_EXTENDED_HEADER_SIZE, GVSP_HEADER_SIZE, StreamParams, encode_packet_resend};

/// Time beyond a period after which a frame is overdue: most frames that the camera or the network
/// delays have arrived by then, and most of the 100 ms after which a block is closed is left.
const MARGIN: Duration = Duration::from_millis(20);
/// Time from check to check: what the receiver itself waits before it repeats a request.
const LOOK: Duration = Duration::from_millis(20);
/// Requests for a frame at most: they span 140 ms, and its block is closed before.
const MOST: u32 = 8;
/// Share of a block's packets that may be missing, one in so many, half of what the receiver
/// requests at most: a block that lacks more is still arriving, or cannot be completed.
const MISSING: u64 = 8;
/// Bytes of the IP and UDP headers, which the size of a packet counts.
const IP_UDP_BYTES: u32 = 28;

/// When the block that is awaited is overdue.
#[derive(Clone, Copy, Debug)]
struct Overdue {
    /// Time from frame to frame; `None` where frames come by triggers.
    period: Option<Duration>,
    /// When the last block came, and the packets of the stream until then.
    since: Instant,
    packets: u64,
    /// Packets at the last look.
    looked: u64,
    next_look: Instant,
    asked: u32,
}

impl Overdue {
    fn new(period: Option<Duration>, now: Instant) -> Self {
        Self { period, since: now, packets: 0, looked: 0, next_look: now + LOOK, asked: 0 }
    }

    /// A block came.
    fn came(&mut self, now: Instant, packets: u64) {
        (self.since, self.packets, self.looked) = (now, packets, packets);
        (self.next_look, self.asked) = (now + self.period.map_or(LOOK, |period| period + MARGIN), 0);
    }

    /// Whether its last packet, of this number, is to be asked for now.
    fn is_due(&mut self, now: Instant, packets: u64, trailer: u32) -> bool {
        if now < self.next_look {
            return false;
        }
        self.next_look = now + LOOK;
        let before_trailer = u64::from(trailer);
        let has_come = packets.saturating_sub(self.packets) >= before_trailer - before_trailer / MISSING;
        let stands = packets == std::mem::replace(&mut self.looked, packets);
        let is_late = self.period.is_some_and(|period| now - self.since >= period + MARGIN);
        let is_due = has_come && (stands || is_late) && self.asked < MOST;
        self.asked += u32::from(is_due);
        is_due
    }
}

/// Asks for last packets.
#[derive(Debug)]
pub(super) struct LastPacket {
    socket: UdpSocket,
    camera: SocketAddrV4,
    channel: u16,
    /// Number of the trailer with ids of 16 and of 64 bits: the packets of payload and 1.
    trailer: [u32; 2],
    /// Whether the camera counts with 64 bits.
    is_long: bool,
    /// The id of the last block; 0 before the first one.
    newest: u64,
    request: u16,
    overdue: Overdue,
}

/// What the camera states of its stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stated {
    /// Bytes of payload of every frame.
    pub payload_bytes: u32,
    /// Whether its ids have 64 bits.
    pub is_long: bool,
    /// Time from frame to frame; `None` where they come by triggers, or it is not stated.
    pub period: Option<Duration>,
}

impl LastPacket {
    /// For a stream; `None` without a socket or an address to ask at.
    pub(super) fn new(params: &StreamParams, stated: Stated, now: Instant) -> Option<Self> {
        let Some(SocketAddr::V4(camera)) = params.camera else { return None };
        let socket = UdpSocket::bind((params.host, 0)).and_then(|socket| {
            // a request that cannot be sent at once is not worth waiting for
            socket.set_nonblocking(true)?;
            Ok(socket)
        });
        let trailer = [GVSP_HEADER_SIZE, GVSP_EXTENDED_HEADER_SIZE]
            .map(|header| trailer_number(stated.payload_bytes, params.packet_size, header as u32));
        Some(Self {
            socket: socket.inspect_err(|why| tracing::debug!("no last packet is asked for: {why}")).ok()?,
            camera,
            channel: u16::try_from(params.channel).ok()?,
            trailer: [trailer[0]?, trailer[1]?],
            is_long: stated.is_long,
            newest: 0,
            request: 0,
            overdue: Overdue::new(stated.period, now),
        })
    }

    /// How long to wait for a block before [`Self::look`].
    pub(super) fn wait(&self, now: Instant) -> Duration {
        self.overdue.next_look.saturating_duration_since(now)
    }

    /// Acquisition begins: ids begin with 1.
    pub(super) fn begin(&mut self, now: Instant, packets: u64) {
        self.newest = 0;
        self.overdue.came(now, packets);
    }

    /// A block came, whole or not.
    pub(super) fn came(&mut self, id: u64, now: Instant, packets: u64) {
        self.newest = id;
        self.is_long |= id > u64::from(u16::MAX);
        self.overdue.came(now, packets);
    }

    /// Asks for the last packet of the next block where that is overdue, after so many packets of
    /// the stream.
    pub(super) fn look(&mut self, now: Instant, packets: u64) {
        let trailer = self.trailer[usize::from(self.is_long)];
        if !self.overdue.is_due(now, packets, trailer) {
            return;
        }
        let block = self.awaited();
        // 0 is no number of a request
        self.request = self.request.checked_add(1).unwrap_or(1);
        let request = encode_packet_resend(self.request, self.channel, block, trailer, trailer, self.is_long);
        tracing::debug!("block {block} is overdue: its last packet, {trailer}, is asked for");
        if let Err(why) = self.socket.send_to(&request, self.camera) {
            tracing::debug!("the last packet of block {block} is not asked for: {why}");
        }
    }

    /// The id after the last one: 0 is left out of those of 16 bits.
    fn awaited(&self) -> u64 {
        match (self.newest, self.is_long) {
            (65_535, false) => 1,
            (newest, _) => newest + 1,
        }
    }
}

/// Number of the trailer: the leader is 0, packets of payload follow; `None` where packets hold
/// nothing.
fn trailer_number(payload_bytes: u32, packet_size: u32, header: u32) -> Option<u32> {
    let each = packet_size.checked_sub(IP_UDP_BYTES + header).filter(|each| *each > 0)?;
    Some(payload_bytes.div_ceil(each) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_came_but_for_few_packets_is_overdue_after_its_period_or_where_packets_stand() {
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        // 50 frames a second of 80 packets and a trailer; packets go on coming
        let mut free = Overdue::new(Some(Duration::from_millis(20)), start);
        free.came(at(0), 100);
        assert_eq!([10, 39].map(|ms| free.is_due(at(ms), 180, 80)), [false; 2], "not yet");
        assert!(!free.is_due(at(40), 169, 80), "more than an eighth is under way");
        assert!(free.is_due(at(60), 170, 80));
        assert!(!free.is_due(at(70), 180, 80), "asked 10 ms ago");
        assert!(free.is_due(at(80), 190, 80));
        assert_eq!((100..400).step_by(20).filter(|ms| free.is_due(at(*ms), 1000 + ms, 80)).count(), 6);
        free.came(at(400), 2000);
        assert!(!free.is_due(at(1000), 2000, 80), "nothing of the next one came");
        // by triggers: leader and pixels that stand from one look to the next
        let mut triggered = Overdue::new(None, start);
        triggered.came(at(0), 10);
        assert_eq!([20, 40].map(|ms| triggered.is_due(at(ms), 11, 2)), [false; 2], "a leader alone");
        assert!(!triggered.is_due(at(60), 12, 2), "it came since the last look");
        assert!(triggered.is_due(at(80), 12, 2));
    }

    #[test]
    fn the_trailer_stands_after_the_packets_of_payload() {
        // packets of 1500 bytes hold 1464 of payload with ids of 16 bits, 1452 with those of 64
        assert_eq!(trailer_number(1464 * 3, 1500, 8), Some(4));
        assert_eq!(trailer_number(1464 * 3 + 1, 1500, 8), Some(5));
        assert_eq!(trailer_number(1452, 1500, 20), Some(2));
        assert_eq!(trailer_number(1, 36, 8), None);
    }

    #[test]
    fn the_request_is_that_of_the_standard_for_the_block_after_the_last() {
        let camera = UdpSocket::bind("127.0.0.1:0").unwrap();
        camera.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let SocketAddr::V4(address) = camera.local_addr().unwrap() else { panic!("IPv6") };
        let params = StreamParams {
            packet_size: 1500,
            packet_delay: None,
            mtu: 1500,
            host: std::net::Ipv4Addr::LOCALHOST,
            port: 1,
            channel: 0,
            camera: Some(SocketAddr::V4(address)),
        };
        let start = Instant::now();
        let stated = Stated { payload_bytes: 4000, is_long: false, period: None };
        let mut last = LastPacket::new(&params, stated, start).unwrap();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let asked = |last: &mut LastPacket, from: u64| {
            last.look(at(from + 20), 7);
            last.look(at(from + 40), 7);
            let mut bytes = [0; 64];
            let length = camera.recv(&mut bytes).unwrap();
            bytes[..length].to_vec()
        };
        // key, no flags, command 0x40, 12 bytes, request 1; channel 0, block 1, packets 4 to 4
        let right = [0x42, 0, 0, 0x40, 0, 12, 0, 1, 0, 0, 0, 1, 0, 0, 0, 4, 0, 0, 0, 4];
        assert_eq!(asked(&mut last, 0), right);
        last.came(65_535, at(100), 0);
        assert_eq!(asked(&mut last, 100)[10..12], [0, 1], "ids of 16 bits leave 0 out");
        last.came(65_536, at(200), 0);
        let long = asked(&mut last, 200);
        assert_eq!((long[1], &long[20..]), (0x10, &65_537_u64.to_be_bytes()[..]));
    }
}
