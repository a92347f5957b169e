//! The counters add up to what was sent, whatever was lost on the way.

use proptest::prelude::*;
use shadowgauge::source::live::{IdWidth, Live, LiveSource as _, Policy};

use super::conformance::{SOON, Seen, settings};
use super::scripted::{Scripted, Step};

/// What becomes of a frame on the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    Whole,
    Part,
    Lost,
    Twice,
}

fn fate() -> impl Strategy<Value = Fate> {
    prop_oneof![5 => Just(Fate::Whole), 1 => Just(Fate::Part), 1 => Just(Fate::Lost), 1 => Just(Fate::Twice)]
}

fn script(fates: &[Fate], start: u64) -> Vec<Step> {
    let id = |at: usize| (start + at as u64) % 65_535 + 1;
    let mut steps: Vec<Step> = Vec::new();
    for (at, fate) in fates.iter().enumerate() {
        match fate {
            Fate::Whole => steps.push(Step::Frame(id(at))),
            Fate::Part => steps.push(Step::Incomplete(id(at))),
            Fate::Lost => {}
            Fate::Twice => steps.extend([Step::Frame(id(at)), Step::Frame(id(at))]),
        }
    }
    steps.push(Step::SentUntil(id(fates.len())));
    steps
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn delivered_dropped_incomplete_and_lost_are_what_was_sent(
        mut fates in prop::collection::vec(fate(), 1..60),
        policy in prop_oneof![Just(Policy::Block), Just(Policy::DropOldest), Just(Policy::DropNewest)],
        slow in any::<bool>(),
        start in prop_oneof![Just(0_u64), Just(65_500)],
    ) {
        // The first frame that comes is the first that is counted.
        fates[0] = Fate::Whole;
        let mut live = Live::new(Scripted::boxed(script(&fates, start), IdWidth::GigE16), settings(policy)).unwrap();
        let begun = std::time::Instant::now();
        while slow && policy != Policy::Block && live.counters().accounted() < fates.len() as u64 {
            assert!(begun.elapsed() < SOON);
            std::thread::yield_now();
        }
        let seen = Seen::until_end(&mut live, |_| {});
        let counted = live.counters();
        let count = |wanted: Fate| fates.iter().filter(|fate| **fate == wanted).count() as u64;
        prop_assert_eq!(counted.accounted(), fates.len() as u64);
        prop_assert_eq!(counted.delivered + counted.dropped, count(Fate::Whole) + count(Fate::Twice));
        prop_assert_eq!((counted.incomplete, counted.lost), (count(Fate::Part), count(Fate::Lost)));
        prop_assert_eq!((counted.repeated, counted.waiting), (count(Fate::Twice), 0));
        prop_assert_eq!(counted.delivered, seen.frames.len() as u64);
        let of = |which: fn(&shadowgauge::source::live::Gap) -> u64| seen.gaps.iter().map(which).sum::<u64>();
        prop_assert_eq!((of(|g| g.lost), of(|g| g.incomplete), of(|g| g.dropped)), (counted.lost, counted.incomplete, counted.dropped));
        if policy == Policy::Block {
            prop_assert_eq!(counted.dropped, 0);
        }
    }
}
