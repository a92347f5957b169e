//! Motion during the exposure: the edge's path, its mean, and its effect on the edge spread.
//!
//! The edge of a column moves across itself by
//!
//! ```text
//! s(t) = v·t + Σ A_k sin(2π f_k t + φ_k)
//! ```
//!
//! feed and carriage motion past a sloped edge (v), run-out (f = spindle), lobes (f = order ×
//! spindle), vibration. The image is the mean over the light's time: the edge at mean s̄ blurred by
//! the distribution of s - s̄. A steady motion is a box of variance (vT)²/12, many periods of a
//! vibration an arcsine of variance A²/2; cases in between are integrated over time. A strobe is an
//! exposure of its own, shorter and later.

#[cfg(test)]
use std::f64::consts::PI;
use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::{RenderError, within};
#[cfg(test)]
use crate::render::optics::edge_spread::EdgeSpread;
use crate::render::optics::edge_spread::Shifts;
use crate::render::optics::edge_spread::quadrature::{gauss_legendre, panels};

/// Nodes per panel of at most half a radian of the fastest motion: accurate to 1e-12 of its
/// amplitude.
const NODES: usize = 4;

/// Periods from which a sinusoid's phase no longer matters and the arcsine distribution is used.
#[cfg(test)]
const MANY_PERIODS: f64 = 64.0;

/// Periods up to which a vibration is integrated over time in a rendered exposure.
const FOLLOWED_PERIODS: f64 = 8.0;

/// Nodes of the arcsine.
const ARCSINE_NODES: usize = 48;

/// When light reaches the sensor: the exposure, or a flash within it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Strobe {
    /// From the start of exposure to the flash, µs.
    pub delay_us: f64,
    /// Length of the flash, µs.
    pub pulse_us: f64,
}

/// A sinusoidal motion of the shaft against the camera, up in the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vibration {
    /// Amplitude (half of peak to peak), µm.
    pub amplitude_um: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase at the start of exposure, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

impl Vibration {
    /// Height at a time after the start of exposure, µm.
    fn lift_um(&self, t_us: f64) -> f64 {
        self.amplitude_um * (TAU * self.frequency_hz * t_us * 1e-6 + self.phase_deg.to_radians()).sin()
    }
}

/// What moves during an exposure: the `[motion]` table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Motion {
    /// Speed of the spindle, rev/min; turns run-out and form past the camera.
    pub spindle_rpm: f64,
    /// Speed of the carriage along z, mm/s; moves sloped edges across themselves.
    pub carriage_mm_s: f64,
    /// Vibrations of the shaft against the camera.
    pub vibration: Vec<Vibration>,
    /// A flash; without it the light is on for the whole exposure.
    pub strobe: Option<Strobe>,
    /// Lets an exposure last longer than a turn of the spindle.
    pub allow_more_than_a_turn: bool,
}

/// The time during which light is collected, µs after the start of exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightTime {
    /// Start.
    pub start_us: f64,
    /// Duration.
    pub length_us: f64,
}

impl Motion {
    /// Checks every value against its range and the exposure.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right: a flash outside the exposure, light for
    /// longer than a revolution without consent.
    pub(crate) fn check(&self, exposure_us: f64) -> Result<(), RenderError> {
        within("camera.exposure_us", exposure_us, 1e-3, 1e7)?;
        within("motion.spindle_rpm", self.spindle_rpm, -1e6, 1e6)?;
        within("motion.carriage_mm_s", self.carriage_mm_s, -1e5, 1e5)?;
        for v in &self.vibration {
            within("motion.vibration.amplitude_um", v.amplitude_um, 0.0, 1e4)?;
            within("motion.vibration.frequency_hz", v.frequency_hz, 0.0, 1e7)?;
            within("motion.vibration.phase_deg", v.phase_deg, -1e6, 1e6)?;
        }
        if let Some(strobe) = self.strobe {
            within("motion.strobe.pulse_us", strobe.pulse_us, 1e-6, exposure_us)?;
            within("motion.strobe.delay_us", strobe.delay_us, 0.0, exposure_us - strobe.pulse_us)?;
        }
        let turns = self.light_time(exposure_us).length_us * 1e-6 * self.spindle_rpm.abs() / 60.0;
        if turns > 1.0 && !self.allow_more_than_a_turn {
            let right = "the light lasts longer than a turn: expose for less, strobe, or set motion.allow_more_than_a_turn = true";
            return Err(RenderError::setting(
                "motion.spindle_rpm",
                &format!("{turns:.2} turns an exposure"),
                right,
            ));
        }
        Ok(())
    }

    /// The time during which light is collected.
    pub(crate) fn light_time(&self, exposure_us: f64) -> LightTime {
        match self.strobe {
            Some(s) => LightTime { start_us: s.delay_us, length_us: s.pulse_us },
            None => LightTime { start_us: 0.0, length_us: exposure_us },
        }
    }

    /// Spindle angle and carriage position (degrees, mm past the start of exposure) at nodes over
    /// the light's time, with weights that add up to one: for outlines whose form turns through the
    /// edge faster than a sinusoid describes.
    #[cfg(test)]
    pub(crate) fn poses(&self, exposure_us: f64, nodes: usize) -> Vec<(f64, f64, f64)> {
        let time = self.light_time(exposure_us);
        let pose = |(x, w): (f64, f64)| {
            let t_s = (time.start_us + 0.5 * (x + 1.0) * time.length_us) * 1e-6;
            (6.0 * self.spindle_rpm * t_s, self.carriage_mm_s * t_s, 0.5 * w)
        };
        gauss_legendre(nodes.max(1)).into_iter().map(pose).collect()
    }

    /// Instants over the light's time at which the scene is evaluated, with weights that add up to
    /// one; a single one where nothing moves.
    ///
    /// Four Gauss nodes per two radians of the fastest motion, including a form of `undulations`
    /// per revolution; vibrations of more than 8 periods enter as arcsine distributions.
    pub(crate) fn instants(&self, exposure_us: f64, undulations: f64) -> Vec<Pose> {
        let time = self.light_time(exposure_us);
        let periods = |v: &Vibration| v.frequency_hz * time.length_us * 1e-6;
        let [fast, slow] = self.by_speed(exposure_us);
        let turns = self.spindle_rpm.abs() / 60.0 * time.length_us * 1e-6;
        let still = self.spindle_rpm == 0.0 && self.carriage_mm_s == 0.0 && slow.is_empty();
        let quickest =
            slow.iter().map(|v| TAU * periods(v)).fold(TAU * turns * undulations.max(1.0), f64::max);
        let rule = gauss_legendre(if still { 1 } else { NODES });
        let panel = time.length_us / (0.5 * quickest).ceil().max(1.0);
        let nodes = panels(time.start_us, time.start_us + time.length_us, &[], panel, &rule);
        let fast_lifts = fast
            .iter()
            .fold(Shifts::none(), |shifts, v| shifts.folded(&Shifts::arcsine(v.amplitude_um, ARCSINE_NODES)));
        let mut poses = Vec::new();
        for (t_us, weight) in nodes {
            let lift_um: f64 = slow.iter().map(|v| v.lift_um(t_us)).sum();
            for (more_um, share) in fast_lifts.iter() {
                poses.push(Pose {
                    t_us,
                    angle_deg: 6.0 * self.spindle_rpm * t_us * 1e-6,
                    z_mm: self.carriage_mm_s * t_us * 1e-6,
                    lift_mm: (lift_um + more_um) * 1e-3,
                    weight: weight / time.length_us * share,
                });
            }
        }
        poses
    }

    /// Vibrations with more periods in the light's time than are followed, and the others.
    fn by_speed(&self, exposure_us: f64) -> [Vec<Vibration>; 2] {
        let time = self.light_time(exposure_us);
        let periods = |v: &Vibration| v.frequency_hz * time.length_us * 1e-6;
        let moving = self.vibration.iter().filter(|v| v.amplitude_um > 0.0);
        let (fast, slow) = moving.partition(|v| periods(v) > FOLLOWED_PERIODS);
        [fast, slow]
    }

    /// The pose `later_us` after one of [`Self::instants`] with the same exposure: spindle,
    /// carriage and the vibrations that are followed have moved on.
    pub(crate) fn later(&self, pose: &Pose, exposure_us: f64, later_us: f64) -> Pose {
        let [_, slow] = self.by_speed(exposure_us);
        let t_us = pose.t_us + later_us;
        let moved_um: f64 = slow.iter().map(|v| v.lift_um(t_us) - v.lift_um(pose.t_us)).sum();
        Pose {
            t_us,
            angle_deg: pose.angle_deg + 6.0 * self.spindle_rpm * later_us * 1e-6,
            z_mm: pose.z_mm + self.carriage_mm_s * later_us * 1e-6,
            lift_mm: pose.lift_mm + moved_um * 1e-3,
            weight: pose.weight,
        }
    }

    /// Largest rate of the phase of what [`Self::later`] moves, rad/µs, with a form of
    /// `undulations` per revolution.
    pub(crate) fn quickest_rad_per_us(&self, exposure_us: f64, undulations: f64) -> f64 {
        let [_, slow] = self.by_speed(exposure_us);
        let spindle = TAU * self.spindle_rpm.abs() / 60.0 * undulations.max(1.0);
        slow.iter().map(|v| TAU * v.frequency_hz).fold(spindle, f64::max) * 1e-6
    }

    /// The path of an edge whose height changes by `slope` (dx/dz) along the shaft and that follows
    /// the sinusoids of `turning`, given per revolution of the spindle (run-out has 1 undulation,
    /// lobes their order).
    #[cfg(test)]
    pub(crate) fn path(&self, slope: f64, turning: &[Turning]) -> EdgePath {
        let mut waves: Vec<Wave> = self
            .vibration
            .iter()
            .map(|v| Wave {
                amplitude_um: v.amplitude_um,
                per_us: v.frequency_hz * 1e-6,
                phase_rad: v.phase_deg.to_radians(),
            })
            .collect();
        waves.extend(turning.iter().map(|t| Wave {
            amplitude_um: t.amplitude_um,
            per_us: t.undulations * self.spindle_rpm / 60.0 * 1e-6,
            phase_rad: t.phase_rad,
        }));
        // The carriage moves the camera by +v along z: at a fixed column the edge rises by v·dx/dz.
        EdgePath { um_per_us: self.carriage_mm_s * slope * 1e-3, waves }
    }
}

/// Positions of shaft and camera at an instant of an exposure, relative to its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// Time, µs.
    pub t_us: f64,
    /// Turn of the spindle, degrees.
    pub angle_deg: f64,
    /// Travel of the carriage along z, mm.
    pub z_mm: f64,
    /// The shaft's height by vibration, mm up in the image.
    pub lift_mm: f64,
    /// Share of the light.
    pub weight: f64,
}

/// A motion of the edge tied to the spindle: A·sin(k·φ + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg(test)]
pub(crate) struct Turning {
    /// Undulations per revolution.
    pub undulations: f64,
    /// Amplitude, µm.
    pub amplitude_um: f64,
    /// Phase at the start of exposure, radians.
    pub phase_rad: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg(test)]
struct Wave {
    amplitude_um: f64,
    /// Periods per µs.
    per_us: f64,
    phase_rad: f64,
}

/// The motion of an edge, µm up in the image over µs.
#[derive(Clone, Debug, PartialEq)]
#[cfg(test)]
pub(crate) struct EdgePath {
    um_per_us: f64,
    waves: Vec<Wave>,
}

#[cfg(test)]
impl EdgePath {
    /// Position at `t_us` after the start of exposure, µm.
    #[cfg(test)]
    pub(crate) fn at_um(&self, t_us: f64) -> f64 {
        let wave = |w: &Wave| w.amplitude_um * (TAU * w.per_us * t_us + w.phase_rad).sin();
        self.um_per_us * t_us + self.waves.iter().map(wave).sum::<f64>()
    }

    /// Mean position over the light's time, µm, which is that of the blurred edge. Closed form.
    #[cfg(test)]
    pub(crate) fn mean_um(&self, time: LightTime) -> f64 {
        let middle = time.start_us + 0.5 * time.length_us;
        let wave = |w: &Wave| {
            let half = PI * w.per_us * time.length_us;
            let sinc = if half.abs() < 1e-8 { 1.0 } else { half.sin() / half };
            w.amplitude_um * sinc * (TAU * w.per_us * middle + w.phase_rad).sin()
        };
        self.um_per_us * middle + self.waves.iter().map(wave).sum::<f64>()
    }

    /// Positions over the light's time with weights, µm.
    ///
    /// Waves of more than 64 periods enter as arcsine distributions; the others and the steady
    /// motion are integrated over time.
    #[cfg(test)]
    pub(crate) fn shifts(&self, time: LightTime) -> Shifts {
        let (fast, slow): (Vec<Wave>, Vec<Wave>) =
            self.waves.iter().partition(|w| (w.per_us * time.length_us).abs() > MANY_PERIODS);
        let quickest = slow.iter().map(|w| TAU * (w.per_us * time.length_us).abs()).fold(1.0, f64::max);
        let slow = Self { um_per_us: self.um_per_us, waves: slow };
        let end = time.start_us + time.length_us;
        let panel = 0.5 * time.length_us / quickest;
        let nodes = panels(time.start_us, end, &[], panel, &gauss_legendre(NODES));
        let followed = Shifts::new(nodes.into_iter().map(|(t, w)| (slow.at_um(t), w)).collect());
        fast.iter().fold(followed, |shifts, w| shifts.folded(&Shifts::arcsine(w.amplitude_um, ARCSINE_NODES)))
    }

    /// The edge spread of a moving upper edge about its mean position; a lower one takes
    /// [`Shifts::mirrored`].
    ///
    /// # Errors
    /// As [`EdgeSpread::tabulate`].
    #[cfg(test)]
    pub(crate) fn blurred(
        &self,
        edge: &EdgeSpread,
        time: LightTime,
        tolerance: f64,
    ) -> Result<EdgeSpread, RenderError> {
        edge.spread(&self.shifts(time).centred(), tolerance)
    }
}
