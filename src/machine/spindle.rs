//! Separation of the spindle's error motion from the form of what turns on it (ISO 230-7, annex on
//! error separation; Donaldson 1972, Whitehouse 1976).
//!
//! A displacement probe at the spindle angles φ_i reads m = p + s: p the form that passes it, s the
//! motion of the axis towards it. Readings are equally spaced over one turn, in any unit. Eccentric
//! chucking is the first order of p; it is left in.

use std::f64::consts::TAU;

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

/// The midline of a head that images both edges, read again with the part chucked 180° round: the
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

/// Weight of an order below which three probes hold nothing of it: rounding.
const LEAST_WEIGHT: f64 = 1e-9;

/// Three probes: form and motion, and the orders that no reading holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ThreeProbes {
    /// Form and the motion towards the first probe.
    pub separation: Separation,
    /// Orders of the form that are zero for want of a weight; the first, eccentricity, always.
    pub hidden: Vec<usize>,
}

/// Weights of the second and third probe that take every motion of the axis out of
/// m₁ + a·m₂ + b·m₃: 1 + a·cos α₂ + b·cos α₃ = a·sin α₂ + b·sin α₃ = 0. None for probes in line.
fn probe_weights(alpha: [f64; 2]) -> Option<[f64; 2]> {
    let between = (alpha[1] - alpha[0]).sin();
    (between.abs() > 1e-6).then(|| [-alpha[1].sin() / between, alpha[0].sin() / between])
}

/// The sum of the weights by the phases that an order has under the probes: [real, imaginary].
fn transfer(weights: [f64; 2], alpha: [f64; 2], order: usize) -> [f64; 2] {
    let phase = |k: usize| order as f64 * alpha[k];
    let sum = |of: fn(f64) -> f64| weights[0] * of(phase(0)) + weights[1] * of(phase(1));
    [1.0 + sum(f64::cos), sum(f64::sin)]
}

/// What of an order of the form the weighted sum of three probes holds: its noise is larger by
/// about the inverse. `steps` are the angles of the second and third probe to the first in readings
/// of which `readings` make a turn. None for probes in line.
pub(crate) fn three_probe_weights(steps: [usize; 2], readings: usize, order: usize) -> Option<f64> {
    let alpha = steps.map(|step| TAU * step as f64 / readings as f64);
    let [re, im] = transfer(probe_weights(alpha)?, alpha, order);
    Some(re.hypot(im))
}

/// Three probes around the part (Whitehouse 1976): m_k(φ) = p(φ + α_k) + s_x·cos α_k + s_y·sin α_k,
/// the first at α = 0, the others `steps` readings on. Their weighted sum is free of s; order by
/// order of a Fourier series it gives p, and m₁ − p the motion towards the first probe. Orders
/// whose weight is zero are in no reading and named. None for turns of different length or probes
/// in line.
pub(crate) fn three_probe(turns: [&[f64]; 3], steps: [usize; 2]) -> Option<ThreeProbes> {
    let count = turns[0].len();
    if count < 8 || turns.iter().any(|turn| turn.len() != count) {
        return None;
    }
    let alpha = steps.map(|step| TAU * step as f64 / count as f64);
    let weights = probe_weights(alpha)?;
    let sums: Vec<f64> =
        (0..count).map(|i| turns[0][i] + weights[0] * turns[1][i] + weights[1] * turns[2][i]).collect();
    // the mean of the sums has the weight 1 + a + b
    let whole = 1.0 + weights[0] + weights[1];
    let mean = sums.iter().sum::<f64>() / count as f64;
    let mut form = vec![if whole.abs() > LEAST_WEIGHT { mean / whole } else { 0.0 }; count];
    let mut hidden = Vec::new();
    for order in 1..count.div_ceil(2) {
        let [re, im] = transfer(weights, alpha, order);
        let square = re * re + im * im;
        if order == 1 || square.sqrt() < LEAST_WEIGHT {
            hidden.push(order);
            continue;
        }
        // M = P·W with p = Re(P·e^{inφ}): P = M·conj(W)/|W|²
        let angle = |i: usize| TAU * ((order * i) % count) as f64 / count as f64;
        let of = |part: fn(f64) -> f64| {
            2.0 / count as f64 * sums.iter().enumerate().map(|(i, m)| m * part(angle(i))).sum::<f64>()
        };
        let (a, b) = (of(f64::cos), -of(f64::sin));
        let (p, q) = ((a * re + b * im) / square, (b * re - a * im) / square);
        for (i, value) in form.iter_mut().enumerate() {
            *value += p * angle(i).cos() - q * angle(i).sin();
        }
    }
    let motion = turns[0].iter().zip(&form).map(|(m, p)| m - p).collect();
    Some(ThreeProbes { separation: Separation { form, motion }, hidden })
}
