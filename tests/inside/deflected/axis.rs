//! The axis of a bent, eccentric shaft from its frames, against the lines of its deflection.

use shadowgauge::gauge::axis_line::{AxisAverager, AxisLine};
use shadowgauge::shaft::{AxisKnot, Bow, Deflection, Eccentricity, Shaft, ShaftForm};

use crate::inside::deflected::setup::{Case, Head, Measured};

pub const CASE: Case = Case {
    diameter_mm: 8.0,
    length_mm: 60.0,
    station_mm: 5.0,
    rows: 672,
    columns: 1280,
    fields: 4,
    angles: 6,
    whole_turn: false,
    field_step: 1,
};

/// Error allowed in addition to U, mm.
const LIMIT_MM: f64 = 1e-4;

fn axis(head: &Head, frames: &[Measured]) -> AxisLine {
    let zero = head.calibration.axis_zero(f64::from(head.case.rows));
    let mut averager = AxisAverager::new(head.case.stations(), head.case.station_mm, zero);
    frames.iter().for_each(|f| averager.add(&f.meta, &f.columns));
    averager.finish()
}

/// Mean offset of an axis given by knots over a station, mm along x and y.
fn mean_offset(knots: &[AxisKnot], z_mm: f64, station_mm: f64) -> [f64; 2] {
    const SLICES: u32 = 500;
    let at = |z: f64| {
        let i = knots.partition_point(|k| k.z_mm <= z).clamp(1, knots.len() - 1);
        let (a, b) = (&knots[i - 1], &knots[i]);
        let share = (z - a.z_mm) / (b.z_mm - a.z_mm);
        [a.x_mm + share * (b.x_mm - a.x_mm), a.y_mm + share * (b.y_mm - a.y_mm)]
    };
    let slices =
        (0..SLICES).map(|k| at(z_mm + station_mm * ((f64::from(k) + 0.5) / f64::from(SLICES) - 0.5)));
    slices.fold([0.0; 2], |sum, p| [sum[0] + p[0] / f64::from(SLICES), sum[1] + p[1] / f64::from(SLICES)])
}

/// Turns a shaft in the machine by `degrees` from y towards x, so that the camera views it from
/// another direction.
fn seen_from(shaft: &Shaft, degrees: f64) -> Shaft {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turned = |k: &AxisKnot| AxisKnot {
        z_mm: k.z_mm,
        x_mm: k.x_mm * cos + k.y_mm * sin,
        y_mm: k.y_mm * cos - k.x_mm * sin,
    };
    let mut other = shaft.clone();
    other.deflection = shaft.deflection.iter().map(turned).collect();
    other.bow = shaft.bow.iter().map(turned).collect();
    other.eccentricity.phase_deg -= degrees;
    other
}

fn form() -> ShaftForm {
    ShaftForm {
        deflection: Deflection { sagitta_x_mm: -0.23, sagitta_y_mm: 0.31 },
        bow: Bow { sagitta_mm: 0.06, phase_deg: 70.0 },
        eccentricity: Eccentricity { amplitude_mm: 0.08, phase_deg: -35.0 },
        ..ShaftForm::default()
    }
}

#[test]
fn the_axis_is_found_along_z_and_what_turns_of_it_in_both_planes() {
    let (mut square, mut n) = ([0.0; 3], 0.0);
    for seed in [5, 6] {
        let head = Head::new(CASE, seed);
        let shaft = head.shaft(&form());
        let seen = axis(&head, &head.scan(&shaft));
        assert!(seen.stations.len() == 12 && seen.gaps.is_empty());
        let second = axis(&head, &head.scan(&seen_from(&shaft, 90.0)));
        let still = seen.seen_from(&second, 90.0);
        for (s, y) in seen.stations.iter().zip(&still) {
            let [x_mm, y_mm] = mean_offset(&shaft.deflection, s.z_mm, CASE.station_mm);
            let bow = mean_offset(&shaft.bow, s.z_mm, CASE.station_mm);
            let (sin, cos) = shaft.eccentricity.phase_deg.to_radians().sin_cos();
            let a = shaft.eccentricity.amplitude_mm * cos + bow[0];
            let b = shaft.eccentricity.amplitude_mm * sin + bow[1];
            let t = s.turning.unwrap();
            let errors = [
                (s.x_mm - x_mm, s.u_mm()),
                (t.x_mm - a, t.u_mm),
                (t.y_mm - b, t.u_mm),
                (y.y_mm - y_mm, y.u_mm),
            ];
            for (error, u) in errors {
                assert!(error.abs() < LIMIT_MM + 2.0 * u, "z {}: {errors:?}", s.z_mm);
            }
            for (sum, (error, u)) in square.iter_mut().zip(errors) {
                *sum += (error / u).powi(2);
            }
            n += 1.0;
        }
    }
    let rms = square.map(|s: f64| (s / n).sqrt());
    println!("rms error over u: still {:.2}, turning {:.2} and {:.2}", rms[0], rms[1], rms[2]);
    assert!(rms.iter().all(|r| *r < 1.4) && rms.iter().any(|r| *r > 0.4), "{rms:?}");
}
