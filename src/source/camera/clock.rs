//! The camera's clock: ticks to nanoseconds, and its map to the host's.
//!
//! Registers of GigE Vision 1.2, 27: tick frequency, control (2 latches) and latched value; each
//! is a high word followed by a low one.
//!
//! Crystals differ by 100 parts per million at most, 1 ms in ten seconds: the clock is latched
//! again while frames come, and its rate is that since the first latch.

use std::time::{Duration, Instant};

use viva_genicam::genapi::RegisterIo;

use crate::source::host_clock::host_t_ns;
use crate::source::live::{ClockMap, ClockMapError, RoundTrip};

const TICK_FREQUENCY: u64 = 0x093C;
const CONTROL: u64 = 0x0944;
const LATCHED: u64 = 0x0948;
const LATCH: u32 = 2;

/// Longest time from latch to latch: by then the rate is that of 10 s or more, within 4 parts per
/// million at a bound of 20 µs.
const LONGEST: Duration = Duration::from_secs(10);
/// Time to the second latch: a loaded host's bound of 1 ms is a quarter of the rate that is
/// refused.
const SHORTEST: Duration = Duration::from_secs(4);

/// The clock of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DeviceClock {
    /// Ticks a second.
    frequency_hz: u64,
    first: Option<ClockMap>,
    map: Option<ClockMap>,
    opened: Instant,
    /// When it is latched again.
    due: Instant,
}

fn double_word(io: &impl RegisterIo, address: u64) -> Option<u64> {
    let bytes = io.read(address, 8).ok()?;
    Some(u64::from_be_bytes(bytes.try_into().ok()?))
}

impl DeviceClock {
    /// The clock of a device; `None` where it states no frequency, and has none.
    pub(super) fn read(io: &impl RegisterIo) -> Option<Self> {
        let frequency_hz = double_word(io, TICK_FREQUENCY).filter(|hz| *hz > 0)?;
        let now = Instant::now();
        let mut clock = Self { frequency_hz, first: None, map: None, opened: now, due: now + SHORTEST };
        match clock.latch(io) {
            Ok(map) => (clock.first, clock.map) = (Some(map), Some(map)),
            Err(why) => tracing::debug!("the camera's clock is not mapped to the host's: {why}"),
        }
        Some(clock)
    }

    /// Latches again where it is time to; a clock that was reset, or has other ticks than it
    /// states, is mapped no more.
    pub(super) fn keep(&mut self, io: &impl RegisterIo, now: Instant) {
        let Some(first) = self.first.filter(|_| now >= self.due) else { return };
        self.due = now + now.duration_since(self.opened).clamp(SHORTEST, LONGEST);
        match self.latch(io).and_then(|map| map.with_rate_since(&first)) {
            Ok(map) => self.map = Some(map),
            Err(why @ (ClockMapError::DeviceStands | ClockMapError::Rate(_))) => {
                tracing::warn!("times of exposure are left out: {why}");
                (self.first, self.map) = (None, None);
            }
            Err(why) => tracing::debug!("the camera's clock is not latched again: {why}"),
        }
    }

    /// Latches up to the first one that fails: one that is not answered takes seconds.
    fn latch(&self, io: &impl RegisterIo) -> Result<ClockMap, ClockMapError> {
        let mut has_failed = false;
        ClockMap::latched(|| {
            let trip = if has_failed { None } else { self.round_trip(io) };
            has_failed = trip.is_none();
            trip
        })
    }

    fn round_trip(&self, io: &impl RegisterIo) -> Option<RoundTrip> {
        let host_before_ns = host_t_ns();
        io.write(CONTROL, &LATCH.to_be_bytes()).ok()?;
        let host_after_ns = host_t_ns();
        let device_ns = self.ns(double_word(io, LATCHED)?);
        // A camera without the latch answers with zeros.
        (device_ns > 0).then_some(RoundTrip { host_before_ns, device_ns, host_after_ns })
    }

    /// The clock, latched now, ns; `None` where it has no latch.
    pub(super) fn now_ns(&self, io: &impl RegisterIo) -> Option<u64> {
        Some(self.round_trip(io)?.device_ns)
    }

    /// Ticks in nanoseconds.
    pub(super) fn ns(&self, ticks: u64) -> u64 {
        let ns = u128::from(ticks) * 1_000_000_000 / u128::from(self.frequency_hz);
        u64::try_from(ns).unwrap_or(u64::MAX)
    }

    /// A time of this clock on the host's, ns.
    pub(super) fn host_ns(&self, device_ns: u64) -> Option<u64> {
        Some(self.map?.host_ns(device_ns))
    }

    /// Most that the map is off at the latch, ns.
    pub(super) fn bound_ns(&self) -> Option<u64> {
        Some(self.map?.bound_ns())
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use viva_genicam::genapi::GenApiError;

    use super::*;

    /// A device whose clock ticks every 8 ns and runs 5 s behind the host's.
    struct Ticks {
        latched: Cell<u64>,
        has_latch: bool,
        /// Ticks gained since.
        gained: Cell<u64>,
    }

    fn ticks(has_latch: bool) -> Ticks {
        Ticks { latched: Cell::new(0), has_latch, gained: Cell::new(0) }
    }

    impl RegisterIo for Ticks {
        fn read(&self, address: u64, _: usize) -> Result<Vec<u8>, GenApiError> {
            let value = if address == TICK_FREQUENCY { 125_000_000 } else { self.latched.get() };
            Ok(value.to_be_bytes().to_vec())
        }

        fn write(&self, address: u64, data: &[u8]) -> Result<(), GenApiError> {
            assert_eq!((address, data), (CONTROL, &[0, 0, 0, 2][..]));
            if self.has_latch {
                self.latched.set((host_t_ns() - 5_000_000_000) / 8 + self.gained.get());
            }
            Ok(())
        }
    }

    #[test]
    fn ticks_are_nanoseconds_and_the_latch_maps_them() {
        let clock = DeviceClock::read(&ticks(true)).unwrap();
        assert_eq!(clock.ns(125_000_000), 1_000_000_000);
        let now_ns = clock.now_ns(&ticks(true)).unwrap() + 5_000_000_000;
        assert!(now_ns.abs_diff(host_t_ns()) < 1_000_000_000, "{now_ns}");
        assert_eq!(clock.now_ns(&ticks(false)), None);
        let bound = clock.bound_ns().unwrap();
        let mapped = clock.host_ns(7_000_000_000).unwrap();
        assert!(mapped.abs_diff(12_000_000_000) <= bound + 8, "{mapped} within {bound}");
        let without = DeviceClock::read(&ticks(false)).unwrap();
        assert_eq!((without.host_ns(5), without.bound_ns()), (None, None));
    }

    #[test]
    fn the_rate_is_followed_and_a_clock_that_jumps_is_mapped_no_more() {
        let device = ticks(true);
        let mut clock = DeviceClock::read(&device).unwrap();
        let (begun, map) = (clock.opened, clock.map);
        clock.keep(&device, begun + SHORTEST / 2);
        assert_eq!(clock.map, map, "not yet due");
        std::thread::sleep(Duration::from_millis(20));
        clock.keep(&device, begun + SHORTEST);
        assert_ne!(clock.map, map);
        let host_ns = host_t_ns();
        let mapped_ns = clock.host_ns(host_ns - 5_000_000_000).unwrap();
        assert!(mapped_ns.abs_diff(host_ns) < 1_000_000, "{mapped_ns} {host_ns}");
        assert_eq!(clock.due, begun + 2 * SHORTEST);
        // an hour in no time
        device.gained.set(3600 * 125_000_000);
        clock.keep(&device, begun + 2 * SHORTEST);
        assert_eq!((clock.map, clock.host_ns(1)), (None, None));
    }
}
