//! SINUMERIK programs: their words, their moves beside those of the other dialects, and what the
//! replay refuses of them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::nc::replay::{self, Control, Deed, Point};
use shadowgauge::nc::{Dialect, NcSettings, Remeasure, Spindle, TurningProgram, Workpiece};
use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};

const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };

fn plan() -> PassPlan {
    let station_z_mm: Vec<f64> = (0..12).map(|i| 2.5 + 5.0 * f64::from(i)).collect();
    let offset = DiameterOffset { o_mm: station_z_mm.iter().map(|z| 1e-4 * z - 0.003).collect() };
    PassPlan { pass: 2, nominal_mm: 9.9955, cutting: CUTTING, station_z_mm, offset, form: PlannedForm::PLAIN }
}

fn settings() -> NcSettings {
    // neither wear_x nor geometry_offset: the path carries the whole correction
    NcSettings { spindle: Some(Spindle::M04), part_number: 3, ..NcSettings::default() }
}

fn piece() -> Workpiece {
    Workpiece::new(60.0, 11.0, 10.5)
}

fn with<T>(settings: &NcSettings, f: impl Fn(&TurningProgram<'_>) -> T) -> T {
    let (plan, piece) = (plan(), piece());
    let limits_mm = settings.remeasure.map(|_| (9.98, 10.0));
    f(&TurningProgram { plan: &plan, settings, piece: &piece, limits_mm, reason: "released" })
}

fn text(settings: &NcSettings) -> String {
    with(settings, |p| p.write(Dialect::Sinumerik).expect("a program").text)
}

#[test]
fn the_words_are_those_of_the_control() {
    let text = text(&settings());
    let lines: Vec<&str> = text.lines().collect();
    let at = |line: &str| lines.iter().position(|l| *l == line).unwrap_or_else(|| panic!("{line}\n{text}"));
    assert!(
        lines[0].starts_with("; SG8001.MPF") && !text.contains(['(', '#', '%']) || text.contains("MSG("),
        "{text}"
    );
    assert!(at("G18 G40 G54 G710 G90 G95 DIAMON") < at("STOPRE"));
    assert!(at("IF R98 <> 302 GOTOF GO_ON_101") < at("MSG(\"PASS WAS CUT ALREADY\")"));
    assert!(at("GO_ON_101:") < at("G75 FP=1 X1=0") && at("G75 FP=1 X1=0") < at("G75 FP=1 Z1=0"));
    assert!(at("G75 FP=1 Z1=0") < at("T1 D1") && at("T1 D1") < at("G96 S80 LIMS=2000 M4"));
    assert!(at("G00 Z=60.5") < at("X=13"));
    // the mark of a finished pass waits for the motion
    assert_eq!(lines[at("R98=302") - 1], "STOPRE");
    assert_eq!(lines[lines.len() - 1], "M30");
    assert!(text.contains("NOT VERIFIED ON A CONTROL") && text.contains("ZERO OFFSET G54"), "{text}");
    assert!(lines.iter().all(|l| l.is_ascii() && l.len() < 80));
    assert!(lines.iter().all(|l| l.starts_with(';') || !l.ends_with('.')), "{text}");
}

/// The moves of a program from one start.
fn moves(dialect: Dialect, settings: &NcSettings) -> Vec<Deed> {
    with(settings, |p| {
        let text = p.write(dialect).expect("a program").text;
        let change = p.working_space(dialect).expect("a scene").change;
        let place = Point { x: change.x_mm, z: change.z_mm };
        let control = Control {
            dialect,
            settings,
            start: Point { x: 50.0, z: 90.0 },
            reference: place,
            variables: vec![(820, 0.0)],
            with_probe: false,
            surface: None,
            tool_page: None,
        };
        let events = replay::run(&text, &control).unwrap_or_else(|e| panic!("{e:?}\n{text}"));
        events.into_iter().map(|e| e.deed).filter(|d| matches!(d, Deed::Move { .. })).collect()
    })
}

#[test]
fn its_moves_are_those_of_gsk_where_no_register_is_written() {
    let gsk = NcSettings {
        wear_x: Some(shadowgauge::nc::WearX::Diameter),
        geometry_offset: Some(shadowgauge::nc::GeometryOffset::ByTool),
        ..settings()
    };
    let (own, other) = (moves(Dialect::Sinumerik, &settings()), moves(Dialect::Gsk, &gsk));
    assert!(own.len() > 20);
    assert_eq!(own, other);
}

#[test]
fn a_program_that_is_changed_is_refused_with_its_block() {
    let settings = settings();
    let whole = text(&settings);
    let refused = |from: &str, to: &str, word: &str| {
        let lines: Vec<&str> =
            whole.lines().map(|l| if l == from { to } else { l }).filter(|l| *l != "-").collect();
        let changed = lines.join("\n") + "\n";
        assert_ne!(changed, whole, "{from} is not in the program");
        let said = with(&settings, |p| {
            let space = p.working_space(Dialect::Sinumerik).expect("a scene");
            replay::check(&changed, &space).expect_err(from).to_string()
        });
        assert!(said.contains(word), "{from} -> {to}: {said}");
    };
    refused("G00 Z=60.5", "G00 X=10 Z=60.5", "X and Z move in rapid together");
    refused("G00 Z=60.5", "G00 Z=59.5", "not cut to size from Z 59.5");
    refused("X=13", "X=9", "below the commanded");
    refused("G18 G40 G54 G710 G90 G95 DIAMON", "G18 G40 G54 G710 G90 G95", "DIAMON");
    refused("G18 G40 G54 G710 G90 G95 DIAMON", "G18 G40 G54 G90 G95 DIAMON", "millimetres");
    refused("G18 G40 G54 G710 G90 G95 DIAMON", "G18 G40 G54 G710 G90 G94 DIAMON", "per revolution");
    refused("G75 FP=1 X1=0", "G75 FP=2 X1=0", "G75 is understood with FP=1");
    refused("G75 FP=1 X1=0", "-", "the tool");
    refused("G96 S80 LIMS=2000 M4", "G96 S80 LIMS=2000 M3", "without the spindle turning");
    refused("G96 S80 LIMS=2000 M4", "G96 S80 M4", "without a speed");
    refused("T1 D1", "T1 D2", "D1");
    refused("T1 D1", "T2 D1", "T2 is not tool 1");
    refused("T1 D1", "T1 D1 G41", "before NORM");
    refused("STOPRE", "-", "without STOPRE");
    refused("M30", "-", "ends without");
}

#[test]
fn a_pass_that_was_cut_and_a_part_out_of_its_limits_end_in_an_alarm() {
    let remeasure = Remeasure { m_code: 150, smallest_variable: 40, largest_variable: 41 };
    let settings = NcSettings { remeasure: Some(remeasure), ..settings() };
    let text = text(&settings);
    let alarm = |variables: Vec<(u32, f64)>| {
        let control = Control {
            dialect: Dialect::Sinumerik,
            settings: &settings,
            start: Point { x: 50.0, z: 90.0 },
            reference: Point { x: 100.0, z: 100.0 },
            variables,
            with_probe: false,
            surface: None,
            tool_page: None,
        };
        let events = replay::run(&text, &control).unwrap_or_else(|e| panic!("{e:?}\n{text}"));
        events.into_iter().rev().find_map(|e| match e.deed {
            Deed::Alarm(text) => Some(text),
            _ => None,
        })
    };
    assert_eq!(alarm(vec![(820, 302.0)]).as_deref(), Some("PASS WAS CUT ALREADY"));
    assert_eq!(alarm(vec![(820, 301.0), (40, 9.97), (41, 9.99)]).as_deref(), Some("PART UNDERSIZE"));
    assert_eq!(alarm(vec![(820, 301.0), (40, 9.985), (41, 10.01)]).as_deref(), Some("PART OVERSIZE"));
    assert_eq!(alarm(vec![(820, 301.0), (40, 9.985), (41, 9.99)]), None);
}

#[test]
fn programs_that_probe_or_lack_the_spindle_are_refused_by_name() {
    let open = NcSettings { spindle: None, ..settings() };
    let said = with(&open, |p| p.write(Dialect::Sinumerik).expect_err("open").to_string());
    assert!(said.contains("sinumerik") && said.contains("spindle") && !said.contains("wear_x"), "{said}");
}
