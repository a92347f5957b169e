//! A frame in packets, numbered from 0: the leader, the payload in pieces, the trailer.

use super::pixels::StreamFormat;
use crate::frame::Roi;

/// Bytes of the headers of IP and UDP, which the size of a packet includes.
pub(crate) const UDP_IP_HEADER_BYTES: usize = 28;
/// Smallest packet size that a device offers, bytes with all headers.
pub(crate) const MIN_PACKET_BYTES: u32 = 576;
/// Payload type of an image, and the bit that states chunks behind it.
const IMAGE: u16 = 0x0001;
const WITH_CHUNKS: u16 = 0x4000;

/// Width of the ids in a stream: GigE Vision 1 has 16 bits for frames and 24 for packets, its
/// version 2 also 64 and 32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ids {
    /// 16 and 24 bits: after frame 65535 comes 1.
    Short,
    /// 64 and 32 bits.
    Extended,
}

impl Ids {
    /// Bytes of a packet's header.
    pub(crate) const fn header_bytes(self) -> usize {
        match self {
            Self::Short => 8,
            Self::Extended => 20,
        }
    }

    /// The id of a frame as it travels; never 0.
    pub(crate) const fn on_the_wire(self, block: u64) -> u64 {
        match self {
            Self::Short => (block.wrapping_sub(1) % 0xffff) + 1,
            Self::Extended => block,
        }
    }
}

/// What a packet is, by its code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Leader = 1,
    Trailer = 2,
    Payload = 3,
}

/// What the leader states of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leader {
    /// Number of the frame in its stream, from 1.
    pub block: u64,
    /// Start of exposure on the head's clock, ns.
    pub timestamp_ns: u64,
    /// Format of the pixels.
    pub format: StreamFormat,
    /// The window of the sensor.
    pub window: Roi,
    /// Whether chunks follow the pixels.
    pub chunks: bool,
    /// Width of the ids.
    pub ids: Ids,
    /// Size of a packet with all its headers, bytes.
    pub packet_bytes: u32,
}

/// A frame as it is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// What the leader states.
    pub leader: Leader,
    /// Pixels, and chunks where they are on.
    pub payload: Vec<u8>,
}

impl Block {
    /// Bytes of payload in a packet.
    fn piece(&self) -> usize {
        let headers = UDP_IP_HEADER_BYTES + self.leader.ids.header_bytes();
        (self.leader.packet_bytes.max(MIN_PACKET_BYTES) as usize).saturating_sub(headers)
    }

    /// Number of its packets, leader and trailer included.
    pub(crate) fn packets(&self) -> u32 {
        let pieces = self.payload.len().div_ceil(self.piece());
        u32::try_from(pieces).unwrap_or(u32::MAX - 2).saturating_add(2)
    }

    /// Writes packet `number` into `out`; `false` where the frame has no such packet.
    pub(crate) fn packet(&self, number: u32, out: &mut Vec<u8>) -> bool {
        let last = self.packets() - 1;
        out.clear();
        match number {
            0 => {
                self.header(Kind::Leader, number, out);
                self.leader_body(out);
            }
            number if number < last => {
                self.header(Kind::Payload, number, out);
                let from = (number as usize - 1) * self.piece();
                let to = (from + self.piece()).min(self.payload.len());
                out.extend_from_slice(&self.payload[from..to]);
            }
            number if number == last => {
                self.header(Kind::Trailer, number, out);
                self.trailer_body(out);
            }
            _ => return false,
        }
        true
    }

    fn header(&self, kind: Kind, number: u32, out: &mut Vec<u8>) {
        header(self.leader.ids, self.leader.block, (0, kind as u8, number), out);
    }

    fn payload_type(&self) -> u16 {
        if self.leader.chunks { IMAGE | WITH_CHUNKS } else { IMAGE }
    }

    fn leader_body(&self, out: &mut Vec<u8>) {
        let Leader { timestamp_ns, format, window, .. } = self.leader;
        out.extend([0, 0]);
        out.extend(self.payload_type().to_be_bytes());
        out.extend(timestamp_ns.to_be_bytes());
        for word in [format.code(), window.columns, window.rows, window.column, window.row, 0] {
            out.extend(word.to_be_bytes());
        }
    }

    fn trailer_body(&self, out: &mut Vec<u8>) {
        out.extend([0, 0]);
        out.extend(self.payload_type().to_be_bytes());
        out.extend(self.leader.window.rows.to_be_bytes());
        if self.leader.chunks {
            let length = u32::try_from(self.payload.len()).unwrap_or(u32::MAX);
            // length of all chunks, and the number of their layout
            out.extend(length.to_be_bytes());
            out.extend(0_u32.to_be_bytes());
        }
    }
}

fn header(ids: Ids, block: u64, (status, kind, number): (u16, u8, u32), out: &mut Vec<u8>) {
    out.extend(status.to_be_bytes());
    let block = ids.on_the_wire(block);
    match ids {
        Ids::Short => {
            out.extend((block as u16).to_be_bytes());
            out.extend((u32::from(kind) << 24 | number & 0x00ff_ffff).to_be_bytes());
        }
        Ids::Extended => {
            out.extend([0, 0]);
            out.extend(((0x80 | u32::from(kind)) << 24).to_be_bytes());
            out.extend(block.to_be_bytes());
            out.extend(number.to_be_bytes());
        }
    }
}

/// A packet of nothing but a status: the answer to a resend request that cannot be met.
pub(crate) fn lone_packet(ids: Ids, block: u64, number: u32, status: u16) -> Vec<u8> {
    let mut out = Vec::with_capacity(ids.header_bytes());
    header(ids, block, (status, Kind::Payload as u8, number), &mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(ids: Ids, chunks: bool, payload: usize) -> Block {
        let leader = Leader {
            block: 0x0001_0203,
            timestamp_ns: 0x0102_0304_0506_0708,
            format: StreamFormat::Mono12,
            window: Roi { row: 0x20, column: 0x10, rows: 0x40, columns: 0x30 },
            chunks,
            ids,
            packet_bytes: 576,
        };
        Block { leader, payload: (0..payload).map(|k| (k % 251) as u8).collect() }
    }

    fn packets(block: &Block) -> Vec<Vec<u8>> {
        let packet = |number| {
            let mut out = Vec::new();
            assert!(block.packet(number, &mut out));
            out
        };
        (0..block.packets()).map(packet).collect()
    }

    #[test]
    fn leader_and_trailer_are_laid_out_as_published() {
        let all = packets(&block(Ids::Short, false, 10));
        // 0x10203 in 16 bits with 65535 followed by 1: 0x0204
        let leader = [
            0, 0, 2, 4, 1, 0, 0, 0, // status, block, leader, packet 0
            0, 0, 0, 1, 1, 2, 3, 4, 5, 6, 7, 8, // image, time
            1, 0x10, 0, 5, 0, 0, 0, 0x30, 0, 0, 0, 0x40, // format, size x, size y
            0, 0, 0, 0x10, 0, 0, 0, 0x20, 0, 0, 0, 0, // offset x, offset y, padding
        ];
        assert_eq!(all[0], leader);
        assert_eq!(all[2], [0, 0, 2, 4, 2, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0x40]);
        let all = packets(&block(Ids::Extended, true, 10));
        let head = [0, 0, 0, 0, 0x81, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0x40, 1];
        assert_eq!(all[0][..24], head);
        assert_eq!(all[2][4], 0x82);
        assert_eq!(all[2][16..], [0, 0, 0, 2, 0, 0, 0x40, 1, 0, 0, 0, 0x40, 0, 0, 0, 10, 0, 0, 0, 0]);
    }

    #[test]
    fn packets_in_any_size_put_together_are_the_payload_and_none_is_too_long() {
        for ids in [Ids::Short, Ids::Extended] {
            for payload in [0, 1, 527, 528, 529, 539, 540, 541, 5000] {
                let block = block(ids, false, payload);
                let all = packets(&block);
                let middle = &all[1..all.len() - 1];
                let joined: Vec<u8> = middle.iter().flat_map(|p| p[ids.header_bytes()..].to_vec()).collect();
                assert_eq!(joined, block.payload, "{ids:?} {payload}");
                assert!(all.iter().all(|p| p.len() + UDP_IP_HEADER_BYTES <= 576));
                assert!(middle.iter().rev().skip(1).all(|p| p.len() + UDP_IP_HEADER_BYTES == 576));
                assert!(!block.packet(block.packets(), &mut Vec::new()));
            }
        }
    }

    #[test]
    fn frame_65535_is_followed_by_1() {
        let ids: Vec<u64> = (65534..65538).map(|block| Ids::Short.on_the_wire(block)).collect();
        assert_eq!(ids, [65534, 65535, 1, 2]);
        assert_eq!(Ids::Extended.on_the_wire(65536), 65536);
        let lone = lone_packet(Ids::Short, 7, 3, 0x800c);
        assert_eq!(lone, [0x80, 0x0c, 0, 7, 3, 0, 0, 3]);
    }
}
