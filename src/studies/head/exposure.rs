//! Exposure against speed: how long light may be collected while the part turns.
//!
//! | what moves | path in T | limit |
//! |---|---|---|
//! | run-out, eccentricity e | e·ω·T at most | its rms as a box, e·ω·T/√12, at most a share of u |
//! | feed along z | v_f·T | a pixel: what is finer is lost along z |
//! | lobes, n a revolution | n·ω·T of their phase | amplitude loss 1 − sin(x)/x at most given, x =
//! n·ω·T/2 |
//!
//! The first is strict: both edges of one exposure run out alike, so that the diameter itself keeps
//! its value and only sharpness is lost. `motion` computes what that does to the diameter at the
//! speed asked for. Light goes with the exposure: a shorter one needs as many times more of it for
//! the same grey level.

use std::f64::consts::TAU;

use serde::Serialize;

use super::settings::ExposureLimits;
use super::setup::HeadSetup;

/// Speeds of the table, rev/min: turning of large and of small parts, grinding.
const SPEEDS_RPM: [f64; 6] = [100.0, 300.0, 1000.0, 3000.0, 10_000.0, 30_000.0];

/// What limits an exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ExposureEnd {
    /// Blur by run-out.
    RunOut,
    /// Travel along z.
    Feed,
    /// Loss of lobes.
    Lobes,
}

/// The longest exposure at a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct ExposureAtSpeed {
    /// Speed, rev/min.
    pub rpm: f64,
    /// Longest exposure by run-out, µs.
    pub run_out_us: f64,
    /// Longest exposure by feed, µs.
    pub feed_us: f64,
    /// Longest exposure by lobes, µs.
    pub lobes_us: f64,
    /// The shortest of them, µs.
    pub longest_us: f64,
    /// Which of them it is.
    pub limited_by: ExposureEnd,
    /// Grey level of the bright field at the longest exposure, at most the configured one, counts.
    pub grey_counts: f64,
    /// Contrast over noise there.
    pub snr: f64,
    /// How many times more light the configured grey level needs at the longest exposure; 1 where
    /// the configured exposure is short enough.
    pub light_factor: f64,
}

/// Longest exposures over the speeds of the table and those of the comparison.
pub(super) fn exposures(
    head: &HeadSetup,
    u_um: f64,
    limits: &ExposureLimits,
    asked_rpm: &[f64],
) -> Vec<ExposureAtSpeed> {
    let mut speeds: Vec<f64> = SPEEDS_RPM.iter().chain(asked_rpm).copied().filter(|rpm| *rpm > 0.0).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    speeds.into_iter().map(|rpm| at_speed(head, u_um, limits, rpm)).collect()
}

fn at_speed(head: &HeadSetup, u_um: f64, limits: &ExposureLimits, rpm: f64) -> ExposureAtSpeed {
    let turning = &head.turning;
    let run_out_us = run_out_us(limits.share_of_u * u_um, 1e3 * turning.eccentricity_mm, rpm);
    let feed_us = 1e6 * head.optics.pixel_mm / (turning.feed_mm_per_rev * rpm / 60.0);
    let lobes_us = lobes_us(limits.undulations_upr, limits.amplitude_loss, rpm);
    let all =
        [(run_out_us, ExposureEnd::RunOut), (feed_us, ExposureEnd::Feed), (lobes_us, ExposureEnd::Lobes)];
    let (longest_us, limited_by) =
        all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((lobes_us, ExposureEnd::Lobes));
    let light_factor = (turning.exposure_us / longest_us).max(1.0);
    let levels = head.levels.with_light(light_factor.recip());
    ExposureAtSpeed {
        rpm,
        run_out_us,
        feed_us,
        lobes_us,
        longest_us,
        limited_by,
        grey_counts: levels.light,
        snr: levels.snr(),
        light_factor,
    }
}

/// Radians a second.
fn omega(rpm: f64) -> f64 {
    TAU * rpm / 60.0
}

/// The exposure in which the fastest point of an eccentric path makes a box of standard deviation
/// `blur_um`, µs; infinite without eccentricity.
fn run_out_us(blur_um: f64, eccentricity_um: f64, rpm: f64) -> f64 {
    1e6 * 12.0_f64.sqrt() * blur_um / (eccentricity_um * omega(rpm))
}

/// The path of the fastest point of an eccentric part in an exposure, µm: at most its diameter.
pub(super) fn path_um(eccentricity_mm: f64, rpm: f64, exposure_us: f64) -> f64 {
    let half_angle = (0.5 * omega(rpm) * 1e-6 * exposure_us).min(0.25 * TAU);
    2e3 * eccentricity_mm * half_angle.sin()
}

/// Amplitude of a sinusoid that passes by `phase` radians in the exposure, lost: 1 − sin(x)/x, x
/// half of it.
pub(super) fn amplitude_loss(phase: f64) -> f64 {
    let x = 0.5 * phase;
    if x.abs() < 1e-4 { x * x / 6.0 } else { 1.0 - x.sin() / x }
}

/// Phase by which `undulations` a revolution pass in an exposure, radians.
pub(super) fn phase(undulations: f64, rpm: f64, exposure_us: f64) -> f64 {
    undulations * omega(rpm) * 1e-6 * exposure_us
}

/// The exposure in which the amplitude of lobes is lost by a share, µs: by halving, as the loss
/// rises up to a whole period.
fn lobes_us(undulations: f64, loss: f64, rpm: f64) -> f64 {
    let (mut low, mut high) = (0.0, TAU);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if amplitude_loss(middle) < loss { low = middle } else { high = middle }
    }
    1e6 * low / (undulations * omega(rpm))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of a sinusoid over the exposure, by 20 000 instants of it.
    #[test]
    fn the_exposure_of_lobes_loses_what_is_allowed() {
        for (upr, loss, rpm) in [(15.0, 0.01, 1000.0), (50.0, 0.1, 300.0), (2.0, 0.5, 30_000.0)] {
            let exposure_s = 1e-6 * lobes_us(upr, loss, rpm);
            let n = 20_000;
            let instant = |i: i32| ((f64::from(i) + 0.5) / f64::from(n) - 0.5) * exposure_s;
            let mean = (0..n).map(|i| (upr * omega(rpm) * instant(i)).cos()).sum::<f64>() / f64::from(n);
            assert!((mean - (1.0 - loss)).abs() < 1e-7, "{upr}: {mean}");
        }
    }

    /// The variance of the places of an edge on its path: e·ω·T/√12 where the path is short.
    #[test]
    fn the_exposure_of_run_out_blurs_by_what_is_allowed() {
        let (blur_um, e_um, rpm) = (0.2, 30.0, 1500.0);
        let exposure_s = 1e-6 * run_out_us(blur_um, e_um, rpm);
        let n = 10_000;
        let places: Vec<f64> = (0..n)
            .map(|i| e_um * (omega(rpm) * ((f64::from(i) + 0.5) / f64::from(n) - 0.5) * exposure_s).sin())
            .collect();
        let square = places.iter().map(|p| p * p).sum::<f64>() / f64::from(n);
        assert!((square.sqrt() / blur_um - 1.0).abs() < 1e-3, "{}", square.sqrt());
        let path = places[n as usize - 1] - places[0];
        assert!((path_um(1e-3 * e_um, rpm, 1e6 * exposure_s) / path - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_path_is_never_longer_than_the_circle_is_wide() {
        assert!((path_um(0.05, 6000.0, 1e6) - 100.0).abs() < 1e-9);
    }
}
