//! Programs that probe: the cut that follows from the probed errors, their alarms, and runs through
//! LinuxCNC's own interpreter.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::linuxcnc;
#[path = "nc_probing/qualification.rs"]
mod qualification;

use linuxcnc::interpret;
use shadowgauge::nc::replay::{self, Deed, Event, Point, Surface, WorkingSpace};
use shadowgauge::nc::{
    Chuck, Dialect, GeometryOffset, MacroProgram, NcError, NcProbe, NcSettings, ProbingProgram, Spindle,
    Tailstock, TurningProgram, WearX, Workpiece, fit_line,
};
use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};

const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };
const LENGTH: f64 = 300.0;
const BEFORE: f64 = 23.7;
const NOMINAL: f64 = 23.2;

fn probe() -> NcProbe {
    let text = "tool = 5\ncorrection_mm = -0.0124\nexpanded_u_mm = 0.002\nskip_variable = 5061\n";
    toml::from_str(text).expect("a probe")
}

fn settings() -> NcSettings {
    NcSettings {
        wear_x: Some(WearX::Diameter),
        geometry_offset: Some(GeometryOffset::ByTool),
        spindle: Some(Spindle::M03),
        chuck: Some(Chuck { diameter_mm: 90.0, jaws_to_z_mm: 0.0, jaws_diameter_mm: None }),
        probe: Some(probe()),
        ..NcSettings::default()
    }
}

fn program(settings: &NcSettings) -> ProbingProgram<'_> {
    ProbingProgram {
        nominal_mm: NOMINAL,
        piece: Workpiece { tolerance_mm: Some((23.187, 23.213)), ..Workpiece::new(LENGTH, 25.0, BEFORE) },
        pass: 3,
        cutting: CUTTING,
        limits_mm: Some((23.187, 23.213)),
        settings,
    }
}

/// The paper's reconstructed errors at its places, mm; the sixth is probed a little beside the
/// chuck.
fn paper(z: f64) -> f64 {
    let errors = [4.4, 4.6, 4.8, 5.0, 5.1, 5.4];
    let x = 6.0 * (LENGTH - z) / LENGTH;
    let i = (x.floor() as usize).clamp(1, 5);
    0.01 * (errors[i - 1] + (errors[i] - errors[i - 1]) * (x - i as f64))
}

fn before() -> Vec<(f64, f64)> {
    (0..=600).map(|i| 0.5 * f64::from(i)).map(|z| (z, BEFORE + paper(z))).collect()
}

fn run(text: &str, working_space: &WorkingSpace<'_>) -> Vec<Event> {
    let start = Point { x: working_space.change.x_mm, z: working_space.change.z_mm };
    replay::run(text, &working_space.control(start)).unwrap_or_else(|e| panic!("{e:?}\n{text}"))
}

fn feeds(events: &[Event]) -> Vec<Point> {
    let feed = |e: &Event| match e.deed {
        Deed::Move { to, rapid: false, .. } => Some(to),
        _ => None,
    };
    events.iter().filter_map(feed).collect()
}

fn touches(events: &[Event]) -> Vec<(Point, Point)> {
    let touch = |e: &Event| match e.deed {
        Deed::Probe { to, target, .. } => Some((to, target)),
        _ => None,
    };
    events.iter().filter_map(touch).collect()
}

/// Slope and intercept by the normal equations of Gauss, written out.
fn normal_equations(x: &[f64], y: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let (sx, sy) = (x.iter().sum::<f64>(), y.iter().sum::<f64>());
    let sxx: f64 = x.iter().map(|x| x * x).sum();
    let sxy: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
    let determinant = n * sxx - sx * sx;
    ((n * sxy - sx * sy) / determinant, (sxx * sy - sx * sxy) / determinant)
}

#[test]
fn what_is_probed_is_fitted_and_its_inverse_cut() {
    let settings = settings();
    let program = program(&settings);
    for dialect in Dialect::WITH_MACROS {
        let written = program.write(dialect).expect("a program");
        let (text, places) = (written.text, written.cut);
        // clear of nc.least_z_mm, the nose's fillet and the ball: .5 + .8 + 3
        assert_eq!(places, [250.0, 200.0, 150.0, 100.0, 50.0, 4.3], "{dialect:?}");
        let working_space = program.working_space(dialect, before()).expect("a scene");
        let events = run(&text, &working_space);
        assert_eq!(touches(&events).len(), 12, "six before and six after the cut");
        assert!(!events.iter().any(|e| matches!(e.deed, Deed::Alarm(_))), "{text}");
        let x: Vec<f64> = places.iter().map(|z| (LENGTH - z) / LENGTH).collect();
        let errors: Vec<f64> = places.iter().map(|z| paper(*z)).collect();
        let (b, a) = normal_equations(&x, &errors);
        let cut = feeds(&events);
        assert_eq!(cut.len(), 5, "radially in, the end face, 1/6, the chuck, radially out");
        for point in &cut[1..4] {
            let wanted = NOMINAL - (b * (LENGTH - point.z) / LENGTH + a);
            assert!((point.x - wanted).abs() < 2e-5, "{dialect:?}: {point:?}, {wanted}");
        }
        for line in text.lines() {
            assert!(line.is_ascii() && line.len() < 80, "{line}");
        }
        assert!(!text.contains("#800=#800") && !text.contains("#800=[#800"), "fresh variables");
        let (code, feed) = if dialect == Dialect::Linuxcnc { ("G38.2", "G94") } else { ("G31", "G98") };
        assert!(text.matches(&format!("{code} X")).count() == 12 && text.contains(&format!("\n{feed}\n")));
        assert!(text.contains("ALARM OUTSIDE 23.189 TO 23.211"), "{text}");
    }
}

/// The paper's own line: its six places at 1/6 … 1, on a part that its chuck holds behind Z 0.
#[test]
fn the_papers_table_gives_the_papers_line() {
    let x: Vec<f64> = (1..=6).map(|i| f64::from(i) / 6.0).collect();
    let z: Vec<f64> = x.iter().map(|x| LENGTH * (1.0 - x)).collect();
    let (b, a) = normal_equations(&x, &z.iter().map(|z| 100.0 * paper(*z)).collect::<Vec<_>>());
    assert!((b - 1.14857).abs() < 5e-6 && (a - 4.21333).abs() < 5e-6, "{b} {a}");
}

#[test]
fn alarms_stop_what_must_not_go_on() {
    let settings = settings();
    let program = program(&settings);
    let last =
        |text: &str, working_space: &WorkingSpace<'_>| run(text, working_space).pop().expect("events").deed;
    for dialect in Dialect::WITH_MACROS {
        let text = program.write(dialect).expect("a program").text;
        let mut working_space = program.working_space(dialect, before()).expect("a scene");
        let surface = |before: f64, after: f64| {
            Some(Surface { before: vec![(0.0, before)], after: vec![(0.0, after)], ..Surface::default() })
        };
        // (before, after, cuts): good; a chip under the ball; nothing there; undersize, oversize,
        // within U of a limit
        for (before, after, alarm, cuts) in [
            (BEFORE, NOMINAL, false, true),
            (BEFORE + 0.31, NOMINAL, true, false),
            (15.0, NOMINAL, true, false),
            (BEFORE, 23.186, true, true),
            (BEFORE, 23.214, true, true),
            (BEFORE, 23.2115, true, true),
            (BEFORE, 23.188, true, true),
            (BEFORE, 15.0, true, true),
        ] {
            working_space.surface = surface(before, after);
            let events = run(&text, &working_space);
            let rings = matches!(last(&text, &working_space), Deed::Alarm(_));
            assert_eq!(rings, alarm, "{dialect:?} {before} {after}");
            assert_eq!(!feeds(&events).is_empty(), cuts, "{dialect:?} {before} {after}");
        }
        // the part's pass was cut before
        working_space.surface = surface(BEFORE, NOMINAL);
        working_space.variables = vec![(820, 103.0)];
        let events = run(&text, &working_space);
        assert!(matches!(&events[..], [Event { deed: Deed::Alarm(_), .. }]), "{events:?}");
    }
}

fn changed(text: &str, change: impl FnMut(&str) -> String) -> String {
    let lines: Vec<String> = text.lines().map(change).filter(|l| l != "-").collect();
    let changed = lines.join("\n") + "\n";
    assert_ne!(changed, text, "nothing was changed");
    changed
}

#[test]
fn a_probe_that_may_hit_something_is_refused() {
    let settings = settings();
    let program = program(&settings);
    for dialect in Dialect::WITH_MACROS {
        let text = program.write(dialect).expect("a program").text;
        let working_space = program.working_space(dialect, before()).expect("a scene");
        let refused = |change: &dyn Fn(&str) -> String, word: &str| {
            let said =
                replay::check(&changed(&text, change), &working_space).expect_err("refused").to_string();
            assert!(said.contains(word), "{dialect:?}, {word}: {said}");
        };
        let code = if dialect == Dialect::Linuxcnc { "G38.2" } else { "G31" };
        // the second touch: a program could read the result of the first again
        let second = text.match_indices(code).nth(1).expect("two touches").0;
        let rapid = format!("{}G00{}", &text[..second], text[second + code.len()..].replacen(" F50.", "", 1));
        let said = replay::check(&rapid, &working_space).expect_err("refused").to_string();
        assert!(said.contains("in rapid the tool touches the stock"), "{dialect:?}: {said}");
        let feed = |l: &str| if l.starts_with(code) { l.replace(code, "G01") } else { l.to_owned() };
        refused(&feed, "the probe in the carrier");
        let along = |l: &str| if l == "G00 X27." { "-".to_owned() } else { l.to_owned() };
        refused(&along, "begins in the part");
        // along the part before it has retracted to the clear diameter
        let low = |l: &str| if l == "G00 X27." { "G00 X24.".to_owned() } else { l.to_owned() };
        refused(&low, "half the clearance");
        let skew = |l: &str| if l.starts_with(code) { format!("{l} Z100.") } else { l.to_owned() };
        refused(&skew, "must move X alone");
        let per_turn = |l: &str| if ["G94", "G98"].contains(&l) { "-".to_owned() } else { l.to_owned() };
        refused(&per_turn, "per minute");
        let off = if dialect == Dialect::Linuxcnc { "M5" } else { "M05" };
        let ends = text.rfind(&format!("\n{off}\n")).expect("the end");
        let second = text[..ends].rfind(&format!("\n{off}\n")).expect("before the second cycle");
        let turning = format!("{}{}", &text[..second], &text[second + off.len() + 1..]);
        if dialect != Dialect::Linuxcnc {
            // LinuxCNC's M6 stops the spindle itself
            let said = replay::check(&turning, &working_space).expect_err("refused").to_string();
            assert!(said.contains("while the spindle turns"), "{said}");
        }
    }
}

#[test]
fn places_and_bodies_that_do_not_fit_are_named() {
    let said = |change: &dyn Fn(&mut NcSettings, &mut Workpiece)| {
        let mut settings = settings();
        let mut piece = program(&settings).piece;
        change(&mut settings, &mut piece);
        let program = ProbingProgram { piece, ..program(&settings) };
        program.write(Dialect::Linuxcnc).expect_err("refused").to_string()
    };
    let with =
        |f: fn(&mut NcProbe)| move |s: &mut NcSettings, _: &mut Workpiece| s.probe.iter_mut().for_each(f);
    let text = said(&|_, p| p.probe_z_mm = vec![1.0, 150.0]);
    assert!(text.contains("Z 1 mm") && text.contains("part.station_z_mm"), "{text}");
    let text = said(&|_, p| p.probe_z_mm = (1..=13).map(|i| 20.0 * f64::from(i)).collect());
    assert!(text.contains("13 places"), "{text}");
    // a probe body wide enough to reach a tall chuck
    let text = said(&|s, _| {
        s.chuck = Some(Chuck { diameter_mm: 400.0, jaws_to_z_mm: 0.0, jaws_diameter_mm: None });
    });
    assert!(text.contains("chuck"), "{text}");
    assert!(said(&with(|p| p.tool = 1)).contains("nc.probe.tool"));
    assert!(said(&with(|p| p.reach_mm = 0.1)).contains("nc.probe.reach_mm"));
    assert!(said(&with(|p| p.expanded_u_mm = 0.02)).contains("no result could prove"));
    assert!(said(&with(|p| p.correction_mm = 2.0)).contains("nc.probe.correction_mm"));
    assert!(said(&|s, _| s.probe = None).contains("nc.probe"));
    let mut open = settings();
    open.probe.iter_mut().for_each(|p| p.skip_variable = None);
    program(&open).write(Dialect::Fanuc).expect("#5061");
    let text = program(&open).write(Dialect::Gsk).expect_err("open").to_string();
    assert!(text.contains("probe.skip_variable"), "{text}");
    // where the chuck is not stated, the body stays in front of Z 0
    open.chuck = None;
    let places = program(&open).write(Dialect::Linuxcnc).expect("a program").cut;
    assert_eq!(places[5], 20.0, "half the body");
}

fn plan() -> PassPlan {
    let station_z_mm: Vec<f64> = (0..30).map(|i| 5.0 + 10.0 * f64::from(i)).collect();
    let offset = DiameterOffset { o_mm: station_z_mm.iter().map(|z| 0.02 + 5e-5 * z).collect() };
    PassPlan {
        pass: 3,
        nominal_mm: NOMINAL,
        cutting: CUTTING,
        station_z_mm,
        offset,
        form: PlannedForm::PLAIN,
    }
}

/// Every form measures again where it can and a tolerance is stated, and otherwise states that it
/// does not.
#[test]
fn every_program_measures_again_or_says_that_it_does_not() {
    let piece = program(&settings()).piece;
    let plan = plan();
    let offsets = fit_line(&[0.2, 0.5, 1.0], &[0.03, 0.03, 0.03]).expect("a line");
    for dialect in Dialect::WITH_MACROS {
        for (probes, finishing) in [(true, true), (true, false), (false, true), (false, false)] {
            let mut settings = settings();
            settings.probe = settings.probe.filter(|_| probes);
            let limits_mm = piece.tolerance_mm.filter(|_| finishing);
            let turning = TurningProgram {
                plan: &plan,
                settings: &settings,
                piece: &piece,
                limits_mm,
                reason: "released",
            };
            let line = MacroProgram {
                line: offsets,
                unit_mm: 1.0,
                diameter_mm: (NOMINAL, NOMINAL),
                piece: piece.clone(),
                pass: 3,
                cutting: CUTTING,
                limits_mm,
                settings: &settings,
            };
            let texts = [
                turning.write(dialect).expect("a program").text,
                line.write(dialect).expect("a program").text,
            ];
            for text in texts {
                let again = text.contains("PROBES AGAIN: ALARM OUTSIDE 23.189 TO 23.211");
                let not = text.contains("DOES NOT MEASURE AGAIN");
                assert!(
                    again != not && again == (probes && finishing),
                    "{dialect:?} {probes} {finishing}\n{text}"
                );
                assert_eq!(text.contains("PART UNDERSIZE"), again);
            }
        }
    }
}

/// The whole program measures again without an alarm where the tolerance belongs to the last pass.
#[test]
fn an_earlier_pass_is_measured_again_without_an_alarm() {
    for dialect in Dialect::WITH_MACROS {
        let settings = settings();
        let earlier = ProbingProgram { limits_mm: None, ..program(&settings) };
        let text = earlier.write(dialect).expect("a program").text;
        assert!(
            text.contains("PROBES AGAIN WITHOUT AN ALARM") && !text.contains("DOES NOT MEASURE"),
            "{text}"
        );
        assert!(!text.contains("PART UNDERSIZE"), "{text}");
    }
}

#[test]
fn nothing_is_said_where_no_tolerance_is_stated() {
    let none = Workpiece { tolerance_mm: None, ..program(&settings()).piece };
    let settings = NcSettings { probe: None, ..settings() };
    let turning = TurningProgram {
        plan: &plan(),
        settings: &settings,
        piece: &none,
        limits_mm: None,
        reason: "released",
    };
    let text = turning.write(Dialect::Linuxcnc).expect("a program").text;
    assert!(!text.contains("MEASURE AGAIN"), "nothing is stated, nothing is said");
}

/// rs274 ends every probing move at its target: the targets are set to the simulated points of
/// touch.
#[test]
fn linuxcnc_runs_it_with_simulated_results() -> Result<(), NcError> {
    let mut settings = settings();
    settings.tailstock = Some(Tailstock::Absent);
    let program = program(&settings);
    let text = program.write(Dialect::Linuxcnc)?.text;
    let working_space = program.working_space(Dialect::Linuxcnc, before())?;
    let simulated = |working_space: &WorkingSpace<'_>| {
        let mut touched = touches(&run(&text, working_space)).into_iter();
        changed(&text, |l| match l.starts_with("G38.2 X") {
            true => touched.next().map_or(l.to_owned(), |(to, _)| format!("G38.2 X{:.7} F50.", to.x)),
            false => l.to_owned(),
        })
    };
    let Some((moves, printed)) = interpret(&simulated(&working_space)) else { return Ok(()) };
    assert!(printed.contains("PROGRAM_END") && printed.matches("STRAIGHT_PROBE(").count() == 12, "{printed}");
    let events = run(&text, &working_space);
    let ours: Vec<((f64, f64), bool)> = events
        .iter()
        .filter_map(|e| match e.deed {
            Deed::Move { to, rapid, .. } => Some(((0.5 * to.x, to.z), rapid)),
            Deed::Probe { to, .. } => Some(((0.5 * to.x, to.z), false)),
            _ => None,
        })
        .collect();
    // rs274 starts at the origin, ours at the change position; a move to the present position is
    // not listed
    let mut at = (0.5 * working_space.change.x_mm, working_space.change.z_mm);
    let theirs: Vec<((f64, f64), bool)> =
        moves.into_iter().skip(2).filter(|m| std::mem::replace(&mut at, m.0) != m.0).collect();
    assert_eq!(theirs.len(), ours.len(), "{printed}");
    for (theirs, ours) in theirs.iter().zip(&ours) {
        let apart = (theirs.0.0 - ours.0.0).abs().max((theirs.0.1 - ours.0.1).abs());
        assert!(apart <= 6e-5 && theirs.1 == ours.1, "{theirs:?} {ours:?}");
    }
    // the alarms, by LinuxCNC: a result out of range before the cut; a part out of tolerance after
    // it
    for (before, after, word) in [
        (BEFORE + 0.31, NOMINAL, "PROBE RESULT OUT OF RANGE"),
        (BEFORE, 23.214, "PART OVERSIZE"),
        (BEFORE, 23.186, "PART UNDERSIZE"),
    ] {
        let mut wrong = working_space.clone();
        wrong.surface =
            Some(Surface { before: vec![(0.0, before)], after: vec![(0.0, after)], ..Surface::default() });
        let (_, printed) = interpret(&simulated(&wrong)).expect("it ran before");
        assert!(printed.contains(word) && !printed.contains("PROGRAM_END"), "{word}: {printed}");
    }
    Ok(())
}
