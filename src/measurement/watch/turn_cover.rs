//! Which angles each turn of a spindle leaves out.

use serde::Serialize;

use crate::position::{AngleCover, Uncovered, shorter_way_deg};

/// A step against the sense of the turn that is larger is one with it, over more than half a turn
/// of lost frames: no spindle reverses by a quarter of a turn from frame to frame.
const LARGEST_BACK_DEG: f64 = 90.0;
/// The same where the exposure has shown the sense: what is left is the jitter of a spindle that
/// nearly stands, a few counts of an encoder of 360 counts a turn.
const JITTER_DEG: f64 = 5.0;

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
    /// The next frame's angle and the angle turned during its exposure (0 where it is not known),
    /// degrees, and whether it shows a diameter; the turn that ended with it, whose angles are
    /// those before it. A whole turn without a frame is not seen: it is a gap of the source.
    pub(crate) fn push(&mut self, angle_deg: f64, sweep_deg: f64, is_measured: bool) -> Option<Turn> {
        let step_deg = self.last_deg.replace(angle_deg).map_or(0.0, |last| shorter_way_deg(last, angle_deg));
        let (sense, largest_deg) =
            if sweep_deg == 0.0 { (self.sense, LARGEST_BACK_DEG) } else { (sweep_deg.signum(), JITTER_DEG) };
        let is_other_way = step_deg * sense < 0.0 && step_deg.abs() > largest_deg;
        self.turned_deg += step_deg + if is_other_way { 360.0 * sense } else { 0.0 };
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
        self.turned_deg -= 360.0 * self.turned_deg.signum();
        let uncovered = std::mem::take(&mut self.cover).uncovered();
        Turn { turn: self.turns, uncovered }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The turns of 32 frames each with this step and angle turned during the exposure, without the
    /// frames that are lost, and with those that show no diameter.
    fn turns(
        [step_deg, sweep_deg]: [f64; 2],
        is_lost: impl Fn(u32) -> bool,
        is_refused: impl Fn(u32) -> bool,
    ) -> Vec<Turn> {
        let mut cover = TurnCover::default();
        let frames = (0..=96).filter(|k| !is_lost(*k));
        let angle_deg = |k: u32| (step_deg * f64::from(k)).rem_euclid(360.0);
        frames.filter_map(|k| cover.push(angle_deg(k), sweep_deg, !is_refused(k))).collect()
    }

    const STEPS: [[f64; 2]; 4] = [[11.25, 0.0], [-11.25, 0.0], [11.25, 7.2], [-11.25, -7.2]];

    #[test]
    fn each_turn_shows_the_angles_that_its_frames_leave_out() {
        for step in STEPS {
            let whole = turns(step, |_| false, |_| false);
            assert_eq!(whole.iter().map(|turn| turn.turn).collect::<Vec<_>>(), [1, 2, 3]);
            assert!(whole.iter().all(|turn| turn.uncovered.uncovered_deg.is_empty()), "{whole:?}");
            // the other half turn shows the same diameter: one of the two may be missing
            let one = turns(step, |k| k == 36, |_| false);
            assert!(one[1].uncovered.uncovered_deg.is_empty(), "{one:?}");
            for found in [
                turns(step, |k| k == 36 || k == 52, |_| false),
                turns(step, |_| false, |k| k == 36 || k == 52),
            ] {
                let gaps = found.iter().map(|turn| turn.uncovered.uncovered_deg.len()).collect::<Vec<_>>();
                assert_eq!(gaps, [0, 1, 0], "{found:?}");
            }
        }
    }

    #[test]
    fn more_than_half_a_turn_lost_is_uncovered() {
        for step in STEPS {
            // 326° differ from -34° by the sense that exposures show alone, 236° from -124° by the
            // turn before
            let first = if step[1] == 0.0 { 54 } else { 62 };
            let found = turns(step, |k| (34..first).contains(&k), |_| false);
            let gaps = found.iter().map(|turn| turn.uncovered.uncovered_deg.len()).collect::<Vec<_>>();
            assert_eq!(gaps, [0, 1, 0], "{found:?}");
        }
    }

    #[test]
    fn a_spindle_that_stands_ends_no_turn() {
        let mut stands = TurnCover::default();
        let jitter = |k: u32| if k.is_multiple_of(2) { 359.99 } else { 0.01 };
        assert!((0..1000).all(|k| stands.push(jitter(k), 0.1, true).is_none()));
    }
}
