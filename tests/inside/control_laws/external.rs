//! A controller in another program: the protocol over a stream in memory.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{Read, Result, Write};
use std::rc::Rc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::{Value, json};
use shadowgauge::control::external::{Fault, PROTOCOL_VERSION, PartFacts, ProgramController};
use shadowgauge::control::{
    ControlSettings, Controller, ControllerName, NextPass, PartStart, PassContext, Pid, PidSettings, build,
};
use shadowgauge::plan::{Decision, DiameterOffset, HeldReason, PassPlan};
use shadowgauge::profile::{DiameterProfile, Reading, Reason};

use crate::inside::control_laws::plant::{CUTTING, Plant};
use crate::inside::control_laws::{NOMINALS_MM, random_pid, settings};

const STATIONS: usize = 20;

/// A program in memory: a line in, perhaps a line out; at the end of its replies the stream ends.
struct InMemory<P> {
    program: P,
    unread: Vec<u8>,
    replies: VecDeque<u8>,
}

impl<P: FnMut(&Value) -> Option<String>> Write for InMemory<P> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.unread.extend_from_slice(bytes);
        while let Some(end) = self.unread.iter().position(|b| *b == b'\n') {
            let line: Vec<u8> = self.unread.drain(..=end).collect();
            let message = serde_json::from_slice(&line).expect("a line of JSON");
            self.replies.extend((self.program)(&message).unwrap_or_default().into_bytes());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl<P> Read for InMemory<P> {
    /// A few bytes at a time, so that lines come in pieces.
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let most = into.len().min(7);
        self.replies.read(&mut into[..most])
    }
}

fn controller<P: FnMut(&Value) -> Option<String>>(
    settings: &ControlSettings,
    program: P,
) -> ProgramController<InMemory<P>> {
    let facts = PartFacts {
        seed: 7,
        station_z_mm: Plant::new(STATIONS).z_mm,
        nominal_mm: NOMINALS_MM.to_vec(),
        station_relative_mm: Vec::new(),
        station_limits_mm: Vec::new(),
        tolerance_mm: Some((24.987, 25.0)),
        cutting: CUTTING,
    };
    let stream = InMemory { program, unread: Vec::new(), replies: VecDeque::new() };
    ProgramController::new(stream, "mine", "python3 mine.py", settings, facts)
}

/// The PID of the crate as a program: what `held` refuses is as if it had not been measured.
fn pid_program(settings: &PidSettings) -> impl FnMut(&Value) -> Option<String> + use<> {
    let mut pid = Pid::new(settings, STATIONS);
    let mut before = pid.clone();
    let numbers = |list: &Value, of: fn(&Value) -> Option<f64>| -> Option<Vec<f64>> {
        list.as_array().expect("a list").iter().map(of).collect()
    };
    move |message| {
        if message["type"] != "pass" {
            return None;
        }
        if !message["held"].is_null() {
            pid = before.clone();
        }
        before = pid.clone();
        let nominal = message["nominal_mm"].as_f64().expect("a nominal diameter");
        let read = numbers(&message["stations"], |s| s["reading"]["value"]["d_mm"].as_f64());
        let Some(read) = read else { return Some("{\"hold\": \"a gap\"}\n".to_owned()) };
        let errors: Vec<f64> = read.iter().map(|d| d - nominal).collect();
        let in_force = numbers(&message["offsets_mm"], Value::as_f64).expect("offsets");
        let offsets: Vec<f64> = in_force.iter().zip(pid.step(&errors)).map(|(o, u)| o + u).collect();
        Some(format!("{}\r\n", json!({ "pass": message["pass"], "offsets_mm": offsets })))
    }
}

/// A measured profile, now and then with a gap, a wild station or a jump of all.
fn disturbed(mut measured: DiameterProfile, rng: &mut Pcg64) -> DiameterProfile {
    let station = rng.random_range(0..STATIONS);
    let shift = |reading: &mut Reading, by: f64| {
        if let Reading::Value(d) = reading {
            d.d_mm += by;
        }
    };
    match rng.random_range(0..8) {
        0 => measured.stations[station].reading = Reading::Gap(Reason::Contaminated),
        1 => shift(&mut measured.stations[station].reading, 0.03),
        2 => measured.stations.iter_mut().for_each(|s| shift(&mut s.reading, 0.12)),
        _ => {}
    }
    measured
}

/// Decisions of both, pass after pass, on one plant; the offsets in force are the decided ones.
fn compare(seed: u64) -> (usize, usize) {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut s = ControlSettings { pid: random_pid(&mut rng), ..settings(ControllerName::Pid) };
    s.allow_unstable = true;
    let mut plant = Plant::new(STATIONS);
    let mut own = build(&s, &plant.z_mm).expect("a controller");
    let mut other = controller(&s, pid_program(&s.pid));
    let mut offset = own.begin_part(&PartStart::default(), STATIONS);
    assert_eq!(other.begin_part(&PartStart::default(), STATIONS), offset);
    let (mut released, mut held) = (0, 0);
    for (i, nominal) in NOMINALS_MM.into_iter().enumerate() {
        let plan = plant.plan(i as u32 + 1, nominal, offset.clone());
        plant.cut(&plan);
        let measured = disturbed(plant.measured(plan.pass), &mut rng);
        let next = NOMINALS_MM.get(i + 1).map(|&nominal_mm| NextPass {
            nominal_mm,
            cutting: CUTTING,
            finishing: i + 2 == NOMINALS_MM.len(),
        });
        let mut context = PassContext { next, ..PassContext::default() };
        let repeat = own.needs_repeat(&plan, &measured, &context);
        assert_eq!(other.needs_repeat(&plan, &measured, &context), repeat, "seed {seed}, pass {}", plan.pass);
        context.repeat = repeat.then_some(&measured);
        let (mine, theirs) =
            (own.decide_in(&plan, &measured, &context), other.decide_in(&plan, &measured, &context));
        assert_eq!(format!("{mine:?}"), format!("{theirs:?}"), "seed {seed}, pass {}", plan.pass);
        assert_eq!((own.notes(), own.alarm()), (other.notes(), other.alarm()), "seed {seed}");
        match mine {
            Decision::Offset(next) => (offset, released) = (next, released + 1),
            Decision::Held(_) => held += 1,
        }
    }
    assert!(other.failure().is_none());
    (released, held)
}

#[test]
fn our_pid_behind_the_protocol_decides_as_our_pid_itself() {
    let outcomes: Vec<(usize, usize)> = (0..60).map(compare).collect();
    let sum = |of: fn(&(usize, usize)) -> usize| outcomes.iter().map(of).sum::<usize>();
    println!("{} released, {} held", sum(|o| o.0), sum(|o| o.1));
    // Both kinds of decision were compared, and passes after a refusal.
    assert!(sum(|o| o.0) > 60 && outcomes.iter().filter(|o| o.0 > 0 && o.1 > 0).count() > 20);
}

/// The first pass of the plant, and its measurement.
fn first_pass() -> (PassPlan, DiameterProfile) {
    let mut plant = Plant::new(STATIONS);
    let plan = plant.plan(1, 26.5, DiameterOffset::zero(STATIONS));
    plant.cut(&plan);
    let measured = plant.measured(1);
    (plan, measured)
}

#[test]
fn a_program_is_given_the_order_and_the_readings_and_is_asked_once_a_pass() {
    let messages = Rc::new(RefCell::new(Vec::new()));
    let kept = Rc::clone(&messages);
    let (plan, mut measured) = first_pass();
    measured.stations[3].reading = Reading::Gap(Reason::OneEdge);
    let mut other = controller(&settings(ControllerName::Pid), move |message: &Value| {
        kept.borrow_mut().push(message.clone());
        (message["type"] == "pass").then(|| "{\"hold\": \"not yet\"}\n".to_owned())
    });
    other.begin_part(&PartStart::default(), STATIONS);
    assert!(!other.needs_repeat(&plan, &measured, &PassContext::default()));
    other.decide(&plan, &measured);
    drop(other);
    let messages = messages.borrow();
    let types: Vec<&str> = messages.iter().filter_map(|m| m["type"].as_str()).collect();
    assert_eq!(types, ["begin", "pass", "end"]);
    let (begin, pass) = (&messages[0], &messages[1]);
    assert_eq!(begin["version"], PROTOCOL_VERSION);
    assert_eq!(begin["tolerance_mm"], json!([24.987, 25.0]));
    assert_eq!(begin["guards"]["step_limit_mm"], 0.1);
    assert_eq!(begin["station_z_mm"].as_array().map(Vec::len), Some(STATIONS));
    assert_eq!(
        (&begin["seed"], &begin["stock"], &begin["event"]),
        (&json!(7), &Value::Null, &json!("continued"))
    );
    assert_eq!(pass["offsets_mm"], json!(vec![0.0; STATIONS]));
    assert_eq!(pass["stations"][3]["reading"], json!({ "gap": "one_edge" }));
    let value = &pass["stations"][2]["reading"]["value"];
    assert_eq!((&value["u_random_mm"], &value["u_common_mm"]), (&json!(2e-4), &json!(1e-4)));
    assert!(value["d_mm"].as_f64().is_some_and(|d| d > 26.5));
}

#[test]
fn a_hold_holds_with_its_reason_and_before_the_finishing_pass_alarms() {
    let (plan, measured) = first_pass();
    for finishing in [false, true] {
        let mut other = controller(&settings(ControllerName::Pid), |_: &Value| {
            Some("{\"hold\": \"chatter\"}\n".to_owned())
        });
        let next = Some(NextPass { nominal_mm: 26.0, cutting: CUTTING, finishing });
        let decision = other.decide_in(&plan, &measured, &PassContext { next, ..PassContext::default() });
        let reason = HeldReason::Guard("the controller holds: chatter".to_owned());
        assert_eq!(decision, Decision::Held(reason));
        assert_eq!((other.alarm().is_some(), other.failure()), (finishing, None));
    }
}

/// What a reply is refused with.
fn fault(reply: &str) -> (Fault, String) {
    let (plan, measured) = first_pass();
    let reply = reply.to_owned();
    let mut other = controller(&settings(ControllerName::Pid), move |_: &Value| Some(reply.clone()));
    let decision = other.decide(&plan, &measured);
    assert!(matches!(decision, Decision::Held(_)) && other.alarm().is_some(), "{decision:?}");
    let error = other.failure().expect("a failure").clone();
    // A program that failed stays so.
    assert_eq!(other.decide(&plan, &measured), Decision::Held(HeldReason::Guard(error.to_string())));
    let text = error.to_string();
    (error.fault, text)
}

#[test]
fn a_bad_reply_is_refused_with_the_command_the_line_and_what_is_right() {
    let list = |value: &str| format!("{{\"offsets_mm\": [{}]}}\n", vec![value; STATIONS].join(", "));
    let long = format!("{{\"hold\": \"{}\"}}\n", "x".repeat(20_000));
    for (reply, word) in [
        ("kp = 0.9\n", "is no JSON"),
        ("\n", "is no JSON"),
        ("[0.1]\n", "is no JSON object"),
        ("{\"offset_mm\": [0.1]}\n", "\"offset_mm\", which is none of offsets_mm, hold, pass"),
        ("{\"offsets_mm\": [0.1, 0.2]}\n", "has 2 offsets for 20 stations"),
        ("{\"offsets_mm\": 0.1}\n", "no array"),
        (&list("NaN"), "has an offset that is NaN"),
        (&list("-Infinity"), "has an offset that is Infinity"),
        (&list("1e999"), "is no JSON (number out of range"),
        (&list("null"), "has null as offset 1, which is no finite number"),
        ("{\"pass\": 2, \"hold\": \"later\"}\n", "is for pass 2"),
        ("{\"hold\": \" \"}\n", "without a reason"),
        ("{\"hold\": \"a\", \"offsets_mm\": []}\n", "both offsets_mm and hold"),
        ("{\"pass\": 1}\n", "neither offsets_mm nor hold"),
        (&long, "is no JSON"),
    ] {
        let (fault, text) = fault(reply);
        assert!(
            matches!(fault, Fault::Reply { line: 1, pass: 1, stations: STATIONS, .. }),
            "{reply}: {fault:?}"
        );
        for word in [word, "controller mine (python3 mine.py)", "line 1", "with 20 numbers"] {
            assert!(text.contains(word), "{reply}: {word:?} is missing in {text}");
        }
        assert!(text.len() < 600, "{text}");
    }
    let (fault, text) = fault("");
    assert!(
        matches!(fault, Fault::Ended { pass: 1, .. }) && text.contains("ended before its reply"),
        "{text}"
    );
}
