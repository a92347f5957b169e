//! A session of clients with the published camera: any datagrams in any order. The body of the fuzz target `gvcp`, which a plain
//! test runs over its seeds and damaged copies of them (tests/inside/publish/hostile.rs). A panic is a finding.

use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::LazyLock;

use crate::publish::camera::{Action, Task};
use crate::publish::genicam::DataSheet;
use crate::publish::{Camera, head::FrameOrder};

/// Most bytes of an answer: those of a datagram of the control protocol.
const ANSWER: usize = 548;
/// Most that the state of the camera grows by in a session, bytes: the last command of sixteen clients with its answer, and one pass.
#[allow(dead_code, reason = "the fuzz target alone measures the heap")]
pub(crate) const STATE: usize = 16 * 2 * 1024 + (64 << 10);

/// What a frame that is ordered must be, whatever was written.
fn check_frame(order: &FrameOrder) {
    let (w, s) = (order.window, &order.scene);
    assert!(w.rows > 0 && w.columns > 0 && w.row + w.rows <= 48 && w.column + w.columns <= 64, "{w:?}");
    let all = [
        order.angle_deg,
        order.z_mm,
        s.diameter_mm,
        s.spindle_rpm,
        s.exposure_us,
        s.gain_db,
        s.contamination,
    ];
    assert!(all.iter().all(|value| value.is_finite()), "{order:?}");
    assert!(
        s.diameter_mm > 0.0 && s.diameter_mm <= 16.0 && s.exposure_us > 0.0 && s.exposure_us <= 1e6,
        "{s:?}"
    );
    assert!(s.contamination >= 0.0, "{s:?}");
}

fn check_task(task: &Task) {
    match task {
        Task::Frame(task) => {
            check_frame(&task.order);
            assert!((576..=65_535).contains(&task.stream.packet_bytes) && task.stream.bytes_per_s > 0);
            assert!(task.stream.to.port() != 0 && !task.stream.to.ip().is_unspecified());
        }
        Task::Cut(order) => {
            assert!(order.pass <= 2 && order.offset_mm.len() == 3, "{order:?}");
            assert!(order.offset_mm.iter().all(|offset| offset.abs() <= 10.0), "{order:?}");
        }
    }
}

/// Datagrams one after another: two bytes of length (ten bits), one of the client (two bits) and the time since the last one (six
/// bits, 100 ms each), and so many bytes. Whether one of them was answered by success.
pub(crate) fn session(bytes: &[u8]) -> bool {
    static CAMERA: LazyLock<Camera> = LazyLock::new(|| Camera::new(DataSheet::of_tests()));
    let (mut camera, mut now_ns, mut succeeded) = (CAMERA.clone(), 1_000_000_000_u64, false);
    let mut rest = bytes;
    while let Some((&[high, low, who], tail)) = rest.split_first_chunk::<3>() {
        let length = usize::from(u16::from_be_bytes([high & 3, low])).min(tail.len());
        let (datagram, left) = tail.split_at(length);
        rest = left;
        now_ns += 1_000_000 + u64::from(who >> 2) * 100_000_000;
        let client = SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 1 + (who & 1)), 5000 + u16::from(who & 2));
        let reply = camera.answer(datagram, client, now_ns);
        if let Some(answer) = &reply.datagram {
            assert!(answer.len() >= 8 && answer.len() <= ANSWER, "{} bytes", answer.len());
            let stated = u16::from_be_bytes([answer[4], answer[5]]);
            assert_eq!(usize::from(stated), answer.len() - 8, "an answer states another length than it has");
            succeeded |= answer[..2] == [0, 0];
        }
        if let Some(Action::TestPacket(to, size)) = reply.action {
            assert!(to.port() != 0 && size <= 65_507, "{size} bytes to {to}");
        }
        camera.tick(now_ns);
        for _ in 0..3 {
            let Some(task) = camera.next_task(now_ns) else { break };
            check_task(&task);
            if matches!(task, Task::Cut(_)) {
                camera.pass_ended(&Ok(()));
            }
        }
    }
    succeeded
}
