//! A stream's diameters as they come: a strip chart that runs down the terminal, a line a frame,
//! with the limits of the tolerance. Redirected into a file it stays readable, in ASCII.
//!
//!     cargo run --release --example live_plot [FRAMES] [LOWER_MM UPPER_MM]

use std::error::Error;
use std::io::IsTerminal as _;

use shadowgauge::frame::{Frame, FrameSource, SourceError};
use shadowgauge::gauge::{Calibration, FrameEdges, Gauge, GaugeSettings};
use shadowgauge::render::settings::{SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::Shaft;

/// A tool that wears: every part is 0.7 µm thicker than the last one.
struct Simulated(Renderer, OpticalSetup, u64);

impl FrameSource for Simulated {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let Self(renderer, setup, part) = self;
        let request = FrameRequest { frame_id: *part, noise: true, ..FrameRequest::default() };
        let scene = Scene::new(setup, Shaft::cylinder(11.997 + 0.0007 * *part as f64));
        *part += 1;
        let frame = scene.and_then(|scene| renderer.render(&scene, &request, None));
        frame.map(Some).map_err(|e| SourceError { what: e.to_string(), cause: None })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, or: f64| arguments.get(i).map_or(Ok(or), |text| text.parse());
    let (frames, lower, upper) = (number(0, 20.0)? as usize, number(1, 11.995)?, number(2, 12.005)?);

    // Any other source of frames may stand here: a folder's `source::FileFrames`, your camera.
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..SetupSettings::default() };
    (settings.camera.rows, settings.camera.columns) = (480, 256);
    settings.optics.magnification = 0.115;
    let setup = OpticalSetup::resolve(&settings, 7)?;
    let calibration = Calibration::from_scale(setup.pixel_mm * 1e3);
    let mut source = Simulated(Renderer::new(BackendChoice::Cpu)?, setup, 0);

    // A stream keeps tables and buffers from frame to frame.
    let (mut stream, mut edges) = (Gauge::new(GaugeSettings::default())?.stream(), FrameEdges::default());
    let (limit, point) = if std::io::stdout().is_terminal() { ('│', '●') } else { ('|', '*') };
    // The limits stand a quarter of the chart from its ends; what lies beyond stays at an end.
    let place =
        |d: f64| (48.0 * (0.25 + 0.5 * (d - lower) / (upper - lower)).clamp(0.0, 1.0)).round() as usize;
    for number in 0..frames {
        let Some(frame) = source.next_frame()? else { break };
        stream.measure(&frame.view(), &mut edges)?;
        let diameters = calibration.diameters(&edges);
        let mean = diameters.mean(0..diameters.columns.len());
        let d = mean.value().ok_or_else(|| format!("frame {number}: {mean:?}"))?;
        let mut chart = [' '; 49];
        (chart[place(lower)], chart[place(upper)], chart[place(d.d_mm)]) = (limit, limit, point);
        let verdict = if (lower..=upper).contains(&d.d_mm) { "" } else { "  out" };
        println!("{number:5}  {:.4} mm  {}{verdict}", d.d_mm, chart.iter().collect::<String>());
    }
    Ok(())
}
