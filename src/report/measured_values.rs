//! The largest diameters of a series of any length, as a chart shows them: one by one while they
//! are few, then in groups of neighbouring frames.
//!
//! A group is closed once it has its number of frames. Where there are [`MOST_GROUPS`], neighbours
//! are merged in pairs and every further group takes twice as many frames: the memory does not
//! grow with the series, and each group is some pixels of a chart.

use crate::measurement::Verdict;
use crate::profile::Diameter;

/// Most frames that have a dot and a bar each: bars of more touch one another.
pub(super) const MOST_BARS: usize = 250;
/// Most groups of frames beyond that: each then is two to four pixels of a chart.
pub(super) const MOST_GROUPS: usize = 400;

/// A diameter with its expanded uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Value {
    pub d_mm: f64,
    pub expanded_mm: f64,
}

impl Value {
    /// Of a diameter, with U = k·u.
    pub(super) fn of(diameter: Diameter, k: f64) -> Self {
        Self { d_mm: diameter.d_mm, expanded_mm: k * diameter.u_mm() }
    }
}

/// A value with the number of its frame, from 1, and its verdict.
pub(super) type Seen = (f64, Value, Verdict);

/// Neighbouring frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    count: f64,
    /// Sum of the frames' numbers.
    sum_x: f64,
    sum_mm: f64,
    /// Least end of a U, mm.
    pub low_mm: f64,
    /// Greatest end of a U, mm.
    pub high_mm: f64,
}

impl Group {
    fn of((x, value, _): &Seen) -> Self {
        let (d_mm, expanded_mm) = (value.d_mm, value.expanded_mm);
        let (low_mm, high_mm) = (d_mm - expanded_mm, d_mm + expanded_mm);
        Self { count: 1.0, sum_x: *x, sum_mm: d_mm, low_mm, high_mm }
    }

    fn joined(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            sum_x: self.sum_x + other.sum_x,
            sum_mm: self.sum_mm + other.sum_mm,
            low_mm: self.low_mm.min(other.low_mm),
            high_mm: self.high_mm.max(other.high_mm),
        }
    }

    /// Middle of its frames' numbers.
    pub(super) fn x(&self) -> f64 {
        self.sum_x / self.count
    }

    /// Mean of its diameters, mm.
    pub(super) fn mean_mm(&self) -> f64 {
        self.sum_mm / self.count
    }
}

/// The values of a series so far.
#[derive(Clone, Debug)]
pub(super) struct MeasuredValues {
    /// Frames, with a value or without.
    pub frames: usize,
    values: usize,
    /// The first [`MOST_BARS`] values.
    first: Vec<Seen>,
    groups: Vec<Group>,
    /// Values of a whole group.
    size: f64,
}

impl Default for MeasuredValues {
    fn default() -> Self {
        Self { frames: 0, values: 0, first: Vec::new(), groups: Vec::new(), size: 1.0 }
    }
}

impl MeasuredValues {
    /// Adds a frame.
    pub(super) fn add(&mut self, value: Option<Value>, verdict: Verdict) {
        self.frames += 1;
        let Some(value) = value else { return };
        let seen = (self.frames as f64, value, verdict);
        self.values += 1;
        if self.first.len() < MOST_BARS {
            self.first.push(seen);
        }
        match self.groups.last_mut().filter(|group| group.count < self.size) {
            Some(open) => *open = open.joined(Group::of(&seen)),
            None => self.begin_group(&seen),
        }
    }

    fn begin_group(&mut self, seen: &Seen) {
        if self.groups.len() == MOST_GROUPS {
            self.groups = self.groups.chunks(2).map(|pair| pair[0].joined(pair[1])).collect();
            self.size *= 2.0;
        }
        self.groups.push(Group::of(seen));
    }

    /// Whether no frame has a value.
    pub(super) fn is_empty(&self) -> bool {
        self.values == 0
    }

    /// All values, where they are few.
    pub(super) fn single(&self) -> Option<&[Seen]> {
        (self.values <= MOST_BARS).then_some(&self.first)
    }

    /// The groups of all values, in their order.
    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_hold_all_values_in_their_order_however_many_there_are() {
        for count in [1, 399, 400, 401, 12_345] {
            let mut values = MeasuredValues::default();
            let d_mm = |index: usize| 25.0 + ((index * 37) % 101) as f64 * 1e-3;
            for index in 0..count {
                let value = Value { d_mm: d_mm(index), expanded_mm: 0.01 };
                values.add((index % 10 != 3).then_some(value), Verdict::NotJudged);
            }
            let kept: Vec<usize> = (0..count).filter(|index| index % 10 != 3).collect();
            assert!(values.groups().len() <= MOST_GROUPS && values.groups().is_sorted_by_key(Group::x));
            // Every group is a run of neighbours: they are gone through one after another.
            let mut rest = kept.as_slice();
            for group in values.groups() {
                let (own, after) = rest.split_at(group.count as usize);
                rest = after;
                let mean =
                    |of: &dyn Fn(usize) -> f64| own.iter().map(|i| of(*i)).sum::<f64>() / own.len() as f64;
                assert!((group.mean_mm() - mean(&d_mm)).abs() < 1e-9);
                assert!((group.x() - mean(&|i| (i + 1) as f64)).abs() < 1e-9);
                let high = own.iter().map(|i| d_mm(*i) + 0.01).fold(0.0, f64::max);
                assert!((group.high_mm - high).abs() < 1e-12);
            }
            assert!(rest.is_empty() && values.frames == count);
            assert_eq!(values.single().is_some(), kept.len() <= MOST_BARS);
        }
    }
}
