//! The closed loop with a touch probe as its instrument.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::program;
use crate::inside::support::turned;

use shadowgauge::cell::{SimulatedCell, TurningCell};
use shadowgauge::closed_loop::{Calibrated, ClosedLoop, LoopError, PassResult, part_verdict};
use shadowgauge::config;
use shadowgauge::conformity::part_verdict::PartConformity;
use shadowgauge::control::ControllerName;
use shadowgauge::job::Job;
use shadowgauge::probe::{ProbeSettings, Sides, Stylus};
use shadowgauge::process::GuidewayPoint;
use shadowgauge::render::{BackendChoice, Renderer};
use turned::turn;

fn job() -> Job {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/probe_000.toml");
    config::load(std::path::Path::new(path)).expect("the preset")
}

fn probe(job: &mut Job) -> &mut ProbeSettings {
    job.probe.as_mut().expect("a probe")
}

/// (measured − true, u) of every station.
fn errors(pass: &PassResult) -> Vec<(f64, f64)> {
    let truth = pass.truth_mm.as_ref().expect("a simulation");
    let found = pass.profile.stations.iter().zip(truth);
    found.filter_map(|(s, t)| s.reading.value().map(|d| (d.d_mm - t, d.u_mm()))).collect()
}

fn true_error(pass: &PassResult) -> f64 {
    let truth = pass.truth_mm.iter().flatten();
    truth.map(|t| (t - pass.plan.nominal_mm).abs()).fold(0.0, f64::max)
}

#[test]
fn the_papers_controller_brings_the_part_into_its_tolerance() {
    let controlled = turn(&job());
    let mut without = job();
    without.control.controller = ControllerName::None;
    let uncontrolled = turn(&without);
    let last = &controlled[2];
    println!(
        "true max |e|: {:.2} µm by the probe's line, {:.2} µm without",
        1e3 * true_error(last),
        1e3 * true_error(&uncontrolled[2])
    );
    assert_eq!(last.profile.stations.len(), 6);
    assert_eq!(last.frames, 6 * 4, "two touches a diameter, two diameters a station");
    // semi-finishing is not compensated, finishing is
    assert!(controlled[1].plan.offset.o_mm.iter().all(|o| o.abs() < 1e-9));
    assert!(last.plan.offset.o_mm.iter().all(|o| *o > 0.005), "{:?}", last.plan.offset);
    assert!(true_error(last) < 0.25 * true_error(&uncontrolled[2]));
    let verdict = part_verdict(&job().loop_job(), &last.profile).expect("a tolerance");
    assert_eq!(verdict.part(), PartConformity::Conforms, "{}", verdict.words());
    let verdict = part_verdict(&job().loop_job(), &uncontrolled[2].profile).expect("a tolerance");
    assert_ne!(verdict.part(), PartConformity::Conforms, "{}", verdict.words());
}

/// Over seeds, the stated uncertainty agrees with the errors, for both ways of touching.
#[test]
fn the_stated_uncertainty_is_that_of_the_results() {
    for (stylus, sides) in [(Stylus::AlongX, Sides::One), (Stylus::AlongY, Sides::Two)] {
        let (mut square, mut beyond, mut n) = (0.0, 0, 0);
        for seed in 1..=24 {
            let mut job = job();
            job.seed = seed;
            (probe(&mut job).stylus, probe(&mut job).sides) = (stylus, sides);
            // the uncertainties of the machine are drawn as a displacement of the axis
            probe(&mut job).u_axis_um = 0.0;
            probe(&mut job).u_guideway_um = 0.0;
            for pass in turn(&job) {
                for (error, u) in errors(&pass) {
                    square += (error / u).powi(2);
                    beyond += usize::from(error.abs() > 2.0 * u);
                    n += 1;
                }
            }
        }
        let rms = (square / f64::from(n)).sqrt();
        println!("{sides:?}: rms error/u {rms:.3}, {beyond} of {n} beyond 2u");
        assert!((0.75..1.15).contains(&rms), "{sides:?}: {rms}");
        assert!(
            f64::from(u32::try_from(beyond).unwrap()) < 0.08 * f64::from(n),
            "{sides:?}: {beyond} of {n}"
        );
    }
}

/// Tool and probe ride on one guideway: from one side its error is cut and not measured, from both
/// sides it is measured.
#[test]
fn the_guideways_error_is_seen_from_both_sides_alone() {
    let worst = |sides: Sides| {
        let mut job = job();
        let bent = |z_mm, away_um| GuidewayPoint { z_mm, away_um };
        job.process.disturbance.guideway = vec![bent(0.0, 0.0), bent(120.0, 6.0), bent(240.0, 0.0)];
        job.control.controller = ControllerName::None;
        job.control.guards.master_limit_mm = 0.1;
        (probe(&mut job).stylus, probe(&mut job).sides) = (Stylus::AlongZ, sides);
        let pass = turn(&job).remove(0);
        errors(&pass).iter().map(|e| e.0).fold(0.0, |a: f64, e| if e.abs() > a.abs() { e } else { a })
    };
    let (one, two) = (worst(Sides::One), worst(Sides::Two));
    println!("guideway bent by 6 µm: one side errs by {:.2} µm, both by {:.2} µm", 1e3 * one, 1e3 * two);
    assert!((-0.0140..-0.0100).contains(&one), "{one}");
    assert!(two.abs() < 0.002, "{two}");
}

/// The pre-travel of touches in one direction is corrected by the master; from two sides, the sum
/// of both is.
#[test]
fn calibration_takes_out_ball_and_pretravel() {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let calibrated = |stylus: Stylus, sides: Sides, delay_ms: f64| {
        let mut job = job();
        (probe(&mut job).stylus, probe(&mut job).sides) = (stylus, sides);
        probe(&mut job).delay_ms = delay_ms;
        let cell = SimulatedCell::new(&job, &renderer).unwrap();
        let turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
        let Calibrated::Probe(found) = turning.calibration().clone() else { panic!("a probe's") };
        let text = serde_json::to_string(turning.calibration()).unwrap();
        let read: Calibrated = serde_json::from_str(&text).unwrap();
        assert!(matches!(read, Calibrated::Probe(p) if p == found), "{text}");
        found
    };
    let tip = calibrated(Stylus::AlongX, Sides::One, 0.0);
    let late = calibrated(Stylus::AlongX, Sides::One, 12.0);
    // 12 ms at 50 mm/min are 10 µm, twice
    assert!((tip.probe_correction_mm - late.probe_correction_mm - 0.020).abs() < 0.0006, "{tip:?} {late:?}");
    assert!((tip.probe_correction_mm - 6.0).abs() < 0.002, "{tip:?}");
    // F·L³/3EI of a lobe's middle (.495 N) and of a gap (.99 N): 2.99 and 5.97 µm, one of each from
    // both sides
    let bent = calibrated(Stylus::AlongY, Sides::Two, 0.0);
    assert!((6.0 - bent.probe_correction_mm - 0.00896).abs() < 0.0015, "{bent:?}");
    assert!((0.0001..0.001).contains(&tip.u_correction_mm), "{tip:?}");
}

#[test]
fn what_cannot_be_is_refused() {
    let said = |change: &dyn Fn(&mut Job)| {
        let mut job = job();
        change(&mut job);
        job.check().expect_err("refused").to_string()
    };
    assert!(said(&|j| probe(j).angles = 1).contains("probe.angles"));
    assert!(said(&|j| probe(j).sides = Sides::Two).contains("probe.sides"));
    assert!(said(&|j| probe(j).temperature.u_k = -1.0).contains("probe.temperature.u_k"));
    assert!(said(&|j| j.masters.pins.clear()).contains("masters.pins"));
    // the calibration of a camera is refused for the probe, and a cell without a probe returns an
    // error
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let (job, mut camera) = (job(), job());
    camera.probe = None;
    let mut cell = SimulatedCell::new(&camera, &renderer).unwrap();
    assert!(cell.touch(None, &[]).unwrap_err().to_string().contains("no touch probe"));
    let started = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None);
    assert!(matches!(started, Err(LoopError::Cell(_))));
}

/// From the command line: a run, its report, and the program that does the same at the machine.
#[test]
fn a_run_and_its_program_on_the_command_line() {
    let shadowgauge = |args: &[&str]| {
        let run = program::shadowgauge(args);
        (run.status.code(), program::text(&run.stdout), program::text(&run.stderr))
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run").display().to_string();
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/probe_000.toml");
    let (code, table, said) =
        shadowgauge(&["run", config, "--out", &out, "--backend", "cpu", "--no-reference"]);
    assert_eq!(code, Some(0), "{table}{said}");
    let page = std::fs::read_to_string(folder.path().join("run/report.html")).unwrap();
    assert!(page.contains("guideway between master and part"));
    let (code, text, said) = shadowgauge(&["nc", &out, "--dialect", "linuxcnc", "--form", "probing"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(text.matches("G38.2 X").count(), 12, "{text}");
    assert!(text.contains("(PROBED AT Z 200. 160. 120. 80. 40. 6.)"), "the listed stations\n{text}");
    let (code, text, said) =
        shadowgauge(&["nc", &out, "--dialect", "linuxcnc", "--form", "probing", "--pass", "1"]);
    assert!(code == Some(2) && text.is_empty() && said.contains("--pass 2 or later"), "{said}");
    // the offsets of the run as knots: probed after the cut, because the tolerance belongs to this
    // pass
    let (code, text, said) = shadowgauge(&["nc", &out, "--dialect", "linuxcnc"]);
    assert!(code == Some(0) && text.contains("PROBES AGAIN"), "{said}{text}");
    // the probe is qualified on the config's reference, at both spindle angles; no pass is given
    let qualify = ["nc", &out, "--dialect", "linuxcnc", "--form", "qualify"];
    let (code, text, said) = shadowgauge(&qualify);
    assert!(code == Some(0) && text.matches("G38.2 X").count() == 10, "{said}{text}");
    assert!(text.contains("HELD AT 0 AND 180 DEG BY M19") && text.contains("\n#884=5.\n"), "{text}");
    let (code, text, said) = shadowgauge(&[&qualify[..], &["--pass", "2"]].concat());
    assert!(code == Some(2) && text.is_empty() && said.contains("touches a reference"), "{said}");
    let (_, text, _) = shadowgauge(&["nc", &out, "--dialect", "linuxcnc", "--pass", "2"]);
    assert!(text.contains("DOES NOT MEASURE AGAIN: THE TOLERANCE"), "{text}");
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let (a, b) = (turn(&job()), turn(&job()));
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a.profile, b.profile);
    }
}
