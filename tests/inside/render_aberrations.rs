//! Frames through a lens with coma and a curved surface of focus, pixel by pixel against the
//! integral over the two-dimensional pupil and source.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::optics_aberrations::{Lens, judge};
use crate::inside::support::render as support;

use shadowgauge::frame::PixelFormat;
use shadowgauge::render::esf_families::PartiallyCoherentEdge;
use shadowgauge::render::lens::{FieldAberrations, FieldCurvature};
use shadowgauge::render::settings::{Esf, SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene, geometric_edges};
use shadowgauge::shaft::Shaft;
use support::counts;

const ROWS: u32 = 600;
const COLUMNS: u32 = 400;
const COMA_NM: f64 = 70.0;
const SAG_MM: f64 = 0.5;

fn settings() -> SetupSettings {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    (settings.camera.rows, settings.camera.columns) = (ROWS, COLUMNS);
    settings.optics.esf =
        Esf::PartiallyCoherent(PartiallyCoherentEdge { reach: 8.0, ..PartiallyCoherentEdge::default() });
    settings.optics.field_curvature = Some(FieldCurvature { sag_mm: SAG_MM, ..Default::default() });
    settings.optics.aberrations =
        vec![FieldAberrations { field: 1.0, coma_nm: COMA_NM, ..FieldAberrations::default() }];
    settings
}

/// Nodes and weights over a pixel's height (Gauss, five points).
const OVER_PIXEL: [(f64, f64); 5] = [
    (-0.453_089_922_969_332, 0.118_463_442_528_094_5),
    (-0.269_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.0, 0.284_444_444_444_444_4),
    (0.269_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.453_089_922_969_332, 0.118_463_442_528_094_5),
];

#[test]
fn coma_and_field_curvature_meet_the_integral_at_their_places() {
    let settings = settings();
    let setup = OpticalSetup::resolve(&settings, 0).unwrap();
    let scene = Scene::new(&setup, Shaft::cylinder(0.8 * f64::from(ROWS) * setup.pixel_mm)).unwrap();
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let frame = counts(&Renderer::new(BackendChoice::Cpu).unwrap().render(&scene, &request, None).unwrap());
    let edges = geometric_edges(&scene, &request).unwrap();
    let half = 0.5 * f64::from(ROWS).hypot(f64::from(COLUMNS));
    // λ/NA is 26.25 µm.
    let unit_px = 26.25e-3 / setup.pixel_mm;
    let (light, mut worst, mut coma) = (&settings.light, 0.0_f64, 0.0_f64);
    for (column, upper) in [(200_usize, true), (20, false)] {
        let edge = if upper { edges[column].top_px } else { edges[column].bottom_px };
        let sign = if upper { -1.0 } else { 1.0 };
        let out = sign * (edge - 299.5) / half;
        let along = (column as f64 - 199.5) / half;
        let height = out.hypot(along);
        let lens = Lens {
            coma: COMA_NM / 525.0 * height,
            psi: along.atan2(out),
            // The surface of focus lies in front of the edge.
            focus: SAG_MM * height * height * 1e3 * 0.02 / 26.25,
            ..Lens::default()
        };
        for row in (edge.round() as i32 - 3)..=(edge.round() as i32 + 3) {
            let over = |lens: &Lens| -> f64 {
                let at =
                    |(y, w): &(f64, f64)| w * judge(0.5, lens, sign * (f64::from(row) + y - edge) / unit_px);
                OVER_PIXEL.iter().map(at).sum()
            };
            let seen = frame[row as usize * COLUMNS as usize + column] - light.shadow_counts;
            let seen = seen / (light.bright_counts - light.shadow_counts);
            let wanted = over(&lens);
            worst = worst.max((seen - wanted).abs());
            coma = coma.max((over(&Lens { coma: 0.0, ..lens }) - wanted).abs());
        }
    }
    println!("{worst:.1e} of full light from the integral; coma moves {coma:.1e}");
    assert!(worst < 5e-4, "{worst}");
    assert!(coma > 2e-2, "{coma}");
}
