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
        let why = match self.last {
            _ if is_good => return None,
            Settled::Untimed => "the frames have no times (t_ns in frames.csv)".to_owned(),
            Settled::Waiting { seen_s, readings } => {
                format!("{readings} readings over {seen_s:.1} s are too few")
            }
            Settled::Trend { um_per_min, u_um_per_min } => format!(
                "the diameter changes by {um_per_min:.2} um/min (u {u_um_per_min:.2} um/min): coolant that runs off, or a part \
                 that cools"
            ),
            Settled::Agrees { .. } => "it settled in no frame".to_owned(),
        };
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
