//! What is exported for a control, and whether the stated uncertainty of the tool's error holds.

use super::{GEOMETRY, TRUTH, config, identified, truth, whole};
use crate::identification::IdentificationConfig;
use crate::identification::export::{knot_program, knots, screw_table, tool_errors};
use crate::inside::machine::close;
use crate::machine::conditions::{Conditions, Direction};
use crate::machine::{Chain, MachineSettings, Motion};
use crate::studies::machine_readings::SimulatedMachine;

/// Error of the tool of a machine, mm along X and Z.
fn tool_mm(machine: &MachineSettings, motion: &Motion, [x, z]: [f64; 2], direction: Direction) -> [f64; 2] {
    let state = Conditions { x_direction: direction, z_direction: direction, ..Conditions::default() };
    let values = motion.values(x, z, &state);
    let shift = Chain { topology: machine.chain, values }.pose(&machine.tool(x, z)).shift_mm;
    [shift.x, shift.z]
}

#[test]
fn screw_tables_are_actual_positions_in_both_directions() {
    let found = identified(&whole(1e-3), TRUTH, 1);
    let (machine, motion) = (truth(TRUTH), truth(TRUTH).motion().unwrap());
    for (is_x, other) in [(true, 40.0), (false, 12.5)] {
        let text = screw_table(&found.chosen, &found.file.machine, is_x, other);
        let rows: Vec<Vec<f64>> =
            text.lines().map(|l| l.split(' ').map(|v| v.parse().unwrap()).collect()).collect();
        assert!(rows.len() <= 256 && rows.iter().all(|row| row.len() == 3));
        assert!(rows.windows(2).all(|pair| pair[1][0] > pair[0][0]));
        let off = |row: &[f64], direction: Direction, column: usize| {
            let at = if is_x { [row[0], other] } else { [other, row[0]] };
            let error = tool_mm(&machine, &motion, at, direction)[usize::from(!is_x)];
            1e3 * (row[column] - row[0] - error)
        };
        // a constant is the set-up; what is left is the identification
        let first = off(&rows[0], Direction::Forward, 1);
        for row in &rows {
            close(off(row, Direction::Forward, 1), first, 0.05, "forward");
            close(off(row, Direction::Backward, 2), first, 0.05, "backward");
        }
    }
}

#[test]
fn knots_leave_no_more_than_their_chord() {
    let found = identified(&whole(1e-3), TRUTH, 1);
    let machine = &found.file.machine;
    let coarse = knots(&found.chosen, machine, 12.5, 1e-3);
    let fine = knots(&found.chosen, machine, 12.5, 1e-5);
    assert!(coarse.len() > 3 && fine.len() > 2 * coarse.len(), "{} {}", coarse.len(), fine.len());
    assert!(coarse.windows(2).all(|pair| pair[1].z_mm > pair[0].z_mm));
    for pair in coarse.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (z, x) = (0.5 * (a.z_mm + b.z_mm), 0.5 * (a.x_mm + b.x_mm));
        let wanted = 12.5 - found.chosen.tool(machine, [12.5, z], 0, Direction::Backward).value;
        close(x, wanted, 1.1e-3, "chord");
    }
    let text = knot_program(&coarse, "lathe");
    // towards the chuck: the first block is the farthest
    let blocks: Vec<&str> = text.lines().skip(2).collect();
    assert!(blocks[0].starts_with("G1 X") && blocks[0].ends_with("Z140.0000"), "{}", blocks[0]);
    assert_eq!(blocks.len(), coarse.len());
    let rows = tool_errors(&found.chosen, machine);
    assert_eq!(rows.len(), 21 * 21);
    assert!(rows.iter().all(|row| row.u_x_um > 0.0 && row.u_x_um < 0.1), "{:?}", rows[0]);
}

/// Stated uncertainty of the tool's error over a part, of drawn machines: 95 % within 2u.
#[test]
fn the_tools_error_lies_within_its_uncertainty() {
    let readings = "[[readings]]\ninstrument = \"cylinder\"\nradius_mm = 12.5\nu_um = 0.1\nplan = { from_mm = 0.0, to_mm = 100.0, positions = 26, quantities = [\"radius\"] }\n";
    let text = format!(
        "name = \"a\"\nmodel = \"structured\"\nidentify = [\"exz\", \"b0c\"]\n{readings}[machine]{GEOMETRY}"
    );
    let (mut inside, mut count) = (0, 0);
    for seed in 0..40_u32 {
        let phase = (f64::from(seed) * 47.0).rem_euclid(360.0);
        let long = 60.0 + f64::from(seed % 7) * 15.0;
        let errors = format!(
            "b0c_urad = {}\n[errors.exz]\nfourier = [{{ wavelength_mm = {long}, amplitude_um = 0.8, phase_deg = {phase} }}, {{ wavelength_mm = 33.0, amplitude_um = 0.15, phase_deg = {} }}]\n",
            f64::from(seed) - 20.0,
            -3.0 * phase
        );
        let found = identified(&config(&text), &errors, u64::from(seed));
        let (machine, motion) = (truth(&errors), truth(&errors).motion().unwrap());
        let z = |k: usize| 4.0 + 4.0 * k as f64;
        let off: Vec<f64> = (0..24)
            .map(|k| {
                let own = found.chosen.tool(&found.file.machine, [12.5, z(k)], 0, Direction::Forward);
                own.value - tool_mm(&machine, &motion, [12.5, z(k)], Direction::Forward)[0]
            })
            .collect();
        // the mean is the set-up of the tool
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        for (k, off) in off.iter().enumerate() {
            let u = found.chosen.tool(&found.file.machine, [12.5, z(k)], 0, Direction::Forward).u;
            inside += usize::from((off - mean).abs() <= 2.0 * u);
            count += 1;
        }
    }
    let share = inside as f64 / f64::from(count);
    println!("tool error within 2u: {:.1} % of {count}", 1e2 * share);
    assert!((0.92..=0.995).contains(&share), "{share}");
}

/// The config of the book: what it identifies against the lathe that drew its readings.
#[test]
fn the_example_identifies_its_lathe() {
    let text = include_str!("../../../../configs/machine_identify.toml");
    let config: IdentificationConfig = toml::from_str(text).unwrap();
    let lathe: toml::Table = toml::from_str(include_str!("../../../../configs/machine/lathe.toml")).unwrap();
    let machine: MachineSettings = lathe["machine"].clone().try_into().unwrap();
    let simulated = SimulatedMachine::new(machine.clone(), 20.0, 1).unwrap();
    let set = |k: usize| {
        let text = simulated.text(&config.readings[k], k).unwrap();
        crate::identification::checked_set(&config, k, text.as_bytes(), "drawn.csv").unwrap()
    };
    let sets: Vec<_> = (0..config.readings.len()).map(set).collect();
    let found = crate::identification::identify(&config, &sets).unwrap();
    println!("{:?} {:?} birge {}", found.file.rank, found.file.models, found.file.birge_ratio);
    assert!(found.file.rank.inseparable.is_empty(), "{:?}", found.file.rank);
    assert!(found.file.birge_ratio < 1.3, "{}", found.file.birge_ratio);
    assert_eq!(found.file.head.as_deref(), Some("telecentric 12"));
    let motion = machine.motion().unwrap();
    let off: Vec<f64> = (0..25)
        .map(|k| {
            let at = [30.0, -60.0 + 7.5 * f64::from(k)];
            let own = found.chosen.tool(&found.file.machine, at, 0, Direction::Forward).value;
            1e3 * (own - tool_mm(&machine, &motion, at, Direction::Forward)[0])
        })
        .collect();
    let mean = off.iter().sum::<f64>() / 25.0;
    let rms = (off.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 25.0).sqrt();
    println!("rms {rms} µm");
    assert!(rms < 0.1, "{rms}");
    let b = found.file.positioning.iter().find(|row| row.error == "EZZ").unwrap();
    assert!(b.parameters.both.unwrap().r < 2.0 && b.parameters.short_of_standard.is_empty(), "{b:?}");
}

/// Profiles of 0.8 µm peak to valley from 51 readings of 0.01 µm, each less its mean.
#[test]
fn profiles_come_back_below_the_readings_own_scatter() {
    let geometry = "chain = \"carriage\"\ntool_mm = [0, 0, 0]\nhead_mm = [0, 0, 0]\nhead_on = \"x_carrier\"\ncarriage_mm = [0, 0, 0]\nx_travel_mm = [-1, 30]\nz_travel_mm = [0, 100]\n";
    let readings = "[[readings]]\ninstrument = \"cylinder\"\nradius_mm = 12.5\nu_um = 0.01\nplan = { from_mm = 0.0, to_mm = 100.0, positions = 51, quantities = [\"radius\"] }\n";
    let config =
        config(&format!("name = \"a\"\nidentify = [\"exz\", \"b0c\"]\n{readings}[machine]\n{geometry}"));
    let mut draws = crate::inside::machine::Draws(7);
    let mut all: Vec<f64> = (0..40)
        .map(|seed| {
            let mut wave = |k: f64| {
                let (long, phase) = (100.0 / (0.7 * k + 0.3 * draws.next().abs()), 180.0 * draws.next());
                (long, (1.0 + 0.5 * draws.next()) / k, phase)
            };
            let waves = [1.0, 2.0, 3.0, 4.0, 5.0].map(&mut wave);
            let at = |z: f64| -> f64 {
                waves.iter().map(|(l, a, p)| a * (std::f64::consts::TAU * z / l + p.to_radians()).cos()).sum()
            };
            let values: Vec<f64> = (0..=500).map(|k| at(0.2 * f64::from(k))).collect();
            let high = values.iter().copied().fold(f64::MIN, f64::max);
            let scale = 0.8 / (high - values.iter().copied().fold(f64::MAX, f64::min));
            let list: Vec<String> = waves
                .iter()
                .map(|(l, a, p)| {
                    format!(
                        "{{ wavelength_mm = {l:.9}, amplitude_um = {:.9}, phase_deg = {p:.9} }}",
                        scale * a
                    )
                })
                .collect();
            let text = format!("{geometry}[errors.exz]\nfourier = [{}]\n", list.join(", "));
            let sets = super::sets(&config, &toml::from_str(&text).unwrap(), seed);
            let found = crate::identification::identify(&config, &sets).unwrap().chosen;
            let tool = |z: f64| 1e3 * found.tool(&config.machine, [12.5, z], 0, Direction::Forward).value;
            let off: Vec<f64> = (0..=100).map(f64::from).map(|z| tool(z) - scale * at(z)).collect();
            let mean = off.iter().sum::<f64>() / 101.0;
            (off.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 101.0).sqrt()
        })
        .collect();
    all.sort_by(f64::total_cmp);
    let mean = all.iter().sum::<f64>() / 40.0;
    println!("profiles: rms {mean} µm in the mean, {} of 95 %", all[37]);
    assert!(mean <= 0.008 && all[37] <= 0.010, "{mean} {}", all[37]);
}
