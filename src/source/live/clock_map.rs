//! The device's clock on the host's: from latch round trips.
//!
//! The host reads its clock, latches the device's, and reads its own again. The latch lies between
//! both readings: their middle is its time on the host's clock within half the round trip (Cristian
//! 1989). Several round trips give several such intervals of the offset of one clock against the
//! other; it lies in all of them, so in their intersection (Marzullo & Owicki 1983), whose ends are
//! the request that was fastest there and the answer that was fastest back. No distribution of
//! delays is assumed: half the intersection bounds the error of its middle.

use thiserror::Error;

/// Round trips of a latch: the shortest of twenty on a loaded host was 2 to 4 µs off, and a camera
/// on a wire answers twenty in some milliseconds.
const ROUND_TRIPS: usize = 20;

/// Rate of two crystals against each other within a series of latches, relative: 100 parts per
/// million at most. A series takes milliseconds: its intervals are widened by tenths of a
/// microsecond.
const CRYSTALS: f64 = 1e-4;

/// Largest rate of one clock against the other, relative: crystals of cameras and hosts are
/// specified to 100 parts per million at most; ten times that is another unit of ticks.
const MOST_DRIFT: f64 = 1e-3;

/// A latch of the device's clock between two readings of the host's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RoundTrip {
    /// Host's clock before the request, ns.
    pub host_before_ns: u64,
    /// Device's clock, latched, ns.
    pub device_ns: u64,
    /// Host's clock after the answer, ns.
    pub host_after_ns: u64,
}

/// Why there is no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(crate) enum ClockMapError {
    /// No round trip at all.
    #[error("no latch of the device's clock was answered")]
    NoLatch,
    /// A host's clock that went back.
    #[error("the host's clock went back by {0} ns during a latch; it was set meanwhile")]
    HostWentBack(u64),
    /// Two maps whose device times do not increase.
    #[error("the device's clock did not advance between two latches; it was reset, or it stands")]
    DeviceStands,
    /// Rates that no two crystals have.
    #[error(
        "the device's clock runs {0} parts per million faster than the host's; its ticks are not nanoseconds"
    )]
    Rate(i64),
}

/// Times of the device's clock on the host's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockMap {
    device_ns: u64,
    host_ns: u64,
    /// Host's nanoseconds a device's nanosecond, less 1.
    drift: f64,
    bound_ns: u64,
}

impl ClockMap {
    /// The map of several round trips: the middle of what all of them allow. Where they contradict
    /// each other (clocks whose rates are no crystals'), the shortest one alone.
    ///
    /// # Errors
    /// No round trip; a host's clock that went back.
    pub(crate) fn of(round_trips: &[RoundTrip]) -> Result<Self, ClockMapError> {
        if let Some(back) = round_trips.iter().find(|r| r.host_after_ns < r.host_before_ns) {
            return Err(ClockMapError::HostWentBack(back.host_before_ns - back.host_after_ns));
        }
        let length = |r: &RoundTrip| r.host_after_ns - r.host_before_ns;
        let shortest = round_trips.iter().min_by_key(|r| length(r)).ok_or(ClockMapError::NoLatch)?;
        let own = [shortest.host_before_ns, shortest.host_after_ns];
        let [from, to] = latch_interval(shortest, round_trips).unwrap_or(own);
        Ok(Self {
            device_ns: shortest.device_ns,
            host_ns: from + (to - from) / 2,
            drift: 0.0,
            // Of an odd length the middle is half a nanosecond off.
            bound_ns: (to - from).div_ceil(2),
        })
    }

    /// Latches twenty times; latches that fail are left out.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub(crate) fn latched(mut latch: impl FnMut() -> Option<RoundTrip>) -> Result<Self, ClockMapError> {
        let round_trips: Vec<RoundTrip> = (0..ROUND_TRIPS).filter_map(|_| latch()).collect();
        Self::of(&round_trips)
    }

    /// This map with the rate between an earlier one and it.
    ///
    /// # Errors
    /// A device's clock that did not advance, or that runs at another rate than a crystal.
    pub(crate) fn with_rate_since(self, earlier: &Self) -> Result<Self, ClockMapError> {
        if self.device_ns <= earlier.device_ns {
            return Err(ClockMapError::DeviceStands);
        }
        let device = (self.device_ns - earlier.device_ns) as f64;
        let host = (i128::from(self.host_ns) - i128::from(earlier.host_ns)) as f64;
        let drift = host / device - 1.0;
        if drift.abs() > MOST_DRIFT {
            return Err(ClockMapError::Rate((-drift * 1e6) as i64));
        }
        Ok(Self { drift, ..self })
    }

    /// A device's time on the host's clock, ns; 0 where it lies before the host's zero.
    pub(crate) fn host_ns(&self, device_ns: u64) -> u64 {
        let since = i128::from(device_ns) - i128::from(self.device_ns);
        let host = i128::from(self.host_ns) + since + (self.drift * since as f64) as i128;
        u64::try_from(host.max(0)).unwrap_or(u64::MAX)
    }

    /// Most that a time at the latch is off, ns: half the round trip.
    pub(crate) fn bound_ns(&self) -> u64 {
        self.bound_ns
    }
}

/// The interval of the host's clock, ns, in which a latch lies by all round trips; `None` where
/// there is none.
fn latch_interval(latch: &RoundTrip, round_trips: &[RoundTrip]) -> Option<[u64; 2]> {
    let (mut from, mut to) = (0, i128::MAX);
    for trip in round_trips {
        let since = i128::from(latch.device_ns) - i128::from(trip.device_ns);
        let slack = (CRYSTALS * since.abs() as f64).ceil() as i128;
        from = from.max(i128::from(trip.host_before_ns) + since - slack);
        to = to.min(i128::from(trip.host_after_ns) + since + slack);
    }
    let [first, last] = [from, to].map(u64::try_from);
    let interval = [first.ok()?, last.ok()?];
    (interval[0] <= interval[1]).then_some(interval)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device `offset` ns behind whose latch lies `there` ns after the request, `back` ns before
    /// the answer.
    fn round_trip(host_ns: u64, offset: u64, there: u64, back: u64) -> RoundTrip {
        RoundTrip {
            host_before_ns: host_ns,
            device_ns: host_ns + there - offset,
            host_after_ns: host_ns + there + back,
        }
    }

    #[test]
    fn the_shortest_round_trip_decides_and_bounds_the_error() {
        let offset = 1_700_000_000_000_000_000;
        let trips = [(400_000, 3_000), (1_500, 2_500), (9_000, 90_000)];
        let mut host = offset + 5_000_000_000;
        let mut latches = trips.iter().cycle().map(|(there, back)| {
            host += 1_000_000;
            round_trip(host, offset, *there, *back)
        });
        let map = ClockMap::latched(|| latches.next()).unwrap();
        assert_eq!(map.bound_ns(), 2_000);
        let device = 123_456_789_012;
        let error = map.host_ns(device).abs_diff(device + offset);
        // Asymmetric by 1000 ns: half of it.
        assert_eq!(error, 500);
        assert!(error <= map.bound_ns());
    }

    #[test]
    fn the_fastest_way_there_and_the_fastest_back_bound_together() {
        let offset = 1_700_000_000_000_000_000;
        let at = |k: u64, there, back| round_trip(offset + k * 1_000_000, offset, there, back);
        // One slow back, one slow there, both slow; a millisecond apart: 100 ns of two crystals.
        let trips = [at(1, 100, 9_000), at(2, 8_000, 200), at(3, 7_000, 7_000)];
        let map = ClockMap::of(&trips).unwrap();
        // [-(100 + 100), 200] about the latch
        assert!(map.bound_ns().abs_diff(200) <= 2, "{}", map.bound_ns());
        let error = map.host_ns(2_008_000).abs_diff(offset + 2_008_000);
        assert!(error <= map.bound_ns(), "{error}");
        // In any order, and never wider than the shortest one's own.
        let turned: Vec<_> = trips.iter().rev().copied().collect();
        assert_eq!(ClockMap::of(&turned), Ok(map));
        // Ticks 1 % fast: the intervals have nothing in common.
        let fast = |k: u64| RoundTrip { device_ns: k * 1_010_000, ..at(k, 100, 900 + k) };
        let map = ClockMap::of(&[fast(1), fast(2), fast(3)]).unwrap();
        assert_eq!((map.device_ns, map.bound_ns()), (1_010_000, 501));
    }

    #[test]
    fn a_rate_is_found_between_two_latches() {
        // 40 parts per million slow against the host.
        let host_of = |device: u64| 1_000_000_000_000 + device + device / 25_000;
        let at = |device: u64| {
            let middle = host_of(device);
            let trip =
                RoundTrip { host_before_ns: middle - 500, device_ns: device, host_after_ns: middle + 500 };
            ClockMap::of(&[trip]).unwrap()
        };
        let map = at(100_000_000_000).with_rate_since(&at(0)).unwrap();
        for device in [50_000_000_000, 100_000_000_000, 160_000_000_000] {
            assert!(map.host_ns(device).abs_diff(host_of(device)) <= 2, "{device}");
        }
        let later = at(7);
        assert_eq!(at(7).with_rate_since(&later), Err(ClockMapError::DeviceStands));
    }

    #[test]
    fn what_is_no_clock_is_refused() {
        assert_eq!(ClockMap::of(&[]), Err(ClockMapError::NoLatch));
        assert_eq!(ClockMap::latched(|| None), Err(ClockMapError::NoLatch));
        let back = RoundTrip { host_before_ns: 9, device_ns: 1, host_after_ns: 4 };
        assert_eq!(ClockMap::of(&[back]), Err(ClockMapError::HostWentBack(5)));
        // Ticks of 8 ns taken for nanoseconds.
        let at = |host: u64| RoundTrip { host_before_ns: host, device_ns: host / 8, host_after_ns: host };
        let [a, b] = [8_000, 8_008_000].map(|host| ClockMap::of(&[at(host)]).unwrap());
        assert_eq!(b.with_rate_since(&a), Err(ClockMapError::Rate(-7_000_000)));
    }
}
