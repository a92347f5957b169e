//! Frames in files whose `frames.csv` has encoder counts and stops.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};

use image::{GrayImage, Luma};
use shadowgauge::plan::ScanPlan;
use shadowgauge::position::{EncoderSettings, LatchedAt};
use shadowgauge::source::{FileFrames, RecordedScan, Recording};

/// 600/min, 32 frames a turn, 4096 counts, latched at the end of exposures of 2 ms.
const FRAMES: u64 = 32;
const PERIOD_NS: u64 = 3_125_000;

fn settings() -> EncoderSettings {
    EncoderSettings {
        latched_at: LatchedAt::ExposureEnd,
        frames_per_turn: Some(FRAMES as u32),
        ..EncoderSettings::new(4096)
    }
}

/// Two turns of frames, but for the triggers that were ignored.
fn written(folder: &Path, ignored: &[u64], header: &str) -> Vec<PathBuf> {
    let mut table = format!("{header}\n");
    let mut paths = Vec::new();
    for i in (0..2 * FRAMES).filter(|i| !ignored.contains(i)) {
        let path = folder.join(format!("{i:06}.png"));
        GrayImage::from_pixel(4, 4, Luma([100])).save(&path).unwrap();
        // 128 counts a frame, and .4 of that in 2 ms of 3.125: 82 from start to end
        let count = 128 * i + 82;
        table += &format!("{i},{},0,2000,{count},{}\n", i * PERIOD_NS, count / 4096 * 4096);
        paths.push(path);
    }
    std::fs::write(folder.join("frames.csv"), table).unwrap();
    paths
}

const HEADER: &str = "frame,t_ns,z_mm,exposure_us,encoder_count,index";

/// Angles of the frames, or why they have none.
fn angles(paths: Vec<PathBuf>, encoder: Option<EncoderSettings>) -> Vec<Result<f64, String>> {
    let mut frames = FileFrames::new(paths).by_encoder(encoder);
    std::iter::from_fn(|| frames.next_stored())
        .map(|read| read.map(|stored| stored.frame.meta.angle_deg).map_err(|e| e.to_string()))
        .collect()
}

#[test]
fn counts_become_angles_at_mid_exposure_and_a_lost_trigger_voids_its_turn() {
    let folder = tempfile::tempdir().unwrap();
    let found = angles(written(folder.path(), &[], HEADER), Some(settings()));
    assert_eq!(found.len(), 64);
    for (i, angle) in found.iter().enumerate() {
        // the middle of the exposure is half the sweep of 7.2° after its start
        let due = (11.25 * i as f64 + 3.6) % 360.0;
        assert!((angle.as_ref().unwrap() - due).abs() < 0.1, "{i}: {angle:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let lost = angles(written(folder.path(), &[10], HEADER), Some(settings()));
    let (first, second) = lost.split_at(31);
    for void in first {
        let why = void.as_ref().unwrap_err();
        assert!(why.contains("turn 1 is void") && why.contains("ignored"), "{why}");
    }
    assert!((second[0].as_ref().unwrap() - 3.6).abs() < 0.1, "{:?}", second[0]);
    // an encoder that counts the other way is named with its row
    let falling =
        EncoderSettings { direction: shadowgauge::position::EncoderDirection::Falling, ..settings() };
    let folder = tempfile::tempdir().unwrap();
    let back = angles(written(folder.path(), &[], HEADER), Some(falling));
    let why = back[0].as_ref().unwrap_err();
    assert!(why.contains("row 3") && why.contains("counts backwards"), "{why}");
}

#[test]
fn counts_without_an_encoder_and_an_encoder_without_counts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let paths = written(folder.path(), &[], HEADER);
    let why = angles(paths, None).remove(0).unwrap_err();
    assert!(why.contains("encoder_count without angle_deg") && why.contains("--counts-per-turn"), "{why}");
    let folder = tempfile::tempdir().unwrap();
    let paths = written(folder.path(), &[], "frame,t_ns,angle_deg,exposure_us,count,other");
    let why = angles(paths, Some(settings())).remove(0).unwrap_err();
    assert!(why.contains("no column `encoder_count`"), "{why}");
}

#[test]
fn a_recorded_scan_pairs_its_stops_with_its_frames() {
    let plan = ScanPlan { field_z_mm: vec![1.0, 2.0], angle_deg: vec![0.0, 60.0, 120.0] };
    let of = |stops: &[u32]| {
        let folder = tempfile::tempdir().unwrap();
        let pass = folder.path().join("pass_1");
        std::fs::create_dir(&pass).unwrap();
        let mut table = "frame,z_mm,angle_deg,stop\n".to_owned();
        for (i, stop) in stops.iter().enumerate() {
            GrayImage::from_pixel(4, 4, Luma([100])).save(pass.join(format!("{i}.png"))).unwrap();
            table += &format!("{i},1,0,{stop}\n");
        }
        std::fs::write(pass.join("frames.csv"), table).unwrap();
        let recording = Recording::open(&folder.path().display().to_string(), Path::new("/")).unwrap();
        let images = recording.images(RecordedScan::Pass(1)).unwrap();
        recording.frames(images, &plan).map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(of(&[1, 2, 3, 4, 5, 6]), Ok(()));
    let why = of(&[1, 2, 3, 3, 5, 6]).unwrap_err();
    assert!(why.contains("frames.csv") && why.contains("stop 3 has 2 frames"), "{why}");
}
