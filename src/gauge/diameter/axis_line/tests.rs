//! The axis along z: still and turning parts, lobes, overlapping fields, a second view.

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::*;
use crate::gauge::diameter::column_diameters::ColumnDiameter;
use crate::profile::Diameter;

/// A frame of 2.55 mm whose middles lie at one height.
fn flat(middle: f64) -> ColumnDiameters {
    let column = ColumnDiameter {
        reading: Reading::Value(Diameter { d_mm: 20.0, u_random_mm: 2e-5, u_common_mm: 0.0 }),
        shared_mm: 0.0,
        width_px: 1.0,
        middle_mm: middle,
        u_middle_common_mm: 1e-6,
    };
    ColumnDiameters { columns: vec![column; 51], shared_length: 1.0, pitch_mm: 0.05 }
}

/// A scan whose axis stands at x(z) and turns about it by (a, b), with noise of one station and
/// angle.
fn line(angles: &[f64], x: impl Fn(f64) -> f64, turning: (f64, f64), noise: f64, seed: u64) -> AxisLine {
    let stations: Vec<f64> = (0..60).map(|k| 2.5 + 5.0 * f64::from(k)).collect();
    let mut averager = AxisAverager::new(stations.clone(), 5.0, AxisZero { height_mm: -7.0, u_scale: 0.0 });
    let mut rng = Pcg64::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise).unwrap();
    for z_mm in stations {
        for angle_deg in angles {
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let middle = -7.0 + x(z_mm) + turning.0 * cos - turning.1 * sin + normal.sample(&mut rng);
            let meta = FrameMeta { angle_deg: *angle_deg, z_mm, ..FrameMeta::default() };
            averager.add(&meta, &flat(middle));
        }
    }
    averager.finish()
}

#[test]
fn still_and_turning_parts_are_told_apart_and_u_is_what_they_scatter_by() {
    let sag = |z: f64| -0.2 * (z / 300.0 * std::f64::consts::PI).sin();
    let half: Vec<f64> = (0..8).map(|k| 22.5 * f64::from(k)).collect();
    let whole: Vec<f64> = (0..4).map(|k| 90.0 * f64::from(k)).collect();
    for (angles, noise) in [(&half, 3e-5), (&whole, 3e-5), (&half, 1e-6)] {
        let (mut square, mut turned, mut n) = (0.0, 0.0, 0.0);
        for seed in 0..20 {
            for s in line(angles, sag, (0.03, -0.05), noise, seed).stations {
                let t = s.turning.unwrap();
                square += ((s.x_mm - sag(s.z_mm)) / s.u_random_mm).powi(2);
                turned += 0.5 * (((t.x_mm - 0.03) / t.u_mm).powi(2) + ((t.y_mm + 0.05) / t.u_mm).powi(2));
                n += 1.0;
            }
        }
        let (x, t) = (f64::sqrt(square / n), f64::sqrt(turned / n));
        if noise > 1e-5 {
            // Over half a turn one of both components is better known than the other one's u.
            assert!((0.9..1.1).contains(&x) && (0.65..1.1).contains(&t), "{x} {t}");
        } else {
            assert!(x < 0.8 && t < 0.8, "the edges' own u is the least: {x} {t}");
        }
    }
}

/// Three and five lobes that run along the part, drawn anew a part: 2u covers them, however many
/// stations show the same.
#[test]
fn lobes_that_run_along_the_part_are_known_from_one_stations_freedom() {
    let angles: Vec<f64> = (0..8).map(|k| 22.5 * f64::from(k)).collect();
    let mut rng = Pcg64::seed_from_u64(77);
    let normal = Normal::new(0.0, 3e-4).unwrap();
    let (mut covered, mut all) = (0.0, 0.0);
    for _ in 0..200 {
        let draw: Vec<f64> = (0..4).map(|_| normal.sample(&mut rng)).collect();
        let lobes = |angle: f64| {
            let (s3, c3) = (3.0 * angle.to_radians()).sin_cos();
            let (s5, c5) = (5.0 * angle.to_radians()).sin_cos();
            draw[0] * c3 + draw[1] * s3 + draw[2] * c5 + draw[3] * s5
        };
        let stations: Vec<f64> = (0..10).map(|k| 2.5 + 5.0 * f64::from(k)).collect();
        let zero = AxisZero { height_mm: 0.0, u_scale: 0.0 };
        let mut averager = AxisAverager::new(stations.clone(), 5.0, zero);
        for z_mm in stations {
            for angle_deg in &angles {
                let frame = flat(lobes(*angle_deg) + 0.03 * normal.sample(&mut rng));
                averager.add(&FrameMeta { angle_deg: *angle_deg, z_mm, ..FrameMeta::default() }, &frame);
            }
        }
        for s in averager.finish().stations {
            covered += f64::from(u8::from(s.x_mm.abs() <= 2.0 * s.u_random_mm));
            all += 1.0;
        }
    }
    // Two lobes are no white scatter over the angles; 95 % would be that.
    assert!(covered / all > 0.85, "{}", covered / all);
}

/// Two fields that show a station while the tool cuts, the far one of an axis bent otherwise: the
/// near burst counts, and at one place two bursts are averaged.
#[test]
fn the_nearest_burst_that_carries_a_station_counts() {
    let zero = AxisZero { height_mm: 0.0, u_scale: 0.0 };
    let mut averager = AxisAverager::new(vec![2.5], 2.0, zero);
    // The carriage moves by .02 mm from frame to frame.
    for (z_mm, middle) in [(4.0, 0.01), (2.6, 0.02), (2.6, 0.03)] {
        for i in 0..8 {
            let (angle_deg, z_mm) = (22.5 * f64::from(i), z_mm - 0.02 * f64::from(i));
            averager.add(&FrameMeta { angle_deg, z_mm, ..FrameMeta::default() }, &flat(middle));
        }
    }
    let x_mm = averager.finish().stations[0].x_mm;
    assert!((x_mm - 0.025).abs() < 1e-12, "{x_mm}");
}

#[test]
fn too_few_angles_are_not_split_and_a_second_view_shows_what_stands_still() {
    for angles in [vec![0.0], vec![0.0, 10.0], vec![0.0, 5.0, 10.0]] {
        let s = line(&angles, |_| 0.1, (0.02, 0.0), 0.0, 1).stations[0];
        assert!(s.turning.is_none() && (s.x_mm - 0.12).abs() < 1e-3, "{s:?}");
    }
    let angles: Vec<f64> = (0..8).map(|k| 22.5 * f64::from(k)).collect();
    let (x, y) = (|z: f64| 1e-3 * z, |z: f64| 0.3 - 2e-3 * z);
    let first = line(&angles, x, (0.01, 0.02), 0.0, 1);
    for view_deg in [90.0_f64, 60.0, -45.0] {
        let (sin, cos) = view_deg.to_radians().sin_cos();
        let second = line(&angles, |z| x(z) * cos + y(z) * sin, (0.01, 0.02), 0.0, 2);
        let still = first.seen_from(&second, view_deg);
        assert_eq!(still.len(), 60);
        assert!(still.iter().all(|s| (s.y_mm - y(s.z_mm)).abs() < 1e-12 && s.u_mm > 0.0));
    }
    assert!(first.seen_from(&first, 3.0).is_empty());
    let bend = first.bend_mm();
    assert!(bend.iter().all(|(_, b, _)| b.abs() < 1e-12));
    let t = first.stations[0].turning.unwrap();
    assert!((t.run_out_mm() - 2.0 * 0.01_f64.hypot(0.02)).abs() < 1e-12);
    assert!((t.at(90.0).0 + 0.02).abs() < 1e-12 && (t.phase_deg() - 63.434_95).abs() < 1e-4);
}
