//! Controllers that learn from pass to pass and from part to part.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[allow(dead_code, reason = "each test uses its part of the shared plant")]
use crate::inside::support::plant;

use plant::{CUTTING, LENGTH_MM, Plant, largest};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;
use shadowgauge::control::{
    ControlSettings, Controller, ControllerName, NextPass, PartEvent, PartStart, PassContext, build,
    stability, transfer,
};
use shadowgauge::plan::Decision;
use shadowgauge::process::{BaseForm, DisturbanceSettings, ProcessSettings, Stock, TurningProcess};

const NOMINALS_MM: [f64; 4] = [26.5, 26.0, 25.5, 25.0 - 0.0065];

fn settings(controller: ControllerName) -> ControlSettings {
    ControlSettings { controller, ..ControlSettings::default() }
}

fn next_pass(pass: usize) -> Option<NextPass> {
    let nominal_mm = *NOMINALS_MM.get(pass)?;
    Some(NextPass { nominal_mm, cutting: CUTTING, finishing: pass + 1 == NOMINALS_MM.len() })
}

/// Largest |e| of every pass.
fn run_part(controller: &mut dyn Controller, plant: &mut Plant, start: &PartStart<'_>) -> Vec<f64> {
    let mut offset = controller.begin_part(start, plant.z_mm.len());
    let mut passes = Vec::new();
    for (i, nominal) in NOMINALS_MM.into_iter().enumerate() {
        let plan = plant.plan(i as u32 + 1, nominal, offset.clone());
        passes.push(largest(&plant.cut(&plan)));
        let context = PassContext { next: next_pass(i + 1), ..PassContext::default() };
        match controller.decide_in(&plan, &plant.measured(plan.pass), &context) {
            Decision::Offset(next) => offset = next,
            Decision::Held(reason) => println!("{} held after pass {}: {reason}", controller.name(), i + 1),
        }
    }
    passes
}

/// The disturbances: wear 1.5 µm radial per pass growing towards the chuck, drift 1 µm per
/// pass, repeatability 0.5 µm, stock form 50 µm, C ± 10 %.
fn disturbed(seed: u64, random: bool) -> Plant {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut plant = Plant::new(100);
    if random {
        plant.force = rng.random_range(0.9..1.1);
        let phases: Vec<(f64, f64)> =
            (1..6).map(|_| (rng.random_range(0.0..6.3), rng.sample(StandardNormal))).collect();
        for (d, z) in plant.diameter_mm.iter_mut().zip(&plant.z_mm) {
            let waves = phases.iter().enumerate();
            let form: f64 = waves.map(|(k, (p, a))| a * (k as f64 * 3.0 * z / LENGTH_MM + p).cos()).sum();
            *d += 0.05 * form / (2.5_f64).sqrt();
        }
    }
    let mut per_pass = std::collections::BTreeMap::new();
    plant.shift = Box::new(move |pass, z| {
        let common = *per_pass
            .entry(pass)
            .or_insert_with(|| if random { 0.5e-3 * rng.sample::<f64, _>(StandardNormal) } else { 0.0 });
        let worn = 1.5e-3 * (f64::from(pass - 1) + (1.0 - z / LENGTH_MM));
        let drift = 0.5e-3 * f64::from(pass);
        worn + drift + 0.5 * common
    });
    plant
}

/// Errors of 20 disturbed shafts, by pass, each pass sorted, µm.
fn disturbed_shafts(settings: &ControlSettings, random: bool) -> Vec<Vec<f64>> {
    let seeds = if random { 20 } else { 1 };
    let mut by_pass = vec![Vec::new(); NOMINALS_MM.len()];
    for seed in 0..seeds {
        let mut plant = disturbed(seed, random);
        let mut controller = build(settings, &plant.z_mm).expect("a controller");
        let errors = run_part(controller.as_mut(), &mut plant, &PartStart::default());
        for (pass, e) in by_pass.iter_mut().zip(errors) {
            pass.push(e * 1e3);
        }
    }
    by_pass.iter_mut().for_each(|e| e.sort_by(f64::total_cmp));
    by_pass
}

/// A model whose C is wrong by 25 % and whose supports are twice as stiff as the plant's.
fn wrong_model() -> ControlSettings {
    let mut wrong = settings(ControllerName::Model);
    wrong.model.coefficient_n = Some(1.25 * wrong.model.workpiece().coefficient_n);
    wrong.model.chuck_n_per_um = Some(2.0 * 50.0);
    wrong.model.tailstock_n_per_um = Some(2.0 * 20.0);
    wrong
}

#[test]
fn a_wrong_model_learns_the_shaft_under_disturbances() {
    let none = disturbed_shafts(&settings(ControllerName::None), true);
    let model = disturbed_shafts(&wrong_model(), true);
    let middle = model[0].len() / 2;
    for pass in 0..4 {
        let worst = model[pass].last().expect("20 shafts");
        println!(
            "pass {}: median {:.2}, worst {worst:.2} µm; none {:.2}",
            pass + 1,
            model[pass][middle],
            none[pass][middle]
        );
    }
    let share = model[2].last().expect("20") / none[2][middle];
    assert!(share <= 0.06, "after two corrected passes {share:.3} of none");
    assert!(model[3][19] <= 3.0 && model[3][middle] <= 1.5);
    assert!((1..4).all(|pass| model[pass][19] < none[pass][0]), "no pass worse than without control");
    assert_eq!(model[0], none[0]);
    let calm = disturbed_shafts(&wrong_model(), false);
    println!("without random disturbance {:.3} µm", calm[3][0]);
    assert!(calm[3][0] <= 0.5);
}

#[test]
fn the_other_controllers_under_the_same_disturbances_are_reported() {
    for controller in ControllerName::ALL {
        let passes = disturbed_shafts(&settings(controller), true);
        let text: Vec<String> = passes.iter().map(|e| format!("{:.2} ({:.2})", e[10], e[19])).collect();
        println!("{controller}: median (worst) {} µm", text.join(", "));
        assert!(controller == ControllerName::None || passes[3][10] < 40.0);
    }
}

/// One station (two for shapes) with a linear plant of error copying, tiny errors, guards wide
/// open.
fn linear_loop(settings: &ControlSettings, gain: f64, passes: usize) -> Vec<f64> {
    let scale = 1e-3;
    let mut plant = Plant::new(3);
    let mut controller = build(settings, &plant.z_mm).expect("a stable controller");
    let (mut e, mut offset) = (scale, controller.begin_part(&PartStart::default(), 3));
    let mut errors = vec![1.0];
    for pass in 1..passes as u32 {
        let plan = plant.plan(pass, 25.0, offset.clone());
        plant.diameter_mm = vec![25.0 + e; 3];
        match controller.decide(&plan, &plant.measured(pass)) {
            Decision::Offset(next) => offset = next,
            Decision::Held(reason) => panic!("{reason}"),
        }
        e = (1.0 - gain) * e - gain * offset.o_mm[1] + gain * scale;
        errors.push(e / scale);
    }
    errors
}

#[test]
fn built_controllers_behave_as_their_transfer_functions() {
    let mut names =
        vec![ControllerName::Lsq, ControllerName::Ewma, ControllerName::Dewma, ControllerName::Ilc];
    names.push(ControllerName::Pid);
    for name in names {
        let mut s = settings(name);
        s.guards.deadband_mm = 0.0;
        s.guards.response_from_mm = 1.0;
        s.ilc.q_cutoff_mm = 0.0;
        (s.ewma.mean_start, s.dewma.mean_start) = (false, false);
        // the derivative of the transfer function acts on the step of the first pass, that of the
        // law begins at zero
        s.pid.kd = 0.0;
        let expected = transfer(&s).expect("feedback").response(stability::Plant::Copying, 0.9, 30);
        let found = linear_loop(&s, 0.9, 30);
        let worst = expected.iter().zip(&found).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        println!("{name}: largest difference {worst:e}, e(5) = {:.4}", found[4]);
        assert!(worst < 1e-9, "{name}: {expected:?} {found:?}");
    }
}

#[test]
fn run_to_run_estimates_follow_their_recurrences_and_track_a_ramp() {
    // a disturbance that grows by 0.001 per pass: EWMA lags by about ramp/λ, double EWMA ends
    // without error
    let ramp = |s: &ControlSettings| {
        let mut plant = Plant::new(3);
        let mut controller = build(s, &plant.z_mm).expect("a controller");
        let mut offset = controller.begin_part(&PartStart::default(), 3);
        let mut e = 0.0;
        for pass in 1..=60_u32 {
            e = 0.001 * f64::from(pass) - 0.95 * offset.o_mm[0];
            let plan = plant.plan(pass, 25.0, offset.clone());
            plant.diameter_mm = vec![25.0 + e; 3];
            let Decision::Offset(next) = controller.decide(&plan, &plant.measured(pass)) else {
                panic!("released")
            };
            offset = next;
        }
        e
    };
    let mut s = settings(ControllerName::Ewma);
    s.guards.deadband_mm = 0.0;
    let lag = ramp(&s);
    assert!((lag - 0.001 / s.ewma.weight).abs() < 1e-9, "ramp/λ, got {lag}");
    s.controller = ControllerName::Dewma;
    let left = ramp(&s);
    assert!(left.abs() < 1e-6, "{left}");
}

#[test]
fn the_q_filter_is_zero_phase_and_halves_its_cutoff() {
    let z: Vec<f64> = (0..200).map(|i| 2.5 + 5.0 * f64::from(i)).collect();
    let q = stability::whittaker(40.0, &z);
    let line = nalgebra::DVector::from_fn(200, |i, _| 3.0 + 0.01 * i as f64);
    assert!((&q * &line - &line).amax() < 1e-9, "constants and lines pass, to the very ends");
    let wave = nalgebra::DVector::from_fn(200, |i, _| (std::f64::consts::TAU * z[i] / 40.0).sin());
    let passed = &q * &wave;
    for i in 40..160 {
        assert!((passed[i] - 0.5 * wave[i]).abs() < 1e-6, "{i}: {} of {}", passed[i], wave[i]);
    }
    assert!((&q - q.transpose()).amax() < 1e-12);
}

#[test]
fn iterative_learning_converges_as_its_norm_says() {
    let z: Vec<f64> = (0..40).map(|i| 2.5 + 5.0 * f64::from(i)).collect();
    let q = stability::whittaker(30.0, &z);
    // a plant that couples neighbours: a command at one station is cut in part at the next
    let plant = nalgebra::DMatrix::from_fn(40, 40, |i, j| match i.abs_diff(j) {
        0 => 0.8,
        1 => 0.08,
        _ => 0.0,
    });
    let report = stability::iteration(&q, 1.05, &plant);
    println!("{report:?}");
    assert!(report.spectral_radius < 1.0 && report.norm < 1.0);
    let d = nalgebra::DVector::from_fn(40, |i, _| 0.05 * (1.0 - (i as f64 / 19.5 - 1.0).powi(2)));
    let mut o = nalgebra::DVector::zeros(40);
    let mut norms = Vec::new();
    for _ in 0..60 {
        let e: nalgebra::DVector<f64> = &d - &plant * &o;
        norms.push(e.norm());
        o = &q * (o + e * 1.05);
    }
    assert!(norms.windows(2).take(3).all(|w| w[1] < w[0]), "falls from the first pass on");
    assert!(norms[59] <= report.left_over * d.norm() && norms[59] < 0.01 * d.norm());
    let fast = stability::iteration(&nalgebra::DMatrix::identity(40, 40), 1.999, &(&plant * 1.3));
    assert!(fast.spectral_radius > 1.0 && fast.left_over.is_infinite());
}

#[test]
fn learning_from_part_to_part_follows_wear_and_starts_again_with_a_new_insert() {
    // a part of four passes; the tool wears by 1 µm of radius per part and is changed every 10
    // parts
    let first_pass = |enabled: bool, parts: usize| {
        let mut s = settings(ControllerName::Pid);
        s.parts.enabled = enabled;
        let mut controller = build(&s, &Plant::new(20).z_mm).expect("a controller");
        let mut errors = Vec::new();
        for part in 0..parts {
            let worn = 1e-3 * (part % 10) as f64;
            let mut plant = Plant::new(20);
            plant.shift = Box::new(move |_, z| worn * (1.0 - 0.3 * z / LENGTH_MM));
            let event =
                if part > 0 && part % 10 == 0 { PartEvent::InsertChanged } else { PartEvent::Continued };
            let start = PartStart { event, stock: None };
            errors.push(run_part(controller.as_mut(), &mut plant, &start));
        }
        errors
    };
    let (alone, learning) = (first_pass(false, 25), first_pass(true, 25));
    let worst_of = |runs: &[Vec<f64>], pass: usize| runs.iter().map(|p| p[pass] * 1e3).fold(0.0, f64::max);
    println!(
        "first pass, parts 4-10: {:.2} µm alone, {:.2} µm learning",
        worst_of(&alone[3..10], 0),
        worst_of(&learning[3..10], 0)
    );
    println!(
        "parts 11-25: {:.2} µm alone, {:.2} µm learning",
        worst_of(&alone[10..], 0),
        worst_of(&learning[10..], 0)
    );
    println!(
        "last pass: {:.2} µm alone, {:.2} µm learning",
        worst_of(&alone[10..], 3),
        worst_of(&learning[10..], 3)
    );
    assert!(worst_of(&alone[3..10], 0) > 40.0 && worst_of(&learning[3..10], 0) < 6.0);
    assert!(worst_of(&learning[10..], 0) < 3.0, "a new insert starts from what the first one needed");
    assert!(worst_of(&learning[10..], 3) < worst_of(&alone[10..], 3) + 0.5);
}

/// The turning process itself as plant, with its true mean diameters in place of a gauge.
fn turn_on_process(settings: &ControlSettings, disturbance: DisturbanceSettings, seed: u64) -> Vec<Vec<f64>> {
    let mut process_settings = ProcessSettings { disturbance, ..ProcessSettings::default() };
    process_settings.texture.rms_um = 0.0;
    process_settings.texture.lobe_um = 0.0;
    let stock = Stock { diameter_mm: 27.0, length_mm: LENGTH_MM };
    let mut process =
        TurningProcess::new(&process_settings, stock, &BaseForm::default(), seed).expect("a blank");
    let shaft = Plant::new(100);
    let mut controller = build(settings, &shaft.z_mm).expect("a controller");
    let stations = |process: &TurningProcess| -> Vec<f64> {
        let nodes: Vec<(f64, f64)> = process.node_z_mm().zip(process.diameter_mm().iter().copied()).collect();
        let mean = |z: &f64| {
            let near: Vec<f64> = nodes.iter().filter(|n| (n.0 - z).abs() <= 2.5).map(|n| n.1).collect();
            near.iter().sum::<f64>() / near.len() as f64
        };
        shaft.z_mm.iter().map(mean).collect()
    };
    // a run scans the stock for the model-based controller
    let stock = plant::profile(0, &shaft.z_mm, &stations(&process));
    let start = PartStart { stock: Some(&stock), ..PartStart::default() };
    let mut offset = controller.begin_part(&start, 100);
    let mut errors = Vec::new();
    for (i, nominal) in NOMINALS_MM.into_iter().enumerate() {
        let plan = shaft.plan(i as u32 + 1, nominal, offset.clone());
        process.cut(&plan).expect("a pass");
        let diameters = stations(&process);
        errors.push(diameters.iter().map(|d| (d - nominal) * 1e3).collect());
        let context = PassContext { next: next_pass(i + 1), ..PassContext::default() };
        let measured = plant::profile(plan.pass, &shaft.z_mm, &diameters);
        match controller.decide_in(&plan, &measured, &context) {
            Decision::Offset(next) => offset = next,
            Decision::Held(reason) => println!("seed {seed} held: {reason}"),
        }
    }
    errors
}

#[test]
fn a_wrong_model_learns_the_turning_process() {
    let calm = DisturbanceSettings { wear_um_per_pass: 1.5, drift_um_per_pass: 1.0, ..Default::default() };
    let settled = turn_on_process(&wrong_model(), calm.clone(), 3);
    println!("without random disturbance {:.2}, {:.2} µm", largest(&settled[2]), largest(&settled[3]));
    assert!(largest(&settled[2]) <= 0.5 && largest(&settled[3]) <= 0.5);
    let rough = DisturbanceSettings { repeatability_um: 0.5, stock_form_um: 50.0, force_spread: 0.1, ..calm };
    let (mut last, mut shares) = (Vec::new(), Vec::new());
    for seed in 0..20 {
        let model = turn_on_process(&wrong_model(), rough.clone(), seed);
        let none = turn_on_process(&settings(ControllerName::None), rough.clone(), seed);
        assert_eq!(model[0], none[0], "pass 1 does not know the controller");
        let share = largest(&model[2]) / largest(&none[2]);
        shares.push(share);
        assert!((1..4).all(|pass| largest(&model[pass]) < largest(&none[pass])), "seed {seed}");
        last.push(largest(&model[3]));
    }
    last.sort_by(f64::total_cmp);
    shares.sort_by(f64::total_cmp);
    println!("after two: shares of none {shares:.3?}");
    println!("after three corrected passes: {last:.2?} µm");
    assert!(shares[19] <= 0.06);
    assert!(last[10] <= 1.5 && last[19] <= 3.0);
}
