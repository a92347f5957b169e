//! `tool render`, `tool nose` and `tool compensate` one after another, `tool render-flank`, `tool
//! train` and `tool flank`, and what is refused.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

fn config(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/tool").join(name)
}

fn run(arguments: &[&str]) -> Output {
    program::shadowgauge(arguments)
}

fn good(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(arguments: &[&str], exit: i32) -> String {
    let output = run(arguments);
    assert_eq!(
        output.status.code(),
        Some(exit),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stderr).unwrap().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Renders an insert of the examples; its image.
fn render(folder: &Path, name: &str) -> String {
    let out = folder.join(name);
    good(&["tool", "render", config(name).to_str().unwrap(), "--out", out.to_str().unwrap()]);
    out.join("frames/000000.png").to_str().unwrap().to_owned()
}

#[test]
fn a_worn_insert_from_its_image_to_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (worn, new) = (render(folder.path(), "insert.toml"), render(folder.path(), "insert_new.toml"));
    let tool = config("tool.toml").to_str().unwrap().to_owned();
    let (out, drawn) = (at("nose.json"), at("nose.png"));
    let text = good(&[
        "tool",
        "nose",
        &worn,
        "--um-per-px",
        "2.415",
        "--tool",
        &tool,
        "--json",
        "--out",
        &out,
        "--overlay",
        &drawn,
    ]);
    let document: Value = serde_json::from_str(&text).unwrap();
    let image = &document["images"][0];
    let truth = folder.path().join("insert.toml/truth.json");
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(truth).unwrap()).unwrap();
    for (key, most) in [("angle_deg", 0.002), ("mean_radius_px", 0.01)] {
        let off = image[key].as_f64().unwrap() - truth[key].as_f64().unwrap();
        assert!(off.abs() < most, "{key}: off by {off}");
    }
    for k in 0..2 {
        let off = image["centre_px"][k].as_f64().unwrap() - truth["centre_px"][k].as_f64().unwrap();
        assert!(off.abs() < 0.01, "centre: off by {off}");
    }
    assert_eq!(image["image"], "000000");
    assert!(image::open(&drawn).unwrap().as_rgb8().is_some());
    let part = config("outline.toml").to_str().unwrap().to_owned();
    let machine = config("machine.toml").to_str().unwrap().to_owned();
    let way = [
        "tool",
        "compensate",
        "--nose",
        &out,
        "--tool",
        &tool,
        "--part",
        &part,
        "--json",
        "--machine",
        &machine,
    ];
    let left: Value = serde_json::from_str(&good(&way)).unwrap();
    assert!(left["e"].as_array().unwrap().len() > 50);
    for baseline in [new.clone(), at("new.json")] {
        if baseline.ends_with("json") {
            good(&["tool", "nose", &new, "--um-per-px", "2.415", "--out", &baseline]);
        }
        let text = good(&["tool", "nose", &worn, "--um-per-px", "2.415", "--baseline", &baseline, "--json"]);
        let document: Value = serde_json::from_str(&text).unwrap();
        let wear = &document["images"][0]["wear"];
        assert!((wear["largest_um"].as_f64().unwrap() - 15.0).abs() < 0.3, "{wear}");
    }
}

#[test]
fn what_cannot_be_measured_names_the_image_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let worn = render(folder.path(), "insert.toml");
    let tool = config("tool.toml").to_str().unwrap().to_owned();
    let out = folder.path().join("nose.json");
    let given = out.to_str().unwrap();
    let picture = image::open(&worn).unwrap();
    let save = |name: &str, image: image::DynamicImage| {
        let path = folder.path().join(name);
        image.save(&path).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let mirrored = save("mirrored.png", picture.fliph());
    let said =
        refused(&["tool", "nose", &mirrored, "--um-per-px", "2.415", "--tool", &tool, "--out", given], 3);
    assert!(said.contains("mirrored:") && said.contains("mirrored left to right"), "{said}");
    let blank = save("blank.png", image::DynamicImage::new_luma8(300, 200));
    let said = refused(&["tool", "nose", &blank, "--um-per-px", "2.415", "--out", given], 3);
    assert!(said.contains("blank: no insert"), "{said}");
    assert!(!out.exists());
    let said = refused(&["tool", "nose", &worn], 2);
    assert!(said.contains("--um-per-px"), "{said}");
    let said = refused(&["tool", "nose", &worn, "--um-per-px", "0"], 2);
    assert!(said.contains("a scale above 0"), "{said}");
    let said = refused(&["tool", "nose", &worn, "--um-per-px", "1e9"], 2);
    assert!(said.contains("from 0.01 to 1000"), "{said}");
    let inverted = save("inverted.png", {
        let mut grey = picture.to_luma16();
        grey.pixels_mut().for_each(|p| p[0] = 4095 - p[0].min(4095));
        image::DynamicImage::ImageLuma16(grey)
    });
    let said = refused(&["tool", "nose", &inverted, "--um-per-px", "2.415", "--out", given], 3);
    assert!(said.contains("inverted: light and shadow are swapped"), "{said}");
    let said = refused(&["tool", "nose", &worn, "--um-per-px", "2.415", "--baseline", &worn], 3);
    assert!(said.contains("worn"), "{said}");
}

#[test]
fn of_a_colour_image_the_channel_is_measured_that_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let worn = render(folder.path(), "insert_new.toml");
    let grey = image::open(&worn).unwrap().into_luma16();
    let colour = image::RgbImage::from_fn(grey.width(), grey.height(), |x, y| {
        let value = (grey.get_pixel(x, y)[0] / 16) as u8;
        image::Rgb([10, value, 255 - value])
    });
    let path = folder.path().join("colour.png");
    colour.save(&path).unwrap();
    let path = path.to_str().unwrap();
    let output = run(&["tool", "nose", path, "--um-per-px", "2.415", "--json"]);
    let (text, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let found: Value = serde_json::from_str(&text).unwrap();
    assert!((found["images"][0]["angle_deg"].as_f64().unwrap() - 60.0).abs() < 0.02, "{text}");
    assert!(said.contains("of red, green and blue green is measured"), "{said}");
    let said = refused(&["tool", "nose", path, "--um-per-px", "2.415", "--channel", "r"], 3);
    assert!(said.contains("no insert"), "{said}");
}

/// An insert of the examples with its nose elsewhere; its image.
fn moved(folder: &Path, name: &str, centre_px: [f64; 2]) -> String {
    let text = std::fs::read_to_string(config("insert_new.toml")).unwrap();
    let text = text.replace("[520.0, 640.0]", &format!("{centre_px:?}"));
    assert!(text.contains(&format!("{centre_px:?}")));
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    let out = folder.join(format!("{name}.out"));
    good(&["tool", "render", path.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let image = folder.join(format!("{name}.png"));
    std::fs::copy(out.join("frames/000000.png"), &image).unwrap();
    image.to_str().unwrap().to_owned()
}

#[test]
fn moves_along_x_and_z_give_the_axes_of_the_image_and_the_tool_takes_them() {
    let folder = tempfile::tempdir().unwrap();
    // .2 mm are 82.8157 px; the image is turned by 1.5 degrees: +X to 91.5, +Z to 1.5
    let (sin, cos) = 1.5_f64.to_radians().sin_cos();
    let step = 200.0 / 2.415;
    let at = |x: f64, z: f64| {
        let (right, up) = (step * (z * cos - x * sin), step * (x * cos + z * sin));
        [520.0 + right, 640.0 - up]
    };
    let places = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    let images: Vec<String> = places
        .iter()
        .enumerate()
        .map(|(k, (x, z))| moved(folder.path(), &format!("{k}.toml"), at(*x, *z)))
        .collect();
    let tool = config("tool_set_new.toml").to_str().unwrap().to_owned();
    let out = folder.path().join("turned.toml").to_str().unwrap().to_owned();
    let mut arguments = vec!["tool", "axes"];
    arguments.extend(images.iter().map(String::as_str));
    let given = ["--um-per-px", "2.415", "--tool", &tool];
    let with = |x: &'static str, z: &'static str, more: &[&str]| {
        let mut all: Vec<String> = arguments.iter().chain(&given).map(|s| (*s).to_owned()).collect();
        all.extend(["--x-mm", x, "--z-mm", z].map(str::to_owned));
        all.extend(more.iter().map(|s| (*s).to_owned()));
        all
    };
    let text = |all: &[String]| good(&all.iter().map(String::as_str).collect::<Vec<_>>());
    let found: Value =
        serde_json::from_str(&text(&with("0,0.2,0,0.2", "0,0,0.2,0.2", &["--json", "--out", &out]))).unwrap();
    for (key, wanted, most) in
        [("off_square_deg", 0.0, 0.02), ("um_per_px_x", 2.415, 0.001), ("um_per_px_z", 2.415, 0.001)]
    {
        let value = found[key].as_f64().unwrap();
        assert!((value - wanted).abs() < most, "{key}: {value}");
    }
    let (x, z) = (&found["image"]["plus_x_deg"], &found["image"]["plus_z_deg"]);
    assert!((x.as_f64().unwrap() - 91.5).abs() < 0.02 && (z.as_f64().unwrap() - 1.5).abs() < 0.02, "{found}");
    assert!(found["u_plus_x_deg"].as_f64().unwrap() > 0.0);
    let written: toml::Table = std::fs::read_to_string(&out).unwrap().parse().unwrap();
    assert_eq!(written["image"]["plus_x_deg"].as_float(), x.as_f64());
    assert_eq!(written["setting"]["x_extent_mm"].as_float(), Some(0.4));
    let said = |all: &[String]| refused(&all.iter().map(String::as_str).collect::<Vec<_>>(), 2);
    let few = said(&with("0,0.2,0", "0,0,0.2,0.2", &[]));
    assert!(few.contains("--x-mm") && few.contains("4 images"), "{few}");
    let line = said(&with("0,0.2,0,0.2", "0,0,0,0", &[]));
    assert!(line.contains("lie on a line"), "{line}");
    let diameters = said(&with("0,0.4,0,0.4", "0,0,0.2,0.2", &[]));
    assert!(diameters.contains("half of diameters"), "{diameters}");
}

#[test]
fn the_papers_mode_has_the_same_keys_without_uncertainties() {
    let folder = tempfile::tempdir().unwrap();
    let worn = render(folder.path(), "insert.toml");
    let tool = config("tool.toml").to_str().unwrap().to_owned();
    let call = ["tool", "nose", &worn, "--um-per-px", "2.415", "--mode", "paper"];
    let with_tool = [&call[..], &["--tool", &tool, "--json"]].concat();
    let found: Value = serde_json::from_str(&good(&with_tool)).unwrap();
    let image = &found["images"][0];
    let truth = folder.path().join("insert.toml/truth.json");
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(truth).unwrap()).unwrap();
    for (key, most) in [("angle_deg", 0.005), ("mean_radius_px", 6.0)] {
        let off = image[key].as_f64().unwrap() - truth[key].as_f64().unwrap();
        assert!(off.abs() < most, "{key}: off by {off}");
    }
    for key in ["u_angle_deg", "u_centre_px", "u_mean_radius_px", "u_mean_radius_mm"] {
        assert!(image[key].is_null(), "{key}");
    }
    assert!(image["u_reason"].as_str().unwrap().contains("--mode ml"));
    assert!(image["sectors"].as_array().unwrap().len() > 110);
    let said = refused(&call, 2);
    assert!(said.contains("--tool"), "{said}");
    let said = refused(&[&with_tool[..], &["--baseline", &worn]].concat(), 2);
    assert!(said.contains("--baseline") && said.contains("--mode ml"), "{said}");
}

/// A small insert for studies, as a file.
fn small(folder: &Path) -> String {
    let path = folder.join("small.toml");
    let text = "[camera]\ncolumns = 640\nrows = 512\n[nose]\nradius_mm = 0.2\ncentre_px = [260.0, 310.0]\n";
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_study_of_worn_noses_writes_what_it_drew_and_counts_every_nose() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let config = small(folder.path());
    let call = [
        "study",
        "nose",
        &config,
        "--worn",
        "5",
        "--contamination",
        "--out",
        out.to_str().unwrap(),
        "--json",
    ];
    let document: Value = serde_json::from_str(&good(&call)).unwrap();
    let all = document["rows"].as_array().unwrap().last().unwrap();
    let count = |key: &str| all[key].as_u64().unwrap();
    assert_eq!(count("noses"), 5);
    assert_eq!(count("measured") + count("flagged") + count("refused"), 5, "{all}");
    let truth: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("truth.json")).unwrap()).unwrap();
    assert_eq!(truth.as_array().unwrap().len(), 5);
    assert_eq!(std::fs::read_to_string(out.join("noses.csv")).unwrap().lines().count(), 6);
    // a frame of it, measured and timed
    let frame = out.join("frames/000004.png").to_str().unwrap().to_owned();
    let text = good(&["tool", "nose", &frame, "--um-per-px", "2.415", "--bench", "1", "--json"]);
    let document: Value = serde_json::from_str(&text).unwrap();
    let off = document["images"][0]["angle_deg"].as_f64().unwrap() - truth[4]["angle_deg"].as_f64().unwrap();
    assert!(off.abs() < 0.02, "{off}");
    assert_eq!(document["bench"]["measurements"], 1);
    let said = refused(&["study", "nose", &config, "--contamination"], 2);
    assert!(said.contains("--worn"), "{said}");
}

/// Whether Python has what the peers of the nose need.
fn peers_installed() -> bool {
    let call = ["-c", "import cv2, numpy"];
    std::process::Command::new("python3").args(call).output().is_ok_and(|o| o.status.success())
}

#[test]
fn the_peers_of_the_nose_make_their_table() {
    if !peers_installed() {
        eprintln!("SKIPPED: python3 with cv2 and numpy is needed for benches/peers/nose_peers.py");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/nose_peers.py");
    let mut call = std::process::Command::new("python3");
    call.arg(script).args(["--binary", env!("CARGO_BIN_EXE_shadowgauge"), "--noses", "5", "--repeats", "1"]);
    let done = call.args(["--config", &small(folder.path())]).output().unwrap();
    let (table, said) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{said}");
    for method in ["this crate, ml", "this crate, the paper's way", "LSD + TLS"] {
        let row = table.lines().find(|line| line.contains(method));
        assert!(row.is_some_and(|row| !row.contains("measured none")), "{method}: {table} {said}");
    }
}

/// Two rendered flanks in a folder below `folder`, and a forest that was trained on them.
fn flanks_and_forest(folder: &Path) -> (PathBuf, String) {
    let at = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let flanks = at("flanks");
    let size = ["--random", "2", "--size", "360x240", "--um-per-px", "4"];
    good(&[&["tool", "render-flank", "--out", &flanks], &size[..]].concat());
    let (forest, strips) = (at("flanks.forest"), at("strips"));
    let out = ["--um-per-px", "4", "--out", &forest, "--strips", &strips];
    let said = good(&[&["tool", "train", &flanks], &out[..]].concat());
    assert!(said.contains("2 images") && said.contains("µm rms"), "{said}");
    // a strip of 510 rows of float32 and its land for every image
    let mut names: Vec<String> = std::fs::read_dir(folder.join("strips"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["000000.tif", "000000_land.png", "000001.tif", "000001_land.png"]);
    let file = std::fs::File::open(folder.join("strips/000000.tif")).unwrap();
    let mut strip = tiff::decoder::Decoder::new(std::io::BufReader::new(file)).unwrap();
    let land = image::open(folder.join("strips/000000_land.png")).unwrap().to_luma8();
    assert_eq!(strip.dimensions().unwrap(), land.dimensions());
    assert_eq!(land.height(), 510);
    let tiff::decoder::DecodingResult::F32(grey) = strip.read_image().unwrap() else { panic!("no float32") };
    assert!(grey.iter().all(|v| (-1.0..=3.0).contains(v)));
    assert!(land.pixels().any(|p| p.0 == [255]) && land.pixels().all(|p| [0, 255].contains(&p.0[0])));
    (folder.join("flanks"), forest)
}

/// Keys of an image in the document of `tool flank`.
const KEYS: [&str; 11] = [
    "image",
    "vbb_um",
    "u_vbb_um",
    "vbb_max_um",
    "u_vbb_max_um",
    "vc_um",
    "vn_um",
    "worn_length_um",
    "class",
    "verdict",
    "flags",
];

/// Flanks by a forest, by the paper's way and by what is no model: keys, history, limits, refusals.
#[test]
fn a_flank_from_its_image_to_a_verdict_a_history_and_a_forecast() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (flanks, forest) = flanks_and_forest(folder.path());
    let image = flanks.join("000000.png").to_str().unwrap().to_owned();
    let tried = |more: &[&str]| run(&[&["tool", "flank", &image, "--um-per-px", "4"], more].concat());
    let document = |more: &[&str]| -> Value {
        let output = tried(more);
        assert_eq!(output.status.code(), Some(0), "{more:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let no = |more: &[&str], exit: i32| {
        refused(&[&["tool", "flank", &image, "--um-per-px", "4"], more].concat(), exit)
    };
    let (history, overlay) = (at("edge.csv"), at("land.png"));
    let mut last = Value::Null;
    for cut in ["1", "2", "3"] {
        last = document(&["--model", &forest, "--json", "--history", &history, "--cut", cut]);
    }
    let one = last["images"][0].as_object().unwrap();
    assert!(KEYS.iter().all(|key| one.contains_key(*key)), "{one:?}");
    assert!(one["image"] == "000000" && one["vbb_um"].as_f64() > Some(0.0), "{one:?}");
    assert!(one["u_vbb_um"].as_f64() > Some(0.0) && one["flags"].is_array(), "{one:?}");
    // three equal readings: both forecasts, and no cut at which a limit is reached
    let forecasts = last["forecasts"].as_array().unwrap();
    assert!(forecasts.len() == 2 && forecasts.iter().all(|f| f["readings"] == 3), "{forecasts:?}");
    assert_eq!(std::fs::read_to_string(&history).unwrap().lines().count(), 4);
    assert!(no(&["--model", &forest, "--history", &history, "--cut", "2"], 2).contains("ends at cut 3"));
    document(&["--model", &forest, "--json", "--overlay", &overlay]);
    assert_eq!(image::open(&overlay).unwrap().to_rgb8().dimensions(), (360, 240));
    // the same picture new: the bend of its edge; a limit below the land ends with 1
    document(&["--model", &forest, "--json", "--baseline", &image]);
    assert_eq!(tried(&["--model", &forest, "--vbb-limit-um", "1"]).status.code(), Some(1));
    assert!(no(&["--model", &image], 2).contains("not a file of `tool train`"));
    let network = no(&["--model", &at("absent.onnx")], 2);
    assert!(network.contains("absent.onnx") && network.contains("FILE.onnx"), "{network}");
    #[cfg(not(feature = "onnx"))]
    assert!(network.contains("--features onnx"), "{network}");
    // without a model the forest that the program brings along
    let shipped = document(&["--json"]);
    assert!(shipped["images"][0]["u_vbb_um"].as_f64() > Some(0.0), "{shipped}");
    // tools about the limits, a row each; images without labels state no errors
    let (tools, empty) = (at("tools.csv"), at("empty"));
    let small = ["--size", "360x240", "--um-per-px", "8", "--tools", "2", "--csv", &tools];
    let said = good(&[&["study", "flank", "--model", &forest], &small[..]].concat());
    assert!(said.starts_with("2 tools about VBB 300 and VBBmax 600 µm"), "{said}");
    let table = std::fs::read_to_string(&tools).unwrap();
    assert!(table.lines().count() == 3 && table.contains(",blunt,verdict"), "{table}");
    std::fs::create_dir(&empty).unwrap();
    std::fs::copy(&image, folder.path().join("empty/alone.png")).unwrap();
    let flanks = flanks.to_str().unwrap();
    let call = ["tool", "train", flanks, "--um-per-px", "4", "--out", &at("no.forest"), "--test", &empty];
    assert!(refused(&call, 2).contains("--test: no labelled image"));
    assert!(!folder.path().join("no.forest").exists());
    // the paper's way has the same keys and no uncertainty, or sees no bright land
    let output = tried(&["--model", "paper", "--json"]);
    match output.status.code() {
        Some(0) => {
            let of: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert!(of["images"][0]["u_vbb_um"].is_null() && of["images"][0]["verdict"] != "sharp", "{of}");
        }
        code => assert_eq!(code, Some(3)),
    }
}
