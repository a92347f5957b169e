//! Calibrates a camera on two master pins and then reads a part in millimetres, from images of your
//! own or, without arguments, from rendered ones.
//!
//!     cargo run --release --example calibrate_two_pins [PIN1.png MM PIN2.png MM PART.png]

use std::error::Error;

use shadowgauge::frame::{Frame, FrameMeta};
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings, MasterCertificate, MasterMeasurement};
use shadowgauge::render::settings::SetupSettings;
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::Shaft;

/// A frame of a cylinder in a simulated setup, whose true pixel size and blur the seed draws.
fn rendered(diameter_mm: f64) -> Result<Frame, Box<dyn Error>> {
    let mut settings = SetupSettings::default();
    (settings.camera.rows, settings.camera.columns) = (512, 512);
    settings.optics.magnification = 0.115;
    let scene = Scene::new(&OpticalSetup::resolve(&settings, 7)?, Shaft::cylinder(diameter_mm))?;
    let request = FrameRequest { noise: true, seed: diameter_mm.to_bits(), ..FrameRequest::default() };
    Ok(Renderer::new(BackendChoice::Cpu)?.render(&scene, &request, None)?)
}

/// A frame of an image file (PNG, TIFF, JPEG, BMP, PGM).
fn read(path: &str) -> Result<Frame, Box<dyn Error>> {
    let bytes = std::fs::read(path).map_err(|e| format!("{path}: {e}"))?;
    Ok(shadowgauge::source::decode(&bytes, None, FrameMeta::default()).map_err(|e| format!("{path}: {e}"))?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (pins, part) = match arguments.as_slice() {
        [] => ([(rendered(10.0)?, 10.0), (rendered(12.5)?, 12.5)], rendered(11.2)?),
        [one, d1, two, d2, part] => ([(read(one)?, d1.parse()?), (read(two)?, d2.parse()?)], read(part)?),
        _ => return Err("give no argument, or PIN1.png MM PIN2.png MM PART.png".into()),
    };

    // A master: its certificate, and the edges of the frames that show it (more than one is
    // better).
    let gauge = Gauge::new(GaugeSettings::default())?;
    let mut masters = Vec::new();
    for (frame, diameter_mm) in &pins {
        let certificate =
            MasterCertificate { diameter_mm: *diameter_mm, expanded_u_mm: 0.0002, coverage_factor: 2.0 };
        masters.push(MasterMeasurement { certificate, frames: vec![gauge.edges(&frame.view())?] });
    }

    // Two pins separate the scale from the constant that both edges add to every width.
    let calibration = Calibration::fit(&masters)?;
    let [var_scale, _, var_offset] = calibration.covariance;
    println!("scale        {:.5} µm/px, u {:.5}", calibration.scale_mm_per_px * 1e3, var_scale.sqrt() * 1e3);
    println!("edge offset  {:.2} µm, u {:.2}", calibration.offset_mm * 1e3, var_offset.sqrt() * 1e3);

    // The part: a diameter a column, their mean with its uncertainty, or the reason for a gap.
    let diameters = calibration.diameters(&gauge.edges(&part.view())?);
    let reading = diameters.mean(0..diameters.columns.len());
    let value = reading.value().ok_or_else(|| format!("no diameter: {reading:?}"))?;
    println!("part         {:.5} mm, u {:.5} mm (k = 1)", value.d_mm, value.u_mm());
    Ok(())
}
