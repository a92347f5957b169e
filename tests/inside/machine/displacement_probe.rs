//! A displacement probe as the second head of a run: blind on the side of the tool, twice the
//! error on the opposite one, its ball, its noise, and what is refused.

use std::f64::consts::TAU;

use super::close;
use crate::config;
use crate::job::Job;

const JOB: &str = include_str!("../../../configs/small_shaft.toml");
const LATHE: &str = r#"
[machine.stated]
chain = "carriage"
tool_mm = [0.0, 0.0, 0.0]
head_mm = [0.0, 0.0, 0.0]
head_on = "x_carrier"
carriage_mm = [0.0, 0.0, 0.0]
x_travel_mm = [-20.0, 20.0]
z_travel_mm = [-20.0, 100.0]
"#;
const BOW: &str = "[machine.stated.errors.exz]\nfourier = [{ wavelength_mm = 240.0, amplitude_um = 5.0 }]\n";

fn parsed(probe: &str, errors: &str) -> Result<Job, String> {
    let text = format!("{JOB}[machine]\n[machine.probe]\n{probe}\n{LATHE}{errors}");
    config::parse(&text, "job.toml").map_err(|e| e.to_string())
}

/// The indicated deviation of every station, µm, of a part that this lathe cut to 11.5 mm.
fn indicated_um(job: &Job) -> Vec<(f64, f64, f64)> {
    let cut = job.machine_rows(1).unwrap();
    let truth: Vec<f64> = cut.iter().map(|row| 11.5 + 1e-3 * row.cut_um).collect();
    let rows = job.probe_rows(1, &truth).unwrap();
    assert_eq!(rows.len(), cut.len());
    rows.iter().zip(&cut).map(|(row, cut)| (row.z_mm, row.indicated_um, cut.cut_um)).collect()
}

#[test]
fn a_probe_on_the_tools_side_shows_its_own_part_straight_and_the_opposite_one_twice() {
    let quiet = "noise_um = 0.0\ntip_radius_mm = 1.5\n";
    // 240 mm and 5 µm: the taper's normal stands off by r·α²/2, below a picometre
    for (z, shown, cut) in indicated_um(&parsed(quiet, BOW).unwrap()) {
        close(shown, 0.0, 1e-3, &format!("same side, z {z}"));
        close(cut, 10.0 * (TAU * z / 240.0).cos(), 2e-3, &format!("cut, z {z}"));
    }
    let opposite = format!("side = \"opposite\"\n{quiet}");
    for (z, shown, cut) in indicated_um(&parsed(&opposite, BOW).unwrap()) {
        close(shown, 2.0 * cut, 2e-3, &format!("opposite side, z {z}"));
    }
}

#[test]
fn a_ball_above_the_axis_counts_a_displacement_along_y_by_its_own_radius() {
    // EYX of 4 µm acts on tool and probe alike; the tip stands .5 mm above the axis
    let errors = "[machine.stated.errors.eyx]\npolynomial = { coefficients_um = [4.0] }\n";
    let of = |radius: f64| {
        let probe = format!("noise_um = 0.0\ntip_radius_mm = {radius:.2}\nprobe_mm = [0.0, 0.5, 0.0]\n");
        let job = parsed(&probe, errors).unwrap();
        let truth = vec![11.5; job.machine_rows(1).unwrap().len()];
        job.probe_rows(1, &truth).unwrap()[3].indicated_um
    };
    for radius in [0.0, 2.0, 10.0] {
        // −2h·u_y/R of the ball's centre, −u_y²/R with it
        let run = 5.75 + radius;
        let wanted = -(2.0 * 0.5 * 4.0 + 1e-3 * 16.0) / run;
        close(of(radius), wanted, 5e-3 * wanted.abs(), &format!("r {radius}"));
    }
}

#[test]
fn noise_is_drawn_by_seed_and_counts_twice_on_a_diameter() {
    let job = parsed("noise_um = 0.05\n", "").unwrap();
    let truth = vec![11.5; job.machine_rows(1).unwrap().len()];
    let rows = |pass: u32| job.probe_rows(pass, &truth).unwrap();
    assert_eq!(rows(1), rows(1));
    assert_ne!(rows(1), rows(2));
    assert!(rows(1).iter().all(|row| (row.u_um - 0.1).abs() < 1e-12));
    let own = rows(1);
    let square = own.iter().map(|row| row.indicated_um.powi(2)).sum::<f64>();
    let count = own.len() as f64;
    let found = (square / count).sqrt();
    // 12 readings: within a factor of two
    assert!((0.05..0.2).contains(&found), "{found}");
}

#[test]
fn what_a_probe_cannot_reach_is_refused() {
    let refused = |probe: &str| parsed(probe, "").err().unwrap();
    let far = refused("side = \"opposite\"\nprobe_mm = [18.0, 0.0, 0.0]\n");
    assert!(far.contains("machine.probe.side") && far.contains("travel"), "{far}");
    let high = refused("probe_mm = [0.0, 4.0, 0.0]\n");
    assert!(high.contains("machine.probe.probe_mm[1]"), "{high}");
    let unit = refused("noise_um = 1000.0\n");
    assert!(unit.contains("machine.probe.noise_um"), "{unit}");
}
