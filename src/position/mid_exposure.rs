//! Angles that were latched at the start of exposure, moved to its middle.
//!
//! ```text
//! φ_mid = φ + ω·T/2,   ω = (φ_k − φ_{k−1} + 360°·n)/(t_k − t_{k−1})
//! ```
//!
//! n whole turns between two frames by the speed that the head states; without one the shorter way,
//! which holds where less than half a turn lies between two frames. Where the speed is not known an
//! angle stays as it was latched.

/// Longest time between two frames from which a speed is taken, ns: over more of it a spindle may
/// have stopped and gone on.
const LONGEST_NS: u64 = 1_000_000_000;

/// Angles of consecutive frames of a spindle.
#[derive(Clone, Copy, Debug, Default)]
pub struct MidExposure {
    last: Option<(f64, u64)>,
    /// The last speed, degrees a ns.
    speed: Option<f64>,
}

/// An angle at mid-exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// Angle that the spindle turned during the exposure, degrees; `None` where its speed is not
    /// known, and the angle is that at the start of exposure.
    pub sweep_deg: Option<f64>,
    /// Standard uncertainty of the angle by the change of speed from the last pair of frames,
    /// degrees; `None` where that is not known: of a first speed, and of one that is stated alone.
    pub u_deg: Option<f64>,
}

impl MidExposure {
    /// The next frame's angle at the start of its exposure, degrees, with its start, ns, and
    /// exposure time, µs, where they are known, and the speed that the head states, degrees a
    /// second.
    pub fn push(
        &mut self,
        angle_deg: f64,
        t_ns: Option<u64>,
        exposure_us: Option<f64>,
        stated_deg_per_s: Option<f64>,
    ) -> Moved {
        let stated = stated_deg_per_s.map(|speed| 1e-9 * speed);
        let measured = t_ns.and_then(|t_ns| self.measured(angle_deg, t_ns, stated));
        let before = self.speed;
        self.last = t_ns.map(|t_ns| (angle_deg, t_ns));
        self.speed = measured;
        let Some((speed, exposure_us)) = measured.or(stated).zip(exposure_us) else {
            return Moved { angle_deg, sweep_deg: None, u_deg: None };
        };
        let exposure_ns = 1e3 * exposure_us;
        // the speed is that half a period earlier: its change since is the limit of its error
        let change = measured.zip(before).map(|(now, before)| (now - before).abs());
        Moved {
            angle_deg: (angle_deg + 0.5 * exposure_ns * speed).rem_euclid(360.0),
            sweep_deg: Some(speed * exposure_ns),
            u_deg: change.map(|change| 0.5 * exposure_ns * change / 3.0_f64.sqrt()),
        }
    }

    /// The speed since the last frame, degrees a ns.
    fn measured(&self, angle_deg: f64, t_ns: u64, stated: Option<f64>) -> Option<f64> {
        // a spindle that is stated to stand is set from angle to angle between the frames
        let (last_deg, last_ns) = self.last.filter(|_| stated != Some(0.0))?;
        let time_ns = t_ns.checked_sub(last_ns).filter(|ns| (1..=LONGEST_NS).contains(ns))? as f64;
        let step_deg = shorter_way_deg(last_deg, angle_deg);
        let turns = stated.map_or(0.0, |speed| ((speed * time_ns - step_deg) / 360.0).round());
        Some((step_deg + 360.0 * turns) / time_ns)
    }
}

/// The step from one angle to another by the shorter way, above -180 to 180 degrees.
pub fn shorter_way_deg(from_deg: f64, to_deg: f64) -> f64 {
    180.0 - (180.0 - (to_deg - from_deg)).rem_euclid(360.0)
}

#[cfg(test)]
mod tests {
    use super::super::smear::attenuation;
    use super::*;

    const PERIOD_NS: u64 = 3_125_000;

    /// Angle at a time of a spindle that turns by `rpm`, degrees.
    fn at_deg(rpm: f64, t_ns: f64) -> f64 {
        (31.0 + 6e-9 * rpm * t_ns).rem_euclid(360.0)
    }

    #[test]
    fn the_phase_of_three_lobes_is_right_in_both_directions_and_their_loss_is_known() {
        for rpm in [600.0, -600.0] {
            let mut spindle = MidExposure::default();
            let (mut c, mut s, mut n) = (0.0, 0.0, 0.0);
            // the first one has no speed: two whole turns are left
            for k in 0..65_u64 {
                let t_ns = 1_000_000 + k * PERIOD_NS;
                let moved = spindle.push(at_deg(rpm, t_ns as f64), Some(t_ns), Some(2000.0), None);
                let Some(sweep_deg) = moved.sweep_deg else {
                    assert!(k == 0, "{k}");
                    continue;
                };
                assert!((sweep_deg - rpm.signum() * 7.2).abs() < 1e-6, "{moved:?}");
                assert!(
                    if k == 1 { moved.u_deg.is_none() } else { moved.u_deg.unwrap() < 1e-6 },
                    "{moved:?}"
                );
                let shown = |i: u32| {
                    let t = t_ns as f64 + 2e6 * (f64::from(i) + 0.5) / 500.0;
                    0.005 * (3.0 * (at_deg(rpm, t) - 17.0)).to_radians().cos()
                };
                let mean = (0..500).map(shown).sum::<f64>() / 500.0;
                let (sin, cos) = (3.0 * moved.angle_deg).to_radians().sin_cos();
                (c, s, n) = (c + mean * cos, s + mean * sin, n + 1.0);
            }
            let phase = f64::atan2(s, c).to_degrees() / 3.0;
            assert!((phase - 17.0).abs() < 0.2, "{rpm}: {phase}");
            let left = 2.0 * f64::hypot(c, s) / n / 0.005;
            assert!((left - attenuation(3, 7.2_f64.to_radians())).abs() < 2e-3, "{left}");
        }
    }

    #[test]
    fn whole_turns_between_frames_are_those_of_the_stated_speed() {
        // 9000/min and 20 frames a second: seven and a half turns from frame to frame
        let mut spindle = MidExposure::default();
        for k in 0..5_u64 {
            let t_ns = k * 50_000_000;
            let moved = spindle.push(at_deg(9003.0, t_ns as f64), Some(t_ns), Some(100.0), Some(54_000.0));
            let due = if k == 0 { 9000.0 } else { 9003.0 };
            assert!((moved.sweep_deg.unwrap() - 6e-4 * due).abs() < 1e-6, "{k} {moved:?}");
        }
        // a spindle that stands is set to angles, and nothing is moved
        let mut set = MidExposure::default();
        for k in 0..3_u64 {
            let moved = set.push(30.0 * k as f64, Some(k * 1_000_000), Some(100.0), Some(0.0));
            assert_eq!((moved.angle_deg, moved.sweep_deg), (30.0 * k as f64, Some(0.0)));
        }
    }

    #[test]
    fn what_is_not_known_is_left_and_a_change_of_speed_is_in_u() {
        let mut spindle = MidExposure::default();
        let of =
            |spindle: &mut MidExposure, deg, ms: u64, us| spindle.push(deg, Some(ms * 1_000_000), us, None);
        assert_eq!(of(&mut spindle, 10.0, 0, Some(1000.0)).sweep_deg, None);
        assert_eq!(of(&mut spindle, 20.0, 10, None).sweep_deg, None);
        // 1°/ms then 2°/ms: half a ms of a change by 1°/ms as a limit
        let faster = of(&mut spindle, 40.0, 20, Some(1000.0));
        assert!(
            (faster.u_deg.unwrap() - 0.5 / 3.0_f64.sqrt()).abs() < 1e-9
                && (faster.angle_deg - 41.0).abs() < 1e-9
        );
        // a pause of more than a second, and a clock that is set back
        assert_eq!(of(&mut spindle, 50.0, 2000, Some(1000.0)).sweep_deg, None);
        assert_eq!(of(&mut spindle, 60.0, 1500, Some(1000.0)).sweep_deg, None);
        assert_eq!(spindle.push(60.0, None, Some(1000.0), None).angle_deg, 60.0);
        assert!((shorter_way_deg(350.0, 10.0) - 20.0).abs() < 1e-12);
        assert!((shorter_way_deg(10.0, 350.0) + 20.0).abs() < 1e-12);
        assert_eq!((shorter_way_deg(0.0, 180.0), shorter_way_deg(180.0, 0.0)), (180.0, 180.0));
    }
}
