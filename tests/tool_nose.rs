//! `tool render`, `tool nose` and `tool compensate` one after another, and what is refused.
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
    let text = good(&["tool", "nose", path, "--um-per-px", "2.415", "--json"]);
    let found: Value = serde_json::from_str(&text).unwrap();
    assert!((found["images"][0]["angle_deg"].as_f64().unwrap() - 60.0).abs() < 0.02, "{text}");
    let said = refused(&["tool", "nose", path, "--um-per-px", "2.415", "--channel", "r"], 3);
    assert!(said.contains("no insert"), "{said}");
}
