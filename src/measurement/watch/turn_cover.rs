//! Which angles each turn of a spindle leaves out.

use serde::Serialize;

use crate::position::{AngleCover, Uncovered, shorter_way_deg};

/// A step against the sense of the turn that is larger is one with it, over more than half a turn
/// of lost frames: no spindle reverses by a quarter of a turn from frame to frame. Smaller ones are
/// the jitter of a spindle that stands.
const LARGEST_BACK_DEG: f64 = 90.0;

/// The turn so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct TurnCover {
    cover: AngleCover,
    last_deg: Option<f64>,
    /// Since the turn began, in the sense of the step's sign, degrees.
    turned_deg: f64,
    /// Sense of rotation, 1 or -1; 0 before it is known.
    sense: f64,
    turns: u64,
}

/// A whole turn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Turn {
    /// Its number, from 1.
    pub(crate) turn: u64,
    /// What the frames with a diameter leave out.
    #[serde(flatten)]
    pub(crate) uncovered: Uncovered,
}

impl TurnCover {
    /// The next frame's angle, degrees, and whether it shows a diameter; the turn that ended with
    /// it, whose angles are those before it.
    pub(crate) fn push(&mut self, angle_deg: f64, is_measured: bool) -> Option<Turn> {
        let step_deg = self.last_deg.replace(angle_deg).map_or(0.0, |last| shorter_way_deg(last, angle_deg));
        let is_other_way = step_deg * self.sense < 0.0 && step_deg.abs() > LARGEST_BACK_DEG;
        self.turned_deg += step_deg + if is_other_way { 360.0 * self.sense } else { 0.0 };
        if self.turned_deg.abs() > LARGEST_BACK_DEG {
            self.sense = self.turned_deg.signum();
        }
        // angles that are rounded to 0.001° do not add up to a turn exactly
        let ended = (self.turned_deg.abs() >= 360.0 - 1e-3).then(|| self.end());
        if is_measured {
            self.cover.add(angle_deg);
        }
        ended
    }

    fn end(&mut self) -> Turn {
        self.turns += 1;
        // what is left over belongs to the next turn
        self.turned_deg -= 360.0 * self.sense;
        let uncovered = std::mem::take(&mut self.cover).uncovered();
        Turn { turn: self.turns, uncovered }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The turns of 32 frames each, without the frames that are lost and with those refused.
    fn turns(sense: f64, is_lost: impl Fn(u32) -> bool, is_refused: impl Fn(u32) -> bool) -> Vec<Turn> {
        let mut cover = TurnCover::default();
        let frames = (0..=96).filter(|k| !is_lost(*k));
        frames
            .filter_map(|k| cover.push((sense * 11.25 * f64::from(k)).rem_euclid(360.0), !is_refused(k)))
            .collect()
    }

    #[test]
    fn each_turn_shows_the_angles_that_its_frames_leave_out() {
        for sense in [1.0, -1.0] {
            let whole = turns(sense, |_| false, |_| false);
            assert_eq!(whole.iter().map(|turn| turn.turn).collect::<Vec<_>>(), [1, 2, 3]);
            assert!(whole.iter().all(|turn| turn.uncovered.uncovered_deg.is_empty()), "{whole:?}");
            // the other half turn shows the same diameter: one of the two may be missing
            let one = turns(sense, |k| k == 36, |_| false);
            assert!(one[1].uncovered.uncovered_deg.is_empty(), "{one:?}");
            for found in [
                turns(sense, |k| k == 36 || k == 52, |_| false),
                turns(sense, |_| false, |k| k == 36 || k == 52),
            ] {
                let gaps = found.iter().map(|turn| turn.uncovered.uncovered_deg.len()).collect::<Vec<_>>();
                assert_eq!(gaps, [0, 1, 0], "{found:?}");
            }
        }
    }

    #[test]
    fn more_than_half_a_turn_lost_is_uncovered_and_a_spindle_that_stands_ends_no_turn() {
        let found = turns(1.0, |k| (34..62).contains(&k), |_| false);
        assert_eq!(found.len(), 3);
        assert!(found[0].uncovered.uncovered_deg.is_empty() && found[1].uncovered.angles < 8, "{found:?}");
        assert!(!found[1].uncovered.uncovered_deg.is_empty() && found[2].uncovered.uncovered_deg.is_empty());
        let mut stands = TurnCover::default();
        let jitter = |k: u32| if k.is_multiple_of(2) { 359.99 } else { 0.01 };
        assert!((0..1000).all(|k| stands.push(jitter(k), true).is_none()));
    }
}
