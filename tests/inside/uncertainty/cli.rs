//! `calibrate`, and `measure` with a calibration, from outside the binary.

use std::path::Path;
use std::process::Output;

use serde_json::Value;
use shadowgauge::frame::{Frame, PixelFormat, Pixels};
use shadowgauge::render::{BackendChoice, OpticalSetup, Renderer};
use shadowgauge::shaft::{Lobe, Shaft};
use shadowgauge::studies::calibration::{CalibrationPlan, Laid, SimulatedSetup};

use crate::inside::uncertainty::program::shadowgauge;

/// A small optical setup without distortion (its truth is drawn apart from [`true_setup`]); every
/// test changes the keys it needs.
pub const PLAN: &str = r#"
optics_id = "small bench"
date = "2026-11-22"
valid_days = 365
[thermometer]
temperature_c = 21.0
limit_temperature_k = 0.2
[lens]
distortion_percent = 0.0
keystone_percent = 0.0
[conditions]
limit_temperature_k = 0.5
limit_axis_y_mm = 0.3
[[masters]]
name = "small"
diameter_mm = 4.0
expanded_u_mm = 0.0004
positions = [{ height_mm = -0.3 }, { height_mm = 0.3, y_mm = 2.0 }]
[[masters]]
name = "large"
diameter_mm = 6.6
expanded_u_mm = 0.0004
positions = [{ height_mm = -0.2, y_mm = 2.0 }, { height_mm = 0.2 }]
[check]
name = "check"
diameter_mm = 5.2
expanded_u_mm = 0.001
positions = [{ height_mm = 0.1 }]
[simulate]
seed = 8
frames_each = 1
[simulate.camera]
rows = 512
columns = 320
"#;

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).split_whitespace().collect::<Vec<_>>().join(" ")
}

pub fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_string_lossy().into_owned()
}

pub fn calibrate(folder: &Path, plan: &str) -> Output {
    let config = path(folder, "plan.toml");
    std::fs::write(&config, plan).unwrap();
    shadowgauge([
        "calibrate",
        &config,
        "--out",
        &path(folder, "calibration.json"),
        "--backend",
        "cpu",
        "--json",
    ])
}

pub fn save(frame: &Frame, to: &Path) {
    std::fs::create_dir_all(to.parent().unwrap()).unwrap();
    let view = frame.view();
    let Pixels::U16(pixels) = view.pixels() else { panic!("12-bit frames") };
    assert_eq!(view.format(), PixelFormat::Mono12);
    let (rows, columns) = (view.rows() as u32, view.columns() as u32);
    image::ImageBuffer::<image::Luma<u16>, _>::from_raw(columns, rows, pixels.to_vec())
        .unwrap()
        .save(to)
        .unwrap();
}

/// The true optical setup of [`PLAN`], and its renderer.
pub fn true_setup(plan: &str) -> OpticalSetup {
    let plan: CalibrationPlan = toml::from_str(plan).unwrap();
    let simulate = plan.simulate.unwrap();
    OpticalSetup::resolve(&simulate.setup(), simulate.seed).unwrap()
}

pub fn laid(diameter_mm: f64, angle_deg: f64, lobes: Vec<Lobe>) -> Laid {
    Laid {
        shaft: Shaft { lobes, ..Shaft::cylinder(diameter_mm) },
        temperature_c: 20.0,
        expansion_per_k: 11.5e-6,
        height_mm: 0.05,
        y_mm: 0.0,
        tilt_mrad: 0.0,
        angle_deg,
    }
}

/// Frames of a part of 5.0 mm in the calibrated optical setup.
fn part(folder: &Path, frames: usize) -> String {
    part_before(folder, frames, PLAN)
}

/// The same in the optical setup of another plan.
fn part_before(folder: &Path, frames: usize, plan: &str) -> String {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut setup = SimulatedSetup::new(&renderer, true_setup(plan), 0.0, 3);
    for i in 0..frames {
        save(&setup.frame(&laid(5.0, 0.0, Vec::new())).unwrap(), &folder.join(format!("part/{i:03}.png")));
    }
    path(folder, "part")
}

pub fn json(output: &Output) -> Value {
    assert!(output.status.code().is_some_and(|c| c < 2), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// An image, transposed.
fn upright(folder: &Path, image: &str) -> String {
    let level = image::open(image).unwrap().into_luma16();
    let turned = image::ImageBuffer::from_fn(level.height(), level.width(), |x, y| *level.get_pixel(y, x));
    let to = path(folder, "upright.png");
    turned.save(&to).unwrap();
    to
}

#[test]
fn a_calibration_holds_for_its_edge_model_and_for_upright_frames() {
    let folder = tempfile::tempdir().unwrap();
    // A square sensor: turned pictures are of its size.
    let plan = PLAN.replace("columns = 320", "columns = 512");
    assert_eq!(calibrate(folder.path(), &plan).status.code(), Some(0));
    let calibration = path(folder.path(), "calibration.json");
    part_before(folder.path(), 1, &plan);
    let level = path(folder.path(), "part/000.png");
    let upright = upright(folder.path(), &level);
    let measure = |image: &str, more: &[&str]| {
        let fixed = ["measure", image, "--calibration", &calibration, "--as-of", "2026-12-01", "--json"];
        shadowgauge([&fixed[..], more].concat())
    };
    // The offset is valid for the Gaussian that was fitted to the masters.
    let learnt = measure(&level, &["--esf", "learnt"]);
    assert_eq!(learnt.status.code(), Some(2));
    assert!(text(&learnt.stderr).contains("edge-spread function gaussian"), "{}", text(&learnt.stderr));
    // A perfect lens is the same in both orientations, except for the effect of noise on the
    // adjusted keystones.
    let (lying, standing) = (json(&measure(&level, &[])), json(&measure(&upright, &["--vertical"])));
    for key in ["max_diameter_mm", "mean_diameter_mm", "u_max_mm"] {
        let [a, b] = [&lying, &standing].map(|all| all["frames"][0][key].as_f64().unwrap());
        assert!((a - b).abs() < 2e-5, "{key}: {a} {b}");
    }
    // Rows that no window read lie between the edges.
    let wide = |more: &[&str]| {
        let all = json(&shadowgauge([&["measure", &level, "--um-per-px", "15.27", "--json"], more].concat()));
        all["frames"][0]["max_diameter_px"].as_f64().unwrap()
    };
    assert!((wide(&["--rows-between", "1000"]) - wide(&[]) - 1000.0).abs() < 1e-3);
}

#[test]
fn a_calibration_is_made_and_used() {
    let folder = tempfile::tempdir().unwrap();
    let made = calibrate(folder.path(), PLAN);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let said = json(&made);
    assert!(said["check"]["e_n"].as_f64().unwrap() <= 1.0 && said["accepted"] == true);
    let html = std::fs::read_to_string(folder.path().join("calibration.html")).unwrap();
    assert!(html.matches("<svg").count() >= 3 && html.contains("Check pin"));
    let calibration = path(folder.path(), "calibration.json");
    let input = part(folder.path(), 4);
    let as_of = ["--as-of", "2026-12-01"];
    let measure = |more: &[&str]| {
        shadowgauge(
            [&["measure", &input, "--calibration", &calibration, "--json"], &as_of[..], more].concat(),
        )
    };
    let all = json(&measure(&["--budget", "--coverage-factor", "3"]));
    let frame = &all["frames"][0];
    let number = |v: &Value| v.as_f64().unwrap();
    let error_um = 1e3 * (number(&frame["max_diameter_mm"]) - 5.0);
    println!("error {error_um} um, u {} mm", frame["u_max_mm"]);
    assert!(error_um.abs() < 3e3 * number(&frame["u_max_mm"]) + 0.05, "{frame}");
    let rows = frame["budget"].as_array().unwrap();
    let sum: f64 = rows.iter().map(|r| number(&r["u_mm"]).powi(2)).sum();
    assert!((sum.sqrt() / number(&frame["u_max_mm"]) - 1.0).abs() < 1e-9 && rows.len() > 5);
    assert!((number(&frame["expanded_u_max_mm"]) / number(&frame["u_max_mm"]) - 3.0).abs() < 1e-9);
    // A stream estimates the blur in every frame anew: its error averages.
    for (source, share) in [
        ("noise of the edges", "random"),
        ("quantisation", "random"),
        ("levels of light and shadow", "random"),
        ("blur", "random"),
    ] {
        let row =
            rows.iter().find(|r| r["source"] == source).unwrap_or_else(|| panic!("{source} in {rows:?}"));
        assert!(number(&row["u_mm"]) > 0.0 && row["share"] == share);
    }
    let random = number(&frame["u_random_mm"]).hypot(number(&frame["u_common_mm"]));
    assert!((random / number(&frame["u_max_mm"]) - 1.0).abs() < 1e-9);
    // One value has no scatter.
    let first = path(folder.path(), "part/000.png");
    let single = json(&shadowgauge(["measure", &first, "--um-per-px", "15.27", "--json", "--budget"]));
    assert!(single["statistics"]["sd_mm"].is_null() && number(&single["statistics"]["u_mean_mm"]) > 0.0);
    let stated = single["frames"][0]["budget"].as_array().unwrap();
    assert!(stated.iter().any(|row| row["input"] == "not stated" && row["u_mm"] == 0.0), "{stated:?}");
    conditions_are_taken(folder.path(), frame, &measure);
    tolerances_are_judged(&input, &measure);
}

/// A file with one condition leaves the others, and with them u, as in the calibration.
fn conditions_are_taken(folder: &Path, frame: &Value, measure: &dyn Fn(&[&str]) -> Output) {
    let number = |v: &Value| v.as_f64().unwrap();
    let one = path(folder, "one.toml");
    std::fs::write(&one, "temperature_c = 20.0\n").unwrap();
    let same = json(&measure(&["--conditions", &one]));
    assert_eq!(same["frames"][0]["u_max_mm"], frame["u_max_mm"]);
    assert_eq!(
        (&same["conditions"]["limit_axis_y_mm"], &same["conditions"]["temperature_c"]),
        (&0.3.into(), &20.0.into())
    );
    std::fs::write(&one, "limit_axis_y_mm = 3.0\n").unwrap();
    let far = json(&measure(&["--conditions", &one]));
    assert!(number(&far["frames"][0]["u_max_mm"]) > number(&frame["u_max_mm"]));
    // Ten kelvin warmer: 11.5 ppm per kelvin smaller at 20 °C.
    let warm = json(&measure(&["--part-temperature", "30"]));
    let ratio = number(&warm["frames"][0]["max_diameter_mm"]) / number(&frame["max_diameter_mm"]);
    assert!((ratio - 1.0 / (1.0 + 1.15e-4)).abs() < 1e-9, "{ratio}");
}

/// Judgement, averages, statistics.
fn tolerances_are_judged(input: &str, measure: &dyn Fn(&[&str]) -> Output) {
    let good = measure(&["--tolerance", "4.99..5.01", "--average", "moving:2"]);
    assert_eq!(good.status.code(), Some(0));
    let good = json(&good);
    assert_eq!(good["frames"][3]["judgement"], "GO");
    assert!(good["frames"][3]["average_mm"].is_number() && good["statistics"]["count"] == 4);
    // Frames of one part have no process capability.
    assert!(good["statistics"]["cp"].is_null() && good["statistics"]["cpk"].is_null(), "{good}");
    assert!(good["statistics"]["capability_none"].as_str().unwrap().contains("--parts"), "{good}");
    let none = measure(&["--tolerance", "4.9999..5.0001"]);
    assert_eq!(none.status.code(), Some(1));
    assert!(text(&none.stderr).contains("leaves no acceptance zone"), "{}", text(&none.stderr));
    let human = shadowgauge(["measure", input, "--um-per-px", "15.27", "--tolerance", "4.9..5.1"]);
    let (said, warned) = (text(&human.stdout), text(&human.stderr));
    assert!(said.contains("mean diameters of 4 frames: mean ") && !said.contains('{'), "{said}");
    assert!(warned.contains("scale and edge offset are not calibrated"), "{warned}");
    let bad = measure(&["--tolerance", "5 h6", "--station-mm", "1"]);
    // 5 h6 ends at 5.000 mm: the part is at the limit, which is not proven good.
    assert_eq!(bad.status.code(), Some(1));
    assert!(json(&bad)["frames"][0]["stations"].as_array().unwrap().len() >= 4);
}

#[test]
fn what_does_not_belong_to_a_calibration_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(calibrate(folder.path(), PLAN).status.code(), Some(0));
    let calibration = path(folder.path(), "calibration.json");
    let input = part(folder.path(), 1);
    let odd = folder.path().join("odd/a.png");
    std::fs::create_dir_all(odd.parent().unwrap()).unwrap();
    image::GrayImage::from_fn(200, 200, |_, y| image::Luma([if (60..140).contains(&y) { 10 } else { 200 }]))
        .save(&odd)
        .unwrap();
    let odd = odd.to_string_lossy().into_owned();
    let run = |input: &str, more: &[&str]| {
        shadowgauge([&["measure", input, "--calibration", &calibration], more].concat())
    };
    for (input, more, exit, word) in [
        (&input, &["--as-of", "2026-12-01", "--optics-id", "other lens"][..], 3, "optics"),
        (&input, &["--as-of", "2028-01-01"][..], 3, "expired on 2027-11-22"),
        (&input, &["--as-of", "2020-01-01"][..], 3, "dated"),
        (&odd, &["--as-of", "2026-12-01"][..], 3, "512 rows"),
        (&input, &["--as-of", "2026-12-01", "--tolerance", "5 k99"][..], 2, "tolerance"),
        (&input, &["--as-of", "yesterday"][..], 2, "YYYY-MM-DD"),
        (&input, &["--as-of", "2026-12-01", "--average", "moving:0"][..], 2, "readings"),
        (
            &input,
            &["--as-of", "2026-12-01", "--average", "moving:2", "--station-mm", "1"][..],
            2,
            "one of them at a time",
        ),
        (&input, &["--as-of", "2026-12-01", "--part-temperature", "9999"][..], 2, "conditions.temperature_c"),
    ] {
        let output = run(input, more);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(exit), "{more:?}: {said}");
        assert!(said.contains(word) && !said.contains("panicked"), "{more:?}: {said}");
        assert!(output.stdout.is_empty(), "{more:?}");
    }
    let consent = run(&input, &["--as-of", "2028-01-01", "--accept-expired", "--optics-id", "small bench"]);
    assert_eq!(consent.status.code(), Some(0), "{}", text(&consent.stderr));
    assert!(text(&consent.stderr).contains("used with consent"));
    let without = shadowgauge(["measure", &input, "--budget"]);
    assert_eq!(without.status.code(), Some(2));
    assert!(text(&without.stderr).contains("--budget needs millimetres"));
}

#[test]
fn a_wrong_plan_is_named() {
    for (from, to, word) in [
        ("optics_id = \"small bench\"", "optics_id = \" \"", "optics_id"),
        ("date = \"2026-11-22\"", "date = \"22.11.2026\"", "is no date"),
        ("valid_days = 365", "valid_months = 12", "valid_months"),
        ("limit_temperature_k = 0.2", "limit_temperature_k = -1.0", "thermometer.limit_temperature_k"),
        ("diameter_mm = 4.0", "diameter_mm = -4.0", "masters[0].diameter_mm"),
        ("diameter_mm = 6.6", "diameter_mm = 4.0", "must differ by 1 %"),
        ("diameter_mm = 6.6", "diameter_mm = 9.0", "masters[1].diameter_mm"),
        (
            "[simulate]\nseed = 8\nframes_each = 1\n[simulate.camera]\nrows = 512\ncolumns = 320\n",
            "",
            "frames",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let plan = PLAN.replacen(from, to, 1);
        assert_ne!(plan, PLAN);
        let output = calibrate(folder.path(), &plan);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{to}: {said}");
        assert!(said.contains(word), "{to}: {said}");
        assert!(!folder.path().join("calibration.json").exists());
    }
    let folder = tempfile::tempdir().unwrap();
    let missing = shadowgauge(["calibrate", "nowhere.toml", "--out", &path(folder.path(), "x.json")]);
    assert_eq!(missing.status.code(), Some(2));
    // The report goes beside the calibration as .html and must not be overwritten by it.
    let config = path(folder.path(), "plan.toml");
    std::fs::write(&config, PLAN).unwrap();
    let page = shadowgauge(["calibrate", &config, "--out", &path(folder.path(), "x.html")]);
    assert_eq!(page.status.code(), Some(2));
    assert!(text(&page.stderr).contains("must end in .json"), "{}", text(&page.stderr));
    let scenes = shadowgauge(["study", "coverage", "--scenes", "0"]);
    assert_eq!(scenes.status.code(), Some(2), "{}", text(&scenes.stderr));
}

/// Without a check pin nothing is accepted, and stdout states it.
#[test]
fn a_calibration_without_a_check_pin_is_not_called_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let (check, simulate) = (PLAN.find("[check]").unwrap(), PLAN.find("[simulate]").unwrap());
    let plan = format!("{}{}", &PLAN[..check], &PLAN[simulate..]);
    let made = calibrate(folder.path(), &plan);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    assert!(json(&made)["accepted"].is_null());
    let config = path(folder.path(), "plan.toml");
    let out = path(folder.path(), "calibration.json");
    let human = text(&shadowgauge(["calibrate", &config, "--out", &out, "--backend", "cpu"]).stdout);
    assert!(human.contains("no check pin") && !human.contains("middle master"), "{human}");
}

/// The same pins as files: recorded frames give a calibration, and a check pin with a wrong
/// certificate is refused.
#[test]
fn recorded_frames_calibrate_and_a_wrong_check_pin_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let setup = true_setup(PLAN);
    let pixel_mm = setup.pixel_mm;
    let mut setup = SimulatedSetup::new(&renderer, setup, 0.0, 3);
    for (name, diameter_mm) in [("small", 4.0), ("large", 6.6), ("check", 5.2)] {
        for i in 0..2 {
            let frame = setup.frame(&laid(diameter_mm, 0.0, Vec::new())).unwrap();
            save(&frame, &folder.path().join(format!("{name}/{i}.png")));
        }
    }
    let simulate = PLAN.find("[simulate]").unwrap();
    let plan = PLAN[..simulate]
        .replace("temperature_c = 21.0", "temperature_c = 20.0")
        .replace(
            "positions = [{ height_mm = -0.3 }, { height_mm = 0.3, y_mm = 2.0 }]",
            "positions = [{ frames = \"small\" }]",
        )
        .replace(
            "positions = [{ height_mm = -0.2, y_mm = 2.0 }, { height_mm = 0.2 }]",
            "positions = [{ frames = \"large\" }]",
        )
        .replace("positions = [{ height_mm = 0.1 }]", "positions = [{ frames = \"check\" }]");
    let made = calibrate(folder.path(), &plan);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let scale = json(&made)["scale_mm_per_px"].as_f64().unwrap();
    // Two frames of each pin: levels common to a frame cause errors of some thousandths of a pixel
    // over 170.
    assert!((scale / pixel_mm - 1.0).abs() < 5e-5, "{scale} {pixel_mm}");
    std::fs::remove_file(folder.path().join("calibration.json")).unwrap();
    let wrong = calibrate(folder.path(), &plan.replace("diameter_mm = 5.2", "diameter_mm = 5.205"));
    assert_eq!(wrong.status.code(), Some(1), "{}", text(&wrong.stderr));
    assert!(!folder.path().join("calibration.json").exists());
    assert!(std::fs::read_to_string(folder.path().join("calibration.html")).unwrap().contains("REFUSED"));
}

#[test]
fn a_turn_shows_sizes_and_lobes_of_the_silhouette() {
    let folder = tempfile::tempdir().unwrap();
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut setup = SimulatedSetup::new(&renderer, true_setup(PLAN), 0.0, 3);
    let lobe = |order_upr, amplitude_mm| Lobe { order_upr, amplitude_mm, phase_deg: 20.0 };
    let mut table = "frame,t_ns,z_mm,angle_deg,exposure_us,bit_depth,um_per_px\n".to_owned();
    for i in 0..16 {
        let angle = 22.5 * f64::from(i);
        let frame = setup.frame(&laid(5.0, angle, vec![lobe(2, 0.003), lobe(3, 0.002)])).unwrap();
        save(&frame, &folder.path().join(format!("frames/{i:06}.png")));
        table += &format!("{i:06},0,0.0,{angle},50,12,15.27\n");
    }
    std::fs::write(folder.path().join("frames.csv"), table).unwrap();
    assert_eq!(calibrate(folder.path(), PLAN).status.code(), Some(0));
    let calibration = path(folder.path(), "calibration.json");
    let input = path(folder.path(), "frames");
    let output = shadowgauge([
        "measure",
        &input,
        "--calibration",
        &calibration,
        "--as-of",
        "2026-12-01",
        "--turn",
        "--cutoff-upr",
        "15",
        "--json",
    ]);
    let all = json(&output);
    let section = &all["turn"]["sections"][0];
    let number = |v: &Value| v.as_f64().unwrap();
    assert!((number(&section["gg_mm"]) - 5.0).abs() < 0.002, "{section}");
    assert!(number(&section["gn_mm"]) > number(&section["gg_mm"]));
    let lobes = section["harmonics"]["section"].as_array().unwrap();
    assert!((number(&lobes[1]["amplitude_mm"]) - 0.003).abs() < 5e-5 && lobes[1]["origin"] == "form");
    assert!(
        (number(&lobes[2]["amplitude_mm"]) - 0.002).abs() < 5e-5 && lobes[2]["origin"] == "form_and_spindle"
    );
    for reference in ["lsci", "mzci", "mici", "mcci"] {
        let roundness = number(&section["roundness_mm"][reference]);
        assert!((0.005..0.014).contains(&roundness), "{reference} {roundness}");
    }
    assert!(all["turn"]["of"].as_str().unwrap().contains("silhouette"));
    let [random, common, both] =
        ["u_gg_random_mm", "u_gg_common_mm", "u_gg_mm"].map(|key| number(&section[key]));
    assert!(common > random && (random.hypot(common) / both - 1.0).abs() < 1e-12, "{section}");
    assert!(number(&section["harmonics"]["even_spindle"][0]["amplitude_mm"]) >= 0.0);
    // 16 tangents per revolution resolve up to 8 undulations, not 15.
    assert!(
        all["turn"]["filter"].as_str().unwrap().contains("as far as the angles reach: 16"),
        "{}",
        all["turn"]
    );
    // With half a turn the spindle is assumed free of error motion, which is not determined.
    let half: Vec<String> = (0..8).map(|i| format!("{input}/{i:06}.png")).collect();
    let files = ["measure", "--um-per-px", "15.27", "--turn", "--angle-step", "22.5", "--json"].into_iter();
    let half = json(&shadowgauge(files.chain(half.iter().map(String::as_str)).collect::<Vec<_>>()));
    let section = &half["turn"]["sections"][0];
    assert!(section["half_turn"] == true && section["harmonics"]["even_spindle"].is_null(), "{section}");
    let human = shadowgauge(["measure", &input, "--um-per-px", "15.27", "--turn"]);
    assert!(text(&human.stdout).contains("total run-out"), "{}", text(&human.stderr));
}

#[test]
fn a_ring_seen_end_on_has_its_keys() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "ring.png");
    let cover = |r: f64, edge: f64| 1.0 / (1.0 + (-(r - edge) * 1.7).exp());
    image::GrayImage::from_fn(330, 320, |x, y| {
        let r = (f64::from(x) - 164.3).hypot(f64::from(y) - 158.6);
        image::Luma([(14.0 + 190.0 * (cover(r, 140.0) + 1.0 - cover(r, 60.0))) as u8])
    })
    .save(&file)
    .unwrap();
    let output = shadowgauge(["measure", "--shape", "ring", "--json", "--um-per-px", "20", &file]);
    let ring = json(&output)["frames"][0].clone();
    for key in [
        "outer_diameter_px",
        "inner_diameter_px",
        "u_outer_diameter_px",
        "u_inner_diameter_px",
        "roundness_outer_px",
        "roundness_inner_px",
        "concentricity_px",
        "outer_diameter_mm",
        "inner_diameter_mm",
        "u_outer_diameter_mm",
        "u_inner_diameter_mm",
        "roundness_outer_mm",
        "roundness_inner_mm",
        "concentricity_mm",
    ] {
        assert!(ring[key].is_number(), "{key} in {ring}");
    }
    assert!((ring["outer_diameter_px"].as_f64().unwrap() - 280.0).abs() < 0.1, "{ring}");
    let refused = shadowgauge(["measure", "--shape", "ring", "--budget", "--um-per-px", "20", &file]);
    assert_eq!(refused.status.code(), Some(2));
}
