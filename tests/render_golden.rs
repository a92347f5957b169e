//! Golden frames: blessed by the f64 reference alone, held against the CPU twin; the device against a fresh CPU frame.
//!
//! `BLESS=<case>|all` writes them anew, prints old and new metrics and ends red; it is refused where `CI` is set.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/render_golden.rs"]
mod golden;
#[path = "support/render.rs"]
#[expect(dead_code, reason = "shared with the other tests of the renderer")]
mod support;

use golden::*;
use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::{Gauge, GaugeSettings};
use shadowgauge::render::{BackendChoice, Renderer};

fn twin() -> Renderer {
    Renderer::new(BackendChoice::Cpu).unwrap()
}

/// Blesses what `BLESS` names; `true` if anything was.
fn blessed(cases: &[GoldenScene]) -> bool {
    let Ok(wanted) = std::env::var("BLESS") else { return false };
    assert!(std::env::var_os("CI").is_none(), "BLESS is refused where CI is set");
    let chosen: Vec<_> = cases.iter().filter(|c| wanted == "all" || wanted == c.name).collect();
    assert!(!chosen.is_empty(), "BLESS={wanted}: no such case");
    for case in chosen {
        let fresh = CpuFrame(case.draw(&twin()));
        let old = case.golden().map(|(g, _)| compare(&fresh, &g, case));
        case.bless();
        let new = case.golden().map(|(g, _)| compare(&fresh, &g, case));
        println!("{}:\n  old {old:?}\n  new {new:?}", case.name);
    }
    true
}

#[test]
fn twin_meets_the_golden_frames() {
    let cases = cases();
    assert!((10..=13).contains(&cases.len()), "{} cases, not 10 to 13", cases.len());
    assert!(!blessed(&cases), "blessed: look at the metrics above, then run again without BLESS");
    for case in &cases {
        let Some((golden, truth)) = case.golden() else {
            panic!("{}: frame.png or truth.json is missing; bless it", case.name)
        };
        for (name, now, then) in
            [("top", &case.truth.top_px, &truth.top_px), ("bottom", &case.truth.bottom_px, &truth.bottom_px)]
        {
            assert_eq!(now.len(), then.len(), "{}", case.name);
            let worst = now.iter().zip(then).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-6, "{}: true {name} edges moved by {worst} px", case.name);
        }
        let metrics = compare(&CpuFrame(case.draw(&twin())), &golden, case);
        println!("{}: {metrics:?}", case.name);
        assert!(metrics.is_ok(), "{}: {metrics:?}", case.name);
    }
}

#[test]
fn device_meets_fresh_cpu_frames() {
    let Some(device) = support::device() else { return };
    for case in cases() {
        let metrics = compare(&GpuFrame(case.draw(&device)), &CpuFrame(case.draw(&twin())), &case);
        assert!(metrics.is_ok(), "{}: {metrics:?}", case.name);
    }
}

#[test]
fn light_of_a_golden_frame_adds_up_to_the_true_edges() {
    // The light above a shadow adds up to the edge's height, whatever the blur: edge + 1/2 = Σ light.
    for case in cases() {
        if case.name == "soft_thin_wire" || !case.is_plain() {
            continue; // light from both sides meets in it, or is not even
        }
        let Some((GoldenFrame(shot), truth)) = case.golden() else { panic!("{}", case.name) };
        let shadow = case.scene.levels(shadowgauge::frame::PixelFormat::Mono16).shadow;
        let mean: f64 = (0..shot.columns)
            .map(|c| {
                let middle = ((truth.top_px[c] + truth.bottom_px[c]) / 2.0).round() as usize;
                let light =
                    |r: usize| (f64::from(shot.pixels[r * shot.columns + c]) - shadow) / case.contrast;
                (0..middle).map(light).sum::<f64>() - 0.5 - truth.top_px[c]
            })
            .sum::<f64>()
            / shot.columns as f64;
        // Half a count of rounding in each of some 50 rows, and a rough edge seen through the blur.
        assert!(mean.abs() < 5e-4, "{}: {mean} px", case.name);
    }
}

#[test]
fn comparator_catches_a_shift_of_two_thousandths_in_every_case() {
    for case in cases() {
        let judge = GoldenFrame(case.quantised(0.0));
        for shift in [0.002, -0.002] {
            let result = compare(&CpuFrame(case.quantised(shift)), &judge, &case);
            assert!(
                matches!(result, Err(Mismatch::Counts(_) | Mismatch::Shift(_))),
                "{}: {result:?}",
                case.name
            );
        }
        assert!(compare(&CpuFrame(case.quantised(0.0002)), &judge, &case).is_ok(), "{}", case.name);
    }
}

#[test]
fn comparator_catches_a_bad_pixel_a_wrong_size_and_the_same_input() {
    let cases = cases();
    let case = &cases[0];
    let shot = case.quantised(0.0);
    let limit =
        compare(&CpuFrame(case.quantised(0.0)), &GoldenFrame(shot.clone()), case).unwrap().limit_counts;
    let bad = shot.spoiled(|p| p[17] -= limit as u16 + 2);
    assert!(matches!(
        compare(&CpuFrame(bad), &GoldenFrame(shot.clone()), case),
        Err(Mismatch::Counts(_) | Mismatch::Shift(_))
    ));
    let short = Shot::new(shot.rows - 1, shot.columns, shot.pixels[shot.columns..].to_vec());
    assert_eq!(compare(&CpuFrame(short), &GoldenFrame(shot.clone()), case), Err(Mismatch::Size));
    assert_eq!(compare(&CpuFrame(shot.clone()), &GoldenFrame(shot.clone()), case), Err(Mismatch::SameInput));
    assert_eq!(compare(&GpuFrame(shot.clone()), &CpuFrame(shot), case), Err(Mismatch::SameInput));
}

/// The program carries every case, so that an adapter can be checked where it alone is at hand.
#[test]
fn program_carries_every_case() {
    let carried: Vec<&str> =
        shadowgauge::studies::golden_cases::CASES.iter().map(|(name, _)| *name).collect();
    let files: Vec<String> = cases().into_iter().map(|case| case.name).collect();
    assert_eq!(carried, files);
}

#[test]
fn golden_files_are_small() {
    for case in cases() {
        for file in ["case.toml", "frame.png", "truth.json"] {
            let size = std::fs::metadata(case.folder.join(file)).map_or(0, |m| m.len());
            assert!(size <= 64 * 1024, "{}/{file}: {size} bytes", case.name);
        }
    }
}

/// The third judge of a golden frame: what the gauge, which knows nothing of the scene, reads in it.
#[test]
fn gauge_reads_the_true_edges_in_the_golden_frames() {
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let mut measured = 0;
    for case in cases().into_iter().filter(GoldenScene::is_plain) {
        let (GoldenFrame(shot), truth) = case.golden().unwrap_or_else(|| panic!("{}: no golden", case.name));
        let view = FrameView::new(
            Pixels::U16(&shot.pixels),
            PixelFormat::Mono16,
            shot.rows,
            shot.columns,
            shot.columns,
        )
        .unwrap();
        let edges = match gauge.edges(&view) {
            Ok(edges) => edges,
            Err(refused) => {
                println!("{}: refused: {refused}", case.name);
                continue;
            }
        };
        for (line, truth) in [(&edges.top, &truth.top_px), (&edges.bottom, &truth.bottom_px)] {
            let errors: Vec<f64> =
                line.iter().zip(truth).filter(|(e, _)| e.is_usable()).map(|(e, t)| e.row_px - t).collect();
            let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
            println!("{}: {} of {} columns, mean error {mean:.2e} px", case.name, errors.len(), truth.len());
            assert!(errors.is_empty() || mean.abs() <= SHIFT_LIMIT_PX, "{}: {mean} px", case.name);
            measured += usize::from(!errors.is_empty());
        }
    }
    // The other cases' frames are smaller than the gauge's own margins; they are refused, never guessed.
    assert!(measured >= 4, "only {measured} edges of the golden frames could be measured");
}
