//! Guards, second scans, stock scans, rounding and batches in runs through frames, on a small part.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::program;

use program::shadowgauge;
use shadowgauge::cell::{CellError, SimulatedCell, TurningCell};
use shadowgauge::closed_loop::{ClosedLoop, PassResult};
use shadowgauge::control::{ControllerName, PartAndTool, PartEvent};
use shadowgauge::frame::{Buffer, Frame, FrameSource, SourceError};
use shadowgauge::job::{Job, StockScan};
use shadowgauge::nc::{Dialect, Path};
use shadowgauge::plan::{Decision, PassPlan, ScanPlan};
use shadowgauge::process::GuidewayPoint;
use shadowgauge::profile::{Reading, Reason};
use shadowgauge::render::{BackendChoice, Renderer};
use shadowgauge::studies::parts::{self, Batch};

/// A short shaft, three passes, a small camera; the tailstock is soft, so that there is something
/// to correct.
const SMALL: &str = concat!(
    r#"
name = "small"
seed = 5
[part]
length_mm = 60.0
stock_diameter_mm = 12.0
nominal_diameter_mm = [11.5, 11.0, 10.5]
aim_mm = 0.0
[part.tolerance]
nominal_mm = 10.5
upper_mm = 0.02
lower_mm = -0.02
"#,
    include_str!("../support/small_view.toml"),
    r#"[process.support]
tailstock_n_per_um = 5.0
[process.disturbance]
stock_form_um = 20.0
[control.model]
length_mm = 60.0
stock_diameter_mm = 12.0
tailstock_n_per_um = 5.0
"#
);

fn job(change: impl FnOnce(&mut Job)) -> Job {
    let mut job: Job = toml::from_str(SMALL).unwrap();
    change(&mut job);
    job
}

/// A fault between cell and controller, from the second pass on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// Another part is in the machine when the offsets are decided.
    PartChanged,
    /// Another insert is in the machine.
    InsertChanged,
    /// The frames were taken before the pass was cut.
    BeforeCut,
    /// The frames are an hour old.
    Old,
    /// The frames' numbers were used before.
    UsedBefore,
    /// The master that is checked is another pin, as if the gauge had drifted.
    MasterOff,
    /// In the middle field both edges of a station are two pixels farther out: a collar that was
    /// not commanded.
    Collar,
}

struct Meddled<'a> {
    cell: SimulatedCell<'a>,
    fault: Fault,
    pass: u32,
    looks: std::cell::Cell<u32>,
}

impl Meddled<'_> {
    fn on(&self, fault: Fault) -> bool {
        self.fault == fault && self.pass >= 2
    }
}

impl TurningCell for Meddled<'_> {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        self.pass = plan.pass;
        self.looks.set(0);
        self.cell.cut(plan)
    }

    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let fault = if self.pass >= 2 { self.fault } else { Fault::None };
        Ok(Box::new(MeddledFrames { source: self.cell.scan(plan)?, fault }))
    }

    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let index = if self.on(Fault::MasterOff) { 1 } else { index };
        self.cell.scan_master(index, frames)
    }

    fn in_machine(&self) -> Option<PartAndTool> {
        self.looks.set(self.looks.get() + 1);
        let mut here = self.cell.in_machine()?;
        let later = self.looks.get() > 1;
        if self.on(Fault::PartChanged) && later {
            here.part = "another".to_owned();
        }
        if self.on(Fault::InsertChanged) && later {
            here.tool = "another".to_owned();
        }
        Some(here)
    }

    fn now_ns(&self) -> Option<u64> {
        self.cell.now_ns()
    }

    fn true_stations_mm(&self, stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        self.cell.true_stations_mm(stations_mm)
    }
}

struct MeddledFrames<'a> {
    source: Box<dyn FrameSource + 'a>,
    fault: Fault,
}

impl FrameSource for MeddledFrames<'_> {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let Some(mut frame) = self.source.next_frame()? else { return Ok(None) };
        match self.fault {
            Fault::BeforeCut => frame.meta.t_ns -= 1_000_000_000,
            // young enough not to trip the guard "before the cut"
            Fault::UsedBefore => frame.meta.frame_id %= 1 << 32,
            Fault::Collar if (frame.meta.z_mm - 30.0).abs() < 1.0 => frame = with_collar(frame),
            _ => {}
        }
        Ok(Some(frame))
    }

    fn remaining(&self) -> Option<usize> {
        self.source.remaining()
    }

    fn recycle(&mut self, frame: Frame) {
        self.source.recycle(frame);
    }
}

/// Columns 150 to 350 with their upper half two rows up and their lower half two rows down.
fn with_collar(frame: Frame) -> Frame {
    let (rows, columns) = (frame.view().rows(), frame.view().columns());
    let (format, meta) = (frame.view().format(), frame.meta.clone());
    let Buffer::U16(mut pixels) = frame.into_buffer() else { panic!("12 bit") };
    let seen = pixels.clone();
    for row in 2..rows - 2 {
        let from = if row < rows / 2 { row + 2 } else { row - 2 };
        let of = |row: usize| row * columns + 150..row * columns + 350;
        pixels[of(row)].copy_from_slice(&seen[of(from)]);
    }
    Frame::new(Buffer::U16(pixels), format, rows, columns, meta).unwrap()
}

fn turn(job: &Job, fault: Fault) -> Vec<PassResult> {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let cell = SimulatedCell::new(job, &renderer).unwrap();
    let cell = Meddled { cell, fault, pass: 0, looks: std::cell::Cell::new(0) };
    let mut turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
    let mut passes = Vec::new();
    while turning.next_pass().is_some() {
        passes.push(turning.run_pass(&mut |_, _| {}).unwrap());
    }
    passes
}

fn held(pass: &PassResult) -> String {
    match &pass.decision {
        Some(Decision::Held(reason)) => reason.to_string(),
        _ => String::new(),
    }
}

#[test]
fn a_sound_run_is_released_and_says_what_it_was_judged_by() {
    let passes = turn(&job(|_| {}), Fault::None);
    for pass in &passes[..2] {
        assert_eq!(held(pass), "", "{:?}", pass.evidence);
        let origin = pass.evidence.origin.as_ref().expect("the simulated cell can tell");
        assert_eq!(Some(&origin.of), pass.evidence.in_machine.as_ref());
        assert!(origin.since_cut_s >= 0.0 && origin.age_s >= 0.0);
        let master = origin.master_deviation_mm.expect("a pin is read after every scan");
        assert!(master.abs() < 0.0005, "{master}");
    }
    assert!(passes[2].decision.is_none() && passes.iter().all(|p| p.alarm.is_none()));
    // re-measured after the finishing pass: a tolerance that the part cannot be proven to lie in
    // raises an alarm
    let tight = job(|j| {
        if let Some(tolerance) = &mut j.part.tolerance {
            (tolerance.lower_mm, tolerance.upper_mm) = (-0.0002, 0.0002);
        }
        j.control.guards.lower_limit_mm = Some(9.0);
    });
    let alarm = turn(&tight, Fault::None)[2].alarm.clone().unwrap_or_default();
    assert!(alarm.starts_with("finished part: "), "{alarm}");
}

/// A collar of 0.12 mm that was not commanded: a gap with its reason, wherever the pass before was
/// sound; where the limit is wider than the collar it is accepted.
#[test]
fn a_station_that_did_not_change_as_commanded_is_a_gap() {
    let implausible = |passes: &[PassResult], pass: usize| -> Vec<f64> {
        let gaps = passes[pass].profile.stations.iter();
        gaps.filter(|s| s.reading == Reading::Gap(Reason::Implausible)).map(|s| s.z_mm).collect()
    };
    let passes = turn(&job(|_| {}), Fault::Collar);
    let found = implausible(&passes, 1);
    assert!(!found.is_empty() && found.iter().all(|z| (z - 30.0).abs() < 6.0), "{found:?}");
    assert!(implausible(&passes, 0).is_empty());
    let note = passes[1].notes.iter().find(|n| n.starts_with("implausible after the last pass: "));
    let note = note.unwrap_or_else(|| panic!("{:?}", passes[1].notes));
    println!("{note}");
    assert!(note.contains("z = ") && note.contains("limit 50.00 µm"));
    let wide = turn(&job(|j| j.gauge.plausibility.pass_limit_mm = 0.5), Fault::Collar);
    assert!(implausible(&wide, 1).is_empty());
    let wrong = job(|j| j.gauge.plausibility.pass_limit_mm = 0.0);
    let error = wrong.check().unwrap_err().to_string();
    assert!(error.contains("plausibility.pass_limit_mm"), "{error}");
}

#[test]
fn measurements_that_do_not_belong_here_are_held() {
    let limited = |fault: Fault| {
        job(|j| {
            if fault == Fault::Old {
                j.control.guards.age_limit_s = 0.0;
            }
        })
    };
    for (fault, guard) in [
        (Fault::PartChanged, "part: "),
        (Fault::InsertChanged, "tool: "),
        (Fault::BeforeCut, "fresh: the scan began 1.0 s before the pass was cut"),
        (Fault::Old, "fresh: the scan is"),
        (Fault::UsedBefore, "used once: "),
        (Fault::MasterOff, "master: read "),
    ] {
        let passes = turn(&limited(fault), fault);
        let text = held(&passes[1]);
        println!("{fault:?}: {text}");
        assert!(text.starts_with(guard), "{fault:?}: {text:?}");
        if fault == Fault::MasterOff {
            // The other master, 2.5 mm apart; the uncertainty of the reading itself is below half a
            // micrometre.
            let read: f64 = text[guard.len()..].split(' ').next().unwrap().parse().unwrap();
            assert!((read - 2500.0).abs() < 0.5, "{text}");
        }
        assert_eq!(passes[2].plan.offset, passes[1].plan.offset, "the last offsets hold");
        // the pass before the finishing pass was refused: the next cut is unchecked
        assert!(passes[1].alarm.is_some(), "{fault:?}");
    }
}

#[test]
fn every_limit_of_the_config_holds_a_run() {
    type Change = fn(&mut Job);
    let cases: [(&str, Change); 11] = [
        ("plausible reading: ", |j| j.control.guards.plausible_error_mm = 1e-4),
        ("uncertainty: ", |j| j.control.guards.uncertainty_limit_mm = 1e-6),
        ("scatter: ", |j| j.control.guards.scatter_limit_mm = 1e-7),
        ("an offset step of ", |j| j.control.guards.step_limit_mm = 1e-4),
        ("cumulative limit: ", |j| j.control.guards.cumulative_limit_mm = 1e-4),
        ("minimum chip: ", |j| j.control.guards.min_depth_mm = 0.3),
        ("depth of cut: ", |j| j.control.guards.max_depth_mm = 0.2),
        ("undersize: ", |j| j.control.guards.lower_limit_mm = Some(11.2)),
        ("two scans: before a step", |j| {
            j.control.guards.confirm_above_mm = 0.001;
            j.control.guards.agreement_limit_mm = 1e-7;
        }),
        ("outlier: ", |j| {
            j.control.guards.outlier_limit_mm = 1e-9;
            j.process.disturbance.guideway = bump();
        }),
        ("12 of 12 stations have no reading", |j| j.gauge.station.min_angles = 5),
    ];
    for (guard, change) in cases {
        let passes = turn(&job(change), Fault::None);
        let texts: Vec<String> = passes.iter().map(held).collect();
        println!("{}", texts[0]);
        assert!(texts[0].starts_with(guard), "{guard}: {texts:?}");
    }
    let strict = job(|j| {
        let g = &mut j.control.guards;
        (g.response_min, g.response_max, g.response_from_mm) = (0.9999, 1.0001, 1e-5);
    });
    let passes = turn(&strict, Fault::None);
    assert!(held(&passes[1]).starts_with("response: ") && passes[1].alarm.is_some(), "{}", held(&passes[1]));
}

/// A step of the guideway below one station.
fn bump() -> Vec<GuidewayPoint> {
    let at = |z_mm, away_um| GuidewayPoint { z_mm, away_um };
    vec![at(29.5, 0.0), at(30.5, 10.0), at(34.5, 10.0), at(35.5, 0.0)]
}

#[test]
fn a_large_step_takes_a_second_scan_and_a_small_one_does_not() {
    let passes = turn(&job(|j| j.control.guards.confirm_above_mm = 0.002), Fault::None);
    let again = passes[0].evidence.repeat.as_ref().expect("a second scan");
    assert_eq!((held(&passes[0]), passes[0].frames), (String::new(), 40));
    assert_ne!(again, &passes[0].profile, "its noise is its own");
    let plain = turn(&job(|_| {}), Fault::None);
    assert!(plain[0].evidence.repeat.is_none() && plain[0].frames == 20);
    assert_eq!(plain[0].profile, passes[0].profile);
}

#[test]
fn the_stock_is_scanned_for_the_controller_that_uses_it_and_pass_one_knows_no_controller() {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let first = |controller: ControllerName, stock: StockScan| {
        let job = job(|j| {
            j.control.controller = controller;
            j.scan.stock = stock;
        });
        let cell = SimulatedCell::new(&job, &renderer).unwrap();
        let mut turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
        let pass = turning.run_pass(&mut |_, _| {}).unwrap();
        let form = turning.stock().map(|s| {
            let d: Vec<f64> = s.stations.iter().map(|s| s.reading.value().unwrap().d_mm).collect();
            (d.iter().copied().fold(0.0, f64::max), d.iter().copied().fold(f64::INFINITY, f64::min))
        });
        (form, pass.profile, pass.truth_mm)
    };
    let (stock, profile, truth) = first(ControllerName::Model, StockScan::Auto);
    let (most, least) = stock.expect("the model uses it");
    assert!((most - 12.0).abs() < 0.1 && most - least > 0.005, "the blank's form: {least} to {most}");
    assert!(first(ControllerName::Model, StockScan::Never).0.is_none());
    for (controller, stock) in [
        (ControllerName::None, StockScan::Auto),
        (ControllerName::Pid, StockScan::Always),
        (ControllerName::Lsq, StockScan::Auto),
    ] {
        let other = first(controller, stock);
        assert_eq!((&other.1, &other.2), (&profile, &truth), "{controller}");
        assert_eq!(other.0.is_some(), stock == StockScan::Always);
    }
}

#[test]
fn rounded_offsets_go_back_to_the_controller() {
    for dialect in Dialect::ALL {
        let job = job(|j| {
            j.nc = Some(shadowgauge::job::NcJob { dialect, machine: shadowgauge::nc::NcSettings::default() });
        });
        let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
        let cell = SimulatedCell::new(&job, &renderer).unwrap();
        let mut turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
        let pass = turning.run_pass(&mut |_, _| {}).unwrap();
        let plan = turning.plan();
        let asked = PassPlan { offset: turning.asked().clone(), ..plan.clone() };
        let path = Path::new(&asked, &shadowgauge::nc::NcSettings::default(), dialect).unwrap();
        assert_eq!(plan.offset, path.in_force, "what is commanded is what the program cuts");
        assert!(pass.notes.iter().any(|n| n.contains(dialect.as_str())), "{:?}", pass.notes);
        let rounded = plan.offset.o_mm.iter().zip(&asked.offset.o_mm).any(|(a, b)| (a - b).abs() > 1e-6);
        assert!(rounded, "{dialect:?} rounds");
        let next = turning.run_pass(&mut |_, _| {}).unwrap();
        assert_eq!(next.plan.offset, path.in_force);
    }
    // an impossible path: refused before anything is cut
    let close = job(|j| {
        let machine = shadowgauge::nc::NcSettings { least_z_mm: 3.0, ..Default::default() };
        j.nc = Some(shadowgauge::job::NcJob { dialect: Dialect::Fanuc, machine });
    });
    assert!(close.check().unwrap_err().to_string().contains("nc.machine"));
}

#[test]
fn a_batch_learns_from_part_to_part() {
    let job = job(|j| {
        j.process.disturbance.stock_form_um = 2.0;
        j.process.disturbance.wear_um_per_pass = 0.2;
    });
    let batch = Batch { parts: 4, insert_every: 2, cold_at: vec![4] };
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let study = parts::run(&job, &batch, &renderer, &mut |_, _| {}).unwrap();
    assert_eq!(study.passes.len(), 2 * 4 * 3);
    let event = |part: u32| study.passes.iter().find(|p| p.part == part).unwrap().event;
    assert_eq!((event(3), event(4)), (PartEvent::InsertChanged, PartEvent::ColdStart));
    let (alone, learning) = (&study.summaries[0], &study.summaries[1]);
    println!("{alone:?}\n{learning:?}");
    assert!(learning.first_pass_mm < 0.5 * alone.first_pass_mm);
    // the first part is the same, the blanks differ from part to part
    let of = |learning: bool, part: u32| -> Vec<f64> {
        let chosen = study.passes.iter().filter(|p| p.learning == learning && p.part == part);
        chosen.map(|p| p.true_worst_mm).collect()
    };
    assert_eq!(of(false, 1), of(true, 1));
    assert_ne!(of(false, 1), of(false, 2));
}

#[test]
fn an_alarm_stops_a_run_and_the_reason_is_written_down() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("job.toml");
    let text = format!("{SMALL}\n[control.guards]\nmaster_limit_mm = 1e-7\n");
    for (more, stops) in [("", true), ("on_alarm = \"go_on\"\n", false)] {
        std::fs::write(&config, format!("{text}{more}")).unwrap();
        let out = folder.path().join(format!("out_{stops}"));
        let output = shadowgauge([
            "run",
            &config.to_string_lossy(),
            "--out",
            &out.to_string_lossy(),
            "--backend",
            "cpu",
            "--no-reference",
            "--json",
        ]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect(&message);
        assert_eq!(json["passes"].as_array().unwrap().len(), if stops { 2 } else { 3 }, "{message}");
        assert_eq!(json["stopped"].is_string(), stops, "{json}");
        assert_eq!(json["passes"][0]["decision"], "held");
        assert!(message.contains("the last offsets hold: master: read"), "{message}");
        if stops {
            assert_eq!(output.status.code(), Some(1));
            assert!(message.contains("stopped before pass 3"), "{message}");
        }
        for name in ["report.html", "control.json"] {
            let page = std::fs::read_to_string(out.join(name)).unwrap();
            assert!(page.contains("master: read"), "{name}");
        }
        let offsets = std::fs::read_to_string(out.join("offsets.csv")).unwrap();
        assert!(
            offsets.contains("held,master: read") || offsets.contains("held,\"master: read"),
            "{offsets}"
        );
    }
}

#[test]
fn a_killed_run_with_stock_second_scans_and_rounding_is_resumed_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("job.toml");
    let text = format!(
        "{SMALL}\n[control.guards]\nconfirm_above_mm = 0.002\n[nc]\ndialect = \"linuxcnc\"\n[nc.machine]\ntool = 3\n"
    );
    std::fs::write(&config, text).unwrap();
    let run = |out: &std::path::Path| {
        let output = shadowgauge([
            "run",
            &config.to_string_lossy(),
            "--out",
            &out.to_string_lossy(),
            "--backend",
            "cpu",
            "--no-reference",
            "--controller",
            "model",
        ]);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    run(&whole);
    std::fs::create_dir(&killed).unwrap();
    for name in [
        "run.toml",
        "calibration.json",
        "stations.csv",
        "diameters.parquet",
        "truth.parquet",
        "offsets.csv",
        "control.json",
    ] {
        std::fs::copy(whole.join(name), killed.join(name)).unwrap();
    }
    let passes = std::fs::read_to_string(whole.join("passes.csv")).unwrap();
    let two: String = passes.lines().take(3).map(|l| format!("{l}\n")).collect();
    std::fs::write(killed.join("passes.csv"), two).unwrap();
    run(&killed);
    for name in ["passes.csv", "stations.csv", "offsets.csv", "control.json", "diameters.parquet"] {
        let read = |f: &std::path::Path| std::fs::read(f.join(name)).unwrap();
        assert!(read(&whole) == read(&killed), "{name} differs after a resume");
    }
    // the program for the run's own control agrees with the offsets in force exactly
    let listed = shadowgauge(["nc", &whole.to_string_lossy(), "--dialect", "linuxcnc", "--dry-run"]);
    let text = String::from_utf8_lossy(&listed.stdout).into_owned();
    let rows = std::fs::read_to_string(whole.join("offsets.csv")).unwrap();
    let last = rows.lines().last().unwrap().split(',').nth(2).unwrap().parse::<f64>().unwrap();
    let shown = text.lines().last().unwrap().split_whitespace().nth(3).unwrap().parse::<f64>().unwrap();
    assert!((last - shown).abs() < 6e-6, "{last} in force, {shown} in the program");
    assert!(text.contains("reason: "), "{text}");
}
