//! How fast frames come, and how long they take.

use std::collections::VecDeque;

/// Frames that the quantiles are of: the 99th percentile of a thousand is its tenth largest, which
/// one slow frame does not decide.
const LATENCIES: usize = 1000;
/// Times that the rate is of: some tens of frames follow a change within a second or two.
const TIMES: usize = 32;

/// Rate and latency of the last frames.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pace {
    latency_ms: VecDeque<f64>,
    times_s: VecDeque<f64>,
}

fn push(window: &mut VecDeque<f64>, value: f64, most: usize) {
    if window.len() == most {
        window.pop_front();
    }
    window.push_back(value);
}

impl Pace {
    /// A frame measured at `t_s`, `latency_ms` after this machine had it, where that is known.
    pub(crate) fn push(&mut self, t_s: f64, latency_ms: Option<f64>) {
        push(&mut self.times_s, t_s, TIMES);
        if let Some(latency_ms) = latency_ms {
            push(&mut self.latency_ms, latency_ms, LATENCIES);
        }
    }

    /// Frames a second over the last ones; `None` before the second frame.
    pub(crate) fn rate_hz(&self) -> Option<f64> {
        let time = self.times_s.back()? - self.times_s.front()?;
        (time > 0.0).then(|| (self.times_s.len() - 1) as f64 / time)
    }

    /// Latency in ms that this share of the last frames does not exceed (nearest rank).
    pub(crate) fn latency_ms(&self, share: f64) -> Option<f64> {
        let mut sorted: Vec<f64> = self.latency_ms.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.max(1) - 1).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_the_nearest_ranks_of_the_last_thousand() {
        let mut pace = Pace::default();
        assert_eq!((pace.latency_ms(0.5), pace.rate_hz()), (None, None));
        // 1..=1000 in another order (7 has no factor with 1000), after a thousand that are gone.
        (0..1000).for_each(|k| pace.push(f64::from(k), Some(1e6)));
        (0..1000).for_each(|k| pace.push(1000.0 + 0.02 * f64::from(k), Some(f64::from(7 * k % 1000 + 1))));
        assert_eq!([0.5, 0.99, 1.0, 0.0].map(|p| pace.latency_ms(p)), [500.0, 990.0, 1000.0, 1.0].map(Some));
        assert!((pace.rate_hz().unwrap() - 50.0).abs() < 1e-6);
    }
}
