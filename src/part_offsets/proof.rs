//! Whether a trial cut proves sign and unit of an offset.
//!
//! A first part is cut without offsets, a second one with offsets that leave T = [`TRIAL_MM`] more
//! on the diameter. The mean change c over the stations, with its expanded uncertainty U (k = 2:
//! random parts of both scans, or the scatter of the stations if that is larger; common parts
//! cancel), must show it:
//!
//! ```text
//! proven       response_min ≤ (c − U)/T  and  (c + U)/T ≤ response_max
//! not proven   the interval reaches over a limit
//! refused      it lies outside: the factor f whose f·g·T lies next to c is named
//! ```
//!
//! with the limits of `control.guards` and the plant gain g of `control`. f = −1 is a wrong sign, 2
//! and ½ radius and diameter, 25.4 inches, 1000 micrometres, 0 an offset without effect. A tool
//! that stays clear of the blank leaves the diameter from before the pass, however large the
//! factor.

use super::state::{PartRead, TRIAL_MM};
use crate::control::ControlSettings;

/// Result of a trial cut.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Proof {
    /// Proven, with the ratio of observed to commanded change.
    Proven(f64),
    /// Not proven, and why.
    NotProven(String),
    /// Refused: the likely cause.
    Refused {
        /// The ratio of observed to commanded change.
        ratio: f64,
        /// Why, in words.
        why: String,
    },
}

/// Factors by which an offset may act, and what each would be.
const CAUSES: [(f64, &str); 11] = [
    (-1.0, "the sign is wrong: the part became smaller"),
    (2.0, "factor 2: a diameter is taken as a radius"),
    (0.5, "factor 1/2: a radius is taken as a diameter"),
    (0.0, "the offset had no effect: it went to another register, tool or path, or is not active"),
    (1.0 / 25.4, "factor 1/25.4: millimetres are taken as inches, or the reverse"),
    (1e-3, "factor 1/1000: millimetres are taken as micrometres"),
    (25.4, "factor 25.4: millimetres are taken as inches"),
    (1e3, "factor 1000: micrometres are taken as millimetres"),
    (-2.0, "the sign is wrong, and a diameter is taken as a radius"),
    (-0.5, "the sign is wrong, and a radius is taken as a diameter"),
    (-25.4, "the sign is wrong, and millimetres are taken as inches"),
];
/// Share of the stations that must have a reading in both scans: fewer are no part.
const LEAST_SHARE: f64 = 0.8;
/// Coverage factor of U.
const COVERAGE: f64 = 2.0;
/// By so much two parts of one command may differ, mm: the repeatability of a lathe, which no scan
/// of one part shows. It is allowed for when a cause is named, not when a trial cut is proven.
const PART_TO_PART_MM: f64 = 0.002;

/// A mean change and its expanded uncertainty, mm.
struct Change {
    mean_mm: f64,
    expanded_mm: f64,
    /// (index of the station, change, standard uncertainty)
    stations: Vec<(usize, f64, f64)>,
}

fn change(first: &PartRead, trial: &PartRead) -> Option<Change> {
    let pairs = first.readings.iter().zip(&trial.readings).enumerate();
    let stations: Vec<(usize, f64, f64)> = pairs
        .filter_map(|(i, (a, b))| {
            let (a, b) = (a.value()?, b.value()?);
            Some((i, b.d_mm - a.d_mm, a.u_random_mm.hypot(b.u_random_mm)))
        })
        .collect();
    let n = stations.len() as f64;
    if stations.len() < 2 || n < LEAST_SHARE * first.readings.len() as f64 {
        return None;
    }
    let mean_mm = stations.iter().map(|s| s.1).sum::<f64>() / n;
    let stated = stations.iter().map(|s| s.2 * s.2).sum::<f64>().sqrt() / n;
    let square: f64 = stations.iter().map(|s| (s.1 - mean_mm).powi(2)).sum();
    let scattered = (square / (n - 1.0) / n).sqrt();
    Some(Change { mean_mm, expanded_mm: COVERAGE * stated.max(scattered), stations })
}

/// Judges a trial cut against the part before it. `before_mm` is the diameter before the pass.
pub(super) fn prove(
    control: &ControlSettings,
    before_mm: f64,
    z_mm: &[f64],
    (first, trial): (&PartRead, &PartRead),
) -> Proof {
    let Some(change) = change(first, trial) else {
        return Proof::NotProven(format!(
            "too few of {} stations have a reading in both parts, the first and the trial cut",
            first.readings.len()
        ));
    };
    let (least, most) = (control.guards.response_min, control.guards.response_max);
    let (c, expanded) = (change.mean_mm, change.expanded_mm);
    let (low, high) = ((c - expanded) / TRIAL_MM, (c + expanded) / TRIAL_MM);
    let found = format!(
        "the diameter changed by {:+.2} µm ± {:.2} µm (k = 2) where {:+.0} µm were commanded",
        1e3 * c,
        1e3 * expanded,
        1e3 * TRIAL_MM
    );
    if high < least || low > most {
        let ratio = c / TRIAL_MM;
        return Proof::Refused {
            ratio,
            why: format!("{found}: {}", cause(control, before_mm, first, &change)),
        };
    }
    if low < least || high > most {
        return Proof::NotProven(format!(
            "{found}; {:.0} to {:.0} µm would prove it",
            1e3 * (least * TRIAL_MM + expanded),
            1e3 * (most * TRIAL_MM - expanded)
        ));
    }
    // the offset must act everywhere, not in the mean alone
    let outside = |(_, c, u): &&(usize, f64, f64)| {
        let widened = COVERAGE * u / TRIAL_MM;
        !(least - widened..=most + widened).contains(&(c / TRIAL_MM))
    };
    match change.stations.iter().find(outside) {
        Some((i, c, _)) => Proof::NotProven(format!(
            "{found} in the mean, but by {:+.2} µm at z = {} mm: the offset does not act alike along the part",
            1e3 * c,
            z_mm.get(*i).copied().unwrap_or(f64::NAN)
        )),
        None => Proof::Proven(c / TRIAL_MM),
    }
}

/// The causes that fit the change, in words.
fn cause(control: &ControlSettings, before_mm: f64, first: &PartRead, change: &Change) -> String {
    let (c, expanded) = (change.mean_mm, change.expanded_mm + PART_TO_PART_MM);
    let read: Vec<f64> = first.readings.iter().filter_map(|r| r.d_mm).collect();
    let uncut_mm = before_mm - read.iter().sum::<f64>() / read.len().max(1) as f64;
    let (least, most) = (control.guards.response_min, control.guards.response_max);
    if (c - uncut_mm).abs() <= expanded + (1.0 - least) * TRIAL_MM && uncut_mm > most * TRIAL_MM {
        return format!(
            "the part has its diameter from before the pass, {before_mm} mm: nothing was cut. The offset acts by a factor of {:.1} \
             or more: millimetres taken as inches (25.4) or micrometres as millimetres (1000)",
            uncut_mm / TRIAL_MM
        );
    }
    let fits = |factor: f64| {
        let (a, b) = (factor * least * TRIAL_MM, factor * most * TRIAL_MM);
        (a.min(b) - expanded..=a.max(b) + expanded).contains(&c)
    };
    let mut named: Vec<(f64, &str)> = CAUSES.into_iter().filter(|(factor, _)| fits(*factor)).collect();
    let off = |factor: f64| (c - factor * control.plant_gain * TRIAL_MM).abs();
    named.sort_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    // a factor whose effect lies within this of the nearest one cannot be separated from it
    let nearest = named.first().map_or(0.0, |n| off(n.0));
    named.retain(|n| off(n.0) <= nearest + expanded);
    match named[..] {
        [] => format!("a factor of {:.2} is none that a sign or a unit explains", c / TRIAL_MM),
        _ => named.iter().map(|n| n.1).collect::<Vec<_>>().join("; or "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part_offsets::state::StationRead;

    fn part(d_mm: impl Fn(usize) -> Option<f64>, u_random_mm: f64) -> PartRead {
        let read = |i: usize| StationRead {
            offset_mm: 0.0,
            d_mm: d_mm(i),
            u_random_mm: Some(u_random_mm),
            u_common_mm: Some(0.001),
        };
        let readings = (0..10).map(read).collect();
        PartRead { measurement: 1, part: String::new(), trial: false, images: Vec::new(), readings }
    }

    fn judged(change_mm: impl Fn(usize) -> f64, u_mm: f64) -> Proof {
        let z: Vec<f64> = (0..10).map(|i| 5.0 * i as f64).collect();
        let first = part(|i| Some(11.0 + 0.001 * i as f64), u_mm);
        let trial = part(|i| Some(11.0 + 0.001 * i as f64 + change_mm(i)), u_mm);
        prove(&ControlSettings::default(), 11.5, &z, (&first, &trial))
    }

    fn why(change_mm: f64) -> String {
        match judged(|_| change_mm, 2e-4) {
            Proof::Refused { why, .. } => why,
            other => panic!("{change_mm}: {other:?}"),
        }
    }

    #[test]
    fn fifty_micrometres_more_prove_sign_and_unit() {
        for g in [0.9, 0.95, 1.0] {
            let Proof::Proven(ratio) = judged(|_| g * TRIAL_MM, 2e-4) else { panic!("{g}") };
            assert!((ratio - g).abs() < 1e-9);
        }
    }

    #[test]
    fn every_slip_is_refused_by_its_name() {
        for (factor, word) in [
            (-1.0, "sign is wrong: the part became smaller"),
            (2.0, "as a radius"),
            (0.5, "radius is taken as a diameter"),
            (0.0, "no effect"),
            (1.0 / 25.4, "1/25.4"),
            (25.4, "nothing was cut"),
            (1000.0, "nothing was cut"),
            (-2.0, "the sign is wrong, and a diameter"),
        ] {
            // above the blank there is no diameter
            let change = (factor * 0.95 * TRIAL_MM).min(0.4955);
            let said = why(change);
            assert!(said.contains(word), "{factor}: {said}");
        }
        assert!(why(0.19).contains("none that a sign"), "{}", why(0.19));
    }

    #[test]
    fn what_u_or_gaps_leave_open_is_not_proven() {
        assert!(matches!(judged(|_| 0.0475, 0.03), Proof::NotProven(_)));
        let z = [0.0; 10];
        let first = part(|_| Some(11.0), 2e-4);
        let gaps = part(|i| (i < 5).then_some(11.0475), 2e-4);
        let control = ControlSettings::default();
        let Proof::NotProven(text) = prove(&control, 11.5, &z, (&first, &gaps)) else { panic!("gaps") };
        assert!(text.contains("too few"), "{text}");
        // half the part did not move
        let Proof::NotProven(text) = judged(|i| if i == 3 { 0.0 } else { 0.0475 }, 2e-4) else {
            panic!("a place that did not move")
        };
        assert!(text.contains("z = 15"), "{text}");
    }
}
