//! NC programs: their text, and their moves by LinuxCNC's own interpreter.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::linuxcnc;

use linuxcnc::{Move, interpret};
use shadowgauge::nc::replay::{self, Deed, Point};
use shadowgauge::nc::{
    Dialect, Direction, GeometryOffset, MacroProgram, NcError, NcSettings, Path, Remeasure, Spindle,
    TurningProgram, WearX, Workpiece, fit_line,
};
use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};

const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };

fn plan() -> PassPlan {
    let station_z_mm: Vec<f64> = (0..100).map(|i| 2.5 + 5.0 * f64::from(i)).collect();
    let barrel = |z: &f64| 0.0532 * (1.0 - (z / 250.0 - 1.0).powi(2)) + 0.00713 * z / 500.0;
    let offset = DiameterOffset { o_mm: station_z_mm.iter().map(barrel).collect() };
    PassPlan {
        pass: 4,
        nominal_mm: 24.9935,
        cutting: CUTTING,
        station_z_mm,
        offset,
        form: PlannedForm::PLAIN,
    }
}

/// A machine that states how its control reads offsets, and nothing else.
fn stated() -> NcSettings {
    NcSettings {
        wear_x: Some(WearX::Diameter),
        geometry_offset: Some(GeometryOffset::ByTool),
        spindle: Some(Spindle::M03),
        ..NcSettings::default()
    }
}

fn settings() -> NcSettings {
    let remeasure = Some(Remeasure { m_code: 150, smallest_variable: 840, largest_variable: 841 });
    NcSettings { part_number: 17, remeasure, ..stated() }
}

fn piece() -> Workpiece {
    Workpiece::new(500.0, 27.0, 25.5)
}

fn write(plan: &PassPlan, settings: &NcSettings, dialect: Dialect) -> Result<(String, Path), NcError> {
    turning(plan, settings, &piece()).write(dialect).map(|w| (w.text, w.cut))
}

fn turning<'a>(plan: &'a PassPlan, settings: &'a NcSettings, piece: &'a Workpiece) -> TurningProgram<'a> {
    TurningProgram { plan, settings, piece, limits_mm: Some((24.987, 25.0)), reason: "released" }
}

/// The paper's reconstructed errors in units of 0.01 mm.
fn paper_line() -> MacroProgram<'static> {
    static SETTINGS: std::sync::LazyLock<NcSettings> = std::sync::LazyLock::new(stated);
    let x: Vec<f64> = (1..=6).map(|i| f64::from(i) / 6.0).collect();
    MacroProgram {
        line: fit_line(&x, &[4.4, 4.6, 4.8, 5.0, 5.1, 5.4]).expect("a line"),
        unit_mm: 0.01,
        diameter_mm: (23.2, 23.2),
        piece: Workpiece::new(300.0, 25.0, 24.0),
        pass: 2,
        cutting: CUTTING,
        limits_mm: None,
        settings: &SETTINGS,
    }
}

/// Numbers of axis, feed and macro words of a line without comments.
fn bare(line: &str) -> String {
    line.split('(').next().unwrap_or_default().trim().to_owned()
}

#[test]
fn every_length_carries_a_decimal_point_and_is_plain_ascii() {
    for dialect in Dialect::WITH_MACROS {
        let (turning, _) = write(&plan(), &settings(), dialect).expect("a program");
        let texts = [turning, paper_line().write(dialect).expect("a program").text];
        for line in texts.iter().flat_map(|t| t.lines()) {
            assert!(line.is_ascii() && line.len() < 80, "{line}");
            for word in bare(line).split_whitespace() {
                let axis = word.starts_with(['X', 'Z', 'F', 'U', 'W']);
                assert!(!axis || word.contains(['.', '#']), "{dialect:?}: {line}");
            }
            let assigned = bare(line);
            if let Some((_, value)) = assigned.split_once('=').filter(|_| line.starts_with('#')) {
                assert!(value.contains(['.', '#']), "{line}");
            }
        }
    }
}

#[test]
fn the_fanuc_register_holds_the_mean_and_the_path_the_rest() {
    let (text, path) = write(&plan(), &settings(), Dialect::Fanuc).expect("a program");
    let lines: Vec<&str> = text.lines().collect();
    let at = |start: &str| lines.iter().position(|l| l.starts_with(start)).unwrap_or(usize::MAX);
    assert!(at("G10 P16 X-") < at("T0116") && at("T0116") < at("G01"), "the register before the call");
    assert!(at("IF[#820 EQ 1704.]THEN #3000=") < at("G10"), "used once");
    assert!(at("G50 S2000") < at("G96 S80"));
    assert!(at("#820=1704.") > at("G01"));
    assert!(at("M150") < at("IF[#840 LT 24.987]") && lines.iter().any(|l| l.contains("GT 25.]")));
    assert!(lines.contains(&"G10 P16 X0."), "the register is left empty");
    let mean = plan().offset.o_mm.iter().sum::<f64>() / 100.0;
    assert!((path.wear_mm + mean).abs() <= 0.0005);
    // the path contains the shape alone: its mean over the stations is the nominal
    let shape: f64 = plan().station_z_mm.iter().map(|z| x_at(&path, *z) - 24.9935).sum::<f64>() / 100.0;
    assert!(shape.abs() < 0.001, "{shape}");
}

fn x_at(path: &Path, z: f64) -> f64 {
    let pair = path.knots.windows(2).find(|w| w[1].0 <= z && z <= w[0].0).expect("inside the path");
    pair[1].1 + (pair[0].1 - pair[1].1) * (z - pair[1].0) / (pair[0].0 - pair[1].0)
}

#[test]
fn rounded_offsets_are_given_back_and_knots_added_until_they_fit() {
    for dialect in Dialect::ALL {
        let (_, path) = write(&plan(), &settings(), dialect).expect("a program");
        let rounding = 10f64.powi(-(dialect.x_decimals() as i32));
        assert!(path.knots.len() >= 21, "21 knots");
        let departure = path.largest_departure(&plan());
        println!("{dialect:?}: {} knots, departure {departure:.6} mm", path.knots.len());
        assert!(departure <= 0.0002 + 1.5 * rounding);
        for (z, o) in plan().station_z_mm.iter().zip(&path.in_force.o_mm) {
            assert!((24.9935 - o - (x_at(&path, *z) + path.wear_mm)).abs() < 1e-9);
        }
        let (z_first, z_last) = (path.knots[0].0, path.knots[path.knots.len() - 1].0);
        assert!(z_first == 497.5 && z_last == 2.5, "from the last station to the first");
    }
}

#[test]
fn paths_out_of_range_are_refused() {
    let refused = |change: &dyn Fn(&mut PassPlan, &mut NcSettings)| {
        let (mut p, mut s) = (plan(), settings());
        change(&mut p, &mut s);
        write(&p, &s, Dialect::Linuxcnc).expect_err("refused").to_string()
    };
    let text = refused(&|p, _| p.offset.o_mm[3] = 0.31);
    assert!(text.contains("0.31") && text.contains("nc.correction_limit_mm"), "{text}");
    assert!(refused(&|p, _| p.offset.o_mm[3] = f64::NAN).contains("NaN"));
    assert!(refused(&|_, s| s.least_z_mm = 2.6).contains("nc.least_z_mm"));
    assert!(refused(&|_, s| s.tool = 0).contains("nc.tool"));
    assert!(refused(&|p, _| p.offset.o_mm.truncate(99)).contains("99 offsets for 100 stations"));
    assert!(refused(&|p, _| p.nominal_mm = 26.0).contains("must not be below"));
    let mut steep = paper_line();
    steep.unit_mm = 1.0;
    assert!(matches!(steep.write(Dialect::Fanuc), Err(NcError::Range { .. })));
}

#[test]
fn macro_values_are_the_papers() {
    let program = paper_line();
    assert!((program.line.b - 201.0 / 175.0).abs() < 1e-12 && (program.line.a - 316.0 / 75.0).abs() < 1e-12);
    let v = program.values();
    assert!((v.v804 - 4.404762).abs() < 1e-6 && (v.v805 - 5.361905).abs() < 1e-6);
    let text = program.write(Dialect::Fanuc).expect("a program").text;
    let order: Vec<usize> =
        ["#804=[#802*1./6.+#803]", "#805=[#802+#803]", "#810=[#800-#804", "#811=[#801-#805"]
            .iter()
            .map(|l| text.find(l).expect("the equation"))
            .collect();
    assert!(order.windows(2).all(|w| w[0] < w[1]), "9, 10, 7, 8");
    assert!(!text.contains("#800=#800"), "fresh variables");
    assert!(text.find("#820 EQ").expect("used once") < text.find("G01").expect("the cut"));
}

#[test]
fn linuxcnc_has_no_u_words_and_no_variable_3000() {
    let (turning, _) = write(&plan(), &settings(), Dialect::Linuxcnc).expect("a program");
    let line = paper_line().write(Dialect::Linuxcnc).expect("a program").text;
    for text in [turning, line] {
        assert!(!text.contains("#3000") && text.contains("(ABORT,"));
        assert!(text.lines().all(|l| !bare(l).contains('U')), "{text}");
        assert!(text.contains("G7 G18 G21") && text.contains("G95") && text.contains("G96 D2000."));
    }
}

fn feeds(moves: &[Move]) -> Vec<(f64, f64)> {
    moves.iter().filter(|m| !m.1).map(|m| m.0).collect()
}

#[test]
fn rs274_prints_the_radius_that_was_intended() {
    // LinuxCNC's M100-M199 are programs of the user's: without such a program the interpreter
    // refuses them
    let plain = NcSettings { remeasure: None, ..settings() };
    let (text, path) = write(&plan(), &plain, Dialect::Linuxcnc).expect("a program");
    let Some((moves, printed)) = interpret(&text) else { return };
    assert!(printed.contains("PROGRAM_END"), "{printed}");
    assert!(printed.contains("SET_SPINDLE_MODE(0 2000.0000)") && printed.contains("SET_FEED_MODE(0, 1)"));
    let feeds = feeds(&moves);
    // in radially, the ends of the cut around the knots, out radially
    assert_eq!(feeds.len(), path.knots.len() + 3);
    let mut worst = 0.0_f64;
    for (radius, z) in &feeds[..feeds.len() - 1] {
        let p = plan();
        let inside = z.clamp(p.station_z_mm[0], p.station_z_mm[99]);
        let i = ((inside - 2.5) / 5.0).floor().min(98.0) as usize;
        let share = (inside - p.station_z_mm[i]) / 5.0;
        let o = p.offset.o_mm[i] * (1.0 - share) + p.offset.o_mm[i + 1] * share;
        worst = worst.max((radius - 0.5 * (p.nominal_mm - o)).abs());
    }
    println!("{} moves, radius within {:.6} mm of the intended one", feeds.len(), worst);
    assert!(worst <= 1e-4, "0.1 µm");
    assert_eq!((feeds[0].1, feeds[feeds.len() - 1]), (500.5, (14.5, 0.5)), "from the air to least_z_mm");
}

/// The moves of the replay as rs274 prints them, from its start in the origin.
fn replayed(text: &str, settings: &NcSettings) -> Vec<Move> {
    let origin = Point { x: 0.0, z: 0.0 };
    let variables = vec![(820, 0.0)];
    let control = replay::Control {
        dialect: Dialect::Linuxcnc,
        settings,
        start: origin,
        reference: origin,
        variables,
        with_probe: false,
        surface: None,
        tool_page: None,
    };
    let events = replay::run(text, &control).expect("understood");
    let moved = |deed: &Deed| match deed {
        Deed::Move { to, rapid, .. } => Some(((0.5 * to.x, to.z), *rapid)),
        _ => None,
    };
    events.iter().filter_map(|e| moved(&e.deed)).collect()
}

#[test]
fn the_replay_moves_as_linuxcnc_does() {
    let plain = NcSettings { remeasure: None, ..settings() };
    for direction in [Direction::TowardsChuck, Direction::TowardsTailstock] {
        let piece = Workpiece { direction, ..piece() };
        let knots = turning(&plan(), &plain, &piece).write(Dialect::Linuxcnc).expect("a program").text;
        let mut program = paper_line();
        program.piece.direction = direction;
        let line = program.write(Dialect::Linuxcnc).expect("a program").text;
        // WHILE, operators, functions and radius words, which the programs themselves do not use
        let loops = "G7 G18 G21 G40 G90 G95\n#1=3.\nG00 X50.\no1 while [#1 GT 0.]\nZ[ABS[#1-10.]*2.+7. MOD 4.]\n\
                     #1=[#1-1.]\no1 endwhile\no2 if [#1 NE 0.]\nX1.\no2 else\nG8 X[SQRT[16.]]\no2 endif\nM2\n";
        for text in [knots, line, loops.to_owned()] {
            let Some((mut moves, printed)) = interpret(&text) else { return };
            // a move to the present position is not listed
            let mut at = (0.0, 0.0);
            moves.retain(|m| std::mem::replace(&mut at, m.0) != m.0);
            let ours = replayed(&text, &plain);
            assert_eq!(moves.len(), ours.len(), "{text}\n{printed}");
            for (theirs, ours) in moves.iter().zip(&ours) {
                let apart = (theirs.0.0 - ours.0.0).abs().max((theirs.0.1 - ours.0.1).abs());
                assert!(apart <= 6e-5 && theirs.1 == ours.1, "{theirs:?} {ours:?}");
            }
        }
    }
}

#[test]
fn rs274_evaluates_the_macro_program_and_refuses_a_second_use() {
    let program = paper_line();
    let text = program.write(Dialect::Linuxcnc).expect("a program").text;
    let Some((moves, printed)) = interpret(&text) else { return };
    assert!(printed.contains("PROGRAM_END"), "{printed}");
    let v = program.values();
    let cone = |z: f64| {
        let x = (300.0 - z) / 300.0;
        23.2 - 0.01 * (program.line.b * x + program.line.a)
    };
    let feeds = feeds(&moves);
    for (radius, z) in feeds.iter().filter(|f| f.1 <= 300.0 && f.0 < 12.5) {
        assert!((2.0 * radius - cone(*z)).abs() <= 2e-4, "X {} at Z {z}, cone {}", 2.0 * radius, cone(*z));
    }
    assert!(feeds.len() == 5 && (2.0 * feeds[2].0 - v.v810).abs() <= 2e-4, "{feeds:?}");
    // the same program with its number already in #820
    let again = text.replacen("#800=", "#820=102.\n#800=", 1);
    let (moves, printed) = interpret(&again).expect("it ran before");
    assert!(moves.is_empty() && printed.contains("OFFSET WAS USED ALREADY"), "{printed}");
    assert!(!printed.contains("PROGRAM_END"));
    // a correction out of range
    let far = text.replacen("#803=4.213333", "#803=400.", 1);
    let (moves, printed) = interpret(&far).expect("it ran before");
    assert!(moves.is_empty() && printed.contains("CORRECTION OUT OF RANGE"), "{printed}");
}
