//! The results of runs against the truth: diameters of several sizes against their uncertainty, the
//! axis against the process' own beam.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::turned;

use shadowgauge::closed_loop::PassResult;
use shadowgauge::job::{Job, ScanWhen};
use shadowgauge::shaft::AxisKnot;
use turned::turn;

/// Columns of the shortened frames.
const COLUMNS: u32 = 1200;

/// The main job with a shaft of another size and the same head: two passes, a short shaft, frames
/// cropped to it. For shafts larger than the head's field the magnification is reduced.
fn job(diameter_mm: f64, length_mm: f64, seed: u64) -> Job {
    let text = std::fs::read_to_string("configs/slender_shaft.toml").unwrap();
    let mut job = shadowgauge::config::parse(&text, "slender_shaft.toml").unwrap();
    job.seed = seed;
    job.optics.magnification *= (27.0 / diameter_mm).min(1.0);
    let pixel_mm = 1e-3 * job.camera.pixel_um / job.optics.magnification;
    job.camera.columns = COLUMNS;
    job.camera.rows = (1.25 * diameter_mm / pixel_mm) as u32 / 16 * 16;
    job.part.length_mm = length_mm;
    job.part.stock_diameter_mm = diameter_mm;
    job.part.nominal_diameter_mm = vec![diameter_mm - 0.5, diameter_mm - 1.0];
    job.part.tolerance = None;
    job.part.aim_mm = 0.0;
    for (pin, off) in job.masters.pins.iter_mut().zip([-1.5, 0.5]) {
        pin.diameter_mm = diameter_mm + off;
    }
    job.scan.fields = (length_mm / (0.8 * pixel_mm * f64::from(COLUMNS))).ceil() as usize;
    job.check().and_then(|()| job.check_coverage()).unwrap();
    job
}

/// Errors over u of every station read.
fn ratios(passes: &[PassResult]) -> Vec<f64> {
    let pairs = passes.iter().flat_map(|p| p.profile.stations.iter().zip(p.truth_mm.as_ref().unwrap()));
    pairs.filter_map(|(s, truth)| s.reading.value().map(|d| (d.d_mm - truth) / d.u_mm())).collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Slender shafts taper by 10 µm per station between chuck and tool: columns that fields show
/// twice, or leave out, cause no error of a station.
#[test]
fn stated_uncertainties_are_true_whatever_the_diameter() {
    let mut all = Vec::new();
    for (diameter_mm, length_mm, straight) in [
        (6.0, 75.0, false),
        (8.2, 150.0, false),
        (8.2, 150.0, true),
        (20.0, 150.0, false),
        (40.0, 150.0, false),
    ] {
        let mut job = job(diameter_mm, length_mm, 3);
        if straight {
            job.shaft = Default::default();
            job.process.bending = Default::default();
        }
        let own = ratios(&turn(&job));
        let beyond = own.iter().filter(|r| r.abs() > 2.0).count() as f64 / own.len() as f64;
        println!(
            "Ø{diameter_mm} straight {straight}: {} stations, rms {:.3}, beyond 2u {beyond:.3}",
            own.len(),
            rms(&own)
        );
        // Twenty stations of two passes determine a standard deviation to a sixth.
        assert!((0.6..1.4).contains(&rms(&own)), "Ø{diameter_mm}: {}", rms(&own));
        all.extend(own);
    }
    let beyond = all.iter().filter(|r| r.abs() > 2.0).count() as f64 / all.len() as f64;
    println!("pooled: {} stations, rms {:.3}, beyond 2u {beyond:.3}", all.len(), rms(&all));
    assert!((0.8..1.15).contains(&rms(&all)), "{}", rms(&all));
    assert!(beyond <= 0.07, "{beyond}");
}

/// Mean of a line over a station, mm along x and y.
fn mean_offset(knots: &[AxisKnot], z_mm: f64, station_mm: f64) -> [f64; 2] {
    const SLICES: u32 = 200;
    let slice = |k: u32| z_mm + station_mm * ((f64::from(k) + 0.5) / f64::from(SLICES) - 0.5);
    let sum = (0..SLICES).map(|k| shadowgauge::process::bending::axis_at(knots, slice(k)));
    sum.fold([0.0; 2], |all, p| [all[0] + p[0] / f64::from(SLICES), all[1] + p[1] / f64::from(SLICES)])
}

/// Error of an axis allowed in addition to U, mm.
const LIMIT_MM: f64 = 1e-4;

/// The axis of a run is that of the process' beam: under weight, tailstock and chuck after the
/// pass; during the cut under the force too, every station as the burst of frames saw it from which
/// the gauge took it.
#[test]
fn the_axis_of_a_run_is_the_beam_of_its_process() {
    for when in [ScanWhen::AfterPass, ScanWhen::DuringCut] {
        let (mut errors, mut largest_mm) = (Vec::new(), 0.0_f64);
        for seed in 1..4 {
            let mut job = job(8.2, 120.0, seed);
            job.scan.when = when;
            job.scan.behind_tool_mm = 14.0;
            job.check_coverage().unwrap();
            for pass in turn(&job) {
                let truth = pass.true_axis.as_ref().unwrap();
                assert!(pass.axis.gaps.is_empty() && pass.axis.stations.len() == 24);
                for s in &pass.axis.stations {
                    let still = mean_offset(&truth.still, s.z_mm, job.part.station_mm);
                    let turning = mean_offset(&truth.turning, s.z_mm, job.part.station_mm);
                    let t = s.turning.unwrap();
                    let own = [
                        (s.x_mm - still[0], s.u_mm()),
                        (t.x_mm - turning[0], t.u_mm),
                        (t.y_mm - turning[1], t.u_mm),
                    ];
                    for (error, u) in own {
                        assert!(
                            error.abs() < LIMIT_MM + 2.0 * u,
                            "{when:?} seed {seed} pass {} z {}: {own:?}",
                            pass.plan.pass,
                            s.z_mm
                        );
                        errors.push(error / u);
                    }
                    largest_mm = largest_mm.max(still[0].abs());
                }
            }
        }
        println!("{when:?}: rms error over u {:.2}, axis up to {:.2} um", rms(&errors), 1e3 * largest_mm);
        assert!((0.3..1.3).contains(&rms(&errors)), "{when:?} {}", rms(&errors));
        // The force bends more than weight and tailstock, and must be included.
        let least_mm = if when == ScanWhen::DuringCut { 0.01 } else { 0.003 };
        assert!(largest_mm > least_mm, "{when:?}: the axis is bent by {largest_mm} mm");
    }
}
