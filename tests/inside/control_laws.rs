//! Control laws against independent evaluations of their recurrences and on a slender shaft.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[allow(dead_code, reason = "each test uses its part of the shared plant")]
use crate::inside::support::plant;

#[path = "control_laws/external.rs"]
mod external;

use plant::{CUTTING, Plant, largest};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;
use shadowgauge::control::{
    ApplyTo, ControlError, ControlSettings, ControllerName, Estimator, FirstPass, NextPass, OffsetForm,
    PassContext, Pid, PidAlgorithm, PidSettings, Shapes, Spatial, build, fit,
};
use shadowgauge::plan::{Decision, DiameterOffset, HeldReason, PassPlan, PlannedForm};
use shadowgauge::profile::{Reading, Reason};

const NOMINALS_MM: [f64; 4] = [26.5, 26.0, 25.5, 25.0 - 0.0065];

/// Largest |e| and (least, most) e of every pass of the preset's job.
fn run_job(settings: &ControlSettings) -> Vec<(f64, f64, f64)> {
    let mut plant = Plant::new(100);
    let mut controller = build(settings, &plant.z_mm).expect("a controller");
    let mut offset = DiameterOffset::zero(100);
    let mut passes = Vec::new();
    for (i, nominal) in NOMINALS_MM.into_iter().enumerate() {
        let plan = plant.plan(i as u32 + 1, nominal, offset.clone());
        let e = plant.cut(&plan);
        let least = e.iter().copied().fold(f64::INFINITY, f64::min);
        let most = e.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        passes.push((largest(&e), least, most));
        match controller.decide(&plan, &plant.measured(plan.pass)) {
            Decision::Offset(next) => offset = next,
            Decision::Held(reason) => panic!("held after pass {}: {reason}", i + 1),
        }
    }
    passes
}

fn settings(controller: ControllerName) -> ControlSettings {
    ControlSettings { controller, ..ControlSettings::default() }
}

#[test]
fn pid_brings_the_job_within_its_target_and_the_uncontrolled_error_grows() {
    let none = run_job(&settings(ControllerName::None));
    let pid = run_job(&settings(ControllerName::Pid));
    println!("none {none:.5?}\npid  {pid:.5?}");
    assert!(none.windows(2).all(|w| w[1].0 > w[0].0), "errors grow without control");
    assert!((0.038..0.046).contains(&none[0].0) && (0.050..0.060).contains(&none[3].0));
    assert_eq!(pid[0], none[0], "the first pass knows no controller");
    assert!(pid[1..].iter().all(|p| p.0 <= 0.003), "at most 3 µm in passes 2-4");
    assert!(pid[3].0 <= none[3].0 / 15.0);
}

#[test]
fn a_line_leaves_most_of_a_barrel_and_a_parabola_less() {
    let none = run_job(&settings(ControllerName::None))[3].0;
    let mut line = settings(ControllerName::Lsq);
    let share_of_line = run_job(&line)[3].0 / none;
    line.lsq.shapes = Shapes::Quadratic;
    let share_of_parabola = run_job(&line)[3].0 / none;
    println!("line leaves {share_of_line:.3}, parabola {share_of_parabola:.3} of the error without control");
    assert!((0.4..0.75).contains(&share_of_line));
    assert!((0.15..0.45).contains(&share_of_parabola));
}

/// Eqs 16 and 18 written out as sums over all errors so far.
fn direct(settings: &PidSettings, errors: &[f64]) -> Vec<f64> {
    (0..errors.len())
        .map(|k| {
            let mut difference = 0.0;
            for j in 1..=k {
                let weight =
                    settings.derivative_filter.powi((k - j) as i32) * (1.0 - settings.derivative_filter);
                difference += weight * (errors[j] - errors[j - 1]);
            }
            let sum: f64 = errors[..=k].iter().sum();
            let integral = if k == 0 && settings.first_pass == FirstPass::Proportional { 0.0 } else { sum };
            settings.kp * errors[k] + settings.ki * integral + settings.kd * difference
        })
        .collect()
}

fn random_pid(rng: &mut impl Rng) -> PidSettings {
    PidSettings {
        kp: rng.random_range(0.0..2.0),
        ki: rng.random_range(0.0..0.5),
        kd: rng.random_range(0.0..0.5),
        derivative_filter: if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..0.9) },
        first_pass: if rng.random_bool(0.5) { FirstPass::Full } else { FirstPass::Proportional },
        ..PidSettings::default()
    }
}

#[test]
fn positional_and_incremental_follow_the_recurrences_for_any_gains() {
    let mut rng = Pcg64::seed_from_u64(18);
    let mut worst = 0.0_f64;
    for _ in 0..500 {
        let positional = random_pid(&mut rng);
        let incremental = PidSettings { algorithm: PidAlgorithm::Incremental, ..positional.clone() };
        let errors: Vec<f64> = (0..20).map(|_| rng.random_range(-0.1..0.1)).collect();
        let expected = direct(&positional, &errors);
        for settings in [positional, incremental] {
            let mut pid = Pid::new(&settings, 1);
            for (e, u) in errors.iter().zip(&expected) {
                worst = worst.max((pid.step(&[*e])[0] - u).abs());
            }
        }
    }
    println!("largest difference from the recurrences {worst:e}");
    assert!(worst < 1e-12);
}

#[test]
fn the_error_transfer_plant_gives_the_sequence_of_eq_18() {
    let settings = PidSettings { first_pass: FirstPass::Proportional, ..PidSettings::default() };
    let mut pid = Pid::new(&settings, 1);
    let mut e = 0.108;
    let mut sequence = vec![e];
    for _ in 0..8 {
        e = 1.3566 * e - 0.704 * pid.step(&[e])[0];
        sequence.push(e);
    }
    println!("{sequence:.4?}");
    for (e, printed) in sequence.iter().zip([0.108, 0.055, 0.024, 0.007]) {
        assert!((e - printed).abs() < 5.1e-4);
    }
    assert!((sequence[8] + 0.0115).abs() < 5e-4, "reaches -.0115 at the ninth");
}

#[test]
fn a_saturated_output_does_not_wind_up() {
    let limited = PidSettings { ki: 0.5, output_limit_mm: Some(0.02), ..PidSettings::default() };
    for algorithm in [PidAlgorithm::Positional, PidAlgorithm::Incremental] {
        let mut pid = Pid::new(&PidSettings { algorithm, ..limited.clone() }, 1);
        for _ in 0..50 {
            assert!(pid.step(&[0.1])[0] <= 0.02);
        }
        let after = pid.step(&[-0.01])[0];
        assert!(after < 0.0, "{algorithm:?}: the output turns with the error at once, got {after}");
    }
    let mut winding = Pid::new(&PidSettings { output_limit_mm: None, ..limited }, 1);
    (0..50).for_each(|_| drop(winding.step(&[0.1])));
    assert!(winding.step(&[-0.01])[0] > 1.0, "without the limit the sum has wound up");
}

#[test]
fn rate_limit_and_deadband_hold() {
    let settings = PidSettings { rate_limit_mm: Some(0.004), deadband_mm: 0.001, ..PidSettings::default() };
    let mut pid = Pid::new(&settings, 2);
    let outputs: Vec<Vec<f64>> = (0..4).map(|_| pid.step(&[0.05, 0.0009])).collect();
    for (k, output) in outputs.iter().enumerate() {
        assert!((output[0] - 0.004 * (k + 1) as f64).abs() < 1e-15);
        assert_eq!(output[1], 0.0);
    }
}

#[test]
fn modal_pid_corrects_its_shapes_and_nothing_else() {
    let mut modal = settings(ControllerName::Pid);
    modal.pid.spatial = Spatial::Modal(Shapes::Polynomial { degree: 4 });
    let none = run_job(&settings(ControllerName::None))[3].0;
    let share = run_job(&modal)[3].0 / none;
    println!("five shapes leave {share:.3}");
    assert!(share < 0.1);
}

#[test]
fn weighted_fit_agrees_with_the_normal_equations_and_states_its_uncertainty() {
    let mut rng = Pcg64::seed_from_u64(4);
    let z: Vec<f64> = (0..30).map(|i| f64::from(i) * 5.0).collect();
    let design = Shapes::Line.design(&z).expect("stations enough");
    let u = nalgebra::DVector::from_fn(30, |i, _| 1e-4 * (1.0 + i as f64 / 10.0));
    let runs = 2000;
    let mut slopes = Vec::new();
    let mut stated = 0.0;
    for _ in 0..runs {
        let y = nalgebra::DVector::from_fn(30, |i, _| {
            3e-3 + 2e-3 * design[(i, 1)] + u[i] * rng.sample::<f64, _>(rand_distr::StandardNormal)
        });
        let fit = fit::weighted(&design, &y, &u).expect("full rank");
        let w = nalgebra::DMatrix::from_diagonal(&u.map(|u| u.powi(-2)));
        let normal = (design.transpose() * &w * &design).try_inverse().expect("regular");
        let closed = &normal * design.transpose() * &w * &y;
        assert!((&fit.coefficients - closed).amax() < 1e-12);
        assert!((&fit.covariance - &normal).amax() < 1e-12 * normal.amax());
        stated = fit.covariance[(1, 1)].sqrt();
        slopes.push(fit.coefficients[1]);
    }
    let mean = slopes.iter().sum::<f64>() / f64::from(runs);
    let sd = (slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / f64::from(runs - 1)).sqrt();
    println!("slope: stated u {stated:e}, observed {sd:e}");
    assert!((mean - 2e-3).abs() < 4.0 * sd / f64::from(runs).sqrt());
    assert!((sd / stated - 1.0).abs() < 0.07);
}

#[test]
fn the_absolute_form_is_refused_with_its_limit_and_built_where_insisted_on() {
    let mut absolute = settings(ControllerName::Pid);
    absolute.pid.form = OffsetForm::Absolute;
    let refused = build(&absolute, &[1.0, 2.0]).err().expect("unstable at g = .95");
    println!("{refused}");
    assert!(matches!(&refused, ControlError::Unstable { spectral_radius, .. } if *spectral_radius > 1.0));
    assert!(refused.to_string().contains("insist_on_unstable"));
    absolute.allow_unstable = true;
    let passes = run_job(&absolute);
    println!("{passes:.5?}");
    assert!(passes[1].0 < 0.01 && passes[2].0 > 0.03, "corrected, then not: the absolute form oscillates");
    absolute.allow_unstable = false;
    absolute.plant_gain = 0.8;
    assert!(build(&absolute, &[1.0, 2.0]).is_ok());
}

#[test]
fn gaps_hold_unless_interpolation_is_allowed_and_then_it_is_said() {
    let mut plant = Plant::new(100);
    let plan = plant.plan(1, 26.5, DiameterOffset::zero(100));
    plant.cut(&plan);
    let whole = plant.measured(1);
    let mut gapped = whole.clone();
    gapped.stations[40].reading = Reading::Gap(Reason::Contaminated);
    gapped.stations[41].reading = Reading::Gap(Reason::Contaminated);

    let strict = settings(ControllerName::Pid);
    let held = build(&strict, &plant.z_mm).expect("a controller").decide(&plan, &gapped);
    assert_eq!(held, Decision::Held(HeldReason::Gaps { missing: 2, of: 100 }));

    let mut filling = strict.clone();
    filling.gaps.interpolate_run = 2;
    let mut controller = build(&filling, &plant.z_mm).expect("a controller");
    let (Decision::Offset(filled), Decision::Offset(full)) =
        (controller.decide(&plan, &gapped), build(&strict, &plant.z_mm).expect("one").decide(&plan, &whole))
    else {
        panic!("both release")
    };
    let worst = largest(&filled.o_mm.iter().zip(&full.o_mm).map(|(a, b)| a - b).collect::<Vec<_>>());
    assert!(worst < 2e-4, "linear between neighbours, off by {worst}");
    assert!(controller.notes()[0].contains("202.5, 207.5"), "{:?}", controller.notes());

    gapped.stations[42].reading = Reading::Gap(Reason::Contaminated);
    assert_eq!(controller.decide(&plan, &gapped), Decision::Held(HeldReason::Gaps { missing: 3, of: 100 }));
    let mut end = whole;
    end.stations[99].reading = Reading::Gap(Reason::Border);
    assert_eq!(controller.decide(&plan, &end), Decision::Held(HeldReason::Gaps { missing: 1, of: 100 }));
}

#[test]
fn settings_are_refused_by_key() {
    let mut bad = ControlSettings::default();
    bad.pid.kp = -1.0;
    let text = bad.validate().expect_err("a negative gain").to_string();
    assert!(text.contains("control.pid.kp") && text.contains("-1"), "{text}");
    assert!(toml::from_str::<ControlSettings>("controler = \"pid\"").is_err());
    let text =
        "controller = \"lsq\"\n[lsq.shapes.polynomial]\ndegree = 3\n[pid.spatial]\nmodal = \"quadratic\"\n";
    let read: ControlSettings = toml::from_str(text).expect("externally tagged variants");
    assert_eq!(read.lsq.shapes, Shapes::Polynomial { degree: 3 });
    assert_eq!(read.pid.spatial, Spatial::Modal(Shapes::Quadratic));
    assert!(build(&read, &[1.0, 2.0]).is_err_and(|e| e.to_string().contains("2 stations")));
    assert!(build(&read, &[1.0, 1.0]).is_err_and(|e| e.to_string().contains("does not ascend")));
    assert!("pdi".parse::<ControllerName>().is_err_and(|e| e.to_string().contains("none, pid, lsq")));
}

/// A barrel with one outlier, measured after the third-last and after the second-last pass.
fn lsq_offsets(change: impl FnOnce(&mut ControlSettings), finishing: bool) -> (Vec<f64>, Vec<String>) {
    let mut s = settings(ControllerName::Lsq);
    s.lsq.shapes = toml::from_str::<LsqShapes>("shapes = \"quadratic\"").expect("a shape").shapes;
    (s.guards.outlier_limit_mm, s.guards.scatter_limit_mm) = (1.0, 1.0);
    change(&mut s);
    let z: Vec<f64> = (0..20).map(|i| 12.5 + 25.0 * f64::from(i)).collect();
    let e: Vec<f64> = (0..20)
        .map(|i| {
            let xi = f64::from(i) / 9.5 - 1.0;
            0.02 * (1.0 - xi * xi) + if i == 7 { 0.02 } else { 0.0 }
        })
        .collect();
    let d: Vec<f64> = e.iter().map(|e| 25.5 + e).collect();
    let mut controller = build(&s, &z).expect("a controller");
    let offset = DiameterOffset::zero(20);
    let plan = PassPlan {
        pass: 3,
        nominal_mm: 25.5,
        cutting: CUTTING,
        station_z_mm: z.clone(),
        offset,
        form: PlannedForm::PLAIN,
    };
    let next = NextPass { nominal_mm: 25.0, cutting: CUTTING, finishing };
    let context = PassContext { next: Some(next), ..PassContext::default() };
    match controller.decide_in(&plan, &plant::profile(3, &z, &d), &context) {
        Decision::Offset(o) => (o.o_mm, controller.notes().to_vec()),
        Decision::Held(reason) => panic!("{reason}"),
    }
}

#[derive(serde::Deserialize)]
struct LsqShapes {
    shapes: Shapes,
}

#[test]
fn hubers_fit_is_not_drawn_by_one_wild_station() {
    let off = |o: &[f64]| {
        let xi = |i: usize| i as f64 / 9.5 - 1.0;
        (0..20).map(|i| (o[i] - 0.02 * (1.0 - xi(i) * xi(i))).abs()).fold(0.0, f64::max)
    };
    let plain = off(&lsq_offsets(|_| {}, false).0);
    let robust = off(&lsq_offsets(|s| s.lsq.estimator = Estimator::Huber, false).0);
    println!(
        "largest departure from the barrel: least squares {:.2} µm, Huber {:.2} µm",
        plain * 1e3,
        robust * 1e3
    );
    assert!(plain > 1e-3 && robust < 0.1 * plain);
}

#[test]
fn the_finishing_pass_alone_is_compensated_where_asked_for() {
    let finishing_only = |s: &mut ControlSettings| s.lsq.apply_to = ApplyTo::FinishingPass;
    let (early, notes) = lsq_offsets(finishing_only, false);
    assert!(early.iter().all(|o| *o == 0.0) && notes[0].contains("finishing pass alone"), "{notes:?}");
    let (late, notes) = lsq_offsets(finishing_only, true);
    assert!(late[10] > 0.015 && notes[0].contains('±'), "{notes:?}");
    assert_eq!(late, lsq_offsets(|_| {}, true).0);
}
