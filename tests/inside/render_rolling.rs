//! Rolling shutters: each edge where it stands at the time of its own row.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::f64::consts::TAU;

use crate::inside::support::render as support;

use shadowgauge::frame::{PixelFormat, Roi};
use shadowgauge::render::motion::{Strobe, Vibration};
use shadowgauge::render::settings::{SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene, geometric_edges};
use shadowgauge::shaft::{Eccentricity, Shaft};
use support::counts;

const LINE_US: f64 = 20.0;

fn settings() -> SetupSettings {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    (settings.camera.rows, settings.camera.columns) = (600, 64);
    settings.camera.exposure_us = 1.0;
    settings.camera.line_time_us = LINE_US;
    settings
}

fn scene(settings: &SetupSettings, shaft: Shaft) -> Scene {
    Scene::new(&OpticalSetup::resolve(settings, 5).unwrap(), shaft).unwrap()
}

fn vibrating() -> SetupSettings {
    let mut settings = settings();
    settings.motion.vibration = vec![Vibration { amplitude_um: 40.0, frequency_hz: 120.0, phase_deg: 35.0 }];
    settings
}

#[test]
fn a_part_at_rest_looks_as_through_a_global_shutter() {
    let request = FrameRequest { noise: true, seed: 3, ..Default::default() };
    let shot = |settings: &SetupSettings| {
        let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
        counts(&renderer.render(&scene(settings, Shaft::cylinder(5.0)), &request, None).unwrap())
    };
    let mut global = settings();
    global.camera.line_time_us = 0.0;
    assert_eq!(shot(&settings()), shot(&global));
    // A flash within the exposure of every row stops the motion for all of them.
    let mut flashed = vibrating();
    flashed.camera.exposure_us = 20_000.0;
    flashed.motion.strobe = Some(Strobe { delay_us: 15_000.0, pulse_us: 5.0 });
    let mut still = flashed.clone();
    still.camera.line_time_us = 0.0;
    assert_eq!(shot(&flashed), shot(&still));
}

/// e = e₀ - a·sin(2πf·τ·n(e) + φ)/p: the edges of the renderer satisfy it, from the first row read.
#[test]
fn edges_of_a_vibrating_part_satisfy_their_equation() {
    let settings = vibrating();
    let scene = scene(&settings, Shaft::cylinder(5.0));
    let pixel_mm = settings.nominal_pixel_mm();
    let (middle, half) = (299.5, 2.5 / pixel_mm);
    let up = |row: f64| {
        // The middle of the exposure of 1 µs.
        let t = 1e-6 * (LINE_US * row + 0.5);
        0.04 * (TAU * 120.0 * t + 35f64.to_radians()).sin() / pixel_mm
    };
    let full = geometric_edges(&scene, &FrameRequest::default()).unwrap();
    let window = Roi { row: 100, column: 0, rows: 400, columns: 64 };
    let from_100 =
        geometric_edges(&scene, &FrameRequest { roi: Some(window), ..Default::default() }).unwrap();
    for (edges, row0) in [(&full, 0.0), (&from_100, 100.0)] {
        let e = edges[31];
        let top = e.top_px + row0 - (middle - half - up(e.top_px));
        let bottom = e.bottom_px + row0 - (middle + half - up(e.bottom_px));
        // 2.6 px of amplitude; the cubic through samples leaves 2e-5 of it.
        assert!(top.abs() < 2e-4 && bottom.abs() < 2e-4, "{top} {bottom}");
    }
    let width = |edges: &[_], c: usize| {
        let e: &shadowgauge::render::columns::ColumnEdges = &edges[c];
        e.bottom_px - e.top_px
    };
    // The diameter errs: the edges stand 328 rows apart, 6.6 ms.
    assert!((width(&full, 31) - 2.0 * half).abs() > 0.5);
}

#[test]
fn an_eccentric_part_turns_on_between_its_edges() {
    let mut settings = settings();
    settings.motion.spindle_rpm = 900.0;
    let mut shaft = Shaft::cylinder(5.0);
    shaft.eccentricity = Eccentricity { amplitude_mm: 0.05, phase_deg: 20.0 };
    let scene = scene(&settings, shaft);
    let pixel_mm = settings.nominal_pixel_mm();
    let request = FrameRequest { angle_deg: 70.0, ..Default::default() };
    let e = geometric_edges(&scene, &request).unwrap()[20];
    let height = |row: f64| {
        let angle = 20.0 + 70.0 + 6.0 * 900.0 * 1e-6 * (LINE_US * row + 0.5);
        0.05 * angle.to_radians().cos()
    };
    for (row, sign) in [(e.top_px, 1.0), (e.bottom_px, -1.0)] {
        let wanted = 299.5 - (height(row) + sign * 2.5) / pixel_mm;
        assert!((row - wanted).abs() < 2e-4, "{row} {wanted}");
    }
}

/// The light above the shadow adds up to the edge, and windows see their own times.
#[test]
fn the_frame_shows_its_own_edges() {
    let settings = vibrating();
    let scene = scene(&settings, Shaft::cylinder(5.0));
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let frame = counts(&renderer.render(&scene, &request, None).unwrap());
    let levels = scene.setup().levels(PixelFormat::F32);
    let edges = geometric_edges(&scene, &request).unwrap();
    let light = |row: usize| (frame[row * 64 + 31] - levels.shadow) / (levels.bright - levels.shadow);
    let top: f64 = (0..300).map(light).sum::<f64>() - 0.5;
    assert!((top - edges[31].top_px).abs() < 2e-3, "{top} {}", edges[31].top_px);
}

#[test]
fn what_rows_cannot_follow_is_refused() {
    let refused = |settings: &SetupSettings| OpticalSetup::resolve(settings, 5).unwrap_err().to_string();
    let mut fast = vibrating();
    fast.motion.vibration[0].frequency_hz = 5000.0;
    assert!(refused(&fast).contains("0.5 rad"));
    let mut early = vibrating();
    early.camera.exposure_us = 20_000.0;
    early.motion.strobe = Some(Strobe { delay_us: 5000.0, pulse_us: 5.0 });
    let said = refused(&early);
    assert!(said.contains("motion.strobe.delay_us") && said.contains("12000"), "{said}");
}
