//! Every guard is tripped once, and a machine with faults runs for 10⁵ cycles.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::faulty_cell;
#[allow(dead_code, reason = "each test uses its part of the shared plant")]
use crate::inside::support::plant;

use plant::{CUTTING, profile};
use shadowgauge::conformity::DecisionRule;
use shadowgauge::conformity::part_verdict::{self, Conformity, Limits};
use shadowgauge::control::{
    ControlSettings, Controller, ControllerName, NextPass, Origin, PartAndTool, PassContext, build,
};
use shadowgauge::plan::{CuttingData, Decision, DiameterOffset, HeldReason, PassPlan, PlannedForm};
use shadowgauge::profile::{DiameterProfile, Reading, Reason};

const STATIONS: usize = 20;

fn z_mm() -> Vec<f64> {
    (0..STATIONS).map(|i| 12.5 + 25.0 * i as f64).collect()
}

fn barrel(height_mm: f64) -> Vec<f64> {
    (0..STATIONS).map(|i| height_mm * (1.0 - (i as f64 / 9.5 - 1.0).powi(2))).collect()
}

fn plan(pass: u32, nominal_mm: f64, o_mm: Vec<f64>) -> PassPlan {
    let offset = DiameterOffset { o_mm };
    PassPlan { pass, nominal_mm, cutting: CUTTING, station_z_mm: z_mm(), offset, form: PlannedForm::PLAIN }
}

fn seen(pass: u32, nominal_mm: f64, e_mm: &[f64]) -> DiameterProfile {
    let d: Vec<f64> = e_mm.iter().map(|e| nominal_mm + e).collect();
    profile(pass, &z_mm(), &d)
}

fn repeated(repeat: &DiameterProfile) -> PassContext<'_> {
    PassContext { repeat: Some(repeat), ..PassContext::default() }
}

fn next(nominal_mm: f64, finishing: bool) -> NextPass {
    NextPass { nominal_mm, cutting: CUTTING, finishing }
}

fn controller(change: impl FnOnce(&mut ControlSettings)) -> Box<dyn Controller + Send> {
    let mut settings = ControlSettings { controller: ControllerName::Pid, ..ControlSettings::default() };
    change(&mut settings);
    build(&settings, &z_mm()).expect("a controller")
}

/// Decides after a first pass at 26.5 with these errors.
fn first(c: &mut dyn Controller, e_mm: &[f64], context: &PassContext<'_>) -> Decision {
    c.decide_in(&plan(1, 26.5, vec![0.0; STATIONS]), &seen(1, 26.5, e_mm), context)
}

fn reason(decision: Decision) -> String {
    match decision {
        Decision::Held(reason) => reason.to_string(),
        Decision::Offset(_) => panic!("released"),
    }
}

#[track_caller]
fn assert_held(decision: Decision, guard: &str) {
    let text = reason(decision);
    println!("{text}");
    assert!(text.starts_with(guard), "{text}");
}

#[test]
fn a_plain_first_correction_is_released() {
    let decision = first(controller(|_| {}).as_mut(), &barrel(0.045), &PassContext::default());
    let Decision::Offset(offset) = decision else { panic!("{decision:?}") };
    for (o, e) in offset.o_mm.iter().zip(barrel(0.045)) {
        assert!((o - 1.25 * e).abs() < 1e-12);
    }
}

#[test]
fn implausible_uncertain_and_unnumbered_readings_hold() {
    let mut wild = barrel(0.04);
    wild[7] = 0.3;
    assert_held(first(controller(|_| {}).as_mut(), &wild, &PassContext::default()), "plausible reading");
    let mut vague = seen(1, 26.5, &barrel(0.04));
    if let Reading::Value(d) = &mut vague.stations[3].reading {
        d.u_common_mm = 0.006;
    }
    let p = plan(1, 26.5, vec![0.0; STATIONS]);
    assert_held(controller(|_| {}).decide(&p, &vague), "uncertainty");
    if let Reading::Value(d) = &mut vague.stations[3].reading {
        d.d_mm = f64::NAN;
    }
    assert_held(controller(|_| {}).decide(&p, &vague), "the reading at z = 87.5 mm is no number");
}

#[test]
fn scatter_and_outliers_hold() {
    let jagged: Vec<f64> =
        barrel(0.04).iter().enumerate().map(|(i, e)| e + [0.007, -0.007, 0.004][i % 3]).collect();
    assert_held(first(controller(|_| {}).as_mut(), &jagged, &PassContext::default()), "scatter");
    for at in [0, 1, 9, STATIONS - 1] {
        for size in [0.02_f64, -0.02] {
            let mut outlier = barrel(0.04);
            outlier[at] += size;
            assert_held(first(controller(|_| {}).as_mut(), &outlier, &PassContext::default()), "outlier");
        }
    }
}

#[test]
fn a_measurement_must_belong_here_be_fresh_and_be_used_once() {
    let here = PartAndTool { part: "7".into(), tool: "T1/3".into() };
    let origin = Origin {
        of: here.clone(),
        scan: 11,
        age_s: 5.0,
        since_cut_s: 3.0,
        master_deviation_mm: Some(0.0002),
    };
    let decide = |c: &mut dyn Controller, origin: &Origin| {
        let context = PassContext { origin: Some(origin), in_machine: Some(&here), ..PassContext::default() };
        first(c, &barrel(0.04), &context)
    };
    let fresh = || controller(|_| {});
    let mut once = fresh();
    assert!(matches!(decide(once.as_mut(), &origin), Decision::Offset(_)));
    assert_held(decide(once.as_mut(), &origin), "used once");
    let other = |part: &str, tool: &str| PartAndTool { part: part.into(), tool: tool.into() };
    assert_held(decide(fresh().as_mut(), &Origin { of: other("8", "T1/3"), ..origin.clone() }), "part");
    assert_held(decide(fresh().as_mut(), &Origin { of: other("7", "T1/4"), ..origin.clone() }), "tool");
    assert_held(decide(fresh().as_mut(), &Origin { age_s: 901.0, ..origin.clone() }), "fresh");
    assert_held(decide(fresh().as_mut(), &Origin { since_cut_s: -0.1, ..origin.clone() }), "fresh");
    let drifted = Origin { master_deviation_mm: Some(-0.0021), ..origin };
    assert_held(decide(fresh().as_mut(), &drifted), "master");
    let p = plan(2, 26.0, vec![0.0; STATIONS]);
    assert_held(fresh().decide(&p, &seen(1, 26.0, &barrel(0.04))), "pass");
    let mut elsewhere = seen(2, 26.0, &barrel(0.04));
    elsewhere.stations[2].z_mm += 1.0;
    assert_held(fresh().decide(&p, &elsewhere), "a station measured at z = 63.5 mm is planned at 62.5 mm");
    elsewhere.stations.pop();
    assert_held(fresh().decide(&p, &elsewhere), "19 stations were measured, 20 planned");
}

#[test]
fn steps_and_sums_are_limited_and_large_steps_need_two_scans() {
    let decision = first(controller(|_| {}).as_mut(), &barrel(0.09), &PassContext::default());
    assert!(matches!(decision, Decision::Held(HeldReason::StepLimit { step_mm, .. }) if step_mm > 0.1));
    let p = plan(2, 26.0, vec![0.29; STATIONS]);
    assert_held(controller(|_| {}).decide(&p, &seen(2, 26.0, &barrel(0.02))), "cumulative limit");

    let large = barrel(0.07);
    assert_held(first(controller(|_| {}).as_mut(), &large, &PassContext::default()), "two scans: a step");
    let again = |shift: f64| seen(1, 26.5, &large.iter().map(|e| e + shift).collect::<Vec<_>>());
    let (alike, apart) = (again(0.001), again(0.0031));
    assert_held(first(controller(|_| {}).as_mut(), &large, &repeated(&apart)), "two scans: before");
    assert!(matches!(first(controller(|_| {}).as_mut(), &large, &repeated(&alike)), Decision::Offset(_)));
    let mut gap = alike.clone();
    gap.stations[4].reading = Reading::Gap(Reason::Contaminated);
    assert_held(first(controller(|_| {}).as_mut(), &large, &repeated(&gap)), "two scans: before");
}

#[test]
fn small_changes_are_not_made() {
    let e: Vec<f64> = (0..STATIONS).map(|i| if i < 10 { 0.00015 } else { 0.0002 }).collect();
    let Decision::Offset(o) = first(controller(|_| {}).as_mut(), &e, &PassContext::default()) else {
        panic!("released")
    };
    assert!(o.o_mm[..10].iter().all(|o| *o == 0.0) && o.o_mm[10..].iter().all(|o| *o > 0.0002));
}

#[test]
fn an_unexpected_response_stops_the_cell() {
    // the second pass if the offset acted with this factor
    let respond = |factor: f64| {
        let mut c = controller(|_| {});
        let Decision::Offset(o) = first(c.as_mut(), &barrel(0.045), &PassContext::default()) else {
            panic!("released")
        };
        let e: Vec<f64> = barrel(0.045).iter().zip(&o.o_mm).map(|(e, o)| e - factor * o).collect();
        let decision = c.decide(&plan(2, 26.0, o.o_mm), &seen(2, 26.0, &e));
        (decision, c.alarm().map(str::to_owned))
    };
    for right in [0.65, 0.84, 1.0, 1.15] {
        let (decision, alarm) = respond(right);
        assert!(matches!(decision, Decision::Offset(_)) && alarm.is_none(), "{right}: {decision:?}");
    }
    for wrong in [-0.9, 0.0, 0.45, 1.8] {
        let (decision, alarm) = respond(wrong);
        assert_held(decision, "response");
        assert!(alarm.is_some_and(|a| a.contains("radius for diameter")));
    }
}

#[test]
fn depth_cutting_data_and_the_lower_limit_are_guarded() {
    let decide = |next: NextPass, lower: Option<f64>, e: f64| {
        let mut c = controller(|s| s.guards.lower_limit_mm = lower);
        let context = PassContext { next: Some(next), ..PassContext::default() };
        let decision = first(c.as_mut(), &barrel(e), &context);
        (decision, c.alarm().map(str::to_owned))
    };
    assert_held(decide(next(26.45, false), None, 0.04).0, "minimum chip");
    assert_held(decide(next(22.4, false), None, 0.04).0, "depth of cut");
    let faster = CuttingData { speed_m_per_min: 90.0, ..CUTTING };
    assert_held(decide(NextPass { cutting: faster, ..next(26.0, false) }, None, 0.04).0, "cutting data");
    assert!(matches!(decide(next(26.0, true), Some(25.98), 0.04).0, Decision::Offset(_)));
    // Kp + Ki = 1.25 removes 10 µm more than needed
    let (decision, alarm) = decide(next(26.0, true), Some(25.993), 0.04);
    assert_held(decision, "undersize");
    assert!(alarm.is_some(), "the finishing pass must not go unchecked");
    // the offsets in force alone cut undersize
    let mut c = controller(|s| s.guards.lower_limit_mm = Some(25.99));
    let context = PassContext { next: Some(next(26.0, false)), ..PassContext::default() };
    let p = plan(1, 26.5, vec![0.05; STATIONS]);
    let mut outlier = vec![-0.03; STATIONS];
    outlier[5] += 0.02;
    assert_held(c.decide_in(&p, &seen(1, 26.5, &outlier), &context), "outlier");
    assert!(c.alarm().is_some_and(|a| a.starts_with("undersize")), "{:?}", c.alarm());
}

#[test]
fn after_a_refusal_it_is_as_if_the_pass_had_not_been_measured() {
    let (mut once, mut twice) = (controller(|_| {}), controller(|_| {}));
    let mut wild = barrel(0.04);
    wild[7] = 0.3;
    assert!(matches!(first(twice.as_mut(), &wild, &PassContext::default()), Decision::Held(_)));
    let good = barrel(0.04);
    assert_eq!(
        first(once.as_mut(), &good, &PassContext::default()),
        first(twice.as_mut(), &good, &PassContext::default())
    );
}

#[test]
fn remeasurement_judges_with_the_uncertainty() {
    let limits = Limits { lower_mm: 24.987, upper_mm: 25.0, rule: DecisionRule::default() };
    let mut p = profile(4, &[1.0, 2.0, 3.0, 4.0, 5.0], &[24.9935, 24.9868, 24.98, 25.01, 25.0]);
    p.stations[4].reading = Reading::Gap(Reason::OneEdge);
    let verdict = part_verdict::judge(&p, &limits);
    let expected = [
        Conformity::Conforms,
        Conformity::Undecided,
        Conformity::Undersize,
        Conformity::Oversize,
        Conformity::Unmeasured,
    ];
    assert_eq!(verdict.stations, expected);
    let alarm = verdict.alarm.expect("an alarm");
    assert!(alarm.starts_with("1 of 5 stations undersize (first at z = 3 mm)"), "{alarm}");
    let good = profile(4, &[1.0, 2.0], &[24.99, 24.995]);
    assert_eq!(part_verdict::judge(&good, &limits).alarm, None);
}

#[test]
fn a_hundred_thousand_cycles_with_faults() {
    let mut total = faulty_cell::Tally::default();
    for (name, parts) in [
        (ControllerName::Pid, 33_000),
        (ControllerName::Ewma, 2_000),
        (ControllerName::Ilc, 1_000),
        (ControllerName::Model, 500),
    ] {
        let tally = faulty_cell::run(name, parts, 1000);
        println!("{name}: {tally:?}");
        total.add(&tally);
    }
    println!("all: {total:?}");
    assert!(total.cycles >= 100_000 && total.faults > 10_000);
    assert_eq!(total.wrong_direction, 0);
    assert_eq!(total.above_limit, 0);
    assert_eq!(total.undersize, 0);
    // a loop that refuses everything would pass the above
    let good = total.parts - total.faults;
    assert!(total.good_parts_stopped * 50 < good, "at least 98 % of the parts without a fault are finished");
    assert!(total.finished > total.parts / 2);
    // and the same faults without guards do harm, or the test could not fail
    let bare = faulty_cell::run_unguarded(ControllerName::Pid, 2_000, 1000);
    println!("guards off: {bare:?}");
    assert!(bare.wrong_direction > 0 && bare.undersize > 0);
}
