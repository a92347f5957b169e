//! What leaves `measure`: `--csv` and `--report`, and its exit codes.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};
use std::process::Output;

use image::{GrayImage, Luma};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use tempfile::TempDir;

use program::{json, said, text};

#[path = "support/program.rs"]
mod program;

/// A noisy shadow from row 60.2 to row `bottom`.
fn save_part(folder: &Path, name: &str, seed: u64, bottom: f64) {
    let soft = |d: f64| 30.0 + 170.0 / (1.0 + (-2.0 * d).exp());
    let mut rng = Pcg64::seed_from_u64(seed);
    let grey = |_, y: u32| {
        let y = f64::from(y);
        let light = if y < 100.0 { soft(60.2 - y) } else { soft(y - bottom) };
        Luma([light as u8 + rng.random_range(0..3)])
    };
    GrayImage::from_fn(320, 200, grey).save(folder.join(name)).unwrap();
}

/// Three frames of a part of 8.01 mm at 100 µm a pixel, in a folder of their own.
struct Case(TempDir);

impl Case {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("frames")).unwrap();
        for (name, seed) in [("a.png", 1), ("b.png", 2), ("c.png", 3)] {
            save_part(&folder.path().join("frames"), name, seed, 140.3);
        }
        Self(folder)
    }

    /// The same with a white frame between them.
    fn with_blank() -> Self {
        let case = Self::new();
        GrayImage::from_pixel(320, 200, Luma([255])).save(case.path("frames/bb<1>.png")).unwrap();
        case
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `measure frames --um-per-px 100` with more arguments, in the folder.
    fn measure(&self, more: &[&str]) -> Output {
        self.run(&[&["frames", "--um-per-px", "100"], more].concat())
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = std::process::Command::new(program::path());
        command.arg("measure").args(arguments).current_dir(self.0.path()).env("NO_COLOR", "1");
        command.output().expect("the program runs")
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// Names in the folder beside those of the inputs.
    fn outputs(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.retain(|name| name != "frames");
        names.sort();
        names
    }
}

/// Rows of a CSV text by the names of their columns.
fn rows(text: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect()
}

#[test]
fn the_csv_has_the_values_of_json() {
    let case = Case::with_blank();
    let output =
        case.measure(&["--json", "--csv", "d.csv", "--average", "moving:2", "--tolerance", "7.9..8.1"]);
    // The white frame is not proven good.
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let frames = json(&output)["frames"].as_array().unwrap().clone();
    let csv = case.read("d.csv");
    assert!(csv.starts_with("frame,row,z_mm,diameter_mm,expanded_u_mm,k,mean_mm,"), "{csv}");
    assert_eq!(csv.matches("\r\n").count(), csv.matches('\n').count(), "RFC 4180 ends a row by CR LF");
    let rows = rows(&csv);
    assert_eq!((rows.len(), frames.len()), (4, 4));
    for (row, frame) in rows.iter().zip(&frames) {
        assert_eq!(row["frame"], frame["frame"].as_str().unwrap());
        assert_eq!(row["row"], "frame");
        for (column, key) in [
            ("z_mm", "max_z_mm"),
            ("diameter_mm", "max_diameter_mm"),
            ("expanded_u_mm", "expanded_u_max_mm"),
            ("k", "coverage_factor"),
            ("mean_mm", "mean_diameter_mm"),
            ("average_mm", "average_mm"),
            ("valid_columns", "valid"),
            ("columns", "columns"),
        ] {
            assert_eq!(row[column].parse::<f64>().ok(), frame[key].as_f64(), "{column} of {frame}");
        }
        let u_mean = frame["u_mean_diameter_mm"].as_f64().map(|u| 2.0 * u);
        assert_eq!(row["expanded_u_mean_mm"].parse::<f64>().ok(), u_mean, "{frame}");
    }
    let blank = rows.iter().find(|row| row["frame"] == "bb<1>").unwrap();
    assert_eq!((&*blank["refused"], &*blank["judgement"]), ("low_contrast", "not_proven"));
    assert_eq!((&*blank["diameter_mm"], &*blank["mean_mm"], &*blank["valid_columns"]), ("", "", "0"));
    let good: Vec<&str> = rows.iter().map(|row| &*row["judgement"]).collect();
    assert_eq!(good.iter().filter(|word| **word == "GO").count(), 3, "{good:?}");
}

#[test]
fn stations_have_rows_of_their_own() {
    let case = Case::new();
    let output = case.measure(&["--json", "--csv", "d.csv", "--station-mm", "8", "--tolerance", "7.9..8.1"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let frames = json(&output)["frames"].as_array().unwrap().clone();
    let rows = rows(&case.read("d.csv"));
    let stations = frames[0]["stations"].as_array().unwrap();
    assert!(stations.len() >= 3, "{}", frames[0]);
    assert_eq!(rows.iter().filter(|row| row["row"] == "frame").count(), 3);
    assert_eq!(rows[0]["row"], "frame");
    for (row, station) in rows[1..].iter().zip(stations) {
        assert_eq!((&*row["row"], &*row["frame"]), ("station", "a"));
        assert_eq!(row["diameter_mm"].parse::<f64>().ok(), station["d_mm"].as_f64(), "{station}");
        assert_eq!(row["judgement"], station["judgement"].as_str().unwrap());
    }
}

#[test]
fn the_report_shows_values_limits_and_what_was_refused() {
    let case = Case::with_blank();
    let wanted = ["--report", "r.html", "--tolerance", "7.9..8.1", "--station-mm", "8"];
    let output = case.measure(&wanted);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let html = case.read("r.html");
    for part in [
        "<html lang=\"en\">",
        "name=\"viewport\"",
        "prefers-color-scheme:dark",
        "@media print",
        "size:A4",
        "role=\"img\" aria-label=\"Chart: largest diameter / mm over frame, in their order\"",
        "role=\"img\" aria-label=\"Chart: diameter of the station / mm over z / mm\"",
        "<th scope=\"col\"",
        "<p class=\"verdict open\">",
        "a scale of 100 µm/px was stated",
        "7.9 mm to 8.1 mm",
        "limits: 8.1 to 8.1",
        "Uncertainty budget of frame",
        "proven to lie within both limits",
        "<h2>Refused frames</h2>",
        "alt=\"Frame bb&lt;1&gt; as the camera gave it\"",
        "src=\"data:image/png;base64,iVBORw0KGgo",
        "contrast too low against the noise",
    ] {
        assert!(html.contains(part), "{part} is not in the report");
    }
    assert_eq!(html.matches("<img").count(), 1);
    assert_eq!(html.matches("<svg").count(), html.matches("role=\"img\"").count());
    assert!(!html.contains("<script") && !html.contains("bb<1>"), "names cannot break out");
    let caption = html.split("<figcaption>").find(|part| part.starts_with("frame bb&lt;1&gt;: "));
    assert!(caption.is_some(), "the reason stands below the picture");
    // Nothing is written that was not asked for, and the budget is the report's alone.
    assert_eq!(case.outputs(), ["r.html"]);
    assert!(!text(&output.stdout).contains("budget of the largest diameter"));
}

#[test]
fn a_report_without_a_tolerance_judges_nothing() {
    let case = Case::new();
    let output = case.measure(&["--report", "r.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let html = case.read("r.html");
    assert!(html.contains("nothing was judged") && !html.contains("Refused frames"));
    assert!(!html.contains("<img") && !html.contains(">judgement</th>") && !html.contains(">limits</text>"));
    // In tolerance, and by a tolerance that is missed.
    for (tolerance, code, class, word) in
        [("7.9..8.1", 0, "good", "In tolerance"), ("7..7.5", 1, "bad", "Out of")]
    {
        let output = case.measure(&["--report", "r.html", "--tolerance", tolerance]);
        assert_eq!(output.status.code(), Some(code), "{}", said(&output));
        let html = case.read("r.html");
        assert!(
            html.contains(&format!("<p class=\"verdict {class}\">")) && html.contains(word),
            "{tolerance}"
        );
    }
}

#[test]
fn judgements_and_averages_stand_in_the_table() {
    let case = Case::with_blank();
    let output = case.measure(&["--tolerance", "7..7.5", "--average", "moving:2"]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let table = text(&output.stdout);
    assert!(table.lines().next().unwrap().contains("average mm"), "{table}");
    assert!(table.contains("HH: proven to lie above the upper limit"), "{table}");
    assert!(!table.contains("LL: proven") && table.contains("-: not measured"), "{table}");
    let plain = text(&case.measure(&[]).stdout);
    assert!(!plain.contains("average mm") && !plain.contains("proven"), "{plain}");
}

#[test]
fn stdout_takes_one_output() {
    let case = Case::new();
    let output = case.measure(&["--csv", "-"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(rows(&text(&output.stdout)).len(), 3, "the table leaves stdout to the CSV");
    let output = case.measure(&["--report", "-", "--csv", "d.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(
        text(&output.stdout).starts_with("<!doctype html>") && text(&output.stdout).ends_with("</html>\n")
    );
    for (more, word) in [
        (&["--csv", "-", "--json"][..], "--csv"),
        (&["--csv", "-", "--edges", "-"][..], "stdout"),
        (&["--csv", "-", "--report", "-"][..], "stdout"),
    ] {
        let output = case.measure(more);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {}", said(&output));
        assert!(output.stdout.is_empty() && said(&output).contains(word), "{more:?}: {}", said(&output));
    }
}

#[test]
fn outputs_that_cannot_be_are_refused_before_anything_is_written() {
    let case = Case::new();
    let image = std::fs::read(case.path("frames/a.png")).unwrap();
    for option in ["--csv", "--report"] {
        let output = case.measure(&[option, "frames/a.png"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(
            said(&output).contains("frames/a.png") && said(&output).contains("input"),
            "{}",
            said(&output)
        );
        let output = case.measure(&[option, "/proc/nothing/of/that.csv"]);
        assert_eq!(output.status.code(), Some(3), "{}", said(&output));
        assert!(said(&output).contains("/proc/nothing/of/that.csv"), "{}", said(&output));
        // Diameters in mm need a scale.
        let output = case.run(&["frames", option, "x.out"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(option) && said(&output).contains("--um-per-px"), "{}", said(&output));
        let output = case.run(&["frames", "--um-per-px", "100", "--shape", "ring", option, "x.out"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains("--shape shaft"), "{}", said(&output));
    }
    assert_eq!(std::fs::read(case.path("frames/a.png")).unwrap(), image);
    assert_eq!(case.outputs(), Vec::<String>::new());
}

/// Where no frame can be measured, what was refused and why is what a reader looks for.
#[test]
fn a_report_of_refused_frames_alone_is_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("frames")).unwrap();
    let case = Case(folder);
    GrayImage::from_pixel(320, 200, Luma([255])).save(case.path("frames/white.png")).unwrap();
    std::fs::write(case.path("frames/torn.png"), "not an image").unwrap();
    let output = case.measure(&["--report", "r.html", "--csv", "d.csv", "--tolerance", "7..8"]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    let (html, rows) = (case.read("r.html"), rows(&case.read("d.csv")));
    assert_eq!(html.matches("<img").count(), 1, "the one that could be read");
    assert!(html.contains("Not proven") && html.contains("2, of which 2 refused"));
    let reasons: Vec<&str> = rows.iter().map(|row| &*row["refused"]).collect();
    assert_eq!(reasons, ["unreadable", "low_contrast"]);
}
