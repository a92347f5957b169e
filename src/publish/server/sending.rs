//! Sends frames at their time, packet by packet at the pace of the link.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use super::making::Made;
use super::ring::Sent;
use super::shared::{LOOK, Shared};
use crate::frame::Frame;
use crate::publish::camera::{Camera, Faults, FrameTask, StreamSettings};
use crate::publish::gvcp::{Resend, Status};
use crate::publish::gvsp::{
    Block, ChunkValues, Leader, UDP_IP_HEADER_BYTES, append_chunks, lone_packet, pack, packed_bytes,
};

/// Packets may leave so much ahead of the pace, ns: a thread cannot sleep for less.
const AHEAD_NS: u64 = 200_000;

/// Packets that are late are sent at once for so long, ns.
const BEHIND_NS: u64 = 1_000_000;

/// Sends what was made until the end.
pub(super) fn send(shared: &Shared<'_>, made: &Receiver<Made>, spent: &SyncSender<Frame>) {
    let mut free = Vec::new();
    loop {
        let Made { task, frame } = match made.recv_timeout(LOOK) {
            Ok(made) => made,
            Err(RecvTimeoutError::Timeout) if !shared.ends() => continue,
            Err(_) => return,
        };
        if wait_until_due(shared, &task) {
            let block = Arc::new(lay_out(shared, &task, &frame, std::mem::take(&mut free)));
            let sent = Sent { block: Arc::clone(&block), stream: task.stream.clone() };
            let kept = shared.ring.lock().unwrap_or_else(PoisonError::into_inner).push(sent);
            free = kept.unwrap_or_default();
            send_block(shared, &task, &block);
        }
        // a full channel: the allocation is dropped
        let _ = spent.try_send(frame);
    }
}

/// Waits until a frame is due; `false` where its acquisition ended before.
fn wait_until_due(shared: &Shared<'_>, task: &FrameTask) -> bool {
    let mut due_ns = task.due_ns;
    let faults = &task.stream.faults;
    if Faults::meets(faults.late, task.order.number + 1) {
        due_ns += u64::from(faults.late_ms) * 1_000_000;
    }
    loop {
        if shared.ends() || !shared.with(|camera| camera.is_wanted(task)) {
            return false;
        }
        let left = due_ns.saturating_sub(shared.now_ns());
        if left == 0 {
            return true;
        }
        std::thread::sleep(Duration::from_nanos(left).min(LOOK));
    }
}

/// The frame in packets: pixels, chunks, leader.
fn lay_out(shared: &Shared<'_>, task: &FrameTask, frame: &Frame, mut payload: Vec<u8>) -> Block {
    let FrameTask { order, stream, .. } = task;
    let number = shared.with(Camera::next_block);
    let mut window = stream.window;
    payload.clear();
    if !pack(&frame.view(), stream.format, &mut payload) {
        tracing::warn!("a frame of {:?} does not fit {:?}", frame.view().format(), stream.format);
    }
    if Faults::meets(stream.faults.wrong_size, number) && window.rows > 1 {
        window.rows -= 1;
        payload.truncate(packed_bytes(stream.format, window.rows as usize * window.columns as usize));
    }
    if let Some(chunks) = &stream.chunks {
        let values = ChunkValues {
            timestamp_ns: order.t_ns,
            block: number,
            exposure_us: order.scene.exposure_us,
            gain_db: order.scene.gain_db,
            angle_deg: order.angle_deg,
            z_mm: order.z_mm,
        };
        append_chunks(&mut payload, chunks, &values);
    }
    let leader = Leader {
        block: number,
        timestamp_ns: order.t_ns,
        format: stream.format,
        window,
        chunks: stream.chunks.is_some(),
        ids: stream.ids,
        packet_bytes: stream.packet_bytes,
    };
    Block { leader, payload }
}

fn send_block(shared: &Shared<'_>, task: &FrameTask, block: &Block) {
    let stream = &task.stream;
    if stream.faults.silent {
        return;
    }
    let number = block.leader.block;
    let times = 1 + u32::from(Faults::meets(stream.faults.duplicate, number));
    for _ in 0..times {
        let mut pace = Pace::new(shared, stream);
        let mut packet = Vec::new();
        for k in 0..block.packets() {
            if !shared.is_open(task.channel) {
                return;
            }
            block.packet(k, &mut packet);
            pace.wait(shared, packet.len());
            if !stream.faults.loses(number, k) && !shared.is_silent() {
                post(shared, &packet, stream);
            }
        }
    }
}

/// A stream is not confirmed: a packet that the system does not take is lost, as on a wire.
fn post(shared: &Shared<'_>, packet: &[u8], stream: &StreamSettings) {
    if let Err(error) = shared.stream.send_to(packet, stream.to) {
        tracing::debug!("a packet of {} bytes to {} was lost: {error}", packet.len(), stream.to);
    }
}

/// The pace of packets: the link's rate, or the delay that is asked for where it is longer.
struct Pace {
    next_ns: u64,
    delay_ns: u64,
    bytes_per_s: u64,
}

impl Pace {
    fn new(shared: &Shared<'_>, stream: &StreamSettings) -> Self {
        let (delay_ns, bytes_per_s) = (stream.packet_delay_ns, stream.bytes_per_s);
        Self { next_ns: shared.now_ns(), delay_ns, bytes_per_s }
    }

    /// Waits for the turn of a packet of `bytes` bytes; in steps, as the client may go meanwhile.
    fn wait(&mut self, shared: &Shared<'_>, bytes: usize) {
        loop {
            let left = self.next_ns.saturating_sub(shared.now_ns());
            if left <= AHEAD_NS || shared.ends() {
                break;
            }
            std::thread::sleep(Duration::from_nanos(left).min(LOOK));
        }
        // a thread that was held up does not catch up in one burst
        self.next_ns = self.next_ns.max(shared.now_ns().saturating_sub(BEHIND_NS));
        let on_wire = (bytes + UDP_IP_HEADER_BYTES) as u64;
        self.next_ns += self.delay_ns.max(on_wire.saturating_mul(1_000_000_000) / self.bytes_per_s);
    }
}

/// Packets that are sent again for one request at most: a frame of 16 MiB in packets of 1500 bytes;
/// what is still missing is asked for again.
const MOST_RESENT: u32 = 12_000;

/// Sends packets of a frame again, or states that they are gone.
pub(super) fn resend(shared: &Shared<'_>, resend: &Resend, to: &StreamSettings) {
    let found = shared.ring.lock().unwrap_or_else(PoisonError::into_inner).find(resend);
    let is_sent = |sent: &Sent| !sent.stream.faults.refuses_resend;
    let Some(Sent { block, stream }) = found.filter(is_sent) else {
        let gone = lone_packet(to.ids, resend.block, resend.first, Status::PacketUnavailable.code());
        return post(shared, &gone, to);
    };
    if stream.faults.silent {
        return;
    }
    let last = resend.last.min(block.packets() - 1).min(resend.first.saturating_add(MOST_RESENT));
    let (mut pace, mut packet) = (Pace::new(shared, &stream), Vec::new());
    for number in resend.first..=last {
        if block.packet(number, &mut packet) {
            pace.wait(shared, packet.len());
            post(shared, &packet, &stream);
        }
    }
    let packets = (last + 1).saturating_sub(resend.first);
    shared.with(|camera| camera.resent(packets));
}
