//! One program for a whole contour, in every dialect, replayed against the solid.

use super::job;
use shadowgauge::nc::{
    Dialect, GeometryOffset, NcSettings, Path, Spindle, TurningProgram, WearX, Workpiece, replay,
};
use shadowgauge::plan::{DiameterOffset, PassPlan};

fn settings() -> NcSettings {
    NcSettings {
        wear_x: Some(WearX::Diameter),
        geometry_offset: Some(GeometryOffset::ByTool),
        spindle: Some(Spindle::M03),
        nose_radius_mm: Some(0.8),
        ..NcSettings::default()
    }
}

/// The last pass of the preset, its sections offset by 20, −10 and 30 µm and a slope.
fn plan() -> PassPlan {
    let order = job().loop_job();
    let z = order.station_z_mm();
    let offset = |z: &f64| match *z {
        z if z < 70.0 => 0.02 + 1e-5 * z,
        z if z < 140.0 => -0.01,
        _ => 0.03,
    };
    order.pass_plan(3, DiameterOffset { o_mm: z.iter().map(offset).collect() })
}

fn piece() -> Workpiece {
    Workpiece { contour: job().loop_job().turned_contour(), ..Workpiece::new(200.0, 29.2, 28.4) }
}

fn program<'a>(plan: &'a PassPlan, settings: &'a NcSettings, piece: &'a Workpiece) -> TurningProgram<'a> {
    TurningProgram { plan, settings, piece, limits_mm: None, reason: "released" }
}

#[test]
fn every_dialect_cuts_the_contour_and_its_offsets() {
    let (plan, settings, piece) = (plan(), settings(), piece());
    for dialect in Dialect::ALL {
        let written =
            program(&plan, &settings, &piece).write(dialect).unwrap_or_else(|e| panic!("{dialect:?}: {e}"));
        // Rounding of X is half an increment; the mitre of two lines of 10 µm in 60 mm is less.
        assert!(
            written.cut.largest_departure(&plan) < 0.0012,
            "{dialect:?}: {}",
            written.cut.largest_departure(&plan)
        );
        let upright =
            written.cut.knots.windows(2).filter(|k| k[0].0 == k[1].0 && (k[1].1 - k[0].1).abs() > 0.2);
        assert!(upright.count() >= 1, "{dialect:?}: the chamfered collar's shoulder is upright");
    }
}

/// The taper of 1:10 lies r(sin α + cos α − 1) inside of the programmed point's line.
#[test]
fn the_nose_is_in_the_path_along_a_taper() {
    let order = job().loop_job();
    let plan = order.pass_plan(3, DiameterOffset::zero(order.station_z_mm().len()));
    let path = Path::new(&plan, &settings(), Dialect::Linuxcnc).unwrap();
    let (z, x): (Vec<f64>, Vec<f64>) = path.knots.iter().rev().copied().unzip();
    let at = |place: f64| {
        let i = z.partition_point(|k| *k < place);
        x[i - 1] + (x[i] - x[i - 1]) * (place - z[i - 1]) / (z[i] - z[i - 1])
    };
    let alpha = (1.5_f64 / 30.0).atan();
    let below = 2.0 * 0.8 * (alpha.sin() + alpha.cos() - 1.0) / alpha.cos();
    // Half of the mean of both aims, which the taper joins.
    let line = 22.0 - 0.1 * (140.0 - 125.0) - 0.5 * (0.0065 + 0.0055);
    assert!((at(140.0) - (line - below)).abs() < 2e-3, "{} {line} {below}", at(140.0));
}

/// A program whose blocks are changed is refused: a shoulder cut into, a taper left too thick.
#[test]
fn the_replay_finds_a_gouge_and_what_is_left() {
    let (plan, settings, piece) = (plan(), settings(), piece());
    let program = program(&plan, &settings, &piece);
    let text = program.write(Dialect::Linuxcnc).unwrap().text;
    let scene = program.working_space(Dialect::Linuxcnc).unwrap();
    replay::check_once(&text, &scene).unwrap();
    // The cut's blocks "X… Z…": the one at the end of the taper is left out, or moved inwards.
    let cuts: Vec<&str> = text.lines().filter(|l| l.starts_with('X') && l.contains(" Z")).collect();
    let of = |line: &str| line.split_once(" Z").unwrap().1.parse::<f64>().unwrap();
    let thin = *cuts.iter().find(|l| of(l) < 130.0).unwrap();
    let x: f64 = thin.split_once(' ').unwrap().0[1..].parse().unwrap();
    let deeper = text.replacen(thin, &thin.replacen(&format!("X{x}"), &format!("X{:.4}", x - 0.2), 1), 1);
    assert_ne!(deeper, text);
    let refused = replay::check_once(&deeper, &scene).unwrap_err().to_string();
    assert!(refused.contains("into the commanded surface"), "{refused}");
    let thicker = text.replacen(thin, &thin.replacen(&format!("X{x}"), &format!("X{:.4}", x + 0.2), 1), 1);
    let refused = replay::check_once(&thicker, &scene).unwrap_err().to_string();
    assert!(refused.contains("leaves"), "{refused}");
    // A rapid down to the thin end before the thick one has passed.
    let rapid = text.replacen("G01 X", "G00 X", 1);
    let refused = replay::check_once(&rapid, &scene).unwrap_err().to_string();
    assert!(refused.contains("in rapid"), "{refused}");
}

#[test]
fn a_nose_that_is_not_stated_or_does_not_fit_is_refused() {
    let plan = plan();
    let said = |nose: Option<f64>| {
        let settings = NcSettings { nose_radius_mm: nose, ..settings() };
        Path::new(&plan, &settings, Dialect::Fanuc).unwrap_err().to_string()
    };
    assert!(said(None).contains("nc.nose_radius_mm"), "{}", said(None));
    assert!(said(Some(1.6)).contains("does not fit"), "{}", said(Some(1.6)));
}
