//! A count or a carriage position between latched samples.

/// A latched sample of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When, ns.
    pub t_ns: u64,
    /// Count, or position in mm.
    pub value: f64,
}

/// The value at `t_ns` on the line between the samples before and after, with half the second
/// difference of the neighbouring samples as the limit of its error: what a constant acceleration
/// leaves of a line is at most an eighth of it. Samples rise in time.
///
/// # Errors
/// A time that is not between two samples, or a gap of more than `longest_ns` about it: a value
/// beyond the samples is not made up.
pub fn interpolated(samples: &[Sample], t_ns: u64, longest_ns: u64) -> Result<(f64, f64), String> {
    let after = samples.partition_point(|s| s.t_ns < t_ns);
    if let Some(exact) = samples.get(after).filter(|s| s.t_ns == t_ns) {
        return Ok((exact.value, 0.0));
    }
    let pair = after.checked_sub(1).and_then(|before| samples.get(before).zip(samples.get(after)));
    let Some((a, b)) = pair else {
        return Err(format!("{t_ns} ns lies before the first or after the last latched sample"));
    };
    let gap_ns = b.t_ns - a.t_ns;
    if gap_ns > longest_ns {
        return Err(format!("no sample was latched for {gap_ns} ns about {t_ns} ns, {longest_ns} at most"));
    }
    let share = (t_ns - a.t_ns) as f64 / gap_ns as f64;
    let neighbours = [after.checked_sub(2).and_then(|i| samples.get(i)), samples.get(after + 1)];
    let slope = |p: &Sample, q: &Sample| (q.value - p.value) / (q.t_ns - p.t_ns).max(1) as f64;
    let own = slope(a, b);
    let bends = neighbours.into_iter().flatten().map(|n| {
        let other = if n.t_ns < a.t_ns { slope(n, a) } else { slope(b, n) };
        (other - own).abs() * gap_ns as f64
    });
    Ok((a.value + share * (b.value - a.value), 0.125 * bends.fold(0.0, f64::max)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_acceleration_stays_within_its_limit() {
        // 1 mm/s², sampled every 10 ms from 0.2 mm/s on
        let at = |t_ns: u64| {
            let t = 1e-9 * t_ns as f64;
            0.2 * t + 0.5 * t * t
        };
        let samples: Vec<Sample> =
            (0..20).map(|i| Sample { t_ns: i * 10_000_000, value: at(i * 10_000_000) }).collect();
        for t_ns in (15_000_000..180_000_000).step_by(1_234_567) {
            let (value, limit) = interpolated(&samples, t_ns, 20_000_000).unwrap();
            assert!((value - at(t_ns)).abs() <= limit * (1.0 + 1e-6) && limit < 2e-5, "{t_ns}: {value}");
        }
        assert_eq!(interpolated(&samples, 50_000_000, 1).unwrap(), (at(50_000_000), 0.0));
        for (t_ns, longest, word) in
            [(195_000_000, 20_000_000, "after the last"), (55_000_000, 5_000_000, "no sample")]
        {
            assert!(interpolated(&samples, t_ns, longest).unwrap_err().contains(word));
        }
    }
}
