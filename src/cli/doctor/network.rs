//! The receive buffer that a frame in one burst needs, and the one that the system grants.

/// Least memory that the kernel takes for a datagram besides its bytes: the descriptor of a packet
/// (`struct sk_buff`, 232 bytes in Linux 6.x, in a slab of 256).
const DESCRIPTOR: u64 = 256;
/// Bytes of a packet that are not the image's: headers of IP, UDP and GVSP with ids of 64 bits.
const HEADERS: u64 = 48;

/// Size of a receive buffer, as `net.core.rmem_max` states it, that holds a frame of so many bytes
/// in packets of `packet_bytes`. The kernel charges a packet with its memory, the next power of two,
/// and doubles what was asked for (`socket(7)`): a frame of 4 MiB in packets of 8000 bytes needs
/// 4.4 MB, in those of 1500 bytes 3.4 MB.
pub(super) fn burst_bytes(frame_bytes: u64, packet_bytes: u32) -> u64 {
    let packet_bytes = u64::from(packet_bytes.clamp(576, 65_535));
    // a leader and a trailer beside the image
    let packets = frame_bytes.div_ceil(packet_bytes - HEADERS) + 2;
    (packets * (packet_bytes.next_power_of_two() + DESCRIPTOR)).div_ceil(2)
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
