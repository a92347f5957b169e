//! A run on a lathe with errors: what it cuts by closed forms, what its compensation leaves, how
//! the head stands before the part, and what is refused.

use std::f64::consts::TAU;
use std::path::Path;

use super::close;
use crate::cell::{SimulatedCell, TurningCell as _};
use crate::closed_loop::ClosedLoop;
use crate::config;
use crate::job::Job;
use crate::machine::Pose;
use crate::machine::response::{Part, TwoSided};
use crate::plan::DiameterOffset;
use crate::probe::ProbeSettings;
use crate::process::{PathDisplacement as _, PathPlace};
use crate::render::silhouette::{Outline, View};
use crate::render::{BackendChoice, Renderer};
use crate::shaft::Shaft;

const JOB: &str = include_str!("../../../configs/small_shaft.toml");

/// A lathe whose references lie in the tip, so that an error has no lever but the part's.
const LATHE: &str = r#"
[process.texture]
rms_um = 0.0
lobe_um = 0.0
[process.support]
chuck_n_per_um = inf
tailstock_n_per_um = inf
[process.material]
youngs_modulus_n_per_mm2 = 1e12
[machine]
compensate = false
[machine.stated]
chain = "carriage"
tool_mm = [0.0, 0.0, 0.0]
head_mm = [0.0, 0.0, 0.0]
head_on = "x_carrier"
carriage_mm = [0.0, 0.0, 0.0]
x_travel_mm = [-1.0, 20.0]
z_travel_mm = [-20.0, 100.0]
"#;

/// The job with changes of its text, and errors behind it.
fn text(changes: &[(&str, &str)], errors: &str) -> String {
    let mut text = format!("{JOB}{LATHE}");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text + errors
}

fn job(changes: &[(&str, &str)], errors: &str) -> Job {
    config::parse(&text(changes, errors), "job.toml").unwrap()
}

/// Deviation of the diameter from 11.5 mm after the first pass, µm, at places.
fn cut_um(job: &Job, z_mm: &[f64]) -> Vec<f64> {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut cell = SimulatedCell::new(job, &renderer).unwrap();
    let order = job.loop_job();
    cell.cut(&order.pass_plan(1, DiameterOffset::zero(order.station_z_mm().len()))).unwrap();
    let narrow: Vec<(f64, f64)> = z_mm.iter().map(|z| (z - 0.01, z + 0.01)).collect();
    cell.true_stations_mm(&narrow).unwrap().into_iter().map(|d| 1e3 * (d - 11.5)).collect()
}

const PLACES: [f64; 5] = [2.5, 17.5, 32.5, 47.5, 57.5];
/// Straightness of Z along X: 5 µm at the chuck's face, a cosine of 240 mm.
const BOW: &str = "[machine.stated.errors.exz]\nfourier = [{ wavelength_mm = 240.0, amplitude_um = 5.0 }]\n";

#[test]
fn a_straightness_error_stands_twice_on_the_diameter() {
    // the slide that carries the tool moves it away; that which carries the part does the opposite
    for (chain, sign) in [("carriage", 1.0), ("t_shaped", -1.0)] {
        let job = job(&[("\"carriage\"", &format!("\"{chain}\""))], BOW);
        for (z, found) in PLACES.iter().zip(cut_um(&job, &PLACES)) {
            let wanted = sign * 10.0 * (TAU * z / 240.0).cos();
            close(found, wanted, 2e-3, &format!("{chain}, z {z}"));
        }
    }
}

#[test]
fn a_spindle_askew_to_the_slide_turns_a_cone_and_a_slide_askew_to_it_a_cylinder() {
    let cone = cut_um(&job(&[("z_travel_mm", "b0c_urad = 100.0\nz_travel_mm")], ""), &PLACES);
    let cylinder = cut_um(&job(&[("z_travel_mm", "b0x_urad = 100.0\nz_travel_mm")], ""), &PLACES);
    let above = cut_um(&job(&[("z_travel_mm", "a0c_urad = 100.0\nz_travel_mm")], ""), &PLACES);
    for (k, z) in PLACES.iter().enumerate() {
        // e_X = −B0C·z
        close(cone[k], -2e-1 * z, 1e-3, &format!("B0C, z {z}"));
        // e_Z alone: nothing on a cylinder; e_Y: (A0C·z)²/R with the tip on the axis
        close(cylinder[k], 0.0, 1e-3, &format!("B0X, z {z}"));
        close(above[k], 1e3 * (1e-4 * z).powi(2) / 5.75, 1e-3, &format!("A0C, z {z}"));
    }
}

#[test]
fn the_controls_table_takes_out_what_stands_still() {
    let compensated = ("compensate = false", "compensate = true");
    let left = cut_um(&job(&[compensated], BOW), &PLACES);
    // the table bends at a station's middle, half a node from the nodes beside it: e''·.5·4.5/2
    assert!(left.iter().all(|e| e.abs() < 1e-2), "{left:?}");
    // between two stations their chord is left, e''·h²/8 with stations 5 mm apart
    let between = cut_um(&job(&[compensated], BOW), &[30.0])[0];
    let wanted = 10.0 * (TAU * 30.0 / 240.0).cos() * (TAU / 240.0_f64).powi(2) * 25.0 / 8.0;
    close(between, wanted, 0.1 * wanted, "between stations");
    // what drifts is not in the table: −2·EXC, warm to 1 − 1/e
    let drift = "[machine.stated.errors.exc]\ndrift = { warm_up_um = 3.0, time_constant_min = 60.0 }\n";
    let warm = job(&[("compensate = false", "compensate = true\nminutes = 60.0")], &format!("{BOW}{drift}"));
    let wanted = -6.0 * (1.0 - (-1.0_f64).exp());
    for found in cut_um(&warm, &PLACES) {
        close(found, wanted, 1e-2, "drift");
    }
}

/// A table that was identified to four fifths leaves a fifth; that of another machine is refused.
#[test]
fn a_table_leaves_what_was_not_identified() {
    let stated = LATHE.split_once("[machine.stated]").unwrap().1;
    let table = |errors: &str| format!("{BOW}[machine.table_stated]\n{stated}{errors}");
    let identified = BOW.replace("machine.stated", "machine.table_stated").replace("5.0", "4.0");
    let compensated = ("compensate = false", "compensate = true");
    let job = job(&[compensated], &table(&identified));
    for (z, found) in PLACES.iter().zip(cut_um(&job, &PLACES)) {
        close(found, 2.0 * (TAU * z / 240.0).cos(), 1e-2, &format!("z {z}"));
    }
    let refused = |text: &str| config::parse(text, "job.toml").unwrap_err().to_string();
    let unused = refused(&text(&[], &table(&identified)));
    assert!(unused.contains("machine.table") && unused.contains("compensate"), "{unused}");
    let other = table(&identified).replace("\"carriage\"", "\"t_shaped\"");
    let other = refused(&text(&[compensated], &other));
    assert!(other.contains("machine.table") && other.contains("another one"), "{other}");
}

#[test]
fn exact_and_first_order_agree_and_rows_say_what_was_cut() {
    let errors =
        format!("{BOW}[machine.stated.errors.ebz]\npolynomial = {{ coefficients_urad = [20.0, 30.0] }}\n");
    let levers = [("carriage_mm = [0.0, 0.0, 0.0]", "carriage_mm = [0.0, 0.0, -80.0]")];
    let job = job(&levers, &errors);
    let rows = job.machine_rows(2).unwrap();
    assert_eq!(rows.iter().map(|row| row.pass).max(), Some(2));
    let first: Vec<_> = rows.iter().filter(|row| row.pass == 1).collect();
    let places: Vec<f64> = first.iter().map(|row| row.z_mm).collect();
    for (row, found) in first.iter().zip(cut_um(&job, &places)) {
        close(found, row.cut_um, 3e-3, &format!("z {}", row.z_mm));
        close(row.cut_um, row.cut_first_order_um, 5e-3, "first order");
        close(row.left_um, row.cut_um, 1e-9, "left without compensation");
        close(row.midline_um, -row.head_x_um, 1e-12, "midline");
    }
    // at the lever: EXZ − 80·EBZ, EBZ = 20 + 30·s with s from −1 to 1 over the travel
    let (row, s) = (first[0], (first[0].z_mm - 40.0) / 60.0);
    let wanted = 2.0 * (5.0 * (TAU * row.z_mm / 240.0).cos() - 0.08 * (20.0 + 30.0 * s));
    close(row.cut_um, wanted, 5e-3, "closed form");
}

/// Both edges of a cylinder of 11 mm before the head of a job, at the middle of a field and 10 mm
/// from it, mm.
fn edges(job: &Job, field_z_mm: f64, view: &View) -> [(f64, f64); 2] {
    let head = job.lathe().unwrap().unwrap().head(field_z_mm);
    let outline = Outline::new(head.seen(Shaft::cylinder(11.0))).unwrap();
    let turned = outline.turned(0.0);
    [0.0, 10.0].map(|aside| {
        let pair = turned.edges_seen(field_z_mm + aside, view);
        (pair.top_mm, pair.bottom_mm)
    })
}

#[test]
fn the_midline_is_the_heads_own_pose_and_the_width_is_not() {
    let errors =
        format!("{BOW}[machine.stated.errors.ebz]\npolynomial = {{ coefficients_urad = [400.0] }}\n");
    let job = job(&[("z_travel_mm", "b0c_urad = 100.0\nz_travel_mm")], &errors);
    let z = 30.0;
    let [(top, bottom), (top_10, bottom_10)] = edges(&job, z, &View { middle_z_mm: z, per_distance: 0.0 });
    // u_x = EXZ − B0C·z, b = EBZ − B0C
    let shift = 5e-3 * (TAU * z / 240.0).cos() - 1e-4 * z;
    let turn = 4e-4 - 1e-4;
    close(0.5 * (top + bottom), -shift, 2e-6, "midline");
    close(0.5 * (top_10 + bottom_10) + shift, -turn * 10.0, 2e-6, "slope");
    close(top - bottom, 11.0 / f64::cos(turn), 1e-9, "width");
}

#[test]
fn the_distance_of_the_head_scales_the_width_by_the_response() {
    let errors = "[machine.stated.errors.eyz]\npolynomial = { coefficients_um = [20.0] }\n";
    let (z, pupil_mm) = (30.0, 300.0);
    let view = View { middle_z_mm: z, per_distance: 1.0 / pupil_mm };
    let width = |errors: &str| {
        let [(top, bottom), _] = edges(&job(&[], errors), z, &view);
        top - bottom
    };
    let moved = (width(errors) / width("") - 1.0) * 11.0;
    let head = TwoSided { pupil_mm, keystone_per_mm: 0.0, pair_mm: [0.0, 0.0] };
    let pose = Pose { shift_mm: [0.0, 0.02, 0.0].into(), turn_rad: [0.0, 0.0, 0.0].into() };
    let wanted = head.read_mm(&Part { diameter_mm: 11.0, taper: 0.0 }, &pose);
    close(wanted, -11.0 * 0.02 / pupil_mm, 0.01 * wanted.abs(), "response");
    close(moved, wanted, 0.01 * wanted.abs(), "silhouette");
}

/// What the spindle cuts with its error motion returns to the same place while it turns with it:
/// the edge on the tool's side stands still.
#[test]
fn the_edge_on_the_tools_side_stands_still_while_the_spindle_errs() {
    let errors = "[machine.stated.errors.exc]\nfourier = [{ order = 3, amplitude_um = 0.4, phase_deg = 20.0 }, { order = 8, amplitude_um = 0.1 }]\n";
    let lathe = job(&[], errors).lathe().unwrap().unwrap();
    let lobes = lathe.lobes(&PathPlace { z_mm: 30.0, diameter_mm: 11.0, taper: 0.0 });
    assert_eq!(lobes.iter().map(|l| l.order_upr).collect::<Vec<_>>(), [3, 8]);
    close(lobes[0].amplitude_mm, 4e-4, 1e-8, "lobe");
    let part = Shaft { lobes, ..Shaft::cylinder(11.0) };
    let alone = Outline::new(part.clone()).unwrap();
    let outline = Outline::new(lathe.head(30.0).seen(part)).unwrap();
    let angles = [0.0, 13.0, 40.0, 77.0, 120.0, 200.0, 301.0];
    let spread = |heights: Vec<f64>| {
        let (low, high) = heights.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    let top = |outline: &Outline| angles.map(|a| outline.turned(a).edges(30.0).top_mm).to_vec();
    let bottom = angles.map(|a| outline.turned(a).edges(30.0).bottom_mm).to_vec();
    assert!(spread(top(&alone)) > 4e-4, "the lobes alone move it");
    // second order: k²a²/2R
    assert!(spread(top(&outline)) < 1e-6, "{}", spread(top(&outline)));
    // opposite, order 3 is of constant width and stands still, too; order 8 counts twice
    assert!(spread(bottom.clone()) > 1e-4 && spread(bottom) < 4.01e-4);
}

/// Changes of the job's text, text added behind it, the key that is refused, and words of the
/// reason.
type Misfit = (&'static [(&'static str, &'static str)], &'static str, &'static str, &'static str);

const MISFITS: [Misfit; 9] = [
    (&[("z_travel_mm = [-20.0, 100.0]", "z_travel_mm = [-20.0, 50.0]")], "", "part.length_mm", "travel of Z"),
    (
        &[("x_travel_mm = [-1.0, 20.0]", "x_travel_mm = [-1.0, 5.8]")],
        "",
        "part.stock_diameter_mm",
        "travel of X",
    ),
    (&[("tool_mm = [0.0, 0.0, 0.0]", "tool_mm = [0.0, 0.0, 9e9]")], "", "machine.stated.tool_mm[2]", "µm"),
    (&[("compensate = false", "compensate = false\nminutes = -1.0")], "", "machine.minutes", "at least 0"),
    (
        &[("compensate = false", "compensate = false\nfile = \"lathe.toml\"")],
        "",
        "machine.file",
        "stands beside",
    ),
    (
        &[("[machine.stated]", "[process.bending]\ntool_deg = 90.0\n[machine.stated]")],
        "",
        "process.bending.tool_deg",
        "0 beside",
    ),
    (
        &[(
            "[machine.stated]",
            "[[process.disturbance.guideway]]\nz_mm = 0.0\naway_um = 5.0\n[machine.stated]",
        )],
        "[machine.stated.errors.exz]\nreversal_um = 0.0\n",
        "process.disturbance.guideway",
        "EXZ",
    ),
    (
        &[(
            "[machine.stated]",
            "[[process.disturbance.spindle_lobes]]\norder_upr = 3\namplitude_mm = 0.001\n[machine.stated]",
        )],
        "",
        "process.disturbance.spindle_lobes",
        "EXC",
    ),
    (
        &[],
        "[machine.stated.errors.exc]\nfourier = [{ order = 400, amplitude_um = 0.1 }]\n",
        "errors.exc.fourier[0].order",
        "at most 359",
    ),
];

#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.toml");
    for (changes, errors, key, words) in MISFITS {
        std::fs::write(&path, text(changes, errors)).unwrap();
        let refused = config::load(&path).unwrap_err().to_string();
        assert!(refused.contains(key) && refused.contains(words), "{key}: {refused}");
    }
}

#[test]
fn a_probe_and_recorded_frames_are_refused_beside_a_machine() {
    let touched = Job { probe: Some(ProbeSettings::default()), ..job(&[], "") };
    let refused = touched.lathe().unwrap_err().to_string();
    assert!(refused.contains("touch probe"), "{refused}");
    let recorded = Job { source: Some("frames".to_owned()), ..job(&[], "") };
    let refused = recorded.lathe().unwrap_err().to_string();
    assert!(refused.contains("recorded"), "{refused}");
    let unread = Job { machine: Some(crate::job::RunMachine::default()), ..job(&[], "") };
    assert!(unread.lathe().unwrap_err().to_string().contains("machine.file"));
}

#[test]
fn a_head_that_leaves_the_travel_is_refused() {
    let beside = job(&[("head_mm = [0.0, 0.0, 0.0]", "head_mm = [0.0, 0.0, 60.0]")], "");
    let refused = beside.check_coverage().unwrap_err().to_string();
    assert!(refused.contains("z_travel_mm") && refused.contains("60 mm beside the tool"), "{refused}");
}

#[test]
fn a_file_is_read_with_the_tables_beside_it_and_resolves_to_itself() {
    let job = config::load(Path::new("configs/machine_run.toml")).unwrap();
    assert!(job.machine.as_ref().unwrap().file.is_none());
    let again: Job = toml::from_str(&config::resolved(&job).unwrap()).unwrap();
    assert_eq!(again, job);
    job.check_coverage().unwrap();
    let place = PathPlace { z_mm: 60.0, diameter_mm: 11.0, taper: 0.0 };
    // EXZ − 80·EBZ − B0C·z, and 2h·e_Y/R of EYZ and A0C with the tip .05 mm above the axis
    let s = (60.0 - 30.0) / 90.0;
    let exz = 2.0 * (TAU + 30.0_f64.to_radians()).cos();
    let along_x = exz - 0.08 * 10.0 * s + 0.06 * 60.0;
    let along_y = 8.0 * s * s + 0.04 * 60.0;
    let wanted = 1e-3 * (2.0 * along_x + 2.0 * 0.05 * along_y / 5.5);
    close(job.lathe().unwrap().unwrap().cut_mm(&place), wanted, 2e-5, "closed form");
}

#[test]
fn the_gauge_measures_what_the_lathe_cut() {
    let job = config::load(Path::new("configs/machine_run.toml")).unwrap();
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let cell = SimulatedCell::new(&job, &renderer).unwrap();
    let mut turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
    let pass = turning.run_pass(&mut |_, _| {}).unwrap();
    let truth = pass.truth_mm.unwrap();
    let range = truth.iter().fold((f64::MAX, f64::MIN), |(l, h), d| (l.min(*d), h.max(*d)));
    assert!(range.1 - range.0 > 5e-3, "the errors show on the part: {range:?}");
    for (station, truth) in pass.profile.stations.iter().zip(truth) {
        let d = station.reading.value().expect("a value");
        assert!((d.d_mm - truth).abs() < 4.0 * d.u_mm(), "{} against {truth}, u {}", d.d_mm, d.u_mm());
    }
}
