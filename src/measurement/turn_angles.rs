//! The angles of a revolution: which its frames cover, and what the exposure took from its lobes.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::frame::FrameMeta;
use crate::position::{AngleCover, Uncovered, attenuation, corrected_amplitude_mm, u_uncorrected_mm};

/// Most places along z whose angles are kept apart; a camera that travels while the part turns has
/// more, and its angles are taken together: 8 MB of them.
const MOST_PLACES: usize = 4096;
/// Places closer than this are one, mm: what a carriage returns to.
const SAME_PLACE_MM: f64 = 0.01;

/// Angles seen at every place, and the largest sweep.
#[derive(Clone, Debug, Default)]
pub(super) struct TurnAngles {
    places: BTreeMap<i64, AngleCover>,
    /// Whether there are too many places to be kept apart.
    together: bool,
    pub(super) sweep_deg: f64,
}

/// Angles that the diameters at a place cover.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Machine z of the frames, mm; `None` where more places than can be kept apart are taken
    /// together.
    pub z_mm: Option<f64>,
    /// What is not covered.
    #[serde(flatten)]
    pub uncovered: Uncovered,
}

impl TurnAngles {
    /// A frame that shows diameters.
    pub(super) fn add(&mut self, meta: &FrameMeta) {
        self.sweep_deg = self.sweep_deg.max(meta.sweep_deg.abs());
        let place = if self.together { 0 } else { (meta.z_mm / SAME_PLACE_MM).round() as i64 };
        self.places.entry(place).or_default().add(meta.angle_deg);
        if self.places.len() > MOST_PLACES {
            let mut all = AngleCover::default();
            self.places.values().for_each(|cover| all.join(cover));
            (self.places, self.together) = (BTreeMap::from([(0, all)]), true);
        }
    }

    /// What every place leaves out.
    pub(super) fn coverage(&self) -> Vec<Coverage> {
        let of = |(place, cover): (&i64, &AngleCover)| Coverage {
            z_mm: (!self.together).then_some(*place as f64 * SAME_PLACE_MM),
            uncovered: cover.uncovered(),
        };
        self.places.iter().map(of).collect()
    }
}

/// What the exposure took from the lobes of a section.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Smear {
    /// Angle turned during the exposure, degrees.
    pub sweep_deg: f64,
    /// Most lobes whose amplitude is given back; of more, the exposure leaves less than half.
    pub corrected_to_lobes: usize,
    /// Amplitudes of the part, mm, from those that the exposure left: (lobes, mm).
    pub corrected_mm: Vec<(usize, f64)>,
    /// Standard uncertainty of local sizes (GN, GX, two-point) and roundness by the lobes that are
    /// not given back to them, mm.
    pub u_mm: f64,
}

impl Smear {
    /// Of measured harmonics (lobes, amplitude in mm).
    pub(super) fn of(harmonics: impl Iterator<Item = (usize, f64)>, sweep_deg: f64) -> Self {
        let sweep = sweep_deg.to_radians();
        let (mut corrected_mm, mut squares, mut most) = (Vec::new(), 0.0, 0);
        // k = 1 is the eccentricity, which no size holds
        for (lobes, measured_mm) in harmonics.filter(|(lobes, _)| *lobes > 1) {
            let k = u32::try_from(lobes).unwrap_or(u32::MAX);
            let restored = corrected_amplitude_mm(k, measured_mm, sweep);
            if let Some(amplitude_mm) = restored {
                corrected_mm.push((lobes, amplitude_mm));
                most = most.max(lobes);
            }
            // both edges of a diameter
            let amplitude_mm = restored.unwrap_or(measured_mm / attenuation(k, sweep).abs().max(0.1));
            squares += (2.0 * u_uncorrected_mm(k, amplitude_mm, sweep)).powi(2);
        }
        Self { sweep_deg, corrected_to_lobes: most, corrected_mm, u_mm: squares.sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_apart_until_they_are_too_many() {
        let frame = |z_mm: f64, angle_deg: f64| FrameMeta { z_mm, angle_deg, ..FrameMeta::default() };
        let mut angles = TurnAngles::default();
        (0..18).for_each(|i| angles.add(&frame(0.0, 10.0 * f64::from(i))));
        (0..15).for_each(|i| angles.add(&frame(5.0, 10.0 * f64::from(i))));
        let found = angles.coverage();
        assert_eq!(found[0].uncovered.uncovered_deg, []);
        assert_eq!(
            (found[1].z_mm, found[1].uncovered.uncovered_deg.clone()),
            (Some(5.0), vec![(140.0, 180.0)])
        );
        (0..=MOST_PLACES).for_each(|i| angles.add(&frame(i as f64, 0.0)));
        assert_eq!(angles.coverage().len(), 1);
        assert_eq!(angles.coverage()[0].z_mm, None);
    }

    #[test]
    fn lobes_are_given_back_and_the_rest_is_in_u() {
        let sweep = 7.2_f64;
        let left = attenuation(3, sweep.to_radians());
        let smear = Smear::of([(1, 0.02), (3, 0.005 * left), (50, 1e-4)].into_iter(), sweep);
        assert_eq!(smear.corrected_to_lobes, 3);
        assert!((smear.corrected_mm[0].1 - 0.005).abs() < 1e-12 && smear.corrected_mm.len() == 1);
        // 2·5 µm·(1 − .9941)/√3, and fifty lobes of which next to nothing is left
        let three = 2.0 * 0.005 * (1.0 - left) / 3.0_f64.sqrt();
        assert!(smear.u_mm > three && smear.u_mm < 2e-3, "{}", smear.u_mm);
    }
}
