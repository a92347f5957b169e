//! What every live source holds to, whatever is behind it.
//!
//! A [`Factory`] opens a source that sends a number of frames whose first pixel is their number (of
//! eight bits). Each part of the suite opens a source of its own.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use shadowgauge::frame::Frame;
use shadowgauge::source::live::{Event, Gap, Lease, Live, LiveSettings, LiveSource, Policy, Producer};

/// Longest time until something comes: hundreds of times what it takes.
pub(super) const SOON: Duration = Duration::from_secs(20);
/// Frames of a series.
pub(super) const FRAMES: u64 = 24;

/// Opens sources of one kind.
pub(super) struct Factory<'a> {
    /// A source of so many frames.
    pub(super) open: &'a dyn Fn(u64) -> Box<dyn Producer>,
    /// What a frame must show to be the one of its number.
    pub(super) is_frame: &'a dyn Fn(&Frame, u64) -> bool,
}

pub(super) fn settings(policy: Policy) -> LiveSettings {
    LiveSettings { policy, waiting: 4, held: 2 }
}

impl Factory<'_> {
    fn live(&self, policy: Policy) -> Live {
        Live::new((self.open)(FRAMES), settings(policy)).unwrap()
    }

    /// The whole suite.
    pub(super) fn conforms(&self) {
        self.frames_come_in_order_each_with_its_own_pixels();
        self.a_wait_ends_in_time();
        self.stopped_and_started_it_goes_on();
        self.leases_are_bounded();
        self.a_slow_consumer_loses_nothing_where_the_producer_waits();
        self.a_slow_consumer_gets_the_newest();
        self.a_slow_consumer_gets_the_oldest();
        self.dropped_in_any_state_it_ends();
    }

    fn frames_come_in_order_each_with_its_own_pixels(&self) {
        let mut live = self.live(Policy::Block);
        let seen = Seen::until_end(&mut live, |_| {});
        assert_eq!(seen.frames, (0..FRAMES).collect::<Vec<_>>());
        assert!(seen.gaps.is_empty() && seen.failure.is_none(), "{seen:?}");
        let mut live = self.live(Policy::Block);
        for number in 0..FRAMES {
            let (found, lease) = next_frame(&mut live);
            assert!(found == number && (self.is_frame)(&lease.frame, number), "{number}");
            lease.give_back();
        }
        // The end stays the end.
        assert!(matches!(live.next_event(SOON), Event::End(None)));
        assert!(matches!(live.next_event(Duration::ZERO), Event::End(None)));
    }

    fn a_wait_ends_in_time(&self) {
        let mut live = self.live(Policy::Block);
        // A second lease of the last place is not given: nothing more can come.
        let held: Vec<Lease> = (0..7).map_while(|_| frame_within(&mut live, SOON)).collect();
        let begun = Instant::now();
        assert!(matches!(live.next_event(Duration::from_millis(30)), Event::Timeout));
        assert!(begun.elapsed() >= Duration::from_millis(30));
        drop(held);
        let (number, _) = next_frame(&mut live);
        assert_eq!(number, 7);
    }

    fn stopped_and_started_it_goes_on(&self) {
        let mut live = self.live(Policy::Block);
        let mut seen = vec![next_frame(&mut live).0, next_frame(&mut live).0];
        live.stop();
        let rest = Seen::until_end(&mut live, |_| {});
        // What waited is given still; one that was in the producer's hand may be dropped.
        seen.extend(&rest.frames);
        let dropped: u64 = rest.gaps.iter().map(Gap::count).sum();
        assert!(rest.frames.len() <= 4 && dropped <= 1, "{rest:?}");
        assert!(matches!(live.next_event(Duration::ZERO), Event::End(None)));
        live.start().unwrap();
        let after = Seen::until_end(&mut live, |_| {});
        seen.extend(&after.frames);
        let gaps: u64 = rest.gaps.iter().chain(&after.gaps).map(Gap::count).sum();
        assert!(seen.is_sorted() && seen.len() as u64 + gaps == FRAMES, "{seen:?} {gaps}");
        assert_eq!(live.counters().accounted(), FRAMES);
    }

    fn leases_are_bounded(&self) {
        let mut live = self.live(Policy::Block);
        // 4 that wait, 2 that are held, 1 that is made.
        let held: Vec<Lease> = (0..7).map_while(|_| frame_within(&mut live, SOON)).collect();
        assert_eq!(held.len(), 7);
        assert!(frame_within(&mut live, Duration::from_millis(150)).is_none());
        held.into_iter().for_each(Lease::give_back);
        let rest = Seen::until_end(&mut live, |_| {});
        assert_eq!(rest.frames, (7..FRAMES).collect::<Vec<_>>());
    }

    fn a_slow_consumer_loses_nothing_where_the_producer_waits(&self) {
        let mut live = self.live(Policy::Block);
        let seen = Seen::until_end(&mut live, |_| std::thread::sleep(Duration::from_millis(4)));
        assert_eq!(seen.frames, (0..FRAMES).collect::<Vec<_>>());
        let counters = live.counters();
        assert_eq!((counters.delivered, counters.dropped, counters.waiting), (FRAMES, 0, 0));
    }

    /// The producer's end has come before the consumer looks at all.
    fn after_all(&self, policy: Policy) -> (Seen, Live) {
        let mut live = self.live(policy);
        let begun = Instant::now();
        while live.counters().accounted() < FRAMES && begun.elapsed() < SOON {
            std::thread::sleep(Duration::from_millis(2));
        }
        let seen = Seen::until_end(&mut live, |_| {});
        assert_eq!(live.counters().accounted(), FRAMES);
        (seen, live)
    }

    fn a_slow_consumer_gets_the_newest(&self) {
        let (seen, live) = self.after_all(Policy::DropOldest);
        assert_eq!(seen.frames, (FRAMES - 4..FRAMES).collect::<Vec<_>>());
        assert_eq!((seen.gaps.len(), seen.gaps[0].dropped), (1, FRAMES - 4));
        assert_eq!((live.counters().delivered, live.counters().dropped), (4, FRAMES - 4));
    }

    fn a_slow_consumer_gets_the_oldest(&self) {
        let (seen, live) = self.after_all(Policy::DropNewest);
        assert_eq!(seen.frames, (0..4).collect::<Vec<_>>());
        assert_eq!(seen.gaps, [Gap { first: 4, next: FRAMES, dropped: FRAMES - 4, ..Gap::default() }]);
        assert_eq!((live.counters().delivered, live.counters().dropped), (4, FRAMES - 4));
    }

    fn dropped_in_any_state_it_ends(&self) {
        for policy in [Policy::Block, Policy::DropOldest, Policy::DropNewest] {
            drop(self.live(policy));
            let mut live = self.live(policy);
            // What came before it may have been dropped by the policy.
            let lease = (0..FRAMES).find_map(|_| frame_within(&mut live, SOON)).unwrap();
            drop(live);
            // A lease outlives its source.
            assert!(lease.frame.view().rows() > 0);
        }
    }
}

/// What came of a source.
#[derive(Debug, Default)]
pub(super) struct Seen {
    pub(super) frames: Vec<u64>,
    pub(super) gaps: Vec<Gap>,
    pub(super) lost: Vec<String>,
    pub(super) failure: Option<String>,
}

impl Seen {
    /// Takes events to the end; every number is in one frame or one gap, in order.
    pub(super) fn until_end(live: &mut dyn LiveSource, mut frame: impl FnMut(u64)) -> Self {
        let (mut seen, mut numbers) = (Self::default(), BTreeSet::new());
        loop {
            match live.next_event(SOON) {
                Event::Frame(taken) => {
                    let number = taken.meta.sequence;
                    assert!(numbers.last().is_none_or(|last| *last < number) && numbers.insert(number));
                    seen.frames.push(number);
                    frame(number);
                    taken.lease.give_back();
                }
                Event::Gap(gap) => {
                    assert_eq!(gap.count(), gap.lost + gap.incomplete + gap.dropped, "{gap}");
                    for number in gap.first..gap.next {
                        assert!(numbers.last().is_none_or(|last| *last < number) && numbers.insert(number));
                    }
                    seen.gaps.push(gap);
                }
                Event::Lost(why) => seen.lost.push(why),
                Event::Timeout => panic!("nothing for {SOON:?}: {seen:?}"),
                Event::End(failure) => {
                    seen.failure = failure;
                    return seen;
                }
            }
        }
    }
}

/// The next event, a frame.
pub(super) fn next_frame(live: &mut dyn LiveSource) -> (u64, Lease) {
    match live.next_event(SOON) {
        Event::Frame(frame) => (frame.meta.sequence, frame.lease),
        other => panic!("{other:?}"),
    }
}

/// The lease of a frame, if one comes in time.
fn frame_within(live: &mut dyn LiveSource, wait: Duration) -> Option<Lease> {
    match live.next_event(wait) {
        Event::Frame(frame) => Some(frame.lease),
        _ => None,
    }
}
