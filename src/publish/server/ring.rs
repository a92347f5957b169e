//! The last frames, kept for resend requests.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::publish::camera::StreamSettings;
use crate::publish::gvcp::Resend;
use crate::publish::gvsp::{Block, Ids};

/// Frames that are kept: at 100 frames a second those of 0.12 s, several times the time after which
/// clients ask again.
const MOST_FRAMES: usize = 12;
/// Bytes that are kept, of large frames fewer than twelve.
const MOST_BYTES: usize = 256 << 20;

/// A frame that was sent.
#[derive(Clone, Debug)]
pub(crate) struct Sent {
    /// Its packets.
    pub block: Arc<Block>,
    /// How it was sent.
    pub stream: StreamSettings,
}

/// The ring.
#[derive(Debug, Default)]
pub(crate) struct Ring {
    frames: VecDeque<Sent>,
    bytes: usize,
}

impl Ring {
    /// Keeps a frame; returns memory of one that made room, where none still sends it.
    pub(super) fn push(&mut self, sent: Sent) -> Option<Vec<u8>> {
        self.bytes += sent.block.payload.len();
        self.frames.push_back(sent);
        let mut free = None;
        while self.frames.len() > MOST_FRAMES || self.bytes > MOST_BYTES && self.frames.len() > 1 {
            let Some(oldest) = self.frames.pop_front() else { break };
            self.bytes -= oldest.block.payload.len();
            free = Arc::try_unwrap(oldest.block).ok().map(|block| block.payload).or(free);
        }
        free
    }

    /// The frame of a request, the newest where an id of 16 bits came round again.
    pub(super) fn find(&self, resend: &Resend) -> Option<Sent> {
        let is_it = |sent: &&Sent| {
            let leader = &sent.block.leader;
            leader.ids.on_the_wire(leader.block) == resend.block
                && (leader.ids == Ids::Extended) == resend.extended
        };
        self.frames.iter().rev().find(is_it).cloned()
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, SocketAddrV4};

    use super::*;
    use crate::frame::Roi;
    use crate::publish::camera::Faults;
    use crate::publish::gvsp::{Leader, StreamFormat};

    fn sent(block: u64, ids: Ids, bytes: usize) -> Sent {
        let window = Roi { row: 0, column: 0, rows: 1, columns: 1 };
        let (format, packet_bytes) = (StreamFormat::Mono8, 1500);
        let leader = Leader { block, timestamp_ns: 0, format, window, chunks: false, ids, packet_bytes };
        let stream = StreamSettings {
            to: SocketAddrV4::new(Ipv4Addr::LOCALHOST, 1),
            packet_bytes,
            packet_delay_ns: 0,
            bytes_per_s: 1,
            ids,
            format,
            window,
            chunks: None,
            faults: Faults::default(),
        };
        Sent { block: Arc::new(Block { leader, payload: vec![0; bytes] }), stream }
    }

    #[test]
    fn twelve_frames_are_kept_and_no_more_bytes_than_allowed() {
        let mut ring = Ring::default();
        for block in 65_530..65_550 {
            ring.push(sent(block, Ids::Short, 100));
        }
        let ask = |block| Resend { channel: 0, block, first: 0, last: 1, extended: false };
        assert_eq!((ring.frames.len(), ring.bytes), (12, 1200));
        // 65549 travels as 14, 65538 as 3; 65537, as 2, is gone
        assert_eq!(ring.find(&ask(14)).unwrap().block.leader.block, 65_549);
        assert_eq!(ring.find(&ask(3)).unwrap().block.leader.block, 65_538);
        assert!(ring.find(&ask(2)).is_none());
        assert!(ring.find(&Resend { extended: true, ..ask(14) }).is_none());
        for block in 0..3 {
            ring.push(sent(block, Ids::Extended, MOST_BYTES / 2 + 1));
        }
        assert_eq!(ring.frames.len(), 1, "one frame is kept, however large");
    }
}
