//! The receive buffer that a frame in one burst needs, and the one that the system grants.

/// Memory of a datagram besides its packet, bytes: the descriptor (`struct sk_buff`, a slab of
/// 256), and behind the packet 320 of `struct skb_shared_info` and 64 of headers (Linux 6.x).
const DESCRIPTOR: u64 = 256;
const BEHIND: u64 = 320 + 64;
/// Largest piece of memory that holds a packet whole; larger ones lie in pages.
const WHOLE: u64 = 16_384;
const PAGE: u64 = 4096;
/// Bytes of a packet that are not the image's: headers of IP, UDP and GVSP with ids of 64 bits.
const HEADERS: u64 = 48;

/// What the kernel charges a receive buffer for a packet, bytes.
fn charged(packet_bytes: u64) -> u64 {
    let held = packet_bytes + BEHIND;
    let memory = if held <= WHOLE { held.next_power_of_two() } else { held.next_multiple_of(PAGE) };
    memory + DESCRIPTOR
}

/// Size of a receive buffer, as `net.core.rmem_max` states it, that holds a frame of so many bytes
/// in packets of `packet_bytes`. The kernel doubles what was asked for (`socket(7)`) and charges
/// each packet with its memory: 16.6 kB for one of 8000 bytes.
pub(super) fn burst_bytes(frame_bytes: u64, packet_bytes: u32) -> u64 {
    let packet_bytes = u64::from(packet_bytes.clamp(576, 65_535));
    // a leader and a trailer beside the image
    let packets = frame_bytes.div_ceil(packet_bytes - HEADERS) + 2;
    (packets * charged(packet_bytes)).div_ceil(2)
}

/// `net.core.rmem_max`, bytes; `None` where the system has no such limit.
pub(super) fn receive_buffer_bytes() -> Option<u64> {
    std::fs::read_to_string("/proc/sys/net/core/rmem_max").ok()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With `rmem_max` of 4 MiB a frame of 2048 x 2048 x 8 bits in one burst was lost in packets of
    /// 8000 bytes a quarter of the time, and arrived in packets of 1500 and of 60000.
    #[test]
    fn the_charge_explains_which_bursts_were_lost() {
        let limit = 4 << 20;
        assert!(burst_bytes(4 << 20, 8000) > limit);
        assert!(burst_bytes(4 << 20, 1500) < limit && burst_bytes(4 << 20, 60_000) < limit);
        assert_eq!(burst_bytes(0, 1500), 2304);
    }
}
