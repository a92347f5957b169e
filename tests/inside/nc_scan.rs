//! Scan programs: their order, their stops, what the replay refuses of them, and LinuxCNC's own
//! interpreter beside it.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::nc::replay::{self, Deed, Event, Point, SpindleState};
use shadowgauge::nc::{
    Chuck, Dialect, GeometryOffset, NcScan, NcSettings, ScanHead, ScanProgram, Spindle, SpindleOrientation,
    Tailstock, WearX, Workpiece, stop_list,
};
use shadowgauge::plan::ScanPlan;

use super::linuxcnc::interpret;

const HEAD_Z_MM: f64 = 45.0;
const FIELDS: [f64; 3] = [30.0, 60.5, 91.0];
const ANGLES: [f64; 4] = [0.0, 45.0, 90.0, 135.0];

fn plan() -> ScanPlan {
    ScanPlan { field_z_mm: FIELDS.to_vec(), angle_deg: ANGLES.to_vec() }
}

fn piece() -> Workpiece {
    Workpiece::new(120.0, 32.0, 31.0)
}

fn scan(dialect: Dialect, speed_per_min: Option<f64>) -> NcScan {
    let code = |iso: &str, linuxcnc: &str| {
        Some(if dialect == Dialect::Linuxcnc { linuxcnc } else { iso }.parse().expect("a code"))
    };
    NcScan {
        head_z_mm: HEAD_Z_MM,
        head: ScanHead { towards_chuck_mm: 25.0, towards_tailstock_mm: 25.0, opening_mm: 60.0 },
        trigger: code("M81", "M64 P0").expect("a code"),
        trigger_off: code("M82", "M65 P0"),
        shutter_open: code("M83", "M64 P1"),
        shutter_close: code("M84", "M65 P1"),
        coolant_off: "M9".parse().expect("a code"),
        air_on: code("M85", "M7"),
        air_off: code("M86", "M9"),
        air_s: 2.5,
        dwell_s: 4.0,
        settle_s: 0.2,
        frame_s: 0.05,
        speed_per_min,
        turns: 2.0,
    }
}

fn settings(dialect: Dialect, speed_per_min: Option<f64>) -> NcSettings {
    NcSettings {
        wear_x: Some(WearX::Diameter),
        geometry_offset: Some(GeometryOffset::ByTool),
        spindle: Some(Spindle::M03),
        spindle_orientation: Some(SpindleOrientation { angle_deg: 300.0, m_code: 19, release_m_code: None }),
        chuck: Some(Chuck { diameter_mm: 80.0, jaws_to_z_mm: 0.0, jaws_diameter_mm: None }),
        tailstock: Some(Tailstock::Absent),
        scan: Some(scan(dialect, speed_per_min)),
        ..NcSettings::default()
    }
}

fn with<T>(settings: &NcSettings, f: impl Fn(&ScanProgram<'_>) -> T) -> T {
    let (plan, piece) = (plan(), piece());
    f(&ScanProgram { plan: &plan, settings, piece: &piece, pass: 2 })
}

fn text(dialect: Dialect, settings: &NcSettings) -> String {
    with(settings, |p| p.write(dialect).unwrap_or_else(|e| panic!("{dialect:?}: {e}")).text)
}

/// Events from the change position.
fn events(dialect: Dialect, settings: &NcSettings, text: &str) -> Vec<Event> {
    with(settings, |p| {
        let space = p.working_space(dialect).expect("a scene");
        let start = Point { x: space.change.x_mm, z: space.change.z_mm };
        replay::run(text, &space.control(start)).unwrap_or_else(|e| panic!("{dialect:?} {e:?}\n{text}"))
    })
}

#[test]
fn every_stop_is_triggered_once_at_its_place_and_angle() {
    for (dialect, speed) in Dialect::ALL.into_iter().flat_map(|d| [(d, None), (d, Some(600.0))]) {
        let settings = settings(dialect, speed);
        let text = text(dialect, &settings);
        let triggers: Vec<(u32, f64, SpindleState)> = events(dialect, &settings, &text)
            .into_iter()
            .filter_map(|e| match e.deed {
                Deed::Trigger(t) => Some((t.stop, t.at.z, t.spindle)),
                _ => None,
            })
            .collect();
        let mut due = Vec::new();
        for z in FIELDS {
            match speed {
                // the angles of the scan from that of the orientation on
                None => {
                    due.extend([300.0, 345.0, 30.0, 75.0].map(|a| (z - HEAD_Z_MM, SpindleState::Held(a))));
                }
                Some(speed) => due.push((z - HEAD_Z_MM, SpindleState::Turning(speed))),
            }
        }
        let due: Vec<_> = due.into_iter().zip(1..).map(|((z, s), n)| (n, z, s)).collect();
        assert_eq!(triggers, due, "{dialect:?} {speed:?}\n{text}");
        let stops = with(&settings, |p| p.stops().expect("stops"));
        assert_eq!(stops.len(), due.len());
        assert!(stop_list(&stops).starts_with("stop,z_mm,angle_deg\n1,30,"), "{}", stop_list(&stops));
        for line in text.lines() {
            assert!(line.is_ascii() && line.len() < 80, "{line}");
        }
        assert!(!text.contains("G01") && !text.contains("G96"), "nothing is cut\n{text}");
    }
}

/// Retract, coolant off, air blast, pause, shutter, carriage, settle, trigger, wait.
#[test]
fn the_order_is_that_of_a_dry_part() {
    let settings = settings(Dialect::Fanuc, Some(600.0));
    let text = text(Dialect::Fanuc, &settings);
    let lines: Vec<&str> = text.lines().collect();
    let order = [
        "G28 U0.",
        "G28 W0.",
        "T0101",
        "M09",
        "G97 S600 M03",
        "M85",
        "G04 P2500",
        "M86",
        "G04 P4000",
        "#838=0.",
        "M83",
        "G00 Z-15.",
        "G04 P200",
        "#838=[#838+1.]",
        "M81",
        // two turns at 600/min and a frame
        "G04 P250",
        "M82",
        "IF[#838 NE 1.]THEN #3000=1(STOPS ARE MISCOUNTED)",
        "G00 Z15.5",
    ];
    let mut from = 0;
    for wanted in order {
        let at = lines[from..].iter().position(|l| *l == wanted);
        from += at.unwrap_or_else(|| panic!("{wanted} is not due after line {from}\n{text}")) + 1;
    }
}

#[test]
fn a_program_that_is_changed_is_refused_with_its_block() {
    for dialect in Dialect::ALL {
        let settings = settings(dialect, None);
        let whole = text(dialect, &settings);
        let code = |iso: &'static str, linuxcnc: &'static str| {
            if dialect == Dialect::Linuxcnc { linuxcnc } else { iso }
        };
        let dwell = |s: f64| match dialect {
            Dialect::Linuxcnc => format!("G04 P{s}"),
            Dialect::Sinumerik => format!("G4 F{s}"),
            _ => format!("G04 P{:.0}", 1e3 * s),
        };
        let held = if dialect == Dialect::Sinumerik { "SPOS=345" } else { "M19 R345." };
        let refused = |from: &str, to: &str, word: &str| {
            let change = |l: &str| if l.starts_with(from) { to.to_owned() } else { l.to_owned() };
            let lines: Vec<String> = whole.lines().map(change).filter(|l| l != "-").collect();
            let changed = lines.join("\n") + "\n";
            assert_ne!(changed, whole, "{dialect:?}: {from} is not in the program\n{whole}");
            let said = with(&settings, |p| {
                let space = p.working_space(dialect).expect("a scene");
                replay::check(&changed, &space).expect_err(from).to_string()
            });
            assert!(said.contains(word), "{dialect:?}: {from} -> {to}: {said}");
        };
        refused(&dwell(0.2), "-", "at rest");
        refused(&dwell(2.5), "-", "air blast");
        refused(&dwell(0.05), "-", "not waited for");
        refused(code("M83", "M64 P1"), "-", "closed shutter");
        refused(held, "-", "due is Held(345.0)");
        refused(code("M81", "M64 P0"), "-", "not triggered");
        let z = if dialect == Dialect::Sinumerik { "G00 Z=15.5" } else { "G00 Z15.5" };
        refused(z, &z.replace("15.5", "16.5"), "due is Z 15.500");
        refused(z, &z.replace("15.5", "-95."), "gauge head touches the chuck");
        if dialect != Dialect::Linuxcnc {
            refused("M09", "-", "before the coolant is off");
            refused("M86", "-", "in the air blast");
        }
    }
}

/// A program that is started in the middle, or a trigger that was left out, ends in the alarm.
#[test]
fn stops_that_are_left_out_raise_the_alarm() {
    for dialect in Dialect::ALL {
        let settings = settings(dialect, None);
        let whole = text(dialect, &settings);
        let count = if dialect == Dialect::Sinumerik { "R97=R97+1" } else { "#838=[#838+1.]" };
        let lost = whole.replacen(&format!("{count}\n"), "\n", 1);
        assert_ne!(lost, whole);
        let events = events(dialect, &settings, &lost);
        assert!(matches!(events.last().expect("events").deed, Deed::Alarm(_)), "{dialect:?}");
        let triggers = events.iter().filter(|e| matches!(e.deed, Deed::Trigger(_))).count();
        assert_eq!(triggers, ANGLES.len(), "{dialect:?}: the alarm ends the first field");
    }
}

#[test]
fn data_that_cannot_be_are_refused_by_their_keys() {
    let refused = |change: &dyn Fn(&mut NcSettings, &mut NcScan), dialect: Dialect| {
        let mut settings = settings(dialect, None);
        let mut scan = settings.scan.expect("a scan");
        change(&mut settings, &mut scan);
        settings.scan = Some(scan);
        with(&settings, |p| p.write(dialect).expect_err("refused").to_string())
    };
    let says = |word: &str, change: &dyn Fn(&mut NcSettings, &mut NcScan)| {
        let said = refused(change, Dialect::Fanuc);
        assert!(said.contains(word), "{word}: {said}");
    };
    says("nc.scan.settle_s", &|_, s| s.settle_s = -1.0);
    says("nc.scan.speed_per_min", &|_, s| s.speed_per_min = Some(5000.0));
    says("nc.scan.head.opening_mm", &|_, s| s.head.opening_mm = 0.0);
    says("nc.scan.trigger", &|_, s| s.trigger = "M30".parse().unwrap());
    says("nc.scan.trigger", &|_, s| s.trigger = "M64 P0".parse().unwrap());
    says("nc.scan.shutter_open", &|_, s| s.shutter_open = Some(s.trigger));
    says("nc.scan.air_off", &|_, s| s.air_off = None);
    says("nc.spindle_orientation", &|m, _| m.spindle_orientation = None);
    // a head that does not pass over the part; chuck jaws in its way; a room that is not stated
    says("gauge head", &|_, s| s.head.opening_mm = 30.0);
    says("gauge head touches the jaws", &|m, _| {
        m.chuck = Some(Chuck { diameter_mm: 80.0, jaws_to_z_mm: 10.0, jaws_diameter_mm: None });
    });
    says("chuck not stated", &|m, s| {
        m.chuck = None;
        s.head.towards_chuck_mm = 40.0;
    });
    let none = NcSettings { scan: None, ..settings(Dialect::Fanuc, None) };
    let said = with(&none, |p| p.write(Dialect::Fanuc).expect_err("no table").to_string());
    assert!(said.contains("nc.scan"), "{said}");
    assert!(
        refused(&|_, s| s.trigger = "M81".parse().unwrap(), Dialect::Linuxcnc).contains("nc.scan.trigger")
    );
}

#[test]
fn the_table_survives_toml() {
    for dialect in Dialect::ALL {
        let settings = settings(dialect, Some(600.0));
        let text = toml::to_string(&settings).expect("written");
        assert_eq!(toml::from_str::<NcSettings>(&text).expect("read"), settings, "{text}");
    }
    let least = "head_z_mm = 45.0\ntrigger = \"M81\"\n\
                 [head]\ntowards_chuck_mm = 25.0\ntowards_tailstock_mm = 25.0\nopening_mm = 60.0\n";
    let read: NcScan = toml::from_str(least).expect("the least");
    assert_eq!((read.coolant_off.m, read.trigger.m, read.speed_per_min), (9, 81, None));
    let said = toml::from_str::<NcScan>(&least.replace("M81", "81")).expect_err("no code").to_string();
    assert!(said.contains("is no M code"), "{said}");
}

/// The moves of the replay are those of LinuxCNC's interpreter, and it takes every word.
#[test]
fn linuxcnc_runs_the_program() {
    for speed in [None, Some(600.0)] {
        let settings = settings(Dialect::Linuxcnc, speed);
        let text = text(Dialect::Linuxcnc, &settings);
        let Some((theirs, printed)) = interpret(&text) else { return };
        assert!(printed.contains("PROGRAM_END"), "{printed}\n{text}");
        let stops = if speed.is_some() { FIELDS.len() } else { FIELDS.len() * ANGLES.len() };
        assert_eq!(printed.matches("SET_AUX_OUTPUT_BIT(0)").count(), stops, "{printed}");
        let orientations = if speed.is_some() { 0 } else { stops };
        assert_eq!(printed.matches("ORIENT_SPINDLE(").count(), orientations, "{printed}");
        let mut own: Vec<(f64, f64)> = Vec::new();
        for event in events(Dialect::Linuxcnc, &settings, &text) {
            if let Deed::Move { to, rapid, .. } = event.deed {
                assert!(rapid, "nothing is cut");
                own.push((0.5 * to.x, to.z));
            }
        }
        // it lists moves of no length, too
        let mut ends: Vec<(f64, f64)> = theirs.iter().map(|m| m.0).collect();
        ends.dedup();
        let last = own.len();
        assert_eq!(ends[ends.len() - last..], own[..], "{printed}");
    }
}
