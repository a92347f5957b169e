//! Parts that enter the field and leave it: one value a part.
//!
//! A part is there from the first of two frames in a row that show one, and gone at the second of
//! two in a row that show none; frames that are refused for another reason count for neither. The
//! first and the last frame may show it moving and are left out where there are others. Its value
//! is the frame in the middle of the sorted diameters, with the uncertainty of that frame: frames
//! of one part share most of it, so that more of them do not reduce it. It is judged as its worst
//! frame is. Where diameters have to settle, value and judgement are of the frames that had; a part
//! without any has the value of all of its frames, and is not proven.

use std::collections::VecDeque;

/// Frames in a row that decide: one alone may be a chip that flies through.
const IN_A_ROW: usize = 2;
/// Most frames of a part that are kept, some 200 kB: of a part that stays longer the last ones.
const MOST: usize = 4096;

/// The value of a frame, in mm or px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameValue {
    /// Its sequence number.
    pub sequence: u64,
    /// Its largest diameter.
    pub value: f64,
    /// Expanded uncertainty of it.
    pub expanded_u: f64,
    /// How far from good: 0 good or not judged, 1 not proven, 2 proven bad.
    pub severity: u8,
    /// The judgement's word; empty where nothing is judged.
    pub word: &'static str,
    /// Whether the diameter had settled; true where it does not have to.
    pub is_settled: bool,
}

/// What a frame shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Seen {
    /// A part.
    Part(FrameValue),
    /// Light without a shadow.
    Empty,
    /// Neither is certain.
    Unclear,
}

/// The value of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PartValue {
    /// Its number, from 1.
    pub number: u64,
    /// Sequence numbers of its first and last frame with a value.
    pub frames: [u64; 2],
    /// Frames with a value.
    pub count: u64,
    /// The middle value, with its expanded uncertainty.
    pub value: f64,
    /// Expanded uncertainty of it.
    pub expanded_u: f64,
    /// Severity and word of the worst frame.
    pub severity: u8,
    /// The judgement's word; empty where nothing is judged.
    pub word: &'static str,
    /// Whether the diameter had settled in some frame.
    pub is_settled: bool,
}

/// Parts as they come and go.
#[derive(Clone, Debug, Default)]
pub(crate) struct Presence {
    /// Frames of the part that is there, or that may be entering.
    frames: VecDeque<FrameValue>,
    first: Option<u64>,
    count: u64,
    is_there: bool,
    empty: usize,
    parts: u64,
}

impl Presence {
    /// Whether a part is in the field.
    pub(crate) fn is_there(&self) -> bool {
        self.is_there
    }

    /// Parts whose values were given.
    pub(crate) fn parts(&self) -> u64 {
        self.parts
    }

    /// Takes a frame; the value of a part that has left with it.
    pub(crate) fn push(&mut self, seen: Seen) -> Option<PartValue> {
        match seen {
            Seen::Unclear => None,
            Seen::Part(frame) => {
                self.empty = 0;
                self.first.get_or_insert(frame.sequence);
                self.count += 1;
                if self.frames.len() == MOST {
                    self.frames.pop_front();
                }
                self.frames.push_back(frame);
                self.is_there |= self.count as usize >= IN_A_ROW;
                None
            }
            Seen::Empty => {
                self.empty += 1;
                if self.is_there && self.empty < IN_A_ROW {
                    return None;
                }
                self.leave()
            }
        }
    }

    /// The value of a part that is there at the end.
    pub(crate) fn end(&mut self) -> Option<PartValue> {
        self.leave()
    }

    fn leave(&mut self) -> Option<PartValue> {
        let (frames, first) = (std::mem::take(&mut self.frames), self.first.take());
        let count = std::mem::take(&mut self.count);
        if !std::mem::take(&mut self.is_there) {
            return None;
        }
        let mut settled: Vec<FrameValue> = frames.iter().copied().collect();
        if settled.len() > 2 {
            settled.pop();
            // Where the oldest were let go, the first is none that moves.
            if count as usize == frames.len() {
                settled.remove(0);
            }
        }
        let is_settled = settled.iter().any(|frame| frame.is_settled);
        if is_settled {
            settled.retain(|frame| frame.is_settled);
        }
        let worst = settled.iter().copied().max_by_key(|frame| frame.severity)?;
        settled.sort_by(|a, b| a.value.total_cmp(&b.value));
        let middle = settled.get((settled.len() - 1) / 2)?;
        self.parts += 1;
        Some(PartValue {
            number: self.parts,
            frames: [first?, frames.back()?.sequence],
            count,
            value: middle.value,
            expanded_u: middle.expanded_u,
            severity: worst.severity,
            word: worst.word,
            is_settled,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(sequence: u64, value: f64) -> Seen {
        Seen::Part(FrameValue {
            sequence,
            value,
            expanded_u: 0.1 * value,
            severity: 0,
            word: "GO",
            is_settled: true,
        })
    }

    fn values(seen: &[Seen]) -> (Vec<PartValue>, Presence) {
        let mut presence = Presence::default();
        let values = seen.iter().filter_map(|seen| presence.push(*seen)).collect();
        (values, presence)
    }

    #[test]
    fn one_value_a_part_without_its_moving_frames() {
        let mut seen = vec![Seen::Empty];
        seen.extend([(1, 3.0), (2, 10.0), (3, 12.0), (4, 11.0), (5, 4.0)].map(|(n, v)| part(n, v)));
        seen.extend([Seen::Empty, Seen::Empty, Seen::Empty]);
        seen.extend([part(9, 20.0), part(10, 21.0), Seen::Empty, Seen::Empty]);
        let (parts, presence) = values(&seen);
        let found: Vec<_> = parts.iter().map(|p| (p.number, p.frames, p.count, p.value)).collect();
        assert_eq!(found, [(1, [1, 5], 5, 11.0), (2, [9, 10], 2, 20.0)]);
        assert!((parts[0].expanded_u - 1.1).abs() < 1e-12 && !presence.is_there());
    }

    #[test]
    fn a_flash_is_no_part_and_a_gap_of_one_frame_no_departure() {
        let (parts, _) = values(&[part(0, 1.0), Seen::Empty, Seen::Empty, part(3, 1.0), Seen::Empty]);
        assert!(parts.is_empty());
        let (parts, mut presence) =
            values(&[part(0, 5.0), part(1, 5.0), Seen::Empty, part(3, 6.0), Seen::Unclear, part(5, 7.0)]);
        assert!(parts.is_empty() && presence.is_there());
        let last = presence.end().unwrap();
        assert_eq!((last.count, last.frames, last.value), (4, [0, 5], 5.0));
        assert_eq!(presence.end(), None);
    }

    #[test]
    fn the_worst_frame_judges() {
        let bad = FrameValue {
            sequence: 2,
            value: 9.0,
            expanded_u: 0.1,
            severity: 2,
            word: "HH",
            is_settled: true,
        };
        let (parts, _) =
            values(&[part(0, 9.0), part(1, 9.0), Seen::Part(bad), part(3, 9.0), Seen::Empty, Seen::Empty]);
        assert_eq!((parts[0].severity, parts[0].word), (2, "HH"));
    }

    #[test]
    fn the_frames_that_had_settled_give_the_value() {
        let waiting = |sequence, value| match part(sequence, value) {
            Seen::Part(frame) => Seen::Part(FrameValue { severity: 1, word: "", is_settled: false, ..frame }),
            other => other,
        };
        let mut seen: Vec<Seen> = (0..6).map(|k| waiting(k, 20.0 - k as f64)).collect();
        seen.extend([part(6, 13.0), part(7, 12.0), part(8, 13.0), part(9, 13.5), Seen::Empty, Seen::Empty]);
        seen.extend((10..14).map(|k| waiting(k, 30.0)));
        seen.extend([Seen::Empty, Seen::Empty]);
        let (parts, _) = values(&seen);
        let found: Vec<_> = parts.iter().map(|p| (p.value, p.severity, p.is_settled, p.count)).collect();
        assert_eq!(found, [(13.0, 0, true, 10), (30.0, 1, false, 4)]);
    }

    #[test]
    fn a_part_that_stays_takes_bounded_memory() {
        let mut presence = Presence::default();
        (0..3 * MOST as u64).for_each(|n| assert_eq!(presence.push(part(n, n as f64)), None));
        assert_eq!(presence.frames.len(), MOST);
        let value = presence.end().unwrap();
        assert_eq!((value.count, value.frames), (3 * MOST as u64, [0, 3 * MOST as u64 - 1]));
    }
}
