//! NC programs among the solids of a machine: every program that is written keeps clear of them,
//! whatever the part, and a program that does not is refused, naming the block.
//!
//! The check of the crate sweeps convex outlines; here moves are sampled against the solids'
//! profile R(z), with the nose as a circle, so that an error would have to be in both.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use proptest::prelude::*;
use shadowgauge::nc::replay::{self, Control, Deed, Event, Point};
use shadowgauge::nc::{
    Centre, ChangePosition, Chuck, Dialect, Direction, GeometryOffset, Holder, MacroProgram, NcSettings,
    Obstacle, Spindle, Tailstock, Travel, TurningProgram, WearX, Workpiece, fit_line,
};
use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};

const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };

/// A part, a machine and a pass.
#[derive(Clone, Debug)]
struct Case {
    piece: Workpiece,
    settings: NcSettings,
    plan: PassPlan,
    starts: Vec<(f64, f64)>,
}

impl Case {
    fn program(&self) -> TurningProgram<'_> {
        TurningProgram {
            plan: &self.plan,
            settings: &self.settings,
            piece: &self.piece,
            limits_mm: None,
            reason: "released",
        }
    }

    fn line(&self) -> MacroProgram<'_> {
        let length = self.piece.length_mm;
        let x: Vec<f64> = self.plan.station_z_mm.iter().map(|z| (length - z) / length).collect();
        MacroProgram {
            line: fit_line(&x, &self.plan.offset.o_mm).expect("two stations or more"),
            unit_mm: 1.0,
            diameter_mm: (self.plan.nominal_mm, self.plan.nominal_mm),
            piece: self.piece.clone(),
            pass: self.plan.pass,
            cutting: CUTTING,
            limits_mm: None,
            settings: &self.settings,
        }
    }

    fn nose(&self) -> f64 {
        self.settings.nose_radius_mm.unwrap_or(0.8)
    }

    fn change(&self) -> ChangePosition {
        self.program().working_space(Dialect::Linuxcnc).expect("a scene").change
    }

    /// Radius occupied by solids at `z`, mm; including the stock for rapid moves.
    fn taken(&self, z: f64, with_stock: bool) -> f64 {
        let (length, s) = (self.piece.length_mm, &self.settings);
        let chuck = match s.chuck {
            None if z < 0.0 => f64::INFINITY,
            Some(c) if z < 0.0 => 0.5 * c.diameter_mm,
            _ => 0.0,
        };
        let jaws = s.chuck.filter(|c| z < c.jaws_to_z_mm).map_or(0.0, |c| 0.5 * c.diameter_mm);
        let beyond = z - length;
        let cone =
            |hole: f64, body: f64| (0.5 * hole + beyond * (30.0_f64).to_radians().tan()).min(0.5 * body);
        let centre = match s.tailstock {
            _ if beyond < 0.0 => 0.0,
            Some(Tailstock::Absent) => 0.0,
            Some(Tailstock::Centre(c)) if beyond > c.quill_from_mm => 0.5 * c.quill_mm.max(c.body_mm),
            Some(Tailstock::Centre(c)) => cone(c.hole_mm, c.body_mm),
            None => {
                let smallest = self.plan.commanded_mm().fold(f64::INFINITY, f64::min);
                cone(0.6 * smallest, 80.0_f64.max(self.piece.stock_mm))
            }
        };
        let stock = if (0.0..=length).contains(&z) && with_stock { 0.5 * self.piece.before_mm } else { 0.0 };
        chuck.max(jaws).max(centre).max(stock)
    }

    /// Depth of the nose in occupied space, mm; negative where it is clear.
    fn depth(&self, at: Point, with_stock: bool) -> f64 {
        let r = self.nose();
        let middle = match self.piece.direction {
            Direction::TowardsChuck => at.z + r,
            Direction::TowardsTailstock => at.z - r,
        };
        let under = |i: i32| {
            let across = r * f64::from(i) / 12.0;
            let bottom = 0.5 * at.x + r - (r * r - across * across).max(0.0).sqrt();
            self.taken(middle + across, with_stock) - bottom
        };
        (-12..=12).map(under).fold(f64::NEG_INFINITY, f64::max)
    }

    fn commanded(&self, z: f64) -> f64 {
        let (s, o) = (&self.plan.station_z_mm, &self.plan.offset.o_mm);
        let i = s.partition_point(|at| *at < z);
        let offset = match i {
            0 => o[0],
            i if i == s.len() => o[i - 1],
            i => o[i - 1] + (o[i] - o[i - 1]) * (z - s[i - 1]) / (s[i] - s[i - 1]),
        };
        self.plan.nominal_mm - offset
    }
}

fn run(text: &str, case: &Case, dialect: Dialect, start: Point) -> Vec<Event> {
    let change = case.change();
    let control = Control {
        dialect,
        settings: &case.settings,
        start,
        reference: Point { x: change.x_mm, z: change.z_mm },
        variables: vec![(820, 0.0)],
        with_probe: false,
        surface: None,
        tool_page: None,
    };
    replay::run(text, &control).unwrap_or_else(|e| panic!("{e:?}\n{text}"))
}

/// Points of a move, at most half a millimetre apart.
fn along(from: Point, to: Point) -> impl Iterator<Item = Point> {
    let steps = (2.0 * (0.5 * (to.x - from.x)).hypot(to.z - from.z)).ceil().max(1.0) as usize;
    (0..=steps).map(move |i| {
        let share = i as f64 / steps as f64;
        Point { x: from.x + (to.x - from.x) * share, z: from.z + (to.z - from.z) * share }
    })
}

/// Judges a program by sampling, from every start of the case that is clear.
fn sampled(text: &str, case: &Case, dialect: Dialect) {
    let change = case.change();
    // the reference point is at the end of the travel
    let most = if dialect == Dialect::Linuxcnc { f64::INFINITY } else { change.x_mm };
    let starts = case.starts.iter().filter(|s| s.0 <= most).map(|(x, z)| Point { x: *x, z: *z });
    let clear: Vec<Point> = starts.filter(|p| case.depth(*p, true) < -0.01).collect();
    assert!(!clear.is_empty(), "no start is clear");
    for start in clear {
        let events = run(text, case, dialect, start);
        for event in &events {
            let line = text.lines().nth(event.block - 1).unwrap_or_default();
            match &event.deed {
                Deed::Move { from, to, rapid } => {
                    let both = (from.x - to.x).abs() > 1e-9 && (from.z - to.z).abs() > 1e-9;
                    assert!(!(both && *rapid), "{dialect:?} {line}: X and Z in rapid together\n{text}");
                    for at in along(*from, *to) {
                        let depth = case.depth(at, *rapid);
                        assert!(depth <= 1e-6, "{dialect:?} {line}: {depth} mm deep at {at:?}\n{text}");
                    }
                }
                Deed::ToolChange(at) => {
                    assert!((at.x, at.z) == (change.x_mm, change.z_mm), "{line}: tool at {at:?}\n{text}");
                }
                other => panic!("{line}: {other:?}\n{text}"),
            }
        }
        on_size(&events, text, case);
    }
}

/// The whole part is cut to the commanded diameter, from the end at the chuck to the end face.
fn on_size(events: &[Event], text: &str, case: &Case) {
    let least = match case.piece.direction {
        Direction::TowardsChuck => case.settings.least_z_mm,
        Direction::TowardsTailstock => case.settings.least_z_mm + 2.0 * case.nose(),
    };
    let feeds: Vec<(Point, Point)> = events
        .iter()
        .filter_map(|e| match &e.deed {
            Deed::Move { from, to, rapid: false } => Some((*from, *to)),
            _ => None,
        })
        .collect();
    let steps = (case.piece.length_mm - least).ceil() as usize * 2;
    for i in 0..=steps {
        let z = least + (case.piece.length_mm - least) * i as f64 / steps as f64;
        let cut = feeds.iter().any(|(a, b)| {
            if !(a.z.min(b.z) - 6e-4..=a.z.max(b.z) + 6e-4).contains(&z) || (a.z - b.z).abs() < 1e-9 {
                return false;
            }
            let x = a.x + (b.x - a.x) * (z - a.z) / (b.z - a.z);
            (x - case.commanded(z)).abs() < 0.0055
        });
        assert!(cut, "Z {z} is not cut to {}\n{text}", case.commanded(z));
    }
}

fn tailstocks(diameter: f64) -> impl Strategy<Value = Option<Tailstock>> {
    let centre = Centre {
        point_deg: 60.0,
        hole_mm: 0.4 * diameter,
        body_mm: 0.4 * diameter + 12.0,
        quill_mm: 0.4 * diameter + 30.0,
        quill_from_mm: 40.0,
    };
    prop_oneof![Just(None), Just(Some(Tailstock::Absent)), Just(Some(Tailstock::Centre(centre)))]
}

prop_compose! {
    fn machines(diameter: f64)(
        tailstock in tailstocks(diameter),
        nose_radius_mm in prop_oneof![Just(None), (0.2..0.8_f64).prop_map(Some)],
        chuck in prop_oneof![Just(None), Just(Some(Chuck { diameter_mm: 90.0, jaws_to_z_mm: 0.3, jaws_diameter_mm: None }))],
        radius in any::<bool>(),
        by_offset in any::<bool>(),
        reversed in any::<bool>(),
        change in any::<bool>(),
        lead_in_mm in 0.3..5.0_f64,
        clearance_mm in 0.5..4.0_f64,
    ) -> NcSettings {
        let position = ChangePosition { x_mm: 260.0, z_mm: 470.0 };
        NcSettings {
            tailstock,
            nose_radius_mm,
            chuck,
            wear_x: Some(if radius { WearX::Radius } else { WearX::Diameter }),
            geometry_offset: Some(if by_offset { GeometryOffset::ByOffset } else { GeometryOffset::ByTool }),
            spindle: Some(if reversed { Spindle::M04 } else { Spindle::M03 }),
            change_position: change.then_some(position),
            lead_in_mm,
            clearance_mm,
            ..NcSettings::default()
        }
    }
}

prop_compose! {
    fn cases()(diameter in 6.0..60.0_f64, length in 30.0..400.0_f64, station in 2.0..20.0_f64)(
        station in Just(station.min(0.5 * length)),
        diameter in Just(diameter),
        length in Just(length),
        settings in machines(diameter),
        towards_tailstock in any::<bool>(),
        depth in 0.1..2.0_f64,
        collar in 0.0..3.0_f64,
        (mean, slope, bow, noise) in (-0.05..0.05_f64, -0.05..0.05_f64, -0.03..0.03_f64, 0.0..0.002_f64),
        starts in proptest::collection::vec((0.0..280.0_f64, -20.0..520.0_f64), 11),
    ) -> Case {
        let station_z_mm: Vec<f64> =
            (0..(length / station + 1e-9) as usize).map(|i| (i as f64 + 0.5) * station).collect();
        let offset = |z: &f64| {
            let x = z / length;
            mean + slope * x + bow * 4.0 * x * (1.0 - x) + noise * (7.3 * z).sin()
        };
        let before_mm = diameter + depth;
        let direction = if towards_tailstock { Direction::TowardsTailstock } else { Direction::TowardsChuck };
        let mut starts = starts;
        // always clear: far out; and one close above the part
        starts.extend([(90.0, 0.5 * length), (before_mm + collar + 10.0, 0.5 * length)]);
        Case {
            piece: Workpiece { direction, ..Workpiece::new(length, before_mm + collar, before_mm) },
            settings,
            plan: PassPlan {
                pass: 2,
                nominal_mm: diameter,
                cutting: CUTTING,
                offset: DiameterOffset { o_mm: station_z_mm.iter().map(offset).collect() },
                station_z_mm,
                form: PlannedForm::PLAIN,
            },
            starts,
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn programs_of_any_part_keep_clear_and_cut_it_whole(case in cases()) {
        for dialect in Dialect::ALL {
            let text = case.program().write(dialect).unwrap_or_else(|e| panic!("{dialect:?}: {e}")).text;
            sampled(&text, &case, dialect);
            if !Dialect::WITH_MACROS.contains(&dialect) {
                continue;
            }
            let mut line = case.clone();
            let (first, last) = (line.plan.offset.o_mm[0], line.plan.offset.o_mm[line.plan.offset.o_mm.len() - 1]);
            let n = (line.plan.offset.o_mm.len() - 1) as f64;
            // a line, as this form needs; level ends differ from its slope by half a station
            for (i, o) in line.plan.offset.o_mm.iter_mut().enumerate() {
                *o = first + (last - first) * 0.05 * i as f64 / n;
            }
            let text = line.line().write(dialect).unwrap_or_else(|e| panic!("{dialect:?}: {e}")).text;
            sampled(&text, &line, dialect);
        }
    }
}

fn case() -> Case {
    let station_z_mm: Vec<f64> = (0..12).map(|i| 2.5 + 5.0 * f64::from(i)).collect();
    let offset = DiameterOffset { o_mm: station_z_mm.iter().map(|z| 1e-4 * z).collect() };
    Case {
        piece: Workpiece::new(60.0, 11.0, 10.5),
        settings: NcSettings {
            wear_x: Some(WearX::Diameter),
            geometry_offset: Some(GeometryOffset::ByTool),
            spindle: Some(Spindle::M03),
            ..NcSettings::default()
        },
        plan: PassPlan {
            pass: 2,
            nominal_mm: 9.9955,
            cutting: CUTTING,
            station_z_mm,
            offset,
            form: PlannedForm::PLAIN,
        },
        starts: vec![(90.0, 30.0)],
    }
}

/// Checks `text` with lines changed; the refusal.
fn refusal(case: &Case, dialect: Dialect, change: impl Fn(&str) -> String) -> String {
    let text = case.program().write(dialect).expect("a program").text;
    let changed: Vec<String> = text.lines().map(change).filter(|l| l != "-").collect();
    let changed = changed.join("\n") + "\n";
    assert_ne!(changed, text, "nothing was changed");
    let working_space = case.program().working_space(dialect).expect("a scene");
    replay::check(&changed, &working_space).expect_err("refused").to_string()
}

#[test]
fn a_program_that_touches_is_refused_with_its_block() {
    let case = case();
    let refused = |from: &'static str, to: &'static str, words: &[&str]| {
        for dialect in Dialect::WITH_MACROS {
            let text = case.program().write(dialect).expect("a program").text;
            if !text.lines().any(|l| l == from) {
                continue;
            }
            let said = refusal(&case, dialect, |l| if l == from { to.to_owned() } else { l.to_owned() });
            assert!(words.iter().all(|w| said.contains(w)), "{dialect:?}, {from} -> {to}: {said}");
        }
    };
    for dialect in Dialect::WITH_MACROS {
        // the lead-in of older programs: down to the finished diameter in rapid, inside the end
        // face
        let said = refusal(&case, dialect, |l| {
            let inside = l.replace("G00 Z60.5", "G00 Z59.5");
            if l.starts_with("G01 X") { l[4..].replace(" F0.1", "") } else { inside }
        });
        assert!(said.contains("(X9.9") && said.contains("in rapid the tool touches the stock"), "{said}");
        let said = refusal(&case, dialect, |l| match l {
            "G00 Z60.5" => "G00 Z59.5".into(),
            "X13." => "X10.6".into(),
            l => l.into(),
        });
        assert!(said.contains("(X10.6)") && said.contains("half the clearance"), "{said}");
    }
    refused("G00 Z60.5", "G00 X13. Z60.5", &["X and Z move in rapid together below the change position"]);
    refused("G00 Z60.5", "G01 X13. Z60.5", &["needs F above 0"]);
    refused("Z100.", "-", &["the tool is changed at"]);
    refused("G28 W0.", "-", &["the tool is changed at"]);
    refused("G28 U0.", "G28 U0. W0.", &["X and Z move in rapid together"]);
    refused("G28 U0.", "G28 X0.", &["G28 is understood with"]);
    refused("G43", "G41", &["G41 is not understood"]);
    refused("G18 G21 G40 G99", "G18 G21 G40 G98", &["per revolution"]);
    refused("G18 G21 G40 G99", "G18 G40 G99", &["G21"]);
    refused("G96 S80 M03", "G96 S80 M04", &["without the spindle turning"]);
    refused("G96 D2000. S80.0 M3", "G96 D2000. S80.0", &["without the spindle turning"]);
    refused("T0116", "T0216", &["tool 2, not tool 1"]);
    refused("M2", "M99", &["M99 is not understood"]);
    refused("M30", "-", &["ends without M02 or M30"]);
}

#[test]
fn a_cut_that_is_short_too_deep_or_in_the_jaws_is_refused() {
    let case = case();
    let dialect = Dialect::Linuxcnc;
    let starts_with = |start: &'static str, f: fn(&str) -> String| {
        refusal(&case, dialect, move |l| if l.starts_with(start) { f(l) } else { l.to_owned() })
    };
    let text = case.program().write(dialect).expect("a program").text;
    let last = text.lines().find(|l| l.ends_with("Z0.5")).expect("the end of the cut").to_owned();
    let said = refusal(&case, dialect, |l| if l == last { l.replace("Z0.5", "Z-0.2") } else { l.to_owned() });
    assert!(said.contains("Z-0.2") && said.contains("room behind Z 0"), "{said}");
    let said = refusal(&case, dialect, |l| if l == last { "-".into() } else { l.to_owned() });
    assert!(said.contains("not cut to size"), "{said}");
    let said = starts_with("G01 X", |l| l.replacen("X9.98", "X9.97", 1).replacen("X9.99", "X9.97", 1));
    assert!(said.contains("below the commanded"), "{said}");
    // the cut must reach the finished diameter: a knot that is too large leaves metal
    let knot = text.lines().find(|l| l.ends_with("Z30.")).expect("a knot").to_owned();
    let said = refusal(&case, dialect, |l| if l == knot { "X10.2 Z30.".into() } else { l.to_owned() });
    assert!(said.contains("not cut to size"), "{said}");
    // a wear value that is doubled by a control that takes it in radius
    let mut other = case.clone();
    other.settings.wear_x = Some(WearX::Radius);
    other.plan.offset.o_mm.iter_mut().for_each(|o| *o += 0.1);
    let text = other.program().write(Dialect::Fanuc).expect("a program").text;
    let mut taken = other.clone();
    taken.settings.wear_x = Some(WearX::Diameter);
    let working_space = taken.program().working_space(Dialect::Fanuc).expect("a scene");
    let said = replay::check(&text, &working_space).expect_err("half the correction is missing").to_string();
    assert!(said.contains("not cut to size"), "{said}");
    let line = |t: &str| t.lines().find(|l| l.starts_with("G10 P16 X-")).expect("the register").to_owned();
    let value = |t: &str| line(t)[9..].parse::<f64>().expect("a number");
    let in_diameter = taken.program().write(Dialect::Fanuc).expect("a program").text;
    assert!(
        (value(&in_diameter) / value(&text) - 2.0).abs() < 0.02,
        "{} {}",
        line(&in_diameter),
        line(&text)
    );
}

#[test]
fn where_the_offset_word_chooses_the_geometry_the_path_carries_all() {
    let mut case = case();
    case.settings.geometry_offset = Some(GeometryOffset::ByOffset);
    let text = case.program().write(Dialect::Fanuc).expect("a program").text;
    assert!(!text.contains("G10") && text.contains("\nT0101\n") && !text.contains("T0116"), "{text}");
}

#[test]
fn what_stands_in_the_way_is_named() {
    let said = |change: &dyn Fn(&mut NcSettings, &mut Workpiece)| {
        let mut case = case();
        change(&mut case.settings, &mut case.piece);
        case.program().write(Dialect::Linuxcnc).expect_err("refused").to_string()
    };
    let place = |from_z_mm, to_z_mm, diameter_mm| Obstacle { from_z_mm, to_z_mm, diameter_mm };
    let text = said(&|s, _| s.steady_rests = Some(vec![place(20.0, 40.0, 60.0)]));
    assert!(text.contains("in feed the tool touches the steady rest"), "{text}");
    let text = said(&|_, p| p.steady_z_mm = vec![30.0]);
    assert!(text.contains("nc.steady_rests is not stated"), "{text}");
    let text = said(&|s, _| s.gauge_head = Some(place(50.0, 90.0, 40.0)));
    assert!(text.contains("gauge head"), "{text}");
    let text = said(&|s, _| s.travel = Some(Travel { x_mm: (0.0, 90.0), z_mm: (0.0, 500.0) }));
    assert!(text.contains("leaves the travel"), "{text}");
    let chuck = |jaws_to_z_mm| Some(Chuck { diameter_mm: 80.0, jaws_to_z_mm, jaws_diameter_mm: None });
    let text = said(&|s, _| s.chuck = chuck(3.0));
    assert!(text.contains("jaws"), "{text}");
    let holder = Holder { towards_chuck_mm: 0.0, towards_tailstock_mm: 20.0, above_mm: 4.0 };
    let text = said(&|s, _| s.holder = Some(holder));
    assert!(text.contains("tailstock centre (assumed)"), "{text}");
    let centre =
        Centre { point_deg: 60.0, hole_mm: 11.0, body_mm: 12.0, quill_mm: 40.0, quill_from_mm: 60.0 };
    let text = said(&|s, _| s.tailstock = Some(Tailstock::Centre(centre)));
    assert!(text.contains("tailstock centre"), "{text}");
    let text = said(&|s, _| s.change_position = Some(ChangePosition { x_mm: 12.0, z_mm: 100.0 }));
    assert!(text.contains("nc.change_position.x_mm = 12"), "{text}");
    let text = said(&|s, _| s.change_position = Some(ChangePosition { x_mm: 70.0, z_mm: 150.0 }));
    assert!(text.contains("tailstock"), "{text}");
    let text = said(&|s, _| s.least_z_mm = 2.6);
    assert!(text.contains("nc.least_z_mm"), "{text}");
    // and an obstacle outside the path is no reason to refuse
    let mut free = case();
    free.settings.tailstock = Some(Tailstock::Absent);
    free.settings.chuck = chuck(0.4);
    free.settings.holder = Some(Holder { towards_chuck_mm: 0.0, towards_tailstock_mm: 20.0, above_mm: 4.0 });
    free.settings.gauge_head = Some(place(-200.0, -100.0, 60.0));
    free.settings.steady_rests = Some(Vec::new());
    free.piece.steady_z_mm = vec![30.0];
    free.settings.travel = Some(Travel { x_mm: (-5.0, 300.0), z_mm: (-5.0, 500.0) });
    free.program().write(Dialect::Linuxcnc).expect("clear");
}

#[test]
fn what_a_control_leaves_open_is_asked_for() {
    let mut case = case();
    (case.settings.wear_x, case.settings.spindle, case.settings.geometry_offset) = (None, None, None);
    case.program().write(Dialect::Linuxcnc).expect("G7 and M3 are LinuxCNC's own");
    for (dialect, words) in [
        (Dialect::Fanuc, vec!["wear_x", "5004", "ORC", "geometry_offset", "5002", "LGN", "spindle"]),
        (Dialect::Gsk, vec!["wear_x", "ORC", "geometry_offset", "spindle"]),
    ] {
        let said = case.program().write(dialect).expect_err("open").to_string();
        assert!(words.iter().all(|w| said.contains(w)), "{said}");
        let said = case.line().write(dialect).expect_err("open").to_string();
        assert!(words.iter().all(|w| said.contains(w)), "{said}");
    }
    case.settings.spindle = Some(Spindle::M04);
    let said = case.program().write(Dialect::Fanuc).expect_err("open").to_string();
    assert!(said.contains("wear_x") && !said.contains("spindle ="), "{said}");
}

#[test]
fn the_head_says_what_a_person_must_know() {
    let mut case = case();
    case.piece.direction = Direction::TowardsTailstock;
    let text = case.program().write(Dialect::Linuxcnc).expect("a program").text;
    for words in [
        "(STAYS UNCUT: Z 0 TO 0.5, NOSE FILLET TO Z 1.3)",
        "(CUTS IN FEED FROM Z 2.1 TO Z 61.3)",
        "(CHANGE POSITION: X 100 Z 100)",
        "(TOOL 1 NOSE R 0.8, SPINDLE M03)",
        "(TOOL Z IS SET AT THE SIDE OF THE NOSE TOWARDS THE TAILSTOCK)",
        "(START: ANYWHERE CLEAR",
        "NOT STATED: NOSE RADIUS, 0.8 ASSUMED",
        "NOT STATED: TAILSTOCK, A CENTRE OF 60 DEG IS ASSUMED",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
}

#[test]
fn loops_and_jumps_of_custom_macro_b_are_followed() {
    let case = case();
    let head = "%\nO8001 (TEST)\nG18 G21 G40 G99\n#1=3.\n";
    let ends = |body: &str| -> Vec<f64> {
        let events = run(&format!("{head}{body}M30\n%\n"), &case, Dialect::Fanuc, Point { x: 90.0, z: 90.0 });
        let z = |e: &Event| match &e.deed {
            Deed::Move { to, .. } => Some(to.z),
            _ => None,
        };
        events.iter().filter_map(z).collect()
    };
    assert_eq!(ends("WHILE[#1 GT 0.]DO1\nG00 Z[#1*10.]\n#1=[#1-1.]\nEND1\n"), [30.0, 20.0, 10.0]);
    assert_eq!(ends("N1 G00 Z[#1*10.]\n#1=[#1-1.]\nIF[#1 GE 2.]GOTO 1\nZ5.\n"), [30.0, 20.0, 5.0]);
    assert_eq!(ends("GOTO 7\nG00 Z1.\nN7\nG00 Z2.\n"), [2.0]);
    assert_eq!(ends("IF[#1 EQ 3.]THEN #2=8.\nG00 Z#2\n"), [8.0]);
    let endless = "N1\nGOTO 1\n";
    let control = case.program().working_space(Dialect::Fanuc).expect("a scene");
    let control = control.control(Point { x: 90.0, z: 90.0 });
    let said = replay::run(&format!("{head}{endless}M30\n"), &control).expect_err("endless").1;
    assert!(said.contains("goes on"), "{said}");
    for (block, why) in [
        ("G00 X100", "no decimal point"),
        ("G00 X#9", "#9 is read before it is set"),
        ("G33 X1. Z1.", "G33 is not understood"),
        ("G00 X1. X2.", "X stands twice"),
        ("GOTO 5", "there is no N5"),
        ("G00 X1. (OPEN", "not closed"),
    ] {
        let (line, said) = replay::run(&format!("{head}{block}\nM30\n"), &control).expect_err(block);
        assert!(line == 5 && said.contains(why), "{block}: {said}");
    }
}

#[test]
fn machine_data_survive_toml() {
    let mut settings = case().settings;
    settings.tailstock = Some(Tailstock::Absent);
    let place = Obstacle { from_z_mm: -50.0, to_z_mm: -20.0, diameter_mm: 60.0 };
    settings.steady_rests = Some(vec![place]);
    settings.gauge_head = Some(place);
    settings.chuck = Some(Chuck { diameter_mm: 90.0, jaws_to_z_mm: 0.3, jaws_diameter_mm: Some(60.0) });
    settings.travel = Some(Travel { x_mm: (-5.0, 300.0), z_mm: (-5.0, 500.0) });
    settings.change_position = Some(ChangePosition { x_mm: 200.0, z_mm: 300.0 });
    let text = toml::to_string(&settings).expect("text");
    assert!(text.contains("tailstock = \"none\"") && text.contains("wear_x = \"diameter\""), "{text}");
    assert_eq!(toml::from_str::<NcSettings>(&text).expect("read again"), settings);
    let centre = "[tailstock.centre]\nhole_mm = 4.0\nbody_mm = 12.0\nquill_mm = 40.0\nquill_from_mm = 60.0\n";
    let read: NcSettings = toml::from_str(centre).expect("read");
    assert!(matches!(read.tailstock, Some(Tailstock::Centre(c)) if c.point_deg == 60.0), "{read:?}");
}
