//! Separation of the spindle's error motion from the form of what turns on it (ISO 230-7, annex on
//! error separation; Donaldson 1972, Whitehouse 1976).
//!
//! A displacement probe at the spindle angles φ_i reads m = p + s: p the form that passes it, s the
//! motion of the axis towards it. Readings are equally spaced over one turn, in any unit. Eccentric
//! chucking is the first order of p; it is left in.

/// Form and motion at the angles of the readings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Separation {
    /// The form that passes the probe.
    pub form: Vec<f64>,
    /// Motion of the axis towards the probe.
    pub motion: Vec<f64>,
}

/// Half the sum and half the difference of two turns.
fn halves(first: &[f64], second: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let alike = first.len() == second.len() && !first.is_empty();
    let half = |sign: f64| first.iter().zip(second).map(|(a, b)| 0.5 * (a + sign * b)).collect();
    alike.then(|| (half(1.0), half(-1.0)))
}

/// Donaldson's reversal: the artefact turned by 180° on the spindle and the probe moved to the
/// opposite side read m₂ = p − s. All orders are separated; either result has 1/√2 of the probe's
/// random error. None for turns of different length.
pub(crate) fn donaldson(first: &[f64], reversed: &[f64]) -> Option<Separation> {
    let (form, motion) = halves(first, reversed)?;
    Some(Separation { form, motion })
}

/// The midline of a head that sees both edges, read again with the part chucked 180° round: the
/// midline holds the motion and the odd lobes alone (even ones move both edges apart), and the
/// second time the odd lobes come with the other sign. The form that returns is its odd part. With
/// the random error σ of an edge the midline has σ/√2 and either result σ/2. None for turns of
/// different length.
pub(crate) fn rechucked(midline: &[f64], turned: &[f64]) -> Option<Separation> {
    let (motion, form) = halves(midline, turned)?;
    Some(Separation { form, motion })
}

/// Multi-step: row j is read with the artefact turned by j/N of a turn on the spindle:
/// m_j(φ) = p(φ + j·2π/N) + s(φ). Means over the rows, along φ and along the artefact, separate all
/// orders but the multiples of N, which stay in both. None unless N ≥ 2 rows of one length divide a
/// turn.
pub(crate) fn multi_step(rows: &[Vec<f64>]) -> Option<Separation> {
    let (steps, count) = (rows.len(), rows.first()?.len());
    let whole = steps >= 2 && count > 0 && count.is_multiple_of(steps);
    if !whole || rows.iter().any(|row| row.len() != count) {
        return None;
    }
    // Every mean holds both means of the turn: the form keeps it, the motion is free of it.
    let all = rows.iter().flatten().sum::<f64>() / (steps * count) as f64;
    let mean = |at: &dyn Fn(usize) -> usize| {
        rows.iter().enumerate().map(|(j, row)| row[at(j)]).sum::<f64>() / steps as f64
    };
    let motion = (0..count).map(|i| mean(&|_| i) - all).collect();
    let form = (0..count).map(|i| mean(&|j| (i + count - j * count / steps) % count)).collect();
    Some(Separation { form, motion })
}
