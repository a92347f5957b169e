//! From touches to one diameter per station.

use super::calibration::ProbeCalibration;
use super::pairs::{Pair, mean_and_scatter};
use super::pretravel::Pretravel;
use super::settings::{ProbeSettings, Sides};
use crate::profile::{Diameter, DiameterProfile, Reading, Reason, Station};

/// A station whose variance exceeds the pooled one by more than this factor keeps its own: with one
/// degree of freedom one good station in 1900 does, fewer with more.
const FAR: f64 = 12.0;
/// Median of χ² of one degree of freedom over its mean: the worst case, of fewest angles.
const MEDIAN_OF_ONE: f64 = 0.455;
/// Degrees of freedom from which Student's t is the normal distribution to a thousandth of u at 95
/// %.
const MANY_FREEDOM: f64 = 1000.0;

/// Diameters at 20 °C of the stations whose `count` pairs each follow one another, z ascending.
///
/// The scatter of a station's angles (form, texture, the touches themselves) is pooled over the
/// stations and gives the random part; the contributions of calibration, temperature, height,
/// yielding and, from one side, axis, guideway and drift are common.
pub(crate) fn profile(
    settings: &ProbeSettings,
    calibration: &ProbeCalibration,
    pairs: &[Pair],
    count: usize,
    pass: u32,
) -> DiameterProfile {
    let found: Vec<Option<(f64, f64, usize)>> = pairs
        .chunks(count.max(1))
        .map(|station| {
            let read: Vec<f64> = station.iter().filter_map(|p| p.read_mm).collect();
            // an angle that is missing would leave the even lobes in the mean
            mean_and_scatter(&read).filter(|_| read.len() == count).map(|(m, v)| (m, v, read.len()))
        })
        .collect();
    let pooled = pooled(&found);
    let stations = pairs.chunks(count.max(1)).zip(&found).map(|(station, found)| {
        let z_mm = station[0].z_mm;
        let Some((read, variance, n)) = *found else {
            return Station { z_mm, reading: Reading::Gap(Reason::NotScanned), freedom: None };
        };
        let own = variance > FAR * pooled.0;
        let (variance, freedom) = if own { (variance, n as f64 - 1.0) } else { pooled };
        let scatter = variance.max(2.0 * settings.touch_variance_mm2()) / n as f64;
        let d_mm = corrected(settings, calibration, read);
        let diameter = Diameter {
            d_mm,
            u_random_mm: scatter.sqrt(),
            u_common_mm: u_common(settings, calibration, d_mm),
        };
        // Welch-Satterthwaite (GUM G.4.1)
        let freedom = Some(freedom * (diameter.u_mm().powi(2) / scatter).powi(2));
        Station { z_mm, reading: Reading::Value(diameter), freedom: freedom.filter(|f| *f < MANY_FREEDOM) }
    });
    DiameterProfile { pass, stations: stations.collect() }
}

/// Variance of one two-point diameter over the stations without those that scatter far more, and
/// its degrees of freedom.
fn pooled(found: &[Option<(f64, f64, usize)>]) -> (f64, f64) {
    let mut all: Vec<(f64, f64)> = found.iter().flatten().map(|f| (f.1, f.2 as f64 - 1.0)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((median, _)) = all.get(all.len() / 2) else { return (0.0, 0.0) };
    let limit = FAR * median / MEDIAN_OF_ONE;
    let kept = || all.iter().filter(|f| f.0 <= limit);
    let freedom: f64 = kept().map(|f| f.1).sum();
    (kept().map(|f| f.0 * f.1).sum::<f64>() / freedom.max(1.0), freedom)
}

/// Largest yield of the part under the touch, where it is softest, mm of diameter.
fn yields_mm(settings: &ProbeSettings) -> f64 {
    let force = Pretravel::new(settings).force_n([1.0, 0.0, 0.0]);
    2e-3 * settings.part_yield_um_per_n * force
}

/// A two-point diameter, corrected and at 20 °C, mm; half of the largest yield is added.
pub(crate) fn corrected(settings: &ProbeSettings, calibration: &ProbeCalibration, read_mm: f64) -> f64 {
    let t = &settings.temperature;
    let grown = 1.0 + 1e-6 * t.expansion_um_per_m_k * (t.part_c - 20.0);
    (read_mm - calibration.probe_correction_mm + 0.5 * yields_mm(settings)) / grown
}

/// A master's diameter, corrected and at 20 °C, mm.
pub(crate) fn of_master(settings: &ProbeSettings, calibration: &ProbeCalibration, read_mm: f64) -> f64 {
    let t = &settings.temperature;
    let grown = 1.0 + 1e-6 * t.expansion_um_per_m_k * (t.master_c - 20.0);
    (read_mm - calibration.probe_correction_mm) / grown
}

/// Standard uncertainty common to all stations, mm.
fn u_common(settings: &ProbeSettings, calibration: &ProbeCalibration, d_mm: f64) -> f64 {
    common_parts(settings, calibration, d_mm).iter().fold(0.0, |u: f64, part| u.hypot(part.1))
}

/// Sources of the common uncertainty of a diameter near `d_mm`, each with its standard uncertainty,
/// mm.
pub(crate) fn common_parts(
    settings: &ProbeSettings,
    calibration: &ProbeCalibration,
    d_mm: f64,
) -> [(&'static str, f64); 7] {
    let s = settings;
    let warm = d_mm * 1e-6 * s.temperature.expansion_um_per_m_k * s.temperature.u_k;
    // a ball y beside the axis reads √((R + ρ)² − y²): y²/2·(1/(R + ρ) − 1/(R' + ρ)) less than on a
    // master, twice; the mean of y⁴ is 3u⁴
    let reach = |d: f64| 1.0 / (0.5 * (d + s.ball_mm));
    let height =
        3.0_f64.sqrt() * (1e-3 * s.u_height_um).powi(2) * (reach(d_mm) - reach(calibration.master_mm));
    // a rectangle of half width yields/2 (GUM 4.3.7)
    let softness = 0.5 * yields_mm(s) / 3.0_f64.sqrt();
    let one_side = match s.sides {
        Sides::One => 2e-3,
        Sides::Two => 0.0,
    };
    [
        ("calibration on the masters", calibration.u_correction_mm),
        ("temperature of the part", warm),
        ("height of the ball beside the axis", height.abs()),
        ("yielding of the part to the touch", softness),
        ("axis of the part", one_side * s.u_axis_um),
        ("guideway between master and part", one_side * s.u_guideway_um),
        ("drift of X since the calibration", one_side * s.u_drift_um),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe::pairs::{orders, pairs};
    use crate::probe::touch::{Touch, TouchOrder};

    fn calibration() -> ProbeCalibration {
        ProbeCalibration {
            probe_correction_mm: 5.99,
            u_correction_mm: 3e-4,
            master_mm: 25.0,
            largest_residual_mm: 0.0,
        }
    }

    /// Two stations of three pairs with known scatter.
    fn two(read: [[Option<f64>; 3]; 2]) -> Vec<Pair> {
        let pair = |z: usize, i: usize| Pair {
            z_mm: 10.0 * (z as f64 + 1.0),
            angle_deg: 60.0 * i as f64,
            id: 0,
            t_ns: 0,
            read_mm: read[z][i],
        };
        (0..2).flat_map(|z| (0..3).map(move |i| pair(z, i))).collect()
    }

    #[test]
    fn the_budget_is_the_sum_of_its_parts() {
        let s = ProbeSettings { part_yield_um_per_n: 0.1, ..ProbeSettings::default() };
        let read = two([[Some(30.99), Some(30.992), Some(30.988)], [Some(30.98), Some(30.983), Some(30.98)]]);
        let found = profile(&s, &calibration(), &read, 3, 2);
        let d = found.stations[0].reading.value().unwrap();
        // 2·.1 µm/N·5.5 N at most, half of it taken
        let yields = 1.1e-3;
        assert!((d.d_mm - (25.0 + 0.5 * yields)).abs() < 1e-12, "{d:?}");
        let (a, b) = (4e-6, 3e-6);
        assert!((d.u_random_mm - (0.5 * (a + b) / 3.0_f64).sqrt()).abs() < 1e-12, "{d:?}");
        let warm = d.d_mm * 11.5e-6 * 0.5;
        let one_side = 4e-6 * 3.0 * 0.09;
        let square = 9e-8 + warm * warm + (0.5 * yields).powi(2) / 3.0 + one_side;
        assert!((d.u_common_mm - f64::sqrt(square)).abs() < 1e-8, "{} {}", d.u_common_mm, square.sqrt());
        // from both sides neither axis nor guideway nor drift counts
        let both = ProbeSettings { sides: Sides::Two, ..s };
        let less = profile(&both, &calibration(), &read, 3, 2).stations[0].reading.value().unwrap();
        assert!((d.u_common_mm.powi(2) - less.u_common_mm.powi(2) - one_side).abs() < 1e-12);
    }

    #[test]
    fn a_missing_touch_is_a_gap_and_a_warm_part_is_taken_to_20_degrees() {
        let mut s = ProbeSettings::default();
        s.temperature.part_c = 25.0;
        let read = two([[Some(30.99), None, Some(30.99)], [Some(30.99), Some(30.991), Some(30.989)]]);
        let found = profile(&s, &calibration(), &read, 3, 1);
        assert_eq!(found.stations[0].reading, Reading::Gap(Reason::NotScanned));
        let d = found.stations[1].reading.value().unwrap();
        assert!((d.d_mm - 25.0 / (1.0 + 57.5e-6)).abs() < 1e-9, "{d:?}");
    }

    #[test]
    fn orders_pair_up_to_two_points() {
        let s = ProbeSettings::default();
        let one = orders(&s, &[5.0, 9.0], 2, 25.0);
        let angles: Vec<f64> = one.iter().map(|o| o.angle_deg).collect();
        assert_eq!(angles, [0.0, 180.0, 90.0, 270.0, 0.0, 180.0, 90.0, 270.0]);
        let two = orders(&ProbeSettings { sides: Sides::Two, ..s }, &[5.0], 2, 25.0);
        assert_eq!(two.iter().map(|o| o.side.sign()).collect::<Vec<_>>(), [1.0, -1.0, 1.0, -1.0]);
        // an axis that is off by a: both distances show it with opposite signs
        let touch = |order: &TouchOrder| Touch {
            order: *order,
            id: 1,
            t_ns: 0,
            x_mm: Some(order.side.sign() * 15.5 + 0.2),
        };
        let read = pairs(&two.iter().map(touch).collect::<Vec<_>>());
        assert!(read.iter().all(|p| (p.read_mm.unwrap() - 31.0).abs() < 1e-12));
    }
}
