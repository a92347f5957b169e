//! A part cut by a worn nose: the shaft against closed forms, the gauge's diameters from frames
//! against them, and the same part by the program that follows the nose.

use std::path::Path;

use super::parts::papers_support;
use crate::cell::{SimulatedCell, drawn_scene, scan_request};
use crate::closed_loop::{ClosedLoop, PassResult};
use crate::config;
use crate::job::Job;
use crate::plan::ScanPlan;
use crate::render::{BackendChoice, Renderer, geometric_edges};
use crate::tool::Way;

/// Half angle of the cone: .25 mm of radius a millimetre.
fn cone_rad() -> f64 {
    0.25_f64.atan()
}

fn job(way: Way) -> Job {
    let mut job = config::load(Path::new("configs/worn_nose.toml")).unwrap();
    job.tool.as_mut().unwrap().way = way;
    // so stiff that nothing bends: what is left is the nose's
    job.process.material.youngs_modulus_n_per_mm2 = Some(1e9);
    job
}

/// e(a) of the example: R and both extents are those of the new nose, so that what is left is what
/// the nose has lost.
fn left_mm(a_rad: f64) -> f64 {
    0.4 - papers_support(a_rad)
}

fn last_pass(job: &Job) -> PassResult {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let cell = SimulatedCell::new(job, &renderer).unwrap();
    let mut turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
    turning.run_pass(&mut |_, _| {}).unwrap();
    turning.run_pass(&mut |_, _| {}).unwrap()
}

#[test]
fn the_contour_is_what_the_closed_forms_say() {
    let (drawn, worn) = job(Way::Register).contours().unwrap();
    let (drawn, worn) = (drawn.unwrap(), worn.unwrap());
    let more = |z: f64| {
        worn.relative_mm(z, crate::plan::Side::Chuck) - drawn.relative_mm(z, crate::plan::Side::Chuck)
    };
    let cone = 2.0 * left_mm(cone_rad()) / cone_rad().cos();
    for (z, wanted) in [(10.0, 2.0 * left_mm(0.0)), (23.0, cone), (30.0, 2.0 * left_mm(0.0)), (50.0, 0.027)] {
        assert!((more(z) - wanted).abs() < 6e-5, "z {z}: {} instead of {wanted}", more(z));
    }
    let (drawn, mended) = job(Way::Path).contours().unwrap();
    let (drawn, mended) = (drawn.unwrap(), mended.unwrap());
    for z in [10.0, 23.0, 30.0, 39.4, 50.0] {
        let of = |c: &crate::plan::Contour| c.relative_mm(z, crate::plan::Side::Chuck);
        // the drawn arc is in chords of .1 µm, twice that on the diameter
        assert!((of(&mended) - of(&drawn)).abs() < 3e-4, "z {z}: {}", of(&mended) - of(&drawn));
    }
}

/// Mean of the readings between two z less the drawn diameter there, mm.
fn cone_error_mm(pass: &PassResult, (from, to): (f64, f64)) -> f64 {
    let drawn = |z: f64| 12.0 - 2.0 * (z - 20.0) * 0.25;
    let read: Vec<f64> = pass
        .readings
        .iter()
        .filter(|r| (from..=to).contains(&r.z_mm))
        .filter_map(|r| Some(r.reading.value()?.d_mm - drawn(r.z_mm)))
        .collect();
    assert!(read.len() > 20, "{} readings on the cone", read.len());
    read.iter().sum::<f64>() / read.len() as f64
}

#[test]
fn the_gauge_measures_what_the_nose_leaves_and_the_path_mends_it() {
    let (worn, mended) = (last_pass(&job(Way::Register)), last_pass(&job(Way::Path)));
    let mut seen = 0;
    let nominal: Vec<f64> = worn.plan.station_nominal_mm().collect();
    for ((a, b), nominal) in worn.profile.stations.iter().zip(&mended.profile.stations).zip(nominal) {
        let (Some(a), Some(b)) = (a.reading.value(), b.reading.value()) else { continue };
        let allowed = |u_mm: f64| 5e-4 + 2.0 * u_mm;
        let wanted = nominal + 2.0 * left_mm(0.0);
        assert!(
            (a.d_mm - wanted).abs() < allowed(a.u_mm()),
            "{} instead of {wanted}, u {}",
            a.d_mm,
            a.u_mm()
        );
        assert!(
            (b.d_mm - nominal).abs() < allowed(b.u_mm()),
            "{} instead of {nominal}, u {}",
            b.d_mm,
            b.u_mm()
        );
        seen += 1;
    }
    assert!(seen >= 20, "{seen} stations");
    let clear = worn.plan.form.contour().unwrap().tapers[0].clear_mm;
    let cone = 2.0 * left_mm(cone_rad()) / cone_rad().cos();
    let (before, after) = (cone_error_mm(&worn, clear), cone_error_mm(&mended, clear));
    println!("cone: {:.2} µm before, {:.2} after; {:.2} by e", 1e3 * before, 1e3 * after, 1e3 * cone);
    // what the gauge itself errs on a cone is common to both
    assert!((before - after - cone).abs() < 1e-3, "{before} {after} {cone}");
}

/// What is said of the example with a change of the config and one of its tool's file.
fn refused(config: (&str, &str), tool: (&str, &str)) -> String {
    let changed = |file: &str, (from, to): (&str, &str)| {
        let text = std::fs::read_to_string(file).unwrap();
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    let here = tempfile::tempdir().unwrap();
    std::fs::create_dir(here.path().join("tool")).unwrap();
    std::fs::copy("configs/tool/nose.json", here.path().join("tool/nose.json")).unwrap();
    let text = changed("configs/tool/tool_set_new.toml", tool);
    std::fs::write(here.path().join("tool/tool_set_new.toml"), text).unwrap();
    let path = here.path().join("run.toml");
    std::fs::write(&path, changed("configs/worn_nose.toml", config)).unwrap();
    config::load(&path).unwrap_err().to_string()
}

#[test]
fn a_tool_that_contradicts_or_does_not_reach_is_refused() {
    let same = ("", "");
    let own = ("[process.support]", "[process.tool]\nnose_radius_mm = 0.8\n\n[process.support]");
    let said = refused(own, same);
    assert!(said.contains("process.tool.nose_radius_mm") && said.contains("tool.file"), "{said}");
    let said = refused(("tool/nose.json", "tool/none.json"), same);
    assert!(said.contains("tool.nose") && said.contains("none.json"), "{said}");
    let said = refused(("file = \"tool/tool_set_new.toml\"", ""), same);
    assert!(said.contains("tool.file"), "{said}");
    let said = refused(same, ("epsilon_r_deg = 60.0", "epsilon_r_deg = 100.0"));
    assert!(said.contains("tool.file") && said.contains("epsilon_r_deg"), "{said}");
    // a cone that falls along the feed by more than the trailing edge is free of
    let falls = (
        "{ z_mm = 60.0, diameter_mm = 6.0 }",
        "{ z_mm = 50.0, diameter_mm = 6.0 },\n{ z_mm = 51.0, diameter_mm = 7.0 },\n{ z_mm = 60.0, diameter_mm = 7.0 }",
    );
    let said = refused(falls, ("tip_direction = 3", "tip_direction = 3\nclearance_deg = 5.0"));
    assert!(said.contains("-26.565°") && said.contains("edges") && said.contains("-22.000°"), "{said}");
    let said = refused(same, ("tip_direction = 3", "tip_direction = 4\nfeed = \"towards_tailstock\""));
    assert!(said.contains("feed_direction"), "{said}");
}

#[test]
fn a_run_is_cut_like_the_pass_that_was_measured() {
    // the example states its pass: the last one of 12.4 to 12.0 mm, 180 m/min, .08 mm
    let depth = "depth_mm = 0.2";
    let said = refused(("", ""), (depth, "depth_mm = 0.3"));
    assert!(
        said.contains("part.nominal_diameter_mm") && said.contains("0.2000 mm") && said.contains("0.3 mm"),
        "{said}"
    );
    let said = refused(("speed_m_per_min = 180.0", "speed_m_per_min = 150.0"), ("", ""));
    assert!(said.contains("cutting.speed_m_per_min: 150") && said.contains("180 m/min"), "{said}");
    let said = refused(("feed_mm_per_rev = 0.08", "feed_mm_per_rev = 0.12"), ("", ""));
    assert!(said.contains("cutting.feed_mm_per_rev: 0.12") && said.contains("0.08 mm"), "{said}");
    let mut open = job(Way::Path);
    assert!(!open.cautions().iter().any(|c| c.contains("measured_pass")), "{:?}", open.cautions());
    if let Some(tool) = open.tool.as_mut().and_then(|t| t.stated.as_mut()) {
        tool.measured_pass = None;
    }
    assert!(open.cautions().iter().any(|c| c.contains("measured_pass")));
}

/// The picture of a config shows what its run would leave.
#[test]
fn a_drawn_scene_shows_what_the_nose_leaves() {
    let diameters_px = |way: Option<Way>| {
        let mut job = job(way.unwrap_or_default());
        job.tool = job.tool.filter(|_| way.is_some());
        // the middle of the first cylinder
        let plan = ScanPlan { field_z_mm: vec![10.0], angle_deg: vec![0.0] };
        let request = scan_request(&job, &plan, 0);
        let edges = geometric_edges(&drawn_scene(&job).unwrap(), &request).unwrap();
        let middle = edges[edges.len() / 2];
        middle.bottom_px - middle.top_px
    };
    let mm_per_px = job(Way::Register).setup_settings().nominal_pixel_mm();
    let (drawn, worn, mended) =
        (diameters_px(None), diameters_px(Some(Way::Register)), diameters_px(Some(Way::Path)));
    let more = |px: f64| mm_per_px * (px - drawn);
    assert!((more(worn) - 2.0 * left_mm(0.0)).abs() < 5e-4, "{}", more(worn));
    assert!(more(mended).abs() < 5e-4, "{}", more(mended));
    let profile = job(Way::Register).worn_profile().unwrap().unwrap();
    let last = job(Way::Register).part.drawn_diameter_mm();
    let (_, contour) = job(Way::Register).contours().unwrap();
    for (knot, of) in profile.iter().zip(contour.unwrap().knots) {
        assert!((2.0 * knot.radius_mm - last - of.relative_mm).abs() < 1e-12);
    }
}

/// The resolved config of a run folder holds tool and nose itself and gives the same contour.
#[test]
fn the_resolved_config_needs_no_other_file() {
    let job = job(Way::Register);
    let text = config::resolved(&job).unwrap();
    let again = config::parse(&text, "resolved.toml").unwrap();
    assert_eq!(again.contours().unwrap(), job.contours().unwrap());
    assert_eq!(again.process.tool.lead_angle_deg, 90.0);
    assert_eq!(again.process.tool.minor_angle_deg, 27.0);
}
