//! Invalid input from outside the binary, and files named in a config.

use std::path::Path;

use std::process::Output;

use crate::inside::render_shaft::program::{shadowgauge, text};

const JOB: &str = include_str!("../../support/small_render_job.toml");

/// One frame of a config, on the CPU.
fn drawn(config: &Path, out: &Path) -> Output {
    let files = ["render".as_ref(), config.as_os_str(), "--out".as_ref(), out.as_os_str()];
    shadowgauge(files.into_iter().chain(["--backend=cpu", "--frames=1"].map(AsRef::as_ref)))
}

fn render(folder: &Path, extra: &str) -> (i32, String) {
    let path = folder.join("job.toml");
    std::fs::write(&path, format!("{JOB}\n{extra}\n")).unwrap();
    let out = folder.join("out");
    let _ = std::fs::remove_dir_all(&out);
    let output = drawn(&path, &out);
    assert!(output.status.success() == out.exists(), "a refused job leaves nothing");
    (output.status.code().unwrap(), text(&output.stderr))
}

#[test]
fn what_cannot_be_is_refused_with_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let samples = |edit: fn(i32) -> f64| (-5..=5).map(|i| format!("{i},{}\n", edit(i))).collect::<String>();
    std::fs::write(
        folder.path().join("falls.csv"),
        samples(|i| if i == 2 { 0.3 } else { f64::from(i + 5) / 10.0 }),
    )
    .unwrap();
    std::fs::write(folder.path().join("dim.csv"), samples(|i| 0.9 * f64::from(i + 5) / 10.0)).unwrap();
    std::fs::write(folder.path().join("back.csv"), "0,1\n1,1\n0.5,0.9\n").unwrap();
    let cases = [
        ("[optics.esf.measured]\nfile = \"falls.csv\"", "monotone = false"),
        ("[optics.esf.measured]\nfile = \"dim.csv\"", "normalised"),
        ("[optics.esf.measured]\nfile = \"nowhere.csv\"", "cannot be read"),
        ("[motion]\nspindle_rpm = 2.0e6", "motion.spindle_rpm"),
        ("[shaft]\ncontour_file = \"back.csv\"", "intersect"),
        (
            "[shaft]\ncontour = [{ z_mm = 0.0, diameter_mm = 1.0 }, { z_mm = 0.75, diameter_mm = 3.0 }, { z_mm = 2.0, diameter_mm = 3.0 }]",
            "field",
        ),
        (
            "[shaft]\nthreads = [{ from_mm = 0.0, to_mm = 1.0, pitch_mm = 0.1, depth_mm = 0.5 }]",
            "flanks intersect",
        ),
        ("[shaft]\nflats = [{ from_mm = 0.0, to_mm = 1.0, distance_mm = -0.1 }]", "flat"),
        (
            "[shaft.texture]\nspectrum = { power_law = { exponent = 2.0, longest_mm = 1.0, shortest_mm = 2.0 } }",
            "shortest_mm",
        ),
        ("[optics.entocentric]\ndistance_mm = 1.2", "optics.entocentric.distance_mm"),
        ("[optics.distortion]\nk1 = -0.45", "optics.distortion"),
    ];
    for (extra, word) in cases {
        // The job has an [optics] table of its own: subtables may follow it.
        let (code, stderr) = render(folder.path(), extra);
        assert_eq!(code, 2, "{extra}: {stderr}");
        assert!(
            stderr.split_whitespace().collect::<String>().contains(&word.replace(' ', "")),
            "{extra}: {stderr}"
        );
    }
}

#[test]
fn an_exposure_longer_than_a_turn_needs_consent() {
    let folder = tempfile::tempdir().unwrap();
    let job = |consent: &str| format!("[motion]\nspindle_rpm = 9.0e5\n{consent}");
    let long = JOB.replace("[camera]\n", "[camera]\nexposure_us = 100.0\n");
    for (consent, wanted) in [("", 2), ("allow_more_than_a_turn = true", 0)] {
        let path = folder.path().join("long.toml");
        std::fs::write(&path, format!("{long}\n{}\n", job(consent))).unwrap();
        let out = folder.path().join(format!("out{wanted}"));
        let output = drawn(&path, &out);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(wanted), "{stderr}");
        assert!(wanted == 0 || stderr.contains("allow_more_than_a_turn"), "{stderr}");
    }
}

#[test]
fn files_beside_the_config_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let samples: String =
        (-10..=10).map(|i| format!("{},{}\n", 6 * i, 0.5 * libm::erfc(-f64::from(i) / 4.0))).collect();
    std::fs::write(folder.path().join("edge.csv"), samples).unwrap();
    std::fs::write(folder.path().join("part.csv"), "z_mm,diameter_mm\n0,1.0\n0.75,1.0\n0.75,0.8\n2,0.8\n")
        .unwrap();
    let extra = "[optics.esf.measured]\nfile = \"edge.csv\"\n[shaft]\ncontour_file = \"part.csv\"";
    let (code, stderr) = render(folder.path(), extra);
    assert_eq!(code, 0, "{stderr}");
    let truth = std::fs::read_to_string(folder.path().join("out/truth.csv")).unwrap();
    let width = |column: usize| {
        let line = truth.lines().nth(1 + column).unwrap();
        let n: Vec<f64> = line.split(',').skip(2).map(|v| v.parse().unwrap()).collect();
        (n[1] - n[0]) * 0.015
    };
    assert!(
        (width(10) - 1.0).abs() < 2e-3 && (width(110) - 0.8).abs() < 2e-3,
        "{} {}",
        width(10),
        width(110)
    );
}

#[test]
fn a_run_refuses_a_finished_part() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.toml");
    std::fs::write(
        &path,
        format!("{JOB}\n[shaft]\nflats = [{{ from_mm = 0.0, to_mm = 1.0, distance_mm = 0.4 }}]\n"),
    )
    .unwrap();
    let out = folder.path().join("run");
    let output = shadowgauge([
        "run".as_ref(),
        path.as_os_str(),
        "--backend=cpu".as_ref(),
        "--out".as_ref(),
        out.as_os_str(),
    ]);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("shaft.flats"), "{stderr}");
}
