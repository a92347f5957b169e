//! Plausibility against what was measured before: earlier revolutions of the same part, and the
//! pass before.
//!
//! A station is refused where it departs from what was expected by more than both
//!
//! ```text
//! k·√(u_now² + u_before²)        random uncertainties: the common one is the same then and now
//! limit                          what the process can do meanwhile
//! ```
//!
//! Between revolutions nothing is cut: a caliper diameter is the same one half a revolution later,
//! except for thermal expansion. Between passes it falls by the change of the command, except for a
//! change of the shaft's deflection.

use std::collections::BTreeMap;

use serde::Serialize;

use super::column_diameters::{ColumnDiameter, ColumnDiameters};
use crate::frame::FrameMeta;
use crate::gauge::limit::limits;
pub(crate) use crate::gauge::settings::PlausibilitySettings;
use crate::profile::{Diameter, DiameterProfile, Reading, Reason};

limits! {
    /// When departures are those of single stations.
    PlausibilityLimits = "plausibility";
    /// Share of a profile's stations above which departures are not those of single stations: then
    /// the whole part, or the machine, did not do what was commanded, which gaps would hide from
    /// control's guards. Tuned: see study limits.
    most_refused: f64 = 0.25;
}

/// A reading that contradicts an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Jump {
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Spindle angle of a revolution's frame, degrees; none for a pass.
    pub angle_deg: Option<f64>,
    /// Diameter less what was expected, mm.
    pub jump_mm: f64,
    /// What would have been accepted, mm.
    pub limit_mm: f64,
}

impl std::fmt::Display for Jump {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the diameter at z = {:.2} mm", self.z_mm)?;
        if let Some(angle) = self.angle_deg {
            write!(f, ", {angle:.2} deg")?;
        }
        let (jump, limit) = (1e3 * self.jump_mm, 1e3 * self.limit_mm);
        write!(f, " is {jump:+.2} µm off what was measured before, limit {limit:.2} µm")
    }
}

/// The jump between two readings, if it is one.
fn jump(now: Diameter, expected: Diameter, coverage: f64, limit_mm: f64) -> Option<(f64, f64)> {
    let limit = (coverage * now.u_random_mm.hypot(expected.u_random_mm)).max(limit_mm);
    let by = now.d_mm - expected.d_mm;
    // A diameter that is no number is not accepted either.
    (!(by.abs() <= limit)).then_some((by, limit))
}

/// Diameters of earlier revolutions at every stretch and angle.
#[derive(Clone, Debug)]
pub(crate) struct TurnHistory {
    settings: PlausibilitySettings,
    stretch_mm: f64,
    /// By angle (mod 180°) in microdegrees and stretch: the mean so far, and of how many turns.
    known: BTreeMap<(i64, i64), (Diameter, f64)>,
}

impl TurnHistory {
    /// Without a reference yet; stretches of this length along z are compared, mm.
    pub(crate) fn new(settings: &PlausibilitySettings, stretch_mm: f64) -> Self {
        Self { settings: *settings, stretch_mm, known: BTreeMap::new() }
    }

    /// Compares a frame's diameters with those of the same angle in earlier revolutions. Stretches
    /// that jump become gaps ([`Reason::Implausible`]); the others become the reference of the next
    /// revolution.
    pub(crate) fn check(&mut self, meta: &FrameMeta, diameters: &mut ColumnDiameters) -> Vec<Jump> {
        let mut jumps = Vec::new();
        let angle = (meta.angle_deg.rem_euclid(180.0) * 1e6).round() as i64 % 180_000_000;
        let mut from = 0;
        while from < diameters.columns.len() {
            let stretch = self.stretch(diameters.z_mm(meta, from));
            let mut to = from + 1;
            while to < diameters.columns.len() && self.stretch(diameters.z_mm(meta, to)) == stretch {
                to += 1;
            }
            if let Some(now) = diameters.mean(from..to).value() {
                match self.judge((angle, stretch), now) {
                    None => {}
                    Some((jump_mm, limit_mm)) => {
                        let z_mm = 0.5 * (diameters.z_mm(meta, from) + diameters.z_mm(meta, to - 1));
                        jumps.push(Jump { z_mm, angle_deg: Some(meta.angle_deg), jump_mm, limit_mm });
                        refuse(diameters, from..to);
                    }
                }
            }
            from = to;
        }
        jumps
    }

    fn stretch(&self, z_mm: f64) -> i64 {
        (z_mm / self.stretch_mm).floor() as i64
    }

    fn judge(&mut self, place: (i64, i64), now: Diameter) -> Option<(f64, f64)> {
        let Some((mean, turns)) = self.known.get_mut(&place) else {
            self.known.insert(place, (now, 1.0));
            return None;
        };
        let found = jump(now, *mean, self.settings.coverage, self.settings.turn_limit_mm);
        if found.is_none() {
            let weight = 1.0 / (*turns + 1.0);
            mean.d_mm += weight * (now.d_mm - mean.d_mm);
            mean.u_random_mm = ((1.0 - weight) * mean.u_random_mm).hypot(weight * now.u_random_mm);
            *turns += 1.0;
        }
        found
    }
}

fn refuse(diameters: &mut ColumnDiameters, columns: std::ops::Range<usize>) {
    for column in &mut diameters.columns[columns] {
        if column.reading.value().is_some() {
            *column = ColumnDiameter::gap(Reason::Implausible);
        }
    }
}

/// Compares a pass with the one before: `fall_mm` is by how much every station was commanded
/// smaller. Stations that jump become gaps, unless more than a quarter of them do: then nothing is
/// refused here, and the jumps are given with `false`.
pub(crate) fn against_pass(
    settings: &PlausibilitySettings,
    before: &DiameterProfile,
    fall_mm: &[f64],
    now: &mut DiameterProfile,
) -> (Vec<Jump>, bool) {
    let limits = PlausibilityLimits::get();
    let mut found = Vec::new();
    let mut compared = 0;
    let stations = now.stations.iter().zip(&before.stations).zip(fall_mm).enumerate();
    for (index, ((station, earlier), fall)) in stations {
        let (Some(d), Some(was)) = (station.reading.value(), earlier.reading.value()) else { continue };
        compared += 1;
        let expected = Diameter { d_mm: was.d_mm - fall, ..was };
        if let Some((jump_mm, limit_mm)) = jump(d, expected, settings.coverage, settings.pass_limit_mm) {
            found.push((index, Jump { z_mm: station.z_mm, angle_deg: None, jump_mm, limit_mm }));
        }
    }
    let theirs = found.len() as f64 <= limits.most_refused * f64::from(compared);
    if theirs {
        found.iter().for_each(|(index, _)| now.stations[*index].reading = Reading::Gap(Reason::Implausible));
    }
    (found.into_iter().map(|(_, jump)| jump).collect(), theirs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Station;

    fn columns(d: impl Fn(usize) -> f64) -> ColumnDiameters {
        let value = |d_mm| Reading::Value(Diameter { d_mm, u_random_mm: 1e-4, u_common_mm: 1e-3 });
        let column = |c| ColumnDiameter {
            reading: value(d(c)),
            shared_mm: 0.0,
            width_px: 1000.0,
            middle_mm: 0.0,
            u_middle_common_mm: 0.0,
        };
        ColumnDiameters { columns: (0..100).map(column).collect(), shared_length: 1.0, pitch_mm: 0.1 }
    }

    fn meta(angle_deg: f64) -> FrameMeta {
        FrameMeta { angle_deg, z_mm: 4.95, ..FrameMeta::default() }
    }

    #[test]
    fn a_stretch_that_jumps_against_an_earlier_turn_is_a_gap_and_teaches_nothing() {
        let mut history = TurnHistory::new(&PlausibilitySettings::default(), 1.0);
        for turn in 0..3 {
            // Oval by 40 µm: other angles may differ; heat adds 2 µm a revolution.
            for step in 0..4 {
                let angle = 360.0 * f64::from(turn) + 45.0 * f64::from(step);
                let d = 25.0 + 0.02 * (2.0 * angle.to_radians()).cos() + 2e-3 * f64::from(turn);
                assert!(history.check(&meta(angle), &mut columns(|_| d)).is_empty());
            }
        }
        for turn in 3..5 {
            let chip = |c: usize| 25.02 + 4e-3 + if (30..40).contains(&c) { 0.012 } else { 0.0 };
            // Half a revolution on is the same caliper.
            let mut seen = columns(chip);
            let jumps = history.check(&meta(360.0 * f64::from(turn) + 180.0), &mut seen);
            assert_eq!(jumps.len(), 1, "{jumps:?}");
            assert!((jumps[0].z_mm - 3.45).abs() < 1e-9 && (jumps[0].jump_mm - 0.0135).abs() < 1.6e-3);
            assert_eq!(jumps[0].limit_mm, 0.005);
            assert_eq!(seen.mean(30..40), Reading::Gap(Reason::Implausible));
            assert!(seen.columns[35].width_px.is_nan() && seen.columns[29].reading.value().is_some());
        }
        // Noise alone is no jump, however small the limit.
        let small = PlausibilitySettings { turn_limit_mm: 1e-6, ..PlausibilitySettings::default() };
        let mut history = TurnHistory::new(&small, 1.0);
        assert!(history.check(&meta(0.0), &mut columns(|_| 25.0)).is_empty());
        assert!(history.check(&meta(0.0), &mut columns(|_| 25.000_1)).is_empty());
        assert_eq!(history.check(&meta(0.0), &mut columns(|_| 25.000_5)).len(), 10);
    }

    fn profile(pass: u32, d: impl Fn(usize) -> f64) -> DiameterProfile {
        let reading = |d_mm| Reading::Value(Diameter { d_mm, u_random_mm: 2e-4, u_common_mm: 1e-3 });
        let stations = (0..20)
            .map(|k| Station { z_mm: 5.0 * k as f64, reading: reading(d(k)), freedom: None })
            .collect();
        DiameterProfile { pass, stations }
    }

    #[test]
    fn a_station_that_did_not_follow_the_command_is_a_gap_and_a_part_that_did_not_is_left_to_control() {
        let settings = PlausibilitySettings::default();
        let barrel = |k: usize| 0.04 * (1.0 - ((k as f64 - 9.5) / 9.5).powi(2));
        let before = profile(1, |k| 26.5 + barrel(k));
        let fall: Vec<f64> = (0..20).map(|k| 0.5 + barrel(k)).collect();
        let mut good = profile(2, |k| 26.0 + 0.1 * barrel(k));
        assert_eq!(against_pass(&settings, &before, &fall, &mut good), (Vec::new(), true));
        let mut one = profile(2, |k| if k == 7 { 26.08 } else { 26.0 });
        let (jumps, theirs) = against_pass(&settings, &before, &fall, &mut one);
        assert!(theirs && jumps.len() == 1 && (jumps[0].jump_mm - 0.08).abs() < 1e-9);
        assert_eq!(one.stations[7].reading, Reading::Gap(Reason::Implausible));
        assert!(jumps[0].to_string().contains("z = 35.00 mm is +80.00 µm"));
        // The tool did not cut: every station is as it was.
        let mut all = profile(2, |k| 26.5 + barrel(k));
        let (jumps, theirs) = against_pass(&settings, &before, &fall, &mut all);
        assert!(!theirs && jumps.len() == 20 && all.stations.iter().all(|s| s.reading.value().is_some()));
        // A gap is no reference for the next pass.
        let mut wide = profile(3, |_| 25.0);
        let (jumps, _) = against_pass(&settings, &one, &[0.5; 20], &mut wide);
        assert!(jumps.iter().all(|j| j.z_mm != 35.0));
    }

    #[test]
    fn limits_out_of_range_are_named() {
        let wrong = PlausibilitySettings { turn_limit_mm: f64::NAN, ..PlausibilitySettings::default() };
        assert_eq!(wrong.validate().unwrap_err().key, "gauge.plausibility.turn_limit_mm");
    }
}
