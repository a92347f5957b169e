//! The probe qualified on a reference, and the spindle held at an angle while it touches.

use shadowgauge::nc::replay::{self, Deed, Surface, WorkingSpace};
use shadowgauge::nc::{
    Dialect, NcError, NcProbe, NcSettings, ProbeReference, Qualification, SpindleOrientation, Tailstock,
};

use super::linuxcnc::interpret;
use super::{BEFORE, NOMINAL, changed, program, run, touches};

/// True correction of the probe's X less the stated one, mm.
const DRIFT: f64 = 0.0031;
/// The scatter of the five touches of a side, mm of diameter: their standard deviation is 0.79 µm.
const SCATTER: [f64; 5] = [0.0004, -0.0006, 0.0011, -0.0009, 0.0];

fn settings(held: bool) -> NcSettings {
    let plain = super::settings();
    let reference =
        ProbeReference { diameter_mm: 40.0024, length_mm: 60.0, z_mm: None, touches: SCATTER.len() as u32 };
    NcSettings {
        probe: plain.probe.map(|probe| NcProbe { reference: Some(reference), ..probe }),
        tailstock: Some(Tailstock::Absent),
        spindle_orientation: held.then_some(SpindleOrientation {
            angle_deg: 30.0,
            m_code: 19,
            release_m_code: None,
        }),
        ..plain
    }
}

/// The reference for the drifted, scattering probe.
fn met(settings: &NcSettings, run_out_mm: f64) -> Surface {
    let reference = settings.probe.and_then(|p| p.reference).expect("a reference");
    Surface {
        before: vec![(0.0, reference.diameter_mm + DRIFT)],
        run_out_mm,
        scatter_mm: SCATTER.to_vec(),
        ..Surface::default()
    }
}

fn left(text: &str, working_space: &WorkingSpace<'_>) -> impl Fn(u32) -> f64 {
    let start = replay::Point { x: working_space.change.x_mm, z: working_space.change.z_mm };
    let variables = replay::variables(text, &working_space.control(start)).expect("it runs");
    move |number| *variables.get(&number).unwrap_or_else(|| panic!("#{number} is not set"))
}

/// Mean and standard deviation about it.
fn statistics(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

#[test]
fn the_correction_the_ball_and_the_scatter_are_left_in_variables() {
    let (mean, deviation) = statistics(&SCATTER);
    for held in [false, true] {
        let settings = settings(held);
        let probe = settings.probe.expect("a probe");
        let qualification = Qualification::new(&settings).expect("a reference");
        for dialect in Dialect::WITH_MACROS {
            let written = qualification.write(dialect).expect("a program");
            let (text, sides) = (written.text, if held { 2 } else { 1 });
            assert_eq!((written.cut.z_mm, written.cut.touches), (30.0, 5 * sides), "{dialect:?}");
            // 12 µm of indicated run-out, of which 0.87 acts at the angle of 30°
            let run_out = if held { 0.012 } else { 0.0 };
            let working_space =
                qualification.working_space(dialect, met(&settings, run_out)).expect("a scene");
            let events = run(&text, &working_space);
            let touched = touches(&events);
            assert_eq!(touched.len(), 5 * sides as usize);
            assert!(touched.iter().all(|(to, _)| to.z == 30.0));
            let left = left(&text, &working_space);
            // on both sides the same scatter: the run-out cancels
            let correction = probe.correction_mm + DRIFT + mean;
            let near = |found: f64, wanted: f64| (found - wanted).abs() < 2e-9;
            assert!(near(left(880), correction), "{dialect:?}: {} {correction}", left(880));
            assert!(near(left(881), probe.ball_mm + correction));
            let freedom = if held { 8.0 } else { 4.0 };
            let of_sides = (f64::from(sides) * 4.0 * deviation.powi(2) / freedom).sqrt();
            assert!((left(882) / of_sides - 1.0).abs() < 1e-6, "{} {of_sides}", left(882));
            let seen = run_out * 30.0_f64.to_radians().cos();
            assert!(near(left(883), seen), "{} {seen}", left(883));
            assert_eq!(left(884), 5.0);
            for line in text.lines() {
                assert!(line.is_ascii() && line.len() < 80, "{line}");
            }
            assert_eq!(text.contains("M19 R30.") && text.contains("M19 R210."), held, "{text}");
            assert_eq!(text.contains("HELD AT 30 AND 210 DEG"), held, "{text}");
            assert_eq!(text.contains("THE REFERENCE MUST RUN TRUE"), !held, "{text}");
            assert!(!text.contains("CUTS IN FEED") && !text.contains("G96"), "nothing is cut\n{text}");
        }
    }
}

#[test]
fn a_probe_that_scatters_or_touches_elsewhere_is_not_qualified() {
    for held in [false, true] {
        let settings = settings(held);
        let qualification = Qualification::new(&settings).expect("a reference");
        for dialect in Dialect::WITH_MACROS {
            let text = qualification.write(dialect).expect("a program").text;
            let good = met(&settings, 0.0);
            // U of 2 µm is less than twice a scatter of 1.4 times the good one
            let wild = Surface { scatter_mm: SCATTER.map(|s| 1.4 * s).to_vec(), ..good.clone() };
            let far = Surface { before: vec![(0.0, 40.4)], ..good.clone() };
            let missing = Surface { before: vec![(0.0, 30.0)], ..good.clone() };
            for (surface, alarm) in [(good, false), (wild, true), (far, true), (missing, true)] {
                let working_space = qualification.working_space(dialect, surface).expect("a scene");
                let rings = matches!(run(&text, &working_space).pop().expect("events").deed, Deed::Alarm(_));
                assert_eq!(rings, alarm, "{dialect:?} {:?}", working_space.surface);
                let set = left(&text, &working_space)(884);
                assert_eq!(set, if alarm { 0.0 } else { 5.0 }, "no qualification is left by an alarm");
            }
        }
    }
}

/// Programs that take the stored correction measure with it, and stop where there is none.
#[test]
fn programs_take_the_correction_that_the_qualification_left() {
    let mut settings = settings(true);
    settings.probe.iter_mut().for_each(|p| p.stored_correction = true);
    let program = program(&settings);
    for dialect in Dialect::WITH_MACROS {
        let text = program.write(dialect).expect("a program").text;
        assert!(text.contains("-#880]") && !text.contains("+0.0124]\n"), "{text}");
        assert!(text.contains("READ LESS 880 OF ITS QUALIFICATION"), "{text}");
        let mut working_space = program.working_space(dialect, vec![(0.0, BEFORE)]).expect("a scene");
        let surface =
            |at: f64| Surface { before: vec![(0.0, at)], after: vec![(0.0, NOMINAL)], ..Surface::default() };
        working_space.surface = Some(surface(BEFORE + 0.05));
        let stored = |working_space: &mut WorkingSpace<'_>, correction: f64, tool: f64| {
            working_space.variables = vec![(820, 0.0), (880, correction), (884, tool)];
        };
        // the probe reads 0.0124 mm too little; with a correction that is wrong by 20 µm so are the
        // diameters
        for off in [0.0, 0.02] {
            stored(&mut working_space, -0.0124 + off, 5.0);
            let left = left(&text, &working_space);
            assert!((left(841) - (BEFORE + 0.05 - off)).abs() < 1e-9, "{dialect:?} {off}");
        }
        // none; another probe's; one that is far from the probe's data
        for (correction, tool) in [(-0.0124, 0.0), (-0.0124, 7.0), (0.4, 5.0)] {
            stored(&mut working_space, correction, tool);
            let events = run(&text, &working_space);
            assert!(
                matches!(events.last().expect("events").deed, Deed::Alarm(_)) && touches(&events).is_empty(),
                "{dialect:?} {correction} {tool}"
            );
        }
    }
}

#[test]
fn the_spindle_is_held_at_its_angle_or_the_header_says_that_it_is_not() {
    for held in [false, true] {
        let settings = settings(held);
        let program = program(&settings);
        for dialect in Dialect::WITH_MACROS {
            let text = program.write(dialect).expect("a program").text;
            // before and after the cut at the same angle
            let working_space = program.working_space(dialect, vec![(0.0, BEFORE)]).expect("a scene");
            let angles: Vec<Option<f64>> = run(&text, &working_space)
                .iter()
                .filter_map(|e| match e.deed {
                    Deed::Probe { angle_deg, .. } => Some(angle_deg),
                    _ => None,
                })
                .collect();
            assert_eq!(angles, vec![held.then_some(30.0); 12], "{dialect:?}");
            assert_eq!(text.matches("\nM19 R30.").count(), if held { 2 } else { 0 });
            assert_eq!(text.contains("THE SPINDLE IS HELD AT 30 DEG BY M19"), held, "{text}");
            assert_eq!(text.contains("THE ANGLE OF THE SPINDLE IS NOT FIXED"), !held, "{text}");
            if !held {
                continue;
            }
            // without the block, and after a block that releases the spindle
            let gone = changed(&text, |l| if l.starts_with("M19") { "-".to_owned() } else { l.to_owned() });
            let said = replay::check(&gone, &working_space).expect_err("refused").to_string();
            assert!(said.contains("not held at its angle"), "{dialect:?}: {said}");
            let off = if dialect == Dialect::Linuxcnc { "M5" } else { "M05" };
            let loose = changed(&text, |l| match l.starts_with("M19") {
                true => format!("{l}\n{off}"),
                false => l.to_owned(),
            });
            assert!(replay::check(&loose, &working_space).is_err(), "{dialect:?}");
            if dialect == Dialect::Linuxcnc {
                let soon = changed(&text, |l| l.replace("M19 R30. Q10.", "M19 R30."));
                let said = replay::check(&soon, &working_space).expect_err("refused").to_string();
                assert!(said.contains("Q is missing"), "{said}");
            }
        }
    }
    // a code that needs a release code, and invalid codes
    let mut other = settings(true);
    let orientation = |m_code: u32, angle_deg: f64| {
        Some(SpindleOrientation { angle_deg, m_code, release_m_code: Some(20) })
    };
    other.spindle_orientation = orientation(21, 0.0);
    let text = program(&other).write(Dialect::Fanuc).expect("a program").text;
    assert!(text.matches("\nM21 R0.\n").count() == 2 && text.matches("\nM20\n").count() == 2, "{text}");
    let said = program(&other).write(Dialect::Linuxcnc).expect_err("M19 alone").to_string();
    assert!(said.contains("nc.spindle_orientation.m_code"), "{said}");
    for (m_code, angle) in [(3, 0.0), (19, 360.0), (19, -1.0)] {
        other.spindle_orientation = orientation(m_code, angle);
        assert!(program(&other).write(Dialect::Fanuc).is_err(), "{m_code} {angle}");
    }
}

#[test]
fn machine_data_of_the_probe_survive_toml() {
    for held in [false, true] {
        let settings = settings(held);
        let text = toml::to_string(&settings).expect("written");
        assert_eq!(toml::from_str::<NcSettings>(&text).expect("read"), settings, "{text}");
    }
    let unknown = "angle_deg = 0.0\nword = \"S\"";
    assert!(toml::from_str::<SpindleOrientation>(unknown).is_err());
}

#[test]
fn references_that_cannot_be_touched_are_named() {
    let said = |change: &dyn Fn(&mut NcSettings, &mut ProbeReference)| {
        let mut settings = settings(false);
        let mut reference = settings.probe.and_then(|p| p.reference).expect("a reference");
        change(&mut settings, &mut reference);
        settings.probe.iter_mut().for_each(|p| p.reference = Some(reference));
        match Qualification::new(&settings).and_then(|q| q.write(Dialect::Linuxcnc)) {
            Ok(written) => panic!("{}", written.text),
            Err(error) => error.to_string(),
        }
    };
    assert!(said(&|_, r| r.z_mm = Some(70.0)).contains("nc.probe.reference.z_mm"));
    assert!(said(&|_, r| r.z_mm = Some(59.0)).contains("nc.probe.reference.z_mm"), "the ball over the edge");
    assert!(said(&|_, r| r.touches = 1).contains("nc.probe.reference.touches"));
    assert!(said(&|_, r| r.diameter_mm = 0.0).contains("nc.probe.reference.diameter_mm"));
    // a chuck in the way of the body
    let text = said(&|s, r| {
        r.z_mm = Some(15.0);
        s.chuck.iter_mut().for_each(|c| c.diameter_mm = 400.0);
    });
    assert!(text.contains("chuck"), "{text}");
    let none = super::settings();
    assert!(Qualification::new(&none).expect_err("no reference").to_string().contains("nc.probe.reference"));
}

/// A program whose probing moves end where the simulated surface is touched: rs274 ends each at its
/// target.
fn simulated(text: &str, working_space: &WorkingSpace<'_>) -> String {
    let mut touched = touches(&run(text, working_space)).into_iter();
    changed(text, |l| match l.starts_with("G38.2 X") {
        true => touched.next().map_or(l.to_owned(), |(to, _)| format!("G38.2 X{:.7} F50.", to.x)),
        // its results, printed at the end
        false if l == "M2" => "(DEBUG,LEFT #880 #881 #882 #883 #884)\nM2".to_owned(),
        false => l.to_owned(),
    })
}

#[test]
fn linuxcnc_qualifies_and_measures_with_simulated_touches() -> Result<(), NcError> {
    let mut settings = settings(true);
    settings.probe.iter_mut().for_each(|p| p.stored_correction = true);
    let qualification = Qualification::new(&settings)?;
    let text = qualification.write(Dialect::Linuxcnc)?.text;
    let working_space = qualification.working_space(Dialect::Linuxcnc, met(&settings, 0.012))?;
    let Some((_, printed)) = interpret(&simulated(&text, &working_space)) else { return Ok(()) };
    assert!(printed.contains("PROGRAM_END") && printed.matches("STRAIGHT_PROBE(").count() == 10, "{printed}");
    assert!(printed.matches("ORIENT_SPINDLE(").count() == 2, "{printed}");
    let told = printed.lines().find_map(|l| l.split_once("LEFT ").map(|(_, rest)| rest)).expect("LEFT");
    let numbers: Vec<f64> = told
        .split(|c: char| !(c.is_ascii_digit() || ".-".contains(c)))
        .filter_map(|n| n.parse().ok())
        .collect();
    let left = left(&text, &working_space);
    for (number, theirs) in (880..).zip(&numbers) {
        // DEBUG prints six decimals
        assert!((left(number) - theirs).abs() < 2e-6, "#{number}: {} {theirs}\n{printed}", left(number));
    }
    assert_eq!(numbers.len(), 5, "{told}");
    // its alarms: a touch far from the expected position, scatter beyond U
    let wild = Surface { scatter_mm: SCATTER.map(|s| 1.4 * s).to_vec(), ..met(&settings, 0.0) };
    let far = Surface { before: vec![(0.0, 40.4)], ..Surface::default() };
    for (surface, word) in [(far, "PROBE RESULT OUT OF RANGE"), (wild, "PROBE SCATTERS BEYOND U")] {
        let working_space = qualification.working_space(Dialect::Linuxcnc, surface)?;
        let (_, printed) = interpret(&simulated(&text, &working_space)).expect("it ran before");
        assert!(printed.contains(word) && !printed.contains("PROGRAM_END"), "{word}: {printed}");
    }
    // the whole program with the stored correction: it runs, and stops without it
    let program = program(&settings);
    let text = program.write(Dialect::Linuxcnc)?.text;
    let working_space = program.working_space(Dialect::Linuxcnc, vec![(0.0, BEFORE + 0.02)])?;
    let stored = simulated(&text, &working_space).replacen("\nG7 ", "\n#880=-0.0124\n#884=5.\nG7 ", 1);
    let (_, printed) = interpret(&stored).expect("it ran before");
    assert!(printed.contains("PROGRAM_END") && printed.matches("STRAIGHT_PROBE(").count() == 12, "{printed}");
    let (_, printed) = interpret(&text).expect("it ran before");
    assert!(printed.contains("PROBE IS NOT QUALIFIED") && !printed.contains("PROGRAM_END"), "{printed}");
    Ok(())
}
