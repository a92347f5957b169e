//! One optical setup for all commands: `render`, `calibrate`, `optics esf` and `measure` agree.

use std::path::Path;

use serde_json::Value;

use crate::inside::field::support::shadowgauge;

/// A job's optical setup and masters, with an edge-spread function and further keys of the optics.
fn job(esf: &str, more: &str) -> String {
    format!(
        r#"
name = "small bench"
seed = 5
[part]
length_mm = 0.6
stock_diameter_mm = 0.42
nominal_diameter_mm = [0.40]
station_mm = 0.3
[scan]
fields = 1
angles = 1
[masters]
frames_each = 2
pins = [{{ diameter_mm = 0.30, expanded_u_mm = 0.00004 }}, {{ diameter_mm = 0.44, expanded_u_mm = 0.00004 }}]
[camera]
columns = 400
rows = 400
[optics]
magnification = 2.5
{more}
[optics.esf.{esf}
"#
    )
}

const COHERENT: &str =
    "partially_coherent]\nnumerical_aperture = 0.1\ncoherence_ratio = 0.9\nwavelength_nm = 525.0";
const GAUSSIAN: &str = "gaussian]\nsigma_px = 1.3";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_string_lossy().into_owned()
    }

    fn write(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Exit code and stderr of a command.
    fn run(&self, arguments: &[&str]) -> (i32, String, Vec<u8>) {
        let output = shadowgauge(arguments);
        let said = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        (output.status.code().unwrap(), said, output.stdout)
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let (code, said, out) = self.run(arguments);
        assert!(code < 2, "{arguments:?}: {said}");
        serde_json::from_slice(&out).unwrap_or_else(|e| panic!("{arguments:?}: {e}: {said}"))
    }

    fn calibrate(&self, config: &str, out: &str, more: &[&str]) -> Value {
        let out = self.path(out);
        let fixed =
            ["calibrate", config, "--out", &out, "--date", "2026-11-22", "--backend", "cpu", "--json"];
        self.json(&[&fixed[..], more].concat())
    }
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("{v} is no number"))
}

/// Light at a distance from a CSV table, linear between its lines.
fn light(csv: &str, d_um: f64) -> f64 {
    let rows: Vec<(f64, f64)> = csv
        .lines()
        .filter_map(|l| l.split_once(',').and_then(|(d, v)| Some((d.parse().ok()?, v.parse().ok()?))))
        .collect();
    let after = rows.partition_point(|r| r.0 < d_um).clamp(1, rows.len() - 1);
    let ((d0, a), (d1, b)) = (rows[after - 1], rows[after]);
    a + (b - a) * (d_um - d0) / (d1 - d0)
}

fn table(folder: &Folder, config: &str, more: &[&str]) -> String {
    let (code, said, out) = folder.run(&[&["optics", "esf", config], more].concat());
    assert_eq!(code, 0, "{said}");
    String::from_utf8(out).unwrap()
}

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found}, not {wanted} ± {tolerance}");
}

/// Closed forms: Φ(d/σ); ¼, .2573, ⅓, .4334 at the edge in partially coherent light, ¼ in a laser's
/// (Fresnel, half the amplitude).
#[test]
fn tables_of_optics_are_those_of_closed_forms() {
    let folder = Folder::new();
    let config = folder.write("gaussian.toml", &job(GAUSSIAN, ""));
    let csv = table(&folder, &config, &[]);
    assert!(csv.lines().any(|l| l == "distance_um,light") && csv.starts_with('#'), "{}", &csv[..200]);
    let sigma_um = 1.3 * 3.45 / 2.5;
    for d in [-4.0, -1.7, 0.0, 0.6, 3.1] {
        let phi = 0.5 * (1.0 + libm::erf(d / sigma_um / std::f64::consts::SQRT_2));
        close(light(&csv, d), phi, 3e-4, "Gaussian");
    }
    for (ratio, at_edge) in [(0.0, 0.25), (0.5, 0.2573), (1.0, 1.0 / 3.0), (1.5, 0.4334)] {
        let esf = format!(
            "partially_coherent]\nnumerical_aperture = 0.1\ncoherence_ratio = {ratio:.1}\nextra_sigma_um = 1.0"
        );
        let config = folder.write("coherent.toml", &job(&esf, ""));
        let csv = table(&folder, &config, &[]);
        close(light(&csv, 0.0), at_edge, 2e-4, "partially coherent");
        assert!(csv.contains("without extra_sigma_um"), "{}", &csv[..400]);
        assert!((light(&table(&folder, &config, &["--with-blur"]), 0.0) - at_edge).abs() > 0.003);
    }
    let laser = "fresnel]\nwavelength_nm = 650.0\nbandwidth_nm = 0.0\ndistance_mm = 40.0\nsource_half_angle_mrad = 0.0";
    let config = folder.write("laser.toml", &job(laser, ""));
    let csv = table(&folder, &config, &[]);
    close(light(&csv, 0.0), 0.25, 2e-5, "laser");
    // v = 1.2172 is the first maximum, 1.3704 (Born & Wolf 8.7.3); x = v √(λz/2).
    close(light(&csv, 1.2172 * (0.5 * 0.65 * 40e3_f64).sqrt()), 1.3704, 3e-4, "first ring");
    // Closer by y, the pattern shrinks by √(1 − y/z).
    let nearer = table(&folder, &config, &["--axis-y-mm", "10"]);
    close(light(&nearer, 1.2172 * (0.5 * 0.65 * 30e3_f64).sqrt()), 1.3704, 5e-4, "nearer");
}

/// A matt cylinder reflects nothing; a polished one has a bright strip Rθ²/8 wide beside the edge,
/// wider on a thicker one.
#[test]
fn a_thick_polished_cylinder_mirrors_light_beside_its_edge() {
    let folder = Folder::new();
    let surface =
        "polished_share = 1.0, source_half_angle_deg = 4.0, refractive_index = 0.1, extinction = 20.0";
    let more = format!("reflection = {{ {surface} }}");
    let config = folder.write("shiny.toml", &job("gaussian]\nsigma_px = 0.3", &more));
    let theta = 4.0_f64.to_radians();
    for radius_mm in [5.0, 20.0] {
        let csv = table(&folder, &config, &["--radius-mm", &radius_mm.to_string()]);
        let strip_um = 1e3 * radius_mm * theta * theta / 8.0;
        // A good conductor reflects nearly all of it: light inside the strip, none beyond it.
        assert!(light(&csv, -0.5 * strip_um) > 0.9, "{radius_mm}: {}", light(&csv, -0.5 * strip_um));
        assert!(light(&csv, -strip_um - 2.0) < 0.01, "{radius_mm}: {}", light(&csv, -strip_um - 2.0));
    }
}

/// The output of `optics esf` is read by `--esf`, as CSV and as JSON, and is the config's own edge.
#[test]
fn a_printed_table_is_read_back() {
    let folder = Folder::new();
    let config = folder.write("job.toml", &job(COHERENT, ""));
    let csv = folder.write("edge.csv", &table(&folder, &config, &[]));
    let json = folder.write("edge.json", &table(&folder, &config, &["--json"]));
    let printed: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!(printed["distance_um"].as_array().unwrap().len(), printed["light"].as_array().unwrap().len());
    close(number(&printed["um_per_px"]), 1.38, 1e-9, "scale");
    assert!(printed["optics"]["esf"]["partially_coherent"].is_object());
    let out = folder.path("frames");
    assert_eq!(
        folder
            .run(&["render", &config, "--out", &out, "--backend", "cpu", "--no-noise", "--format", "f32"])
            .0,
        0
    );
    let frames = format!("{out}/frames");
    let measured = |esf: &str| {
        let all = folder.json(&["measure", &frames, "--um-per-px", "1.38", "--esf", esf, "--json"]);
        number(&all["frames"][0]["max_diameter_px"])
    };
    let [own, from_csv, from_json, gaussian] = [&config, &csv, &json, "gaussian"].map(measured);
    assert!((from_csv - own).abs() < 1e-4 && (from_json - own).abs() < 1e-4, "{own} {from_csv} {from_json}");
    assert!((gaussian - own).abs() > 0.02, "{gaussian} {own}");
    let (code, said, _) = folder.run(&["optics", "esf", &config, "--radius-mm", "-1"]);
    assert!(code == 2 && said.contains("radius"), "{said}");
}

/// A small calibration of its own file.
fn plan(simulate: &str) -> String {
    format!(
        r#"
optics_id = "small bench"
date = "2026-11-22"
[lens]
distortion_percent = 0.05
keystone_percent = 0.02
[fields]
flats = [{{ exposure = 0.1 }}, {{ exposure = 0.25 }}, {{ exposure = 0.4 }}, {{ exposure = 0.55 }}, {{ exposure = 1.0 }}]
[[masters]]
name = "small"
diameter_mm = 0.30
expanded_u_mm = 0.00004
positions = [{{ height_mm = -0.03 }}, {{ height_mm = 0.03 }}]
[[masters]]
name = "large"
diameter_mm = 0.44
expanded_u_mm = 0.00004
positions = [{{ height_mm = 0.0 }}, {{ height_mm = 0.02 }}]
[check]
name = "check"
diameter_mm = 0.36
expanded_u_mm = 0.00004
positions = [{{ height_mm = 0.01 }}]
[simulate]
{simulate}
"#
    )
}

/// `render` of a calibration's file draws the frames that `calibrate` measures: a calibration from
/// their folders has the same values; the flat fields show the fall-off of the light, set by
/// photons as well as by counts.
#[test]
fn a_calibration_draws_what_it_measures() {
    let folder = Folder::new();
    let job_config = folder.write(
        "job.toml",
        &job(COHERENT, "").replace(
            "[camera]",
            "[light]\nbright_photons = 10000.0\n[light.field]\ngradient_down = 0.06\n[sensor]\nprnu_rel = 0.004\n[camera]",
        ),
    );
    let config = folder.write("plan.toml", &plan("config = \"job.toml\"\nframes_each = 1"));
    let drawn = folder.path("drawn");
    let (code, said, _) = folder.run(&["render", &config, "--out", &drawn, "--backend", "cpu"]);
    assert_eq!(code, 0, "{said}");
    let simulated = folder.calibrate(&config, "simulated.json", &[]);
    let recorded_plan = format!("{drawn}/calibrate.toml");
    let recorded = folder.calibrate(&recorded_plan, "recorded.json", &[]);
    for key in ["scale_mm_per_px", "offset_mm", "birge_ratio", "defects", "edge_model"] {
        assert_eq!(simulated[key], recorded[key], "{key}: {simulated} {recorded}");
    }
    assert_eq!(
        simulated["sensor"]["gain_counts_per_electron"],
        recorded["sensor"]["gain_counts_per_electron"]
    );
    let file: Value = serde_json::from_slice(&std::fs::read(folder.path("simulated.json")).unwrap()).unwrap();
    let fall_off = number(&file["bench"]["flat_field"]["fall_off"]);
    assert!((0.04..0.12).contains(&fall_off), "{fall_off}");
    // The masters and the job share the optical setup: a frame of the job is measured correctly
    // with the calibration.
    let out = folder.path("part");
    assert_eq!(folder.run(&["render", &job_config, "--out", &out, "--backend", "cpu"]).0, 0);
    let (frames, calibration) = (format!("{out}/frames"), folder.path("simulated.json"));
    let part =
        folder.json(&["measure", &frames, "--calibration", &calibration, "--as-of", "2026-12-01", "--json"]);
    let frame = &part["frames"][0];
    let (error, u) = (number(&frame["max_diameter_mm"]) - 0.40, number(&frame["u_max_mm"]));
    assert!(error.abs() < 3.0 * u + 5e-6 && u < 1e-4, "{error} {u}");
}

/// A master in the optical setup of a job and the same shaft in the job itself: the same image,
/// with the same light, lens, edge spread and sensor.
#[test]
fn a_master_is_drawn_alike_by_both() {
    let folder = Folder::new();
    let optics = "distortion = { k1 = 0.01, p1 = 0.002 }\ntelecentricity_mrad = 3.0";
    let sensor = "[light]\nbright_photons = 9000.0\n[light.field]\ngradient_along = 0.1\n[sensor]\nprnu_rel = 0.004\ndsnu_e = 2.0\n[camera]";
    for (name, esf) in [("gaussian", GAUSSIAN), ("coherent", COHERENT)] {
        let text = job(esf, optics).replace("[0.40]", "[0.36]").replace("[camera]", sensor);
        let config = folder.write("job.toml", &text);
        let exact = "config = \"job.toml\"\nframes_each = 1\nlimit_tilt_mrad = 0.0\nlimit_height_mm = 0.0";
        let own =
            plan(exact).replace("{ height_mm = 0.01 }", "{ height_mm = 0.0 }").replace("0.00004", "1e-12");
        let config_of_plan = folder.write("plan.toml", &own);
        let (part, pins) = (folder.path(&format!("{name}_part")), folder.path(&format!("{name}_pins")));
        for (config, out) in [(&config, &part), (&config_of_plan, &pins)] {
            let (code, said, _) =
                folder.run(&["render", config, "--out", out, "--backend", "cpu", "--no-noise"]);
            assert_eq!(code, 0, "{said}");
        }
        let pixels =
            |path: String| image::open(&path).unwrap_or_else(|e| panic!("{path}: {e}")).into_luma16();
        let of_job = pixels(format!("{part}/frames/000000.png"));
        let of_plan = pixels(format!("{pins}/pin_2_0/000000.png"));
        assert_eq!(of_job.dimensions(), of_plan.dimensions());
        let differ = of_job.iter().zip(of_plan.iter()).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        let unequal = of_job.iter().zip(of_plan.iter()).filter(|(a, b)| a != b).count();
        println!("{name}: {unequal} pixels differ by a count");
        assert!(differ == 0 && unequal < 20, "{name}: {differ} {unequal}");
        let edges = |path: String, frame: &str| -> Vec<(f64, f64)> {
            let text = std::fs::read_to_string(path).unwrap();
            let of_frame = text.lines().filter(|l| l.starts_with(frame));
            let number = |f: Option<&str>| f.unwrap().parse::<f64>().unwrap();
            of_frame.map(|l| (number(l.split(',').nth(2)), number(l.split(',').nth(3)))).collect()
        };
        let [a, b] = [
            edges(format!("{part}/truth.csv"), "000000,"),
            edges(format!("{pins}/truth.csv"), "pin_2_0/000000,"),
        ];
        assert!(
            a.len() == 400
                && a.iter().zip(&b).all(|(a, b)| (a.0 - b.0).abs() < 1e-5 && (a.1 - b.1).abs() < 1e-5)
        );
    }
}

/// `calibrate` of a job's own config: its optical setup on its own master pins, with the same
/// optics as in `render`.
#[test]
fn a_job_is_calibrated_by_its_own_config() {
    let folder = Folder::new();
    for esf in [GAUSSIAN, COHERENT] {
        let config = folder.write("job.toml", &job(esf, ""));
        let said = folder.calibrate(&config, "own.json", &["--esf", &config]);
        assert_eq!((&said["edge_model"], &said["optics_id"]), (&"table".into(), &"small bench".into()));
        let out = folder.path(&format!("part_{}", &esf[..4]));
        assert_eq!(folder.run(&["render", &config, "--out", &out, "--backend", "cpu"]).0, 0);
        let (frames, own) = (format!("{out}/frames"), folder.path("own.json"));
        let part =
            folder.json(&["measure", &frames, "--calibration", &own, "--as-of", "2026-12-01", "--json"]);
        let frame = &part["frames"][0];
        let (error, u) = (number(&frame["max_diameter_mm"]) - 0.40, number(&frame["u_max_mm"]));
        assert!(error.abs() < 3.0 * u + 5e-6, "{esf}: {error} {u}");
    }
}

/// A level pin does not determine an edge-spread function: it used to be fitted by a Gaussian under
/// another name.
#[test]
fn a_level_pin_teaches_no_edge_model() {
    let folder = Folder::new();
    folder.write("job.toml", &job(COHERENT, ""));
    let simulated = "config = \"job.toml\"\nframes_each = 1\nlimit_tilt_mrad = 0.3";
    let level = folder.write("level.toml", &plan(simulated));
    let out = folder.path("learnt.json");
    let (code, said, _) =
        folder.run(&["calibrate", &level, "--out", &out, "--esf", "learnt", "--backend", "cpu"]);
    assert!(code == 3 && said.contains("must travel 1.5 rows") && said.contains("--esf gaussian"), "{said}");
    assert!(!Path::new(&out).exists());
}

/// The fitted edge model is stated in text, JSON, report and file; another one is refused, and
/// without one the file's own is used.
#[test]
fn a_calibration_says_and_keeps_its_edge_model() {
    let folder = Folder::new();
    let config = folder.write("job.toml", &job(COHERENT, ""));
    let edge = folder.write("edge.csv", &table(&folder, &config, &["--with-blur"]));
    let other =
        folder.write("other.csv", &table(&folder, &folder.write("other.toml", &job(GAUSSIAN, "")), &[]));
    let simulated = "config = \"job.toml\"\nframes_each = 1\nlimit_tilt_mrad = 40.0";
    let oblique = folder.write("oblique.toml", &plan(simulated));
    let [gaussian, learnt, by_table] =
        [("gaussian", "gaussian.json"), ("learnt", "learnt.json"), (edge.as_str(), "table.json")]
            .map(|(esf, out)| folder.calibrate(&oblique, out, &["--esf", esf]));
    assert_eq!(
        [&gaussian, &learnt, &by_table].map(|c| c["edge_model"].as_str().unwrap()),
        ["gaussian", "learnt", "table"]
    );
    assert_ne!(gaussian["offset_mm"], learnt["offset_mm"]);
    let html = std::fs::read_to_string(folder.path("learnt.html")).unwrap();
    assert!(html.contains("edge model fitted: learnt"), "report");
    let text = folder.run(&[
        "calibrate",
        &oblique,
        "--out",
        &folder.path("t.json"),
        "--esf",
        &edge,
        "--backend",
        "cpu",
    ]);
    assert!(String::from_utf8_lossy(&text.2).contains("edge model fitted: table of "), "{}", text.1);
    let out = folder.path("part");
    assert_eq!(folder.run(&["render", &config, "--out", &out, "--backend", "cpu"]).0, 0);
    let frames = format!("{out}/frames");
    let measure = |calibration: &str, more: &[&str]| {
        let path = folder.path(calibration);
        let fixed = ["measure", &frames, "--calibration", &path, "--as-of", "2026-12-01", "--json"];
        folder.run(&[&fixed[..], more].concat())
    };
    let diameter = |calibration: &str, more: &[&str]| {
        let (code, said, out) = measure(calibration, more);
        assert_eq!(code, 0, "{said}");
        let all: Value = serde_json::from_slice(&out).unwrap();
        number(&all["frames"][0]["max_diameter_mm"])
    };
    // The file has six decimals of the table.
    close(diameter("table.json", &[]), diameter("table.json", &["--esf", &edge]), 1e-8, "its own table");
    close(diameter("table.json", &["--esf", &config]), 0.40, 1e-4, "the config's own optics are the table's");
    for (calibration, esf) in [
        ("table.json", "gaussian"),
        ("table.json", other.as_str()),
        ("learnt.json", "gaussian"),
        ("gaussian.json", edge.as_str()),
    ] {
        let (code, said, _) = measure(calibration, &["--esf", esf]);
        let said = said.replace("│ ", "");
        assert!(code == 2 && said.contains("edge-spread function"), "{calibration} {esf}: {said}");
    }
    // A file of an earlier version contains only the name of its model.
    let before = std::fs::read_to_string(folder.path("gaussian.json")).unwrap();
    folder.write("before.json", &before.replace("\"edge_model\": \"gaussian\",", ""));
    close(diameter("before.json", &[]), diameter("gaussian.json", &[]), 1e-12, "a file without a model");
}

/// A missing statement is a row: wide ones for recorded masters without thermometer and conditions,
/// none for rendered ones.
#[test]
fn what_is_not_stated_is_a_row() {
    let folder = Folder::new();
    folder.write("job.toml", &job(GAUSSIAN, ""));
    let config = folder.write("plan.toml", &plan("config = \"job.toml\"\nframes_each = 1"));
    let drawn = folder.path("drawn");
    assert_eq!(folder.run(&["render", &config, "--out", &drawn, "--backend", "cpu"]).0, 0);
    let own = std::fs::read_to_string(format!("{drawn}/calibrate.toml")).unwrap();
    let without: String = {
        let mut table: toml::Table = own.parse().unwrap();
        table.remove("conditions");
        table.remove("thermometer");
        table.to_string()
    };
    std::fs::write(format!("{drawn}/unstated.toml"), &without).unwrap();
    let stated = without.clone()
        + "\n[conditions]\nlimit_temperature_k = 0.5\nlimit_expansion_um_per_m_k = 1.0\nfinish_of_masters = \"lapped\"\nfinish_of_part = \"ground\"\n\
           [thermometer]\nlimit_temperature_k = 0.2\nlimit_expansion_um_per_m_k = 1.0\n";
    std::fs::write(format!("{drawn}/stated.toml"), stated).unwrap();
    folder.calibrate(&config, "simulated.json", &[]);
    folder.calibrate(&format!("{drawn}/unstated.toml"), "unstated.json", &[]);
    folder.calibrate(&format!("{drawn}/stated.toml"), "stated.json", &[]);
    let frames = format!("{drawn}/pin_2_0");
    let rows = |calibration: &str, more: &[&str]| {
        let path = folder.path(calibration);
        let fixed =
            ["measure", &frames, "--calibration", &path, "--as-of", "2026-12-01", "--json", "--budget"];
        let all = folder.json(&[&fixed[..], more].concat());
        all["frames"][0]["budget"].as_array().unwrap().clone()
    };
    let u_um = |rows: &[Value], source: &str| {
        let found = rows.iter().filter(|r| r["source"].as_str().unwrap().starts_with(source));
        found.map(|r| 1e3 * number(&r["u_mm"])).sum::<f64>()
    };
    let open = rows("unstated.json", &[]);
    close(u_um(&open, "edges unlike the masters'"), 3.0 / 3.0_f64.sqrt(), 1e-9, "finish");
    let ppm_um = 0.36e-3 * (11.5 * 5.0 / 3.0_f64.sqrt()).hypot(5.0 / 3.0);
    close(u_um(&open, "temperature of the part"), ppm_um, 1e-3 * ppm_um, "temperature");
    assert!(u_um(&open, "temperature of the masters, not stated") > 0.8 * ppm_um, "{open:?}");
    assert!(open.iter().any(|r| r["input"].as_str().unwrap().contains("not stated")));
    let known = rows("stated.json", &[]);
    let ground = u_um(&known, "edges unlike the masters'");
    assert!((0.3..0.6).contains(&ground), "{ground}");
    let exact = rows("simulated.json", &[]);
    assert!(u_um(&exact, "edges unlike") + u_um(&exact, "temperature") < 1e-12, "{exact:?}");
    // A file of conditions sets only the keys that it contains.
    let conditions = folder.write("conditions.toml", "limit_edge_um = 0.1\n");
    let named = rows("unstated.json", &["--conditions", &conditions]);
    close(u_um(&named, "edges unlike"), 0.2 / 3.0_f64.sqrt(), 1e-9, "stated finish");
    assert!(u_um(&named, "temperature of the part") > 0.9 * ppm_um);
}

/// `study uncertainty` has the rows of `--budget`, by name, and a part whose rows follow from the
/// inverted lens model.
#[test]
fn the_study_of_uncertainty_has_every_row_of_the_budget() {
    let folder = Folder::new();
    folder.write("job.toml", &job(COHERENT, "distortion = { k1 = 0.02 }"));
    let text = plan("config = \"job.toml\"\nframes_each = 1")
        .replace("distortion_percent = 0.05", "distortion_percent = 3.0")
        + "\n[conditions]\nlimit_temperature_k = 2.0\ntemperature_c = 24.0\nlimit_edge_um = 0.02\nlimit_axis_y_mm = 0.01\nlimit_drift_ppm = 5.0\n\
           [thermometer]\ntemperature_c = 22.0\nlimit_temperature_k = 0.5\n";
    let config = folder.write("plan.toml", &text);
    let study = folder.json(&[
        "study",
        "uncertainty",
        &config,
        "--trials",
        "20000",
        "--backend",
        "cpu",
        "--json",
        "--diameter-mm",
        "0.36",
    ]);
    let sources: Vec<&str> = study["uncertainty"]["sources"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| s["name"].as_str().unwrap())
        .collect();
    close(number(&study["uncertainty"]["y_mm"]), 0.36, 1e-9, "the lens inverted");
    folder.calibrate(&config, "c.json", &[]);
    let out = folder.path("drawn");
    assert_eq!(folder.run(&["render", &config, "--out", &out, "--backend", "cpu"]).0, 0);
    let (frames, calibration) = (format!("{out}/pin_2_0"), folder.path("c.json"));
    let measured = folder.json(&[
        "measure",
        &frames,
        "--calibration",
        &calibration,
        "--as-of",
        "2026-12-01",
        "--json",
        "--budget",
    ]);
    for row in measured["frames"][0]["budget"].as_array().unwrap() {
        let source = row["source"].as_str().unwrap();
        // A contribution of a millionth of the total may vanish at one of two places in the field.
        if number(&row["u_mm"]) > 1e-3 * number(&measured["frames"][0]["u_max_mm"]) {
            assert!(sources.contains(&source), "{source} in {sources:?}");
        }
    }
}
