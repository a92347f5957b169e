//! Renders one frame of a lobed shaft on the CPU path, writes it as a PNG and prints where its
//! edges truly lie: an image for your own algorithm, with the answer beside it.
//!
//!     cargo run --release --example render_with_truth [OUT.png] [DIAMETER_MM]

use std::error::Error;
use std::path::PathBuf;

use shadowgauge::frame::{PixelFormat, Pixels};
use shadowgauge::render::settings::SetupSettings;
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::{Lobe, ProfileKnot, Shaft};
use shadowgauge::truth::true_edges;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let out =
        arguments.next().map_or_else(|| std::env::temp_dir().join("shadowgauge_frame.png"), PathBuf::from);
    let diameter_mm: f64 = arguments.next().map_or(Ok(8.0), |text| text.parse())?;

    // The optical setup: a small telecentric camera. Its seed draws how far the true optics depart
    // from the nominal ones, as a calibration would find them.
    let mut settings = SetupSettings::default();
    (settings.camera.rows, settings.camera.columns) = (400, 512);
    settings.optics.magnification = 0.115;
    let setup = OpticalSetup::resolve(&settings, 7)?;

    // The body: a cylinder to z = 0, then a taper, with three lobes of 4 µm; seen at 30°.
    let mut shaft = Shaft::cylinder(diameter_mm);
    shaft.profile.push(ProfileKnot { z_mm: 8.0, radius_mm: 0.5 * diameter_mm + 0.02 });
    shaft.lobes.push(Lobe { order_upr: 3, amplitude_mm: 0.004, phase_deg: 0.0 });
    let scene = Scene::new(&setup, shaft)?;
    let request = FrameRequest {
        angle_deg: 30.0,
        noise: true,
        seed: 1,
        format: Some(PixelFormat::Mono8),
        ..FrameRequest::default()
    };

    let frame = Renderer::new(BackendChoice::Cpu)?.render(&scene, &request, None)?;
    let view = frame.view();
    let Pixels::U8(pixels) = view.pixels() else { return Err("8 bits were asked for".into()) };
    let (columns, rows) = (view.columns() as u32, view.rows() as u32);
    image::save_buffer(&out, pixels, columns, rows, image::ExtendedColorType::L8)?;
    println!("{}: {columns} x {rows} px, 8 bits", out.display());

    // The truth: rows of both edges in every column, by geometry alone.
    println!("true pixel size {:.5} µm", setup.pixel_mm * 1e3);
    println!("column  top/px      bottom/px   true width/mm");
    for (column, edge) in true_edges(&scene, &request)?.iter().enumerate().step_by(64) {
        let width_mm = (edge.bottom_px - edge.top_px) * setup.pixel_mm;
        println!("{column:6}  {:10.5}  {:10.5}  {width_mm:.6}", edge.top_px, edge.bottom_px);
    }
    Ok(())
}
