//! The study of the paper's four workpieces against closed forms of the true nose.

use std::sync::OnceLock;

use crate::config;
use crate::render::insert::{InsertSettings, Wear};
use crate::render::{BackendChoice, Renderer};
use crate::studies::worn_tool::{Jobs, Noses, Settings, Study, Tried, Workpiece, curves, run};

/// Depth of the wear in its middle, µm.
const DEPTH_UM: f64 = 40.0;

fn studied_of(workpieces: &[Workpiece]) -> (Study, Noses) {
    let mut insert = InsertSettings::default();
    (insert.camera.columns, insert.camera.rows) = (700, 600);
    insert.nose.centre_px = [300.0, 360.0];
    insert.nose.radius_mm = 0.3;
    insert.wear = vec![Wear::Round { depth_um: DEPTH_UM }];
    // whole degrees, at which the curves have values
    let cone_deg = [24.0, 38.0];
    let settings = Settings { insert, cone_deg, pieces: 1, workpieces: workpieces.to_vec(), seed: 5 };
    let text = include_str!("../../../src/cli/study/tool_workpiece.toml");
    let batch = config::parse(text, "tool_workpiece.toml").unwrap();
    let text = include_str!("../../../src/cli/study/tool_profiles.toml");
    let mut profiles = config::parse(text, "tool_profiles.toml").unwrap();
    profiles.scan.angles = 2;
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    run(&settings, &Jobs { profiles, batch }, &renderer, &|| ()).unwrap()
}

/// The whole study, once for all tests.
fn studied() -> &'static (Study, Noses) {
    static STUDIED: OnceLock<(Study, Noses)> = OnceLock::new();
    STUDIED.get_or_init(|| studied_of(&Workpiece::ALL))
}

/// Support of the true nose about its centre by trying every direction of its contour, mm.
fn support_mm(a_deg: f64) -> f64 {
    let of = |k: u32| {
        let turn = f64::from(k) * 1e-3;
        let worn = (std::f64::consts::FRAC_PI_2 * (turn / 60.0 - 1.0)).cos().powi(2);
        (0.3 - 1e-3 * DEPTH_UM * worn) * (a_deg + 27.0 - turn).to_radians().cos()
    };
    (0..=120_000).map(of).fold(0.0, f64::max)
}

#[test]
fn what_is_left_before_follows_from_the_true_nose_and_the_measured_path_mends_it() {
    let (study, noses) = studied();
    let e = curves(noses).real;
    let left = |deg: f64| e[deg as usize].1;
    // the curve itself: set by touching, R0 in the register
    for deg in [10.0_f64, 24.0, 38.0, 45.0, 80.0] {
        let (s, c) = deg.to_radians().sin_cos();
        let wanted = 0.3 * (1.0 - c - s) + support_mm(0.0) * c + support_mm(90.0) * s - support_mm(deg);
        assert!((left(deg) - 1e3 * wanted).abs() < 0.02, "{deg}: {} {}", left(deg), 1e3 * wanted);
    }
    let row = |workpiece: Workpiece, program: Tried| {
        let found =
            study.rows.iter().find(|r| r.workpiece == workpiece.number() && r.program == program).unwrap();
        assert_eq!(found.refused, None, "{found:?}");
        found.clone()
    };
    let before = |workpiece| row(workpiece, Tried::RegisterR0);
    let (one, two) = (24f64.to_radians(), 38f64.to_radians());
    let length = before(Workpiece::LengthBehindCone).error_um.unwrap();
    assert!((length - left(24.0) / one.sin()).abs() < 0.5, "{length} {}", left(24.0) / one.sin());
    let large = before(Workpiece::LargeDiameter).error_um.unwrap();
    assert!((large - 2.0 * left(38.0) / two.cos()).abs() < 0.5, "{large}");
    let batch = before(Workpiece::BatchDiameter);
    let wanted = 2e3 * (0.3 - support_mm(0.0));
    let allowed = 0.5 + 2.0 * batch.u_um.unwrap();
    assert!((batch.error_um.unwrap() - wanted).abs() < allowed, "{batch:?} {wanted}");
    // through frames as on the surface itself: within three standard uncertainties, and .1 µm of
    // the ridges that the feed and the texture leave
    for found in &study.rows {
        assert_eq!((found.measured_by, &found.refused), ("frames", &None), "{found:?}");
        let (error, surface) = (found.error_um.unwrap(), found.true_error_um.unwrap());
        println!(
            "{} {:?}: {error:.3} µm (u {:.3}), surface {surface:.3} µm",
            found.workpiece,
            found.program,
            found.u_um.unwrap()
        );
        assert!((error - surface).abs() < 0.1 + 3.0 * found.u_um.unwrap(), "{found:?}");
    }
    for workpiece in Workpiece::ALL {
        let mended = row(workpiece, Tried::Path);
        println!("{}: {:?} µm, {:?} %", workpiece.number(), mended.error_um, mended.reduction_percent);
        // the design's 98 %, for errors that are a hundred times the measurement's own .1 µm
        let size = before(workpiece).error_um.unwrap().abs();
        assert!(mended.error_um.unwrap().abs() < 0.6_f64.max(0.02 * size), "{mended:?} {size}");
        assert!(mended.scattered_um.unwrap() > mended.error_um.unwrap().abs() * 0.5, "{mended:?}");
    }
}

#[test]
fn slides_scatter_by_a_quarter_of_the_repeatability_and_the_paper_stands_beside() {
    let (study, _) = studied();
    assert_eq!(study.slides_um, [1.0, 1.25]);
    let reductions = study.paper.map(|p| p.reduction_percent);
    assert_eq!(reductions, [75.8, 79.2, 37.5, 69.6]);
    assert!((study.paper[3].before_um - 17.25).abs() < 1e-9);
    assert_eq!(study.rows.len(), 24);
    // the same seed gives the same scatter
    let again = studied_of(&[Workpiece::ArcRadius]).0;
    assert_eq!(study.rows[12..18], again.rows);
}
