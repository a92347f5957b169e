//! Control by section: nothing is fitted, filled or compared across a shoulder.

use super::job;
use crate::inside::support::plant;

use shadowgauge::control::{
    ControlSettings, Controller, ControllerName, LsqSettings, NextPass, PassContext, build,
};
use shadowgauge::plan::{Decision, DiameterOffset, PassPlan};
use shadowgauge::profile::DiameterProfile;

/// The plan of a pass of the preset, and its measurement with the errors `e` (mm, by z).
fn pass(number: u32, o_mm: Option<Vec<f64>>, e: impl Fn(f64) -> f64) -> (PassPlan, DiameterProfile) {
    let order = job().loop_job();
    let count = order.station_z_mm().len();
    let plan = order.pass_plan(number, DiameterOffset { o_mm: o_mm.unwrap_or_else(|| vec![0.0; count]) });
    let d: Vec<f64> = plan.station_nominal_mm().zip(&plan.station_z_mm).map(|(r, z)| r + e(*z)).collect();
    let measured = plant::profile(number, &plan.station_z_mm, &d);
    (plan, measured)
}

fn controller(name: ControllerName, change: impl FnOnce(&mut ControlSettings)) -> Box<dyn Controller + Send> {
    let order = job().loop_job();
    let mut settings = order.run_control();
    settings.controller = name;
    change(&mut settings);
    build(&settings, order.layout()).unwrap()
}

fn decided(c: &mut dyn Controller, (plan, measured): &(PassPlan, DiameterProfile)) -> Decision {
    let next = NextPass { nominal_mm: 28.4, cutting: plan.cutting, finishing: false };
    c.decide_in(plan, measured, &PassContext { next: Some(next), ..PassContext::default() })
}

fn offsets(decision: Decision) -> Vec<f64> {
    match decision {
        Decision::Offset(o) => o.o_mm,
        Decision::Held(reason) => panic!("{reason}"),
    }
}

/// Lines that step at the shoulders: the least-squares law takes off each section's own line, which
/// one fit over the whole part would smear by half of the steps.
#[test]
fn least_squares_fit_every_section_by_itself() {
    let error = |z: f64| match z {
        z if z < 70.0 => 0.010 + 1e-4 * z,
        z if z < 140.0 => -0.008 + 2e-5 * z,
        z => 0.015 - 5e-5 * z,
    };
    let measured = pass(1, None, error);
    let mut lsq =
        controller(ControllerName::Lsq, |s| s.lsq = LsqSettings { gain: 1.0, ..LsqSettings::default() });
    let o = offsets(decided(lsq.as_mut(), &measured));
    for (o, z) in o.iter().zip(&measured.0.station_z_mm) {
        assert!((o - error(*z)).abs() < 1e-9, "z {z}: {o} {}", error(*z));
    }
    let note = lsq.notes().join(" ");
    assert!(note.contains("section 1 P0") && note.contains("section 3 P1"), "{note}");
}

/// Steps between sections of .1 mm are no outliers and no scatter; within a section the same step
/// of one station is.
#[test]
fn guards_compare_stations_within_their_section() {
    let step = |z: f64| {
        if z < 70.0 {
            0.02
        } else if z < 140.0 {
            -0.02
        } else {
            0.02
        }
    };
    let fresh = || controller(ControllerName::Pid, |s| s.guards.outlier_limit_mm = 0.01);
    offsets(decided(fresh().as_mut(), &pass(1, None, step)));
    let odd = pass(1, None, |z| if (z - 30.0).abs() < 2.0 { 0.02 } else { 0.0 });
    let Decision::Held(reason) = decided(fresh().as_mut(), &odd) else { panic!("released") };
    assert!(reason.to_string().contains("outlier"), "{reason}");
}

/// A guard against undersize takes the limit of the station's own section: 22 h6 is no limit of the
/// 16 mm seat.
#[test]
fn the_lower_limit_is_that_of_the_section() {
    let order = job().loop_job();
    let contour = order.turned_contour().unwrap();
    let deep = |z: f64| if contour.section_at(z).unwrap().name == "bearing seat B" { -0.02 } else { 0.0 };
    let (plan, measured) = pass(2, None, deep);
    let next = NextPass { nominal_mm: 28.0, cutting: plan.cutting, finishing: true };
    let context = PassContext { next: Some(next), ..PassContext::default() };
    let mut c = controller(ControllerName::Pid, |s| (s.pid.kp, s.pid.ki, s.pid.kd) = (0.01, 0.0, 0.0));
    let Decision::Held(reason) = c.decide_in(&plan, &measured, &context) else { panic!("released") };
    assert!(reason.to_string().contains("lower limit 15.989"), "{reason}");
}

/// The model-based controller predicts the next pass of a stepped shaft from its own beam: cut by
/// the process with the job's supports, it removes the deflection at once.
#[test]
fn the_model_knows_the_steps_from_the_job() {
    let mut job = job();
    (job.process.texture.rms_um, job.process.texture.lobe_um) = (0.0, 0.0);
    job.process.bending = Default::default();
    let order = job.loop_job();
    let mut settings = order.run_control();
    settings.controller = ControllerName::Model;
    assert_eq!(settings.model.chuck_n_per_um, Some(60.0));
    assert_eq!(settings.model.tailstock_n_per_um, Some(12.0));
    let mut model = build(&settings, order.layout()).unwrap();
    let form = shadowgauge::process::BaseForm { contour: order.turned_contour(), ..Default::default() };
    let stock = shadowgauge::process::Stock { diameter_mm: 29.2, length_mm: 200.0 };
    let mut process = shadowgauge::process::TurningProcess::new(&job.process, stock, &form, 1).unwrap();
    let z = order.station_z_mm();
    let mut offset = DiameterOffset::zero(z.len());
    let mut errors = Vec::new();
    for number in 1..=3 {
        let plan = order.pass_plan(number, offset.clone());
        process.cut_profile(&plan).unwrap();
        let nodes: Vec<(f64, f64)> = process.node_z_mm().zip(process.diameter_mm().iter().copied()).collect();
        let d: Vec<f64> = z
            .iter()
            .map(|z| shadowgauge::plan::value_at(&nodes, *z, shadowgauge::plan::Side::Chuck, |n| *n))
            .collect();
        let worst = d.iter().zip(plan.station_nominal_mm()).map(|(d, r)| (d - r).abs()).fold(0.0, f64::max);
        errors.push(worst * 1e3);
        let next = NextPass {
            nominal_mm: order.part.target_mm(number + 1),
            cutting: plan.cutting,
            finishing: number == 2,
        };
        let context = PassContext { next: Some(next), ..PassContext::default() };
        if number < 3 {
            offset = DiameterOffset {
                o_mm: offsets(model.decide_in(&plan, &plant::profile(number, &z, &d), &context)),
            };
        }
    }
    println!("largest errors by pass, µm: {errors:?}");
    assert!(errors[0] > 10.0 && errors[1] < 0.1 * errors[0] && errors[2] < 1.0, "{errors:?}");
}
