//! Optical setups, scenes and comparisons for the renderer's tests.

use shadowgauge::frame::{Frame, Pixels};
use shadowgauge::render::settings::{Esf, GaussianEsf, SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::{ProfileKnot, Shaft};

/// An optical setup with nominal optics of the given size and blur; 15 µm per pixel.
pub fn setup(rows: u32, columns: u32, sigma_px: f64) -> OpticalSetup {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    settings.camera.rows = rows;
    settings.camera.columns = columns;
    settings.camera.pixel_um = 3.0;
    settings.optics.magnification = 0.2;
    settings.optics.esf = Esf::Gaussian(GaussianEsf { sigma_px });
    OpticalSetup::resolve(&settings, 0).unwrap()
}

/// A cone whose upper edge crosses the central column at `row` and falls along z with slope tan β =
/// `slope`.
///
/// The field's centre is z = 0.
pub fn cone(setup: &OpticalSetup, row: f64, slope: f64) -> Shaft {
    let radius = (setup.centre_row() - row) * setup.pixel_mm;
    // Straight beyond the frame over the reach of any blur.
    let half = (setup.columns() + 40) as f64 * setup.pixel_mm;
    let mut shaft = Shaft::cylinder(2.0 * radius);
    shaft.profile = vec![
        ProfileKnot { z_mm: -half, radius_mm: radius + half * slope },
        ProfileKnot { z_mm: half, radius_mm: radius - half * slope },
    ];
    shaft
}

/// A device renderer, or `None` with a notice; an error where `REQUIRE_VULKAN=1`.
pub fn device() -> Option<Renderer> {
    match Renderer::new(BackendChoice::Vulkan) {
        // Strict: where the device fails, the twin must not be compared with itself.
        Ok(renderer) => Some(renderer.strict()),
        Err(e) => {
            assert!(
                std::env::var("REQUIRE_VULKAN").as_deref() != Ok("1"),
                "REQUIRE_VULKAN=1 and no adapter: {e}"
            );
            println!("SKIPPED (no Vulkan adapter): {e}");
            eprintln!("SKIPPED (no Vulkan adapter): {e}");
            None
        }
    }
}

/// Counts of a frame in f64.
pub fn counts(frame: &Frame) -> Vec<f64> {
    match frame.view().pixels() {
        Pixels::U8(p) => p.iter().map(|&v| f64::from(v)).collect(),
        Pixels::U16(p) => p.iter().map(|&v| f64::from(v)).collect(),
        Pixels::F32(p) => p.iter().map(|&v| f64::from(v)).collect(),
    }
}

/// Signed edge-equivalent shifts, px, of both halves of every column: ΣΔ over the half ÷ contrast.
pub fn shifts(test: &[f64], reference: &[f64], columns: usize, contrast: f64) -> Vec<[f64; 2]> {
    let rows = test.len() / columns;
    (0..columns)
        .map(|c| {
            let half = |rows: std::ops::Range<usize>| {
                rows.map(|r| test[r * columns + c] - reference[r * columns + c]).sum::<f64>() / contrast
            };
            [half(0..rows / 2), half(rows / 2..rows)]
        })
        .collect()
}

/// Largest magnitude of the shifts.
pub fn worst(shifts: &[[f64; 2]]) -> f64 {
    shifts.iter().flatten().fold(0.0, |w, s| f64::max(w, s.abs()))
}

/// Exact edges of a scene at fractional columns, for the reference.
pub fn exact(scene: &Scene, z_mm: f64, angle_deg: f64) -> impl Fn(f64) -> [f64; 2] + '_ {
    let turned = scene.outline().turned(angle_deg);
    move |column| {
        let e = scene.edges_at(&turned, z_mm, column);
        [e.top_px, e.bottom_px]
    }
}
