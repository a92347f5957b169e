//! `render` and `doctor` from outside the binary.

#![expect(clippy::unwrap_used, reason = "a test that cannot set its scene up must fail")]

use std::path::Path;

use assert_cmd::Command;

fn shadowgauge() -> Command {
    Command::new(env!("CARGO_BIN_EXE_shadowgauge"))
}

/// A small job in `folder`: a thin part, few pixels, one field, two angles.
fn config(folder: &Path, extra: &str) -> std::path::PathBuf {
    let path = folder.join("job.toml");
    let text = format!("{extra}\n{}", include_str!("support/small_render_job.toml"));
    std::fs::write(&path, text).unwrap();
    path
}

fn run(arguments: &[&str], config: &Path, out: &Path) -> (i32, String) {
    let output = shadowgauge()
        .arg("render")
        .arg(config)
        .args(["--out", out.to_str().unwrap(), "--backend", "cpu"])
        .args(arguments)
        .output()
        .unwrap();
    (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn every_format_is_written_with_truth_and_pixel_size() {
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path(), "");
    for (format, extension) in [("png16", "png"), ("png8", "png"), ("tiff16", "tif"), ("f32", "tif")] {
        let out = folder.path().join(format);
        let (code, stderr) = run(&["--format", format], &config, &out);
        assert_eq!(code, 0, "{stderr}");
        let frame = out.join(format!("frames/000001.{extension}"));
        assert!(frame.exists() && out.join("previews/000001.png").exists());
        let frames = std::fs::read_to_string(out.join("frames.csv")).unwrap();
        assert!(frames.starts_with("frame,t_ns,z_mm,angle_deg,exposure_us,bit_depth,um_per_px\n"));
        let truth = std::fs::read_to_string(out.join("truth.csv")).unwrap();
        assert_eq!(truth.lines().count(), 1 + 2 * 120);
        if format == "png16" {
            let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(frame).unwrap()))
                .read_info()
                .unwrap();
            let size = reader.info().pixel_dims.unwrap();
            assert_eq!((size.xppu, size.unit), (66_667, png::Unit::Meter), "15 µm a pixel");
            assert_eq!(reader.info().bit_depth, png::BitDepth::Sixteen);
        }
    }
}

#[test]
fn same_config_gives_the_same_bytes_at_any_thread_count() {
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path(), "");
    let files: Vec<Vec<u8>> = ["1", "3"]
        .iter()
        .map(|threads| {
            let out = folder.path().join(threads);
            assert_eq!(run(&["--threads", threads], &config, &out).0, 0);
            std::fs::read(out.join("frames/000000.png")).unwrap()
        })
        .collect();
    assert_eq!(files[0], files[1]);
}

#[test]
fn what_cannot_be_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let good = config(folder.path(), "");
    let taken = folder.path().join("taken");
    std::fs::create_dir(&taken).unwrap();
    std::fs::write(taken.join("a"), "a").unwrap();
    let (code, stderr) = run(&[], &good, &taken);
    assert!(code == 2 && stderr.contains("not empty"), "{code} {stderr}");
    for (text, word) in [
        ("[optik]\n", "optik"),
        ("[optics]\nmagnification = 0.0\n", "magnification"),
        ("[optics]\nmagnification = 5.0\n", "field"),
        ("[contamination.dirt]\nper_cm2 = -3.0\n", "contamination.dirt.per_cm2"),
        ("[contamination.mist]\noptical_depth = -0.1\n", "optical_depth"),
        ("[contamination.chips]\nper_cm2 = 1e5\n[optics]\nmagnification = 1e-3\n", "contamination"),
        ("[light.field]\nvignetting_2 = 1.0\nsag = 1.0\n", "light.field"),
        ("[sensor]\npreset = \"no such camera\"\n", "sony_imx900"),
        ("[sensor]\nquantum_efficiency = 1.5\n", "quantum_efficiency"),
        ("[light]\nbright_photons = -5.0\n", "bright_photons"),
    ] {
        let path = folder.path().join("bad.toml");
        let mut job =
            include_str!("support/small_render_job.toml").replace("[optics]\nmagnification = 0.2\n", "");
        job.push_str(text);
        std::fs::write(&path, job).unwrap();
        let out = folder.path().join("refused");
        let (code, stderr) = run(&[], &path, &out);
        assert_eq!(code, 2, "{text}: {stderr}");
        assert!(stderr.contains(word), "{text}: {stderr}");
        assert!(!out.exists());
    }
    let left = std::fs::read_dir(folder.path())
        .unwrap()
        .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().contains("partial"));
    assert_eq!(left.count(), 0, "something half-written stays");
}

#[test]
fn bench_and_doctor_speak_json() {
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path(), "");
    let output = shadowgauge()
        .arg("render")
        .arg(&config)
        .args(["--bench", "3", "--json", "--backend", "cpu"])
        .output()
        .unwrap();
    let out = folder.path().join("frames");
    let ignored =
        shadowgauge().arg("render").arg(&config).args(["--bench", "3", "--out"]).arg(&out).output().unwrap();
    assert_eq!(ignored.status.code(), Some(2), "--bench writes nothing");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for key in [
        "ms_per_frame_min",
        "ms_per_frame_median",
        "floor_ms_median",
        "ratio",
        "backend",
        "adapter",
        "width",
        "height",
    ] {
        assert!(!report[key].is_null(), "{key} is missing");
    }
    let output = shadowgauge().args(["doctor", "--json"]).output().unwrap();
    assert!(output.status.success());
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["adapters"].is_array() && !report["auto"]["backend"].is_null());
}

/// A device that is lost after two frames: the run continues on the CPU twin with a notice, and the
/// frames are the same.
#[test]
fn a_device_lost_on_the_way_does_not_end_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path(), "");
    let out = folder.path().join("lost");
    let output = shadowgauge()
        .arg("render")
        .arg(&config)
        .args(["--out", out.to_str().unwrap(), "--frames", "4", "--backend", "vulkan"])
        .env("SHADOWGAUGE_LOSE_DEVICE_AFTER", "2")
        .output()
        .unwrap();
    let (stdout, stderr) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr).into_owned());
    if stderr.contains("no Vulkan adapter") {
        assert!(std::env::var("REQUIRE_VULKAN").as_deref() != Ok("1"), "{stderr}");
        println!("SKIPPED (no Vulkan adapter): {stderr}");
        return;
    }
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("goes on with the CPU twin"), "{stderr}");
    assert_eq!(stderr.matches("goes on with the CPU twin").count(), 1, "said more than once: {stderr}");
    assert!(stdout.contains("lost on the way"), "{stdout}");
    let twin = folder.path().join("twin");
    assert_eq!(run(&["--frames", "4"], &config, &twin).0, 0);
    for frame in ["000000", "000003"] {
        let read = |folder: &Path| std::fs::read(folder.join(format!("frames/{frame}.png"))).unwrap();
        assert_eq!(read(&out), read(&twin), "{frame}");
    }
}

/// Frames larger than the adapter's buffers are rendered by the CPU twin with a notice; no format
/// is refused, because images are plain words.
#[test]
fn a_frame_or_a_format_that_the_adapter_refuses_is_drawn_by_the_twin() {
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path(), "");
    for (limit, format) in [("20000", "png16"), ("none", "png8"), ("none", "tiff16"), ("none", "f32")] {
        let out = folder.path().join(format!("{limit}_{format}"));
        let mut command = shadowgauge();
        command.arg("render").arg(&config).args(["--out", out.to_str().unwrap(), "--frames", "2"]);
        command.args(["--backend", "vulkan", "--format", format]);
        if limit != "none" {
            command.env("SHADOWGAUGE_LARGEST_BUFFER", limit);
        }
        let output = command.output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        if stderr.contains("no Vulkan adapter") {
            assert!(std::env::var("REQUIRE_VULKAN").as_deref() != Ok("1"), "{stderr}");
            println!("SKIPPED (no Vulkan adapter): {stderr}");
            return;
        }
        assert_eq!(output.status.code(), Some(0), "{format}: {stderr}");
        let said = stderr.matches("are drawn by the CPU twin").count();
        assert_eq!(said, usize::from(limit != "none"), "{format}: {stderr}");
        assert!(said == 0 || stderr.contains("the adapter's largest has 20000"), "{stderr}");
        if limit != "none" {
            let twin = folder.path().join("twin");
            assert_eq!(run(&["--frames", "2", "--format", format], &config, &twin).0, 0);
            let read = |folder: &Path| std::fs::read(folder.join("frames/000001.png")).unwrap();
            assert_eq!(read(&out), read(&twin));
        }
    }
}

#[test]
fn contamination_writes_its_mask_and_presets_fill_in_a_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let extra = "[contamination.dirt]\nper_cm2 = 800.0\n[sensor]\npreset = \"sony_imx900\"\nprnu_rel = 0.0\n[light]\nbright_photons = 5000.0\nshadow_counts = 250.0\n[departures]\ngain_rel = 0.0\n";
    let path = folder.path().join("job.toml");
    std::fs::write(&path, format!("{}\n{extra}", include_str!("support/small_render_job.toml"))).unwrap();
    let out = folder.path().join("out");
    let (code, stderr) = run(&[], &path, &out);
    assert_eq!(code, 0, "{stderr}");
    let mask = image::open(out.join("masks/000000.png")).unwrap().into_luma8();
    assert!(
        mask.pixels().any(|p| p.0[0] == 32) && mask.pixels().all(|p| p.0[0] & !32 == 0),
        "dirt is bit 32"
    );
    // 5000 photons, QE 0.9125, 2.505 electrons per count over a black level of 240: 2061 counts,
    // slightly dimmed by blurred dirt.
    let frame = image::open(out.join("frames/000000.png")).unwrap().into_luma16();
    let mut first_row: Vec<u16> = (0..frame.width()).map(|x| frame.get_pixel(x, 0).0[0]).collect();
    first_row.sort_unstable();
    let median = f64::from(first_row[first_row.len() / 2]);
    assert!((1600.0..2100.0).contains(&median), "{median}");
}
