//! Disappearance and return, reasons of gaps, and a producer that fails.

use shadowgauge::source::live::{Event, Gap, IdWidth, Live, LiveSource as _, Policy};

use super::conformance::{SOON, Seen, settings};
use super::scripted::{Scripted, Step};

fn seen(steps: Vec<Step>, policy: Policy) -> (Seen, Live) {
    let mut live = Live::new(Scripted::boxed(steps, IdWidth::GigE16), settings(policy)).unwrap();
    (Seen::until_end(&mut live, |_| {}), live)
}

#[test]
fn a_camera_that_was_away_goes_on_with_the_next_number() {
    let steps = vec![
        Step::Frame(1),
        Step::Frame(2),
        Step::Away,
        // It comes and goes without a frame: one report.
        Step::Away,
        Step::Frame(1),
        Step::Frame(3),
    ];
    let (seen, live) = seen(steps, Policy::Block);
    assert_eq!((seen.frames.as_slice(), seen.lost.len()), (&[0, 1, 2, 4][..], 1));
    assert_eq!(seen.gaps, [Gap { first: 3, next: 4, lost: 1, ..Gap::default() }]);
    assert_eq!((live.counters().disappeared, live.counters().accounted()), (1, 5));
}

#[test]
fn a_gap_states_its_numbers_and_why() {
    let steps = vec![Step::Frame(1), Step::Incomplete(3), Step::Incomplete(4), Step::Frame(6)];
    let (seen, _) = seen(steps, Policy::Block);
    let total: u64 = seen.gaps.iter().map(Gap::count).sum();
    assert_eq!((seen.frames.as_slice(), total), (&[0, 5][..], 4));
    let words: Vec<String> = seen.gaps.iter().map(ToString::to_string).collect();
    let words = words.join("; ");
    assert!(words.contains("did not arrive") && words.contains("3 packets of 8"), "{words}");
    let joined = Gap { first: 3, next: 7, lost: 1, incomplete: 1, dropped: 2, why: Some("x".to_owned()) };
    let right = "frames 3 to 6: 1 did not arrive, 1 incomplete, 2 left out: the gauge was too slow (x)";
    assert_eq!(joined.to_string(), right);
}

#[test]
fn with_every_lease_out_frames_are_dropped_and_counted_not_waited_for() {
    for policy in [Policy::DropOldest, Policy::DropNewest] {
        let steps = (0..500).map(|n| Step::Frame(n + 1));
        let mut live = Live::new(Scripted::boxed(steps, IdWidth::GigE16), settings(policy)).unwrap();
        let mut held = Vec::new();
        // A consumer that gives nothing back: the producer ends all the same.
        let begun = std::time::Instant::now();
        while live.counters().accounted() < 500 {
            assert!(begun.elapsed() < SOON, "{policy:?}: {:?}", live.counters());
            if let Event::Frame(frame) = live.next_event(std::time::Duration::ZERO) {
                held.push(frame.lease);
            }
        }
        assert!(held.len() <= 7, "{}", held.len());
        drop(held);
        Seen::until_end(&mut live, |_| {});
        let counters = live.counters();
        assert_eq!((counters.accounted(), counters.waiting, counters.lost), (500, 0, 0));
        assert!(counters.dropped >= 493, "{counters:?}");
    }
}

#[test]
fn a_producer_that_fails_ends_the_source_with_a_reason() {
    let (seen, mut live) = seen(vec![Step::Frame(1), Step::Panic], Policy::Block);
    assert_eq!(seen.frames, [0]);
    assert!(seen.failure.unwrap().contains("failed"));
    live.stop();
    assert!(live.start().is_ok());
}
