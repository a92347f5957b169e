//! Golden frames of bent, turning shafts: one with noise, compared to ± 1 count and by the gauge's
//! reading; one of 2448 columns whose truth is diameters rather than pixels. The third, without
//! noise, is `golden/bent_turning`.
//!
//! `BLESS=<case>|all` writes them anew and ends red; it is refused where `CI` is set.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};

use shadowgauge::frame::{Frame, PixelFormat, Pixels};
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, Renderer, Scene};
use shadowgauge::studies::golden_cases::GoldenCase;

/// Columns per mean diameter in the truth.
const STEP: usize = 16;

#[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
struct Diameters {
    /// Mean width of every 16 columns, px.
    width_px: Vec<f64>,
}

struct Case {
    name: &'static str,
    folder: PathBuf,
    scene: Scene,
    request: FrameRequest,
}

impl Case {
    fn load(name: &'static str, format: PixelFormat, noise: bool) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden_deflected").join(name);
        let case: GoldenCase =
            toml::from_str(&std::fs::read_to_string(folder.join("case.toml")).unwrap()).unwrap();
        let scene = case.scene().unwrap();
        let request = FrameRequest { format: Some(format), noise, seed: case.seed, ..case.request() };
        Self { name, folder, scene, request }
    }

    fn draw(&self) -> Frame {
        Renderer::new(BackendChoice::Cpu).unwrap().render(&self.scene, &self.request, None).unwrap()
    }

    fn widths_px(&self) -> Vec<f64> {
        let edges = shadowgauge::truth::true_edges(&self.scene, &self.request).unwrap();
        means(&edges.iter().map(|e| Some(e.bottom_px - e.top_px)).collect::<Vec<_>>())
    }

    fn truth(&self) -> Diameters {
        let path = self.folder.join("truth.json");
        let text = std::fs::read_to_string(path).unwrap_or_else(|_| panic!("{}: bless it", self.name));
        serde_json::from_str(&text).unwrap()
    }

    /// Writes the cases named by `BLESS`.
    fn bless(&self, frame: Option<&[u8]>, size: (usize, usize)) {
        let Ok(wanted) = std::env::var("BLESS") else { return };
        assert!(std::env::var_os("CI").is_none(), "BLESS is refused where CI is set");
        if wanted != "all" && wanted != self.name {
            return;
        }
        if let Some(pixels) = frame {
            let grey: image::GrayImage =
                image::ImageBuffer::from_raw(size.1 as u32, size.0 as u32, pixels.to_vec()).unwrap();
            grey.save(self.folder.join("frame.png")).unwrap();
        }
        let truth = Diameters { width_px: self.widths_px() };
        std::fs::write(self.folder.join("truth.json"), serde_json::to_string(&truth).unwrap()).unwrap();
        panic!("{}: blessed; run again without BLESS", self.name);
    }

    /// The gauge's widths, by groups of columns.
    fn read(&self, frame: &Frame) -> (Vec<f64>, FrameEdges) {
        let gauge = Gauge::new(GaugeSettings::default()).unwrap();
        let edges = gauge.edges(&frame.view()).unwrap_or_else(|e| panic!("{}: {e}", self.name));
        let width = |(t, b): (&shadowgauge::gauge::Edge, &shadowgauge::gauge::Edge)| {
            (t.is_usable() && b.is_usable()).then_some(b.row_px - t.row_px)
        };
        (means(&edges.top.iter().zip(&edges.bottom).map(width).collect::<Vec<_>>()), edges)
    }
}

/// Means of 16 columns each; NaN where no width is available.
fn means(widths: &[Option<f64>]) -> Vec<f64> {
    let mean = |group: &[Option<f64>]| {
        let known: Vec<f64> = group.iter().flatten().copied().collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    widths.chunks(STEP).map(mean).collect()
}

fn largest_apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).filter(|d| d.is_finite()).fold(0.0, f64::max)
}

#[test]
fn a_noisy_frame_of_a_bent_turning_shaft() {
    let case = Case::load("noisy_turn", PixelFormat::Mono8, true);
    let frame = case.draw();
    let view = frame.view();
    let Pixels::U8(pixels) = view.pixels() else { panic!("not 8 bit") };
    case.bless(Some(pixels), (view.rows(), view.columns()));
    let golden = image::open(case.folder.join("frame.png")).unwrap().to_luma8();
    let worst = pixels.iter().zip(golden.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst.is_some_and(|w| w <= 1) && pixels.len() == golden.as_raw().len(), "{worst:?} counts");
    assert!(largest_apart(&case.widths_px(), &case.truth().width_px) < 1e-6);
    // 8-bit noise of about 0.75 counts with a contrast of about 190: 0.006 px for one edge, 0.002
    // px for a mean of 16 columns and two edges.
    let (read, edges) = case.read(&frame);
    let u_px =
        edges.top.iter().filter(|e| e.is_usable()).map(shadowgauge::gauge::Edge::u_px).fold(0.0, f64::max);
    let limit = 5.0 * u_px * (2.0 / STEP as f64).sqrt();
    let apart = largest_apart(&read, &case.truth().width_px);
    println!("worst of 16 columns {apart:.4} px, limit {limit:.4} px");
    assert!(apart < limit, "{apart} px against {limit} px");
    assert!(read.iter().filter(|w| w.is_finite()).count() >= read.len() - 1);
}

#[test]
fn diameters_of_a_whole_line_of_a_bent_turning_shaft() {
    let case = Case::load("long_field", PixelFormat::Mono16, false);
    case.bless(None, (0, 0));
    let truth = case.truth();
    assert_eq!(truth.width_px.len(), 153);
    assert!(largest_apart(&case.widths_px(), &truth.width_px) < 1e-6);
    // The width varies by even lobes and the slope of the bow.
    let (low, high) = truth.width_px.iter().fold((f64::MAX, 0.0_f64), |(l, h), w| (l.min(*w), h.max(*w)));
    assert!(high > low, "{low} {high}");
    let (read, _) = case.read(&case.draw());
    let apart = largest_apart(&read, &truth.width_px);
    println!("worst of 16 columns {apart:.5} px");
    assert!(apart < 2e-3, "{apart} px");
    // The gauge's window does not fit the outermost columns.
    assert!(read.iter().filter(|w| w.is_finite()).count() >= read.len() - 4);
}
