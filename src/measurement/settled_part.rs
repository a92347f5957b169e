//! The settling of the part that a series shows, and what it makes of the frames' judgements.

use super::result::Measurement;
use super::settling::{Settled, Settling, TurnMeans};
use crate::frame::FrameMeta;
use crate::profile::{Diameter, Reading};

/// The part that a series shows.
pub(super) struct SettledPart {
    settling: Settling,
    /// Where the part turns: its readings are means of whole turns.
    turns: Option<TurnMeans>,
    last: Settled,
    good: usize,
}

impl SettledPart {
    /// A part whose readings must agree over so many seconds.
    pub(super) fn new(settle_s: f64, turns: bool) -> Self {
        Self {
            settling: Settling::new(settle_s),
            turns: turns.then(TurnMeans::default),
            last: Settled::Waiting { seen_s: 0.0, readings: 0 },
            good: 0,
        }
    }

    /// Another part: nothing of the last one holds for it.
    pub(super) fn restart(&mut self) {
        self.settling.restart();
        self.turns = self.turns.as_ref().map(|_| TurnMeans::default());
        (self.last, self.good) = (Settled::Waiting { seen_s: 0.0, readings: 0 }, 0);
    }

    /// Readings are means of whole turns from now on.
    pub(super) fn take_turns(&mut self) {
        self.turns.get_or_insert_default();
    }

    /// Adds a frame's mean diameter; a frame without one leaves the state as it is.
    pub(super) fn push(&mut self, meta: &FrameMeta, mean: Option<Diameter>) -> Settled {
        let reading = mean.and_then(|mean| match &mut self.turns {
            None => Some((meta.t_ns, mean.d_mm)),
            Some(turns) => turns.push(meta.t_ns, meta.angle_deg, mean.d_mm),
        });
        if let Some((t_ns, d_mm)) = reading {
            self.last = self.settling.push(t_ns, d_mm);
        }
        self.good += usize::from(self.last.u_trend_mm().is_some());
        self.last
    }

    /// Why no value of the series is good; `None` where some are.
    pub(super) fn word(&self) -> Option<String> {
        let is_good = match self.turns {
            // the sizes over the turn are those of its end
            Some(_) => self.last.u_trend_mm().is_some(),
            None => self.good > 0,
        };
        if is_good {
            return None;
        }
        let why = self.last.why().unwrap_or_else(|| "it settled in no frame".to_owned());
        Some(format!("the diameter has not settled, nothing is proven: {why}"))
    }
}

/// The reading with what is left of a trend in its u.
pub(super) fn widened(reading: Reading, u_trend_mm: f64) -> Reading {
    match reading {
        Reading::Value(d) => Reading::Value(wider(d, u_trend_mm)),
        gap @ Reading::Gap(_) => gap,
    }
}

fn wider(d: Diameter, u_trend_mm: f64) -> Diameter {
    Diameter { u_common_mm: d.u_common_mm.hypot(u_trend_mm), ..d }
}

/// Takes what is left of a trend into the frame's diameters.
pub(super) fn widen(out: &mut Measurement, u_trend_mm: f64) {
    if let Some(largest) = &mut out.diameter {
        largest.widen(u_trend_mm);
    }
    for d in [&mut out.mean, &mut out.average].into_iter().flatten() {
        *d = wider(*d, u_trend_mm);
    }
}
