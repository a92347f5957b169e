//! What the registers state of a stream: format, window, chunks, packets, faults.

use std::net::{Ipv4Addr, SocketAddrV4};

use super::memory::Memory;
use crate::frame::Roi;
use crate::publish::genicam::address as at;
use crate::publish::gvsp::{Chunk, Ids, StreamFormat, chunk_bytes, packed_bytes};

/// Bit of the configuration of streams: ids of 64 bits.
const EXTENDED_IDS: u32 = 0x4000_0000;

/// Faults that a client has asked for; 0 is none everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Faults {
    /// Packets lost of a thousand.
    pub lost_per_thousand: u32,
    /// Which.
    pub seed: u32,
    /// Packets that are asked for again are stated as gone.
    pub refuses_resend: bool,
    /// No packet at all.
    pub silent: bool,
    /// Every which frame has a row less.
    pub wrong_size: u32,
    /// Every which frame is late.
    pub late: u32,
    /// By so many ms.
    pub late_ms: u32,
    /// Every which frame is sent twice.
    pub duplicate: u32,
}

impl Faults {
    /// Whether a fault of every `nth` frame meets this one.
    pub(crate) fn meets(nth: u32, block: u64) -> bool {
        nth > 0 && block.is_multiple_of(u64::from(nth))
    }

    /// Whether a packet is lost: a hash of seed, frame and packet (SplitMix64, Steele et al. 2014).
    pub(crate) fn loses(&self, block: u64, packet: u32) -> bool {
        if self.lost_per_thousand == 0 {
            return false;
        }
        let key = u64::from(self.seed) << 32 ^ block.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(packet);
        let mut z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ z >> 31) % 1000 < u64::from(self.lost_per_thousand)
    }
}

/// How a frame is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct StreamSettings {
    /// Where to.
    pub to: SocketAddrV4,
    /// Bytes of a packet with all headers.
    pub packet_bytes: u32,
    /// Time between packets, ns.
    pub packet_delay_ns: u64,
    /// Bytes a second.
    pub bytes_per_s: u64,
    /// Width of ids.
    pub ids: Ids,
    /// Format of the pixels.
    pub format: StreamFormat,
    /// Window of the sensor.
    pub window: Roi,
    /// Chunks behind the pixels; `None` where chunks are off.
    pub chunks: Option<Vec<Chunk>>,
    /// Faults.
    pub faults: Faults,
}

/// The window that the registers state.
pub(crate) fn window(memory: &Memory) -> Roi {
    Roi {
        row: memory.get(at::OFFSET_Y),
        column: memory.get(at::OFFSET_X),
        rows: memory.get(at::HEIGHT),
        columns: memory.get(at::WIDTH),
    }
}

/// The format that the registers state.
pub(crate) fn format(memory: &Memory) -> StreamFormat {
    StreamFormat::from_code(memory.get(at::PIXEL_FORMAT)).unwrap_or(StreamFormat::Mono8)
}

fn chunks(memory: &Memory) -> Option<Vec<Chunk>> {
    let is_on = |k: u32| memory.get(at::CHUNK_ENABLE_1 + 8 * k) != 0;
    let on = || Chunk::ALL.iter().zip(0..).filter(|(_, k)| is_on(*k)).map(|((chunk, _), _)| *chunk).collect();
    (memory.get(at::CHUNK_MODE) != 0).then(on)
}

/// Bytes of a frame.
pub(crate) fn payload_bytes(memory: &Memory) -> usize {
    let window = window(memory);
    let image = packed_bytes(format(memory), window.rows as usize * window.columns as usize);
    chunks(memory).map_or(image, |chunks| chunk_bytes(image, &chunks))
}

/// How frames are sent now; `None` where no stream is open.
pub(crate) fn stream(memory: &Memory) -> Option<StreamSettings> {
    let port = (memory.get(at::STREAM_PORT) & 0xffff) as u16;
    let address = Ipv4Addr::from(memory.get(at::STREAM_ADDRESS));
    if port == 0 || address.is_unspecified() {
        return None;
    }
    let extended = memory.get(at::GVSP_CONFIGURATION) & EXTENDED_IDS != 0;
    Some(StreamSettings {
        to: SocketAddrV4::new(address, port),
        packet_bytes: memory.get(at::PACKET_SIZE) & 0xffff,
        packet_delay_ns: memory.get(at::PACKET_DELAY).into(),
        bytes_per_s: u64::from(memory.get(at::THROUGHPUT_LIMIT)).max(1),
        ids: if extended { Ids::Extended } else { Ids::Short },
        format: format(memory),
        window: window(memory),
        chunks: chunks(memory),
        faults: Faults {
            lost_per_thousand: memory.get(at::FAULT_PACKET_LOSS),
            seed: memory.get(at::FAULT_SEED),
            refuses_resend: memory.get(at::FAULT_RESEND_REFUSED) != 0,
            silent: memory.get(at::FAULT_STREAM_SILENCE) != 0,
            wrong_size: memory.get(at::FAULT_WRONG_SIZE),
            late: memory.get(at::FAULT_LATE),
            late_ms: memory.get(at::FAULT_LATE_MS),
            duplicate: memory.get(at::FAULT_DUPLICATE),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_lost_packets_is_the_one_asked_for_and_the_seed_chooses_them() {
        let faults = Faults { lost_per_thousand: 5, seed: 3, ..Faults::default() };
        let lost = |faults: Faults| {
            let all = (1..=400_u64).flat_map(|block| (0..500_u32).map(move |packet| (block, packet)));
            all.filter(|(block, packet)| faults.loses(*block, *packet)).collect::<Vec<_>>()
        };
        let first = lost(faults);
        // 200 000 draws of .005: 1000 ± 32, five standard deviations
        assert!((840..1160).contains(&first.len()), "{}", first.len());
        assert_eq!(first, lost(faults));
        assert_ne!(first, lost(Faults { seed: 4, ..faults }));
        assert!(lost(Faults::default()).is_empty());
        assert!((0..9).all(|packet| Faults { lost_per_thousand: 1000, ..faults }.loses(1, packet)));
    }
}
