//! Stations that a config lists.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::cell::SimulatedCell;
use shadowgauge::closed_loop::ClosedLoop;
use shadowgauge::control::ControllerName;
use shadowgauge::job::Job;
use shadowgauge::nc::{Dialect, NcSettings, TurningProgram, Workpiece};
use shadowgauge::render::{BackendChoice, Renderer};

fn job(listed: &[f64]) -> Job {
    let mut job = Job::default();
    job.part.station_z_mm = Some(listed.to_vec());
    job
}

#[test]
fn a_list_is_taken_as_it_stands() {
    let job = job(&[5.0, 83.5, 250.0, 497.5]);
    job.check().expect("a job");
    assert_eq!(job.part.station_z_mm(), [5.0, 83.5, 250.0, 497.5]);
    assert_eq!(Job::default().part.station_z_mm().len(), 100);
}

#[test]
fn a_list_that_cannot_be_is_refused_with_its_place() {
    let said = |listed: &[f64]| job(listed).check().expect_err("refused").to_string();
    for (listed, words) in [
        (&[][..], ["part.station_z_mm:", "lists 0 stations"]),
        (&[1.0, 20.0], ["part.station_z_mm[0]: 1 mm", "between 2.5 and 497.5"]),
        (&[5.0, 498.0], ["part.station_z_mm[1]: 498 mm", "inside the part"]),
        (&[5.0, f64::NAN], ["part.station_z_mm[1]: NaN", "inside the part"]),
        (&[50.0, 20.0], ["part.station_z_mm[1]: 20 mm", "must ascend"]),
        (&[20.0, 20.0], ["part.station_z_mm[1]: 20 mm", "must ascend"]),
        (&[20.0, 24.0], ["part.station_z_mm[1]: 24 mm", "overlap"]),
    ] {
        let text = said(listed);
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
    }
    // side by side, as by default
    let touching: Vec<f64> = (0..100).map(|i| (f64::from(i) + 0.5) * 5.0).collect();
    job(&touching).check().expect("stations may touch");
}

#[test]
fn fields_that_show_no_station_are_left_out() {
    let (all, some) = (Job::default().loop_job().scan_plan(), job(&[5.0, 250.0]).loop_job().scan_plan());
    assert!(some.field_z_mm.len() < 6 && some.field_z_mm.iter().all(|z| all.field_z_mm.contains(z)));
    let half = Job::default().loop_job().field_length_mm() / 2.0;
    // the remaining fields show as much of each station as all fields do
    for z in [2.6, 5.0, 7.4, 247.6, 250.0, 252.4] {
        let shown = |fields: &[f64]| fields.iter().filter(|f| (*f - z).abs() <= half).count();
        assert_eq!(shown(&some.field_z_mm), shown(&all.field_z_mm), "Z {z}");
    }
}

/// A short shaft in front of a small camera; the tailstock is soft, so that there is an error to
/// correct.
const SMALL: &str = concat!(
    r#"
[part]
length_mm = 60.0
stock_diameter_mm = 12.0
nominal_diameter_mm = [11.5, 11.0]
station_z_mm = [3.0, 11.0, 30.5, 40.0, 57.0]
station_mm = 5.0
"#,
    include_str!("../support/small_view.toml"),
    r#"[process.support]
tailstock_n_per_um = 5.0
"#
);

/// Scanned, controlled and written where they are listed; the learning controller takes their
/// uneven pitch.
#[test]
fn a_run_measures_and_corrects_the_listed_stations() {
    let mut job: Job = toml::from_str(SMALL).unwrap();
    job.part.tolerance = None;
    job.control.controller = ControllerName::Ilc;
    // few stations far apart: between them the shaft bends by more than the outlier limit
    job.control.guards.outlier_limit_mm = 0.03;
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let cell = SimulatedCell::new(&job, &renderer).unwrap();
    let mut turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
    let first = turning.run_pass(&mut |_, _| {}).unwrap();
    let z: Vec<f64> = first.profile.stations.iter().map(|s| s.z_mm).collect();
    assert_eq!(z, [3.0, 11.0, 30.5, 40.0, 57.0]);
    assert_eq!(first.form.sections.len(), 5);
    for (station, truth) in first.profile.stations.iter().zip(first.truth_mm.as_ref().unwrap()) {
        let d = station.reading.value().expect("every station is shown");
        assert!((d.d_mm - truth).abs() < 4.0 * d.u_mm(), "{station:?}, true {truth}");
    }
    assert!(turning.held().is_none(), "{:?}", turning.held());
    let plan = turning.plan();
    assert!(plan.station_z_mm == z && plan.offset.o_mm.iter().any(|o| o.abs() > 1e-4), "{plan:?}");
    let settings = NcSettings { least_knots: 41, ..NcSettings::default() };
    let piece = Workpiece::new(60.0, 12.0, 11.5);
    let program = TurningProgram {
        plan: &plan,
        settings: &settings,
        piece: &piece,
        limits_mm: None,
        reason: "released",
    };
    let written = program.write(Dialect::Linuxcnc).expect("a program");
    assert!(written.cut.largest_departure(&plan) < 0.0005, "{:?}", written.cut);
}
